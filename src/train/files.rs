//! Files of runs and of models, written aside, then renamed: what was there before stays whole if that fails.

use std::io::Write as _;
use std::path::Path;

use plenoscope::aside::NewFile;

use crate::TrainError;

/// Writes a file; `action` says in an error what was tried.
pub fn write(path: &Path, bytes: &[u8], action: &'static str) -> Result<(), TrainError> {
    let written = NewFile::new(path).and_then(|mut new| {
        new.file().write_all(bytes)?;
        new.put()
    });
    written.map_err(|source| TrainError::File { action, source, path: path.to_owned() })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_was_there_stays_whole_and_nothing_is_left_beside_it() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("config.json");
        write(&path, b"first", "write").unwrap();
        write(&path, b"second", "write").unwrap();
        assert_eq!(std::fs::read(&path).unwrap(), b"second");
        assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 1);
        let text =
            write(&folder.path().join("none/config.json"), b"third", "write the config").unwrap_err().to_string();
        assert!(text.contains("write the config") && text.ends_with("config.json"), "{text}");
        assert_eq!(std::fs::read(&path).unwrap(), b"second");
    }
}
