//! The table of modules.

use std::collections::VecDeque;

use runlog::flotilla::{Link, Links, ModuleStatus, Status};
use serde_json::{Value, json};

/// The share of datagrams that arrive is taken over so many sets of counts: seconds.
const OVER: usize = 5;
/// A module that was not heard for this time is stale, s.
const STALE_S: f64 = 1.0;

/// See the module's documentation.
#[derive(Default)]
pub struct Modules {
    /// Numbers that persons know them by.
    pub ids: Vec<u16>,
    /// The newest angles of all tails, rad.
    pub tails: Vec<f64>,
    /// By set of counts, by place: datagrams sent, and arrived in time.
    counts: VecDeque<Vec<[u64; 2]>>,
    links: Option<Links>,
}

impl Modules {
    /// Takes in a set of counts.
    pub fn links(&mut self, links: &Links) {
        let count = |link: &Link| [link.datagrams_sent, link.datagrams_acknowledged];
        self.counts.push_back(links.links.iter().map(count).collect());
        if self.counts.len() > OVER {
            self.counts.pop_front();
        }
        self.links = Some(links.clone());
    }

    fn delivered(&self, place: usize) -> Option<f64> {
        let [first, last] = [self.counts.front()?, self.counts.back()?].map(|counts| counts.get(place));
        let ([sent_first, came_first], [sent, came]) = (first?, last?);
        let (sent, came) = (sent.checked_sub(*sent_first)?, came.checked_sub(*came_first)?);
        // What was sent a moment ago is not answered yet.
        (sent > 0).then(|| (came as f64 / sent as f64).min(1.0))
    }

    /// As the page has it.
    #[must_use]
    pub fn show(&self, status: Option<&Status>) -> Vec<Value> {
        let unknown = ModuleStatus::default();
        let one = |(place, id): (usize, &u16)| {
            let said = status.and_then(|status| status.modules.get(place)).unwrap_or(&unknown);
            let link = self.links.as_ref().and_then(|links| links.links.get(place));
            json!({
                "id": id,
                "state": Some(&said.state).filter(|state| !state.is_empty()),
                "faults": said.faults,
                "battery_v": said.battery_v,
                "silent_s": said.silent_s,
                "delivered": self.delivered(place),
                "answer_ms": link.filter(|link| link.answer.count > 0).map(|link| link.answer.p50_ms),
                "clock_us": link.and_then(|link| link.clock_uncertainty_us),
                "tail_rad": self.tails.get(place).copied().or(said.tail_rad),
                "tail_error_rad": said.tail_error_rad,
                "stale": said.silent_s.is_none_or(|silent_s| silent_s > STALE_S),
            })
        };
        self.ids.iter().enumerate().map(one).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_share_that_arrives_is_of_the_last_seconds() {
        let mut modules = Modules { ids: vec![7], ..Modules::default() };
        assert_eq!(modules.show(None)[0]["delivered"], Value::Null);
        // 50 a second; all arrive in the first ten seconds, 40 of 50 after that.
        for second in 0..20_u64 {
            let (sent, came) = (50 * second, 50 * second.min(10) + 40 * second.saturating_sub(10));
            let link = Link { datagrams_sent: sent, datagrams_acknowledged: came, ..Link::default() };
            modules.links(&Links { links: vec![link], ..Links::default() });
            let share = modules.show(None)[0]["delivered"].as_f64();
            if second == 9 {
                assert_eq!(share, Some(1.0));
            }
        }
        assert_eq!(modules.show(None)[0]["delivered"].as_f64(), Some(0.8));
        assert_eq!(
            (&modules.show(None)[0]["state"], modules.show(None)[0]["stale"].as_bool()),
            (&Value::Null, Some(true))
        );
    }
}
