//! `burst`: several photos of one subject become one light field.

use anyhow::Result;
use plenoscope::field::{Provenance, Seen};
use plenoscope::job::Job;
use plenoscope::scene::export::{self, Settings};
use plenoscope::scene::{Edit, Scene, SeveralAsked, SeveralFound, Subject, asked, rays_told};

use super::export::target;
use super::input;
use super::output::output;
use crate::cli::Burst;
use crate::output::{say, say_json};

/// Opens, finds the cameras, measures, and writes.
pub fn run(args: &Burst, job: &Job) -> Result<()> {
    let how = input::how(&args.synth, args.recipe.recipe.as_deref())?;
    let wanted =
        SeveralAsked { reference: usize::from(args.reference) - 1, share: args.baseline, denoise: args.denoise };
    let settings = Settings { kind: args.format, ..Settings::default() };
    let first = &args.photos[0];
    let target = target(&args.output, &settings, first);
    output(&target, first, false).check_written(args.format)?;
    let subject = how.subject(Subject::open_several(&args.photos, wanted, job)?);
    asked::check_is_photo(&subject)?;
    let scene = how.scene(&subject, &input::maker(&args.synth), args.format.need(settings.size()), job)?;
    asked::make_folder(&target)?;
    export::write(&scene, &Edit::default(), &settings, &target, job)?;
    tell(&scene, args.json)
}

/// What came of it, for people or for programs.
fn tell(scene: &Scene, as_json: bool) -> Result<()> {
    let found = scene.several();
    let rays = scene.views().and_then(|views| views.provenance.as_deref());
    match (found, rays) {
        _ if as_json => say_json(&json(found, rays)),
        (Some(SeveralFound { used, reprojection_px, share }), Some(rays)) => say(&format!(
            "{used} photos, {reprojection_px:.2} px off; the views reach over {:.0} % of the baseline\n{}",
            100.0 * share,
            rays_told(rays)
        )),
        _ => Ok(()),
    }
}

fn json(found: Option<SeveralFound>, rays: Option<&Provenance>) -> serde_json::Value {
    let share = |seen: Seen| rays.map(|rays| rays.share(seen));
    serde_json::json!({
        "photos": found.map_or(1, |found| found.used),
        "reprojection_px": found.map(|found| found.reprojection_px),
        "baseline_share": found.map(|found| found.share),
        "seen": {
            "in_the_photo": share(Seen::Reference),
            "in_another_photo": share(Seen::Frame),
            "invented": share(Seen::Invented),
        },
    })
}
