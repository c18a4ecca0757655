//! What happened: events, decisions and the trail, the newest of each.

use std::collections::{BTreeMap, VecDeque};

use runlog::flotilla::{Contact, Cycle, Decision, Event, Gap, Order, Robots};
use runlog::message::Message as _;
use serde_json::{Value, json};

use super::boats::{Point, components};

/// Events and decisions that are kept, of each.
const KEPT: usize = 500;
/// Points that are kept.
const POINTS: usize = 4000;
/// Time between two points, ns.
const POINT_EVERY_NS: u64 = 500_000_000;

/// See the module's documentation.
#[derive(Default)]
pub struct History {
    origin_ns: Option<u64>,
    events: VecDeque<Value>,
    decisions: BTreeMap<u32, Decision>,
    achieved: BTreeMap<u32, [f64; 3]>,
    trail: VecDeque<Value>,
    point_ns: Option<u64>,
    fresh_events: Vec<Value>,
    /// Decisions that are new or have changed.
    fresh: Vec<u32>,
}

impl History {
    /// Time zero is known.
    pub fn begin(&mut self, origin_ns: u64) {
        self.origin_ns = Some(origin_ns);
    }

    /// Time of the run, s, if its beginning is known.
    #[must_use]
    pub fn t_s(&self, at_ns: u64) -> Option<f64> {
        self.origin_ns.map(|origin_ns| (at_ns as f64 - origin_ns as f64) * 1e-9)
    }

    fn event(&mut self, at_ns: u64, sort: &str, module: u16, text: String) {
        let event = json!({
            "fleet_s": at_ns as f64 * 1e-9,
            "t_s": self.t_s(at_ns),
            "module": Some(module).filter(|module| *module != 0),
            "text": text,
            "sort": sort,
        });
        keep(&mut self.events, event.clone(), KEPT);
        self.fresh_events.push(event);
    }

    /// Takes in a message of `topic`, if it is of these.
    pub fn take(&mut self, topic: &str, at_ns: u64, data: &[u8]) {
        match topic {
            "/event" => {
                if let Ok(Event { module, text, .. }) = Event::read(data) {
                    self.event(at_ns, "event", module, text);
                }
            }
            "/order" => {
                if let Ok(Order { by, what, followed, text, .. }) = Order::read(data) {
                    let verb = if followed { "" } else { " refused" };
                    self.event(at_ns, "order", 0, format!("{by}: {what}{verb}: {text}"));
                }
            }
            "/gap" => {
                if let Ok(Gap { start_us, end_us, .. }) = Gap::read(data) {
                    let length_s = end_us.saturating_sub(start_us) as f64 * 1e-6;
                    self.event(at_ns, "gap", 0, format!("the host did not run for {length_s:.1} s"));
                }
            }
            "/contact" => {
                if let Ok(Contact { modules: [a, b], overlap_m, .. }) = Contact::read(data) {
                    let overlap_mm = 1e3 * overlap_m;
                    let text = format!("tails of {a} and {b} touched: {overlap_mm:.1} mm deep");
                    self.event(at_ns, "contact", a, text);
                }
            }
            "/decision" => {
                if let Ok(decision) = Decision::read(data) {
                    let index = decision.index;
                    self.decisions.insert(index, decision);
                    if self.decisions.len() > KEPT {
                        let oldest = self.decisions.pop_first();
                        oldest.map(|(index, _)| self.achieved.remove(&index));
                    }
                    self.renew(index);
                }
            }
            "/cycle" => {
                if let Ok(Cycle { index, achieved, .. }) = Cycle::read(data)
                    && self.decisions.contains_key(&index)
                {
                    self.achieved.insert(index, components(&achieved));
                    self.renew(index);
                }
            }
            _ => {}
        }
    }

    fn renew(&mut self, index: u32) {
        if !self.fresh.contains(&index) {
            self.fresh.push(index);
        }
    }

    fn is_due(&mut self, at_ns: u64) -> bool {
        let due = self.point_ns.is_none_or(|last_ns| at_ns >= last_ns.saturating_add(POINT_EVERY_NS));
        if due {
            self.point_ns = Some(at_ns);
        }
        due
    }

    /// Where the structure is.
    pub fn boat(&mut self, at_ns: u64, [x, y, heading]: Point) {
        if self.is_due(at_ns) {
            let point = json!([self.t_s(at_ns), x, y, heading]);
            keep(&mut self.trail, point, POINTS);
        }
    }

    /// Where robots are. Time zero of a plan is told with each.
    pub fn robots(&mut self, at_ns: u64, robots: &Robots) {
        let since_ns = (robots.t_s.clamp(0.0, 1e9) * 1e9) as u64;
        self.origin_ns.get_or_insert(at_ns.saturating_sub(since_ns));
        if self.is_due(at_ns) {
            for robot in &robots.robots {
                let [x, y, z, ..] = robot.eta;
                keep(&mut self.trail, json!([robots.t_s, robot.id, x, y, z]), POINTS);
            }
        }
    }

    fn decision(&self, decision: &Decision) -> Value {
        let span_s = |us: u32| f64::from(us) * 1e-6;
        json!({
            "index": decision.index,
            "number": decision.number,
            "start_s": self.t_s(decision.start_us.saturating_mul(1000)),
            "transition_s": span_s(decision.transition_us),
            "period_s": span_s(decision.period_us),
            "outcome": decision.outcome,
            "reason": decision.reason,
            "demand": components(&decision.demand),
            "commanded": components(&decision.commanded),
            "achieved": self.achieved.get(&decision.index),
            "error": decision.error,
            "bounded": decision.bounded,
            "loss_tolerant": decision.loss_tolerant,
            "power_tolerant": decision.power_tolerant,
            "missing": decision.missing,
            "solve_us": decision.solve_us,
        })
    }

    /// The newest wrench that was demanded and commanded, and the newest that was achieved; nothing before a decision.
    #[must_use]
    pub fn wrench(&self) -> Option<Value> {
        let (_, decision) = self.decisions.last_key_value()?;
        Some(json!({
            "demanded": components(&decision.demand),
            "commanded": components(&decision.commanded),
            "achieved": self.achieved.last_key_value().map(|(_, achieved)| achieved),
        }))
    }

    /// All that is kept.
    #[must_use]
    pub fn all(&self) -> Value {
        let decisions: Vec<Value> = self.decisions.values().map(|decision| self.decision(decision)).collect();
        json!({ "kind": "history", "trail": self.trail, "events": self.events, "decisions": decisions })
    }

    /// What is new since the last call, a message each.
    pub fn fresh(&mut self) -> Vec<Value> {
        let mut messages = Vec::new();
        if !self.fresh_events.is_empty() {
            messages.push(json!({ "kind": "events", "events": std::mem::take(&mut self.fresh_events) }));
        }
        if !self.fresh.is_empty() {
            let fresh = std::mem::take(&mut self.fresh);
            let known = fresh.iter().filter_map(|index| self.decisions.get(index));
            let decisions: Vec<Value> = known.map(|decision| self.decision(decision)).collect();
            messages.push(json!({ "kind": "decisions", "decisions": decisions }));
        }
        messages
    }
}

fn keep(all: &mut VecDeque<Value>, one: Value, most: usize) {
    if all.len() >= most {
        all.pop_front();
    }
    all.push_back(one);
}

#[cfg(test)]
mod tests {
    use runlog::cdr::Encoder;

    use super::*;

    fn bytes(message: &impl runlog::message::Message) -> Vec<u8> {
        let mut encoder = Encoder::default();
        message.write(&mut encoder);
        encoder.bytes().to_vec()
    }

    #[test]
    fn what_happens_is_told_once_and_kept_up_to_a_limit() {
        let mut history = History::default();
        history.begin(1_000_000_000);
        for second in 0..600_u64 {
            let event = Event { module: 3, text: format!("event {second}"), ..Event::default() };
            history.take("/event", second * 1_000_000_000, &bytes(&event));
        }
        let [told] = history.fresh().try_into().expect("one message");
        assert_eq!(told["events"].as_array().map(Vec::len), Some(600));
        assert!(history.fresh().is_empty());
        let all = history.all();
        let kept = all["events"].as_array().expect("events");
        assert_eq!((kept.len(), &kept[0]["text"]), (KEPT, &json!("event 100")));
        assert_eq!(kept[0]["t_s"], json!(99.0));
    }

    #[test]
    fn a_decision_is_told_again_when_its_cycle_is_over() {
        let mut history = History::default();
        let decision = Decision { index: 4, outcome: "planned".to_owned(), ..Decision::default() };
        history.take("/decision", 0, &bytes(&decision));
        assert_eq!(history.fresh()[0]["decisions"][0]["achieved"], Value::Null);
        history.take("/cycle", 0, &bytes(&Cycle { index: 4, ..Cycle::default() }));
        history.take("/cycle", 0, &bytes(&Cycle { index: 5, ..Cycle::default() }));
        let told = history.fresh();
        assert_eq!(told[0]["decisions"].as_array().map(Vec::len), Some(1));
        assert_eq!(told[0]["decisions"][0]["achieved"], json!([0.0, 0.0, 0.0]));
    }

    #[test]
    fn a_trail_has_two_points_a_second_and_an_end() {
        let mut history = History::default();
        for tick in 0..(20 * 2100_u64) {
            history.boat(tick * 50_000_000, [0.0; 3]);
        }
        assert_eq!(history.all()["trail"].as_array().map(Vec::len), Some(POINTS));
        let mut short = History::default();
        for tick in 0..=200 {
            short.boat(tick * 50_000_000, [0.0; 3]);
        }
        assert_eq!(short.all()["trail"].as_array().map(Vec::len), Some(21));
    }
}
