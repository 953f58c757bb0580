//! What Apple writes beside a depth map: the scale of its values (namespace `apdi`).

use super::UnitMap;
use crate::io::xmp::Xmp;
use crate::io::{DepthKind, EmbeddedDepth};

pub(super) const PIXEL_DATA: &str = "http://ns.apple.com/pixeldatainfo/1.0/";
const DEPTH_DATA: &str = "http://ns.apple.com/depthData/1.0/";

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
    pub(super) fn is_depth_map(xmp: &Xmp) -> bool {
        matches!(xmp.get(PIXEL_DATA, "AuxiliaryImageType"), Some("disparity" | "depth"))
    }

    /// The map in inverse depth. Disparity is 1/m already: `FloatMin + n · (FloatMax − FloatMin)`.
    pub(super) fn apply(&self, map: UnitMap) -> EmbeddedDepth {
        let [low, high] = self.range;
        let UnitMap { size, values } = map.map(|n| {
            let value = low + n * (high - low);
            if self.is_depth { 1.0 / value.max(1e-3) } else { value }
        });
        EmbeddedDepth { kind: DepthKind::ApplePortrait, size, inverse_depth: values, metric: self.metric }
    }
}
