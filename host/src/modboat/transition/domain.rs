//! The ways each module may take to its next pose, and arc consistency between neighbours.
//!
//! A module takes the short way (|rotation| ≤ π) or the long way round. For each pair of neighbours up to
//! four combinations remain; one that collides is forbidden. AC-3 (Mackworth 1977, \[16\] of the paper)
//! drops a module's way when a neighbour has none left that goes with it, until nothing changes.
//!
//! With two ways each, this propagation after a choice is unit propagation of 2-SAT.

use crate::modboat::pairs::Pairs;

/// The ways that are still open to one module: bit 0 the short way, bit 1 the long one.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Domain(u8);

impl Domain {
    /// No way left.
    pub const EMPTY: Self = Self(0);
    /// Both ways.
    pub const BOTH: Self = Self(0b11);

    /// Only `way` (0 short, 1 long).
    #[must_use]
    pub const fn only(way: usize) -> Self {
        Self(1 << way)
    }

    /// True if `way` is still open.
    #[must_use]
    pub const fn has(self, way: usize) -> bool {
        self.0 & (1 << way) != 0
    }

    /// True if no way is left.
    #[must_use]
    pub const fn is_empty(self) -> bool {
        self.0 == 0
    }

    /// True if both ways are still open.
    #[must_use]
    pub const fn is_open(self) -> bool {
        self.0 == 0b11
    }

    /// What is open in both.
    #[must_use]
    pub const fn intersect(self, other: Self) -> Self {
        Self(self.0 & other.0)
    }

    /// What is open in either.
    #[must_use]
    pub const fn union(self, other: Self) -> Self {
        Self(self.0 | other.0)
    }
}

/// Which of the four combinations of one pair do not collide: bit `way_i + 2·way_j`.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Allowed(u8);

impl Allowed {
    /// Nothing collides.
    pub const ALL: Self = Self(0b1111);

    /// Marks (way of i, way of j) as free of collision.
    pub const fn allow(&mut self, way_i: usize, way_j: usize) {
        self.0 |= 1 << (way_i + 2 * way_j);
    }

    /// True if (way of i, way of j) is free of collision.
    #[must_use]
    pub const fn has(self, way_i: usize, way_j: usize) -> bool {
        self.0 & (1 << (way_i + 2 * way_j)) != 0
    }

    /// True if nothing is forbidden.
    #[must_use]
    pub const fn is_all(self) -> bool {
        self.0 == 0b1111
    }

    /// The ways of one end that some open way of the other end goes with; `of_i` says which end is asked for.
    #[must_use]
    pub fn supported(self, of_i: bool, other: Domain) -> Domain {
        let mut supported = Domain::EMPTY;
        for way in 0..2 {
            let has = |other_way| if of_i { self.has(way, other_way) } else { self.has(other_way, way) };
            if (0..2).any(|other_way| other.has(other_way) && has(other_way)) {
                supported = supported.union(Domain::only(way));
            }
        }
        supported
    }
}

/// AC-3 from the modules in `queue`, over the pairs that `within` accepts. Former domains go on `trail`.
/// False if a module is left without a way; then `queue` is empty again too.
pub fn propagate(
    pairs: &Pairs,
    allowed: &[Allowed],
    domains: &mut [Domain],
    queue: &mut Vec<usize>,
    trail: &mut Vec<(usize, Domain)>,
    within: impl Fn(usize) -> bool,
) -> bool {
    while let Some(module) = queue.pop() {
        for &index in pairs.of(module).iter().filter(|&&index| within(index)) {
            let pair = pairs.all()[index];
            let other = pair.other(module);
            let before = domains[other];
            let after = before.intersect(allowed[index].supported(other == pair.i, domains[module]));
            if after == before {
                continue;
            }
            trail.push((other, before));
            domains[other] = after;
            if after.is_empty() {
                queue.clear();
                return false;
            }
            queue.push(other);
        }
    }
    true
}

#[cfg(test)]
mod tests {
    use super::super::super::pairs::Pair;
    use super::*;

    #[test]
    fn a_forbidden_way_travels_down_a_row() {
        // Short beside short collides everywhere; module 0 must go the short way: alternation follows.
        let pairs = Pairs::new(4, (0..3).map(|i| Pair { i, j: i + 1, offset: 0 }));
        let mut no_two_short = Allowed::ALL;
        no_two_short.0 &= !1;
        let mut no_two_long = no_two_short;
        no_two_long.0 &= !0b1000;
        let mut domains = [Domain::BOTH; 4];
        domains[0] = Domain::only(0);
        let mut trail = Vec::new();
        assert!(propagate(&pairs, &[no_two_long; 3], &mut domains, &mut vec![0], &mut trail, |_| true));
        assert_eq!(domains, [0, 1, 0, 1].map(Domain::only));
        assert_eq!(trail.len(), 3);
    }

    #[test]
    fn a_module_without_a_way_is_reported() {
        let pairs = Pairs::new(2, [Pair { i: 0, j: 1, offset: 0 }]);
        let mut domains = [Domain::BOTH; 2];
        assert!(!propagate(
            &pairs,
            &[Allowed::default()],
            &mut domains,
            &mut vec![0],
            &mut Vec::new(),
            |_| true
        ));
        assert!(domains[1].is_empty());
    }

    #[test]
    fn support_is_read_from_the_right_end() {
        let mut allowed = Allowed::default();
        allowed.allow(0, 1);
        assert_eq!(allowed.supported(true, Domain::BOTH), Domain::only(0));
        assert_eq!(allowed.supported(false, Domain::BOTH), Domain::only(1));
        assert_eq!(allowed.supported(true, Domain::only(0)), Domain::EMPTY);
    }
}
