//! Every command of the book runs as it stands there, on the sample.

use std::path::{Path, PathBuf};
use std::process::Command;

use super::common::Scratch;

fn pages() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../docs/book/src")
}

fn read(page: &str) -> String {
    std::fs::read_to_string(pages().join(page)).unwrap()
}

/// The pages that the table of contents names.
fn chapters() -> Vec<String> {
    let contents = read("SUMMARY.md");
    contents.lines().filter_map(|line| Some(line.split_once("](")?.1.trim_end_matches(')').to_owned())).collect()
}

/// The lines of a page's blocks of a language.
fn blocks<'a>(page: &'a str, language: &str) -> Vec<&'a str> {
    let opens = |line: &str| line.strip_prefix("```").is_some_and(|name| name == language);
    let mut inside = false;
    let mut found = Vec::new();
    for line in page.lines() {
        match line {
            line if opens(line) => inside = true,
            "```" => inside = false,
            line if inside && !line.is_empty() => found.push(line),
            _ => {}
        }
    }
    found
}

/// Whether a command opens the window, which needs a screen.
fn opens_window(command: &str) -> bool {
    command == "plenoscope photo.jpg"
}

/// Runs a line of the book in a folder, with the program of these tests and a cache that the pages share.
fn run(command: &str, folder: &Path) {
    let (program, arguments) = command.split_once(' ').unwrap();
    assert_eq!(program, "plenoscope", "the book's shell commands are the program's: {command}");
    let aside = PathBuf::from(env!("CARGO_TARGET_TMPDIR"));
    let done = Command::new(assert_cmd::cargo::cargo_bin!("plenoscope"))
        .args(arguments.split(' '))
        .current_dir(folder)
        .env("XDG_CACHE_HOME", aside.join("cache"))
        .env("XDG_CONFIG_HOME", aside.join("config"))
        .env("XDG_DATA_HOME", aside.join("data"))
        .output()
        .unwrap();
    assert!(done.status.success(), "{command}\n{}", String::from_utf8_lossy(&done.stderr));
}

#[test]
fn every_command_of_the_book_runs() {
    let mut ran = 0;
    for chapter in chapters() {
        let scratch = Scratch::new();
        run("plenoscope sample -o .", &scratch.path(""));
        let page = read(&chapter);
        std::fs::write(scratch.path("edit.json"), blocks(&page, "json").concat()).unwrap();
        for command in blocks(&page, "sh").into_iter().filter(|command| !opens_window(command)) {
            run(command, &scratch.path(""));
            ran += 1;
        }
    }
    assert!(ran >= 25, "the book lost its commands: {ran} are left");
}

#[test]
fn the_book_has_at_most_twelve_pages_and_all_their_pictures() {
    let chapters = chapters();
    assert!(chapters.len() <= 12, "{}", chapters.len());
    for chapter in chapters {
        for target in read(&chapter).split("![").skip(1).filter_map(|rest| rest.split_once("](")?.1.split(')').next()) {
            assert!(pages().join(target).exists(), "{chapter} shows {target}, which is not there");
        }
    }
}
