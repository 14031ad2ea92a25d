//! The text of built-in shots: their values and headings, and beside each setting what its table says of it.

use super::keys::Keys;
use crate::settings::{Dial, DialKind};

/// Where comments begin, and where lines end.
const COLUMN: usize = 32;
const WIDTH: usize = 120;

/// The text of a shot, with a comment at each key of an effect's settings.
pub(super) fn commented(text: &str, keys: &Keys) -> String {
    let mut table = "";
    let mut out = String::new();
    for line in text.lines() {
        if let Some(header) = line.strip_prefix('[').and_then(|line| line.strip_suffix(']')) {
            table = header;
        }
        let key = line.strip_prefix("# ").unwrap_or(line).split_once(" = ").map_or("", |(key, _)| key);
        match keys.find(&format!("{table}.{key}")).filter(|dial| !dial.about.is_empty() && dial.kind != DialKind::Table)
        {
            Some(dial) => beside(&mut out, line, &comment(dial)),
            None => out.push_str(line),
        }
        out.push('\n');
    }
    out
}

/// The allowed values of a dial, the default, and its description.
fn comment(dial: &Dial) -> String {
    let default = dial.default.as_ref().map_or("default: none".to_owned(), |default| format!("default {default}"));
    format!("{}; {default}. {}", dial.allowed, dial.about.replace('`', ""))
}

/// Adds a line and a comment beside it, on as many lines as that needs.
fn beside(out: &mut String, line: &str, comment: &str) {
    let mut row = format!("{line:<width$}#", width = COLUMN.max(line.len() + 1));
    for word in comment.split(' ') {
        if row.len() + 1 + word.len() > WIDTH {
            out.push_str(&row);
            out.push('\n');
            row = format!("{:COLUMN$}#", "");
        }
        row.push(' ');
        row.push_str(word);
    }
    out.push_str(&row);
}
