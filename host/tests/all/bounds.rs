//! A structure that is told to swim through the edge of the water keeps off it, in a current and in gusts.

use host::run::experiment::simulate;
use host::run::scenario::Scenario;
use modboat::bounds::{Place, centres_m, footprint_m};
use modboat::parameters::Parameters;
use quantity::bounds::Bounds;

use crate::cores::all_cores;

/// Legs through each wall, with turns, in the tank of `edge_m`.
fn scenario(edge_m: &str, size: &str, turn_rad: f64, current: [f64; 2]) -> Scenario {
    let mut text = format!("name = \"t\"\n[structure]\nsize = \"{size}\"\n");
    for (index, velocity) in [[0.06, 0.01], [-0.02, 0.06], [-0.06, -0.03], [0.03, -0.06]].iter().enumerate() {
        let [x, y] = velocity;
        let heading_rad = turn_rad + 0.8 * index as f64;
        text +=
            &format!("[[leg]]\nduration_s = 40.0\nvelocity_m_s = [{x}, {y}]\nheading_rad = {heading_rad}\n");
    }
    text += &format!(
        "[start]\nposition_m = [-0.3, -0.3]\n[bounds]\nedge_m = {edge_m}\n[tank]\ncurrent_m_s = [{}, {}]\ngust_m_s = 0.005\n",
        current[0], current[1]
    );
    Scenario::parse("t.toml", &text).expect("valid")
}

/// Least distance of the footprint from the edge over a run, m; negative outside.
fn least_room_m(scenario: &Scenario, seed: u64) -> f64 {
    let bounds: &Bounds = scenario.bounds.as_ref().expect("it has bounds");
    let result = simulate(scenario, seed).expect("it runs");
    assert!(result.summary.cycles.bounded > 0, "seed {seed}: nothing was held back");
    let positions_m = scenario.structure.positions_m(Parameters::default().pitch_m);
    let mut least_m = f64::INFINITY;
    for pose in &result.record.poses {
        let place = Place { position_m: pose.position_m, heading_rad: pose.heading_rad };
        for centre_m in centres_m(&positions_m, place) {
            least_m = least_m.min(bounds.distance_m(centre_m) - footprint_m(&Parameters::default()));
        }
    }
    least_m
}

#[test]
fn no_wall_is_swum_through() {
    let _cores = all_cores();
    let square = "[[-1.2, -1.2], [1.2, -1.2], [1.2, 1.2], [-1.2, 1.2]]";
    let notched = "[[-1.2, -1.2], [1.2, -1.2], [1.2, 0.2], [0.2, 0.2], [0.2, 1.2], [-1.2, 1.2]]";
    let mut least_m = f64::INFINITY;
    for seed in 0..100 {
        let (edge_m, size) = ([square, notched][seed as usize % 2], ["3x1", "2x2", "1x3"][seed as usize % 3]);
        let angle = seed as f64;
        let current = [0.01 * angle.cos(), 0.01 * angle.sin()];
        let room_m = least_room_m(&scenario(edge_m, size, 0.37 * angle, current), seed);
        assert!(room_m > 0.0, "seed {seed}: {room_m:.3} m");
        least_m = least_m.min(room_m);
    }
    println!("100 seeds of 160 s: least room {:.1} mm", 1e3 * least_m);
}
