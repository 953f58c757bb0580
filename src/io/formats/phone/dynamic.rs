//! Dynamic Depth (Android 10 and later): pictures behind the JPEG, listed in its XMP.

use super::gdepth::Range;
use super::jpeg::Extras;
use super::unit_map;
use crate::io::xmp::Xmp;
use crate::io::{DepthKind, EmbeddedDepth};

pub(super) const DEPTH: &str = "http://ns.google.com/photos/dd/1.0/depthmap/";
const ITEM: &str = "http://ns.google.com/photos/dd/1.0/item/";

struct Item<'a> {
    uri: &'a str,
    semantic: &'a str,
    length: usize,
    padding: usize,
}

fn item<'a>(fields: &[(&'a str, &'a str)]) -> Result<Item<'a>, String> {
    let text = |name| fields.iter().find(|(key, _)| *key == name).map_or("", |(_, value)| value);
    let number = |name| match text(name) {
        "" => Ok(0),
        text => text.parse().map_err(|_parse| format!("its item list has the length `{text}`")),
    };
    Ok(Item {
        uri: text("DataURI"),
        semantic: text("Semantic"),
        length: number("Length")?,
        padding: number("Padding")?,
    })
}

/// The depth map of a JPEG, if its XMP tells of one.
pub(crate) fn read(extras: &Extras) -> Option<Result<EmbeddedDepth, String>> {
    extras.xmp.has(DEPTH).then(|| depth(&extras.xmp, extras.bytes, extras.end))
}

/// The depth map of a file whose first picture ends at `end`.
fn depth(xmp: &Xmp, file: &[u8], end: usize) -> Result<EmbeddedDepth, String> {
    let range = Range::from_xmp(xmp, DEPTH)?;
    let groups = xmp.groups(ITEM);
    let items = groups.iter().map(|fields| item(fields)).collect::<Result<Vec<_>, _>>()?;
    let uri = xmp.get(DEPTH, "DepthURI").unwrap_or("");
    let wanted = |item: &Item| (!uri.is_empty() && item.uri == uri) || (uri.is_empty() && item.semantic == "Depth");
    let at = items.iter().position(wanted).ok_or("its item list does not name the depth map")?;
    // Payloads follow the first picture in order; some writers count from the file's end instead.
    let before =
        |items: &[Item]| items.iter().try_fold(0usize, |sum, i| sum.checked_add(i.length)?.checked_add(i.padding));
    let from_picture = before(&items[..at]).and_then(|skip| end.checked_add(skip));
    let from_end = before(&items[at..]).and_then(|rest| file.len().checked_sub(rest));
    let payload = |start: Option<usize>| file.get(start?..start?.checked_add(items[at].length)?);
    let mut reason = "its depth map lies outside the file".to_owned();
    for bytes in [payload(from_picture), payload(from_end)].into_iter().flatten() {
        match unit_map(bytes) {
            Ok(map) => return Ok(range.apply(map, DepthKind::DynamicDepth)),
            Err(problem) => reason = problem.to_string(),
        }
    }
    Err(reason)
}
