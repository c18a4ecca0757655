//! The figures of a run, for a person.

use std::io::Write;

use link::ledger::Ledger;
use protocol::ledger::{Incoming, Outgoing};

use crate::run::summary::Summary;

/// Prints the figures of a run.
pub(super) fn print(out: &mut impl Write, summary: &Summary) -> std::io::Result<()> {
    let Summary { scenario, modules, seed, duration_s, cycles, .. } = summary;
    writeln!(out, "{scenario}: {modules} modules, {duration_s:.0} s, seed {seed}")?;
    writeln!(out)?;
    writeln!(out, "  leg   demanded m/s      mean of last 60 s    error   heading   RMS after 20 s")?;
    for (index, leg) in summary.legs.iter().enumerate() {
        let [dx, dy] = leg.demand_m_s;
        // What rounds to zero has no sign.
        let [mx, my] = leg.mean_m_s.map(|mean_m_s| (1e4 * mean_m_s).round() / 1e4 + 0.0);
        // Of nothing there is no share.
        let (error, unit) = match leg.demand_m_s {
            [0.0, 0.0] => (1e3 * leg.velocity_error, "mm/s"),
            _ => (100.0 * leg.velocity_error, "%"),
        };
        writeln!(
            out,
            "  {:>3}   {dx:>6.3} {dy:>6.3}     {mx:>8.4} {my:>8.4}   {error:>6.1} {unit:<4}{:>5.2}      {:.3} rad",
            index + 1,
            leg.heading_rad,
            leg.heading_rms_rad
        )?;
    }
    for (index, leg) in summary.legs.iter().enumerate() {
        let Some(station) = &leg.station else { continue };
        let [x, y] = station.position_m;
        let (rms_mm, max_mm) = (1e3 * station.rms_m, 1e3 * station.max_m);
        writeln!(
            out,
            "  {:>3}   station {x:.3} {y:.3}: off by {rms_mm:.1} mm RMS, {max_mm:.1} mm at most after 20 s",
            index + 1
        )?;
    }
    writeln!(out)?;
    writeln!(
        out,
        "  cycles     {} planned, {} repeated, {} held; {} with a transition of {:.2} rad a module on average",
        cycles.planned, cycles.repeated, cycles.held, cycles.with_transition, cycles.mean_travel_rad
    )?;
    writeln!(
        out,
        "  intervals  {:.2} s on average; {:.0} % without transition, {:.0} % loss tolerant, {:.0} % power tolerant",
        cycles.mean_interval_s,
        100.0 * cycles.without_transition_share,
        100.0 * cycles.loss_tolerant_share,
        100.0 * cycles.power_tolerant_share
    )?;
    writeln!(
        out,
        "  planner    {}: wrench error {:.1} % on average{}; {:.2} ms median, {:.2} ms at most",
        summary.planner,
        100.0 * cycles.mean_relative_error,
        match cycles.outside_envelope {
            0 => String::new(),
            count => format!(", {count} demands outside the envelope"),
        } + &match cycles.zero_demands {
            0 => String::new(),
            count => format!(", {:.2} mN for {count} demands of zero", 1e3 * cycles.mean_zero_error_n),
        },
        cycles.solve_us_median as f64 * 1e-3,
        cycles.solve_us_max as f64 * 1e-3
    )?;
    let clearance = match summary.least_clearance_m {
        Some(clearance_m) => format!("tails never closer than {:.1} mm", 1e3 * clearance_m),
        None => "no two tails can meet".to_owned(),
    };
    match summary.contacts.len() {
        // Real water tells of no contact, and real tails are where modules report them.
        _ if summary.poses.is_some() => {}
        0 => writeln!(out, "  contacts   none; {clearance}")?,
        n => writeln!(out, "  contacts   {n}: the structure would have come apart")?,
    }
    let sum = |of: fn(&Ledger) -> u64| -> u64 { summary.link.iter().map(|link| of(&link.ledger)).sum() };
    writeln!(
        out,
        "  link       {} cycles sent, {} acknowledged, {} refused, {} late, {} unanswered; {} sent again",
        sum(|l| l.cycles),
        sum(|l| l.acknowledged),
        sum(|l| l.refused),
        sum(|l| l.late),
        sum(|l| l.unanswered),
        sum(|l| l.resent)
    )?;
    let out_ward = summary.link.iter().fold(Outgoing::default(), |sum, link| sum.plus(&link.to_module));
    writeln!(
        out,
        "  datagrams  {} sent: {} acknowledged, {} late, {} lost, {} under way",
        out_ward.sent,
        out_ward.acknowledged,
        out_ward.late,
        out_ward.lost,
        out_ward.under_way()
    )?;
    let inward = || summary.link.iter().map(|link| &link.from_module).chain([&summary.strays]);
    let sum = |of: fn(&Incoming) -> u32| -> u64 { inward().map(|counts| u64::from(of(counts))).sum() };
    writeln!(
        out,
        "             {} received: {} accepted, {} duplicate, {} stale, {} corrupt, {} forged, {} foreign",
        sum(|i| i.received),
        sum(|i| i.accepted),
        sum(|i| i.duplicate),
        sum(|i| i.stale),
        sum(|i| i.corrupt),
        sum(|i| i.forged),
        sum(|i| i.foreign)
    )?;
    if let Some(poses) = &summary.poses {
        let (frames, bodies) = (&poses.frames, &poses.bodies);
        writeln!(
            out,
            "  poses      {}: {} frames, {} used; {} doubled, {} off the clock, {} out of order, {} frozen, {} without a body",
            poses.source,
            frames.received,
            frames.accepted,
            frames.doubled,
            frames.off_the_clock,
            frames.out_of_order,
            frames.frozen,
            frames.without_body
        )?;
        writeln!(
            out,
            "             {} bodies, {} used; {} untracked, {} not finite, {} teleported",
            bodies.received, bodies.accepted, bodies.untracked, bodies.not_finite, bodies.teleported
        )?;
        let least =
            poses.least_delay_s.map_or("not shown".to_owned(), |s| format!("{:.1} ms at least", 1e3 * s));
        writeln!(
            out,
            "             latency {least}; half of the frames at most {:.0} ms later, 99 % at most {:.0} ms",
            1e3 * poses.late_p50_s,
            1e3 * poses.late_p99_s
        )?;
        for trouble in &poses.troubles {
            writeln!(out, "             held for {:.1} s: {}", trouble.time_s, trouble.reason)?;
        }
    }
    for weak in &summary.weak_modules {
        writeln!(
            out,
            "  weak       module {} pushes {:.0} % of what the others do, as found at {:.1} s",
            weak.module,
            100.0 * weak.share,
            weak.at_s
        )?;
    }
    if let Some(error_us) = summary.clock_error_us {
        writeln!(out, "  clocks     fleet time known to {:.2} ms on every module", error_us as f64 * 1e-3)?;
    }
    if !summary.gaps.is_empty() {
        let length_s: f64 = summary.gaps.iter().map(|gap| gap.length_s).sum();
        writeln!(
            out,
            "  gaps       {}, of {length_s:.1} s in all, in which the host did not run",
            summary.gaps.len()
        )?;
    }
    for shortfall in &summary.shortfalls {
        writeln!(out, "  short of   {shortfall}")?;
    }
    writeln!(out, "  time       {:.2} s for {duration_s:.0} s", summary.wall_s)?;
    writeln!(out)
}
