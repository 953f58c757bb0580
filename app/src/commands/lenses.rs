//! `lenses`: the lenses that are known by name.

use anyhow::Result;
use plenoscope::job::Job;
use plenoscope::scene::real::{KnownLens, known_lenses};
use serde_json::json;

use crate::cli::Lenses;
use crate::output::{say, say_json};

/// Lists them; files of the person's own that cannot be used are told of.
pub fn run(args: &Lenses, job: &Job) -> Result<()> {
    let (lenses, errors) = known_lenses();
    errors.iter().for_each(|error| job.sink.warning(error.to_string()));
    if args.json {
        let all: Vec<_> = lenses.iter().map(|lens| json!({ "id": lens.id(), "lens": lens })).collect();
        return say_json(&json!({ "lenses": all }));
    }
    lenses.iter().try_for_each(|lens| say(&line(lens)))
}

fn line(lens: &KnownLens) -> String {
    let [widest, narrowest] = lens.f_numbers;
    let blades = lens.blades.map(|n| format!(", {n} blades")).unwrap_or_default();
    let nearest = lens.nearest_m.map(|m| format!(", from {m} m")).unwrap_or_default();
    format!("{:32} {}: f/{widest} … f/{narrowest}{blades}{nearest}", lens.id(), lens.name)
}
