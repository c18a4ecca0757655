//! The cheapest assignment of rows to columns: Kuhn's method with potentials, shortest augmenting paths (Jonker and
//! Volgenant 1987), O(n³).
//!
//! ```text
//! minimise Σ c[i][m(i)] over injections m;   c̄[i][j] = c[i][j] − u[i] − v[j] ≥ 0, zero where m(i) = j
//! least with m(i) = j:  z + c̄[i][j] + (shortest way in c̄ from the row that had j to column m(i))
//! ```

use super::MOST;

/// Costs, rows by columns; infinite where a pair is not allowed. Rows above the number of robots are free.
pub type Costs = [[f64; MOST]; MOST];

/// An optimal assignment with its potentials.
#[derive(Clone, Debug)]
pub struct Assignment {
    /// Its sum.
    pub cost: f64,
    /// Column of each row.
    pub column: [usize; MOST],
    row: [usize; MOST],
    reduced: Costs,
    size: usize,
    potentials: [[f64; MOST]; 2],
}

impl Assignment {
    /// Of the first `rows` rows to the first `columns` columns, not fewer; `None` if there is none.
    #[must_use]
    pub fn new(costs: &Costs, rows: usize, columns: usize) -> Option<Self> {
        const NONE: usize = usize::MAX;
        let size = columns;
        let cost = |row: usize, column: usize| if row < rows { costs[row][column] } else { 0.0 };
        let (mut u, mut v) = ([0.0; MOST], [0.0; MOST]);
        let mut row_of = [NONE; MOST];
        for first in 0..size {
            // Dijkstra over columns, from the row that has none yet.
            let (mut least, mut came) = ([f64::INFINITY; MOST], [NONE; MOST]);
            let mut done = [false; MOST];
            let (mut row, mut last) = (first, NONE);
            loop {
                let (mut delta, mut next) = (f64::INFINITY, NONE);
                for column in 0..size {
                    if done[column] {
                        continue;
                    }
                    let way = cost(row, column) - u[row] - v[column];
                    if way < least[column] {
                        (least[column], came[column]) = (way, last);
                    }
                    if least[column] < delta {
                        (delta, next) = (least[column], column);
                    }
                }
                if next == NONE {
                    return None;
                }
                u[first] += delta;
                for column in 0..size {
                    if done[column] {
                        u[row_of[column]] += delta;
                        v[column] -= delta;
                    } else {
                        least[column] -= delta;
                    }
                }
                (last, done[next]) = (next, true);
                if row_of[next] == NONE {
                    break;
                }
                row = row_of[next];
            }
            while last != NONE {
                let before = came[last];
                row_of[last] = if before == NONE { first } else { row_of[before] };
                last = before;
            }
        }
        let (mut column, mut reduced) = ([0; MOST], [[0.0; MOST]; MOST]);
        for (k, &row) in row_of[..size].iter().enumerate() {
            column[row] = k;
        }
        for row in 0..size {
            for k in 0..size {
                reduced[row][k] = (cost(row, k) - u[row] - v[k]).max(0.0);
            }
        }
        let total = (0..rows).map(|row| costs[row][column[row]]).sum();
        Some(Self { cost: total, column, row: row_of, reduced, size, potentials: [u, v] })
    }

    /// u and v: no pair costs less than the sum of its two, and all of them together are the cost.
    #[must_use]
    pub const fn potentials(&self) -> [[f64; MOST]; 2] {
        self.potentials
    }

    /// The least sum with row i in column j, for all i and j; infinite where there is none.
    #[must_use]
    pub fn forced(&self) -> Costs {
        let n = self.size;
        // From row to row, by taking the other's column.
        let mut way = [[f64::INFINITY; MOST]; MOST];
        for (i, row) in way.iter_mut().enumerate().take(n) {
            for (k, cost) in row.iter_mut().enumerate().take(n) {
                *cost = if i == k { 0.0 } else { self.reduced[i][self.column[k]] };
            }
        }
        for middle in 0..n {
            let onwards = way[middle];
            for row in way.iter_mut().take(n) {
                let first = row[middle];
                for (cost, next) in row.iter_mut().zip(onwards).take(n) {
                    *cost = cost.min(first + next);
                }
            }
        }
        let mut forced = [[f64::INFINITY; MOST]; MOST];
        for (i, row) in forced.iter_mut().enumerate().take(n) {
            for (j, cost) in row.iter_mut().enumerate().take(n) {
                *cost = self.cost + self.reduced[i][j] + way[self.row[j]][i];
            }
        }
        forced
    }
}
