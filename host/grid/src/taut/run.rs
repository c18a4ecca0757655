//! One search: cones in the order of f, and the ways to vertices.

use std::cmp::Reverse;

use super::super::Map;
use super::super::plane::Plane;
use super::super::theta::key;
use super::Taut;
use super::cone::{Cone, Goal};

/// Lengths that differ by less than this share of them are equal.
const ROUNDING: f64 = 1e-12;

/// Stands for the goal in the open list.
const GOAL: u32 = u32::MAX;

/// One search under way.
pub(super) struct Run<'r> {
    pub(super) plane: &'r Plane,
    pub(super) goal: Goal,
    goal_vertex: usize,
    /// The shortest way to the goal yet.
    least: f64,
    /// The least of the cones that the one in hand has led to: most often it is the next.
    held: Option<(u128, Cone)>,
    taut: &'r mut Taut,
}

impl<'r> Run<'r> {
    /// A search that has not begun.
    pub(super) fn new(taut: &'r mut Taut, plane: &'r Plane, goal: usize) -> Self {
        let at = plane.place(goal).map(|c| c as i32);
        Self { plane, goal: Goal { at }, goal_vertex: goal, least: f64::INFINITY, held: None, taut }
    }

    /// Searches; whether there is a path.
    pub(super) fn finds(mut self, start: usize) -> bool {
        self.start(start);
        self.is_reached()
    }

    /// Notes a way to a vertex; whether it is shorter than what is known.
    pub(super) fn reaches(&mut self, vertex: usize, g: f64, from: u32) -> bool {
        let known = &mut self.taut.known[vertex];
        let is_shorter = known.2 != self.taut.generation || g < known.0 * (1.0 - ROUNDING);
        if is_shorter {
            *known = (g, from, self.taut.generation);
        }
        is_shorter
    }

    /// Opens a cone around a vertex: no way through it is shorter than straight to the goal.
    pub(super) fn fan(&mut self, cone: Cone) {
        let f = cone.g + self.goal.distance(cone.root_at);
        self.push(f, cone);
    }

    /// Opens a cone whose f that is, if it can still be part of the shortest path.
    pub(super) fn push(&mut self, f: f64, cone: Cone) {
        if f >= self.least {
            return;
        }
        let Reverse(mut entry) = key(cone.g, f - cone.g, 0);
        let mut cone = cone;
        if let Some((held, other)) = &mut self.held {
            if entry < *held {
                std::mem::swap(&mut entry, held);
                std::mem::swap(&mut cone, other);
            }
            self.queue(entry, cone);
        } else {
            self.held = Some((entry, cone));
        }
    }

    fn queue(&mut self, entry: u128, cone: Cone) {
        let index = match self.taut.unused.pop() {
            Some(index) => {
                self.taut.cones[index as usize] = cone;
                index
            }
            None => {
                self.taut.cones.push(cone);
                self.taut.cones.len() as u32 - 1
            }
        };
        self.taut.open.push(Reverse(entry | u128::from(index)));
    }

    /// Expands cones until the goal is the least; whether it was.
    fn is_reached(&mut self) -> bool {
        loop {
            let top = self.taut.open.peek().map(|&Reverse(entry)| entry);
            let cone = match (self.held.take(), top) {
                (Some((entry, cone)), top) if top.is_none_or(|top| entry <= top) => cone,
                (held, Some(_)) => {
                    let Some(Reverse(entry)) = self.taut.open.pop() else { return false };
                    let index = entry as u32;
                    if index == GOAL {
                        return true;
                    }
                    let cone = self.taut.cones[index as usize];
                    self.taut.unused.push(index);
                    if let Some((entry, cone)) = held {
                        self.queue(entry, cone);
                    }
                    cone
                }
                (_, None) => return false,
            };
            // A shorter way to its root has been found since.
            if cone.g > self.taut.known[cone.root as usize].0 {
                continue;
            }
            self.taut.expanded += 1;
            if let Some(side) = cone.walk {
                self.walk(&cone, side);
            }
            self.sweep(cone);
        }
    }

    /// The root of a cone sees the goal.
    pub(super) fn arrive(&mut self, cone: &Cone) {
        let g = cone.g + self.goal.distance(cone.root_at);
        if self.reaches(self.goal_vertex, g, cone.root) {
            self.least = g;
            let Reverse(entry) = key(g, 0.0, 0);
            self.taut.open.push(Reverse(entry | u128::from(GOAL)));
        }
    }
}
