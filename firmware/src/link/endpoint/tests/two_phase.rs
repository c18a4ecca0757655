//! Prepare and commit, over the link.

use super::*;

#[test]
fn prepared_without_a_commit_it_holds() {
    let mut bench = Bench::ready();
    assert_eq!(bench.ask(&prepare(1, 2_000 * MS)), Verdict::Prepared);
    assert_eq!(bench.ask(&prepare(1, 2_000 * MS)), Verdict::Prepared);
    bench.run(2_500 * MS);
    assert_eq!(bench.state(), ModuleState::Ready);
    assert!(bench.is_frozen_at(0.0));
    assert_eq!(bench.ask(&Message::Commit(1)), refused(Refusal::NotPrepared), "late");
    bench.run(3_000 * MS);
    assert!(bench.state() == ModuleState::Ready && bench.is_frozen_at(0.0));
}

#[test]
fn committed_it_runs_and_a_second_commit_is_a_duplicate() {
    let mut bench = Bench::ready();
    assert_eq!(bench.ask(&prepare(1, 2_000 * MS)), Verdict::Prepared);
    assert_eq!(bench.ask(&Message::Commit(9)), refused(Refusal::NotPrepared), "something else");
    assert_eq!(bench.ask(&Message::Commit(1)), Verdict::Accepted);
    assert_eq!(bench.ask(&Message::Commit(1)), Verdict::Duplicate);
    assert_eq!(bench.ask(&prepare(1, 2_000 * MS)), Verdict::Duplicate);
    bench.run(2_001 * MS);
    assert_eq!(bench.state(), ModuleState::Executing);
    assert_eq!(bench.ask(&Message::Commit(1)), Verdict::Duplicate, "while it runs");
    // The next one is prepared meanwhile and runs without a gap; up to the one refused no number is taken any more.
    assert_eq!(bench.ask(&prepare(9, 4_000 * MS)), refused(Refusal::NotPrepared));
    assert_eq!(bench.ask(&prepare(10, 4_000 * MS)), Verdict::Prepared);
    assert_eq!(bench.ask(&Message::Commit(10)), Verdict::Accepted);
    bench.run(4_001 * MS);
    assert_eq!(bench.endpoint.robot.running(bench.endpoint.fleet(bench.now)), Some(10));
}

#[test]
fn a_greater_number_takes_the_place_of_a_prepared_cycle() {
    let mut bench = Bench::ready();
    assert_eq!(bench.ask(&prepare(1, 2_000 * MS)), Verdict::Prepared);
    assert_eq!(bench.ask(&prepare(2, 2_000 * MS)), Verdict::Prepared);
    assert_eq!(bench.ask(&Message::Commit(1)), refused(Refusal::NotPrepared));
    assert_eq!(bench.ask(&prepare(1, 2_000 * MS)), refused(Refusal::NotPrepared), "a refusal is final");
    assert_eq!(bench.ask(&direct(3, 2_000 * MS)), Verdict::Accepted);
    assert_eq!(bench.ask(&prepare(4, 2_000 * MS)), refused(Refusal::Conflict), "it was promised to run");
    assert_eq!(bench.ask(&Message::Commit(3)), Verdict::Duplicate, "it needs none");
    bench.run(2_001 * MS);
    assert_eq!(bench.endpoint.robot.running(bench.endpoint.fleet(bench.now)), Some(3));
}

#[test]
fn a_hold_drops_what_is_prepared_or_committed() {
    for commits in [false, true] {
        let mut bench = Bench::ready();
        assert_eq!(bench.ask(&prepare(1, 2_000 * MS)), Verdict::Prepared);
        if commits {
            assert_eq!(bench.ask(&Message::Commit(1)), Verdict::Accepted);
        }
        bench.say(&Message::Hold);
        assert_eq!(bench.ask(&Message::Commit(1)), refused(Refusal::NotPrepared));
        bench.run(2_001 * MS);
        assert_eq!(bench.state(), ModuleState::Ready);
    }
}

/// What was sent before a hold and comes after it is not wanted any more.
#[test]
fn what_a_hold_has_overtaken_does_not_run() {
    let mut bench = Bench::ready();
    let (cycle, hold) = (bench.host.seal(&direct(1, 2_000 * MS)), bench.host.seal(&Message::Hold));
    assert_eq!([bench.bring(&hold), bench.bring(&cycle)], [Ok(()); 2]);
    assert_eq!(bench.host.listen(bench.now, &mut bench.endpoint), [], "nothing is promised");
    bench.run(1_500 * MS);
    assert_eq!(bench.host.session().outgoing().late, 1);
    assert_eq!(bench.ask(&prepare(2, 2_000 * MS)), Verdict::Prepared);
    let (commit, hold) = (bench.host.seal(&Message::Commit(2)), bench.host.seal(&Message::Hold));
    assert_eq!([bench.bring(&hold), bench.bring(&commit)], [Ok(()); 2]);
    bench.run(2_001 * MS);
    assert_eq!(bench.state(), ModuleState::Ready);
    assert_eq!(bench.host.session().outgoing().late, 2);
}

#[test]
fn a_hold_that_a_cycle_has_overtaken_does_not_drop_it() {
    let mut bench = Bench::ready();
    let (hold, cycle) = (bench.host.seal(&Message::Hold), bench.host.seal(&direct(1, 2_000 * MS)));
    assert_eq!([bench.bring(&cycle), bench.bring(&hold)], [Ok(()); 2]);
    bench.run(2_001 * MS);
    assert_eq!(bench.state(), ModuleState::Executing, "the hold was older");
    assert_eq!(bench.host.session().outgoing().late, 1);
}
