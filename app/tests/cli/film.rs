//! Films and timelines, as ffprobe reads them. Where there is none the test says so.

use std::fs;
use std::process::Command;

use super::common::{Scratch, plenoscope};

/// Runs a command on the small photo with one map.
fn export(dir: &Scratch, rest: &[&str]) -> assert_cmd::assert::Assert {
    let (photo, map) = (dir.arg("sample.png"), dir.arg("sample.pfm"));
    let common = ["export", &photo, "--disparity", &map, "--f-number", "2"];
    plenoscope(&[&common[..], rest].concat()).assert()
}

/// What ffprobe says of the film's stream: codec, width, height, rate, frames read.
fn probed(path: &str) -> Option<String> {
    let shown = "stream=codec_name,width,height,r_frame_rate,nb_read_frames";
    let done = Command::new("ffprobe")
        .args(["-v", "error", "-count_frames", "-of", "csv=p=0", "-show_entries", shown, path])
        .output();
    let Ok(done) = done else {
        eprintln!("SKIPPED: there is no ffprobe");
        return None;
    };
    assert!(done.stderr.is_empty(), "{}", String::from_utf8_lossy(&done.stderr));
    Some(String::from_utf8_lossy(&done.stdout).trim().to_owned())
}

#[test]
fn a_film_is_read_back_with_all_its_frames() {
    let dir = Scratch::new();
    plenoscope(&["sample", "-o", &dir.arg("")]).assert().success();
    for name in ["pull.mp4", "pull.webm"] {
        let film = dir.arg(name);
        export(&dir, &["--as", "video", "--size", "121x81", "--frames", "7", "-o", &film]).success();
        let Some(probed) = probed(&film) else { return };
        assert_eq!(probed, "av1,120,80,30/1,7", "{name}");
    }
}

#[test]
fn a_recipes_timeline_moves_the_lens() {
    let dir = Scratch::new();
    plenoscope(&["sample", "-o", &dir.arg("")]).assert().success();
    let timeline = |keys: &str| format!(r#"{{"version": 2, "timeline": {{"seconds": 0.2, "keys": [{keys}]}}}}"#);
    fs::write(dir.path("edit.json"), timeline(r#"{"at": 0, "f_number": 28}, {"at": 1, "f_number": 2}"#)).unwrap();
    let film = ["--as", "animation", "--size", "90x60", "--frames", "3", "--recipe", &dir.arg("edit.json")];
    export(&dir, &[&film[..], &["-o", &dir.arg("a.gif")]].concat()).success();
    let file = std::io::BufReader::new(fs::File::open(dir.path("a.gif")).unwrap());
    let frames = image::AnimationDecoder::into_frames(image::codecs::gif::GifDecoder::new(file).unwrap());
    let frames: Vec<_> = frames.collect_frames().unwrap();
    let apart = |a: usize, b: usize| {
        let [a, b] = [a, b].map(|n| frames[n].buffer());
        a.iter().zip(b.iter()).map(|(a, b)| u64::from(a.abs_diff(*b))).sum::<u64>()
    };
    assert!(frames.len() == 3 && apart(0, 2) > apart(1, 2) && apart(1, 2) > 0);
    fs::write(dir.path("edit.json"), timeline(r#"{"at": 1e9}"#)).unwrap();
    let refused = export(&dir, &[&film[..], &["-o", &dir.arg("b.gif")]].concat()).failure();
    assert!(String::from_utf8_lossy(&refused.get_output().stderr).contains("key 1 of its timeline is out of range"));
    assert!(!dir.path("b.gif").exists());
}
