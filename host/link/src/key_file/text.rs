//! What stands in a key file. Every error is a line, from 1, and a message of fixed words and counts: a file that was
//! mistaken for a key file, or has its values in the wrong places, is not quoted.

use std::fmt::Write;

use protocol::{FleetId, FleetKey, ModuleId, ModuleKey};
use quantity::MODULE_IDS;
use reader::line_at;
use toml::Spanned;
use toml::de::{DeTable, DeValue};
use zeroize::Zeroizing;

use super::ModuleCredentials;

/// No key file is longer, bytes.
pub(super) const LENGTH_MAX: usize = 4096;
/// No key file that is written is longer, bytes: the text never moves in memory and leaves nothing behind.
const WRITTEN_MAX: usize = 512;

/// Whose key a file has.
#[derive(Debug)]
pub(super) enum Content {
    /// The fleet's.
    Fleet(FleetKey),
    /// One module's.
    Module(ModuleCredentials),
}

pub(super) fn of_fleet(key: &FleetKey) -> Zeroizing<String> {
    let head = "# Flotilla fleet key. Its holder commands the fleet; keep it to yourself.";
    written(head, key.fleet(), key.bytes())
}

pub(super) fn of_module(credentials: &ModuleCredentials) -> Zeroizing<String> {
    let ModuleCredentials { id, fleet, key } = credentials;
    let head = format!(
        "# Flotilla key of module {id}. Its holder can pass for this module; keep it to yourself.\nmodule = {id}"
    );
    written(&head, *fleet, key.bytes())
}

fn written(head: &str, fleet: FleetId, key: &[u8; 32]) -> Zeroizing<String> {
    let mut text = Zeroizing::new(String::with_capacity(WRITTEN_MAX));
    // Writing to a String cannot fail.
    let _ = write!(text, "{head}\nfleet = \"{fleet}\"\nkey = \"");
    for byte in key {
        let _ = write!(text, "{byte:02x}");
    }
    text.push_str("\"\n");
    debug_assert!(text.capacity() == WRITTEN_MAX, "{} bytes", text.len());
    text
}

/// Reads a key file.
pub(super) fn parse(bytes: &[u8]) -> Result<Content, (usize, String)> {
    if bytes.len() > LENGTH_MAX {
        return Err((1, format!("is longer than {LENGTH_MAX} bytes: not a key file")));
    }
    let text = std::str::from_utf8(bytes)
        .map_err(|error| (line_at(bytes, error.valid_up_to()), "is not a text in UTF-8".to_owned()))?;
    // The reader's own message, and its name for an unknown key, may quote what stands there.
    let document = DeTable::parse(text).map_err(|error| {
        let line = error.span().map_or(1, |span| line_at(bytes, span.start));
        (line, "is not TOML: a line is KEY = \"VALUE\"".to_owned())
    })?;
    let (mut module, mut fleet, mut key) = (None, None, None);
    for (name, value) in document.get_ref() {
        let line = line_at(bytes, name.span().start);
        let at = |message: String| (line, message);
        match name.get_ref().as_ref() {
            "module" => module = Some((line, number(value).map_err(at)?)),
            "fleet" => fleet = Some((line, digits::<4>("fleet", value).map_err(at)?)),
            "key" => key = Some(digits::<32>("key", value).map_err(at)?),
            _ => return Err((line, "unknown key: a key file has fleet, key and perhaps module".to_owned())),
        }
    }
    let Some((line, stated)) = fleet else { return Err((1, "has no fleet = \"8 digits\"".to_owned())) };
    let Some(key) = key else { return Err((1, "has no key = \"64 digits\"".to_owned())) };
    let fleet = FleetId(*stated);
    if let Some((line, id)) = module {
        if !MODULE_IDS.contains(&id) {
            let (first, last) = (MODULE_IDS.start(), MODULE_IDS.end());
            return Err((line, format!("module = {id}: must be from {first} to {last}")));
        }
        return Ok(Content::Module(ModuleCredentials { id: ModuleId(id), fleet, key: ModuleKey::new(*key) }));
    }
    let key = FleetKey::new(*key);
    if key.fleet() != fleet {
        let message =
            format!("fleet = \"{fleet}\", but the key is that of fleet {}: one is wrong", key.fleet());
        return Err((line, message));
    }
    Ok(Content::Fleet(key))
}

/// The value of `module`.
fn number(value: &Spanned<DeValue<'_>>) -> Result<u16, String> {
    let number = match value.get_ref() {
        DeValue::Integer(integer) => u16::from_str_radix(integer.as_str(), integer.radix()).ok(),
        _ => None,
    };
    let (first, last) = (MODULE_IDS.start(), MODULE_IDS.end());
    number.ok_or_else(|| format!("module: must be a whole number from {first} to {last}"))
}

/// The value of `name`: two hexadecimal digits for each byte.
fn digits<const N: usize>(name: &str, value: &Spanned<DeValue<'_>>) -> Result<Zeroizing<[u8; N]>, String> {
    let wanted = 2 * N;
    let DeValue::String(text) = value.get_ref() else {
        return Err(format!("{name}: must be {wanted} hexadecimal digits in quotes"));
    };
    let found = text.chars().count();
    if found != wanted {
        return Err(format!("{name}: {found} characters where {wanted} hexadecimal digits are asked for"));
    }
    let mut bytes = Zeroizing::new([0; N]);
    for (k, character) in text.chars().enumerate() {
        let digit = character.to_digit(16).and_then(|digit| u8::try_from(digit).ok());
        let digit = digit.ok_or_else(|| format!("{name}: character {} is no hexadecimal digit", k + 1))?;
        bytes[k / 2] = bytes[k / 2] << 4 | digit;
    }
    Ok(bytes)
}
