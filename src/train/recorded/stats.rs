//! `plenoscope-train data --stats DIR`: what a folder of light fields holds, before anything is trained on it.

use std::collections::BTreeMap;
use std::fmt::Write as _;
use std::path::{Path, PathBuf};

use anyhow::Result;
use clap::ArgMatches;

use crate::eval::metrics::{mean, median};
use crate::field::TrueField;
use crate::scenes::REFERENCE;

/// Bars of the histogram of disparities, from −1.6 to 1.6 px per view step.
const BARS: usize = 16;
const BAR_PX: f32 = 0.2;
/// Characters of the longest bar.
const LONGEST: f32 = 40.0;

/// What was found.
#[derive(Debug, Default, PartialEq)]
pub struct Stats {
    /// Light fields of each width and height of a view.
    pub sizes: BTreeMap<[usize; 2], usize>,
    /// Mean sRGB value of each reference view, 0 … 1.
    pub brightness: Vec<f32>,
    /// Share of the pixels by disparity, of those that were measured; what lies beyond is in the outermost bars.
    pub disparities: [f32; BARS],
    /// How many were measured.
    pub measured: usize,
    /// Why the others cannot be read.
    pub passed_over: Vec<String>,
}

/// Looks at all light fields of a folder and measures the disparities of `measure` of them, evenly spread.
///
/// # Errors
/// A folder without any.
pub fn of_folder(folder: &Path, measure: usize) -> Result<Stats> {
    let files = super::found(folder)?;
    let every = files.len().div_ceil(measure.max(1)).max(1);
    let mut stats = Stats::default();
    let mut counts = [0usize; BARS];
    for (i, file) in files.iter().enumerate() {
        let field = match TrueField::open(file) {
            Ok(field) => field,
            Err(error) => {
                stats.passed_over.push(error.to_string());
                continue;
            }
        };
        *stats.sizes.entry(field.size).or_default() += 1;
        let values = field.views[REFERENCE].px.iter().flatten().copied();
        stats.brightness.extend(mean(values));
        if i % every == 0 && measure > 0 {
            stats.measured += 1;
            for d in field.reference_disparity()?.px {
                counts[bar_of(d)] += 1;
            }
        }
    }
    let all = counts.iter().sum::<usize>().max(1) as f32;
    stats.disparities = counts.map(|count| count as f32 / all);
    Ok(stats)
}

/// The bar that a disparity belongs to.
fn bar_of(disparity_px: f32) -> usize {
    let place = disparity_px / BAR_PX + (BARS / 2) as f32;
    place.clamp(0.0, (BARS - 1) as f32) as usize
}

/// As `data --stats` prints it.
///
/// # Errors
/// A folder without light fields.
pub fn run(matches: &ArgMatches) -> Result<String> {
    let folder = matches.get_one::<PathBuf>("stats").cloned().unwrap_or_default();
    let measure = matches.get_one::<usize>("measure").copied().unwrap_or(0);
    Ok(text(&of_folder(&folder, measure)?))
}

fn text(stats: &Stats) -> String {
    let mut text = String::new();
    // Writing to a string cannot fail.
    let mut line = |line: String| writeln!(text, "{line}").unwrap_or_default();
    line(format!("{} light fields", stats.brightness.len()));
    for ([w, h], count) in &stats.sizes {
        line(format!("  {count} of {w}×{h} px, 8×8 views of each used"));
    }
    let range = stats.brightness.iter().fold([1.0f32, 0.0], |[lo, hi], b| [lo.min(*b), hi.max(*b)]);
    if let Some(middle) = median(stats.brightness.clone()) {
        line(format!("mean brightness {:.2} … {:.2}, the middle one {middle:.2} (sRGB, 0 … 1)", range[0], range[1]));
    }
    if stats.measured > 0 {
        line(format!("disparities of {} of them, px per view step", stats.measured));
        let most = stats.disparities.iter().copied().fold(f32::MIN_POSITIVE, f32::max);
        for (bar, share) in stats.disparities.iter().enumerate() {
            let from = (bar as f32 - (BARS / 2) as f32) * BAR_PX;
            let drawn = "█".repeat((LONGEST * share / most).round() as usize);
            line(format!("{from:5.1} {:5.1} % {drawn}", 100.0 * share));
        }
    }
    stats.passed_over.iter().for_each(|why| line(format!("passed over: {why}")));
    text
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::recorded::tests::write_plane;

    #[test]
    fn sizes_and_disparities_of_a_folder_are_told_and_what_cannot_be_read() {
        let folder = tempfile::tempdir().unwrap();
        write_plane(&folder.path().join("near"), 0.5);
        write_plane(&folder.path().join("far"), -0.5);
        std::fs::create_dir(folder.path().join("empty")).unwrap();
        let stats = of_folder(folder.path(), 8).unwrap();
        assert_eq!(stats.sizes, BTreeMap::from([([48, 36], 2)]));
        assert_eq!((stats.measured, stats.passed_over.len()), (2, 1));
        let (near, far) = (bar_of(0.5), bar_of(-0.5));
        assert!(stats.disparities[near] > 0.4 && stats.disparities[far] > 0.4, "{:?}", stats.disparities);
        let told = text(&stats);
        assert!(told.contains("2 of 48×36") && told.contains("passed over"), "{told}");
        assert!(of_folder(&folder.path().join("empty"), 8).unwrap_err().to_string().contains("--data"));
    }
}
