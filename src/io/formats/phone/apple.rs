//! Apple's portrait photos: a second picture holds the depth, and XMP beside it the scale (namespace `apdi`).

use super::jpeg::Extras;
use super::unit_map;
use crate::field::RelativeDepth;
use crate::io::jpeg_parts;
use crate::io::xmp::Xmp;
use crate::io::{DepthKind, EmbeddedDepth};

const PIXEL_DATA: &str = "http://ns.apple.com/pixeldatainfo/1.0/";
const DEPTH_DATA: &str = "http://ns.apple.com/depthData/1.0/";

/// Pictures behind the first one that are looked at.
const MAX_PICTURES: usize = 16;

/// Looks for a depth map among the pictures behind the first of a JPEG (MPO files).
pub(crate) fn read_jpeg(extras: &Extras) -> Option<Result<EmbeddedDepth, String>> {
    let mut rest = &extras.bytes[extras.end..];
    for _ in 0..MAX_PICTURES {
        let start = rest.windows(3).position(|three| three == [0xff, 0xd8, 0xff])?;
        rest = &rest[start..];
        let parts = jpeg_parts::parse(rest);
        let xmp = parts.xmp().and_then(|packet| Xmp::parse(packet).ok());
        if let Some(xmp) = xmp.filter(|xmp| xmp.has(PIXEL_DATA) && Scale::is_depth_map(xmp)) {
            let map = unit_map(rest).map_err(|problem| problem.to_string());
            return Some(map.map(|map| Scale::from_xmp(&xmp).apply(map)));
        }
        rest = &rest[parts.end?..];
    }
    None
}

/// The scale of a map.
pub(super) struct Scale {
    range: [f32; 2],
    is_depth: bool,
    metric: bool,
}

impl Scale {
    /// From the XMP of the auxiliary picture. Without it, white is taken as near.
    pub(super) fn from_xmp(xmp: &Xmp) -> Self {
        let number = |name, other| xmp.number(PIXEL_DATA, name).unwrap_or(other);
        Self {
            range: [number("FloatMinValue", 0.0), number("FloatMaxValue", 1.0)],
            is_depth: xmp.get(PIXEL_DATA, "AuxiliaryImageType") == Some("depth"),
            metric: xmp.get(DEPTH_DATA, "Accuracy") == Some("absolute"),
        }
    }

    /// Whether the XMP is that of a depth map, not of a matte or a gain map.
    fn is_depth_map(xmp: &Xmp) -> bool {
        matches!(xmp.get(PIXEL_DATA, "AuxiliaryImageType"), Some("disparity" | "depth"))
    }

    /// The map in inverse depth. Disparity is 1/m already: `FloatMin + n · (FloatMax − FloatMin)`.
    pub(super) fn apply(&self, map: RelativeDepth) -> EmbeddedDepth {
        let [low, high] = self.range;
        let map = map.map(|n| {
            let value = low + n * (high - low);
            if self.is_depth { 1.0 / value.max(1e-3) } else { value }
        });
        EmbeddedDepth { kind: DepthKind::ApplePortrait, map, metric: self.metric }
    }
}
