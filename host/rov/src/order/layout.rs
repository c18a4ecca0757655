//! Places, states and hops: which kind of robot rests where, in one number.
//!
//! Places are numbered: first the starts, in the order of the robots, then the slots, then the parking places. A robot
//! that may make m moves may rest in m − 1 parking places on its way, so every berth counts m − 1 times: once for robots
//! that have made one move, once for those that have made two, and so on. The number of moves made is then part of where
//! a robot rests.
//!
//! ```text
//! state = Σ vacated_i·2ⁱ + Σ (kind_p + 1)·2^(n + b·p)       i: starts, p: slots and parking places, 0 for an empty one
//! b = ⌈log₂(kinds + 1)⌉
//! ```

/// Most robots, and most slots, that an order is found for.
pub const MOST: usize = 16;

/// Which kind of robot rests where.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct State(u128);

/// A move from one place to another.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct Hop {
    /// Where a robot rests.
    pub from: u8,
    /// Where it is to rest.
    pub to: u8,
}

impl Hop {
    /// Between places of these numbers, below 256.
    #[must_use]
    pub const fn new(from: usize, to: usize) -> Self {
        Self { from: from as u8, to: to as u8 }
    }

    /// Numbers of both places.
    #[must_use]
    pub const fn ends(self) -> (usize, usize) {
        (self.from as usize, self.to as usize)
    }
}

/// How many places of which sort there are, and the kinds of the robots.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Layout {
    kinds: Vec<u8>,
    settled: Vec<u8>,
    slots: usize,
    berths: usize,
    moves: usize,
    bits: usize,
}

impl Layout {
    /// Robots of these kinds, without parking places. Kinds that are no longer told apart once they rest in a slot have
    /// the same number in `settled`.
    ///
    /// # Panics
    /// For more than [`MOST`] robots or slots.
    #[must_use]
    pub fn new(kinds: Vec<u8>, settled: Vec<u8>, slots: usize) -> Self {
        assert!(kinds.len() <= MOST && slots <= MOST, "{} robots, {slots} slots", kinds.len());
        let greatest = settled.len();
        let bits = (usize::BITS - greatest.leading_zeros()) as usize;
        Self { kinds, settled, slots, berths: 0, moves: 1, bits }
    }

    /// How many berths fit into a state when robots may make `moves` moves.
    #[must_use]
    pub fn berths_most(&self, moves: usize) -> usize {
        let left = 128 - self.kinds.len() - self.bits * self.slots;
        let places = self.kinds.len() + self.slots;
        (left / self.bits).min(255 - places) / moves.saturating_sub(1).max(1)
    }

    /// With parking places, as many as fit.
    #[must_use]
    pub fn with_berths(self, berths: usize, moves: usize) -> Self {
        let berths = if moves > 1 { berths.min(self.berths_most(moves)) } else { 0 };
        Self { berths, moves: moves.max(1), ..self }
    }

    /// How many robots.
    #[must_use]
    pub fn robots(&self) -> usize {
        self.kinds.len()
    }

    /// How many slots.
    #[must_use]
    pub const fn slots(&self) -> usize {
        self.slots
    }

    /// How many berths.
    #[must_use]
    pub const fn berths(&self) -> usize {
        self.berths
    }

    /// How often a robot may move.
    #[must_use]
    pub const fn moves(&self) -> usize {
        self.moves
    }

    /// How many places.
    #[must_use]
    pub fn places(&self) -> usize {
        self.robots() + self.slots + self.berths * (self.moves - 1)
    }

    /// Kind of a robot.
    #[must_use]
    pub fn kind(&self, robot: usize) -> u8 {
        self.kinds[robot]
    }

    /// The slot that a place is.
    #[must_use]
    pub fn slot(&self, place: usize) -> Option<usize> {
        place.checked_sub(self.robots()).filter(|&slot| slot < self.slots)
    }

    /// The berth that a place is, and how many moves less one a robot there has made.
    #[must_use]
    pub fn berth(&self, place: usize) -> Option<(usize, usize)> {
        let index = place.checked_sub(self.robots() + self.slots)?;
        Some((index % self.berths, index / self.berths))
    }

    const fn mask(&self) -> u128 {
        (1 << self.bits) - 1
    }

    fn shift(&self, place: usize) -> usize {
        self.robots() + self.bits * (place - self.robots())
    }

    /// Kind of the robot that rests in a place.
    #[must_use]
    pub fn occupant(&self, state: &State, place: usize) -> Option<u8> {
        if place < self.robots() {
            return (state.0 >> place & 1 == 0).then(|| self.kinds[place]);
        }
        let field = state.0 >> self.shift(place) & self.mask();
        (field as u8).checked_sub(1)
    }

    /// The state after a hop of the robot that rests at its beginning.
    #[must_use]
    pub fn after(&self, state: &State, hop: Hop) -> State {
        let (from, to) = hop.ends();
        let Some(kind) = self.occupant(state, from) else { return *state };
        let mut bits = self.without(state, from).0;
        let kind = if self.slot(to).is_some() { self.settled[usize::from(kind)] } else { kind };
        bits |= u128::from(kind + 1) << self.shift(to);
        State(bits)
    }

    /// The state while the robot of a place is away.
    #[must_use]
    pub fn without(&self, state: &State, place: usize) -> State {
        if place < self.robots() {
            State(state.0 | 1 << place)
        } else {
            State(state.0 & !(self.mask() << self.shift(place)))
        }
    }

    /// Filled slots, a bit each.
    #[must_use]
    pub fn filled(&self, state: &State) -> u32 {
        let slots = (0..self.slots).filter(|slot| self.occupant(state, self.robots() + slot).is_some());
        slots.fold(0, |mask, slot| mask | 1 << slot)
    }

    /// Starts where robots rest, a bit each.
    #[must_use]
    pub fn unmoved(&self, state: &State) -> u32 {
        (0..self.robots())
            .filter(|&start| self.occupant(state, start).is_some())
            .fold(0, |mask, k| mask | 1 << k)
    }

    /// Places where a robot rests that is in no slot yet, and its kind.
    pub fn waiting(&self, state: &State) -> impl Iterator<Item = (usize, u8)> + use<'_> {
        let state = *state;
        let places = (0..self.robots()).chain(self.robots() + self.slots..self.places());
        places.filter_map(move |place| Some((place, self.occupant(&state, place)?)))
    }

    /// Whether every robot is in a slot.
    #[must_use]
    pub fn is_done(&self, state: &State) -> bool {
        self.waiting(state).next().is_none()
    }

    /// Hops to empty places that the number of moves allows, and the kind of robot.
    pub fn hops(&self, state: &State) -> impl Iterator<Item = (Hop, u8)> + use<'_> {
        let state = *state;
        self.waiting(&state).flat_map(move |(from, kind)| {
            let slots = self.robots()..self.robots() + self.slots;
            let level = self.berth(from).map_or(0, |(_, level)| level + 1);
            let first = self.robots() + self.slots + level * self.berths;
            let parks = if level + 1 < self.moves { first..first + self.berths } else { 0..0 };
            slots
                .chain(parks)
                .filter(move |&to| self.occupant(&state, to).is_none())
                .map(move |to| (Hop::new(from, to), kind))
        })
    }
}
