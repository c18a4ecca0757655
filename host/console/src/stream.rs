//! Foxglove's protocol: the log's topics live, parameters for targets, services for stop, hold and release.
//!
//! A text is a JSON object with the key `op`; bytes begin with the number of an operation, numbers are little endian:
//!
//! | from | operation | bytes behind its number |
//! |---|---|---|
//! | server | 1 message data | subscription `u32`, time ns `u64`, CDR |
//! | server | 3 service call response | service `u32`, call `u32`, length of the encoding's name `u32`, the name, the response |
//! | client | 2 service call request | the same, with the request |
//!
//! Source: <https://github.com/foxglove/ws-protocol/blob/main/docs/spec.md>; `foxglove.sdk.v1` is its newer name. Written here and not taken
//! from the crate `foxglove`, which wants an asynchronous runtime for its server.

use runlog::cdr::{Cdr as _, Encoder};
use runlog::flotilla::Goal;
use serde_json::{Value, json};
use tungstenite::{Bytes, Message};

use super::desk::Wanted;
use super::tap::Channel;

/// Services, by number from 1.
const SERVICES: [(&str, Wanted); 4] = [
    ("/flotilla/stop", Wanted::Stop),
    ("/flotilla/hold", Wanted::Hold),
    ("/flotilla/resume", Wanted::Resume),
    ("/flotilla/release", Wanted::Release(None)),
];

/// Parameters.
pub const PARAMETERS: [&str; 4] =
    ["target/velocity_m_s", "target/station_m", "target/heading_rad", "target/waypoints_m"];

/// Subscriptions of one client at most.
const SUBSCRIPTIONS: usize = 512;

/// What a client of the stream has.
#[derive(Clone, Debug, Default)]
pub struct Subscriber {
    /// Number of the subscription, number of the topic.
    subscriptions: Vec<(u32, u16)>,
    /// Whether parameters are told when they change.
    pub follows_parameters: bool,
}

/// How to answer a call.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Call {
    service: u32,
    call: u32,
    encoding: String,
}

/// What a client wants.
#[derive(Clone, Debug, PartialEq)]
pub enum Asked {
    /// Nothing but what was done.
    Nothing,
    /// These topics are new to it: the newest of those that are told seldom is due.
    Subscribed(Vec<u16>),
    /// Parameters are asked for, with a number.
    Parameters(Option<String>),
    /// Targets are set, and parameters asked for.
    Set(Vec<Wanted>, Option<String>),
    /// A service is called.
    Call(Wanted, Call),
    /// It makes no sense: what it is told.
    Refused(String),
}

impl Subscriber {
    /// The subscriptions to `channel`.
    pub fn to(&self, channel: u16) -> impl Iterator<Item = u32> + '_ {
        self.subscriptions.iter().filter(move |(_, known)| *known == channel).map(|(id, _)| *id)
    }

    /// Takes in a text.
    pub fn text(&mut self, text: &str) -> Asked {
        let Ok(message) = serde_json::from_str::<Value>(text) else {
            return Asked::Refused("no JSON".to_owned());
        };
        let list = |key: &str| message.get(key).and_then(Value::as_array).map_or(&[][..], Vec::as_slice);
        let number = |value: &Value, key: &str| value.get(key).and_then(Value::as_u64);
        let id = message.get("id").and_then(Value::as_str).map(str::to_owned);
        match message.get("op").and_then(Value::as_str).unwrap_or_default() {
            "subscribe" => {
                let mut new = Vec::new();
                for one in list("subscriptions") {
                    let numbers = number(one, "id").zip(number(one, "channelId"));
                    let Some((Ok(id), Ok(channel))) =
                        numbers.map(|(id, channel)| (id.try_into(), channel.try_into()))
                    else {
                        return Asked::Refused("subscribe: wants id and channelId".to_owned());
                    };
                    if self.subscriptions.len() >= SUBSCRIPTIONS
                        || self.subscriptions.iter().any(|(known, _)| *known == id)
                    {
                        return Asked::Refused(format!(
                            "subscribe: {id} is there already, or there are too many"
                        ));
                    }
                    self.subscriptions.push((id, channel));
                    new.push(channel);
                }
                Asked::Subscribed(new)
            }
            "unsubscribe" => {
                let gone: Vec<u64> = list("subscriptionIds").iter().filter_map(Value::as_u64).collect();
                self.subscriptions.retain(|(id, _)| !gone.contains(&u64::from(*id)));
                Asked::Nothing
            }
            "getParameters" => Asked::Parameters(id),
            "subscribeParameterUpdates" => {
                self.follows_parameters = true;
                Asked::Nothing
            }
            "unsubscribeParameterUpdates" => {
                self.follows_parameters = false;
                Asked::Nothing
            }
            "setParameters" => {
                let wanted: Result<Vec<Wanted>, String> = list("parameters").iter().map(target).collect();
                wanted.map_or_else(Asked::Refused, |wanted| Asked::Set(wanted, id))
            }
            "advertise" | "unadvertise" => Asked::Nothing,
            op => Asked::Refused(format!("{op:?} is not done here")),
        }
    }

    /// Takes in bytes.
    pub fn binary(&mut self, bytes: &[u8]) -> Asked {
        let call = || {
            let rest = bytes.strip_prefix(&[2])?;
            let (service, rest) = number(rest)?;
            let (call, rest) = number(rest)?;
            let (length, rest) = number(rest)?;
            let encoding = str::from_utf8(rest.get(..usize::try_from(length).ok()?)?).ok()?.to_owned();
            Some(Call { service, call, encoding })
        };
        let Some(call) = call() else { return Asked::Refused("these bytes are no service call".to_owned()) };
        let place = usize::try_from(call.service).ok().and_then(|service| service.checked_sub(1));
        match place.and_then(|place| SERVICES.get(place)) {
            Some((_, wanted)) if matches!(call.encoding.as_str(), "json" | "cdr") => {
                Asked::Call(wanted.clone(), call)
            }
            _ => Asked::Refused("there is no such service, or not in this encoding".to_owned()),
        }
    }
}

fn number(bytes: &[u8]) -> Option<(u32, &[u8])> {
    let (number, rest) = bytes.split_first_chunk()?;
    Some((u32::from_le_bytes(*number), rest))
}

/// The target that a parameter sets.
fn target(parameter: &Value) -> Result<Wanted, String> {
    let name = parameter.get("name").and_then(Value::as_str).unwrap_or_default();
    let value = parameter.get("value").unwrap_or(&Value::Null);
    let wanted = match name.trim_start_matches('/') {
        "target/velocity_m_s" => pair(value).map(|pair| Wanted::Velocity(pair, None)),
        "target/station_m" => pair(value).map(|pair| Wanted::Station(pair, None)),
        "target/heading_rad" => value.as_f64().map(Wanted::Heading),
        "target/waypoints_m" => value
            .as_array()
            .filter(|all| all.len() <= super::command::WAYPOINTS)
            .and_then(|all| all.iter().map(pair).collect::<Option<Vec<_>>>())
            .map(|waypoints| Wanted::Waypoints(waypoints, None)),
        _ => return Err(format!("there is no parameter {name:?}")),
    };
    wanted.ok_or_else(|| format!("{name}: wants numbers: [x, y], a list of such, or a heading"))
}

fn pair(value: &Value) -> Option<[f64; 2]> {
    match value.as_array()?.as_slice() {
        [x, y] => Some([x.as_f64()?, y.as_f64()?]),
        _ => None,
    }
}

fn text(value: &Value) -> Message {
    Message::text(value.to_string())
}

/// What a client is told first. `session` tells one run from another; `orders`: whether there is anything to order.
#[must_use]
pub fn hello(name: &str, session: &str, orders: bool) -> Vec<Message> {
    let capabilities: &[&str] = if orders { &["parameters", "parametersSubscribe", "services"] } else { &[] };
    let info = json!({
        "op": "serverInfo",
        "name": name,
        "capabilities": capabilities,
        "supportedEncodings": ["json", "cdr"],
        "metadata": {},
        "sessionId": session,
    });
    let response = "bool success\nstring message\n";
    let side = |name: &str, schema: &str| json!({ "encoding": "cdr", "schemaName": name, "schemaEncoding": "ros2msg", "schema": schema });
    let services = SERVICES.iter().zip(1..).map(|((name, _), id)| {
        json!({
            "id": id,
            "name": name,
            "type": "std_srvs/srv/Trigger",
            "requestSchema": "",
            "responseSchema": response,
            "request": side("std_srvs/srv/Trigger_Request", ""),
            "response": side("std_srvs/srv/Trigger_Response", response),
        })
    });
    let services = json!({ "op": "advertiseServices", "services": services.collect::<Vec<Value>>() });
    if orders { vec![text(&info), text(&services)] } else { vec![text(&info)] }
}

/// Topics.
#[must_use]
pub fn advertise<'a>(channels: impl IntoIterator<Item = &'a Channel>) -> Message {
    let channels = channels.into_iter().map(|channel| {
        json!({
            "id": channel.id,
            "topic": channel.topic,
            "encoding": "cdr",
            "schemaName": channel.schema,
            "schema": channel.definition,
            "schemaEncoding": "ros2msg",
        })
    });
    text(&json!({ "op": "advertise", "channels": channels.collect::<Vec<Value>>() }))
}

/// A message for a subscription.
#[must_use]
pub fn data(subscription: u32, at_ns: u64, cdr: &[u8]) -> Message {
    let mut bytes = Vec::with_capacity(13 + cdr.len());
    bytes.push(1);
    bytes.extend_from_slice(&subscription.to_le_bytes());
    bytes.extend_from_slice(&at_ns.to_le_bytes());
    bytes.extend_from_slice(cdr);
    Message::Binary(Bytes::from(bytes))
}

/// Targets as they are.
#[must_use]
pub fn parameters(goal: Option<&Goal>, id: Option<&str>) -> Message {
    let pair = |values: &[f64]| match values {
        [x, y] => json!([x, y]),
        _ => json!([]),
    };
    let goal = goal.cloned().unwrap_or_default();
    let waypoints = goal.waypoints_x_m.iter().zip(&goal.waypoints_y_m);
    let values = [
        pair(&goal.velocity_m_s),
        pair(&goal.station_m),
        json!(goal.heading_rad),
        json!(waypoints.map(|(x, y)| [*x, *y]).collect::<Vec<[f64; 2]>>()),
    ];
    let all: Vec<Value> =
        PARAMETERS.iter().zip(values).map(|(name, value)| json!({ "name": name, "value": value })).collect();
    let mut message = json!({ "op": "parameterValues", "parameters": all });
    if let (Some(id), Some(object)) = (id, message.as_object_mut()) {
        object.insert("id".to_owned(), json!(id));
    }
    text(&message)
}

/// What came of a call.
#[must_use]
pub fn response(call: &Call, outcome: &Result<String, String>) -> Message {
    let (success, words) = match outcome {
        Ok(words) => (true, words),
        Err(words) => (false, words),
    };
    let body = if call.encoding == "json" {
        json!({ "success": success, "message": words }).to_string().into_bytes()
    } else {
        let mut encoder = Encoder::default();
        encoder.begin();
        success.encode(&mut encoder);
        words.encode(&mut encoder);
        encoder.bytes().to_vec()
    };
    let mut bytes = vec![3];
    let length = call.encoding.len() as u32;
    [call.service, call.call, length].iter().for_each(|n| bytes.extend_from_slice(&n.to_le_bytes()));
    bytes.extend_from_slice(call.encoding.as_bytes());
    bytes.extend_from_slice(&body);
    Message::Binary(Bytes::from(bytes))
}

/// That a call is not taken.
#[must_use]
pub fn failure(call: &Call, why: &str) -> Message {
    text(
        &json!({ "op": "serviceCallFailure", "serviceId": call.service, "callId": call.call, "message": why }),
    )
}

/// Something to be told a person; level 1: a warning, 2: an error.
#[must_use]
pub fn status(level: u8, why: &str) -> Message {
    text(&json!({ "op": "status", "level": level, "message": why }))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn subscriptions_come_and_go() {
        let mut subscriber = Subscriber::default();
        let text = r#"{"op":"subscribe","subscriptions":[{"id":0,"channelId":3},{"id":1,"channelId":5}]}"#;
        assert_eq!(subscriber.text(text), Asked::Subscribed(vec![3, 5]));
        assert_eq!(subscriber.to(5).collect::<Vec<u32>>(), [1]);
        let again = r#"{"op":"subscribe","subscriptions":[{"id":1,"channelId":3}]}"#;
        assert!(matches!(subscriber.text(again), Asked::Refused(_)));
        assert_eq!(subscriber.text(r#"{"op":"unsubscribe","subscriptionIds":[1]}"#), Asked::Nothing);
        assert_eq!((subscriber.to(5).count(), subscriber.to(3).count()), (0, 1));
        for nonsense in ["", "{}", r#"{"op":"jump"}"#, r#"{"op":"subscribe","subscriptions":[{"id":-1}]}"#] {
            assert!(matches!(subscriber.text(nonsense), Asked::Refused(_)), "{nonsense}");
        }
    }

    /// Bytes as the specification draws them.
    #[test]
    fn data_and_calls_lie_as_the_specification_has_them() {
        let Message::Binary(bytes) = data(7, 0x0102, &[0, 1, 0, 0, 9]) else { panic!("bytes") };
        assert_eq!(bytes.as_ref(), [1, 7, 0, 0, 0, 2, 1, 0, 0, 0, 0, 0, 0, 0, 1, 0, 0, 9]);
        let mut subscriber = Subscriber::default();
        let request = [&[2, 1, 0, 0, 0, 9, 0, 0, 0, 4, 0, 0, 0][..], b"json{}"].concat();
        let Asked::Call(Wanted::Stop, call) = subscriber.binary(&request) else { panic!("a call of stop") };
        let Message::Binary(bytes) = response(&call, &Ok("done".to_owned())) else { panic!("bytes") };
        let expected =
            [&[3, 1, 0, 0, 0, 9, 0, 0, 0, 4, 0, 0, 0][..], br#"json{"message":"done","success":true}"#]
                .concat();
        assert_eq!(bytes.as_ref(), expected);
        for length in 0..request.len() - 2 {
            assert!(matches!(subscriber.binary(&request[..length]), Asked::Refused(_)), "of {length} bytes");
        }
    }

    #[test]
    fn parameters_are_targets() {
        let mut subscriber = Subscriber::default();
        let set = |name: &str, value: &str| {
            format!(r#"{{"op":"setParameters","id":"7","parameters":[{{"name":"{name}","value":{value}}}]}}"#)
        };
        for (name, value, wanted) in [
            ("target/station_m", "[1,2.5]", Some(Wanted::Station([1.0, 2.5], None))),
            ("/target/heading_rad", "1.5", Some(Wanted::Heading(1.5))),
            (
                "target/waypoints_m",
                "[[0,1],[2,3]]",
                Some(Wanted::Waypoints(vec![[0.0, 1.0], [2.0, 3.0]], None)),
            ),
            ("target/velocity_m_s", "[0.04,0]", Some(Wanted::Velocity([0.04, 0.0], None))),
            ("target/station_m", "[1]", None),
            ("target/speed", "1", None),
        ] {
            let asked = subscriber.text(&set(name, value));
            match wanted {
                Some(wanted) => assert_eq!(asked, Asked::Set(vec![wanted], Some("7".to_owned()))),
                None => assert!(matches!(asked, Asked::Refused(_)), "{asked:?}"),
            }
        }
    }
}
