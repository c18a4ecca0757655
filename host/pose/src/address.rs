//! Addresses of pose sources in words: `natnet:HOST[:PORT]`, `qtm:HOST[:PORT]`, `vrpn:[BODY,…@]HOST[:PORT]`,
//! `ros2:[BODY=]/TOPIC[,…][@FRAME]`, `log:FILE`.

use std::fmt;
use std::net::{Ipv4Addr, SocketAddr, ToSocketAddrs};
use std::path::PathBuf;
use std::str::FromStr;

use thiserror::Error;

use crate::natnet::client::NatNetClient;
use crate::ros2::{Relay, StartError, TopicError, Topics};
use crate::source::{Source, SourceError};
use crate::vrpn::client::VrpnClient;
use crate::{natnet, qtm, vrpn};

/// Where poses come from.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Address {
    /// OptiTrack Motive.
    NatNet(Host),
    /// Qualisys Track Manager.
    Qtm(Host),
    /// A VRPN server, and the trackers that are wanted: all if none is named.
    Vrpn(Vec<String>, Host),
    /// Topics of ROS 2.
    Ros2(Topics),
    /// A log.
    Log(PathBuf),
}

/// A machine and a port.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Host {
    /// Its name or number.
    pub name: String,
    /// The port.
    pub port: u16,
}

/// Why an address is none.
#[derive(Clone, Debug, Error, PartialEq, Eq)]
pub enum AddressError {
    /// No protocol, or one that is not known.
    #[error(
        "\"{given}\": no pose source \"{protocol}\"; there are natnet:HOST[:PORT], qtm:HOST[:PORT], vrpn:[BODY,…@]HOST[:PORT], \
         ros2:[BODY=]/TOPIC[,…][@FRAME] and log:FILE"
    )]
    Protocol {
        /// The whole address.
        given: String,
        /// What stands before the colon.
        protocol: String,
    },
    /// No host.
    #[error("\"{given}\": the host is missing, as in {protocol}:192.168.1.10")]
    NoHost {
        /// The whole address.
        given: String,
        /// The protocol.
        protocol: &'static str,
    },
    /// A port that is none.
    #[error("\"{given}\": \"{port}\" is no port; ports are 1 to 65535")]
    Port {
        /// The whole address.
        given: String,
        /// What stands for the port.
        port: String,
    },
    /// No topic of ROS.
    #[error("\"{given}\": {error}")]
    Topic {
        /// The whole address.
        given: String,
        /// What is wrong with it.
        error: TopicError,
    },
    /// No file.
    #[error("\"{given}\": the file is missing, as in log:runs/latest/log.mcap")]
    NoFile {
        /// The whole address.
        given: String,
    },
}

/// Why a source cannot be opened.
#[derive(Clone, Debug, Error, PartialEq, Eq)]
pub enum OpenError {
    /// A host that the machine does not find.
    #[error("{address}: the host \"{host}\" is not found: {reason}")]
    Resolve {
        /// The whole address.
        address: String,
        /// The host.
        host: String,
        /// What the operating system said.
        reason: String,
    },
    /// A log is no server.
    #[error("{0}: a log is read by the program itself")]
    Log(String),
    /// The program that reads ROS 2.
    #[error("{address}: {error}")]
    Ros2 {
        /// The whole address.
        address: String,
        /// Why it does not run.
        error: StartError,
    },
    /// A socket.
    #[error(transparent)]
    Source(#[from] SourceError),
}

/// What an address leaves open.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Options {
    /// This machine's address in the network of a NatNet server, where the operating system would choose another.
    pub interface: Option<Ipv4Addr>,
    /// Whether QTM sends frames as datagrams.
    pub over_udp: bool,
}

impl FromStr for Address {
    type Err = AddressError;

    fn from_str(given: &str) -> Result<Self, AddressError> {
        let (protocol, rest) = given.split_once(':').unwrap_or((given, ""));
        let host = |protocol, rest, port| host(given, protocol, rest, port);
        match protocol {
            "natnet" => Ok(Self::NatNet(host("natnet", rest, natnet::message::COMMAND_PORT)?)),
            "qtm" => Ok(Self::Qtm(host("qtm", rest, qtm::packet::PORT)?)),
            "vrpn" => {
                let (bodies, rest) = rest.rsplit_once('@').unwrap_or(("", rest));
                let bodies = bodies.split(',').map(str::trim).filter(|body| !body.is_empty() && *body != "*");
                Ok(Self::Vrpn(bodies.map(str::to_owned).collect(), host("vrpn", rest, vrpn::message::PORT)?))
            }
            "ros2" => {
                let topics = rest.parse();
                topics.map(Self::Ros2).map_err(|error| AddressError::Topic { given: given.into(), error })
            }
            "log" if rest.is_empty() => Err(AddressError::NoFile { given: given.into() }),
            "log" => Ok(Self::Log(rest.into())),
            other => Err(AddressError::Protocol { given: given.into(), protocol: other.into() }),
        }
    }
}

/// `HOST[:PORT]`; an IPv6 address with a port stands in brackets.
fn host(given: &str, protocol: &'static str, rest: &str, standard: u16) -> Result<Host, AddressError> {
    let (name, port) = match rest.strip_prefix('[').and_then(|rest| rest.split_once(']')) {
        Some((name, "")) => (name, None),
        Some((name, port)) => (name, Some(port.strip_prefix(':').unwrap_or(port))),
        None if rest.matches(':').count() > 1 => (rest, None),
        None => rest.split_once(':').map_or((rest, None), |(name, port)| (name, Some(port))),
    };
    if name.is_empty() {
        return Err(AddressError::NoHost { given: given.into(), protocol });
    }
    let wrong = |port: &str| AddressError::Port { given: given.into(), port: port.into() };
    let port =
        port.map(|port| port.parse().ok().filter(|&n: &u16| n > 0).ok_or_else(|| wrong(port))).transpose()?;
    Ok(Host { name: name.into(), port: port.unwrap_or(standard) })
}

impl fmt::Display for Host {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.name.contains(':') {
            true => write!(f, "[{}]:{}", self.name, self.port),
            false => write!(f, "{}:{}", self.name, self.port),
        }
    }
}

impl fmt::Display for Address {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::NatNet(host) => write!(f, "natnet:{host}"),
            Self::Qtm(host) => write!(f, "qtm:{host}"),
            Self::Vrpn(bodies, host) if bodies.is_empty() => write!(f, "vrpn:{host}"),
            Self::Vrpn(bodies, host) => write!(f, "vrpn:{}@{host}", bodies.join(",")),
            Self::Ros2(topics) => write!(f, "ros2:{topics}"),
            Self::Log(file) => write!(f, "log:{}", file.display()),
        }
    }
}

impl Address {
    /// Opens the source. The host is looked up here, or the program for ROS 2 started, which may take seconds; all else is done while it is polled.
    ///
    /// # Errors
    /// A host that is not found, a socket that cannot be opened, a log.
    pub fn open(&self, options: Options) -> Result<Box<dyn Source>, OpenError> {
        Ok(match self {
            Self::NatNet(host) => Box::new(NatNetClient::new(self.resolve(host)?, options.interface)?),
            Self::Qtm(host) => Box::new(qtm::client::QtmClient::new(self.resolve(host)?, options.over_udp)?),
            Self::Vrpn(bodies, host) => {
                let wanted: Vec<&str> = bodies.iter().map(String::as_str).collect();
                Box::new(VrpnClient::new(self.resolve(host)?, &wanted))
            }
            Self::Ros2(topics) => {
                let relay = Relay::start(topics);
                Box::new(relay.map_err(|error| OpenError::Ros2 { address: self.to_string(), error })?)
            }
            Self::Log(_) => return Err(OpenError::Log(self.to_string())),
        })
    }

    /// The host's address, of IPv4 where it has one: multicast and QTM's and VRPN's own servers are of IPv4.
    fn resolve(&self, host: &Host) -> Result<SocketAddr, OpenError> {
        let failed = |reason: String| OpenError::Resolve {
            address: self.to_string(),
            host: host.name.clone(),
            reason,
        };
        let found =
            (host.name.as_str(), host.port).to_socket_addrs().map_err(|error| failed(error.to_string()))?;
        let found: Vec<SocketAddr> = found.collect();
        let first = found.iter().find(|address| address.is_ipv4()).or(found.first());
        first.copied().ok_or_else(|| failed("it has no address".into()))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_written_is_read_again() {
        for (given, written) in [
            ("natnet:192.168.1.10", "natnet:192.168.1.10:1510"),
            ("natnet:motive.lab:1600", "natnet:motive.lab:1600"),
            ("qtm:localhost", "qtm:localhost:22223"),
            ("qtm:[fe80::1]:99", "qtm:[fe80::1]:99"),
            ("qtm:fe80::1", "qtm:[fe80::1]:22223"),
            ("vrpn:boat@host", "vrpn:boat@host:3883"),
            ("vrpn:a, b@host:3884", "vrpn:a,b@host:3884"),
            ("vrpn:*@host", "vrpn:host:3883"),
            ("vrpn:host", "vrpn:host:3883"),
            ("ros2:/boat/pose", "ros2:/boat/pose"),
            ("ros2:blue=/boat/pose,/module_2/odom@map", "ros2:blue=/boat/pose,/module_2/odom@map"),
            ("log:runs/a b/log.mcap", "log:runs/a b/log.mcap"),
        ] {
            let address: Address = given.parse().expect(given);
            assert_eq!(address.to_string(), written);
            assert_eq!(written.parse(), Ok(address));
        }
    }

    #[test]
    fn errors_name_what_is_wrong_and_what_there_is() {
        for (given, part) in [
            ("vicon:host", "no pose source \"vicon\"; there are natnet:HOST[:PORT], qtm:"),
            ("host", "no pose source \"host\""),
            ("natnet:", "the host is missing, as in natnet:192.168.1.10"),
            ("vrpn:boat@", "the host is missing"),
            ("qtm:host:70000", "\"70000\" is no port"),
            ("qtm:host:0", "\"0\" is no port"),
            ("natnet:host:", "\"\" is no port"),
            ("ros2:", "the topic is missing"),
            ("ros2:boat", "\"boat\" is no topic"),
            ("log:", "the file is missing"),
        ] {
            let text = given.parse::<Address>().expect_err(given).to_string();
            assert!(text.contains(part), "{text}");
            assert!(text.starts_with(&format!("\"{given}\":")), "{text}");
        }
    }

    #[test]
    fn a_host_that_is_not_found_is_named() {
        // The name is reserved never to exist: RFC 2606.
        let address: Address = "natnet:motive.invalid".parse().expect("an address");
        let error = address.open(Options::default()).err().expect("no such host").to_string();
        assert!(
            error.starts_with("natnet:motive.invalid:1510: the host \"motive.invalid\" is not found"),
            "{error}"
        );
        let log: Address = "log:x".parse().expect("an address");
        assert!(log.open(Options::default()).is_err());
    }
}
