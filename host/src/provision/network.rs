//! How a module gets to its host: addresses that can work, and the network's secret.

use std::net::{Ipv4Addr, SocketAddrV4};
use std::path::Path;

use link::private_file;
use protocol::ModuleId;
use protocol::configuration::{Host, Network, Own, PASSPHRASE_MAX, Passphrase, SSID_MAX};
use reader::without_mark;
use zeroize::Zeroizing;

use super::file::{ModuleFile, NetworkOptions, ProvisionError};

const TABLE: [&str; 1] = ["network"];
/// What stands for the module's number in an address.
const ID: &str = "{id}";
/// Shortest passphrase (IEEE 802.11-2020, J.4.1: 8 to 63 characters, each from 32 to 126).
const PASSPHRASE_MIN: usize = 8;
/// No file with a passphrase is longer, bytes.
const FILE_MAX: usize = 4096;

/// `[network]` of module `id`, and the options that take its place.
pub(super) fn network(
    file: &ModuleFile,
    options: &NetworkOptions,
    id: ModuleId,
) -> Result<Network, ProvisionError> {
    let host = host(file, options)?;
    let own = own(file, id, *host.ip())?;
    let ssid = match (&options.ssid, &file.tables.network.ssid) {
        (Some(ssid), _) => ssid.as_bytes().try_into().map_err(|_| option("--ssid", ssid, &long(ssid)))?,
        (None, Some(ssid)) => {
            ssid.as_bytes().try_into().map_err(|_| value(file, "ssid", ssid, &long(ssid)))?
        }
        (None, None) => Default::default(),
    };
    let network = Network {
        ssid,
        passphrase: passphrase(file, options)?,
        host: Host { address: host.ip().octets(), port: host.port() },
        own,
    };
    if network.ssid.is_empty() && !network.passphrase.bytes().is_empty() {
        let message = "has a passphrase, and no ssid that it is for";
        return Err(file.wrong(&TABLE, "ssid", message));
    }
    Ok(network)
}

fn long(ssid: &str) -> String {
    format!("has {} bytes: at most {SSID_MAX}", ssid.len())
}

/// What is wrong with the value of an option.
fn option(option: &'static str, value: &str, why: &str) -> ProvisionError {
    ProvisionError::Option { option, message: format!("{value}: {why}") }
}

/// What is wrong with the value of a key.
fn value(file: &ModuleFile, key: &str, value: &str, why: &str) -> ProvisionError {
    file.wrong(&TABLE, key, &format!("{key} = {value:?}: {why}"))
}

fn host(file: &ModuleFile, options: &NetworkOptions) -> Result<SocketAddrV4, ProvisionError> {
    match (&options.host, &file.tables.network.host) {
        (Some(text), _) => known_host(text).map_err(|why| option("--host", text, &why)),
        (None, Some(text)) => known_host(text).map_err(|why| value(file, "host", text, &why)),
        (None, None) => {
            let message = "host is missing: write host = \"ADDRESS:PORT\", where flotilla run --radio udp listens, such as \
                           host = \"192.168.4.1:4870\", or give --host";
            Err(file.wrong(&TABLE, "host", message))
        }
    }
}

fn known_host(text: &str) -> Result<SocketAddrV4, String> {
    let host: SocketAddrV4 =
        text.parse().map_err(|_| "it takes ADDRESS:PORT, such as 192.168.4.1:4870".to_owned())?;
    if host.port() == 0 {
        return Err("port 0 cannot be sent to".to_owned());
    }
    if host.ip().is_loopback() {
        return Err(
            "to the module that is itself: write the address that the network knows the host by".to_owned()
        );
    }
    match unfit(*host.ip()) {
        Some(why) => Err(why),
        None => Ok(host),
    }
}

/// Why no host can have this address.
fn unfit(address: Ipv4Addr) -> Option<String> {
    let unfit = address.is_unspecified()
        || address.is_broadcast()
        || address.is_multicast()
        || address.is_loopback()
        || address.octets()[0] == 0;
    unfit.then(|| format!("{address} is no host's address"))
}

fn own(file: &ModuleFile, id: ModuleId, host: Ipv4Addr) -> Result<Own, ProvisionError> {
    let table = &file.tables.network;
    let Some(text) = &table.address else {
        return match &table.gateway {
            Some(text) => {
                Err(value(file, "gateway", text, "without an address the network tells the gateway too"))
            }
            None => Ok(Own::Dhcp),
        };
    };
    let wrong = |why: &str| value(file, "address", text, why);
    let (address, prefix) = interface(&text.replace(ID, &id.to_string())).map_err(|why| wrong(&why))?;
    let network = |address: Ipv4Addr| address.to_bits() >> (32 - prefix);
    let within = u32::MAX >> prefix;
    if matches!(address.to_bits() & within, rest if rest == 0 || rest == within) {
        return Err(wrong(&format!("{address} is the network itself, or all in it")));
    }
    if address == host {
        return Err(wrong(&format!("{address} is the host's")));
    }
    let gateway = table.gateway.as_ref().map(|text| {
        let wrong = |why: &str| value(file, "gateway", text, why);
        let gateway: Ipv4Addr =
            text.parse().map_err(|_| wrong("it takes an ADDRESS, such as 192.168.4.254"))?;
        if gateway == address {
            return Err(wrong("is the module's own address"));
        }
        if network(gateway) != network(address) {
            return Err(wrong(&format!("is not in the module's network, {address}/{prefix}")));
        }
        Ok(gateway)
    });
    let gateway = gateway.transpose()?;
    if gateway.is_none() && network(host) != network(address) {
        return Err(wrong(&format!("the host, {host}, is outside of that network: write its gateway too")));
    }
    Ok(Own::Static { address: address.octets(), prefix, gateway: gateway.map(|gateway| gateway.octets()) })
}

/// `ADDRESS/BITS`.
fn interface(text: &str) -> Result<(Ipv4Addr, u8), String> {
    let parts = text
        .split_once('/')
        .and_then(|(address, prefix)| Some((address.parse::<Ipv4Addr>().ok()?, prefix.parse::<u8>().ok()?)));
    let (address, prefix) =
        parts.ok_or("it takes ADDRESS/BITS, such as 192.168.4.{id}/24, each number at most 255")?;
    if !(1..=30).contains(&prefix) {
        return Err(format!("{prefix} bits: must be 1 to 30"));
    }
    match unfit(address) {
        Some(why) => Err(why),
        None => Ok((address, prefix)),
    }
}

/// Refuses one address for several modules.
pub(super) fn check_shared(file: &ModuleFile, modules: usize) -> Result<(), ProvisionError> {
    match &file.tables.network.address {
        Some(text) if modules > 1 && !text.contains(ID) => {
            let why = format!("{modules} modules cannot all have it: write {ID} where their number goes");
            Err(value(file, "address", text, &why))
        }
        _ => Ok(()),
    }
}

fn passphrase(file: &ModuleFile, options: &NetworkOptions) -> Result<Passphrase, ProvisionError> {
    let table = &file.tables.network;
    let path = match (&options.passphrase_file, &table.passphrase_file) {
        (Some(path), _) => Some(path.clone()),
        (None, Some(path)) => Some(file.folder.join(path)),
        (None, None) => None,
    };
    let text = match (&path, &table.passphrase) {
        (Some(_), Some(_)) if options.passphrase_file.is_none() => {
            return Err(file.wrong(
                &TABLE,
                "passphrase_file",
                "passphrase_file: there is a passphrase already",
            ));
        }
        (Some(path), _) => first_line(path)?,
        (None, Some(secret)) => secret.0.clone(),
        (None, None) => Zeroizing::default(),
    };
    // A network without one is open; a file without one is a mistake.
    let length = text.chars().count();
    let fits = match length {
        0 => path.is_none(),
        _ => {
            (PASSPHRASE_MIN..=PASSPHRASE_MAX).contains(&length)
                && text.bytes().all(|c| (32..127).contains(&c))
        }
    };
    // Not a character of it is shown.
    Passphrase::new(text.as_bytes()).filter(|_| fits).ok_or_else(|| {
        let why = format!(
            "{PASSPHRASE_MIN} to {PASSPHRASE_MAX} characters of ASCII make a passphrase, not these {length}"
        );
        match (&options.passphrase_file, &table.passphrase_file) {
            (Some(path), _) => option("--passphrase-file", &path.display().to_string(), &why),
            (None, Some(path)) => value(file, "passphrase_file", path, &why),
            (None, None) => file.wrong(&TABLE, "passphrase", &format!("passphrase: {why}")),
        }
    })
}

/// The first line of a file that only its owner reads.
fn first_line(path: &Path) -> Result<Zeroizing<String>, ProvisionError> {
    let mut buffer = Zeroizing::new([0; FILE_MAX]);
    let length = private_file::read(path, &mut *buffer)?;
    let text = String::from_utf8_lossy(&buffer[..length]);
    Ok(Zeroizing::new(without_mark(&text).lines().next().unwrap_or_default().to_owned()))
}
