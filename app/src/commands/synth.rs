//! `synth`: a photo becomes a light field on the disk.

use anyhow::{Result, bail};
use plenoscope::io::Opened;
use plenoscope::job::Job;

use super::{input, light_field};
use crate::cli::Synth;

/// Makes the light field and writes it.
pub fn run(args: &Synth, job: &Job) -> Result<()> {
    let Opened::Photo(file) = input::open(&args.photo, job)? else {
        bail!(
            "this is a light field already — synth takes a photo — use `plenoscope export`: {}",
            args.photo.display()
        );
    };
    let target = light_field::Target::new(&args.output, args.format, &args.photo);
    target.check(false)?;
    let scene = input::from_photo(&file, &args.synth, job)?;
    target.write(&scene, job)
}
