//! Which modules' tails can touch: the flat list of neighbour pairs of a structure, computed once.
//!
//! Every law between two modules (distance to collision, repulsion, transitions) runs over this list; by
//! module it is read through a compressed adjacency, so that the inner loops allocate nothing.

/// Two modules with tails that can reach each other.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Pair {
    /// First module.
    pub i: usize,
    /// Second module, at the lattice offset from the first.
    pub j: usize,
    /// Index of that offset in the distance-to-collision tables.
    pub offset: usize,
}

impl Pair {
    /// The other end, seen from `module`.
    #[must_use]
    pub const fn other(&self, module: usize) -> usize {
        if module == self.i { self.j } else { self.i }
    }
}

/// All pairs of a structure, and those of each module.
#[derive(Clone, Debug, Default)]
pub struct Pairs {
    modules: usize,
    pairs: Vec<Pair>,
    /// The pairs of module m are `incident[first[m]..first[m + 1]]`.
    first: Vec<usize>,
    incident: Vec<usize>,
}

impl Pairs {
    /// From the pairs of a structure of so many modules; pairs that name a module beyond it are dropped.
    #[must_use]
    pub fn new(modules: usize, pairs: impl IntoIterator<Item = Pair>) -> Self {
        let pairs: Vec<Pair> = pairs.into_iter().filter(|p| p.i < modules && p.j < modules).collect();
        let mut first = vec![0; modules + 1];
        for pair in &pairs {
            first[pair.i + 1] += 1;
            first[pair.j + 1] += 1;
        }
        for module in 0..modules {
            first[module + 1] += first[module];
        }
        let mut next = first.clone();
        let mut incident = vec![0; 2 * pairs.len()];
        for (index, pair) in pairs.iter().enumerate() {
            for module in [pair.i, pair.j] {
                incident[next[module]] = index;
                next[module] += 1;
            }
        }
        Self { modules, pairs, first, incident }
    }

    /// Number of modules in the structure.
    #[must_use]
    pub const fn modules(&self) -> usize {
        self.modules
    }

    /// All pairs of modules with tails that can touch.
    #[must_use]
    pub fn all(&self) -> &[Pair] {
        &self.pairs
    }

    /// Indices into [`Self::all`] of the pairs that `module` belongs to.
    #[must_use]
    pub fn of(&self, module: usize) -> &[usize] {
        &self.incident[self.first[module]..self.first[module + 1]]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_pair_is_found_from_both_its_ends() {
        // 0 – 1
        // |   |
        // 2 – 3
        let list = [(0, 1, 0), (2, 3, 0), (0, 2, 1), (1, 3, 1)].map(|(i, j, offset)| Pair { i, j, offset });
        let pairs = Pairs::new(4, list);
        let others = |m: usize| {
            let mut others: Vec<_> = pairs.of(m).iter().map(|&p| pairs.all()[p].other(m)).collect();
            others.sort_unstable();
            others
        };
        assert_eq!(others(0), [1, 2]);
        assert_eq!(others(1), [0, 3]);
        assert_eq!(others(2), [0, 3]);
        assert_eq!(others(3), [1, 2]);
        assert_eq!(pairs.of(3).iter().map(|&p| pairs.all()[p].offset).sum::<usize>(), 1);
    }

    #[test]
    fn a_lone_module_has_no_pairs() {
        let pairs = Pairs::new(1, []);
        assert!(pairs.of(0).is_empty());
        assert_eq!(pairs.modules(), 1);
    }
}
