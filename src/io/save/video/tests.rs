//! Films as their own containers say: boxes, elements, colours.

use super::*;

fn frame(number: u32, size: [u32; 2]) -> Result<Picture, SaveError> {
    let light = |i: u32| ((i / 3 + number * 5) % 40) as f32 / 40.0;
    Ok(Picture { size, rgb_linear: (0..size[0] * size[1] * 3).map(light).collect() })
}

/// Places of the boxes of a file, by their names.
fn boxes(bytes: &[u8]) -> Vec<(String, usize, usize)> {
    let mut found = Vec::new();
    let mut at = 0;
    while at + 8 <= bytes.len() {
        let len = u32::from_be_bytes(bytes[at..at + 4].try_into().unwrap()) as usize;
        found.push((String::from_utf8_lossy(&bytes[at + 4..at + 8]).into_owned(), at + 8, at + len));
        at += len;
    }
    assert_eq!(at, bytes.len(), "boxes end where the file ends");
    found
}

#[test]
fn a_film_of_odd_size_is_cut_and_its_tables_find_the_frames() {
    let dir = tempfile::tempdir().unwrap();
    let path = dir.path().join("a.mp4");
    video(&path, (0..5).map(|n| frame(n, [65, 49])), 10).unwrap();
    let bytes = std::fs::read(&path).unwrap();
    let all = boxes(&bytes);
    assert_eq!(all.iter().map(|(name, ..)| name.as_str()).collect::<Vec<_>>(), ["ftyp", "moov", "mdat"]);
    let find = |name: &[u8]| bytes.windows(4).position(|w| w == name).unwrap();
    let word = |at: usize| u32::from_be_bytes(bytes[at..at + 4].try_into().unwrap()) as usize;
    assert_eq!(word(find(b"stco") + 12), all[2].1, "the first frame is where the table says");
    let sizes = find(b"stsz") + 12;
    assert_eq!(word(sizes), 5);
    assert_eq!((0..5).map(|n| word(sizes + 4 + 4 * n)).sum::<usize>(), all[2].2 - all[2].1);
    let entry = find(b"mp41") + 4;
    let entry = entry + bytes[entry..].windows(4).position(|w| w == b"av01").unwrap();
    assert_eq!(bytes[entry + 28..entry + 32], [0, 64, 0, 48]);
}

#[test]
fn a_film_that_cannot_be_is_told_in_a_sentence_and_leaves_no_file() {
    let dir = tempfile::tempdir().unwrap();
    let path = dir.path().join("a.webm");
    let tiny = video(&path, std::iter::once(frame(0, [12, 40])), 10).unwrap_err().to_string();
    assert!(tiny.contains("choose a larger size"), "{tiny}");
    let frames = [frame(0, [32, 32]), Err(SaveError::DiskFull("x".into()))];
    assert!(matches!(video(&path, frames.into_iter(), 10), Err(SaveError::DiskFull(_))));
    let two = [frame(0, [32, 32]), frame(1, [64, 32])];
    assert!(video(&path, two.into_iter(), 10).is_err());
    assert!(!path.exists());
}
