//! A source and its gate: fixes from one call, and figures of what came.

use crate::figures::Figures;
use crate::frame::Label;
use crate::gate::{Fix, Gate};
use crate::ledger::{FrameFault, Ledger};
use crate::source::{Source, SourceError, Status};
use crate::time::HostInstant;

/// What one call gave.
#[derive(Clone, Debug, PartialEq)]
pub enum Event {
    /// A frame that was accepted.
    Fix(Fix),
    /// A frame that was dropped, and why.
    Dropped(FrameFault),
}

/// A source behind its gate.
pub struct Feed {
    source: Box<dyn Source>,
    gate: Gate,
    figures: Figures,
    newest_s: Option<f64>,
}

impl Feed {
    /// Around a source.
    pub fn new(source: Box<dyn Source>, gate: Gate) -> Self {
        Self { source, gate, figures: Figures::default(), newest_s: None }
    }

    /// The next frame's fate, if one has come; to be called until it gives `None`.
    ///
    /// # Errors
    /// What waiting does not mend.
    pub fn poll(&mut self, now: HostInstant) -> Result<Option<Event>, SourceError> {
        let arrival = self.source.poll(now)?;
        if let Some(exchange) = self.source.exchange() {
            self.gate.clock_mut().exchanged(&exchange);
        }
        let Some(arrival) = arrival else { return Ok(None) };
        self.figures.count(&arrival);
        Ok(Some(match self.gate.take(&arrival) {
            Ok(fix) => {
                self.figures.count_fix(&fix);
                self.newest_s = Some(fix.captured_s);
                Event::Fix(fix)
            }
            Err(fault) => Event::Dropped(fault),
        }))
    }

    /// For how long there has been no fix, s: since the newest was captured, or since the program's start.
    pub fn blind_s(&self, now: HostInstant) -> f64 {
        (now.seconds() - self.newest_s.unwrap_or_default()).max(0.0)
    }

    /// How the connection stands.
    pub fn status(&self) -> &Status {
        self.source.status()
    }

    /// The bodies that the server has announced.
    pub fn bodies(&self) -> &[Label] {
        self.source.bodies()
    }

    /// What became of every frame.
    pub fn ledger(&self) -> &Ledger {
        self.gate.ledger()
    }

    /// Rates, latencies, shares.
    pub fn figures(&self) -> &Figures {
        &self.figures
    }

    /// The gate, for its clock.
    pub fn gate(&self) -> &Gate {
        &self.gate
    }
}
