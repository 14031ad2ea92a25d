//! The header's text: a Python dictionary of three entries.

use super::{Element, Header};

/// The fault, and what was expected.
type Fault = (String, String);

fn malformed(what: &str) -> Fault {
    (format!("the header {what}"), "{'descr': '<f4', 'fortran_order': False, 'shape': (..), }".into())
}

/// Reads the text; keys in any order.
pub(super) fn parse(text: &[u8]) -> Result<Header, Fault> {
    let text = std::str::from_utf8(text).map_err(|_| malformed("is not text"))?;
    let (mut descr, mut order, mut shape) = (None, None, None);
    let mut rest = text.trim().strip_prefix('{').ok_or_else(|| malformed("is no dictionary"))?;
    loop {
        rest = rest.trim_start();
        if let Some(after) = rest.strip_prefix('}') {
            if !after.trim().is_empty() {
                return Err(malformed("goes on after the dictionary"));
            }
            break;
        }
        let (key, after) = string(rest).ok_or_else(|| malformed("has a key that is no string"))?;
        let value = after.trim_start().strip_prefix(':').ok_or_else(|| malformed("has a key without value"))?;
        let value = value.trim_start();
        rest = match key {
            "descr" => {
                let (found, after) = string(value).ok_or_else(|| not_a_number("of several fields"))?;
                descr = Some(found);
                after
            }
            "fortran_order" => {
                let found = value.strip_prefix("True").map(|r| (true, r));
                let found = found.or_else(|| value.strip_prefix("False").map(|r| (false, r)));
                let (found, after) = found.ok_or_else(|| malformed("has a fortran_order that is no bool"))?;
                order = Some(found);
                after
            }
            "shape" => {
                let (found, after) = tuple(value).ok_or_else(|| malformed("has a shape that is no tuple"))?;
                shape = Some(found);
                after
            }
            _ => return Err(malformed("has an unknown key")),
        };
        rest = rest.trim_start();
        rest = match rest.strip_prefix(',') {
            Some(after) => after,
            None if rest.starts_with('}') => rest,
            None => return Err(malformed("lacks a comma")),
        };
    }
    match (descr, order, shape) {
        (Some(descr), Some(fortran_order), Some(shape)) => {
            let (element, little_endian) = element(descr)?;
            Ok(Header { element, shape, little_endian, fortran_order })
        }
        _ => Err(malformed("lacks descr, fortran_order or shape")),
    }
}

fn not_a_number(kind: &str) -> Fault {
    (format!("elements {kind}"), "f16, f32 or f64".into())
}

fn element(descr: &str) -> Result<(Element, bool), Fault> {
    let unsupported = || not_a_number(&format!("of type `{descr}`"));
    let mut letters = descr.chars();
    let little = match letters.next() {
        Some('<' | '|') => true,
        Some('>') => false,
        Some('=') => cfg!(target_endian = "little"),
        _ => return Err(unsupported()),
    };
    let kind = letters.next().ok_or_else(unsupported)?;
    let bytes = match letters.as_str() {
        "1" => 1,
        "2" => 2,
        "4" => 4,
        "8" => 8,
        _ => return Err(unsupported()),
    };
    let element = match (kind, bytes) {
        ('f', 2) => Element::F16,
        ('f', 4) => Element::F32,
        ('f', 8) => Element::F64,
        ('i', _) => Element::Int(bytes),
        ('u', _) => Element::Uint(bytes),
        _ => return Err(unsupported()),
    };
    Ok((element, little))
}

/// A quoted string at the start of `text`, and what follows. NumPy escapes nothing in these.
fn string(text: &str) -> Option<(&str, &str)> {
    let quote = text.chars().next().filter(|c| matches!(c, '\'' | '"'))?;
    text[1..].split_once(quote)
}

/// A tuple of whole numbers (an `L` after them as in Python 2), and what follows.
fn tuple(text: &str) -> Option<(Vec<u64>, &str)> {
    let (inside, rest) = text.strip_prefix('(')?.split_once(')')?;
    let mut parts: Vec<&str> = inside.split(',').map(str::trim).collect();
    if parts.last() == Some(&"") {
        parts.pop();
    }
    let numbers = parts.iter().map(|p| p.strip_suffix('L').unwrap_or(p).parse().ok());
    Some((numbers.collect::<Option<Vec<u64>>>()?, rest))
}
