//! The rules of the house, read off the source text.
//!
//! ```text
//! protocol ← firmware ← host::sim ← host::run ← host::plot ← host::cli          protocol ← host::{modboat, rov, link} ← run
//!                                                                               firmware, host::link ← host::provision ← cli
//! ```
//!
//! - An area imports only from those that [`may_import`] names.
//! - The judge of plans (`host::verify`) names no part of `host::rov` but its data types.
//! - `protocol` and `firmware` never use `std` or `alloc`.
//! - Planners (`host::modboat`, `host::rov`, `host::grid`, `host::verify`) read no clock, open no socket, start no thread
//!   and print nothing. The table of DoC may use threads to be generated and a file to be kept in.
//!
//! Tests are free of all this: items under `#[cfg(test)]`, files that are such a module, and everything outside `src`.
//!
//! Limits: text is read as tokens, not compiled. What a macro makes up is not seen, nor is `super` in a module inside
//! a file told from `super` at its top.

/// One broken rule.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Breach {
    /// Path below the top of the repository.
    pub file: String,
    /// Line, from 1.
    pub line: usize,
    /// What is wrong there.
    pub what: String,
}

impl std::fmt::Display for Breach {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "{}:{}: {}", self.file, self.line, self.what)
    }
}

/// Areas that `area` may import from, beside itself.
#[must_use]
pub fn may_import(area: &str) -> &'static [&'static str] {
    match area {
        "firmware" => &["protocol"],
        "host::modboat" => &["host::quantity", "protocol"],
        "host::grid" => &["host::quantity"],
        // Of host::rov, no more than JUDGE_MAY.
        "host::verify" => &["host::quantity", "host::rov"],
        "host::rov" => &["host::quantity", "host::grid", "host::toml_lines"],
        "host::link" => &["host::quantity", "host::toml_lines", "protocol"],
        "host::provision" => &["host::quantity", "host::toml_lines", "host::link", "firmware", "protocol"],
        "host::sim" => &["host::quantity", "host::modboat", "host::rov", "firmware", "protocol"],
        "host::run" => &[
            "host::quantity",
            "host::toml_lines",
            "host::modboat",
            "host::rov",
            "host::link",
            "host::sim",
            "firmware",
            "protocol",
        ],
        "host::plot" => &["host::quantity", "host::modboat", "host::rov", "host::grid", "host::run"],
        "host::cli" => &[
            "host::quantity",
            "host::modboat",
            "host::rov",
            "host::grid",
            "host::link",
            "host::provision",
            "host::sim",
            "host::run",
            "host::plot",
            "host::verify",
            "firmware",
            "protocol",
        ],
        // The program itself.
        "host" => &["host::cli"],
        // protocol, host::quantity and whatever is new: nobody.
        _ => &[],
    }
}

/// Areas that only compute.
const PLANNERS: [&str; 4] = ["host::modboat", "host::rov", "host::grid", "host::verify"];
/// The judge of plans shares data with the planner it judges, and no code.
const JUDGE: &str = "host::verify";
const JUDGE_MAY: [&str; 4] = ["pose", "vehicle", "problem", "plan"];

/// What no planner may touch: standard modules, and names that give them away.
const IMPURE_MODULES: [&str; 7] = ["time", "net", "thread", "fs", "io", "process", "env"];
const IMPURE_NAMES: [&str; 6] =
    ["Instant", "SystemTime", "UdpSocket", "TcpStream", "TcpListener", "available_parallelism"];
const PRINTS: [&str; 5] = ["println", "print", "eprintln", "eprint", "dbg"];
/// The table of DoC: generated on all cores, kept in a file under a name of its process.
const TABLE: &str = "host/src/modboat/table.rs";
const TABLE_MAY: [&str; 5] = ["thread", "fs", "io", "process", "available_parallelism"];

#[derive(Clone, Debug, PartialEq, Eq)]
struct Token {
    line: usize,
    text: String,
}

impl Token {
    fn is_name(&self) -> bool {
        self.text.starts_with(|c: char| c.is_alphabetic() || c == '_')
    }
}

/// Names, `::` and single characters; comments, lifetimes and literals are left out.
fn tokens(source: &str) -> Vec<Token> {
    let text: Vec<char> = source.chars().collect();
    let (mut tokens, mut line, mut k) = (Vec::new(), 1, 0);
    let starts = |k: usize, what: &str| what.chars().enumerate().all(|(n, c)| text.get(k + n) == Some(&c));
    while k < text.len() {
        let begin = k;
        match text[k] {
            '/' if starts(k, "//") => {
                while k < text.len() && text[k] != '\n' {
                    k += 1;
                }
            }
            '/' if starts(k, "/*") => {
                let mut depth = 1;
                k += 2;
                while k < text.len() && depth > 0 {
                    let (opens, closes) = (starts(k, "/*"), starts(k, "*/"));
                    depth = depth + usize::from(opens) - usize::from(closes);
                    k += if opens || closes { 2 } else { 1 };
                }
            }
            'r' if starts(k, "r\"") || starts(k, "r#") => {
                let hashes = text[k + 1..].iter().take_while(|&&c| c == '#').count();
                if text.get(k + 1 + hashes) == Some(&'"') {
                    let end = format!("\"{}", "#".repeat(hashes));
                    k += 2 + hashes;
                    while k < text.len() && !starts(k, &end) {
                        k += 1;
                    }
                    k += end.len();
                } else {
                    // A raw name.
                    k += 1 + hashes;
                }
            }
            '"' => {
                k += 1;
                while k < text.len() && text[k] != '"' {
                    k += if text[k] == '\\' { 2 } else { 1 };
                }
                k += 1;
            }
            // 'x' or '\n' is a character, 'a alone a lifetime.
            '\'' if text.get(k + 1) == Some(&'\\') => {
                k += 3;
                while k < text.len() && text[k] != '\'' {
                    k += 1;
                }
                k += 1;
            }
            '\'' if text.get(k + 2) == Some(&'\'') => k += 3,
            '\'' => k += 1,
            ':' if starts(k, "::") => {
                tokens.push(Token { line, text: "::".to_owned() });
                k += 2;
            }
            c if c.is_alphanumeric() || c == '_' => {
                while k < text.len() && (text[k].is_alphanumeric() || text[k] == '_') {
                    k += 1;
                }
                tokens.push(Token { line, text: text[begin..k].iter().collect() });
            }
            c => {
                if !c.is_whitespace() {
                    tokens.push(Token { line, text: c.to_string() });
                }
                k += 1;
            }
        }
        k = k.min(text.len());
        line += text[begin..k].iter().filter(|&&c| c == '\n').count();
    }
    tokens
}

/// The tokens without items under `#[cfg(test)]`, and the modules that such an item declares in files of their own.
fn without_tests(tokens: Vec<Token>) -> (Vec<Token>, Vec<String>) {
    const MARK: [&str; 7] = ["#", "[", "cfg", "(", "test", ")", "]"];
    let (mut kept, mut modules, mut k) = (Vec::new(), Vec::new(), 0);
    while k < tokens.len() {
        let marked = tokens.len() >= k + MARK.len()
            && MARK.iter().zip(&tokens[k..]).all(|(mark, token)| token.text == *mark);
        if !marked {
            kept.push(tokens[k].clone());
            k += 1;
            continue;
        }
        k += MARK.len();
        // To the semicolon or the closing brace of the item.
        let mut depth = 0;
        while k < tokens.len() {
            let text = tokens[k].text.as_str();
            depth += i32::from(matches!(text, "{" | "(" | "[")) - i32::from(matches!(text, "}" | ")" | "]"));
            let closed = depth == 0 && matches!(text, ";" | "}");
            if closed && text == ";" && k >= 2 && tokens[k - 2].text == "mod" {
                modules.push(tokens[k - 1].text.clone());
            }
            k += 1;
            if closed {
                break;
            }
        }
    }
    (kept, modules)
}

/// Modules declared under `#[cfg(test)]` with a file of their own.
#[must_use]
pub fn test_modules(source: &str) -> Vec<String> {
    without_tests(tokens(source)).1
}

/// Every path in the tokens, imports spread out: line and segments.
fn paths(tokens: &[Token]) -> Vec<(usize, Vec<String>)> {
    let mut found = Vec::new();
    let mut k = 0;
    while k < tokens.len() {
        let in_use = tokens[k].text == "use";
        if in_use {
            k += 1;
        }
        // A leading :: says that a crate follows.
        if in_use && tokens.get(k).is_some_and(|token| token.text == "::") {
            k += 1;
        }
        if in_use || tokens.get(k).is_some_and(Token::is_name) {
            k = tree(tokens, k, &[], &mut found).max(k + 1);
        } else {
            k += 1;
        }
    }
    found
}

/// Reads one tree of paths from `k`; where it ends.
fn tree(tokens: &[Token], mut k: usize, stem: &[String], found: &mut Vec<(usize, Vec<String>)>) -> usize {
    let mut path = stem.to_vec();
    let line = tokens.get(k).map_or(0, |token| token.line);
    while let Some(token) = tokens.get(k) {
        if token.is_name() {
            path.push(token.text.clone());
            k += 1;
        } else if token.text == "{" && (path.len() > stem.len() || stem.is_empty()) {
            k += 1;
            while tokens.get(k).is_some_and(|token| token.text != "}") {
                k = tree(tokens, k, &path, found).max(k + 1);
                // `x as y`, and the comma.
                while tokens.get(k).is_some_and(|token| !matches!(token.text.as_str(), "," | "}")) {
                    k += 1;
                }
                if tokens.get(k).is_some_and(|token| token.text == ",") {
                    k += 1;
                }
            }
            return k + 1;
        } else {
            break;
        }
        if tokens.get(k).is_none_or(|token| token.text != "::") {
            break;
        }
        k += 1;
    }
    if path.len() > stem.len() {
        found.push((line, path));
    }
    k
}

/// The module path of a file, such as `[host, modboat, tail]`; nothing outside a `src`.
fn module_of(file: &str) -> Option<Vec<String>> {
    let (package, rest) = file.strip_suffix(".rs")?.split_once("/src/")?;
    let mut path: Vec<String> = std::iter::once(package).chain(rest.split('/')).map(str::to_owned).collect();
    if path.last().is_some_and(|last| matches!(last.as_str(), "mod" | "lib" | "main")) {
        path.pop();
    }
    Some(path)
}

/// The area a path belongs to, if it is one of ours.
fn area(path: &[String]) -> Option<String> {
    match path.first()?.as_str() {
        "host" => Some(path.get(1).map_or_else(|| "host".to_owned(), |second| format!("host::{second}"))),
        package @ ("protocol" | "firmware") => Some(package.to_owned()),
        _ => None,
    }
}

/// A path as seen from `module`, from its package on.
fn resolved(module: &[String], path: &[String]) -> Vec<String> {
    let mut base = match path.first().map(String::as_str) {
        Some("crate") => module[..1].to_vec(),
        Some("self" | "super") => module.to_vec(),
        _ => return path.to_vec(),
    };
    for segment in path {
        match segment.as_str() {
            "crate" | "self" => {}
            "super" => drop(base.pop()),
            name => base.push(name.to_owned()),
        }
    }
    base
}

/// The rules that `source`, the text of `file`, breaks.
#[must_use]
pub fn breaches(file: &str, source: &str) -> Vec<Breach> {
    let Some(module) = module_of(file) else { return Vec::new() };
    let Some(home) = area(&module) else { return Vec::new() };
    let (tokens, _) = without_tests(tokens(source));
    let mut found = Vec::new();
    let mut breach = |line, what| found.push(Breach { file: file.to_owned(), line, what });
    let (bare, planner) =
        (matches!(home.as_str(), "protocol" | "firmware"), PLANNERS.contains(&home.as_str()));
    let lenient = |name: &str| file == TABLE && TABLE_MAY.contains(&name);
    for (line, path) in paths(&tokens) {
        let full = resolved(&module, &path);
        let shown = path.join("::");
        if let Some(target) = area(&full).filter(|_| full.len() > 1)
            && target != home
            && !may_import(&home).contains(&target.as_str())
        {
            breach(line, format!("{home} must not import {target} ({shown})"));
        }
        let of_planner = full.len() > 1 && full[1] == "rov" && home == JUDGE;
        if of_planner && !full.get(2).is_some_and(|module| JUDGE_MAY.contains(&module.as_str())) {
            breach(line, format!("{home} takes only data from host::rov, not {shown}"));
        }
        let first = full.first().map_or("", String::as_str);
        if bare && full.len() > 1 && matches!(first, "std" | "alloc") {
            breach(line, format!("{home} must not use {first} ({shown})"));
        }
        if planner {
            let second = full.get(1).map_or("", String::as_str);
            let standard = first == "std" && IMPURE_MODULES.contains(&second) && !lenient(second);
            let name = full.iter().find(|s| IMPURE_NAMES.contains(&s.as_str()) && !lenient(s));
            if standard || name.is_some() {
                breach(line, format!("a planner must not use {shown}"));
            }
        }
    }
    if planner {
        for pair in tokens.windows(2) {
            if pair[1].text == "!" && PRINTS.contains(&pair[0].text.as_str()) {
                breach(pair[0].line, format!("a planner must not print ({}!)", pair[0].text));
            }
        }
    }
    found
}

#[cfg(test)]
mod tests;
