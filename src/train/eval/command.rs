//! `plenoscope-train eval`: the figures of a models folder, for people or as JSON.

use std::fmt::Write as _;
use std::path::PathBuf;

use anyhow::Result;
use clap::{ArgMatches, Command, arg, value_parser};
use indicatif::{ProgressBar, ProgressStyle};
use plenoscope::io::{self, Opened};
use plenoscope::job::{Cancel, Job};
use plenoscope::shard::Shard;
use plenoscope::synth::Scale;
use serde_json::{Value, json};

use super::light_field::{Closeness, Figures};
use super::photos::LONG_SIDE;
use super::{Models, Predictor, TrueField, constructed, light_field, phone, photos, sheet, truth};
use crate::scenes;

/// Width of a picture on a contact sheet.
const TILE: usize = 240;

/// What the command line understands.
pub fn command() -> Command {
    let path = || value_parser!(PathBuf);
    Command::new("eval")
        .about("Figures on light fields, on photos with a phone's depth and on validation photos")
        .arg(arg!([FILE] ... "Light fields (views, HCI, ESLF) and photos with a phone's depth").value_parser(path()))
        .arg(arg!(--photos "The validation photos of the data folder, too"))
        .arg(arg!(--data <DIR> "Folder of flowers/ and everyday/").default_value("data").value_parser(path()))
        .arg(arg!(--scenes <N> "Constructed validation scenes").default_value("24").value_parser(value_parser!(usize)))
        .arg(
            arg!(--depth <DIR> "Photos with measured depth, as everyday10k holds them")
                .required(false)
                .value_parser(path()),
        )
        .arg(
            arg!(--solid <N> "Scenes in three dimensions, of meshes and textures of --data that training never sees")
                .default_value("0")
                .value_parser(value_parser!(usize)),
        )
        .arg(
            arg!(--"solid-px" <PX> "Width of those scenes, 4 to 3; a net is judged fairly at the size that it works at")
                .default_value("160")
                .value_parser(value_parser!(u16).range(64..=640)),
        )
        .arg(arg!(--models <DIR> "Models, laid out like models/").required(false).value_parser(path()))
        .arg(
            arg!(--net <NAME> "A depth net of theirs other than the pair's own, such as paper-flowers").required(false),
        )
        .arg(
            arg!(--scale <SCALE> "How far ray depths reach: deep, or lytro")
                .default_value("deep")
                .value_parser(value_parser!(Scale)),
        )
        .arg(arg!(--threads <N> "Threads; 0 means all").default_value("0").value_parser(value_parser!(usize)))
        .arg(arg!(--sheets <DIR> "Write contact sheets there").required(false).value_parser(path()))
        .arg(arg!(--json "One JSON object on stdout"))
        .arg(
            arg!(--shard <"K/N"> "The K-th of N parts of the files, by their names; means are over that part")
                .default_value("1/1")
                .conflicts_with_all(["photos", "depth", "solid"])
                .value_parser(value_parser!(Shard)),
        )
}

/// Evaluates as asked; gives what is to be printed.
///
/// # Errors
/// Bad input, in one sentence that names the file; what the nets say.
pub fn run(matches: &ArgMatches) -> Result<String> {
    let threads = matches.get_one::<usize>("threads").copied().unwrap_or(0);
    let folder = matches.get_one::<PathBuf>("models").map(PathBuf::as_path);
    let scale = matches.get_one::<Scale>("scale").copied().unwrap_or_default();
    let models = Models::load(folder, matches.get_one::<String>("net").map(String::as_str), scale, threads)?;
    let mut files: Vec<PathBuf> = matches.get_many("FILE").into_iter().flatten().cloned().collect();
    anyhow::ensure!(
        !files.is_empty() || ["photos", "depth", "solid"].iter().any(|name| given(matches, name)),
        "nothing to evaluate — give light fields, photos with depth, --photos, --depth DIR or --solid N"
    );
    let shard = matches.get_one::<Shard>("shard").copied().unwrap_or_default();
    files.retain(|file| shard.takes_file(file));
    let sheets = matches.get_one::<PathBuf>("sheets");
    if let Some(folder) = sheets {
        std::fs::create_dir_all(folder)?;
    }
    let put = |name: &str, rows: &[Vec<super::Rgb>]| -> Result<()> {
        let Some(folder) = sheets.filter(|_| !rows.is_empty()) else { return Ok(()) };
        Ok(sheet::write_png(&folder.join(name), &sheet::join(rows, TILE))?)
    };
    let found = evaluate_files(&files, &models)?;
    put("light_fields.png", &found.field_rows)?;
    put("phones.png", &found.phone_rows)?;
    let figures = found.fields;
    let photos = if matches.get_flag("photos") { Some(photo_figures(matches, &models, &put)?) } else { None };
    let judged = against_truth(matches, &models, &put)?;
    let tags: Vec<_> = models.tags().iter().map(|tag| json!({"id": tag.id, "sha256": tag.sha256})).collect();
    if matches.get_flag("json") {
        let value = json!({
            "models": tags, "light_fields": figures, "mean": mean_of(&figures), "phones": found.phones, "photos": photos,
            "truth": judged.iter().map(|(title, groups)| json!({"of": title, "kinds": groups})).collect::<Vec<_>>(),
        });
        return Ok(format!("{value}\n"));
    }
    let mut text = table(&figures);
    text.extend(found.phones.iter().map(phone_line));
    text.extend(judged.iter().map(|(title, groups)| truth::table(title, groups)));
    if let Some(photos) = photos {
        let _ = writeln!(text, "{}", serde_json::to_string_pretty(&photos)?);
    }
    Ok(text)
}

/// Whether an option was named on the command line.
fn given(matches: &ArgMatches, name: &str) -> bool {
    matches.value_source(name) == Some(clap::parser::ValueSource::CommandLine)
}

/// Measured depth and drawn scenes, as far as they are asked for.
fn against_truth(
    matches: &ArgMatches,
    models: &dyn Predictor,
    put: &PutSheet,
) -> Result<Vec<(String, Vec<truth::Group>)>> {
    let mut judged = Vec::new();
    if let Some(folder) = matches.get_one::<PathBuf>("depth") {
        let (pictures, notes) = scenes::measured(folder, LONG_SIDE)?;
        let report = judge(&pictures, models)?;
        put("measured.png", &report.rows)?;
        let notes: String = notes.iter().map(|note| format!("{note}\n")).collect();
        judged
            .push((format!("{notes}measured depth, places that no net is trained on"), truth::groups(&report.figures)));
    }
    let count = matches.get_one::<usize>("solid").copied().unwrap_or(0);
    if count > 0 {
        let data = matches.get_one::<PathBuf>("data").cloned().unwrap_or_default();
        let width = matches.get_one::<u16>("solid-px").copied().map_or(160, usize::from);
        let report = judge_scenes(data, count, width, models)?;
        put("scenes.png", &report.rows)?;
        judged.push((format!("scenes in three dimensions of {width} px, held out"), truth::groups(&report.figures)));
    }
    Ok(judged)
}

/// Figures, and pictures of some.
#[derive(Default)]
struct Judged {
    figures: Vec<truth::Figures>,
    rows: Vec<Vec<super::Rgb>>,
}

impl Judged {
    fn add(&mut self, found: &truth::Compared, of: [&str; 2], photo: &super::Rgb, every: usize) {
        if self.figures.len().is_multiple_of(every) {
            self.rows.push(found.tiles(photo));
        }
        self.figures.push(found.figures(of[0], of[1]));
    }
}

fn judge(pictures: &[scenes::Picture], models: &dyn Predictor) -> Result<Judged> {
    let mut judged = Judged::default();
    let bar = progress("measured depth");
    for picture in pictures {
        let Some(map) = &picture.nearness else { continue };
        let photo = picture.rgb.map(|texel| texel.map(|c| f32::from(c) / 255.0));
        let prediction = models.predict(&photo)?;
        let known = |i: usize| picture.holes.as_ref().is_none_or(|holes| holes.px[i] < 64);
        let truth: Vec<f32> =
            (0..map.px.len()).map(|i| if known(i) { f32::from(map.px[i]) } else { f32::NAN }).collect();
        let depth = prediction.view(scenes::REFERENCE, photo.px.len());
        let found = truth::Compared { size: photo.size, depth, truth: &truth };
        judged.add(&found, [&picture.id, &picture.kind], &photo, pictures.len().div_ceil(12));
        step(&bar, pictures.len());
    }
    bar.finish_and_clear();
    Ok(judged)
}

fn judge_scenes(data: PathBuf, count: usize, width: usize, models: &dyn Predictor) -> Result<Judged> {
    let size = [width, width * 3 / 4];
    let mix = scenes::Mix { lifted: 0.0, collage: 0.0, pseudo: 0.0, real: 0.0, solid: 1.0 };
    let split = scenes::Split::Val;
    let config = scenes::Config { data, long_side: width, crop: size, mix, split, ..Default::default() };
    let source = scenes::Source::new(&config)?;
    let mut judged = Judged::default();
    let bar = progress("scenes");
    for index in 0..count as u64 {
        let sample = source.solid_scene(index, size);
        let plane = size[0] * size[1];
        let px = (0..plane).map(|i| [0, 1, 2].map(|c| sample.rgb[c * plane + i])).collect();
        let photo = crate::scenes::raster::Raster { size, px };
        let prediction = models.predict(&photo)?;
        let depth = prediction.view(scenes::REFERENCE, plane);
        let found = truth::Compared { size, depth, truth: &sample.disparity };
        judged.add(&found, [&index.to_string(), &sample.origin], &photo, count.div_ceil(12));
        step(&bar, count);
    }
    bar.finish_and_clear();
    Ok(judged)
}

/// What was found on the files that were named, and pictures of it.
#[derive(Default)]
struct Found {
    fields: Vec<Figures>,
    field_rows: Vec<Vec<super::Rgb>>,
    phones: Vec<phone::Figures>,
    phone_rows: Vec<Vec<super::Rgb>>,
}

fn evaluate_files(files: &[PathBuf], models: &dyn Predictor) -> Result<Found> {
    let mut found = Found::default();
    let cancel = Cancel::default();
    let bar = progress("files");
    for path in files {
        match io::open(path, &Job { cancel: &cancel, sink: &() })? {
            Opened::LightField(file) => {
                let report = light_field::evaluate(&TrueField::of(path, *file)?, models)?;
                found.fields.push(report.figures);
                found.field_rows.push(report.tiles);
            }
            Opened::Photo(file) => {
                let (figures, tiles) = phone::evaluate(path, &file, models)?;
                found.phones.push(figures);
                found.phone_rows.push(tiles);
            }
        }
        step(&bar, files.len());
    }
    bar.finish_and_clear();
    Ok(found)
}

fn phone_line(found: &phone::Figures) -> String {
    format!(
        "{}: Spearman with the depth that came with it {:.3} (the row number alone: {:.3}), over {:.0} % of the picture\n",
        found.name,
        found.spearman,
        found.rows_spearman,
        100.0 * found.known
    )
}

/// A bar on the terminal's error stream, none where that is no terminal.
fn progress(what: &'static str) -> ProgressBar {
    let style = ProgressStyle::with_template("{msg} {wide_bar} {pos}/{len}, {eta} left")
        .unwrap_or_else(|_| ProgressStyle::default_bar());
    ProgressBar::new(0).with_style(style).with_message(what)
}

fn step(bar: &ProgressBar, all: usize) {
    bar.set_length(all as u64);
    bar.inc(1);
}

/// Writes the rows of a contact sheet under a name.
type PutSheet<'a> = dyn Fn(&str, &[Vec<super::Rgb>]) -> Result<()> + 'a;

fn photo_figures(matches: &ArgMatches, models: &dyn Predictor, put: &PutSheet) -> Result<Value> {
    let data = matches.get_one::<PathBuf>("data").cloned().unwrap_or_default();
    let scenes = matches.get_one::<usize>("scenes").copied().unwrap_or(24);
    let bar = progress("photos");
    let report = photos::evaluate(&data, models, 12, &|all| step(&bar, all))?;
    bar.finish_and_clear();
    put("photos.png", &report.tiles)?;
    let bar = progress("constructed scenes");
    let built = constructed::evaluate(&data, models, scenes, &|all| step(&bar, all))?;
    bar.finish_and_clear();
    put("constructed.png", &built.tiles)?;
    Ok(json!({"folders": report.summaries, "constructed": built.figures}))
}

/// The mean of every number that the light fields have in common.
fn mean_of(figures: &[Figures]) -> Value {
    let values: Vec<Value> = figures.iter().filter_map(|f| serde_json::to_value(f).ok()).collect();
    values.first().map_or(Value::Null, |first| mean_value(first, &values.iter().collect::<Vec<_>>()))
}

fn mean_value(like: &Value, all: &[&Value]) -> Value {
    match like {
        Value::Number(_) => json!(all.iter().filter_map(|v| v.as_f64()).sum::<f64>() / all.len() as f64),
        Value::Array(items) => {
            let column = |i: usize| all.iter().filter_map(|v| v.get(i)).collect::<Vec<_>>();
            items.iter().enumerate().map(|(i, item)| mean_value(item, &column(i))).collect()
        }
        Value::Object(fields) => {
            let column = |key: &str| all.iter().filter_map(|v| v.get(key)).collect::<Vec<_>>();
            let numbers = fields.iter().filter(|(_, value)| !value.is_string());
            Value::Object(numbers.map(|(key, value)| (key.clone(), mean_value(value, &column(key)))).collect())
        }
        _ => Value::Null,
    }
}

fn table(figures: &[Figures]) -> String {
    let mut text = String::new();
    for f in figures {
        let c = &f.corners;
        let _ = writeln!(
            text,
            "{}: corner L1 copy {:.4}, flat {:.4}, predicted {:.4}, fit {:.4}, sweep {:.4}: {:.0} % closed (by the \
             swept depth {:.0} %: {:.2} of what is possible by one map); depth correlation {:.2}, MAE {:.3} px",
            f.name,
            c.copy,
            c.flat,
            c.predicted,
            c.fit,
            c.sweep,
            100.0 * c.closed,
            100.0 * c.swept_depth_closed,
            c.of_possible,
            f.depth_correlation,
            f.depth_mae_px
        );
        let ratio = f.full.l1_01 / f.zero.l1_01.max(1e-6);
        let _ = writeln!(text, "  nothing fitted: L1 of all views {ratio:.3} of that of copying the photo");
        if let Some(t) = &f.truth {
            let views = if t.views == 1 { "the reference view".to_owned() } else { format!("{} views", t.views) };
            let _ = writeln!(
                text,
                "  true ray depths of {views}: correlation {:.2}, MAE {:.3} px, {:.3} after the best scale and shift",
                t.correlation, t.mae_px, t.fit_mae_px
            );
        }
        let line = |name: &str, v: &Closeness| {
            format!(
                "  {name:<10} L1 {:.4} (outermost {:.4}), in −1 … 1 {:.4} ({:.4}); PSNR {:.2} dB, SSIM {:.4}\n",
                v.l1_01, v.outer_l1_01, v.l1_11, v.outer_l1_11, v.psnr, v.ssim
            )
        };
        let all = [("full", &f.full), ("lambertian", &f.lambertian), ("zero", &f.zero), ("plane", &f.plane)];
        text.extend(all.iter().map(|(name, v)| line(name, v)));
        text.push_str(&line("sweep", &f.sweep));
    }
    text
}
