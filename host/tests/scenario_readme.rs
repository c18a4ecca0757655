//! `scenarios/README.md` against the program: the same tables, the same keys, the same defaults.
//!
//! The program is asked through [`Scenario::parse`], [`ReconfigureScenario::parse`] and [`Roster::parse`] alone: a key that
//! cannot exist makes them list those that can, and a file with every default written out must equal one with none.

use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;

use host::run::reconfigure::scenario::ReconfigureScenario;
use host::run::roster::Roster;
use host::run::scenario::Scenario;

const README: &str = include_str!("../scenarios/README.md");

/// The part about runs, and the one about reconfigurations.
fn parts() -> (&'static str, &'static str) {
    let (runs, rest) = README.split_once("\n# Reconfigurations\n").expect("three parts");
    (runs, rest.split_once("\n# Rosters\n").expect("three parts").0)
}

/// The part about rosters.
fn rosters() -> &'static str {
    README.split_once("\n# Rosters\n").expect("three parts").1
}

/// What cannot be left out, and what has no default that could be written down. One module, because a map with one
/// entry always prints the same.
const LEAST: &str = "name = \"t\"\n[structure]\nsize = \"1x1\"\n[[leg]]\nduration_s = 5.0\n\
                     velocity_m_s = [0.04, 0.0]\nheading_rad = 1.5\n";

/// Table → its keys and what stands in their default column. The empty name is the top of the file.
fn documented(part: &str) -> BTreeMap<String, BTreeMap<String, String>> {
    let mut tables = BTreeMap::<String, BTreeMap<String, String>>::new();
    let mut table = None;
    for line in part.lines() {
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
    let documented = documented(parts().0);
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
    for (table, keys) in documented(parts().0) {
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
    let (_, example) = parts().0.split_once("```toml\n").expect("an example");
    let (example, _) = example.split_once("```").expect("its end");
    assert_eq!(Scenario::parse("example.toml", example).expect("parses").structure.len(), 2);
}

/// The least of a reconfiguration; a robot keeps its place.
const LEAST_RECONFIGURE: &str = "name = \"t\"\n[[robot]]\nid = 1\nvehicle = \"bluerov1\"\nstart = [0.0, 0.0, 0.0, 0.0]\n\
                                 [[slot]]\npose = [0.0, 0.0, 0.0, 0.0]\n";

#[test]
fn every_key_of_a_reconfiguration_is_documented_with_its_default() {
    let parse = |text: &str| ReconfigureScenario::parse("t.toml", text, Path::new(""));
    let documented = documented(parts().1);
    let tables: BTreeSet<String> = documented.keys().filter(|table| !table.is_empty()).cloned().collect();
    let mut full = LEAST_RECONFIGURE.to_owned();
    for (table, keys) in &documented {
        let unknown = "no_such_key = 1\n";
        let text = match table.as_str() {
            "" => format!("{unknown}{LEAST_RECONFIGURE}"),
            "rules" => format!("{LEAST_RECONFIGURE}[rules]\n{unknown}"),
            "tool" => format!("{LEAST_RECONFIGURE}[[tool]]\n{unknown}"),
            table => LEAST_RECONFIGURE.replace(&format!("[[{table}]]\n"), &format!("[[{table}]]\n{unknown}")),
        };
        let complaint = parse(&text).expect_err(&text).to_string();
        let (start, list) = complaint.split_once("expected").expect(&complaint);
        assert!(start.contains("unknown field `no_such_key`"), "{complaint}");
        let known: BTreeSet<String> = list.split('`').skip(1).step_by(2).map(str::to_owned).collect();
        let mut expected: BTreeSet<String> = keys.keys().cloned().collect();
        if table.is_empty() {
            expected.extend(tables.iter().cloned());
        }
        assert_eq!(known, expected, "[{table}]: left the program, right the README");
        for (key, default) in keys {
            let Some(literal) = default.strip_prefix('`').and_then(|rest| rest.strip_suffix('`')) else {
                continue;
            };
            full = match table.as_str() {
                "" => format!("{key} = {literal}\n{full}"),
                "rules" if full.contains("[rules]") => format!("{full}{key} = {literal}\n"),
                "rules" => format!("{full}[rules]\n{key} = {literal}\n"),
                table => {
                    full.replace(&format!("[[{table}]]\n"), &format!("[[{table}]]\n{key} = {literal}\n"))
                }
            };
        }
    }
    assert_eq!(documented["rules"].len(), 12);
    assert_eq!(parse(&full).expect(&full), parse(LEAST_RECONFIGURE).expect("least"), "{full}");
}

#[test]
fn the_example_of_a_reconfiguration_can_be_planned() {
    let (_, example) = parts().1.split_once("```toml\n").expect("an example");
    let (example, _) = example.split_once("```").expect("its end");
    let scenario = ReconfigureScenario::parse("example.toml", example, Path::new("")).expect("parses");
    assert_eq!(scenario.problem.robots.len(), 2);
}

#[test]
fn every_key_of_a_roster_is_documented_with_its_default() {
    const LEAST: &str = "[[module]]\nid = 1\n";
    let documented = documented(rosters());
    let mut full = LEAST.to_owned();
    for (table, keys) in &documented {
        let below = |text: &str, line: &str| match table.as_str() {
            "" => format!("{line}{text}"),
            table => text.replace(&format!("[[{table}]]\n"), &format!("[[{table}]]\n{line}")),
        };
        let complaint =
            Roster::parse("t.toml", &below(LEAST, "no_such_key = 1\n")).expect_err("unknown").to_string();
        let (start, list) = complaint.split_once("expected").expect(&complaint);
        assert!(start.contains("unknown field `no_such_key`"), "{complaint}");
        let known: BTreeSet<String> = list.split('`').skip(1).step_by(2).map(str::to_owned).collect();
        let mut expected: BTreeSet<String> = keys.keys().cloned().collect();
        if table.is_empty() {
            expected.extend(documented.keys().filter(|table| !table.is_empty()).cloned());
        }
        assert_eq!(known, expected, "[{table}]: left the program, right the README");
        for (key, default) in keys {
            if let Some(literal) = default.strip_prefix('`').and_then(|rest| rest.strip_suffix('`')) {
                full = below(&full, &format!("{key} = {literal}\n"));
            }
        }
    }
    assert_eq!(documented["module"].len(), 4);
    assert_eq!(
        Roster::parse("t.toml", &full).expect(&full),
        Roster::parse("t.toml", LEAST).expect("least"),
        "{full}"
    );
}

#[test]
fn the_example_of_a_roster_can_be_read() {
    let (_, example) = rosters().split_once("```toml\n").expect("an example");
    let (example, _) = example.split_once("```").expect("its end");
    let roster = Roster::parse("example.toml", example).expect("parses");
    assert_eq!(roster.ids().map(|id| id.0).collect::<Vec<_>>(), [3, 7]);
}
