//! Flotilla's own messages. Names of fields end with their unit. Fleet time is in whole microseconds, as on the wire; in `stamp`, and as
//! a message's time in the log, it is the same instant.
//!
//! What `summary.json` is made of is here as `float64` or as it was counted, so that it comes out again digit for digit.

use super::message::messages;
use super::ros::Time;

/// The form of the messages below. Another one is another form: a reader refuses what is newer than itself.
pub const FORMAT: u32 = 1;

pub use holds::Holds;
pub use poses::{Poses, Trouble};
pub use rovs::{DeadThrusters, Energy, Move, Moves, PARKED, Pauses, Place, Robot, Robots, Sighted, Sighting};
pub use status::{Bodies, Body, Goal, ModuleStatus, Order, Status};

mod holds;
mod poses;
mod rovs;
mod status;

messages! {
    /// The first message of a log: what was run, by what.
    Scenario = "flotilla_msgs" {
        /// Form of Flotilla's messages.
        format: u32,
        /// Program and version that wrote the log.
        program: String,
        /// modboats, or rovs.
        fleet: String,
        /// Name.
        name: String,
        /// Seed of everything random.
        seed: u64,
        /// When the log was begun, by the clock of the host, s since 1970. Fleet time is near 0 then.
        began_unix_s: f64,
        /// Modules by place: the numbers that persons know them by.
        modules: Vec<u16>,
        /// Everything that was asked, with every value that was not: TOML for Modboats, JSON for ROVs.
        document: String,
    }

    /// Time zero of the run is known: the start of the first cycle, or of the plan.
    Begin = "flotilla_msgs" {
        /// Fleet time.
        stamp: Time,
        /// Time zero, fleet time, us.
        origin_us: u64,
    }

    /// The structure's motion: position of the centre of mass in the world, heading of the surge axis.
    BoatState = "flotilla_msgs" {
        /// Fleet time.
        stamp: Time,
        /// East, north, m.
        position_m: [f64; 2],
        /// Counter-clockwise from east, unwrapped, rad.
        heading_rad: f64,
        /// East, north, m/s.
        velocity_m_s: [f64; 2],
        /// Counter-clockwise, rad/s.
        yaw_rate_rad_s: f64,
    }

    /// One pose of the structure as measured.
    Fix = "flotilla_msgs" {
        /// Fleet time at which it came.
        stamp: Time,
        /// Fleet time at which it was measured, s.
        captured_s: f64,
        /// East, north, m.
        position_m: [f64; 2],
        /// Counter-clockwise from east, rad.
        heading_rad: f64,
    }

    /// Forces and torque in the structure's frame.
    Wrench = "flotilla_msgs" {
        /// Sway, to the right, N.
        fx_n: f64,
        /// Surge, forward, N.
        fy_n: f64,
        /// Yaw, counter-clockwise, N m.
        tau_nm: f64,
    }

    /// What was decided for one cycle: transition and swim cycle of every module. One that is given up is logged again, as it is then.
    Decision = "flotilla_msgs" {
        /// Fleet time of the log's writing.
        stamp: Time,
        /// Which decision of the run, from 0.
        index: u32,
        /// Number of its cycle.
        number: u32,
        /// Start of the transition, fleet time, us.
        start_us: u64,
        /// Length of the transition, all of it, us.
        transition_us: u32,
        /// Of its first step, where it has two: how long it turns, us.
        via_turning_us: u32,
        /// How long it rests then, us.
        via_rest_us: u32,
        /// Length of each ramp from and to rest, by step, s.
        ramps_s: [f64; 2],
        /// Length of the swim cycle, us.
        period_us: u32,
        /// planned, repeated or held.
        outcome: String,
        /// Why nothing moves, where nothing does.
        reason: String,
        /// Asked for.
        demand: Wrench,
        /// What the plan yields.
        commanded: Wrench,
        /// Weighted error of the wrench, relative; in N for a demand of zero.
        error: f64,
        /// Travel of all tails in the transition, rad.
        travel_rad: f64,
        /// Least distance between the surfaces of two tails as planned, m.
        clearance_m: f64,
        /// The same for tails as far off as modules let them be, m.
        guarantee_m: Option<f64>,
        /// Nothing could have met the demand.
        outside_envelope: bool,
        /// It asks for less than the leg, to keep off the edge of the water.
        bounded: bool,
        /// Any modules may miss it.
        loss_tolerant: bool,
        /// Any module may lose its power in it.
        power_tolerant: bool,
        /// Time the planner took, us.
        solve_us: u64,
        /// By module: it was missing, and got nothing.
        missing: Vec<bool>,
        /// Tail before the transition, unwrapped, rad.
        from_rad: Vec<f64>,
        /// Tail between its two steps, where it has two, unwrapped, rad.
        via_rad: Vec<f64>,
        /// Tail after it, unwrapped, rad.
        to_rad: Vec<f64>,
        /// Centerline of the swim cycle, rad.
        centerline_rad: Vec<f64>,
        /// Amplitude of the swim cycle, rad.
        amplitude_rad: Vec<f64>,
    }

    /// What came of a decision.
    Cycle = "flotilla_msgs" {
        /// Fleet time.
        stamp: Time,
        /// Which decision of the run, from 0.
        index: u32,
        /// Number of its cycle.
        number: u32,
        /// Mean wrench of the tails on the water while it was swum.
        achieved: Wrench,
        /// How much of the swim cycle was seen, s.
        swum_s: f64,
    }

    /// A module answered a cycle.
    Acknowledgement = "flotilla_msgs" {
        /// Fleet time at which it came.
        stamp: Time,
        /// Which module.
        module: u16,
        /// Which cycle.
        cycle: u32,
        /// It took it.
        accepted: bool,
        /// Why not.
        reason: String,
    }

    /// Something that happened, in words.
    Event = "flotilla_msgs" {
        /// Fleet time.
        stamp: Time,
        /// The module that it is about; 0 for none.
        module: u16,
        /// What.
        text: String,
    }

    /// The host did not run.
    Gap = "flotilla_msgs" {
        /// Fleet time.
        stamp: Time,
        /// Which one, from 0.
        index: u32,
        /// When it began, fleet time, us.
        start_us: u64,
        /// When it was known again what the modules do, fleet time, us.
        end_us: u64,
    }

    /// Two tails touched. Logged again when they overlap more.
    Contact = "flotilla_msgs" {
        /// Fleet time.
        stamp: Time,
        /// Which one, from 0.
        index: u32,
        /// When it began, fleet time, s.
        began_s: f64,
        /// The two modules.
        modules: [u16; 2],
        /// Deepest overlap so far, m.
        overlap_m: f64,
    }

    /// What was received, by kind.
    Incoming = "flotilla_msgs" {
        /// All.
        received: u32,
        /// Genuine and new.
        accepted: u32,
        /// Had come before.
        duplicate: u32,
        /// From a session that is over.
        stale: u32,
        /// Damaged.
        corrupt: u32,
        /// Not sealed by whom it claims.
        forged: u32,
        /// For another.
        foreign: u32,
    }

    /// How long answers took, ms.
    Answers = "flotilla_msgs" {
        /// How many.
        count: u64,
        /// Half are no longer.
        p50_ms: f64,
        /// Nine of ten are no longer.
        p90_ms: f64,
        /// 99 of 100 are no longer.
        p99_ms: f64,
        /// The longest.
        max_ms: f64,
    }

    /// One module's link.
    Link = "flotilla_msgs" {
        /// Its number.
        module: u16,
        /// Cycles dispatched to it.
        cycles: u64,
        /// Times one was sent again.
        resent: u64,
        /// Cycles it took.
        acknowledged: u64,
        /// Cycles that came after their start.
        late: u64,
        /// Cycles it refused for another reason.
        refused: u64,
        /// Cycles without an answer.
        unanswered: u64,
        /// Datagrams to it.
        datagrams_sent: u64,
        /// Arrived in time.
        datagrams_acknowledged: u64,
        /// Arrived too late.
        datagrams_late: u64,
        /// Did not arrive.
        datagrams_lost: u64,
        /// Datagrams from it.
        from_module: Incoming,
        /// What it says came to it.
        module_received: Option<Incoming>,
        /// From a cycle's first datagram to its answer.
        answer: Answers,
        /// How far its fleet time may be off, us.
        clock_uncertainty_us: Option<u32>,
        /// How much faster fleet time runs than its clock, 1e-9.
        clock_drift_ppb: Option<i32>,
        /// Boots seen.
        boots: u32,
        /// Sessions it has had.
        sessions: u32,
        /// What is wrong with it, a bit each.
        faults: u8,
    }

    /// Every module's link, so far.
    Links = "flotilla_msgs" {
        /// Fleet time.
        stamp: Time,
        /// By place.
        links: Vec<Link>,
    }

    /// What the simulated medium did to datagrams: sent + duplicated + replayed + forged = delivered + lost + under way.
    Medium = "flotilla_msgs" {
        /// Handed over.
        sent: u64,
        /// Vanished.
        lost: u64,
        /// Of those lost: in a burst.
        burst_lost: u64,
        /// Of those lost: thrown away.
        dropped: u64,
        /// Doubled.
        duplicated: u64,
        /// With one bit flipped.
        corrupted: u64,
        /// Shorter than they were.
        truncated: u64,
        /// Held back behind later ones.
        reordered: u64,
        /// Held up in a spike of delay.
        late: u64,
        /// Sent again.
        replayed: u64,
        /// By a stranger: random bytes.
        forged_noise: u64,
        /// By a stranger: changed in the middle.
        forged_remade: u64,
        /// By a stranger: to another address.
        forged_misdirected: u64,
        /// By a stranger: back to whom it came from.
        forged_reflected: u64,
        /// Handed on.
        delivered: u64,
        /// Neither delivered nor lost yet.
        under_way: u64,
    }

    /// What is counted besides, so far.
    Ledger = "flotilla_msgs" {
        /// Fleet time.
        stamp: Time,
        /// Datagrams that no module can be charged with.
        strays: Incoming,
        /// Of the medium, where it is simulated.
        medium: Option<Medium>,
        /// Greatest error of a module's fleet time, where that is known, us.
        clock_error_us: Option<u64>,
        /// Cycles refused.
        refusals: u32,
        /// Least distance between the surfaces of two tails, m; infinite where no two can meet.
        least_clearance_m: Option<f64>,
    }

    /// For how long each leg was swum, so far.
    Legs = "flotilla_msgs" {
        /// Fleet time.
        stamp: Time,
        /// How long it was swum, or held in, by leg, s.
        time_s: Vec<f64>,
        /// For how long of that the fleet held, by leg, s.
        held_s: Vec<f64>,
    }

    /// A module took no part in a leg.
    Absence = "flotilla_msgs" {
        /// Which leg, from 0.
        leg: u32,
        /// Which module, by place from 0.
        place: u32,
        /// Why, as a number.
        reason: u8,
        /// Which faults, or which refusal.
        detail: u8,
        /// Why, in words.
        text: String,
        /// For how long so far, s.
        time_s: f64,
    }

    /// For how long each module took no part, so far.
    Absences = "flotilla_msgs" {
        /// Fleet time.
        stamp: Time,
        /// In the order in which they were met, leg by leg.
        absences: Vec<Absence>,
    }

    /// Modules that were found to push less than the others, so far.
    WeakModules = "flotilla_msgs" {
        /// Fleet time.
        stamp: Time,
        /// Each, by its id.
        module: Vec<u16>,
        /// What it gives of what the others do, as it is planned with now.
        share: Vec<f64>,
        /// When it was found, s after the start of the first cycle.
        at_s: Vec<f64>,
    }

    /// The run is over.
    End = "flotilla_msgs" {
        /// Fleet time.
        stamp: Time,
        /// Why, if before its time.
        why: Option<String>,
        /// How long it took by the wall clock, s.
        wall_s: f64,
    }
}
