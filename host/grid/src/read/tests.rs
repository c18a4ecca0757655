use super::*;
use crate::Map;

const MAP: &str = "type octile\nheight 2\nwidth 3\nmap\n.G@\nSWT\n";
const VOXELS: &str = "voxel 3 2 1\n2 1 0\n0 0 0\n";

fn said<T>(outcome: Result<T, ReadError>) -> String {
    outcome.err().map(|error| error.to_string()).unwrap_or_default()
}

#[test]
fn maps_are_read() {
    for text in [MAP.to_owned(), MAP.replace('\n', "\r\n"), format!("{MAP}\n\n")] {
        let plane = plane(&text).expect("a map");
        let free: Vec<_> = (0..2).flat_map(|y| (0..3).map(move |x| (x, y))).collect();
        let free: Vec<_> = free.into_iter().filter(|&(x, y)| plane.is_free(x, y)).collect();
        assert_eq!((plane.width(), plane.height(), free), (3, 2, vec![(0, 0), (1, 0), (0, 1)]));
    }
    let volume = volume(VOXELS).expect("a map");
    let open = |cell| volume.is_open(volume.vertex(cell).expect("on the map"));
    assert_eq!(volume.last(), [2, 1, 0]);
    assert!(!open([2, 1, 0]) && !open([0, 0, 0]) && open([1, 1, 0]) && open([2, 0, 0]));
}

#[test]
fn scenarios_are_read() {
    let plane = plane(MAP).expect("a map");
    let text = "version 1\n0\tmy map.map\t3\t2\t0\t0\t1\t1\t2.82842712\n";
    let expected = Query { line: 2, start: [0, 0], goal: [1, 1], length: 2.82842712 };
    assert_eq!(plane_scenario(text, &plane), Ok(vec![expected]));
    assert_eq!(plane_scenario(&text.replace("my map", "m").replace('\t', " "), &plane), Ok(vec![expected]));
    assert_eq!(plane_scenario("version 1.0\n", &plane), Ok(vec![]));
    let text = "version 1\nA1.3dmap\n\n1 0 0 2 0 0 1.5 1.000\n";
    let expected = Query { line: 4, start: [1, 0, 0], goal: [2, 0, 0], length: 1.5 };
    assert_eq!(volume_scenario(text, [2, 1, 0]), Ok(vec![expected]));
}

#[test]
fn mistakes_are_named_with_line_and_value() {
    let cases = [
        (said(plane("")), "1: \"\": type octile, height and width before map expected"),
        (said(plane("type hexile\n")), "1: \"type hexile\": type octile, height, width or map expected"),
        (said(plane(&MAP.replace("width 3\n", ""))), "3: \"\": type octile, height and width before map"),
        (said(plane(&MAP.replace("height 2", "height -2"))), "2: \"-2\": a whole number expected"),
        (said(plane(&MAP.replace("height 2", "height 70000"))), "2: height = 70000 cells: must be between 1"),
        (said(plane(&MAP.replace("width 3", "width 0"))), "3: width = 0 cells: must be between 1 and 65535"),
        (said(plane(&MAP.replace("SWT", "SW"))), "6: 2 cells in a row, 3 expected"),
        (said(plane(&MAP.replace("SWT\n", ""))), "5: 1 rows, 2 expected"),
        (said(plane(&format!("{MAP}...\n"))), "7: 3 rows, 2 expected"),
        (said(plane(&MAP.replace("SWT", "S?T"))), "6: \"?\": one of . G S @ O T W expected"),
        (said(volume("")), "1: \"\": voxel X Y Z expected"),
        (said(volume("voxel 3 2\n")), "1: \"voxel 3 2\": voxel X Y Z expected"),
        (said(volume("voxel 3 2 0\n")), "1: side = 0 cells: must be between 1 and 65535"),
        (
            said(volume("voxel 65535 65535 65535\n")),
            "1: map = 281462092005375 cells: must be at most 536870912",
        ),
        (said(volume("voxel 3 2 1\n0 0\n")), "2: \"0 0\": x y z of a blocked cell expected"),
        (said(volume("voxel 3 2 1\n0 0 x\n")), "2: \"x\": a whole number expected"),
        (
            said(volume("voxel 3 2 1\n0 2 0\n")),
            "2: blocked cell [0, 2, 0] is outside the map, whose last is [2, 1, 0]",
        ),
    ];
    for (said, expected) in cases {
        assert!(said.starts_with(expected), "{said}");
    }
    let plane = plane(MAP).expect("a map");
    let scenario = |text: &str| said(plane_scenario(text, &plane));
    let volume = |text: &str| said(volume_scenario(text, [2, 1, 0]));
    let cases = [
        (scenario(""), "1: \"\": version 1 expected"),
        (scenario("0 m 3 2 0 0 1 1 1\n"), "1: \"0 m 3 2 0 0 1 1 1\": version 1 expected"),
        (scenario("version 1\n0 m 3 2 0 0 1 1\n"), "2: \"0 m 3 2 0 0 1 1\": bucket, map, width, height"),
        (scenario("version 1\n0 m 4 2 0 0 1 1 1\n"), "2: width = 4 cells: must be 3 as in the map"),
        (
            scenario("version 1\n0 m 3 2 0 0 3 1 1\n"),
            "2: goal [3, 1] is outside the map, whose last is [2, 1]",
        ),
        (scenario("version 1\n0 m 3 2 -1 0 1 1 1\n"), "2: \"-1\": a whole number expected"),
        (scenario("version 1\n0 m 3 2 0 0 1 1 NaN\n"), "2: \"NaN\": a length expected"),
        (volume("version 1\nm\n0 0 0 1 1 0 1.4\n"), "3: \"0 0 0 1 1 0 1.4\": start x y z, goal x y z"),
        (volume("version 1\nm\n0 0 1 1 1 0 1.4 1\n"), "3: start [0, 0, 1] is outside the map"),
    ];
    for (said, expected) in cases {
        assert!(said.starts_with(expected), "{said}");
    }
}
