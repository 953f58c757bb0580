//! What others sent stays within bounds: ordinary files of a bounded length, names that lead nowhere else, and words that
//! command no terminal.

use std::fs::File;
use std::io::{self, Read};
use std::path::Path;

/// The longest name of a file or a folder that is taken from a text.
const LONGEST_NAME: usize = 255;

/// Opens a file for reading, if it is an ordinary one: pipes and devices may never end.
///
/// # Errors
/// The system's; `InvalidInput` for what is no ordinary file.
pub fn open(path: &Path) -> io::Result<File> {
    let mut options = File::options();
    options.read(true);
    // A pipe that nobody writes to is not waited for.
    #[cfg(unix)]
    std::os::unix::fs::OpenOptionsExt::custom_flags(&mut options, libc::O_NONBLOCK);
    let file = options.open(path)?;
    let facts = file.metadata()?;
    if facts.is_dir() {
        return Err(io::Error::new(io::ErrorKind::IsADirectory, "it is a folder"));
    }
    if !facts.is_file() {
        return Err(io::Error::new(io::ErrorKind::InvalidInput, "it is no ordinary file"));
    }
    Ok(file)
}

/// Reads a file whole, unless it is longer than it should be; it may grow meanwhile.
///
/// # Errors
/// Those of [`open`]; `FileTooLarge`.
pub fn bytes(path: &Path, most_bytes: u64) -> io::Result<Vec<u8>> {
    let file = open(path)?;
    let length = file.metadata()?.len();
    let mut bytes = Vec::with_capacity(length.min(most_bytes) as usize);
    if length <= most_bytes {
        file.take(most_bytes + 1).read_to_end(&mut bytes)?;
    }
    if length > most_bytes || bytes.len() as u64 > most_bytes {
        return Err(io::Error::new(io::ErrorKind::FileTooLarge, "it is too large for what it should be"));
    }
    Ok(bytes)
}

/// The same of a text.
///
/// # Errors
/// Those of [`bytes`]; `InvalidData` for what is no UTF-8.
pub fn text(path: &Path, most_bytes: u64) -> io::Result<String> {
    let not_text = |_| io::Error::new(io::ErrorKind::InvalidData, "it is no UTF-8 text");
    String::from_utf8(bytes(path, most_bytes)?).map_err(not_text)
}

/// Whether a name is one of a file or a folder right here, on every system.
pub fn is_plain_name(name: &str) -> bool {
    !matches!(name, "" | "." | "..")
        && name.len() <= LONGEST_NAME
        && !name.contains(['/', '\\', ':'])
        && !name.chars().any(char::is_control)
}

/// A stranger's words as a person is shown them: without what a terminal obeys, and not for ever.
pub fn plain_words(text: &str, most: usize) -> String {
    let mut plain = text.chars().map(|letter| if is_odd(letter) { ' ' } else { letter });
    let mut short: String = plain.clone().take(most).collect();
    if plain.nth(most).is_some() {
        short.push('…');
    }
    short
}

/// Control characters, and those that turn the direction of what follows.
pub fn is_odd(letter: char) -> bool {
    letter.is_control() || matches!(letter, '\u{200e}' | '\u{200f}' | '\u{202a}'..='\u{202e}' | '\u{2066}'..='\u{2069}')
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_that_lead_elsewhere_are_told() {
        for name in ["model.onnx", "α β.bin", "..model", "a.b.c", "-x"] {
            assert!(is_plain_name(name), "{name}");
        }
        for name in ["", ".", "..", "../x", "a/b", "/etc/passwd", "a\\b", "c:x", "x\0", "\u{1b}[2J", &"x".repeat(256)] {
            assert!(!is_plain_name(name), "{name:?}");
        }
    }

    #[test]
    fn words_command_no_terminal_and_end() {
        assert_eq!(plain_words("\u{1b}]0;owned\u{7} a\nb \u{202e}gpj", 100), " ]0;owned  a b  gpj");
        assert_eq!(plain_words(&"x".repeat(1000), 3), "xxx…");
        assert_eq!(plain_words("xyz", 3), "xyz");
    }

    #[test]
    fn long_files_are_not_read() {
        let dir = tempfile::tempdir().unwrap();
        let path = dir.path().join("a");
        std::fs::write(&path, "12345").unwrap();
        assert_eq!(text(&path, 5).unwrap(), "12345");
        assert_eq!(bytes(&path, 4).unwrap_err().kind(), io::ErrorKind::FileTooLarge);
        std::fs::write(&path, b"\xff").unwrap();
        assert_eq!(text(&path, 5).unwrap_err().kind(), io::ErrorKind::InvalidData);
        assert_eq!(bytes(dir.path(), 5).unwrap_err().kind(), io::ErrorKind::IsADirectory);
    }

    #[cfg(unix)]
    #[test]
    fn a_device_without_end_is_no_file() {
        assert_eq!(bytes(Path::new("/dev/zero"), 5).unwrap_err().kind(), io::ErrorKind::InvalidInput);
    }
}
