//! A plane convolution of many channels, one component of the transform after the other: its weights, a megabyte or more
//! in all, are read once for a few hundred tiles, where [`plane_tile`](super::plane_tile) reads them for every few dozen.

use std::sync::atomic::{AtomicBool, Ordering};

use super::plane_tile::{COMPONENTS, Component, TOGETHER, Tiles, Transformed};
use crate::job::Cancelled;
use crate::kernel::isa::{Isa, on_isa};
use crate::kernel::padded::SendPtr;
use crate::kernel::team;

/// Products of channels from which on the weights fill a core's second cache several times.
const LEAST_PRODUCTS: usize = 160 * 128;
/// Tiles that are done together: one component of them and its weights stay in the second cache.
const MOST_TILES: usize = 192;
/// Tiles that a thread transforms at a time.
const TASK_TILES: usize = 2;

/// Whether a layer of these channels gains by it.
pub(super) fn pays([channels_in, channels_out]: [usize; 2]) -> bool {
    channels_in * channels_out >= LEAST_PRODUCTS
}

/// Computes all `tiles`.
pub(super) fn run(isa: Isa, tiles: &Tiles, cancel: Option<&AtomicBool>) -> Result<(), Cancelled> {
    let stopped = || cancel.is_some_and(|flag| flag.load(Ordering::Relaxed));
    let rows = tiles.channels[0].max(tiles.channels[1]);
    let most = tiles.origins.len().min(MOST_TILES).next_multiple_of(TOGETHER);
    // One line more, lest all components of a tile fall into one set of the cache.
    let step = most * rows + 16;
    let room = COMPONENTS * step;
    let (mut inputs, mut sums) = (Vec::with_capacity(room), Vec::with_capacity(room));
    let (inputs, sums) = (SendPtr(inputs.as_mut_ptr()), SendPtr(sums.as_mut_ptr()));
    // As many in each round, so that none has a few alone.
    let rounds = tiles.origins.len().div_ceil(most).max(1);
    for origins in tiles.origins.chunks(tiles.origins.len().div_ceil(rounds).max(1)) {
        let count = origins.len();
        let place = |buffer: &SendPtr, tile: usize| Transformed {
            // SAFETY: there is room for `most` tiles, which no round exceeds.
            first: unsafe { buffer.at(tile * rows) },
            rows,
            step,
        };
        let part = |task: usize| task * TASK_TILES..((task + 1) * TASK_TILES).min(count);
        team::each(count.div_ceil(TASK_TILES), |task| {
            let part = part(task);
            let some = Tiles { origins: &origins[part.clone()], ..*tiles };
            on_isa!(isa, winograd_enter(&some, place(&inputs, part.start)));
        });
        // What fills up the last few tiles is multiplied, too; it had better be numbers.
        for component in 0..COMPONENTS {
            // SAFETY: as above.
            unsafe {
                inputs
                    .at(component * step + count * rows)
                    .write_bytes(0, (count.next_multiple_of(TOGETHER) - count) * rows);
            }
        }
        team::each(COMPONENTS, |number| {
            if stopped() {
                return;
            }
            let [from, to] = [&inputs, &sums].map(|buffer| {
                // SAFETY: as above.
                unsafe { buffer.at(number * step) }
            });
            let weights = tiles.weights[number * tiles.channels[0] * tiles.channels[1]..].as_ptr();
            on_isa!(isa, winograd_component(&Component { channels: tiles.channels, rows, count, from, weights, to }));
        });
        if stopped() {
            return Err(Cancelled);
        }
        team::each(count.div_ceil(TASK_TILES), |task| {
            let part = part(task);
            let some = Tiles { origins: &origins[part.clone()], ..*tiles };
            on_isa!(isa, winograd_leave(&some, place(&sums, part.start)));
        });
    }
    Ok(())
}
