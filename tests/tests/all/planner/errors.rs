//! Tables (a), (b) and (c) of the same plans: errors, transitions, loss tolerance.

use std::sync::OnceLock;

use modboat::parameters::Parameters;
use modboat::planner_kind::PlannerKind;
use tests::stream::{DemandStream, Kind, Rows, Sequence, on_both_cores, settings};

use super::{EXACT, FAR, NEAR, SHAPES, SHARE, alone, finish, full, structure};

/// Figures of both planners for one stream.
struct Pair {
    shape: &'static str,
    share: f64,
    sequence: Sequence,
    exact: Rows,
    field: Rows,
}

/// The streams that tables (a), (b) and (c) are about, run once.
fn pairs() -> &'static [Pair] {
    static PAIRS: OnceLock<Vec<Pair>> = OnceLock::new();
    PAIRS.get_or_init(|| {
        let kind = Kind::new(Parameters::default());
        let mut jobs = Vec::new();
        for shape in SHAPES {
            for share in [SHARE, 0.8, 0.95] {
                for sequence in [Sequence::Apart, NEAR, FAR] {
                    jobs.push((shape, share, sequence));
                }
            }
        }
        on_both_cores(&jobs, |&(shape, share, sequence)| {
            // What is only printed may be less.
            let promised = share <= SHARE;
            let (walks, each) = match (full(), promised) {
                (true, true) => (20, 500),
                (true, false) => (10, 200),
                (false, true) => (10, 120),
                (false, false) => (10, 25),
            };
            let stream = |planner| {
                let (structure, kind) = (structure(shape), kind.clone());
                DemandStream {
                    structure,
                    kind,
                    config: settings(planner),
                    share,
                    sequence,
                    walks,
                    each,
                    times: 1,
                }
                .run()
            };
            Pair {
                shape,
                share,
                sequence,
                exact: stream(PlannerKind::Exact),
                field: stream(PlannerKind::PotentialField),
            }
        })
    })
}

#[test]
fn table_a_errors() {
    let _alone = alone();
    let (mut table, mut broken) = (String::new(), Vec::new());
    table += "(a) Weighted relative error, demands uniform inside a share of the envelope\n";
    table +=
        "                              |             exact                      |        potential field\n";
    table += "structure  share demands      | plans  <= 1e-6     p99     most planned | plans <= 1e-6 <= 1e-2    p50    p99 planned\n";
    for Pair { shape, share, sequence, exact, field } in pairs() {
        let (own, other) = (exact.quantiles(|row| row.error), field.quantiles(|row| row.error));
        let met = exact.percent(|row| row.error <= EXACT);
        table += &format!(
            "{shape:<10} {:>3.0} % {sequence:<12} | {:>5} {met:>6.2} % {:>7.1e} {:>8.1e} {:>5.1} % | {:>5} {:>5.1} % {:>5.1} % {:>6.4} {:>6.3} {:>5.1} %\n",
            100.0 * share,
            exact.0.len(),
            own.p99,
            own.most,
            exact.percent(|row| row.planned),
            field.0.len(),
            field.percent(|row| row.error <= EXACT),
            field.percent(|row| row.error <= 1e-2),
            other.median,
            other.p99,
            field.percent(|row| row.planned),
        );
        if *share == SHARE && (exact.0.is_empty() || own.most > EXACT) {
            broken.push(format!("{shape}, {sequence}: an error of {:e}, above 1e-6", own.most));
        }
    }
    finish(&table, &broken);
}

#[test]
fn table_b_transitions() {
    let _alone = alone();
    let (mut table, mut broken) = (String::new(), Vec::new());
    table += "(b) Cycles without transition, mean tail travel of a module before a cycle, mean decision interval\n";
    table += "                              |            exact                      |     potential field              | travel\n";
    table += "structure  share demands      |   none two steps  travel   interval | none     travel     interval | ratio\n";
    for Pair { shape, share, sequence, exact, field } in pairs() {
        let still = exact.percent(|row| row.still);
        let travels = [exact, field].map(|rows| rows.mean(|row| row.travel_rad));
        let ratio = travels[0] / travels[1];
        table += &format!(
            "{shape:<10} {:>3.0} % {sequence:<12} | {still:>5.1} % {:>5.1} % {:>7.4} rad {:>6.3} s | {:>4.1} % {:>7.4} rad {:>6.3} s | {ratio:.4}\n",
            100.0 * share,
            exact.percent(|row| row.two_steps),
            travels[0],
            exact.mean(|row| row.interval_s),
            field.percent(|row| row.still),
            travels[1],
            field.mean(|row| row.interval_s),
        );
        // 93.6 % and 97.4 % were seen.
        let least = if *shape == "3x1" { 88.0 } else { 96.0 };
        if *share == SHARE && *sequence == NEAR {
            if still < least {
                broken.push(format!("{shape}, {sequence}: {still:.1} % without transition, not {least} %"));
            }
            // Three modules turn now and then whatever they do, and take what is found quickly.
            let most = if *shape == "3x1" { 0.12 } else { 0.1 };
            if ratio > most {
                broken.push(format!("{shape}, {sequence}: {ratio:.3} of the potential field's travel"));
            }
        }
    }
    finish(&table, &broken);
}

#[test]
fn table_c_loss() {
    let _alone = alone();
    let (mut table, mut broken) = (String::new(), Vec::new());
    table += "(c) Loss tolerant plans, default geometry, `prefer`\n";
    table += "structure  share demands      |    exact | potential field\n";
    for Pair { shape, share, sequence, exact, field } in pairs() {
        let own = exact.percent(|row| row.loss_tolerant);
        table += &format!(
            "{shape:<10} {:>3.0} % {sequence:<12} | {own:>6.2} % | {:>5.1} %\n",
            100.0 * share,
            field.percent(|row| row.loss_tolerant)
        );
        if *share == SHARE && exact.0.iter().any(|row| !row.loss_tolerant) {
            broken.push(format!("{shape}, {sequence}: {own:.2} % loss tolerant, not all"));
        }
    }
    finish(&table, &broken);
}
