//! The list of repairs as a recipe keeps it: bounded, of one photo, and never losing what it does not know.

use std::sync::Arc;

use serde::{Deserialize, Deserializer, Serialize, Serializer};
use serde_json::Value;

use super::Repair;
use crate::field::Photo;

/// So many repairs of one photo are done; more stay in the file.
pub const MOST: usize = 1000;
/// Cells of a photo's sign in each direction, and the levels of each.
const CELLS: usize = 8;
const LEVELS: f32 = 15.0;
/// Signs of one photo differ by less than this on average, in levels: it may have been saved anew.
const SAME_PHOTO: f32 = 1.0;
/// Pixels of a cell that are looked at in each direction.
const SAMPLES: usize = 16;

/// Everything that was done to a photo's depth, in its order. A clone shares the list.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
#[serde(default)]
pub struct Repairs {
    /// What the photo looks like; none where a person wrote the list by hand.
    #[serde(skip_serializing_if = "Option::is_none")]
    photo: Option<PhotoSign>,
    #[serde(serialize_with = "write_list", deserialize_with = "read_list")]
    list: Arc<[Entry]>,
}

impl PartialEq for Repairs {
    fn eq(&self, other: &Self) -> bool {
        // Asked at every frame, and most often of one list.
        self.photo == other.photo && (Arc::ptr_eq(&self.list, &other.list) || self.list == other.list)
    }
}

fn write_list<S: Serializer>(list: &Arc<[Entry]>, to: S) -> Result<S::Ok, S::Error> {
    to.collect_seq(list.iter())
}

fn read_list<'de, D: Deserializer<'de>>(from: D) -> Result<Arc<[Entry]>, D::Error> {
    Ok(Vec::<Value>::deserialize(from)?.into_iter().map(Entry::from).collect())
}

/// One line of the list.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[serde(untagged)]
pub enum Entry {
    /// A repair that can be done.
    Known(Repair),
    /// What this version does not know, or what cannot be meant; it stays as it is.
    Unknown(Value),
}

impl From<Value> for Entry {
    fn from(value: Value) -> Self {
        match Repair::deserialize(&value) {
            Ok(repair) if repair.is_usable() => Self::Known(repair),
            _ => Self::Unknown(value),
        }
    }
}

impl Entry {
    /// The repair, where it can be done.
    pub fn repair(&self) -> Option<&Repair> {
        match self {
            Self::Known(repair) => Some(repair),
            Self::Unknown(_) => None,
        }
    }
}

impl Repairs {
    /// Whether nothing was ever mended.
    pub fn is_empty(&self) -> bool {
        self.list.is_empty()
    }

    /// All lines, in their order.
    pub fn entries(&self) -> &[Entry] {
        &self.list
    }

    /// What is done: all that can be used, as many as there may be.
    pub fn usable(&self) -> impl Iterator<Item = &Repair> {
        self.list.iter().filter_map(Entry::repair).take(MOST)
    }

    /// With one more of a photo; none where there are enough, or where it cannot be meant.
    #[must_use]
    pub fn with(&self, repair: Repair, photo: Option<&PhotoSign>) -> Option<Self> {
        if self.list.len() >= MOST || !repair.is_usable() {
            return None;
        }
        let list = self.list.iter().cloned().chain([Entry::Known(repair)]).collect();
        Some(Self { photo: self.photo.clone().or(photo.cloned()), list })
    }

    /// Without one of them.
    #[must_use]
    pub fn without(&self, number: usize) -> Self {
        let others = self.list.iter().enumerate().filter(|(i, _)| *i != number).map(|(_, entry)| entry.clone());
        Self { photo: self.photo.clone(), list: others.collect() }
    }

    /// Whether they may be done to a photo: theirs, or any where they do not say which is theirs.
    pub fn are_of(&self, sign: &PhotoSign) -> bool {
        self.photo.as_ref().is_none_or(|own| own.is_like(sign))
    }

    /// What a person is told of those that are not done; none where all are.
    pub fn left_out(&self) -> Option<String> {
        let left = self.list.len() - self.usable().count();
        let some = if left == 1 { "one repair".to_owned() } else { format!("{left} repairs") };
        (left > 0).then(|| {
            format!(
                "{some} of this edit cannot be done — of a later version, beside the photo, of impossible numbers, or \
                 more than {MOST} — the rest is done, and the file keeps them all"
            )
        })
    }
}

/// What a photo looks like from afar: the brightness of 8 × 8 cells, a hexadecimal digit each.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(transparent)]
pub struct PhotoSign(String);

impl PhotoSign {
    /// Of a photo.
    pub fn of(photo: &Photo) -> Self {
        Self::of_pixels(photo.size(), photo.srgb8())
    }

    /// Of a picture, `[y, x, 4]`.
    pub fn of_pixels(size: [u32; 2], rgba: &[u8]) -> Self {
        let [w, h] = size.map(|side| side as usize);
        let middle = |i: usize, side: usize| ((2 * i + 1) * side / (2 * CELLS * SAMPLES)).min(side - 1);
        let level = |cell: usize| {
            let (cx, cy) = (cell % CELLS * SAMPLES, cell / CELLS * SAMPLES);
            let places = (0..SAMPLES * SAMPLES).map(|s| (middle(cx + s % SAMPLES, w), middle(cy + s / SAMPLES, h)));
            let light = places.map(|(x, y)| rgba[(y * w + x) * 4..][..3].iter().map(|c| f32::from(*c)).sum::<f32>());
            light.sum::<f32>() / (SAMPLES * SAMPLES) as f32 / (3.0 * 255.0) * LEVELS
        };
        Self((0..CELLS * CELLS).map(|cell| char::from_digit(level(cell).round() as u32, 16).unwrap_or('0')).collect())
    }

    /// Whether both are of one photo, perhaps saved anew.
    fn is_like(&self, other: &Self) -> bool {
        let levels = |sign: &Self| sign.0.chars().map(|c| c.to_digit(16).unwrap_or(0)).collect::<Vec<_>>();
        let (own, other) = (levels(self), levels(other));
        let apart: u32 = own.iter().zip(&other).map(|(a, b)| a.abs_diff(*b)).sum();
        own.len() == other.len() && (apart as f32) < SAME_PHOTO * own.len() as f32
    }
}
