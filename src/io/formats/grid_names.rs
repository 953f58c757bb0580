//! Which file of a folder is which view: told by the numbers in the names.
//!
//! Names that differ only in numbers belong together. Two numbers that change are row and column
//! (`view_3_4.png`, `lily_03_11.png`, `003_011.ppm`); one is a running number, row by row (`input_Cam036.png`).

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use super::{file_types, views};
use crate::field::ViewGrid;
use crate::io::Problem;

/// The files of a light field, in `[v, u]` order.
#[derive(Debug)]
pub(super) struct GridFiles {
    pub(super) grid: ViewGrid,
    pub(super) files: Vec<PathBuf>,
    /// Whether the names hold one running number only, so that it is a guess that they are views at all.
    pub(super) running: bool,
    /// Whether they are the four at the corners of a larger grid, whose other views are not there.
    pub(super) corners: bool,
}

/// A grid of which less than one in so many places is filled is none.
const MOSTLY: usize = 2;

/// A name's pattern and the numbers in it.
fn split_numbers(stem: &str) -> (String, Vec<u64>) {
    let (mut pattern, mut numbers, mut digits) = (String::new(), Vec::new(), String::new());
    for c in stem.chars().chain(['\0']) {
        if c.is_ascii_digit() {
            digits.push(c);
            continue;
        }
        if !digits.is_empty() {
            numbers.push(digits.parse().unwrap_or(u64::MAX));
            pattern.push('#');
            digits.clear();
        }
        if c != '\0' {
            pattern.push(c);
        }
    }
    (pattern, numbers)
}

/// Files of one pattern, each with the numbers in its name.
type Family = Vec<(Vec<u64>, PathBuf)>;

/// Picture files of a folder by pattern, in file order.
fn families(folder: &Path) -> std::io::Result<BTreeMap<String, Family>> {
    let mut found: BTreeMap<String, Family> = BTreeMap::new();
    for entry in std::fs::read_dir(folder)? {
        let path = entry?.path();
        let suffix = path.extension().map(|s| s.to_string_lossy().to_lowercase()).unwrap_or_default();
        if !file_types().any(|kind| kind.pixels.is_some() && kind.suffixes.contains(&suffix.as_str())) {
            continue;
        }
        let stem = path.file_stem().map(|s| s.to_string_lossy().into_owned()).unwrap_or_default();
        let (pattern, numbers) = split_numbers(&stem);
        if !numbers.is_empty() {
            found.entry(format!("{pattern}.{suffix}")).or_default().push((numbers, path));
        }
    }
    Ok(found)
}

/// The largest family of names that fills a grid; `None` where there is none. `grid` is what an index file says.
pub(super) fn find(folder: &Path, grid: Option<ViewGrid>) -> Result<Option<GridFiles>, Problem> {
    let mut families: Vec<_> = families(folder)?.into_iter().collect();
    // What says where rays come from lies beside the views, under the same numbers.
    families.sort_by_key(|(pattern, files)| (pattern == views::SEEN_PATTERN, std::cmp::Reverse(files.len())));
    let Some((pattern, files)) = families.into_iter().next() else { return Ok(None) };
    if files.len() < 2 {
        return Ok(None);
    }
    let fields = files[0].0.len();
    let changing: Vec<usize> = (0..fields).filter(|&at| files.iter().any(|(n, _)| n[at] != files[0].0[at])).collect();
    match changing[..] {
        [row, col] => two_numbers(files, [row, col], grid),
        [at] => running_number(&pattern, files, at, grid),
        _ => Ok(None),
    }
}

/// Rows and columns; none where it is rather days and times, so that most places are empty.
fn two_numbers(files: Family, [row, col]: [usize; 2], grid: Option<ViewGrid>) -> Result<Option<GridFiles>, Problem> {
    let distinct = |at: usize| {
        let mut all: Vec<u64> = files.iter().map(|(numbers, _)| numbers[at]).collect();
        all.sort_unstable();
        all.dedup();
        all
    };
    let (mut rows, mut cols) = (distinct(row), distinct(col));
    if grid.is_none() && MOSTLY * files.len() < rows.len() * cols.len() {
        return Ok(None);
    }
    let corners = files.len() == 4 && are_corners(&rows, &cols);
    if let Some(grid) = grid.filter(|g| !corners && (g.rows() != rows.len() || g.cols() != cols.len())) {
        // A whole row or column of files is missing: the index file says how many there should be.
        (rows, cols) = ((0..grid.rows() as u64).collect(), (0..grid.cols() as u64).collect());
    }
    let grid = ViewGrid::new(rows.len(), cols.len())?;
    let by_place: BTreeMap<[u64; 2], PathBuf> =
        files.into_iter().map(|(numbers, path)| ([numbers[row], numbers[col]], path)).collect();
    let mut ordered = Vec::with_capacity(grid.count());
    for (v, &r) in rows.iter().enumerate() {
        for (u, &c) in cols.iter().enumerate() {
            let missing = || Problem::MissingView { v, u, rows: rows.len(), cols: cols.len() };
            ordered.push(by_place.get(&[r, c]).ok_or_else(missing)?.clone());
        }
    }
    Ok(Some(GridFiles { grid, files: ordered, running: false, corners }))
}

/// Two rows and two columns that lie equally far apart, with others between them.
fn are_corners(rows: &[u64], cols: &[u64]) -> bool {
    let step = |lines: &[u64]| if let [first, last] = lines { last - first } else { 0 };
    step(rows) > 1 && step(rows) == step(cols)
}

/// A running number fills the grid of the index file, else a square, else one row.
fn running_number(
    pattern: &str,
    mut files: Family,
    at: usize,
    grid: Option<ViewGrid>,
) -> Result<Option<GridFiles>, Problem> {
    files.sort();
    let (first, last) = (files[0].0[at], files[files.len() - 1].0[at]);
    let span = (last - first) as usize + 1;
    let known = grid.is_some() || pattern.to_lowercase().starts_with("input_cam");
    let count = grid.map_or(span, ViewGrid::count);
    let side = (count as f64).sqrt().round() as usize;
    let shape = match grid {
        Some(grid) => grid,
        None if side * side == count => ViewGrid::new(side, side)?,
        None if count <= ViewGrid::MAX_SIDE => ViewGrid::new(1, count)?,
        None => return Ok(None),
    };
    let origin = if known { first.min(1) } else { first };
    for layer in 0..count {
        if files.get(layer).is_none_or(|(numbers, _)| numbers[at] != origin + layer as u64) {
            let view = shape.view_from_layer(layer);
            let missing =
                Problem::MissingView { v: view.v.into(), u: view.u.into(), rows: shape.rows(), cols: shape.cols() };
            // Photos of a camera have gaps in their numbers too: that is no light field, and no error.
            return if known { Err(missing) } else { Ok(None) };
        }
    }
    let files = files.into_iter().take(count).map(|(_, path)| path).collect();
    Ok(Some(GridFiles { grid: shape, files, running: !known, corners: false }))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn folder(names: &[String]) -> tempfile::TempDir {
        let dir = tempfile::tempdir().unwrap();
        for name in names {
            std::fs::write(dir.path().join(name), b"").unwrap();
        }
        dir
    }

    fn names(made: impl Fn(u32, u32) -> String, rows: u32, cols: u32) -> Vec<String> {
        (0..rows * cols).map(|n| made(n / cols, n % cols)).collect()
    }

    #[test]
    fn known_patterns_are_put_in_order() {
        type Name = fn(u32, u32) -> String;
        let patterns: [Name; 5] = [
            |v, u| format!("view_{v}_{u}.png"),
            |v, u| format!("lego_2019_{v:02}_{u:02}.jpg"),
            |v, u| format!("{:03}_{:03}.ppm", v + 1, u + 1),
            |v, u| format!("{v}_{u}.png"),
            |v, u| format!("input_Cam{:03}.png", v * 3 + u),
        ];
        for made in patterns {
            let dir = folder(&names(made, 3, 3));
            let found = find(dir.path(), None).unwrap().unwrap();
            assert_eq!((found.grid.rows(), found.grid.cols()), (3, 3));
            assert_eq!(found.files[5], dir.path().join(made(1, 2)));
        }
    }

    #[test]
    fn one_row_is_a_strip_and_a_gap_is_named() {
        let strip = folder(&names(|_, u| format!("cam{u:02}.png"), 1, 7));
        let found = find(strip.path(), None).unwrap().unwrap();
        assert_eq!((found.grid.rows(), found.grid.cols(), found.running), (1, 7, true));

        let mut gap = names(|v, u| format!("view_{v}_{u}.png"), 4, 4);
        gap.remove(6);
        let problem = find(folder(&gap).path(), None).unwrap_err();
        assert!(matches!(problem, Problem::MissingView { v: 1, u: 2, rows: 4, cols: 4 }), "{problem}");
    }

    #[test]
    fn four_views_with_a_gap_between_them_are_corners() {
        let of = |v: u32, u: u32| format!("view_{}_{}.png", 7 * v, 7 * u);
        let found = find(folder(&names(of, 2, 2)).path(), Some(ViewGrid::PAPER)).unwrap().unwrap();
        assert_eq!((found.grid.rows(), found.grid.cols(), found.corners), (2, 2, true));
        let beside = find(folder(&names(|v, u| format!("view_{v}_{u}.png"), 2, 2)).path(), None).unwrap().unwrap();
        assert!(!beside.corners);
    }

    #[test]
    fn what_says_where_rays_come_from_is_no_view() {
        let both = [names(|v, u| format!("seen_{v}_{u}.png"), 3, 3), names(|v, u| format!("view_{v}_{u}.png"), 3, 3)];
        let dir = folder(&both.concat());
        let found = find(dir.path(), None).unwrap().unwrap();
        assert_eq!(found.files[5], dir.path().join("view_1_2.png"));
    }

    #[test]
    fn photos_of_a_camera_are_no_light_field() {
        let photos = ["IMG_0001.jpg", "IMG_0004.jpg", "IMG_0007.jpg"].map(String::from);
        assert!(find(folder(&photos).path(), None).unwrap().is_none());
        let days = ["20260101_120455", "20260101_120501", "20260103_090000", "20260103_090417", "20260104_171002"];
        let photos = days.map(|at| format!("IMG_{at}.jpg"));
        assert!(find(folder(&photos).path(), None).unwrap().is_none());
    }
}
