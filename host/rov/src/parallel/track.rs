//! Where a robot is at every instant of its moves: pieces of time in which its place is a polynomial of second degree.
//!
//! ```text
//! p(t) = p₀ + v (t − t₀) + ½ a (t − t₀)²        t₀ ≤ t ≤ t₁
//! ```
//!
//! A leg has up to three of them, for its ramps and for what is between ([`Profile`](super::super::guidance::profile)).
//! It is cut where the robot leaves and enters its dock zones too, so that every piece is in the open or is not: (19) is
//! asked of the former.

use reconfiguration::plan::{Action, ActionKind, Move};
use reconfiguration::pose::Pose;

use super::super::vector::{dot, length, offset};

/// Pieces shorter than this are none, s.
const NOTHING_S: f64 = 1e-12;

/// What a robot's hull takes up as seen from above.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Outline {
    /// Its box at this heading, rad.
    Held(f64),
    /// It turns in place: the circle around its box.
    Turning,
}

/// See the module's documentation.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Piece {
    pub from_s: f64,
    pub to_s: f64,
    pub place_m: [f64; 3],
    pub velocity_m_s: [f64; 3],
    pub acceleration_m_s2: [f64; 3],
    pub outline: Outline,
    /// Outside the dock zones.
    pub open: bool,
}

impl Piece {
    /// At rest in `pose`.
    pub fn at_rest(pose: Pose, origin_m: [f64; 3], from_s: f64, to_s: f64) -> Self {
        Self {
            from_s,
            to_s,
            place_m: offset(origin_m, pose.position_m),
            velocity_m_s: [0.0; 3],
            acceleration_m_s2: [0.0; 3],
            outline: Outline::Held(pose.yaw_rad),
            open: false,
        }
    }

    /// The same, that much later.
    pub fn later(self, by_s: f64) -> Self {
        Self { from_s: self.from_s + by_s, to_s: self.to_s + by_s, ..self }
    }

    /// p, v and ½ a at `t_s`.
    pub fn motion(&self, t_s: f64) -> [[f64; 3]; 3] {
        let Self { place_m, velocity_m_s: v, acceleration_m_s2: a, .. } = self;
        if v.iter().chain(a).all(|component| *component == 0.0) {
            return [*place_m, [0.0; 3], [0.0; 3]];
        }
        let past_s = t_s - self.from_s;
        [
            [0, 1, 2].map(|k| place_m[k] + past_s * (v[k] + 0.5 * past_s * a[k])),
            [0, 1, 2].map(|k| v[k] + past_s * a[k]),
            a.map(|component| 0.5 * component),
        ]
    }
}

/// The pieces of a move from its own beginning on, in places relative to `origin_m`; d of (19) is `distance_m`.
pub(super) fn pieces(own: &Move, origin_m: [f64; 3], distance_m: f64) -> Vec<Piece> {
    let (Some(first), Some(last)) = (own.actions.first(), own.actions.last()) else { return Vec::new() };
    let docks = [first.from, last.to].map(|pose| offset(origin_m, pose.position_m));
    let mut all = Vec::new();
    let mut now_s = 0.0;
    for action in &own.actions {
        let whole = Piece::at_rest(action.from, origin_m, now_s, now_s + action.duration_s);
        now_s = whole.to_s;
        let outline = if action.kind == ActionKind::Turn { Outline::Turning } else { whole.outline };
        let parts = match action.kind {
            ActionKind::Leg => leg(action, whole, docks, distance_m),
            _ => vec![Piece { outline, ..whole }],
        };
        all.extend(parts.into_iter().filter(|part| part.to_s - part.from_s > NOTHING_S).map(|part| {
            let [middle_m, ..] = part.motion(0.5 * (part.from_s + part.to_s));
            let open = docks.iter().all(|&dock_m| length(offset(dock_m, middle_m)) > distance_m);
            Piece { open, ..part }
        }));
    }
    all
}

/// A leg cut at the ends of its ramps and where it crosses a dock zone's edge.
fn leg(action: &Action, whole: Piece, docks: [[f64; 3]; 2], distance_m: f64) -> Vec<Piece> {
    let way_m = offset(action.from.position_m, action.to.position_m);
    let size_m = length(way_m);
    if size_m == 0.0 || action.duration_s <= 0.0 {
        return vec![whole];
    }
    let along = |size: f64| way_m.map(|component| component / size_m * size);
    // At constant speed there are no ramps.
    let speed = action.acceleration.map_or(action.speed, |a| action.speed.min((a * size_m).sqrt()));
    let ramp_s = action.acceleration.map_or(0.0, |a| speed / a);
    let total_s = action.duration_s;
    let at = |place_m: [f64; 3], share_s: [f64; 2], velocity: f64, acceleration: f64| Piece {
        from_s: whole.from_s + share_s[0],
        to_s: whole.from_s + share_s[1],
        place_m,
        velocity_m_s: along(velocity),
        acceleration_m_s2: along(acceleration),
        ..whole
    };
    let up_m = 0.5 * speed * ramp_s;
    let further = |m: f64| [0, 1, 2].map(|k| whole.place_m[k] + along(m)[k]);
    let a = action.acceleration.unwrap_or(0.0);
    let phases = [
        at(whole.place_m, [0.0, ramp_s], 0.0, a),
        at(further(up_m), [ramp_s, total_s - ramp_s], speed, 0.0),
        at(further(size_m - up_m), [total_s - ramp_s, total_s], speed, -a),
    ];
    // Where the way crosses an edge: |p₀ + s u − c|² = d².
    let unit = along(1.0);
    let mut edges_s = Vec::new();
    for dock_m in docks {
        let off_m = offset(dock_m, whole.place_m);
        let (b, c) = (dot(off_m, unit), dot(off_m, off_m) - distance_m * distance_m);
        if b * b > c {
            let root = (b * b - c).sqrt();
            let crossed = [-b - root, -b + root].into_iter().filter(|s| *s > 0.0 && *s < size_m);
            edges_s.extend(crossed.map(|s| whole.from_s + time_of(s, size_m, speed, ramp_s, total_s)));
        }
    }
    edges_s.sort_by(f64::total_cmp);
    let mut parts = Vec::new();
    for phase in phases {
        let mut rest = phase;
        for &edge_s in edges_s.iter().filter(|s| **s > phase.from_s && **s < phase.to_s) {
            let [place_m, velocity_m_s, _] = rest.motion(edge_s);
            parts.push(Piece { to_s: edge_s, ..rest });
            rest = Piece { from_s: edge_s, place_m, velocity_m_s, ..rest };
        }
        parts.push(rest);
    }
    parts
}

/// When a leg has come `way_m` far, s from its beginning.
fn time_of(way_m: f64, size_m: f64, speed: f64, ramp_s: f64, total_s: f64) -> f64 {
    let up_m = 0.5 * speed * ramp_s;
    let ramp = |m: f64| ramp_s * (m / up_m).max(0.0).sqrt();
    if way_m < up_m {
        ramp(way_m)
    } else if way_m > size_m - up_m {
        total_s - ramp(size_m - way_m)
    } else {
        ramp_s + (way_m - up_m) / speed
    }
}

#[cfg(test)]
mod tests {
    use super::super::super::guidance::reference::ReferenceTrajectory;
    use super::*;
    use reconfiguration::problem::Rules;

    /// Pieces are where the reference of the execution is, join each other, and know where they are in the open.
    #[test]
    fn pieces_follow_the_reference() {
        let (start, slot) = (Pose::from([0.3, -0.2, 0.1, 0.4]), Pose::from([3.3, 0.7, -0.5, 1.4]));
        let corner = Pose { position_m: [1.2, 1.9, -0.5], ..start };
        let turned = Pose { yaw_rad: 1.4, ..corner };
        let mut actions = Vec::new();
        let mut now_s = 0.0;
        use ActionKind::{Dock, Leg, Turn, Undock};
        for (kind, from, to, speed, a) in [
            (Undock, start, start, 0.0, None),
            (Leg, start, corner, 0.3, Some(0.2)),
            (Turn, corner, turned, 0.8, Some(1.0)),
            (Leg, turned, slot, 0.9, Some(0.2)),
            (Dock, slot, slot, 0.0, None),
        ] {
            let mut action = Action {
                kind,
                start_s: now_s,
                duration_s: 0.5,
                from,
                to,
                speed,
                acceleration: a,
                energy_j: 0.0,
            };
            if a.is_some() {
                action.duration_s = ReferenceTrajectory::new(&action, &Rules::default()).duration_s();
            }
            now_s += action.duration_s;
            actions.push(action);
        }
        let own = Move {
            robot: 1,
            slot: Some(0),
            to: None,
            path: Vec::new(),
            start_s: 0.0,
            duration_s: now_s,
            energy_navigate_j: 0.0,
            energy_balance_j: 0.0,
            balance_w: 0.0,
            balance: Vec::new(),
            actions,
        };
        let origin_m = [1.0, 1.0, 1.0];
        let pieces = pieces(&own, origin_m, 0.7);
        assert!(pieces.len() > 8, "{}", pieces.len());
        let mut end_s = 0.0;
        for piece in &pieces {
            assert!((piece.from_s - end_s).abs() < 1e-9, "{piece:?} does not follow {end_s}");
            end_s = piece.to_s;
            for share in [0.0, 0.3, 0.7, 1.0] {
                let t_s = piece.from_s + share * (piece.to_s - piece.from_s);
                let action = own.actions.iter().rfind(|action| action.start_s <= t_s + 1e-12).expect("begun");
                let expected = ReferenceTrajectory::new(action, &Rules::default()).at(t_s - action.start_s);
                let [place_m, ..] = piece.motion(t_s);
                let off_m = length(offset(offset(origin_m, expected.pose.position_m), place_m));
                assert!(off_m < 1e-9, "{t_s} s: {off_m} m");
                let out = [start, slot].map(|dock| length(offset(dock.position_m, expected.pose.position_m)));
                if (0.1..0.9).contains(&share) {
                    assert_eq!(piece.open, out.iter().all(|m| *m > 0.7), "{t_s} s: {out:?}");
                }
            }
        }
        assert!((end_s - now_s).abs() < 1e-9);
        assert!(pieces.iter().any(|piece| piece.open) && pieces.iter().any(|piece| !piece.open));
    }
}
