//! What must not happen, looked for at every tick: cycles of no host or out of their time, neighbours in different cycles, contacts.

use protocol::time::FleetInstant;

use super::{SKEW_US, World};

impl World<'_> {
    pub(super) fn watch_cycles(&mut self, now_us: u64) {
        let now = FleetInstant(now_us);
        let skew_us = SKEW_US + self.storm.jumped_us();
        for module in 0..self.storm.modules {
            let sim = &self.fleet.modules[module];
            let running = sim.running(now);
            let boot = sim.link().and_then(|link| link.host_nonce()).map(|nonce| &nonce.0[..12]);
            let host_run = self.host_runs.iter().rposition(|host_run| Some(&host_run.boot[..]) == boot);
            let running = running.map(|number| (host_run, number));
            self.watch.running[module] = running.and_then(|(host_run, number)| Some((host_run?, number)));
            let Some((host_run, number)) = running else { continue };
            self.watch.powerless[module] = None;
            let Some(host_run) = host_run.map(|host_run| &self.host_runs[host_run]) else {
                self.violation(now_us, &format!("module {} runs a cycle of no host", module + 1));
                continue;
            };
            let host_us = now_us.saturating_sub(host_run.epoch_us);
            let fits = host_run.cycles.get(&number).is_some_and(|&(start_us, end_us, _)| {
                host_us + skew_us >= start_us && host_us <= end_us + skew_us
            });
            if !fits && self.watch.told.insert((module, number)) {
                let span = host_run.cycles.get(&number).copied();
                self.violation(
                    now_us,
                    &format!(
                        "module {} runs cycle {number} at {host_us} µs, decided for {span:?}",
                        module + 1
                    ),
                );
            }
        }
        if let Some(host_run) = self.host_runs.last() {
            let host_us = now_us - host_run.epoch_us;
            let mut now = host_run
                .cycles
                .values()
                .filter(|(start_us, end_us, _)| (*start_us..*end_us).contains(&host_us));
            let tolerant = now.all(|(.., tolerant)| *tolerant);
            self.watch.powerless.iter_mut().flatten().for_each(|so_far| *so_far &= tolerant);
        }
        for k in 0..self.watch.neighbours.len() {
            let pair = self.watch.neighbours[k];
            let both = (self.watch.running[pair.0], self.watch.running[pair.1]);
            let apart = matches!(both, (Some(i), Some(j)) if i != j);
            if !apart {
                self.watch.apart_since.remove(&pair);
                continue;
            }
            let since = *self.watch.apart_since.entry(pair).or_insert(now_us);
            // One may have jumped ahead and the other back.
            if now_us.saturating_sub(since) > skew_us + self.storm.jumped_us() {
                let (i, j) = (pair.0 + 1, pair.1 + 1);
                self.violation(now_us, &format!("modules {i} and {j} run different cycles: {both:?}"));
                self.watch.apart_since.insert(pair, u64::MAX / 2);
            }
        }
    }

    pub(super) fn watch_contacts(&mut self, now_us: u64) {
        for k in self.watch.contacts..self.tank.contacts().len() {
            let contact = &self.tank.contacts()[k];
            let (i, j) = contact.modules;
            let powerless = [self.watch.powerless[i], self.watch.powerless[j]];
            if powerless.into_iter().flatten().any(|tolerant| !tolerant) {
                self.outcome.powerless_contacts += 1;
            } else {
                let what = format!("tails of modules {} and {} touch", i + 1, j + 1);
                self.violation(now_us, &what);
            }
        }
        self.watch.contacts = self.tank.contacts().len();
    }
}
