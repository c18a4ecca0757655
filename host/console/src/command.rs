//! What a page asks for: one JSON object a frame.

use serde::Deserialize;
use serde_json::{Map, Value};

use super::desk::Wanted;

/// Waypoints at once, at most.
pub const WAYPOINTS: usize = 100;

/// What is asked of the player of a log.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Playing {
    /// Goes on.
    Play,
    /// Stands still.
    Pause,
    /// Goes to this time of the log, s.
    Seek(f64),
    /// So many times as fast as it was.
    Speed(f64),
}

/// A command.
#[derive(Clone, Debug, PartialEq)]
pub enum Command {
    /// The token, for those that follow.
    Hello(String),
    /// To a run.
    Run(Wanted),
    /// To the player of a log.
    Play(Playing),
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields, rename_all = "kebab-case", tag = "do")]
enum Do {
    Hello { token: String },
    Stop {},
    Hold {},
    Resume {},
    Release { module: Option<u16> },
    Velocity { velocity_m_s: [f64; 2], heading_rad: Option<f64> },
    LetGo {},
    Station { position_m: [f64; 2], heading_rad: Option<f64> },
    Heading { heading_rad: f64 },
    Waypoints { positions_m: Vec<[f64; 2]>, heading_rad: Option<f64> },
    Legs {},
    End {},
    Play {},
    Pause {},
    Seek { at_s: f64 },
    Speed { factor: f64 },
}

/// Reads a frame: the number that the page gave, if it did, and the command, or why it is none.
pub fn read(text: &str) -> (Option<u32>, Result<Command, String>) {
    let mut object: Map<String, Value> = match serde_json::from_str(text) {
        Ok(object) => object,
        Err(error) => return (None, Err(format!("no JSON object: {error}"))),
    };
    let id = match object.remove("id").map(|id| id.as_u64().and_then(|id| u32::try_from(id).ok())) {
        None => None,
        Some(Some(id)) => Some(id),
        Some(None) => return (None, Err("id: must be a whole number below 2^32".to_owned())),
    };
    let command = serde_json::from_value::<Do>(Value::Object(object)).map_err(|error| error.to_string());
    (id, command.and_then(checked))
}

fn checked(what: Do) -> Result<Command, String> {
    Ok(Command::Run(match what {
        Do::Hello { token } => return Ok(Command::Hello(token)),
        Do::Play {} => return Ok(Command::Play(Playing::Play)),
        Do::Pause {} => return Ok(Command::Play(Playing::Pause)),
        Do::Seek { at_s } => return Ok(Command::Play(Playing::Seek(at_s))),
        Do::Speed { factor } if (0.1..=100.0).contains(&factor) => {
            return Ok(Command::Play(Playing::Speed(factor)));
        }
        Do::Speed { factor } => return Err(format!("factor = {factor}: must lie between 0.1 and 100")),
        Do::Waypoints { positions_m, .. } if positions_m.len() > WAYPOINTS => {
            return Err(format!("{} waypoints: at most {WAYPOINTS}", positions_m.len()));
        }
        Do::Stop {} => Wanted::Stop,
        Do::Hold {} => Wanted::Hold,
        Do::Resume {} => Wanted::Resume,
        Do::Release { module } => Wanted::Release(module),
        Do::Velocity { velocity_m_s, heading_rad } => Wanted::Velocity(velocity_m_s, heading_rad),
        Do::LetGo {} => Wanted::LetGo("let go"),
        Do::Station { position_m, heading_rad } => Wanted::Station(position_m, heading_rad),
        Do::Heading { heading_rad } => Wanted::Heading(heading_rad),
        Do::Waypoints { positions_m, heading_rad } => Wanted::Waypoints(positions_m, heading_rad),
        Do::Legs {} => Wanted::Legs,
        Do::End {} => Wanted::End,
    }))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_command_of_the_protocol_is_read() {
        let document = include_str!("../docs/protocol.md");
        let shown: Vec<&str> = document
            .lines()
            .filter(|line| line.starts_with("| `{"))
            .filter_map(|line| line.split('`').nth(1))
            .collect();
        assert!(shown.len() >= 13, "{shown:?}");
        for text in shown {
            let (id, command) = read(text);
            assert!(id.is_some() && command.is_ok(), "{text}: {command:?}");
        }
    }

    #[test]
    fn what_is_no_command_is_refused_with_its_number() {
        for (text, id, expected) in [
            ("", None, "no JSON object"),
            ("[1]", None, "no JSON object"),
            (r#"{"id":-1,"do":"stop"}"#, None, "id: must be"),
            (r#"{"id":7}"#, Some(7), "missing field `do`"),
            (r#"{"id":7,"do":"jump"}"#, Some(7), "unknown variant `jump`"),
            (r#"{"id":7,"do":"stop","now":true}"#, Some(7), "unknown field `now`"),
            (r#"{"id":7,"do":"velocity"}"#, Some(7), "missing field `velocity_m_s`"),
            (r#"{"id":7,"do":"velocity","velocity_m_s":[1]}"#, Some(7), "invalid length 1"),
            (r#"{"id":7,"do":"station","position_m":["a",1]}"#, Some(7), "invalid type"),
            (r#"{"id":7,"do":"speed","factor":0}"#, Some(7), "factor = 0"),
        ] {
            let (found, command) = read(text);
            let why = command.expect_err(text);
            assert!(found == id && why.contains(expected), "{text}: {found:?}, {why}");
        }
        let many = format!(r#"{{"do":"waypoints","positions_m":[{}[0,0]]}}"#, "[0,0],".repeat(WAYPOINTS));
        assert!(read(&many).1.is_err());
    }
}
