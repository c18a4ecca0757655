//! What the axes of a laboratory probably are, of what its bodies say: a proposal for the operator, never a setting.
//!
//! Boats float: over all bodies and moments their heights differ by centimetres, their places by more. So the axis along which
//! positions spread least is up. Tanks are metres wide: positions of hundreds are millimetres.

use nalgebra::Vector3;

use crate::axes::{Unit, Up};

/// A place further from the origin than this is in millimetres. *Assumed*: larger than any tank in metres, smaller than any in
/// millimetres.
const FAR: f64 = 50.0;
/// The one spread is less than this share of the other, or nothing is proposed. *Assumed.*
const CLEARLY: f64 = 0.3;
/// Spreads below this say nothing, m: the bodies have not moved. *Assumed.*
const LEAST_M: f64 = 0.05;

/// The spread of positions in the server's own axes and unit, as they come.
#[derive(Clone, Copy, Debug, Default)]
pub struct Proposal {
    count: u64,
    mean: Vector3<f64>,
    squares: Vector3<f64>,
    furthest: f64,
}

impl Proposal {
    /// Counts a position of a tracked body.
    pub fn count(&mut self, position: &Vector3<f64>) {
        if !position.iter().all(|number| number.is_finite()) {
            return;
        }
        self.count += 1;
        #[expect(clippy::cast_precision_loss, reason = "counts are small")]
        let count = self.count as f64;
        // Welford's recurrence for mean and sum of squares.
        let before = position - self.mean;
        self.mean += before / count;
        self.squares += before.component_mul(&(position - self.mean));
        self.furthest = self.furthest.max(position.amax());
    }

    /// The unit; `None` before the first position.
    pub fn unit(&self) -> Option<Unit> {
        (self.count > 0).then_some(if self.furthest > FAR { Unit::Millimetre } else { Unit::Metre })
    }

    /// The axis that is up; `None` where positions do not say: bodies that dive, or have not moved.
    pub fn up(&self) -> Option<Up> {
        let metres = self.unit()?.metres();
        #[expect(clippy::cast_precision_loss, reason = "counts are small")]
        let spread = (self.squares / self.count as f64).map(f64::sqrt) * metres;
        if spread.x.max(spread.y).max(spread.z) < LEAST_M {
            return None;
        }
        if spread.z < CLEARLY * spread.y {
            Some(Up::Z)
        } else if spread.y < CLEARLY * spread.z {
            Some(Up::Y)
        } else {
            None
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::axes::{Axes, Pose};

    /// Boats that circle in a tank, as a server of these axes says it.
    fn circling(axes: &Axes, dive_m: f64) -> Proposal {
        let mut proposal = Proposal::default();
        for step in 0..500 {
            let angle = 0.02 * f64::from(step);
            let position = Vector3::new(angle.cos(), angle.sin(), 0.3 + dive_m * (3.0 * angle).sin());
            let pose = Pose { position, attitude: nalgebra::UnitQuaternion::identity() };
            proposal.count(&axes.from_world(&pose).position);
        }
        proposal
    }

    #[test]
    fn boats_show_unit_and_up_of_every_laboratory() {
        for up in [Up::Z, Up::Y] {
            for unit in [Unit::Metre, Unit::Millimetre] {
                let axes = Axes { up, unit, origin_m: Vector3::new(2.0, -1.0, 0.5), heading_rad: 0.8 };
                let proposal = circling(&axes, 0.02);
                assert_eq!((proposal.unit(), proposal.up()), (Some(unit), Some(up)));
            }
        }
    }

    #[test]
    fn nothing_is_proposed_of_what_says_nothing() {
        let axes = Axes::new(Up::Z, Unit::Metre);
        assert_eq!(circling(&axes, 0.8).up(), None, "vehicles that dive");
        let mut proposal = Proposal::default();
        assert_eq!((proposal.unit(), proposal.up()), (None, None));
        (0..100).for_each(|_| proposal.count(&Vector3::new(1.0, 2.0, f64::NAN)));
        assert_eq!(proposal.unit(), None);
        (0..100).for_each(|_| proposal.count(&Vector3::new(1.0, 2.0, 0.3)));
        assert_eq!((proposal.unit(), proposal.up()), (Some(Unit::Metre), None), "a body that has not moved");
    }
}
