//! The end of a storm: everything that was under way has arrived, and all counts are compared.

use protocol::time::FleetInstant;

use super::strangers::Player;
use super::{THREE_CYCLES_S, TICK_US, World, add};

impl World<'_> {
    /// Lets everything arrive that is on its way, and compares all counts.
    pub(super) fn settle(&mut self, now_us: u64) {
        self.fleet.heal(true);
        let now = FleetInstant(now_us + TICK_US);
        self.fleet.advance(now);
        let host_now = FleetInstant(now.0 - self.host_runs.last().map_or(0, |host_run| host_run.epoch_us));
        self.receive(now, host_now);
        self.count_tape(host_now);
        self.player.listen();
        self.stop_host();
        (0..self.fleet.modules.len()).for_each(|module| self.note_boot(module));
        let host = self.fleet.radio.radio().count();
        let modules = self
            .fleet
            .modules
            .iter()
            .map(|m| m.radio().radio().count())
            .reduce(|a, b| a + b)
            .unwrap_or_default();
        let unheard: u64 = self.fleet.modules.iter().map(|module| module.unheard()).sum();
        let mut heard = [0; 7];
        self.watch.module_received.iter().for_each(|classes| add(&mut heard, *classes));
        let told = self.watch.host_received;
        let failed: Vec<u64> = self.fleet.troubles.iter().map(|trouble| trouble.failed.get()).collect();
        let (host_failed, modules_failed) = (failed[0], failed[1..].iter().sum::<u64>());
        let Player { played, called, came, .. } = self.player;
        let to_hosts = modules.delivered - modules_failed + played - came[1];
        let claims = [
            (
                "datagrams handed to modules",
                host.delivered - host_failed + called,
                heard[0] + unheard + came[0],
            ),
            ("datagrams handed to hosts", to_hosts, told[0] + self.watch.discarded),
            ("datagrams hosts sealed", host.sent, self.watch.host_sent.iter().sum()),
            ("datagrams modules sealed", modules.sent, self.watch.module_sent),
        ];
        for (what, one, other) in claims {
            if one != other {
                self.violation(now_us, &format!("{what}: {one} and {other}"));
            }
        }
        add(&mut heard, told);
        self.outcome.received = heard;
        self.outcome.faults = host + modules;
        let kinds = &mut self.outcome.kinds;
        (kinds.send_errors, kinds.played, kinds.called) = (host_failed + modules_failed, played, called);
        match self.outcome.swam_after_s {
            None => {
                let states: Vec<_> = self.fleet.modules.iter().map(|module| module.state(now)).collect();
                let what = format!(
                    "they do not all swim, long after the medium healed: {states:?}; last decision {:?}, tails {:?}",
                    self.last,
                    self.fleet.modules.iter().map(|m| m.tail().angle_rad).collect::<Vec<_>>()
                );
                self.violation(now_us, &what);
            }
            // A module that was doubled until then is used again once the other has been silent for 3 s.
            Some(s) if s > THREE_CYCLES_S + if self.storm.kinds.double.is_some() { 3.0 } else { 0.0 } => {
                self.violation(now_us, &format!("it took {s:.2} s to swim after the medium healed"));
            }
            Some(_) => {}
        }
    }
}
