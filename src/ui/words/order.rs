//! Texts that are read from right to left, in the order in which egui draws.
//!
//! egui shapes a run of one script rightly, but lays runs from left to right. So runs are given to it in the order in
//! which they are seen; letters within a leftward run stay as they are spoken, as the shaper turns them. What is in order
//! stands between isolates, which nobody sees, so that a sentence that it is put into leaves it alone.

const OPEN: char = '\u{2066}';
const CLOSE: char = '\u{2069}';

/// A text as it is seen; lines stay one below the other.
pub fn visual(text: &str) -> String {
    text.split('\n').map(line).collect::<Vec<_>>().join("\n")
}

#[derive(Clone, Copy, PartialEq)]
enum Way {
    Leftward,
    Rightward,
    Neither,
    /// In order already.
    Ordered,
}

/// Letters that go the same way, and what is in order already.
fn runs(text: &str) -> Vec<(Way, String)> {
    let mut runs: Vec<(Way, String)> = Vec::new();
    let mut depth = 0;
    for letter in text.chars() {
        let way = if depth > 0 || letter == OPEN { Way::Ordered } else { way_of(letter) };
        let goes_on = if way == Way::Ordered { depth > 0 } else { way != Way::Neither };
        match runs.last_mut() {
            Some((last, run)) if *last == way && goes_on => run.push(letter),
            _ => runs.push((way, letter.to_string())),
        }
        depth += i32::from(letter == OPEN) - i32::from(letter == CLOSE && depth > 0);
    }
    runs
}

fn line(text: &str) -> String {
    let runs = runs(text);
    if runs.iter().all(|(way, _)| matches!(way, Way::Rightward | Way::Neither)) {
        return text.to_owned();
    }
    // What stands between two rightward runs goes with them.
    let mut out = Vec::new();
    let mut i = 0;
    while i < runs.len() {
        let (way, run) = &runs[i];
        match way {
            Way::Rightward => {
                let last = last_rightward(&runs, i);
                out.push(runs[i..=last].iter().map(|(_, run)| run.as_str()).collect());
                i = last;
            }
            Way::Neither => out.push(run.chars().map(mirrored).collect::<String>()),
            Way::Leftward | Way::Ordered => out.push(run.clone()),
        }
        i += 1;
    }
    out.reverse();
    format!("{OPEN}{}{CLOSE}", out.concat())
}

/// The last of the rightward runs that begin at `i`, with no leftward one between.
fn last_rightward(runs: &[(Way, String)], i: usize) -> usize {
    let rest = runs[i..].iter().take_while(|(way, _)| matches!(way, Way::Rightward | Way::Neither)).enumerate();
    i + rest.filter(|(_, (way, _))| *way == Way::Rightward).map(|(k, _)| k).last().unwrap_or(0)
}

fn way_of(letter: char) -> Way {
    match letter {
        // Hebrew, Arabic, Syriac, Thaana, N'Ko and their presentation forms.
        '\u{590}'..='\u{8ff}' | '\u{fb1d}'..='\u{fdff}' | '\u{fe70}'..='\u{fefc}' => Way::Leftward,
        _ if letter.is_alphanumeric() => Way::Rightward,
        _ => Way::Neither,
    }
}

fn mirrored(letter: char) -> char {
    const PAIRS: [(char, char); 5] = [('(', ')'), ('[', ']'), ('{', '}'), ('<', '>'), ('«', '»')];
    let other = PAIRS.iter().find_map(|&(a, b)| match letter {
        _ if letter == a => Some(b),
        _ if letter == b => Some(a),
        _ => None,
    });
    other.unwrap_or(letter)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn seen(text: &str) -> String {
        visual(text).replace([OPEN, CLOSE], "")
    }

    #[test]
    fn words_go_leftward_and_numbers_stay() {
        assert_eq!(seen("שלום עולם"), "עולם שלום", "the first word is drawn last");
        assert_eq!(seen("רוחב 4032 px (גדול)."), ".(גדול) 4032 px רוחב");
        assert_eq!(visual("f/3.5"), "f/3.5");
    }

    #[test]
    fn letters_of_a_word_are_left_to_the_shaper() {
        assert_eq!(seen("العدسة"), "العدسة");
    }

    #[test]
    fn what_is_in_order_stays_so_within_a_sentence() {
        let part = visual("שלום עולם");
        assert_eq!(seen(&format!("רוחב {part} 3.5")), "3.5 עולם שלום רוחב");
    }
}
