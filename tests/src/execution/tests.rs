use super::*;

/// Two modules side by side; both decisions are the same: rest for half a second, then swing about north.
fn motion(guarantee_m: Option<f64>) -> PlannedMotion {
    let north = std::f64::consts::FRAC_PI_2;
    let step = Step { to_rad: vec![north + 1.0; 2], turning_s: 0.0, ramp_s: 0.0, rest_s: 0.0 };
    let from_rad = step.to_rad.clone();
    PlannedMotion {
        number: 1,
        start_s: 1.0,
        from_rad,
        steps: vec![step],
        swings: vec![[north, 1.0]; 2],
        period_s: 1.5,
        guarantee_m,
        power_tolerant: true,
    }
}

const CELLS: [[i32; 2]; 2] = [[0, 0], [1, 0]];

fn seen(angle_rad: f64, runs: Option<u32>) -> Seen {
    Seen { angle_rad, powered: true, runs, clock_error_s: 0.0 }
}

/// Both swing as planned, the second one `off_rad` off and `late_s` late, of which its clock is to blame for `clock_s`.
fn swing(guarantee_m: Option<f64>, off_rad: f64, late_s: f64, clock_s: f64) -> Report {
    let mut judge = Judge::new(&Modboat::default(), &CELLS);
    let motion = motion(guarantee_m);
    judge.decided(0, motion.clone());
    for k in 1_000..2_500 {
        let t_s = f64::from(k) * 1e-3;
        let rad = |module: usize, t_s: f64| motion.planned(module, 1, t_s).expect("its number").0;
        let second = Seen {
            clock_error_s: clock_s,
            ..seen(rad(1, t_s - late_s) + off_rad + 4.0 * std::f64::consts::PI, Some(1))
        };
        judge.observe(t_s, &[seen(rad(0, t_s), Some(1)), second]);
    }
    judge.report()
}

#[test]
fn what_is_as_planned_is_found_so() {
    let report = swing(Some(0.03), 0.0, 0.0, 0.0);
    assert!(report.greatest_rad() < 1e-9 && report.contacts.is_empty() && report.broken.is_empty());
    // Parallel, at most 1 rad off north: one's tip beside the other's axis, 0.15·sin(1) − 0.09 m along them and 0.15·cos(1) across.
    let least_m = (0.15 * 1.0_f64.sin() - 0.09).hypot(0.15 * 1.0_f64.cos()) - 0.015;
    assert!((report.least_m - least_m).abs() < 1e-6, "{} {least_m}", report.least_m);
    assert!((report.spare_m - (report.least_m - 0.03)).abs() < 1e-12);
    assert_eq!(report.of(Phase::Swing).count(), 2 * 1_500);
}

#[test]
fn an_error_is_told_from_a_clock_that_is_off() {
    let strays = swing(None, 0.02, 0.0, 0.0);
    assert!((strays.of(Phase::Swing).greatest_rad - 0.02).abs() < 1e-9);
    assert!((strays.of(Phase::Swing).rms_rad() - 0.02 * 0.5_f64.sqrt()).abs() < 1e-6);
    assert_eq!(strays.of(Phase::Rest).count(), 0);
    let late = swing(None, 0.0, 0.002, -0.002);
    assert!(late.greatest_rad() < 1e-4 && (late.clock_s - 0.002).abs() < 1e-12, "{late:?}");
    // 2π/1.5 s · 1 rad · 2 ms.
    let lags = swing(None, 0.0, 0.002, 0.0);
    assert!((lags.of(Phase::Swing).greatest_rad - 0.008_38).abs() < 1e-4, "{lags:?}");
    let limits = Limits { tracking_error_rad: 0.018, clock_error_s: 0.001 };
    assert_eq!(strays.broken_promises(&limits).len(), 1);
    assert_eq!(late.broken_promises(&limits).len(), 1);
    assert!(lags.broken_promises(&limits).is_empty());
}

#[test]
fn a_guarantee_that_is_not_kept_is_told_once() {
    let report = swing(Some(0.075), 0.0, 0.0, 0.0);
    assert_eq!((report.broken.len(), report.contacts.len()), (3, 0), "at both ends, and at half the period");
    assert_eq!(report.broken[0].modules, [1, 2]);
}

/// Between two ticks both tails pass each other, and are apart at both.
#[test]
fn a_contact_between_two_ticks_is_seen() {
    let mut judge = Judge::new(&Modboat::default(), &CELLS);
    let west = std::f64::consts::PI;
    judge.observe(0.000, &[seen(0.22, None), seen(west + 0.22, None)]);
    judge.observe(0.001, &[seen(-0.22, None), seen(west - 0.22, None)]);
    judge.observe(0.002, &[seen(-0.22, None), seen(west - 0.22, None)]);
    let report = judge.report();
    assert_eq!(report.contacts.len(), 1, "{report:?}");
}

/// One that never had the order rests where it was; one that booted again rests where it was found; without power nothing is
/// expected.
#[test]
fn a_module_that_runs_nothing_is_expected_to_rest() {
    let mut judge = Judge::new(&Modboat::default(), &CELLS);
    let motion = motion(None);
    let start_rad = motion.from_rad[0];
    judge.observe(0.9, &[seen(start_rad, None), seen(1.0, None)]);
    judge.decided(0, motion.clone());
    let mid_rad = motion.planned(0, 1, 1.3).expect("its number").0;
    judge.observe(1.3, &[seen(mid_rad, Some(1)), seen(1.01, None)]);
    let off = Seen { powered: false, ..seen(0.3, None) };
    judge.observe(1.301, &[off, seen(1.01, None)]);
    judge.observe(1.4, &[seen(0.25, None), seen(1.01, None)]);
    judge.observe(1.5, &[seen(0.26, None), seen(1.01, None)]);
    let report = judge.report();
    assert!((report.of(Phase::Rest).greatest_rad - 0.01).abs() < 1e-12, "{report:?}");
    assert_eq!((report.of(Phase::Rest).count(), report.of(Phase::Swing).count()), (8, 1));
}
