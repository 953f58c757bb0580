//! Curves of a run's metrics as an SVG picture: each loss over the samples seen, on a logarithmic scale.

use std::collections::BTreeMap;
use std::fmt::Write as _;
use std::path::Path;

use crate::TrainError;
use crate::files;

/// Size of the picture and its margins, px.
const SIZE: [f64; 2] = [900.0, 480.0];
const MARGIN: [f64; 2] = [60.0, 30.0];
/// Colours that can be told apart, in turn.
const COLOURS: [&str; 9] =
    ["#0072b2", "#d55e00", "#009e73", "#cc79a7", "#56b4e9", "#e69f00", "#000000", "#999999", "#7f3c8d"];

/// Points (samples seen, value) of each loss.
type Curves = BTreeMap<String, Vec<(f64, f64)>>;

/// Draws `metrics` (JSON lines) to `svg`; nothing is written while there are fewer than two lines.
pub fn draw(metrics: &Path, svg: &Path) -> Result<(), TrainError> {
    let failed = |source| TrainError::File { action: "read the metrics", source, path: metrics.to_owned() };
    let curves = read(&std::fs::read_to_string(metrics).map_err(failed)?);
    match picture(&curves) {
        Some(text) => files::write(svg, text.as_bytes(), "draw the curves"),
        None => Ok(()),
    }
}

/// Lines that are no metrics (a torn last one) are left out.
fn read(text: &str) -> Curves {
    let mut curves = Curves::new();
    for line in text.lines().filter_map(|line| serde_json::from_str::<serde_json::Value>(line).ok()) {
        let (Some(samples), Some(losses)) = (line["samples"].as_f64(), line["losses"].as_object()) else { continue };
        for (name, value) in losses {
            if let Some(value) = value.as_f64().filter(|v| *v > 0.0) {
                curves.entry(name.clone()).or_default().push((samples, value));
            }
        }
    }
    curves
}

fn picture(curves: &Curves) -> Option<String> {
    let all = || curves.values().flatten();
    let end = all().map(|p| p.0).fold(0.0, f64::max);
    let low = all().map(|p| p.1).fold(f64::INFINITY, f64::min).log10();
    let high = all().map(|p| p.1).fold(0.0, f64::max).log10();
    if curves.values().map(Vec::len).max().unwrap_or(0) < 2 || end <= 0.0 {
        return None;
    }
    let place = |(x, y): (f64, f64)| {
        let [w, h] = [SIZE[0] - 2.0 * MARGIN[0] - 80.0, SIZE[1] - 2.0 * MARGIN[1]];
        let up = (y.log10() - low) / (high - low).max(1e-9);
        (MARGIN[0] + w * x / end, SIZE[1] - MARGIN[1] - h * up)
    };
    let [w, h] = SIZE;
    let mut svg = format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {w} {h}\" font-family=\"sans-serif\" font-size=\"12\">\n"
    );
    // Writing to a string cannot fail.
    let mut line = |text: String| writeln!(svg, "{text}").unwrap_or_default();
    line(format!("<rect width=\"{w}\" height=\"{h}\" fill=\"white\"/>"));
    for decade in low.ceil() as i32..=high.floor() as i32 {
        let (x, y) = place((0.0, 10f64.powi(decade)));
        line(format!("<path d=\"M{x} {y:.1}H{:.1}\" stroke=\"#ddd\"/>", w - MARGIN[0] - 80.0));
        line(format!("<text x=\"8\" y=\"{:.1}\">1e{decade}</text>", y + 4.0));
    }
    line(format!(
        "<text x=\"{:.0}\" y=\"{:.0}\" text-anchor=\"end\">{end} samples</text>",
        w - MARGIN[0] - 80.0,
        h - 8.0
    ));
    for ((name, points), colour) in curves.iter().zip(COLOURS.iter().cycle()) {
        let path: Vec<String> = points.iter().map(|p| place(*p)).map(|(x, y)| format!("{x:.1},{y:.1}")).collect();
        line(format!(
            "<polyline points=\"{}\" fill=\"none\" stroke=\"{colour}\" stroke-width=\"1.5\"/>",
            path.join(" ")
        ));
        if let Some((x, y)) = points.last().map(|p| place(*p)) {
            line(format!("<text x=\"{:.1}\" y=\"{:.1}\" fill=\"{colour}\">{name}</text>", x + 6.0, y + 4.0));
        }
    }
    svg.push_str("</svg>\n");
    Some(svg)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_loss_has_its_curve_and_torn_lines_do_no_harm() {
        let text = "{\"samples\":4,\"losses\":{\"row\":0.5}}\n{\"samples\":8,\"losses\":{\"row\":0.05}}\n{\"samp";
        let svg = picture(&read(text)).unwrap();
        assert!(svg.contains(">row</text>") && svg.matches("<polyline").count() == 1);
        assert!(picture(&read("")).is_none());
    }
}
