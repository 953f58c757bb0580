//! From a photo to a light field and what is made of it, with the real program. The depth is known here (the sample's
//! own), so that no net runs; `nets.rs` runs them.

use std::fs;

use crate::common::{Scratch, plenoscope};
use image::GenericImageView;
use predicates::prelude::*;
use predicates::str::{contains, starts_with};

/// The sample photo and its disparity in a scratch folder.
fn sample() -> Scratch {
    let dir = Scratch::new();
    plenoscope(&["sample", "-o", &dir.arg("")]).assert().success().stdout("").stderr("");
    dir
}

/// Runs a command on the sample, with its own disparity and small views.
fn on_sample(dir: &Scratch, command: &str, rest: &[&str]) -> assert_cmd::assert::Assert {
    let (photo, map) = (dir.arg("sample.png"), dir.arg("sample.pfm"));
    let known = ["--disparity", &map, "--lambertian", "--long-side", "120"];
    plenoscope(&[&[command, &photo], &known[..], rest].concat()).assert()
}

#[test]
fn synth_writes_views_and_ray_depths() {
    let dir = sample();
    on_sample(&dir, "synth", &["-o", &dir.arg("field")]).success().stdout("").stderr("");
    for name in ["view_0_0.png", "view_4_4.png", "view_7_7.png", "disparity_0_7.pfm", "lightfield.json"] {
        assert!(dir.path("field").join(name).exists(), "{name}");
    }
    let said = json(&["info", "--json", &dir.arg("field")]);
    assert_eq!(said["kind"], "light field");
    assert_eq!(said["size"], serde_json::json!([120, 80]));
    assert_eq!(said["views"], serde_json::json!([8, 8]));
    let index: serde_json::Value =
        serde_json::from_slice(&fs::read(dir.path("field/lightfield.json")).unwrap()).unwrap();
    assert_eq!(index["reference_view"], serde_json::json!([4, 4]));
    assert_eq!(index["size_xy"], serde_json::json!([120, 80]));
}

#[test]
fn four_corners_become_a_light_field_that_holds_them() {
    let dir = sample();
    on_sample(&dir, "synth", &["-o", &dir.arg("field")]).success();
    let corner = |name: &str| dir.arg(&format!("field/view_{name}.png"));
    let corners = ["0_0", "0_7", "7_0", "7_7"].map(corner);
    let [a, b, c, d] = [0, 1, 2, 3].map(|i| corners[i].as_str());
    plenoscope(&["synth", "--corners", a, b, c, d, "-o", &dir.arg("between")]).assert().success().stdout("").stderr("");
    let view =
        |folder: &str, name: &str| image::open(dir.path(folder).join(format!("view_{name}.png"))).unwrap().to_rgb8();
    assert_eq!(view("between", "7_0"), view("field", "7_0"));
    let off = |a: &image::RgbImage, b: &image::RgbImage| {
        a.iter().zip(b.iter()).map(|(a, b)| f64::from(a.abs_diff(*b))).sum::<f64>() / a.len() as f64
    };
    let truth = view("field", "3_3");
    let (made, nearest) = (off(&view("between", "3_3"), &truth), off(&view("field", "0_0"), &truth));
    assert!(made < nearest, "{made} of 255, and {nearest} of a corner");
    let said = json(&["info", "--json", &dir.arg("between")]);
    assert_eq!(said["views"], serde_json::json!([8, 8]));
    // A folder of nothing but these four is the same.
    fs::create_dir(dir.path("four")).unwrap();
    for name in ["view_0_0.png", "view_0_7.png", "view_7_0.png", "view_7_7.png"] {
        fs::copy(dir.path("field").join(name), dir.path("four").join(name)).unwrap();
    }
    plenoscope(&["view", &dir.arg("four"), "--at", "-1,-1", "-o", &dir.arg("made.png")]).assert().success();
    assert_eq!(image::open(dir.path("made.png")).unwrap().to_rgb8(), view("between", "3_3"));
    let three = ["synth", "--corners", a, b, c, "-o", &dir.arg("none")];
    plenoscope(&three).assert().code(2);
    let field = dir.arg("field");
    plenoscope(&["synth", "--corners", a, b, c, &field, "-o", &dir.arg("none")])
        .assert()
        .failure()
        .stderr(contains("each corner is one photo"));
}

#[test]
fn every_format_is_written_and_read_back() {
    let dir = sample();
    for (format, out) in [("views", "v"), ("hci", "h"), ("stanford", "s"), ("eslf", "e/lf_eslf.png"), ("quilt", "q")] {
        on_sample(&dir, "synth", &["--format", format, "-o", &dir.arg(out)]).success();
        let written = if format == "quilt" { first_file(&dir.path(out)) } else { dir.arg(out) };
        let said = json(&["info", "--json", &written]);
        assert_eq!(said["kind"], "light field", "{format}");
    }
}

#[test]
fn view_epi_and_depth_have_the_light_fields_size() {
    let dir = sample();
    on_sample(&dir, "synth", &["-o", &dir.arg("field")]).success();
    let field = dir.arg("field");
    let made = |args: &[&str], name: &str| {
        plenoscope(&[args, &["-o", &dir.arg(name)]].concat()).assert().success().stdout("").stderr("");
        image::open(dir.path(name)).unwrap()
    };
    assert_eq!(made(&["view", &field, "--at", "-1.5,2"], "view.png").dimensions(), (120, 80));
    assert_eq!(made(&["epi", &field, "--row", "40", "--scale", "3"], "row.png").dimensions(), (120, 24));
    assert_eq!(made(&["epi", &field, "--column", "60", "--scale", "2"], "column.png").dimensions(), (80, 16));
    assert_eq!(made(&["depth", &field, "--colormap", "turbo"], "turbo.png").dimensions(), (120, 80));
    let gray = made(&["depth", &field, "--view", "0,7"], "gray.png");
    assert_eq!(gray.color(), image::ColorType::L16);
    plenoscope(&["depth", &field, "-o", &dir.arg("depth.pfm")]).assert().success();
    assert!(fs::read(dir.path("depth.pfm")).unwrap().starts_with(b"Pf\n120 80\n"));
}

#[test]
fn the_reference_view_is_the_view_at_zero() {
    let dir = sample();
    on_sample(&dir, "synth", &["-o", &dir.arg("field")]).success();
    plenoscope(&["view", &dir.arg("field"), "--at", "0,0", "-o", &dir.arg("zero.png")]).assert().success();
    let pixels = |name: &str| image::open(dir.path(name)).unwrap().to_rgb8().into_raw();
    assert_eq!(pixels("zero.png"), pixels("field/view_4_4.png"));
}

#[test]
fn the_exports_are_made() {
    let dir = sample();
    for (kind, name) in
        [("anaglyph", "a.png"), ("side-by-side", "s.png"), ("ply", "p.ply"), ("gdepth", "g.jpg"), ("views", "v")]
    {
        on_sample(&dir, "export", &["--as", kind, "-o", &dir.arg(name)]).success();
        assert!(dir.path(name).exists(), "{kind}");
    }
    let [w, h] = image::image_dimensions(dir.path("sample.png")).map(|(w, h)| [w, h]).unwrap();
    assert_eq!(image::open(dir.path("s.png")).unwrap().dimensions(), (2 * w, h), "both eyes at the photo's size");
    assert!(json(&["info", "--json", &dir.arg("g.jpg")])["embedded_depth"].is_object());
}

#[test]
fn series_are_made_and_the_lens_stands_where_it_is_put() {
    let dir = sample();
    let series = ["--size", "90x60", "--frames", "3"];
    let export = |rest: &[&str]| on_sample(&dir, "export", &[&series[..], rest].concat()).success();
    export(&["--as", "focal-stack", "-o", &dir.arg("stack")]);
    for name in ["frame_000.png", "frame_002.png", "all_in_focus.png", "depth_index.png"] {
        assert_eq!(image::open(dir.path("stack").join(name)).unwrap().dimensions(), (90, 60), "{name}");
    }
    for (motion, name) in [("focus-pull", "a.gif"), ("aperture-ramp", "b.webp"), ("circle", "c.png")] {
        export(&["--as", "animation", "--motion", motion, "-o", &dir.arg(name)]);
        assert_eq!(image::open(dir.path(name)).unwrap().dimensions(), (90, 60), "{name}");
    }
    let refocus = |name: &str, rest: &[&str]| {
        on_sample(&dir, "refocus", &[&["--size", "90x60", "-o", &dir.arg(name)], rest].concat()).success();
        fs::read(dir.path(name)).unwrap()
    };
    assert_eq!(refocus("middle.png", &[]), refocus("zero.png", &["--at", "0,0"]));
    assert_ne!(refocus("middle.png", &[]), refocus("left.png", &["--at", "-3,0"]));
}

#[test]
fn strength_is_the_same_through_every_command() {
    let dir = sample();
    let made = |command: &str, rest: &[&str], name: &str| {
        let out = dir.arg(name);
        on_sample(&dir, command, &[rest, &["-o", &out]].concat()).success().stdout("").stderr("");
        dir.arg(name)
    };
    let deep = made("depth", &["--strength", "2"], "deep.pfm");
    let plain = ["depth", &dir.arg("sample.png"), "--disparity", &deep, "-o", &dir.arg("same.pfm")];
    plenoscope(&plain).assert().success();
    assert_eq!(fs::read(&deep).unwrap(), fs::read(dir.path("same.pfm")).unwrap());
    // Typed numbers are those of strength 1; the map of a strength is a map like any other.
    let lens = ["--strength", "2", "--focus-disparity", "0.25", "--tilt", "0.5,0", "--f-number", "5"];
    let by_strength = made("refocus", &lens, "strength.png");
    let lens = ["--focus-disparity", "0.5", "--tilt", "1,0", "--f-number", "5", "--disparity", &deep];
    let by_map = dir.arg("map.png");
    plenoscope(&[&["refocus", &dir.arg("sample.png"), "-o", &by_map], &lens[..]].concat()).assert().success();
    assert_eq!(fs::read(by_strength).unwrap(), fs::read(by_map).unwrap());
    // What `synth` writes is what `view`, `epi` and `depth` see.
    let field = made("synth", &["--strength", "2"], "deep");
    for (command, rest) in [
        ("view", ["--at", "-2,1"]),
        ("epi", ["--row", "40"]),
        ("depth", ["--view", "0,7"]),
        ("depth", ["--view", "4,4"]),
    ] {
        let (own, of_field) =
            (made(command, &[&rest[..], &["--strength", "2"]].concat(), "own.png"), dir.arg("field.png"));
        plenoscope(&[&[command, &field, "-o", &of_field], &rest[..]].concat()).assert().success();
        let [own, of_field] = [own, of_field].map(|path| image::open(path).unwrap());
        let apart = own.as_bytes().iter().zip(of_field.as_bytes()).map(|(a, b)| a.abs_diff(*b)).max();
        // A map in 16 bits is spread over its own range.
        assert!(own.dimensions() == of_field.dimensions() && (command == "depth" || apart == Some(0)), "{command}");
    }
}

#[test]
fn places_are_kept_sharp_and_the_lens_is_told() {
    let dir = sample();
    let refocus = |name: &str, rest: &[&str]| {
        let out = dir.arg(name);
        let said = on_sample(&dir, "refocus", &[&["--json", "-o", &out], rest].concat()).success().stderr("");
        serde_json::from_slice::<serde_json::Value>(&said.get_output().stdout).unwrap()
    };
    // One place is a click; values may stand together or apart, before other options.
    refocus("click.png", &["--focus", "514,340", "--f-number", "2"]);
    refocus("one.png", &["--keep-sharp", "514,340", "--f-number", "2"]);
    assert_eq!(fs::read(dir.path("click.png")).unwrap(), fs::read(dir.path("one.png")).unwrap());
    let solved = refocus("together.png", &["--keep-sharp", "514,340", "200,300", "--quality", "90"]);
    refocus("apart.png", &["--keep-sharp", "514,340", "--keep-sharp", "200,300"]);
    assert_eq!(fs::read(dir.path("together.png")).unwrap(), fs::read(dir.path("apart.png")).unwrap());
    assert!(solved["f_number"].as_f64().unwrap() < 28.0, "{solved}");
    assert_eq!(solved["real_lens"]["scale"], "relative");
    assert!(solved["real_lens"]["focus_m"].is_null() && solved["real_lens"]["background_px"].is_number());
    let known = refocus("known.png", &["--focus", "514,340", "--distance", "60cm", "--sensor", "mft"]);
    assert!((known["real_lens"]["focus_m"].as_f64().unwrap() - 0.6).abs() < 1e-3, "{known}");
    assert_eq!(known["real_lens"]["format"], "Micro Four Thirds");
    let long = refocus("long.png", &["--focus", "514,340", "--length", "504,340..524,340=12mm"]);
    let width = image::image_dimensions(dir.path("long.png")).unwrap().0;
    // 20 px of the picture's width, behind 28 mm on 36 mm of film.
    let metres = 0.012 * 28.0 / 36.0 * f64::from(width) / 20.0;
    assert!((long["real_lens"]["focus_m"].as_f64().unwrap() - metres).abs() < 0.01 * metres, "{long} for {metres}");
    for wrong in [
        &["--length", "504,340..504,340=1m"][..],
        &["--length", "504,340..9999,340=1m"],
        &["--length", "504,340..524,340=long"],
        &["--length", "504,340=1m"],
        &["--length", "504,340..524,340=1m", "--distance", "2m"],
        &["--keep-sharp", "1,1", "2,2", "3,3", "4,4"],
        &["--keep-sharp", "1,1", "--keep-sharp", "-0.2..0.2"],
        &["--keep-sharp", "10,10", "--focus", "5,5"],
        &["--keep-sharp", "9999,1"],
        &["--distance", "0m"],
        &["--distance", "far"],
        &["--as-lens", "kit"],
        &["--lens", "picture:"],
        &["--lens", "picture:none.png"],
        &["--lens", "picture:Cargo.toml"],
    ] {
        on_sample(&dir, "refocus", &[&["-o", &dir.arg("wrong.png")], wrong].concat()).code(2).stdout("");
        assert!(!dir.path("wrong.png").exists(), "{wrong:?}");
    }
}

#[test]
fn a_lens_of_ones_own_is_taken_and_nonsense_is_one_sentence() {
    let dir = sample();
    let lens = |text: &str| {
        fs::write(dir.path("lens.toml"), text).unwrap();
        let args = ["--as-lens", &dir.arg("lens.toml"), "--focus", "514,340", "--json", "-o", &dir.arg("o.png")];
        on_sample(&dir, "refocus", &args)
    };
    // No focal length is known of the sample: 28 mm are assumed, and the same aperture is f/4 there.
    let said = lens("name = \"Tele\"\nfocal_mm = 56\nf_numbers = [8, 16]").success();
    let said: serde_json::Value = serde_json::from_slice(&said.get_output().stdout).unwrap();
    assert!((said["f_number"].as_f64().unwrap() - 4.0).abs() < 1e-3, "{said}");
    let refused = contains("this lens cannot be used").and(contains("lens.toml"));
    lens("name = 5").code(2).stderr(refused);
    let list = json(&["lenses", "--json"]);
    assert!(list["lenses"].as_array().unwrap().iter().any(|lens| lens["id"] == "helios-44-2-58-f2"), "{list}");
}

#[test]
fn what_was_recorded_is_made_flatter_but_not_deeper() {
    let dir = sample();
    on_sample(&dir, "synth", &["-o", &dir.arg("field")]).success();
    let depth = |strength: &str, name: &str| {
        let args = ["depth", &dir.arg("field"), "--strength", strength, "-o", &dir.arg(name)];
        let said = plenoscope(&args).assert().success().stdout("");
        (fs::read(dir.path(name)).unwrap(), String::from_utf8_lossy(&said.get_output().stderr).into_owned())
    };
    let (plain, nothing) = depth("1", "plain.pfm");
    let (deep, said) = depth("3", "deep.pfm");
    assert!(plain == deep && nothing.is_empty() && said.contains("strength is 1 at most"), "{said}");
    let (flat, nothing) = depth("0.5", "flat.pfm");
    assert!(plain != flat && nothing.is_empty());
    on_sample(&dir, "view", &["--at", "0,0", "--strength", "9", "-o", &dir.arg("v.png")]).code(2);
}

#[test]
fn the_input_is_not_written_over() {
    let dir = sample();
    let before = fs::read(dir.path("sample.png")).unwrap();
    let refused = starts_with("error: ").and(contains("--force"));
    on_sample(&dir, "view", &["--at", "0,0", "-o", &dir.arg("sample.png")]).code(1).stderr(refused);
    assert_eq!(fs::read(dir.path("sample.png")).unwrap(), before);
    on_sample(&dir, "view", &["--at", "0,0", "--force", "-o", &dir.arg("sample.png")]).success();
    assert_ne!(fs::read(dir.path("sample.png")).unwrap(), before);
}

#[test]
fn what_cannot_be_is_wrong_usage() {
    let dir = sample();
    let out = dir.arg("out.png");
    on_sample(&dir, "epi", &["-o", &out]).code(2);
    on_sample(&dir, "epi", &["--row", "80", "-o", &out]).code(2).stderr(contains("0 to 79"));
    on_sample(&dir, "depth", &["--view", "8,0", "-o", &out]).code(2);
    on_sample(&dir, "depth", &["--colormap", "turbo", "-o", &dir.arg("out.pfm")]).code(2);
    on_sample(&dir, "view", &["--at", "left", "-o", &out]).code(2);
    assert!(!dir.path("out.png").exists());
}

#[test]
fn a_target_that_cannot_be_is_one_line() {
    let dir = sample();
    let no_panic = contains("panicked").not();
    let one_line = || starts_with("error: ").and(contains(" — ")).and(contains("panicked").not());
    on_sample(&dir, "view", &["--at", "0,0", "-o", &dir.arg("away/out.png")]).code(1).stderr(one_line());
    on_sample(&dir, "view", &["--at", "0,0", "-o", &dir.arg("out.xyz")]).code(1).stderr(one_line());
    fs::create_dir(dir.path("folder.png")).unwrap();
    on_sample(&dir, "view", &["--at", "0,0", "-o", &dir.arg("folder.png")]).code(1).stderr(no_panic);
    // A file where a folder is needed fails for every user, root too.
    fs::write(dir.path("file"), b"in the way").unwrap();
    on_sample(&dir, "synth", &["-o", &dir.arg("file/field")]).code(1).stderr(one_line());
    assert_eq!(fs::read(dir.path("file")).unwrap(), b"in the way");
}

#[test]
fn a_map_that_is_no_map_is_one_line() {
    let dir = sample();
    fs::write(dir.path("sample.pfm"), b"Pf\n1200 800\n-1.0\ntoo short").unwrap();
    on_sample(&dir, "synth", &["-o", &dir.arg("field")])
        .code(1)
        .stderr(starts_with("error: ").and(contains("sample.pfm")));
    assert!(!dir.path("field").exists());
}

/// What Ctrl-C sends.
#[cfg(unix)]
#[test]
fn ctrl_c_stops_the_job_and_leaves_nothing() {
    use std::io::{BufRead, BufReader};
    use std::process::{Command, Stdio};

    let dir = sample();
    let mut command = Command::new(assert_cmd::cargo::cargo_bin!("plenoscope"));
    command.args(["-v", "synth", &dir.arg("sample.png"), "--disparity", &dir.arg("sample.pfm"), "--lambertian"]);
    command.args(["--long-side", "1200", "-o", &dir.arg("field")]).stderr(Stdio::piped());
    let mut program = command.spawn().unwrap();
    let mut said = BufReader::new(program.stderr.take().unwrap()).lines();
    assert!(said.next().unwrap().unwrap().contains("opened"));
    assert!(Command::new("kill").args(["-INT", &program.id().to_string()]).status().unwrap().success());
    assert_eq!(program.wait().unwrap().code(), Some(130));
    assert_eq!(said.filter(|line| line.as_ref().is_ok_and(|line| line.contains("error"))).count(), 0);
    let mut left: Vec<_> = fs::read_dir(dir.path("")).unwrap().map(|entry| entry.unwrap().file_name()).collect();
    left.sort();
    assert_eq!(left, ["sample.pfm", "sample.png"]);
}

fn json(args: &[&str]) -> serde_json::Value {
    let out = plenoscope(args).assert().success();
    serde_json::from_slice(&out.get_output().stdout).unwrap()
}

fn first_file(folder: &std::path::Path) -> String {
    let entry = fs::read_dir(folder).unwrap().next().unwrap().unwrap();
    entry.path().to_string_lossy().into_owned()
}

#[test]
fn every_command_takes_the_repairs_of_a_recipe() {
    let dir = sample();
    let click = r#"{"region": {"of": {"click": {"at": [0.43, 0.42], "size": 0.15}}, "do": {"farther": 0.003}}}"#;
    fs::write(dir.path("r.json"), format!(r#"{{"version": 2, "repairs": {{"list": [{click}]}}}}"#)).unwrap();
    let recipe = dir.arg("r.json");
    let differs = |command: &str, name: &str, rest: &[&str]| {
        let made = |name: &str, more: &[&str]| {
            on_sample(&dir, command, &[rest, more, &["-o", &dir.arg(name)]].concat()).success();
            fs::read(dir.path(name)).unwrap()
        };
        let (plain, mended) = (made(name, &[]), made(&format!("mended-{name}"), &["--recipe", &recipe]));
        assert!(plain != mended, "{command} is the same with repairs");
    };
    differs("refocus", "r.png", &[]);
    differs("view", "v.png", &["--at", "3,0"]);
    differs("epi", "e.png", &["--row", "33"]);
    differs("depth", "d.pfm", &[]);
    differs("depth", "d0.pfm", &["--view", "1,1"]);
    differs("export", "g.jpg", &["--as", "gdepth"]);
    differs("export", "s.png", &["--as", "side-by-side"]);
}

#[test]
fn repairs_that_cannot_be_done_are_told_in_one_sentence() {
    let dir = sample();
    let told = |text: &str| {
        fs::write(dir.path("r.json"), text).unwrap();
        let run = on_sample(&dir, "depth", &["--recipe", &dir.arg("r.json"), "-o", &dir.arg("d.pfm")]);
        let output = run.get_output();
        (output.status.success(), String::from_utf8(output.stderr.clone()).unwrap())
    };
    let stroke = r#"{"stroke": {"brush": "nearer", "path": [[0.5, 0.5]], "size": 0.01, "strength": 1}}"#;
    let strokes = vec![stroke; 10_000].join(",");
    for (list, said) in [
        (strokes.as_str(), "9000 repairs"),
        (r#"{"warp": 1}"#, "one repair"),
        (&stroke.replace("0.5, 0.5", "7, 7"), "one repair"),
    ] {
        let (is_done, said_there) = told(&format!(r#"{{"version": 2, "repairs": {{"list": [{list}]}}}}"#));
        assert!(is_done && said_there.matches(said).count() == 1, "{said_there}");
    }
    let other = "0".repeat(64);
    let (is_done, said) = told(&format!(r#"{{"version": 2, "repairs": {{"photo": "{other}", "list": [{stroke}]}}}}"#));
    assert!(is_done && said.contains("another photo"), "{said}");
    let (is_done, said) = told(r#"{"version": 2, "repairs": [1]}"#);
    assert!(!is_done && said.starts_with("error: ") && !said.contains("panicked"), "{said}");
}

#[test]
fn what_was_invented_is_told_and_tinted() {
    let dir = sample();
    let told = |name: &str, rest: &[&str]| {
        let known = ["--as", "trust", "-o", &dir.arg(name)];
        let run = on_sample(&dir, "depth", &[&known[..], rest].concat()).success();
        String::from_utf8(run.get_output().stdout.clone()).unwrap()
    };
    let (usual, much) = (told("t.png", &[]), told("t.pfm", &["--limit", "50", "--view", "4,0"]));
    assert!(usual.contains("2 % of the picture is invented") && usual != much, "{usual}{much}");
    assert!(much.contains("up to f/1.0"), "{much}");
    let tinted = image::open(dir.path("t.png")).unwrap().to_rgb8();
    on_sample(&dir, "view", &["--at", "0,0", "-o", &dir.arg("v.png")]).success();
    let plain = image::open(dir.path("v.png")).unwrap().to_rgb8();
    let changed = tinted.pixels().zip(plain.pixels()).filter(|(a, b)| a != b).count();
    assert!(changed > 50 && changed < 120 * 80 / 2, "{changed} pixels are tinted");
    assert!(fs::read(dir.path("t.pfm")).unwrap().starts_with(b"Pf\n120 80\n"));
}
