//! The edge of the water, by hand.

use super::*;

/// Robot 2 turns by a radian at y = 0.3 m, where half its diagonal reaches 0.25 m to the side; 0.1 m of margin are asked.
#[test]
fn the_edge_of_the_water_is_kept_to_the_centimetre() {
    let mut problem = problem();
    let plan = plan(&problem, Manner::Best, &WAYS);
    for (y_m, kept) in [(0.66, true), (0.64, false)] {
        let edge_m = vec![[-3.0, -3.0], [3.0, -3.0], [3.0, y_m], [-3.0, y_m]];
        problem.bounds = Some(quantity::bounds::Bounds { edge_m, margin_m: 0.1 });
        let (conditions, told) = broken(&problem, &plan);
        assert_eq!(conditions, (!kept).then_some(Condition::Bounds).into_iter().collect(), "{told}");
        assert!(
            kept || told.contains("robot 2 is 0.090 m from the edge at least, 0.1 m are asked"),
            "{told}"
        );
    }
}
