//! Poses from a log: the fixes of an earlier run, told again at their own pace from the first look on.

use std::fs::File;
use std::io::BufReader;
use std::path::Path;

use modboat::observer::Fix;
use protocol::time::FleetInstant;
use runlog::flotilla;
use runlog::reader::{LogError, read};

use super::RunError;
use super::pose_source::PoseSource;

/// See the module's documentation.
#[derive(Debug)]
pub struct LoggedPoses {
    name: String,
    /// As they were told, with times from the first one, s.
    fixes: Vec<Fix>,
    next: usize,
    began_s: Option<f64>,
    fix: Fix,
    trouble: String,
}

impl LoggedPoses {
    /// The fixes of the log at `path`.
    ///
    /// # Errors
    /// With the file's name: no such file, no log, or one without a fix.
    pub fn open(path: &Path) -> Result<Self, String> {
        let name = path.display().to_string();
        let file = File::open(path).map_err(|error| format!("{name}: {error}"))?;
        let mut fixes: Vec<Fix> = Vec::new();
        let extent = read(BufReader::new(file), |entry, _| {
            if entry.topic == "/fix" {
                let flotilla::Fix { captured_s, position_m, heading_rad, .. } = entry.read()?;
                fixes.push(Fix { t_s: captured_s, position_m, heading_rad });
            }
            Ok::<(), LogError>(())
        });
        extent.map_err(|error| format!("{name}: {error}"))?;
        let numbers = |fix: &Fix| [fix.t_s, fix.position_m[0], fix.position_m[1], fix.heading_rad];
        fixes.retain(|fix| numbers(fix).iter().all(|number| number.is_finite()));
        let Some(first_s) = fixes.first().map(|fix| fix.t_s) else {
            return Err(format!("{name}: a log without a pose (/fix)"));
        };
        fixes.iter_mut().for_each(|fix| fix.t_s -= first_s);
        let trouble = format!("{name}: the log has no more poses");
        Ok(Self { name, fixes, next: 0, began_s: None, fix: Fix::default(), trouble })
    }

    /// Where they come from.
    #[must_use]
    pub fn name(&self) -> &str {
        &self.name
    }
}

impl<W> PoseSource<W> for LoggedPoses {
    type Pose = Fix;

    fn poll<'a>(&'a mut self, now: FleetInstant, _: Option<&'a W>) -> Result<Option<&'a Fix>, RunError> {
        let began_s = *self.began_s.get_or_insert(now.as_secs_f64());
        let mut is_new = false;
        while let Some(fix) = self.fixes.get(self.next).filter(|fix| began_s + fix.t_s <= now.as_secs_f64()) {
            self.fix = Fix { t_s: began_s + fix.t_s, ..*fix };
            (self.next, is_new) = (self.next + 1, true);
        }
        Ok(is_new.then_some(&self.fix))
    }

    fn trouble(&self) -> Option<&str> {
        (self.next >= self.fixes.len()).then_some(&self.trouble)
    }
}
