//! Depth mended by hand: a short list of operations on a disparity map.
//!
//! A repair says where and what, in shares of the photo and never in pixels of one map. So the same list mends every
//! source of depth at every size.
//!
//! ```text
//! Region (click, lasso) × Operation (nearer … join)        Stroke (a brush along a path)
//!          └────────────── Mender: map + photo's colours ──────────────┘
//! ```
//!
//! Places go from 0 to 1, lengths are shares of the longer side, disparities shares of the width per view step. Only
//! a map is changed here; `scene` decides which, and carries the change to the other views.

mod brush;
mod fit;
mod guide;
mod lasso;
mod list;
mod mask;
mod mender;
mod operation;
mod reach;
#[cfg(test)]
mod tests;

use serde::{Deserialize, Serialize};

pub use brush::Draft;
pub use guide::Guide;
pub use list::{Entry, MOST, PhotoSign, Repairs};
pub use mask::Mask;
pub use mender::{Mender, Rect, Region as Reached, mended};

/// A place of the photo: x and y from 0 to 1.
pub type Place = [f32; 2];

/// One thing that was done to the depth.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case", deny_unknown_fields)]
pub enum Repair {
    /// An operation on a thing.
    Region {
        /// Which thing.
        of: Region,
        /// What is done to it.
        #[serde(rename = "do")]
        what: Operation,
    },
    /// A brush along a path.
    Stroke(Stroke),
}

/// A thing of the photo, told by its colours and its depth.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case", deny_unknown_fields)]
pub enum Region {
    /// What is seen at a place, as far as one gets without crossing an edge.
    Click {
        /// The place.
        at: Place,
        /// How far one may go, as a share of the longer side; an edge is a long way.
        size: f32,
    },
    /// What lies within an outline.
    Lasso {
        /// Its corners; the last is joined with the first.
        outline: Vec<Place>,
        /// How far the outline moves to an edge, as a share of the longer side.
        snap: f32,
    },
}

/// What is done to a thing.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Operation {
    /// All of it comes nearer by so much.
    Nearer(f32),
    /// All of it goes farther by so much.
    Farther(f32),
    /// It becomes a card that faces the camera.
    Flatten,
    /// It becomes a vertical plane on its foot.
    Stand,
    /// It becomes a part of the ground around it.
    Lie,
    /// It takes the depth of the neighbour whose colours it has.
    Join,
    /// All of it is moved until the place that was clicked has this disparity.
    To(f32),
}

/// A brush along a path.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Stroke {
    /// What it does.
    pub brush: Brush,
    /// Where it went.
    pub path: Vec<Place>,
    /// Its diameter, as a share of the longer side.
    pub size: f32,
    /// How much it does, 0 … 1.
    pub strength: f32,
}

/// What a brush does.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Brush {
    /// Brings nearer.
    Nearer,
    /// Takes farther.
    Farther,
    /// Evens bumps out, without crossing the photo's edges.
    Smooth,
    /// Brings the map's edge to the photo's, as a step.
    Sharpen,
}

/// What a brush of full strength moves by, as a share of the width per view step: 1 px of 540.
pub const FULL_STRENGTH: f32 = 1.0 / 540.0;
/// Points of one path or outline.
const MOST_POINTS: usize = 4096;
/// Places may lie beside the photo by this much, in sides: a hand does not stop at the edge.
const BESIDE: f32 = 1.0;
/// The most that something is moved by, as a share of the width per view step.
const FARTHEST: f32 = 0.05;

impl Repair {
    /// Whether its numbers can be meant, and something of it lies in the photo.
    pub fn is_usable(&self) -> bool {
        let share = |n: f32, most: f32| n > 0.0 && n <= most;
        match self {
            Self::Region { of, what } => of.is_usable() && what.is_usable(),
            Self::Stroke(Stroke { path, size, strength, .. }) => {
                are_usable(path, 1) && share(*size, 2.0) && (0.0..=1.0).contains(strength)
            }
        }
    }

    /// A place of it, for whoever shows where it is.
    pub fn place(&self) -> Option<Place> {
        match self {
            Self::Region { of: Region::Click { at, .. }, .. } => Some(*at),
            Self::Region { of: Region::Lasso { outline, .. }, .. } => outline.first().copied(),
            Self::Stroke(stroke) => stroke.path.first().copied(),
        }
    }

    /// What it is, for people.
    pub fn label(&self) -> &'static str {
        match self {
            Self::Region { what, .. } => what.label(),
            Self::Stroke(stroke) => stroke.brush.label(),
        }
    }
}

impl Region {
    fn is_usable(&self) -> bool {
        match self {
            Self::Click { at, size } => are_usable(&[*at], 1) && *size > 0.0 && *size <= 4.0,
            Self::Lasso { outline, snap } => are_usable(outline, 3) && (0.0..=0.2).contains(snap),
        }
    }
}

impl Operation {
    fn is_usable(self) -> bool {
        match self {
            Self::Nearer(by) | Self::Farther(by) | Self::To(by) => by.abs() <= FARTHEST,
            Self::Flatten | Self::Stand | Self::Lie | Self::Join => true,
        }
    }

    /// What it does, for people.
    pub fn label(self) -> &'static str {
        match self {
            Self::Nearer(_) => "Nearer",
            Self::Farther(_) => "Farther",
            Self::Flatten => "Flatten",
            Self::Stand => "Stand upright",
            Self::Lie => "Lie on the ground",
            Self::Join => "Join with neighbour",
            Self::To(_) => "Move to a depth",
        }
    }
}

impl Brush {
    /// All of them.
    pub const ALL: [Self; 4] = [Self::Nearer, Self::Farther, Self::Smooth, Self::Sharpen];

    /// What it does, for people.
    pub fn label(self) -> &'static str {
        match self {
            Self::Nearer => "Nearer brush",
            Self::Farther => "Farther brush",
            Self::Smooth => "Smooth",
            Self::Sharpen => "Sharpen edge",
        }
    }
}

/// Numbers, enough and not too many, not far away, and one of them in the photo.
fn are_usable(places: &[Place], least: usize) -> bool {
    let is_near = |at: &f32| (-BESIDE..=1.0 + BESIDE).contains(at);
    (least..=MOST_POINTS).contains(&places.len())
        && places.iter().flatten().all(is_near)
        && (places.iter().any(is_inside) || surround(places))
}

fn is_inside(place: &Place) -> bool {
    place.iter().all(|at| (0.0..=1.0).contains(at))
}

/// Whether an outline or a path whose corners all lie outside has the photo between them.
fn surround(places: &[Place]) -> bool {
    let reaches = |axis: usize| {
        let [low, high] =
            places.iter().fold([f32::MAX, f32::MIN], |[low, high], p| [low.min(p[axis]), high.max(p[axis])]);
        low < 1.0 && high > 0.0
    };
    reaches(0) && reaches(1)
}
