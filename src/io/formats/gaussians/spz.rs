//! Packed Gaussian splats: SPZ of Niantic (2024), versions 2 and 3, a gzip stream of fixed-point numbers.
//!
//! Behind a head of 16 bytes lie, each for all Gaussians: places (three signed numbers of 24 bits), opacities (a byte), constant
//! colours, logarithms of the sizes, rotations, and the harmonics, coefficient after coefficient with its three channels. Axes are
//! right, up, back; the scene's are right, down, front, as in a PLY.

use std::io::Read as _;

use flate2::read::GzDecoder;
use glam::{Quat, Vec3};

use super::read::Read;
use crate::io::Problem;
use crate::splats::{Blend, Cloud, Gaussian, harmonics};

pub(super) const NAME: &str = "SPZ";
/// What `info` says of it.
pub(super) const FORMAT: &str = "Gaussian splats (SPZ)";
/// What a gzip stream begins with.
const GZIP: [u8; 3] = [0x1f, 0x8b, 8];
/// What the unpacked file begins with, and the length of its head.
const MAGIC: &[u8] = b"NGSP";
const HEAD: usize = 16;
/// Numbers of a scene are never packed to less than one in so many bytes.
const MOST_PACKED: usize = 200;
/// A colour is stored as this share of its harmonic, around the middle.
const COLOUR: f32 = 0.15;
/// Signs of the harmonics behind the constant one where y and z turn round, to degree 3.
const TURNED: [f32; 15] = [-1., -1., 1., -1., 1., 1., -1., 1., -1., 1., -1., -1., 1., -1., 1.];

pub(super) fn begins(bytes: &[u8]) -> bool {
    bytes.starts_with(&GZIP)
}

/// Where each kind of number begins, and how many of them a Gaussian has.
struct Head {
    version: u32,
    count: usize,
    /// Degree of the harmonics in the file.
    degree: usize,
    fraction_bits: u8,
}

impl Head {
    fn of(bytes: &[u8]) -> Result<Self, Problem> {
        let head = bytes.get(..HEAD).ok_or(Problem::Truncated { format: NAME })?;
        let number = |at: usize| u32::from_le_bytes([head[at], head[at + 1], head[at + 2], head[at + 3]]);
        if !head.starts_with(MAGIC) {
            let reason = "it is a packed file of something else".to_owned();
            return Err(Problem::Unsupported { format: NAME, reason, advice: "unpack it, and open what is in it" });
        }
        let head =
            Self { version: number(4), count: number(8) as usize, degree: head[12].into(), fraction_bits: head[13] };
        let refused = match head {
            Self { version: 2 | 3, count: 1..=Cloud::MOST, degree: 0..=4, fraction_bits: 0..=23 } => return Ok(head),
            Self { version: 2 | 3, count: 0, .. } => "it has no points".to_owned(),
            Self { version: 2 | 3, count, .. } if count > Cloud::MOST => {
                format!("it says {count} Gaussians, where {} are the most", Cloud::MOST)
            }
            Self { version: 2 | 3, .. } => "its head says what none of its kind says".to_owned(),
            Self { version, .. } => format!("it is of version {version}, and 2 and 3 are known"),
        };
        Err(Problem::Unsupported { format: NAME, reason: refused, advice: "save it as PLY" })
    }

    /// Harmonics of a Gaussian beside the constant one.
    fn harmonics(&self) -> usize {
        (self.degree + 1).pow(2) - 1
    }

    fn rotation_bytes(&self) -> usize {
        if self.version == 2 { 3 } else { 4 }
    }
}

/// Reads a whole file.
pub(super) fn read(bytes: &[u8]) -> Result<Read, Problem> {
    let damaged = |error: std::io::Error| match error.kind() {
        std::io::ErrorKind::UnexpectedEof => Problem::Truncated { format: NAME },
        _ => Problem::damaged(NAME, "it cannot be unpacked"),
    };
    let mut packed = GzDecoder::new(bytes);
    let mut head = Vec::new();
    packed.by_ref().take(HEAD as u64).read_to_end(&mut head).map_err(damaged)?;
    let head = Head::of(&head)?;
    let of_each = 16 + head.rotation_bytes() + 3 * head.harmonics();
    if head.count * of_each > bytes.len().saturating_mul(MOST_PACKED) {
        return Err(Problem::Truncated { format: NAME });
    }
    let mut take = |of_each: usize| -> Result<Vec<u8>, Problem> {
        let length = head.count * of_each;
        let mut data = Vec::new();
        packed.by_ref().take(length as u64).read_to_end(&mut data).map_err(damaged)?;
        if data.len() == length { Ok(data) } else { Err(Problem::Truncated { format: NAME }) }
    };
    let columns = Columns {
        places: take(9)?,
        opacities: take(1)?,
        colours: take(3)?,
        sizes: take(3)?,
        rotations: take(head.rotation_bytes())?,
        harmonics: take(3 * head.harmonics())?,
        head,
    };
    // The stream's checksum stands at its end, behind whatever later versions add.
    let most = bytes.len().saturating_mul(MOST_PACKED) as u64;
    std::io::copy(&mut packed.take(most), &mut std::io::sink()).map_err(damaged)?;
    let (degree, count) = (columns.head.degree.min(harmonics::MOST_DEGREE), columns.head.count);
    let mut cloud = Cloud::with_room(degree, count, Blend::default());
    for i in 0..count {
        let gaussian = columns.gaussian(i);
        if gaussian.is_sound() {
            cloud.push(gaussian, &columns.coefficients(i));
        }
    }
    if cloud.gaussians.is_empty() {
        return Err(Problem::damaged(NAME, "none of its Gaussians can be drawn"));
    }
    let mut warnings = Vec::new();
    if columns.head.degree > degree {
        warnings.push(format!("harmonics beyond degree {degree} are left out"));
    }
    Ok(Read { cloud, camera: None, steps: None, in_metres: false, warnings })
}

struct Columns {
    head: Head,
    places: Vec<u8>,
    opacities: Vec<u8>,
    colours: Vec<u8>,
    sizes: Vec<u8>,
    rotations: Vec<u8>,
    harmonics: Vec<u8>,
}

impl Columns {
    fn gaussian(&self, i: usize) -> Gaussian {
        let unit = 1.0 / (1u32 << self.head.fraction_bits) as f32;
        let place = |axis: usize| {
            let at = 9 * i + 3 * axis;
            // The sign is the highest of 24 bits.
            let fixed = i32::from_le_bytes([0, self.places[at], self.places[at + 1], self.places[at + 2]]) >> 8;
            fixed as f32 * unit
        };
        let size = |axis: usize| (f32::from(self.sizes[3 * i + axis]) / 16.0 - 10.0).exp();
        let bytes = self.head.rotation_bytes();
        let [x, y, z, w] = rotation(&self.rotations[i * bytes..(i + 1) * bytes]);
        Gaussian {
            center: Vec3::new(place(0), -place(1), -place(2)),
            scale: Vec3::new(size(0), size(1), size(2)),
            rotation: Quat::from_xyzw(x, -y, -z, w).normalize(),
            opacity: f32::from(self.opacities[i]) / 255.0,
        }
    }

    fn coefficients(&self, i: usize) -> [[f32; 3]; 16] {
        let mut all = [[0.0; 3]; 16];
        all[0] = [0, 1, 2].map(|c| (f32::from(self.colours[3 * i + c]) / 255.0 - 0.5) / COLOUR);
        let count = self.head.harmonics();
        let own = self.harmonics[3 * count * i..3 * count * (i + 1)].as_chunks::<3>().0;
        for ((to, from), sign) in all[1..].iter_mut().zip(own).zip(TURNED) {
            *to = from.map(|value| sign * (f32::from(value) - 128.0) / 128.0);
        }
        all
    }
}

/// A quaternion, x y z w: its first three numbers, or all but the largest.
fn rotation(bytes: &[u8]) -> [f32; 4] {
    let rest = |known: &[f32]| (1.0 - known.iter().map(|value| value * value).sum::<f32>()).max(0.0).sqrt();
    let mut all = [0.0; 4];
    if let &[x, y, z] = bytes {
        let known = [x, y, z].map(|value| f32::from(value) / 127.5 - 1.0);
        all[..3].copy_from_slice(&known);
        all[3] = rest(&known);
        return all;
    }
    let mut packed = bytes.iter().rev().fold(0u32, |all, byte| (all << 8) | u32::from(*byte));
    let largest = (packed >> 30) as usize;
    for value in (0..4).rev().filter(|i| *i != largest) {
        let size = (packed & 511) as f32 / 511.0 * std::f32::consts::FRAC_1_SQRT_2;
        all[value] = if packed & 512 == 0 { size } else { -size };
        packed >>= 10;
    }
    all[largest] = rest(&all);
    all
}

#[cfg(test)]
mod tests {
    use std::io::Write;

    use super::*;

    /// A packed file of some Gaussians that stand at a place, made by hand from the format's description.
    fn file(version: u32, count: u32, degree: u8, rotation: &[u8]) -> Vec<u8> {
        let place = |value: f32| ((value * 4096.0).round() as i32).to_le_bytes()[..3].to_vec();
        let mut bytes = [MAGIC, &version.to_le_bytes(), &count.to_le_bytes(), &[degree, 12, 0, 0]].concat();
        let n = count as usize;
        bytes.extend([place(0.5), place(0.25), place(-2.0)].concat().repeat(n));
        bytes.extend([255].repeat(n));
        bytes.extend([166, 128, 89].repeat(n));
        bytes.extend([112, 128, 144].repeat(n));
        bytes.extend(rotation.repeat(n));
        bytes.extend([192].repeat(n * 3 * ((usize::from(degree) + 1).pow(2) - 1)));
        let mut packed = flate2::write::GzEncoder::new(Vec::new(), flate2::Compression::fast());
        packed.write_all(&bytes).unwrap();
        packed.finish().unwrap()
    }

    #[test]
    fn both_versions_say_places_sizes_turns_and_colours() {
        // A turn about x by 60°: (0.5, 0, 0, 0.866). Version 3 leaves out the last one, which is the largest.
        let third = (3u32 << 30) | ((0.5 / std::f32::consts::FRAC_1_SQRT_2 * 511.0).round() as u32) << 20;
        for (version, rotation) in [(2, vec![191, 128, 128]), (3, third.to_le_bytes().to_vec())] {
            let read = read(&file(version, 3, 1, &rotation)).unwrap();
            let one = &read.cloud.gaussians[2];
            assert_eq!(one.center, Vec3::new(0.5, -0.25, 2.0), "down and in front");
            assert!((one.scale - Vec3::new(-3.0, -2.0, -1.0).map(f32::exp)).abs().max_element() < 1e-5);
            assert!(one.rotation.abs_diff_eq(Quat::from_rotation_x(std::f32::consts::FRAC_PI_3), 0.01), "{one:?}");
            let [constant, a, b, c] = read.cloud.coefficients(2) else { panic!("degree 1") };
            assert!((constant[0] - 1.0065).abs() < 1e-3 && constant[2] < -1.0, "{constant:?}");
            assert_eq!([a[0], b[0], c[0]], [-0.5, -0.5, 0.5]);
        }
    }

    #[test]
    fn what_is_no_such_file_is_told_in_a_sentence() {
        let whole = file(2, 5, 0, &[128, 128, 128]);
        let why = |bytes: &[u8]| read(bytes).unwrap_err().to_string();
        assert!(why(&file(4, 5, 0, &[0; 4])).contains("version 4"));
        assert!(why(&file(2, 0, 0, &[])).contains("no points"));
        assert!(matches!(read(&whole[..whole.len() / 2]), Err(Problem::Truncated { .. } | Problem::Damaged { .. })));
        let mut other = flate2::write::GzEncoder::new(Vec::new(), flate2::Compression::fast());
        other.write_all(&[b'x'; 64]).unwrap();
        assert!(why(&other.finish().unwrap()).contains("something else"));
    }
}
