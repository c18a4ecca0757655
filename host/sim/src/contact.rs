//! Detection of tails that touch, by the exact capsule test on the actual angles.
//!
//! Two neighbours that touch with their tails push each other off their docks: an undocking, counted once from the moment
//! the surfaces meet until they part again.
//!
//! A tail of length L that turns by Δφ moves none of its points by more than L·|Δφ|, so the clearance of a pair
//! cannot shrink faster than L·(|Δφᵢ| + |Δφⱼ|). A pair is measured again only once that bound has come down
//! to the least clearance seen so far: the events and the least clearance are the same as with a test of
//! every pair at every step.
//!
//! Assumptions and limits: tails are stiff, and a contact neither stops them nor parts the structure. Between
//! two steps nothing is tested; at 13 rad/s a tip moves 1.2 mm in a millisecond.

use modboat::parameters::Parameters;
use modboat::structure::Structure;
use modboat::tail::Tail;

use super::TailState;

/// Two tails touched.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Contact {
    /// When they met, s.
    pub t_s: f64,
    /// The two modules.
    pub modules: (usize, usize),
    /// Least distance of their surfaces until they parted (negative: depth of the overlap), m.
    pub clearance_m: f64,
}

/// Two modules close enough for their tails to touch.
#[derive(Clone, Debug)]
struct Pair {
    modules: (usize, usize),
    offset: [i32; 2],
    /// The clearance is at least this, m.
    bound_m: f64,
    /// Index of the contact these two are in.
    contact: Option<usize>,
}

/// All pairs of one structure.
#[derive(Clone, Debug)]
pub(crate) struct ContactWatch {
    tail: Tail,
    length_m: f64,
    pairs: Vec<Pair>,
    angles_rad: Vec<f64>,
    contacts: Vec<Contact>,
    least_m: f64,
}

impl ContactWatch {
    pub(crate) fn new(structure: &Structure, parameters: &Parameters) -> Self {
        let tail = Tail::new(parameters);
        let pairs = tail
            .reachable_offsets()
            .into_iter()
            .flat_map(|offset| structure.neighbours(offset).map(move |modules| (offset, modules)))
            .map(|(offset, modules)| Pair { modules, offset, bound_m: f64::NEG_INFINITY, contact: None })
            .collect();
        Self {
            tail,
            length_m: parameters.tail_length_m,
            pairs,
            angles_rad: vec![0.0; structure.len()],
            contacts: Vec::new(),
            least_m: f64::INFINITY,
        }
    }

    /// Contacts so far, by the time they began.
    pub(crate) fn contacts(&self) -> &[Contact] {
        &self.contacts
    }

    /// Least clearance of all pairs so far, m; infinite without neighbours in reach.
    pub(crate) fn least_clearance_m(&self) -> f64 {
        self.least_m
    }

    /// The tails have come to where they are unseen: no contact goes on through that.
    pub(crate) fn forget(&mut self) {
        for pair in &mut self.pairs {
            (pair.bound_m, pair.contact) = (f64::NEG_INFINITY, None);
        }
    }

    /// Tests the tails as they are at `t_s`.
    pub(crate) fn check(&mut self, t_s: f64, tails: &[TailState]) {
        for pair in &mut self.pairs {
            let (i, j) = pair.modules;
            let (Some(tail_i), Some(tail_j)) = (tails.get(i), tails.get(j)) else { continue };
            let turned_rad =
                (tail_i.angle_rad - self.angles_rad[i]).abs() + (tail_j.angle_rad - self.angles_rad[j]).abs();
            pair.bound_m -= self.length_m * turned_rad;
            if pair.contact.is_none() && pair.bound_m > self.least_m.max(0.0) {
                continue;
            }
            let clearance_m = self.tail.clearance_m(pair.offset, tail_i.angle_rad, tail_j.angle_rad);
            pair.bound_m = clearance_m;
            self.least_m = self.least_m.min(clearance_m);
            pair.contact = match pair.contact {
                _ if clearance_m >= 0.0 => None,
                None => {
                    self.contacts.push(Contact { t_s, modules: pair.modules, clearance_m });
                    Some(self.contacts.len() - 1)
                }
                Some(index) => {
                    if let Some(contact) = self.contacts.get_mut(index) {
                        contact.clearance_m = contact.clearance_m.min(clearance_m);
                    }
                    Some(index)
                }
            };
        }
        for (angle_rad, tail) in self.angles_rad.iter_mut().zip(tails) {
            *angle_rad = tail.angle_rad;
        }
    }
}

#[cfg(test)]
mod tests {
    use std::f64::consts::{PI, TAU};

    use super::*;

    fn tails(angles_rad: &[f64]) -> Vec<TailState> {
        angles_rad.iter().map(|&angle_rad| TailState { angle_rad, ..TailState::default() }).collect()
    }

    #[test]
    fn two_tails_that_face_each_other_touch_once_until_they_part() {
        let structure = Structure::from_cells(&[[0, 0], [1, 0]]).expect("a pair");
        let mut watch = ContactWatch::new(&structure, &Parameters::default());
        // Tail 0 points at its neighbour; tail 1 comes up to it, stays, and goes; twice.
        for (step, angle_rad) in [0.5, 0.8, PI, PI, PI + 0.01, 1.0, 0.5, PI, 0.0].into_iter().enumerate() {
            watch.check(step as f64, &tails(&[0.0, angle_rad]));
        }
        let contacts = watch.contacts();
        assert_eq!(contacts.len(), 2, "{contacts:?}");
        assert_eq!((contacts[0].modules, contacts[0].t_s, contacts[1].t_s), ((0, 1), 2.0, 7.0));
        // Pointing at each other the centre lines overlap: distance 0, clearance −0.015 m.
        assert!((contacts[0].clearance_m + 0.015).abs() < 1e-12, "{}", contacts[0].clearance_m);
        assert!((watch.least_clearance_m() + 0.015).abs() < 1e-12);
    }

    #[test]
    fn a_lone_module_touches_nothing() {
        let structure = Structure::from_cells(&[[0, 0]]).expect("one");
        let mut watch = ContactWatch::new(&structure, &Parameters::default());
        watch.check(0.0, &tails(&[1.0]));
        assert!(watch.contacts().is_empty() && watch.least_clearance_m().is_infinite());
    }

    /// Against a plain test of every pair at every step.
    #[test]
    fn the_bound_misses_no_contact_and_not_the_least_clearance() {
        let parameters = Parameters::default();
        let structure = Structure::from_word("3x2").expect("six");
        let tail = Tail::new(&parameters);
        let pairs: Vec<_> = tail
            .reachable_offsets()
            .into_iter()
            .flat_map(|offset| structure.neighbours(offset).map(move |pair| (offset, pair)))
            .collect();
        assert_eq!(pairs.len(), 7, "four side by side, three stacked");
        let mut events_seen = 0;
        for spread_rad in [0.1, 0.4, 0.9, 2.0] {
            let mut watch = ContactWatch::new(&structure, &parameters);
            let (mut least_m, mut events, mut touching) = (f64::INFINITY, 0, vec![false; pairs.len()]);
            for step in 0..30_000 {
                let t_s = f64::from(step) * 1e-3;
                let angles: Vec<f64> = (0..6)
                    .map(|module| {
                        let k = f64::from(module);
                        0.785 + 1.571 * k + spread_rad * (TAU * t_s / (1.3 + 0.1 * k) + k).sin()
                    })
                    .collect();
                watch.check(t_s, &tails(&angles));
                for (index, &(offset, (i, j))) in pairs.iter().enumerate() {
                    let clearance_m = tail.clearance_m(offset, angles[i], angles[j]);
                    least_m = least_m.min(clearance_m);
                    events += usize::from(clearance_m < 0.0 && !touching[index]);
                    touching[index] = clearance_m < 0.0;
                }
            }
            assert_eq!(watch.contacts().len(), events, "spread {spread_rad} rad");
            assert!((watch.least_clearance_m() - least_m).abs() < 1e-15, "spread {spread_rad} rad");
            events_seen += events;
        }
        assert!(events_seen > 10, "{events_seen}");
    }
}
