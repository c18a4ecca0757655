//! The same structure in the same water, pushed by a wrench that is given instead of one that tails make.
//!
//! What the planner believes of a cycle is its mean wrench, by (7). A hull moves as the [`Tank`](super::Tank) does under such a wrench:
//! mass, added mass, drag and current are the tank's. What only tails or single instants have is left out: reaction torque of rotors,
//! thrust within a swing and in transitions, gusts, waves and contacts.
//!
//! Assumptions and limits: steps of up to half a second are meant; velocity changes over seconds (m + m_a over D·v is some 8 s).

use modboat::motion::Wrench;
use modboat::parameters::Parameters;
use modboat::structure::Structure;
use quantity::ParameterError;
use record::PoseSample;

use super::TankParameters;
use crate::body::{Body, BodyState};

/// A structure that a given wrench moves.
#[derive(Clone, Debug)]
pub struct Hull {
    body: Body,
    state: BodyState,
    current_m_s: [f64; 2],
    t_s: f64,
}

impl Hull {
    /// The structure with pose and velocity as in `initial`, in the water of `tank`; `believed` as for [`Tank::new`](super::Tank::new).
    ///
    /// # Errors
    /// As [`TankParameters::validate`], and for a key of the tank that a mean wrench cannot show.
    pub fn new(
        structure: &Structure,
        believed: &Parameters,
        tank: &TankParameters,
        initial: &PoseSample,
    ) -> Result<Self, ParameterError> {
        tank.validate(structure.len()).map_err(|(_, error)| error)?;
        tank.has_mean_alone()?;
        let body = tank.body(structure, &tank.real(believed));
        Ok(Self { body, state: BodyState::of(initial), current_m_s: tank.current_m_s, t_s: initial.t_s })
    }

    /// Pose, velocity and time are those of `sample` from now on.
    pub fn place(&mut self, sample: &PoseSample) {
        (self.t_s, self.state) = (sample.t_s, BodyState::of(sample));
    }

    /// Goes on by `dt_s` under `wrench` in S.
    pub fn step(&mut self, dt_s: f64, wrench: Wrench) {
        self.state = self.body.step(&self.state, dt_s, wrench, self.current_m_s);
        self.t_s += dt_s;
    }

    /// Pose and velocity over ground, as [`Tank::pose`](super::Tank::pose).
    #[must_use]
    pub fn pose(&self) -> PoseSample {
        self.state.sample(self.t_s)
    }
}

#[cfg(test)]
mod tests {
    use super::super::Tank;
    use super::super::tests::{DT_S, row, waveforms};
    use super::*;
    use crate::thrust::ThrustParameters;
    use crate::waves::WaveParameters;
    use modboat::motion::Swing;

    const SWINGS: [[f64; 2]; 3] = [[-1.2, 1.4], [0.4, -2.0], [2.9, 1.1]];

    fn mean() -> Wrench {
        let parameters = Parameters::default();
        SWINGS.iter().zip(row().positions_m(0.15)).fold(Wrench::default(), |sum, (swing, at)| {
            sum + Swing { centerline_rad: swing[0], amplitude_rad: swing[1] }.wrench(&parameters, at)
        })
    }

    /// Over ten cycles the hull comes where the tank comes, but for what swings within a cycle do.
    #[test]
    fn the_mean_wrench_moves_the_hull_as_tails_move_the_tank() {
        let parameters = TankParameters { current_m_s: [0.01, -0.005], ..TankParameters::default() };
        let start = PoseSample { heading_rad: 0.4, ..PoseSample::default() };
        let mut tank = Tank::new(&row(), &Parameters::default(), &parameters, &start, 0).expect("valid");
        let mut hull = Hull::new(&row(), &Parameters::default(), &parameters, &start).expect("valid");
        (1..=15_000).for_each(|step| tank.step(DT_S, &waveforms(SWINGS, f64::from(step) * DT_S)));
        (0..30).for_each(|_| hull.step(0.5, mean()));
        let (tank, hull) = (tank.pose(), hull.pose());
        let moved_m = tank.position_m[0].hypot(tank.position_m[1]);
        let apart_m = [0, 1].map(|axis| tank.position_m[axis] - hull.position_m[axis]);
        let turned_rad = (tank.heading_rad - 0.4).abs();
        assert!(moved_m > 0.2 && apart_m[0].hypot(apart_m[1]) < 0.08 * moved_m, "{tank:?} {hull:?}");
        assert!(
            (tank.heading_rad - hull.heading_rad).abs() < 0.08 * turned_rad.max(1.0),
            "{tank:?} {hull:?}"
        );
        assert!((hull.t_s - 15.0).abs() < 1e-9);
    }

    #[test]
    fn half_a_second_is_short_enough() {
        let ends = [0.5, 0.005].map(|dt_s: f64| {
            let start = PoseSample { heading_rad: 0.4, ..PoseSample::default() };
            let mut hull =
                Hull::new(&row(), &Parameters::default(), &TankParameters::default(), &start).expect("valid");
            (0..(90.0 / dt_s).round() as u32).for_each(|_| hull.step(dt_s, mean()));
            hull.pose()
        });
        let off = [0, 1].map(|axis| ends[0].position_m[axis] - ends[1].position_m[axis]);
        assert!(off[0].hypot(off[1]) < 1e-5, "{ends:?}");
        assert!((ends[0].heading_rad - ends[1].heading_rad).abs() < 1e-5, "{ends:?}");
    }

    #[test]
    fn what_a_mean_wrench_cannot_show_is_refused_by_its_key() {
        for (tank, key) in [
            (TankParameters { gust_m_s: 0.01, ..TankParameters::default() }, "gust_m_s"),
            (
                TankParameters {
                    wave: WaveParameters { height_m: 0.01, period_s: 1.0, direction_rad: 0.0 },
                    ..TankParameters::default()
                },
                "height_m",
            ),
            (
                TankParameters {
                    thrust: ThrustParameters { spread: 0.1, ..ThrustParameters::default() },
                    ..TankParameters::default()
                },
                "spread",
            ),
        ] {
            let refused = Hull::new(&row(), &Parameters::default(), &tank, &PoseSample::default());
            assert_eq!(refused.expect_err(key).key, key);
        }
    }
}
