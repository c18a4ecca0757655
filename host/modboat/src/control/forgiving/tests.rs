use super::super::ControllerKind;
use super::super::margins::{Axis, Loop};
use super::*;

fn with<T>(kind: ControllerKind, use_it: impl Fn(&Loop<'_>) -> T) -> T {
    let structure = Structure::from_cells(&[[0, 0], [1, 0], [2, 0]]).expect("a row of three");
    let control = ControlConfig { kind, ..ControlConfig::default() };
    use_it(&Loop {
        structure: &structure,
        parameters: &Parameters::default(),
        control: &control,
        observer: &ObserverParameters::default(),
        lead_s: 0.3,
    })
}

/// The greatest demand late after a push, over the greatest at first.
fn left(sampled: &Loop<'_>, axis: Axis, gain: f64) -> f64 {
    let push = match axis {
        Axis::Surge => Wrench { fy_n: 1e-4, ..Wrench::default() },
        Axis::Heading => Wrench { tau_nm: 1e-5, ..Wrench::default() },
    };
    let demands = sampled.response(push, gain).expect("a response");
    let size =
        |demands: &[Wrench]| demands.iter().map(|w| w.weighted_norm([1.0, 1.0, 10.0])).fold(0.0, f64::max);
    let (first, last) = demands.split_at(demands.len() / 2);
    if demands.len() < 150 { f64::INFINITY } else { size(last) / size(first) }
}

#[test]
fn margins_are_where_the_loop_really_becomes_unstable() {
    for kind in ControllerKind::ALL {
        for axis in [Axis::Heading, Axis::Surge] {
            with(kind, |sampled| {
                let margins = sampled.margins(axis).expect("margins");
                println!(
                    "{} {axis:?}: thrust × {:.2} to {:.2}, {:.0}°",
                    kind.name(),
                    margins.least_gain,
                    margins.gain,
                    margins.phase_rad.to_degrees()
                );
                let [inside, outside] = [0.93, 1.1].map(|by| left(sampled, axis, by * margins.gain));
                assert!(
                    inside < 0.5 && outside > 2.0,
                    "{} {axis:?} {margins:?}: {inside} {outside}",
                    kind.name()
                );
            });
        }
    }
}

#[test]
fn margins_of_the_default_are_those_stated() {
    with(ControllerKind::Forgiving, |sampled| {
        for axis in [Axis::Heading, Axis::Surge] {
            let margins = sampled.margins(axis).expect("margins");
            assert!(margins.gain > 1.2 && margins.least_gain < 0.6, "{axis:?}: {margins:?}");
            assert!(margins.phase_rad.to_degrees() > 20.0, "{axis:?}: {margins:?}");
        }
    });
}
