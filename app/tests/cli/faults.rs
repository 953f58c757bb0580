//! What is said when something is wrong: reports of faults, and `doctor`.

use std::fs;

use plenoscope::crash;
use predicates::prelude::*;
use predicates::str::contains;

use crate::common::{Scratch, plenoscope};

/// The program with folders of its own.
fn doctor(dir: &Scratch, args: &[&str]) -> assert_cmd::Command {
    let mut command = plenoscope(&[&["doctor"], args].concat());
    for (name, folder) in [("XDG_DATA_HOME", "data"), ("XDG_CACHE_HOME", "cache"), ("XDG_CONFIG_HOME", "config")] {
        command.env(name, dir.path(folder));
    }
    command
}

#[test]
fn a_fault_leaves_a_report_without_paths() {
    let dir = Scratch::new();
    crash::watch(dir.path("crashes"));
    crash::note("open");
    let broke =
        std::thread::Builder::new().name("fragile".to_owned()).spawn(|| panic!("in /home/me/My Photos/cat.jpg"));
    assert!(broke.unwrap().join().is_err());
    let report = crash::take_unseen(&dir.path("crashes")).unwrap();
    for part in ["Plenoscope 0.", "thread fragile broke at faults.rs:", "in cat.jpg", "  open", "   0: "] {
        assert!(report.text.contains(part), "{part}: {}", report.text);
    }
    assert!(!report.text.contains("/"), "{}", report.text);
    assert_eq!(crash::take_unseen(&dir.path("crashes")), None, "it is offered once");
    #[cfg(unix)]
    {
        use std::os::unix::fs::PermissionsExt;
        assert_eq!(fs::metadata(report.path).unwrap().permissions().mode() & 0o777, 0o600);
    }
}

#[cfg(target_os = "linux")]
#[test]
fn doctor_says_what_is_there_and_what_is_wrong() {
    let dir = Scratch::new();
    fs::create_dir_all(dir.path("data/plenoscope/models/torn")).unwrap();
    fs::write(dir.path("data/plenoscope/models/torn/manifest.toml"), "id = 3").unwrap();
    fs::create_dir_all(dir.path("cache/plenoscope")).unwrap();
    fs::write(dir.path("cache/plenoscope/light-fields"), "a file where a folder is to be").unwrap();
    let out = doctor(&dir, &["--json"]).assert().success();
    let said: serde_json::Value = serde_json::from_slice(&out.get_output().stdout).unwrap();
    assert_eq!(said["program"]["version"], env!("CARGO_PKG_VERSION"));
    assert!(said["models"]["torn"] == "cannot be used" && said["limits"]["open files"].is_string(), "{said:#}");
    let sums =
        said["models"].as_object().unwrap().values().filter(|v| v.as_str().is_some_and(|v| v.contains("sha256")));
    assert!(sums.count() >= 2, "{said:#}");
    let wrong = said["wrong"].to_string();
    assert!(wrong.contains("torn/manifest.toml") && wrong.contains("light fields kept cannot be kept"), "{wrong}");
    doctor(&dir, &[]).assert().success().stdout(contains("folders\n").and(contains("\nwrong\n")));
}
