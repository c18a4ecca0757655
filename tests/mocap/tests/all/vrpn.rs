//! VRPN: the project's own C++ client inside libmotioncapture, called back and over TCP alone.

use std::net::{Ipv4Addr, SocketAddr};

use mocap::{frame, frames_read, judge, labels};
use pose::frame::{Frame, Label};
use pose::server::Server;
use pose::vrpn::server::VrpnServer;

const LOCAL: SocketAddr = SocketAddr::new(std::net::IpAddr::V4(Ipv4Addr::LOCALHOST), 0);

/// VRPN has names alone, and no tracker that is not seen; the second body is not tracked.
fn as_vrpn(mut frame: Frame) -> Frame {
    frame.bodies.iter_mut().for_each(|body| body.label.number = None);
    frame.bodies[1].tracked = false;
    frame
}

#[test]
fn the_project_s_client_reads_our_trackers() {
    for way in ["", "tcp://"] {
        let names: Vec<Label> = labels().into_iter().map(|label| Label { number: None, ..label }).collect();
        let mut server = VrpnServer::new(LOCAL, &names).expect("a free port");
        let host = format!("hostname={way}127.0.0.1:{}", server.address().port());
        let arguments = ["vrpn".into(), "20".into(), host];
        let lines = frames_read(&mut server, "motioncapture_frames.py", &arguments, as_vrpn);
        // The client shows what has come since it was asked last: a frame at its beginning may be in two parts.
        let whole: Vec<_> = lines.into_iter().filter(|line| line.bodies.len() == 2).collect();
        assert!(whole.len() >= 10, "{} whole frames", whole.len());
        judge(&whole, whole.len(), |number| as_vrpn(frame(number)));
    }
}
