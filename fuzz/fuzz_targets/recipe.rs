//! Recipes, and what is written of them.
#![no_main]

use plenoscope::recipe::Recipe;

libfuzzer_sys::fuzz_target!(|text: &str| {
    if let Ok(recipe) = Recipe::from_json(text) {
        let _text = recipe.to_json();
    }
});
