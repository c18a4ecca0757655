use serde::Deserialize;

use super::*;

#[derive(Debug, Deserialize, PartialEq)]
#[serde(deny_unknown_fields)]
struct Top {
    name: String,
    #[serde(default)]
    count: u8,
    #[serde(default)]
    mass_kg: f64,
    #[serde(default)]
    on: Option<bool>,
    #[serde(default)]
    kind: Kind,
    #[serde(default)]
    inner: Inner,
    #[serde(default)]
    part: Vec<Inner>,
}

#[derive(Debug, Default, Deserialize, PartialEq)]
#[serde(rename_all = "lowercase")]
enum Kind {
    #[default]
    Near,
    Far,
}

#[derive(Debug, Default, Deserialize, PartialEq)]
#[serde(deny_unknown_fields, default)]
struct Inner {
    place_m: [f64; 2],
    total: i64,
    names: Vec<String>,
}

fn toml(text: &str) -> Result<Top, Mistake> {
    Document::toml(text)?.read()
}

fn json(text: &str) -> Result<Top, Mistake> {
    Document::json(text)?.read()
}

/// Line, column and message of a refusal.
fn told(read: Result<Top, Mistake>, text: &str) -> String {
    let Mistake { line, column, message } = read.expect_err(text);
    format!("{line}:{column}: {message}")
}

#[test]
fn both_formats_say_the_same() {
    let written = "\u{feff}name = \"n\"\ncount = 4.0\nmass_kg = 4\non = true\nkind = \"far\"\n[inner]\nplace_m = [1, 2.5]\n\
                   [[part]]\ntotal = -7.0\n[[part]]\nnames = [\"a\", \"\\\"b\"]\n";
    let lines = written.replace('\n', "\r\n");
    let object = "\u{feff}{\"name\":\"n\",\"count\":4.0,\"mass_kg\":4,\"on\":true,\"kind\":\"far\",\"inner\":{\"place_m\":[1,2.5]},\n\
                  \"part\":[{\"total\":-7.0},{\"names\":[\"a\",\"\\\"b\"]}]}";
    let inner = |total, names: &[&str]| Inner {
        total,
        names: names.iter().map(|name| (*name).to_owned()).collect(),
        ..Inner::default()
    };
    let expected = Top {
        name: "n".to_owned(),
        count: 4,
        mass_kg: 4.0,
        on: Some(true),
        kind: Kind::Far,
        inner: Inner { place_m: [1.0, 2.5], ..Inner::default() },
        part: vec![inner(-7, &[]), inner(0, &["a", "\"b"])],
    };
    for read in [toml(written), toml(&lines), json(object)] {
        assert_eq!(read.as_ref(), Ok(&expected));
    }
    assert_eq!(json("{\"name\":\"n\",\"on\":null}").map(|top| top.on), Ok(None));
}

#[test]
fn mistakes_in_toml_have_their_line_key_and_value() {
    for (more, expected) in [
        ("count = 4.5", "2:9: count = 4.5: must be a whole number from 0 to 255"),
        ("count = 256", "2:9: count = 256: must be a whole number from 0 to 255"),
        ("count = nan", "2:9: count = nan: must be a whole number from 0 to 255"),
        ("count = 1e99", "2:9: count = 1e99: must be a whole number from 0 to 255"),
        ("mass_kg = 1e999", "2:11: mass_kg = 1e999: number out of range"),
        ("mass_kg = \"4 kg\"", "2:11: mass_kg = \"4 kg\": must be a number"),
        (
            "mass = 4",
            "2:1: unknown field `mass`, expected one of `name`, `count`, `mass_kg`, `on`, `kind`, `inner`, `part`; did you mean `mass_kg`?",
        ),
        (
            "kind = \"farr\"",
            "2:8: kind = \"farr\": unknown name, expected `near` or `far`; did you mean `far`?",
        ),
        ("kind = 1", "2:8: kind = 1: must be a text in quotes, one of near, far"),
        ("on = 1", "2:6: on = 1: must be true or false"),
        ("inner = 1", "2:9: inner = 1: must be a table of keys and values"),
        ("[inner]\nplace_m = [1]", "3:11: [inner] place_m = [1]: a list of 1 where 2 are asked for"),
        ("[inner]\nplace_m = [1,\n2, 3]", "3:11: [inner] place_m = [1,…: a list of 3 where 2 are asked for"),
        ("[inner]\nplace_m = 1", "3:11: [inner] place_m = 1: must be a list of 2"),
        ("[inner]\nnames = [\"a\", 1]", "3:15: [inner] names[1] = 1: must be a text in quotes"),
        (
            "[inner]\ntotl = 1",
            "3:1: [inner] unknown field `totl`, expected one of `place_m`, `total`, `names`; did you mean `total`?",
        ),
        ("[[part]]\n[[part]]\ntotal = 0.5", "4:9: [[part]] 2: total = 0.5: must be a whole number"),
        (
            "[[part]]\nx = 0.5",
            "3:1: [[part]] 1: unknown field `x`, expected one of `place_m`, `total`, `names`",
        ),
        ("[part]", "2:1: part: must be a list"),
        // Tables are not quoted: they may hold a secret.
        ("inner = [{ secret = 1 }]", "2:9: inner: must be a table of keys and values"),
        ("count = 1\ncount = 2", "3:1: duplicate key `count`"),
    ] {
        let text = format!("name = \"n\"\n{more}\n");
        assert_eq!(told(toml(&text), &text), expected);
    }
    assert_eq!(told(toml("\ncount = 1"), ""), "1:1: missing field `name`");
    let long = format!("name = [\"{}\"]", "n".repeat(100));
    let shown = format!("1:8: name = [\"{}…: must be a text in quotes", "n".repeat(38));
    assert_eq!(told(toml(&long), &long), shown);
}

#[test]
fn mistakes_in_json_have_their_place_key_and_value() {
    for (more, expected) in [
        ("\"count\":4.5", "2:9: count = 4.5: must be a whole number from 0 to 255"),
        ("\"mass_kg\":null", "2:11: mass_kg = null: must be a number"),
        ("\"mass_kg\":-1e999", "2:11: mass_kg = -1e999: number out of range"),
        ("\"mass_kg\":NaN", "2:11: expected value, found NaN"),
        ("\"inner\":{\"place_m\":[1,\"x\"]}", "2:23: inner.place_m[1] = \"x\": must be a number"),
        (
            "\"part\":[{},{\"totl\":1}]",
            "2:13: part[1]: unknown field `totl`, expected one of `place_m`, `total`, `names`; did you mean `total`?",
        ),
        ("\"part\":[[1]]", "2:9: part[0] = [1]: must be an object"),
        ("\"count\":1,\"count\":2", "2:11: duplicate field `count`"),
    ] {
        let text = format!("{{\"name\":\"n\",\n{more}}}");
        assert_eq!(told(json(&text), &text), expected);
    }
    assert_eq!(told(json("[]"), "[]"), "1:1: must be an object");
    assert_eq!(told(json("{}"), "{}"), "1:1: missing field `name`");
    let deep = format!("{{\"part\":{}{}}}", "[".repeat(100_000), "]".repeat(100_000));
    assert!(told(json(&deep), "deep").ends_with("recursion limit exceeded: more than 128 in each other"));
}

#[test]
fn numbers_are_those_of_the_parsers() {
    for number in
        ["0.1", "-0", "1e-7", "5e-324", "1.7976931348623157e308", "9007199254740993", "123456789012345678"]
    {
        let read = Document::json(number).and_then(|document| document.read::<f64>()).expect(number);
        let known: f64 = serde_json::from_str(number).expect(number);
        assert_eq!(read.to_bits(), known.to_bits(), "{number}");
    }
    for (number, whole) in [
        ("-0", Some(0)),
        ("9007199254740993", Some(9_007_199_254_740_993)),
        ("1e16", None),
        ("1e3", Some(1000)),
    ] {
        let read = Document::json(number).and_then(|document| document.read::<i64>());
        assert_eq!(read.ok(), whole, "{number}");
    }
}

#[test]
fn what_is_found_later_has_its_place_too() {
    let document = Document::toml("name = \"n\"\n[inner]\n\n[[part]]\n[[part]]\ntotal = 1\n").expect("TOML");
    let told = |mistake: Mistake| format!("{}: {}", mistake.line, mistake.message);
    assert_eq!(told(document.mistake(&["part", "1", "total"], "is one")), "6: is one");
    assert_eq!(told(document.mistake(&["part", "1", "names"], "are none")), "5: are none");
    assert_eq!(told(document.mistake_in(&["part", "1"], "total", "is one")), "6: [[part]] 2: is one");
    assert_eq!(told(document.mistake_in(&["inner"], "total", "is none")), "2: [inner] is none");
    assert_eq!(told(document.mistake_in(&[], "name", "is short")), "1: is short");
    assert_eq!(document.lines(&["part", "1", "total"]), Some(6..=6));
    assert_eq!(document.lines(&["passphrase"]), None);
}
