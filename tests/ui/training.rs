//! Training beside the window, by a program that takes the trainer's place.

use std::fs;
use std::os::unix::fs::PermissionsExt as _;

use egui_kittest::kittest::Queryable as _;
use plenoscope::synth::adopt::Shelf;

use crate::common::{Window, has_device, steps, window_with_trainer};

/// Steps until a text is shown.
fn wait_for(harness: &mut Window, text: &str) {
    for _ in 0..2000 {
        harness.step();
        if harness.query_by_label_contains(text).is_some() {
            // What is shown with it may have moved what is pressed next.
            return steps(harness, 4);
        }
        std::thread::sleep(std::time::Duration::from_millis(10));
    }
    panic!("{text:?} is not shown");
}

#[test]
fn training_is_shown_while_it_runs_rests_and_goes_on() {
    if !has_device() {
        return;
    }
    let folder = tempfile::tempdir().expect("a folder");
    let (data, program) = (folder.path().join("fields"), folder.path().join("trainer"));
    let run = folder.path().join("training/fields");
    fs::create_dir_all(&data).expect("made");
    // It counts its starts as steps, draws a sheet, and ends with its input as the trainer does.
    let script = format!(
        "#!/bin/sh\nmkdir -p {run}\necho '{{\"steps\": 40, \"data\": \"{data}\"}}' > {run}/config.json\n\
         echo x >> {run}/starts\nn=$(wc -l < {run}/starts)\n\
         echo '{{\"step\":'$n',\"losses\":{{\"full\":0.25,\"lambertian\":0.5}}}}' >> {run}/metrics.jsonl\ncat > /dev/null\n",
        run = run.display(),
        data = data.display()
    );
    fs::write(&program, script).expect("written");
    fs::set_permissions(&program, fs::Permissions::from_mode(0o755)).expect("set");
    let shelf = Shelf::new(&folder.path().join("models"));
    let mut harness = window_with_trainer([1000.0, 700.0], shelf, &program);
    harness.state_mut().train_on(&data);
    wait_for(&mut harness, "fields: not begun");
    for step in 1..=2 {
        harness.get_by_label(if step == 1 { "Train" } else { "Go on" }).click();
        wait_for(&mut harness, &format!("step {step} of 40"));
        assert!(harness.query_by_label("full 0.2500").is_some(), "its losses are said");
        harness.get_by_label("Pause").click();
        wait_for(&mut harness, &format!("resting after step {step} of 40"));
    }
}
