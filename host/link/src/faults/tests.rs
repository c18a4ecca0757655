//! What a listener at the other end sees of every fault, against what was asked for and what was counted.

use std::collections::HashMap;

use crc::{CRC_32_ISO_HDLC, Crc};

use super::flight::UNDER_WAY_MAX;
use super::*;
use crate::loopback::{Ether, LoopbackRadio, Node};

const HOST: Node = Node(0);
const MODULE: Node = Node(1);
const OTHER: Node = Node(2);
/// After this everything sent with the delays below has arrived, ms.
const TAIL_MS: u64 = 2_000;

/// Every fault at once.
const STORM: FaultParameters = FaultParameters {
    loss: 0.1,
    burst: 0.15,
    burst_s: 0.05,
    duplication: 0.1,
    corruption: 0.1,
    truncation: 0.1,
    delay_s: 0.002,
    jitter_s: 0.01,
    reordering: 0.1,
    reorder_s: 0.03,
    late: 0.05,
    late_s: 0.3,
    replay: 0.2,
    replay_s: 0.5,
    forgery: 0.3,
};

/// Sends 0, 1, 2 … a millisecond apart and returns (arrival in ms, number) in order of arrival.
fn flood(parameters: FaultParameters, seed: u64, datagrams: u32) -> (Vec<(u64, u32)>, FaultCount) {
    let ether = Ether::default();
    let mut host = Faulty::new(ether.radio(HOST), parameters, seed);
    let mut module = ether.radio(MODULE);
    let mut arrivals = Vec::new();
    for ms in 0..u64::from(datagrams) + TAIL_MS {
        let now = FleetInstant(ms * 1000);
        if let Ok(number) = u32::try_from(ms)
            && number < datagrams
        {
            host.send(now, MODULE, &number.to_le_bytes()).unwrap();
        }
        let mut buffer = [0; 16];
        assert_eq!(host.receive(now, &mut buffer), Ok(None), "nothing is sent to the host");
        while let Ok(Some((4, HOST))) = module.receive(now, &mut buffer) {
            arrivals.push((ms, u32::from_le_bytes(buffer[..4].try_into().unwrap())));
        }
    }
    (arrivals, host.count())
}

/// Sixteen bytes that say which they are, twice over so that no few changed bytes make another one, and their checksum.
fn sealed(number: u64, sender: u8) -> Vec<u8> {
    let mut datagram = vec![1, sender];
    datagram.extend_from_slice(&number.to_le_bytes());
    datagram.extend_from_slice(&number.wrapping_mul(0x9E37_79B9_7F4A_7C15).to_le_bytes()[2..]);
    let checksum = Crc::<u32>::new(&CRC_32_ISO_HDLC).checksum(&datagram);
    datagram.extend_from_slice(&checksum.to_le_bytes());
    datagram
}

fn has_right_checksum(datagram: &[u8]) -> bool {
    datagram.split_last_chunk().is_some_and(|(body, end)| {
        Crc::<u32>::new(&CRC_32_ISO_HDLC).checksum(body) == u32::from_le_bytes(*end)
    })
}

/// A host that speaks to two modules, one of which answers over a perfect medium.
struct Bench {
    host: Faulty<LoopbackRadio>,
    module: LoopbackRadio,
    other: LoopbackRadio,
    now_ms: u64,
    /// (arrival in ms, where, bytes)
    arrivals: Vec<(u64, Node, Vec<u8>)>,
}

impl Bench {
    fn new(parameters: FaultParameters, seed: u64) -> Self {
        let ether = Ether::default();
        let host = Faulty::new(ether.radio(HOST), parameters, seed);
        let (module, other) = (ether.radio(MODULE), ether.radio(OTHER));
        Self { host, module, other, now_ms: 0, arrivals: Vec::new() }
    }

    /// Even milliseconds go to one module, odd ones to the other.
    fn addressee(ms: u64) -> Node {
        if ms.is_multiple_of(2) { MODULE } else { OTHER }
    }

    fn step(&mut self, sends: bool) {
        let (ms, now) = (self.now_ms, FleetInstant(self.now_ms * 1000));
        let mut buffer = [0; 600];
        if sends {
            self.host.send(now, Self::addressee(ms), &sealed(ms, 0)).unwrap();
            self.module.send(now, HOST, &sealed(ms, 1)).unwrap();
        }
        while self.host.receive(now, &mut buffer).unwrap().is_some() {}
        for (radio, node) in [(&mut self.module, MODULE), (&mut self.other, OTHER)] {
            while let Some((length, from)) = radio.receive(now, &mut buffer).unwrap() {
                assert_eq!(from, HOST);
                self.arrivals.push((ms, node, buffer[..length].to_vec()));
            }
        }
        let count = self.host.count();
        assert!(count.is_balanced(), "{ms} ms: {count:?}");
        assert_eq!(count.delivered, self.arrivals.len() as u64, "{ms} ms: {count:?}");
        self.now_ms += 1;
    }

    fn run(parameters: FaultParameters, seed: u64, datagrams: u64) -> Self {
        parameters.validate().unwrap();
        let mut bench = Self::new(parameters, seed);
        (0..datagrams).for_each(|_| bench.step(true));
        (0..TAIL_MS).for_each(|_| bench.step(false));
        let count = bench.host.count();
        assert_eq!((count.sent, count.under_way), (datagrams, 0), "seed {seed}");
        bench
    }

    fn count(&self) -> FaultCount {
        self.host.count()
    }
}

#[track_caller]
fn assert_share(number: u64, of: u64, share: f64) {
    let measured = number as f64 / of as f64;
    let tolerance = 5.0 * (share * (1.0 - share) / of as f64).sqrt();
    assert!((measured - share).abs() <= tolerance, "{number} of {of} is {measured}, not {share}");
}

#[test]
fn a_perfect_medium_changes_nothing() {
    let (arrivals, count) = flood(FaultParameters::default(), 1, 500);
    assert!(arrivals.iter().copied().eq((0..500).map(|number| (u64::from(number), number))));
    assert_eq!(count, FaultCount { sent: 500, delivered: 500, ..FaultCount::default() });
}

#[test]
fn every_datagram_is_accounted_for() {
    let parameters = FaultParameters {
        loss: 0.3,
        duplication: 0.1,
        delay_s: 0.010,
        jitter_s: 0.050,
        ..Default::default()
    };
    for seed in 0..5 {
        let (arrivals, count) = flood(parameters, seed, 5_000);
        assert_eq!(arrivals.len() as u64, count.sent - count.lost + count.duplicated, "seed {seed}");
        assert_share(count.lost, count.sent, 0.3);
        assert!(arrivals.windows(2).any(|pair| pair[1].1 < pair[0].1), "seed {seed}: jitter reorders");
        for (ms, number) in arrivals {
            assert!((10..=61).contains(&(ms - u64::from(number))), "seed {seed}: {number} came at {ms} ms");
        }
    }
}

#[test]
fn every_datagram_is_accounted_for_in_a_storm() {
    let mut sum = FaultCount::default();
    for seed in 0..20 {
        sum = sum + Bench::run(STORM, seed, 2_000).count();
    }
    assert!(sum.is_balanced(), "{sum:?}");
    assert!(sum.lost > sum.burst_lost && sum.burst_lost > 0 && sum.dropped == 0, "{sum:?}");
    let kept = sum.sent - sum.lost;
    for number in [sum.duplicated, sum.corrupted, sum.truncated, sum.reordered, sum.late, sum.replayed] {
        assert!(number > kept / 50, "{sum:?}");
    }
    let forged = sum.forged;
    for number in [forged.noise, forged.remade, forged.misdirected, forged.reflected] {
        assert_share(number, forged.total(), 0.25);
    }
    assert_share(forged.total(), sum.sent, 0.3);
    assert_share(sum.replayed, sum.sent, 0.2);
}

#[test]
fn a_seed_reproduces_a_run() {
    let parameters = FaultParameters { loss: 0.2, corruption: 0.2, jitter_s: 0.02, ..Default::default() };
    assert_eq!(flood(parameters, 7, 300), flood(parameters, 7, 300));
    assert_ne!(flood(parameters, 7, 300), flood(parameters, 8, 300));
    let storm = |seed| {
        let bench = Bench::run(STORM, seed, 500);
        (bench.count(), bench.arrivals)
    };
    assert_eq!(storm(7), storm(7));
    assert_ne!(storm(7), storm(8));
}

/// Seeds stand in other tests and in what was published: new faults must not change what the old ones draw.
#[test]
fn what_a_seed_draws_stays() {
    let parameters = FaultParameters {
        loss: 0.3,
        duplication: 0.2,
        corruption: 0.1,
        delay_s: 0.01,
        jitter_s: 0.05,
        ..Default::default()
    };
    let (arrivals, count) = flood(parameters, 7, 1000);
    assert_eq!((count.lost, count.duplicated, count.corrupted), (294, 134, 86));
    let first = [(20, 8), (20, 6), (28, 5), (29, 12), (36, 17), (37, 10), (40, 19), (42, 18)];
    assert_eq!(arrivals[..8], first);
    let mixed = arrivals.iter().fold(0_u64, |sum, &(ms, number)| {
        sum.wrapping_mul(31).wrapping_add(ms).wrapping_mul(31).wrapping_add(u64::from(number))
    });
    assert_eq!(mixed, 3_123_911_334_939_244_333);
}

#[test]
fn a_burst_takes_everything() {
    let parameters = FaultParameters { burst: 0.2, burst_s: 0.1, duplication: 0.1, ..Default::default() };
    let bench = Bench::run(parameters, 3, 100_000);
    let count = bench.count();
    assert_eq!(count.lost, count.burst_lost);
    let share = count.lost as f64 / count.sent as f64;
    assert!((share - 0.2).abs() < 0.03, "{share} of the time");
    let mut heard = vec![false; 100_000];
    bench.arrivals.iter().for_each(|(ms, ..)| heard[*ms as usize] = true);
    let silences = heard.windows(2).filter(|pair| pair[0] && !pair[1]).count();
    let mean_ms = count.lost as f64 / silences as f64;
    assert!((mean_ms / 100.0 - 1.0).abs() < 0.15, "{mean_ms} ms");
}

#[test]
fn damaged_ones_are_changed_and_cut_ones_shorter() {
    let parameters = FaultParameters { truncation: 0.2, ..Default::default() };
    let bench = Bench::run(parameters, 1, 20_000);
    let mut lengths = [0_u64; 21];
    for (ms, _, datagram) in &bench.arrivals {
        assert_eq!(sealed(*ms, 0)[..datagram.len()], datagram[..], "what is left is unchanged");
        lengths[datagram.len()] += 1;
    }
    let cut = bench.count().truncated;
    assert_eq!(lengths[..20].iter().sum::<u64>(), cut);
    assert_share(cut, 20_000, 0.2);
    assert!(lengths[..20].iter().all(|&number| number > cut / 40), "every length: {lengths:?}");

    let parameters = FaultParameters { corruption: 0.2, ..Default::default() };
    let bench = Bench::run(parameters, 1, 20_000);
    let changed = bench.arrivals.iter().filter(|(ms, _, datagram)| sealed(*ms, 0) != *datagram).count();
    assert_eq!(changed as u64, bench.count().corrupted);
    // Nothing can be cut off, or flipped in, a datagram without bytes.
    let mut host =
        Bench::new(FaultParameters { truncation: 1.0, corruption: 1.0, ..Default::default() }, 1).host;
    host.send(FleetInstant(0), MODULE, &[]).unwrap();
    host.send(FleetInstant(0), MODULE, &[7]).unwrap();
    assert_eq!((host.count().truncated, host.count().corrupted), (1, 0));
}

#[test]
fn some_are_held_back_and_some_are_late() {
    let held = FaultParameters { reordering: 0.1, reorder_s: 0.02, ..Default::default() };
    let late = FaultParameters { late: 0.1, late_s: 1.0, ..Default::default() };
    for (parameters, least_ms, greatest_ms) in [(held, 20, 20), (late, 0, 1001)] {
        let bench = Bench::run(parameters, 1, 20_000);
        let delays = bench
            .arrivals
            .iter()
            .map(|(ms, _, datagram)| ms - u64::from_le_bytes(datagram[2..10].try_into().unwrap()));
        let delayed: Vec<u64> = delays.filter(|&delay_ms| delay_ms > 0).collect();
        let count = bench.count();
        // A spike shorter than the step cannot be seen.
        assert!(count.reordered + count.late - delayed.len() as u64 <= count.late / 100);
        assert_share(count.reordered + count.late, 20_000, 0.1);
        assert!(delayed.iter().all(|delay_ms| (least_ms..=greatest_ms).contains(delay_ms)));
    }
}

#[test]
fn a_replay_is_an_earlier_one_to_the_same_address_as_it_was() {
    let parameters = FaultParameters { replay: 0.1, replay_s: 0.5, corruption: 0.1, ..Default::default() };
    let bench = Bench::run(parameters, 2, 20_000);
    let (mut replays, mut oldest_ms) = (0, 0);
    for (ms, node, datagram) in &bench.arrivals {
        let number = u64::from_le_bytes(datagram[2..10].try_into().unwrap());
        if number < *ms && *datagram == sealed(number, 0) {
            replays += 1;
            assert_eq!(*node, Bench::addressee(number));
            oldest_ms = oldest_ms.max(ms - number);
        }
    }
    assert_eq!(replays, bench.count().replayed);
    assert_share(replays, 20_000, 0.1);
    assert!((600..=757).contains(&oldest_ms), "{oldest_ms} ms: 256 back and half a second");
}

#[test]
fn a_forgery_is_what_it_is_counted_as() {
    let bench = Bench::run(FaultParameters { forgery: 0.5, ..Default::default() }, 4, 20_000);
    let mut seen = ForgeryCount::default();
    let mut genuine = HashMap::new();
    for (ms, node, datagram) in &bench.arrivals {
        let number = datagram.get(2..10).map(|bytes| u64::from_le_bytes(bytes.try_into().unwrap()));
        let number = number.filter(|number| number <= ms);
        if !has_right_checksum(datagram) {
            assert!((1..=512).contains(&datagram.len()));
            seen.noise += 1;
        } else if number.is_some_and(|number| *datagram == sealed(number, 1)) {
            assert_eq!(*node, MODULE, "to whom it came from");
            seen.reflected += 1;
        } else if let Some(number) = number.filter(|&number| *datagram == sealed(number, 0)) {
            if *node == Bench::addressee(number) {
                *genuine.entry(number).or_insert(0) += 1;
            } else {
                seen.misdirected += 1;
            }
        } else {
            assert_eq!((datagram.len(), &datagram[..2]), (20, &[1, 0][..]));
            seen.remade += 1;
        }
    }
    assert_eq!(seen, bench.count().forged);
    assert!(genuine.len() == 20_000 && genuine.values().all(|&times| times == 1));
    assert_share(seen.total(), 20_000, 0.5);
    for number in [seen.noise, seen.remade, seen.misdirected, seen.reflected] {
        assert_share(number, seen.total(), 0.25);
    }
}

#[test]
fn one_without_a_record_forges_noise() {
    let mut host = Bench::new(FaultParameters { forgery: 1.0, loss: 1.0, ..Default::default() }, 1).host;
    (0..50).for_each(|ms| host.send(FleetInstant(ms * 1000), MODULE, &sealed(ms, 0)).unwrap());
    let count = host.count();
    assert_eq!(count.forged, ForgeryCount { noise: 50, ..Default::default() });
    assert_eq!((count.lost, count.delivered), (50, 50));
}

#[test]
fn the_weather_changes() {
    for drop_under_way in [false, true] {
        let mut bench = Bench::new(STORM, 5);
        (0..1000).for_each(|_| bench.step(true));
        let before = bench.count();
        bench.host.heal(drop_under_way);
        assert_eq!(*bench.host.parameters(), FaultParameters::default());
        let (dropped, left) = if drop_under_way { (before.under_way, 0) } else { (0, before.under_way) };
        assert!(before.under_way > 20);
        assert_eq!((bench.count().dropped, bench.count().under_way), (dropped, left));
        (0..1000).for_each(|_| bench.step(true));
        let after = bench.count();
        assert_eq!(after.lost, before.lost + dropped);
        assert_eq!((after.under_way, after.delivered), (0, before.delivered + left + 1000));
        let at_once = bench.arrivals.iter().filter(|(ms, node, datagram)| {
            *ms >= 1000 && *node == Bench::addressee(*ms) && *datagram == sealed(*ms, 0)
        });
        assert_eq!(at_once.count(), 1000);
        bench.host.set_parameters(FaultParameters { loss: 1.0, ..Default::default() });
        (0..100).for_each(|_| bench.step(true));
        assert_eq!(bench.count().lost, after.lost + 100);
    }
}

#[test]
fn no_more_are_under_way_than_there_is_room_for() {
    let mut host = Bench::new(FaultParameters { delay_s: 1e6, ..Default::default() }, 1).host;
    (0..UNDER_WAY_MAX as u64 + 10).for_each(|us| host.send(FleetInstant(us), MODULE, &[1]).unwrap());
    let count = host.count();
    assert_eq!((count.under_way, count.dropped, count.lost), (UNDER_WAY_MAX as u64, 10, 10));
    assert!(count.is_balanced());
}
