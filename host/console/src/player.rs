//! A log file, told again at its own pace, or faster, or from another place.

use std::fs::File;
use std::io::BufReader;
use std::path::Path;
use std::time::Instant;

use runlog::reader::{LogError, read};
use serde_json::{Value, json};

use super::command::Playing;
use super::tap::Channel;

/// The longest log that is played, bytes: it is kept in memory.
const LONGEST: u64 = 2 << 30;

/// Where a message lies.
#[derive(Clone, Copy, Debug)]
struct Place {
    channel: usize,
    at_ns: u64,
    start: usize,
    length: usize,
}

/// A message.
#[derive(Clone, Copy, Debug)]
pub struct Told<'a> {
    /// Of which topic.
    pub channel: &'a Channel,
    /// When, ns.
    pub at_ns: u64,
    /// CDR.
    pub data: &'a [u8],
}

/// See the module's documentation.
pub struct Player {
    name: String,
    cut: bool,
    channels: Vec<Channel>,
    places: Vec<Place>,
    bytes: Vec<u8>,
    /// The next message.
    next: usize,
    /// Since when it plays, and from which time of the log, ns.
    anchor: (Instant, u64),
    speed: f64,
    playing: bool,
}

impl Player {
    /// The log at `path`, at its beginning, playing.
    ///
    /// # Errors
    /// With the file's name: no such file, no log, too long.
    pub fn open(path: &Path, now: Instant) -> Result<Self, String> {
        let name = path.display().to_string();
        let failed = |error: &dyn std::fmt::Display| format!("{name}: {error}");
        let file = File::open(path).map_err(|error| failed(&error))?;
        let length = file.metadata().map_or(0, |metadata| metadata.len());
        if length > LONGEST {
            return Err(failed(&format!("{} MB: at most {} MB are played", length >> 20, LONGEST >> 20)));
        }
        let (mut channels, mut places, mut bytes) = (Vec::<Channel>::new(), Vec::new(), Vec::new());
        let extent = read(BufReader::new(file), |entry, _| {
            let known = channels.iter().position(|known| known.id == entry.channel);
            let channel = known.unwrap_or(channels.len());
            if known.is_none() {
                channels.push(Channel {
                    id: entry.channel,
                    topic: entry.topic.to_owned(),
                    schema: entry.schema.to_owned(),
                    definition: entry.definition.unwrap_or_default().to_owned(),
                });
            }
            places.push(Place { channel, at_ns: entry.at_ns, start: bytes.len(), length: entry.data.len() });
            bytes.extend_from_slice(entry.data);
            Ok::<(), LogError>(())
        });
        let extent = extent.map_err(|error| failed(&error))?;
        if !channels.iter().any(|channel| channel.topic == "/scenario") {
            return Err(failed(&"a log, but not of Flotilla: it does not say what was run (/scenario)"));
        }
        places.sort_by_key(|place| place.at_ns);
        let begin_ns = places.first().map_or(0, |place| place.at_ns);
        let (anchor, cut) = ((now, begin_ns), !extent.whole);
        Ok(Self { name, cut, channels, places, bytes, next: 0, anchor, speed: 1.0, playing: true })
    }

    /// Its topics.
    #[must_use]
    pub fn channels(&self) -> &[Channel] {
        &self.channels
    }

    fn bounds_ns(&self) -> [u64; 2] {
        [self.places.first(), self.places.last()].map(|place| place.map_or(0, |place| place.at_ns))
    }

    /// Where it is at `now`, ns of the log.
    #[must_use]
    pub fn at_ns(&self, now: Instant) -> u64 {
        let [begin_ns, end_ns] = self.bounds_ns();
        let (since, from_ns) = self.anchor;
        let passed_ns = if self.playing {
            now.saturating_duration_since(since).as_nanos() as f64 * self.speed
        } else {
            0.0
        };
        (from_ns as f64 + passed_ns).clamp(begin_ns as f64, end_ns as f64) as u64
    }

    /// Does what is asked at `now`. What came of it, and whether everything before must be told again: [`until_now`](Self::until_now).
    ///
    /// # Errors
    /// Why not.
    pub fn ask(&mut self, playing: Playing, now: Instant) -> Result<bool, String> {
        let at_ns = self.at_ns(now);
        let [begin_ns, end_ns] = self.bounds_ns();
        match playing {
            // At its end it begins again.
            Playing::Play if at_ns >= end_ns => {
                (self.anchor, self.playing) = ((now, begin_ns), true);
                return Ok(true);
            }
            Playing::Play => (self.anchor, self.playing) = ((now, at_ns), true),
            Playing::Pause => (self.anchor, self.playing) = ((now, at_ns), false),
            Playing::Speed(factor) => (self.anchor, self.speed) = ((now, at_ns), factor),
            Playing::Seek(at_s) if at_s.is_finite() => {
                let to_ns = (at_s * 1e9).clamp(begin_ns as f64, end_ns as f64) as u64;
                self.anchor = (now, to_ns);
                return Ok(true);
            }
            Playing::Seek(at_s) => return Err(format!("at_s = {at_s}: no time of this log")),
        }
        Ok(false)
    }

    /// Calls `take` with every message up to where it is at `now`; it goes on from there.
    pub fn until_now(&mut self, now: Instant, mut take: impl FnMut(&Told<'_>)) {
        let at_ns = self.at_ns(now);
        self.next = self.places.partition_point(|place| place.at_ns <= at_ns);
        self.places.iter().take(self.next).filter_map(|place| self.told(place)).for_each(|told| take(&told));
    }

    /// Calls `take` with what has become due by `now`.
    pub fn advance(&mut self, now: Instant, mut take: impl FnMut(&Told<'_>)) {
        let at_ns = self.at_ns(now);
        while let Some(place) = self.places.get(self.next).filter(|place| place.at_ns <= at_ns) {
            if let Some(told) = self.told(place) {
                take(&told);
            }
            self.next += 1;
        }
        if self.playing && self.next >= self.places.len() {
            (self.anchor, self.playing) = ((now, at_ns), false);
        }
    }

    fn told(&self, place: &Place) -> Option<Told<'_>> {
        let data = self.bytes.get(place.start..place.start + place.length)?;
        Some(Told { channel: self.channels.get(place.channel)?, at_ns: place.at_ns, data })
    }

    /// As the page has it.
    #[must_use]
    pub fn show(&self, now: Instant) -> Value {
        let [begin_s, end_s] = self.bounds_ns().map(|at_ns| at_ns as f64 * 1e-9);
        json!({
            "at_s": self.at_ns(now) as f64 * 1e-9,
            "begin_s": begin_s,
            "end_s": end_s,
            "speed": self.speed,
            "playing": self.playing,
            "name": self.name,
            "cut": self.cut,
        })
    }
}

#[cfg(test)]
mod tests {
    use std::time::Duration;

    use runlog::flotilla::{Event, Scenario};
    use runlog::writer::Writer;

    use super::*;

    /// A log of eleven seconds with an event each.
    fn player(now: Instant) -> Player {
        let folder = tempfile::tempdir().expect("a folder");
        let path = folder.path().join("log.mcap");
        let mut writer = Writer::create(&path).expect("a file");
        let scenario = writer.topic("/scenario").expect("a topic");
        writer.write(scenario, 0, &Scenario::default()).expect("room");
        let event = writer.topic("/event").expect("a topic");
        for second in 0..=10 {
            let text = second.to_string();
            writer.write(event, second * 1_000_000_000, &Event { text, ..Event::default() }).expect("room");
        }
        writer.finish().expect("room");
        Player::open(&path, now).expect("a log")
    }

    fn due(player: &mut Player, now: Instant) -> usize {
        let mut count = 0;
        player.advance(now, |_| count += 1);
        count
    }

    #[test]
    fn it_plays_pauses_jumps_and_ends() {
        let began = Instant::now();
        let at = |ms| began + Duration::from_millis(ms);
        let mut player = player(began);
        assert_eq!(
            (due(&mut player, at(0)), due(&mut player, at(900)), due(&mut player, at(2100))),
            (2, 0, 2)
        );
        assert_eq!(player.ask(Playing::Pause, at(2200)), Ok(false));
        assert_eq!(due(&mut player, at(60_000)), 0);
        assert_eq!(player.ask(Playing::Speed(2.0), at(60_000)), Ok(false));
        assert_eq!(player.ask(Playing::Play, at(60_000)), Ok(false));
        // From 2.2 s at twice the speed.
        assert_eq!((due(&mut player, at(60_300)), due(&mut player, at(60_500))), (0, 1));
        assert_eq!(player.ask(Playing::Seek(7.5), at(61_000)), Ok(true));
        let mut before = 0;
        player.until_now(at(61_000), |_| before += 1);
        assert_eq!((before, due(&mut player, at(61_300))), (9, 1));
        assert_eq!(due(&mut player, at(99_000)), 2);
        let shown = player.show(at(99_000));
        assert_eq!((shown["playing"].as_bool(), shown["at_s"].as_f64()), (Some(false), Some(10.0)));
        assert_eq!(player.ask(Playing::Play, at(99_000)), Ok(true));
        assert!(player.ask(Playing::Seek(f64::NAN), at(99_000)).is_err());
    }
}
