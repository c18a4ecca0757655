use serde_json::json;

use super::*;

fn head() -> Head {
    Head { campaign: "c".to_owned(), fingerprint: "f".to_owned(), shard: 1, shards: 2 }
}

fn row(run: usize) -> Map<String, Value> {
    Map::from_iter([
        ("run squared".to_owned(), json!(run * run)),
        ("mean".to_owned(), json!(0.1 * run as f64)),
    ])
}

#[test]
fn wherever_it_is_cut_off_whole_rows_stay_and_no_other() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("journal");
    let mut journal = Journal::open(&path, &head(), || {}).expect("new");
    let mut ends = vec![std::fs::metadata(&path).expect("there").len()];
    for run in 0..3 {
        journal.add(run, row(run)).expect("written");
        ends.push(std::fs::metadata(&path).expect("there").len());
    }
    drop(journal);
    let whole = std::fs::read(&path).expect("there");
    for length in 0..=whole.len() {
        std::fs::write(&path, &whole[..length]).expect("written");
        let kept = ends.iter().filter(|&&end| end <= length as u64).count().saturating_sub(1);
        let mut journal = Journal::open(&path, &head(), || {}).expect("whatever is torn");
        assert_eq!(journal.rows().len(), kept, "cut at {length}");
        // It goes on behind what is whole.
        for run in kept..3 {
            journal.add(run, row(run)).expect("written");
        }
        assert!(journal.rows().iter().all(|(run, found)| *found == row(*run)));
        drop(journal);
        assert_eq!(std::fs::read(&path).expect("there"), whole, "cut at {length}");
    }
}

#[test]
fn what_is_another_s_is_left_alone() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("journal");
    let mut journal = Journal::open(&path, &head(), || {}).expect("new");
    journal.add(0, row(0)).expect("written");
    let told = |head: &Head| Journal::open(&path, head, || {}).expect_err("refused");
    // A second process waits for the end of the first.
    let (waits, waited) = std::sync::mpsc::channel();
    std::thread::scope(|scope| {
        let second = scope.spawn(|| Journal::open(&path, &head(), || waits.send(()).expect("heard")));
        waited.recv().expect("it waits");
        journal.add(1, row(1)).expect("written");
        drop(journal);
        assert_eq!(second.join().expect("no panic").expect("its turn").rows().len(), 2);
    });
    for other in [
        Head { fingerprint: "g".to_owned(), ..head() },
        Head { shard: 2, ..head() },
        Head { shards: 3, ..head() },
    ] {
        assert!(matches!(told(&other), JournalError::Other { .. }), "{other:?}");
    }
    let text = std::fs::read_to_string(&path).expect("there");
    std::fs::write(&path, format!("{text}{{}}\n")).expect("written");
    assert!(matches!(told(&head()), JournalError::Line { line: 4, .. }));
    // A row that is there twice counts once.
    let last = text.lines().last().expect("a row");
    std::fs::write(&path, format!("{text}{last}\n")).expect("written");
    assert_eq!(Journal::open(&path, &head(), || {}).expect("sound").rows().len(), 2);
}
