//! What is kept sharp together: rings on the picture that are set, moved and taken away, and what is solved for them.

use egui::{Pos2, Rect, Vec2};

use super::open::Open;
use super::words::t;
use crate::scene::sharp::Places;
use crate::scene::{Edit, Focus};

/// How near to a ring's middle the pointer takes it, in points.
pub const GRAB: f32 = 14.0;

/// The edit with one more place kept sharp, or one less where a ring is; a place that was clicked before is the first.
pub fn toggled(open: &Open, edit: &Edit, place: [f32; 2], ring: Option<usize>, picture_width: u32) -> Edit {
    let places = match (edit.focus, ring) {
        (Focus::Through(places), Some(index)) => places.without(index),
        (Focus::Through(places), None) => Some(places.with(place)),
        (Focus::At(first), _) => Some(Places::from(first).with(place)),
        _ => Some(place.into()),
    };
    let focus = match places {
        Some(places) => Focus::Through(places),
        None => Focus::At(place),
    };
    opened(open, Edit { focus, ..edit.clone() }, picture_width)
}

/// The edit with a ring elsewhere; an aperture that was as wide as could be stays so.
pub fn moved(open: &Open, edit: &Edit, ring: usize, place: [f32; 2], picture_width: u32) -> Edit {
    let Focus::Through(places) = edit.focus else { return edit.clone() };
    let widest = open.scene().and_then(|scene| scene.widest(edit, picture_width));
    let after = Edit { focus: Focus::Through(places.moved(ring, place)), ..edit.clone() };
    let was_widest = widest.is_some_and(|widest| (widest.0 - edit.f_number.0).abs() < 1e-3);
    if was_widest { opened(open, after, picture_width) } else { after }
}

/// As wide open as the places let it.
fn opened(open: &Open, edit: Edit, picture_width: u32) -> Edit {
    let widest = open.scene().and_then(|scene| scene.widest(&edit, picture_width));
    Edit { f_number: widest.unwrap_or(edit.f_number), ..edit }
}

/// The middles of the rings on a screen where the picture lies at `rect`.
pub fn rings(open: &Open, edit: &Edit, rect: Rect) -> Vec<Pos2> {
    let (Focus::Through(places), Some(rays)) = (edit.focus, open.rays()) else { return Vec::new() };
    places
        .all()
        .iter()
        .map(|place| rect.min + Vec2::from(rays.place_from_reference(edit.viewpoint, *place)) * rect.size())
        .collect()
}

/// The ring under the pointer.
pub fn ring_at(open: &Open, edit: &Edit, at: Pos2, rect: Rect) -> Option<usize> {
    let far = |ring: &Pos2| ring.distance(at);
    let rings = rings(open, edit, rect);
    let nearest = (0..rings.len()).min_by(|a, b| far(&rings[*a]).total_cmp(&far(&rings[*b])))?;
    (far(&rings[nearest]) <= GRAB).then_some(nearest)
}

/// What is said of it; nothing where there are not two.
pub fn told(open: &Open, edit: &Edit) -> Option<&'static str> {
    Some(match open.scene()?.goes_through(edit)? {
        true => t!("plane-leans"),
        false => t!("plane-none"),
    })
}
