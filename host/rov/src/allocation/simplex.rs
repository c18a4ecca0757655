//! Linear programs of allocation, by the simplex method with bounded variables.
//!
//! ```text
//! first   maximise s           subject to   Σ qⱼ xⱼ − b s = 0,   0 ≤ xⱼ ≤ wⱼ,   0 ≤ s ≤ 1
//! then    minimise Σ cⱼ xⱼ     with s held, where pieces of a convex law are given
//! ```
//!
//! A thruster is two columns of Q, forward and reverse, cut into the pieces of its law; dearer pieces fill after
//! cheaper ones by themselves, since the law is convex. Six artificial columns, bound to zero, are the first basis, so
//! that rest is where the search begins. What would change s keeps its bound in the second program: all with a reduced
//! cost in the first. Prices go by the largest gain, after a run of steps without progress by the lowest index (Bland),
//! which cannot cycle.

use nalgebra::{Matrix6, Matrix6xX, Vector6};

use super::super::power::Piece;

const PRICE_TOLERANCE: f64 = 1e-10;
const PIVOT_TOLERANCE: f64 = 1e-9;
const STALLS_MAX: usize = 30;
const PIVOTS_MAX: usize = 20_000;

/// What the programs found.
pub(super) struct Found {
    /// Greatest share of the demand.
    pub served: f64,
    /// Thrusts that serve it, N.
    pub thrusts_n: Vec<f64>,
    /// Thrusters that stand at this limit in every solution.
    pub pinned: Vec<bool>,
}

struct Variable {
    column: Vector6<f64>,
    width: f64,
    /// Bound of a variable outside the basis at which it stands.
    at_upper: bool,
    /// Whether it keeps that bound.
    held: bool,
}

impl Variable {
    fn new(column: Vector6<f64>, width: f64) -> Self {
        Self { column, width, at_upper: false, held: width <= 0.0 }
    }
}

struct Tableau {
    variables: Vec<Variable>,
    basis: [usize; 6],
    values: Vector6<f64>,
}

/// Solves both programs; nothing if the pivots run out.
pub(super) fn solve(
    rows: &Matrix6xX<f64>,
    target: &Vector6<f64>,
    limits_n: &[(f64, f64)],
    pieces: &[Piece],
) -> Option<Found> {
    let size = target.norm();
    let mut variables = Vec::new();
    let mut costs = Vec::new();
    let mut owner = Vec::new();
    for k in 0..6 {
        variables.push(Variable::new(Vector6::ith(k, 1.0), 0.0));
    }
    // b of length one, so that s is of the size of a thrust.
    variables.push(Variable::new(-target / size, size));
    costs.resize(variables.len(), 0.0);
    let share = variables.len() - 1;
    for (k, (column, &(low, high))) in rows.column_iter().zip(limits_n).enumerate() {
        for (sign, room) in [(1.0, high), (-1.0, -low)] {
            let mut left = room;
            let own = pieces.iter().filter(|piece| piece.forward == (sign > 0.0));
            let mut own: Vec<(f64, f64)> = own.map(|piece| (piece.width_n, piece.slope_w_n)).collect();
            own.sort_by(|a, b| a.1.total_cmp(&b.1));
            // Room beyond the law's end goes on at its last slope.
            own.push((f64::INFINITY, own.last().map_or(0.0, |last| last.1)));
            for (width, slope) in own {
                let width = width.min(left);
                if width > 0.0 {
                    variables.push(Variable::new(column * sign, width));
                    costs.push(slope);
                    owner.push((k, sign));
                }
                left -= width;
            }
        }
    }
    let mut tableau = Tableau { variables, basis: [0, 1, 2, 3, 4, 5], values: Vector6::zeros() };
    let mut gain = vec![0.0; tableau.variables.len()];
    gain[share] = -1.0;
    let prices = tableau.minimise(&gain)?;
    let mut served = tableau.value(share) / size;
    if served > 1.0 - 1e-12 {
        served = 1.0;
    }
    let pinned =
        rows.column_iter().map(|column| prices.dot(&column).abs() > PRICE_TOLERANCE * 10.0).collect();
    if !pieces.is_empty() {
        tableau.hold(&gain, &prices);
        tableau.minimise(&costs)?;
    }
    let mut thrusts_n = vec![0.0; limits_n.len()];
    for (index, (thruster, sign)) in owner.into_iter().enumerate() {
        thrusts_n[thruster] += sign * tableau.value(share + 1 + index);
    }
    for (u, (low, high)) in thrusts_n.iter_mut().zip(limits_n) {
        *u = u.clamp(*low, *high);
    }
    Some(Found { served, thrusts_n, pinned })
}

impl Tableau {
    fn value(&self, index: usize) -> f64 {
        match self.basis.iter().position(|&basic| basic == index) {
            Some(row) => self.values[row],
            None if self.variables[index].at_upper => self.variables[index].width,
            None => 0.0,
        }
    }

    /// From here on `costs` stay at their least: who would change them keeps its bound.
    fn hold(&mut self, costs: &[f64], prices: &Vector6<f64>) {
        for (index, variable) in self.variables.iter_mut().enumerate() {
            let reduced = costs[index] - prices.dot(&variable.column);
            variable.held |= !self.basis.contains(&index) && reduced.abs() > PRICE_TOLERANCE;
        }
    }

    /// Minimises Σ cost · x from the present basis; the prices of the rows at the end.
    fn minimise(&mut self, costs: &[f64]) -> Option<Vector6<f64>> {
        let mut stalls = 0;
        for _ in 0..PIVOTS_MAX {
            let basis = Matrix6::from_columns(&self.basis.map(|index| self.variables[index].column));
            let lu = basis.lu();
            // Values anew from the bounds, so that rounding does not add up.
            let mut load = Vector6::zeros();
            for (index, variable) in self.variables.iter().enumerate() {
                if variable.at_upper && !self.basis.contains(&index) {
                    load -= variable.column * variable.width;
                }
            }
            self.values = lu.solve(&load)?;
            // B' π = c_B
            let basic_costs = Vector6::from(self.basis.map(|index| costs[index]));
            let prices = basis.transpose().lu().solve(&basic_costs)?;
            let Some((entering, direction)) = self.enter(costs, &prices, stalls > STALLS_MAX) else {
                return Some(prices);
            };
            let change = lu.solve(&self.variables[entering].column)? * direction;
            let (length, leaving) = self.leave(entering, &change);
            stalls = if length > 0.0 { 0 } else { stalls + 1 };
            match leaving {
                None => self.variables[entering].at_upper = direction > 0.0,
                Some(row) => {
                    // Falling basic variables leave at zero, rising ones at their width.
                    self.variables[self.basis[row]].at_upper = change[row] < 0.0;
                    self.basis[row] = entering;
                }
            }
        }
        None
    }

    /// The variable to move and which way.
    fn enter(&self, costs: &[f64], prices: &Vector6<f64>, first: bool) -> Option<(usize, f64)> {
        let mut best: Option<(usize, f64, f64)> = None;
        for (index, variable) in self.variables.iter().enumerate() {
            if variable.held || self.basis.contains(&index) {
                continue;
            }
            let direction = if variable.at_upper { -1.0 } else { 1.0 };
            let gain = -direction * (costs[index] - prices.dot(&variable.column));
            if gain > PRICE_TOLERANCE && best.is_none_or(|(_, _, most)| gain > most) {
                best = Some((index, direction, gain));
                if first {
                    break;
                }
            }
        }
        best.map(|(index, direction, _)| (index, direction))
    }

    /// How far the entering variable may go, and the row that stops it unless it meets its own other bound.
    fn leave(&self, entering: usize, change: &Vector6<f64>) -> (f64, Option<usize>) {
        let mut length = self.variables[entering].width;
        let mut leaving: Option<usize> = None;
        for row in 0..6 {
            let width = self.variables[self.basis[row]].width;
            let room = if change[row] > PIVOT_TOLERANCE {
                self.values[row].max(0.0) / change[row]
            } else if change[row] < -PIVOT_TOLERANCE {
                (width - self.values[row]).max(0.0) / -change[row]
            } else {
                continue;
            };
            // Of equal rooms the larger pivot.
            let tie = (room - length).abs() <= 1e-12
                && leaving.is_some_and(|other| change[row].abs() > change[other].abs());
            if room < length - 1e-12 || tie {
                length = length.min(room);
                leaving = Some(row);
            }
        }
        (length, leaving)
    }
}
