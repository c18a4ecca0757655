//! What is studied, from a TOML file: scenarios × controllers × planners × points × seeds, one run for each combination.
//!
//! Runs are numbered from 0, the seeds fastest, then the points, the planners, the controllers and the scenarios. A point is a combination
//! of the values in `[grid]` together with one point of `[sample]`. Keys count in alphabetical order, so that their order in the
//! file does not matter.

use std::cmp::Ordering;
use std::path::{Path, PathBuf};

use modboat::planner_kind::PlannerKind;
use reader::{Document, FileError, Mistake, file};
use serde::Deserialize;
use toml::Value;

use crate::sampling::Method;
use crate::work::fingerprint;
use axis::{Axis, Set, Setting};
pub use base::Base;
pub use run::Run;

mod axis;
mod base;
mod path;
mod run;

/// No campaign has more runs.
pub const RUNS_MAX: usize = 1_000_000;

/// A campaign.
#[derive(Debug)]
pub struct Study {
    /// The campaign file, for messages.
    pub file: String,
    /// Name, also of the output folder.
    pub name: String,
    /// One line.
    pub description: String,
    /// Whether rows hold what was measured of time on this machine: two campaigns that are otherwise equal differ there.
    pub times: bool,
    /// Keys that are sampled.
    pub sampled: Vec<String>,
    grid: Vec<(String, Axis)>,
    bases: Vec<Base>,
    controllers: Vec<Controller>,
    planners: Vec<Option<PlannerKind>>,
    /// The values of `sampled` at each point; one without any where nothing is sampled.
    samples: Vec<Vec<Value>>,
    seeds: Option<Vec<u64>>,
    text: String,
}

/// Keys set together, under a name.
#[derive(Clone, Debug, Default)]
struct Controller {
    name: Option<String>,
    settings: Vec<Setting>,
}

/// The file's own shape.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Tables {
    name: String,
    #[serde(default)]
    description: String,
    scenarios: Vec<String>,
    #[serde(default)]
    planners: Vec<PlannerKind>,
    seeds: Option<Seeds>,
    #[serde(default = "yes")]
    times: bool,
    #[serde(default)]
    grid: toml::Table,
    sample: Option<Sample>,
    #[serde(default, rename = "controller")]
    controllers: Vec<ControllerTable>,
}

const fn yes() -> bool {
    true
}

/// How many seeds from 1 on, which, or how many from which on.
#[derive(Deserialize)]
#[serde(untagged, expecting = "must be a number of seeds, a list of seeds, or { first, count }")]
enum Seeds {
    Count(u64),
    List(Vec<u64>),
    From { first: u64, count: u64 },
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Sample {
    #[serde(default)]
    method: Method,
    points: u64,
    #[serde(default = "one")]
    seed: u64,
    range: toml::Table,
}

const fn one() -> u64 {
    1
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct ControllerTable {
    name: String,
    #[serde(default)]
    set: toml::Table,
}

impl Study {
    /// Reads a campaign file.
    ///
    /// # Errors
    /// [`FileError`]: of the campaign's file, or of one of its scenarios.
    pub fn open(path: &Path) -> Result<Self, FileError> {
        let name = path.display().to_string();
        let source = file::open(&name, "campaign", &[])?;
        Self::parse(&name, &source.folder, &source.text)
    }

    /// Reads a campaign from `text`; `file` is its name in messages, `folder` where the names of scenario files begin.
    ///
    /// # Errors
    /// As for [`open`](Self::open).
    pub fn parse(file: &str, folder: &Path, text: &str) -> Result<Self, FileError> {
        let document = Document::toml(text).map_err(|mistake| mistake.in_file(file))?;
        let tables: Tables = document.read().map_err(|mistake| mistake.in_file(file))?;
        let mut bases = Vec::with_capacity(tables.scenarios.len());
        for name in &tables.scenarios {
            bases.push(Base::open(name, folder)?);
        }
        let study =
            Self::of(file, text, &document, tables, bases).map_err(|mistake| mistake.in_file(file))?;
        study.check_values(&document).map_err(|mistake| mistake.in_file(file))?;
        Ok(study)
    }

    fn of(
        file: &str,
        text: &str,
        document: &Document<'_>,
        tables: Tables,
        bases: Vec<Base>,
    ) -> Result<Self, Mistake> {
        if let Some(message) = unfit(&tables.name) {
            return Err(document.mistake(&["name"], message));
        }
        if bases.is_empty() {
            return Err(document.mistake(&["scenarios"], "scenarios: names at least one"));
        }
        let twice = |names: &[&str]| (1..names.len()).find(|&k| names[..k].contains(&names[k]));
        let names: Vec<&str> = bases.iter().map(|base| base.name()).collect();
        if let Some(k) = twice(&names) {
            let message = format!("scenarios: two of them bear the name {:?}", names[k]);
            return Err(document.mistake(&["scenarios", &k.to_string()], message));
        }
        let names: Vec<&str> = tables.planners.iter().map(|kind| kind.name()).collect();
        if let Some(k) = twice(&names) {
            let message = format!("planners: {:?} is named twice", names[k]);
            return Err(document.mistake(&["planners", &k.to_string()], message));
        }
        let names: Vec<&str> = tables.controllers.iter().map(|controller| controller.name.as_str()).collect();
        if let Some(k) = twice(&names) {
            let message = format!("[[controller]] {}: name = {:?} is taken", k + 1, names[k]);
            return Err(document.mistake(&["controller", &k.to_string(), "name"], message));
        }
        let mut controllers = Vec::with_capacity(tables.controllers.len().max(1));
        for (index, controller) in tables.controllers.iter().enumerate() {
            let place = ["controller", &index.to_string(), "set"];
            let settings = axis::settings(document, &place, &controller.set)?;
            controllers.push(Controller { name: Some(controller.name.clone()), settings });
        }
        if controllers.is_empty() {
            controllers.push(Controller::default());
        }
        let seeds = seeds(document, tables.seeds)?;
        let grid = axis::axes(document, &["grid"], &tables.grid)?;
        let (sampled, samples) = match &tables.sample {
            Some(sample) => sample_points(document, sample)?,
            None => (Vec::new(), vec![Vec::new()]),
        };
        let set = controllers.iter().flat_map(|controller| &controller.settings).map(|(key, _)| key);
        if let Some(key) = set.chain(&sampled).find(|key| grid.iter().any(|(known, _)| known == *key)) {
            return Err(document.mistake(&["grid", key], format!("[grid] {key}: is set elsewhere too")));
        }
        let planners: Vec<Option<PlannerKind>> = match tables.planners.as_slice() {
            [] => vec![None],
            some => some.iter().copied().map(Some).collect(),
        };
        let runs = [
            bases.len(),
            controllers.len(),
            planners.len(),
            seeds.as_ref().map_or(1, Vec::len),
            samples.len(),
        ];
        let runs = grid.iter().map(|(_, values)| values.len()).chain(runs);
        let runs = runs.fold(1_usize, usize::saturating_mul);
        if runs > RUNS_MAX {
            let message = format!("makes more than {RUNS_MAX} runs: fewer values, points or seeds");
            return Err(document.mistake(&["name"], message));
        }
        Ok(Self {
            file: file.to_owned(),
            name: tables.name,
            description: tables.description,
            times: tables.times,
            sampled,
            grid,
            bases,
            controllers,
            planners,
            samples,
            seeds,
            text: text.to_owned(),
        })
    }

    /// Keys of scenarios that are varied on a grid.
    pub fn on_grid(&self) -> impl Iterator<Item = &str> {
        self.grid.iter().map(|(key, _)| key.as_str())
    }

    fn points(&self) -> usize {
        self.grid.iter().map(|(_, values)| values.len()).product::<usize>() * self.samples.len()
    }

    fn seeds(&self) -> usize {
        self.seeds.as_ref().map_or(1, Vec::len)
    }

    /// How many runs there are.
    #[must_use]
    pub fn runs(&self) -> usize {
        self.bases.len() * self.controllers.len() * self.planners.len() * self.points() * self.seeds()
    }

    /// What the runs are made of, in words.
    #[must_use]
    pub fn told(&self) -> String {
        let parts = [
            (self.bases.len(), "scenario"),
            (self.controllers.len(), "controller"),
            (self.planners.len(), "planner"),
            (self.points(), "point"),
            (self.seeds(), "seed"),
        ];
        let plural =
            |(count, what): (usize, &str)| format!("{count} {what}{}", if count == 1 { "" } else { "s" });
        parts.map(plural).join(" × ")
    }

    /// Run `number`, from 0.
    #[must_use]
    pub fn run(&self, number: usize) -> Run<'_> {
        let (rest, seed) = (number / self.seeds(), number % self.seeds());
        let (rest, mut point) = (rest / self.points(), rest % self.points());
        let (rest, planner) = (rest / self.planners.len(), rest % self.planners.len());
        let (rest, controller) = (rest / self.controllers.len(), rest % self.controllers.len());
        let controller = &self.controllers[controller];
        let sample = &self.samples[point % self.samples.len()];
        point /= self.samples.len();
        let mut varied: Vec<Set<'_>> = Vec::with_capacity(self.grid.len() + sample.len());
        for (key, values) in self.grid.iter().rev() {
            varied.insert(0, (key, &values[point % values.len()]));
            point /= values.len();
        }
        varied.extend(self.sampled.iter().map(String::as_str).zip(sample));
        Run {
            number,
            base: &self.bases[rest % self.bases.len()],
            controller: controller.name.as_deref(),
            planner: self.planners[planner],
            seed: self.seeds.as_ref().map(|seeds| seeds[seed]),
            set: controller.settings.iter().map(|(key, value)| (key.as_str(), value)).collect(),
            varied,
        }
    }

    /// A number that is another for every other campaign: of its file, the text of its scenarios, and this program's version.
    #[must_use]
    pub fn fingerprint(&self) -> String {
        let scenarios = self.bases.iter().map(|base| base.text.as_ref());
        let parts = [env!("CARGO_PKG_VERSION"), &self.text].into_iter().chain(scenarios);
        fingerprint(parts.map(str::as_bytes))
    }

    /// Where results go when nothing else is said.
    #[must_use]
    pub fn folder(&self) -> PathBuf {
        Path::new("runs").join(format!("{}-campaign", self.name))
    }

    /// Refuses the first value that one of the scenarios cannot have, each taken alone.
    fn check_values(&self, document: &Document<'_>) -> Result<(), Mistake> {
        let controllers = self.controllers.iter().map(|controller| {
            controller.settings.iter().map(|(key, value)| (key.as_str(), value)).collect::<Vec<_>>()
        });
        let on_grid =
            self.grid.iter().flat_map(|(key, values)| values.iter().map(|value| (key.as_str(), value)));
        let sampled = self.sampled.iter().enumerate().flat_map(|(index, key)| {
            // Of a range, the points that are next to its ends.
            let values = || self.samples.iter().filter_map(|sample| sample.get(index));
            let order = |a: &&Value, b: &&Value| {
                axis::number(a).partial_cmp(&axis::number(b)).unwrap_or(Ordering::Equal)
            };
            [values().min_by(order), values().max_by(order)]
                .into_iter()
                .flatten()
                .map(|value| (key.as_str(), value))
        });
        let alone = on_grid.chain(sampled).map(|setting| vec![setting]);
        for settings in alone.chain(controllers).filter(|settings| !settings.is_empty()) {
            for base in &self.bases {
                if let Err(message) = base.with(&settings) {
                    return Err(self.mistake(document, &settings, base, &message));
                }
            }
        }
        Ok(())
    }

    /// A value that a scenario refuses, with its place in the campaign's file.
    fn mistake(&self, document: &Document<'_>, settings: &[Set<'_>], base: &Base, message: &str) -> Mistake {
        let Some(&(key, value)) = settings.first() else { return document.mistake(&["name"], message) };
        let is_same = |controller: &Controller| {
            let known = controller.settings.iter().map(|(key, value)| (key.as_str(), value));
            known.eq(settings.iter().copied())
        };
        let is_varied =
            self.on_grid().any(|known| known == key) || self.sampled.iter().any(|known| known == key);
        let of_controller = self.controllers.iter().position(is_same).filter(|_| !is_varied);
        let index = of_controller.unwrap_or_default().to_string();
        let (table, shown): (Vec<&str>, String) = match of_controller {
            Some(_) => (vec!["controller", &index, "set"], String::new()),
            None if self.sampled.iter().any(|known| known == key) => {
                (vec!["sample", "range"], format!("{key} = {value}: "))
            }
            None => (vec!["grid"], format!("{key} = {value}: ")),
        };
        let place = axis::place(document, &table, key);
        let table: Vec<&str> = table.into_iter().filter(|step| *step != "set").collect();
        let place: Vec<&str> = place.iter().map(String::as_str).collect();
        let head = document.mistake_in(&table, key, "").message;
        document.mistake(&place, format!("{head}{shown}in {}: {message}", base.name()))
    }
}

/// The keys of a sample, and their values at each of its points.
fn sample_points(
    document: &Document<'_>,
    sample: &Sample,
) -> Result<(Vec<String>, Vec<Vec<Value>>), Mistake> {
    let Sample { method, points, seed, range } = sample;
    if !(1..=RUNS_MAX as u64).contains(points) {
        let message = format!("points = {points}: must lie between 1 and {RUNS_MAX}");
        return Err(document.mistake_in(&["sample"], "points", message));
    }
    let ranges = axis::ranges(document, &["sample", "range"], range)?;
    let most = method.dimensions_max();
    if ranges.is_empty() || ranges.len() > most {
        let message = format!("range: this method takes 1 to {most} keys, here are {}", ranges.len());
        return Err(document.mistake_in(&["sample"], "range", message));
    }
    let points = method.points(*points as usize, ranges.len(), *seed);
    let values =
        |point: Vec<f64>| ranges.iter().zip(point).map(|((_, range), share)| range.at(share)).collect();
    let samples = points.into_iter().map(values).collect();
    Ok((ranges.into_iter().map(|(key, _)| key).collect(), samples))
}

fn seeds(document: &Document<'_>, seeds: Option<Seeds>) -> Result<Option<Vec<u64>>, Mistake> {
    let refuse = |message: &str| Err(document.mistake(&["seeds"], format!("seeds: {message}")));
    let (first, count) = match seeds {
        None => return Ok(None),
        Some(Seeds::Count(count)) => (1, count),
        Some(Seeds::From { first, count }) => (first, count),
        Some(Seeds::List(mut list)) => {
            let count = list.len();
            if list.is_empty() || list.iter().any(|&seed| seed > i64::MAX as u64) {
                return refuse("at least one, each from 0 to 2⁶³ − 1");
            }
            let kept = list.clone();
            list.sort_unstable();
            list.dedup();
            return if list.len() < count { refuse("one of them is there twice") } else { Ok(Some(kept)) };
        }
    };
    let last = first.checked_add(count).filter(|&end| end <= i64::MAX as u64);
    match last {
        Some(end) if (1..=RUNS_MAX as u64).contains(&count) => Ok(Some((first..end).collect())),
        _ => refuse(&format!("1 to {RUNS_MAX} of them, each from 0 to 2⁶³ − 1")),
    }
}

/// What is wrong with the name of a campaign, if anything is.
fn unfit(name: &str) -> Option<String> {
    let fit = |c: char| c.is_ascii_alphanumeric() || "-_.".contains(c);
    let fits = (1..=100).contains(&name.len()) && !name.starts_with(['.', '-']) && name.chars().all(fit);
    (!fits).then(|| {
        format!("name = {name:?}: names folders and jobs too: 1 to 100 of letters, digits, -, _ and ., neither - nor . first")
    })
}

#[cfg(test)]
mod tests;
