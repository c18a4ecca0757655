//! The contract of `flotilla plan`, through the binary, with mechanics written out here once more.

use std::f64::consts::TAU;
use std::io::Write;

use crate::common::{PATIENCE, Process};
use rand::rngs::ChaCha8Rng;
use rand::{RngExt, SeedableRng};
use serde_json::{Value, json};
use tempfile::tempdir;

const LINE: &str = "[[0,0],[1,0],[2,0]]";

fn request(cells: &str, [fx_n, fy_n, tau_nm]: [f64; 3], tail_rad: &str) -> String {
    format!(
        "{{\"cells\":{cells},\"demand\":{{\"fx_n\":{fx_n:?},\"fy_n\":{fy_n:?},\"tau_nm\":{tau_nm:?}}},\"tail_rad\":{tail_rad}}}"
    )
}

/// A `flotilla plan` that is asked one line at a time.
struct Filter(Process);

impl Filter {
    fn start(arguments: &[&str]) -> Self {
        let folder = std::env::temp_dir();
        Self(Process::start(&folder, &[&["plan"], arguments].concat()))
    }

    /// The answer to one request, before another is sent.
    fn ask(&mut self, line: &str) -> Value {
        writeln!(self.0.input.as_mut().expect("open"), "{line}").expect("it reads");
        let answer = self.0.out.recv_timeout(PATIENCE).expect("an answer that was flushed");
        serde_json::from_str(&answer).expect("JSON")
    }

    fn finish(self) {
        let finished = self.0.finish();
        assert_eq!((finished.code, finished.err.len(), finished.out.len()), (Some(0), 0, 0), "{finished:?}");
    }
}

fn number(value: &Value) -> f64 {
    value.as_f64().unwrap_or_else(|| panic!("{value} is no number"))
}

fn numbers(list: &Value, key: &str) -> Vec<f64> {
    list.as_array().expect("a list").iter().map(|item| number(&item[key])).collect()
}

fn keys(value: &Value) -> Vec<&str> {
    let mut keys: Vec<_> = value.as_object().expect("an object").keys().map(String::as_str).collect();
    keys.sort_unstable();
    keys
}

/// How far two angles are apart on the circle, rad.
fn apart_rad(a: f64, b: f64) -> f64 {
    let turn = (a - b).rem_euclid(TAU);
    turn.min(TAU - turn)
}

fn close(a: f64, b: f64, what: &str) {
    assert!((a - b).abs() <= 1e-9 * (1.0 + a.abs()), "{what}: {a} ≠ {b}");
}

/// All that the contract says of one plan. `tails` are the angles where the plan begins, if they are known.
fn check(plan: &Value, cells: &str, demand: [f64; 3], tails: Option<&[f64]>) {
    let cells: Vec<[i32; 2]> = serde_json::from_str(cells).expect("cells");
    let modules = cells.len();
    let always = [
        "clearance_m",
        "cycle",
        "error",
        "loss_tolerant",
        "outcome",
        "planner",
        "solve_us",
        "transition",
        "travel_rad",
        "wrench",
    ];
    let (now_and_then, asked): (Vec<&str>, Vec<&str>) =
        keys(plan).into_iter().partition(|key| ["guarantee_m", "reason"].contains(key));
    assert_eq!(asked, always);
    // What is guaranteed is no more than what is planned.
    if now_and_then.contains(&"guarantee_m") {
        assert!(plan["planner"] == "exact" && tails.is_some(), "{plan}");
        assert!(plan["guarantee_m"].as_f64() <= plan["clearance_m"].as_f64(), "{plan}");
        assert!(plan["outcome"] == "held" || plan["guarantee_m"].as_f64() > Some(0.0), "{plan}");
    }
    let outcome = plan["outcome"].as_str().expect("a word");
    assert!(["planned", "repeated", "held"].contains(&outcome), "{outcome}");
    assert!(["exact", "potential-field"].contains(&plan["planner"].as_str().expect("a name")), "{plan}");
    assert!(plan["solve_us"].is_u64() && plan["loss_tolerant"].is_boolean(), "{plan}");
    let cycle = plan["cycle"].as_array().expect("a list");
    assert_eq!(cycle.len(), modules);
    for swing in cycle {
        assert_eq!(keys(swing), ["amplitude_rad", "centerline_rad"]);
    }
    let (centerlines, amplitudes) =
        (numbers(&plan["cycle"], "centerline_rad"), numbers(&plan["cycle"], "amplitude_rad"));

    // F = 0.022·|A| − 0.019 (2); Fx = −F·cos φ₀, Fy = −F·sin φ₀, τ = x·Fy − y·Fx (7); centre of mass at the mean.
    let mean = [0, 1].map(|axis| cells.iter().map(|c| f64::from(c[axis])).sum::<f64>() / modules as f64);
    let mut wrench = [0.0; 3];
    for ((cell, phi), amplitude) in cells.iter().zip(&centerlines).zip(&amplitudes) {
        let size = amplitude.abs();
        // Held, no module moves; planned, a module may rest.
        if size == 0.0 {
            continue;
        }
        assert!(outcome != "held", "{plan}");
        assert!((0.9 - 1e-9..=2.6 + 1e-9).contains(&size), "amplitude {amplitude}");
        let [x, y] = [0, 1].map(|axis| (f64::from(cell[axis]) - mean[axis]) * 0.15);
        let thrust = 0.022 * size - 0.019;
        let (fx, fy) = (-thrust * phi.cos(), -thrust * phi.sin());
        wrench = [wrench[0] + fx, wrench[1] + fy, wrench[2] + x * fy - y * fx];
    }
    let told = ["fx_n", "fy_n", "tau_nm"].map(|key| number(&plan["wrench"][key]));
    assert_eq!(keys(&plan["wrench"]), ["fx_n", "fy_n", "tau_nm"]);
    (0..3).for_each(|axis| close(told[axis], wrench[axis], "wrench"));

    // error = ‖w∘(F_des − F)‖ / ‖w∘F_des‖, w = (1, 1, 10); absolute for a zero demand
    let weighted = |v: [f64; 3]| (v[0].powi(2) + v[1].powi(2) + (10.0 * v[2]).powi(2)).sqrt();
    let off = weighted([0, 1, 2].map(|axis| demand[axis] - wrench[axis]));
    let size = weighted(demand);
    close(number(&plan["error"]), if size == 0.0 { off } else { off / size }, "error");

    let starts: Vec<f64> = centerlines.iter().zip(&amplitudes).map(|(phi, a)| phi + a).collect();
    match (&plan["transition"], tails) {
        (Value::Null, None) => {
            assert_eq!(plan["loss_tolerant"], false, "nothing is known about the tails");
            close(number(&plan["travel_rad"]), 0.0, "travel");
        }
        (Value::Null, Some(tails)) => {
            close(number(&plan["travel_rad"]), 0.0, "travel");
            for (tail, start) in tails.iter().zip(&starts).filter(|_| outcome != "held") {
                assert!(apart_rad(*tail, *start) < 1e-6, "no transition, but {tail} is not {start}");
            }
        }
        (turns, tails) => {
            let tails = tails.expect("no transition without known tails");
            let (from, to) = (numbers(turns, "from_rad"), numbers(turns, "to_rad"));
            assert_eq!(from, tails, "a transition begins where the tails are");
            for (to, start) in to.iter().zip(&starts) {
                assert!(apart_rad(*to, *start) < 1e-6, "to_rad {to} ≢ centerline + amplitude {start}");
            }
            let travel: f64 = from.iter().zip(&to).map(|(from, to)| (to - from).abs()).sum();
            close(number(&plan["travel_rad"]), travel, "travel");
            // 13 rad/s for 0.5 s
            assert!(from.iter().zip(&to).all(|(from, to)| (to - from).abs() <= 6.5 + 1e-9), "{turns}");
        }
    }
    match plan["clearance_m"].as_f64() {
        Some(clearance_m) => assert!(modules > 1 && clearance_m > 0.0 && clearance_m < 0.3, "{clearance_m}"),
        None => assert!(plan["clearance_m"].is_null() && modules == 1, "{plan}"),
    }
}

/// Where a plan leaves the tails.
fn ends(plan: &Value, tails: Option<&[f64]>) -> Vec<f64> {
    match (&plan["transition"], tails) {
        (Value::Null, Some(tails)) => tails.to_vec(),
        (Value::Null, None) => {
            let (phi, a) =
                (numbers(&plan["cycle"], "centerline_rad"), numbers(&plan["cycle"], "amplitude_rad"));
            phi.iter().zip(a).map(|(phi, a)| phi + a).collect()
        }
        (turns, _) => numbers(turns, "to_rad"),
    }
}

#[test]
fn a_first_cycle_knows_nothing_of_the_tails() {
    let mut filter = Filter::start(&[]);
    let demand = [0.02, 0.0, 0.0];
    let plan = filter.ask(&request(LINE, demand, "null"));
    check(&plan, LINE, demand, None);
    assert_eq!((&plan["outcome"], &plan["transition"]), (&json!("planned"), &Value::Null));
    assert!(number(&plan["error"]) < 0.05, "well inside the envelope: {plan}");
    filter.finish();
}

#[test]
fn previous_goes_on_where_the_last_plan_ends() {
    let mut filter = Filter::start(&["--planner", "potential-field"]);
    let mut tails: Option<Vec<f64>> = None;
    let mut turned = 0;
    for step in 0..20 {
        let angle = f64::from(step) * 0.7;
        let demand = [0.03 * angle.cos(), 0.03 * angle.sin(), 0.002 * (2.0 * angle).sin()];
        let plan = filter.ask(&request(LINE, demand, if step == 0 { "null" } else { "\"previous\"" }));
        check(&plan, LINE, demand, tails.as_deref());
        turned += usize::from(!plan["transition"].is_null());
        tails = Some(ends(&plan, tails.as_deref()));
    }
    assert!(turned >= 10, "other forces need other tails: {turned}");
    filter.finish();
}

#[test]
fn angles_may_have_any_number_of_turns() {
    let mut filter = Filter::start(&[]);
    let demand = [0.0, 0.03, 0.0];
    for turns in [0.0, 1.0, -7.0, 1000.0] {
        let tails = [0.1, 1.4, -1.0].map(|tail| tail + turns * TAU);
        let plan = filter.ask(&request(LINE, demand, &json!(tails).to_string()));
        check(&plan, LINE, demand, Some(&tails));
        assert_eq!(plan["outcome"], "planned", "from {turns} turns: {plan}");
    }
    filter.finish();
}

#[test]
fn the_error_of_a_zero_demand_is_absolute() {
    let mut filter = Filter::start(&[]);
    let mut tails: Option<Vec<f64>> = None;
    for (cells, word) in [(LINE, "null"), (LINE, "\"previous\""), ("[[0,0]]", "null")] {
        tails = tails.filter(|_| word != "null");
        let plan = filter.ask(&request(cells, [0.0; 3], word));
        check(&plan, cells, [0.0; 3], tails.as_deref());
        assert!(number(&plan["error"]) < 0.05, "{plan}");
        tails = Some(ends(&plan, tails.as_deref()));
    }
    filter.finish();
}

#[test]
fn one_module_alone_is_a_structure() {
    let mut filter = Filter::start(&[]);
    for tails in ["null", "\"previous\"", "[0.5]"] {
        let plan = filter.ask(&request("[[5,-3]]", [0.02, 0.01, 0.0], tails));
        assert_eq!((&plan["outcome"], &plan["clearance_m"]), (&json!("planned"), &Value::Null), "{plan}");
        assert!(number(&plan["error"]) < 0.05, "{plan}");
    }
    let demand = [0.0, 0.02, 0.0];
    let plan = filter.ask(&request("[[5,-3]]", demand, "[0.5]"));
    check(&plan, "[[5,-3]]", demand, Some(&[0.5]));
    filter.finish();
}

#[test]
fn tails_that_lie_across_each_other_hold_or_part() {
    // The left tail points right, the right one left: they overlap. No plan may claim clearance.
    let mut filter = Filter::start(&[]);
    let cells = "[[0,0],[1,0]]";
    let plan = filter.ask(&request(cells, [0.02, 0.0, 0.0], "[0.0,3.141592653589793]"));
    assert_eq!(plan["outcome"], "held", "{plan}");
    assert!(number(&plan["clearance_m"]) < 0.0, "{plan}");
    assert_eq!(plan["loss_tolerant"], false);
    assert_eq!(plan["transition"], Value::Null);
    for key in ["fx_n", "fy_n", "tau_nm"] {
        close(number(&plan["wrench"][key]), 0.0, key);
    }
    // The stream can go on from there, and from elsewhere.
    assert_eq!(filter.ask(&request(cells, [0.02, 0.0, 0.0], "\"previous\""))["outcome"], "held");
    assert_eq!(filter.ask(&request(cells, [0.02, 0.0, 0.0], "[1.5,1.5]"))["outcome"], "planned");
    filter.finish();
}

/// Two hundred requests about five shapes: first cycles, known angles, and "previous" mixed.
fn stream(seed: u64) -> Vec<(&'static str, [f64; 3], String)> {
    const SHAPES: [&str; 5] =
        [LINE, "[[0,0]]", "[[0,0],[0,1]]", "[[0,0],[1,0],[1,1],[2,1]]", "[[0,0],[1,0],[0,1],[1,1]]"];
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    let mut last = "";
    (0..200)
        .map(|_| {
            let stay = !last.is_empty() && rng.random_range(0..3) > 0;
            let cells = if stay { last } else { SHAPES[rng.random_range(0..SHAPES.len())] };
            let modules = cells.matches('[').count() - 1;
            let tails = match rng.random_range(0..4) {
                0 => "null".to_owned(),
                // All parallel: no two of them meet.
                1 => json!(vec![rng.random_range(-9.0..9.0); modules]).to_string(),
                _ if cells == last => "\"previous\"".to_owned(),
                _ => "null".to_owned(),
            };
            last = cells;
            let reach = 0.02 * modules as f64;
            let demand = [
                rng.random_range(-reach..reach),
                rng.random_range(-reach..reach),
                rng.random_range(-0.002..0.002) * (modules as f64 - 1.0),
            ];
            (cells, demand, tails)
        })
        .collect()
}

#[test]
fn two_hundred_requests_are_answered_in_order_and_alike_each_time() {
    let seed = 20_260_101;
    let requests = stream(seed);
    let text: String =
        requests.iter().map(|(cells, demand, tails)| request(cells, *demand, tails) + "\n").collect();
    let folder = tempdir().expect("a folder");
    let answers = [(); 2].map(|()| {
        let finished = Process::given(folder.path(), &["plan"], &text);
        assert_eq!((finished.code, finished.err.len()), (Some(0), 0), "{:?}", finished.err);
        let mut plans: Vec<Value> =
            finished.out.iter().map(|line| serde_json::from_str(line).expect("JSON")).collect();
        for plan in &mut plans {
            let solve_us = plan.as_object_mut().expect("a plan").insert("solve_us".to_owned(), json!(0));
            assert!(solve_us.is_some_and(|time| time.is_u64()), "{plan}");
        }
        plans
    });
    assert_eq!(answers[0].len(), requests.len());
    assert!(answers[0] == answers[1], "the same stream, other plans");

    let mut tails: Option<Vec<f64>> = None;
    let mut kinds = [0; 3];
    for (index, ((cells, demand, word), plan)) in requests.iter().zip(&answers[0]).enumerate() {
        println!("seed {seed}, request {index}: {}", request(cells, *demand, word));
        tails = match word.as_str() {
            "null" => None,
            "\"previous\"" => tails,
            list => Some(serde_json::from_str(list).expect("angles")),
        };
        check(plan, cells, *demand, tails.as_deref());
        tails = Some(ends(plan, tails.as_deref()));
        kinds[["planned", "repeated", "held"]
            .iter()
            .position(|kind| plan["outcome"] == *kind)
            .expect("one")] += 1;
    }
    assert!(kinds[0] >= 190, "planned, repeated, held: {kinds:?}");
}

/// What a scenario says about modules and planner holds for `plan` too.
#[test]
fn a_scenario_describes_the_modules() {
    let folder = tempdir().expect("a folder");
    let text = "name = \"t\"\n[structure]\nsize = \"1x1\"\n[[leg]]\nduration_s = 1\nvelocity_m_s = [0, 0]\n\
                heading_rad = 0\n[modboat]\namplitude_min_rad = 1.0\namplitude_max_rad = 1.2\n";
    std::fs::write(folder.path().join("t.toml"), text).expect("a file");
    let arguments = ["plan", "--scenario", "t.toml"];
    let finished = Process::given(folder.path(), &arguments, &request(LINE, [0.1, 0.0, 0.0], "null"));
    assert_eq!(finished.code, Some(0), "{finished:?}");
    let answer: Value = serde_json::from_str(&finished.out[0]).expect("JSON");
    for amplitude in numbers(&answer["cycle"], "amplitude_rad") {
        assert!((1.0 - 1e-9..=1.2 + 1e-9).contains(&amplitude.abs()), "{amplitude}");
    }
}
