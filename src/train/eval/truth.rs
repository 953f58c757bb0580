//! Figures on depth that is true: measured by a sensor or by stereo, or known because the scene was drawn.
//!
//! Every Spearman stands beside that of the row number on the same pixels; the margin between the two has a 95 %
//! interval by bootstrap over pictures. A net that is not above the row with confidence is no better than a gradient.

use serde::Serialize;

use super::Rgb;
use super::metrics::{mean, spearman};
use super::sheet::{depth_tile, usual_range};
use crate::loss::affine_fit;
use crate::rng::Rng;
use crate::scenes::raster::Raster;

/// An edge of depth: a step between neighbours of this share of the picture's usual range.
const EDGE: f32 = 0.12;
/// How near to a true edge a predicted one must be, pixels.
const EDGE_PX: isize = 2;
/// How far from a true edge the steepest step is looked for, pixels.
const SEARCH_PX: isize = 8;
/// Least width of the surround of a thin part on either side, and most of the part itself, pixels.
const THIN_PX: usize = 3;
/// By what share of the usual range a thin part stands before both its sides, and what share of that a net must show.
const THIN_STEP: f32 = 0.15;
const THIN_FOUND: f32 = 0.3;
/// Resamples of the bootstrap.
const RESAMPLES: usize = 2000;

/// Figures of one picture.
#[derive(Clone, Debug, Default, Serialize)]
pub struct Figures {
    /// The picture.
    pub id: String,
    /// Room, street …
    pub kind: String,
    /// Rank correlation with the truth.
    pub spearman: f32,
    /// That of the row number.
    pub rows_spearman: f32,
    /// Mean absolute difference after the best scale and shift, as a share of the usual range of the truth.
    pub fit_error: f32,
    /// F-score of edges of depth within 2 px; none where the truth has no edges.
    pub edge_f: Option<f32>,
    /// The share of the true edges at which the steepest step that falls the same way, of those up to 8 px away that no
    /// other true edge is nearer to, lies within 2 px.
    pub edges: Option<f32>,
    /// The share of parts at most 3 px wide that stand out.
    pub thin: Option<f32>,
    /// The share of such parts of the net's map that stand out in truth.
    pub thin_true: Option<f32>,
}

/// Means over the pictures of a kind.
#[derive(Clone, Debug, Serialize)]
pub struct Group {
    /// The kind, or `all`.
    pub kind: String,
    /// Pictures.
    pub count: usize,
    /// Mean Spearman.
    pub spearman: f32,
    /// That of the row number.
    pub rows_spearman: f32,
    /// The difference.
    pub margin: f32,
    /// Its 95 % interval.
    pub margin_interval: [f32; 2],
    /// Mean of [`Figures::fit_error`].
    pub fit_error: f32,
    /// Mean of [`Figures::edge_f`].
    pub edge_f: Option<f32>,
    /// Mean of [`Figures::edges`].
    pub edges: Option<f32>,
    /// Mean of [`Figures::thin`].
    pub thin: Option<f32>,
    /// Mean of [`Figures::thin_true`].
    pub thin_true: Option<f32>,
}

/// A depth map beside the truth, `[y, x]`; larger is nearer, NaN in the truth where it is not known.
pub struct Compared<'a> {
    /// Width and height.
    pub size: [usize; 2],
    /// What a net says.
    pub depth: &'a [f32],
    /// What is so.
    pub truth: &'a [f32],
}

impl Compared<'_> {
    /// The figures of a picture.
    pub fn figures(&self, id: &str, kind: &str) -> Figures {
        let known: Vec<usize> = (0..self.truth.len()).filter(|&i| self.truth[i].is_finite()).collect();
        let of = |value: &dyn Fn(usize) -> f32| known.iter().map(|&i| value(i)).collect::<Vec<_>>();
        let (depth, truth) = (of(&|i| self.depth[i]), of(&|i| self.truth[i]));
        let (scale, shift) = affine_fit_freely(&depth, &truth);
        let [lo, hi] = usual_range(&truth);
        let range = (hi - lo).max(1e-6);
        let error = mean(depth.iter().zip(&truth).map(|(d, t)| (scale * d + shift - t).abs() / range));
        let fitted = Raster { size: self.size, px: self.depth.iter().map(|d| (scale * d + shift) / range).collect() };
        let true_map = Raster { size: self.size, px: self.truth.iter().map(|t| t / range).collect() };
        Figures {
            id: id.to_owned(),
            kind: kind.to_owned(),
            spearman: spearman(&depth, &truth),
            rows_spearman: spearman(&of(&|i| (i / self.size[0]) as f32), &truth),
            fit_error: error.unwrap_or(0.0),
            edge_f: edge_f(&fitted, &true_map),
            edges: edges(&fitted, &true_map),
            thin: thin(&true_map, &fitted),
            thin_true: thin(&fitted, &true_map),
        }
    }

    /// Photo, truth, prediction.
    pub fn tiles(&self, photo: &Rgb) -> Vec<Rgb> {
        let tile = |map: &[f32]| depth_tile(map, self.size, usual_range(map));
        vec![photo.clone(), tile(self.truth), tile(self.depth)]
    }
}

/// The best scale and shift, whatever the units of the two.
fn affine_fit_freely(depth: &[f32], truth: &[f32]) -> (f32, f32) {
    let spread = |values: &[f32]| {
        let [lo, hi] = usual_range(values);
        (hi - lo).max(1e-6)
    };
    let unit = spread(truth) / spread(depth);
    let brought: Vec<f32> = depth.iter().map(|d| d * unit).collect();
    let (scale, shift) = affine_fit(&brought, truth);
    (scale * unit, shift)
}

/// Pixels beside an edge of depth, by steps to the right and down.
fn edge_map(map: &Raster<f32>) -> Vec<bool> {
    let [w, h] = map.size;
    let step = |a: usize, b: usize| (map.px[a] - map.px[b]).abs() > EDGE;
    (0..w * h).map(|i| (i % w + 1 < w && step(i, i + 1)) || (i / w + 1 < h && step(i, i + w))).collect()
}

fn within(map: &[bool], [w, h]: [usize; 2], i: usize) -> bool {
    let (x, y) = ((i % w) as isize, (i / w) as isize);
    let clear = |at: isize, side: usize| at.clamp(0, side as isize - 1) as usize;
    (-EDGE_PX..=EDGE_PX).any(|dy| (-EDGE_PX..=EDGE_PX).any(|dx| map[clear(y + dy, h) * w + clear(x + dx, w)]))
}

/// F-score of the predicted edges of depth; none where the truth has none.
fn edge_f(depth: &Raster<f32>, truth: &Raster<f32>) -> Option<f32> {
    // Edges at what is not known tell nothing: a comparison with NaN is false.
    let (own, real) = (edge_map(depth), edge_map(truth));
    let known = |i: usize| truth.px[i].is_finite();
    let share = |of: &[bool], by: &[bool]| {
        mean((0..of.len()).filter(|&i| of[i] && known(i)).map(|i| f32::from(within(by, truth.size, i))))
    };
    let recall = share(&real, &own)?;
    let precision = share(&own, &real).unwrap_or(0.0);
    Some(if recall + precision > 0.0 { 2.0 * recall * precision / (recall + precision) } else { 0.0 })
}

/// See [`Figures::edges`].
fn edges(depth: &Raster<f32>, truth: &Raster<f32>) -> Option<f32> {
    let [w, h] = truth.size;
    let (mut good, mut all) = (0.0f32, 0.0f32);
    for (stride, length, lines) in [(1, w, h), (w, h, w)] {
        let start = |line: usize| if stride == 1 { line * w } else { line };
        for line in 0..lines {
            let at = |map: &Raster<f32>, k: isize| map.px[start(line) + k as usize * stride];
            let step = |map: &Raster<f32>, k: isize| at(map, k + 1) - at(map, k);
            let whole = SEARCH_PX..length as isize - SEARCH_PX - 1;
            let real_edges: Vec<isize> = (0..length as isize - 1).filter(|&k| step(truth, k).abs() > EDGE).collect();
            for &k in real_edges.iter().filter(|k| whole.contains(k)) {
                let way = step(truth, k).signum();
                let own = |a: &isize| real_edges.iter().all(|&other| (k + a - other).abs() >= a.abs());
                let steepest = (-SEARCH_PX..=SEARCH_PX)
                    .filter(own)
                    .max_by(|&a, &b| (way * step(depth, k + a)).total_cmp(&(way * step(depth, k + b))))
                    .unwrap_or(0);
                all += 1.0;
                good += f32::from(steepest.abs() <= EDGE_PX && way * step(depth, k + steepest) > 0.0);
            }
        }
    }
    (all > 0.0).then(|| good / all)
}

/// See [`Figures::thin`] and [`Figures::thin_true`]: the share of one map's parts across a row or a column that the other
/// has, too.
fn thin(parts: &Raster<f32>, found: &Raster<f32>) -> Option<f32> {
    let [w, h] = parts.size;
    let (mut good, mut all) = (0.0f32, 0.0f32);
    for (stride, length, lines) in [(1, w, h), (w, h, w)] {
        for line in 0..lines {
            let place = |k: usize| if stride == 1 { line * w + k } else { k * w + line };
            let mut k = THIN_PX + 1;
            while k + 2 * THIN_PX + 1 < length {
                let Some(wide) = part(parts, &place, k) else {
                    k += 1;
                    continue;
                };
                let out = |map: &Raster<f32>| {
                    let top = (k..k + wide).map(|i| map.px[place(i)]).fold(f32::MIN, f32::max);
                    // Beyond the part's soft edge.
                    top - map.px[place(k - 2)].max(map.px[place(k + wide + 1)])
                };
                let is_known = (k - 2..k + wide + 2).all(|i| found.px[place(i)].is_finite());
                all += f32::from(is_known);
                good += f32::from(is_known && out(found) > THIN_FOUND * out(parts));
                k += wide + 1;
            }
        }
    }
    (all > 0.0).then(|| good / all)
}

/// The width of a thin part that begins at place `k` of a line; none where none begins.
fn part(truth: &Raster<f32>, place: &dyn Fn(usize) -> usize, k: usize) -> Option<usize> {
    let at = |k: usize| truth.px[place(k)];
    // A comparison with what is not known is false.
    let begins = at(k) - at(k - 1) > THIN_STEP;
    if !begins {
        return None;
    }
    let wide = (1..=THIN_PX).find(|&wide| at(k + wide - 1) - at(k + wide) > THIN_STEP)?;
    let least = (k..k + wide).map(at).fold(f32::MAX, f32::min);
    let beside = [k - 1, k - 2, k + wide, k + wide + 1].map(at);
    beside.iter().all(|&side| least - side > THIN_STEP).then_some(wide)
}

/// Figures by kind, and of all.
pub fn groups(figures: &[Figures]) -> Vec<Group> {
    let mut kinds: Vec<&str> = figures.iter().map(|f| f.kind.as_str()).collect();
    kinds.sort_unstable();
    kinds.dedup();
    let all = (!figures.is_empty()).then(|| group("all", &figures.iter().collect::<Vec<_>>()));
    let each = kinds.iter().map(|kind| group(kind, &figures.iter().filter(|f| f.kind == **kind).collect::<Vec<_>>()));
    all.into_iter().chain(each).collect()
}

fn group(kind: &str, figures: &[&Figures]) -> Group {
    let margins: Vec<f32> = figures.iter().map(|f| f.spearman - f.rows_spearman).collect();
    let of = |what: fn(&Figures) -> f32| mean(figures.iter().map(|f| what(f))).unwrap_or(0.0);
    let some = |what: fn(&Figures) -> Option<f32>| mean(figures.iter().filter_map(|f| what(f)));
    Group {
        kind: kind.to_owned(),
        count: figures.len(),
        spearman: of(|f| f.spearman),
        rows_spearman: of(|f| f.rows_spearman),
        margin: mean(margins.iter().copied()).unwrap_or(0.0),
        margin_interval: interval(&margins),
        fit_error: of(|f| f.fit_error),
        edge_f: some(|f| f.edge_f),
        edges: some(|f| f.edges),
        thin: some(|f| f.thin),
        thin_true: some(|f| f.thin_true),
    }
}

/// The 95 % interval of the mean, by bootstrap.
pub fn interval(values: &[f32]) -> [f32; 2] {
    let mut rng = Rng::new(0xb007, 0);
    let resample = |_| mean((0..values.len()).map(|_| values[rng.below(values.len())])).unwrap_or(0.0);
    let mut means: Vec<f32> = (0..RESAMPLES).map(resample).collect();
    means.sort_unstable_by(f32::total_cmp);
    [0.025, 0.975].map(|share| means[(share * (RESAMPLES - 1) as f32) as usize])
}

/// Figures as a table for people.
pub fn table(title: &str, groups: &[Group]) -> String {
    let percent = |share: Option<f32>| share.map_or_else(|| "–".to_owned(), |share| format!("{:.0} %", 100.0 * share));
    let line = |g: &Group| {
        let [lo, hi] = g.margin_interval;
        format!(
            "  {:<10} {:>4}  Spearman {:.3}, row {:.3}, margin {:+.3} [{lo:+.3}, {hi:+.3}]; fit {:.3}; edge F {}, edges \
             {}, thin {}, true {}\n",
            g.kind,
            g.count,
            g.spearman,
            g.rows_spearman,
            g.margin,
            g.fit_error,
            percent(g.edge_f),
            percent(g.edges),
            percent(g.thin),
            percent(g.thin_true)
        )
    };
    format!("{title}\n{}", groups.iter().map(line).collect::<String>())
}

#[cfg(test)]
mod tests {
    use super::*;

    const SIZE: [usize; 2] = [60, 44];

    /// A far wall with a near box on it and a bar 2 px wide.
    fn scene() -> Vec<f32> {
        let near = |x: usize, y: usize| {
            let bar = (40..42).contains(&x) && (8..36).contains(&y);
            let cube = (12..28).contains(&x) && (12..32).contains(&y);
            if bar {
                0.7
            } else if cube {
                1.0
            } else {
                0.001 * x as f32
            }
        };
        (0..SIZE[0] * SIZE[1]).map(|i| near(i % SIZE[0], i / SIZE[0])).collect()
    }

    fn figures(depth: &[f32], truth: &[f32]) -> Figures {
        Compared { size: SIZE, depth, truth }.figures("a", "room")
    }

    #[test]
    fn the_truth_scores_full_in_any_unit_and_a_row_ramp_nothing() {
        let truth = scene();
        let same = figures(&truth.iter().map(|t| 0.01 * t - 3.0).collect::<Vec<_>>(), &truth);
        assert!(same.spearman > 0.999 && same.fit_error < 0.01, "{same:?}");
        let all = Some(1.0);
        assert_eq!([same.edge_f, same.edges, same.thin, same.thin_true], [all; 4]);
        let rows: Vec<f32> = (0..truth.len()).map(|i| (i / SIZE[0]) as f32).collect();
        let ramp = figures(&rows, &truth);
        assert!((ramp.spearman - ramp.rows_spearman).abs() < 1e-6);
        assert!(ramp.edges < Some(0.2) && ramp.thin == Some(0.0), "{ramp:?}");
    }

    #[test]
    fn a_bar_that_is_missed_and_an_edge_that_is_moved_are_told() {
        let truth = scene();
        let without: Vec<f32> =
            truth.iter().enumerate().map(|(i, &t)| if (40..42).contains(&(i % SIZE[0])) { 0.04 } else { t }).collect();
        let missed = figures(&without, &truth);
        assert_eq!((missed.thin, missed.thin_true), (Some(0.0), None));
        let invented = figures(&truth, &without);
        assert_eq!((invented.thin, invented.thin_true), (None, Some(0.0)));
        let moved: Vec<f32> = (0..truth.len()).map(|i| truth[(i + 5) % truth.len()]).collect();
        assert!(figures(&moved, &truth).edges < Some(0.6));
    }

    #[test]
    fn what_is_unknown_does_not_count() {
        let truth = scene();
        let holes: Vec<f32> = truth.iter().enumerate().map(|(i, &t)| if i % 7 == 0 { f32::NAN } else { t }).collect();
        let wrong: Vec<f32> = truth.iter().enumerate().map(|(i, &t)| if i % 7 == 0 { 9.0 } else { t }).collect();
        assert!(figures(&wrong, &holes).spearman > 0.999);
    }

    #[test]
    fn the_interval_holds_the_mean_and_narrows() {
        let few: Vec<f32> = (0..20).map(|i| (i as f32 * 1.7).sin()).collect();
        let many = few.repeat(25);
        let ([a, b], [c, d]) = (interval(&few), interval(&many));
        let mean = few.iter().sum::<f32>() / 20.0;
        assert!(a < c && c < mean && mean < d && d < b, "{a} {c} {mean} {d} {b}");
    }
}
