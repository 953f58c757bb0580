//! How fast this processor can multiply and add, measured: what every share of the peak is a share of.

use std::hint::black_box;
use std::sync::Barrier;
use std::time::Instant;

use super::isa::{Isa, on_isa};
use super::vector::Vector;

/// Sums that are added to in turn: enough to hide the latency of a multiply-add, few enough for 16 registers.
const CHAINS: usize = 10;
/// Multiply-adds of each chain in one measurement: about ten milliseconds.
const ROUNDS: usize = 4_000_000;

/// `rounds` multiply-adds in each of [`CHAINS`] chains.
#[inline(always)]
pub(super) unsafe fn chains<V: Vector>(rounds: usize) -> f32 {
    // SAFETY: the processor has the instructions (caller's word); no memory is touched.
    unsafe {
        let (factor, summand) = (V::splat(black_box(0.999)), V::splat(black_box(1e-3)));
        let mut sums = [V::splat(1.0); CHAINS];
        for _ in 0..rounds {
            for sum in &mut sums {
                *sum = sum.mul_add(factor, summand);
            }
        }
        let mut total = sums[0];
        for sum in &sums[1..] {
            total = total.add(*sum);
        }
        total.sum()
    }
}

/// The most f32 GFLOP/s (two per multiply-add) that `threads` threads reached together in `tries` measurements.
pub fn gflops(isa: Isa, threads: usize, tries: usize) -> f64 {
    let flop = (2 * isa.lanes() * CHAINS * ROUNDS * threads.max(1)) as f64;
    let once = || {
        // All begin together: threads that are woken one after the other would do their parts in turn.
        let start = Barrier::new(threads.max(1));
        let part = || {
            start.wait();
            let started = Instant::now();
            black_box(on_isa!(isa, multiply_add_chains(ROUNDS)));
            started.elapsed().as_secs_f64()
        };
        let secs = std::thread::scope(|scope| {
            let parts: Vec<_> = (0..threads.max(1)).map(|_| scope.spawn(part)).collect();
            parts.into_iter().filter_map(|part| part.join().ok()).fold(0.0, f64::max)
        });
        flop / secs / 1e9
    };
    (0..tries.max(1)).map(|_| once()).fold(0.0, f64::max)
}

/// Processor seconds of all threads of this process so far; NaN where the system does not say.
pub fn cpu_seconds() -> f64 {
    #[cfg(unix)]
    {
        let mut time = libc::timespec { tv_sec: 0, tv_nsec: 0 };
        // SAFETY: the system writes the time into a place of the right type.
        if unsafe { libc::clock_gettime(libc::CLOCK_PROCESS_CPUTIME_ID, &raw mut time) } == 0 {
            return time.tv_sec as f64 + time.tv_nsec as f64 * 1e-9;
        }
    }
    f64::NAN
}
