//! What is open: a photo or a light field, and what has been made of it so far.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use super::subject;
use crate::field::{DisparityMap, LightField, Photo, RayDepths, View, ViewGrid, ViewIndex};
use crate::io::formats::depth_map::GivenDepth;
use crate::io::formats::layout::Layout;
use crate::io::{EmbeddedDepth, FileInfo, LightFieldFile, Opened};
use crate::recipe::Recipe;

/// An open file.
#[derive(Clone, Debug, Default)]
pub struct Document {
    /// Its name in the top bar.
    pub name: String,
    /// Where it lies; none for a pasted picture and the sample.
    pub path: Option<PathBuf>,
    /// Size, profile and the like, in a few words.
    pub facts: String,
    /// The photo; none for a light field from disk.
    pub photo: Option<Arc<Photo>>,
    /// Depth that the phone measured.
    pub phone: Option<Arc<EmbeddedDepth>>,
    /// Disparity of the reference view alone, where it is known (the sample, benchmark scenes).
    pub reference: Option<Arc<DisparityMap>>,
    /// Ray depths of the photo from a map of one's own.
    pub own_map: Option<GivenDepth>,
    /// The light field, once it is complete.
    pub field: Option<Arc<LightField>>,
    /// A light field from disk as it lies in its files, where it is shown brighter.
    pub stored: Option<Arc<LightField>>,
    /// How a light field from disk was laid out to fit the conventions.
    pub layout: Layout,
    /// The edit that lies beside the photo.
    pub recipe: Option<Box<Recipe>>,
    /// The disparity of every ray.
    pub depths: Option<Arc<RayDepths>>,
    /// What the ray depths say about the scene.
    pub survey: Option<Arc<Survey>>,
    /// Who made the light field.
    pub made_by: String,
    /// How long that took.
    pub took_secs: f64,
    /// What a person should know about the file.
    pub warnings: Vec<String>,
}

/// A finished light field.
#[derive(Clone, Debug)]
pub struct Made {
    /// The views.
    pub field: Arc<LightField>,
    /// The disparity of every ray.
    pub depths: Option<Arc<RayDepths>>,
    /// What they say about the scene.
    pub survey: Option<Arc<Survey>>,
    /// Who made it.
    pub made_by: String,
    /// How long it took.
    pub took_secs: f64,
    /// The document it was made of: what is shown of it changes with it.
    pub of: Box<Document>,
}

impl Document {
    /// From what was read.
    pub fn new(opened: Opened, path: Option<&Path>, name: &str) -> Self {
        let facts = facts(opened.info());
        let base = Self { name: name.to_owned(), path: path.map(Path::to_owned), facts, ..Self::default() };
        match opened {
            Opened::Photo(file) => {
                Self { photo: Some(file.photo), phone: file.depth.map(Arc::new), warnings: file.warnings, ..base }
            }
            Opened::LightField(file) => Self::of_light_field(*file, base),
        }
    }

    fn of_light_field(file: LightFieldFile, base: Self) -> Self {
        let shown = file.display_gamma.map(|gamma| Arc::new(brighter(&file.field, gamma)));
        Self {
            stored: shown.is_some().then(|| Arc::clone(&file.field)),
            field: Some(shown.unwrap_or(file.field)),
            survey: file.depths.as_deref().map(|depths| Arc::new(Survey::new(depths))),
            depths: file.depths,
            reference: file.reference_disparity.map(Arc::new),
            layout: file.layout,
            warnings: file.warnings,
            made_by: "from disk".to_owned(),
            ..base
        }
    }

    /// A light field from disk in another layout, without ray depths: they are to be measured anew.
    pub fn laid_out(&self, layout: Layout) -> Self {
        let turn = |field: &Arc<LightField>| Arc::new(layout.apply(&self.layout.undo(field)));
        Self {
            field: self.field.as_ref().map(turn),
            stored: self.stored.as_ref().map(turn),
            layout,
            depths: None,
            reference: None,
            survey: None,
            ..self.clone()
        }
    }

    /// Width and height of the picture that is looked at.
    pub fn size(&self) -> Option<[u32; 2]> {
        let of_photo = self.photo.as_ref().map(|photo| photo.size());
        of_photo.or_else(|| self.field.as_ref().map(|field| field.size()))
    }

    /// Whether it is a light field that came as one.
    pub fn is_from_disk(&self) -> bool {
        self.photo.is_none()
    }

    /// The grid of views, once there is one.
    pub fn grid(&self) -> Option<ViewGrid> {
        let of_field = self.field.as_ref().map(|field| field.grid());
        of_field.or_else(|| self.depths.as_ref().map(|depths| depths.grid()))
    }

    /// Where in the reference view the point lies that is seen at a place of a view: `x + (u − u0)·D` ([`crate::field`]).
    pub fn place_in_reference(&self, view: ViewIndex, place: [f32; 2], disparity_px: f32) -> Option<[f32; 2]> {
        let depths = self.depths.as_ref()?;
        let ([w, h], step) = (depths.size(), depths.grid().offset(view));
        let x = place[0] + step.du * disparity_px / w as f32;
        let y = place[1] + step.dv * disparity_px / h as f32;
        Some([x.clamp(0.0, 1.0), y.clamp(0.0, 1.0)])
    }

    /// The disparity at a place of a view, x and y from 0 to 1: the median of 5×5 rays, so that a stray ray does not
    /// move the focus.
    pub fn disparity_at(&self, view: ViewIndex, place: [f32; 2]) -> Option<f32> {
        let depths = self.depths.as_ref()?;
        let [w, h] = depths.size();
        let center = |p: f32, n: u32| (p * n as f32).floor() as i64;
        let inside = |p: i64, n: u32| p.clamp(0, i64::from(n) - 1) as u32;
        let (cx, cy) = (center(place[0], w), center(place[1], h));
        let mut around: Vec<f32> = (-2..=2)
            .flat_map(|dy| (-2..=2).map(move |dx| (dx, dy)))
            .map(|(dx, dy)| depths.at(view, inside(cx + dx, w), inside(cy + dy, h)))
            .collect();
        around.sort_by(f32::total_cmp);
        around.get(around.len() / 2).copied()
    }
}

/// A dark light field as it should be shown: `shown = stored ^ γ`.
fn brighter(field: &LightField, gamma: f32) -> LightField {
    let table: Vec<u8> = (0..=255u8).map(|v| ((f32::from(v) / 255.0).powf(gamma) * 255.0).round() as u8).collect();
    let shown = |view: &Arc<View>| {
        let rgba = view.rgba().chunks_exact(4);
        let rgba =
            rgba.flat_map(|p| [table[p[0] as usize], table[p[1] as usize], table[p[2] as usize], p[3]]).collect();
        View::new(view.size(), rgba).map_or_else(|_same_size| Arc::clone(view), Arc::new)
    };
    LightField::new(field.grid(), field.views().iter().map(shown).collect()).unwrap_or_else(|_same_views| field.clone())
}

/// "4032 × 3024 · Display P3 · phone depth".
fn facts(info: &FileInfo) -> String {
    let mut parts = vec![format!("{} × {}", info.size[0], info.size[1])];
    parts.extend(info.views.map(|[rows, cols]| format!("{cols} × {rows} views")));
    parts.extend(info.profile.clone().filter(|name| !name.contains("sRGB")));
    if info.bits > 8 {
        parts.push(format!("{} bits", info.bits));
    }
    if info.embedded_depth.is_some() {
        parts.push("phone depth found".to_owned());
    }
    parts.join(" · ")
}

/// What the ray depths say about a scene.
#[derive(Clone, Debug)]
pub struct Survey {
    /// Disparities between which almost all rays lie, far and near, with a little room.
    pub range_px: [f32; 2],
    /// Share of the reference view's rays in each of [`Survey::BINS`] equal steps of the range; the largest is 1.
    pub bins: Vec<f32>,
    /// For each view, how much of it the reference view has seen (the rest was invented), 0 … 1, in `[v, u]` order.
    pub seen: Vec<f32>,
    /// Where the subject most likely is in the reference view, x and y from 0 to 1.
    pub subject: [f32; 2],
}

impl Survey {
    /// Bars of the histogram.
    pub const BINS: usize = 96;
    /// Rays that are looked at in each direction.
    const SAMPLES: u32 = 64;
    /// Disparity by which two rays may differ and still be one point.
    const SAME_POINT_PX: f32 = 0.15;

    /// Looks over the ray depths. Takes some milliseconds, so it is not for the window's thread.
    pub fn new(depths: &RayDepths) -> Self {
        let mut sorted: Vec<f32> = depths.reference().iter().copied().filter(|d| d.is_finite()).collect();
        sorted.sort_unstable_by(f32::total_cmp);
        let at = |share: f32| sorted.get(((sorted.len().max(1) - 1) as f32 * share) as usize).copied().unwrap_or(0.0);
        let (far, near) = (at(0.002), at(0.998));
        let room = ((near - far) * 0.08).max(0.05);
        let range_px = [far - room, near + room];
        let mut counts = vec![0u32; Self::BINS];
        for d in &sorted {
            let place = (d - range_px[0]) / (range_px[1] - range_px[0]) * Self::BINS as f32;
            if let Some(count) = counts.get_mut(place.max(0.0) as usize) {
                *count += 1;
            }
        }
        let most = counts.iter().copied().max().unwrap_or(1).max(1) as f32;
        // The square root keeps small things visible beside a large wall.
        let bins = counts.into_iter().map(|count| (count as f32 / most).sqrt()).collect();
        let seen = depths.grid().views().map(|view| Self::seen(depths, view)).collect();
        Self { range_px, bins, seen, subject: subject::place(depths) }
    }

    fn seen(depths: &RayDepths, view: ViewIndex) -> f32 {
        let (grid, [w, h]) = (depths.grid(), depths.size());
        let step = grid.offset(view);
        let zero = grid.reference();
        let (nx, ny) = (Self::SAMPLES.min(w), Self::SAMPLES.min(h));
        let mut same = 0;
        for (i, j) in (0..ny).flat_map(|j| (0..nx).map(move |i| (i, j))) {
            let (x, y) = (i * w / nx, j * h / ny);
            let d = depths.at(view, x, y);
            let to = |p: u32, s: f32, n: u32| (p as f32 + s * d).round().clamp(0.0, (n - 1) as f32) as u32;
            let there = depths.at(zero, to(x, step.du, w), to(y, step.dv, h));
            same += u32::from((there - d).abs() < Self::SAME_POINT_PX);
        }
        same as f32 / (nx * ny) as f32
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_flat_scene_is_seen_whole_and_a_step_is_not() {
        let flat = RayDepths::new(ViewGrid::PAPER, [20, 10], vec![0.5; 64 * 200]).unwrap();
        let survey = Survey::new(&flat);
        assert!(survey.seen.iter().all(|&share| share == 1.0));
        assert!(survey.range_px[0] < 0.5 && survey.range_px[1] > 0.5);
        assert_eq!(survey.bins.iter().copied().fold(0.0, f32::max), 1.0);

        let step: Vec<f32> = (0..64 * 200).map(|i| if i % 20 < 10 { -2.0 } else { 2.0 }).collect();
        let survey = Survey::new(&RayDepths::new(ViewGrid::PAPER, [20, 10], step).unwrap());
        assert_eq!(survey.seen[ViewGrid::PAPER.layer_from_view(ViewGrid::PAPER.reference())], 1.0);
        assert!(survey.seen[ViewGrid::PAPER.layer_from_view(ViewIndex { v: 4, u: 0 })] < 0.9);
    }
}
