//! The folder of a campaign: which files are in it, and of which campaign it is.
//!
//! | file | what |
//! |---|---|
//! | `campaign.json` | what the folder is of: name, fingerprint, runs, shards, format, keys that are varied |
//! | `shard-3-of-8.journal` | the rows of a shard that is being run |
//! | `shard-3-of-8.parquet` | the rows of a shard that is done |
//! | `rows.parquet` | all rows: of a campaign in one piece, or merged |

use std::path::{Path, PathBuf};
use std::time::SystemTime;

use serde::{Deserialize, Serialize};
use thiserror::Error;

use crate::journal::replace_by;
use crate::table::Format;
use crate::work::Work;

/// What a folder is of: `campaign.json`.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Manifest {
    /// The campaign's name.
    pub campaign: String,
    /// See [`Work::fingerprint`].
    pub fingerprint: String,
    /// How many runs.
    pub runs: usize,
    /// In how many shards.
    pub shards: usize,
    /// The end of the names of the files.
    pub format: String,
    /// Keys on a grid.
    pub grid: Vec<String>,
    /// Keys that are sampled.
    pub sampled: Vec<String>,
}

/// Why a folder cannot be used.
#[derive(Debug, Error)]
#[expect(missing_docs, reason = "the messages say what the fields are")]
pub enum FolderError {
    /// Reading or writing failed.
    #[error("{}: {source}", path.display())]
    File { path: PathBuf, source: std::io::Error },
    /// It has no `campaign.json` that can be read.
    #[error("{}: is no campaign's folder: {reason}", path.display())]
    None { path: PathBuf, reason: String },
    /// It is of another campaign.
    #[error("{}: holds {what}: name another folder by --out, or remove it", path.display())]
    Other { path: PathBuf, what: String },
}

/// One shard of several.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Shard {
    /// Which, from 1.
    pub index: usize,
    /// Of how many.
    pub count: usize,
}

impl Shard {
    /// The whole campaign.
    pub const WHOLE: Self = Self { index: 1, count: 1 };

    /// The numbers of its runs: every `count`-th, so that shards take about as long as each other.
    pub fn runs(self, of: usize) -> impl Iterator<Item = usize> + Clone {
        (self.index - 1..of).step_by(self.count)
    }
}

/// See the module's documentation.
#[derive(Clone, Debug)]
pub struct Folder {
    /// Where it is.
    pub path: PathBuf,
    /// What it is of.
    pub manifest: Manifest,
}

impl Folder {
    /// The folder of `work` at `path`, made if it is not there.
    ///
    /// # Errors
    /// [`FolderError`].
    pub fn of(work: &dyn Work, path: &Path, shards: usize, format: Format) -> Result<Self, FolderError> {
        let manifest = Manifest {
            campaign: work.name().to_owned(),
            fingerprint: work.fingerprint(),
            runs: work.runs(),
            shards,
            format: format.extension().to_owned(),
            grid: work.grid(),
            sampled: work.sampled(),
        };
        let file = path.join("campaign.json");
        if file.exists() {
            let folder = Self::open(path)?;
            let other = |what: String| Err(FolderError::Other { path: path.to_owned(), what });
            let known = &folder.manifest;
            return if known == &manifest {
                Ok(folder)
            } else if known.fingerprint != manifest.fingerprint {
                other(format!("another campaign, or an earlier text of this one ({})", known.campaign))
            } else {
                other(format!("this campaign in {} shards as {}", known.shards, known.format))
            };
        }
        let failed = |source| FolderError::File { path: file.clone(), source };
        std::fs::create_dir_all(path).map_err(failed)?;
        // Of several shards that begin at once, perhaps on several machines, each writes the same.
        let since = SystemTime::now().duration_since(SystemTime::UNIX_EPOCH).unwrap_or_default();
        let end = format!(".{}-{}.new", std::process::id(), since.as_nanos());
        replace_by(&file, &end, |to| Ok(serde_json::to_writer_pretty(to, &manifest)?)).map_err(failed)?;
        Ok(Self { path: path.to_owned(), manifest })
    }

    /// A folder that is there.
    ///
    /// # Errors
    /// [`FolderError`].
    pub fn open(path: &Path) -> Result<Self, FolderError> {
        let none = |reason: String| FolderError::None { path: path.to_owned(), reason };
        let text = std::fs::read_to_string(path.join("campaign.json"));
        let text = text.map_err(|error| none(format!("campaign.json: {error}")))?;
        let manifest =
            serde_json::from_str(&text).map_err(|error| none(format!("campaign.json: {error}")))?;
        Ok(Self { path: path.to_owned(), manifest })
    }

    /// The format of its files.
    #[must_use]
    pub fn format(&self) -> Format {
        let known = Format::ALL.into_iter().find(|format| format.extension() == self.manifest.format);
        known.unwrap_or(Format::Parquet)
    }

    /// Keys that are varied, in the order of columns.
    #[must_use]
    pub fn varied(&self) -> Vec<String> {
        let mut keys = [self.manifest.grid.as_slice(), &self.manifest.sampled].concat();
        keys.sort();
        keys
    }

    /// All shards.
    pub fn shards(&self) -> impl Iterator<Item = Shard> + use<> {
        let count = self.manifest.shards;
        (1..=count).map(move |index| Shard { index, count })
    }

    /// The file of all rows.
    #[must_use]
    pub fn rows(&self) -> PathBuf {
        self.path.join(format!("rows.{}", self.manifest.format))
    }

    /// The file of a shard's rows.
    #[must_use]
    pub fn file(&self, shard: Shard) -> PathBuf {
        match shard {
            Shard::WHOLE => self.rows(),
            Shard { index, count } => {
                self.path.join(format!("shard-{index}-of-{count}.{}", self.manifest.format))
            }
        }
    }

    /// The journal of a shard.
    #[must_use]
    pub fn journal(&self, shard: Shard) -> PathBuf {
        self.file(shard).with_extension("journal")
    }

    /// How many rows of a shard there are by now.
    #[must_use]
    pub fn done(&self, shard: Shard) -> usize {
        if self.file(shard).exists() {
            return shard.runs(self.manifest.runs).count();
        }
        let lines = std::fs::read(self.journal(shard)).unwrap_or_default();
        lines.iter().filter(|&&byte| byte == b'\n').count().saturating_sub(1)
    }
}
