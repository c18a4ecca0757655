//! The roster of a fleet: which modules there are, by the numbers their keys are derived from, and where each sits.
//!
//! ```toml
//! name = "tank fleet"
//!
//! [[module]]
//! id = 3
//! name = "Ada"
//! cell = [0, 0]
//! ```
//!
//! A structure has places, a fleet has modules: [`Roster::seats`] says which module has which place. With cells, the module that has the
//! place's cell; without, the Modboats in the order of the file. Modules that are left over stay out of it. ROVs have no cells: those of
//! the file, in its order, are the robots of a scenario in its order ([`Roster::rov_seats`]).
//!
//! A motion capture tracks bodies: `body` says which is the module's, `body_offset_m` and `body_turn_rad` how it is mounted.
//!
//! Limits: numbers from 1 to 1024, each once, so that there are no more modules than that.

use std::collections::HashMap;
use std::path::{Path, PathBuf};

use modboat::structure::{COORDINATE_MAX, Structure};
use pose::roster::{Entry, Name};
use protocol::{ModuleId, ModuleKind};
use quantity::MODULE_IDS;
use reader::file::{WRITTEN_MAX, text_of};
use reader::{Document, FileError, Mistake};
use serde::Deserialize;
use thiserror::Error;

/// The modules of a fleet.
#[derive(Clone, Debug, PartialEq)]
pub struct Roster {
    name: String,
    members: Vec<Member>,
}

/// One module of a fleet.
#[derive(Clone, Debug, PartialEq)]
pub struct Member {
    /// Its number, which its key is derived from.
    pub id: ModuleId,
    /// What people call it.
    pub name: Option<String>,
    /// What it is.
    pub kind: ModuleKind,
    /// Its place `[col, row]` in a structure; all of a roster have one, or none.
    pub cell: Option<[i32; 2]>,
    /// How the motion capture calls its body; `None` for what [`Roster::bodies`] says.
    pub body: Option<Name>,
    /// The body's origin on the module, from its pivot, m: x to the right, y forward, z up of a Modboat; x forward, y right, z down of
    /// an ROV.
    pub body_offset_m: [f64; 3],
    /// How the body's x axis is turned from the module's forward direction, counter-clockwise seen from above of a Modboat, clockwise of
    /// an ROV, rad.
    pub body_turn_rad: f64,
}

impl Member {
    /// One that nothing is said of but its number and kind.
    #[must_use]
    pub const fn plain(id: ModuleId, kind: ModuleKind) -> Self {
        Self { id, name: None, kind, cell: None, body: None, body_offset_m: [0.0; 3], body_turn_rad: 0.0 }
    }
}

/// Why there is no roster, or not the one that is needed.
#[derive(Debug, Error)]
pub enum RosterError {
    /// No such file.
    #[error("{}: no such file", path.display())]
    Missing {
        /// Which file.
        path: PathBuf,
    },
    /// The file cannot be read, or is not what it should be.
    #[error(transparent)]
    File(#[from] FileError),
    /// A structure has more places than there are Modboats.
    #[error("roster {roster:?} has {modboats} Modboats for {places} places")]
    TooFew {
        /// The roster's name.
        roster: String,
        /// Modboats in it.
        modboats: usize,
        /// Modules in the structure.
        places: usize,
    },
    /// No module has a cell of the structure.
    #[error("roster {roster:?} has no module for cell [{}, {}]", cell[0], cell[1])]
    Vacant {
        /// The roster's name.
        roster: String,
        /// The cell `[col, row]`.
        cell: [i32; 2],
    },
    /// A reconfiguration has more robots than there are ROVs.
    #[error("roster {roster:?} has {rovs} ROVs (kind = \"rov\") for {robots} robots")]
    TooFewRovs {
        /// The roster's name.
        roster: String,
        /// ROVs in it.
        rovs: usize,
        /// Robots in the scenario.
        robots: usize,
    },
    /// An ROV sits in a cell of a structure of Modboats.
    #[error("roster {roster:?} has an ROV, module {id}, for cell [{}, {}]", cell[0], cell[1])]
    NoModboat {
        /// The roster's name.
        roster: String,
        /// Which module.
        id: ModuleId,
        /// The cell `[col, row]`.
        cell: [i32; 2],
    },
}

/// The file's own shape; [`Roster`] is what becomes of it.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Tables {
    #[serde(default)]
    name: String,
    #[serde(rename = "module", default)]
    modules: Vec<ModuleTable>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct ModuleTable {
    id: i64,
    #[serde(default)]
    name: Option<String>,
    #[serde(default)]
    kind: Kind,
    #[serde(default)]
    cell: Option<[i32; 2]>,
    #[serde(default)]
    body: Option<BodyName>,
    #[serde(default)]
    body_offset_m: [f64; 3],
    #[serde(default)]
    body_turn_rad: f64,
}

#[derive(Clone, Deserialize)]
#[serde(untagged, expecting = "must be a name or a number")]
enum BodyName {
    Number(i32),
    Name(String),
}

#[derive(Clone, Copy, Default, Deserialize)]
#[serde(rename_all = "lowercase")]
enum Kind {
    #[default]
    Modboat,
    Rov,
}

/// No name is longer, characters.
const NAME_MAX: usize = 100;

impl Roster {
    /// Reads a roster.
    ///
    /// # Errors
    /// [`RosterError`].
    pub fn read(path: &Path) -> Result<Self, RosterError> {
        let text =
            text_of(path, WRITTEN_MAX)?.ok_or_else(|| RosterError::Missing { path: path.to_owned() })?;
        Ok(Self::parse(&path.display().to_string(), &text)?)
    }

    /// Reads a roster from `text`; `file` is its name in error messages.
    ///
    /// # Errors
    /// [`FileError::Invalid`].
    pub fn parse(file: &str, text: &str) -> Result<Self, FileError> {
        let document = Document::toml(text).map_err(|mistake| mistake.in_file(file))?;
        Self::of(&document).map_err(|mistake| mistake.in_file(file))
    }

    fn of(document: &Document<'_>) -> Result<Self, Mistake> {
        let tables: Tables = document.read()?;
        if let Some(message) = unfit(&tables.name) {
            return Err(document.mistake(&["name"], message));
        }
        let Some(first) = tables.modules.first() else {
            return Err(document.mistake(&["module"], "a roster needs at least one [[module]]"));
        };
        let (mut ids, mut cells, mut bodies) = (HashMap::new(), HashMap::new(), HashMap::new());
        let mut members = Vec::with_capacity(tables.modules.len());
        for (index, module) in tables.modules.iter().enumerate() {
            let number = index + 1;
            let at = |key: &str, message: String| {
                document.mistake_in(&["module", &index.to_string()], key, message)
            };
            let id = known_id(module.id).map_err(|message| at("id", message))?;
            if let Some(earlier) = ids.insert(id, number) {
                return Err(at("id", format!("id = {id}: [[module]] {earlier} has it already")));
            }
            if let Some(message) = module.name.as_deref().and_then(unfit) {
                return Err(at("name", message));
            }
            if module.cell.is_some() != first.cell.is_some() {
                let (has, first_has) = if module.cell.is_some() { ("a", "none") } else { ("no", "one") };
                let message =
                    format!("has {has} cell, but [[module]] 1 has {first_has}: all have one, or none has");
                return Err(at("cell", message));
            }
            if let Some([col, row]) = module.cell {
                let shown = format!("cell = [{col}, {row}]");
                let limits = -COORDINATE_MAX..=COORDINATE_MAX;
                if !limits.contains(&col) || !limits.contains(&row) {
                    return Err(at("cell", format!("{shown}: must lie within ±{COORDINATE_MAX}")));
                }
                if let Some(earlier) = cells.insert([col, row], number) {
                    return Err(at("cell", format!("{shown}: [[module]] {earlier} sits there already")));
                }
            }
            let kind = match module.kind {
                Kind::Modboat => ModuleKind::Modboat,
                Kind::Rov => ModuleKind::Rov,
            };
            let body = module.body.clone().map(|body| match body {
                BodyName::Number(number) => Name::Number(number),
                BodyName::Name(name) => Name::Name(name),
            });
            if let Some(body) = &body
                && let Some(earlier) = bodies.insert(body.to_string(), number)
            {
                return Err(at("body", format!("body = {body}: [[module]] {earlier} has it already")));
            }
            let &ModuleTable { ref name, cell, body_offset_m, body_turn_rad, .. } = module;
            for (key, value, unit) in body_offset_m
                .map(|value| ("body_offset_m", value, "m"))
                .into_iter()
                .chain([("body_turn_rad", body_turn_rad, "rad")])
            {
                if !(-100.0..=100.0).contains(&value) {
                    return Err(at(key, format!("{key} = {value} {unit}: must lie within ±100")));
                }
            }
            let (id, name) = (ModuleId(id), name.clone());
            members.push(Member { id, name, kind, cell, body, body_offset_m, body_turn_rad });
        }
        Ok(Self { name: tables.name, members })
    }

    /// Modules 1 to `count` of a kind, at most 1024, in order: the roster of a fleet that has none.
    #[must_use]
    pub fn numbered(count: usize, kind: ModuleKind) -> Self {
        let members = MODULE_IDS.take(count).map(|id| Member::plain(ModuleId(id), kind));
        Self { name: "numbered".to_owned(), members: members.collect() }
    }

    /// Which body is which of the modules `of`, for a motion capture that tells bodies by number, or by name alone. Where the roster does not say,
    /// the body has the module's number, or the name `module-NUMBER`.
    ///
    /// # Errors
    /// Two modules with one body.
    pub fn bodies(
        &self,
        by_number: bool,
        of: &[ModuleId],
    ) -> Result<pose::roster::Roster, pose::roster::RosterError> {
        let members = self.members.iter().filter(|member| of.contains(&member.id));
        let entries = members.map(|member| {
            let id = member.id.0;
            let own =
                || if by_number { Name::Number(i32::from(id)) } else { Name::Name(format!("module-{id}")) };
            Entry {
                module: id,
                body: member.body.clone().unwrap_or_else(own),
                offset_m: member.body_offset_m.into(),
                turn_rad: member.body_turn_rad,
            }
        });
        pose::roster::Roster::new(entries.collect())
    }

    /// The fleet's name, perhaps empty.
    #[must_use]
    pub fn name(&self) -> &str {
        &self.name
    }

    /// The modules, in the order of the file.
    #[must_use]
    pub fn members(&self) -> &[Member] {
        &self.members
    }

    /// The modules' numbers, in the order of the file.
    pub fn ids(&self) -> impl Iterator<Item = ModuleId> + '_ {
        self.members.iter().map(|member| member.id)
    }

    /// The module with this number.
    #[must_use]
    pub fn member(&self, id: ModuleId) -> Option<&Member> {
        self.members.iter().find(|member| member.id == id)
    }

    /// Whether places are told by cell.
    #[must_use]
    pub fn has_cells(&self) -> bool {
        self.members.iter().any(|member| member.cell.is_some())
    }

    /// The ROV that is each of so many robots.
    ///
    /// # Errors
    /// [`RosterError::TooFewRovs`].
    pub fn rov_seats(&self, robots: usize) -> Result<Vec<ModuleId>, RosterError> {
        let rovs = self.members.iter().filter(|member| member.kind == ModuleKind::Rov);
        let seats: Vec<ModuleId> = rovs.map(|member| member.id).take(robots).collect();
        if seats.len() < robots {
            return Err(RosterError::TooFewRovs { roster: self.name.clone(), rovs: seats.len(), robots });
        }
        Ok(seats)
    }

    /// The module in each place of `structure`, in the structure's order.
    ///
    /// # Errors
    /// [`RosterError::TooFew`], [`RosterError::Vacant`] or [`RosterError::NoModboat`].
    pub fn seats(&self, structure: &Structure) -> Result<Vec<ModuleId>, RosterError> {
        let roster = || self.name.clone();
        if !self.has_cells() {
            let modboats = self.members.iter().filter(|member| member.kind == ModuleKind::Modboat);
            let seats: Vec<ModuleId> =
                modboats.clone().map(|member| member.id).take(structure.len()).collect();
            if seats.len() < structure.len() {
                let (modboats, places) = (seats.len(), structure.len());
                return Err(RosterError::TooFew { roster: roster(), modboats, places });
            }
            return Ok(seats);
        }
        let by_cell: HashMap<[i32; 2], &Member> =
            self.members.iter().filter_map(|member| Some((member.cell?, member))).collect();
        let seat = |&cell: &[i32; 2]| match by_cell.get(&cell) {
            None => Err(RosterError::Vacant { roster: roster(), cell }),
            Some(Member { id, kind: ModuleKind::Rov, .. }) => {
                Err(RosterError::NoModboat { roster: roster(), id: *id, cell })
            }
            Some(member) => Ok(member.id),
        };
        structure.cells().iter().map(seat).collect()
    }
}

/// A number that a module can have, or what is wrong with it.
fn known_id(id: i64) -> Result<u16, String> {
    let known = u16::try_from(id).ok().filter(|id| MODULE_IDS.contains(id));
    known.ok_or_else(|| format!("id = {id}: must be from {} to {}", MODULE_IDS.start(), MODULE_IDS.end()))
}

/// What is wrong with a name, if anything is.
fn unfit(name: &str) -> Option<String> {
    let fits = name.chars().count() <= NAME_MAX && !name.chars().any(char::is_control);
    (!fits).then(|| format!("name = {name:?}: at most {NAME_MAX} characters in one line"))
}

#[cfg(test)]
mod tests;
