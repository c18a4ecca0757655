//! What must hold for every picture, whatever was planned and executed.

use super::*;
use crate::style;
use crate::tests::assert_sound;

fn pictures(records: &[Record]) -> [(&'static str, String); 6] {
    [
        ("scene", scene::svg(records).expect("a picture")),
        ("top", top::svg(records).expect("a picture")),
        ("velocity", quantities::velocity(records).expect("a picture")),
        ("force", quantities::force(records).expect("a picture")),
        ("power", power::svg(records).expect("a picture")),
        ("pwm", quantities::pwm(records).expect("a picture")),
    ]
}

/// A text and the rectangle it covers, px: left, right, top, bottom.
struct Words<'s> {
    text: &'s str,
    at: [f64; 4],
}

fn attribute<'s>(tag: &'s str, key: &str) -> Option<&'s str> {
    let (_, rest) = tag.split_once(&format!(" {key}=\""))?;
    rest.split_once('"').map(|(value, _)| value)
}

fn words(svg: &str) -> Vec<Words<'_>> {
    let texts = svg.split("<text").skip(1).filter_map(|t| t.split_once("</text>"));
    texts
        .map(|(element, _)| {
            let (tag, text) = element.split_once('>').expect("a tag");
            let number = |key| -> f64 {
                attribute(tag, key).and_then(|v| v.parse().ok()).unwrap_or_else(|| panic!("{tag}: {key}"))
            };
            let text = text.trim();
            let size = number("font-size") / style::SUBPIXELS;
            let (x, y) = (number("x") / style::SUBPIXELS, number("y") / style::SUBPIXELS);
            // The estimate errs on the wide side.
            let width = 0.85 * style::text_width(text, size);
            let from = match attribute(tag, "text-anchor") {
                Some("middle") => -0.5 * width,
                Some("end") => -width,
                _ => 0.0,
            };
            let half = 0.4 * size;
            let at = if tag.contains("rotate") {
                [x - half, x + half, y + from, y + from + width]
            } else {
                [x + from, x + from + width, y - half, y + half]
            };
            Words { text, at }
        })
        .collect()
}

fn size(svg: &str) -> (f64, f64) {
    let head = svg.split_once('>').expect("a tag").0;
    let side = |key| attribute(head, key).and_then(|v| v.parse().ok()).expect("a size");
    (side("width"), side("height"))
}

fn assert_words_stay_inside(case: &str, svg: &str) {
    let (width, height) = size(svg);
    for Words { text, at: [left, right, top, bottom] } in words(svg) {
        let inside = left >= 0.0 && right <= width && top >= 0.0 && bottom <= height;
        assert!(inside, "{case}: {text:?} at {left:.0}..{right:.0}, {top:.0}..{bottom:.0}");
    }
}

fn assert_words_stand_clear(case: &str, svg: &str) {
    let words = words(svg);
    for (n, a) in words.iter().enumerate() {
        for b in words.iter().skip(n + 1).filter(|b| !a.text.is_empty() && !b.text.is_empty()) {
            let apart = a.at[1] <= b.at[0] || b.at[1] <= a.at[0] || a.at[3] <= b.at[2] || b.at[3] <= a.at[2];
            assert!(apart, "{case}: {:?} on {:?} at {:?}", a.text, b.text, a.at);
        }
    }
}

#[test]
fn every_picture_carries_its_labels_and_every_robot() {
    let mut records = sample::far();
    for record in &mut records {
        record.problem.name = "tank <2> & co".to_owned();
    }
    let labels: [&[&str]; 6] = [
        &["start left", "empty slot", "clearance (19)", "2. robot 1 to slot 2", "N", "E", "D", "Energy"],
        &["East, m", "North, m", "3. robot 2 to slot 3", "robot at the end", "Best"],
        &["Surge velocity u, m/s", "Yaw rate r, rad/s", "robot 4, ", "To slot 2 at (0.97, 0.00, 0.00) m"],
        &["Surge force X of the mover, N", "Yaw moment N", "Restoring moment M"],
        &["Energy: power, W", "balancing", "planned, both", "robot 3", "Time, s"],
        &["Thruster 1, µs", "Thruster 6, µs", "no thrust, 1472–1528 µs", "Euclidean"],
    ];
    for ((name, svg), labels) in pictures(&records).into_iter().zip(labels) {
        assert_sound(name, &svg);
        assert_words_stay_inside(name, &svg);
        for label in labels {
            assert!(svg.contains(label), "{name} lacks {label:?}");
        }
        for robot in &records[0].problem.robots {
            let (id, named) = (robot.id.to_string(), format!("robot {}", robot.id));
            let is_there = words(&svg).iter().any(|w| w.text == id || w.text.contains(&named));
            assert!(is_there, "{name} lacks robot {id}");
        }
        assert!(svg.contains("<title>tank &lt;2&gt; &amp; co"), "{name}");
        assert!(svg.contains("stroke-dasharray"), "{name}");
        assert!(svg.len() < 500_000, "{name} has {} bytes", svg.len());
    }
}

#[test]
fn words_do_not_stand_on_each_other() {
    for (case, records) in [
        ("far", sample::far().to_vec()),
        ("below", sample::below().to_vec()),
        ("eight", vec![sample::eight()]),
    ] {
        let [_, _, series @ ..] = pictures(&records);
        for (name, svg) in series {
            assert_words_stand_clear(&format!("{case}, {name}"), &svg);
        }
    }
}

#[test]
fn layers_and_large_fleets_stay_inside() {
    for (case, records) in [("below", sample::below().to_vec()), ("eight", vec![sample::eight()])] {
        for (name, svg) in pictures(&records) {
            let case = format!("{case}, {name}");
            assert_sound(&case, &svg);
            assert_words_stay_inside(&case, &svg);
            for robot in &records[0].problem.robots {
                let (id, named) = (robot.id.to_string(), format!("robot {}", robot.id));
                assert!(words(&svg).iter().any(|w| w.text == id || w.text.contains(&named)), "{case}: {id}");
            }
        }
    }
    let heave = quantities::velocity(&sample::below()).expect("a picture");
    assert!(heave.contains("Heave velocity w, m/s"));
    assert!(scene::svg(&sample::below()).expect("a picture").contains("sensor"));
}

#[test]
fn odd_records_still_give_pictures() {
    let whole = sample::far()[0].clone();
    let mut unexecuted = whole.clone();
    unexecuted.samples.clear();
    let mut single = whole.clone();
    single.samples.truncate(1);
    let mut still = whole.clone();
    (still.samples, still.plan.moves) = (Vec::new(), Vec::new());
    let mut nothing = still.clone();
    nothing.problem.robots.clear();
    nothing.problem.tools.clear();
    nothing.problem.slots.clear();
    nothing.problem.vehicles.clear();
    let mut alone = whole.problem.clone();
    alone.robots.truncate(1);
    alone.slots.truncate(1);
    let one = sample::record(&alone, whole.plan.criterion, whole.plan.manner, &[(0, 0, &[])]);
    let mut broken = whole.clone();
    broken.samples[3].robots[1].eta[0] = f64::NAN;
    broken.samples[4].robots[1].nu[0] = f64::INFINITY;
    broken.samples[5].robots.clear();
    broken.samples[6].t_s = f64::NAN;
    broken.samples[7].robots[1].power_w = f64::NAN;
    broken.samples[8].robots[1].pulses_us.clear();
    broken.samples[9].restoring_nm[1] = f64::NAN;
    broken.samples[10].robots[1].eta[1] = 1e300;
    broken.plan.moves[1].path[1][2] = f64::NAN;
    broken.plan.moves[1].actions[0].energy_j = f64::NAN;
    broken.plan.moves[2].robot = 77;
    broken.plan.moves[3].slot = Some(9);
    broken.problem.name = "a name that goes on and on ".repeat(20);
    let cases = [
        ("no record", Vec::new()),
        ("unexecuted", vec![unexecuted]),
        ("single", vec![single]),
        ("still", vec![still]),
        ("nothing", vec![nothing]),
        ("one robot", vec![one]),
        ("broken", vec![broken, whole]),
    ];
    for (case, records) in &cases {
        for (name, svg) in pictures(records) {
            let case = format!("{case}, {name}");
            assert_sound(&case, &svg);
            assert_words_stay_inside(&case, &svg);
        }
    }
}

#[test]
fn files_are_written_and_a_missing_folder_is_named() {
    let folder = tempfile::tempdir().expect("a folder");
    let files = write_all(&sample::far(), folder.path()).into_iter();
    let files: Vec<_> = files.collect::<Result<_, _>>().expect("six pictures");
    let names: Vec<_> = files.iter().filter_map(|f| f.file_name()?.to_str()).collect();
    assert_eq!(names, ["scene.svg", "top.svg", "velocity.svg", "force.svg", "power.svg", "pwm.svg"]);
    for file in &files {
        assert!(std::fs::read_to_string(file).expect("a text").starts_with("<svg xmlns="));
    }
    let missing = folder.path().join("not/there");
    let errors: Vec<_> = write_all(&sample::far(), &missing)
        .into_iter()
        .map(|file| file.expect_err("no such folder"))
        .collect();
    assert_eq!(errors.len(), files.len(), "each is named");
    let error = errors[0].to_string();
    assert!(error.contains("not/there") && error.contains("scene.svg"), "{error}");
}
