//! Table (f): demands outside the envelope, which no plan can meet.

use modboat::motion::Wrench;
use modboat::parameters::Parameters;
use modboat::planner_kind::PlannerKind;
use rand::rngs::ChaCha8Rng;
use rand::{RngExt, SeedableRng};
use tests::checker::Modboat;
use tests::figures::{Quantiles, mean};
use tests::random;
use tests::stream::{Kind, follow, on_both_cores, settings};

use super::{SHAPES, alone, finish, full, structure};

/// Sine of the greatest angle at which a wrench counts as parallel to its demand.
const PARALLEL: f64 = 1e-6;

/// What came of one structure's demands.
#[derive(Default)]
struct Told {
    /// Sine of the angle between demand and result, both weighted; 1 if they point apart.
    sines: Vec<f64>,
    /// What share of the border was reached.
    shares: Vec<f64>,
    /// Whether it was said that the demand lies outside.
    said: Vec<bool>,
}

/// Demands of 1.02 to 3 times the border.
fn outside(shape: &str, kind: &Kind, planner: PlannerKind, count: usize) -> Told {
    let (structure, modboat) = (structure(shape), Modboat::default());
    let envelope = kind.envelope(&structure);
    let mut rng = ChaCha8Rng::seed_from_u64(6);
    let demands: Vec<Wrench> = (0..=count)
        .map(|_| {
            let times = rng.random_range(1.02..3.0);
            Wrench::from_array(random::border(&modboat, structure.cells(), &mut rng).map(|f| times * f))
        })
        .collect();
    let mut told = Told::default();
    follow(&mut kind.planner(&structure, &settings(planner)), demands, 1, |asked, plan, _| {
        let weighted = |wrench: Wrench| [0, 1, 2].map(|k| modboat.weights[k] * wrench.to_array()[k]);
        let (d, f) = (weighted(asked.demand), weighted(plan.wrench));
        let dot = |a: [f64; 3], b: [f64; 3]| a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
        let share = dot(d, f) / dot(d, d);
        let off = [0, 1, 2].map(|k| f[k] - share * d[k]);
        let sine = if share > 0.0 { (dot(off, off) / dot(f, f)).sqrt() } else { 1.0 };
        told.sines.push(sine);
        told.shares.push(share * envelope.gauge(asked.demand));
        told.said.push(plan.outside_envelope);
    });
    told
}

#[test]
fn table_f_demands_outside_the_envelope() {
    let _alone = alone();
    let kind = Kind::new(Parameters::default());
    let shapes: Vec<&str> = SHAPES.into_iter().chain(["10x10"]).collect();
    let (count, few) = if full() { (500, 50) } else { (12, 2) };
    let told = on_both_cores(&shapes, |shape| {
        [(PlannerKind::Exact, count), (PlannerKind::PotentialField, few)]
            .map(|(p, n)| outside(shape, &kind, p, n))
    });
    let (mut table, mut broken) = (String::new(), Vec::new());
    table += "(f) Demands of 1.02 to 3 times the border: share of the border reached along the demand, angle off it\n";
    table += "           |                     exact                          |   potential field\n";
    table += "structure  | plans said parallel | reached: least   mean  most | plans parallel | angle p50  reached\n";
    for (shape, [exact, field]) in shapes.iter().zip(&told) {
        let parallel = |told: &Told| told.sines.iter().filter(|sine| **sine <= PARALLEL).count();
        let said = exact.said.iter().filter(|said| **said).count();
        let reached = Quantiles::of(exact.shares.iter().copied());
        let angle = Quantiles::of(field.sines.iter().copied());
        table += &format!(
            "{shape:<10} | {:>5} {said:>4} {:>8} | {:>14.3} {:>6.3} {:>5.3} | {:>5} {:>8} | {:>5.2} rad {:>8.3}\n",
            exact.sines.len(),
            parallel(exact),
            reached.least,
            mean(exact.shares.iter().copied()),
            reached.most,
            field.sines.len(),
            parallel(field),
            angle.median.asin(),
            mean(field.shares.iter().copied()),
        );
        if said < exact.said.len() {
            broken.push(format!("{shape}: a demand outside was not said to be"));
        }
        if parallel(exact) < exact.sines.len() {
            broken.push(format!(
                "{shape}: {} of {} parallel to the demand",
                parallel(exact),
                exact.sines.len()
            ));
        }
        // 0.86 at least and 0.98 on average were seen.
        let average = mean(exact.shares.iter().copied());
        if !(reached.least > 0.72 && average > 0.96 && reached.most < 1.0 + 1e-9) {
            broken.push(format!("{shape}: {reached:?} of the border reached, {average} on average"));
        }
    }
    finish(&table, &broken);
}
