//! The lines of a folder's `manifest.jsonl`: what is known of each photo before it is read.

use std::collections::HashMap;
use std::path::{Path, PathBuf};

use serde::Deserialize;

use super::{SceneError, Split};

/// One line.
#[derive(Deserialize)]
pub(super) struct Entry {
    pub(super) id: String,
    #[serde(default)]
    split: Option<Split>,
    #[serde(default)]
    gate: Option<String>,
    #[serde(default)]
    pub(super) label: Option<String>,
    #[serde(default)]
    pub(super) kind: Option<String>,
    #[serde(default)]
    pub(super) invalid_zero: bool,
    #[serde(default)]
    squeezed: Option<bool>,
    /// Where its map lies, if not beside the photo.
    #[serde(skip)]
    pub(super) maps: Option<PathBuf>,
}

/// Places (beginnings of names in `everyday10k/`) whose measured depth is for validation alone: frames of one place are
/// too alike to be on both sides.
pub(super) const PLACES_HELD_OUT: [&str; 4] = ["repl_", "rccube_", "aimsl_", "pose6d_"];

/// What a map is worth that a net for rooms alone made of a room: where its maps were compared with measured ones they
/// ordered as 0.82, those of the general teacher as 0.51.
pub(super) const WELL_LABELLED: f32 = 0.8;

/// Photos that a source pressed into a square were mostly this much wider.
const SQUEEZED_BY: f32 = 4.0 / 3.0;

impl Entry {
    pub(super) fn split(&self) -> Split {
        let held_out = self.is_measured() && PLACES_HELD_OUT.iter().any(|place| self.id.starts_with(place));
        if held_out { Split::Val } else { self.split.unwrap_or(Split::Train) }
    }

    pub(super) fn is_measured(&self) -> bool {
        matches!(self.label.as_deref(), Some("sensor" | "stereo"))
    }

    /// Whether a net of ours made its map.
    pub(super) fn is_taught(&self) -> bool {
        self.maps.is_some()
    }

    /// Measured depth is the truth; a map of another net is worth what it agrees with itself.
    pub(super) fn worth(&self) -> f32 {
        match self.gate.as_deref() {
            _ if self.is_measured() => 1.0,
            Some("self") if self.label.as_deref() == Some("teacher-rooms") => WELL_LABELLED,
            Some("mask") => 0.4,
            Some("soft") => 0.3,
            _ => 0.6,
        }
    }

    pub(super) fn has_map(&self) -> bool {
        self.gate.as_deref() != Some("doubtful")
    }

    /// The photo's shape without the stretch that its source gave it.
    pub(super) fn unsqueezed(&self, [w, h]: [usize; 2]) -> [usize; 2] {
        [if self.squeezed == Some(true) { (w as f32 * SQUEEZED_BY) as usize } else { w }, h]
    }
}

/// The entries of a folder's manifest; lines that are none are told.
pub(super) fn read(folder: &Path, notes: &mut Vec<String>) -> Vec<Entry> {
    let path = folder.join("manifest.jsonl");
    if !path.exists() {
        return Vec::new();
    }
    let expected = "one JSON object with an id on each line";
    let text = std::fs::read_to_string(&path).map_err(|e| SceneError::read("manifest", &path, e, expected));
    let text = text.unwrap_or_else(|note| {
        notes.push(note.to_string());
        String::new()
    });
    let mut entries = Vec::new();
    for line in text.lines().filter(|line| !line.trim().is_empty()) {
        let entry = serde_json::from_str(line).map_err(|e| SceneError::read("manifest", &path, e, expected));
        entry.map_or_else(|note| notes.push(note.to_string()), |entry| entries.push(entry));
    }
    entries
}

/// Lets entries have the maps of a folder that `teach.rs` wrote; how many there are.
pub(super) fn take_maps(entries: &mut [Entry], folder: &Path, notes: &mut Vec<String>) -> usize {
    let own: HashMap<String, Entry> = read(folder, notes).into_iter().map(|entry| (entry.id.clone(), entry)).collect();
    for entry in entries.iter_mut().filter(|entry| !entry.is_measured()) {
        if let Some(own) = own.get(&entry.id) {
            (entry.gate, entry.label) = (own.gate.clone(), own.label.clone());
            entry.maps = Some(folder.to_owned());
        }
    }
    own.len()
}
