//! `flotilla keygen`: the secret of a fleet, and the key of one of its modules. No digit of either is ever printed.

use std::io::Write;
use std::path::{Path, PathBuf};

use link::identity::HostIdentity;
use link::key_file::{KeyFile, KeyFileError, ModuleCredentials};
use protocol::ModuleId;

use super::{Failure, could, written};

#[derive(clap::Args)]
#[command(after_help = "Examples:\n  flotilla keygen\n  flotilla keygen --out tank/fleet.key\n  \
                        flotilla keygen --module 3 --from tank/fleet.key --out module-3.key")]
pub(super) struct Arguments {
    /// File to write [default: flotilla/fleet.key in $XDG_CONFIG_HOME or ~/.config; module-ID.key beside the fleet's for
    /// a module]
    #[arg(long, value_name = "FILE")]
    out: Option<PathBuf>,
    /// Replace a file that is there: nothing that has the former key will be heard any more
    #[arg(long)]
    force: bool,
    /// Derive the key of this module from the fleet's, for a machine that is to have no other
    #[arg(long, value_name = "ID", value_parser = clap::value_parser!(u16).range(1..=1024))]
    module: Option<u16>,
    /// The fleet's key file that a module's key is derived from [default: as for --out]
    #[arg(long, value_name = "FLEETKEY", requires = "module")]
    from: Option<PathBuf>,
}

pub(super) fn main(arguments: &Arguments) -> Result<(), Failure> {
    let (made, next) = match arguments.module {
        Some(id) => module(arguments, ModuleId(id)),
        None => fleet(arguments),
    }
    .map_err(failure)?;
    let mut out = std::io::stdout().lock();
    written(writeln!(out, "{made}\n{next}").and_then(|()| out.flush()))
}

/// What was made, and what to do with it.
fn fleet(arguments: &Arguments) -> Result<(String, String), KeyFileError> {
    let path = named(arguments.out.as_deref())?;
    let key = KeyFile::create(&path, arguments.force)?;
    // Where the others look by themselves, it need not be named.
    let (key_option, from_option) = match KeyFile::default_path() {
        Ok(default) if default == path => (String::new(), String::new()),
        _ => (format!(" with --key {}", path.display()), format!(" --from {}", path.display())),
    };
    let made = format!("{}: key of fleet {}", path.display(), key.fleet());
    let next = format!(
        "next: flotilla run --radio udp and flotilla module{key_option} on this machine; \
         flotilla keygen --module ID{from_option} for others"
    );
    Ok((made, next))
}

fn module(arguments: &Arguments, id: ModuleId) -> Result<(String, String), KeyFileError> {
    let from = named(arguments.from.as_deref())?;
    let fleet = KeyFile::read(&from)?;
    let path = arguments.out.clone().unwrap_or_else(|| from.with_file_name(format!("module-{id}.key")));
    let credentials = KeyFile::create_module(&path, &fleet, id, arguments.force)?;
    let made = format!("{}: key of module {id} in fleet {}", path.display(), credentials.fleet);
    let next = format!(
        "next: take it to the module by a way that cannot be listened to; flotilla module --id {id} --key {} there",
        path.display()
    );
    Ok((made, next))
}

/// The file that was named, or the default.
fn named(path: Option<&Path>) -> Result<PathBuf, KeyFileError> {
    path.map_or_else(KeyFile::default_path, |path| Ok(path.to_owned()))
}

/// The host that the file, or the default, makes.
pub(super) fn host(path: Option<&Path>) -> Result<HostIdentity, Failure> {
    let key = named(path).and_then(|path| KeyFile::read(&path)).map_err(failure)?;
    HostIdentity::new(key).map_err(could)
}

/// What module `id` needs, from the file or the default.
pub(super) fn module_credentials(path: Option<&Path>, id: u16) -> Result<ModuleCredentials, Failure> {
    named(path).and_then(|path| KeyFile::credentials(&path, ModuleId(id))).map_err(failure)
}

/// A failure of the operating system's random source is not the user's mistake; every other failure is.
fn failure(error: KeyFileError) -> Failure {
    match error {
        KeyFileError::Entropy(_) => Failure::Could(error.to_string()),
        _ => Failure::Bad(error.to_string()),
    }
}
