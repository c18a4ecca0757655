//! QTM RT: the vendor's Python client, and the vendor's C++ client inside libmotioncapture.

use std::net::{Ipv4Addr, SocketAddr};

use mocap::{frame, frames_read, judge, labels};
use pose::frame::{Frame, Label};
use pose::qtm::server::QtmServer;
use pose::server::Server;

const LOCAL: SocketAddr = SocketAddr::new(std::net::IpAddr::V4(Ipv4Addr::LOCALHOST), 0);

/// QTM has names alone; the second body is not tracked.
fn as_qtm(mut frame: Frame) -> Frame {
    frame.bodies.iter_mut().for_each(|body| body.label.number = None);
    frame.bodies[1].tracked = false;
    frame
}

fn server() -> QtmServer {
    let names: Vec<Label> = labels().into_iter().map(|label| Label { number: None, ..label }).collect();
    QtmServer::new(LOCAL, &names).expect("a free port")
}

#[test]
fn the_vendor_s_python_client_reads_our_frames() {
    for component in ["6d", "6dres"] {
        let mut server = server();
        let arguments = ["20".into(), server.address().port().to_string(), component.into()];
        let lines = frames_read(&mut server, "qtm_frames.py", &arguments, as_qtm);
        judge(&lines, 20, |number| as_qtm(frame(number)));
        assert!(lines.iter().all(|line| line.number.is_some() && line.captured_us.is_some()));
    }
}

/// Metres for what was sent in millimetres.
fn in_metres(number: u32) -> Frame {
    let mut frame = as_qtm(frame(number));
    frame.bodies.iter_mut().for_each(|body| body.position *= 1e-3);
    frame
}

#[test]
fn the_vendor_s_cpp_client_reads_our_datagrams() {
    let mut server = server();
    // The client adds one for little-endian numbers.
    let base = format!("port={}", server.address().port() - 1);
    let arguments = ["qualisys", "20", "hostname=127.0.0.1", &base, "enable_pointcloud=0"];
    let lines = frames_read(&mut server, "motioncapture_frames.py", &arguments.map(str::to_owned), as_qtm);
    judge(&lines, 20, in_metres);
}
