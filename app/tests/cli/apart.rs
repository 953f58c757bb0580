//! Decoders in a process of their own: the same pictures as within, and limits that hold.

use std::path::{Path, PathBuf};

use plenoscope::apart;
use plenoscope::io::{self, Opened};
use plenoscope::job::{Cancel, Job};

/// Photos in AV1, of all kinds that there are.
fn photos() -> Vec<PathBuf> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../tests/avif");
    let mut all: Vec<_> = folder.read_dir().unwrap().map(|entry| entry.unwrap().path()).collect();
    all.retain(|path| path.extension().is_some_and(|ending| ending == "avif"));
    all.sort();
    all
}

/// Pixels of a photo as its file has them, and what it is; or why it does not open.
fn open(path: &Path) -> Result<(String, serde_json::Value), String> {
    let opened = io::open(path, &Job { cancel: &Cancel::default(), sink: &() }).map_err(|error| error.to_string())?;
    let info = serde_json::to_value(opened.info()).unwrap();
    match opened {
        Opened::Photo(file) => Ok((format!("{:?}", file.photo.pixels()), info)),
        Opened::LightField(_) => panic!("a photo"),
    }
}

#[test]
fn a_picture_is_the_same_whoever_decodes_it() {
    let dir = tempfile::tempdir().unwrap();
    let mut photos = photos();
    assert!(photos.len() > 10);
    let whole = std::fs::read(&photos[0]).unwrap();
    for (name, cut) in [("half.avif", whole.len() / 2), ("most.avif", whole.len() - 9)] {
        let path = dir.path().join(name);
        std::fs::write(&path, &whole[..cut]).unwrap();
        photos.push(path);
    }
    let within: Vec<_> = photos.iter().map(|path| open(path)).collect();
    apart::work_with(assert_cmd::cargo::cargo_bin!("plenoscope").to_owned());
    for (path, within) in photos.iter().zip(within) {
        assert_eq!(open(path), within, "{}", path.display());
    }
}
