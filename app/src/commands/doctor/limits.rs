//! What the system allows the program.

use std::fs;

use super::{Section, size};

/// Fewer open files than this are too few for a light field's views and a window.
const FEW_FILES: u64 = 256;
/// A stack below this is less than what decoders and drivers are used to, in bytes.
const SMALL_STACK: u64 = 1 << 20;

/// A limit: its line in the system's file, its name here, the least that is enough, and how it is shown.
type Kind = (&'static str, &'static str, u64, fn(u64) -> String);

/// Reads the limits of this process, where the system tells them in a file.
pub(super) fn look() -> Section {
    let mut section = Section::new("limits");
    match fs::read_to_string("/proc/self/limits") {
        Ok(text) => judge(&mut section, &text),
        Err(_) => section.say("limits", "the system does not say"),
    }
    // Version 2 of control groups, as containers have it.
    if let Some(most) = fs::read_to_string("/sys/fs/cgroup/memory.max").ok().and_then(|text| text.trim().parse().ok()) {
        section.say("memory of the container", size(most));
        if most < 2 << 30 {
            section.wrong.push(format!(
                "the container's memory is small — {} are its limit — give it 2 GB, or use --long-side 360",
                size(most)
            ));
        }
    }
    section
}

fn judge(section: &mut Section, text: &str) {
    let kinds: [Kind; 4] = [
        ("Max open files", "open files", FEW_FILES, |n| n.to_string()),
        ("Max file size", "size of a file", 1 << 30, size),
        ("Max address space", "address space", 4 << 30, size),
        ("Max stack size", "stack", SMALL_STACK, size),
    ];
    for (line, name, least, show) in kinds {
        match soft_limit(text, line) {
            None => section.say(name, "no limit"),
            Some(most) => {
                section.say(name, show(most));
                if most < least {
                    section.wrong.push(format!(
                        "a limit of the shell is low — {name}: {}, where {} are needed — raise it with ulimit",
                        show(most),
                        show(least)
                    ));
                }
            }
        }
    }
}

/// The number behind a name; none where there is no limit.
fn soft_limit(text: &str, name: &str) -> Option<u64> {
    text.lines().find_map(|line| line.strip_prefix(name))?.split_whitespace().next()?.parse().ok()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn low_limits_are_told() {
        let text = "Limit                     Soft Limit           Hard Limit           Units     \n\
                    Max file size             1024                 unlimited            bytes     \n\
                    Max stack size            8388608              unlimited            bytes     \n\
                    Max open files            1024                 524288               files     \n\
                    Max address space         unlimited            unlimited            bytes     \n";
        let mut section = Section::new("limits");
        judge(&mut section, text);
        assert_eq!(section.lines[0], ("open files".to_owned(), "1024".to_owned()));
        assert_eq!(section.lines[2], ("address space".to_owned(), "no limit".to_owned()));
        assert_eq!(section.wrong.len(), 1);
        assert!(section.wrong[0].contains("size of a file: 1 kB"), "{:?}", section.wrong);
    }
}
