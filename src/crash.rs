//! What is kept of a fault in the program: a small report beside the settings, for whoever mends it. It holds what broke,
//! where, and the last things that were done; no picture, and of files no more than names. Nothing is sent.

use std::backtrace::Backtrace;
use std::collections::VecDeque;
use std::fs::{self, File};
use std::io::{self, Write};
use std::panic::{PanicHookInfo, set_hook, take_hook};
use std::path::{Path, PathBuf};
use std::sync::Mutex;
use std::sync::atomic::{AtomicU32, Ordering};
use std::time::{SystemTime, UNIX_EPOCH};

use directories::ProjectDirs;

use crate::within;

/// How many things that were done are remembered.
const ACTIONS: usize = 10;
/// Reports that are kept; older ones go.
const KEPT: usize = 10;
/// Reports of one run: what breaks in a loop is told once and some.
const MOST_A_RUN: u32 = 5;
/// The most of a report that is read.
const MOST_BYTES: u64 = 256 << 10;
/// Reports that nobody was offered yet, and those that somebody was.
const NEW: &str = "crash-";
const SEEN: &str = "seen-";
const ENDING: &str = ".txt";

/// What was done last, the latest at the end.
static DONE: Mutex<VecDeque<String>> = Mutex::new(VecDeque::new());

/// A report on the disk.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Report {
    /// Where it lies.
    pub path: PathBuf,
    /// What it says.
    pub text: String,
}

/// Remembers something that was done, by its name: never a path, never what a person typed.
pub fn note(action: &str) {
    // Whoever holds it is about to let go, or broke while it did: then there is nothing to remember.
    if let Ok(mut done) = DONE.lock() {
        remember(&mut done, action);
    }
}

fn remember(done: &mut VecDeque<String>, action: &str) {
    done.push_back(action.to_owned());
    let over = done.len().saturating_sub(ACTIONS);
    done.drain(..over);
}

/// Where reports lie: beside the window's settings; none where the system has no such place.
pub fn folder() -> Option<PathBuf> {
    ProjectDirs::from("", "", "plenoscope").map(|dirs| dirs.data_dir().join("crashes"))
}

/// From now on each panic that nobody expects writes a report into a folder. What is said about it on stderr stays.
pub fn watch(folder: PathBuf) {
    static WRITTEN: AtomicU32 = AtomicU32::new(0);
    let say = take_hook();
    set_hook(Box::new(move |panic| {
        say(panic);
        if WRITTEN.fetch_add(1, Ordering::Relaxed) < MOST_A_RUN {
            match keep(&folder, &describe(panic, &Backtrace::force_capture().to_string())) {
                Ok(_) => log::error!("a report of this fault was kept; plenoscope doctor says where"),
                Err(error) => log::error!("no report of this fault could be kept: {error}"),
            }
        }
    }));
}

/// The reports of a folder, the latest first.
pub fn reports(folder: &Path) -> Vec<PathBuf> {
    let number = |path: &PathBuf| {
        let name = path.file_name()?.to_str()?;
        let rest = name.strip_prefix(NEW).or_else(|| name.strip_prefix(SEEN))?;
        rest.strip_suffix(ENDING)?.replace('-', "").parse::<u64>().ok()
    };
    let files = fs::read_dir(folder).into_iter().flatten().flatten().map(|entry| entry.path());
    let mut found: Vec<_> = files.filter_map(|path| Some((number(&path)?, path))).collect();
    found.sort_by(|a, b| b.cmp(a));
    found.into_iter().map(|(_, path)| path).collect()
}

/// The latest report that nobody was offered yet. From now on all that are there count as offered.
pub fn take_unseen(folder: &Path) -> Option<Report> {
    let name = |path: &Path| path.file_name().map(|name| name.to_string_lossy().into_owned()).unwrap_or_default();
    let mut latest = None;
    for path in reports(folder).into_iter().filter(|path| name(path).starts_with(NEW)) {
        let seen = folder.join(name(&path).replacen(NEW, SEEN, 1));
        // One that cannot be renamed would be offered for ever.
        if fs::rename(&path, &seen).is_ok() && latest.is_none() {
            latest = within::text(&seen, MOST_BYTES).ok().map(|text| Report { path: seen, text });
        }
    }
    latest
}

fn keep(folder: &Path, text: &str) -> io::Result<PathBuf> {
    fs::create_dir_all(folder)?;
    let now = SystemTime::now().duration_since(UNIX_EPOCH).unwrap_or_default();
    let path = folder.join(format!("{NEW}{}-{:03}{ENDING}", now.as_secs(), now.subsec_millis()));
    let mut options = File::options();
    options.write(true).create_new(true);
    #[cfg(unix)]
    std::os::unix::fs::OpenOptionsExt::mode(&mut options, 0o600);
    options.open(&path)?.write_all(text.as_bytes())?;
    reports(folder).iter().skip(KEPT).try_for_each(fs::remove_file)?;
    Ok(path)
}

fn describe(panic: &PanicHookInfo<'_>, backtrace: &str) -> String {
    let at = panic.location().map(ToString::to_string).unwrap_or_default();
    let what = panic.payload_as_str().unwrap_or("something that is no text");
    let thread = std::thread::current().name().unwrap_or("without a name").to_owned();
    let secs = SystemTime::now().duration_since(UNIX_EPOCH).unwrap_or_default().as_secs();
    // The thread that broke may be the one that was noting something down.
    let done = DONE.try_lock().map(|done| Vec::from(done.clone()).join("\n  ")).unwrap_or_default();
    let [system, processor, version] = [std::env::consts::OS, std::env::consts::ARCH, env!("CARGO_PKG_VERSION")];
    let text = format!(
        "Plenoscope {version} on {system}, {processor}\n\
         {secs} s after the beginning of 1970 (UTC)\n\
         thread {thread} broke at {at}\n\
         {what}\n\n\
         done before, the latest at the end:\n  {done}\n\n\
         {backtrace}\n"
    );
    names_only(&text)
}

/// A text whose paths are names alone. A path may hold spaces: from the word that it begins in to its last separator in
/// the same part of a sentence all goes.
fn names_only(text: &str) -> String {
    const ENDS: [&str; 2] = [": ", " — "];
    fn without(text: &str, ends: &[&str]) -> String {
        if let [end, rest @ ..] = ends {
            return text.split(end).map(|part| without(part, rest)).collect::<Vec<_>>().join(end);
        }
        let is_separator = |letter: char| matches!(letter, '/' | '\\');
        let (Some(first), Some(last)) = (text.find(is_separator), text.rfind(is_separator)) else {
            return text.to_owned();
        };
        let begins = |letter: char| letter.is_whitespace() || "\"'`([<".contains(letter);
        let start = text[..first].rfind(begins).map_or(0, |at| at + 1);
        format!("{}{}", &text[..start], &text[last + 1..])
    }
    text.lines().map(|line| without(line, &ENDS)).collect::<Vec<_>>().join("\n")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn paths_become_names() {
        for (text, want) in [
            ("at /rustc/5b1/library/std/src/panicking.rs:697:5", "at panicking.rs:697:5"),
            ("   3: plenoscope::ui::worker::Worker<R>::spawn", "   3: plenoscope::ui::worker::Worker<R>::spawn"),
            ("could not read /home/me/My Photos/a b.jpg", "could not read a b.jpg"),
            ("bad \"/home/me/My Photos/a b.jpg\" here", "bad \"a b.jpg\" here"),
            (r"bad C:\Users\me\x.heic: No such file", "bad x.heic: No such file"),
            ("it failed — /a/b/c.jpg — try /d/e.jpg: /f/g", "it failed — c.jpg — try e.jpg: g"),
            ("thread synth broke at src/ui/app.rs:1:2", "thread synth broke at app.rs:1:2"),
        ] {
            assert_eq!(names_only(text), want);
        }
    }

    #[test]
    fn a_report_is_offered_once_and_old_ones_go() {
        let dir = tempfile::tempdir().unwrap();
        assert_eq!(take_unseen(&dir.path().join("none")), None);
        for number in 0..KEPT + 3 {
            let first = keep(dir.path(), &format!("fault {number}")).unwrap();
            assert!(first.exists());
            std::thread::sleep(std::time::Duration::from_millis(2));
        }
        assert_eq!(reports(dir.path()).len(), KEPT);
        let offered = take_unseen(dir.path()).unwrap();
        assert_eq!((offered.text.as_str(), offered.path.exists()), ("fault 12", true));
        assert_eq!(take_unseen(dir.path()), None);
        assert_eq!(reports(dir.path()).len(), KEPT, "they stay for whoever looks");
    }

    #[test]
    fn ten_things_are_remembered() {
        let mut done = VecDeque::new();
        (0..25).for_each(|number| remember(&mut done, &format!("thing {number}")));
        assert_eq!((done.len(), done[0].as_str(), done[9].as_str()), (ACTIONS, "thing 15", "thing 24"));
    }
}
