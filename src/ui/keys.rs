//! What pictures that come late belong to: they are drawn only while this is what the window shows.

use egui::{ColorImage, Rect, Vec2};

use crate::field::{Lens, Strength, ViewIndex, fit_long_side};
use crate::render::lens::Region;
use crate::scene::Edit;

/// What a picture at rest shows: it is drawn only while this is what the window asks for.
#[derive(Clone, Debug, PartialEq)]
pub struct RestKey {
    /// What is done to the picture.
    pub edit: Edit,
    /// Size of the whole picture, in pixels.
    pub size: [u32; 2],
    /// The part of it that is seen.
    pub region: Region,
    /// Which light field, counted by the window.
    pub generation: u64,
}

/// Regions begin and end at multiples of this, so that a little panning asks for nothing new.
const STEP: u32 = 128;

impl RestKey {
    /// What is needed for a picture that lies at `rect` (in screen pixels) behind a canvas.
    pub fn new(edit: &Edit, generation: u64, photo: [u32; 2], rect: Rect, canvas: Rect) -> Self {
        let long = rect.size().max_elem().max(64.0);
        // Sizes in steps of a quarter octave, so that a little zoom asks for nothing new either.
        let wanted = 2f32.powf((long.log2() * 4.0 - 0.1).ceil() / 4.0) as u32;
        let size = fit_long_side(photo, wanted);
        let seen = rect.intersect(canvas);
        let place = |p: f32, start: f32, extent: f32, side: u32| ((p - start) / extent).clamp(0.0, 1.0) * side as f32;
        let low = |p: f32| (p as u32) / STEP * STEP;
        let high = |p: f32, side: u32| (p.ceil() as u32).next_multiple_of(STEP).clamp(1, side);
        let at = [
            low(place(seen.left(), rect.left(), rect.width(), size[0])),
            low(place(seen.top(), rect.top(), rect.height(), size[1])),
        ];
        let end = [
            high(place(seen.right(), rect.left(), rect.width(), size[0]), size[0]),
            high(place(seen.bottom(), rect.top(), rect.height(), size[1]), size[1]),
        ];
        let part = Region { at, size: [0, 1].map(|axis| end[axis].saturating_sub(at[axis]).max(1)) };
        Self { edit: edit.clone(), size, region: part, generation }
    }

    /// The same, all of it, at another size.
    #[must_use]
    pub fn whole_at(self, size: [u32; 2]) -> Self {
        Self { size, region: Region { at: [0, 0], size }, ..self }
    }

    /// Whether it shows all of the picture at this size.
    pub fn is_whole_at(&self, size: [u32; 2]) -> bool {
        self.size == size && self.region == Region { at: [0, 0], size }
    }

    /// Where the region lies within a picture that is drawn at `rect`.
    pub fn on_screen(&self, rect: Rect) -> Rect {
        let scale = rect.size() / Vec2::new(self.size[0] as f32, self.size[1] as f32);
        let at = Vec2::new(self.region.at[0] as f32, self.region.at[1] as f32) * scale;
        let size = Vec2::new(self.region.size[0] as f32, self.region.size[1] as f32) * scale;
        Rect::from_min_size(rect.min + at, size)
    }
}

/// What the marks belong to: they are drawn only while this is what the window shows.
#[derive(Clone, Debug, PartialEq)]
pub struct PeaksKey {
    /// The lens, in pixels of the view's width.
    pub lens: Lens,
    /// The view that is looked at.
    pub view: ViewIndex,
    /// How deep the scene is.
    pub strength: Strength,
    /// Which light field, counted by the window.
    pub generation: u64,
}

/// Marks, ready for the screen.
#[derive(Debug)]
pub struct Peaks {
    /// What they belong to.
    pub key: PeaksKey,
    /// The marks, transparent elsewhere, at light-field size.
    pub image: ColorImage,
}

#[cfg(test)]
mod tests {
    use super::*;
    use egui::{pos2, vec2};

    #[test]
    fn a_region_covers_what_is_seen_and_no_more_than_there_is() {
        let canvas = Rect::from_min_size(pos2(100.0, 50.0), vec2(900.0, 600.0));
        let photo = [4000, 3000];
        let whole = Rect::from_min_size(pos2(150.0, 50.0), vec2(800.0, 600.0));
        let key = RestKey::new(&Edit::default(), 1, photo, whole, canvas);
        assert_eq!(key.region, Region { at: [0, 0], size: key.size });
        assert!(key.size[0] >= 800 && key.size[0] < 960, "{:?}", key.size);

        let close = Rect::from_min_size(pos2(-1900.0, -950.0), vec2(4000.0, 3000.0));
        let key = RestKey::new(&Edit::default(), 1, photo, close, canvas);
        assert_eq!(key.size, photo, "never more than the photo's own pixels");
        assert!(key.on_screen(close).contains_rect(canvas));
        assert!(key.region.size[0] < 1300 && key.region.size[1] < 1000);
    }
}
