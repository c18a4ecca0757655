//! Flash and RAM of each image, as a table in a Markdown file that is checked in.
//!
//! One row an image, bytes; a section that is in flash and in RAM, as `.data` is, counts in both sums. A row agrees with another if each of
//! its numbers does: within 2 % or 512 bytes, whichever is more (*assumed*: compilers of one version but other origin were
//! seen to differ by less).

use std::fmt::{self, Write};

use crate::elf::{ElfError, Program};

/// Sections that have a column of their own.
const SECTIONS: [&str; 7] = [".vector_table", ".start_block", ".text", ".rodata", ".data", ".bss", ".uninit"];
/// Numbers in a row: the sections, all others, flash, RAM.
const COLUMNS: usize = SECTIONS.len() + 3;
/// Numbers that differ by no more agree, bytes.
const TOLERANCE: u64 = 512;
/// And by no more than one part in so many.
const TOLERANCE_PART: u64 = 50;

/// One image with its sizes.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Row {
    /// What it is called.
    pub name: String,
    numbers: [u64; COLUMNS],
}

impl Row {
    /// Measures the flash and RAM of an image.
    pub fn measure(name: &str, program: &Program<'_>) -> Result<Self, ElfError> {
        let mut numbers = [0; COLUMNS];
        let [sections @ .., others, flash, ram] = &mut numbers;
        for section in program.sections()? {
            let column = SECTIONS.iter().position(|name| *name == section.name);
            let column = column.and_then(|column| sections.get_mut(column)).unwrap_or(&mut *others);
            *column += section.bytes;
            *flash += u64::from(section.in_flash) * section.bytes;
            *ram += u64::from(section.in_ram) * section.bytes;
        }
        Ok(Self { name: name.to_owned(), numbers })
    }

    /// Flash that the image takes, bytes.
    #[must_use]
    pub const fn flash(&self) -> u64 {
        self.numbers[COLUMNS - 2]
    }

    /// RAM that it takes before the stack, bytes.
    #[must_use]
    pub const fn ram(&self) -> u64 {
        self.numbers[COLUMNS - 1]
    }

    /// Reads a row; nothing for a line that is none.
    fn parse(line: &str) -> Option<Self> {
        let mut cells = line.trim().strip_prefix('|')?.strip_suffix('|')?.split('|').map(str::trim);
        let name = cells.next()?.trim_matches('`').to_owned();
        let numbers: Vec<u64> =
            cells.map(|cell| cell.replace(' ', "").parse().ok()).collect::<Option<_>>()?;
        Some(Self { name, numbers: numbers.try_into().ok()? })
    }

    /// What is too different in `now`.
    fn difference(&self, now: &Self) -> Option<String> {
        let pairs = self.numbers.iter().zip(&now.numbers);
        headings().skip(1).zip(pairs).find_map(|(heading, (&was, &is))| {
            let far = was.abs_diff(is) > TOLERANCE.max(was / TOLERANCE_PART);
            far.then(|| format!("{}: {heading} is {is} bytes, the table says {was}", self.name))
        })
    }
}

impl fmt::Display for Row {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "| `{}` |", self.name)?;
        self.numbers.iter().try_for_each(|number| write!(f, " {number} |"))
    }
}

/// What stands above the columns.
fn headings() -> impl Iterator<Item = &'static str> {
    ["image"].into_iter().chain(SECTIONS).chain(["others", "flash", "RAM"])
}

/// The first line of a table.
fn head() -> String {
    headings().fold("|".to_owned(), |line, heading| line + " " + heading + " |")
}

/// The table of these images as Markdown.
#[must_use]
pub fn rendered(rows: &[Row]) -> String {
    let mut table = head() + "\n|---|";
    table.push_str(&"---:|".repeat(COLUMNS));
    table.push('\n');
    for row in rows {
        // Writing to a String cannot fail.
        let _ = writeln!(table, "{row}");
    }
    table
}

/// `text` with the table in it replaced by that of `rows`, or put at its end.
#[must_use]
pub fn replaced(text: &str, rows: &[Row]) -> String {
    let (before, after) = match text.split_once(&head()) {
        Some((before, rest)) => {
            let lines = rest.split_inclusive('\n').skip(1);
            (before, lines.skip_while(|line| line.starts_with('|')).collect())
        }
        None => (text, String::new()),
    };
    let gap = if before.is_empty() || before.ends_with("\n\n") || !after.is_empty() { "" } else { "\n" };
    format!("{before}{gap}{}{after}", rendered(rows))
}

/// What in `text`, or in the images, does not agree with the other; nothing if all does.
#[must_use]
pub fn disagreements(text: &str, rows: &[Row]) -> Vec<String> {
    let Some((_, table)) = text.split_once(&head()) else { return vec!["has no such table".to_owned()] };
    let lines = table.lines().skip(1).take_while(|line| line.starts_with('|'));
    let former: Vec<Row> = lines.filter_map(Row::parse).collect();
    let of = |rows: &[Row], name: &str| rows.iter().find(|row| row.name == name).cloned();
    let changed = rows.iter().filter_map(|now| match of(&former, &now.name) {
        Some(was) => was.difference(now),
        None => Some(format!("{}: is not in the table", now.name)),
    });
    let gone = former.iter().filter(|was| of(rows, &was.name).is_none());
    changed.chain(gone.map(|was| format!("{}: is in the table and was not given", was.name))).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn row(name: &str, text: u64) -> Row {
        let mut numbers = [0; COLUMNS];
        (numbers[2], numbers[COLUMNS - 2]) = (text, text);
        Row { name: name.to_owned(), numbers }
    }

    #[test]
    fn a_table_is_read_as_it_was_written_and_replaced_where_it_stands() {
        let rows = [row("pico2w", 40_000), row("qemu", 900)];
        let alone = replaced("", &rows);
        assert_eq!(alone, rendered(&rows));
        assert_eq!(disagreements(&alone, &rows), [""; 0]);
        let text = replaced("# Sizes\n", &rows);
        assert_eq!(text, format!("# Sizes\n\n{alone}"));
        let text = text + "\nMore.\n";
        let again = replaced(&text, &[row("pico2w", 50_000)]);
        assert_eq!(again, format!("# Sizes\n\n{}\nMore.\n", rendered(&[row("pico2w", 50_000)])));
    }

    #[test]
    fn small_differences_are_none() {
        let table = rendered(&[row("large", 100_000), row("small", 1_000)]);
        let with = |large, small| disagreements(&table, &[row("large", large), row("small", small)]);
        assert!(with(102_000, 1_512).is_empty() && with(98_000, 488).is_empty());
        let far = with(102_001, 487);
        assert_eq!(
            far,
            [
                "large: .text is 102001 bytes, the table says 100000",
                "small: .text is 487 bytes, the table says 1000"
            ]
        );
        assert_eq!(disagreements("# None\n", &[row("a", 1)]), ["has no such table"]);
        let other = disagreements(&table, &[row("large", 100_000), row("new", 1)]);
        assert_eq!(other, ["new: is not in the table", "small: is in the table and was not given"]);
    }
}
