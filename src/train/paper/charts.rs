//! Figures as SVG: lines, and bars side by side.

use std::fmt::Write as _;

/// Size of a figure and the room around its axes, px.
const SIZE: [f64; 2] = [720.0, 360.0];
const LEFT: f64 = 64.0;
const RIGHT: f64 = 190.0;
const ABOVE: f64 = 20.0;
const BELOW: f64 = 48.0;
/// Colours that can be told apart, in turn (Okabe and Ito).
const COLOURS: [&str; 7] = ["#0072b2", "#d55e00", "#009e73", "#cc79a7", "#56b4e9", "#e69f00", "#000000"];
/// Lines across.
const GRID: usize = 4;

/// A name and its values by place.
pub struct Series<'a> {
    /// What people read.
    pub name: &'a str,
    /// One for each place.
    pub values: Vec<f64>,
}

/// What stands at the axes.
pub struct Axes<'a> {
    /// Under the places.
    pub across: &'a str,
    /// Beside the values.
    pub up: &'a str,
    /// Names of the places; the empty ones are left out.
    pub places: Vec<String>,
}

/// Values over places as lines.
pub fn lines(axes: &Axes<'_>, series: &[Series<'_>]) -> String {
    let frame = Frame::new(series);
    let step = frame.width / (axes.places.len().max(2) - 1) as f64;
    let mut svg = frame.open(axes, |place| LEFT + step * place as f64);
    for (one, colour) in series.iter().zip(COLOURS.iter().cycle()) {
        let place = |(i, value): (usize, &f64)| format!("{:.1},{:.1}", LEFT + step * i as f64, frame.y(*value));
        let points: Vec<String> = one.values.iter().enumerate().map(place).collect();
        put(
            &mut svg,
            &format!(
                "<polyline points=\"{}\" fill=\"none\" stroke=\"{colour}\" stroke-width=\"2\"/>",
                points.join(" ")
            ),
        );
    }
    close(svg, series)
}

/// Values over places as bars, those of a place side by side.
pub fn bars(axes: &Axes<'_>, series: &[Series<'_>]) -> String {
    let frame = Frame::new(series);
    let step = frame.width / axes.places.len().max(1) as f64;
    let mut svg = frame.open(axes, |place| LEFT + step * (place as f64 + 0.5));
    let wide = 0.8 * step / series.len().max(1) as f64;
    for (n, (one, colour)) in series.iter().zip(COLOURS.iter().cycle()).enumerate() {
        for (i, value) in one.values.iter().enumerate().filter(|(_, value)| **value > 0.0) {
            let (x, y) = (LEFT + step * (i as f64 + 0.1) + wide * n as f64, frame.y(*value));
            let high = frame.y(0.0) - y;
            put(
                &mut svg,
                &format!(
                    "<rect x=\"{x:.1}\" y=\"{y:.1}\" width=\"{wide:.1}\" height=\"{high:.1}\" fill=\"{colour}\"/>"
                ),
            );
        }
    }
    close(svg, series)
}

struct Frame {
    width: f64,
    height: f64,
    /// From one line across to the next.
    step: f64,
    most: f64,
}

impl Frame {
    fn new(series: &[Series<'_>]) -> Self {
        let most = series.iter().flat_map(|one| &one.values).copied().fold(0.0, f64::max);
        let step = round_step(most / GRID as f64);
        Self { width: SIZE[0] - LEFT - RIGHT, height: SIZE[1] - ABOVE - BELOW, step, most: step * GRID as f64 }
    }

    fn y(&self, value: f64) -> f64 {
        ABOVE + self.height * (1.0 - value / self.most)
    }

    /// The picture up to what stands in it.
    fn open(&self, axes: &Axes<'_>, x: impl Fn(usize) -> f64) -> String {
        let [w, h] = SIZE;
        let mut svg = format!(
            "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {w} {h}\" font-family=\"sans-serif\" font-size=\"12\">\n"
        );
        put(&mut svg, &format!("<rect width=\"{w}\" height=\"{h}\" fill=\"white\"/>"));
        let decimals = (-self.step.log10().floor()).max(0.0) as usize;
        for line in 0..=GRID {
            let value = self.step * line as f64;
            let y = self.y(value);
            put(&mut svg, &format!("<path d=\"M{LEFT} {y:.1}h{:.1}\" stroke=\"#ddd\"/>", self.width));
            put(
                &mut svg,
                &format!(
                    "<text x=\"{}\" y=\"{:.1}\" text-anchor=\"end\">{value:.decimals$}</text>",
                    LEFT - 6.0,
                    y + 4.0
                ),
            );
        }
        for (i, name) in axes.places.iter().enumerate().filter(|(_, name)| !name.is_empty()) {
            let y = h - BELOW + 16.0;
            put(&mut svg, &format!("<text x=\"{:.1}\" y=\"{y}\" text-anchor=\"middle\">{name}</text>", x(i)));
        }
        let middle = LEFT + self.width / 2.0;
        put(
            &mut svg,
            &format!("<text x=\"{middle}\" y=\"{}\" text-anchor=\"middle\">{}</text>", h - 10.0, axes.across),
        );
        let turned = format!("transform=\"translate(14 {}) rotate(-90)\"", ABOVE + self.height / 2.0);
        put(&mut svg, &format!("<text {turned} text-anchor=\"middle\">{}</text>", axes.up));
        svg
    }
}

/// The least of 1, 2, 3, 4, 5, 6 and 8 times a power of ten that is not below `least`; 1 where that is 0.
fn round_step(least: f64) -> f64 {
    if least <= 0.0 {
        return 1.0;
    }
    let power = 10f64.powi(least.log10().floor() as i32);
    // What misses a round number by rounding alone is that number.
    let reaches = |times: &f64| times * power >= least * (1.0 - 1e-9);
    [1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 8.0].into_iter().find(reaches).unwrap_or(10.0) * power
}

/// The names beside the figure where there are several, and its end.
fn close(mut svg: String, series: &[Series<'_>]) -> String {
    let x = SIZE[0] - RIGHT + 14.0;
    let series = if series.len() > 1 { series } else { &[] };
    for (i, (one, colour)) in series.iter().zip(COLOURS.iter().cycle()).enumerate() {
        let y = ABOVE + 18.0 * (i as f64 + 1.0);
        put(&mut svg, &format!("<rect x=\"{x}\" y=\"{}\" width=\"12\" height=\"12\" fill=\"{colour}\"/>", y - 10.0));
        put(&mut svg, &format!("<text x=\"{}\" y=\"{y}\">{}</text>", x + 18.0, one.name));
    }
    svg.push_str("</svg>\n");
    svg
}

fn put(svg: &mut String, text: &str) {
    // Writing to a string cannot fail.
    writeln!(svg, "{text}").unwrap_or_default();
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_series_is_drawn_and_named() {
        let axes = Axes { across: "u", up: "L1", places: vec!["-1".into(), String::new(), "1".into()] };
        let series =
            || [("a", [0.1, 0.0, 0.2]), ("b", [0.3, 0.1, 0.0])].map(|(name, v)| Series { name, values: v.to_vec() });
        let drawn = lines(&axes, &series());
        assert!(drawn.matches("<polyline").count() == 2 && drawn.contains(">b</text>") && drawn.contains(">-1</text>"));
        // Background, two names, and a bar for each value above 0.
        assert_eq!(bars(&axes, &series()).matches("<rect").count(), 1 + 2 + 4);
        let alone = lines(&axes, &[Series { name: "alone", values: vec![0.0] }]);
        assert!(
            !alone.contains("NaN") && !alone.contains(">alone<"),
            "one series needs no name: the axes say what it is"
        );
    }

    #[test]
    fn lines_across_stand_at_round_values() {
        for (least, step) in [(0.0, 1.0), (4.0, 4.0), (0.00975, 0.01), (0.3, 0.3), (0.74, 0.8), (9.0, 10.0)] {
            assert!((round_step(least) / step - 1.0).abs() < 1e-9, "{least}: {}", round_step(least));
        }
        let drawn = bars(
            &Axes { across: "L1", up: "light fields", places: vec![String::new()] },
            &[Series { name: "", values: vec![16.0] }],
        );
        assert!(drawn.contains(">16<") && drawn.contains(">4<"), "whole numbers without decimals: {drawn}");
    }
}
