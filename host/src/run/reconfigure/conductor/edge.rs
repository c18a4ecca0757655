//! Whether a robot has drifted towards the edge of the water, or is about to.
//!
//! ```text
//! d = room of the hull at η + (v − v_r)·t         against the edge of `[bounds]`; v_r: velocity of its reference, t = [`AHEAD_S`]
//! d < [`DRIFTED`] · margin: the plan waits, and the tracking controllers bring everything back
//! d ≥ [`BACK`] · margin: it goes on
//! ```
//!
//! Plans keep the whole margin, so what is nearer has been carried there. Rests and references lie inside, and every robot is steered
//! to its own, whatever waits.

use quantity::bounds::Bounds;
use reconfiguration::pose::Pose;
use reconfiguration::vehicle::Vehicle;
use rov::configuration::LevelBox;
use rov::dynamics::State;

/// Share of the margin below which a robot has drifted. *Assumed.*
const DRIFTED: f64 = 0.5;
/// Share of it at which it is back. *Assumed.*
const BACK: f64 = 0.75;
/// A drift is looked at so far ahead, s. *Assumed*: three times what a thrust takes to act.
const AHEAD_S: f64 = 0.5;

/// The body that has drifted most, with its room, m, if one has; `drifted`: one had before. `reference_m_s` is the velocity of the
/// reference that a body follows, if it follows one.
pub(super) fn drifted(
    bounds: &Bounds,
    bodies: &[(Pose, &Vehicle)],
    states: &[State],
    reference_m_s: impl Fn(usize) -> Option<[f64; 3]>,
    drifted: bool,
) -> Option<(usize, f64)> {
    let least_m = bounds.margin_m * if drifted { BACK } else { DRIFTED };
    let room_m = |(body, (state, (_, vehicle))): (usize, (&State, &(Pose, &Vehicle)))| {
        let reference_m_s = reference_m_s(body).unwrap_or_default();
        let v = state.attitude * nalgebra::Vector3::from(state.nu.fixed_rows::<3>(0));
        let eta = state.eta();
        let at = |ahead_s: f64| {
            let place = [0, 1].map(|k| eta[k] + (v[k] - reference_m_s[k]) * ahead_s);
            let pose = Pose::from([place[0], place[1], eta[2], eta[5]]);
            bounds.room_m(&LevelBox::around(pose, vehicle).outline_m())
        };
        (body, at(0.0).min(at(AHEAD_S)))
    };
    let rooms = states.iter().zip(bodies).enumerate().map(room_m);
    rooms.min_by(|a, b| a.1.total_cmp(&b.1)).filter(|(_, room_m)| *room_m < least_m)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A BlueROV1 is 0.483 m by 0.33 m: at the middle of a square of 2 m its bow is 0.7585 m from the edge.
    #[test]
    fn a_hull_has_drifted_from_half_of_the_margin_until_it_is_well_back() {
        let edge_m = vec![[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]];
        let bounds = Bounds { edge_m, margin_m: 0.1 };
        let vehicle = Vehicle::built_in("bluerov1").expect("built in");
        let bodies = [(Pose::default(), &vehicle)];
        let found = |x: f64, speed: f64, reference_m_s: Option<[f64; 3]>, before: bool| {
            let state = State::from_eta(&[x, 0.0, 0.0, 0.0, 0.0, 0.0], &[speed, 0.0, 0.0, 0.0, 0.0, 0.0]);
            drifted(&bounds, &bodies, &[state], |_| reference_m_s, before)
                .map(|(body, room_m)| (body, (room_m * 1e4).round()))
        };
        assert_eq!(found(0.70, 0.0, None, false), None);
        assert_eq!(found(0.71, 0.0, None, false), Some((0, 485.0)));
        assert_eq!(found(0.69, 0.0, None, true), Some((0, 685.0)));
        assert_eq!(found(0.68, 0.0, None, true), None);
        // 0.2 m/s of drift is 0.1 m further; of a reference that goes there it is none.
        assert_eq!(found(0.65, 0.2, None, false), Some((0, 85.0)));
        assert_eq!(found(0.65, 0.2, Some([0.2, 0.0, 0.0]), false), None);
    }
}
