//! Files of runs and of models, written aside, then renamed: what was there before stays whole if that fails.

use std::ffi::OsString;
use std::fs::File;
use std::io::Write as _;
use std::path::Path;

use crate::TrainError;

/// Writes a file; `action` says in an error what was tried.
pub fn write(path: &Path, bytes: &[u8], action: &'static str) -> Result<(), TrainError> {
    let name = path.file_name().unwrap_or_default();
    let aside = path.with_file_name([name, ".part".as_ref()].into_iter().collect::<OsString>());
    let filled = File::create(&aside).and_then(|mut file| {
        file.write_all(bytes)?;
        file.sync_all()
    });
    filled.and_then(|()| std::fs::rename(&aside, path)).map_err(|source| {
        // What is left of it is of no use; if it cannot be removed either, the first error is the one to tell.
        drop(std::fs::remove_file(&aside));
        TrainError::File { action, source, path: path.to_owned() }
    })
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
        // A folder where the file is to be written aside.
        std::fs::create_dir(folder.path().join("config.json.part")).unwrap();
        let text = write(&path, b"third", "write the config").unwrap_err().to_string();
        assert!(text.contains("write the config") && text.ends_with("config.json"), "{text}");
        assert_eq!(std::fs::read(&path).unwrap(), b"second");
    }
}
