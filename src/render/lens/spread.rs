//! A slice's light spread over a tile: differences along rows on grids of all coarsenesses, summed up and put behind
//! what is nearer.

use super::kernel::Kernel;
use super::rays::{LEVELS, Ray};
use super::tile::{Optics, Region};
use crate::field::{ramp, sides};

/// One slice on its way over a tile.
pub(super) struct Spread {
    sheets: [Sheet; LEVELS],
    /// Light that stays in its pixel; not as differences, so that it stays exact.
    still: Vec<[f32; 4]>,
    still_rows: [usize; 2],
    still_columns: [usize; 2],
}

/// The grid of one level.
struct Sheet {
    /// Of a cell: 1 << level pixels.
    level: usize,
    /// First cell, in the picture's cells of this level.
    at: [i32; 2],
    size: [usize; 2],
    /// From a ray's cell to this grid's.
    shift: [i32; 2],
    /// `[y, x]` with two columns more than the grid; what goes in left of it is in the first column.
    steps: Vec<[f32; 4]>,
    /// The same summed up, with what the coarser levels give; `[y, x]`.
    sums: Vec<[f32; 4]>,
    /// First and last row that rays reach, and that there is light in after the sum.
    rows: [usize; 2],
    filled: [usize; 2],
    /// First and last column of both.
    columns: [usize; 2],
    filled_columns: [usize; 2],
}

/// An empty range of rows or columns.
const NO_ROWS: [usize; 2] = [usize::MAX, 0];

fn is_none(rows: [usize; 2]) -> bool {
    rows[0] > rows[1]
}

fn both(a: [usize; 2], b: [usize; 2]) -> [usize; 2] {
    [a[0].min(b[0]), a[1].max(b[1])]
}

impl Default for Spread {
    fn default() -> Self {
        let sheets = std::array::from_fn(|level| Sheet {
            level,
            at: [0; 2],
            size: [0; 2],
            shift: [0; 2],
            steps: Vec::new(),
            sums: Vec::new(),
            rows: NO_ROWS,
            filled: NO_ROWS,
            columns: NO_ROWS,
            filled_columns: NO_ROWS,
        });
        Self { sheets, still: Vec::new(), still_rows: NO_ROWS, still_columns: NO_ROWS }
    }
}

impl Spread {
    /// Begins another tile. All grids are empty then: each slice clears what it has put there.
    pub(super) fn begin(&mut self, region: Region) {
        let at = region.at.map(|at| at as i32);
        let (mut first, mut size) = (at, sides(region.size));
        for (level, sheet) in self.sheets.iter_mut().enumerate() {
            if level > 0 {
                let last = [0, 1].map(|a| ((first[a] + size[a] as i32 - 1) >> 1) + 1);
                first = first.map(|f| (f >> 1) - 1);
                size = [0, 1].map(|a| (last[a] - first[a] + 1) as usize);
            }
            (sheet.at, sheet.size) = (first, size);
            sheet.shift = [0, 1].map(|a| (at[a] >> level) - first[a]);
            sheet.sums.resize(if level > 0 { size[0] * size[1] } else { 0 }, [0.0; 4]);
            sheet.steps.resize((size[0] + 2) * size[1], [0.0; 4]);
        }
        self.still.resize((region.size[0] * region.size[1]) as usize, [0.0; 4]);
    }

    /// Spreads a slice and puts it behind what is there; the last number of `front` is how much is left to cover.
    pub(super) fn put_behind(&mut self, rays: &[Vec<Ray>; LEVELS], optics: &Optics, front: &mut [[f32; 4]]) {
        for (sheet, rays) in self.sheets.iter_mut().zip(rays) {
            for ray in rays.iter().filter(|ray| ray.kernel > 0) {
                sheet.add(ray, optics);
            }
        }
        for ray in rays[0].iter().filter(|ray| ray.kernel == 0) {
            self.stay(ray);
        }
        for level in (1..LEVELS).rev() {
            let (fine, coarse) = self.sheets.split_at_mut(level + 1);
            fine[level].sum_up(coarse.first());
        }
        self.cover(front);
        self.clear();
    }

    fn stay(&mut self, ray: &Ray) {
        let [width, height] = self.sheets[0].size;
        let [x, y] = [ray.x, ray.y].map(|at| at as usize);
        // Negative places are large ones here.
        if x < width && y < height {
            add(&mut self.still[y * width + x], &ray.light, 1.0);
            self.still_rows = both(self.still_rows, [y, y]);
            self.still_columns = both(self.still_columns, [x, x]);
        }
    }

    fn cover(&self, front: &mut [[f32; 4]]) {
        let [finest, coarse, ..] = &self.sheets;
        let [width, height] = finest.size;
        let mut rows = both(finest.rows, self.still_rows);
        let mut columns = both(finest.columns, self.still_columns);
        if !is_none(coarse.filled) {
            rows = both(rows, finest.under(coarse, coarse.filled, 1));
            columns = both(columns, finest.under(coarse, coarse.filled_columns, 0));
        }
        if is_none(rows) {
            return;
        }
        // Left of the first column there is no light, and right of the last one none is left.
        let (first, end) = (columns[0].min(width), (columns[1] + 1).min(width));
        let mut upper = vec![[0.0; 4]; end - first];
        for y in rows[0]..=rows[1].min(height - 1) {
            let mut sum = [0.0; 4];
            finest.interpolated(coarse, y, first, &mut upper);
            let steps = &finest.steps[y * (width + 2)..][first..end];
            let still = &self.still[y * width..][first..end];
            let front = &mut front[y * width..][first..end];
            for (((pixel, step), still), upper) in front.iter_mut().zip(steps).zip(still).zip(&upper) {
                add(&mut sum, step, 1.0);
                put(pixel, std::array::from_fn(|c| sum[c] + still[c] + upper[c]));
            }
        }
    }

    fn clear(&mut self) {
        self.sheets.iter_mut().for_each(Sheet::clear);
        if !is_none(self.still_rows) {
            cleared(&mut self.still, self.sheets[0].size[0], self.still_rows, self.still_columns);
        }
        [self.still_rows, self.still_columns] = [NO_ROWS; 2];
    }
}

/// Puts light and coverage behind a pixel.
#[inline(always)]
fn put(pixel: &mut [f32; 4], light: [f32; 4]) {
    let cover = light[3];
    if cover <= 1e-5 {
        return;
    }
    let share = at_most(closed(cover), pixel[3]);
    let part = share / cover;
    let lit = light.map(|v| if v > 0.0 { v } else { 0.0 });
    let [r, g, b, left] = *pixel;
    *pixel = [r + part * lit[0], g + part * lit[1], b + part * lit[2], left - share];
}

/// The lesser of two numbers, without a look at what is none.
#[inline(always)]
fn at_most(a: f32, b: f32) -> f32 {
    if a < b { a } else { b }
}

/// Coverage with its last per cent closed: a surface whose blur changes from place to place spreads a little unevenly,
/// and a bright background would show through a dark one.
#[inline(always)]
fn closed(cover: f32) -> f32 {
    if cover < 0.8 { cover } else { at_most(cover + 0.015 * at_most((cover - 0.8) * 10.0, 1.0), 1.0) }
}

/// Covers a pixel of whose opening its own surface, or all nearly sharp ones, have left next to nothing. Where blur has a
/// ridge, each side spreads away from it; where it passes through the focal plane, sharp pixels give nothing to those
/// beside them that are spread. Up to a tenth would be missing, and a bright background show through.
#[inline]
pub(super) fn close(pixel: &mut [f32; 4], open: f32) {
    let left = pixel[3];
    if left > 0.0 && left < LOOSE[1] * open {
        narrow(pixel, left * ramp(LOOSE[0], LOOSE[1], left / open));
    }
}

/// Covers a pixel up to the part that may be left open.
#[inline]
pub(super) fn narrow(pixel: &mut [f32; 4], open: f32) {
    let left = pixel[3];
    if left > open && left < 1.0 {
        let more = (1.0 - open) / (1.0 - left);
        *pixel = [pixel[0] * more, pixel[1] * more, pixel[2] * more, open];
    }
}

/// Up to the first part of the opening nothing is left, and from the second on it stays.
const LOOSE: [f32; 2] = [0.05, 0.2];

impl Sheet {
    fn clear(&mut self) {
        if !is_none(self.rows) {
            cleared(&mut self.steps, self.size[0] + 2, self.rows, self.columns);
        }
        [self.rows, self.filled, self.columns, self.filled_columns] = [NO_ROWS; 4];
    }

    fn add(&mut self, ray: &Ray, optics: &Optics) {
        let [x, y] = [i32::from(ray.x) + self.shift[0], i32::from(ray.y) + self.shift[1]];
        let [width, height] = self.size.map(|s| s as i32);
        let [px, py] = [(self.at[0] + x) << self.level, (self.at[1] + y) << self.level];
        let Kernel { spans, reach } = optics.kernels.get(ray.kernel.into(), ray.flipped, px, py);
        let reach = *reach;
        let from = if y < reach { spans.partition_point(|span| span.dy < -y) } else { 0 };
        let to = if y + reach >= height { spans.partition_point(|span| span.dy < height - y) } else { spans.len() };
        if from >= to || x + reach < 0 || x - reach >= width {
            return;
        }
        let spans = &spans[from..to];
        let (Some(first), Some(last)) = (spans.first(), spans.last()) else { return };
        self.rows = both(self.rows, [(first.dy + y) as usize, (last.dy + y) as usize]);
        let wide = self.size[0] + 2;
        let top = (first.dy + y) as usize * wide;
        let column = |at: i32| at.clamp(0, width + 1) as usize;
        self.columns = both(self.columns, [column(x - reach), column(x + reach)]);
        let inside = x >= reach && x + reach < width;
        for span in spans {
            let start = top + (span.dy - first.dy) as usize * wide;
            let row = &mut self.steps[start..start + wide];
            if inside {
                step(row, (span.begin.0 + x) as usize, &ray.light, span.begin.1);
                step(row, (span.end.0 + x) as usize, &ray.light, span.end.1.map(|p| -p));
                continue;
            }
            let (at, parts) = span.begin;
            add(&mut row[column(at + x)], &ray.light, parts[0]);
            add(&mut row[column(at + 1 + x)], &ray.light, parts[1]);
            let (at, parts) = span.end;
            add(&mut row[column(at + x)], &ray.light, -parts[0]);
            add(&mut row[column(at + 1 + x)], &ray.light, -parts[1]);
        }
    }

    /// Sums the differences up, with the coarser level's light between its cells.
    fn sum_up(&mut self, coarser: Option<&Self>) {
        let [width, height] = self.size;
        [self.filled, self.filled_columns] = [self.rows, self.columns];
        if let Some(coarser) = coarser.filter(|c| !is_none(c.filled)) {
            self.filled = both(self.filled, self.under(coarser, coarser.filled, 1));
            self.filled_columns = both(self.filled_columns, self.under(coarser, coarser.filled_columns, 0));
        }
        if is_none(self.filled) {
            return;
        }
        self.filled[1] = self.filled[1].min(height - 1);
        let mut sums = std::mem::take(&mut self.sums);
        for y in self.filled[0]..=self.filled[1] {
            let sums = &mut sums[y * width..][..width];
            match coarser {
                Some(coarser) => self.interpolated(coarser, y, 0, sums),
                None => sums.fill([0.0; 4]),
            }
            let mut sum = [0.0; 4];
            for (total, step) in sums.iter_mut().zip(&self.steps[y * (width + 2)..]) {
                add(&mut sum, step, 1.0);
                add(total, &sum, 1.0);
            }
        }
        self.sums = sums;
    }

    /// Rows, or columns, that a coarser level's light reaches from its own.
    fn under(&self, coarser: &Self, [first, last]: [usize; 2], axis: usize) -> [usize; 2] {
        let fine = |at: usize| (coarser.at[axis] + at as i32) * 2 - self.at[axis];
        let top = self.size[axis] as i32 - 1;
        [(fine(first) - 1).clamp(0, top) as usize, (fine(last) + 2).clamp(0, top) as usize]
    }

    /// A row of the coarser level's light from a column on, between its cells: three parts of the cell, one of its
    /// neighbour.
    fn interpolated(&self, coarser: &Self, y: usize, first: usize, out: &mut [[f32; 4]]) {
        let (first, y) = (self.at[0] + first as i32, self.at[1] + y as i32);
        let row = |at: i32| {
            let at = at - coarser.at[1];
            let is_filled = at >= coarser.filled[0].min(i32::MAX as usize) as i32 && at <= coarser.filled[1] as i32;
            is_filled.then(|| &coarser.sums[at as usize * coarser.size[0]..][..coarser.size[0]])
        };
        let rows = [(row(y >> 1), 0.75), (row((y >> 1) + if y & 1 == 0 { -1 } else { 1 }), 0.25)];
        out.fill([0.0; 4]);
        for (row, share) in rows {
            let Some(row) = row else { continue };
            let mut cell = ((first >> 1) - coarser.at[0]) as usize;
            let mut odd = first & 1 == 1;
            for out in out.iter_mut() {
                let beside = if odd { &row[cell + 1] } else { &row[cell - 1] };
                let own = &row[cell];
                let between = |c: usize| 0.75 * own[c] + 0.25 * beside[c];
                add(out, &[between(0), between(1), between(2), between(3)], share);
                cell += usize::from(odd);
                odd = !odd;
            }
        }
    }
}

/// Empties a part of a grid of `wide` columns.
fn cleared(grid: &mut [[f32; 4]], wide: usize, rows: [usize; 2], columns: [usize; 2]) {
    let end = (columns[1] + 1).min(wide);
    for row in grid.chunks_exact_mut(wide).take(rows[1] + 1).skip(rows[0]) {
        row[columns[0].min(end)..end].fill([0.0; 4]);
    }
}

/// Two neighbouring steps of a row at once.
#[inline(always)]
fn step(row: &mut [[f32; 4]], at: usize, light: &[f32; 4], parts: [f32; 2]) {
    if let Some([a, b]) = row[at..].first_chunk_mut::<2>() {
        add(a, light, parts[0]);
        add(b, light, parts[1]);
    }
}

/// All four at once: written one by one they would be computed one by one.
#[inline(always)]
fn add(to: &mut [f32; 4], what: &[f32; 4], times: f32) {
    let [r, g, b, a] = *to;
    *to = [r + what[0] * times, g + what[1] * times, b + what[2] * times, a + what[3] * times];
}
