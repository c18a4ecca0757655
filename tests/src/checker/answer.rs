//! Input of the checker: a request to a planner, and its answer.

use serde_json::Value;

/// A request to a planner.
#[derive(Clone, Debug)]
pub struct Request {
    /// Cells [col, row] by module.
    pub cells: Vec<[i32; 2]>,
    /// (Fx, Fy, τ), N, N, N·m.
    pub demand: [f64; 3],
    /// Present tail angles, rad, if they are known.
    pub tail_rad: Option<Vec<f64>>,
    /// The cycle before, (φ₀, A) by module, if there was one.
    pub previous: Option<Vec<[f64; 2]>>,
}

/// The planner's answer.
#[derive(Clone, Debug)]
pub struct Answer {
    /// `planned`, `repeated` or `held`.
    pub outcome: String,
    /// (φ₀, A) by module, rad.
    pub cycle: Vec<[f64; 2]>,
    /// (from, to) by module, rad.
    pub transition: Option<Vec<[f64; 2]>>,
    /// Where each tail is between the two steps of a transition that has two, rad.
    pub via_rad: Option<Vec<f64>>,
    /// How long the tails turn, both steps of it where it has two, s; t_trans for each step if absent.
    pub turning_s: Option<f64>,
    /// (Fx, Fy, τ), N, N, N·m.
    pub wrench: [f64; 3],
    /// Relative error of the wrench.
    pub error: f64,
    /// Σ |to − from|, over both steps where there are two, rad.
    pub travel_rad: f64,
    /// Least distance of two tails' surfaces, m; none where no two can meet.
    pub clearance_m: Option<f64>,
    /// Whether any module may miss it.
    pub loss_tolerant: bool,
}

impl Answer {
    /// Reads one line of `flotilla plan`.
    ///
    /// # Errors
    /// What is missing, or not what it should be.
    pub fn from_json(line: &str) -> Result<Self, String> {
        let value: Value = serde_json::from_str(line).map_err(|error| error.to_string())?;
        let number = |value: &Value, key: &str| {
            value[key].as_f64().ok_or_else(|| format!("{key} is {}, not a number", value[key]))
        };
        let rows = |list: &Value, keys: &[&str]| -> Result<Vec<Vec<f64>>, String> {
            let items = list.as_array().ok_or_else(|| format!("{list} is no list of {keys:?}"))?;
            let row = |item: &Value| {
                let known = item.as_object().is_some_and(|object| object.len() == keys.len());
                if !known {
                    return Err(format!("{item} should have the keys {keys:?} and no other"));
                }
                keys.iter().map(|key| number(item, key)).collect()
            };
            items.iter().map(row).collect()
        };
        let twos = |rows: &[Vec<f64>]| rows.iter().map(|row| [row[0], row[1]]).collect::<Vec<_>>();
        // If one tail goes by way of a third angle, all say so.
        let (transition, via_rad) = match &value["transition"] {
            Value::Null => (None, None),
            turns if turns[0]["via_rad"].is_null() => {
                (Some(twos(&rows(turns, &["from_rad", "to_rad"])?)), None)
            }
            turns => {
                let turns = rows(turns, &["from_rad", "to_rad", "via_rad"])?;
                (Some(twos(&turns)), Some(turns.iter().map(|row| row[2]).collect()))
            }
        };
        let wrench = &value["wrench"];
        let optional =
            |key: &str| if value[key].is_null() { Ok(None) } else { number(&value, key).map(Some) };
        Ok(Self {
            outcome: value["outcome"].as_str().ok_or("outcome is no text")?.to_owned(),
            cycle: twos(&rows(&value["cycle"], &["centerline_rad", "amplitude_rad"])?),
            transition,
            via_rad,
            turning_s: None,
            wrench: [number(wrench, "fx_n")?, number(wrench, "fy_n")?, number(wrench, "tau_nm")?],
            error: number(&value, "error")?,
            travel_rad: number(&value, "travel_rad")?,
            clearance_m: optional("clearance_m")?,
            loss_tolerant: value["loss_tolerant"]
                .as_bool()
                .ok_or("loss_tolerant is neither true nor false")?,
        })
    }

    /// The steps of its transition, (from, to) by module each: none, one or two.
    #[must_use]
    pub fn steps(&self) -> Vec<Vec<[f64; 2]>> {
        match (&self.transition, &self.via_rad) {
            (None, _) => Vec::new(),
            (Some(turns), None) => vec![turns.clone()],
            (Some(turns), Some(via)) => {
                let first = turns.iter().zip(via).map(|(&[from, _], &via)| [from, via]);
                let second = turns.iter().zip(via).map(|(&[_, to], &via)| [via, to]);
                vec![first.collect(), second.collect()]
            }
        }
    }
}
