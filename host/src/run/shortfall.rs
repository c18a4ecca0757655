//! What a run was to do and did not: why it does not end with 0 though it came to its end without a contact.
//!
//! | shortfall | when | why there |
//! |---|---|---|
//! | a module took no part | for more than [`SHARE`] of a leg, and [`FLOOR`] intervals | a figure of such a leg is not that of this fleet |
//! | two modules had one number | ever | which of the two swam is not known |
//! | a module reported numbers that none can have, and nothing else | for [`IMPLAUSIBLE_FOR`](link::dispatcher::IMPLAUSIBLE_FOR) | what it did is not known |
//! | the fleet held | for more than [`SHARE`] of a leg, and [`FLOOR`] intervals | the same |
//! | a thruster gives nothing | ever | the robot does not steer alone any more |
//! | more was asked than can be given | the demand is faster than the structure can ever swim that way | no cycle can be at fault |
//! | much slower than asked | in a leg of at least [`SETTLED_S`], more than [`MISSED`] of the velocity was missed | beyond what a current, a wrong drag or lost cycles cost |
//!
//! Where a run may leave modules out (`require`), one that is left out is no shortfall.
//!
//! The greatest steady speed along a demand v at heading Θ is that at which drag (19) takes all of the envelope:
//!
//! ```text
//! F(v) = N C_L v_S|v_S| by axis,  F(s·v) = s² F(v),  so  v_max = ‖v‖ / √gauge(F(v))
//! ```
//!
//! with the gauge of [`Envelope`], in water that rests, without a transition. Thresholds are *assumed*.

use std::fmt::{self, Display, Formatter};

use modboat::envelope::Envelope;
use modboat::motion::Wrench;
use modboat::parameters::Parameters;
use modboat::structure::Structure;
use serde::Serialize;

use super::leg_figures::LegFigures;
use super::scenario::{Demand, Leg};
use super::watch::{LegWatch, Reason};

/// More than this share of a leg is too much.
pub const SHARE: f64 = 0.25;
/// Less than so many intervals of a cycle and its transition is the noise of one decision.
pub const FLOOR: f64 = 2.0;
/// Legs that last this time are judged by their velocity: the mean is over the last 60 s, and the first 20 s go to gain speed.
pub const SETTLED_S: f64 = 80.0;
/// More than this share of the velocity is too much to miss.
pub const MISSED: f64 = 0.5;

/// One of them. Legs count from 1; none where a run has no legs.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[serde(tag = "kind", rename_all = "kebab-case")]
pub enum Shortfall {
    /// A module took no part.
    Absent {
        /// In which leg.
        leg: Option<usize>,
        /// What it is: module, or robot.
        #[serde(skip)]
        what: &'static str,
        /// Its id.
        module: u16,
        /// For how long, s.
        time_s: f64,
        /// Of the leg.
        share: f64,
        /// Why, for the longest part of it.
        reason: String,
    },
    /// The fleet held.
    Held {
        /// In which leg.
        leg: Option<usize>,
        /// For how long, s.
        time_s: f64,
        /// Of the leg.
        share: f64,
        /// Why, for the longest part of it; null where the log does not say.
        reason: Option<String>,
    },
    /// More was asked than the structure can give.
    Unattainable {
        /// In which leg.
        leg: usize,
        /// The speed asked for, m/s.
        demand_m_s: f64,
        /// The greatest that way, m/s.
        attainable_m_s: f64,
        /// What was swum, m/s.
        mean_m_s: f64,
    },
    /// A thruster gives nothing.
    Thruster {
        /// Whose.
        robot: u16,
        /// Which, from 1.
        thruster: u16,
        /// When it was found, s.
        at_s: f64,
    },
    /// It could have been given, and was not.
    Missed {
        /// In which leg.
        leg: usize,
        /// The speed asked for, m/s.
        demand_m_s: f64,
        /// What was swum, m/s.
        mean_m_s: f64,
        /// ‖mean − demand‖ / ‖demand‖ of the velocities.
        share: f64,
    },
}

impl Display for Shortfall {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        if let Self::Absent { leg: Some(leg), .. }
        | Self::Held { leg: Some(leg), .. }
        | Self::Unattainable { leg, .. }
        | Self::Missed { leg, .. } = self
        {
            write!(f, "leg {leg}: ")?;
        }
        match self {
            Self::Absent { what, module, time_s, share, reason, .. } => {
                write!(f, "{what} {module} took no part for {time_s:.1} s ({:.0} %): {reason}", 100.0 * share)
            }
            Self::Thruster { robot, thruster, at_s } => {
                write!(f, "thruster {thruster} of robot {robot} gives nothing, as found at {at_s:.1} s")
            }
            Self::Held { time_s, share, reason, .. } => {
                write!(f, "the fleet held for {time_s:.1} s ({:.0} %)", 100.0 * share)?;
                reason.as_ref().map_or(Ok(()), |reason| write!(f, ": {reason}"))
            }
            Self::Unattainable { demand_m_s, attainable_m_s, mean_m_s, .. } => write!(
                f,
                "{demand_m_s:.3} m/s asked is more than this structure can give: at most {attainable_m_s:.3} m/s that way; \
                 {mean_m_s:.3} m/s swum"
            ),
            Self::Missed { demand_m_s, mean_m_s, share, .. } => write!(
                f,
                "{demand_m_s:.3} m/s asked, {mean_m_s:.3} m/s swum: {:.0} % of the velocity was missed",
                100.0 * share
            ),
        }
    }
}

/// The greatest steady speed along the demand of a leg, m/s; `None` where no speed is asked for, or nothing holds it back.
#[must_use]
pub fn attainable_m_s(structure: &Structure, modboat: &Parameters, leg: &Leg) -> Option<f64> {
    let Demand::Velocity([vx, vy]) = leg.demand else { return None };
    let (sin, cos) = leg.heading_rad.sin_cos();
    let drag_n_s2_m2 = structure.len() as f64 * modboat.drag_n_s2_m2;
    // F(v) = N C_L v_S|v_S|
    let [fx_n, fy_n] = [vx * sin - vy * cos, vx * cos + vy * sin].map(|v| drag_n_s2_m2 * v * v.abs());
    let gauge = Envelope::new(&structure.positions_m(modboat.pitch_m), modboat).gauge(Wrench {
        fx_n,
        fy_n,
        tau_nm: 0.0,
    });
    // v_max = ‖v‖ / √gauge(F(v))
    (gauge > 0.0).then(|| vx.hypot(vy) / gauge.sqrt())
}

/// What the modules and the fleet fell short of in one leg; `floor_s` is the time below which nothing counts, `id` says what a module (by
/// index) is called.
pub fn of_watch(
    leg: Option<usize>,
    watch: &LegWatch,
    floor_s: f64,
    what: &'static str,
    id: impl Fn(usize) -> u16,
) -> Vec<Shortfall> {
    let (mut found, time_s) = (Vec::new(), watch.time_s);
    let too_long = |part_s: f64| part_s > floor_s && part_s > SHARE * time_s;
    let mut modules: Vec<usize> = watch.absences.iter().map(|absence| absence.module).collect();
    modules.sort_unstable();
    modules.dedup();
    for module in modules {
        let own = || watch.absences.iter().filter(|absence| absence.module == module);
        let away_s: f64 = own().map(|absence| absence.time_s).sum();
        let longest = own().max_by(|a, b| a.time_s.total_cmp(&b.time_s));
        let ever = own().find(|absence| matches!(absence.reason, Reason::Doubled | Reason::Implausible));
        if let Some(longest) = ever.or(longest.filter(|_| too_long(away_s))) {
            let (share, reason) = (away_s / time_s, longest.reason.to_string());
            found.push(Shortfall::Absent { leg, what, module: id(module), time_s: away_s, share, reason });
        }
    }
    if too_long(watch.held_s) {
        let longest = watch.holds.iter().max_by(|a, b| a.1.total_cmp(&b.1));
        let reason = longest.map(|(hold, _)| hold.to_string());
        found.push(Shortfall::Held { leg, time_s: watch.held_s, share: watch.held_s / time_s, reason });
    }
    found
}

/// What the velocity of a leg of `duration_s` fell short of.
#[must_use]
pub fn of_velocity(leg: usize, figures: &LegFigures, duration_s: f64) -> Option<Shortfall> {
    let [demand_m_s, mean_m_s] = [figures.demand_m_s, figures.mean_m_s].map(|[x, y]| x.hypot(y));
    match figures.attainable_m_s {
        Some(attainable_m_s) if demand_m_s > attainable_m_s * (1.0 + 1e-9) => {
            Some(Shortfall::Unattainable { leg, demand_m_s, attainable_m_s, mean_m_s })
        }
        _ => {
            let missed = demand_m_s > 0.0 && duration_s >= SETTLED_S && figures.velocity_error > MISSED;
            missed.then_some(Shortfall::Missed { leg, demand_m_s, mean_m_s, share: figures.velocity_error })
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::hold::Hold;
    use super::super::watch::{Absence, Reason};
    use super::*;

    /// The greatest speed against an oracle of its own: drag of the force at the speed said lies on the border of the envelope, which
    /// for a pure force is N·F(A_max) at any angle.
    #[test]
    fn the_attainable_speed_takes_all_of_the_thrust() {
        let modboat = Parameters::default();
        for (word, velocity_m_s, heading_rad) in [
            ("3x1", [0.04, 0.0], 1.5),
            ("3x3", [0.5, 0.1], 1.57),
            ("2x2", [-0.01, 0.3], -2.0),
            ("1x1", [0.0, 0.2], 0.3),
        ] {
            let structure = Structure::from_word(word).expect("valid");
            let leg = Leg { duration_s: 1.0, demand: Demand::Velocity(velocity_m_s), heading_rad };
            let most_m_s = attainable_m_s(&structure, &modboat, &leg).expect("a speed");
            let (dx, dy) = (velocity_m_s[0], velocity_m_s[1]);
            let speed_m_s = f64::hypot(dx, dy);
            // Angle between motion and surge axis.
            let aside_rad = dy.atan2(dx) - heading_rad;
            let modules = structure.len() as f64;
            let drag_n = |v: f64| modules * 4.5 * v * v;
            let force_n = drag_n(most_m_s * aside_rad.cos()).hypot(drag_n(most_m_s * aside_rad.sin()));
            let thrust_n = modules * (0.022 * 2.6 - 0.019);
            assert!(
                (force_n / thrust_n - 1.0).abs() < 1e-6,
                "{word}: {force_n} N of {thrust_n} N, {speed_m_s} m/s"
            );
        }
        let station = Leg { duration_s: 1.0, demand: Demand::Station([1.0, 1.0]), heading_rad: 0.0 };
        assert_eq!(attainable_m_s(&Structure::from_word("3x1").expect("valid"), &modboat, &station), None);
    }

    #[test]
    fn a_quarter_of_a_leg_is_too_much_and_one_decision_is_not() {
        let absence = |module, reason, time_s| Absence { module, reason, time_s };
        let judged = |time_s, held_s, absences| {
            let holds = vec![(Hold::Operator, 0.4 * held_s), (Hold::PosesLost, 0.6 * held_s)];
            let watch = LegWatch { time_s, held_s, holds, absences };
            let found = of_watch(Some(2), &watch, 4.0, "module", |module| module as u16 + 10);
            found.iter().map(ToString::to_string).collect::<Vec<_>>()
        };
        assert_eq!(judged(100.0, 25.0, vec![absence(0, Reason::Silent, 25.0)]), [""; 0]);
        assert_eq!(judged(10.0, 3.9, vec![absence(0, Reason::Silent, 3.9)]), [""; 0]);
        let low = Reason::Refuses(protocol::Refusal::LowBattery);
        assert_eq!(
            judged(
                100.0,
                26.0,
                vec![absence(3, Reason::Silent, 11.0), absence(1, low, 9.0), absence(3, low, 16.0)]
            ),
            [
                "leg 2: module 13 took no part for 27.0 s (27 %): it refuses its cycles: low battery",
                "leg 2: the fleet held for 26.0 s (26 %): no pose was new enough"
            ]
        );
    }
}
