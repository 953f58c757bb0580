//! What each pixel of the picture sees: its near side, its far side, and what goes on behind them.

use super::Prepared;
use super::behind::{self, Hidden};
use super::surfaces::{self, MIXTURE, Seen};
use crate::field::{Mix, ramp};

/// Reads the pixels of rows.
pub(super) struct Reader<'a> {
    surfaces: surfaces::Reader<'a>,
    behind: behind::Reader<'a>,
}

/// A row to be read.
pub(super) struct Row {
    surfaces: surfaces::Row,
    behind: (usize, usize, f32),
}

impl Prepared {
    /// Reads pixels from column `x0` on.
    pub(super) fn reader(&self, x0: i32, count: usize) -> Reader<'_> {
        let surfaces = self.surfaces.reader(x0, count, self.size);
        Reader { surfaces, behind: self.behind.reader(x0, count, self.size) }
    }
}

impl Reader<'_> {
    pub(super) fn at_row(&self, y: i32) -> Row {
        Row { surfaces: self.surfaces.at_row(y), behind: self.behind.at_row(y) }
    }

    /// Disparity at the `i`-th pixel of the row, as the map has it.
    #[inline]
    pub(super) fn disparity(&self, row: &Row, i: usize) -> f32 {
        self.surfaces.disparity(&row.surfaces, i)
    }

    /// What the `i`-th pixel of the row sees, with its colour.
    #[inline]
    pub(super) fn at(&self, row: &Row, i: usize, color: &[f32; 3]) -> (Seen, Option<Hidden>) {
        let seen = self.surfaces.seen(&row.surfaces, i, color);
        let hidden = self.behind.hidden(row.behind, i);
        if seen.edge <= 0.0 {
            return (seen, hidden);
        }
        let seen = hidden.map_or(seen, |hidden| one_surface(seen, &hidden));
        (seen, far_side_behind(&seen, hidden))
    }
}

/// A step within one surface, before something that is much farther, is no edge of that surface.
#[inline]
fn one_surface(seen: Seen, hidden: &Hidden) -> Seen {
    let step = seen.near_px - seen.far_px;
    let two = ramp(0.6, 0.9, step / (seen.near_px - hidden.disparity_px).max(step).max(1e-6));
    let between = seen.far_px + seen.cover * step;
    Seen { near_px: between.mix(seen.near_px, two), cover: 1f32.mix(seen.cover, two), ..seen }
}

/// Behind a near side's fringe over the far side, the far side goes on, and not what is behind that.
#[inline]
fn far_side_behind(seen: &Seen, hidden: Option<Hidden>) -> Option<Hidden> {
    if seen.cover <= MIXTURE[0] || seen.cover >= MIXTURE[1] {
        return hidden;
    }
    let own = Hidden { rgb: seen.far_rgb, disparity_px: seen.far_px, share: seen.foreign, distance_px: 0.0 };
    let hidden = hidden.unwrap_or(Hidden { share: 0.0, ..own });
    let deeper = (seen.far_px - hidden.disparity_px) / (seen.near_px - seen.far_px).max(1e-6);
    let known = hidden.share * (1.0 - ramp(0.1, 0.3, deeper));
    let more = (1.0 - known) * seen.foreign;
    let t = more / (known + more).max(1e-6);
    let share = known + more;
    (share > 0.0).then(|| Hidden {
        rgb: hidden.rgb.mix(own.rgb, t),
        disparity_px: hidden.disparity_px.mix(own.disparity_px, t),
        share,
        distance_px: hidden.distance_px,
    })
}
