//! Stanford's new light-field archive: `out_RR_CC_Y_X.png`, row, column, camera position (y, then x).

use std::path::{Path, PathBuf};

use super::grid_names::GridFiles;
use super::out::{self, FieldToWrite};
use super::views;
use crate::field::{ViewGrid, ViewIndex};
use crate::io::save::{self, SaveError};
use crate::io::{Opened, Problem};
use crate::job::Job;

/// One file's name, taken apart.
#[derive(Clone, Debug, PartialEq)]
struct Camera {
    row: u32,
    col: u32,
    y: f64,
    x: f64,
    path: PathBuf,
}

fn parse_name(path: &Path) -> Option<Camera> {
    let stem = path.file_stem()?.to_str()?.strip_prefix("out_")?.trim_end_matches('_');
    let mut parts = stem.split('_');
    let camera = Camera {
        row: parts.next()?.parse().ok()?,
        col: parts.next()?.parse().ok()?,
        y: parts.next()?.parse().ok()?,
        x: parts.next()?.parse().ok()?,
        path: path.to_owned(),
    };
    parts.next().is_none().then_some(camera)
}

/// Reads an archive's folder; `None` where the names are others.
pub(super) fn read(folder: &Path, job: &Job) -> Result<Option<Opened>, Problem> {
    let Some(files) = find(folder)? else { return Ok(None) };
    views::read_files("Stanford archive", folder, &files, views::read_index(folder)?, job)
}

/// The files of an archive's folder in `[v, u]` order; `None` where the names are others.
///
/// Rows and columns are numbers without a direction; the cameras' positions give it: u grows with x, v against y. The
/// photo-consistency check has the last word.
fn find(folder: &Path) -> Result<Option<GridFiles>, Problem> {
    let mut cameras: Vec<Camera> =
        std::fs::read_dir(folder)?.filter_map(Result::ok).filter_map(|entry| parse_name(&entry.path())).collect();
    if cameras.len() < 2 {
        return Ok(None);
    }
    let count = |of: fn(&Camera) -> u32| {
        let mut all: Vec<u32> = cameras.iter().map(of).collect();
        all.sort_unstable();
        all.dedup();
        all
    };
    let (rows, cols) = (count(|c| c.row), count(|c| c.col));
    let grid = ViewGrid::new(rows.len(), cols.len())?;
    let rises = |of: fn(&Camera) -> (u32, f64)| slope(cameras.iter().map(of)) >= 0.0;
    let (flip_v, flip_u) = (rises(|c| (c.row, c.y)), !rises(|c| (c.col, c.x)));
    cameras.sort_by_key(|c| (c.row, c.col));
    let mut files = Vec::with_capacity(grid.count());
    for at in grid.views() {
        let pick = |all: &[u32], n: u8, flip: bool| all[if flip { all.len() - 1 - usize::from(n) } else { n.into() }];
        let (row, col) = (pick(&rows, at.v, flip_v), pick(&cols, at.u, flip_u));
        let missing = || Problem::MissingView { v: at.v.into(), u: at.u.into(), rows: grid.rows(), cols: grid.cols() };
        let found = cameras.binary_search_by_key(&(row, col), |c| (c.row, c.col)).map_err(|_place| missing())?;
        files.push(cameras[found].path.clone());
    }
    Ok(Some(GridFiles { grid, files, running: false, corners: false }))
}

/// How a position changes with a number: the sign of their covariance.
fn slope(pairs: impl Iterator<Item = (u32, f64)> + Clone) -> f64 {
    let n = pairs.clone().count().max(1) as f64;
    let (sum_a, sum_b) = pairs.clone().fold((0.0, 0.0), |(a, b), (x, y)| (a + f64::from(x), b + y));
    pairs.map(|(x, y)| (f64::from(x) - sum_a / n) * (y - sum_b / n)).sum()
}

/// Writes the views under the archive's names, one unit of position a step: x to the right, y up.
///
/// # Errors
/// [`SaveError`]; then nothing has been written.
pub fn write(path: &Path, source: &FieldToWrite, job: &Job) -> Result<(), SaveError> {
    let is_ours = |name: &str| name.starts_with("out_") && name.ends_with(".png");
    let grid = source.field.grid();
    let name = |at: ViewIndex| {
        let steps = grid.offset(at);
        format!("out_{:02}_{:02}_{:.6}_{:.6}.png", at.v, at.u, -steps.dv, steps.du)
    };
    save::folder(path, is_ours, |folder| out::views(folder, source.field, name, job))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_with_and_without_a_tail_are_read() {
        let parse = |name: &str| parse_name(Path::new(name)).map(|c| (c.row, c.col, c.y, c.x));
        assert_eq!(parse("out_00_00_-381.909271_1103.376221.png"), Some((0, 0, -381.909_271, 1_103.376_221)));
        assert_eq!(parse("out_00_12_-399.772888_671.237122_.png"), Some((0, 12, -399.772_888, 671.237_122)));
        assert_eq!(parse("out_00_12.png"), None);
    }

    #[test]
    fn positions_turn_rows_and_columns() {
        let dir = tempfile::tempdir().unwrap();
        // Columns count against x, rows against the downward direction.
        for (row, col) in (0..9).map(|n| (n / 3, n % 3)) {
            let name = format!("out_{row:02}_{col:02}_{}_{}.png", f64::from(row) * 2.5, 100.0 - f64::from(col));
            std::fs::write(dir.path().join(name), b"").unwrap();
        }
        let found = find(dir.path()).unwrap().unwrap();
        let name = |n: usize| found.files[n].file_name().unwrap().to_string_lossy().into_owned();
        assert!(name(0).starts_with("out_02_02_") && name(5).starts_with("out_01_00_"));
    }
}
