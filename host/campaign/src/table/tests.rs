use proptest::prelude::*;
use serde_json::json;

use super::*;

fn cells() -> impl Strategy<Value = Cell> {
    prop_oneof![
        Just(Cell::Null),
        any::<bool>().prop_map(Cell::Bool),
        any::<i64>().prop_map(Cell::Int),
        prop::num::f64::NORMAL.prop_map(Cell::Float),
        Just(Cell::Float(4.0)),
        "\\PC{0,8}|[\",\r\n 1.e-]{0,6}".prop_map(Cell::Text),
    ]
}

/// A table of columns that each hold one kind of cell, or nothing.
fn tables() -> impl Strategy<Value = Table> {
    (1..5_usize, 0..6_usize).prop_flat_map(|(width, height)| {
        let kinds = proptest::collection::vec(0..5_u8, width);
        let values = proptest::collection::vec(proptest::collection::vec(cells(), width), height);
        (kinds, values).prop_map(|(kinds, mut rows)| {
            for row in &mut rows {
                for (cell, kind) in row.iter_mut().zip(&kinds) {
                    let fits = matches!(
                        (&cell, kind),
                        (Cell::Bool(_), 0) | (Cell::Int(_), 1) | (Cell::Float(_), 2) | (Cell::Text(_), 3)
                    );
                    if !fits {
                        *cell = Cell::Null;
                    }
                }
            }
            Table { columns: (0..kinds.len()).map(|k| format!("c\".{k}")).collect(), rows }
        })
    })
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(100))]

    #[test]
    fn files_read_as_they_were_written(table in tables()) {
        let folder = tempfile::tempdir().expect("a folder");
        for format in Format::ALL {
            let path = folder.path().join(format!("t.{}", format.extension()));
            table.write(&path, format).expect("written");
            prop_assert_eq!(Table::read(&path).expect("read"), table.clone());
        }
        // No half-written file is left behind.
        prop_assert_eq!(std::fs::read_dir(folder.path()).expect("a folder").count(), 2);
    }
}

#[test]
fn columns_have_one_order() {
    let names = [
        "legs.10.v",
        "legs.2.v",
        "legs.2",
        "cycles.total",
        "seed",
        "tank.b.1",
        "tank.b.0",
        "tank.bc",
        "run",
        "radio.loss",
        "scenario",
    ];
    let row = |names: &[&str]| names.iter().map(|name| ((*name).to_owned(), json!(1))).collect::<Map<_, _>>();
    let varied = ["radio.loss".to_owned(), "tank.b".to_owned()];
    let expected = [
        "run",
        "scenario",
        "seed",
        "radio.loss",
        "tank.b.0",
        "tank.b.1",
        "cycles.total",
        "legs.2",
        "legs.2.v",
        "legs.10.v",
        "tank.bc",
    ];
    for turn in 0..names.len() {
        let mut names = names;
        names.rotate_left(turn);
        let rows = BTreeMap::from([(3, row(&names[..5])), (7, row(&names[5..]))]);
        assert_eq!(Table::new(&rows, &varied).columns, expected);
    }
}

#[test]
fn shards_merge_into_the_file_of_the_whole() {
    let row = |run: usize| -> Map<String, Value> {
        let mut row = Map::from_iter([("seed".to_owned(), json!(run)), ("x".to_owned(), Value::Null)]);
        if run.is_multiple_of(3) {
            row.insert("x".to_owned(), json!(0));
        }
        if run == 4 {
            row.insert("x".to_owned(), json!(0.25));
            row.insert(format!("only.{run}"), json!("text"));
        }
        row
    };
    let all: BTreeMap<usize, Map<String, Value>> = (0..20).map(|run| (run, row(run))).collect();
    let folder = tempfile::tempdir().expect("a folder");
    for format in Format::ALL {
        let file = |name: &str| folder.path().join(format!("{name}.{}", format.extension()));
        Table::new(&all, &[]).write(&file("whole"), format).expect("written");
        let shards = (0..4).map(|shard| {
            let of_shard =
                all.iter().filter(|(run, _)| *run % 4 == shard).map(|(run, row)| (*run, row.clone()));
            let path = file(&format!("shard-{shard}"));
            Table::new(&of_shard.collect(), &[]).write(&path, format).expect("written");
            Table::read(&path).expect("read")
        });
        Table::merged(shards.collect(), &[]).write(&file("merged"), format).expect("written");
        let [whole, merged] = ["whole", "merged"].map(|name| std::fs::read(file(name)).expect("read"));
        assert!(whole == merged, "{format:?}");
    }
}

#[test]
fn what_is_no_table_is_refused() {
    let folder = tempfile::tempdir().expect("a folder");
    for (name, text, told) in [
        ("a.csv", "\"x\",\"y\"\r\n1\r\n", "line 2: 1 values for 2 columns"),
        ("b.csv", "\"x\"\r\n\"y\r\n", "line 2: a quote is not closed"),
        ("c.csv", "\"x\"\r\n\"y\"z\r\n", "line 2: more after a closing quote"),
        ("d.parquet", "PAR1", ""),
        ("e.txt", "", "its name ends neither with .parquet nor with .csv"),
    ] {
        let path = folder.path().join(name);
        std::fs::write(&path, text).expect("written");
        let error = Table::read(&path).expect_err(name).to_string();
        assert!(error.ends_with(told) && error.contains(name), "{error}");
    }
}
