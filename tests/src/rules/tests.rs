use super::*;

/// "line: what" of each breach.
fn of(file: &str, source: &str) -> Vec<String> {
    breaches(file, source).iter().map(|b| format!("{}: {}", b.line, b.what)).collect()
}

#[test]
fn an_import_against_the_stream_is_found_at_its_line() {
    let source =
        "//! crate::run is spoken of here.\n\nuse std::sync::Arc;\nuse crate::run::record::PoseSample;\n";
    assert_eq!(
        of("host/src/sim/tank.rs", source),
        ["4: host::sim must not import host::run (crate::run::record::PoseSample)"]
    );
    assert_eq!(of("host/src/run/pilot.rs", source), [""; 0]);
    assert_eq!(
        breaches("host/src/sim/tank.rs", source)[0].to_string(),
        "host/src/sim/tank.rs:4: host::sim must not import host::run (crate::run::record::PoseSample)"
    );
}

#[test]
fn nested_and_renamed_imports_and_paths_in_the_text_are_found() {
    let source = "pub use crate::{\n    modboat::tail::Tail as T,\n    link::{faults::Faulty, udp},\n};\n\
                  fn f() -> crate::cli::Failure { super::super::sim::go(\"crate::run\", 'x') }\n";
    assert_eq!(
        of("host/src/modboat/transition/search.rs", source),
        [
            "3: host::modboat must not import host::link (crate::link::faults::Faulty)",
            "3: host::modboat must not import host::link (crate::link::udp)",
            "5: host::modboat must not import host::cli (crate::cli::Failure)",
        ]
    );
    // From one level up, `super::super` is the package.
    assert_eq!(
        of("host/src/modboat/plan.rs", source)[3],
        "5: host::modboat must not import host::sim (super::super::sim::go)"
    );
    assert_eq!(of("host/src/modboat/mod.rs", "use firmware::modboat::limits::Violation;").len(), 1);
    assert_eq!(
        of("host/src/sim/module.rs", "use firmware::modboat::limits::Violation;\nuse protocol::Radio;").len(),
        0
    );
    assert_eq!(of("firmware/src/lib.rs", "fn f(_: host::quantity::Range) {}").len(), 1);
    assert_eq!(of("protocol/src/frame.rs", "use ::firmware::modboat::limits;").len(), 1);
    assert_eq!(of("host/src/main.rs", "fn main() { host::cli::main() }").len(), 0);
    assert_eq!(of("host/src/newcomer.rs", "use crate::modboat::tail::Tail;").len(), 1);
}

#[test]
fn the_judge_takes_data_and_no_code_from_the_planner() {
    let source = "use crate::rov::{plan::Plan, pose::Pose};\nuse crate::rov::configuration::adjacency;\n\
                  fn f() { crate::rov::clearance::length([0.0; 3]); }\nuse crate::rov::*;\nuse super::Judge;\n";
    assert_eq!(
        of("host/src/verify/balance.rs", source),
        [
            "2: host::verify takes only data from host::rov, not crate::rov::configuration::adjacency",
            "3: host::verify takes only data from host::rov, not crate::rov::clearance::length",
            "4: host::verify takes only data from host::rov, not crate::rov",
        ]
    );
    assert_eq!(of("host/src/run/pilot.rs", "use crate::rov::configuration::adjacency;").len(), 0);
}

#[test]
fn std_stays_out_of_what_the_module_runs() {
    let source = "use core::fmt;\n#[cfg(test)]\nextern crate std;\nuse std::vec::Vec;\nfn f() { alloc::vec::Vec::new(); }\n\
                  #[cfg(test)]\nmod tests {\n    use std::rc::Rc;\n    fn g() { if true { std::process::abort() } }\n}\n\
                  fn late() { std::println!() }\n";
    assert_eq!(
        of("firmware/src/modboat/servo.rs", source),
        [
            "4: firmware must not use std (std::vec::Vec)",
            "5: firmware must not use alloc (alloc::vec::Vec::new)",
            "11: firmware must not use std (std::println)",
        ]
    );
}

#[test]
fn planners_are_pure() {
    let source = "use std::time::Instant;\nuse std::{f64::consts::PI, net::UdpSocket};\nfn f(now: Instant) {\n    \
                  std::thread::spawn(|| ());\n    println!(\"{now:?}\");\n}\n";
    assert_eq!(
        of("host/src/modboat/plan.rs", source),
        [
            "1: a planner must not use std::time::Instant",
            "2: a planner must not use std::net::UdpSocket",
            "3: a planner must not use Instant",
            "4: a planner must not use std::thread::spawn",
            "5: a planner must not print (println!)",
        ]
    );
    assert_eq!(of("host/src/grid/theta.rs", source).len(), 5);
    assert_eq!(of("host/src/run/pilot.rs", source).len(), 0);
    let table = "use std::fs;\nfn f() { std::thread::scope(|_| ()); std::time::Instant::now(); }";
    assert_eq!(of("host/src/modboat/table.rs", table), ["2: a planner must not use std::time::Instant::now"]);
}

#[test]
fn comments_literals_and_lifetimes_are_not_code() {
    let source = "/* use crate::run; /* nested */ use crate::run; */\n// use crate::run::x;\n\
                  const A: &str = \"use crate::run::x; \\\" crate::run::x\";\nconst B: &str = r#\"crate::run::x \" \"#;\n\
                  const C: char = '\"';\nconst D: char = '\\'';\nfn f<'a>(x: &'a str) -> &'a str { x }\nuse crate::run::y;\n";
    assert_eq!(
        of("host/src/sim/body.rs", source),
        ["8: host::sim must not import host::run (crate::run::y)"]
    );
}

#[test]
fn test_modules_in_files_of_their_own_are_named() {
    let source = "#[cfg(test)]\nextern crate std;\n\n#[cfg(test)]\npub(crate) mod plant;\nmod tail;\n#[cfg(test)]\nmod tests;\n";
    assert_eq!(test_modules(source), ["plant", "tests"]);
}
