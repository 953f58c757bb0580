//! Lytro's LFP container: the processed `-stk.lfp` opens as its middle picture with its depth look-up table.
//!
//! Container as in lfptools and LF Toolbox' `LFReadLFP.m`: sections of a 12-byte magic, a length, `sha1-` and 40 hex
//! digits, 35 zeros, data, zeros. Raw sensor files need the camera's own white images and are refused with advice.

use std::collections::HashMap;

use serde_json::Value;

use crate::field::RelativeDepth;
use crate::io::file_type::FileType;
use crate::io::raster;
use crate::io::{DepthKind, EmbeddedDepth, PhotoFile, Problem};

const FORMAT: &str = "Lytro LFP";
/// Lytro's containers.
pub(crate) const TYPE: FileType = FileType {
    name: FORMAT,
    suffixes: &["lfp"],
    begins: |bytes| bytes.starts_with(&MAGIC[..4]),
    photo: Some(|bytes, _job| open(bytes)),
    ..FileType::UNKNOWN
};
/// The first bytes of a container.
const MAGIC: [u8; 12] = *b"\x89LFP\x0d\x0a\x1a\x0a\0\0\0\x01";
const TABLE: &[u8; 4] = b"\x89LFM";
const DATA: &[u8; 4] = b"\x89LFC";
/// Magic, length, name with zeros.
const HEADER_BYTES: usize = 12 + 4 + 80;
/// Values on a side of the depth table at most.
const MAX_TABLE_SIDE: u64 = 4096;

/// A container, taken apart.
struct Container<'a> {
    table: Value,
    data: HashMap<&'a str, &'a [u8]>,
}

fn damaged(reason: impl ToString) -> Problem {
    Problem::damaged(FORMAT, reason)
}

fn parse(bytes: &[u8]) -> Result<Container<'_>, Problem> {
    let truncated = || Problem::Truncated { format: FORMAT };
    if bytes.len() < 16 {
        return Err(truncated());
    }
    if !bytes.starts_with(&MAGIC[..8]) {
        return Err(damaged("its head is not that of an LFP file"));
    }
    let mut at = 16;
    let (mut table, mut data) = (None, HashMap::new());
    while let Some(start) = bytes.get(at..).and_then(|rest| rest.iter().position(|&b| b != 0)) {
        at += start;
        let header = bytes.get(at..at + HEADER_BYTES).ok_or_else(truncated)?;
        let length = u32::from_be_bytes([header[12], header[13], header[14], header[15]]) as usize;
        let body_at = at + HEADER_BYTES;
        let body = bytes.get(body_at..).and_then(|rest| rest.get(..length)).ok_or_else(truncated)?;
        let name = std::str::from_utf8(&header[16..61]).map_err(|_utf8| damaged("a section has no name"))?;
        check_sha1(name, body)?;
        match &header[..4] {
            magic if magic == TABLE && table.is_none() => {
                let text = body.strip_suffix(b"\0").unwrap_or(body);
                table = Some(
                    serde_json::from_slice(text)
                        .map_err(|error| damaged(format!("its table of contents is broken ({error})")))?,
                );
            }
            magic if magic == TABLE || magic == DATA => {
                data.insert(name, body);
            }
            _ => return Err(damaged(format!("at byte {at} no section begins"))),
        }
        at = body_at + length;
    }
    Ok(Container { table: table.ok_or_else(|| damaged("it has no table of contents"))?, data })
}

fn check_sha1(name: &str, body: &[u8]) -> Result<(), Problem> {
    let found = format!("sha1-{}", sha1_smol::Sha1::from(body).digest());
    if found.eq_ignore_ascii_case(name) { Ok(()) } else { Err(damaged(format!("the checksum of {name} is wrong"))) }
}

/// One picture of the focal stack.
struct Slice<'a> {
    lambda: f64,
    bytes: &'a [u8],
}

/// Opens a processed file: the picture focused nearest to the camera's own focus, and the depth table.
fn open(bytes: &[u8]) -> Result<PhotoFile, Problem> {
    let container = parse(bytes)?;
    let mut slices = Vec::new();
    let mut depth = None;
    visit(&container.table, &mut |object| {
        if let Some(images) = object.get("imageArray").and_then(Value::as_array) {
            slices.extend(images.iter().filter_map(|image| slice(&container, image)));
        }
        if let Some(table) = object.get("depthLut") {
            depth = Some(depth_table(&container, table));
        }
    });
    let middle = slices.iter().min_by(|a, b| a.lambda.abs().total_cmp(&b.lambda.abs()));
    let Some(middle) = middle else {
        return Err(Problem::Unsupported {
            format: FORMAT,
            reason: "it holds raw sensor data, which need the calibration of their camera".to_owned(),
            advice: "export it as ESLF or as views with Lytro Desktop or lfptool, and open that",
        });
    };
    let mut file = PhotoFile::from_raster(raster::jpeg::decode(middle.bytes)?, FORMAT)?;
    let note = format!(
        "{} pictures, focus from {:.1} to {:.1}",
        slices.len(),
        extreme(&slices, f64::min),
        extreme(&slices, f64::max)
    );
    file.info.notes.push(("focal stack".to_owned(), note));
    match depth {
        Some(Ok(depth)) => file.set_depth(depth),
        Some(Err(reason)) => file.warn(format!("the depth table is left out — {reason}")),
        None => {}
    }
    Ok(file)
}

fn extreme(slices: &[Slice], pick: fn(f64, f64) -> f64) -> f64 {
    slices.iter().map(|slice| slice.lambda).reduce(pick).unwrap_or(0.0)
}

/// Calls `found` for every object of the table; JSON's own depth limit bounds the recursion.
fn visit(value: &Value, found: &mut impl FnMut(&serde_json::Map<String, Value>)) {
    match value {
        Value::Object(object) => {
            found(object);
            object.values().for_each(|value| visit(value, found));
        }
        Value::Array(values) => values.iter().for_each(|value| visit(value, found)),
        _ => {}
    }
}

fn slice<'a>(container: &Container<'a>, image: &Value) -> Option<Slice<'a>> {
    let bytes = *container.data.get(image.get("imageRef")?.as_str()?)?;
    Some(Slice { lambda: image.get("lambda")?.as_f64()?, bytes })
}

/// The table of λ: smaller is nearer to the camera.
fn depth_table(container: &Container, table: &Value) -> Result<EmbeddedDepth, String> {
    let side = |name| table.get(name).and_then(Value::as_u64).filter(|n| (1..=MAX_TABLE_SIDE).contains(n));
    let (width, height) = side("width").zip(side("height")).ok_or("it has no size")?;
    let name = table.get("imageRef").and_then(Value::as_str).ok_or("it has no data")?;
    let bytes = container.data.get(name).ok_or("its data are missing")?;
    let count = (width * height) as usize;
    let values = bytes.get(..count * 4).ok_or("it is cut off")?.as_chunks().0.iter().map(|b| -f32::from_le_bytes(*b));
    let map = RelativeDepth::new([width as u32, height as u32], values.collect()).map_err(|error| error.to_string())?;
    Ok(EmbeddedDepth { kind: DepthKind::LytroTable, map, metric: false })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::io::{Opened, open_bytes};

    fn section(magic: &[u8; 4], body: &[u8]) -> (String, Vec<u8>) {
        let name = format!("sha1-{}", sha1_smol::Sha1::from(body).digest());
        let mut out = magic.to_vec();
        out.extend(b"\x0d\x0a\x1a\x0a\0\0\0\0");
        out.extend((body.len() as u32).to_be_bytes());
        out.extend(name.as_bytes());
        out.extend([0; 35]);
        out.extend(body);
        out.extend(vec![0; 16 - out.len() % 16]);
        (name, out)
    }

    fn jpeg(gray: u8) -> Vec<u8> {
        let mut bytes = Vec::new();
        let pixels = [gray; 16 * 16];
        jpeg_encoder::Encoder::new(&mut bytes, 90).encode(&pixels, 16, 16, jpeg_encoder::ColorType::Luma).unwrap();
        bytes
    }

    /// A stack of two pictures and a 2×2 table.
    fn stack() -> Vec<u8> {
        let (far, far_section) = section(DATA, &jpeg(40));
        let (sharp, sharp_section) = section(DATA, &jpeg(200));
        let table: Vec<u8> = [-5.0f32, 1.0, 2.0, 9.0].iter().flat_map(|l| l.to_le_bytes()).collect();
        let (lut, lut_section) = section(DATA, &table);
        let json = format!(
            r#"{{"picture":{{"accelerationArray":[{{"vendorContent":{{"depthLut":{{"width":2,"height":2,"imageRef":"{lut}"}},
            "imageArray":[{{"imageRef":"{far}","lambda":7.5}},{{"imageRef":"{sharp}","lambda":-0.5}}]}}}}]}}}}"#
        );
        let mut file = MAGIC.to_vec();
        file.extend([0; 4]);
        for part in [section(TABLE, json.as_bytes()).1, far_section, sharp_section, lut_section] {
            file.extend(part);
        }
        file
    }

    #[test]
    fn a_processed_file_opens_with_its_depth() {
        let Opened::Photo(file) = open_bytes(&stack(), None).unwrap() else { panic!("a photo") };
        assert!(file.photo.srgb8()[0].abs_diff(200) < 3, "the picture nearest to λ = 0");
        assert_eq!(file.depth.as_ref().unwrap().map.nearness(), [5.0, -1.0, -2.0, -9.0]);
    }

    #[test]
    fn a_wrong_checksum_and_every_cut_are_told() {
        let whole = stack();
        let mut tampered = whole.clone();
        let at = whole.windows(7).position(|w| w == b"picture").unwrap();
        tampered[at] = b'P';
        assert!(open(&tampered).unwrap_err().to_string().contains("checksum"));
        let last = whole.iter().rposition(|&b| b != 0).unwrap();
        for end in (0..last).step_by(last / 40) {
            assert!(open(&whole[..end]).is_err(), "cut at {end} of {last}");
        }
    }

    #[test]
    fn raw_files_are_refused_with_advice() {
        let mut file = MAGIC.to_vec();
        file.extend([0; 4]);
        file.extend(section(TABLE, br#"{"frames":[]}"#).1);
        assert!(matches!(open(&file), Err(Problem::Unsupported { .. })));
    }
}
