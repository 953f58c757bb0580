//! All that reads what strangers send, and small whole files of it: for damage at random, and for the fuzzer in `fuzz/`.
//!
//! Where plain bytes would stay at the door, they are what lies behind it: the checksums around them are right.

use std::fmt::Display;
use std::fs;
use std::path::{Path, PathBuf};

use image::ImageFormat;
use plenoscope::io::carried::PhotoTag;
use plenoscope::io::formats::{TABLE, depth_map};
use plenoscope::io::{self, OpenError, Opened, opening, several};
use plenoscope::job::{Cancel, Job};
use plenoscope::markup;
use plenoscope::scene::real::KnownLens;
use plenoscope::scene::training::Run;
use plenoscope::scene::{Recipe, Restored};
use plenoscope::synth::Manifest;
use plenoscope::synth::tract::{Options, prepare};
use tempfile::TempDir;

use crate::nets;
use crate::seeds::{self, As, Seed};

/// Reads a file; what it says of one that cannot be read.
type Read = Box<dyn Fn(&[u8]) -> Result<(), String>>;

/// One reader, with whole files for it.
pub struct Reader {
    /// What it is called on the command line of tests and fuzzer.
    pub name: String,
    /// Files that it reads without complaint.
    pub whole: Vec<Vec<u8>>,
    /// What reads.
    pub read: Read,
}

/// The longest packet that fits into a segment of a JPEG.
const LONGEST_PACKET: usize = 60_000;

/// Every reader.
pub fn all() -> Vec<Reader> {
    let of_table = TABLE.iter().filter(|line| line.is_read()).flat_map(|line| seeds::of(line.name)).map(of_seed);
    let others = [pictures(), packets(), lytro(), recipes(), nets_and_manifests()].into_iter().flatten();
    of_table.chain(others).collect()
}

fn reader<T, E: Display>(name: &str, whole: Vec<Vec<u8>>, read: impl Fn(&[u8]) -> Result<T, E> + 'static) -> Reader {
    let read = Box::new(move |bytes: &[u8]| read(bytes).map(drop).map_err(|error| error.to_string()));
    Reader { name: name.to_owned(), whole, read }
}

/// A reader of paths: what is given lies there under this name.
fn at_path<T, E: Display>(
    name: &str,
    file: &'static str,
    whole: Vec<Vec<u8>>,
    read: impl Fn(&Path) -> Result<T, E> + 'static,
) -> Reader {
    let folder = TempDir::new().unwrap();
    reader(name, whole, move |bytes| {
        let path = folder.path().join(file);
        fs::write(&path, mended(bytes)).unwrap();
        read(&path)
    })
}

/// Of a PNG the checksums are made right, so that damage reaches what lies behind them.
fn mended(bytes: &[u8]) -> Vec<u8> {
    let mut bytes = bytes.to_vec();
    if bytes.starts_with(b"\x89PNG") {
        seeds::mend_png(&mut bytes);
    }
    bytes
}

fn with_job<T>(run: impl FnOnce(&Job) -> T) -> T {
    run(&Job { cancel: &Cancel::default(), sink: &() })
}

fn of_seed(seed: Seed) -> Reader {
    let Seed { parser, opened, whole } = seed;
    match opened {
        As::File(name) => reader(&parser, whole, move |bytes| io::open_bytes(&mended(bytes), Some(Path::new(name)))),
        As::Map => at_path(&parser, "map", whole, depth_map::read),
        // One file of a folder at a time is damaged.
        As::In { folder, file, open } => {
            let first = whole[0].clone();
            reader(&parser, whole, move |bytes| {
                let path = folder.path().join(file);
                fs::write(&path, mended(bytes)).unwrap();
                let opened = with_job(|job| io::open(&folder.path().join(open), job));
                fs::write(&path, &first).unwrap();
                opened
            })
        }
    }
}

/// Pictures as something else than a photo, and what codecs read in containers that are right.
fn pictures() -> Vec<Reader> {
    vec![
        at_path("aperture", "a.png", vec![seeds::still(ImageFormat::Png)], opening::read),
        at_path("several", "a.mpo", seeds::several(), |path| with_job(|job| several::photos(path, job))),
        within_media("avif-data", seeds::avif()[0].clone()),
        within_media("heic-data", seeds::heic()),
    ]
}

/// Damage in the data of a picture, in a container that is right.
fn within_media(name: &str, whole: Vec<u8>) -> Reader {
    let start = whole.windows(4).position(|window| window == b"mdat").unwrap() + 4;
    reader(name, vec![whole[start..].to_vec()], move |bytes| {
        let mut data = bytes.to_vec();
        data.resize(whole.len() - start, 0);
        io::open_bytes(&[&whole[..start], &data].concat(), None)
    })
}

fn packet(text: &str) -> Vec<u8> {
    seeds::jpeg(&[seeds::xmp(text)])
}

/// XMP in a JPEG: as it is, and with the edit of a picture that this program has made.
fn packets() -> Vec<Reader> {
    let folder = TempDir::new().unwrap();
    let photo = seeds::jpeg(&[]);
    fs::write(folder.path().join("a.jpg"), &photo).unwrap();
    let tag = PhotoTag::of("a.jpg", &photo);
    let around = move |recipe: &str| {
        let (sha256, bytes, recipe) = (&tag.sha256, tag.bytes, markup::escaped(recipe));
        format!(
            r#"<x:xmpmeta xmlns:x="adobe:ns:meta/"><rdf:RDF xmlns:rdf="http://www.w3.org/1999/02/22-rdf-syntax-ns#">
            <rdf:Description xmlns:p="urn:plenoscope:picture:1.0/" p:Version="1" p:PhotoName="a.jpg"
            p:PhotoSha256="{sha256}" p:PhotoBytes="{bytes}" p:Recipe="{recipe}"/></rdf:RDF></x:xmpmeta>"#
        )
    };
    let line = Recipe::default().to_line();
    let whole = vec![around(&line).into_bytes(), seeds::depth_packet(300).into_bytes()];
    let xmp = reader("xmp", whole, |bytes| {
        io::open_bytes(&packet(&String::from_utf8_lossy(&bytes[..bytes.len().min(LONGEST_PACKET)])), None)
    });
    let carried = reader("carried", vec![line.into_bytes(), film()], move |bytes| {
        let text = String::from_utf8_lossy(&bytes[..bytes.len().min(LONGEST_PACKET / 8)]);
        let opened = io::open_bytes(&packet(&around(&text)), None).map_err(|error| error.to_string())?;
        let Opened::Photo(file) = opened else { return Ok(()) };
        // A character that no XML may hold costs the whole packet, and then there is no edit.
        let Some(found) = file.carried else { return Ok(()) };
        let picture = folder.path().join("out.jpg");
        with_job(|job| Restored::of(&found, &picture, job)).map(drop).map_err(|error| error.to_string())
    });
    vec![xmp, carried]
}

/// What lies behind the checksums of Lytro's container.
fn lytro() -> Vec<Reader> {
    const SHAPE: &str = r#""width":2,"height":2"#;
    let open = |table: &[u8], json: &str| {
        io::open_bytes(&seeds::lfp([&seeds::still(ImageFormat::Jpeg), &seeds::jpeg(&[])], table, json), None)
    };
    vec![
        reader("lfp-json", vec![SHAPE.as_bytes().to_vec()], move |bytes| {
            open(&seeds::lfp_table(), &String::from_utf8_lossy(bytes))
        }),
        reader("lfp-table", vec![seeds::lfp_table()], move |bytes| open(bytes, SHAPE)),
        reader("lfp-picture", vec![seeds::jpeg(&[])], |bytes| {
            io::open_bytes(&seeds::lfp([bytes, &seeds::jpeg(&[])], &seeds::lfp_table(), SHAPE), None)
        }),
    ]
}

/// A recipe with a film of three keys.
fn film() -> Vec<u8> {
    let mut recipe: serde_json::Value = serde_json::from_str(&Recipe::default().to_line()).unwrap();
    recipe["timeline"] = serde_json::json!({"seconds": 2.0, "keys": [
        {"at": 0.0, "f_number": 2.0, "eye": [-1.0, 0.5]},
        {"at": 0.5, "focus": {"disparity": 0.01}, "strength": 1.5},
        {"at": 1.0, "f_number": 8.0, "eye": [2.0, 0.0]},
    ]});
    recipe.to_string().into_bytes()
}

/// What a person can be sent as an edit, a lens, or a run of the trainer.
fn recipes() -> Vec<Reader> {
    let whole = vec![Recipe::default().to_json().into_bytes(), film()];
    let recipe = at_path("recipe", "a.json", whole, |path| {
        Recipe::read(path).map(|recipe| {
            let edit = recipe.edit(540);
            let _text = recipe.clone().with_edit(edit.clone()).to_json();
            let _name = recipe.export.file_name(Path::new("a.jpg"), &edit);
        })
    });
    let lens = "name = \"Mine 50 mm\"\nfocal_mm = 50.0\nf_numbers = [1.4, 16.0]\nblades = 9\nnearest_m = 0.45\n";
    let metrics = "{\"step\":20,\"losses\":{\"depth\":0.5,\"all\":1.5}}\n{\"step\":40,\"losses\":{\"depth\":0.25}}\n";
    vec![
        recipe,
        at_path("lens", "lens.toml", vec![lens.into()], KnownLens::read),
        at_path("metrics", "metrics.jsonl", vec![metrics.into()], |path| {
            let folder = path.parent().map(PathBuf::from).unwrap_or_default();
            Ok::<_, OpenError>(Run { data: folder.clone(), folder }.told())
        }),
    ]
}

fn nets_and_manifests() -> Vec<Reader> {
    let folder = TempDir::new().unwrap();
    nets::write_patches(folder.path(), "net");
    let whole = |name: &str| vec![fs::read(folder.path().join("net").join(name)).unwrap()];
    vec![
        reader("manifest", whole("manifest.toml"), |bytes| {
            Manifest::parse(&String::from_utf8_lossy(bytes), "manifest.toml")
        }),
        // What the engine says of a strange model can be long.
        reader("onnx", whole("model.onnx"), |bytes| {
            prepare(bytes, &[1, 3, 28, 28], &Options::default())
                .map_err(|_long| "the model cannot be used — it is damaged — get it again")
        }),
    ]
}
