//! `report.html`: one file with all figures and panels in it; beside it the same as SVG, PNG and JSON.

use std::collections::BTreeMap;
use std::fmt::Write as _;
use std::path::{Path, PathBuf};

use anyhow::Result;
use plenoscope::markup::escaped;
use serde::Serialize;

use super::charts::{Axes, Series, bars, lines};
use super::findings::{Finding, Found, L1_BAR, L1_BARS, disparity_places};
use super::judge::{Figures, LAMBERTIAN, title};
use super::panels::Panel;
use crate::eval::sheet::write_png;
use crate::files;

/// Light fields of which a table is shown without being asked for.
const OPEN: usize = 12;

/// Everything that the same seed gives again, to the byte.
#[derive(Serialize)]
pub struct Summary<'a> {
    /// How the light fields were parted.
    pub split: &'a str,
    /// Those that the methods were judged by.
    pub light_fields: Vec<&'a str>,
    /// Seed of nets, data and split.
    pub seed: u64,
    /// Steps that each method was trained.
    pub steps: BTreeMap<&'static str, u64>,
    /// Samples of a step, and the side of a crop in px.
    pub batch: usize,
    /// See `batch`.
    pub crop: usize,
    /// Last learning rate, relative to the first.
    pub lr_end: f32,
    /// Long side of the views that are judged.
    pub long_side: usize,
    /// The figures.
    #[serde(flatten)]
    pub found: &'a Found,
    /// Of each light field, by method.
    pub each: Vec<&'a BTreeMap<&'static str, Figures>>,
}

/// What differs from one machine to another, and so is no part of [`Summary`].
#[derive(Serialize)]
pub struct Times {
    /// Seconds for a light field of 187 × 270 × 8 × 8 with its ray depths; the paper: under 1 on a Titan X.
    pub synthesis_secs: Option<f64>,
    /// Threads.
    pub threads: usize,
}

/// Writes all files; gives the report's path.
///
/// # Errors
/// What the disk says.
pub fn write(out: &Path, summary: &Summary<'_>, panels: &[Panel], times: &Times) -> Result<PathBuf> {
    for folder in ["figures", "panels"] {
        std::fs::create_dir_all(out.join(folder))?;
    }
    let charts = charts(summary.found);
    for (name, svg) in &charts {
        files::write(&out.join("figures").join(format!("{name}.svg")), svg.as_bytes(), "write the figure")?;
    }
    let mut pictures = Vec::new();
    for panel in panels {
        let path = out.join("panels").join(format!("{}.png", panel.name));
        write_png(&path, &panel.picture)?;
        pictures.push((panel, std::fs::read(&path)?));
    }
    let json = format!("{}\n", serde_json::to_string_pretty(summary)?);
    files::write(&out.join("figures.json"), json.as_bytes(), "write the figures")?;
    files::write(
        &out.join("times.json"),
        format!("{}\n", serde_json::to_string_pretty(times)?).as_bytes(),
        "write the times",
    )?;
    let path = out.join("report.html");
    files::write(&path, html(summary, &charts, &pictures, times).as_bytes(), "write the report")?;
    Ok(path)
}

fn charts(found: &Found) -> Vec<(&'static str, String)> {
    let shown = ["ours", LAMBERTIAN, "flow", "regression"];
    let by_u = shown.iter().filter_map(|name| found.mean.get_key_value(name)).map(|(name, figures)| Series {
        name: title(name),
        values: figures.l1_by_u.iter().map(|v| f64::from(*v)).collect(),
    });
    let outermost = shown
        .iter()
        .filter_map(|name| found.outermost_histogram.get_key_value(name))
        .map(|(name, bars)| Series { name: title(name), values: bars.iter().map(|n| f64::from(*n)).collect() });
    let edge = |bar: usize| if bar.is_multiple_of(4) { format!("{:.2}", bar as f32 * L1_BAR) } else { String::new() };
    let u_axes = Axes { across: "u", up: "mean L1", places: (-4..4).map(|u: i32| u.to_string()).collect() };
    let l1_axes = Axes {
        across: "mean L1 of the outermost views, values in 0 … 1",
        up: "light fields",
        places: (0..L1_BARS).map(edge).collect(),
    };
    let px_axes =
        Axes { across: "disparity across the whole aperture, px", up: "share of rays", places: disparity_places() };
    vec![
        ("outermost-l1", bars(&l1_axes, &outermost.collect::<Vec<_>>())),
        ("l1-by-u", lines(&u_axes, &by_u.collect::<Vec<_>>())),
        ("disparities", bars(&px_axes, &[Series { name: "ours", values: found.disparities.clone() }])),
    ]
}

const STYLE: &str = "body{font:15px/1.5 system-ui,sans-serif;max-width:60rem;margin:2rem auto;padding:0 1rem;color:#111}\
table{border-collapse:collapse}td,th{padding:.2rem .8rem;border-bottom:1px solid #ccc;text-align:right}\
td:first-child,th:first-child{text-align:left}figure{margin:1.5rem 0;break-inside:avoid}\
img,svg{max-width:100%;height:auto}img{image-rendering:pixelated}.holds{color:#067}.not{color:#b30}\
.each{font-size:.7rem}.each th{font-weight:400}.each td,.each th{padding:.1rem .3rem}\
@media print{body{margin:0;max-width:none}h2{break-after:avoid}}";

fn html(summary: &Summary<'_>, charts: &[(&str, String)], pictures: &[(&Panel, Vec<u8>)], times: &Times) -> String {
    let mut page = format!(
        "<!doctype html>\n<html lang=\"en\"><head><meta charset=\"utf-8\"><title>The paper, run again</title>\
         <style>{STYLE}</style></head><body>\n<h1>Learning to synthesize a 4D RGBD light field from a single image, run again</h1>\n"
    );
    let mut put = |text: String| writeln!(page, "{text}").unwrap_or_default();
    put(format!("<p>Light fields parted {}. Judged by {}.</p>", summary.split, judges(&summary.light_fields)));
    let steps: Vec<String> = summary.steps.iter().map(|(name, steps)| format!("{} {steps}", title(name))).collect();
    put(format!(
        "<p>Steps trained: {}; {} crops of {}² a step (the paper: 4 of 96², 120,000 steps), the rate falls to {} of its \
         first (the paper: 1), seed {}. L1 is of values in 0 … 1, views {} px on their long side.</p>",
        steps.join(", "),
        summary.batch,
        summary.crop,
        summary.lr_end,
        summary.seed,
        summary.long_side
    ));
    put("<h2>Mean L1</h2>".into());
    put(table(summary.found));
    put(each(summary));
    put("<h2>What the paper found, and what is found here</h2>".into());
    for finding in &summary.found.findings {
        put(statement(finding));
        if let Some((_, svg)) = charts.iter().find(|(name, _)| *name == finding.figure) {
            put(format!("<figure>{svg}</figure>"));
        }
        for (panel, png) in pictures.iter().filter(|(panel, _)| panel.name == finding.figure) {
            put(figure(panel, png));
        }
    }
    put("<h2>Panels</h2>".into());
    let told = |panel: &Panel| summary.found.findings.iter().any(|finding| finding.figure == panel.name);
    for (panel, png) in pictures.iter().filter(|(panel, _)| !told(panel)) {
        put(figure(panel, png));
    }
    if let Some(secs) = times.synthesis_secs {
        put("<h2>Time</h2>".into());
        put(format!(
            "<p>187 × 270 × 8 × 8 with ray depths: {secs:.2} s on {} threads, by the trainer's own path (the paper: under 1 s on a \
             Titan X).</p>",
            times.threads
        ));
    }
    put("</body></html>".into());
    page
}

/// What was judged by: a few by name, many by number, as the table of each names them.
fn judges(names: &[&str]) -> String {
    if names.len() > OPEN { format!("{} light fields", names.len()) } else { escaped(&names.join(", ")) }
}

fn table(found: &Found) -> String {
    let mut rows: Vec<_> = found.mean.iter().collect();
    rows.sort_by(|a, b| a.1.l1.total_cmp(&b.1.l1));
    let optional =
        |value: Option<f32>, digits: usize| value.map_or_else(|| "–".to_owned(), |v| format!("{v:.digits$}"));
    let row = |(name, f): &(&&str, &Figures)| {
        format!(
            "<tr><td>{}</td><td>{:.4}</td><td>{:.4}</td><td>{:.4}</td><td>{}</td><td>{}</td></tr>",
            title(name),
            f.l1,
            f.outermost_l1,
            f.unseen_l1,
            optional(f.inconsistency_px, 3),
            optional(f.depth_correlation, 2)
        )
    };
    let rows: String = rows.iter().map(row).collect();
    format!(
        "<table><tr><th>method</th><th>all views</th><th>outermost</th><th>without corners</th><th>ψ_c, px</th>\
         <th>depth as measured</th></tr>{rows}</table>\
         <p>ψ_c, px: how far ray depths part along epipolar lines. Depth as measured: correlation of the reference view's \
         ray depths with those of the whole light field, or the file's own.</p>"
    )
}

/// Mean L1 of each light field by each method.
fn each(summary: &Summary<'_>) -> String {
    let names: Vec<&str> = summary.found.mean.keys().copied().collect();
    let cell = |figures: &Figures| format!("<td>{:.4}</td>", figures.l1);
    let row = |(field, figures): (&&str, &&BTreeMap<&'static str, Figures>)| {
        let cells: String =
            names.iter().map(|name| figures.get(name).map_or_else(|| "<td>–</td>".into(), cell)).collect();
        format!("<tr><td>{}</td>{cells}</tr>", escaped(field))
    };
    let rows: String = summary.light_fields.iter().zip(&summary.each).map(row).collect();
    let heads: String = names.iter().map(|name| format!("<th>{}</th>", title(name))).collect();
    format!(
        "<details{}><summary>Each light field, all views</summary><table class=\"each\"><tr><th></th>{heads}</tr>{rows}</table></details>",
        if summary.light_fields.len() > OPEN { "" } else { " open" }
    )
}

fn statement(finding: &Finding) -> String {
    let (class, verdict) = match finding.holds {
        Some(true) => ("holds", "It holds here."),
        Some(false) => ("not", "It does not hold here."),
        None => ("", ""),
    };
    format!(
        "<p><b>The paper:</b> {}. <b>Here:</b> {}. <span class=\"{class}\">{verdict}</span></p>",
        escaped(finding.paper),
        escaped(&finding.here)
    )
}

fn figure(panel: &Panel, png: &[u8]) -> String {
    let says = escaped(&panel.says);
    format!(
        "<figure><img alt=\"{says}\" src=\"data:image/png;base64,{}\"><figcaption>{says}</figcaption></figure>",
        base64(png)
    )
}

/// Bytes as text (RFC 4648).
fn base64(bytes: &[u8]) -> String {
    const SIGNS: &[u8; 64] = b"ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    let mut text = String::with_capacity(bytes.len().div_ceil(3) * 4);
    for three in bytes.chunks(3) {
        let bits = (0..3).fold(0u32, |bits, i| bits << 8 | u32::from(three.get(i).copied().unwrap_or(0)));
        for i in 0..4 {
            let sign = SIGNS[(bits >> (18 - 6 * i) & 63) as usize];
            text.push(if i <= three.len() { char::from(sign) } else { '=' });
        }
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bytes_become_text_as_the_standard_says() {
        let told = ["", "f", "fo", "foo", "foobar"].map(|text| base64(text.as_bytes()));
        assert_eq!(told, ["", "Zg==", "Zm8=", "Zm9v", "Zm9vYmFy"]);
    }
}
