//! Numbers as a language writes them.

use super::spoken;

/// From this on, thousands are set apart: widths of pictures are read as one.
const GROUPED_FROM: f64 = 10_000.0;

/// How a language writes numbers.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Style {
    /// Before the decimals.
    pub decimal: String,
    /// Between groups of three figures.
    pub group: String,
}

/// A number in the language of the window.
pub fn number(value: impl Into<f64>, decimals: usize) -> String {
    spoken().style().fixed(value.into(), decimals)
}

/// The same with its sign: `+0.18`, `−0.40`.
pub fn with_sign(value: impl Into<f64>, decimals: usize) -> String {
    spoken().style().signed(value.into(), decimals)
}

/// With as many decimals as it needs: `3.5`, `2`.
pub fn shortest(value: f32) -> String {
    decimal(&value.to_string())
}

/// A number in figures, as the language writes it.
pub fn decimal(figures: &str) -> String {
    figures.replace('.', &spoken().style().decimal).replace('-', "−")
}

/// A number that was typed, with a point or with a comma, and with either minus.
pub fn typed(text: &str) -> Option<f64> {
    text.trim().replace('−', "-").replace(',', ".").parse().ok()
}

impl Style {
    /// A number with so many decimals.
    pub fn fixed(&self, value: f64, decimals: usize) -> String {
        self.written(&format!("{value:.decimals$}"), value.abs() >= GROUPED_FROM)
    }

    /// The same with its sign.
    pub fn signed(&self, value: f64, decimals: usize) -> String {
        self.written(&format!("{value:+.decimals$}"), value.abs() >= GROUPED_FROM)
    }

    fn written(&self, plain: &str, is_grouped: bool) -> String {
        let (whole, decimals) = plain.split_once('.').unwrap_or((plain, ""));
        let (sign, figures) = whole.split_at(whole.find(|c: char| c.is_ascii_digit()).unwrap_or(0));
        let mut out = sign.replace('-', "−");
        for (i, figure) in figures.chars().enumerate() {
            if is_grouped && i > 0 && (figures.len() - i).is_multiple_of(3) {
                out += &self.group;
            }
            out.push(figure);
        }
        if !decimals.is_empty() {
            out += &self.decimal;
            out += decimals;
        }
        out
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_are_written_as_the_language_has_it() {
        let german = Style { decimal: ",".to_owned(), group: ".".to_owned() };
        assert_eq!(german.fixed(3.5, 1), "3,5");
        assert_eq!(german.signed(-0.25, 2), "−0,25");
        assert_eq!(german.fixed(1_234_567.0, 0), "1.234.567");
        assert_eq!(german.fixed(4032.0, 0), "4032", "widths are read as one");
        assert_eq!(german.signed(0.18, 2), "+0,18");
        assert_eq!((typed("−1,5"), typed(" 2.25 "), typed("two")), (Some(-1.5), Some(2.25), None));
    }
}
