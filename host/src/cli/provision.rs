//! `flotilla provision`: the image that makes a board one module of a fleet, and what such an image holds. Nothing secret is ever printed.

use std::collections::BTreeSet;
use std::fmt::Write as _;
use std::fs::{self, File};
use std::io::{Read, Write};
use std::path::{Path, PathBuf};
use std::str::FromStr;

use link::private_file::{self, PrivateFileError};
use protocol::Configuration;
use quantity::MODULE_IDS;
use zeroize::Zeroizing;

use super::keygen::module_credentials;
use super::{Failure, bad, written};
use crate::provision::image::{self, Format};
use crate::provision::memory::CONFIGURATION;
use crate::provision::{ModuleFile, NetworkOptions, shown};

#[derive(clap::Args)]
#[command(after_help = "Examples:\n  flotilla provision --id 3 --from module.toml --out module-3.uf2\n  \
                        flotilla provision --id 1-9 --from modboat --host 192.168.4.1:4870 --ssid tank \
                        --passphrase-file wifi.txt --out images/\n  \
                        flotilla provision --show module-3.uf2")]
pub(super) struct Arguments {
    /// Numbers in the fleet, such as 3, 1-9 or 1,2,5
    #[arg(long, value_name = "IDS", required_unless_present = "show")]
    id: Option<Ids>,
    /// Module file, or one that comes with the program: modboat, rov
    #[arg(long, value_name = "FILE", required_unless_present = "show")]
    from: Option<String>,
    /// The fleet's key file, or the module's own [default: flotilla/fleet.key in $XDG_CONFIG_HOME or ~/.config]
    #[arg(long, value_name = "FILE")]
    key: Option<PathBuf>,
    /// File to write, .uf2 or .bin, or a folder for several [default: module-ID.uf2]
    #[arg(long, value_name = "FILE")]
    out: Option<PathBuf>,
    /// Bare images instead of UF2, for a probe or the emulator, where --out does not say
    #[arg(long)]
    bin: bool,
    /// Replace files that are there
    #[arg(long)]
    force: bool,
    /// Where the host listens, in place of what the module file says
    #[arg(long, value_name = "ADDRESS:PORT")]
    host: Option<String>,
    /// Name of the wireless network, in place of what the module file says
    #[arg(long, value_name = "NAME")]
    ssid: Option<String>,
    /// File whose first line is the network's passphrase, in place of what the module file says
    #[arg(long, value_name = "FILE")]
    passphrase_file: Option<PathBuf>,
    /// Print what an image holds, as a module file, without its secrets
    #[arg(long, value_name = "FILE", exclusive = true)]
    show: Option<PathBuf>,
}

/// Numbers of modules, in order, each once.
#[derive(Clone)]
struct Ids(BTreeSet<u16>);

impl FromStr for Ids {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let number = |text: &str| {
            let known = text.parse().ok().filter(|id| MODULE_IDS.contains(id));
            let (first, last) = (MODULE_IDS.start(), MODULE_IDS.end());
            known.ok_or_else(|| format!("{text:?} is not a number from {first} to {last}"))
        };
        let mut ids = BTreeSet::new();
        for part in text.split(',') {
            let (first, last) = part.split_once('-').unwrap_or((part, part));
            let (first, last) = (number(first)?, number(last)?);
            if first > last {
                return Err(format!("{part:?} ends before it begins"));
            }
            ids.extend(first..=last);
        }
        Ok(Self(ids))
    }
}

pub(super) fn main(arguments: &Arguments) -> Result<(), Failure> {
    match (&arguments.show, &arguments.id, &arguments.from) {
        (Some(path), _, _) => show(path),
        (None, Some(ids), Some(from)) => provision(arguments, &ids.0, from),
        // The parser lets no other by.
        _ => Err(Failure::Bad("--id and --from, or --show".to_owned())),
    }
}

fn provision(arguments: &Arguments, ids: &BTreeSet<u16>, from: &str) -> Result<(), Failure> {
    let file = ModuleFile::open(from).map_err(bad)?;
    file.check_shared(ids.len()).map_err(bad)?;
    let options = NetworkOptions {
        host: arguments.host.clone(),
        ssid: arguments.ssid.clone(),
        passphrase_file: arguments.passphrase_file.clone(),
    };
    let (targets, format) = targets(arguments, ids)?;
    let mut configurations = Vec::with_capacity(ids.len());
    for &id in ids {
        let credentials = module_credentials(arguments.key.as_deref(), id)?;
        configurations.push(file.configuration(&credentials, &options).map_err(bad)?);
    }
    // Several files come all, or none does for one that is there already.
    if let Some(path) = targets.iter().find(|path| !arguments.force && fs::symlink_metadata(path).is_ok()) {
        return Err(Failure::Bad(PrivateFileError::Exists { path: path.clone() }.to_string()));
    }
    let mut said = String::new();
    for (configuration, path) in configurations.iter().zip(&targets) {
        let bytes = image::encode(configuration, format).map_err(bad)?;
        private_file::write(path, &bytes, arguments.force)
            .map_err(|error| Failure::Bad(error.to_string()))?;
        // Writing to a String cannot fail.
        let _ = writeln!(said, "{}: {}", path.display(), summary(configuration));
    }
    let _ = writeln!(said, "next: {}", next(&targets, format));
    let mut out = std::io::stdout().lock();
    written(out.write_all(said.as_bytes()).and_then(|()| out.flush()))
}

/// Where each image goes, and how it is written.
fn targets(arguments: &Arguments, ids: &BTreeSet<u16>) -> Result<(Vec<PathBuf>, Format), Failure> {
    let format = if arguments.bin { Format::Bin } else { Format::Uf2 };
    let within = |folder: &Path| {
        let name = |id: &u16| folder.join(format!("module-{id}.{}", format.extension()));
        (ids.iter().map(name).collect(), format)
    };
    let Some(out) = &arguments.out else { return Ok(within(Path::new(""))) };
    let named = [Format::Uf2, Format::Bin]
        .into_iter()
        .find(|format| out.extension().is_some_and(|end| end.eq_ignore_ascii_case(format.extension())));
    let bad = |what: &str| Err(Failure::Bad(format!("--out {}: {what}", out.display())));
    let is_folder = out.is_dir() || out.to_string_lossy().ends_with(std::path::is_separator);
    match named {
        _ if is_folder => Ok(within(out)),
        Some(_) if ids.len() > 1 => bad(&format!("{} modules need a folder, such as images/", ids.len())),
        Some(Format::Uf2) if arguments.bin => bad("--bin makes files that end with .bin"),
        Some(format) => Ok((vec![out.clone()], format)),
        None if ids.len() > 1 => Ok(within(out)),
        None => bad("must end with .uf2 or .bin, or with / for a folder"),
    }
}

fn summary(configuration: &Configuration) -> String {
    let Configuration { module, fleet, network, .. } = configuration;
    let (host, own) = shown::addresses(configuration);
    let way = match network.ssid.is_empty() {
        true => "on a wire".to_owned(),
        false => format!("in {:?}", String::from_utf8_lossy(&network.ssid)),
    };
    let own = own.unwrap_or_else(|| "DHCP".to_owned());
    format!("module {module} of fleet {fleet}, {}, {way} at {own}, host {host}", shown::kind(configuration))
}

/// What to do with the files.
fn next(targets: &[PathBuf], format: Format) -> String {
    let file = match targets {
        [one] => one.display().to_string(),
        _ => "its file".to_owned(),
    };
    let flash = match format {
        Format::Uf2 => format!("hold BOOTSEL while you plug a board in, and copy {file} to the drive RP2350"),
        Format::Bin => format!(
            "probe-rs download --chip RP235x --binary-format bin --base-address {:#010x} {file}, and probe-rs reset --chip \
             RP235x",
            CONFIGURATION.origin
        ),
    };
    format!("{flash}; then delete it: it holds the module's key")
}

/// No file that is shown is longer, bytes: a program as UF2 may well be mistaken for an image.
const SHOWN_MAX: u64 = 1 << 24;

fn show(path: &Path) -> Result<(), Failure> {
    let bad = |what: &dyn std::fmt::Display| Failure::Bad(format!("{}: {what}", path.display()));
    let mut bytes = Zeroizing::new(Vec::new());
    let file = File::open(path).map_err(|error| bad(&error))?;
    file.take(SHOWN_MAX).read_to_end(&mut bytes).map_err(|error| bad(&error))?;
    let (configuration, format) = image::decode(&bytes).map_err(|error| bad(&error))?;
    let text = shown::shown(&configuration).map_err(|error| bad(&error))?;
    let place = match format {
        Format::Uf2 => format!("UF2 for {:#010x}", CONFIGURATION.origin),
        Format::Bin => "a bare image".to_owned(),
    };
    let mut out = std::io::stdout().lock();
    written(write!(out, "# {}: {place}\n{text}", path.display()).and_then(|()| out.flush()))
}
