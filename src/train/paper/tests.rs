//! The whole command on two small light fields.

use super::*;
use crate::recorded::tests::write_plane;

fn asked(data: &std::path::Path, out: &std::path::Path) -> Asked {
    let line =
        ["paper", "--data", "d", "--out", "o", "--steps", "1", "--batch", "1", "--crop", "16", "--long-side", "32"];
    let matches = command().get_matches_from(line);
    Asked { data: data.to_owned(), out: out.to_owned(), ..Asked::from_matches(&matches).unwrap() }
}

#[test]
fn a_folder_of_light_fields_becomes_a_report_and_the_same_seed_the_same_figures() {
    let folder = tempfile::tempdir().unwrap();
    let (data, out) = (folder.path().join("data"), folder.path().join("out"));
    std::fs::create_dir(&data).unwrap();
    write_plane(&data.join("a"), 0.4);
    write_plane(&data.join("b"), -0.3);
    let (stop, quiet) = (AtomicBool::new(false), |_: &str| ());
    let first = asked(&data, &out);
    let path = run(&first, &stop, &quiet).unwrap();
    let page = std::fs::read_to_string(&path).unwrap();
    assert!(page.contains("appearance flow") && page.contains("data:image/png;base64,") && page.contains("<svg"));
    assert!(!page.contains("http://") || page.matches("http://").count() == page.matches("http://www.w3.org").count());
    let json = |out: &std::path::Path| std::fs::read_to_string(out.join("figures.json")).unwrap();
    let told: serde_json::Value = serde_json::from_str(&json(&out)).unwrap();
    for method in Method::ALL {
        assert_eq!(told["steps"][method.name()], 1, "{told}");
        assert!(told["mean"][method.name()]["l1"].as_f64().unwrap() > 0.0);
    }
    assert!(
        told["mean"]["measured-depth"]["l1"].as_f64() < told["mean"]["copy"]["l1"].as_f64(),
        "measured depth helps"
    );
    for file in ["figures/l1-by-u.svg", "panels/depths.png", "panels/ablation.png", "panels/photographic.png"] {
        assert!(out.join(file).exists(), "{file}");
    }
    let again = folder.path().join("again");
    run(&asked(&data, &again), &stop, &quiet).unwrap();
    assert_eq!(json(&out), json(&again));

    // Nothing is trained twice; other options are refused; more steps go on.
    run(&first, &stop, &quiet).unwrap();
    assert_eq!(json(&out), json(&again));
    let other = Asked { batch: 2, ..first.clone() };
    assert!(run(&other, &stop, &quiet).unwrap_err().to_string().contains("other options"));
    let more = Asked { steps: 2, only: vec![Method::Regression], ..first };
    run(&more, &stop, &quiet).unwrap();
    let told: serde_json::Value = serde_json::from_str(&json(&out)).unwrap();
    assert_eq!((&told["steps"]["regression"], &told["steps"]["ours"]), (&2.into(), &1.into()));
    stop.store(true, Ordering::Relaxed);
    assert!(run(&more, &stop, &quiet).unwrap_err().to_string().contains("stays"));
}
