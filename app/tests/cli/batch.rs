//! `batch` as several workers run it: parts, reports, two with the same part, one that is killed, a folder that goes.

use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};

use predicates::prelude::*;
use predicates::str::contains;
use serde_json::Value;

use crate::common::{Scratch, plenoscope};

/// Photos, a recipe, and a map that takes the place of the nets.
struct Work {
    dir: Scratch,
    photos: Vec<String>,
}

impl Work {
    fn of(count: usize, width: u32) -> Self {
        let dir = Scratch::new();
        let photos = (0..count).map(|n| dir.photo(&format!("photo-{n}.png"), width, width * 2 / 3)).collect();
        fs::write(dir.path("edit.json"), r#"{"version": 2, "lens": {"f_number": 2.0}}"#).unwrap();
        dir.map("map.pfm", [48, 32], |x| x as f32 / 24.0 - 1.0);
        Self { dir, photos }
    }

    /// The arguments of a worker.
    fn args(&self, more: &[&str]) -> Vec<String> {
        let (recipe, out, map) = (self.dir.arg("edit.json"), self.dir.arg("out"), self.dir.arg("map.pfm"));
        let fixed = ["batch", "--recipe", &recipe, "-o", &out, "--disparity", &map, "--no-cache"];
        let photos = self.photos.iter().map(String::as_str);
        fixed.into_iter().chain(more.iter().copied()).chain(photos).map(str::to_owned).collect()
    }

    fn run(&self, more: &[&str]) -> assert_cmd::assert::Assert {
        let args = self.args(more);
        plenoscope(&args.iter().map(String::as_str).collect::<Vec<_>>()).assert()
    }

    /// A worker that goes on by itself.
    fn spawn(&self, more: &[&str]) -> Child {
        let mut command = Command::new(assert_cmd::cargo::cargo_bin!("plenoscope"));
        command.args(self.args(more)).stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap()
    }

    /// The pictures that are there; all of them must open, and nothing else may lie beside them.
    fn pictures(&self) -> Vec<PathBuf> {
        let entries = fs::read_dir(self.dir.path("out")).into_iter().flatten().map(|entry| entry.unwrap().path());
        let (hidden, mut pictures): (Vec<_>, Vec<_>) =
            entries.partition(|path| path.file_name().unwrap().to_string_lossy().starts_with('.'));
        assert!(hidden.iter().all(|path| path.is_dir()), "left behind: {hidden:?}");
        pictures.iter().for_each(|path| drop(image::open(path).unwrap()));
        pictures.sort();
        pictures
    }

    /// Waits until so many pictures are there.
    fn wait_for(&self, pictures: usize) {
        let started = Instant::now();
        let there = || fs::read_dir(self.dir.path("out")).into_iter().flatten().count();
        // One more is the record.
        while there() < pictures + 1 {
            assert!(started.elapsed() < Duration::from_secs(120), "no picture came");
            std::thread::sleep(Duration::from_millis(5));
        }
    }
}

/// JSON lines by the photo's name.
fn lines(text: &[u8]) -> BTreeMap<String, Value> {
    let lines = std::str::from_utf8(text).unwrap().lines().map(|line| serde_json::from_str::<Value>(line).unwrap());
    lines
        .map(|line| {
            (Path::new(line["path"].as_str().unwrap()).file_name().unwrap().to_string_lossy().into_owned(), line)
        })
        .collect()
}

#[test]
fn parts_make_every_photo_once_and_say_so_in_json() {
    let work = Work::of(6, 48);
    fs::write(work.dir.path("photo-3.png"), "no photo").unwrap();
    let (mut all, mut failed) = (BTreeMap::new(), 0);
    for part in ["1/3", "2/3", "3/3"] {
        let report = work.dir.arg("report.jsonl");
        let done = work.run(&["--shard", part, "--json", "--report", &report]);
        let said = lines(&done.get_output().stdout);
        assert_eq!(said, lines(&fs::read(&report).unwrap()));
        let bad = said.values().filter(|line| line["state"] == "failed").count();
        done.code(i32::from(bad > 0));
        failed += bad;
        for (name, line) in said {
            assert!(all.insert(name, line).is_none(), "a photo in two parts");
        }
    }
    assert_eq!((all.len(), failed), (6, 1));
    let bad = &all["photo-3.png"];
    assert!(bad["error"].as_str().unwrap().contains(" — ") && bad["output"].is_null());
    let good = &all["photo-4.png"];
    assert!(good["error"].is_null() && good["secs"].as_f64().unwrap() > 0.0);
    assert!(Path::new(good["output"].as_str().unwrap()).ends_with("out/photo-4-f2.jpg"));
    assert_eq!(work.pictures().len(), 5);
}

#[test]
fn two_workers_with_the_same_part_do_no_harm() {
    let work = Work::of(8, 300);
    let workers = [0, 1].map(|_| work.spawn(&["--json", "--jobs", "1", "--shard", "1/1", "--resume"]));
    let told = workers.map(|worker| worker.wait_with_output().unwrap());
    for done in &told {
        assert!(done.status.success(), "{}", String::from_utf8_lossy(&done.stderr));
        let said = lines(&done.stdout);
        assert_eq!(said.len(), 8);
        let here = said.values().filter(|line| line["state"] == "met").count();
        assert_eq!(here > 0, String::from_utf8_lossy(&done.stderr).contains("same shard"));
    }
    assert_eq!(work.pictures().len(), 8);
    let states: Vec<_> =
        told.iter().flat_map(|done| lines(&done.stdout).into_values()).map(|line| line["state"].clone()).collect();
    assert!(states.iter().filter(|state| **state == "made").count() >= 8 && !states.contains(&"failed".into()));
}

#[test]
fn what_a_killed_worker_left_is_gone_on_with() {
    let work = Work::of(5, 600);
    let mut worker = work.spawn(&["--jobs", "1"]);
    work.wait_for(3);
    worker.kill().unwrap();
    worker.wait().unwrap();
    let left = work.pictures();
    assert!(left.len() >= 3, "whole ones");
    // One that somebody cut off is not taken for finished.
    fs::write(&left[0], &fs::read(&left[0]).unwrap()[..100]).unwrap();
    let report = work.dir.arg("report.jsonl");
    fs::write(&report, "{\"path\": \"of last time\"}\n").unwrap();
    let done = work.run(&["--resume", "--json", "--report", &report]).success();
    let said = lines(&done.get_output().stdout);
    let skipped = said.values().filter(|line| line["state"] == "skipped").count();
    assert!(said.len() == 5 && (1..left.len()).contains(&skipped), "{skipped} of {} skipped", left.len());
    assert_eq!(lines(&fs::read(&report).unwrap()).len(), 6, "a resumed report is gone on with");
    assert_eq!(work.pictures().len(), 5);
    work.run(&["--resume"]).success().stdout(contains("0 made, 5 there already"));
    fs::write(work.dir.path("edit.json"), r#"{"version": 2, "lens": {"f_number": 2.0, "grain": 1.0}}"#).unwrap();
    work.run(&["--resume"]).success().stdout(contains("5 made, 0 there already"));
}

#[cfg(unix)]
#[test]
fn a_folder_that_goes_away_is_one_sentence() {
    let work = Work::of(40, 300);
    let worker = work.spawn(&["--jobs", "1"]);
    work.wait_for(1);
    fs::rename(work.dir.path("out"), work.dir.path("unmounted")).unwrap();
    let done = worker.wait_with_output().unwrap();
    let said = String::from_utf8(done.stderr).unwrap();
    assert_eq!(done.status.code(), Some(1), "{said}");
    assert!(said.starts_with("error: ") && said.lines().count() == 1 && said.contains("gone away"), "{said}");
    assert!(!work.dir.path("out").exists(), "nothing is made in its place");
}

#[test]
fn photos_are_taken_from_a_list_too() {
    let mut work = Work::of(3, 48);
    let list = work.photos.join("\n");
    work.photos.clear();
    let args = work.args(&["--files-from", "-"]);
    let mut command = plenoscope(&args.iter().map(String::as_str).collect::<Vec<_>>());
    command.write_stdin(list).assert().success().stdout(contains("3 made"));
    let away = work.dir.arg("away.txt");
    work.run(&["--files-from", &away]).code(1).stderr(contains("away.txt").and(contains(" — ")));
}

#[test]
fn a_folder_stands_for_its_photos_unless_it_is_a_light_field() {
    let mut work = Work::of(0, 48);
    fs::create_dir(work.dir.path("scans")).unwrap();
    for name in ["a", "b", "c"] {
        work.dir.photo(&format!("scans/{name}.png"), 48, 32);
    }
    let single = work.dir.photo("single.png", 48, 32);
    let field = work.dir.arg("field");
    plenoscope(&["synth", &single, "--disparity", &work.dir.arg("map.pfm"), "--no-cache", "-o", &field])
        .assert()
        .success();
    work.photos = vec![work.dir.arg("scans"), field];
    work.run(&[]).success().stdout(contains("4 made"));
    let names: Vec<_> = work.pictures().iter().map(|path| path.file_name().unwrap().to_owned()).collect();
    assert_eq!(names, ["a-f2.jpg", "b-f2.jpg", "c-f2.jpg", "field-f2.jpg"]);
}

#[test]
fn what_cannot_be_a_part_is_wrong_usage() {
    let work = Work::of(1, 48);
    for part in ["0/3", "4/3", "x", "1/0"] {
        work.run(&["--shard", part]).code(2).stderr(contains("write 1/8 to 8/8"));
    }
    work.run(&["--resume", "--force"]).code(2);
}
