//! The program's sign: an aperture over a grid of lenses. Drawn from these numbers at every size, and as SVG.
//!
//! Lengths are shares of the side; y goes down.

use std::fmt::Write as _;

/// Sides of the pictures that desktops ask for, in pixels.
pub const SIDES: [u32; 8] = [16, 24, 32, 48, 64, 128, 256, 512];

/// Corner radius of the ground.
const CORNER: f32 = 0.2;
/// Outer radius of the aperture.
const APERTURE: f32 = 0.39;
/// Distance of the opening's corners from the middle.
const OPENING: f32 = 0.2;
/// Half the width of the gaps between blades.
const GAP: f32 = 0.011;
const BLADES: usize = 6;
/// Lenses along a side.
const LENSES: usize = 6;
const LENS_RADIUS: f32 = 0.058;
/// Samples along a side of a pixel.
const SAMPLES: u32 = 6;

const GROUND: [u8; 3] = [0x1B, 0x1D, 0x21];
const LENS: [u8; 3] = [0x3A, 0x3E, 0x46];
const SEEN_LENS: [u8; 3] = [0xF4, 0xF5, 0xF6];
/// The blades, lit from the upper left.
const BLADE: [[u8; 3]; BLADES] = [
    [0xC9, 0x88, 0x2C],
    [0xE8, 0xA3, 0x3D],
    [0xF6, 0xBE, 0x67],
    [0xEE, 0xAE, 0x4E],
    [0xD6, 0x93, 0x33],
    [0xB5, 0x77, 0x22],
];

type Point = [f32; 2];

/// The icon with a side of so many pixels, RGBA row by row, not premultiplied.
pub fn rgba(side: u32) -> Vec<u8> {
    let mut all = Vec::with_capacity((side * side * 4) as usize);
    for (y, x) in (0..side).flat_map(|y| (0..side).map(move |x| (y, x))) {
        let (mut sum, mut covered) = ([0_u32; 3], 0_u32);
        for (j, i) in (0..SAMPLES).flat_map(|j| (0..SAMPLES).map(move |i| (j, i))) {
            let place = |pixel: u32, part: u32| (pixel as f32 + (part as f32 + 0.5) / SAMPLES as f32) / side as f32;
            if let Some(color) = color([place(x, i), place(y, j)]) {
                covered += 1;
                (0..3).for_each(|c| sum[c] += u32::from(color[c]));
            }
        }
        all.extend(sum.map(|c| (c / covered.max(1)) as u8));
        all.push((covered * 255 / (SAMPLES * SAMPLES)) as u8);
    }
    all
}

/// The same as a PNG file.
///
/// # Errors
/// The encoder's.
pub fn png(side: u32) -> Result<Vec<u8>, png::EncodingError> {
    let mut file = Vec::new();
    let mut encoder = png::Encoder::new(&mut file, side, side);
    encoder.set_color(png::ColorType::Rgba);
    encoder.set_depth(png::BitDepth::Eight);
    encoder.write_header()?.write_image_data(&rgba(side))?;
    Ok(file)
}

/// All sizes up to 256 pixels in one file, as Windows reads them.
///
/// # Errors
/// The encoder's.
pub fn ico() -> Result<Vec<u8>, png::EncodingError> {
    let sides: Vec<u32> = SIDES.into_iter().filter(|side| *side <= 256).collect();
    let pictures = sides.iter().map(|side| png(*side)).collect::<Result<Vec<_>, _>>()?;
    let count = sides.len() as u16;
    let mut file = [0_u16, 1, count].iter().flat_map(|n| n.to_le_bytes()).collect::<Vec<u8>>();
    let mut offset = 6 + 16 * u32::from(count);
    for (side, picture) in sides.iter().zip(&pictures) {
        // 256 is written as 0; one plane, 32 bits a pixel.
        file.extend([*side as u8, *side as u8, 0, 0, 1, 0, 32, 0]);
        file.extend([picture.len() as u32, offset].iter().flat_map(|n| n.to_le_bytes()));
        offset += picture.len() as u32;
    }
    file.extend(pictures.into_iter().flatten());
    Ok(file)
}

/// The colour at a place; none beside the ground.
fn color(at: Point) -> Option<[u8; 3]> {
    let beyond = at.map(|c| ((c - 0.5).abs() - (0.5 - CORNER)).max(0.0));
    if beyond[0].hypot(beyond[1]) > CORNER {
        return None;
    }
    let from_middle = [at[0] - 0.5, at[1] - 0.5];
    let radius = from_middle[0].hypot(from_middle[1]);
    let lens = lenses().find(|lens| (lens[0] - at[0]).hypot(lens[1] - at[1]) < LENS_RADIUS);
    if radius > APERTURE {
        return Some(if lens.is_some() && radius > APERTURE + GAP { LENS } else { GROUND });
    }
    let blades: Vec<[Point; 2]> = (0..BLADES).map(edge).collect();
    if blades.iter().any(|edge| distance(at, *edge) < GAP) {
        return Some(GROUND);
    }
    // A blade lies inside its own edge's line and outside the next one's.
    let is_inside = |n: usize| side_of(at, blades[n % BLADES]) > 0.0;
    match (0..BLADES).find(|n| is_inside(*n) && !is_inside(n + 1)) {
        Some(n) => Some(BLADE[n]),
        None => Some(if lens.is_some_and(is_seen) { SEEN_LENS } else { GROUND }),
    }
}

/// Whether the opening shows all of a lens.
fn is_seen(lens: Point) -> bool {
    (lens[0] - 0.5).hypot(lens[1] - 0.5) + LENS_RADIUS < OPENING
}

/// Middles of the lenses.
fn lenses() -> impl Iterator<Item = Point> {
    let place = |n: usize| (n as f32 + 0.5) / LENSES as f32 * 0.88 + 0.06;
    (0..LENSES * LENSES).map(move |n| [place(n % LENSES), place(n / LENSES)])
}

/// The edge of a blade: from a corner of the opening past the next one to the aperture's rim.
fn edge(n: usize) -> [Point; 2] {
    let corner = |n: usize| {
        let angle = (n as f32 + 0.25) / BLADES as f32 * std::f32::consts::TAU;
        [0.5 + OPENING * angle.cos(), 0.5 + OPENING * angle.sin()]
    };
    let (from, past) = (corner(n), corner(n + 1));
    let step = [past[0] - from[0], past[1] - from[1]].map(|c| c / OPENING);
    // Sides of a hexagon are as long as its radius: |from + t·step − middle| = APERTURE, the later of both t.
    let start = [from[0] - 0.5, from[1] - 0.5];
    let along = start[0] * step[0] + start[1] * step[1];
    let t = -along + (along * along + APERTURE * APERTURE - OPENING * OPENING).sqrt();
    [from, [from[0] + t * step[0], from[1] + t * step[1]]]
}

/// Positive to the side of the middle.
fn side_of(at: Point, [from, to]: [Point; 2]) -> f32 {
    (to[0] - from[0]) * (at[1] - from[1]) - (to[1] - from[1]) * (at[0] - from[0])
}

/// Distance of a point from a segment.
fn distance(at: Point, [from, to]: [Point; 2]) -> f32 {
    let (line, off) = ([to[0] - from[0], to[1] - from[1]], [at[0] - from[0], at[1] - from[1]]);
    let share = (line[0] * off[0] + line[1] * off[1]) / (line[0] * line[0] + line[1] * line[1]);
    let share = share.clamp(0.0, 1.0);
    (off[0] - share * line[0]).hypot(off[1] - share * line[1])
}

/// The same as SVG, 512 units wide.
pub fn svg() -> String {
    let px = |share: f32| format!("{:.1}", share * 512.0);
    let at = |point: Point| format!("{} {}", px(point[0]), px(point[1]));
    let hex = |color: [u8; 3]| format!("#{:02x}{:02x}{:02x}", color[0], color[1], color[2]);
    let mut text = format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 512 512\">\n<rect width=\"512\" height=\"512\" rx=\"{}\" fill=\"{}\"/>\n",
        px(CORNER),
        hex(GROUND)
    );
    let lens = |text: &mut String, lens: Point, color| {
        let radius = px(LENS_RADIUS);
        let _ = writeln!(
            text,
            "<circle cx=\"{}\" cy=\"{}\" r=\"{radius}\" fill=\"{}\"/>",
            px(lens[0]),
            px(lens[1]),
            hex(color)
        );
    };
    lenses().for_each(|place| lens(&mut text, place, LENS));
    let _ = writeln!(text, "<circle cx=\"256\" cy=\"256\" r=\"{}\" fill=\"{}\"/>", px(APERTURE), hex(GROUND));
    lenses().filter(|place| is_seen(*place)).for_each(|place| lens(&mut text, place, SEEN_LENS));
    for (n, color) in BLADE.iter().enumerate() {
        let ([from, to], [next_from, next_to]) = (edge(n), edge(n + 1));
        let rim = px(APERTURE);
        let _ = writeln!(
            text,
            "<path d=\"M{} L{} A{rim} {rim} 0 0 1 {} L{} Z\" fill=\"{}\" stroke=\"{}\" stroke-width=\"{}\"/>",
            at(from),
            at(to),
            at(next_to),
            at(next_from),
            hex(*color),
            hex(GROUND),
            px(2.0 * GAP)
        );
    }
    text.push_str("</svg>\n");
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn it_has_clear_corners_an_opening_that_shows_lenses_and_amber_round_it() {
        for side in SIDES {
            let all = rgba(side);
            let pixel = |x: f32, y: f32| {
                let at = ((y * side as f32) as u32 * side + (x * side as f32) as u32) as usize * 4;
                [all[at], all[at + 1], all[at + 2], all[at + 3]]
            };
            assert_eq!(all.len() as u32, side * side * 4);
            assert_eq!(pixel(0.0, 0.0)[3], 0, "{side}: the corner is clear");
            assert_eq!(pixel(0.5, 0.02)[3], 255, "{side}: the ground is there");
            let blade = pixel(0.5, 0.2);
            assert!(blade[0] > blade[2] + 60, "{side}: amber, not {blade:?}");
        }
        assert_eq!(color([0.5 + 0.0733, 0.5 + 0.0733]), Some(SEEN_LENS));
        assert_eq!(color([0.1333, 0.1333]), Some(LENS));
    }

    #[test]
    fn files_are_read_as_what_they_are() {
        let png = image::load_from_memory(&png(48).unwrap()).unwrap().into_rgba8();
        assert_eq!((png.width(), png.into_raw()), (48, rgba(48)));
        let ico = ico().unwrap();
        let number = |at: usize| u32::from_le_bytes([ico[at], ico[at + 1], ico[at + 2], ico[at + 3]]) as usize;
        let last = 6 + 16 * (usize::from(ico[4]) - 1);
        let (bytes, offset) = (number(last + 8), number(last + 12));
        assert_eq!(offset + bytes, ico.len());
        assert_eq!(image::load_from_memory(&ico[offset..]).unwrap().width(), 256);
    }

    #[test]
    fn the_svg_has_every_lens_and_blade() {
        let text = svg();
        assert_eq!(text.matches("<path").count(), BLADES);
        assert!(text.matches("<circle").count() > LENSES * LENSES && !text.contains("NaN"));
    }
}
