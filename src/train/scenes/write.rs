//! `plenoscope-train data`: samples as folders of views that the window can open, and one sheet to look at.

use std::path::{Path, PathBuf};

use anyhow::Result;
use clap::{ArgMatches, Command, arg, value_parser};
use plenoscope::field::{RayDepths, ViewGrid};
use plenoscope::io::formats::{self, views};
use plenoscope::job::{Cancel, Job};

use super::raster::Raster;
use super::{Config, Mix, Sample, Source};
use crate::eval::sheet::{depth_tile, epi_tile, join, usual_range, write_png};
use crate::field::light_field;

/// What the command line understands.
pub fn command() -> Command {
    let number = || value_parser!(usize);
    Command::new("data")
        .about("Write samples of the data engine as folders of views, and a contact sheet")
        .arg(arg!(--out <DIR> "Folder for them").required(true).value_parser(value_parser!(PathBuf)))
        .arg(arg!(--count <N> "Samples").default_value("12").value_parser(number()))
        .arg(
            arg!(--data <DIR> "Folder of flowers/, everyday/ …")
                .default_value("data")
                .value_parser(value_parser!(PathBuf)),
        )
        .arg(arg!(--"long-side" <PX> "Long side of the whole picture").default_value("270").value_parser(number()))
        .arg(arg!(--seed <N> "Seed").default_value("1").value_parser(value_parser!(u64)))
        .arg(
            arg!(--mix <SHARES> "Shares of the kinds, e.g. `lifted=0.4,pseudo=0.3,collage=0.2,real=0.1`")
                .default_value("")
                .hide_default_value(true)
                .value_parser(value_parser!(Mix)),
        )
}

/// Writes samples; gives what is to be printed.
///
/// # Errors
/// Bad data, or a disk that cannot be written.
pub fn run(matches: &ArgMatches) -> Result<String> {
    let number = |name: &str| matches.get_one::<usize>(name).copied().unwrap_or(0);
    let path = |name: &str| matches.get_one::<PathBuf>(name).cloned().unwrap_or_default();
    let long_side = number("long-side");
    let config = Config {
        data: path("data"),
        long_side,
        crop: [long_side, long_side * 3 / 4],
        views_per_sample: 64,
        mix: matches.get_one::<Mix>("mix").copied().unwrap_or_default(),
        seed: matches.get_one::<u64>("seed").copied().unwrap_or(1),
        ..Config::default()
    };
    let source = Source::new(&config)?;
    let out = path("out");
    std::fs::create_dir_all(&out)?;
    let mut rows = Vec::new();
    for index in 0..number("count") as u64 {
        let sample = source.sample(index);
        write(&out.join(format!("sample_{index:04}_{:?}", sample.kind).to_lowercase()), &sample)?;
        rows.push(tiles(&sample));
    }
    write_png(&out.join("sheet.png"), &join(&rows, 240))?;
    Ok(format!("{} samples and sheet.png in {}", rows.len(), out.display()))
}

/// The pictures of a sample in `[v, u]` order.
fn pictures(sample: &Sample) -> Vec<Raster<[f32; 3]>> {
    let count = sample.size[0] * sample.size[1];
    let mut all = vec![Raster { size: sample.size, px: Vec::new() }; 64];
    for (k, &layer) in sample.views.iter().enumerate() {
        let at = |c: usize, i: usize| sample.rgb[(3 * k + c) * count + i];
        all[layer].px = (0..count).map(|i| [at(0, i), at(1, i), at(2, i)]).collect();
    }
    all
}

/// Reference view, its ray depth, the first corner view, its ray depth, epipolar image of the middle row.
fn tiles(sample: &Sample) -> Vec<Raster<[f32; 3]>> {
    let pictures = pictures(sample);
    let count = sample.size[0] * sample.size[1];
    let place = |layer: usize| sample.views.iter().position(|&l| l == layer).unwrap_or(0);
    let depth = |layer: usize| &sample.disparity[place(layer) * count..][..count];
    let range = usual_range(depth(36));
    vec![
        pictures[36].clone(),
        depth_tile(depth(36), sample.size, range),
        pictures[0].clone(),
        depth_tile(depth(0), sample.size, range),
        epi_tile(|layer| &pictures[layer], sample.size[1] / 2, 4),
    ]
}

fn all_known(sample: &Sample) -> bool {
    sample.disparity.iter().all(|d| !d.is_nan())
}

fn ray_depths(sample: &Sample) -> Result<RayDepths> {
    let count = sample.size[0] * sample.size[1];
    let mut sorted = vec![0.0; sample.disparity.len()];
    for (map, &layer) in sample.disparity.chunks_exact(count).zip(&sample.views) {
        sorted[layer * count..(layer + 1) * count].copy_from_slice(map);
    }
    Ok(RayDepths::new(ViewGrid::PAPER, sample.size.map(|side| side as u32), sorted)?)
}

/// Writes one sample of 64 views, with its ray depths where all of them are known.
///
/// # Errors
/// A sample of fewer views; a disk that cannot be written.
pub fn write(folder: &Path, sample: &Sample) -> Result<()> {
    anyhow::ensure!(sample.views.len() == 64, "a sample of {} views; expected all 64", sample.views.len());
    let field = light_field(&pictures(sample))?;
    let depths = all_known(sample).then(|| ray_depths(sample)).transpose()?;
    let cancel = Cancel::default();
    let job = Job { cancel: &cancel, sink: &() };
    Ok(views::write(folder, &formats::Source { depths: depths.as_ref(), ..formats::Source::new(&field) }, &job)?)
}
