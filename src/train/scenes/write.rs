//! `plenoscope-train data`: samples as folders of views that the window can open, and one sheet to look at.

use std::path::{Path, PathBuf};
use std::time::Instant;

use anyhow::Result;
use clap::{Arg, ArgMatches, Command, arg, value_parser};
use plenoscope::field::{RayDepths, ViewGrid};
use plenoscope::io::formats::{self, eslf, views};
use plenoscope::job::{Cancel, Job};
use plenoscope::shard::Shard;

use super::raster::Rgb;
use super::{Config, Mix, REFERENCE, Sample, Source};
use crate::eval::constructed;
use crate::eval::metrics::{mean, spearman};
use crate::eval::sheet::{depth_tile, epi_tile, join, usual_range, write_png};
use crate::field::light_field;
use crate::recorded::ENDINGS;

/// Rows of the sheet.
const SHEET_ROWS: usize = 40;

/// What the command line understands.
pub fn command() -> Command {
    let number = || value_parser!(usize);
    Command::new("data")
        .about("Write samples of the data engine as light fields, and a contact sheet; or say what a folder of light fields holds")
        .arg(
            arg!(--out <DIR> "Folder for them")
                .required_unless_present("stats")
                .required(false)
                .value_parser(value_parser!(PathBuf)),
        )
        .arg(
            arg!(--stats <DIR> "Say what a folder of light fields holds instead: number, sizes, brightness, disparities")
                .required(false)
                .value_parser(value_parser!(PathBuf)),
        )
        .arg(
            arg!(--pack <DIR> "Pack a folder of light fields into --out instead: their 8 x 8 views, read without decoding")
                .required(false)
                .conflicts_with("stats")
                .value_parser(value_parser!(PathBuf)),
        )
        .arg(
            arg!(--measure <N> "Light fields of --stats whose disparities are measured")
                .default_value("24")
                .value_parser(number()),
        )
        .arg(arg!(--count <N> "Samples").default_value("12").value_parser(number()))
        .arg(
            arg!(--views <N> "Views of each; with fewer than 64 they are drawn for the sheet and the figures alone")
                .default_value("64")
                .value_parser(clap::builder::RangedU64ValueParser::<usize>::new().range(1..=64)),
        )
        .arg(
            arg!(--data <DIR> "Folder of flowers/, everyday/ …")
                .default_value("data")
                .value_parser(value_parser!(PathBuf)),
        )
        .arg(arg!(--"long-side" <PX> "Long side of the whole picture").default_value("270").value_parser(number()))
        .arg(arg!(--seed <N> "Seed").default_value("1").value_parser(value_parser!(u64)))
        .arg(
            arg!(--mix <SHARES> "Shares of the kinds, e.g. `solid=1` or `lifted=0.3,pseudo=0.4,real=0.1,solid=0.2`")
                .default_value("")
                .hide_default_value(true)
                .value_parser(value_parser!(Mix)),
        )
        .arg(part("turned", "Part of the lifted maps that lie on a side or upside down"))
        .arg(part("shading", "Part of the samples on which falls light that says nothing about depth"))
        .arg(part("pitfalls", "Part of the scenes that show bare tops, bright upper walls, portraits, wide land, clouds, flowers from near, things on ledges, bold patterns, long shadows, sunlight in patches"))
        .arg(part("fine", "Part of the scenes in three dimensions of which a window is shown, two or three times as large"))
        .arg(arg!(--"held-out" "Photos that training never sees, as they are: what methods are judged by"))
        .arg(arg!(--eslf "Write Lytro's ESLF pictures in place of folders").requires("out"))
        .arg(
            arg!(--shard <"K/N"> "Write every N-th sample, from the K-th; N workers write what one would")
                .default_value("1/1")
                .value_parser(value_parser!(Shard)),
        )
}

/// A flag for a share.
fn part(name: &'static str, help: &'static str) -> Arg {
    Arg::new(name).long(name).value_name("PART").help(help).default_value("0").value_parser(value_parser!(f32))
}

/// Writes samples; gives what is to be printed.
///
/// # Errors
/// Bad data, or a disk that cannot be written.
pub fn run(matches: &ArgMatches) -> Result<String> {
    let number = |name: &str| matches.get_one::<usize>(name).copied().unwrap_or(0);
    let share = |name: &str| matches.get_one::<f32>(name).copied().unwrap_or(0.0);
    let path = |name: &str| matches.get_one::<PathBuf>(name).cloned().unwrap_or_default();
    let long_side = number("long-side");
    let config = Config {
        data: path("data"),
        long_side,
        crop: [long_side, long_side * 3 / 4],
        views_per_sample: number("views"),
        mix: matches.get_one::<Mix>("mix").copied().unwrap_or_default(),
        seed: matches.get_one::<u64>("seed").copied().unwrap_or(1),
        turned: share("turned"),
        shading: share("shading"),
        pitfalls: share("pitfalls"),
        fine: share("fine"),
        ..Config::default()
    };
    let held_out = matches.get_flag("held-out");
    let (source, photos) = if held_out {
        let (source, photos) = constructed::held_out(&config.data, long_side)?;
        (source, Some(photos))
    } else {
        (Source::new(&config)?, None)
    };
    let most = photos.as_ref().map_or(usize::MAX, Vec::len).min(number("count"));
    let notes: String = source.notes().map(|note| format!("{note}\n")).collect();
    let out = path("out");
    std::fs::create_dir_all(&out)?;
    let shard = matches.get_one::<Shard>("shard").copied().unwrap_or_default();
    let (mut rows, mut told, mut secs, mut count) = (Vec::new(), Vec::new(), 0.0, 0);
    for index in (0..most as u64).filter(|index| shard.takes_number(*index)) {
        count += 1;
        let started = Instant::now();
        let sample = match &photos {
            Some(photos) => source.constructed(photos[index as usize], constructed::all_views()),
            None => source.sample(index),
        };
        secs += started.elapsed().as_secs_f64();
        told.extend(told_by_row(&sample));
        let name = format!("{}_{index:04}_{:?}", if held_out { "held_out" } else { "sample" }, sample.kind);
        if let Some((pictures, depths)) = sample.pictures().zip(sample.depths()) {
            write(&out.join(name.to_lowercase()), &pictures, &depths, matches.get_flag("eslf"))?;
            if rows.len() < SHEET_ROWS {
                rows.push(tiles(&pictures, &depths));
            }
        } else if rows.len() < SHEET_ROWS {
            rows.push(reference_tiles(&sample));
        }
    }
    let sheet =
        if shard.is_whole() { "sheet.png".to_owned() } else { format!("sheet_{shard}.png").replace('/', "_of_") };
    if !rows.is_empty() {
        write_png(&out.join(&sheet), &join(&rows, 240))?;
    }
    Ok(format!(
        "{notes}{count} samples and {sheet} in {}\n{:.1} samples a second; Spearman of the row number {:.3} over them\n",
        out.display(),
        f64::from(count) / secs.max(1e-9),
        mean(told.into_iter()).unwrap_or(0.0)
    ))
}

/// How well the row number alone orders the reference view's depth; none where that is not known.
fn told_by_row(sample: &Sample) -> Option<f32> {
    let map = &sample.disparity[..sample.size[0] * sample.size[1]];
    let known = map.iter().enumerate().filter(|(_, d)| d.is_finite());
    let (rows, depths): (Vec<f32>, Vec<f32>) = known.map(|(i, d)| ((i / sample.size[0]) as f32, *d)).unzip();
    (!depths.is_empty()).then(|| spearman(&rows, &depths))
}

/// Reference view and its ray depth.
fn reference_tiles(sample: &Sample) -> Vec<Rgb> {
    let plane = sample.size[0] * sample.size[1];
    let px = (0..plane).map(|i| [0, 1, 2].map(|c| sample.rgb[c * plane + i])).collect();
    let map = &sample.disparity[..plane];
    vec![Rgb { size: sample.size, px }, depth_tile(map, sample.size, usual_range(map))]
}

/// Reference view, its ray depth, the first corner view, its ray depth, epipolar image of the middle row.
fn tiles(pictures: &[Rgb], depths: &[&[f32]]) -> Vec<Rgb> {
    let size = pictures[REFERENCE].size;
    let range = usual_range(depths[REFERENCE]);
    vec![
        pictures[REFERENCE].clone(),
        depth_tile(depths[REFERENCE], size, range),
        pictures[0].clone(),
        depth_tile(depths[0], size, range),
        epi_tile(|layer| &pictures[layer], size[1] / 2, 4),
    ]
}

/// Writes the 64 views of a sample: a folder, with their ray depths where all of them are known, or one ESLF picture without.
fn write(folder: &Path, pictures: &[Rgb], depths: &[&[f32]], as_eslf: bool) -> Result<()> {
    let field = light_field(pictures)?;
    let all_known = depths.iter().all(|map| map.iter().all(|d| !d.is_nan()));
    let depths = all_known.then(|| RayDepths::new(ViewGrid::PAPER, field.size(), depths.concat())).transpose()?;
    let cancel = Cancel::default();
    let job = Job { cancel: &cancel, sink: &() };
    let source = formats::FieldToWrite { depths: depths.as_ref(), ..formats::FieldToWrite::new(&field) };
    if as_eslf {
        let name = format!("{}{}", folder.file_name().unwrap_or_default().to_string_lossy(), ENDINGS[0]);
        return Ok(eslf::write(&folder.with_file_name(name), &source, &job)?);
    }
    Ok(views::write(folder, &source, &job)?)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::eval::TrueField;
    use crate::scenes::raster::Raster;

    #[test]
    fn a_written_sample_is_read_with_its_ray_depths() {
        let folder = tempfile::tempdir().unwrap();
        let pictures = vec![Raster { size: [12, 8], px: vec![[0.5; 3]; 96] }; 64];
        let maps: Vec<Vec<f32>> = (0..64).map(|layer| vec![layer as f32 / 64.0; 96]).collect();
        let mut depths: Vec<&[f32]> = maps.iter().map(|map| &map[..]).collect();
        write(&folder.path().join("known"), &pictures, &depths, false).unwrap();
        let read = TrueField::open(&folder.path().join("known")).unwrap();
        assert_eq!(read.depths, maps.iter().cloned().enumerate().collect::<Vec<_>>());
        depths[3] = &[f32::NAN; 96];
        write(&folder.path().join("in part"), &pictures, &depths, false).unwrap();
        assert!(TrueField::open(&folder.path().join("in part")).unwrap().depths.is_empty());
        write(&folder.path().join("one"), &pictures, &depths, true).unwrap();
        let read = TrueField::open(&folder.path().join("one_eslf.png")).unwrap();
        assert!(read.views.iter().zip(&pictures).all(|(a, b)| (a.px[0][0] - b.px[0][0]).abs() < 0.003));
    }
}
