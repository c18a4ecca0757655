//! The table and the picture of the pilot's phases in `host/docs/pilot.md`, generated from the table that the code uses.
//!
//! The file must be what is generated here, byte for byte; `FLOTILLA_WRITE_DOCS=1 cargo test -p host --test pilot_phases` writes it.

use std::collections::BTreeSet;
use std::fmt::Write as _;
use std::path::Path;

use host::run::pilot::phase::{PHASE_TRANSITIONS, PHASES, Phase, PhaseEvent};

/// `FirstSent` → `first sent`.
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

/// The transitions out of a phase.
fn out_of(phase: Phase) -> impl Iterator<Item = (PhaseEvent, Phase)> {
    PHASE_TRANSITIONS.iter().filter(move |line| line.from == phase).map(|line| (line.event, line.to))
}

fn markdown() -> String {
    let mut text = String::from(
        "# Phases of the pilot\n\n\
         Generated from `PHASE_TRANSITIONS` in `host/src/run/pilot/phase.rs`; change that table and run\n\
         `FLOTILLA_WRITE_DOCS=1 cargo test -p host --test pilot_phases`.\n\n\
         ```mermaid\nstateDiagram-v2\n    [*] --> Waiting\n",
    );
    for from in PHASES {
        let targets: BTreeSet<Phase> = out_of(from).map(|(_, to)| to).collect();
        for to in targets {
            let events = out_of(from).filter(|(_, target)| *target == to);
            let events: Vec<String> = events.map(|(event, _)| words(&event)).collect();
            writeln!(text, "    {from:?} --> {to:?}: {}", events.join(", ")).expect("a string");
        }
    }
    text += "    Finished --> [*]\n```\n\n\
             What is not in the table changes nothing.\n\n\
             | in | on | to | why |\n|---|---|---|---|\n";
    let mut rows: Vec<(PhaseEvent, Phase, &str, Vec<String>)> = Vec::new();
    for line in PHASE_TRANSITIONS {
        match rows.iter_mut().find(|(event, to, ..)| (*event, *to) == (line.event, line.to)) {
            Some((.., from)) => from.push(format!("{:?}", line.from)),
            None => rows.push((line.event, line.to, line.why, vec![format!("{:?}", line.from)])),
        }
    }
    for (event, to, why, from) in rows {
        writeln!(text, "| {} | {} | {to:?} | {why} |", from.join(", "), words(&event)).expect("a string");
    }
    text
}

#[test]
fn the_document_is_that_of_the_table() {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("docs/pilot.md");
    if std::env::var_os("FLOTILLA_WRITE_DOCS").is_some() {
        std::fs::write(&path, markdown()).expect("writable");
    }
    let stored = std::fs::read_to_string(&path).unwrap_or_else(|error| panic!("{}: {error}", path.display()));
    assert!(
        stored == markdown(),
        "{} is out of date: run this test with FLOTILLA_WRITE_DOCS=1",
        path.display()
    );
}

#[test]
fn every_phase_is_reached_and_every_run_can_end() {
    for (index, line) in PHASE_TRANSITIONS.iter().enumerate() {
        let again = PHASE_TRANSITIONS[..index]
            .iter()
            .any(|other| (other.from, other.event) == (line.from, line.event));
        assert!(!again, "{:?} has two ways out of {:?}", line.event, line.from);
        assert_eq!(line.from.after(line.event), line.to, "{line:?}");
    }
    let mut reached = BTreeSet::from([Phase::Waiting]);
    while let Some((_, to)) = reached.iter().copied().flat_map(out_of).find(|(_, to)| !reached.contains(to)) {
        reached.insert(to);
    }
    assert_eq!(reached, BTreeSet::from(PHASES));
    for phase in PHASES {
        assert_eq!(phase.after(PhaseEvent::Ended), Phase::Finished, "{phase:?}");
    }
    assert_eq!(out_of(Phase::Finished).count(), 0, "what is over is over");
}

/// What the table does not name changes nothing: a module that stops while none swims, a second step of a plan that was given up.
#[test]
fn an_event_out_of_place_changes_nothing() {
    assert_eq!(Phase::Pausing.after(PhaseEvent::Stopped), Phase::Pausing);
    assert_eq!(Phase::Waiting.after(PhaseEvent::SecondSent), Phase::Waiting);
    assert_eq!(Phase::Turning.after(PhaseEvent::Sent), Phase::Turning);
    assert_eq!(Phase::Finished.after(PhaseEvent::Sent), Phase::Finished);
    let under_way = PHASES.map(Phase::is_under_way);
    assert_eq!(under_way, [false, false, true, true, false]);
}
