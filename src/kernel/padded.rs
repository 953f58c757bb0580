//! The padded copy of an activation that the tiles read: no tile ever asks whether it is inside the picture.
//!
//! Laid out `[n][v][y][c][x]`: the rows of all channels at one (view, y) lie together, so a tile that walks over the
//! channels reads few memory streams and few pages. Channel-major copies ran at a third of the speed.

use std::mem::MaybeUninit;

use rayon::prelude::*;

use super::shape::Padding;
use super::team;

/// Values that a tile may read past the end of the last row.
const SLACK: usize = 128;
/// Rows of a task.
const TASK_ROWS: usize = 8;

/// A padded copy of an activation; made by [`Conv`](super::Conv).
#[derive(Clone, Debug)]
pub struct Padded {
    values: Vec<f32>,
    pub(super) layout: Layout,
}

/// Where a row belongs.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct RowAt {
    /// Picture of the batch.
    pub image: usize,
    /// Channel.
    pub channel: usize,
    /// View.
    pub view: usize,
    /// Row of the picture.
    pub y: usize,
}

/// Sizes of a padded copy.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Layout {
    pub(super) batch: usize,
    pub(super) channels: usize,
    /// (views, rows, columns) of the picture.
    pub(super) size: [usize; 3],
    /// (views, rows, columns) added on either side.
    pub(super) margin: [usize; 3],
}

impl Layout {
    /// (views, rows, columns) with margins.
    pub(super) fn outer(&self) -> [usize; 3] {
        [0, 1, 2].map(|axis| self.size[axis] + 2 * self.margin[axis])
    }

    /// Values from one channel's row to the next: whole vectors, and one more against cache lines that collide.
    pub(super) fn channel_step(&self) -> usize {
        self.outer()[2].next_multiple_of(16) + 16
    }

    /// Values from one row to the next.
    pub(super) fn row_step(&self) -> usize {
        self.channels * self.channel_step()
    }

    /// Values from one view to the next.
    pub(super) fn view_step(&self) -> usize {
        self.outer()[1] * self.row_step()
    }

    /// Values from one picture of the batch to the next.
    pub(super) fn image_step(&self) -> usize {
        self.outer()[0] * self.view_step()
    }

    fn len(&self) -> usize {
        self.batch * self.image_step() + SLACK
    }

    /// The row of the picture that stands at the `index`-th row of the copy, clamped to the picture; and whether it
    /// is inside. The channel is 0.
    fn source(&self, index: usize) -> (RowAt, bool) {
        let [views, rows, _] = self.outer();
        let (image, view, y) = (index / (views * rows), index / rows % views, index % rows);
        let clamp = |at: usize, axis: usize| at.saturating_sub(self.margin[axis]).min(self.size[axis] - 1);
        let at = RowAt { image, channel: 0, view: clamp(view, 0), y: clamp(y, 1) };
        (at, at.view + self.margin[0] == view && at.y + self.margin[1] == y)
    }
}

impl Padded {
    /// A copy whose rows are written by `fill`, which gets them zeroed. With edge padding it is called again for the
    /// rows of the margin.
    pub(super) fn build(layout: Layout, padding: Padding, fill: impl Fn(&mut [f32], RowAt) + Sync) -> Self {
        let mut values = Vec::with_capacity(layout.len());
        let rows = layout.batch * layout.outer()[0] * layout.outer()[1];
        let row_step = layout.row_step();
        let target = SendPtr(values.as_mut_ptr());
        team::each(rows.div_ceil(TASK_ROWS), |task| {
            for index in task * TASK_ROWS..((task + 1) * TASK_ROWS).min(rows) {
                // SAFETY: rows are disjoint pieces of the allocation; all bits zero is a valid f32.
                let row = unsafe {
                    let row = target.at(index * row_step);
                    row.write_bytes(0, row_step);
                    std::slice::from_raw_parts_mut(row, row_step)
                };
                fill_row(&layout, padding, row, index, &fill);
            }
        });
        // SAFETY: the rows above and this slack are the whole length.
        unsafe {
            target.at(rows * row_step).write_bytes(0, SLACK);
            values.set_len(layout.len());
        }
        Self { values, layout }
    }

    /// The first value of the row of channel 0 at (image, view, y), counted with margins.
    pub(super) fn row(&self, image: usize, view: usize, y: usize) -> &[f32] {
        let layout = &self.layout;
        &self.values[image * layout.image_step() + view * layout.view_step() + y * layout.row_step()..]
    }
}

/// Fills the rows of all channels at one place of the copy.
fn fill_row(
    layout: &Layout,
    padding: Padding,
    row: &mut [f32],
    index: usize,
    fill: &(impl Fn(&mut [f32], RowAt) + Sync),
) {
    let (at, inside) = layout.source(index);
    if !inside && padding == Padding::Zero {
        return;
    }
    let (start, end) = (layout.margin[2], layout.margin[2] + layout.size[2]);
    for (channel, row) in row.chunks_exact_mut(layout.channel_step()).enumerate() {
        fill(&mut row[start..end], RowAt { channel, ..at });
        if padding == Padding::Edge {
            let (first, last) = (row[start], row[end - 1]);
            row[..start].fill(first);
            row[end..].fill(last);
        }
    }
}

/// `count` chunks of `len` values, each zeroed and then written by the thread that takes it.
pub(super) fn by_chunks<T>(count: usize, len: usize, write: impl Fn(usize, &mut [T]) + Sync) -> Vec<T>
where
    T: Copy + Default + Send,
{
    let mut values = Vec::with_capacity(count * len);
    let room = &mut values.spare_capacity_mut()[..count * len];
    room.par_chunks_mut(len).enumerate().for_each(|(index, room)| {
        room.fill(MaybeUninit::new(T::default()));
        // SAFETY: it was filled.
        write(index, unsafe { room.assume_init_mut() });
    });
    // SAFETY: each chunk was filled.
    unsafe { values.set_len(count * len) };
    values
}

/// A pointer that several threads write through, each to places of its own.
#[derive(Clone, Copy)]
pub(super) struct SendPtr(pub(super) *mut f32);

// SAFETY: whoever dereferences it answers for disjoint places.
unsafe impl Send for SendPtr {}
// SAFETY: as above.
unsafe impl Sync for SendPtr {}

impl SendPtr {
    /// The pointer, `offset` values on.
    ///
    /// # Safety
    /// The place is inside the allocation.
    pub(super) unsafe fn at(&self, offset: usize) -> *mut f32 {
        // SAFETY: the caller's word.
        unsafe { self.0.add(offset) }
    }
}
