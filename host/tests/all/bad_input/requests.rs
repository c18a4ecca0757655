//! Bad requests in a stream of good ones.

use std::io::Write;

use serde_json::Value;
use tempfile::tempdir;

use crate::common::Process;

/// Good requests before, between and after bad ones are answered; each bad one has its line in both streams.
#[test]
fn bad_requests_get_an_error_line_each_and_the_stream_goes_on() {
    let demand = r#""demand":{"fx_n":0.02,"fy_n":0.0,"tau_nm":0.0}"#;
    let cells = r#""cells":[[0,0],[1,0]]"#;
    let good = format!("{{{cells},{demand},\"tail_rad\":null}}");
    let row = |n: usize| (0..n).map(|col| format!("[{col},0]")).collect::<Vec<_>>().join(",");
    let of_cells = |list: &str| format!("{{\"cells\":[{list}],{demand},\"tail_rad\":null}}");
    let of_tails = |tails: &str| format!("{{{cells},{demand},\"tail_rad\":{tails}}}");
    let of_force = |force: &str| good.replace("0.02", force);
    let bad: Vec<(String, &[&str])> = vec![
        (of_tails("\"previous\""), &["no plan came before"]),
        (of_force("NaN"), &["column 41: ", "found NaN"]),
        (of_force("nan"), &["found nan"]),
        (of_force("Infinity"), &["found Infinity"]),
        (of_force("1e300"), &["demand.fx_n = 1e300 N", "at most 1e6"]),
        (of_force("-1e300"), &["demand.fx_n = -1e300 N"]),
        (of_force("1e999"), &["demand.fx_n = 1e999: number out of range"]),
        (good.replace("\"tau_nm\":0.0", "\"tau_nm\":2e6"), &["demand.tau_nm = 2e6 N·m"]),
        (of_force("\"much\""), &["demand.fx_n = \"much\": must be a number"]),
        (of_force("null"), &["demand.fx_n = null: must be a number"]),
        (good[..good.len() / 2].to_owned(), &["EOF"]),
        (format!("{good} {good}"), &["trailing characters"]),
        (String::new(), &["empty"]),
        ("   ".to_owned(), &["empty"]),
        ("[]".to_owned(), &["must be an object"]),
        ("null".to_owned(), &["must be an object"]),
        ("42".to_owned(), &["must be an object"]),
        ("hello".to_owned(), &["found hello"]),
        (good.replace("\"tail_rad\":null", "\"tail_rad\":null,\"speed\":1"), &["unknown field `speed`"]),
        (good.replace("\"fx_n\"", "\"fx\""), &["demand: unknown field `fx`", "did you mean `fx_n`?"]),
        (good.replace("\"tau_nm\":0.0", "\"fx_n\":0.0"), &["duplicate field `fx_n`"]),
        (good.replace(",\"tau_nm\":0.0", ""), &["demand: missing field `tau_nm`"]),
        (format!("{{{cells},\"tail_rad\":null}}"), &["missing field `demand`"]),
        (format!("{{{demand},\"tail_rad\":null}}"), &["missing field `cells`"]),
        (of_cells(""), &["cells: ", "at least one module"]),
        (of_cells("[0,0],[0,0]"), &["cells: ", "[0, 0]", "twice"]),
        (of_cells("[0,0],[2,0]"), &["cells: ", "pieces"]),
        (of_cells(&row(1025)), &["cells: 1025 modules", "1024"]),
        (of_cells("[0,0],[2147483647,2147483647]"), &["cells: ", "[2147483647, 2147483647]", "10000"]),
        (of_cells("[-2147483648,0]"), &["cells: ", "[-2147483648, 0]"]),
        (of_cells("[2147483648,0]"), &["cells[0][0] = 2147483648: must be a whole number from"]),
        (of_cells("[0.5,0]"), &["cells[0][0] = 0.5: must be a whole number from"]),
        (of_cells("[0,0,0]"), &["cells[0] = [0,0,0]: a list of 3 where 2 are asked for"]),
        (of_cells("[0]"), &["cells[0] = [0]: a list of 1 where 2 are asked for"]),
        (of_tails("[0.0]"), &["tail_rad has 1 angles for 2 cells"]),
        (of_tails("[0.0,0.0,0.0]"), &["tail_rad has 3 angles for 2 cells"]),
        (of_tails("[]"), &["tail_rad has 0 angles for 2 cells"]),
        (of_tails("[0.0,1e300]"), &["tail_rad[1] = 1e300 rad", "at most 1e6"]),
        (of_tails("[0.0,NaN]"), &["found NaN"]),
        (of_tails("\"next\""), &["list of angles, null or \"previous\""]),
        (of_tails("0.0"), &["list of angles, null or \"previous\""]),
        (of_tails("[null,null]"), &["list of angles, null or \"previous\""]),
        (of_tails(&format!("{}{}", "[".repeat(100_000), "]".repeat(100_000))), &["recursion limit"]),
        (format!("{{\"cells\":{}", "[".repeat(100_000)), &["column "]),
        ("x".repeat(3 << 20), &["longer than 1048576 bytes"]),
        (of_cells("[0,0],[0,1]").replace("null", "\"previous\""), &["for other cells"]),
    ];
    let folder = tempdir().expect("a folder");
    let mut plan = Process::start(folder.path(), &["plan"]);
    let mut input = plan.input.take().expect("a pipe");
    // The first is "previous" with nothing before it. From then on the good one stands after every bad one.
    let (requests, last): (Vec<_>, _) = (bad.iter().map(|(line, _)| line.clone()).collect(), good.clone());
    let writer = std::thread::spawn(move || {
        for line in requests {
            writeln!(input, "{line}\n{last}").expect("it reads");
        }
        input.write_all(b"\xff\xfe{}\n").expect("it reads");
        // Half a line, and the end of the stream.
        input.write_all(&last.as_bytes()[..20]).expect("it reads");
    });
    let finished = plan.finish();
    writer.join().expect("written");

    assert_eq!(finished.code, Some(2));
    assert_eq!(finished.out.len(), 2 * bad.len() + 2, "one line out for each in");
    assert_eq!(finished.err.len(), bad.len() + 2, "one line of complaint for each bad request");
    for (index, (request, expected)) in bad.iter().enumerate() {
        let shown: String = request.chars().take(120).collect();
        let error = error_of(&finished.out[2 * index]);
        for &part in *expected {
            assert!(error.contains(part), "{shown}\n{error}\ndoes not say {part:?}");
        }
        assert!(error.len() < 400, "{shown}\n{error}");
        assert_eq!(finished.err[index], format!("flotilla: line {}: {error}", 2 * index + 1));
        let answer: Value = serde_json::from_str(&finished.out[2 * index + 1]).expect("JSON");
        assert_eq!(answer["outcome"], "planned", "after {shown}");
    }
    let rest = &finished.out[2 * bad.len()..];
    assert!(error_of(&rest[0]).contains("column 1: is not UTF-8"), "{rest:?}");
    assert!(error_of(&rest[1]).contains("EOF"), "{rest:?}");
}

fn error_of(line: &str) -> String {
    let answer: Value = serde_json::from_str(line).expect("JSON");
    let object = answer.as_object().expect("an object");
    assert_eq!(object.len(), 1, "nothing but the error: {line}");
    object["error"].as_str().expect("a text").to_owned()
}
