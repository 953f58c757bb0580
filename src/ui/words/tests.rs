//! Every language says all that the window says, of the same things, and the window says nothing else.

use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};

use fluent_syntax::ast::{Expression, InlineExpression, Pattern, PatternElement};

use super::heard::{self, heard};
use super::language::SHIPPED;
use super::{Language, Message, fixed, message, speak, t};

/// What a language file says of itself.
const OF_ITSELF: [&str; 4] = ["language-name", "reading", "number-decimal", "number-group"];

/// A Rust file without comments and tests: its code, in which each string stands as `"0"`, and the strings.
struct Code {
    path: PathBuf,
    code: String,
    strings: Vec<String>,
}

impl Code {
    fn read(path: &Path) -> Self {
        let text = std::fs::read_to_string(path).unwrap();
        let text = text.split("#[cfg(test)]\nmod tests {").next().unwrap();
        let (mut code, mut strings) = (String::new(), Vec::new());
        let mut rest = text;
        while let Some(first) = rest.chars().next() {
            if rest.starts_with("//") {
                rest = &rest[rest.find('\n').unwrap_or(rest.len())..];
            } else if first == '"' {
                let (string, after) = string(&rest[1..]);
                code += &format!("\"{}\"", strings.len());
                strings.push(string);
                rest = after;
            } else if let Some(length) = letter(rest) {
                rest = &rest[length..];
            } else {
                code.push(first);
                rest = &rest[first.len_utf8()..];
            }
        }
        Self { path: path.to_owned(), code, strings }
    }

    /// The strings right behind something in the code.
    fn strings_behind(&self, what: &str) -> impl Iterator<Item = &String> {
        let squeezed: String = self.code.split_whitespace().collect();
        let numbers: Vec<usize> = squeezed
            .match_indices(&format!("{what}\""))
            .filter(|(at, _)| !squeezed[..*at].ends_with(|c: char| c.is_alphanumeric() || c == '_'))
            .filter_map(|(at, found)| squeezed[at + found.len()..].split('"').next()?.parse().ok())
            .collect();
        numbers.into_iter().map(|number| &self.strings[number])
    }
}

/// A string up to its quote, with line ends as they are read, and what follows.
fn string(text: &str) -> (String, &str) {
    let (mut out, mut rest) = (String::new(), text);
    loop {
        let next = rest.chars().next().expect("a string ends");
        rest = &rest[next.len_utf8()..];
        match next {
            '"' => return (out, rest),
            '\\' if rest.starts_with('\n') => rest = rest.trim_start(),
            '\\' => {
                let escaped = rest.chars().next().expect("something is escaped");
                rest = &rest[escaped.len_utf8()..];
                out.push(if escaped == 'n' { '\n' } else { escaped });
            }
            _ => out.push(next),
        }
    }
}

/// The length of a letter in single quotes, which may be a double one.
fn letter(text: &str) -> Option<usize> {
    let inside = text.strip_prefix('\'')?;
    let length = match inside.strip_prefix('\\') {
        Some(_) => 1 + inside[1..].find('\'')?,
        None => inside.chars().next()?.len_utf8(),
    };
    inside[length..].starts_with('\'').then_some(length + 2)
}

/// All Rust files below a folder, but those that a room keeps for itself.
fn files(folder: &str, without: &[&str]) -> Vec<Code> {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join(folder);
    let (mut folders, mut files) = (vec![root.clone()], Vec::new());
    while let Some(folder) = folders.pop() {
        for path in folder.read_dir().unwrap().map(|entry| entry.unwrap().path()) {
            let is_left_out =
                without.iter().any(|part| path.starts_with(root.join(part))) || path.ends_with("tests.rs");
            if path.is_dir() && !is_left_out {
                folders.push(path);
            } else if path.extension().is_some_and(|it| it == "rs") && !is_left_out {
                files.push(Code::read(&path));
            }
        }
    }
    assert!(files.len() > 20, "the sources are there");
    files
}

/// What is put into each text of a language, by its id.
fn holes(language: &Language) -> BTreeMap<String, BTreeSet<String>> {
    language.ids().map(|id| (id.to_owned(), in_pattern(language.pattern(id).unwrap()))).collect()
}

fn in_pattern(pattern: &Pattern<&str>) -> BTreeSet<String> {
    let of_inline = |inline: &InlineExpression<&str>| match inline {
        InlineExpression::VariableReference { id } => Some(id.name.to_owned()),
        _ => None,
    };
    let mut all = BTreeSet::new();
    for element in &pattern.elements {
        match element {
            PatternElement::TextElement { .. } => {}
            PatternElement::Placeable { expression: Expression::Inline(inline) } => all.extend(of_inline(inline)),
            PatternElement::Placeable { expression: Expression::Select { selector, variants } } => {
                all.extend(of_inline(selector));
                variants.iter().for_each(|variant| all.extend(in_pattern(&variant.value)));
            }
        }
    }
    all
}

#[test]
fn every_language_says_the_same_of_the_same_things() {
    let english = holes(Language::english());
    for source in SHIPPED {
        let (language, faults) = Language::read(source.tag, source.text);
        assert!(faults.is_empty(), "{}: lines {faults:?} cannot be read", source.tag);
        let own = holes(&language);
        let lacks: Vec<_> = english.keys().filter(|id| !own.contains_key(*id)).collect();
        let extra: Vec<_> = own.keys().filter(|id| !english.contains_key(*id)).collect();
        assert!(lacks.is_empty() && extra.is_empty(), "{} lacks {lacks:?}, and nobody says {extra:?}", source.tag);
        for (id, holes) in &english {
            assert_eq!(holes, &own[id], "what is put into {id} in {}", source.tag);
        }
        assert_eq!(
            source.text.lines().filter(|line| line.starts_with(char::is_lowercase)).count(),
            own.keys().filter(|id| !id.contains('.')).count(),
            "no id stands twice in {}",
            source.tag
        );
    }
}

#[test]
fn what_the_code_says_is_there_and_nothing_else() {
    let mut said: BTreeSet<String> = OF_ITSELF.map(str::to_owned).into();
    for file in files("src/ui", &[]) {
        for macro_name in ["t!(", "message!(", "id!("] {
            said.extend(file.strings_behind(macro_name).cloned());
        }
    }
    let known: BTreeSet<String> = Language::english()
        .ids()
        .filter(|id| !id.contains('.') && !id.starts_with(heard::PREFIX))
        .map(str::to_owned)
        .collect();
    assert_eq!(said.difference(&known).collect::<Vec<_>>(), Vec::<&String>::new(), "not in en.ftl");
    assert_eq!(known.difference(&said).collect::<Vec<_>>(), Vec::<&String>::new(), "said by nobody");
}

/// Whether a person would read it as words: it begins like a sentence, or has several words.
fn is_text(string: &str) -> bool {
    let without_holes: String =
        string.split('{').map(|part| part.split_once('}').map_or(part, |(_, rest)| rest)).collect();
    let has_word = without_holes.split(|c: char| !c.is_alphabetic()).any(|word| word.chars().count() > 1);
    let is_name = without_holes.chars().all(|c| c.is_ascii_uppercase() || c.is_ascii_digit());
    has_word && !is_name && (without_holes.starts_with(char::is_uppercase) || without_holes.contains(' '))
}

/// Where a string is that no person reads in the window: in the log, in a report, in what is told the compiler.
fn is_unseen(file: &Code, before: &str) -> bool {
    const UNSEEN: [&str; 8] = ["trace!(", "debug!(", "info!(", "warn!(", "error!(", "#[error(", "expect(", "reason="];
    let is_action = file.path.ends_with("action.rs") && before.ends_with("=>");
    is_action || UNSEEN.iter().any(|what| before.ends_with(what))
}

#[test]
fn no_text_stands_in_the_code_of_the_window() {
    // Names that are the same in every language.
    let names = ["Plenoscope", "{} — Plenoscope", "WebM", "WebP"];
    let mut texts = Vec::new();
    // What `lost.rs` says is for the log and the terminal: there is no window then.
    for file in files("src/ui", &["icon.rs", "lost.rs", "words"]) {
        let squeezed: String = file.code.split_whitespace().collect();
        for (number, string) in file.strings.iter().enumerate() {
            let (before, _) = squeezed.split_once(&format!("\"{number}\"")).unwrap();
            if is_text(string) && !names.contains(&string.as_str()) && !is_unseen(&file, before) {
                texts.push(format!("{}: {string:?}", file.path.display()));
            }
        }
    }
    assert!(texts.is_empty(), "these belong into src/ui/words/en.ftl:\n{}", texts.join("\n"));
}

/// A sentence as it comes out, with something in its holes.
fn spoken_out(format: &str) -> String {
    let mut out = String::new();
    let mut rest = format.replace("{{", "(").replace("}}", ")");
    while let Some((before, after)) = rest.split_once('{') {
        out += before;
        out += "7";
        rest = after.split_once('}').map_or(String::new(), |(_, rest)| rest.to_owned());
    }
    out + &rest
}

#[test]
fn the_sentences_of_the_library_are_known() {
    // What the command line, the trainer and the benchmarks say alone.
    let elsewhere = ["ui", "train", "bench", "bench.rs", "scene/asked", "scene/batch", "shard.rs"];
    let mut unknown = Vec::new();
    for file in files("src", &elsewhere) {
        let errors = file.strings_behind("#[error(");
        let warnings = ["warning(format!(", "warning(", "Refused(format!(", "Refused("].into_iter();
        for sentence in errors.chain(warnings.flat_map(|what| file.strings_behind(what))) {
            let out = spoken_out(sentence);
            // A frame for other sentences, as `{problem}: {path}`.
            let is_frame = !out.contains(|c: char| c.is_alphabetic());
            if !is_frame && heard::recognised(&out).is_none() {
                unknown.push(format!("{}: {sentence}", file.path.display()));
            }
        }
    }
    assert!(unknown.is_empty(), "these need a line heard-… in every language:\n{}", unknown.join("\n"));
}

#[test]
fn german_counts_and_writes_numbers_as_germans_do() {
    speak(Language::shipped("de").unwrap());
    assert_eq!(t!("files-count", count = 1), "1 Datei");
    assert_eq!(t!("files-count", count = 12_345), "12.345 Dateien");
    assert_eq!(t!("seconds", secs = fixed(3.25, 1)), "3,2 s");
    let cause = "could not open the file — it is empty — copy it again from where it came from: /a: b.jpg";
    let said = Message::heard(cause).text();
    assert!(said.ends_with(": /a: b.jpg") && !said.contains("could not"), "{said}");
    let said = Message::heard(
        "could not open the JPEG file — it ends — copy it again, or save it anew with the program that made it: /a",
    )
    .text();
    assert!(said.starts_with("die JPEG-Datei ") && said.ends_with(" stammt: /a"), "{said}");
    assert_eq!(heard("focus at 1.25 m · sharp from 65 cm on"), "Fokus auf 1,25 m · scharf ab 65 cm");
    assert_eq!(Message::heard("words of nobody here").text(), "words of nobody here");
    assert_eq!(Message::heard(cause).in_english(), cause);
    assert_eq!(message!("seconds", secs = fixed(3.25, 1)).in_english(), "3.2 s");
    assert_eq!(message!("saved", name = "a.jpg").text(), "a.jpg gespeichert");
    speak(Language::english());
    assert_eq!(Message::heard(cause).text(), cause, "English stays as the library says it");
}
