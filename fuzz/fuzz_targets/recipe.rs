//! Recipes, and what is written of them.
#![no_main]

use plenoscope::scene::Recipe;

libfuzzer_sys::fuzz_target!(|text: &str| {
    if let Ok(recipe) = Recipe::from_json(text) {
        let _text = recipe.clone().with_edit(recipe.edit(540)).to_json();
        let _text = recipe.to_json();
    }
});
