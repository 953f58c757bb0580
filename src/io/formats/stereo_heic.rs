//! Both eyes as a spatial photo: two HEVC pictures in one HEIC, with what headsets ask of the cameras.
//!
//! Boxes are those of ISO/IEC 23008-12: each eye is a grid of tiles, as phones write them, and a stereo-pair group `ster`
//! holds both, left first. What Apple's headset writes of its cameras stands in `uuid` boxes with the content that the
//! standard later gave to `cmin` and `cmex`; so it does here. Who does not know the group sees the left eye's picture.

use std::io::Write;
use std::path::Path;
use std::sync::atomic::{AtomicU32, Ordering};

use heifer::EncodeOptions;
use heifer::heifer_isobmff::{BoxIter, HeifFile};
use rayon::prelude::*;

use super::out;
use crate::field::{Picture, Size};
use crate::io::save::SaveError;
use crate::job::{Job, Stage};

/// Sides of a tile, in pixels.
const TILE: u32 = 512;
/// More than a tile takes in the tables.
const TABLES_BYTES: usize = 512;
/// Of the encoder, up to 100: some 47 dB.
const QUALITY: u8 = 90;
/// sRGB with the matrix of BT.601, full range: what the encoder makes.
const COLORS: &[u8] = b"nclx\0\x01\0\x0d\0\x06\x80";
/// Of the camera within (`cmin`), of its place (`cmex`), and how much the eyes are shifted, in 10000ths of the width.
const INTRINSICS: u128 = 0x22cc04c7_d6d9_4e07_9d90_4eb6ecbaf3a3;
const EXTRINSICS: u128 = 0x4363e914_5b7d_4aab_97ae_bea69803b434;
const SHIFT: u128 = 0xde225085_36cb_4365_8743_2f8705e7c78a;
/// Numbers of the camera within are shares of the width (and height), times 2 to this.
const PRECISION: u32 = 24;

/// The cameras of both eyes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Eyes {
    /// Focal length over the picture's width.
    pub focal: f32,
    /// How far they stand apart.
    pub apart_m: f32,
}

/// Writes two pictures of one size, left eye first.
///
/// # Errors
/// [`SaveError`]; then nothing has been written.
pub fn write(path: &Path, [left, right]: [&Picture; 2], eyes: Eyes, job: &Job) -> Result<(), SaveError> {
    let fail = |why: String| SaveError::Encode { why, path: path.to_owned() };
    let even = left.size.map(|side| side.next_multiple_of(2));
    if even.iter().any(|side| u16::try_from(*side).is_err()) {
        return Err(fail("a spatial photo is at most 65534 pixels wide; write a smaller one (--size)".to_owned()));
    }
    let tiles = encoded([left, right], job)?.map_err(fail)?;
    if u32::try_from(tiles.iter().map(|tile| tile.data.len() + TABLES_BYTES).sum::<usize>()).is_err() {
        return Err(fail("a spatial photo has at most 4 GB; write a smaller one (--size)".to_owned()));
    }
    let file = File { size: even, tiles, eyes };
    out::single(path, |out| file.parts().iter().try_for_each(|part| out.write_all(part)))
}

/// A tile as HEVC.
#[derive(Clone, Debug)]
struct Tile {
    /// How it is decoded (`hvcC`, without its head).
    config: Vec<u8>,
    data: Vec<u8>,
}

/// The tiles of both pictures, row by row; left ones first. The outer result is a stopped job's.
fn encoded(pictures: [&Picture; 2], job: &Job) -> Result<Result<Vec<Tile>, String>, SaveError> {
    let done = AtomicU32::new(0);
    let [columns, rows] = pictures[0].size.map(|side| side.div_ceil(TILE));
    let (all, each) = (2 * columns * rows, columns * rows);
    let stored = pictures.map(Picture::to_srgb8);
    let tile = |number: u32| {
        job.advance(Stage::Save, done.fetch_add(1, Ordering::Relaxed), all)?;
        let eye = (number / each) as usize;
        let at = [number % each % columns, number % each / columns].map(|place| place * TILE);
        Ok(encode(&cut(&stored[eye], pictures[eye].size, at)))
    };
    (0..all).into_par_iter().map(tile).collect::<Result<Vec<_>, SaveError>>().map(|tiles| tiles.into_iter().collect())
}

/// A tile's pixels; beyond the picture its edge goes on.
fn cut(rgba: &[u8], [width, height]: Size, at: [u32; 2]) -> Vec<u8> {
    let mut tile = Vec::with_capacity((TILE * TILE * 4) as usize);
    for y in at[1]..at[1] + TILE {
        let row = &rgba[(y.min(height - 1) * width * 4) as usize..][..width as usize * 4];
        for x in at[0]..at[0] + TILE {
            tile.extend_from_slice(&row[x.min(width - 1) as usize * 4..][..4]);
        }
    }
    tile
}

fn encode(rgba: &[u8]) -> Result<Tile, String> {
    let options = EncodeOptions { quality: QUALITY, max_threads: 1 };
    let why = |error: heifer::Error| format!("the picture cannot be encoded as HEVC: {error}");
    let whole = heifer::encode_rgba8(TILE, TILE, rgba, &options).map_err(why)?;
    let inside = |data, kind: &[u8; 4]| BoxIter::new(data).flatten().find(|b| b.header.box_type.0 == *kind);
    let meta = inside(&whole, b"meta").and_then(|meta| meta.content.get(4..));
    let config = meta.and_then(|meta| inside(meta, b"iprp")).and_then(|all| inside(all.content, b"ipco"));
    let config = config.and_then(|all| inside(all.content, b"hvcC")).map(|config| config.content.to_vec());
    let file = HeifFile::parse(&whole).ok();
    let data = file.and_then(|file| file.item_data(file.primary_id).ok().map(std::borrow::Cow::into_owned));
    let broken = "the picture cannot be encoded as HEVC: the encoder wrote something else";
    config.zip(data).map(|(config, data)| Tile { config, data }).ok_or_else(|| broken.to_owned())
}

/// All that is written. Items are numbered from 1: the tiles, then the left eye's grid and the right one's.
struct File {
    size: Size,
    tiles: Vec<Tile>,
    eyes: Eyes,
}

impl File {
    /// The file's boxes, and its data.
    fn parts(&self) -> Vec<Vec<u8>> {
        let kind = boxed(b"ftyp", &[b"heic", &[0; 4], b"mif1heic"]);
        let data = self.data();
        let head = [&(data.iter().map(Vec::len).sum::<usize>() as u32 + 8).to_be_bytes()[..], b"mdat"].concat();
        // The places of the data do not change how long the tables are.
        let first = kind.len() + self.meta(0).len() + head.len();
        [kind, self.meta(first as u32), head].into_iter().chain(data).collect()
    }

    /// What the items hold, in their order.
    fn data(&self) -> Vec<Vec<u8>> {
        let [columns, rows] = self.size.map(|side| side.div_ceil(TILE) as u8 - 1);
        let [width, height] = self.size.map(|side| (side as u16).to_be_bytes());
        let grid = [&[0, 0, rows, columns][..], &width, &height].concat();
        self.tiles.iter().map(|tile| tile.data.clone()).chain([grid.clone(), grid]).collect()
    }

    fn grids(&self) -> [u16; 2] {
        let tiles = self.tiles.len() as u16;
        [tiles + 1, tiles + 2]
    }

    /// The tables; the data begins at a place of the file.
    fn meta(&self, first: u32) -> Vec<u8> {
        let [left, right] = self.grids();
        let handler = full(b"hdlr", 0, &[&[0; 4], b"pict", &[0; 13]]);
        let primary = full(b"pitm", 0, &[&left.to_be_bytes()]);
        // The group's number is none of the items'.
        let group = [u32::from(right) + 1, 2, left.into(), right.into()];
        let groups = boxed(b"grpl", &[&full(b"ster", 0, &[&numbers(group)])]);
        let tables = [self.items(), self.references(), self.properties(), groups, self.places(first)];
        full(b"meta", 0, &[&handler, &primary, &tables.concat()])
    }

    fn items(&self) -> Vec<u8> {
        let item = |(number, kind, flags): (u16, &[u8; 4], u32)| {
            full(b"infe", 2 << 24 | flags, &[&number.to_be_bytes(), &[0; 2], kind, &[0]])
        };
        // Tiles are hidden.
        let tiles = (1..=self.tiles.len() as u16).map(|number| (number, b"hvc1", 1));
        let all: Vec<u8> = tiles.chain(self.grids().map(|number| (number, b"grid", 0))).flat_map(item).collect();
        full(b"iinf", 0, &[&self.grids()[1].to_be_bytes(), &all])
    }

    /// Which tiles are which grid's.
    fn references(&self) -> Vec<u8> {
        let each = self.tiles.len() as u16 / 2;
        let made_of = |(number, first): (u16, u16)| {
            let tiles: Vec<u8> = (first..first + each).flat_map(u16::to_be_bytes).collect();
            boxed(b"dimg", &[&number.to_be_bytes(), &each.to_be_bytes(), &tiles])
        };
        let [left, right] = self.grids();
        full(b"iref", 0, &[&[(left, 1), (right, 1 + each)].map(made_of).concat()])
    }

    /// Sizes, colours, decoders and cameras, and what has which.
    fn properties(&self) -> Vec<u8> {
        let whole = 1.0f32 * (1 << PRECISION) as f32;
        let within = [self.eyes.focal * whole, 0.5 * whole, 0.5 * whole].map(|share| share as i32 as u32);
        let apart_um = (self.eyes.apart_m * 1e6).round() as i32 as u32;
        let mut boxes = vec![
            full(b"ispe", 0, &[&numbers([TILE, TILE])]),
            full(b"ispe", 0, &[&numbers(self.size)]),
            full(b"pixi", 0, &[&[3, 8, 8, 8]]),
            boxed(b"colr", &[COLORS]),
            named(INTRINSICS, PRECISION << 8, &numbers(within)),
            // The left eye stands where the world begins, the right one so much to the right.
            named(EXTRINSICS, 0, &[]),
            named(EXTRINSICS, 1, &numbers([apart_um])),
            boxed(b"uuid", &[&SHIFT.to_be_bytes(), &[0; 4]]),
        ];
        let mut configs: Vec<&[u8]> = Vec::new();
        let mut table = Vec::new();
        for (number, tile) in (1u16..).zip(&self.tiles) {
            let known = configs.iter().position(|config| *config == tile.config);
            let config = known.unwrap_or(configs.len());
            if known.is_none() {
                configs.push(&tile.config);
            }
            // Who cannot decode must not show it.
            table.extend(has(number, &[0x80 | (boxes.len() + 1 + config) as u8, 1, 4]));
        }
        boxes.extend(configs.iter().map(|config| boxed(b"hvcC", &[config])));
        let [left, right] = self.grids();
        table.extend(has(left, &[2, 3, 4, 5, 6]));
        table.extend(has(right, &[2, 3, 4, 5, 7, 8]));
        let associations = full(b"ipma", 0, &[&u32::from(right).to_be_bytes(), &table]);
        boxed(b"iprp", &[&boxed(b"ipco", &[&boxes.concat()]), &associations])
    }

    /// Where each item's data lies.
    fn places(&self, first: u32) -> Vec<u8> {
        let mut at = first;
        let place = |(number, data): (u16, Vec<u8>)| {
            let from = at;
            at += data.len() as u32;
            [&number.to_be_bytes()[..], &[0, 0, 0, 1], &numbers([from, data.len() as u32])].concat()
        };
        let all: Vec<u8> = (1u16..).zip(self.data()).flat_map(place).collect();
        full(b"iloc", 0, &[&[0x44, 0], &self.grids()[1].to_be_bytes(), &all])
    }
}

/// The properties of an item, by their numbers from 1.
fn has(item: u16, properties: &[u8]) -> Vec<u8> {
    [&item.to_be_bytes()[..], &[properties.len() as u8], properties].concat()
}

fn numbers<const N: usize>(values: [u32; N]) -> Vec<u8> {
    values.iter().flat_map(|value| value.to_be_bytes()).collect()
}

fn boxed(kind: &[u8; 4], content: &[&[u8]]) -> Vec<u8> {
    let content = content.concat();
    [&(content.len() as u32 + 8).to_be_bytes()[..], kind, &content].concat()
}

/// A box with a version and flags.
fn full(kind: &[u8; 4], flags: u32, content: &[&[u8]]) -> Vec<u8> {
    boxed(kind, &[&flags.to_be_bytes(), &content.concat()])
}

/// A box with a name of its own, a version and flags.
fn named(name: u128, flags: u32, content: &[u8]) -> Vec<u8> {
    boxed(b"uuid", &[&name.to_be_bytes(), &flags.to_be_bytes(), content])
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::io::{DepthKind, Opened, open, several};
    use crate::job::Cancel;

    /// A ground of leaves, and a square before it that stands `shift` px farther to the left.
    fn eye(size: Size, shift: f32) -> Picture {
        let [w, h] = size;
        // Of cells that do not repeat.
        let leaf = |x: f32, y: f32, side: f32| {
            let cell = (x / side).floor() * 12.989 + (y / side).floor() * 78.233;
            (cell.sin() * 43758.547).fract().abs()
        };
        let light = |i: u32| {
            let (x, y) = ((i % w) as f32, (i / w) as f32);
            let (near, is_near) = (x + shift, y > 150.0 && y < 400.0 && x + shift > 200.0 && x + shift < 420.0);
            if is_near { [leaf(near, y, 8.0), 0.2, 0.1] } else { [0.1, leaf(x, y, 9.0), leaf(y, x, 12.0)] }
        };
        Picture { size, rgb_linear: (0..w * h).flat_map(light).collect() }
    }

    #[test]
    fn both_eyes_come_back_with_their_depth() {
        let dir = tempfile::tempdir().unwrap();
        let path = dir.path().join("pair.heic");
        let job = Job { cancel: &Cancel::default(), sink: &() };
        // Two by two tiles, of odd sides.
        let pictures = [eye([601, 517], 0.0), eye([601, 517], 9.0)];
        let eyes = Eyes { focal: 0.75, apart_m: 0.004 };
        write(&path, [&pictures[0], &pictures[1]], eyes, &job).unwrap();
        let Opened::Photo(file) = open(&path, &job).unwrap() else { panic!("it is a photo") };
        assert_eq!((file.photo.size(), &file.warnings), ([602, 518], &Vec::new()));
        let depth = file.depth.expect("the other eye gives depth");
        assert_eq!(depth.kind, DepthKind::SpatialPair);
        let (map, [w, h]) = (depth.map.nearness(), depth.map.size());
        let at = |x: u32, y: u32| map[(y * h / 518 * w + x * w / 602) as usize];
        assert!(at(310, 280) > at(80, 280), "the square is nearer: {} and {}", at(310, 280), at(80, 280));
        // Colours are kept at half the size: light says how good it is.
        let light = |p: &[u8]| 0.299 * f64::from(p[0]) + 0.587 * f64::from(p[1]) + 0.114 * f64::from(p[2]);
        let psnr = |want: &[u8], have: &[u8]| {
            let rows = want.chunks_exact(601 * 4).zip(have.chunks_exact(602 * 4));
            let pixels = rows.flat_map(|(a, b)| a.chunks_exact(4).zip(b.chunks_exact(4)));
            let squares = pixels.map(|(a, b)| (light(a) - light(b)).powi(2)).sum::<f64>();
            10.0 * (255.0f64.powi(2) * 601.0 * 517.0 / squares).log10()
        };
        let eyes = several::photos(&path, &job).unwrap();
        assert!(eyes.len() == 2 && eyes[0].photo.srgb8() == file.photo.srgb8());
        for (eye, picture) in eyes.iter().zip(&pictures) {
            let psnr = psnr(&picture.to_srgb8(), eye.photo.srgb8());
            assert!(psnr > 33.0, "{psnr} dB");
        }
    }

    #[test]
    fn a_stopped_job_writes_nothing() {
        let dir = tempfile::tempdir().unwrap();
        let path = dir.path().join("pair.heic");
        let cancel = Cancel::default();
        cancel.cancel();
        let picture = eye([40, 30], 0.0);
        let eyes = Eyes { focal: 1.0, apart_m: 0.06 };
        let done = write(&path, [&picture, &picture], eyes, &Job { cancel: &cancel, sink: &() });
        assert!(matches!(done, Err(SaveError::Cancelled)) && !path.exists());
    }
}
