//! Hidden boats: what the water and the boat are like differs from what the host believes, and nothing of it was identified. The paper's four
//! experiments with either controller, and a loop that has one thing wrong at a time.
//! The boats are those of [`tests::hidden`].

use host::run::experiment::simulate;
use host::run::scenario::{BUILT_IN, Demand, Leg, Scenario};
use host::run::summary::Summary;
use modboat::envelope::Envelope;
use modboat::motion::Wrench;
use modboat::parameters::Parameters;
use modboat::structure::Structure;
use tests::hidden::Hidden;
use tests::seeds::{number, on_all_cores};

const CONTROLLERS: [&str; 2] = ["forgiving", "paper"];
const STATION: &str = "holonomic-station";

/// A scenario's own text, or that of three modules that keep a station, with more tables behind it.
fn scenario(name: &str, controller: &str, tables: &str) -> Scenario {
    let own = BUILT_IN.iter().find(|(built_in, _)| *built_in == name).map(|(_, text)| (*text).to_owned());
    let text = own.unwrap_or_else(|| {
        "name = \"holonomic-station\"\n[structure]\nsize = \"2x2\"\n[[leg]]\nduration_s = 180.0\nposition_m = [0.0, 0.0]\n\
         heading_rad = 1.5707963267948966\n"
            .to_owned()
    });
    let text = format!("{text}\n[control]\nkind = \"{controller}\"\n{tables}");
    Scenario::parse(name, &text).unwrap_or_else(|error| panic!("{error}\n{text}"))
}

/// `[tank]` and `[mocap]` of the hidden boat `seed`.
fn hidden(seed: u64) -> String {
    let structure = Structure::from_word("3x1").expect("three in a row");
    Hidden::new(&structure, &Parameters::default(), seed).tables
}

/// The greatest share of what the hidden boat `seed` can give that a leg of `scenario` asks for, steady and in its current.
fn asked(scenario: &Scenario, seed: u64) -> f64 {
    let belief = Parameters::default();
    let hidden = Hidden::new(&scenario.structure, &belief, seed);
    let truth =
        |name: &str| hidden.truth.iter().find(|(of, _)| *of == name).map_or(f64::NAN, |(_, value)| *value);
    let boat = Parameters {
        force_slope_n_rad: truth("force_slope_n_rad"),
        force_offset_n: truth("force_offset_n"),
        module_share: hidden.shares.clone(),
        ..belief
    };
    let envelope = Envelope::new(&scenario.structure.positions_m(boat.pitch_m), &boat);
    let modules = scenario.structure.len() as f64;
    let gauge = |leg: &Leg| {
        let Demand::Velocity([x, y]) = leg.demand else { return 0.0 };
        let through = [x - truth("current_east_m_s"), y - truth("current_north_m_s")];
        let (sin, cos) = leg.heading_rad.sin_cos();
        let sway = through[0] * sin - through[1] * cos;
        let surge = through[0] * cos + through[1] * sin;
        let fx_n = modules * truth("drag_sway_n_s2_m2") * sway * sway.abs();
        let fy_n = modules * truth("drag_surge_n_s2_m2") * surge * surge.abs();
        envelope.gauge(Wrench { fx_n, fy_n, tau_nm: 0.0 })
    };
    scenario.legs.iter().map(gauge).fold(0.0, f64::max)
}

/// Velocity error, heading RMS (rad), contacts; the worst of its legs.
fn worst(summary: &Summary) -> (f64, f64, usize) {
    let legs = summary.legs.iter();
    let moving = legs.clone().filter(|leg| leg.demand_m_s[0].hypot(leg.demand_m_s[1]) > 0.0);
    (
        moving.map(|leg| leg.velocity_error).fold(0.0, f64::max),
        legs.map(|leg| leg.heading_rms_rad).fold(0.0, f64::max),
        summary.contacts.len(),
    )
}

/// A leg whose heading strays like this is one of a loop that does not hold it. *Assumed.*
const UNSTABLE_RAD: f64 = 0.3;

#[test]
fn table_hidden_boats_keep_velocity_and_heading() {
    let boats = number("FLOTILLA_BOATS").unwrap_or(4);
    for controller in CONTROLLERS {
        let runs = on_all_cores(0..4 * boats, |index| {
            let (name, seed) = (format!("holonomic-{}", 1 + index % 4), 1 + index / 4);
            let run = simulate(&scenario(&name, controller, &hidden(seed)), seed);
            let run = run.unwrap_or_else(|error| panic!("{name}, seed {seed}: {error}"));
            (name, seed, worst(&run.summary))
        });
        let kept = runs
            .iter()
            .filter(|(_, _, (velocity, heading_rad, _))| *velocity <= 0.05 && *heading_rad <= 0.05);
        let kept = kept.count() as f64;
        // What no controller can meet: more than all of the thrust.
        let beyond =
            runs.iter().filter(|(name, seed, _)| asked(&scenario(name, controller, ""), *seed) > 1.0).count();
        let share = kept / (runs.len() - beyond) as f64;
        let mut velocities: Vec<f64> = runs.iter().map(|(_, _, (velocity, ..))| *velocity).collect();
        let mut headings: Vec<f64> = runs.iter().map(|(_, _, (_, heading_rad, _))| *heading_rad).collect();
        velocities.sort_by(f64::total_cmp);
        headings.sort_by(f64::total_cmp);
        let at = |values: &[f64], share: f64| values[((values.len() - 1) as f64 * share).round() as usize];
        println!(
            "{controller}: {} runs of {boats} boats, {:.1} % within 5 % and 0.05 rad, {:.1} % without the {beyond} that ask for more than the boat can give; velocity error median {:.2} %, 95 % {:.2} %, worst {:.2} %; \
             heading RMS {:.4}, {:.4}, {:.4} rad",
            runs.len(),
            100.0 * kept / runs.len() as f64,
            100.0 * share,
            100.0 * at(&velocities, 0.5),
            100.0 * at(&velocities, 0.95),
            100.0 * at(&velocities, 1.0),
            at(&headings, 0.5),
            at(&headings, 0.95),
            at(&headings, 1.0),
        );
        for (name, seed, (velocity, heading_rad, _)) in &runs {
            if *velocity > 0.05 || *heading_rad > 0.05 {
                let asked = asked(&scenario(name, controller, ""), *seed);
                println!(
                    "  beyond: {name}, boat {seed}: {:.1} %, {heading_rad:.4} rad; {:.0} % of what the boat can give are asked for",
                    100.0 * velocity,
                    100.0 * asked
                );
            }
        }
        if controller == "forgiving" {
            let bad: Vec<_> =
                runs.iter().filter(|(_, _, (_, h, contacts))| *h > UNSTABLE_RAD || *contacts > 0).collect();
            assert!(bad.is_empty(), "{bad:?}");
            assert!(share >= 0.95 || runs.len() < 100, "{share}");
        }
    }
}

#[test]
fn table_one_thing_wrong_at_a_time() {
    let thrust =
        |by: f64| format!("[tank.thrust]\nslope_n_rad = {}\noffset_n = {}\n", 0.022 * by, 0.019 * by);
    let drag = |by: f64| format!("[tank]\ndrag_sway_n_s2_m2 = {0}\ndrag_surge_n_s2_m2 = {0}\n", 4.5 * by);
    let late = "[mocap]\nlatency_s = 0.5\nstamped_on_arrival = true\n".to_owned();
    // Scenario, tables, velocity error, heading RMS (rad), station RMS (m) at most.
    let cases = [
        ("holonomic-1", "[tank]\ncurrent_m_s = [0.02, 0.0]\n".to_owned(), 0.01, 0.03, 1.0),
        ("holonomic-1", "[tank]\ncurrent_m_s = [0.0, -0.02]\n".to_owned(), 0.01, 0.03, 1.0),
        ("holonomic-1", drag(2.0), 0.01, 0.03, 1.0),
        ("holonomic-1", drag(0.5), 0.01, 0.03, 1.0),
        ("holonomic-1", thrust(0.5), 0.01, 0.03, 1.0),
        ("holonomic-1", thrust(1.5), 0.01, 0.03, 1.0),
        ("holonomic-1", thrust(2.0), 0.01, 0.03, 1.0),
        ("holonomic-1", late.clone(), 0.01, 0.02, 1.0),
        (STATION, thrust(0.5), 1.0, 0.03, 0.015),
        (STATION, thrust(1.5), 1.0, 0.03, 0.015),
        (STATION, thrust(2.0), 1.0, 0.03, 0.015),
        (STATION, late, 1.0, 0.02, 0.015),
        (STATION, "[tank]\ngust_m_s = 0.02\n".to_owned(), 1.0, 0.05, 0.022),
    ];
    let seeds = if number("FLOTILLA_BOATS").is_some() { 4 } else { 2 };
    let mut broken = Vec::new();
    for (name, tables, velocity, heading_rad, station_m) in &cases {
        let [ours, papers] = CONTROLLERS.map(|controller| {
            let runs = on_all_cores(1..seeds + 1, |seed| {
                simulate(&scenario(name, controller, tables), seed)
                    .unwrap_or_else(|error| panic!("{error}"))
                    .summary
            });
            let over = |of: &dyn Fn(&Summary) -> f64| runs.iter().map(of).sum::<f64>() / runs.len() as f64;
            let station = |run: &Summary| run.legs[0].station.as_ref().map_or(0.0, |station| station.rms_m);
            [over(&|run| worst(run).0), over(&|run| worst(run).1), over(&station)]
        });
        let shown = |[v, h, s]: [f64; 3]| format!("{:.2} % {:.4} rad {:.1} mm", 100.0 * v, h, 1e3 * s);
        println!("{name} {}: {} (paper {})", tables.replace('\n', " "), shown(ours), shown(papers));
        if ours[0] > *velocity || ours[1] > *heading_rad || ours[2] > *station_m {
            broken.push(format!("{name} {tables}: {}", shown(ours)));
        }
    }
    assert!(broken.is_empty(), "{}", broken.join("\n"));
}
