use std::f64::consts::{FRAC_PI_2, PI};

use rand::rngs::ChaCha8Rng;
use rand::{RngExt, SeedableRng};

use super::*;

fn bounds(edge_m: &[[f64; 2]]) -> Bounds {
    Bounds { edge_m: edge_m.to_vec(), margin_m: 0.1 }
}

fn square() -> Bounds {
    bounds(&[[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]])
}

/// An L: the square without its upper right quarter.
fn corner() -> Bounds {
    bounds(&[[-1.0, -1.0], [1.0, -1.0], [1.0, 0.0], [0.0, 0.0], [0.0, 1.0], [-1.0, 1.0]])
}

fn governor(bounds: &Bounds, size: &str) -> Governor {
    let structure = Structure::from_word(size).unwrap();
    Governor::new(bounds, &structure, &Parameters::default(), &ControlConfig::default())
}

#[test]
fn far_from_the_edge_nothing_changes() {
    let wanted = Target { velocity_m_s: [0.02, 0.01], heading_rad: 0.3 };
    let place = Place { position_m: [0.0; 2], heading_rad: 0.0 };
    let governed = governor(&square(), "3x1").govern(&wanted, place, [0.0; 2], 4.0);
    assert_eq!((governed.target, governed.is_limited), (wanted, false));
    // Three in a row, heading east: the outermost is 0.15 m from the centre, across.
    assert!((governed.room_m - (1.0 - 0.15 - 0.15 * 0.5_f64.sqrt() - 0.1)).abs() < 1e-12);
}

#[test]
fn what_is_beyond_the_edge_comes_back() {
    let wanted = Target { velocity_m_s: [0.05, 0.03], heading_rad: 0.0 };
    let place = Place { position_m: [0.98, 0.0], heading_rad: 0.0 };
    let governed = governor(&square(), "1x1").govern(&wanted, place, [0.0; 2], 4.0);
    let [x, y] = governed.target.velocity_m_s;
    assert!(governed.is_limited && governed.room_m < 0.0 && x < 0.0, "{governed:?}");
    assert!((y - 0.03).abs() < 1e-12, "along the edge it goes on: {governed:?}");
    let outside =
        governor(&square(), "1x1").govern(&wanted, Place { position_m: [1.5, 0.0], ..place }, [0.0; 2], 4.0);
    assert!(outside.target.velocity_m_s[0] < x, "{outside:?}");
}

#[test]
fn a_turn_waits_for_room() {
    // A row of nine along the edge, which is to stand across.
    let wanted = Target { velocity_m_s: [0.0; 2], heading_rad: FRAC_PI_2 };
    let place = Place { position_m: [0.0, -0.75], heading_rad: PI };
    let mut governor = governor(&square(), "1x9");
    let governed = governor.govern(&wanted, place, [0.0; 2], 4.0);
    assert!(governed.target.velocity_m_s[1] > 0.0, "{governed:?}");
    assert!((governed.target.heading_rad - PI).abs() < 1e-12, "{governed:?}");
    let middle = governor.govern(&wanted, Place { position_m: [0.0; 2], ..place }, [0.0; 2], 4.0);
    assert_eq!(middle.target, wanted);
}

/// A point mass that takes on the velocity asked for, by the acceleration that (b2) counts on and an interval late: it never leaves,
/// wherever it is sent. The edge may be anywhere and turned by any angle.
#[test]
fn a_mass_with_delay_never_leaves() {
    for seed in 0..200 {
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        let (turn, shift) = (rng.random_range(-PI..PI), [0, 1].map(|_| rng.random_range(-1e3..1e3)));
        let (sin, cos) = f64::sin_cos(turn);
        let place = |[x, y]: [f64; 2]| [shift[0] + x * cos - y * sin, shift[1] + x * sin + y * cos];
        let plain = if seed % 2 == 0 { square() } else { corner() };
        let moved = bounds(&plain.edge_m.iter().map(|&point| place(point)).collect::<Vec<_>>());
        let mut governor = governor(&moved, "1x1");
        let (mut position_m, mut velocity) = (place([-0.5, -0.5]), [0.0_f64; 2]);
        let (interval_s, tick_s) = (2.0, 0.01);
        let (mut asked, mut next) = ([0.0; 2], [0.0; 2]);
        for decision in 0..400 {
            let angle: f64 = rng.random_range(-PI..PI);
            let velocity_m_s =
                if decision % 10 == 0 { [angle.cos(), angle.sin()].map(|k| 0.08 * k) } else { next };
            let wanted = Target { velocity_m_s, heading_rad: 0.0 };
            next = velocity_m_s;
            let here = Place { position_m, heading_rad: 0.0 };
            let governed = governor.govern(&wanted, here, velocity, 3.0 * interval_s);
            for _ in 0..(interval_s / tick_s) as usize {
                let away = [0, 1].map(|k| asked[k] - velocity[k]);
                let share = (governor.braking_m_s2 * tick_s / length(away)).min(1.0);
                for k in 0..2 {
                    velocity[k] += share * away[k];
                    position_m[k] += velocity[k] * tick_s;
                }
                let room_m = moved.distance_m(position_m) - governor.radius_m;
                assert!(room_m > 0.0, "seed {seed}: {room_m}");
            }
            asked = governed.target.velocity_m_s;
        }
    }
}
