//! Words that the house does not use: texts name their subject, a module or a robot.

use std::fs;
use std::path::Path;

/// What is searched, below the top: folders whole, and files.
const AREAS: [&str; 12] = [
    ".cargo",
    ".ci",
    "CHANGELOG.md",
    "CONTRIBUTING.md",
    "Cargo.toml",
    "README.md",
    "deny.toml",
    "firmware",
    "host",
    "protocol",
    "rust-toolchain.toml",
    "tests",
];
/// Files that may use one of the words, and why.
const EXCEPT: [(&str, &str); 1] =
    [("firmware/proptest-regressions/modboat/motor.txt", "its head is written by proptest")];
/// The words, in lower case; in pieces, so that this file does not fail its own check.
const WORDS: [&str; 11] = [
    concat!("no", "body"),
    concat!("every", "body"),
    concat!("every", "one"),
    concat!("some", "body"),
    concat!("any", "body"),
    concat!("who", "ever"),
    concat!("an", "ew"),
    concat!("who", "se ta", "ils"),
    concat!("who", " re", "sts"),
    concat!("does ", "not da", "re"),
    concat!("so ", "lo", "ng"),
];

/// One word of a text: its line from 1, and the word in lower case.
type Word = (usize, String);

/// The words of a text: runs of letters, split where a capital follows a small letter, as in names of types.
fn split(text: &str) -> Vec<Word> {
    let mut words: Vec<Word> = Vec::new();
    for (line, text) in text.lines().enumerate() {
        let mut before = ' ';
        for letter in text.chars() {
            if letter.is_alphabetic() {
                if !before.is_alphabetic() || before.is_lowercase() && letter.is_uppercase() {
                    words.push((line + 1, String::new()));
                }
                if let Some((_, word)) = words.last_mut() {
                    word.extend(letter.to_lowercase());
                }
            }
            before = letter;
        }
    }
    words
}

/// Every use of [`WORDS`] in a text: line and word. Phrases are found across lines and comment marks too.
fn uses(text: &str) -> Vec<(usize, &'static str)> {
    let words = split(text);
    let mut found = Vec::new();
    for banned in WORDS {
        let phrase: Vec<&str> = banned.split(' ').collect();
        let same = |window: &[Word]| {
            // With an s too: the possessive in a function's name.
            window.iter().zip(&phrase).all(|((_, word), part)| word == part || *word == format!("{part}s"))
        };
        let hits = words.windows(phrase.len()).filter(|window| same(window));
        found.extend(hits.map(|window| (window[0].0, banned)));
    }
    found
}

/// Every readable text below `path`: path below the top, and text.
fn texts(top: &Path, path: &Path, into: &mut Vec<(String, String)>) {
    if path.is_dir() {
        if path.file_name().is_some_and(|name| name != "target") {
            let entries = fs::read_dir(path).expect("readable");
            entries.for_each(|entry| texts(top, &entry.expect("readable").path(), into));
        }
    } else if let Ok(text) = fs::read_to_string(path) {
        let below = path.strip_prefix(top).expect("below the top").to_str().expect("UTF-8");
        into.push((below.replace('\\', "/"), text));
    }
}

#[test]
fn texts_name_their_subject() {
    let top = super::top();
    let mut all = Vec::new();
    for area in AREAS {
        let before = all.len();
        texts(&top, &top.join(area), &mut all);
        assert!(all.len() > before, "{area}: nothing to read");
    }
    let kept = |file: &str| EXCEPT.iter().any(|(except, _)| *except == file);
    let mut found = Vec::new();
    for (file, text) in all.iter().filter(|(file, _)| !kept(file)) {
        found.extend(uses(text).into_iter().map(|(line, word)| format!("{file}:{line}: {word}")));
    }
    assert!(found.is_empty(), "{}", found.join("\n"));
    for (file, _) in EXCEPT {
        let text = fs::read_to_string(top.join(file)).expect(file);
        assert!(!uses(&text).is_empty(), "{file} needs no exception");
    }
}

#[test]
fn every_word_is_found_in_every_form() {
    for word in WORDS {
        for text in [
            format!("// Said that {word} is here."),
            format!("fn a_{}_b() {{}}", word.replace(' ', "_")),
            format!("{}'s", word.to_uppercase()),
            format!("/// {}", word.replace(' ', "\n/// ")),
        ] {
            assert!(uses(&text).contains(&(1, word)), "{word} in {text:?}");
        }
    }
    let camel = format!("Some{}{}Brings", "No", "body");
    assert_eq!(uses(&camel), [(1, WORDS[0])]);
    // Neither a part of a longer word nor words apart.
    let longer = WORDS.iter().map(|word| format!("c{word}")).collect::<Vec<_>>().join(", ");
    assert_eq!(uses(&format!("No body is in its place; as long as a tail rests, {longer}, one else")), []);
}
