//! `scenarios/README.md` against the program: the same tables, the same keys, the same defaults.
//!
//! The program is asked through what reads its files alone, [`Scenario::parse`] and its like: a key that cannot exist makes
//! them list those that can, and a file with every default written out must equal one with none.

use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;

use host::run::reconfigure::scenario::ReconfigureScenario;
use host::run::roster::Roster;
use host::run::scenario::Scenario;
use reader::Document;
use reconfiguration::plan::Plan;
use reconfiguration::vehicle::Vehicle;
use serde_json::Value;

const README: &str = include_str!("../../scenarios/README.md");

/// The part under a title of the first rank.
fn part(title: &str) -> &'static str {
    let mut parts = README.split("\n# ").map(|part| part.trim_start_matches("# "));
    parts.find(|part| part.starts_with(&format!("{title}\n"))).expect(title)
}

/// The first block of code in `language` there.
fn example(part: &'static str, language: &str) -> &'static str {
    let (_, rest) = part.split_once(&format!("```{language}\n")).expect("an example");
    rest.split_once("```").expect("its end").0
}

/// The keys that a complaint about `no_such_key` lists.
fn listed(complaint: &str) -> BTreeSet<String> {
    let (start, list) = complaint.split_once("expected").expect(complaint);
    assert!(start.contains("unknown field `no_such_key`"), "{complaint}");
    list.split('`').skip(1).step_by(2).map(str::to_owned).collect()
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
    listed(&complaint)
}

#[test]
fn every_key_is_documented_and_no_other() {
    let documented = documented(part("Scenarios"));
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
    for (table, keys) in documented(part("Scenarios")) {
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
    let example = example(part("Scenarios"), "toml");
    assert_eq!(Scenario::parse("example.toml", example).expect("parses").structure.len(), 2);
}

/// The least of a reconfiguration; a robot keeps its place.
const LEAST_RECONFIGURE: &str = "name = \"t\"\n[[robot]]\nid = 1\nvehicle = \"bluerov1\"\nstart = [0.0, 0.0, 0.0, 0.0]\n\
                                 [[slot]]\npose = [0.0, 0.0, 0.0, 0.0]\n";

#[test]
fn every_key_of_a_reconfiguration_is_documented_with_its_default() {
    let parse = |text: &str| ReconfigureScenario::parse("t.toml", text, Path::new(""));
    let documented = documented(part("Reconfigurations"));
    let tables: BTreeSet<String> = documented.keys().filter(|table| !table.is_empty()).cloned().collect();
    let mut full = LEAST_RECONFIGURE.to_owned();
    for (table, keys) in &documented {
        let unknown = "no_such_key = 1\n";
        let text = match table.as_str() {
            "" => format!("{unknown}{LEAST_RECONFIGURE}"),
            "rules" | "pose" | "bounds" => format!("{LEAST_RECONFIGURE}[{table}]\n{unknown}"),
            "tool" => format!("{LEAST_RECONFIGURE}[[tool]]\n{unknown}"),
            table => LEAST_RECONFIGURE.replace(&format!("[[{table}]]\n"), &format!("[[{table}]]\n{unknown}")),
        };
        let complaint = parse(&text).expect_err(&text).to_string();
        let known = listed(&complaint);
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
                "rules" | "pose" if full.contains(&format!("\n[{table}]")) => {
                    full.replace(&format!("\n[{table}]\n"), &format!("\n[{table}]\n{key} = {literal}\n"))
                }
                "rules" | "pose" => format!("{full}[{table}]\n{key} = {literal}\n"),
                table => {
                    full.replace(&format!("[[{table}]]\n"), &format!("[[{table}]]\n{key} = {literal}\n"))
                }
            };
        }
    }
    assert_eq!(documented["rules"].len(), 16);
    assert_eq!(parse(&full).expect(&full), parse(LEAST_RECONFIGURE).expect("least"), "{full}");
}

#[test]
fn the_example_of_a_reconfiguration_can_be_planned() {
    let example = example(part("Reconfigurations"), "toml");
    let scenario = ReconfigureScenario::parse("example.toml", example, Path::new("")).expect("parses");
    assert_eq!(scenario.problem.robots.len(), 2);
}

#[test]
fn every_key_of_a_roster_is_documented_with_its_default() {
    const LEAST: &str = "[[module]]\nid = 1\n";
    let documented = documented(part("Rosters"));
    let mut full = LEAST.to_owned();
    for (table, keys) in &documented {
        let below = |text: &str, line: &str| match table.as_str() {
            "" => format!("{line}{text}"),
            table => text.replace(&format!("[[{table}]]\n"), &format!("[[{table}]]\n{line}")),
        };
        let complaint =
            Roster::parse("t.toml", &below(LEAST, "no_such_key = 1\n")).expect_err("unknown").to_string();
        let known = listed(&complaint);
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
    assert_eq!(documented["module"].len(), 7);
    assert_eq!(
        Roster::parse("t.toml", &full).expect(&full),
        Roster::parse("t.toml", LEAST).expect("least"),
        "{full}"
    );
}

#[test]
fn the_example_of_a_roster_can_be_read() {
    let example = example(part("Rosters"), "toml");
    let roster = Roster::parse("example.toml", example).expect("parses");
    assert_eq!(roster.ids().map(|id| id.0).collect::<Vec<_>>(), [3, 7]);
}

#[test]
fn every_key_of_a_vehicle_is_documented_with_its_default() {
    let documented = documented(part("Vehicles"));
    let connector =
        "[[connectors]]\nname = \"nose\"\nposition_m = [0.2, 0.0, 0.0]\nnormal = [1.0, 0.0, 0.0]\n";
    let least = format!("{}{connector}", example(part("Vehicles"), "toml"));
    let tables: BTreeSet<&str> =
        documented.keys().map(String::as_str).filter(|table| !table.is_empty()).collect();
    assert_eq!(tables, BTreeSet::from(["connectors", "thrusters"]));
    let below = |text: &str, table: &str, line: &str| match table {
        "" => format!("{line}{text}"),
        table => text.replacen(&format!("[[{table}]]\n"), &format!("[[{table}]]\n{line}"), 1),
    };
    let mut full = least.clone();
    for (table, keys) in &documented {
        let unknown = below(&least, table, "no_such_key = 1\n");
        let complaint = Vehicle::parse("v.toml", &unknown).expect_err(&unknown).to_string();
        let mut expected: BTreeSet<String> = keys.keys().cloned().collect();
        if table.is_empty() {
            expected.extend(tables.iter().map(|table| (*table).to_owned()));
        }
        assert_eq!(listed(&complaint), expected, "[{table}]: left the program, right the README");
        for (key, default) in keys {
            let stated = least.lines().find(|line| line.starts_with(&format!("{key} = ")));
            assert_eq!(stated.is_some(), default == "required", "{key}");
            if let Some(literal) = default.strip_prefix('`').and_then(|rest| rest.strip_suffix('`')) {
                full = below(&full, table, &format!("{key} = {literal}\n"));
            }
        }
    }
    let parse = |text: &str| Vehicle::parse("v.toml", text).unwrap_or_else(|error| panic!("{error}\n{text}"));
    assert_eq!(parse(&full), parse(&least), "{full}");
    // What is required cannot be left out.
    let alone = example(part("Vehicles"), "toml");
    for (key, _) in documented[""].iter().filter(|(_, default)| *default == "required") {
        let kept = alone.split_inclusive('\n').filter(|line| !line.starts_with(&format!("{key} = ")));
        let without: String = kept.collect();
        let complaint = Vehicle::parse("v.toml", &without).err().map(|error| error.to_string());
        let complaint = complaint.unwrap_or_else(|| panic!("{key} can be left out"));
        assert!(complaint.ends_with(&format!("missing field `{key}`")), "{complaint}");
    }
}

/// Objects of a plan by their documented names, the first of each.
fn first_of<'a>(plan: &'a mut Value, table: &str) -> &'a mut Value {
    let steps = table.split('.').filter(|step| !step.is_empty());
    steps.fold(plan, |value, step| &mut value[step][0])
}

#[test]
fn every_key_of_a_plan_is_documented_and_the_example_keeps_every_condition() {
    let text = example(part("Plans"), "json");
    let read = |text: &str| Document::json(text).and_then(|document| document.read::<Plan>());
    let plan = read(text).expect("a plan");
    let documented = documented(part("Plans"));
    assert_eq!(documented.len(), 5);
    for (table, keys) in &documented {
        let edited = |edit: &dyn Fn(&mut serde_json::Map<String, Value>)| {
            let mut value: Value = serde_json::from_str(text).expect("JSON");
            edit(first_of(&mut value, table).as_object_mut().expect(table));
            read(&value.to_string()).map_err(|mistake| mistake.message)
        };
        let complaint = edited(&|object| drop(object.insert("no_such_key".to_owned(), 1.into())));
        let expected: BTreeSet<String> = keys.keys().cloned().collect();
        assert_eq!(
            listed(&complaint.expect_err(table)),
            expected,
            "{table}: left the program, right the README"
        );
        for (key, default) in keys {
            let without = edited(&|object| drop(object.remove(key)));
            if default == "required" {
                let complaint = without.expect_err(key);
                assert!(complaint.ends_with(&format!("missing field `{key}`")), "{complaint}");
                continue;
            }
            let literal: Value = serde_json::from_str(default.trim_matches('`')).expect(key);
            let with = edited(&|object| drop(object.insert(key.clone(), literal.clone())));
            assert_eq!(without.expect(key), with.expect(key), "{key}");
        }
    }
    let scenario = example(part("Reconfigurations"), "toml");
    let scenario = ReconfigureScenario::parse("example.toml", scenario, Path::new("")).expect("parses");
    let found = judge::verify(&scenario.problem, &plan);
    assert!(found.is_empty(), "{}", found.iter().map(|wrong| format!("{wrong}\n")).collect::<String>());
}
