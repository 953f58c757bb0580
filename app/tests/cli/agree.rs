//! The same edit is the same picture, byte for byte, through every door: `refocus` with arguments, `refocus --recipe`,
//! `batch`, and the window's export.

use std::fs;
use std::path::{Path, PathBuf};

use plenoscope::field::{FNumber, LensShape, Strength, ViewOffset, ViewPoint};
use plenoscope::io::opening;
use plenoscope::io::save::Keep;
use plenoscope::scene::recipe::PictureSettings;
use plenoscope::scene::{Edit, Focus, Recipe};

use crate::common::{Scratch, plenoscope};
use crate::window_export::WindowExport;

/// Width and height of the photos.
const PHOTO: [u32; 2] = [600, 400];
/// Long side of the views of the recorded light field.
const RECORDED: u32 = 240;

/// One edit, as arguments and as a recipe.
struct Case {
    name: &'static str,
    args: Vec<String>,
    edit: Edit,
}

/// Any picture that is not black.
const OPENING: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../tests/snapshots/ray_depths.png");

/// Edits of every kind, of a picture of this size whose map is `map_width` pixels wide.
fn cases(picture: [u32; 2], map_width: u32) -> Vec<Case> {
    let width = map_width as f32;
    // Disparities of about half a pixel in views of the usual width.
    let px = |at_540: f32| at_540 * width / 540.0;
    let case = |name, args: &[String], edit| Case { name, args: args.to_vec(), edit };
    let at_plane = |f_number: f32, focus_px: f32| Edit {
        f_number: FNumber(f_number),
        focus: Focus::Disparity(focus_px / width),
        ..Edit::default()
    };
    let lens = |f_number: f32, focus_px: f32| {
        ["--f-number", &f_number.to_string(), "--focus-disparity", &focus_px.to_string()].map(str::to_owned)
    };
    let plus = |head: [String; 4], name: &str, value: String| [&head[..], &[name.to_owned(), value]].concat();
    let (d, low, high) = (px(0.3), px(0.1), px(0.45));
    let plane = d / width * width;
    let keep_sharp = [(low - plane).min(0.0) / width, (high - plane).max(0.0) / width];
    let at = ViewPoint(ViewOffset { du: -1.5, dv: 0.5 });
    let place = [picture[0] / 3, picture[1] * 3 / 4];
    let share = [0, 1].map(|axis| (place[axis] as f32 + 0.5) / picture[axis] as f32);
    let by_place =
        ["--f-number".to_owned(), "2".to_owned(), "--focus".to_owned(), format!("{},{}", place[0], place[1])];
    let by_subject = ["--f-number", "2.4", "--focus", "subject"].map(str::to_owned);
    vec![
        case("closed", &lens(28.0, d), at_plane(28.0, d)),
        case("usual", &lens(3.5, d), at_plane(3.5, d)),
        case("wide", &lens(1.4, d), at_plane(1.4, d)),
        case("beside", &plus(lens(3.5, d), "--at", "-1.5,0.5".to_owned()), Edit { viewpoint: at, ..at_plane(3.5, d) }),
        case(
            "tilted",
            &plus(lens(2.0, d), "--tilt", format!("{},{}", px(0.5), px(-0.25))),
            Edit { tilt: [px(0.5) / width, px(-0.25) / width], ..at_plane(2.0, d) },
        ),
        case(
            "kept sharp",
            &plus(lens(1.4, d), "--keep-sharp", format!("{low}..{high}")),
            Edit { keep_sharp, ..at_plane(1.4, d) },
        ),
        case(
            "flatter",
            &plus(lens(2.0, d), "--strength", "0.5".to_owned()),
            Edit { strength: Strength(0.5), ..at_plane(2.0, d) },
        ),
        case(
            "through a picture",
            &plus(lens(1.4, d), "--lens", format!("picture:{OPENING}")),
            Edit { shape: LensShape::Picture(opening::read(Path::new(OPENING)).unwrap()), ..at_plane(1.4, d) },
        ),
        case("by place", &by_place, Edit { f_number: FNumber(2.0), focus: Focus::At(share), ..Edit::default() }),
        case("on the subject", &by_subject, Edit { f_number: FNumber(2.4), focus: Focus::Subject, ..Edit::default() }),
    ]
}

/// How pictures are kept: as the window's dialog has it at first.
fn settings() -> PictureSettings {
    PictureSettings { keep: Keep::WithoutPosition, ..PictureSettings::default() }
}

/// The sample as a photo, with a depth inside as phones write it, and as a recorded light field.
fn subjects(dir: &Scratch) -> [String; 3] {
    plenoscope(&["sample", "-o", &dir.arg("")]).assert().success();
    let photo = image::open(dir.path("sample.png")).unwrap();
    photo.resize_exact(PHOTO[0], PHOTO[1], image::imageops::FilterType::Triangle).save(dir.path("photo.png")).unwrap();
    let known = ["--disparity", &dir.arg("sample.pfm"), "--lambertian"].map(str::to_owned);
    let made = |args: &[&str]| {
        let known: Vec<&str> = known.iter().map(String::as_str).collect();
        plenoscope(&[args, &known].concat()).assert().success();
    };
    made(&["export", &dir.arg("photo.png"), "--as", "gdepth", "-o", &dir.arg("phone.jpg")]);
    made(&["synth", &dir.arg("photo.png"), "--long-side", &RECORDED.to_string(), "-o", &dir.arg("field")]);
    [dir.arg("photo.png"), dir.arg("phone.jpg"), dir.arg("field")]
}

/// The picture of each door, for one subject and one edit.
fn doors(dir: &Scratch, input: &str, how: &[&str], case: &Case, window: &mut Option<WindowExport>) -> Vec<Vec<u8>> {
    let recipe = dir.path("edit.json");
    Recipe::new(case.edit.clone(), settings()).write(&recipe).unwrap();
    let recipe = recipe.to_string_lossy().into_owned();
    let (by_args, by_recipe, out) = (dir.arg("args.jpg"), dir.arg("recipe.jpg"), dir.arg("out"));
    let args: Vec<&str> = case.args.iter().map(String::as_str).collect();
    plenoscope(&[&["refocus", input, "-o", &by_args], how, &args].concat()).assert().success();
    plenoscope(&[&["refocus", input, "-o", &by_recipe, "--recipe", &recipe], how].concat()).assert().success();
    plenoscope(&[&["batch", input, "--force", "-o", &out, "--recipe", &recipe], how].concat()).assert().success();
    let batch = settings().file_name(Path::new(input), &case.edit);
    let mut files: Vec<PathBuf> = vec![by_args.into(), by_recipe.into(), dir.path("out").join(batch)];
    files.extend(window.as_mut().map(|window| window.export(&case.edit, &dir.path("window"))));
    files.iter().map(|file| fs::read(file).unwrap()).collect()
}

/// Checks that all doors give the same picture of every edit, and different edits different ones.
fn agree(dir: &Scratch, input: &str, how: &[&str], cases: Vec<Case>, mut window: Option<WindowExport>) {
    let mut pictures = Vec::new();
    for case in cases {
        let mut all = doors(dir, input, how, &case, &mut window).into_iter();
        let first = all.next().unwrap();
        for (door, other) in ["refocus --recipe", "batch", "the window"].iter().zip(all) {
            assert!(other == first, "{}: {door} differs from refocus, {input} {how:?}", case.name);
        }
        assert!(!pictures.contains(&first), "{} changes nothing", case.name);
        pictures.push(first);
    }
}

#[test]
fn the_same_edit_is_the_same_picture_through_every_door() {
    let dir = Scratch::new();
    let [photo, phone, field] = subjects(&dir);
    for long_side in [270, 540] {
        let side = long_side.to_string();
        let window = |input: &str, source| WindowExport::open(Path::new(input), long_side, source);
        agree(&dir, &photo, &["--long-side", &side], cases(PHOTO, long_side), window(&photo, None));
        let how = ["--long-side", &side, "--source", "phone"];
        agree(&dir, &phone, &how, cases(PHOTO, long_side), window(&phone, Some("Phone")));
    }
    let size = [RECORDED, RECORDED * 2 / 3];
    agree(&dir, &field, &[], cases(size, RECORDED), WindowExport::open(Path::new(&field), 540, None));
}

/// Recipes of version 1 with pictures of them. Those that the program made which wrote that version were equal to the last
/// byte until the phone's map came to be enlarged otherwise; these were made anew then, and when edges came to follow the photo,
/// and to take their colours from the photo itself, and when nearly sharp surfaces came to be closed, up to their rims too,
/// when what goes on behind surfaces in steps came to be the farthest, and when stains of a blurred near side came to be taken away.
#[test]
fn recipes_of_version_1_look_as_they_did() {
    let dir = Scratch::new();
    plenoscope(&["sample", "-o", &dir.arg("")]).assert().success();
    let known = ["--disparity", &dir.arg("sample.pfm"), "--lambertian"];
    let depth = ["export", &dir.arg("sample.png"), "--as", "gdepth", "-o", &dir.arg("depth.jpg")];
    plenoscope(&[&depth[..], &known].concat()).assert().success();
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../tests/recipes");
    for name in ["place", "number", "tilt", "beside"] {
        let (recipe, out) = (folder.join(format!("{name}.json")), dir.arg("out.png"));
        let how = ["--source", "phone", "--long-side", "270", "--recipe", &recipe.to_string_lossy(), "-o", &out];
        plenoscope(&[&["refocus", &dir.arg("depth.jpg")], &how[..]].concat()).assert().success();
        let [now, then] =
            [Path::new(&out), &folder.join(format!("{name}.png"))].map(|p| image::open(p).unwrap().to_rgb8());
        assert_eq!(now.dimensions(), then.dimensions());
        let apart = now.iter().zip(then.iter()).map(|(a, b)| a.abs_diff(*b)).max();
        assert!(apart <= Some(1), "{name}: {apart:?} of 255");
    }
}
