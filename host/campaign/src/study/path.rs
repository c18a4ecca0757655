//! A key of a scenario's file by its path: `tank.current_m_s.0`, `leg.0.duration_s`.

use toml::{Table, Value};

/// Sets what is at `path` of `table`. Tables that are missing are made; items of lists are not.
///
/// # Errors
/// What stands in the way.
pub fn set(table: &mut Table, path: &str, value: &Value) -> Result<(), String> {
    let steps: Vec<&str> = path.split('.').collect();
    let Some((last, way)) = steps.split_last() else { return Ok(()) };
    let mut node = None;
    let mut at = String::new();
    for step in way {
        let inner = match node {
            None => inner_of_table(table, step),
            Some(node) => inner(node, step, &at)?,
        };
        at = if at.is_empty() { (*step).to_owned() } else { format!("{at}.{step}") };
        node = Some(inner);
    }
    match node {
        None => drop(table.insert((*last).to_owned(), value.clone())),
        Some(Value::Table(table)) => drop(table.insert((*last).to_owned(), value.clone())),
        Some(list @ Value::Array(_)) => *inner(list, last, &at)? = value.clone(),
        Some(_) => return Err(format!("`{at}` is a value, and no table or list")),
    }
    Ok(())
}

fn inner_of_table<'n>(table: &'n mut Table, step: &str) -> &'n mut Value {
    table.entry(step.to_owned()).or_insert_with(|| Value::Table(Table::new()))
}

fn inner<'n>(node: &'n mut Value, step: &str, at: &str) -> Result<&'n mut Value, String> {
    match node {
        Value::Table(table) => Ok(inner_of_table(table, step)),
        Value::Array(items) => {
            let count = items.len();
            let item = step.parse().ok().and_then(|index: usize| items.get_mut(index));
            item.ok_or_else(|| format!("`{at}` is a list of {count}, counted from 0: there is no `{step}`"))
        }
        _ => Err(format!("`{at}` is a value, and no table or list")),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn values_are_set_in_tables_and_lists() {
        let mut table: Table = "a = 1\nlist = [1, [2, 3]]\n[[leg]]\nv = [0.0, 1.0]\n".parse().expect("TOML");
        for (path, value) in
            [("a", 5), ("b", 6), ("c.d.e", 7), ("list.1.0", 8), ("leg.0.v.1", 9), ("leg.0.w", 10)]
        {
            set(&mut table, path, &Value::Integer(value)).expect(path);
        }
        let expected: Table = "a = 5\nb = 6\nc.d.e = 7\nlist = [1, [8, 3]]\n[[leg]]\nv = [0.0, 9]\nw = 10\n"
            .parse()
            .expect("TOML");
        assert_eq!(table, expected);
        for (path, told) in [
            ("a.b", "`a` is a value, and no table or list"),
            ("a.b.c", "`a` is a value, and no table or list"),
            ("leg.1.w", "`leg` is a list of 1, counted from 0: there is no `1`"),
            ("list.1.2", "`list.1` is a list of 2, counted from 0: there is no `2`"),
            ("list.x", "`list` is a list of 2, counted from 0: there is no `x`"),
        ] {
            assert_eq!(set(&mut table, path, &Value::Integer(0)), Err(told.to_owned()), "{path}");
        }
    }
}
