//! Both eyes of a spatial photo (stereo-pair group `ster`): matched, they give depth.

use heifer::heifer_isobmff::BoxIter;
use heifer::heifer_isobmff::{HeifFile, ItemId};

use super::heic::decode_item;
use crate::field::Raster;
use crate::io::formats::matching;
use crate::io::{DepthKind, EmbeddedDepth};

/// The items of the stereo pair, left first, if the file has one.
pub(super) fn stereo_pair(bytes: &[u8]) -> Option<[ItemId; 2]> {
    let find = |data, kind: &[u8; 4]| BoxIter::new(data).flatten().find(|b| b.header.box_type.0 == *kind);
    let meta = find(bytes, b"meta")?;
    let groups = find(meta.content.get(4..)?, b"grpl")?;
    let pair = find(groups.content, b"ster")?;
    // Version and flags, group id, count, then the items.
    let number = |at: usize| Some(u32::from_be_bytes(*pair.content.get(at..)?.first_chunk()?));
    (number(8)? == 2).then_some([number(12)?, number(16)?])
}

/// Depth of the main photo from the pair, if there is one.
pub(crate) fn read(file: &HeifFile, bytes: &[u8]) -> Option<Result<EmbeddedDepth, String>> {
    stereo_pair(bytes).map(|pair| depth(file, bytes, pair))
}

fn depth(file: &HeifFile, bytes: &[u8], [left, right]: [ItemId; 2]) -> Result<EmbeddedDepth, String> {
    let primary = file.primary_id;
    let other = if primary == right { left } else { right };
    let gray = |id| {
        let image = decode_item(file, bytes, id).map_err(|problem| problem.to_string())?;
        let [red, green, blue] = [0.3, 0.6, 0.1].map(|share| share / image.white);
        let luma = |px: &[u16; 4]| red * f32::from(px[0]) + green * f32::from(px[1]) + blue * f32::from(px[2]);
        Raster::new(image.size, image.pixels.iter().map(luma).collect()).map_err(|error| error.to_string())
    };
    let (from, to) = (gray(primary)?, gray(other)?);
    // Seen from the right eye, near things have moved to the left.
    let sign = if primary == right { 1.0 } else { -1.0 };
    let map = matching::stereo(from, to, sign).ok_or("the two eyes do not match")?;
    Ok(EmbeddedDepth { kind: DepthKind::SpatialPair, map, metric: false })
}
