//! Experiments that show the constants of a boat: `identify-SHAPE`, and the same for any scenario with an edge of the water.

use identify::experiment::{Site, design};
use modboat::bounds::Place;
use modboat::structure::Structure;
use quantity::bounds::Bounds;
use reader::FileError;

use super::{Demand, Leg, Scenario};

/// What names of such scenarios begin with.
pub const PREFIX: &str = "identify-";
/// How long an experiment is, s.
pub const DURATION_S: f64 = 180.0;
/// Shapes by number of modules, beside columns × rows.
const SHAPES: [(&str, &str); 4] = [("3", "3x1"), ("4", "2x2"), ("6", "3x2"), ("9", "3x3")];

/// The scenario `identify-SHAPE`, if `name` is one.
///
/// # Errors
/// [`FileError::Invalid`] for a shape that is none, or too large for its water.
pub(super) fn named(name: &str) -> Option<Result<Scenario, FileError>> {
    let shape = name.strip_prefix(PREFIX)?;
    let known = SHAPES.iter().find(|(count, _)| *count == shape);
    let size = known.map_or(shape, |(_, size)| size);
    let structure = Structure::from_word(size).ok()?;
    let pitch_m = modboat::parameters::Parameters::default().pitch_m;
    let reach_m = structure.positions_m(pitch_m).iter().map(|[x, y]| x.hypot(*y)).fold(0.0, f64::max);
    // Room for some seconds at full speed each way.
    let (east_m, north_m) = (1.6 + reach_m, 1.3 + reach_m);
    let text = format!(
        "name = \"{name}\"\ndescription = \"Legs that show the constants of {} modules in {:.1} m by {:.1} m of water\"\n\
         [structure]\nsize = \"{size}\"\n[start]\nheading_rad = {}\n[bounds]\n\
         edge_m = [[-{east_m}, -{north_m}], [{east_m}, -{north_m}], [{east_m}, {north_m}], [-{east_m}, {north_m}]]\n\
         [[leg]]\nduration_s = 1.0\nvelocity_m_s = [0.0, 0.0]\nheading_rad = 0.0\n",
        structure.len(),
        2.0 * east_m,
        2.0 * north_m,
        std::f64::consts::FRAC_PI_2,
    );
    Some(Scenario::parse(&format!("{name}.toml"), &text).and_then(|scenario| {
        let invalid = |message| FileError::Invalid { file: format!("{name}.toml"), line: 1, message };
        scenario.into_experiment(DURATION_S).map_err(invalid)
    }))
}

impl Scenario {
    /// The same with legs that show the constants of its modules, `duration_s` long, inside its bounds.
    ///
    /// # Errors
    /// Why there are no such legs.
    pub fn into_experiment(mut self, duration_s: f64) -> Result<Self, String> {
        let bounds: &Bounds = self
            .bounds
            .as_ref()
            .ok_or("[bounds] is missing: the edge of the water that an experiment stays inside")?;
        let start = Place { position_m: self.start.position_m, heading_rad: self.start_heading_rad() };
        let site = Site { structure: &self.structure, belief: &self.modboat, bounds, start, duration_s };
        let legs = design(&site);
        if legs.is_empty() {
            return Err("[bounds] leave no room for an experiment with this structure".to_owned());
        }
        self.legs = legs
            .into_iter()
            .map(|leg| Leg {
                duration_s: leg.duration_s,
                demand: Demand::Velocity(leg.velocity_m_s),
                heading_rad: leg.heading_rad,
            })
            .collect();
        self.start.heading_rad = Some(start.heading_rad);
        Ok(self)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn shapes_have_experiments_and_other_names_have_none() {
        for (name, modules) in [("identify-3", 3), ("identify-9", 9), ("identify-2x1", 2)] {
            let scenario = Scenario::open(name).expect(name);
            assert_eq!((scenario.structure.len(), scenario.name.as_str()), (modules, name));
            assert!((scenario.duration_s() - DURATION_S).abs() < 1e-9 && scenario.legs.len() > 8, "{name}");
            // Its document is the same experiment again.
            let again = Scenario::parse(name, &scenario.document()).expect(name);
            assert_eq!(again.legs, scenario.legs);
        }
        let error = Scenario::open("identify-nothing").expect_err("no shape").to_string();
        assert!(error.contains("no such file"), "{error}");
        let unbounded = Scenario::open("holonomic-1").expect("built in").into_experiment(60.0);
        assert!(unbounded.expect_err("no edge").contains("[bounds]"));
    }
}
