use std::collections::BTreeSet;

use host::run::scenario::Scenario;

use super::*;

const GOOD: &str = "name = \"c\"\nscenarios = [\"holonomic-1\", \"six\"]\nplanners = [\"exact\", \"potential-field\"]\nseeds = 3\n\
                    [grid]\n\"radio.loss\" = [0.0, 0.1]\ntank.gust_m_s = { from = 0.0, to = 0.02, steps = 3 }\n\
                    [sample]\nmethod = \"latin-hypercube\"\npoints = 4\n[sample.range]\n\
                    \"control.leak\" = { from = 0.5, to = 0.9 }\n\"radio.delay_s\" = { from = 0.001, to = 0.01, scale = \"log\" }\n\
                    [[controller]]\nname = \"as it is\"\n[[controller]]\nname = \"soft\"\nset.control.yaw_derivative_1_s = 1.0\n";

fn parse(text: &str) -> Result<Study, FileError> {
    Study::parse("c.toml", Path::new(""), text)
}

/// What only the water reads.
fn gust_m_s(scenario: &Scenario) -> Option<f64> {
    serde_json::to_value(&scenario.tank).expect("a document")["gust_m_s"].as_f64()
}

#[test]
fn every_combination_is_run_once() {
    let study = parse(GOOD).unwrap_or_else(|error| panic!("{error}"));
    assert_eq!(study.runs(), 2 * 2 * 2 * (2 * 3 * 4) * 3);
    let told: BTreeSet<String> = (0..study.runs())
        .map(|number| study.run(number).told().split_once(": ").expect("a number").1.to_owned())
        .collect();
    assert_eq!(told.len(), study.runs());
    let first = study.run(0);
    let keys: Vec<&str> = first.varied.iter().map(|(key, _)| *key).collect();
    assert_eq!(keys, ["radio.loss", "tank.gust_m_s", "control.leak", "radio.delay_s"]);
    let (scenario, seed) = study.run(study.runs() - 1).scenario().unwrap_or_else(|error| panic!("{error}"));
    assert_eq!((scenario.name.as_str(), seed, scenario.planner.kind.name()), ("six", 3, "potential-field"));
    assert!((scenario.radio.loss - 0.1).abs() < 1e-12 && gust_m_s(&scenario) == Some(0.02));
    assert!((scenario.control.yaw_derivative_1_s - 1.0).abs() < 1e-12);
    assert!((0.5..0.9).contains(&scenario.control.leak) && (0.001..0.01).contains(&scenario.radio.delay_s));
}

#[test]
fn the_order_of_keys_does_not_matter_and_the_seed_of_a_sample_does() {
    let varied = |text: &str| {
        let study = parse(text).unwrap_or_else(|error| panic!("{error}"));
        (0..study.runs()).map(|number| study.run(number).told()).collect::<Vec<_>>()
    };
    let turned = GOOD
        .replace("\"radio.loss\" = [0.0, 0.1]\n", "")
        .replace("steps = 3 }\n", "steps = 3 }\nradio.loss = [0.0, 0.1]\n");
    assert_ne!(turned, GOOD);
    assert_eq!(varied(&turned), varied(GOOD));
    assert_ne!(varied(&GOOD.replace("points = 4", "points = 4\nseed = 2")), varied(GOOD));
}

#[test]
fn a_scenario_without_changes_is_the_scenario() {
    let study = parse("name = \"c\"\nscenarios = [\"nine\"]\n").unwrap_or_else(|error| panic!("{error}"));
    let (scenario, seed) = study.run(0).scenario().expect("sound");
    let known = Scenario::open("nine").expect("it comes with the program");
    assert_eq!(study.runs(), 1);
    assert_eq!((scenario.document(), seed), (known.document(), known.seed));
}

#[test]
fn every_mistake_has_its_line_key_and_unit() {
    for (from, to, told) in [
        ("seeds = 3", "seeds = []", "c.toml:4: seeds: at least one"),
        ("seeds = 3", "seeds = [1, 1]", "c.toml:4: seeds: one of them is there twice"),
        ("seeds = 3", "seeds = \"3\"", "c.toml:4: seeds = \"3\": must be a number of seeds"),
        ("\"exact\",", "\"exat\",", "c.toml:3: planners[0] = \"exat\": unknown name"),
        ("\"exact\",", "\"potential-field\",", "c.toml:3: planners: \"potential-field\" is named twice"),
        ("\"six\"", "\"sixx\"", "sixx: no such file, and no built-in scenario of that name"),
        ("\"six\"", "\"holonomic-1\"", "c.toml:2: scenarios: two of them bear the name"),
        ("[0.0, 0.1]", "[0.0, 1.5]", "c.toml:6: [grid] radio.loss = 1.5: in holonomic-1: [radio] loss = 1.5"),
        ("[0.0, 0.1]", "[0.0, 0.0]", "c.toml:6: [grid] radio.loss: 0.0 is there twice"),
        (
            "[0.0, 0.1]",
            "0.1",
            "c.toml:6: [grid] radio.loss: must be a list of values, or { from, to, steps }",
        ),
        (
            "\"radio.loss\"",
            "\"radio.los\"",
            "c.toml:6: [grid] radio.los = 0.0: in holonomic-1: [radio] unknown field `los`",
        ),
        ("\"radio.loss\"", "\"seed\"", "c.toml:6: [grid] seed: is not varied: `seeds`"),
        ("\"radio.loss\"", "\"control.leak\"", "c.toml:6: [grid] control.leak: is set elsewhere too"),
        ("to = 0.02, steps = 3", "to = 0.02", "c.toml:7: [grid] tank.gust_m_s: steps: says how many values"),
        (
            "to = 0.02, steps = 3",
            "to = 0.02, step = 3",
            "c.toml:7: [grid] tank.gust_m_s: unknown field `step`",
        ),
        (
            "from = 0.0, to = 0.02",
            "from = -1.0, to = 0.02",
            "c.toml:7: [grid] tank.gust_m_s = -1.0: in holonomic-1: [tank] gust_m_s = -1 m/s",
        ),
        ("points = 4", "points = 0", "c.toml:10: [sample] points = 0: must lie between"),
        (
            "from = 0.5, to = 0.9",
            "from = 0.5, to = 0.5",
            "c.toml:12: [sample.range] control.leak: from = 0.5, to = 0.5: `from` must lie below",
        ),
        (
            "from = 0.001,",
            "from = 0.0,",
            "c.toml:13: [sample.range] radio.delay_s: from = 0: must be greater than zero",
        ),
        (
            "set.control.yaw",
            "set.control.yow",
            "c.toml:18: [[controller]] 2: in holonomic-1: [control] unknown field `yow_derivative_1_s`",
        ),
        ("\"soft\"", "\"as it is\"", "c.toml:17: [[controller]] 2: name = \"as it is\" is taken"),
        ("name = \"c\"", "name = \"a b\"", "c.toml:1: name = \"a b\": names folders and jobs too"),
        ("seeds = 3", "seeds = 900000", "c.toml:1: makes more than 1000000 runs"),
        ("seeds = 3", "seed = 3", "c.toml:4: unknown field `seed`"),
    ] {
        let text = GOOD.replacen(from, to, 1);
        assert_ne!(text, GOOD, "{from}");
        let error = parse(&text).expect_err(to).to_string();
        assert!(error.starts_with(told), "{error}\nexpected {told}");
    }
}

#[test]
fn ranges_are_even_and_hold_their_ends() {
    let text = "name = \"c\"\nscenarios = [\"holonomic-1\"]\n[grid]\n\
                \"radio.delay_s\" = { from = 0.001, to = 0.1, steps = 3, scale = \"log\" }\n\
                \"planner.epochs\" = { from = 1, to = 4, steps = 4, whole = true }\n";
    let study = parse(text).unwrap_or_else(|error| panic!("{error}"));
    let told: Vec<String> = (0..study.runs()).map(|number| study.run(number).told()).collect();
    assert_eq!(told.len(), 12);
    assert_eq!(told[0], "run 0: holonomic-1, planner.epochs = 1, radio.delay_s = 0.001");
    assert_eq!(told[11], "run 11: holonomic-1, planner.epochs = 4, radio.delay_s = 0.1");
    assert!(told[1].contains("radio.delay_s = 0.01"), "{}", told[1]);
}

#[test]
fn what_the_documentation_shows_and_what_comes_with_the_program_can_be_run() {
    let top = Path::new(env!("CARGO_MANIFEST_DIR")).join("..");
    let page = std::fs::read_to_string(top.join("docs/campaigns.md")).expect("part of the repository");
    let blocks: Vec<&str> = page
        .split("```toml\n")
        .skip(1)
        .filter_map(|rest| rest.split_once("```"))
        .map(|(block, _)| block)
        .collect();
    assert_eq!(blocks.len(), 2);
    for (block, runs) in blocks.iter().zip([120, 2 * 2 * 3 * 32 * 4]) {
        let study = parse(block).unwrap_or_else(|error| panic!("{error}\n{block}"));
        assert_eq!(study.runs(), runs, "{block}");
    }
    let told = "flotilla: loss.toml:7: [grid] radio.loss = 1.5: in holonomic-1: ";
    let told = page.lines().find(|line| line.starts_with(told)).expect("a mistake");
    let error =
        Study::parse("loss.toml", Path::new(""), &blocks[0].replace("0.3]", "1.5]")).expect_err("1.5");
    assert_eq!(format!("flotilla: {error}"), told);
    let mut names = BTreeSet::new();
    for entry in std::fs::read_dir(top.join("scenarios/campaigns")).expect("a folder") {
        let path = entry.expect("a file").path();
        let study = Study::open(&path).unwrap_or_else(|error| panic!("{error}"));
        assert_eq!(path.file_stem().and_then(|stem| stem.to_str()), Some(study.name.as_str()));
        names.insert(format!("{} {}", study.name, study.runs()));
    }
    assert!(names.contains("thousand 1000") && names.contains("experiments 160"), "{names:?}");
}
