//! The picture and the table of the failsafe in `firmware/docs`, generated from the table that the code uses.
//!
//! The files must be what is generated here, byte for byte; `FLOTILLA_WRITE_DOCS=1 cargo test -p firmware --test all failsafe_picture::`
//! writes them. Where things stand in the picture, [`layout`] says: a state or an arrow without a place fails.

mod layout;
mod svg;

use std::collections::{BTreeMap, HashSet, VecDeque};
use std::fmt::Write as _;
use std::path::PathBuf;

use firmware::link::failsafe::{Failsafe, FailsafeEvent, STATES, TRANSITIONS};
use protocol::ModuleState;

use layout::{FRAME, NODES, ROUTES, Route, START};

/// `ClockKnown` → `clock known`.
fn words(name: &impl std::fmt::Debug) -> String {
    let mut words = String::new();
    for c in format!("{name:?}").chars() {
        if c.is_uppercase() && !words.is_empty() {
            words.push(' ');
        }
        words.extend(c.to_lowercase());
    }
    words
}

/// The events between every two states, in the order of the table.
fn arrows() -> Vec<(ModuleState, ModuleState, Vec<FailsafeEvent>)> {
    let mut arrows: Vec<(ModuleState, ModuleState, Vec<FailsafeEvent>)> = Vec::new();
    for t in TRANSITIONS {
        match arrows.iter_mut().find(|(from, to, _)| (*from, *to) == (t.from, t.to)) {
            Some((_, _, events)) => events.push(t.event),
            None => arrows.push((t.from, t.to, vec![t.event])),
        }
    }
    arrows
}

/// A module that has come to `state` by the fewest events.
fn come_to(state: ModuleState) -> Failsafe {
    let mut open = VecDeque::from([Failsafe::new()]);
    let mut seen = HashSet::from([ModuleState::Boot]);
    while let Some(failsafe) = open.pop_front() {
        if failsafe.state() == state {
            return failsafe;
        }
        for event in FailsafeEvent::ALL {
            let mut next = failsafe.clone();
            if next.handle(event).is_some_and(|to| seen.insert(to)) {
                open.push_back(next);
            }
        }
    }
    panic!("nothing leads to {state:?}");
}

fn markdown() -> String {
    let mut text = String::from(
        "# The failsafe\n\n\
         Generated from `TRANSITIONS` in `firmware/src/link/failsafe/transitions.rs`, as is the picture; change that table and run\n\
         `FLOTILLA_WRITE_DOCS=1 cargo test -p firmware --test all failsafe_picture::`.\n\n\
         ![Every state of a module and what leads from one to the other](failsafe.svg)\n\n\
         ## Transitions\n\n\
         What is not in the table changes nothing.\n\n\
         | in | on | to | why |\n|---|---|---|---|\n",
    );
    let mut rows: Vec<(FailsafeEvent, ModuleState, &str, Vec<String>)> = Vec::new();
    for t in TRANSITIONS {
        match rows.iter_mut().find(|(event, to, why, _)| (*event, *to, *why) == (t.event, t.to, t.why)) {
            Some((_, _, _, from)) => from.push(format!("{:?}", t.from)),
            None => rows.push((t.event, t.to, t.why, vec![format!("{:?}", t.from)])),
        }
    }
    for (event, to, why, from) in rows {
        writeln!(text, "| {} | {} | {to:?} | {why} |", from.join(", "), words(&event)).expect("a string");
    }
    text += "\n## What a module may do\n\n\
             As the code answers after the fewest events that lead to the state. Low battery is no state: it refuses cycles in\n\
             every one. While it is Arming, the outputs of an ROV put out neutral whatever is asked of them.\n\n\
             | state | may drive | takes cycles | speaks |\n|---|---|---|---|\n";
    let yes = |is| if is { "yes" } else { "no" };
    for state in STATES {
        let failsafe = come_to(state);
        let takes = failsafe
            .takes_cycles()
            .map_or_else(|refusal| format!("no: {}", words(&refusal)), |()| "yes".into());
        let drives = match state {
            ModuleState::Stopped => stopped(),
            _ => yes(failsafe.may_drive()).into(),
        };
        writeln!(text, "| {state:?} | {drives} | {takes} | {} |", yes(failsafe.announces()))
            .expect("a string");
    }
    text
}

/// What a module does after which of the stops.
fn stopped() -> String {
    let mut after: BTreeMap<String, Vec<String>> = BTreeMap::new();
    for event in FailsafeEvent::ALL {
        let mut failsafe = come_to(ModuleState::Executing);
        if failsafe.handle(event) == Some(ModuleState::Stopped) {
            assert!(!failsafe.may_drive(), "after {event:?}");
            after.entry(words(&failsafe.permission())).or_default().push(words(&event));
        }
    }
    let each = after.iter().map(|(permission, events)| format!("{permission}s after {}", events.join(", ")));
    format!("no: {}", each.collect::<Vec<_>>().join("; "))
}

/// The stored file is what is generated.
fn compare(name: &str, text: &str) {
    let path = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("docs").join(name);
    if std::env::var_os("FLOTILLA_WRITE_DOCS").is_some() {
        std::fs::write(&path, text).expect("writable");
    }
    let stored = std::fs::read_to_string(&path).unwrap_or_else(|error| panic!("{}: {error}", path.display()));
    assert!(stored == text, "{} is out of date: run this test with FLOTILLA_WRITE_DOCS=1", path.display());
}

#[test]
fn the_documents_are_those_of_the_table() {
    compare("failsafe.md", &markdown());
    compare("failsafe.svg", &svg::picture());
}

#[test]
fn every_state_and_every_arrow_has_its_place() {
    for state in STATES {
        let places = NODES.iter().filter(|node| node.state == state).count();
        assert_eq!(places, 1, "{state:?} stands in layout::NODES once");
    }
    for (from, to, _) in arrows() {
        let places = ROUTES.iter().filter(|route| route.from.contains(&from) && route.to == to).count();
        assert_eq!(places, 1, "the arrow from {from:?} to {to:?} stands in layout::ROUTES once");
    }
    for Route { from, to, .. } in &ROUTES {
        let events: Vec<_> = from
            .iter()
            .map(|from| {
                arrows().into_iter().find(|arrow| (arrow.0, arrow.1) == (*from, *to)).map(|arrow| arrow.2)
            })
            .collect();
        assert!(
            events[0].is_some(),
            "layout::ROUTES has an arrow from {from:?} to {to:?}, the table has none"
        );
        assert!(
            events.iter().all(|other| *other == events[0]),
            "{from:?} → {to:?}: drawn as one, but differ"
        );
    }
}

#[test]
fn the_frame_holds_what_its_arrow_leaves() {
    let route = ROUTES.iter().find(|route| route.from.len() > 1).expect("the arrow of the stops");
    for node in &NODES {
        let (inside, outside) = (FRAME.contains(&node.area()), !FRAME.overlaps(&node.area()));
        let leaves = route.from.contains(&node.state);
        assert!(if leaves { inside } else { outside }, "{:?} and the frame", node.state);
    }
}

#[test]
fn nothing_lies_upon_anything() {
    let labels: Vec<_> = ROUTES.iter().map(|route| (route, svg::label_area(route))).collect();
    for (k, (route, label)) in labels.iter().enumerate() {
        let who = format!("the label {:?} → {:?}", route.from, route.to);
        assert!(svg::CANVAS.contains(label), "{who} leaves the picture");
        for node in &NODES {
            assert!(!label.overlaps(&node.area()), "{who} lies upon {:?}", node.state);
        }
        for (other, area) in &labels[..k] {
            assert!(!label.overlaps(area), "{who} lies upon that of {:?} → {:?}", other.from, other.to);
        }
        for other in &ROUTES {
            let hit = other.points().into_iter().find(|&point| label.holds(point));
            assert!(hit.is_none(), "{who} lies upon the arrow {:?} → {:?} at {hit:?}", other.from, other.to);
        }
        assert!(!FRAME.edge_crosses(label), "{who} lies upon the frame");
    }
    for route in &ROUTES {
        for node in &NODES {
            let points = route.points();
            let within = &points[2..points.len() - 2];
            assert!(
                !within.iter().any(|&point| node.area().holds(point)),
                "the arrow {:?} → {:?} crosses {:?}",
                route.from,
                route.to,
                node.state
            );
        }
    }
    assert!(NODES.iter().all(|node| !node.area().holds(START)));
}
