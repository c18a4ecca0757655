//! The shape of a fleet of docked Modboats: which lattice cells are occupied.
//!
//! Cell `[col, row]` has its centre at (col, row)·pitch minus the mean over all modules, in the structure frame S
//! (x sway, y surge). Modules dock face to face, so that a structure is connected over cells that share a side.
//!
//! | symbol | unit | meaning |
//! |---|---|---|
//! | r | m | distance of a module's centre from the centre of mass |
//! | M, I | kg, kg·m² | mass and moment of inertia about the vertical axis through the centre of mass |
//! | C_R | N·m·s² | rotational drag, τ = C_R·Ω·abs(Ω) as in (15) |
//!
//! Assumptions: all modules are alike, so that the centre of mass is the mean of the cell centres.
//! Limits: 1 to 1024 modules, coordinates within ±10 000.

use std::collections::{HashMap, HashSet};

use thiserror::Error;

use super::parameters::Parameters;

/// Most modules one structure may have.
pub const MODULES_MAX: usize = 1024;
/// Greatest absolute cell coordinate.
pub const COORDINATE_MAX: i32 = 10_000;

/// A shape that no structure can have.
#[derive(Clone, Debug, Error, PartialEq, Eq)]
#[expect(missing_docs, reason = "the messages say what the fields are")]
pub enum StructureError {
    /// No cell is occupied.
    #[error("a structure needs at least one module; none was given")]
    NoModules,
    /// More modules than [`MODULES_MAX`].
    #[error("{count} modules are too many: the limit is {MODULES_MAX}")]
    TooMany { count: u64 },
    /// Two modules in one cell.
    #[error("cell [{}, {}] is given twice, as module {} and as module {}", cell[0], cell[1], first + 1, second + 1)]
    DuplicateCell { cell: [i32; 2], first: usize, second: usize },
    /// A coordinate beyond ±[`COORDINATE_MAX`].
    #[error("cell [{}, {}] (module {}) lies outside ±{COORDINATE_MAX}", cell[0], cell[1], index + 1)]
    OutOfRange { cell: [i32; 2], index: usize },
    /// The cells fall into pieces that share no side.
    #[error(
        "the structure is in pieces: no chain of docked sides joins cell [{}, {}] to cell [{}, {}]",
        one[0], one[1], other[0], other[1]
    )]
    Disconnected { one: [i32; 2], other: [i32; 2] },
    /// A character in a picture that is neither module nor water.
    #[error("line {line}, column {column}: {character:?} is neither '#' (module) nor '.' or ' ' (water)")]
    UnknownCharacter { line: usize, column: usize, character: char },
    /// A word that is not columns × rows.
    #[error("{word:?} is not a size such as \"3x1\" (columns x rows, whole numbers)")]
    BadWord { word: String },
}

/// A connected set of lattice cells, one module in each, in the order in which they were given.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Structure {
    cells: Vec<[i32; 2]>,
    index: HashMap<[i32; 2], usize>,
}

impl Structure {
    /// From cells `[col, row]`; module i sits in the i-th.
    ///
    /// # Errors
    /// [`StructureError`] for no or too many cells, coordinates out of range, duplicates, and separate pieces.
    pub fn from_cells(cells: &[[i32; 2]]) -> Result<Self, StructureError> {
        if cells.is_empty() {
            return Err(StructureError::NoModules);
        }
        if cells.len() > MODULES_MAX {
            return Err(StructureError::TooMany { count: cells.len() as u64 });
        }
        let mut index = HashMap::with_capacity(cells.len());
        for (second, &cell) in cells.iter().enumerate() {
            if cell.iter().any(|c| c.unsigned_abs() > COORDINATE_MAX.unsigned_abs()) {
                return Err(StructureError::OutOfRange { cell, index: second });
            }
            if let Some(first) = index.insert(cell, second) {
                return Err(StructureError::DuplicateCell { cell, first, second });
            }
        }
        let structure = Self { cells: cells.to_vec(), index };
        match structure.cell_apart() {
            Some(other) => Err(StructureError::Disconnected { one: cells[0], other }),
            None => Ok(structure),
        }
    }

    /// From a word such as `3x1`: columns × rows, also with `X` or `×`. Modules row by row from row 0, columns
    /// ascending.
    ///
    /// # Errors
    /// [`StructureError::BadWord`], [`StructureError::NoModules`] or [`StructureError::TooMany`].
    pub fn from_word(word: &str) -> Result<Self, StructureError> {
        let bad = || StructureError::BadWord { word: word.to_owned() };
        let (columns, rows) = word.trim().split_once(['x', 'X', '×']).ok_or_else(bad)?;
        let count = |text: &str| text.trim().parse::<u32>().map_err(|_| bad());
        let (columns, rows) = (count(columns)?, count(rows)?);
        let modules = u64::from(columns) * u64::from(rows);
        if modules > MODULES_MAX as u64 {
            return Err(StructureError::TooMany { count: modules });
        }
        let cells: Vec<_> =
            (0..rows).flat_map(|row| (0..columns).map(move |col| [col as i32, row as i32])).collect();
        Self::from_cells(&cells)
    }

    /// From a picture: `#` module, `.` or space water, the top line the highest row. Modules row by row from the
    /// lowest, columns ascending; the lowest row and the leftmost column that hold a module get the number 0.
    ///
    /// # Errors
    /// [`StructureError::UnknownCharacter`] with line and column, and those of [`Structure::from_cells`].
    pub fn from_picture(picture: &str) -> Result<Self, StructureError> {
        let mut seen = Vec::new();
        for (line, text) in picture.lines().enumerate() {
            for (column, character) in text.chars().enumerate() {
                match character {
                    '#' => seen.push([column, line]),
                    '.' | ' ' => {}
                    _ => {
                        let (line, column) = (line + 1, column + 1);
                        return Err(StructureError::UnknownCharacter { line, column, character });
                    }
                }
            }
        }
        if seen.len() > MODULES_MAX {
            return Err(StructureError::TooMany { count: seen.len() as u64 });
        }
        let left = seen.iter().map(|s| s[0]).min().unwrap_or(0);
        let bottom = seen.iter().map(|s| s[1]).max().unwrap_or(0);
        // A picture too wide for i32 is beyond COORDINATE_MAX and refused as such.
        let number = |n: usize| i32::try_from(n).unwrap_or(i32::MAX);
        let mut cells: Vec<_> =
            seen.iter().map(|&[column, line]| [number(column - left), number(bottom - line)]).collect();
        cells.sort_unstable_by_key(|&[col, row]| (row, col));
        Self::from_cells(&cells)
    }

    /// Number of modules, at least 1.
    #[must_use]
    #[expect(clippy::len_without_is_empty, reason = "a structure is never empty")]
    pub fn len(&self) -> usize {
        self.cells.len()
    }

    /// The cells `[col, row]` by module.
    #[must_use]
    pub fn cells(&self) -> &[[i32; 2]] {
        &self.cells
    }

    /// The module centres in S, m, by module: (col, row)·pitch minus the mean.
    #[must_use]
    pub fn positions_m(&self, pitch_m: f64) -> Vec<[f64; 2]> {
        let n = self.cells.len() as f64;
        let mean = [0, 1].map(|axis| self.cells.iter().map(|cell| f64::from(cell[axis])).sum::<f64>() / n);
        let position = |cell: &[i32; 2]| [0, 1].map(|axis| (f64::from(cell[axis]) - mean[axis]) * pitch_m);
        self.cells.iter().map(position).collect()
    }

    /// All pairs (i, j) of modules with cell_j = cell_i + offset, i ascending.
    pub fn neighbours(&self, offset: [i32; 2]) -> impl Iterator<Item = (usize, usize)> + '_ {
        self.cells.iter().enumerate().filter_map(move |(i, &[col, row])| {
            let cell = [col.checked_add(offset[0])?, row.checked_add(offset[1])?];
            self.index.get(&cell).map(|&j| (i, j))
        })
    }

    /// Mass M of the structure, kg.
    #[must_use]
    pub fn mass_kg(&self, parameters: &Parameters) -> f64 {
        self.cells.len() as f64 * parameters.module_mass_kg
    }

    /// Moment of inertia about the vertical axis through the centre of mass, kg·m², by the parallel axis theorem:
    ///
    /// I = Σ (I₁ + m·r²)
    #[must_use]
    pub fn inertia_kg_m2(&self, parameters: &Parameters) -> f64 {
        self.radii_m(parameters)
            .map(|r_m| parameters.module_inertia_kg_m2 + parameters.module_mass_kg * r_m.powi(2))
            .sum()
    }

    /// Rotational drag C_R of (15), N·m·s². The paper takes it from a measurement; this is a strip sum: a module at
    /// distance r moves through the water at Ω·r, drags with C_L·(Ω·r)² on a lever r, and turns about itself:
    ///
    /// C_R = Σ (C_L·r³ + C_R,own)
    ///
    /// It takes every module to meet undisturbed water, as if the others were not there.
    #[must_use]
    pub fn yaw_drag_n_m_s2(&self, parameters: &Parameters) -> f64 {
        self.radii_m(parameters)
            .map(|r_m| parameters.drag_n_s2_m2 * r_m.powi(3) + parameters.yaw_drag_n_m_s2)
            .sum()
    }

    /// A cell that no chain of docked sides joins to the first.
    fn cell_apart(&self) -> Option<[i32; 2]> {
        let mut joined = HashSet::from([self.cells[0]]);
        let mut open = vec![self.cells[0]];
        while let Some([col, row]) = open.pop() {
            for cell in [[col + 1, row], [col - 1, row], [col, row + 1], [col, row - 1]] {
                if self.index.contains_key(&cell) && joined.insert(cell) {
                    open.push(cell);
                }
            }
        }
        self.cells.iter().find(|&cell| !joined.contains(cell)).copied()
    }

    /// Distances of the modules from the centre of mass, m.
    fn radii_m(&self, parameters: &Parameters) -> impl Iterator<Item = f64> {
        self.positions_m(parameters.pitch_m).into_iter().map(|[x_m, y_m]| x_m.hypot(y_m))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn words_and_pictures_order_their_modules_as_documented() {
        let word = Structure::from_word("3x2").unwrap();
        assert_eq!(word.cells(), [[0, 0], [1, 0], [2, 0], [0, 1], [1, 1], [2, 1]]);
        assert_eq!(Structure::from_word(" 3 × 2 ").unwrap(), word);
        assert_eq!(Structure::from_word("3X2").unwrap(), word);
        let picture = Structure::from_picture("\n ##.\r\n .##\n\n").unwrap();
        assert_eq!(picture.cells(), [[1, 0], [2, 0], [0, 1], [1, 1]]);
    }

    #[test]
    fn positions_sum_to_zero_and_keep_the_pitch() {
        let positions = Structure::from_cells(&[[7, -3], [8, -3], [8, -2]]).unwrap().positions_m(0.3);
        for axis in [0, 1] {
            assert!(positions.iter().map(|p| p[axis]).sum::<f64>().abs() < 1e-12);
        }
        assert!((positions[1][0] - positions[0][0] - 0.3).abs() < 1e-12);
        assert!((positions[2][1] - positions[1][1] - 0.3).abs() < 1e-12);
    }

    #[test]
    fn neighbours_are_found_in_every_direction() {
        let square = Structure::from_word("2x2").unwrap();
        assert_eq!(square.neighbours([1, 0]).collect::<Vec<_>>(), [(0, 1), (2, 3)]);
        assert_eq!(square.neighbours([0, 1]).collect::<Vec<_>>(), [(0, 2), (1, 3)]);
        assert_eq!(square.neighbours([1, 1]).collect::<Vec<_>>(), [(0, 3)]);
        assert_eq!(square.neighbours([1, -1]).collect::<Vec<_>>(), [(2, 1)]);
        assert_eq!(square.neighbours([i32::MAX, 0]).count(), 0);
    }

    /// Three modules in line, worked by hand: I = 3·0.003 + 2·1·0.15², C_R = 3·5e-4 + 2·4.5·0.15³.
    #[test]
    fn inertia_and_yaw_drag_of_three_in_line() {
        let (line, parameters) = (Structure::from_word("3x1").unwrap(), Parameters::default());
        assert!((line.mass_kg(&parameters) - 3.0).abs() < 1e-12);
        assert!((line.inertia_kg_m2(&parameters) - 0.054).abs() < 1e-12);
        assert!((line.yaw_drag_n_m_s2(&parameters) - 0.031_875).abs() < 1e-12);
    }

    #[test]
    fn what_is_no_structure_is_refused_by_name() {
        assert_eq!(Structure::from_cells(&[]), Err(StructureError::NoModules));
        assert_eq!(Structure::from_picture("...\n"), Err(StructureError::NoModules));
        assert_eq!(Structure::from_word("0x3"), Err(StructureError::NoModules));
        let duplicate = StructureError::DuplicateCell { cell: [1, 0], first: 1, second: 2 };
        assert_eq!(Structure::from_cells(&[[0, 0], [1, 0], [1, 0]]), Err(duplicate));
        let apart = StructureError::Disconnected { one: [0, 0], other: [1, 1] };
        assert_eq!(Structure::from_cells(&[[0, 0], [1, 1]]), Err(apart));
        let unknown = StructureError::UnknownCharacter { line: 2, column: 3, character: 'o' };
        assert_eq!(Structure::from_picture("##.\n.#o"), Err(unknown.clone()));
        assert!(unknown.to_string().starts_with("line 2, column 3: 'o'"), "{unknown}");
        for word in ["", "3", "x", "3x", "ax2", "3x-1", "3x1x1", "1.5x2", "99999999999x1"] {
            let bad = StructureError::BadWord { word: word.to_owned() };
            assert_eq!(Structure::from_word(word), Err(bad), "{word}");
        }
        assert_eq!(Structure::from_word("33x32"), Err(StructureError::TooMany { count: 1056 }));
        assert!(Structure::from_word("4294967295x4294967295").is_err());
        let far = StructureError::OutOfRange { cell: [10_001, 0], index: 0 };
        assert_eq!(Structure::from_cells(&[[10_001, 0]]), Err(far));
        assert!(Structure::from_cells(&[[i32::MIN, 0]]).is_err());
        assert_eq!(Structure::from_word("32x32").unwrap().len(), 1024);
    }
}
