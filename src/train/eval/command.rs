//! `plenoscope-train eval`: the figures of a models folder, for people or as JSON.

use std::fmt::Write as _;
use std::path::PathBuf;

use anyhow::Result;
use clap::{ArgMatches, Command, arg, value_parser};
use indicatif::{ProgressBar, ProgressStyle};
use plenoscope::io::{self, Opened};
use plenoscope::job::{Cancel, Job};
use serde_json::{Value, json};

use super::light_field::{Closeness, Figures};
use super::{Models, Predictor, TrueField, constructed, light_field, phone, photos, sheet};

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
        .arg(arg!(--models <DIR> "Models, laid out like models/").required(false).value_parser(path()))
        .arg(
            arg!(--net <NAME> "A depth net of theirs other than the pair's own, such as paper-flowers").required(false),
        )
        .arg(arg!(--threads <N> "Threads; 0 means all").default_value("0").value_parser(value_parser!(usize)))
        .arg(arg!(--sheets <DIR> "Write contact sheets there").required(false).value_parser(path()))
        .arg(arg!(--json "One JSON object on stdout"))
}

/// Evaluates as asked; gives what is to be printed.
///
/// # Errors
/// Bad input, in one sentence that names the file; what the nets say.
pub fn run(matches: &ArgMatches) -> Result<String> {
    let threads = matches.get_one::<usize>("threads").copied().unwrap_or(0);
    let folder = matches.get_one::<PathBuf>("models").map(PathBuf::as_path);
    let models = Models::load(folder, matches.get_one::<String>("net").map(String::as_str), threads)?;
    let files: Vec<PathBuf> = matches.get_many("FILE").into_iter().flatten().cloned().collect();
    anyhow::ensure!(
        !files.is_empty() || matches.get_flag("photos"),
        "nothing to evaluate — give light fields, photos with depth, or --photos"
    );
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
    let tags: Vec<_> = models.tags().iter().map(|tag| json!({"id": tag.id, "sha256": tag.sha256})).collect();
    if matches.get_flag("json") {
        let value = json!({
            "models": tags, "light_fields": figures, "mean": mean_of(&figures), "phones": found.phones, "photos": photos,
        });
        return Ok(format!("{value}\n"));
    }
    let mut text = table(&figures);
    text.extend(found.phones.iter().map(phone_line));
    if let Some(photos) = photos {
        let _ = writeln!(text, "{}", serde_json::to_string_pretty(&photos)?);
    }
    Ok(text)
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
             swept depth {:.0} %); depth correlation {:.2}, MAE {:.3} px",
            f.name,
            c.copy,
            c.flat,
            c.predicted,
            c.fit,
            c.sweep,
            100.0 * c.closed,
            100.0 * c.swept_depth_closed,
            f.depth_correlation,
            f.depth_mae_px
        );
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
