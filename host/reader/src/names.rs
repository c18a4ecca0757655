//! A name that is unknown: the nearest one, and those that there are.

/// Names are near from this Jaro–Winkler likeness on (0: nothing in common, 1: the same). *Assumed*: it takes slips of the
/// finger and a unit that was left out, `mass` for `mass_kg`.
const NEAR: f64 = 0.8;

/// The one of `names` that is nearest to `name`, if one is near.
pub fn nearest<'n>(name: &str, names: impl IntoIterator<Item = &'n str>) -> Option<&'n str> {
    let word = name.to_lowercase();
    let likeness = |known: &str| strsim::jaro_winkler(&word, &known.to_lowercase());
    let near = names.into_iter().map(|known| (likeness(known), known)).filter(|(near, _)| *near >= NEAR);
    // The first of several that are as near.
    near.min_by(|(a, _), (b, _)| b.total_cmp(a)).map(|(_, known)| known)
}

/// What is said of a word that is none of `names`: those that there are, and the nearest.
#[must_use]
pub fn there_are(name: &str, names: &[&str]) -> String {
    let near = nearest(name, names.iter().copied());
    let near = near.map_or_else(String::new, |near| format!("; did you mean {near}?"));
    format!("there are {}{near}", names.join(", "))
}

/// The same of a key or a value in a document.
pub(crate) fn expected(name: &str, names: &[&str]) -> String {
    let near = nearest(name, names.iter().copied());
    let near = near.map_or_else(String::new, |near| format!("; did you mean `{near}`?"));
    let quoted: Vec<String> = names.iter().map(|name| format!("`{name}`")).collect();
    match quoted.as_slice() {
        [] => "there are none".to_owned(),
        [one] => format!("expected {one}"),
        [one, other] => format!("expected {one} or {other}{near}"),
        all => format!("expected one of {}{near}", all.join(", ")),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn slips_and_units_left_out_are_near_and_other_words_are_not() {
        let keys = ["mass_kg", "period_s", "box_m", "name", "kind"];
        for (name, expected) in [
            ("mass", Some("mass_kg")),
            ("period", Some("period_s")),
            ("perid_s", Some("period_s")),
            ("PERIOD_S", Some("period_s")),
            ("box", Some("box_m")),
            ("nme", Some("name")),
            ("colour", None),
            ("", None),
        ] {
            assert_eq!(nearest(name, keys), expected, "{name}");
        }
    }

    #[test]
    fn all_names_are_offered() {
        assert_eq!(expected("x", &[]), "there are none");
        assert_eq!(expected("x", &["kind"]), "expected `kind`");
        assert_eq!(expected("knd", &["kind", "name"]), "expected `kind` or `name`; did you mean `kind`?");
        assert_eq!(expected("x", &["a", "b", "c"]), "expected one of `a`, `b`, `c`");
        assert_eq!(there_are("rovv", &["modboat", "rov"]), "there are modboat, rov; did you mean rov?");
    }
}
