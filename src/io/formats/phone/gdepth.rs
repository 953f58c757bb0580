//! GDepth: a depth map in the (extended) XMP of a JPEG, and the all-in-focus photo beside it.
//!
//! Specification: developers.google.com/depthmap-metadata. White is far.

use super::jpeg::Extras;
use super::{dynamic, unit_map};
use crate::field::RelativeDepth;
use crate::io::raster::{self, Raster};
use crate::io::xmp::Xmp;
use crate::io::{DepthKind, EmbeddedDepth};

const DEPTH: &str = "http://ns.google.com/photos/1.0/depthmap/";
const IMAGE: &str = "http://ns.google.com/photos/1.0/image/";

/// How values 0 … 1 become depth; GDepth and Dynamic Depth share it.
pub(super) struct Range {
    near: f32,
    far: f32,
    inverse: bool,
    /// Metres in a unit of `near` and `far`, if that is known.
    metres: Option<f32>,
}

impl Range {
    pub(super) fn from_xmp(xmp: &Xmp, namespace: &str) -> Result<Self, String> {
        let number = |name| xmp.number(namespace, name).ok_or_else(|| format!("its depth map has no {name}"));
        let (near, far) = (number("Near")?, number("Far")?);
        if !(near > 0.0 && far > near) {
            return Err(format!("its depth map reaches from {near} to {far}"));
        }
        let inverse = match xmp.get(namespace, "Format") {
            None | Some("RangeInverse") => true,
            Some("RangeLinear") => false,
            Some(other) => return Err(format!("its depth map is in the unknown format {other}")),
        };
        let metres = match xmp.get(namespace, "Units") {
            Some("m" | "Meters" | "meters") => Some(1.0),
            Some("mm" | "Millimeters" | "millimeters") => Some(1e-3),
            _ => None,
        };
        Ok(Self { near, far, inverse, metres })
    }

    /// Inverse depth of a value 0 … 1, in 1/m where the unit is known.
    fn inverse_depth(&self, n: f32) -> f32 {
        let per_unit = if self.inverse {
            (self.far - n * (self.far - self.near)) / (self.far * self.near)
        } else {
            1.0 / (self.near + n * (self.far - self.near))
        };
        per_unit / self.metres.unwrap_or(1.0)
    }

    pub(super) fn apply(&self, map: RelativeDepth, kind: DepthKind) -> EmbeddedDepth {
        EmbeddedDepth { kind, map: map.map(|n| self.inverse_depth(n)), metric: self.metres.is_some() }
    }
}

/// The depth map of a JPEG, if it has one; the main XMP or the extended one says what it means.
pub(crate) fn read(extras: &Extras) -> Option<Result<EmbeddedDepth, String>> {
    find(&extras.xmp, extras.extended.as_ref())
}

/// The depth map that an XMP tells of.
pub(crate) fn find(main: &Xmp, extended: Option<&Result<Xmp, String>>) -> Option<Result<EmbeddedDepth, String>> {
    let data = match extended {
        None => main,
        Some(Ok(extended)) => extended,
        Some(Err(reason)) => return main.has(DEPTH).then(|| Err(reason.clone())),
    };
    (main.has(DEPTH) || data.has(DEPTH)).then(|| {
        let holder = if main.get(DEPTH, "Near").is_some() { main } else { data };
        let range = Range::from_xmp(holder, DEPTH)?;
        let picture = data.base64(DEPTH, "Data").ok_or("its depth map is missing")??;
        Ok(range.apply(unit_map(&picture).map_err(|problem| problem.to_string())?, DepthKind::Gdepth))
    })
}

/// The all-in-focus original beside a depth map, if there is one. It lies as the main picture does.
pub(super) fn original(extras: &Extras) -> Option<Result<Raster, String>> {
    let data = match &extras.extended {
        Some(extended) => extended.as_ref().ok()?,
        None => &extras.xmp,
    };
    let has_depth = [DEPTH, dynamic::DEPTH].iter().any(|space| extras.xmp.has(space) || data.has(space));
    let decode = |bytes: Vec<u8>| raster::decode(&bytes).map_err(|problem| problem.to_string());
    Some(data.base64(IMAGE, "Data").filter(|_| has_depth)?.and_then(decode))
}
