//! A module that gives half of what the others do, with weed about its flippers: planned with as it is, the fleet swims as asked; taken for a
//! whole one, it is a disturbance that the controller has to find.

use host::run::experiment::simulate;
use host::run::scenario::Scenario;

fn swum(known: bool) -> (f64, f64) {
    let share = "module_share = [1.0, 1.0, 1.0, 0.5, 1.0, 1.0]";
    let believed = if known { format!("[modboat]\n{share}\n") } else { String::new() };
    let scenario = format!(
        "name = \"weed\"\n[structure]\nsize = \"3x2\"\n{believed}[tank.thrust]\n{share}\n\
         [[leg]]\nduration_s = 30\nvelocity_m_s = [0.03, 0.0]\nheading_rad = 1.2\n\
         [[leg]]\nduration_s = 30\nvelocity_m_s = [0.0, 0.03]\nheading_rad = 1.2\n"
    );
    let scenario = Scenario::parse("weed", &scenario).unwrap_or_else(|error| panic!("{error}"));
    let run = simulate(&scenario, 1).expect("a run");
    assert!(run.summary.contacts.is_empty(), "{:?}", run.summary.contacts);
    let greatest = |values: &mut dyn Iterator<Item = f64>| values.fold(0.0, f64::max);
    let legs = || run.summary.legs.iter();
    (
        greatest(&mut legs().map(|leg| leg.velocity_error)),
        greatest(&mut legs().map(|leg| leg.heading_rms_rad)),
    )
}

#[test]
fn a_weak_module_that_is_known_is_made_up_for_by_the_others() {
    let [(known, known_rad), (unknown, unknown_rad)] = [true, false].map(swum);
    println!(
        "known: velocity off by {known:.4}, heading {known_rad:.4} rad; unknown: {unknown:.4}, {unknown_rad:.4} rad"
    );
    assert!(known_rad < 0.5 * unknown_rad, "{known_rad} {unknown_rad}");
    assert!(known < 0.04 && known_rad < 0.006, "{known}, {known_rad}");
}

#[test]
fn shares_of_another_number_of_modules_are_refused() {
    let text = "name = \"t\"\n[structure]\nsize = \"3x1\"\n[modboat]\nmodule_share = [1.0, 0.5]\n\
                [[leg]]\nduration_s = 5\nvelocity_m_s = [0.02, 0.0]\nheading_rad = 0.0\n";
    let refused = Scenario::parse("t.toml", text).expect_err("two of three").to_string();
    assert!(
        refused.contains("t.toml:5: [modboat] module_share") && refused.contains("one for each module"),
        "{refused}"
    );
}
