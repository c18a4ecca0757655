//! Which message goes by which topic.

use runlog::flotilla;
use runlog::reader::{Entry, LogError};
use runlog::ros;
use runlog::writer::{FileWriter, Topic};

/// An enum of borrowed messages, a variant a topic, and the topics of a file that is being written.
macro_rules! topics {
    (
        $(#[doc = $doc:literal])* $name:ident, $topics:ident {
            $($(#[doc = $comment:literal])* $variant:ident, $field:ident: $message:ty = $topic:literal;)*
        }
    ) => {
        $(#[doc = $doc])*
        #[derive(Clone, Copy, Debug)]
        pub enum $name<'a> {
            $($(#[doc = $comment])* $variant(&'a $message),)*
        }

        #[derive(Default)]
        pub(super) struct $topics {
            $($field: Option<Topic<$message>>,)*
        }

        impl $topics {
            pub(super) fn write(
                &mut self,
                writer: &mut FileWriter,
                at_ns: u64,
                message: $name<'_>,
            ) -> std::io::Result<()> {
                match message {
                    $($name::$variant(message) => {
                        let topic = super::topic(&mut self.$field, writer, $topic)?;
                        writer.write(topic, at_ns, message)
                    })*
                }
            }
        }

        impl $name<'_> {
            /// Hands the message of a log to `take`, if it is one of these.
            ///
            /// # Errors
            /// [`LogError::Message`] for one that is none of its topic's type.
            pub fn of(entry: &Entry<'_>, take: impl FnOnce($name<'_>)) -> Result<(), LogError> {
                match entry.topic {
                    $($topic => take($name::$variant(&entry.read()?)),)*
                    _ => {}
                }
                Ok(())
            }
        }
    };
}

topics! {
    /// What figures and pictures are made of.
    Told, ToldTopics {
        /// What is run.
        Scenario, scenario: flotilla::Scenario = "/scenario";
        /// Time zero.
        Begin, begin: flotilla::Begin = "/begin";
        /// The true motion, where the water is simulated.
        Truth, truth: flotilla::BoatState = "/truth/state";
        /// The motion as the observer has it.
        Estimate, estimate: flotilla::BoatState = "/estimate/state";
        /// Actual angles of all tails.
        Tails, tails: ros::JointState = "/tails";
        /// A decision, or what is left of one.
        Decision, decision: flotilla::Decision = "/decision";
        /// A cycle that is over.
        Cycle, cycle: flotilla::Cycle = "/cycle";
        /// The host did not run.
        Gap, gap: flotilla::Gap = "/gap";
        /// Two tails touched.
        Contact, contact: flotilla::Contact = "/contact";
        /// Links so far.
        Links, links: flotilla::Links = "/links";
        /// Counts so far.
        Ledger, ledger: flotilla::Ledger = "/ledger";
        /// What a motion capture sent, so far.
        Poses, poses: flotilla::Poses = "/poses";
        /// Legs so far.
        Legs, legs: flotilla::Legs = "/legs";
        /// Absences so far.
        Absences, absences: flotilla::Absences = "/absences";
        /// Why the fleet held, so far; nothing where it did not.
        Holds, holds: flotilla::Holds = "/holds";
        /// Modules that push less than the others, so far; nothing where there is none.
        WeakModules, weak_modules: flotilla::WeakModules = "/weak_modules";
        /// All ROVs.
        Robots, robots: flotilla::Robots = "/robots";
        /// Moves so far.
        Moves, moves: flotilla::Moves = "/moves";
        /// Gaps in the time of a plan so far.
        Pauses, pauses: flotilla::Pauses = "/pauses";
        /// Thrusters that give nothing, so far; nothing where there is none.
        DeadThrusters, dead_thrusters: flotilla::DeadThrusters = "/dead_thrusters";
        /// What was ordered.
        Order, order: flotilla::Order = "/order";
        /// The end.
        End, end: flotilla::End = "/end";
    }
}

topics! {
    /// What others' tools look at.
    Shown, ShownTopics {
        /// Frames that move.
        Transforms, transforms: ros::TFMessage = "/tf";
        /// Frames that do not.
        Fixed, fixed: ros::TFMessage = "/tf_static";
        /// The observer's motion.
        Odometry, odometry: ros::Odometry = "/odom";
        /// The true motion.
        TrueOdometry, true_odometry: ros::Odometry = "/truth/odom";
        /// Where to.
        Target, target: ros::PoseStamped = "/target";
        /// The wrench asked for.
        Demanded, demanded: ros::WrenchStamped = "/wrench/demanded";
        /// The wrench of the plan.
        Commanded, commanded: ros::WrenchStamped = "/wrench/commanded";
        /// The wrench on the water.
        Achieved, achieved: ros::WrenchStamped = "/wrench/achieved";
        /// How modules are.
        Diagnostics, diagnostics: ros::DiagnosticArray = "/diagnostics";
        /// Bodies and tails.
        Markers, markers: ros::MarkerArray = "/markers";
        /// Poses as they were measured.
        Fix, fix: flotilla::Fix = "/fix";
        /// Answers of modules.
        Acknowledgement, acknowledgement: flotilla::Acknowledgement = "/acknowledgement";
        /// How the run stands.
        Status, status: flotilla::Status = "/status";
        /// What the fleet is steered by.
        Goal, goal: flotilla::Goal = "/goal";
        /// ROVs as a motion capture sees them.
        Sighting, sighting: flotilla::Sighting = "/sighting";
        /// Bodies as a motion capture sees them.
        Bodies, bodies: flotilla::Bodies = "/bodies";
        /// What happened, in words.
        Event, event: flotilla::Event = "/event";
    }
}
