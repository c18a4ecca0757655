//! `scenarios/README.md` against the program: the same tables, the same keys, the same defaults.
//!
//! The program is asked through [`Scenario::parse`] alone: a key that cannot exist makes it list those that can,
//! and a scenario with every default written out must equal one with none.

use std::collections::{BTreeMap, BTreeSet};

use host::run::scenario::Scenario;

const README: &str = include_str!("../scenarios/README.md");

/// What cannot be left out, and what has no default that could be written down. One module, because a map with one
/// entry always prints the same.
const LEAST: &str = "name = \"t\"\n[structure]\nsize = \"1x1\"\n[[leg]]\nduration_s = 5.0\n\
                     velocity_m_s = [0.04, 0.0]\nheading_rad = 1.5\n";

/// Table → its keys and what stands in their default column. The empty name is the top of the file.
fn documented() -> BTreeMap<String, BTreeMap<String, String>> {
    let mut tables = BTreeMap::<String, BTreeMap<String, String>>::new();
    let mut table = None;
    for line in README.lines() {
        if let Some(title) = line.strip_prefix("## ") {
            let name = title.trim_matches(['`', '[', ']']);
            table = Some(if title.starts_with('`') { name.to_owned() } else { String::new() });
        }
        let (Some(table), Some(row)) = (&table, line.strip_prefix("| `")) else { continue };
        let (key, row) = row.split_once("` |").expect(line);
        let default = row.split('|').nth(1).expect(line).trim();
        let keys = tables.entry(table.clone()).or_default();
        assert_eq!(keys.insert(key.to_owned(), default.to_owned()), None, "[{table}] {key} stands twice");
    }
    tables
}

/// The keys the program knows in `table`, from its complaint about one that it does not.
fn known(table: &str) -> BTreeSet<String> {
    let text = match table {
        "" => format!("no_such_key = 1\n{LEAST}"),
        "structure" => LEAST.replace("size", "no_such_key = 1\nsize"),
        "leg" => LEAST.replace("duration_s", "no_such_key = 1\nduration_s"),
        _ => format!("{LEAST}[{table}]\nno_such_key = 1\n"),
    };
    let complaint = Scenario::parse("t.toml", &text).expect_err(&text).to_string();
    let (start, list) = complaint.split_once("expected").expect(&complaint);
    assert!(start.contains("unknown field `no_such_key`"), "{complaint}");
    list.split('`').skip(1).step_by(2).map(str::to_owned).collect()
}

#[test]
fn every_key_is_documented_and_no_other() {
    let documented = documented();
    let tables: BTreeSet<_> = documented.keys().filter(|name| !name.is_empty()).cloned().collect();
    for (table, keys) in &documented {
        let mut expected: BTreeSet<String> = keys.keys().cloned().collect();
        // Tables inside this one have headings of their own.
        for inner in &tables {
            let name = if table.is_empty() {
                Some(inner.as_str())
            } else {
                inner.strip_prefix(&format!("{table}."))
            };
            expected.extend(name.filter(|name| !name.contains('.')).map(str::to_owned));
        }
        assert_eq!(known(table), expected, "[{table}]: left the program, right the README");
    }
}

#[test]
fn every_documented_default_is_the_programs() {
    let (mut top, mut inner, mut written) = (String::new(), String::new(), 0);
    for (table, keys) in documented() {
        let target = if table.is_empty() { &mut top } else { &mut inner };
        let literals = keys.iter().filter_map(|(key, default)| {
            let literal = default.strip_prefix('`')?.strip_suffix('`')?;
            Some(format!("{key} = {literal}\n"))
        });
        let literals: Vec<_> = literals.collect();
        if !table.is_empty() && !literals.is_empty() {
            target.push_str(&format!("[{table}]\n"));
        }
        written += literals.len();
        target.extend(literals);
    }
    assert!(written > 60, "only {written} defaults found in the README");
    let full = format!("{top}{LEAST}{inner}");
    let full = Scenario::parse("full.toml", &full).unwrap_or_else(|error| panic!("{error}\n{full}"));
    let least = Scenario::parse("least.toml", LEAST).expect("parses");
    let (full, least) = (format!("{full:#?}"), format!("{least:#?}"));
    for (documented, default) in full.lines().zip(least.lines()) {
        assert_eq!(documented, default, "left the README, right the program");
    }
    assert_eq!(full, least);
}

#[test]
fn the_example_can_be_run() {
    let (_, example) = README.split_once("```toml\n").expect("an example");
    let (example, _) = example.split_once("```").expect("its end");
    assert_eq!(Scenario::parse("example.toml", example).expect("parses").structure.len(), 2);
}
