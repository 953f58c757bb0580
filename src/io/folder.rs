//! The photos of a folder, in the order in which people number them.

use std::cmp::Ordering;
use std::path::{Path, PathBuf};

use super::file_type::FileType;
use super::formats::file_types;
use crate::aside::parent;

/// `a` before `b` as people count: `img2` before `img10`, upper and lower case alike.
pub fn natural_order(a: &str, b: &str) -> Ordering {
    let (mut left, mut right) = (a, b);
    loop {
        match (left.chars().next(), right.chars().next()) {
            (None, None) => return a.cmp(b),
            (None, _) => return Ordering::Less,
            (_, None) => return Ordering::Greater,
            (Some(l), Some(r)) if l.is_ascii_digit() && r.is_ascii_digit() => {
                let (digits_l, digits_r) = (take_number(&mut left), take_number(&mut right));
                let order = digits_l.len().cmp(&digits_r.len()).then(digits_l.cmp(digits_r));
                if order.is_ne() {
                    return order;
                }
            }
            (Some(l), Some(r)) => {
                let order = l.to_lowercase().cmp(r.to_lowercase());
                if order.is_ne() {
                    return order;
                }
                (left, right) = (&left[l.len_utf8()..], &right[r.len_utf8()..]);
            }
        }
    }
}

/// Takes the digits at the front, without leading zeros.
fn take_number<'a>(text: &mut &'a str) -> &'a str {
    let end = text.find(|c: char| !c.is_ascii_digit()).unwrap_or(text.len());
    let (digits, rest) = text.split_at(end);
    *text = rest;
    digits.trim_start_matches('0')
}

/// The pictures of a folder in natural order; depth maps that belong to a photo (`_DEPTH`) are left out.
pub fn pictures(folder: &Path) -> std::io::Result<Vec<PathBuf>> {
    let mut found: Vec<PathBuf> = std::fs::read_dir(folder)?
        .filter_map(Result::ok)
        .map(|entry| entry.path())
        .filter(|path| is_picture(path))
        .collect();
    found.sort_by(|a, b| natural_order(&name(a), &name(b)));
    Ok(found)
}

fn is_picture(path: &Path) -> bool {
    let suffix = path.extension().map(|s| s.to_string_lossy().to_lowercase()).unwrap_or_default();
    let stem = path.file_stem().map(|s| s.to_string_lossy().to_lowercase()).unwrap_or_default();
    let has_photo = |kind: &FileType| kind.map.is_none() && kind.suffixes.contains(&suffix.as_str());
    file_types().any(has_photo) && !stem.ends_with("_depth") && !stem.starts_with('.') && path.is_file()
}

fn name(path: &Path) -> String {
    path.file_name().map(|n| n.to_string_lossy().into_owned()).unwrap_or_default()
}

/// The picture before and the one after `current` in its folder.
pub fn neighbours(current: &Path) -> std::io::Result<(Option<PathBuf>, Option<PathBuf>)> {
    let mut all = pictures(parent(current))?;
    let place = all.iter().position(|path| path.file_name() == current.file_name());
    let Some(at) = place else { return Ok((None, None)) };
    let next = (at + 1 < all.len()).then(|| all.swap_remove(at + 1));
    let previous = at.checked_sub(1).map(|before| all.swap_remove(before));
    Ok((previous, next))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_count_as_numbers() {
        let mut names = ["img10.jpg", "IMG2.jpg", "img1.jpg", "a.jpg", "img02.jpg", "img010b.jpg"];
        names.sort_by(|a, b| natural_order(a, b));
        assert_eq!(names, ["a.jpg", "img1.jpg", "IMG2.jpg", "img02.jpg", "img10.jpg", "img010b.jpg"]);
    }

    #[test]
    fn neighbours_are_found_in_natural_order() {
        let dir = tempfile::tempdir().unwrap();
        for name in ["p9.png", "p10.png", "p11.jpg", "p10_DEPTH.png", "notes.txt"] {
            std::fs::write(dir.path().join(name), b"x").unwrap();
        }
        let at = |name: &str| dir.path().join(name);
        assert_eq!(neighbours(&at("p10.png")).unwrap(), (Some(at("p9.png")), Some(at("p11.jpg"))));
        assert_eq!(neighbours(&at("p9.png")).unwrap(), (None, Some(at("p10.png"))));
        assert_eq!(neighbours(&at("p11.jpg")).unwrap(), (Some(at("p10.png")), None));
    }
}
