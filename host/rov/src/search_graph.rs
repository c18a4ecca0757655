//! The graph that a route is searched in: a regular 3D grid, with a mover's start and slot as vertices of their own.
//!
//! Cells are the box of the first robot divided by [`Rules::grid_divisions`](reconfiguration::problem::Rules), so that docked
//! poses lie on the grid; start and slot need not. A dock beside others can often be left only along its own faces, and where it is turned
//! against the grid, or lies between its points, no edge of the grid does that. There a piece of grid around the dock, of its own axes and
//! its mover's cells, as wide as its dock zone, goes with the regular one ([`Lattice::with_docks`]). Whether a leg is free is decided exactly, by
//! [`Clearance`], never by cells. That is most of the work, and the same under every
//! criterion and in both directions, so [`Edges`] remembers it.

use std::cell::RefCell;

use grid::theta::Space;

use super::clearance::Clearance;
use super::cost_per_metre::CostPerMetre;
use super::vector::{length, offset, turned};

/// Points of a grid that is searched as it is: 16 MB of scratch.
const MOST_POINTS: usize = 1 << 20;

/// Points of a regular grid, upright, of whatever heading.
#[derive(Clone, Debug)]
struct Grid {
    origin_m: [f64; 3],
    yaw_rad: f64,
    cell_m: [f64; 3],
    counts: [usize; 3],
    /// Number of its first point among those of all grids.
    first: usize,
}

/// A regular grid in the bounds of the water, and pieces of others around docks.
#[derive(Clone, Debug)]
pub struct Lattice {
    grid: Grid,
    docks: Vec<Grid>,
}

impl Lattice {
    /// All grid points `anchor + n·cell` within the corners `bounds_m`.
    #[must_use]
    pub fn new(anchor_m: [f64; 3], cell_m: [f64; 3], bounds_m: [[f64; 3]; 2]) -> Self {
        let first = |k: usize| ((bounds_m[0][k] - anchor_m[k]) / cell_m[k] - 1e-9).ceil();
        let last = |k: usize| ((bounds_m[1][k] - anchor_m[k]) / cell_m[k] + 1e-9).floor();
        let count = |k: usize| (last(k) - first(k) + 1.0).max(0.0) as usize;
        let origin_m = std::array::from_fn(|k| anchor_m[k] + first(k) * cell_m[k]);
        let counts = [count(0), count(1), count(2)];
        Self { grid: Grid { origin_m, yaw_rad: 0.0, cell_m, counts, first: 0 }, docks: Vec::new() }
    }

    /// The part of a large grid that a way can want, made coarser by a whole number where even that is large. Away from all
    /// bodies, start and slot by d and a hull, the water is free: what leads farther out comes back no cheaper.
    #[must_use]
    pub fn around_bodies(&self, clearance: &Clearance) -> Self {
        if self.len() <= MOST_POINTS {
            return self.clone();
        }
        let Grid { origin_m, cell_m, .. } = self.grid;
        let room_m = |k: usize| clearance.distance_m + 2.0 * cell_m[k] + length(clearance.half_m);
        let ends = [&clearance.start, &clearance.slot].map(|pose| (pose.position_m, 0.0));
        let bodies = clearance.resting.iter().map(|body| (body.pose.position_m, length(body.half_m)));
        let mut near_m = [[f64::INFINITY; 3], [f64::NEG_INFINITY; 3]];
        for (at_m, reach_m) in bodies.chain(ends) {
            for k in 0..3 {
                near_m[0][k] = near_m[0][k].min(at_m[k] - reach_m - room_m(k));
                near_m[1][k] = near_m[1][k].max(at_m[k] + reach_m + room_m(k));
            }
        }
        let [low, high] = clearance.water.extent_m();
        let near_m = [
            std::array::from_fn(|k| near_m[0][k].max(low[k])),
            std::array::from_fn(|k| near_m[1][k].min(high[k])),
        ];
        let mut times = 1.0;
        loop {
            let part = Self::new(origin_m, cell_m.map(|side| side * times), near_m);
            if part.len() <= MOST_POINTS {
                return part;
            }
            times += 1.0;
        }
    }

    /// With a piece around the start and one around the slot, along the axes of each: the mover's box by `divisions`, from
    /// the dock out to d.
    #[must_use]
    pub fn with_docks(mut self, clearance: &Clearance, divisions: [u32; 3]) -> Self {
        let cell_m: [f64; 3] =
            std::array::from_fn(|k| 2.0 * clearance.half_m[k] / f64::from(divisions[k].max(1)));
        let out = cell_m.map(|side| (clearance.distance_m / side).ceil());
        for dock in [&clearance.start, &clearance.slot] {
            let corner_m = turned(std::array::from_fn(|k| out[k] * cell_m[k]), dock.yaw_rad);
            self.docks.push(Grid {
                origin_m: offset(corner_m, dock.position_m),
                yaw_rad: dock.yaw_rad,
                cell_m,
                counts: out.map(|out| 2 * out as usize + 1),
                first: self.len(),
            });
        }
        self
    }

    /// Its points, m.
    pub fn places_m(&self) -> impl Iterator<Item = [f64; 3]> + '_ {
        self.grids().flat_map(|grid| (0..grid.len()).map(|vertex| grid.place_m(vertex)))
    }

    fn grids(&self) -> impl Iterator<Item = &Grid> {
        std::iter::once(&self.grid).chain(&self.docks)
    }

    fn len(&self) -> usize {
        self.grids().map(Grid::len).sum()
    }

    /// Of which grid a point is, and the number of that.
    fn grid_of(&self, vertex: usize) -> (usize, &Grid) {
        let of = |dock: &&Grid| dock.first <= vertex;
        let index = self.docks.iter().take_while(of).count();
        (index, index.checked_sub(1).and_then(|dock| self.docks.get(dock)).unwrap_or(&self.grid))
    }

    fn place_m(&self, vertex: usize) -> [f64; 3] {
        let (_, grid) = self.grid_of(vertex);
        grid.place_m(vertex - grid.first)
    }
}

impl Grid {
    fn len(&self) -> usize {
        self.counts.iter().product()
    }

    fn place_m(&self, vertex: usize) -> [f64; 3] {
        let [nx, ny, _] = self.counts;
        let cell = [vertex % nx, vertex / nx % ny, vertex / (nx * ny)];
        let way_m = std::array::from_fn(|k| cell[k] as f64 * self.cell_m[k]);
        let way_m = self.turned(way_m, 1.0);
        std::array::from_fn(|k| self.origin_m[k] + way_m[k])
    }

    /// Out of its axes; with `sense` −1 into them.
    fn turned(&self, way_m: [f64; 3], sense: f64) -> [f64; 3] {
        if self.yaw_rad == 0.0 { way_m } else { turned(way_m, sense * self.yaw_rad) }
    }

    /// Whether two places are at most one cell away from each other on every axis.
    fn are_beside(&self, from_m: [f64; 3], to_m: [f64; 3]) -> bool {
        let way_m = self.turned(offset(from_m, to_m), -1.0);
        (0..3).all(|k| way_m[k].abs() <= self.cell_m[k] * (1.0 + 1e-9))
    }

    /// The neighbours of a grid point: their numbers and themselves.
    fn beside(&self, vertex: usize, mut visit: impl FnMut(usize, usize)) {
        let [nx, ny, nz] = self.counts;
        let (x, y, z) = (vertex % nx, vertex / nx % ny, vertex / (nx * ny));
        // Offsets as 0, 1, 2, so that nothing falls below zero.
        let span = |at: usize, count: usize| usize::from(at == 0)..3.min(count + 1 - at);
        for dz in span(z, nz) {
            for dy in span(y, ny) {
                for dx in span(x, nx) {
                    let number = dx + 3 * (dy + 3 * dz);
                    if number != NEIGHBOURS / 2 {
                        visit(number, vertex + dx + nx * (dy + ny * dz) - (1 + nx * (1 + ny)));
                    }
                }
            }
        }
    }

    /// Grid points at most one cell away from a place on every axis; on a grid point its 26 neighbours and itself.
    fn around(&self, place_m: [f64; 3], mut visit: impl FnMut(usize)) {
        let way_m = self.turned(offset(self.origin_m, place_m), -1.0);
        let span: [(usize, usize); 3] = std::array::from_fn(|k| {
            let at = way_m[k] / self.cell_m[k];
            let first = (at - 1.0 - 1e-9).ceil().max(0.0);
            let last = (at + 1.0 + 1e-9).floor().min(self.counts[k] as f64 - 1.0);
            if last < first { (1, 0) } else { (first as usize, last as usize) }
        });
        let [nx, ny, _] = self.counts;
        for z in span[2].0..=span[2].1 {
            for y in span[1].0..=span[1].1 {
                for x in span[0].0..=span[0].1 {
                    visit(x + nx * (y + ny * z));
                }
            }
        }
    }
}

/// Neighbours of a grid point, itself among them, numbered by offset: x fastest, from −1 to 1 on each axis.
const NEIGHBOURS: usize = 27;

/// Which edges between neighbouring grid points are free, as far as searches have asked.
#[derive(Clone, Debug)]
pub struct Edges {
    /// By grid point, and in it by neighbour: bit n, it has been asked for; bit n + 32, it is free.
    known: RefCell<Vec<u64>>,
}

impl Edges {
    /// No edge of `lattice` looked at yet.
    #[must_use]
    pub fn new(lattice: &Lattice) -> Self {
        Self { known: RefCell::new(vec![0; lattice.len()]) }
    }

    /// Whether the edge from a grid point to its neighbour of that number is free.
    fn is_free(&self, from: usize, number: usize, to: usize, look: impl FnOnce() -> bool) -> bool {
        let mut known = self.known.borrow_mut();
        if known[from] >> number & 1 == 0 {
            let answer = 1 | u64::from(look()) << 32;
            known[from] |= answer << number;
            known[to] |= answer << (NEIGHBOURS - 1 - number);
        }
        known[from] >> (number + 32) & 1 == 1
    }
}

/// Cost of a corner; zero where headings are held or decided later.
pub type CornerCost<'a> = &'a dyn Fn(Option<[f64; 3]>, [f64; 3], bool) -> f64;

/// The graph of one mover under one criterion.
pub struct SearchGraph<'a> {
    lattice: &'a Lattice,
    clearance: &'a Clearance,
    edges: &'a Edges,
    cost_per_metre: &'a CostPerMetre,
    corner: Option<CornerCost<'a>>,
    /// What an edge costs, by grid and the number of the neighbour.
    steps: Vec<[f64; NEIGHBOURS]>,
}

impl<'a> SearchGraph<'a> {
    /// The grid, what is free, and what a metre costs. `corner` is the cost of turning from the leg before (none at the
    /// start) to a leg, told whether that one ends at the slot; `edges` is what is known of this lattice and clearance.
    #[must_use]
    pub fn new(
        (lattice, clearance, edges): (&'a Lattice, &'a Clearance, &'a Edges),
        cost_per_metre: &'a CostPerMetre,
        corner: Option<CornerCost<'a>>,
    ) -> Self {
        let steps = |grid: &Grid| {
            std::array::from_fn(|number| {
                let cells = [number % 3, number / 3 % 3, number / 9];
                let way_m = std::array::from_fn(|k| (cells[k] as f64 - 1.0) * grid.cell_m[k]);
                cost_per_metre.cost(grid.turned(way_m, 1.0))
            })
        };
        let steps = lattice.grids().map(steps).collect();
        Self { lattice, clearance, edges, cost_per_metre, corner, steps }
    }

    /// Whether the slot can be entered from anywhere: where not, no search need look for it.
    #[must_use]
    pub fn slot_is_open(&self) -> bool {
        let (start_m, slot_m) = (self.clearance.start.position_m, self.clearance.slot.position_m);
        let mut open = self.is_beside_slot(start_m) && self.is_free(start_m, slot_m);
        for grid in self.lattice.grids() {
            grid.around(slot_m, |vertex| {
                let place_m = grid.place_m(vertex);
                open = open || (!self.is_slot(grid, place_m) && self.is_free(place_m, slot_m));
            });
        }
        open
    }

    /// At most one cell away from it on every axis of some grid.
    fn is_beside_slot(&self, place_m: [f64; 3]) -> bool {
        self.lattice.grids().any(|grid| grid.are_beside(place_m, self.clearance.slot.position_m))
    }

    /// Whether a point of a dock's grid is the slot, which is a vertex of its own.
    fn is_slot(&self, grid: &Grid, place_m: [f64; 3]) -> bool {
        grid.first > 0 && length(offset(self.clearance.slot.position_m, place_m)) < 1e-9
    }

    /// The vertex of the mover's start.
    #[must_use]
    pub fn start(&self) -> usize {
        self.lattice.len()
    }

    /// The vertex of the mover's slot.
    #[must_use]
    pub fn slot(&self) -> usize {
        self.lattice.len() + 1
    }

    /// Position of a vertex, m.
    #[must_use]
    pub fn place_m(&self, vertex: usize) -> [f64; 3] {
        if vertex < self.lattice.len() {
            self.lattice.place_m(vertex)
        } else if vertex == self.start() {
            self.clearance.start.position_m
        } else {
            self.clearance.slot.position_m
        }
    }

    /// Free for the hull as it is taken by the paper's rules.
    fn is_free(&self, from_m: [f64; 3], to_m: [f64; 3]) -> bool {
        self.clearance.docked_leg_is_free(from_m, to_m)
    }
}

impl Space for SearchGraph<'_> {
    fn vertices(&self) -> usize {
        self.lattice.len() + 2
    }

    fn for_neighbours(&self, vertex: usize, mut visit: impl FnMut(usize, f64)) {
        let here_m = self.place_m(vertex);
        let own = (vertex < self.lattice.len()).then(|| self.lattice.grid_of(vertex));
        if let Some((index, grid)) = own {
            grid.beside(vertex - grid.first, |number, next| {
                let next_m = grid.place_m(next);
                let look = || !self.is_slot(grid, next_m) && self.is_free(here_m, next_m);
                if self.edges.is_free(vertex, number, grid.first + next, look) {
                    visit(grid.first + next, self.steps[index][number]);
                }
            });
        }
        let others = self.lattice.grids().filter(|grid| own.is_none_or(|(_, own)| own.first != grid.first));
        for grid in others {
            grid.around(here_m, |next| {
                let next_m = grid.place_m(next);
                if !self.is_slot(grid, next_m) && self.is_free(here_m, next_m) {
                    visit(grid.first + next, self.cost_per_metre.cost(offset(here_m, next_m)));
                }
            });
        }
        let slot_m = self.clearance.slot.position_m;
        if vertex != self.slot() && self.is_beside_slot(here_m) && self.is_free(here_m, slot_m) {
            visit(self.slot(), self.cost_per_metre.cost(offset(here_m, slot_m)));
        }
    }

    fn leg_below(&self, from: usize, to: usize, limit: f64) -> Option<f64> {
        let (from_m, to_m) = (self.place_m(from), self.place_m(to));
        let cost = self.cost_per_metre.cost(offset(from_m, to_m));
        (cost < limit && self.is_free(from_m, to_m)).then_some(cost)
    }

    fn turn(&self, before: usize, at: usize, to: usize) -> f64 {
        let Some(corner) = self.corner else { return 0.0 };
        let at_m = self.place_m(at);
        let came_m = offset(self.place_m(before), at_m);
        let came_m = (before != at && length(came_m) > 0.0).then_some(came_m);
        corner(came_m, offset(at_m, self.place_m(to)), to == self.slot())
    }

    fn bound(&self, vertex: usize, goal: usize) -> f64 {
        self.cost_per_metre.bound(offset(self.place_m(vertex), self.place_m(goal)))
    }
}
