//! One `flotilla module --rov` process over a real socket, in real time. Nothing is asked that does not hold on a machine
//! that is slow and has much else to do.

use std::time::Instant;

use crate::common::{PATIENCE, Process};
use crate::keys::{KEY, keygen};
use link::dispatcher::{Dispatcher, DispatcherEvent};
use link::identity::HostIdentity;
use link::key_file::KeyFile;
use link::udp::UdpRadio;
use protocol::time::{Duration, FleetInstant};
use protocol::units::Newtons;
use protocol::{Connectors, Delivery, MAX_DATAGRAM, ModuleId, ModuleState, Motion, Radio, Refusal, RovCycle};
use sim::rov::remote::RemoteRov;
use tempfile::tempdir;

const REVERSED: [bool; 3] = [false, false, true];

#[test]
fn a_process_thrusts_as_told_and_stops_in_silence() {
    let folder = tempdir().expect("a folder");
    keygen(folder.path());
    let mut radio = UdpRadio::bind("127.0.0.1:0").expect("a port");
    let address = radio.local_address().expect("an address").to_string();
    // Should this test be killed, it ends by itself.
    let arguments =
        ["module", "--rov", "--id", "1", "--host", &address, "--thrusters", "3", "--reversed", "3"];
    let arguments = [&arguments[..], &["--battery", "15", "--duration", "3600", "--key", KEY]].concat();
    let _process = Process::start(folder.path(), &arguments);

    let key = KeyFile::read(&folder.path().join(KEY)).expect("a key file");
    let identity = HostIdentity::new(key).expect("random bytes");
    let mut dispatcher = Dispatcher::new(&[ModuleId(1)], &identity.key, identity.boot);
    let mut remote = RemoteRov::new(&REVERSED);
    let wanted_n = [12.0, -5.0, 7.0];
    let near = |remote: &RemoteRov, thrusts_n: [f64; 3]| {
        remote.thrusts_n().iter().zip(thrusts_n).all(|(shown, wanted)| (shown - wanted).abs() < 0.1)
    };
    let (began, mut number, mut next, mut reached) = (Instant::now(), 0, FleetInstant(0), false);
    let mut buffer = [0; MAX_DATAGRAM];
    loop {
        assert!(began.elapsed() < PATIENCE, "{:?} N, {:?}", remote.thrusts_n(), dispatcher.modules()[0]);
        let now = FleetInstant(began.elapsed().as_micros() as u64);
        while let Some((length, from)) = radio.receive(now, &mut buffer).expect("a radio") {
            let event = dispatcher.handle_datagram(now, from, &buffer[..length]).expect("a datagram");
            match event {
                Some(DispatcherEvent::Reported(0)) => {
                    remote.report(dispatcher.modules()[0].rov_telemetry().expect("a report"), now);
                }
                // Its lease has ended on the way: that is the machine's doing.
                Some(DispatcherEvent::Refused { reason, .. }) => assert_eq!(reason, Refusal::Late),
                _ => {}
            }
        }
        remote.step(now);
        let state = dispatcher.modules()[0].rov_telemetry().map(|report| report.state);
        let ready =
            state.is_some_and(|state| !matches!(state, ModuleState::Unsynchronised | ModuleState::Arming));
        if ready && !reached && now >= next {
            number += 1;
            next = now.after(Duration(50_000));
            let thrusts = wanted_n.iter().map(|&newtons| Newtons(newtons as f32)).collect();
            let motion =
                Motion::Rov(RovCycle { thrusts, lease: Duration(500_000), connectors: Connectors::Closed });
            let start = now.after(Duration(30_000));
            dispatcher.dispatch(now, number, start, &[Some(motion)], Delivery::Direct);
        }
        if !reached {
            dispatcher.handle_timer(now);
            reached = near(&remote, wanted_n);
        } else if near(&remote, [0.0; 3]) && state == Some(ModuleState::Holding) {
            break;
        }
        while let Some((to, datagram)) = dispatcher.poll_transmit(now, &mut buffer) {
            radio.send(now, to, datagram).expect("a radio");
        }
        std::thread::sleep(std::time::Duration::from_millis(2));
    }
    let report = dispatcher.modules()[0].rov_telemetry().expect("a report");
    assert_eq!(report.pulses.len(), 3);
    assert!((report.battery.0 - 15.0).abs() < 1e-6);
    let ledger = dispatcher.modules()[0].ledger();
    assert!(ledger.acknowledged >= 1, "{ledger:?}");
    let link = &dispatcher.modules()[0];
    assert!(link.incoming().is_exact() && link.outgoing().lost == 0, "{link:?}");
    assert_eq!((link.boots(), dispatcher.strays().received), (1, 0));
}

#[test]
fn what_cannot_be_is_one_line() {
    let folder = tempdir().expect("a folder");
    keygen(folder.path());
    for (arguments, wanted) in [
        (&["--battery", "9"][..], "battery_v = 9 V: must lie between 10 and 20"),
        (&["--battery", "NaN"], "battery_v = NaN V"),
        (&["--reversed", "7"], "--reversed 7: there are only 6 thrusters"),
    ] {
        let arguments = [&["module", "--rov", "--id", "1", "--key", KEY][..], arguments].concat();
        let finished = Process::start(folder.path(), &arguments).finish();
        assert_eq!((finished.code, finished.err.len()), (Some(2), 1), "{finished:?}");
        assert!(finished.err[0].contains(wanted) && finished.out.is_empty(), "{finished:?}");
    }
}
