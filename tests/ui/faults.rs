//! A fault of the last time is offered once.

use egui_kittest::kittest::Queryable as _;

use crate::common::{has_device, steps, window_after_faults};

#[test]
fn the_report_of_a_fault_is_offered_once() {
    if !has_device() {
        return;
    }
    let folder = tempfile::tempdir().expect("a folder");
    std::fs::write(folder.path().join("crash-1700000000-001.txt"), "thread synth broke").expect("written");
    let mut harness = window_after_faults([1000.0, 700.0], folder.path());
    steps(&mut harness, 3);
    assert!(harness.query_by_label("thread synth broke").is_none(), "it is shown to those who ask");
    harness.get_by_label("Show report").click();
    steps(&mut harness, 3);
    harness.get_by_label("thread synth broke");
    harness.get_by_label("Go on").click();
    steps(&mut harness, 3);
    assert!(harness.query_by_label("A fault in Plenoscope").is_none());
    let mut harness = window_after_faults([1000.0, 700.0], folder.path());
    steps(&mut harness, 3);
    assert!(harness.query_by_label("A fault in Plenoscope").is_none());
}
