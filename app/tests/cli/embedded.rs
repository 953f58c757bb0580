//! Pictures that know how they were made: the way back from each format, what other programs see in them, and what a
//! stranger's picture cannot do.

use std::fs;
use std::path::Path;
use std::process::Command;

use serde_json::Value;

use crate::common::{Scratch, plenoscope};

const FORMATS: [&str; 4] = ["jpg", "png", "tif", "webp"];

/// A photo with a depth inside, so that no net has to run.
fn photo(dir: &Scratch) -> String {
    plenoscope(&["sample", "-o", &dir.arg("")]).assert().success();
    let photo = image::open(dir.path("sample.png")).unwrap();
    photo.resize_exact(300, 200, image::imageops::FilterType::Triangle).save(dir.path("small.png")).unwrap();
    let known = ["--disparity", &dir.arg("sample.pfm"), "--lambertian"];
    let made = ["export", &dir.arg("small.png"), "--as", "gdepth", "-o", &dir.arg("photo.jpg")];
    plenoscope(&[&made[..], &known].concat()).assert().success();
    dir.arg("photo.jpg")
}

const EDIT: [&str; 8] = ["--source", "phone", "--f-number", "2", "--focus", "100,90", "--strength", "1.5"];

fn export(photo: &str, out: &str, embed: &str) {
    plenoscope(&[&["refocus", photo, "-o", out, "--embed", embed], &EDIT[..]].concat()).assert().success();
}

fn again(picture: &str, out: &str) -> Vec<u8> {
    plenoscope(&["refocus", picture, "--recipe", "embedded", "-o", out]).assert().success();
    fs::read(out).unwrap()
}

#[test]
fn a_picture_leads_back_to_the_same_bytes_from_every_format() {
    let dir = Scratch::new();
    let photo = photo(&dir);
    for format in FORMATS {
        let (picture, other) = (dir.arg(&format!("a.{format}")), dir.arg(&format!("b.{format}")));
        export(&photo, &picture, "recipe,depth");
        assert!(again(&picture, &other) == fs::read(&picture).unwrap(), "{format}: beside its photo");
        let plain = dir.arg(&format!("plain.{format}"));
        plenoscope(&[&["refocus", &photo, "-o", &plain], &EDIT[..]].concat()).assert().success();
        let pixels = |path: &str| image::open(path).unwrap().into_rgb8();
        assert!(pixels(&plain) == pixels(&picture), "{format}: what goes along changes no pixel");

        let alone = Scratch::new();
        let picture = alone.arg(&format!("a.{format}"));
        export(&photo, &picture, "recipe,photo");
        assert!(again(&picture, &alone.arg(&format!("b.{format}"))) == fs::read(&picture).unwrap(), "{format}: alone");
    }
}

#[test]
fn the_photo_is_found_by_its_hash_whatever_it_is_called_now() {
    let dir = Scratch::new();
    let (photo, picture) = (photo(&dir), dir.arg("a.jpg"));
    export(&photo, &picture, "recipe");
    fs::rename(&photo, dir.path("renamed.jpg")).unwrap();
    fs::write(&photo, "another file of that name").unwrap();
    assert!(again(&picture, &dir.arg("b.jpg")) == fs::read(&picture).unwrap());
    fs::remove_file(dir.path("renamed.jpg")).unwrap();
    let done = plenoscope(&["refocus", &picture, "--recipe", "embedded", "-o", &dir.arg("c.jpg")]).assert().code(1);
    let said = String::from_utf8_lossy(&done.get_output().stderr).into_owned();
    assert!(said.contains("photo.jpg was moved or changed") && said.lines().count() == 1, "{said}");
}

/// What a program prints; none, and said so, where it is not there.
fn told(program: &str, args: &[&str]) -> Option<String> {
    let done = Command::new(program).args(args).output().ok().filter(|done| done.status.success());
    if done.is_none() {
        eprintln!("SKIPPED: {program} {} does not run", args.first().unwrap_or(&""));
    }
    done.map(|done| String::from_utf8_lossy(&done.stdout).into_owned())
}

#[test]
fn other_programs_see_recipe_and_depth() {
    let dir = Scratch::new();
    let photo = photo(&dir);
    for format in FORMATS {
        let picture = dir.arg(&format!("a.{format}"));
        export(&photo, &picture, "recipe,depth");
        if let Some(text) = told("exiftool", &["-j", "-G1", "-b", &picture]) {
            let seen: Value = serde_json::from_str(&text).unwrap();
            let of = |name: &str| seen[0][name].as_str().unwrap_or_else(|| panic!("{format}: {name}")).to_owned();
            let recipe: Value = serde_json::from_str(&of("XMP-plenoscope:Recipe")).unwrap();
            assert_eq!(recipe["lens"]["f_number"], 2.0, "{format}");
            assert_eq!(
                (of("XMP-plenoscope:PhotoName"), of("XMP-GDepth:Format")),
                ("photo.jpg".into(), "RangeInverse".into())
            );
            assert!(of("XMP-GDepth:DepthImage").len() > 1000, "{format}");
        }
        let script =
            "import sys, PIL.Image; p = PIL.Image.open(sys.argv[1]); print(p.info.get('xmp') or p.tag_v2[700])";
        if let Some(text) = told("python3", &["-c", script, &picture]) {
            assert!(text.contains("plenoscope:PhotoSha256") && text.contains("GDepth:Near"), "{format}: {text:.300}");
        }
    }
}

#[test]
fn nothing_goes_along_where_it_is_not_asked_for_or_all_is_dropped() {
    let dir = Scratch::new();
    let photo = photo(&dir);
    let has = |name: &str| {
        let bytes = fs::read(dir.path(name)).unwrap();
        bytes.windows(16).any(|w| w == b"plenoscope:photo".as_slice() || w == b"urn:plenoscope:p".as_slice())
    };
    plenoscope(&[&["refocus", &photo, "-o", &dir.arg("a.jpg")], &EDIT[..]].concat()).assert().success();
    assert!(!has("a.jpg"));
    export(&photo, &dir.arg("b.jpg"), "recipe");
    assert!(has("b.jpg"));
    plenoscope(&["refocus", &dir.arg("b.jpg"), "--recipe", "embedded", "--strip-metadata", "-o", &dir.arg("c.jpg")])
        .assert()
        .success();
    assert!(!has("c.jpg"), "dropped with all the rest");
    plenoscope(&["refocus", &dir.arg("b.jpg"), "--source", "phone", "-o", &dir.arg("d.jpg")]).assert().success();
    assert!(!has("d.jpg"), "of another picture's edit nothing is kept");
    let both = ["refocus", &photo, "-o", &dir.arg("e.jpg"), "--embed", "recipe", "--strip-metadata"];
    plenoscope(&both).assert().code(2);
}

/// A PNG with a packet of its own in place of the one that was written.
fn forged(picture: &Path, change: impl Fn(&str) -> String) -> Vec<u8> {
    let whole = fs::read(picture).unwrap();
    let key = b"XML:com.adobe.xmp";
    let at = whole.windows(key.len()).position(|w| w == key).unwrap() - 8;
    let length = u32::from_be_bytes(whole[at..at + 4].try_into().unwrap()) as usize;
    let head = [key.as_slice(), &[0; 5]].concat();
    let text = String::from_utf8(whole[at + 8 + head.len()..at + 8 + length].to_vec()).unwrap();
    let body = [b"iTXt".as_slice(), &head, change(&text).as_bytes()].concat();
    let mut crc = !0u32;
    for byte in &body {
        crc ^= u32::from(*byte);
        (0..8).for_each(|_| crc = (crc >> 1) ^ (0xedb8_8320 & (crc & 1).wrapping_neg()));
    }
    let length = (body.len() as u32 - 4).to_be_bytes();
    [
        &whole[..at],
        &length,
        &body,
        &(!crc).to_be_bytes(),
        &whole[at + 12 + u32::from_be_bytes(whole[at..at + 4].try_into().unwrap()) as usize..],
    ]
    .concat()
}

#[test]
fn what_a_stranger_wrote_is_one_sentence_and_reads_nothing_else() {
    let dir = Scratch::new();
    let photo = photo(&dir);
    export(&photo, &dir.arg("a.png"), "recipe,photo");
    let secret = dir.arg("secret.jpg");
    fs::copy(&photo, &secret).unwrap();
    let inside = dir.path("inside");
    fs::create_dir(&inside).unwrap();
    let between = |text: &str, from: &str, new: &str| {
        let start = text.find(from).unwrap_or_else(|| panic!("{from}")) + from.len();
        let end = start + text[start..].find('"').unwrap();
        [&text[..start], new, &text[end..]].concat()
    };
    let deep = "[".repeat(100_000);
    let cases: [(&str, &str, String, &str); 9] = [
        ("cut base64", "plenoscope:Photo=\"", "AAAA".into(), "damaged"),
        ("no base64", "plenoscope:Photo=\"", "<!--".replace('<', "&lt;"), "base64"),
        ("another hash", "PhotoSha256=\"", "0".repeat(64), "damaged"),
        ("a path", "PhotoName=\"", "../secret.jpg".into(), "no plain file name"),
        ("deep", "Recipe=\"", deep, "cannot be used"),
        ("a script", "Recipe=\"", "&lt;script&gt;alert(1)&lt;/script&gt;".into(), "cannot be used"),
        (
            "a number out of range",
            "Recipe=\"",
            "{&quot;version&quot;: 2, &quot;lens&quot;: {&quot;f_number&quot;: -2}}".into(),
            "out of range",
        ),
        ("a later version", "plenoscope:Version=\"", "9".into(), "later version"),
        ("no XML", "Recipe=\"", "\"/></nothing><x a=\"".into(), "its XMP is not XML"),
    ];
    for (what, from, new, why) in cases {
        let picture = inside.join("picture.png");
        fs::write(&picture, forged(&dir.path("a.png"), |text| between(text, from, &new))).unwrap();
        let picture = picture.to_string_lossy().into_owned();
        let out = dir.arg("out.png");
        let done = plenoscope(&["refocus", &picture, "--recipe", "embedded", "-o", &out]).assert().code(1);
        let said = String::from_utf8_lossy(&done.get_output().stderr).into_owned();
        assert!(said.contains(why) && said.lines().count() == 1 && said.matches(" — ").count() >= 2, "{what}: {said}");
        assert!(!Path::new(&out).exists(), "{what}");
        plenoscope(&["info", &picture]).assert().success();
    }
}
