//! Files of several programs, made by hand, and what is wrong with others.

use std::fmt::Write;

use super::*;
use crate::field::{LightField, RayDepths, View, ViewGrid};
use crate::io::formats::FieldToWrite;
use crate::io::{Opened, open_bytes};
use crate::job::Cancel;
use crate::splats::harmonics;

const OWN: [&str; 14] = [
    "x", "y", "z", "f_dc_0", "f_dc_1", "f_dc_2", "opacity", "scale_0", "scale_1", "scale_2", "rot_0", "rot_1", "rot_2",
    "rot_3",
];

/// A wall of Gaussians two units away, wider than a picture; red, and green on its right half.
fn wall() -> Vec<[f32; 14]> {
    let one = |i: i32| {
        let (x, y) = (i % 41 - 20, i / 41 - 20);
        let color = if x < 0 { [1.0, 0.0, 0.0] } else { [0.0, 1.0, 0.0] };
        let [r, g, b] = harmonics::constant(color);
        let scale = 0.05f32.ln();
        [x as f32 * 0.1, y as f32 * 0.1, 2.0, r, g, b, 5.0, scale, scale, scale, 2.0, 0.0, 0.0, 0.0]
    };
    (0..41 * 41).map(one).collect()
}

fn head(format: &str, count: usize, properties: &[&str], kind: &str) -> String {
    let mut head = format!("ply\nformat {format} 1.0\nelement vertex {count}\n");
    properties.iter().for_each(|name| writeln!(head, "property {kind} {name}").unwrap());
    head
}

fn binary(rows: &[[f32; 14]]) -> Vec<u8> {
    let mut bytes = (head("binary_little_endian", rows.len(), &OWN, "float") + "end_header\n").into_bytes();
    bytes.extend(rows.iter().flatten().flat_map(|value| value.to_le_bytes()));
    bytes
}

/// The same as SHARP writes it: its camera and more behind the Gaussians.
fn of_sharp(rows: &[[f32; 14]]) -> Vec<u8> {
    let mut head = head("binary_little_endian", rows.len(), &OWN, "float");
    head += "element extrinsic 16\nproperty float extrinsic\nelement intrinsic 9\nproperty float intrinsic\n";
    head += "element image_size 2\nproperty uint image_size\nelement frame 2\nproperty int frame\n";
    head +=
        "element color_space 1\nproperty uchar color_space\nelement version 3\nproperty uchar version\nend_header\n";
    let mut bytes = head.into_bytes();
    let mut put = |values: &[f32]| bytes.extend(values.iter().flat_map(|value| value.to_le_bytes()));
    put(rows.as_flattened());
    // Moved half a unit to the left: what was at x = −0.5 lies in the middle.
    put(&[1.0, 0.0, 0.0, 0.5, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 1.0]);
    put(&[80.0, 0.0, 48.0, 0.0, 80.0, 32.0, 0.0, 0.0, 1.0]);
    bytes.extend([96u32, 64, 1, rows.len() as u32].iter().flat_map(|value| value.to_le_bytes()));
    bytes.extend([0, 1, 5, 0]);
    bytes
}

fn open(bytes: &[u8]) -> PhotoFile {
    match open_bytes(bytes, None).unwrap() {
        Opened::Photo(file) => *file,
        Opened::LightField(_) => panic!("a picture with its scene"),
    }
}

#[test]
fn drawing_a_scene_can_be_stopped() {
    let cancel = Cancel::default();
    cancel.cancel();
    let stopped = super::open(&binary(&wall()), &Job { cancel: &cancel, sink: &() });
    assert!(matches!(stopped, Err(Problem::Stopped(_))));
}

fn pixel(file: &PhotoFile, x: f32, y: f32) -> [u8; 3] {
    let [w, h] = file.photo.size();
    let at = ((y * h as f32) as usize * w as usize + (x * w as f32) as usize) * 4;
    file.photo.srgb8()[at..at + 3].try_into().unwrap()
}

fn is_red([r, g, _]: [u8; 3]) -> bool {
    r > 200 && g < 60
}

fn is_green([r, g, _]: [u8; 3]) -> bool {
    g > 200 && r < 60
}

#[test]
fn a_cloud_that_lies_before_the_origin_is_seen_from_there() {
    let file = open(&binary(&wall()));
    assert!(is_red(pixel(&file, 0.3, 0.5)) && is_green(pixel(&file, 0.7, 0.5)), "left is left");
    assert_eq!((file.info.kind, file.warnings.len()), (FileKind::Splats, 0));
}

#[test]
fn text_and_double_and_further_properties_say_the_same() {
    let rows = wall();
    let plain = open(&binary(&rows));
    let mut text = head("ascii", rows.len(), &OWN, "float") + "comment hello\nend_header\n";
    for row in &rows {
        let words: Vec<String> = row.iter().map(f32::to_string).collect();
        writeln!(text, "{}", words.join("  ")).unwrap();
    }
    assert_eq!(open(text.as_bytes()).photo.srgb8(), plain.photo.srgb8());
    let mut names: Vec<&str> = vec!["id", "nx"];
    names.extend(OWN.iter().rev());
    let mut wide = (head("binary_little_endian", rows.len(), &names, "double") + "end_header\n").into_bytes();
    for row in &rows {
        let values = [7.0, f64::NAN].into_iter().chain(row.iter().rev().map(|value| f64::from(*value)));
        wide.extend(values.flat_map(f64::to_le_bytes));
    }
    assert_eq!(open(&wide).photo.srgb8(), plain.photo.srgb8());
}

#[test]
fn sharps_camera_is_the_reference_view() {
    let file = open(&of_sharp(&wall()));
    assert_eq!(file.photo.size(), [96, 64]);
    let stage = &file.splats.as_ref().unwrap().stage;
    assert!(stage.in_metres && stage.named == NamedCamera::File && stage.rig.camera.focal_px.x == 80.0);
    // x = 0 is seen half a unit to the right: at 48 + 80 · 0.5 / 2 = 68 px. A Gaussian reaches three deviations, 6 px.
    assert!(is_red(pixel(&file, 62.0 / 96.0, 0.5)) && is_green(pixel(&file, 74.0 / 96.0, 0.5)));
}

#[test]
fn colours_change_with_the_direction() {
    let mut names: Vec<String> = OWN.map(str::to_owned).to_vec();
    names.extend((0..9).map(|i| format!("f_rest_{i}")));
    let names: Vec<&str> = names.iter().map(String::as_str).collect();
    let mut bytes = (head("binary_little_endian", wall().len(), &names, "float") + "end_header\n").into_bytes();
    for mut row in wall() {
        row[3..6].fill(0.0);
        // The third coefficient of the first channel counts −0.49·x: red to the left.
        let rest = [0.0, 0.0, 2.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0];
        bytes.extend(row.into_iter().chain(rest).flat_map(f32::to_le_bytes));
    }
    let file = open(&bytes);
    let [left, right] = [0.1, 0.9].map(|x| pixel(&file, x, 0.5));
    assert!(left[0] > 180 && right[0] < 70 && left[1].abs_diff(right[1]) < 3, "{left:?} {right:?}");
}

#[test]
fn what_is_not_made_of_numbers_is_left_out() {
    let mut rows = wall();
    rows[3][0] = f32::NAN;
    rows[4][7] = f32::INFINITY;
    rows[5][10] = 0.0;
    let file = open(&binary(&rows));
    assert!(file.warnings.len() == 1 && file.warnings[0].starts_with("3 of 1681 Gaussians"), "{:?}", file.warnings);
    rows.iter_mut().for_each(|row| row[2] = f32::NAN);
    assert!(open_bytes(&binary(&rows), None).unwrap_err().to_string().contains("none of its Gaussians"));
}

#[test]
fn what_cannot_be_opened_says_why() {
    let rows = wall();
    let swapped = |from: &str, to: &str| {
        let text = head("binary_little_endian", rows.len(), &OWN, "float") + "end_header\n";
        let mut bytes = text.replace(from, to).into_bytes();
        bytes.extend(rows.iter().flatten().flat_map(|value| value.to_le_bytes()));
        bytes
    };
    let whole = binary(&rows);
    let cases = [
        (swapped("little", "big"), "big-endian"),
        (swapped("opacity", "alpha"), "opacity is missing"),
        (swapped("f_dc_0", "red"), "a cloud of points"),
        (swapped("x\n", "packed_position\n"), "packed"),
        (swapped("vertex 1681", "vertex 0"), "no points"),
        (swapped("vertex 1681", "vertex 1682"), "cut off"),
        (swapped("vertex 1681", "vertex 9000000"), "8000000 are the most"),
        (swapped("vertex 1681", "vertex 99999999999999999999999"), "99999999999999999999999"),
        (swapped("element vertex", "element thing"), "no points"),
        (swapped("float x", "list uchar float x"), "lists"),
        (swapped("end_header", "no_header"), "no end"),
        (whole[..whole.len() - 1].to_vec(), "cut off"),
        (b"ply\nformat ascii 1.0\n".repeat(9000), "no end"),
    ];
    for (bytes, part) in cases {
        let sentence = open_bytes(&bytes, None).unwrap_err().to_string();
        assert!(sentence.contains(part) && sentence.matches(" — ").count() == 2, "{part}: {sentence}");
    }
}

#[test]
fn our_own_file_comes_back_with_its_camera_and_steps() {
    let grid = ViewGrid::new(3, 3).unwrap();
    let view = |_| Arc::new(View::new([48, 32], [90, 120, 60, 255].repeat(48 * 32)).unwrap());
    let field = LightField::new(grid, (0..9).map(view).collect()).unwrap();
    let values = (0..9 * 48 * 32).map(|i| if i % 48 < 24 { -0.6 } else { 0.8 }).collect();
    let depths = RayDepths::new(grid, [48, 32], values).unwrap();
    let dir = tempfile::tempdir().unwrap();
    let path = dir.path().join("splats.ply");
    let job = Job { cancel: &Cancel::default(), sink: &() };
    write(&path, &FieldToWrite { depths: Some(&depths), ..FieldToWrite::new(&field) }, &job).unwrap();
    let file = open(&std::fs::read(&path).unwrap());
    assert_eq!(file.photo.size(), [48, 32]);
    let map = &file.splats.as_ref().unwrap().map;
    assert!((map.at(8, 16) + 0.6).abs() < 0.02 && (map.at(40, 16) - 0.8).abs() < 0.02, "{}", map.at(8, 16));
    assert!(pixel(&file, 0.2, 0.5).iter().zip([90, 120, 60]).all(|(a, b)| a.abs_diff(b) < 4));
    assert!(write(&path, &FieldToWrite::new(&field), &job).is_err(), "no depths, no Gaussians");
}
