//! Which language is spoken: the one that was chosen, else the system's, else English.

use std::path::{Path, PathBuf};

use directories::ProjectDirs;

use super::language::{Language, SHIPPED, is_too_deep};
use super::{Message, SPOKEN, message};
use crate::within;

/// The most that a language file may hold.
const MOST_BYTES: u64 = 1 << 20;
/// The most files that are looked at.
const MOST_FILES: usize = 100;

/// From now on this thread says everything in it.
pub fn speak(language: &'static Language) {
    SPOKEN.set(Some(language));
}

/// Those in the program, then those that lie as `TAG.ftl` in the person's folder; and what of those cannot be read.
/// `own`: whether that folder is looked into. A file with a shipped language's tag takes its place.
pub fn all(own: bool) -> (Vec<&'static Language>, Vec<Message>) {
    let mut languages: Vec<_> = SHIPPED.iter().filter_map(|source| Language::shipped(source.tag)).collect();
    let mut faults = Vec::new();
    for path in folder().filter(|_| own).map(|folder| files(&folder)).unwrap_or_default() {
        match read(&path, &mut faults) {
            Some(language) => {
                languages.retain(|other| other.tag() != language.tag());
                // It is borrowed from everywhere until the program ends.
                languages.push(Box::leak(Box::new(language)));
            }
            None => faults.push(message!("language-unreadable", path = path.as_path())),
        }
    }
    (languages, faults)
}

/// The language with a tag; without one, the first of the system's that is there.
pub fn best(languages: &[&'static Language], wanted: Option<&str>) -> &'static Language {
    match wanted {
        Some(tag) => fitting(languages, tag),
        None => sys_locale::get_locales().find_map(|tag| fitting(languages, &tag)),
    }
    .unwrap_or_else(Language::english)
}

/// `pt-BR` for `pt-BR`, else `pt`; `C` is English.
fn fitting(languages: &[&'static Language], tag: &str) -> Option<&'static Language> {
    let is = |tag: &str| languages.iter().copied().find(|language| language.tag().eq_ignore_ascii_case(tag));
    let first = tag.split(['-', '_', '.', '@']).next().unwrap_or(tag);
    match first {
        "C" | "POSIX" => Some(Language::english()),
        _ => is(tag).or_else(|| is(first)),
    }
}

fn folder() -> Option<PathBuf> {
    ProjectDirs::from("", "", "plenoscope").map(|dirs| dirs.config_dir().join("languages"))
}

fn files(folder: &Path) -> Vec<PathBuf> {
    let entries = folder.read_dir().into_iter().flatten().flatten().map(|entry| entry.path());
    let mut files: Vec<_> =
        entries.filter(|path| path.extension().is_some_and(|it| it == "ftl")).take(MOST_FILES).collect();
    files.sort();
    files
}

/// A file, and the lines of it that cannot be read.
fn read(path: &Path, faults: &mut Vec<Message>) -> Option<Language> {
    let tag = path.file_stem()?.to_str().filter(|tag| tag.parse::<unic_langid::LanguageIdentifier>().is_ok())?;
    let text = within::text(path, MOST_BYTES).ok().filter(|text| !is_too_deep(text))?;
    let (language, lines) = Language::read(tag, &text);
    if let Some(first) = lines.first() {
        faults.push(message!("language-damaged", line = first, count = lines.len(), path = path));
    }
    Some(language)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_tag_finds_its_language() {
        let (languages, _) = all(false);
        for (tag, want) in [("de-AT", "de"), ("de_DE.UTF-8", "de"), ("en-GB", "en"), ("C", "en"), ("tlh", "en")] {
            assert_eq!(best(&languages, Some(tag)).tag(), want, "{tag}");
        }
    }

    #[test]
    fn a_third_language_is_one_file() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("nl.ftl");
        std::fs::write(&path, "language-name = Nederlands\nbutton-cancel = Annuleren\n%%%\n").unwrap();
        let mut faults = Vec::new();
        let dutch = read(&files(folder.path())[0], &mut faults).unwrap();
        assert_eq!((dutch.name(), dutch.plain("button-cancel")), ("Nederlands", Some("Annuleren")));
        assert_eq!(faults.len(), 1, "a line that is none is told");
        std::fs::write(folder.path().join("no language.ftl"), "").unwrap();
        assert!(read(&folder.path().join("no language.ftl"), &mut faults).is_none());
    }

    #[test]
    fn braces_within_braces_end_no_program() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("nl.ftl");
        let deep = |unit: &str| format!("button-cancel = {{1 ->\n *[a] {}", unit.repeat(50_000));
        for unit in ["{", "{A(", "{1 ->\n *[a] ", "{-a(", "{\"}\" ->\n *[a] \""] {
            std::fs::write(&path, deep(unit)).unwrap();
            assert!(read(&path, &mut Vec::new()).is_none(), "{unit}");
        }
        let many = "a = {\"{\"} ( {b} )\n-b = (((((\n".repeat(1000);
        std::fs::write(&path, many).unwrap();
        assert!(read(&path, &mut Vec::new()).is_some(), "many texts are not deep");
        assert!(SHIPPED.iter().all(|source| !is_too_deep(source.text)));
    }

    #[test]
    fn a_damaged_language_is_read_as_far_as_it_goes() {
        let mut state = 7_u64;
        let mut next = |below: usize| {
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            (state >> 33) as usize % below
        };
        let marks = b"{}()[]*->=\"\\.#$ \n\0\xff";
        let whole = SHIPPED[1].text.as_bytes();
        for _ in 0..200 {
            let from = next(whole.len() - 4000);
            let mut bytes = whole[from..from + 4000].to_vec();
            for _ in 0..40 {
                let at = next(bytes.len());
                bytes[at] = marks[next(marks.len())];
            }
            let text = String::from_utf8_lossy(&bytes);
            let (language, _) = Language::read("de", &text);
            assert!(language.ids().all(|id| !id.is_empty()));
        }
    }
}
