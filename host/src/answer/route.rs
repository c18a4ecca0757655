//! Shortest paths on a map: `flotilla path`.

use std::time::Instant;

use clap::ValueEnum;
use grid::any_angle::{AnyAngle, Shortest};
use grid::theta::{self, FoundPath, Search};
use serde::{Deserialize, Serialize};

/// How to search.
#[derive(Clone, Copy, Debug, Deserialize, ValueEnum)]
#[serde(rename_all = "kebab-case")]
pub enum Algorithm {
    /// Any angle: in 2D the shortest path, in 3D Theta* with its corners put right
    #[value(name = "theta")]
    #[serde(rename = "theta")]
    AnyAngle,
    /// Basic Theta* as published
    BasicTheta,
    /// A* along the moves to neighbouring vertices: exact, for those moves
    AStar,
    /// A*, and then straight legs where they are free
    AStarSmoothed,
}

/// A query's answer, as in its JSON line.
#[derive(Serialize)]
pub struct Answer {
    /// From where.
    pub start: Vec<u32>,
    /// To where.
    pub goal: Vec<u32>,
    /// How long the way is, in cells; `None` where there is none.
    pub length: Option<f64>,
    /// Its corners, both ends included.
    pub path: Option<Vec<Vec<u32>>>,
    /// Vertices that were expanded.
    pub expanded: usize,
    /// How long the search took, µs.
    pub time_us: u64,
}

/// The memory of searches, from one query to the next.
#[derive(Default)]
pub struct Scratch {
    any_angle: AnyAngle,
    search: Search,
}

impl Scratch {
    /// None yet.
    #[must_use]
    pub fn new() -> Self {
        Self { any_angle: AnyAngle::new(), search: Search::new() }
    }
}

/// A shortest path from one place to another. There is none where either end is blocked or outside of the map.
pub fn ask<const N: usize>(
    algorithm: Algorithm,
    Scratch { any_angle, search }: &mut Scratch,
    map: &impl Shortest<N>,
    start: [u32; N],
    goal: [u32; N],
) -> Answer {
    let ends = map.vertex(start).zip(map.vertex(goal));
    let ends = ends.filter(|&(start, goal)| map.is_open(start) && map.is_open(goal));
    let began = Instant::now();
    let found = ends.and_then(|(start, goal)| match algorithm {
        Algorithm::AnyAngle => map.shortest(any_angle, start, goal),
        Algorithm::BasicTheta => search.theta_star(map, start, goal),
        Algorithm::AStar => search.a_star(map, start, goal),
        Algorithm::AStarSmoothed => search.a_star(map, start, goal).and_then(|found| {
            let path = theta::smooth(map, &found.path);
            Some(FoundPath { cost: theta::cost(map, &path)?, path, ..found })
        }),
    });
    let expanded = match algorithm {
        _ if ends.is_none() => 0,
        Algorithm::AnyAngle => any_angle.expanded(),
        _ => search.expanded(),
    };
    let time_us = began.elapsed().as_micros() as u64;
    let places = |path: &[usize]| path.iter().map(|&vertex| map.place(vertex).to_vec()).collect();
    Answer {
        start: start.to_vec(),
        goal: goal.to_vec(),
        length: found.as_ref().map(|found| found.cost),
        path: found.as_ref().map(|found| places(&found.path)),
        expanded,
        time_us,
    }
}
