//! The fuzz targets of `firmware/fuzz` without the fuzzer: their corpora replayed, so that a finding stays found, and
//! random input.

#[path = "../../fuzz/src/lib.rs"]
mod fuzz;

use proptest::prelude::*;

/// Every file of a corpus.
fn corpus(target: &str) -> Vec<(String, Vec<u8>)> {
    let folder = format!("{}/fuzz/corpus/{target}", env!("CARGO_MANIFEST_DIR"));
    let entries = std::fs::read_dir(&folder).unwrap_or_else(|error| panic!("{folder}: {error}"));
    let mut files: Vec<_> = entries
        .map(|entry| entry.expect("readable").path())
        .map(|path| (path.display().to_string(), std::fs::read(&path).expect("readable")))
        .collect();
    files.sort();
    assert!(files.len() >= 24, "only {} files in {folder}", files.len());
    files
}

#[test]
fn the_corpora_are_replayed() {
    let mut met = fuzz::endpoint::Met::default();
    for (file, bytes) in corpus("endpoint") {
        println!("{file}");
        let once = fuzz::endpoint::run(&bytes);
        met.executing += once.executing;
        met.stopped += once.stopped;
        met.accepted += once.accepted;
        met.rejected += once.rejected;
    }
    println!("{met:?}");
    assert!(
        met.executing > 5_000 && met.stopped > 1_000 && met.accepted > 300 && met.rejected > 100,
        "{met:?}"
    );
    for (file, bytes) in corpus("configuration") {
        println!("{file}");
        fuzz::configuration::run(&bytes);
    }
}

/// Steps as the target reads them, the useful ones often.
fn steps() -> impl Strategy<Value = Vec<u8>> {
    let bytes = prop::collection::vec(any::<u8>(), 0..40);
    let step = prop_oneof![
        1 => bytes.clone().prop_map(|bytes| [&[0, bytes.len() as u8], &bytes[..]].concat()),
        2 => (0_u8..15, bytes).prop_map(|(variant, bytes)| {
            [&[1, bytes.len() as u8 + 1, variant], &bytes[..]].concat()
        }),
        3 => any::<u8>().prop_map(|index| vec![2, index]),
        2 => any::<u8>().prop_map(|command| vec![3, command]),
        6 => any::<u8>().prop_map(|ms| vec![4, ms]),
        4 => any::<[u8; 4]>().prop_map(|[a, b, c, d]| vec![5, a, b, c, d]),
        3 => any::<u8>().prop_map(|command| vec![6, command]),
        1 => any::<u8>().prop_map(|what| vec![7, what]),
    ];
    prop::collection::vec(step, 1..40).prop_map(|steps| [vec![1], steps.concat()].concat())
}

/// The same of an ROV.
fn steps_of_an_rov() -> impl Strategy<Value = Vec<u8>> {
    let bytes = prop::collection::vec(any::<u8>(), 0..40);
    let step = prop_oneof![
        1 => bytes.clone().prop_map(|bytes| [&[0, bytes.len() as u8], &bytes[..]].concat()),
        2 => (0_u8..15, bytes).prop_map(|(variant, bytes)| {
            [&[1, bytes.len() as u8 + 1, variant], &bytes[..]].concat()
        }),
        3 => any::<u8>().prop_map(|index| vec![2, index]),
        4 => any::<[u8; 3]>().prop_map(|[a, b, c]| vec![3, a, b, c]),
        6 => any::<u8>().prop_map(|ticks| vec![4, ticks % 64]),
        2 => any::<u8>().prop_map(|command| vec![5, command]),
        1 => any::<u8>().prop_map(|what| vec![6, what]),
        1 => any::<u8>().prop_map(|what| vec![7, what]),
    ];
    prop::collection::vec(step, 1..40).prop_map(|steps| [vec![1], steps.concat()].concat())
}

/// Thrust, a stop in it, a release and thrust again, an output that fails: the runs go somewhere.
#[test]
fn an_rov_is_driven_and_stopped() {
    let thrust = [3, 200, 60, 100, 4, 60];
    let met =
        fuzz::rov::run(&[&[1][..], &thrust, &[5, 1, 4, 20, 5, 2, 4, 60], &thrust, &[6, 0, 4, 60]].concat());
    assert!(met.thrust > 100 && met.stopped > 40, "{met:?}");
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 2_000, max_shrink_time: 20_000, ..ProptestConfig::default() })]

    #[test]
    fn a_modboat_keeps_its_word_whatever_happens(steps in steps()) {
        fuzz::endpoint::run(&steps);
    }

    #[test]
    fn an_rov_keeps_its_word_whatever_happens(steps in steps_of_an_rov()) {
        fuzz::rov::run(&steps);
    }

    #[test]
    fn and_an_rov_whatever_the_bytes(bytes in prop::collection::vec(any::<u8>(), 0..300)) {
        fuzz::rov::run(&bytes);
    }

    #[test]
    fn and_whatever_the_bytes(bytes in prop::collection::vec(any::<u8>(), 0..300)) {
        fuzz::endpoint::run(&bytes);
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(20_000))]

    #[test]
    fn no_block_of_flash_panics(
        bytes in prop::collection::vec(any::<u8>(), 0..300), place in any::<prop::sample::Index>(), value: u8,
    ) {
        fuzz::configuration::run(&bytes);
        // A good one with another byte.
        let good = include_bytes!("../../fuzz/corpus/configuration/modboat");
        let mut content = good[8..good.len() - 4].to_vec();
        let at = place.index(content.len());
        content[at] = value;
        fuzz::configuration::run(&content);
    }
}
