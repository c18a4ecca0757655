//! From a file and a key to the configuration of one module.

use link::key_file::ModuleCredentials;
use protocol::Configuration;
use protocol::configuration::Robot;

use super::file::{ModuleFile, NetworkOptions, ProvisionError};
use super::{constants, network, trial};

impl ModuleFile {
    /// Refuses a file that cannot be for so many modules at once.
    ///
    /// # Errors
    /// [`ProvisionError::File`]: an address that only one of them can have.
    pub fn check_shared(&self, modules: usize) -> Result<(), ProvisionError> {
        network::check_shared(self, modules)
    }

    /// The configuration of the module that these are the credentials of.
    ///
    /// # Errors
    /// [`ProvisionError`]: all that protocol and firmware would refuse, and what could not work.
    pub fn configuration(
        &self,
        credentials: &ModuleCredentials,
        options: &NetworkOptions,
    ) -> Result<Configuration, ProvisionError> {
        let ModuleCredentials { id, fleet, key } = credentials;
        let robot = match (&self.tables.modboat, &self.tables.rov) {
            (_, Some(table)) => Robot::Rov(constants::rov(self, table)?),
            (Some(table), None) => Robot::Modboat(constants::modboat(self, table)?),
            (None, None) => return Err(self.wrong(&[], "", "says neither [modboat] nor [rov]")),
        };
        let configuration = Configuration {
            module: *id,
            fleet: *fleet,
            key: key.clone(),
            network: network::network(self, options, *id)?,
            report_every: constants::report_every(self)?,
            sure_within: constants::sure_within(self, &robot)?,
            supply: constants::supply(self, &robot)?,
            robot,
        };
        // Whatever protocol or firmware refuse that was not refused above.
        trial::run(&configuration).map_err(|error| self.wrong(&[], "", &error.to_string()))?;
        Ok(configuration)
    }
}
