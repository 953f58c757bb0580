//! Texts that are read from right to left, in the order in which egui draws.
//!
//! egui shapes a run of one script rightly, but lays runs from left to right. So runs are given to it in the order in
//! which they are seen; letters within a leftward run stay as they are spoken, as the shaper turns them.

/// A text in one line as it is seen; lines stay one below the other.
pub fn visual(text: &str) -> String {
    text.split('\n').map(line).collect::<Vec<_>>().join("\n")
}

#[derive(Clone, Copy, PartialEq)]
enum Way {
    Leftward,
    Rightward,
    Neither,
}

fn line(text: &str) -> String {
    let mut runs: Vec<(Way, String)> = Vec::new();
    for letter in text.chars() {
        match runs.last_mut() {
            Some((way, run)) if *way == way_of(letter) && *way != Way::Neither => run.push(letter),
            _ => runs.push((way_of(letter), letter.to_string())),
        }
    }
    if runs.iter().all(|(way, _)| *way != Way::Leftward) {
        return text.to_owned();
    }
    // What stands between two rightward runs goes with them.
    let mut out = Vec::new();
    let mut i = 0;
    while i < runs.len() {
        if runs[i].0 == Way::Rightward {
            let last = last_rightward(&runs, i);
            out.push(runs[i..=last].iter().map(|(_, run)| run.as_str()).collect());
            i = last;
        } else if runs[i].0 == Way::Neither {
            out.push(runs[i].1.chars().map(mirrored).collect::<String>());
        } else {
            out.push(runs[i].1.clone());
        }
        i += 1;
    }
    out.reverse();
    out.concat()
}

/// The last of the rightward runs that begin at `i`, with no leftward one between.
fn last_rightward(runs: &[(Way, String)], i: usize) -> usize {
    let rest = runs[i..].iter().take_while(|(way, _)| *way != Way::Leftward).enumerate();
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

    #[test]
    fn words_go_leftward_and_numbers_stay() {
        assert_eq!(visual("שלום עולם"), "עולם שלום", "the first word is drawn last");
        assert_eq!(visual("רוחב 4032 px (גדול)."), ".(גדול) 4032 px רוחב");
        assert_eq!(visual("f/3.5"), "f/3.5");
    }

    #[test]
    fn letters_of_a_word_are_left_to_the_shaper() {
        assert_eq!(visual("العدسة"), "العدسة");
    }
}
