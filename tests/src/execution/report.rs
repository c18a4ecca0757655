//! Report of a judge of execution.

use std::fmt;

use super::planned_motion::Phase;

/// Errors of tails in one phase of their motion.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Off {
    /// The greatest, rad.
    pub greatest_rad: f64,
    /// Module (from 0) with the greatest error, and when, s of true time.
    pub at: (usize, f64),
    square_rad2: f64,
    count: u64,
}

impl Off {
    /// Takes in one error, rad, of a module at a time.
    pub fn add(&mut self, error_rad: f64, at: (usize, f64)) {
        if error_rad.abs() > self.greatest_rad {
            (self.greatest_rad, self.at) = (error_rad.abs(), at);
        }
        self.square_rad2 += error_rad * error_rad;
        self.count += 1;
    }

    /// Root mean square, rad; zero without any.
    #[must_use]
    pub fn rms_rad(&self) -> f64 {
        (self.square_rad2 / self.count.max(1) as f64).sqrt()
    }

    /// How many.
    #[must_use]
    pub const fn count(&self) -> u64 {
        self.count
    }

    fn join(&mut self, other: &Self) {
        if other.greatest_rad > self.greatest_rad {
            (self.greatest_rad, self.at) = (other.greatest_rad, other.at);
        }
        self.square_rad2 += other.square_rad2;
        self.count += other.count;
    }
}

/// Contact or near contact of two tails.
#[derive(Clone, Debug, PartialEq)]
pub struct Near {
    /// When first, s of true time.
    pub t_s: f64,
    /// Which modules, from 1.
    pub modules: [usize; 2],
    /// The least distance between their surfaces while it lasted, m.
    pub least_m: f64,
    /// What was promised, m: 0 for a contact.
    pub promised_m: f64,
    /// One of them had lost its power, in a plan that was not tolerant of that.
    pub powerless: bool,
    /// What both were doing, in words.
    pub doing: String,
}

impl fmt::Display for Near {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let [i, j] = self.modules;
        let (least_mm, promised_mm) = (1e3 * self.least_m, 1e3 * self.promised_m);
        write!(
            f,
            "at {:.3} s modules {i} and {j}: {least_mm:.3} mm, promised {promised_mm:.3} mm; {}",
            self.t_s, self.doing
        )
    }
}

/// Findings of a judge in one run, or in many.
#[derive(Clone, Debug)]
pub struct Report {
    /// The least distance between the surfaces of two tails, m; +∞ where no two can meet.
    pub least_m: f64,
    /// The least distance less what the plan guarantees, m.
    pub spare_m: f64,
    /// Tails that touched.
    pub contacts: Vec<Near>,
    /// Tails that came nearer to each other than the plan of the cycle that both ran guarantees.
    pub broken: Vec<Near>,
    /// Errors about the planned angles at the modules' own reckoning of the time, by [`Phase`].
    pub off: [Off; 3],
    /// The greatest error of a module's fleet time while its tail moves, s.
    pub clock_s: f64,
    /// The greatest step from where a tail should rest to where its next order sets out from, rad.
    pub leap_rad: f64,
    /// Ticks that were looked at.
    pub ticks: u64,
}

impl Default for Report {
    fn default() -> Self {
        Self {
            least_m: f64::INFINITY,
            spare_m: f64::INFINITY,
            contacts: Vec::new(),
            broken: Vec::new(),
            off: <[Off; 3]>::default(),
            clock_s: 0.0,
            leap_rad: 0.0,
            ticks: 0,
        }
    }
}

impl Report {
    /// Of one phase.
    #[must_use]
    pub const fn of(&self, phase: Phase) -> &Off {
        &self.off[phase as usize]
    }

    /// The greatest of all phases, rad.
    #[must_use]
    pub fn greatest_rad(&self) -> f64 {
        self.off.iter().map(|off| off.greatest_rad).fold(0.0, f64::max)
    }

    /// Takes in what was found in another run.
    pub fn join(&mut self, other: &Self) {
        self.least_m = self.least_m.min(other.least_m);
        self.spare_m = self.spare_m.min(other.spare_m);
        self.contacts.extend_from_slice(&other.contacts);
        self.broken.extend_from_slice(&other.broken);
        self.off.iter_mut().zip(&other.off).for_each(|(own, other)| own.join(other));
        self.clock_s = self.clock_s.max(other.clock_s);
        self.leap_rad = self.leap_rad.max(other.leap_rad);
        self.ticks += other.ticks;
    }

    /// Contacts but those with a tail that had lost its power in a plan that was not tolerant of that.
    fn promised(&self) -> impl Iterator<Item = &Near> {
        self.contacts.iter().filter(|near| !near.powerless)
    }

    /// What must hold of a run and does not, in words: no contact (see [`Near::powerless`]), no guarantee broken, no tail or clock farther off than `limits`.
    #[must_use]
    pub fn broken_promises(&self, limits: &Limits) -> Vec<String> {
        let mut promises: Vec<String> = Vec::new();
        promises.extend(self.promised().map(|near| format!("contact {near}")));
        promises.extend(self.broken.iter().map(|near| format!("guarantee {near}")));
        for (phase, off) in Phase::ALL.into_iter().zip(&self.off) {
            if off.greatest_rad > limits.tracking_error_rad {
                let (module, t_s) = off.at;
                promises.push(format!(
                    "module {} strays by {:.4} rad at {t_s:.3} s, {}",
                    module + 1,
                    off.greatest_rad,
                    phase.name()
                ));
            }
        }
        if self.clock_s > limits.clock_error_s {
            promises.push(format!("a clock is off by {:.3} ms in motion", 1e3 * self.clock_s));
        }
        promises
    }

    /// Clearance, and how much of the limits was used, by phase.
    #[must_use]
    pub fn table(&self, limits: &Limits) -> String {
        let mm = |m: f64| 1e3 * m;
        let mut table = format!(
            "least clearance {:.3} mm, least above its guarantee {:.3} mm; {} contacts, {} more with tails that had lost their \
             power in plans not tolerant of that; {} guarantees broken\n\
             phase        RMS rad   greatest rad   share of e = {} rad\n",
            mm(self.least_m),
            mm(self.spare_m),
            self.promised().count(),
            self.contacts.len() - self.promised().count(),
            self.broken.len(),
            limits.tracking_error_rad
        );
        for (phase, off) in Phase::ALL.into_iter().zip(&self.off) {
            let share = 100.0 * off.greatest_rad / limits.tracking_error_rad;
            let (name, rms) = (phase.name(), off.rms_rad());
            table += &format!("{name:<12} {rms:>7.4} {:>14.4} {share:>8.1} %\n", off.greatest_rad);
        }
        table
            + &format!(
                "clocks in motion: {:.3} ms, {:.1} % of {} ms; greatest leap between two orders {:.4} rad; {:.0} s looked at",
                mm(self.clock_s),
                100.0 * self.clock_s / limits.clock_error_s,
                mm(limits.clock_error_s),
                self.leap_rad,
                self.ticks as f64 * 1e-3
            )
    }
}

/// Limits of the errors of modules.
#[derive(Clone, Copy, Debug)]
pub struct Limits {
    /// e_s, rad.
    pub tracking_error_rad: f64,
    /// ε_c, s.
    pub clock_error_s: f64,
}
