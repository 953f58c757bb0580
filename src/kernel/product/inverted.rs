//! Inverted residual blocks (Sandler et al. 2018, "MobileNetV2") in one pass: pixels are widened to many channels, each
//! channel is convolved by itself, and the sum is narrowed again. The wide values never leave the cache: they are made a
//! few rows at a time.

use std::mem::MaybeUninit;
use std::ops::Range;
use std::sync::atomic::{AtomicBool, Ordering};

use super::depthwise::{DepthWise, Layout, Places};
use super::patches::Patches;
use super::project::{Columns, Project};
use super::tile::{Block, Finish, LINE, VECTORS, aligned, panel_step};
use crate::job::Cancelled;
use crate::kernel::isa::{self, Isa, on_isa};
use crate::kernel::padded::SendPtr;
use crate::kernel::team;

/// Bytes of wide values that are kept at a time: about a core's second cache.
const KEPT_BYTES: usize = 768 << 10;
/// Pixels from which on the weights are not most of what is read.
const LEAST_PIXELS: usize = 1024;
/// Rows of the result that are made at a time, at most.
const MOST_ROWS: usize = 8;

/// A product, a convolution of each channel, a product.
#[derive(Clone, Copy, Debug)]
pub struct Inverted<'a> {
    /// Makes the channels of the convolution out of those of the picture; none where they are the same.
    pub widen: Option<Project<'a>>,
    /// Each channel by itself.
    pub depthwise: DepthWise<'a>,
    /// Makes the channels of the result.
    pub narrow: Project<'a>,
}

/// How the work is shared out.
struct Plan {
    /// Rows of the result that one thread makes one after the other.
    strip_rows: usize,
    /// Rows of the result that are made at a time.
    rows: usize,
    /// Values of a wide row, zeros at its end among them: they stand before the next row, too.
    row_len: usize,
    /// Values from one wide channel to the next.
    pitch: usize,
    /// Pixels of a panel.
    width: usize,
}

/// What a thread keeps.
#[derive(Default)]
struct Scratch {
    /// Pixels that are widened, as panels.
    packed: Vec<f32>,
    /// Wide rows, `[channel][row][column]`, and which rows of the padded picture they are.
    wide: Vec<f32>,
    held: Range<usize>,
    /// A channel's rows, taken apart, and what is made of them where that cannot go to the panels at once.
    padded: Vec<f32>,
    convolved: Vec<f32>,
    /// What is made of all channels, as panels.
    panels: Vec<f32>,
}

impl Inverted<'_> {
    /// Whether the picture is so large that its wide values would leave the cache, and has so many rows that few are
    /// widened by two threads.
    pub fn pays(patches: &Patches) -> bool {
        let fits = patches.before[1] <= LINE;
        fits && patches.pixels() >= LEAST_PIXELS && patches.output[0] >= 8 * shared_rows(patches)
    }

    /// Writes `[channels, rows, columns]`; `summand` of the same shape is added at the end.
    ///
    /// # Errors
    /// [`Cancelled`] once `cancel` is set.
    pub fn run(
        &self,
        x: &[f32],
        summand: Option<&[f32]>,
        out: &mut [MaybeUninit<f32>],
        cancel: Option<&AtomicBool>,
    ) -> Result<(), Cancelled> {
        let patches = self.depthwise.patches;
        let (channels_out, pixels) = (self.narrow.bias.len(), patches.pixels());
        self.check(x.len(), summand.map(<[f32]>::len), out.len());
        let plan = Plan::of(self.narrow.isa, patches, self.widen.is_some());
        let rows = patches.output[0];
        let out = SendPtr(out.as_mut_ptr().cast::<f32>());
        let summand = summand.map(|summand| SendPtr(summand.as_ptr().cast_mut()));
        let stopped = || cancel.is_some_and(|flag| flag.load(Ordering::Relaxed));
        team::each_with(rows.div_ceil(plan.strip_rows), Scratch::default, |scratch, strip| {
            let strip = strip * plan.strip_rows..((strip + 1) * plan.strip_rows).min(rows);
            scratch.held = 0..0;
            for first in strip.clone().step_by(plan.rows) {
                if stopped() {
                    return;
                }
                let rows = first..(first + plan.rows).min(strip.end);
                let panels = self.convolve(&plan, scratch, x, rows.clone());
                let at = first * patches.output[1];
                // SAFETY: the lengths were checked; these rows are written by this task alone.
                let block = unsafe {
                    Block {
                        a: self.narrow.weights.as_ptr(),
                        a_step: patches.channels,
                        panels: panels.as_ptr(),
                        panel_step: panel_step(patches.channels, plan.width),
                        depth: patches.channels,
                        rows: channels_out,
                        columns: rows.len() * patches.output[1],
                        out: out.at(at),
                        out_step: pixels,
                        finish: Finish {
                            row_bias: self.narrow.bias.as_ptr(),
                            activation: self.narrow.activation,
                            limits: self.narrow.limits,
                            summand: summand.as_ref().map_or(std::ptr::null(), |summand| summand.at(at)),
                            ..Finish::PLAIN
                        },
                    }
                };
                on_isa!(self.narrow.isa, product(&block));
            }
        });
        if stopped() { Err(Cancelled) } else { Ok(()) }
    }

    fn check(&self, x: usize, summand: Option<usize>, out: usize) {
        let patches = self.depthwise.patches;
        let (channels, plane) = (patches.channels, patches.size[0] * patches.size[1]);
        let channels_in = self.widen.map_or(channels, |widen| widen.weights.len() / channels.max(1));
        assert_eq!((x, out), (channels_in * plane, self.narrow.bias.len() * patches.pixels()), "lengths of a block");
        assert_eq!(self.narrow.weights.len(), self.narrow.bias.len() * channels, "weights that narrow");
        assert!(self.widen.is_none_or(|widen| widen.bias.len() == channels), "weights that widen");
        assert!(summand.is_none_or(|summand| summand == out), "length of the summand");
        self.depthwise.check();
    }

    /// All channels of some rows of the convolution's result, as panels.
    fn convolve<'s>(&self, plan: &Plan, scratch: &'s mut Scratch, x: &[f32], rows: Range<usize>) -> &'s [f32] {
        let (patches, isa) = (self.depthwise.patches, self.depthwise.isa);
        let (first, reach) = (rows.start * patches.stride[0], needed_at_most(patches, rows.len()));
        if let Some(widen) = &self.widen {
            scratch.widen(widen, plan, patches, x, first..first + reach);
        }
        let Scratch { wide, padded, convolved, panels, .. } = scratch;
        let wide = aligned(wide, plan.wide_len(patches)).as_ptr();
        let (above, needed) = in_picture(patches, first..first + reach);
        let (columns, width, depth) = (patches.size[1], plan.width, patches.channels);
        let part = Patches {
            size: [needed.len(), columns],
            before: [above, patches.before[1]],
            output: [rows.len(), patches.output[1]],
            ..*patches
        };
        let step = panel_step(depth, width);
        let panels = aligned(panels, part.pixels().div_ceil(width) * step);
        let convolved = aligned(convolved, part.pixels().next_multiple_of(width));
        // Vectors lie in one panel each then.
        let at_once = patches.output[1].is_multiple_of(isa.lanes());
        let depthwise = DepthWise { patches: &part, ..self.depthwise };
        let as_it_is = self.widen.is_some() && patches.stride[1] == 1;
        let layout = if as_it_is { Layout::with(&part, plan.row_len) } else { depthwise.layout() };
        // Zeros stand elsewhere around other rows.
        padded.clear();
        for channel in 0..depth {
            let from = wide.wrapping_add(LINE + channel * plan.pitch - patches.before[1]);
            let padded = if as_it_is {
                from
            } else if self.widen.is_some() {
                // SAFETY: `wide_len` counts what lies behind the last row, too.
                unsafe { layout.split(isa, from, plan.row_len, padded) };
                padded.as_ptr()
            } else {
                let source = &x[(channel * patches.size[0] + needed.start) * columns..];
                layout.fill(&part, &source[..needed.len() * columns], padded);
                padded.as_ptr()
            };
            if at_once {
                let places = Places::panels(panels[channel * width..].as_mut_ptr(), width, step);
                depthwise.one(&layout, channel, padded, places);
                continue;
            }
            depthwise.one(&layout, channel, padded, Places::plain(convolved.as_mut_ptr()));
            for (panel, pixels) in convolved.chunks_exact(width).enumerate() {
                panels[panel * step + channel * width..][..width].copy_from_slice(pixels);
            }
        }
        panels
    }
}

impl Scratch {
    /// Makes the wide rows `needed` of the padded picture; those that are here already are kept.
    fn widen(&mut self, widen: &Project, plan: &Plan, patches: &Patches, x: &[f32], needed: Range<usize>) {
        let wide = &mut aligned(&mut self.wide, plan.wide_len(patches))[LINE..];
        let kept = needed.start.max(self.held.start)..self.held.end.min(needed.end);
        let fresh = if kept.is_empty() { needed.clone() } else { kept.end..needed.end };
        if !kept.is_empty() && kept.start > self.held.start {
            let from = (kept.start - self.held.start) * plan.row_len;
            for rows in wide.chunks_exact_mut(plan.pitch).take(patches.channels) {
                rows.copy_within(from..from + kept.len() * plan.row_len, 0);
            }
        }
        self.held = needed.clone();
        let [height, columns] = patches.size;
        for row in fresh {
            let place = &mut wide[(row - needed.start) * plan.row_len..];
            match row.checked_sub(patches.before[0]).filter(|y| *y < height) {
                None => place.chunks_mut(plan.pitch).take(patches.channels).for_each(|row| row[..columns].fill(0.0)),
                Some(y) => widen_row(widen, plan, x, y * columns..(y + 1) * columns, (&mut self.packed, place)),
            }
        }
    }
}

/// Some pixels of all wide channels, which are `plan.pitch` apart.
fn widen_row(
    widen: &Project,
    plan: &Plan,
    x: &[f32],
    pixels: Range<usize>,
    (packed, out): (&mut Vec<f32>, &mut [f32]),
) {
    let (channels, columns) = (widen.bias.len(), pixels.len());
    let depth = widen.weights.len() / channels;
    assert!(out.len() >= (channels - 1) * plan.pitch + columns, "room for a wide row");
    let plane = x.len() / depth;
    // The next row comes closer while this one is multiplied.
    for channel in 0..depth {
        isa::prefetch(x.as_ptr().wrapping_add(channel * plane + pixels.end), columns.div_ceil(LINE));
    }
    let packed = Columns::Planes(x).pack(depth, plane, pixels, plan.width, packed);
    let block = Block {
        a: widen.weights.as_ptr(),
        a_step: depth,
        panels: packed.as_ptr(),
        panel_step: panel_step(depth, plan.width),
        depth,
        rows: channels,
        columns,
        out: out.as_mut_ptr(),
        out_step: plan.pitch,
        finish: Finish {
            row_bias: widen.bias.as_ptr(),
            activation: widen.activation,
            limits: widen.limits,
            ..Finish::PLAIN
        },
    };
    on_isa!(widen.isa, product(&block));
}

impl Plan {
    fn of(isa: Isa, patches: &Patches, widens: bool) -> Self {
        let width = VECTORS * isa.lanes();
        let [out_rows, out_columns] = patches.output;
        let threads = rayon::current_num_threads();
        // More strips share the work more evenly, and widen more rows twice.
        let strips = if widens && out_rows < 16 * shared_rows(patches) * threads { threads } else { 3 * threads };
        let strip_rows = out_rows.div_ceil(strips.max(1)).max(1);
        let wide_rows = |rows: usize| if widens { needed_at_most(patches, rows) } else { 0 };
        let margin = patches.before[1].max(patches.reach(1).saturating_sub(patches.before[1] + patches.size[1]));
        let row_len = (patches.size[1] + margin).next_multiple_of(LINE);
        let bytes =
            |rows: usize| (wide_rows(rows) * row_len + rows * out_columns) * patches.channels * size_of::<f32>();
        let fits = |rows: &usize| bytes(*rows) <= KEPT_BYTES;
        let most = (1..=MOST_ROWS.min(strip_rows)).rev().find(fits).unwrap_or(1);
        // As many as fill whole panels, if there are such.
        let rows = (1..=most).rev().find(|rows| (rows * out_columns).is_multiple_of(width)).unwrap_or(most);
        // An odd number of lines, lest the channels fall into one set of the cache.
        let pitch = ((wide_rows(rows) * row_len / LINE) | 1) * LINE;
        Self { strip_rows, rows, row_len, pitch, width }
    }

    /// Values of all wide rows, with a line before the first, and what is read behind the last when it is taken apart.
    fn wide_len(&self, patches: &Patches) -> usize {
        LINE + patches.channels * self.pitch + patches.stride[1] * (LINE + 1) + LINE
    }
}

/// Rows of the picture that two neighbouring strips both need, as rows of the result.
fn shared_rows(patches: &Patches) -> usize {
    let reach = (patches.kernel[0] - 1) * patches.dilation[0] + 1;
    reach.saturating_sub(patches.stride[0]).div_ceil(patches.stride[0])
}

/// Rows of the picture that so many rows of the result need at most.
fn needed_at_most(patches: &Patches, rows: usize) -> usize {
    (rows - 1) * patches.stride[0] + (patches.kernel[0] - 1) * patches.dilation[0] + 1
}

/// Rows of zeros above some rows of the padded picture, and those that are in the picture.
fn in_picture(patches: &Patches, rows: Range<usize>) -> (usize, Range<usize>) {
    let (height, before) = (patches.size[0], patches.before[0]);
    let start = rows.start.saturating_sub(before).min(height);
    let end = rows.end.saturating_sub(before).clamp(start, height);
    (before.saturating_sub(rows.start), start..end)
}
