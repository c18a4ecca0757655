//! What a campaign shows: figures over the runs that differ in their seed alone, with 95 % intervals, and pictures of them.
//!
//! Runs are put together that agree in scenario, controller, planner and the keys on a grid. A figure is a column of the rows, or
//! `passed`: the share of runs that did what was asked.

use std::collections::HashMap;
use std::fmt::Write;
use std::path::{Path, PathBuf};

use plot::PlotError;
use plot::campaign::{Panel, Point, Series};
use serde::Serialize;

use crate::cell::Cell;
use crate::folder::Folder;
use crate::statistics::{Estimate, estimate};
use crate::table::Table;

/// The share of runs without `error` and `failure`.
const PASSED: &str = "passed";
/// What is reported where nothing is asked for, of those that there are.
const FIGURES: [&str; 9] = [
    PASSED,
    "legs.0.velocity_error",
    "legs.0.heading_rms_rad",
    "legs.0.station.rms_m",
    "least_clearance_m",
    "cycles.mean_error",
    "cycles.without_transition_share",
    "cycles.loss_tolerant_share",
    "contacts.count",
];
/// Columns by which runs are told apart, beside the keys on a grid.
const FACTORS: [&str; 3] = ["scenario", "controller", "planner"];

/// Runs that differ in their seed, and in what is sampled, alone.
#[derive(Debug, Serialize)]
pub struct Group {
    /// Of each factor, its value.
    pub of: Vec<String>,
    /// The figure, if a run has it.
    #[serde(flatten)]
    pub estimate: Option<Estimate>,
    #[serde(skip)]
    rows: Vec<usize>,
}

/// One figure over all groups.
#[derive(Debug, Serialize)]
pub struct Figure {
    /// Its column.
    pub figure: String,
    /// In the order of the runs.
    pub groups: Vec<Group>,
}

/// See the module's documentation.
#[derive(Debug, Serialize)]
pub struct Report {
    /// The campaign's name.
    pub campaign: String,
    /// Runs.
    pub runs: usize,
    /// What tells groups apart.
    pub factors: Vec<String>,
    /// Figures.
    pub figures: Vec<Figure>,
    #[serde(skip)]
    sampled: Vec<String>,
    #[serde(skip)]
    table: Table,
}

impl Report {
    /// Of all rows of a campaign.
    ///
    /// # Errors
    /// A figure of `wanted` that is no column of numbers.
    pub fn new(folder: &Folder, table: Table, wanted: &[String]) -> Result<Self, String> {
        let grid = folder.manifest.grid.iter().flat_map(|key| columns_of(&table, key));
        let factors: Vec<String> = FACTORS.map(str::to_owned).into_iter().chain(grid).collect();
        let values = |name: &String| -> Vec<String> {
            let Some(at) = table.column(name) else { return Vec::new() };
            table.rows.iter().map(|row| row[at].shown()).collect()
        };
        // What is the same in all runs tells nothing apart.
        let columns: Vec<(String, Vec<String>)> =
            factors.into_iter().map(|name| (name.clone(), values(&name))).collect();
        let columns: Vec<_> = columns
            .into_iter()
            .filter(|(_, values)| values.iter().any(|value| *value != values[0]))
            .collect();
        let mut groups: Vec<(Vec<String>, Vec<usize>)> = Vec::new();
        let mut known: HashMap<Vec<String>, usize> = HashMap::new();
        for row in 0..table.rows.len() {
            let of: Vec<String> = columns.iter().map(|(_, values)| values[row].clone()).collect();
            let index = *known.entry(of.clone()).or_insert_with(|| {
                groups.push((of, Vec::new()));
                groups.len() - 1
            });
            groups[index].1.push(row);
        }
        let names: Vec<String> = if wanted.is_empty() {
            FIGURES
                .iter()
                .filter(|name| numbers(&table, name).is_some())
                .map(|name| (*name).to_owned())
                .collect()
        } else {
            wanted.to_vec()
        };
        let mut figures = Vec::with_capacity(names.len());
        for figure in names {
            let (numbers, is_share) = numbers(&table, &figure).ok_or_else(|| {
                format!(
                    "--figures: {figure} is no column of numbers; there are {}",
                    columns_of_numbers(&table)
                )
            })?;
            let group = |(of, rows): &(Vec<String>, Vec<usize>)| {
                let values: Vec<f64> = rows.iter().filter_map(|&row| numbers[row]).collect();
                Group { of: of.clone(), estimate: estimate(&values, is_share), rows: rows.clone() }
            };
            figures.push(Figure { groups: groups.iter().map(group).collect(), figure });
        }
        let factors = columns.into_iter().map(|(name, _)| name).collect();
        let sampled = folder.manifest.sampled.iter().flat_map(|key| columns_of(&table, key)).collect();
        let (campaign, runs) = (folder.manifest.campaign.clone(), table.rows.len());
        Ok(Self { campaign, runs, factors, figures, sampled, table })
    }

    /// As tables for a terminal.
    #[must_use]
    pub fn text(&self) -> String {
        let mut text =
            format!("{}: {} runs; means and shares with 95 % intervals\n", self.campaign, self.runs);
        for Figure { figure, groups } in &self.figures {
            let mut lines: Vec<Vec<String>> = vec![self.factors.clone()];
            lines[0].extend([figure.as_str(), "from", "to", "least", "greatest", "runs"].map(str::to_owned));
            for group in groups {
                let mut line = group.of.clone();
                line.extend(match &group.estimate {
                    Some(found) => {
                        let [low, high] =
                            [found.low, found.high].map(|end| end.map_or("–".to_owned(), shown));
                        [
                            shown(found.mean),
                            low,
                            high,
                            shown(found.least),
                            shown(found.greatest),
                            found.count.to_string(),
                        ]
                    }
                    None => ["–", "–", "–", "–", "–", "0"].map(str::to_owned),
                });
                lines.push(line);
            }
            let width =
                |column: usize| lines.iter().map(|line| line[column].chars().count()).max().unwrap_or(0);
            let widths: Vec<usize> = (0..lines[0].len()).map(width).collect();
            text.push('\n');
            for line in &lines {
                let cells = line.iter().enumerate().map(|(column, cell)| {
                    let width = widths[column];
                    if column < self.factors.len() {
                        format!("  {cell:<width$}")
                    } else {
                        format!("  {cell:>width$}")
                    }
                });
                // Writing to a String cannot fail.
                let _ = writeln!(text, "{}", cells.collect::<String>().trim_end());
            }
        }
        text
    }

    /// Writes a picture of each figure into `folder`; what became of each.
    pub fn pictures(&self, folder: &Path) -> Vec<Result<PathBuf, PlotError>> {
        let pictures = self.figures.iter().map(|figure| {
            let name = format!("report-{}.svg", figure.figure.replace('.', "-"));
            (name, plot::campaign::svg(&self.campaign, &figure.figure, &self.panels(figure)))
        });
        plot::campaign::write(pictures, folder)
    }

    /// A panel for each key that is sampled; else one over the first factor that is a number, or over the groups.
    fn panels(&self, figure: &Figure) -> Vec<Panel> {
        if !self.sampled.is_empty() {
            return self.sampled.iter().map(|key| self.cloud(figure, key)).collect();
        }
        let is_number =
            |column: usize| figure.groups.iter().all(|group| group.of[column].parse::<f64>().is_ok());
        let over = (0..self.factors.len()).find(|&column| is_number(column));
        let mut series: Vec<Series> = Vec::new();
        for (index, group) in figure.groups.iter().enumerate() {
            let others = group.of.iter().enumerate().filter(|(column, _)| Some(*column) != over);
            let name = others.map(|(_, value)| value.as_str()).collect::<Vec<_>>().join(", ");
            let x = over.and_then(|column| group.of[column].parse().ok()).unwrap_or(index as f64);
            let point = group.estimate.as_ref().map(|found| Point {
                x,
                y: found.mean,
                low: found.low.unwrap_or(found.mean),
                high: found.high.unwrap_or(found.mean),
            });
            match series.iter_mut().find(|known| known.name == name) {
                Some(known) => known.points.extend(point),
                None => {
                    series.push(Series {
                        name,
                        points: point.into_iter().collect(),
                        is_line: over.is_some(),
                    });
                }
            }
        }
        let x_title = over.map_or("group", |column| self.factors[column].as_str()).to_owned();
        vec![Panel { x_title, series }]
    }

    /// Every run over a key that is sampled.
    fn cloud(&self, figure: &Figure, key: &str) -> Panel {
        let numbers = numbers(&self.table, &figure.figure).map(|found| found.0).unwrap_or_default();
        let x = self.table.column(key);
        let series = figure.groups.iter().map(|group| {
            let point = |&row: &usize| {
                let (x, y) = (self.table.rows[row][x?].number()?, numbers.get(row).copied().flatten()?);
                Some(Point { x, y, low: y, high: y })
            };
            let points = group.rows.iter().filter_map(point).collect();
            Series { name: group.of.join(", "), points, is_line: false }
        });
        Panel { x_title: key.to_owned(), series: series.collect() }
    }
}

/// The columns of a key: it, or its items.
fn columns_of(table: &Table, key: &str) -> Vec<String> {
    let is_of =
        |name: &&String| name.strip_prefix(key).is_some_and(|rest| rest.is_empty() || rest.starts_with('.'));
    table.columns.iter().filter(is_of).cloned().collect()
}

/// The numbers of a figure by row, and whether it is a share; `None` for what has none.
fn numbers(table: &Table, figure: &str) -> Option<(Vec<Option<f64>>, bool)> {
    if figure == PASSED {
        let [error, failure] = ["error", "failure"].map(|name| table.column(name));
        let is_null = |row: &Vec<Cell>, column: Option<usize>| column.is_none_or(|at| row[at] == Cell::Null);
        let passed = |row| Some(f64::from(u8::from(is_null(row, error) && is_null(row, failure))));
        return Some((table.rows.iter().map(passed).collect(), true));
    }
    let at = table.column(figure)?;
    let numbers: Vec<Option<f64>> = table.rows.iter().map(|row| row[at].number()).collect();
    let is_share = table.rows.iter().all(|row| matches!(row[at], Cell::Bool(_) | Cell::Null));
    numbers.iter().any(Option::is_some).then_some((numbers, is_share))
}

fn columns_of_numbers(table: &Table) -> String {
    let names = table.columns.iter().filter(|name| numbers(table, name).is_some() && name.as_str() != "run");
    names.cloned().chain([PASSED.to_owned()]).collect::<Vec<_>>().join(", ")
}

/// Four digits that count.
fn shown(value: f64) -> String {
    let size = if value == 0.0 { 0 } else { value.abs().log10().floor() as i32 };
    match size {
        -3..=5 => format!("{value:.*}", (3 - size).clamp(0, 6) as usize),
        _ => format!("{value:.3e}"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_have_four_digits() {
        for (value, told) in [
            (0.0, "0.000"),
            (0.0123456, "0.01235"),
            (12.3456, "12.35"),
            (123_456.7, "123457"),
            (-1.5e-7, "-1.500e-7"),
        ] {
            assert_eq!(shown(value), told);
        }
    }
}
