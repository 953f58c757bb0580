//! The Gaussians of a file, its camera, and what a person should know of both.

use glam::{Mat3, Quat, Vec2, Vec3};
use rayon::prelude::*;

use super::header::{self, Element, Header, Kind, Property};
use super::{CAMERA, NAME};
use crate::io::Problem;
use crate::splats::{Blend, Camera, Cloud, Gaussian, harmonics};

/// The longest side of the picture of a file that names its size, in pixels.
const MOST_PX: u32 = 1600;
/// Logarithms of scales beyond this are no sizes.
const MOST_SCALE: f32 = 60.0;
/// Gaussians that are read at once.
const CHUNK: usize = 4096;

/// What a file holds.
#[derive(Debug)]
pub(super) struct Read {
    pub(super) cloud: Cloud,
    pub(super) camera: Option<Camera>,
    /// View step and inverse distance of disparity 0, where the file says them.
    pub(super) steps: Option<[f32; 2]>,
    /// Whether its unit is the metre.
    pub(super) in_metres: bool,
    pub(super) warnings: Vec<String>,
}

/// Reads a whole file.
pub(super) fn read(bytes: &[u8]) -> Result<Read, Problem> {
    let header = header::read(bytes)?;
    let mut body = Body { kind: header.kind, bytes: &bytes[header.end..] };
    let (mut cloud, mut extras, mut warnings) = (None, Extras::default(), Vec::new());
    for element in &header.elements {
        if element.name == "vertex" {
            no_lists(element)?;
            let columns = Columns::of(element, &header, &mut warnings)?;
            cloud = Some(gaussians(&columns, body.take(element)?, header.kind, &mut warnings)?);
        } else if cloud.is_none() {
            body.take(element)?;
        } else {
            // What follows is extra: the scene does without.
            match (element.has_list, body.take(element)) {
                (false, Ok(rows)) => extras.add(element, rows, header.kind),
                _ => break,
            }
        }
    }
    let mut cloud = cloud.ok_or_else(no_points)?;
    cloud.blend = extras.blend();
    let (camera, steps) = match own_camera(&header.comments) {
        Some((camera, steps)) => (Some(camera), Some(steps)),
        None => (extras.camera(&mut warnings), None),
    };
    let in_metres = steps.is_none() && camera.is_some();
    Ok(Read { cloud, camera, steps, in_metres, warnings })
}

fn no_points() -> Problem {
    Problem::Unsupported {
        format: NAME,
        reason: "it has no points".to_owned(),
        advice: "open one that holds Gaussian splats",
    }
}

/// A list has no length that is known beforehand.
fn no_lists(element: &Element) -> Result<(), Problem> {
    if !element.has_list {
        return Ok(());
    }
    Err(Problem::Unsupported {
        format: NAME,
        reason: format!("lists of {} stand before what could be Gaussians", element.name),
        advice: "save the points alone",
    })
}

/// What is left of the file behind its head.
struct Body<'a> {
    kind: Kind,
    bytes: &'a [u8],
}

impl<'a> Body<'a> {
    /// The bytes of all of an element.
    fn take(&mut self, element: &Element) -> Result<&'a [u8], Problem> {
        no_lists(element)?;
        let length = match self.kind {
            Kind::Binary => element.count.checked_mul(element.stride()),
            Kind::Text => lines(self.bytes, element.count),
        };
        let length = length.filter(|length| *length <= self.bytes.len());
        let (taken, left) = self.bytes.split_at(length.ok_or(Problem::Truncated { format: NAME })?);
        self.bytes = left;
        Ok(taken)
    }
}

/// Bytes of so many lines; the last one may have no end.
fn lines(bytes: &[u8], count: usize) -> Option<usize> {
    let mut at = 0;
    for _ in 0..count {
        let rest = bytes.get(at..).filter(|rest| !rest.is_empty())?;
        at += rest.iter().position(|byte| *byte == b'\n').map_or(rest.len(), |end| end + 1);
    }
    Some(at)
}

/// Where in an element the numbers of a Gaussian stand.
struct Columns<'a> {
    element: &'a Element,
    /// Place, constant colour, opacity, scale, rotation.
    own: Vec<&'a Property>,
    /// The rest of the harmonics, channel after channel.
    rest: Vec<&'a Property>,
    degree: usize,
}

const OWN: [&str; 14] = [
    "x", "y", "z", "f_dc_0", "f_dc_1", "f_dc_2", "opacity", "scale_0", "scale_1", "scale_2", "rot_0", "rot_1", "rot_2",
    "rot_3",
];

impl<'a> Columns<'a> {
    fn of(element: &'a Element, header: &Header, warnings: &mut Vec<String>) -> Result<Self, Problem> {
        let unsupported = |reason: String, advice| Problem::Unsupported { format: NAME, reason, advice };
        if element.property("packed_position").is_some() {
            return Err(unsupported("its Gaussians are packed".to_owned(), "save it as an uncompressed PLY"));
        }
        let missing = OWN.iter().filter(|name| element.property(name).is_none()).copied().collect::<Vec<_>>();
        if !missing.is_empty() {
            let what =
                if header.elements.iter().any(|other| other.name == "face") { "a mesh" } else { "a cloud of points" };
            let reason = format!("it holds {what} and no Gaussian splats: {} is missing", missing[0]);
            return Err(unsupported(reason, "open one that a program for Gaussian splats wrote"));
        }
        match element.count {
            0 => return Err(no_points()),
            count if count > Cloud::MOST => {
                let reason = format!("it says {count} Gaussians, where {} are the most", Cloud::MOST);
                return Err(unsupported(reason, "thin it out first"));
            }
            _ => {}
        }
        let own = OWN.iter().filter_map(|name| element.property(name)).collect();
        let rest: Vec<_> = (0..45).map_while(|i| element.property(&format!("f_rest_{i}"))).collect();
        let degree =
            (0..=harmonics::MOST_DEGREE).rev().find(|degree| 3 * (harmonics::count(*degree) - 1) == rest.len());
        if degree.is_none() {
            warnings
                .push(format!("its colours are the same from all sides — {} harmonics are of no degree", rest.len()));
        }
        Ok(Self { element, own, rest, degree: degree.unwrap_or(0) })
    }

    /// One Gaussian with its harmonics.
    fn gaussian(&self, value: &impl Fn(&Property) -> f32, coefficients: &mut [[f32; 3]; 16]) -> Gaussian {
        let own = |i: usize| value(self.own[i]);
        let three = |i: usize| Vec3::new(own(i), own(i + 1), own(i + 2));
        let per_channel = harmonics::count(self.degree) - 1;
        coefficients[0] = three(3).to_array();
        for i in 0..per_channel {
            coefficients[i + 1] = [0, 1, 2].map(|channel| value(self.rest[channel * per_channel + i]));
        }
        let scale = three(7);
        let is_size = scale.abs().max_element() < MOST_SCALE;
        Gaussian {
            center: three(0),
            scale: if is_size { scale.map(f32::exp) } else { Vec3::NAN },
            rotation: Quat::from_xyzw(own(11), own(12), own(13), own(10)).normalize(),
            opacity: 1.0 / (1.0 + (-own(6)).exp()),
        }
    }
}

fn gaussians(columns: &Columns, rows: &[u8], kind: Kind, warnings: &mut Vec<String>) -> Result<Cloud, Problem> {
    let parts: Vec<Result<Cloud, Problem>> = match kind {
        Kind::Binary => {
            let stride = columns.element.stride();
            let read = |rows: &[u8]| Ok(some(columns, rows.chunks_exact(stride), of_bytes));
            rows.par_chunks(stride * CHUNK).map(read).collect()
        }
        Kind::Text => {
            let rows = numbers(rows, columns.element)?;
            let width = columns.element.properties.len();
            let read = |rows: &[f32]| Ok(some(columns, rows.chunks_exact(width), of_numbers));
            rows.par_chunks(width * CHUNK).map(read).collect()
        }
    };
    let mut cloud = Cloud::with_room(columns.degree, columns.element.count, Blend::default());
    for part in parts {
        cloud.append(part?);
    }
    let bad = columns.element.count - cloud.gaussians.len();
    if cloud.gaussians.is_empty() {
        return Err(Problem::damaged(NAME, "none of its Gaussians is made of numbers (NaN or infinity)"));
    }
    if bad > 0 {
        warnings
            .push(format!("{bad} of {} Gaussians are left out: they are not made of numbers", columns.element.count));
    }
    Ok(cloud)
}

fn of_bytes(row: &[u8], property: &Property) -> f32 {
    property.number.of(&row[property.at[0]..])
}

fn of_numbers(row: &[f32], property: &Property) -> f32 {
    row[property.at[1]]
}

/// The Gaussians of some rows that are made of numbers.
fn some<'r, T: 'r + ?Sized>(
    columns: &Columns,
    rows: impl Iterator<Item = &'r T>,
    value: fn(&T, &Property) -> f32,
) -> Cloud {
    let mut cloud = Cloud::with_room(columns.degree, CHUNK, Blend::default());
    let mut coefficients = [[0.0; 3]; 16];
    for row in rows {
        let gaussian = columns.gaussian(&|property: &Property| value(row, property), &mut coefficients);
        if gaussian.is_sound() && coefficients.as_flattened().iter().all(|value| value.is_finite()) {
            cloud.push(gaussian, &coefficients);
        }
    }
    cloud
}

/// All numbers of an element that is written as text.
fn numbers(rows: &[u8], element: &Element) -> Result<Vec<f32>, Problem> {
    let text = String::from_utf8_lossy(rows);
    let mut values = Vec::with_capacity(rows.len() / 4);
    for line in text.lines() {
        let before = values.len();
        // What is no number at all is not made of numbers: it is left out with its Gaussian.
        values.extend(line.split_ascii_whitespace().map(|word| word.parse().unwrap_or(f32::NAN)));
        if values.len() - before != element.properties.len() {
            return Err(Problem::damaged(NAME, format!("a line of {} has not all of its numbers", element.name)));
        }
    }
    Ok(values)
}

/// The camera of our own files: it stands at the origin.
fn own_camera(comments: &[String]) -> Option<(Camera, [f32; 2])> {
    let text = comments.iter().find_map(|comment| comment.strip_prefix(CAMERA))?;
    let values: Vec<f32> = text.split_whitespace().map_while(|word| word.parse().ok()).collect();
    let [focal, width, height, step, zero] = values.try_into().ok()?;
    let side = |px: f32| (16.0..=4096.0).contains(&px).then_some(px as u32);
    let size = [side(width)?, side(height)?];
    let is_good = (1.0..1e6).contains(&focal) && (0.0..1e6).contains(&step) && (-1e6..1e6).contains(&zero);
    is_good.then(|| (Camera::at_origin(focal, size), [step, zero]))
}

/// What SHARP writes behind the Gaussians.
#[derive(Default)]
struct Extras {
    extrinsic: Vec<f32>,
    intrinsic: Vec<f32>,
    image_size: Vec<f32>,
    color_space: Vec<f32>,
}

impl Extras {
    fn add(&mut self, element: &Element, rows: &[u8], kind: Kind) {
        let to = match element.name.as_str() {
            "extrinsic" => &mut self.extrinsic,
            "intrinsic" => &mut self.intrinsic,
            "image_size" => &mut self.image_size,
            "color_space" => &mut self.color_space,
            _ => return,
        };
        let (Some(property), true) = (element.properties.first(), element.count <= 16) else { return };
        *to = match kind {
            Kind::Binary => rows.chunks_exact(element.stride()).map(|row| of_bytes(row, property)).collect(),
            Kind::Text => numbers(rows, element).unwrap_or_default(),
        };
    }

    /// SHARP puts light together linearly, whatever colours are stored as: 0 is sRGB, 1 is linear.
    fn blend(&self) -> Blend {
        match self.color_space.first() {
            None => Blend::Encoded,
            Some(0.0) => Blend::Linear,
            Some(_) => Blend::StoredLinear,
        }
    }

    fn camera(&self, warnings: &mut Vec<String>) -> Option<Camera> {
        if self.intrinsic.is_empty() {
            return None;
        }
        let camera = self.sound_camera();
        if camera.is_none() {
            warnings.push("its camera is left out — its numbers are those of no camera".to_owned());
        }
        camera
    }

    fn sound_camera(&self) -> Option<Camera> {
        let (focal, center, [w, h]) = match (self.intrinsic.as_slice(), self.image_size.as_slice()) {
            ([fx, _, cx, _, fy, cy, ..], [w, h]) => (Vec2::new(*fx, *fy), Vec2::new(*cx, *cy), [*w, *h]),
            // Older files: focal lengths and size together.
            ([fx, fy, w, h], []) => (Vec2::new(*fx, *fy), Vec2::new(*w, *h) / 2.0, [*w, *h]),
            _ => return None,
        };
        let side = |px: f32| (16.0..=100_000.0).contains(&px).then_some(px as u32);
        let size = [side(w)?, side(h)?];
        let is_good = focal.min_element() > 1.0 && focal.max_element() < 1e6 && center.abs().max_element() < 1e6;
        let (turn, shift) = self.place()?;
        let camera = Camera { turn, shift, focal_px: focal, center_px: center - 0.5, size };
        is_good.then(|| camera.resized(crate::field::fit_long_side(size, MOST_PX)))
    }

    /// Camera from world; the world's own axes where nothing is said.
    fn place(&self) -> Option<(Mat3, Vec3)> {
        let m = &self.extrinsic;
        if m.len() != 16 {
            return Some((Mat3::IDENTITY, Vec3::ZERO));
        }
        let row = |y: usize| Vec3::new(m[4 * y], m[4 * y + 1], m[4 * y + 2]);
        let turn = Mat3::from_cols(row(0), row(1), row(2)).transpose();
        let shift = Vec3::new(m[3], m[7], m[11]);
        let is_turn = turn.is_finite() && (turn * turn.transpose()).abs_diff_eq(Mat3::IDENTITY, 1e-2);
        (is_turn && turn.determinant() > 0.0 && shift.is_finite()).then_some((turn, shift))
    }
}
