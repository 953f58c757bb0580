//! Version 1 of recipes: disparities in pixels of whatever map the photo had.
//!
//! The version does not say how wide that map was. It was the width of the views, or that of the map that was given, so
//! its numbers are taken for those of the map in use.

use serde::{Deserialize, Serialize};
use serde_json::Value;

use super::PictureSettings;
use crate::field::{Lens, Strength, ViewPoint};
use crate::scene::{Edit, Focus};

/// An edit of version 1.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct PixelEdit {
    lens: Lens,
    focus_at: Option<[f32; 2]>,
    viewpoint: ViewPoint,
}

/// Version 1, as it stands in the file.
#[derive(Debug, Default, Serialize, Deserialize)]
#[serde(default)]
pub(super) struct Stored {
    lens: Lens,
    focus_at: Option<[f32; 2]>,
    viewpoint: ViewPoint,
    pub(super) export: PictureSettings,
}

impl Stored {
    pub(super) fn new(edit: &PixelEdit, export: &PictureSettings) -> Self {
        let PixelEdit { lens, focus_at, viewpoint } = edit.clone();
        Self { lens, focus_at, viewpoint, export: export.clone() }
    }

    pub(super) fn edit(&self) -> PixelEdit {
        PixelEdit { lens: self.lens.clone(), focus_at: self.focus_at, viewpoint: self.viewpoint }
    }
}

impl PixelEdit {
    /// The edit without a width. Places beyond the picture meant its edge.
    pub(super) fn at_width(&self, width: u32) -> Edit {
        let edit =
            Edit { viewpoint: self.viewpoint, ..Edit::default() }.with_lens(&self.lens, width, Strength::AS_MADE);
        match self.focus_at {
            Some(place) => Edit { focus: Focus::At(place.map(|share| share.clamp(0.0, 1.0))), ..edit },
            None => edit,
        }
    }
}

/// Takes out of a file's keys those that version 2 says otherwise.
pub(super) fn forget(whole: &mut Value) {
    let Some(keys) = whole.as_object_mut() else { return };
    keys.remove("focus_at");
    let Some(lens) = keys.get_mut("lens").and_then(Value::as_object_mut) else { return };
    lens.remove("keep_sharp_px");
    // Version 2 says what is in focus, how the opening looks and what is known of distances in one word or with one key.
    for name in ["focus", "shape", "distance"] {
        lens.remove(name);
    }
}

#[cfg(test)]
mod tests {
    use crate::scene::{Focus, Recipe};

    const TEXT: &str = r#"{"lens": {"f_number": 2.0, "focus": {"disparity_px": 0.54, "tilt_px": [1.08, 0.0]},
        "keep_sharp_px": [-0.27, 0.54], "swirl": 3}, "focus_at": null, "viewpoint": {"du": -1.5, "dv": 0.5}}"#;

    #[test]
    fn its_pixels_are_those_of_the_map_in_use() {
        let recipe = Recipe::from_json(TEXT).unwrap();
        let edit = recipe.edit(540);
        assert_eq!(edit.focus, Focus::Disparity(0.54 / 540.0));
        assert_eq!((edit.tilt[0], edit.keep_sharp[1]), (1.08 / 540.0, 0.54 / 540.0));
        assert_eq!(recipe.edit(270).focus, Focus::Disparity(0.54 / 270.0));
        assert_eq!(edit.viewpoint.0.du, -1.5);
        let placed = Recipe::from_json(r#"{"focus_at": [0.5, 2.0]}"#).unwrap();
        assert_eq!(placed.edit(270).focus, Focus::At([0.5, 1.0]));
    }

    #[test]
    fn it_stays_as_it_was_until_it_is_edited_and_keeps_what_nobody_knows() {
        let recipe = Recipe::from_json(TEXT).unwrap();
        let unread = |text: &str| serde_json::from_str::<serde_json::Value>(text).unwrap();
        assert!(unread(&recipe.to_json()).get("version").is_none());
        let edit = recipe.edit(540);
        let text = recipe.with_edit(edit.clone()).to_json();
        let new = unread(&text);
        assert_eq!((&new["version"], &new["lens"]["swirl"]), (&2.into(), &3.into()));
        assert!(new.get("focus_at").is_none() && new["lens"].get("keep_sharp_px").is_none());
        assert_eq!(Recipe::from_json(&text).unwrap().edit(7), edit);
    }
}
