//! Which file imports which inside a crate, read off the source text.
//!
//! A path that begins with `crate`, `super` or `self` counts for the longest prefix that is a module with a file of its
//! own. Code under `#[cfg(test)]` and comments do not count, nor does an import between a module and its direct child.
//!
//! Limits: text is read line by line, not compiled; what a macro makes up is not seen, and what a module re-exports counts for that
//! module.

use std::collections::{BTreeMap, BTreeSet};

type Module = Vec<String>;

/// Files of one crate that import each other, directly or around; each circle sorted.
pub fn circles(files: &[(String, String)]) -> Vec<Vec<String>> {
    let files = without_test_files(files);
    let modules: BTreeMap<Module, String> =
        files.into_iter().map(|(file, text)| (module_of(file), text)).collect();
    let imports: BTreeMap<&Module, BTreeSet<&Module>> = modules
        .iter()
        .map(|(module, text)| {
            let found = paths(text).into_iter().filter_map(|path| {
                let full = resolved(module, &path)?;
                let (target, _) = (0..=full.len()).rev().find_map(|n| modules.get_key_value(&full[..n]))?;
                let kin = target.split_last().is_some_and(|(_, parent)| parent == module.as_slice())
                    || module.split_last().is_some_and(|(_, parent)| parent == target.as_slice());
                (target != module && !kin).then_some(target)
            });
            (module, found.collect())
        })
        .collect();
    let reach: BTreeMap<&Module, BTreeSet<&Module>> =
        imports.keys().map(|&module| (module, reached(&imports, module))).collect();
    let mut circles: BTreeSet<Vec<String>> = BTreeSet::new();
    for (module, reached) in reach.iter().filter(|(module, reached)| reached.contains(*module)) {
        let circle = reached.iter().filter(|other| reach[*other].contains(*module));
        circles.insert(circle.map(|other| other.join("::")).collect());
    }
    circles.into_iter().collect()
}

/// The files that are no modules of tests, each without its comments and tests.
pub fn without_test_files(files: &[(String, String)]) -> Vec<(&str, String)> {
    let tests = test_modules(files);
    let is_test = |file: &str| tests.iter().any(|test| module_of(file).starts_with(test));
    let kept = files.iter().filter(|(file, _)| !is_test(file));
    kept.map(|(file, text)| (file.as_str(), without_tests(text))).collect()
}

fn reached<'a>(imports: &BTreeMap<&'a Module, BTreeSet<&'a Module>>, from: &Module) -> BTreeSet<&'a Module> {
    let mut found = BTreeSet::new();
    let mut open: Vec<&Module> = imports[from].iter().copied().collect();
    while let Some(module) = open.pop() {
        if found.insert(module) {
            open.extend(&imports[module]);
        }
    }
    found
}

/// The module of a file below `src`: `tail.rs` and `tail/mod.rs` are `[tail]`, `lib.rs` is the root.
fn module_of(file: &str) -> Module {
    let mut path: Module = file.trim_end_matches(".rs").split('/').map(str::to_owned).collect();
    if path.last().is_some_and(|last| matches!(last.as_str(), "mod" | "lib" | "main")) {
        path.pop();
    }
    path
}

/// Modules declared under `#[cfg(test)]`.
fn test_modules(files: &[(String, String)]) -> Vec<Module> {
    let mut found = Vec::new();
    for (file, text) in files {
        let lines: Vec<&str> = text.lines().map(str::trim).collect();
        for pair in lines.windows(2).filter(|pair| pair[0] == "#[cfg(test)]") {
            let name = pair[1]
                .trim_start_matches("pub ")
                .strip_prefix("mod ")
                .and_then(|rest| rest.strip_suffix(';'));
            found.extend(name.map(|name| [module_of(file), vec![name.to_owned()]].concat()));
        }
    }
    found
}

/// The text without comments and without items under `#[cfg(test)]`: one statement, or all up to the closing brace.
fn without_tests(text: &str) -> String {
    let mut kept = String::new();
    let mut lines = text.lines();
    while let Some(line) = lines.next() {
        if line.trim() != "#[cfg(test)]" {
            kept.push_str(line.split("//").next().unwrap_or_default());
            kept.push('\n');
            continue;
        }
        let indent = line.len() - line.trim_start().len();
        let ends = |line: &str| line.trim_start().len() + indent == line.len() && line.ends_with(['}', ';']);
        lines.by_ref().find(|line| ends(line));
    }
    kept
}

/// Every path that begins with `crate`, `super` or `self`, with each item of a list in braces after it.
fn paths(text: &str) -> Vec<Module> {
    let is_name = |c: char| c.is_alphanumeric() || c == '_';
    let mut found = Vec::new();
    for (start, _) in text.char_indices().filter(|&(_, c)| is_name(c)) {
        let before = &text[..start];
        let mut rest = &text[start..];
        let begins = ["crate::", "super::", "self::"].iter().any(|word| rest.starts_with(word));
        if !begins || before.ends_with(is_name) || before.ends_with("::") {
            continue;
        }
        let mut path = Module::new();
        loop {
            let end = rest.find(|c| !is_name(c)).unwrap_or(rest.len());
            path.push(rest[..end].to_owned());
            match rest[end..].strip_prefix("::") {
                Some(more) => rest = more,
                None => break,
            }
        }
        match rest.strip_prefix('{').and_then(|list| list.split_once(';')) {
            Some((list, _)) => {
                path.pop();
                let items = list.split(['{', '}', ',']).map(str::trim).filter(|item| !item.is_empty());
                found.extend(items.map(|item| {
                    let names = item.split("::").map(str::to_owned);
                    path.iter().cloned().chain(names).collect()
                }));
            }
            None => found.push(path),
        }
    }
    found
}

/// A path as seen from `module`, from the root of its crate on.
fn resolved(module: &[String], path: &[String]) -> Option<Module> {
    let mut base = module.to_vec();
    for segment in path {
        match segment.as_str() {
            "crate" => base.clear(),
            "self" => {}
            "super" => drop(base.pop()?),
            name => base.push(name.to_owned()),
        }
    }
    Some(base)
}

#[test]
fn a_circle_is_found_and_kin_and_tests_are_left_out() {
    let file = |name: &str, text: &str| (name.to_owned(), text.to_owned());
    let mut files = vec![
        file("lib.rs", "pub mod a;\npub mod b;\npub mod c;\n"),
        file("a.rs", "mod child;\nuse super::b::{B, deep::X};\nuse child::Y; // crate::c\n"),
        file("a/child.rs", "use super::A;\n"),
        file("b/mod.rs", "fn f(_: super::c::C) {}\n"),
        file(
            "c.rs",
            "#[cfg(test)]\nuse super::a::A;\n\n#[cfg(test)]\nmod tests {\n    use super::a::A;\n}\n",
        ),
    ];
    assert!(circles(&files).is_empty(), "{:?}", circles(&files));
    files[4].1.push_str("fn g() -> crate::a::child::Y {}\n");
    assert!(circles(&files).is_empty(), "a child does not import for its parent");
    files[4].1.push_str("type A = super::a::A;\n");
    assert_eq!(circles(&files), [["a", "b", "c"]]);
}
