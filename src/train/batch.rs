//! Batches, and the threads that make them ahead of the trainer.

use std::collections::BTreeMap;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::sync::mpsc::{Receiver, sync_channel};
use std::thread::{Builder, JoinHandle};

use crate::TrainError;
use crate::loss::Maps;
use crate::rng::Rng;

/// Samples of one size and one set of views.
#[derive(Clone, Debug, PartialEq)]
pub struct Batch {
    /// Sizes; the reference view is among the views.
    pub maps: Maps,
    /// Number of the first sample in the data engine's order.
    pub first_sample: u64,
    /// The views `[n, v, 3, h, w]`, sRGB 0 … 1.
    pub views: Vec<f32>,
    /// True ray depths `[n, v, h, w]`, NaN where unknown.
    pub truth: Vec<f32>,
    /// Where each crop lies in its picture, which runs from −1 to 1: y of first and last row, x of first and last column.
    pub yx: Vec<[f32; 4]>,
    /// What the truth of each sample is worth, 0 … 1.
    pub worth: Vec<f32>,
    /// How much of each pixel of a sample's reference view is its subject, 255 = all; empty where that is not known.
    pub subjects: Vec<Vec<u8>>,
}

impl Batch {
    /// The reference views `[n, 3, h, w]`.
    pub fn photos(&self) -> Vec<f32> {
        let (one, all) = (3 * self.maps.plane(), 3 * self.maps.plane() * self.maps.views.len());
        let from = self.maps.reference() * one;
        let photos: Vec<&[f32]> = self.views.chunks(all).map(|views| &views[from..from + one]).collect();
        photos.concat()
    }

    /// What the depth net is given: `[n, 3 or 5, h, w]`, colours in −1 … 1, then y and x in −1 … 1 over the whole picture.
    pub fn net_input(&self, coordinates: bool) -> Vec<f32> {
        let (w, h, p) = (self.maps.width, self.maps.height, self.maps.plane());
        let mut input = Vec::with_capacity(self.maps.samples * 5 * p);
        for (photo, [top, bottom, left, right]) in self.photos().chunks(3 * p).zip(&self.yx) {
            input.extend(photo.iter().map(|v| 2.0 * v - 1.0));
            if coordinates {
                (0..h).for_each(|y| input.extend(std::iter::repeat_n(along(y, h, *top, *bottom), w)));
                (0..h).for_each(|_| input.extend((0..w).map(|x| along(x, w, *left, *right))));
            }
        }
        input
    }
}

/// Blanks a few patches of a part of the photos in a net's input `[n, channels, h, w]`: what a patch shows must then be
/// told from what is around it, and no photo is known by a single spot.
pub fn blank_patches(input: &mut [f32], channels: usize, [w, h]: [usize; 2], part: f32, rng: &mut Rng) {
    for photo in input.chunks_mut(channels * w * h) {
        if !rng.chance(part) {
            continue;
        }
        for _ in 0..=rng.below(3) {
            let [pw, ph] = [w, h].map(|side| (side as f32 * rng.range(0.1, 0.35)) as usize);
            let (left, top) = (rng.below(w - pw), rng.below(h - ph));
            for channel in photo.chunks_mut(w * h).take(3) {
                let value = rng.range(-1.0, 1.0);
                channel.chunks_mut(w).skip(top).take(ph).for_each(|row| row[left..left + pw].fill(value));
            }
        }
    }
}

/// Takes the coordinates from a part of the photos in a net's input `[n, channels, h, w]`, that it learns what a picture
/// tells without them: the middle's stand everywhere.
pub fn drop_coordinates(input: &mut [f32], channels: usize, plane: usize, part: f32, rng: &mut Rng) {
    let colours = 3;
    for photo in input.chunks_mut(channels * plane).filter(|photo| photo.len() > colours * plane) {
        if rng.chance(part) {
            photo[colours * plane..].fill(0.0);
        }
    }
}

/// The coordinate of pixel `i` of `n`, the first having `start` and the last `end`.
fn along(i: usize, n: usize, start: f32, end: f32) -> f32 {
    start + (end - start) * i as f32 / (n - 1).max(1) as f32
}

/// Makes the batch of a number. The same number gives the same batch, whichever thread asks.
pub type Draw = Arc<dyn Fn(u64) -> Result<Batch, TrainError> + Send + Sync>;

/// Threads that make batches ahead, handed out in order.
pub struct Loader {
    receiver: Option<Receiver<(u64, Result<Batch, TrainError>)>>,
    early: BTreeMap<u64, Result<Batch, TrainError>>,
    next: u64,
    stop: Arc<AtomicBool>,
    threads: Vec<JoinHandle<()>>,
}

/// Batches that wait for the trainer, at most.
const AHEAD: usize = 4;

impl Loader {
    /// Starts `threads` threads at batch number `first`.
    pub fn new(draw: &Draw, first: u64, threads: usize) -> Result<Self, TrainError> {
        let (sender, receiver) = sync_channel(AHEAD);
        let (counter, stop) = (Arc::new(AtomicU64::new(first)), Arc::new(AtomicBool::new(false)));
        let mut handles = Vec::new();
        for i in 0..threads.max(1) {
            let (sender, counter, stop, draw) = (sender.clone(), counter.clone(), stop.clone(), draw.clone());
            let work = move || {
                while !stop.load(Ordering::Relaxed) {
                    let number = counter.fetch_add(1, Ordering::Relaxed);
                    if sender.send((number, draw(number))).is_err() {
                        break;
                    }
                }
            };
            let handle = Builder::new().name(format!("loader-{i}")).spawn(work);
            handles.push(handle.map_err(|e| TrainError::Data { why: e.to_string() })?);
        }
        Ok(Self { receiver: Some(receiver), early: BTreeMap::new(), next: first, stop, threads: handles })
    }

    /// The next batch in order; waits for it if it must.
    pub fn next_batch(&mut self) -> Result<Batch, TrainError> {
        loop {
            if let Some(batch) = self.early.remove(&self.next) {
                self.next += 1;
                return batch;
            }
            let received = self.receiver.as_ref().and_then(|r| r.recv().ok());
            let (number, batch) = received
                .ok_or_else(|| TrainError::Data { why: "the data engine stopped: its threads ended".into() })?;
            self.early.insert(number, batch);
        }
    }
}

impl Drop for Loader {
    fn drop(&mut self) {
        self.stop.store(true, Ordering::Relaxed);
        // Closing the channel wakes the threads that wait to hand over.
        self.receiver = None;
        for thread in self.threads.drain(..) {
            // A loader that panicked has said so; there is nothing left to do for it.
            drop(thread.join());
        }
    }
}

#[cfg(test)]
pub(crate) mod tests {
    use super::*;
    use crate::nets::REFERENCE;

    /// Small random batches with true depths that follow the picture's brightness.
    pub(crate) fn toy(samples: usize, size: (usize, usize)) -> Draw {
        Arc::new(move |number| {
            let maps = Maps { samples, views: vec![0, REFERENCE, 37], height: size.1, width: size.0 };
            let mut rng = Rng::new(5, number);
            let views: Vec<f32> = (0..3 * maps.len()).map(|_| rng.unit()).collect();
            let truth =
                (0..maps.len()).map(|i| views[i / maps.plane() * 3 * maps.plane() + i % maps.plane()] - 0.5).collect();
            Ok(Batch {
                first_sample: number * samples as u64,
                views,
                truth,
                yx: vec![[-1.0, 1.0, -1.0, 1.0]; samples],
                worth: vec![1.0; samples],
                subjects: vec![Vec::new(); samples],
                maps,
            })
        })
    }

    #[test]
    fn batches_come_in_order_whichever_thread_made_them() {
        let draw = toy(1, (4, 4));
        let mut loader = Loader::new(&draw, 3, 3).unwrap();
        for number in 3..20 {
            assert_eq!(loader.next_batch().unwrap(), draw(number).unwrap());
        }
    }

    #[test]
    fn the_photo_is_the_reference_view_wherever_it_stands() {
        let batch = toy(2, (2, 2))(0).unwrap();
        assert_eq!(batch.photos()[..12], batch.views[12..24]);
        assert_eq!(batch.photos()[12..], batch.views[48..60]);
    }

    #[test]
    fn coordinates_run_from_minus_one_to_one() {
        let input = toy(1, (4, 2))(0).unwrap().net_input(true);
        assert_eq!(input[24..32], [-1.0, -1.0, -1.0, -1.0, 1.0, 1.0, 1.0, 1.0]);
        assert_eq!((input[32], input[35], input[36]), (-1.0, 1.0, -1.0));
    }

    #[test]
    fn coordinates_are_taken_from_a_part_of_the_photos_and_colours_from_none() {
        let input = vec![0.5; 100 * 5 * 6];
        let mut dropped = input.clone();
        drop_coordinates(&mut dropped, 5, 6, 0.3, &mut Rng::new(3, 0));
        let photos = || dropped.chunks(5 * 6);
        assert!(photos().all(|photo| photo[..18] == input[..18]));
        let without = photos().filter(|photo| photo[18..].iter().all(|c| *c == 0.0)).count();
        let with = photos().filter(|photo| photo[18..] == input[..12]).count();
        assert_eq!(without + with, 100);
        assert!((15..45).contains(&without), "{without}");
        let mut colours = vec![0.5; 3 * 6];
        drop_coordinates(&mut colours, 3, 6, 1.0, &mut Rng::new(3, 0));
        assert!(colours.iter().all(|c| *c == 0.5));
    }

    #[test]
    fn blank_patches_leave_coordinates_and_most_of_the_photo() {
        let input: Vec<f32> = (0..4 * 5 * 400).map(|i| i as f32).collect();
        let mut blanked = input.clone();
        blank_patches(&mut blanked, 5, [20, 20], 1.0, &mut Rng::new(3, 0));
        for (before, after) in input.chunks(400).zip(blanked.chunks(400)).skip(3).step_by(5) {
            assert_eq!(before, after);
        }
        for (before, after) in input.chunks(5 * 400).zip(blanked.chunks(5 * 400)) {
            let changed = before.iter().zip(after).filter(|(a, b)| a != b).count();
            assert!((12..3 * 160).contains(&changed), "{changed}");
        }
        let mut none = input.clone();
        blank_patches(&mut none, 5, [20, 20], 0.0, &mut Rng::new(3, 0));
        assert_eq!(none, input);
    }
}
