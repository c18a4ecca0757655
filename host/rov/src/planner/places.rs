//! Where robots can rest, and which of them would be docked to each other or in each other's way there.
//!
//! A *seat* is a vehicle in a place. Everything that only depends on two seats is worked out once: whether their
//! connectors meet (18), and whether their boxes overlap.

use reconfiguration::pose::Pose;
use reconfiguration::problem::Problem;
use reconfiguration::vehicle::Vehicle;

use super::super::configuration::{LevelBox, clusters_by, holds};
use super::super::order::{Layout, State};

/// Places of a problem: starts, slots, parking places.
#[derive(Debug)]
pub(super) struct Places<'a> {
    problem: &'a Problem,
    /// Of every place.
    poses: Vec<Pose>,
    /// [seat][seat] for all seats, tools last.
    docked: Vec<Vec<bool>>,
    overlapping: Vec<Vec<bool>>,
    /// Kinds of robots: a vehicle, and the slots where it may rest.
    vehicle_of_kind: Vec<usize>,
}

impl<'a> Places<'a> {
    /// With parking places at `berths`.
    pub(super) fn new(
        problem: &'a Problem,
        layout: &Layout,
        vehicle_of_kind: &[usize],
        berths: &[Pose],
    ) -> Self {
        let starts = problem.robots.iter().map(|robot| robot.start);
        let slots = problem.slots.iter().map(|slot| slot.pose);
        let parked = (0..layout.moves() - 1).flat_map(|_| berths[..layout.berths()].iter().copied());
        let poses: Vec<Pose> = starts.chain(slots).chain(parked).collect();
        let mut places = Self {
            problem,
            poses,
            docked: Vec::new(),
            overlapping: Vec::new(),
            vehicle_of_kind: vehicle_of_kind.to_vec(),
        };
        let seats: Vec<(Pose, &Vehicle)> =
            (0..places.seats() + problem.tools.len()).map(|seat| places.body(seat)).collect();
        let table = |holds: &dyn Fn(usize, usize) -> bool| {
            let row = |i: usize| (0..seats.len()).map(|j| i != j && holds(i.min(j), i.max(j))).collect();
            (0..seats.len()).map(row).collect()
        };
        let reach = |seat: usize| seats[seat].1.box_m.iter().map(|side| side * side).sum::<f64>().sqrt();
        let near = |i: usize, j: usize| {
            let [a, b] = [seats[i].0.position_m, seats[j].0.position_m];
            let apart = (0..3).map(|k| (a[k] - b[k]).powi(2)).sum::<f64>().sqrt();
            // Connectors may stand out from the box: twice its diagonal is far enough.
            apart <= reach(i) + reach(j)
        };
        let box_of = |seat: usize| LevelBox::around(seats[seat].0, seats[seat].1);
        places.docked = table(&|i, j| near(i, j) && holds(seats[i], seats[j]).is_some());
        places.overlapping = table(&|i, j| near(i, j) && box_of(i).overlaps(&box_of(j)));
        places
    }

    /// Seats without those of the tools.
    fn seats(&self) -> usize {
        self.poses.len() * self.problem.vehicles.len()
    }

    /// A kind of robot in a place.
    pub(super) fn seat(&self, place: usize, kind: u8) -> usize {
        place * self.problem.vehicles.len() + self.vehicle_of_kind[usize::from(kind)]
    }

    /// Whether all robots are of one vehicle.
    pub(super) fn has_one_vehicle(&self) -> bool {
        self.vehicle_of_kind.windows(2).all(|pair| pair[0] == pair[1])
    }

    /// Seats of a place: every vehicle that a robot is.
    pub(super) fn seats_of(&self, place: usize) -> impl Iterator<Item = usize> {
        let vehicles = self.problem.vehicles.len();
        (0..vehicles)
            .filter(|vehicle| self.vehicle_of_kind.contains(vehicle))
            .map(move |own| place * vehicles + own)
    }

    /// Where a place is.
    pub(super) fn pose(&self, place: usize) -> Pose {
        self.poses[place]
    }

    /// Pose and vehicle of a seat.
    pub(super) fn body(&self, seat: usize) -> (Pose, &'a Vehicle) {
        let (problem, kinds) = (self.problem, self.problem.vehicles.len());
        match seat.checked_sub(self.seats()) {
            Some(tool) => (problem.tools[tool].pose, &problem.vehicles[problem.tools[tool].vehicle]),
            None => (self.poses[seat / kinds], &problem.vehicles[seat % kinds]),
        }
    }

    /// The place of a robot's seat; `None` for a tool's.
    pub(super) fn place(&self, seat: usize) -> Option<usize> {
        (seat < self.seats()).then(|| seat / self.problem.vehicles.len())
    }

    /// Seats that are taken while the robot of `away` moves: tools, then robots by their places.
    pub(super) fn taken(&self, layout: &Layout, state: &State, away: usize) -> Vec<usize> {
        let tools = self.seats()..self.seats() + self.problem.tools.len();
        let places = (0..layout.places()).filter(|&place| place != away);
        let robots = places.filter_map(|place| Some(self.seat(place, layout.occupant(state, place)?)));
        tools.chain(robots).collect()
    }

    /// Seats that may be taken: every kind of robot's in every place, and the tools'.
    pub(super) fn robots_and_tools(&self) -> impl Iterator<Item = usize> {
        let vehicles = self.problem.vehicles.len();
        let robots = (0..self.seats()).filter(move |seat| self.vehicle_of_kind.contains(&(seat % vehicles)));
        robots.chain(self.tools())
    }

    /// Seats of the tools.
    pub(super) fn tools(&self) -> Vec<usize> {
        (self.seats()..self.seats() + self.problem.tools.len()).collect()
    }

    /// Whether a robot of that kind in a place would overlap one of the seats.
    pub(super) fn is_blocked(&self, place: usize, kind: u8, taken: &[usize]) -> bool {
        let own = &self.overlapping[self.seat(place, kind)];
        taken.iter().any(|&other| own[other])
    }

    /// Clusters of seats, each ascending.
    pub(super) fn clusters(&self, taken: &[usize]) -> Vec<Vec<usize>> {
        let mut found = clusters_by(taken.len(), |a, b| self.docked[taken[a]][taken[b]]);
        for cluster in &mut found {
            cluster.iter_mut().for_each(|member| *member = taken[*member]);
            cluster.sort_unstable();
        }
        found
    }

    /// Whether robots in these slots, whatever their kinds, and all tools may be one cluster.
    pub(super) fn is_one_cluster(&self, layout: &Layout, slots: &[usize], kinds: &[Vec<u8>]) -> bool {
        let tools = (self.seats()..self.seats() + self.problem.tools.len()).map(|seat| vec![seat]);
        let filled = slots
            .iter()
            .map(|&slot| kinds[slot].iter().map(|&kind| self.seat(layout.robots() + slot, kind)).collect());
        let nodes: Vec<Vec<usize>> = tools.chain(filled).collect();
        let meet = |a: usize, b: usize| nodes[a].iter().any(|&a| nodes[b].iter().any(|&b| self.docked[a][b]));
        clusters_by(nodes.len(), meet).len() == 1
    }
}

/// Half its length, width and height, m.
pub(super) fn half_m(vehicle: &Vehicle) -> [f64; 3] {
    vehicle.box_m.map(|side| side / 2.0)
}
