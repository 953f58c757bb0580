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
    // Far and near, and from beside.
    let asked = [("100,100", "0,0", ""), ("1100,660", "0,0", ""), ("1100,660", "-3,1", "&x=-3&y=1")];
    let mut shots = Vec::new();
    for (number, (focus, at, eye)) in asked.into_iter().enumerate() {
        let [page, ours] = [format!("{number}.html"), format!("{number}.png")];
        let (photo, map) = (dir.arg("sample.png"), dir.arg("sample.pfm"));
        let lens = ["--disparity", &map, "--size", "360x240", "--focus", focus, "--f-number", "2"];
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
    let bytes = std::fs::metadata(dir.path("0.html")).unwrap().len();
    assert!(bytes < 3_000_000, "{bytes}");
}
