//! Films and timelines, as ffprobe reads them. Where there is none the test says so.

use std::io::{BufRead, BufReader};
use std::net::TcpListener;
use std::process::{Command, Stdio};
use std::time::{Duration, Instant};
use std::{fs, thread};

use super::common::{Scratch, plenoscope};
use super::living::chromium;

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

/// Shows the end of the film beside it, and tells a port how wide it is, how long, and whether it can be seen.
const PAGE: &str = r#"<video muted preload=auto src="FILM"></video><script>
const film = document.querySelector("video");
const say = (text) => new Image().src = "http://127.0.0.1:PORT/" + encodeURIComponent(text);
film.onerror = () => say(film.error.message);
film.onloadeddata = () => film.currentTime = film.duration;
film.onseeked = () => say(`${film.videoWidth} wide, ${Math.round(film.duration * 30)} frames, ${film.readyState}`);
</script>"#;
/// A decoder on a busy machine takes its time; nothing waits so long where it works.
const PATIENCE: Duration = Duration::from_secs(60);
const SILENCE: Duration = Duration::from_secs(2);

/// What the browser tells of a film in the folder, in the line of its request.
///
/// The browser's clock runs as ours: its virtual one does not wait for a decoder.
fn told(browser: &str, dir: &Scratch, film: &str) -> String {
    let port = TcpListener::bind("127.0.0.1:0").unwrap();
    let page = PAGE.replace("FILM", film).replace("PORT", &port.local_addr().unwrap().port().to_string());
    fs::write(dir.path("page.html"), page).unwrap();
    let mut browser = Command::new(browser)
        .args(["--headless=new", "--no-sandbox", "--disable-gpu", "--disable-background-networking"])
        .arg(format!("--user-data-dir={}", dir.arg(&format!("browser of {film}"))))
        .arg(format!("file://{}", dir.arg("page.html")))
        .stderr(Stdio::null())
        .spawn()
        .unwrap();
    port.set_nonblocking(true).unwrap();
    let (begin, mut line) = (Instant::now(), String::new());
    while line.is_empty() && begin.elapsed() < PATIENCE {
        thread::sleep(Duration::from_millis(50));
        if let Ok((stream, _)) = port.accept() {
            // A browser may open a connection ahead, on which it says nothing.
            stream.set_nonblocking(false).unwrap();
            stream.set_read_timeout(Some(SILENCE)).unwrap();
            let _ = BufReader::new(stream).read_line(&mut line);
        }
    }
    browser.kill().unwrap();
    browser.wait().unwrap();
    line
}

#[test]
fn a_browser_plays_the_film() {
    let Some(browser) = chromium() else { return };
    let dir = Scratch::new();
    plenoscope(&["sample", "-o", &dir.arg("")]).assert().success();
    for name in ["pull.mp4", "pull.webm"] {
        export(&dir, &["--as", "video", "--size", "121x81", "--frames", "7", "-o", &dir.arg(name)]).success();
        let told = told(browser, &dir, name);
        assert!(told.starts_with("GET /120%20wide%2C%207%20frames%2C%204 "), "{name}: {told}");
    }
}

#[test]
fn frames_are_written_as_a_folder_of_pictures() {
    let dir = Scratch::new();
    plenoscope(&["sample", "-o", &dir.arg("")]).assert().success();
    export(&dir, &["--as", "frames", "--size", "90x60", "--frames", "3", "-o", &dir.arg("film")]).success();
    let size = |name: &str| image::image_dimensions(dir.path("film").join(name)).unwrap();
    assert!(["frame_000.png", "frame_001.png", "frame_002.png"].iter().all(|name| size(name) == (90, 60)));
    assert_eq!(fs::read_dir(dir.path("film")).unwrap().count(), 3);
}

#[test]
fn a_recipes_timeline_moves_the_lens() {
    let dir = Scratch::new();
    plenoscope(&["sample", "-o", &dir.arg("")]).assert().success();
    let timeline = |keys: &str| format!(r#"{{"version": 2, "timeline": {{"seconds": 0.2, "keys": [{keys}]}}}}"#);
    fs::write(dir.path("edit.json"), timeline(r#"{"at": 0, "f_number": 28}, {"at": 1, "f_number": 2}"#)).unwrap();
    let film = ["--as", "animation", "--size", "90x60", "--frames", "3", "--recipe", &dir.arg("edit.json")];
    export(&dir, &[&film[..], &["-o", &dir.arg("a.gif")]].concat()).success();
    let file = BufReader::new(fs::File::open(dir.path("a.gif")).unwrap());
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
