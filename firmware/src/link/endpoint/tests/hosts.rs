//! More than one host, and recordings of any of them.

use super::*;

/// An announcement as it would send it now.
fn announcement(bench: &mut Bench) -> Vec<u8> {
    let link = bench.endpoint.link.as_mut().unwrap();
    let hello = Hello { kind: ModuleKind::Modboat, firmware: VERSION, session: link.session() };
    link.seal_announcement(&hello, &mut [0; protocol::MAX_DATAGRAM]).unwrap().to_vec()
}

/// Another host calls it, and is let in.
fn serve_a_second_host(bench: &mut Bench) {
    bench.host = BenchHost::new(2);
    let announcement = announcement(bench);
    let call = bench.host.call(&announcement);
    assert_eq!(bench.bring(&call), Ok(()));
}

fn is_call(datagram: &[u8]) -> bool {
    protocol::Frame::parse(datagram).unwrap().header.kind == protocol::Kind::Call
}

/// What may not change.
fn inside(bench: &Bench) -> std::string::String {
    let endpoint = &bench.endpoint;
    let session = endpoint.link().map(|link| (link.session(), link.outgoing()));
    std::format!("{:?} {:?} {:?} {session:?}", endpoint.robot, endpoint.failsafe, endpoint.clock)
}

#[test]
fn another_host_waits_until_the_first_is_silent_and_nothing_runs() {
    let mut bench = Bench::ready();
    assert_eq!(bench.ask(&direct(9, 2_000 * MS)), Verdict::Accepted);
    let mut other = BenchHost::new(2);
    let call = other.call(&announcement(&mut bench));
    assert_eq!(bench.bring(&call), Err(Class::Foreign), "the first is heard");
    // From now on the first is silent.
    bench.host.tells_time = false;
    bench.run(3_900 * MS);
    assert!(!bench.endpoint.link().unwrap().hears_host(bench.now));
    assert_eq!(bench.bring(&call), Err(Class::Foreign), "its cycle runs");
    assert_eq!(bench.state(), ModuleState::Executing);
    bench.run(4_010 * MS);
    let pose = bench.reference();
    assert_eq!(bench.bring(&call), Ok(()), "the same call, for its announcement is in force");
    assert_eq!(bench.state(), ModuleState::Unsynchronised, "its time is new");
    assert_eq!(bench.reference(), pose, "the pose is held");
    // The first one has lost it.
    let late = bench.host.seal(&Message::EmergencyStop);
    assert_eq!(bench.bring(&late), Err(Class::Stale));
    let first = std::mem::replace(&mut bench.host, other);
    bench.run(5_000 * MS);
    assert_eq!(bench.state(), ModuleState::Ready);
    assert_eq!(bench.ask(&direct(1, 6_000 * MS)), Verdict::Accepted, "its numbers are new");
    let outgoing = bench.endpoint.link().unwrap().outgoing();
    assert!(outgoing.lost > 0, "what was under way to the first is lost: {outgoing:?}");
    drop(first);
}

#[test]
fn silence_of_a_host_is_measured_to_the_tick() {
    let mut bench = Bench::ready();
    bench.host.tells_time = false;
    bench.say(&Message::Hold);
    let heard = bench.now;
    let call = BenchHost::new(2).call(&announcement(&mut bench));
    bench.run(heard.after(HOST_SILENCE).0 - MS);
    assert_eq!(bench.bring(&call), Err(Class::Foreign));
    bench.run(heard.after(HOST_SILENCE).0);
    assert_eq!(bench.bring(&call), Ok(()));
}

/// Held back, and let in late: they are genuine and new, and say nothing of now.
#[test]
fn what_a_dead_host_said_before_keeps_no_other_out() {
    let mut bench = Bench::ready();
    bench.host.tells_time = false;
    let held: Vec<Vec<u8>> = (0..40).map(|_| bench.host.seal(&Message::Hold)).collect();
    bench.say(&Message::Hold);
    let heard = bench.now;
    let call = BenchHost::new(2).call(&announcement(&mut bench));
    for (k, datagram) in (0..).zip(&held) {
        bench.run(heard.0 + k * 35 * MS);
        assert_eq!(bench.bring(datagram), Ok(()), "{k}");
    }
    bench.run(heard.after(HOST_SILENCE).0);
    assert_eq!(bench.bring(&call), Ok(()));
}

#[test]
fn the_same_life_of_a_host_goes_on_in_another_session() {
    let mut bench = Bench::ready();
    assert_eq!(bench.ask(&direct(1, 1_500 * MS)), Verdict::Accepted);
    bench.host.tells_time = false;
    bench.run(4_000 * MS);
    assert_eq!(bench.state(), ModuleState::Holding);
    let announcement = announcement(&mut bench);
    let call = bench.host.call(&announcement);
    assert_eq!(bench.bring(&call), Ok(()));
    assert_eq!(bench.state(), ModuleState::Holding, "its epoch goes on");
    assert_eq!(bench.ask(&direct(1, 5_000 * MS)), refused(Refusal::Conflict), "and so do its numbers");
    assert_eq!(bench.ask(&direct(2, 5_000 * MS)), Verdict::Accepted);
}

/// A second host runs with a copy of the fleet key.
#[test]
fn a_clone_of_the_host_moves_nothing_while_the_first_is_heard() {
    let mut bench = Bench::ready();
    let mut clone = bench.host.clone_as(2);
    let mut refusals = 0;
    for number in 1..=20 {
        bench.run(bench.now.0 + 250 * MS);
        let before = inside(&bench);
        let call = clone.call(&announcement(&mut bench));
        let mut tries = Vec::from([call]);
        tries.extend([Message::EmergencyStop, Message::Release].map(|m| clone.seal(&m)));
        tries.push(clone.seal(&direct(100 + number, bench.now.0 + 500 * MS)));
        // Under the number of the session in force, too.
        let session = bench.host.session().id();
        let renumbered: Vec<_> = tries.iter().map(|datagram| in_session(datagram, session)).collect();
        for datagram in tries.iter().chain(&renumbered) {
            let class = bench.bring(datagram).unwrap_err();
            assert!(matches!(class, Class::Foreign | Class::Stale | Class::Forged), "{class:?}");
            refusals += 1;
        }
        assert_eq!(inside(&bench), before);
        assert_eq!(bench.state(), ModuleState::Ready);
    }
    let incoming = bench.incoming();
    assert_eq!((incoming.foreign, incoming.stale, incoming.forged), (20, 60, 80));
    assert_eq!(incoming.foreign + incoming.stale + incoming.forged, refusals);
}

#[test]
fn a_whole_session_played_again_after_the_host_has_changed_is_stale() {
    let mut bench = Bench::ready();
    assert_eq!(bench.ask(&direct(1, 1_200 * MS)), Verdict::Accepted);
    bench.run(3_300 * MS);
    bench.say(&Message::EmergencyStop);
    bench.say(&Message::Release);
    bench.run(3_310 * MS);
    let recorded = std::mem::take(&mut bench.host.recorded);
    assert!(recorded.len() > 8);
    for datagram in &recorded {
        assert_eq!(bench.bring(datagram), Err(Class::Duplicate), "in the session itself");
    }
    bench.host.tells_time = false;
    bench.run(6_000 * MS);
    // No host is there: now the recording is played, its call first, and then again to the next host's session.
    for next_host in [false, true] {
        if next_host {
            bench.host = BenchHost::new(2);
            let call = {
                let announcement = announcement(&mut bench);
                bench.host.call(&announcement)
            };
            assert_eq!(bench.bring(&call), Ok(()));
            bench.run(7_000 * MS);
        }
        let before = inside(&bench);
        for datagram in &recorded {
            let expected = match is_call(datagram) {
                _ if !next_host => Class::Duplicate,
                // Not looked at while a host is heard.
                true => Class::Foreign,
                false => Class::Stale,
            };
            assert_eq!(bench.bring(datagram), Err(expected));
        }
        assert_eq!(inside(&bench), before);
    }
    bench.host.tells_time = false;
    bench.run(10_000 * MS);
    let before = inside(&bench);
    for datagram in &recorded {
        assert_eq!(bench.bring(datagram), Err(Class::Stale), "nor when no host is heard");
    }
    assert_eq!(inside(&bench), before);
}

#[test]
fn everything_ever_recorded_is_stale_after_a_reboot() {
    let mut bench = Bench::ready();
    assert_eq!(bench.ask(&prepare(1, 1_200 * MS)), Verdict::Prepared);
    assert_eq!(bench.ask(&Message::Commit(1)), Verdict::Accepted);
    bench.run(3_300 * MS);
    let mut recorded = std::mem::take(&mut bench.host.recorded);
    // Another host's session, of the same boot.
    bench.host.tells_time = false;
    bench.run(5_500 * MS);
    serve_a_second_host(&mut bench);
    bench.run(6_000 * MS);
    assert_eq!(bench.ask(&direct(1, 6_500 * MS)), Verdict::Accepted);
    bench.run(6_600 * MS);
    recorded.append(&mut bench.host.recorded);
    // Power is lost; its clock begins at zero, as then.
    bench = Bench {
        endpoint: Endpoint::new(Some(identity(2)), ModboatRobot::new(TailLimits::default())),
        ..Bench::boot()
    };
    for datagram in &recorded {
        assert_eq!(bench.bring(datagram), Err(Class::Stale), "before it has said a word");
    }
    bench.run(1_000 * MS);
    let before = inside(&bench);
    for datagram in &recorded {
        let expected = if is_call(datagram) { Class::Foreign } else { Class::Stale };
        assert_eq!(bench.bring(datagram), Err(expected), "in the session of its new boot");
    }
    assert_eq!((inside(&bench), bench.state()), (before, ModuleState::Ready));
    let calls = recorded.iter().filter(|datagram| is_call(datagram)).count();
    let incoming = bench.incoming();
    assert_eq!((incoming.stale as usize, incoming.foreign as usize), (2 * recorded.len() - calls, calls));
}

/// A module was taken apart: its key is known, and its fleet's number.
#[test]
fn the_key_of_another_module_opens_nothing() {
    let mut bench = Bench::ready();
    let key = crate::bench_host::fleet_key();
    let stolen = key.module(ModuleId(7));
    let boot = protocol::Frame::parse(&announcement(&mut bench)).unwrap().header.nonce.unwrap();
    let before = inside(&bench);
    for claims in [ModuleId(7), crate::bench_host::MODULE] {
        let nonce = protocol::Nonce([7; 16]);
        let mut thief =
            protocol::Session::new(protocol::Side::Host, key.fleet(), claims, &stolen, &boot, nonce);
        let mut buffer = [0; protocol::MAX_DATAGRAM];
        let mut tries = Vec::from([thief.seal_call(&mut buffer).unwrap().to_vec()]);
        for message in [Message::EmergencyStop, direct(1, 2_000 * MS)] {
            tries.push(thief.seal(&message, &mut buffer).unwrap().to_vec());
        }
        for datagram in tries {
            let renumbered = in_session(&datagram, bench.host.session().id());
            let classes = [bench.bring(&datagram), bench.bring(&renumbered)];
            let foreign = [Err(Class::Foreign); 2];
            let claimed =
                [Err(if is_call(&datagram) { Class::Foreign } else { Class::Stale }), Err(Class::Forged)];
            assert_eq!(classes, if claims == ModuleId(7) { foreign } else { claimed });
        }
    }
    assert_eq!(inside(&bench), before);
}

/// The stop of a host that answers this announcement.
fn stop_for(announcement: &[u8]) -> Vec<u8> {
    let key = crate::bench_host::fleet_key();
    let boot = protocol::Frame::parse(announcement).unwrap().header.nonce.unwrap();
    let module = crate::bench_host::MODULE;
    let mut buffer = [0; protocol::MAX_DATAGRAM];
    protocol::session::seal_stop(key.fleet(), module, &key.module(module), boot, &mut buffer)
        .unwrap()
        .to_vec()
}

/// The operator's second machine, while the first swims the module.
#[test]
fn any_host_of_the_fleet_stops_it_in_mid_cycle_and_only_a_release_ends_it() {
    let mut bench = Bench::ready();
    assert_eq!(bench.ask(&direct(1, 2_000 * MS)), Verdict::Accepted);
    bench.run(2_700 * MS);
    assert_eq!(bench.state(), ModuleState::Executing);
    // A release that was sent before, and comes late.
    let early = bench.host.seal(&Message::Release);
    let stop = stop_for(&announcement(&mut bench));
    let session = bench.endpoint.link().unwrap().session();
    assert_eq!(bench.bring(&stop), Ok(()));
    let permission = bench.endpoint.failsafe().permission();
    assert_eq!((bench.state(), permission), (ModuleState::Stopped, Permission::Brake));
    assert_eq!(bench.endpoint.link().unwrap().session(), session, "whom it serves does not change");
    assert_eq!(bench.bring(&early), Ok(()));
    assert_eq!(bench.state(), ModuleState::Stopped, "the release knew nothing of it");
    assert_eq!(bench.host.session().outgoing().late, 0, "not told yet");
    let said = bench.run(2_701 * MS);
    let told = |m: &Message| matches!(m, Message::Telemetry(t) if t.faults == Faults::EMERGENCY);
    assert!(said.iter().any(told), "it says so at once: {said:?}");
    assert_eq!(bench.bring(&stop), Err(Class::Stale), "played again");
    bench.say(&Message::Release);
    bench.run(2_710 * MS);
    assert_eq!(bench.state(), ModuleState::Ready);
    assert_eq!(bench.bring(&stop), Err(Class::Stale), "and again, after the release");
    assert_eq!(bench.state(), ModuleState::Ready);
    // A reboot of the host is no release.
    let stop = stop_for(&announcement(&mut bench));
    assert_eq!(bench.bring(&stop), Ok(()));
    bench.host.tells_time = false;
    bench.run(5_000 * MS);
    serve_a_second_host(&mut bench);
    bench.run(6_000 * MS);
    assert_eq!(bench.state(), ModuleState::Stopped);
    bench.say(&Message::Release);
    bench.run(6_100 * MS);
    assert_eq!(bench.state(), ModuleState::Ready);
}

/// Damaged, under a right checksum, or of a fleet with another key.
#[test]
fn a_forged_stop_stops_nothing() {
    let mut bench = Bench::ready();
    let good = stop_for(&announcement(&mut bench));
    let before = inside(&bench);
    for bit in 0..(good.len() - 4) * 8 {
        let mut bad = good.clone();
        bad[bit / 8] ^= 1 << (bit % 8);
        // The checksum is made right by putting the session's own number, 0, into its place again.
        if (8..12).contains(&(bit / 8)) {
            continue;
        }
        let bad = in_session(&bad, 0);
        assert!(bench.bring(&bad).is_err(), "bit {bit}");
        assert_eq!((inside(&bench), bench.state()), (before.clone(), ModuleState::Ready), "bit {bit}");
    }
    assert_eq!(bench.bring(&good), Ok(()));
}

/// A stranger answers every announcement with calls of its own.
#[test]
fn forged_calls_are_looked_at_a_few_times_for_each_announcement() {
    let mut bench = Bench::ready();
    let mut thief = bench.host.clone_as(9);
    let forged = |thief: &mut BenchHost, bench: &mut Bench| {
        let mut call = thief.call(&announcement(bench));
        let tag = call.len() - 5;
        call[tag] ^= 1;
        let session = u32::from_le_bytes(call[8..12].try_into().unwrap());
        in_session(&call, session)
    };
    // While its host is heard none is looked at.
    for _ in 0..100 {
        let call = forged(&mut thief, &mut bench);
        assert_eq!(bench.bring(&call), Err(Class::Foreign));
    }
    bench.host.tells_time = false;
    bench.run(4_000 * MS);
    let call = forged(&mut thief, &mut bench);
    for k in 0..100 {
        let expected = if k < CALLS { Class::Forged } else { Class::Stale };
        assert_eq!(bench.bring(&call), Err(expected), "{k}");
    }
    assert_eq!(bench.incoming().forged, u32::from(CALLS));
    // The next announcement is answered by its host.
    serve_a_second_host(&mut bench);
}
