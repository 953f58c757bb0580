//! The living picture in a browser: the same pictures as ours. Where there is no Chromium the test says so.

use std::process::Command;

use super::common::{Scratch, plenoscope};

/// The first browser of these names that starts.
pub fn chromium() -> Option<&'static str> {
    let starts = |name: &&str| Command::new(name).arg("--version").output().is_ok_and(|done| done.status.success());
    let found = ["chromium", "chromium-browser", "google-chrome"].into_iter().find(starts);
    if found.is_none() {
        eprintln!("SKIPPED: there is no Chromium");
    }
    found
}

/// What the browser shows of a page, which is the picture alone.
fn shot(browser: &str, dir: &Scratch, page: &str, name: &str, [width, height]: [u32; 2]) -> image::RgbImage {
    let done = Command::new(browser)
        .args(["--headless=new", "--no-sandbox", "--use-gl=angle", "--use-angle=swiftshader"])
        .args(["--enable-unsafe-swiftshader", "--hide-scrollbars", "--force-device-scale-factor=1"])
        .args(["--virtual-time-budget=4000", "--disable-background-networking"])
        .arg(format!("--user-data-dir={}", dir.arg("browser")))
        .arg(format!("--window-size={},{}", width.max(500), height + 200))
        .arg(format!("--screenshot={}", dir.arg(name)))
        .arg(format!("file://{}", dir.arg(page)))
        .output()
        .unwrap();
    let picture =
        image::open(dir.path(name)).unwrap_or_else(|e| panic!("{e}: {}", String::from_utf8_lossy(&done.stderr)));
    image::imageops::crop_imm(&picture.to_rgb8(), 0, 0, width, height).to_image()
}

/// Peak signal to noise ratio, dB.
fn psnr(a: &image::RgbImage, b: &image::RgbImage) -> f64 {
    assert_eq!(a.dimensions(), b.dimensions());
    let apart = a.iter().zip(b.iter()).map(|(a, b)| f64::from(a.abs_diff(*b)).powi(2));
    10.0 * (255.0f64.powi(2) / (apart.sum::<f64>() / a.len() as f64)).log10()
}

#[test]
fn a_browser_shows_our_pictures() {
    let Some(browser) = chromium() else { return };
    let dir = Scratch::new();
    plenoscope(&["sample", "-o", &dir.arg("")]).assert().success();
    let size = [360, 240];
    std::fs::write(dir.path("pivot.json"), r#"{"version": 2, "lens": {"pivot": 0.003}}"#).unwrap();
    // Far and near, from beside, and around something near.
    let beside = "&x=-3&y=1";
    let asked = [
        ("100,100", "0,0", "", ""),
        ("1100,660", "0,0", "", ""),
        ("1100,660", "-3,1", beside, ""),
        ("1100,660", "-3,1", beside, "pivot.json"),
    ];
    let mut shots = Vec::new();
    for (number, (focus, at, eye, recipe)) in asked.into_iter().enumerate() {
        let [page, ours] = [format!("{number}.html"), format!("{number}.png")];
        let (photo, map) = (dir.arg("sample.png"), dir.arg("sample.pfm"));
        let mut lens = vec!["--disparity", &map, "--size", "360x240", "--focus", focus, "--f-number", "2"];
        let recipe = dir.arg(recipe);
        if recipe.ends_with(".json") {
            lens.extend(["--recipe", &recipe]);
        }
        let export = ["export", &photo, "--as", "html", "-o", &dir.arg(&page)];
        plenoscope(&[&export[..], &lens].concat()).assert().success();
        let refocus = ["refocus", &photo, "--at", at, "-o", &dir.arg(&ours)];
        plenoscope(&[&refocus[..], &lens].concat()).assert().success();
        let shown = shot(browser, &dir, &format!("{page}#bare{eye}"), &format!("shot{number}.png"), size);
        let ours = image::open(dir.path(&ours)).unwrap().to_rgb8();
        assert!(psnr(&shown, &ours) > 32.0, "{focus} {at}: {} dB", psnr(&shown, &ours));
        shots.push(shown);
    }
    assert!(psnr(&shots[0], &shots[1]) < 32.0, "far and near are other pictures");
    assert!(psnr(&shots[2], &shots[3]) < 32.0, "a pivot moves the picture");
    let bytes = std::fs::metadata(dir.path("0.html")).unwrap().len();
    assert!(bytes < 3_000_000, "{bytes}");
}

/// Exports near on the left, far on the right, and says the page's name. `halo`: of the first two far columns.
fn step(dir: &Scratch, name: &str, halo: u8) -> String {
    let photo = image::RgbImage::from_fn(800, 300, |x, _| match x {
        ..400 => image::Rgb([203, 149, 39]),
        400..402 => image::Rgb([149, 169, 218].map(|far: u8| far.saturating_add(halo))),
        402.. => image::Rgb([149, 169, 218]),
    });
    photo.save(dir.path(&format!("{name}.png"))).unwrap();
    let map = dir.map(&format!("{name}.pfm"), [400, 150], |x| if x < 200 { 1.0 } else { -1.0 });
    let (photo, page) = (dir.arg(&format!("{name}.png")), format!("{name}.html"));
    let export = ["export", &photo, "--as", "html", "-o", &dir.arg(&page)];
    let lens = ["--disparity", &map, "--focus", "700,150", "--f-number", "2"];
    plenoscope(&[&export[..], &lens].concat()).assert().success();
    page
}

#[test]
fn a_browser_shows_no_outline_of_a_blurred_near_side() {
    let Some(browser) = chromium() else { return };
    let dir = Scratch::new();
    let pages = [("with", 30), ("without", 0)].map(|(name, halo)| step(&dir, name, halo));
    // Seen straight on and from beside.
    for eye in ["", "&x=-2", "&x=2"] {
        let shown =
            |page: &String| shot(browser, &dir, &format!("{page}#bare{eye}"), &format!("{page}{eye}.png"), [800, 300]);
        let [with, without] = pages.each_ref().map(shown);
        let [near, far] = [100, 700].map(|x| without[(x, 150)].0);
        assert!(near[0].abs_diff(203) < 8 && far[2].abs_diff(218) < 8, "another picture{eye}: {near:?}, {far:?}");
        let apart = |x: u32| (0..3).map(|c| with[(x, 150)].0[c].abs_diff(without[(x, 150)].0[c])).max();
        let outline = (380..480).filter_map(apart).max();
        assert!(outline < Some(8), "the outline stays{eye}: {outline:?} of 255");
    }
}
