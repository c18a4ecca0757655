use super::*;

const GOOD: &str = "name = \"tank fleet\"\n[[module]]\nid = 3\nname = \"Ada\"\ncell = [0, 0]\n\
                    [[module]]\nid = 1\nkind = \"modboat\"\ncell = [1, 0]\n\
                    [[module]]\nid = 1024\nkind = \"rov\"\ncell = [2, 0]\n";

fn without_cells() -> String {
    GOOD.lines().filter(|line| !line.starts_with("cell")).map(|line| format!("{line}\n")).collect()
}

fn seats(text: &str, cells: &[[i32; 2]]) -> Result<Vec<u16>, String> {
    let structure = Structure::from_cells(cells).unwrap();
    let seats = Roster::parse("t.toml", text).unwrap().seats(&structure);
    seats.map(|seats| seats.into_iter().map(|id| id.0).collect()).map_err(|error| error.to_string())
}

#[test]
fn a_roster_is_read_as_it_stands() {
    let roster = Roster::parse("t.toml", GOOD).unwrap();
    assert_eq!(roster.name(), "tank fleet");
    assert_eq!(roster.ids().map(|id| id.0).collect::<Vec<_>>(), [3, 1, 1024]);
    let ada = Member {
        name: Some("Ada".to_owned()),
        cell: Some([0, 0]),
        ..Member::plain(ModuleId(3), ModuleKind::Modboat)
    };
    assert_eq!(roster.members()[0], ada);
    assert_eq!(roster.member(ModuleId(3)), Some(&ada));
    assert_eq!(roster.member(ModuleId(1024)).unwrap().kind, ModuleKind::Rov);
    assert_eq!(roster.member(ModuleId(2)), None);
    assert!(roster.has_cells());
    let least = Roster::parse("t.toml", "[[module]]\nid = 7\n").unwrap();
    assert_eq!((least.name(), least.has_cells()), ("", false));
    assert_eq!(least.members(), [Member::plain(ModuleId(7), ModuleKind::Modboat)]);
}

#[test]
fn places_are_taken_by_cell_or_in_order() {
    assert_eq!(seats(GOOD, &[[1, 0], [0, 0]]), Ok(vec![1, 3]));
    assert_eq!(
        seats(GOOD, &[[0, 0], [0, 1]]),
        Err("roster \"tank fleet\" has no module for cell [0, 1]".to_owned())
    );
    assert_eq!(
        seats(GOOD, &[[0, 0], [1, 0], [2, 0]]),
        Err("roster \"tank fleet\" has an ROV, module 1024, for cell [2, 0]".to_owned())
    );
    let text = without_cells();
    assert_eq!(seats(&text, &[[5, 5]]), Ok(vec![3]));
    assert_eq!(seats(&text, &[[1, 0], [0, 0]]), Ok(vec![3, 1]));
    assert_eq!(
        seats(&text, &[[0, 0], [1, 0], [2, 0]]),
        Err("roster \"tank fleet\" has 2 Modboats for 3 places".to_owned())
    );
}

#[test]
fn without_a_roster_modules_count_from_one() {
    let structure = Structure::from_word("32x32").unwrap();
    let roster = Roster::numbered(structure.len(), ModuleKind::Modboat);
    let expected: Vec<ModuleId> = (1..=1024).map(ModuleId).collect();
    assert_eq!(roster.seats(&structure).unwrap(), expected);
    assert!(roster.members().iter().all(|member| member.name.is_none() && member.cell.is_none()));
    assert_eq!(Roster::numbered(3, ModuleKind::Modboat).ids().count(), 3);
    assert_eq!(Roster::numbered(5000, ModuleKind::Modboat).ids().count(), 1024);
}

#[test]
fn mistakes_are_named_with_their_line() {
    for (text, expected) in [
        (String::new(), "t.toml:1: a roster needs at least one [[module]]"),
        ("name = \"t\"\nmodule = []\n".to_owned(), "t.toml:2: a roster needs at least one [[module]]"),
        (GOOD.replace("id = 1\n", "id = 3\n"), "t.toml:7: [[module]] 2: id = 3: [[module]] 1 has it already"),
        (GOOD.replace("id = 3", "id = 0"), "t.toml:3: [[module]] 1: id = 0: must be from 1 to 1024"),
        (GOOD.replace("id = 3", "id = 1025"), "t.toml:3: [[module]] 1: id = 1025: must be from 1 to 1024"),
        (
            GOOD.replace("id = 3", "id = -70000"),
            "t.toml:3: [[module]] 1: id = -70000: must be from 1 to 1024",
        ),
        (GOOD.replace("id = 3", "id = \"3\""), "t.toml:3: [[module]] 1: id = \"3\": must be a whole number"),
        (GOOD.replace("id = 3\n", ""), "t.toml:2: [[module]] 1: missing field `id`"),
        (GOOD.replace("kind", "sort"), "t.toml:8: [[module]] 2: unknown field `sort`"),
        (format!("nme = \"t\"\n{GOOD}"), "t.toml:1: unknown field `nme`"),
        (
            GOOD.replace("\"modboat\"", "\"boat\""),
            "t.toml:8: [[module]] 2: kind = \"boat\": unknown name, expected `modboat` or `rov`",
        ),
        (
            GOOD.replace("[1, 0]", "[0, 0]"),
            "t.toml:9: [[module]] 2: cell = [0, 0]: [[module]] 1 sits there already",
        ),
        (
            GOOD.replace("[1, 0]", "[1, 0, 0]"),
            "t.toml:9: [[module]] 2: cell = [1, 0, 0]: a list of 3 where 2 are",
        ),
        (GOOD.replace("[1, 0]", "[1]"), "t.toml:9: [[module]] 2: cell = [1]: a list of 1 where 2 are"),
        (
            GOOD.replace("[1, 0]", "[10001, 0]"),
            "t.toml:9: [[module]] 2: cell = [10001, 0]: must lie within ±10000",
        ),
        (
            GOOD.replace("cell = [1, 0]\n", ""),
            "t.toml:6: [[module]] 2: has no cell, but [[module]] 1 has one: all have one",
        ),
        (
            GOOD.replace("cell = [0, 0]\n", ""),
            "t.toml:8: [[module]] 2: has a cell, but [[module]] 1 has none: all have one",
        ),
        (GOOD.replace("Ada", "A\\nda"), "t.toml:4: [[module]] 1: name = \"A\\nda\": at most 100 characters"),
        (GOOD.replace("tank fleet", &"t".repeat(101)), "t.toml:1: name = \"ttt"),
        (GOOD.replace("[[module]]", "[[module"), "t.toml:2: "),
    ] {
        let complaint = Roster::parse("t.toml", &text).expect_err(&text).to_string();
        assert!(complaint.starts_with(expected), "{complaint}\nexpected {expected}");
    }
    let missing = Roster::read(Path::new("no-such.toml")).expect_err("no file").to_string();
    assert_eq!(missing, "no-such.toml: no such file");
}

/// The ROVs of a file are the robots of a scenario in the file's order, with their bodies; Modboats between them are no robots.
#[test]
fn rovs_take_their_places_in_order() {
    let text = "[[module]]\nid = 9\nkind = \"rov\"\nbody = \"yellow\"\nbody_turn_rad = 0.5\n\
                [[module]]\nid = 4\n[[module]]\nid = 2\nkind = \"rov\"\n[[module]]\nid = 3\nkind = \"rov\"\n";
    let roster = Roster::parse("fleet.toml", text).expect("a roster");
    let seats = roster.rov_seats(2).expect("enough");
    assert_eq!(seats, [ModuleId(9), ModuleId(2)]);
    let bodies = roster.bodies(false, &seats).expect("bodies");
    let names: Vec<String> = bodies.entries().iter().map(|entry| entry.body.to_string()).collect();
    assert_eq!(names, ["\"yellow\"", "\"module-2\""]);
    let error = roster.rov_seats(4).expect_err("three").to_string();
    assert_eq!(error, "roster \"\" has 3 ROVs (kind = \"rov\") for 4 robots");
    assert_eq!(Roster::numbered(3, ModuleKind::Rov).rov_seats(3).expect("three"), [1, 2, 3].map(ModuleId));
}
