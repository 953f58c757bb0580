//! A depth map of one's own does not say which end is near: both readings are shown, and a person points at the right one.

use std::path::Path;
use std::sync::Arc;

use egui::{Color32, ColorImage, Context, CursorIcon, RichText, Sense, StrokeKind, TextureHandle, Ui, vec2};

use super::app::App;
use super::state::Source;
use super::{theme, widgets};
use crate::field::{DisparityMap, FieldError};
use crate::io::formats::depth_map::{DepthMap, GivenDepth, NearEnd};
use crate::render::cpu::Colormap;

/// Long side of the small pictures, in pixels.
const PREVIEW: u32 = 320;
/// Shapes that differ by less than this are one shape: maps are cut to even sizes.
const SAME_SHAPE: f32 = 0.02;

/// A map read both ways.
#[derive(Clone, Debug)]
pub struct Reading {
    /// Which end is near.
    end: NearEnd,
    /// The map, read so.
    depth: GivenDepth,
    /// A small picture of it, near is red.
    image: Arc<ColorImage>,
}

/// Both readings of a map, the likelier first. For a thread: the map may be large.
///
/// # Errors
/// Disparities that are no numbers.
pub fn readings(map: &DepthMap) -> Result<[Reading; 2], FieldError> {
    let image = |depth: &GivenDepth| Arc::new(small(&depth.disparity()));
    Ok(map.previews()?.map(|(end, depth)| Reading { end, image: image(&depth), depth }))
}

fn small(map: &DisparityMap) -> ColorImage {
    let [w, h] = map.size();
    let step = w.max(h).div_ceil(PREVIEW).max(1);
    let [far, near] = map.range_px();
    let scale = 1.0 / (near - far).max(1e-6);
    let color = |x: u32, y: u32| {
        let [r, g, b] = Colormap::Turbo.srgb((map.at(x, y) - far) * scale).map(|v| (v * 255.0) as u8);
        Color32::from_rgb(r, g, b)
    };
    let pixels = (0..h).step_by(step as usize).flat_map(|y| (0..w).step_by(step as usize).map(move |x| color(x, y)));
    ColorImage::new([w.div_ceil(step), h.div_ceil(step)].map(|side| side as usize), pixels.collect())
}

/// The question, while it is asked.
pub struct Question {
    name: String,
    size: [u32; 2],
    readings: [Reading; 2],
    textures: [TextureHandle; 2],
}

impl Question {
    /// About the map of a file.
    pub fn new(path: &Path, size: [u32; 2], readings: [Reading; 2], ctx: &Context) -> Self {
        let texture = |reading: &Reading| ctx.load_texture("near end", Arc::clone(&reading.image), Default::default());
        let textures = [texture(&readings[0]), texture(&readings[1])];
        let name = path.file_name().unwrap_or(path.as_os_str()).to_string_lossy().into_owned();
        Self { name, size, readings, textures }
    }

    /// Whether the map has the shape of a photo.
    pub fn fits(&self, photo: [u32; 2]) -> bool {
        let shape = |[w, h]: [u32; 2]| w as f32 / h as f32;
        self.size == [1, 1] || (shape(self.size) / shape(photo) - 1.0).abs() < SAME_SHAPE
    }
}

/// Draws the question; false once it is answered.
pub fn show(app: &mut App, ctx: &Context) -> bool {
    let Some(question) = &app.near_end else { return false };
    let colors = theme::palette(ctx);
    let mut answer = None;
    let mut is_open = true;
    let modal = widgets::modal(ctx, "near end");
    let shown = modal.show(ctx, |ui| {
        ui.set_width(2.0 * PREVIEW as f32 + 16.0);
        ui.spacing_mut().item_spacing.y = 8.0;
        ui.label(RichText::new("Which one has near things in red?").font(theme::title(16.0)).color(colors.strong));
        let text =
            format!("{} does not say which end of its values is near. Click the picture that is right", question.name);
        ui.label(RichText::new(text).color(colors.weak));
        ui.horizontal_top(|ui| {
            ui.spacing_mut().item_spacing.x = 16.0;
            for (index, texture) in question.textures.iter().enumerate() {
                if preview(ui, question, index, texture) {
                    answer = Some(index);
                }
            }
        });
        ui.with_layout(egui::Layout::right_to_left(egui::Align::Center), |ui| {
            if widgets::button(ui, "Cancel").clicked() {
                is_open = false;
            }
        });
    });
    if let Some(index) = answer {
        app.document.own_map = Some(question.readings[index].depth.clone());
        app.settings.source = Source::Map;
        app.make_again();
    }
    let stays = answer.is_none() && is_open && !shown.should_close();
    if !stays {
        app.near_end = None;
    }
    stays
}

/// One reading; true once it is clicked.
fn preview(ui: &mut Ui, question: &Question, index: usize, texture: &TextureHandle) -> bool {
    let colors = theme::palette(ui.ctx());
    let end = question.readings[index].end;
    let size = texture.size_vec2();
    let size = size * (PREVIEW as f32 / size.max_elem());
    ui.vertical(|ui| {
        let (rect, response) = ui.allocate_exact_size(vec2(PREVIEW as f32, size.y), Sense::click());
        let at = egui::Rect::from_center_size(rect.center(), size);
        widgets::picture(ui.painter(), texture.id(), at, widgets::WHOLE, 1.0);
        let name = if end == NearEnd::White { "Large values are near" } else { "Small values are near" };
        response.widget_info(|| egui::WidgetInfo::labeled(egui::Role::Button, true, name));
        if response.hovered() || response.has_focus() {
            ui.painter().rect_stroke(at, theme::PICTURE_RADIUS, (2.0, colors.accent), StrokeKind::Outside);
        }
        let guess = if index == 0 { " · likely" } else { "" };
        let label = RichText::new(format!("{name}{guess}")).color(colors.text);
        ui.vertical_centered(|ui| ui.label(label));
        response.on_hover_cursor(CursorIcon::PointingHand).clicked()
    })
    .inner
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::field::Raster;

    #[test]
    fn both_readings_are_offered_and_differ() {
        let values = (0..12 * 8).map(|i| (i / 12) as f32 / 7.0).collect();
        let map = DepthMap { values: Raster::new([12, 8], values).unwrap(), is_disparity: false };
        let [likely, other] = readings(&map).unwrap();
        assert_eq!((likely.end, other.end), (NearEnd::White, NearEnd::Black));
        assert!(likely.depth.disparity().at(0, 7) > likely.depth.disparity().at(0, 0), "below is near");
        assert!(other.depth.disparity().at(0, 7) < other.depth.disparity().at(0, 0));
        assert_eq!(likely.image.pixels[0], other.image.pixels[12 * 7], "far here is near there");
    }
}
