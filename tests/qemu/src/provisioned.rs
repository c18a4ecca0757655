//! The configuration of an emulated module: what `flotilla provision` makes of a module's file.

use std::path::Path;

use host::provision::{ModuleFile, NetworkOptions};
use link::identity::HostIdentity;
use link::key_file::ModuleCredentials;
use protocol::configuration::IMAGE_MAX;
use protocol::{Configuration, ModuleId};

/// The PC, as a module behind the emulator's network sees it.
const HOST: &str = "10.0.2.2";

/// Of module `id` of `host`'s fleet, whose host listens on `port` of this machine. It reports every 2 ms.
///
/// # Panics
/// Never for a valid id.
#[must_use]
pub fn modboat(host: &HostIdentity, id: ModuleId, port: u16) -> Configuration {
    modboat_with(host, id, port, None)
}

/// The same with these lines of `[modboat.encoder]`.
///
/// # Panics
/// For lines that are none.
#[must_use]
pub fn modboat_with(host: &HostIdentity, id: ModuleId, port: u16, encoder: Option<&str>) -> Configuration {
    // Both ways are gone, by turns: what the emulator's network would give, taken without asking.
    let address = if id.0.is_multiple_of(2) { "address = \"10.0.2.15/24\"\n" } else { "" };
    let text = format!(
        "[network]\nhost = \"{HOST}:{port}\"\n{address}[report]\nevery_ms = 2\n[supply]\nvolts_per_volt = 4\n\
         [modboat.encoder]\n{}\n",
        encoder.unwrap_or("counts_per_turn = 0")
    );
    let file = ModuleFile::parse("module.toml", Path::new("."), text).expect("a module's file");
    let credentials = ModuleCredentials::derive(&host.key, id);
    file.configuration(&credentials, &NetworkOptions::default()).expect("a configuration")
}

/// Its image.
///
/// # Panics
/// If it is none.
#[must_use]
pub fn image(configuration: &Configuration) -> Vec<u8> {
    configuration.write(&mut [0; IMAGE_MAX]).expect("a valid configuration").to_vec()
}
