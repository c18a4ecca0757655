use std::f64::consts::{FRAC_PI_2, PI};

use super::*;

/// Two modules side by side with tails that swing about north, alike; both came a quarter turn, and all of it is true.
fn cleared() -> (Request, Answer) {
    let cycle = vec![[FRAC_PI_2, 1.0]; 2];
    let start = FRAC_PI_2 + 1.0;
    // 0.022·1 − 0.019 = 0.003 N each, southwards; the torques of x = ±0.075 m cancel.
    let wrench = [0.0, -0.006, 0.0];
    let demand = [0.0, -0.012, 0.0];
    let request = Request {
        cells: vec![[0, 0], [1, 0]],
        demand,
        tail_rad: Some(vec![start - 0.5, start - 0.25]),
        previous: None,
    };
    let mut answer = Answer {
        outcome: "planned".to_owned(),
        cycle,
        transition: Some(vec![[start - 0.5, start], [start - 0.25, start]]),
        via_rad: None,
        turning_s: None,
        wrench,
        error: 0.5,
        travel_rad: 0.75,
        clearance_m: None,
        loss_tolerant: false,
    };
    answer.clearance_m = Some(brute_clearance_m(&answer));
    (request, answer)
}

/// Least clearance of module 1 and its neighbour to the right, at ten thousand samples a phase.
fn brute_clearance_m(answer: &Answer) -> f64 {
    let mut least = f64::INFINITY;
    for k in 0..=10_000 {
        let share = f64::from(k) / 10_000.0;
        let swing = |m: usize| answer.cycle[m][0] + answer.cycle[m][1] * (TAU * share).cos();
        let mut poses = vec![[swing(0), swing(1)]];
        for turns in answer.steps() {
            poses.push([0, 1].map(|m| turns[m][0] + share * (turns[m][1] - turns[m][0])));
        }
        for [a, b] in poses {
            least = least.min(geometry::between_tails_m(0.09, [0.15, 0.0], a, b) - 0.015);
        }
    }
    least
}

#[track_caller]
fn refused(change: impl FnOnce(&mut Request, &mut Answer), because: &str) {
    let (mut request, mut answer) = cleared();
    change(&mut request, &mut answer);
    let message = check(&Modboat::default(), &request, &answer).expect_err("accepted");
    assert!(message.contains(because), "{message:?} does not say {because:?}");
}

#[test]
fn a_true_answer_is_accepted() {
    let (request, answer) = cleared();
    let least = check(&Modboat::default(), &request, &answer).expect("true").expect("two tails can meet");
    assert!((least - answer.clearance_m.expect("given")).abs() < STEP_M);
    // Tails that swing alike stay a pitch apart across; obliquely nearer.
    assert!(least > 0.02, "{least}");
}

#[test]
fn a_swim_that_collides_is_refused_with_modules_time_and_figures() {
    // Both swing through the line between them: at 0 s they are at ±1 rad off it, a quarter period later on it.
    let (mut request, mut answer) = cleared();
    answer.cycle = vec![[0.0, 1.0], [PI, -1.0]];
    answer.transition = Some(vec![[0.9, 1.0], [PI - 0.9, PI - 1.0]]);
    request.tail_rad = Some(vec![0.9, PI - 0.9]);
    request.demand = [0.0; 3];
    (answer.wrench, answer.error, answer.travel_rad) = ([0.0; 3], 0.0, 0.2);
    let message = check(&Modboat::default(), &request, &answer).expect_err("collides");
    assert!(message.contains("modules 1 and 2: -") && message.contains("s of the swim"), "{message}");
    // cos φ + … : tips 0.15 − 2·0.09·cos φ apart; below 0.015 from cos φ = 0.75, φ = 0.7227 = cos(2πt/1.5): t = 0.1822.
    let t_s: f64 = message.split("mm at ").nth(1).and_then(|t| t.split(' ').next()).unwrap().parse().unwrap();
    assert!((t_s - 0.1822).abs() < 2e-3, "{message}");
}

#[test]
fn a_transition_that_collides_is_refused() {
    // From north by way of east and of west to the south: they meet between them.
    let (mut request, mut answer) = cleared();
    // The swims mirror each other and stay apart.
    answer.cycle = vec![[-FRAC_PI_2 - 0.5, 1.0], [0.5 - FRAC_PI_2, -1.0]];
    request.tail_rad = Some(vec![FRAC_PI_2, FRAC_PI_2]);
    answer.transition = Some(vec![[FRAC_PI_2, 0.5 - FRAC_PI_2], [FRAC_PI_2, 1.5 * PI - 0.5]]);
    let fy_n = 0.006 * 0.5_f64.cos();
    answer.wrench = [0.0, fy_n, 0.0];
    answer.error = (0.012 + fy_n) / 0.012;
    answer.travel_rad = 2.0 * (PI - 0.5);
    let message = check(&Modboat::default(), &request, &answer).expect_err("collides");
    assert!(message.contains("modules 1 and 2: -") && message.contains("of the transition"), "{message}");
}

#[test]
fn modules_that_are_not_neighbours_are_looked_at_too() {
    // Tails of 0.9 pitches reach across a diagonal; module 2 swims along, out of reach of either.
    let modboat = Modboat { tail_length_m: 0.134, ..Modboat::default() };
    let apart = pairs(&modboat, &[[0, 0], [1, 0], [1, 1], [3, 0], [0, 2]]);
    let names: Vec<_> = apart.iter().map(|pair| (pair.i, pair.j)).collect();
    assert_eq!(names, [(0, 1), (0, 2), (1, 2), (2, 4)]);
    let diagonal = apart[1].apart_m;
    assert!(least_m(&modboat, diagonal, TailMotion::Rest(PI / 4.0), TailMotion::Rest(1.25 * PI)).is_err());
    assert!(least_m(&modboat, diagonal, TailMotion::Rest(PI / 4.0), TailMotion::Rest(0.0)).is_ok());
}

#[test]
fn each_broken_rule_is_named() {
    refused(|_, a| a.cycle.truncate(1), "2 modules asked, 1 answered");
    refused(|_, a| a.outcome = "tried".to_owned(), "outcome");
    refused(|_, a| a.cycle[1][1] = 0.8, "out of range");
    refused(|_, a| a.cycle[0][1] = -2.7, "module 1: (");
    refused(|_, a| a.cycle[0][0] = f64::NAN, "out of range");
    refused(|r, _| r.tail_rad.as_mut().unwrap()[1] += 0.01, "module 2: turns from");
    refused(|_, a| a.transition.as_mut().unwrap()[0][1] += 0.01, "but its cycle starts at");
    refused(|_, a| a.transition.as_mut().unwrap()[0][1] += TAU, "turns at 13.5");
    refused(|_, a| a.transition = None, "module 1: comes to");
    refused(|r, _| r.tail_rad = None, "tail angles unknown");
    refused(|_, a| a.wrench[2] = 1e-6, "by (7)");
    refused(|_, a| a.error = 0.51, "error 0.51 said");
    refused(|r, _| r.demand = [0.0; 3], "error 0.5 said, 0.00");
    refused(|_, a| a.error = f64::NAN, "error NaN said");
    refused(|_, a| a.travel_rad = f64::NAN, "travel NaN rad said");
    refused(|_, a| a.transition.as_mut().unwrap()[1] = [f64::NAN; 2], "module 2: comes to NaN");
    refused(|_, a| a.travel_rad = 0.7, "travel 0.7 rad said");
    refused(|_, a| a.clearance_m = a.clearance_m.map(|c| c + 1e-3), "clearance");
    refused(|_, a| a.clearance_m = a.clearance_m.map(|c| c - 2e-3), "clearance");
    refused(|_, a| a.clearance_m = None, "clearance");
    refused(|_, a| a.outcome = "repeated".to_owned(), "nothing was before");
    refused(
        |r, a| {
            a.outcome = "repeated".to_owned();
            r.previous = Some(vec![[FRAC_PI_2, 1.0], [FRAC_PI_2, 1.1]]);
        },
        "not the cycle before",
    );
    refused(|_, a| a.outcome = "held".to_owned(), "held, but module 1 swings");
}

#[test]
fn a_tail_faster_than_it_can_be_is_refused() {
    let (request, answer) = cleared();
    let slow = Modboat { tail_speed_max_rad_s: 4.0, ..Modboat::default() };
    // 2π/1.5·1 = 4.19 rad/s.
    assert!(check(&slow, &request, &answer).expect_err("too fast").contains("swings at 4.18"));
}

#[test]
fn loss_tolerance_is_tried_out() {
    // Alike they swing clear through all directions; a tail that rests at the line between them is met.
    let (mut request, mut answer) = cleared();
    answer.cycle = vec![[FRAC_PI_2, 2.0]; 2];
    let start = FRAC_PI_2 + 2.0;
    request.tail_rad = Some(vec![start, start]);
    (answer.transition, answer.travel_rad) = (None, 0.0);
    // 0.022·2 − 0.019 = 0.025 N each.
    answer.wrench = [0.0, -0.05, 0.0];
    answer.error = 0.038 / 0.012;
    answer.clearance_m = Some(brute_clearance_m(&answer));
    let modboat = Modboat::default();
    check(&modboat, &request, &answer).expect("true as long as it does not claim to be loss tolerant");
    check_without(&modboat, &request, &answer, &[]).expect("no module is missing");
    check_without(&modboat, &request, &answer, &[0, 1]).expect("no module moves");
    check_without(&modboat, &request, &answer, &[1]).expect_err("module 1 swings into module 2");
    answer.loss_tolerant = true;
    let message = check(&modboat, &request, &answer).expect_err("one of them may rest in the other's way");
    assert!(message.contains("swim, which one of them missed"), "{message}");
    // Swings of ±1 rad about north from a rest at north-west meet no other.
    let (request, mut answer) = cleared();
    answer.loss_tolerant = true;
    check(&modboat, &request, &answer).expect("loss tolerant");
    refused(
        |r, a| {
            (r.tail_rad, a.transition, a.travel_rad) = (None, None, 0.0);
            a.loss_tolerant = true;
        },
        "tail angles unknown",
    );
}

#[test]
fn a_held_fleet_stays_where_it_is() {
    let request = Request {
        cells: vec![[0, 0], [0, 1]],
        demand: [0.01, 0.0, 0.0],
        tail_rad: Some(vec![0.0, 7.0]),
        previous: None,
    };
    let clearance_m = geometry::between_tails_m(0.09, [0.0, 0.15], 0.0, 7.0) - 0.015;
    let held = Answer {
        outcome: "held".to_owned(),
        cycle: vec![[0.0, 0.0], [7.0, 0.0]],
        transition: None,
        via_rad: None,
        turning_s: None,
        wrench: [0.0; 3],
        error: 1.0,
        travel_rad: 0.0,
        clearance_m: Some(clearance_m),
        loss_tolerant: true,
    };
    let modboat = Modboat::default();
    check(&modboat, &request, &held).expect("true");
    let moved = Answer { cycle: vec![[0.1, 0.0], [7.0, 0.0]], ..held.clone() };
    assert!(check(&modboat, &request, &moved).expect_err("moved").contains("module 1 is at 0 rad"));
    // Tails that touch may be told to stay, but that is not safe.
    let touching = Request { tail_rad: Some(vec![FRAC_PI_2, -FRAC_PI_2]), ..request };
    let mut held = Answer { cycle: vec![[FRAC_PI_2, 0.0], [-FRAC_PI_2, 0.0]], ..held };
    held.clearance_m = Some(-0.015);
    assert!(check(&modboat, &touching, &held).expect_err("not safe").contains("modules 1 and 2: -15.000 mm"));
    held.loss_tolerant = false;
    check(&modboat, &touching, &held).expect("no module moves");
    held.clearance_m = Some(0.01);
    assert!(check(&modboat, &touching, &held).is_err(), "a clearance that is none");
}

#[test]
fn a_line_of_json_is_read() {
    let line = r#"{"outcome":"planned","cycle":[{"centerline_rad":0.5,"amplitude_rad":-1.5}],
        "transition":[{"from_rad":1.0,"to_rad":-1.0}],"wrench":{"fx_n":1.0,"fy_n":2.0,"tau_nm":3.0},"error":0.25,
        "travel_rad":2.0,"clearance_m":null,"loss_tolerant":true,"planner":"potential-field","solve_us":12}"#;
    let answer = Answer::from_json(line).expect("valid");
    assert_eq!(answer.cycle, [[0.5, -1.5]]);
    assert_eq!(answer.transition, Some(vec![[1.0, -1.0]]));
    assert_eq!((answer.wrench, answer.clearance_m), ([1.0, 2.0, 3.0], None));
    let by_way = line.replace(r#""from_rad":1.0,"#, r#""from_rad":1.0,"via_rad":0.5,"#);
    let steps = Answer::from_json(&by_way).expect("valid").steps();
    assert_eq!(steps, [[[1.0, 0.5]], [[0.5, -1.0]]]);
    let unknown = by_way.replace("via_rad", "by_rad");
    assert!(Answer::from_json(&unknown).expect_err("unknown key").contains("by_rad"));
    assert!(Answer::from_json(r#"{"error":"no"}"#).is_err());
    assert!(Answer::from_json(&line.replace("null", "\"far\"")).is_err());
}

/// From north to the south, module 1 by way of east and module 2 of west: not both at once, but in two steps.
fn in_two_steps(via: [f64; 2]) -> (Request, Answer) {
    let (mut request, mut answer) = cleared();
    let (from, to) = ([FRAC_PI_2; 2], [0.5 - FRAC_PI_2, 1.5 * PI - 0.5]);
    answer.cycle = vec![[-FRAC_PI_2 - 0.5, 1.0], [0.5 - FRAC_PI_2, -1.0]];
    request.tail_rad = Some(from.to_vec());
    answer.transition = Some(vec![[from[0], to[0]], [from[1], to[1]]]);
    answer.via_rad = Some(via.to_vec());
    let fy_n = 0.006 * 0.5_f64.cos();
    (answer.wrench, answer.error) = ([0.0, fy_n, 0.0], (0.012 + fy_n) / 0.012);
    answer.travel_rad = (0..2).map(|m| (via[m] - from[m]).abs() + (to[m] - via[m]).abs()).sum();
    answer.clearance_m = Some(brute_clearance_m(&answer));
    (request, answer)
}

#[test]
fn two_steps_are_accepted_where_one_is_not_and_an_overlap_in_either_is_refused() {
    let modboat = Modboat::default();
    let (north, south) = (FRAC_PI_2, [0.5 - FRAC_PI_2, 1.5 * PI - 0.5]);
    // One after the other, and any of them may miss it.
    let (request, mut answer) = in_two_steps([south[0], north]);
    answer.loss_tolerant = true;
    check(&modboat, &request, &answer).expect("true");
    for (via, which) in [([south[0], south[1]], "first"), ([north, north], "second")] {
        let (request, answer) = in_two_steps(via);
        let message = check(&modboat, &request, &answer).expect_err(which);
        assert!(message.contains("of the transition"), "{which}: {message}");
    }
    // Module 2 comes by while module 1 leaves the way between them: if it never hears of leaving, they meet.
    let (request, mut answer) = in_two_steps([0.0, north]);
    check(&modboat, &request, &answer).expect("both go on");
    answer.loss_tolerant = true;
    let message = check(&modboat, &request, &answer).expect_err("one stays between");
    assert!(message.contains("which one of them missed"), "{message}");
}

#[test]
fn speed_and_travel_of_two_steps_are_both_looked_at() {
    let modboat = Modboat::default();
    let (request, answer) = in_two_steps([0.5 - FRAC_PI_2, FRAC_PI_2]);
    // 2.64 rad each, one step after the other.
    let fast = Answer { turning_s: Some(0.40), ..answer.clone() };
    assert!(check(&modboat, &request, &fast).expect_err("too fast").contains("module 1: turns at 13.2"));
    check(&modboat, &request, &Answer { turning_s: Some(0.41), ..answer.clone() }).expect("slow enough");
    let direct = Answer { travel_rad: 5.28, ..answer };
    check(&modboat, &request, &Answer { travel_rad: 5.2, ..direct }).expect_err("less than it travels");
    // A way about: there and back counts twice.
    let (request, mut about) = in_two_steps([0.0 - PI, FRAC_PI_2]);
    about.travel_rad = 2.0 * (PI - 0.5);
    assert!(check(&modboat, &request, &about).expect_err("too little").contains("travel"));
}

#[test]
fn a_module_may_rest_in_a_planned_cycle() {
    let (mut request, mut answer) = cleared();
    // Module 1 points up and to the left, away from module 2.
    answer.cycle[0] = [FRAC_PI_2 + 1.0, 0.0];
    let torque = -0.003 * 0.075;
    answer.wrench = [0.0, -0.003, torque];
    request.demand = [0.0, -0.012, 0.0];
    answer.error = 0.009_f64.hypot(10.0 * torque) / 0.012;
    answer.clearance_m = Some(brute_clearance_m(&answer));
    check(&Modboat::default(), &request, &answer).expect("true");
    // It gives nothing, whatever the plan says.
    answer.wrench = [0.0, -0.006, 0.0];
    assert!(check(&Modboat::default(), &request, &answer).expect_err("rests").contains("by (7)"));
    // Nor is a little more than nothing a rest.
    answer.cycle[0][1] = 1e-3;
    assert!(check(&Modboat::default(), &request, &answer).expect_err("swings").contains("out of range"));
}
