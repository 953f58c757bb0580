//! `doctor`: what the program finds on this machine, and what is wrong with it.

mod limits;
mod models;
mod places;

use anyhow::Result;
use plenoscope::job::Job;
use plenoscope::kernel::Isa;
use plenoscope::synth::memory;
use plenoscope::ui::graphics;
use plenoscope::within::plain_words;
use serde_json::{Map, Value, json};

use crate::cli::Doctor;
use crate::output::{say, say_json};

/// The most letters of a line: names of devices and files are others' words.
const MOST_LETTERS: usize = 300;

/// One subject, and what is known of it.
struct Section {
    name: &'static str,
    lines: Vec<(String, String)>,
    /// Sentences: what — why — what to do.
    wrong: Vec<String>,
}

impl Section {
    fn new(name: &'static str) -> Self {
        Self { name, lines: Vec::new(), wrong: Vec::new() }
    }

    fn say(&mut self, what: &str, text: impl ToString) {
        self.lines.push((what.to_owned(), plain_words(&text.to_string(), MOST_LETTERS)));
    }
}

/// Looks at everything and says it. What is wrong is no failure of this command.
pub fn run(args: &Doctor, job: &Job) -> Result<()> {
    let mut sections = Vec::new();
    for look in [program, device, places::look, models::look, limits::look] {
        job.check()?;
        sections.push(look());
    }
    if args.json { say_json(&as_json(&sections)) } else { say(&as_text(&sections)) }
}

fn program() -> Section {
    let mut section = Section::new("program");
    section.say("version", env!("CARGO_PKG_VERSION"));
    section.say("system", format!("{} {}", std::env::consts::OS, std::env::consts::ARCH));
    let threads = std::thread::available_parallelism().map_or(1, usize::from);
    section.say("processor", format!("{threads} threads, {}", Isa::best()));
    match memory::free_bytes() {
        Some(bytes) => {
            section.say("free memory", size(bytes));
            if bytes < 1 << 30 {
                section.wrong.push(
                    "little memory is free — a light field of a photo takes about a gigabyte — close other programs, or make \
                     smaller ones (--long-side 360)"
                        .to_owned(),
                );
            }
        }
        None => section.say("free memory", "the system does not say"),
    }
    section
}

fn device() -> Section {
    let mut section = Section::new("graphics");
    let adapters = graphics::adapters();
    for adapter in &adapters {
        let limits = format!("textures to {} px, buffers to {}", adapter.texture_px, size(adapter.buffer_bytes));
        section.say(&adapter.name, format!("{}, {}, {}, {limits}", adapter.kind, adapter.interface, adapter.driver));
    }
    if adapters.is_empty() {
        section.wrong.push(
            "the window cannot be opened — no graphics driver (Vulkan, Metal or DirectX 12) answers — install one, such as \
             mesa-vulkan-drivers, or use the command line"
                .to_owned(),
        );
    } else if adapters.iter().all(|adapter| adapter.is_software) {
        section.wrong.push(
            "the window is drawn by the processor — no graphics card's driver answers — install that of your card, if there \
             is one"
                .to_owned(),
        );
    }
    if cfg!(target_os = "linux") && ["DISPLAY", "WAYLAND_DISPLAY"].iter().all(|name| std::env::var_os(name).is_none()) {
        section.wrong.push(
            "the window cannot be opened — there is no display — start it on a desktop, or use the command line"
                .to_owned(),
        );
    }
    section
}

/// Bytes as people read them.
fn size(bytes: u64) -> String {
    match bytes {
        0..1_000_000 => format!("{:.0} kB", bytes as f64 / 1e3),
        1_000_000..1_000_000_000 => format!("{:.0} MB", bytes as f64 / 1e6),
        _ => format!("{:.1} GB", bytes as f64 / 1e9),
    }
}

fn as_json(sections: &[Section]) -> Value {
    let mut all = Map::new();
    for section in sections {
        let lines = section.lines.iter().map(|(what, text)| (what.clone(), json!(text)));
        all.insert(section.name.to_owned(), Value::Object(lines.collect()));
    }
    let wrong: Vec<&String> = sections.iter().flat_map(|section| &section.wrong).collect();
    all.insert("wrong".to_owned(), json!(wrong));
    Value::Object(all)
}

fn as_text(sections: &[Section]) -> String {
    let mut text = String::new();
    for section in sections {
        text += &format!("{}\n", section.name);
        for (what, said) in &section.lines {
            text += &format!("  {what:26} {said}\n");
        }
    }
    let wrong: Vec<&String> = sections.iter().flat_map(|section| &section.wrong).collect();
    if wrong.is_empty() {
        return text + "nothing is wrong";
    }
    let lines: Vec<String> = wrong.iter().map(|line| format!("  {line}")).collect();
    format!("{text}wrong\n{}", lines.join("\n"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sizes_are_read_easily() {
        assert_eq!([999, 1_500_000, 2 << 30].map(size), ["1 kB", "2 MB", "2.1 GB"]);
    }

    #[test]
    fn what_is_wrong_is_told_at_the_end() {
        let mut section = Section::new("disk");
        section.say("free", "0 kB\u{1b}[2J");
        assert_eq!(as_text(&[section]), "disk\n  free                       0 kB [2J\nnothing is wrong");
        let section = Section { wrong: vec!["it is full".to_owned()], ..Section::new("disk") };
        assert_eq!(as_text(&[section]), "disk\nwrong\n  it is full");
    }
}
