//! Nothing torn: kills at random moments, a full disk, a disk that cannot be written to, what is brought to the disk first.
//!
//! The ordinary run kills a few times; `PLENOSCOPE_KILLS=200 cargo test --test cli -- torn --nocapture` kills that often and
//! says how it went: its figures stand in docs/reliability.md.

use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};

use plenoscope::field::FNumber;
use plenoscope::scene::{Edit, Found, Recipe};
use predicates::prelude::*;
use predicates::str::contains;

use crate::common::{Scratch, plenoscope};
use crate::small_nets;

/// Kills where nobody asks for more.
const FEW: usize = 22;
/// A sidecar's writer works until it is killed.
const WRITER: &str = "PLENOSCOPE_TEST_WRITES_BESIDE";

/// All that lies in a folder: files by their path in it, and what they hold. Records of a batch are left out: each worker
/// adds a file of its own.
fn all_in(folder: &Path) -> BTreeMap<PathBuf, Vec<u8>> {
    let mut found = BTreeMap::new();
    let mut waiting = vec![folder.to_owned()];
    while let Some(next) = waiting.pop() {
        for entry in fs::read_dir(&next).into_iter().flatten().flatten() {
            let path = entry.path();
            match path.is_dir() {
                true if path.ends_with(".plenoscope-batch") => {}
                true => {
                    found.insert(path.strip_prefix(folder).unwrap().join(""), Vec::new());
                    waiting.push(path);
                }
                false => {
                    found.insert(path.strip_prefix(folder).unwrap().to_owned(), fs::read(&path).unwrap_or_default());
                }
            }
        }
    }
    found
}

/// One thing that is written, by a program that can be killed.
struct Kind {
    name: &'static str,
    args: Vec<String>,
    /// What is to be old or new, whole: a file or a folder in `folder`.
    folder: PathBuf,
    /// Whether each file in it may be old, new or away by itself.
    is_piecemeal: bool,
}

fn environment(command: &mut Command, dir: &Scratch) {
    for (name, folder) in [("XDG_DATA_HOME", "data"), ("XDG_CACHE_HOME", "cache"), ("XDG_CONFIG_HOME", "config")] {
        command.env(name, dir.path(folder));
    }
    command.stdout(Stdio::null()).stderr(Stdio::null());
}

impl Kind {
    fn spawn(&self, dir: &Scratch) -> Child {
        let mut command = Command::new(assert_cmd::cargo::cargo_bin!("plenoscope"));
        environment(&mut command, dir);
        command.args(&self.args).spawn().unwrap()
    }

    fn run(&self, dir: &Scratch) -> Duration {
        let start = Instant::now();
        assert!(self.spawn(dir).wait().unwrap().success(), "{}: {:?}", self.name, self.args);
        start.elapsed()
    }
}

/// All kinds of writing, each into a folder of its own, of a photo that can change between old and new.
fn kinds(dir: &Scratch) -> Vec<Kind> {
    let words = |words: &[&str]| -> Vec<String> { words.iter().map(|word| (*word).to_owned()).collect() };
    let (photo, second, map, edit) =
        (dir.arg("photo.png"), dir.arg("photo-2.png"), dir.arg("map.pfm"), dir.arg("edit.json"));
    let folder = |name: &str| dir.path(&format!("out-{name}"));
    let simple = |name: &'static str, first: &[&str], target: &str| {
        let target = folder(name).join(target).display().to_string();
        let rest = ["--disparity", &map, "--long-side", "48", "--no-cache", "-o", &target];
        let args = [words(first), words(&[&photo]), words(&rest)].concat();
        Kind { name, args, folder: folder(name), is_piecemeal: false }
    };
    let out = folder("batch").display().to_string();
    let batch =
        words(&["batch", &photo, &second, "--recipe", &edit, "--disparity", &map, "--no-cache", "--force", "-o", &out]);
    let nets = words(&["models", "add", &dir.arg("nets/patches/model.onnx"), "--name", "mine", "--force"]);
    let cache = words(&["depth", &photo, "--long-side", "48", "-o", &dir.arg("depth.pfm")]);
    vec![
        simple("picture", &["refocus"], "a.jpg"),
        simple("views", &["synth"], "field"),
        simple("stack", &["export", "--as", "focal-stack", "--frames", "5"], "stack"),
        simple("animation", &["export", "--as", "animation", "--frames", "5"], "a.gif"),
        simple("hci", &["export", "--as", "hci"], "scene"),
        simple("eslf", &["export", "--as", "eslf"], "a.png"),
        simple("cloud", &["export", "--as", "ply"], "a.ply"),
        simple("depth", &["depth"], "a.pfm"),
        Kind { name: "batch", args: batch, folder: folder("batch"), is_piecemeal: true },
        Kind { name: "nets", args: nets, folder: dir.path("data/plenoscope/models"), is_piecemeal: false },
        Kind { name: "cache", args: cache, folder: dir.path("cache/plenoscope/light-fields"), is_piecemeal: true },
    ]
}

/// A photo whose left half is of a brightness, so that old and new outputs differ.
fn write_photo(dir: &Scratch, level: u8) {
    for (name, add) in [("photo.png", 0), ("photo-2.png", 20)] {
        let pixel = |x: u32, y: u32| image::Rgb([if x < 24 { level + add } else { 90 }, (y * 7) as u8, (x * 5) as u8]);
        image::RgbImage::from_fn(48, 32, pixel).save(dir.path(name)).unwrap();
    }
}

/// Runs a kind to its end for the old and for the new photo, and returns what lies there after each.
fn truth(kind: &Kind, dir: &Scratch) -> ([BTreeMap<PathBuf, Vec<u8>>; 2], Duration) {
    let mut took = Duration::ZERO;
    let both = [40, 200].map(|level| {
        let _ = fs::remove_dir_all(&kind.folder);
        if kind.name != "nets" && kind.name != "cache" {
            fs::create_dir_all(&kind.folder).unwrap();
        }
        write_photo(dir, level);
        took = kind.run(dir);
        all_in(&kind.folder)
    });
    (both, took)
}

fn is_aside(path: &Path) -> bool {
    path.components().any(|part| part.as_os_str().to_string_lossy().starts_with(".plenoscope-"))
}

#[test]
fn a_kill_leaves_the_old_or_the_new_whole_and_the_next_start_nothing_else() {
    let kills = std::env::var("PLENOSCOPE_KILLS").ok().and_then(|text| text.parse().ok()).unwrap_or(FEW);
    let dir = Scratch::new();
    write_photo(&dir, 40);
    small_nets::write_patches(&dir.path("nets"), "patches");
    fs::write(dir.path("edit.json"), r#"{"version": 2, "lens": {"f_number": 2.0}}"#).unwrap();
    dir.map("map.pfm", [48, 32], |x| x as f32 / 24.0 - 1.0);
    let kinds = kinds(&dir);
    let mut state = 0x2545_f491_4f6c_dd1d_u64;
    let mut random = || {
        state ^= state << 13;
        state ^= state >> 7;
        state ^= state << 17;
        (state >> 11) as f64 / (1_u64 << 53) as f64
    };
    for kind in &kinds {
        let ([old, new], took) = truth(kind, &dir);
        let (mut finished, mut left, count) = (0, 0, kills.div_ceil(kinds.len()));
        for n in 0..count {
            // Old lies there, and new comes; then the other way round.
            let (before, after, level) = if n % 2 == 0 { (&new, &old, 40) } else { (&old, &new, 200) };
            write_photo(&dir, level);
            let mut child = kind.spawn(&dir);
            std::thread::sleep(took.mul_f64(1.3 * random()));
            let _ = child.kill();
            finished += usize::from(child.wait().unwrap().success());
            let mut found = all_in(&kind.folder);
            left += usize::from(found.keys().any(|path| is_aside(path)));
            found.retain(|path, _| !is_aside(path));
            let is_whole = match kind.is_piecemeal {
                true => {
                    found.iter().all(|(path, bytes)| [before, after].iter().any(|all| all.get(path) == Some(bytes)))
                }
                false => found == *before || found == *after || (kind.name == "nets" && found.is_empty()),
            };
            assert!(is_whole, "{} is torn: {:?}", kind.name, found.keys());
            kind.run(&dir);
            let mut at_end = all_in(&kind.folder);
            assert!(!at_end.keys().any(|path| is_aside(path)), "{} left {:?}", kind.name, at_end.keys());
            if kind.name == "cache" {
                at_end.retain(|path, _| after.contains_key(path));
            }
            assert!(at_end == *after, "{}: the next run does not mend it", kind.name);
        }
        eprintln!(
            "{}: {count} kills, {finished} had finished, {left} left something until the next start, 0 torn",
            kind.name
        );
    }
}

/// Not a test of its own: the program that the next one kills.
#[test]
#[ignore = "it writes until it is killed"]
fn writer_of_a_sidecar() {
    let Some(photo) = std::env::var_os(WRITER).map(PathBuf::from) else { return };
    for n in 1.. {
        let edit = Edit { f_number: FNumber(1.0 + (n % 20) as f32), ..Edit::default() };
        Recipe::default().with_edit(edit).keep_beside(&photo, Found::default()).unwrap();
    }
}

/// That program, once it has written.
fn start_writer(photo: &Path) -> Child {
    let mut writer = Command::new(std::env::current_exe().unwrap());
    writer.args(["torn::writer_of_a_sidecar", "--exact", "--ignored"]).env(WRITER, photo);
    let child = writer.stdout(Stdio::null()).stderr(Stdio::null()).spawn().unwrap();
    let start = Instant::now();
    while !Recipe::sidecar(photo).exists() && start.elapsed() < Duration::from_secs(60) {
        std::thread::sleep(Duration::from_millis(2));
    }
    child
}

#[test]
fn two_windows_and_a_batch_on_one_sidecar_find_and_leave_whole_edits() {
    let dir = Scratch::new();
    let photo = PathBuf::from(dir.photo("photo.png", 48, 32));
    let recipe = Recipe::sidecar(&photo);
    let mut writers = [start_writer(&photo), start_writer(&photo)];
    let how = ["--force", "--no-cache", "--lambertian", "--long-side", "48", "-o", &dir.arg("out")].map(str::to_owned);
    for _ in 0..3 {
        let args = ["batch", &photo.to_string_lossy(), "--recipe", &recipe.to_string_lossy()].map(str::to_owned);
        plenoscope(&[args.as_slice(), &how].concat().iter().map(String::as_str).collect::<Vec<_>>()).assert().success();
    }
    for writer in &mut writers {
        assert!(writer.try_wait().unwrap().is_none(), "it writes until it is killed");
        writer.kill().unwrap();
        writer.wait().unwrap();
    }
    let edits: Vec<PathBuf> = fs::read_dir(dir.path("")).unwrap().map(|entry| entry.unwrap().path()).collect();
    let edits: Vec<&PathBuf> = edits.iter().filter(|path| path.extension().is_some_and(|end| end == "json")).collect();
    // What one window wrote and the other had not seen lies there under another name.
    assert!(edits.len() > 1, "{edits:?}");
    edits.iter().for_each(|path| drop(Recipe::read(path).unwrap()));
}

#[test]
fn a_killed_writer_of_a_sidecar_leaves_it_whole() {
    let kills = std::env::var("PLENOSCOPE_KILLS").ok().and_then(|text| text.parse().ok()).unwrap_or(FEW) / 4;
    let dir = Scratch::new();
    let photo = PathBuf::from(dir.photo("photo.png", 48, 32));
    for n in 0..kills {
        let mut child = start_writer(&photo);
        std::thread::sleep(Duration::from_millis(7 * n as u64 % 40));
        child.kill().unwrap();
        child.wait().unwrap();
        assert!(Recipe::of_photo(&photo).unwrap().is_some());
    }
    // The next start, which has seen what lies there.
    let (recipe, found) = Recipe::found_beside(&photo);
    recipe.unwrap().unwrap().keep_beside(&photo, found).unwrap();
    let names: Vec<String> = all_in(&dir.path("")).keys().map(|path| path.display().to_string()).collect();
    assert!(names.iter().all(|name| name.starts_with("photo.png")), "{names:?}");
}

/// A small disk of its own; says so and is none where this user may not have one.
struct Disk(PathBuf);

impl Disk {
    fn new(dir: &Scratch, size: &str) -> Option<Self> {
        let at = dir.path("disk");
        fs::create_dir(&at).unwrap();
        let made =
            Command::new("mount").args(["-t", "tmpfs", "-o", &format!("size={size}"), "tmpfs"]).arg(&at).output();
        if made.is_ok_and(|made| made.status.success()) {
            return Some(Self(at));
        }
        eprintln!("SKIPPED: no small disk can be mounted here, which takes the rights of root");
        None
    }

    fn remount(&self, how: &str) {
        assert!(Command::new("mount").args(["-o", &format!("remount,{how}")]).arg(&self.0).status().unwrap().success());
    }
}

impl Drop for Disk {
    fn drop(&mut self) {
        let _ = Command::new("umount").arg(&self.0).status();
    }
}

#[test]
fn a_full_or_locked_disk_is_one_sentence_and_the_old_stays() {
    let dir = Scratch::new();
    let photo = dir.photo("photo.png", 240, 160);
    let Some(disk) = Disk::new(&dir, "96k") else { return };
    let small = ["--no-cache", "--long-side", "120"];
    let try_all = |says: &str| {
        for (args, target) in [
            (vec!["refocus"], "disk/a.png"),
            (vec!["synth"], "disk/field"),
            (vec!["export", "--as", "focal-stack"], "disk/stack"),
            (vec!["export", "--as", "animation"], "disk/a.gif"),
            (vec!["export", "--as", "ply"], "disk/a.ply"),
            (vec!["depth"], "disk/a.pfm"),
        ] {
            let target = dir.arg(target);
            let all = [&args[..], &[photo.as_str(), "-o", &target], &small].concat();
            plenoscope(&all).assert().code(1).stderr(contains(says).and(one_line()));
        }
    };
    fs::write(dir.path("disk/a.png"), "old").unwrap();
    assert!(fs::write(dir.path("disk/filler"), vec![1; 200 << 10]).is_err(), "it takes what there is room for");
    try_all("the disk is full");
    disk.remount("ro");
    try_all("writing is not allowed there");
    disk.remount("rw");
    let left = all_in(&disk.0);
    assert_eq!(left.keys().map(|path| path.display().to_string()).collect::<Vec<_>>(), ["a.png", "filler"]);
    assert_eq!(left[Path::new("a.png")], b"old");
}

fn one_line() -> impl predicates::Predicate<str> {
    predicates::function::function(|text: &str| text.lines().filter(|line| line.starts_with("error: ")).count() == 1)
}

#[test]
fn names_that_are_too_long_and_folders_that_are_gone_are_one_sentence() {
    let dir = Scratch::new();
    let photo = dir.photo("photo.png", 48, 32);
    let small = ["--no-cache", "--long-side", "48"];
    let long = dir.arg(&format!("{}.png", "x".repeat(300)));
    let gone = dir.arg("gone/a.png");
    for (target, says) in [(&long, "its name is too long"), (&gone, "its folder does not exist")] {
        plenoscope(&[&["refocus", &photo, "-o", target], &small[..]].concat())
            .assert()
            .code(1)
            .stderr(contains(says).and(one_line()));
    }
}

/// A run of the program under `strace`, which does what it is told; none where that cannot be.
fn traced(dir: &Scratch, options: &[&str], args: &[&str]) -> Option<Command> {
    let mut command = Command::new("strace");
    let is_there =
        Command::new("strace").args(["-o", "/dev/null", "true"]).output().is_ok_and(|tried| tried.status.success());
    if !is_there {
        eprintln!("SKIPPED: strace is not installed, or may not look at programs here");
        return None;
    }
    command.args(["-f", "-q"]).args(options).arg(assert_cmd::cargo::cargo_bin!("plenoscope")).args(args);
    environment(&mut command, dir);
    Some(command)
}

/// The same with a fault that it injects.
fn injected(dir: &Scratch, fault: &str, args: &[&str]) -> Option<Command> {
    let inject = format!("inject={fault}");
    traced(dir, &["-o", "/dev/null", "-e", "trace=write,fsync,fdatasync", "-e", &inject], args)
}

/// What a folder on a network does: it takes long, and in the end it may not have kept what it took.
#[test]
fn slow_writes_show_the_old_or_the_new_and_failed_ones_leave_the_old() {
    let dir = Scratch::new();
    let photo = dir.photo("photo.png", 48, 32);
    let small = ["--no-cache", "--long-side", "48", "--force"];
    for (args, target) in [(vec!["refocus"], "a.png"), (vec!["export", "--as", "animation", "--frames", "5"], "a.gif")]
    {
        let [quick, slow] = ["quick", "slow"].map(|folder| dir.arg(&format!("{folder}/{target}")));
        let all = |target| [&args[..], &[photo.as_str(), "-o", target], &small].concat();
        for folder in ["quick", "slow"] {
            let _ = fs::remove_dir_all(dir.path(folder));
            fs::create_dir(dir.path(folder)).unwrap();
        }
        plenoscope(&all(&quick)).assert().success();
        let [old, new] = [b"old".to_vec(), fs::read(&quick).unwrap()];
        fs::write(&slow, &old).unwrap();
        for error in ["EIO", "ESTALE", "EDQUOT", "ETIMEDOUT"] {
            let Some(mut run) = injected(&dir, &format!("fsync,fdatasync:error={error}"), &all(&slow)) else {
                return;
            };
            let said = run.stderr(Stdio::piped()).output().unwrap();
            let said = (said.status.code(), String::from_utf8(said.stderr).unwrap());
            assert!(
                said.0 == Some(1) && one_line().eval(&said.1) && said.1.matches(" — ").count() == 2,
                "{error}: {said:?}"
            );
            assert_eq!(all_in(&dir.path("slow")), BTreeMap::from([(PathBuf::from(target), old.clone())]), "{error}");
        }
        let Some(mut run) = injected(&dir, "write,fsync,fdatasync:delay_enter=30000", &all(&slow)) else { return };
        let mut child = run.spawn().unwrap();
        let mut seen = 0;
        let code = loop {
            let found = fs::read(&slow).unwrap();
            assert!(found == old || found == new, "{target}: {} bytes are seen", found.len());
            seen += usize::from(found == old);
            if let Some(code) = child.try_wait().unwrap() {
                break code;
            }
            std::thread::sleep(Duration::from_millis(1));
        };
        assert!(code.success() && seen > 1, "{code}, the old seen {seen} times");
        assert_eq!(all_in(&dir.path("slow")), BTreeMap::from([(PathBuf::from(target), new)]));
    }
}

/// What the system was asked for, in order: each file is brought to the disk before it gets its name.
#[test]
fn a_file_is_on_the_disk_before_it_has_its_name() {
    let dir = Scratch::new();
    let photo = dir.photo("photo.png", 48, 32);
    let calls = "trace=fsync,fdatasync,linkat,link,rename,renameat,renameat2";
    for (args, target, files) in
        [(vec!["refocus"], "a.png", 1), (vec!["export", "--as", "focal-stack", "--frames", "3"], "stack", 5)]
    {
        let to = dir.arg(target);
        let args = [&args[..], &[photo.as_str(), "-o", &to, "--no-cache", "--long-side", "48"]].concat();
        let Some(mut run) = traced(&dir, &["-e", calls, "-o", &dir.arg("log")], &args) else { return };
        assert!(run.status().unwrap().success(), "{target}");
        let log = fs::read_to_string(dir.path("log")).unwrap();
        let lines: Vec<&str> = log.lines().collect();
        let gives = |line: &&str| (line.contains("link") || line.contains("rename")) && line.contains(target);
        let named = lines.iter().rposition(gives).unwrap_or_else(|| panic!("{target} never got its name:\n{log}"));
        let is_synced = |line: &&&str| line.contains("fsync(") && line.ends_with("= 0");
        let synced = lines[..named].iter().filter(is_synced).count();
        assert!(synced >= files, "{synced} of {files} files of {target} were brought to the disk before:\n{log}");
    }
}
