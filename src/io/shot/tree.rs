//! A shot's text as a tree of keys that remembers where each one stands.

use toml::Value;
use toml::de::{DeTable, DeValue};

use super::keys::{self, INSTEAD_OF_FILE, Keys};
use super::{ShotError, Table};
use crate::srgb::linear_from_srgb;

/// Where a key was given.
#[derive(Clone, Debug)]
pub(crate) enum Place {
    /// In this line of the shot's file, from 1.
    Line(usize),
    /// On the command line.
    Set,
}

/// A key's value and its place.
#[derive(Clone, Debug)]
pub(crate) struct Node {
    pub(super) place: Place,
    pub(super) kind: Kind,
}

/// The content of a key.
#[derive(Clone, Debug)]
pub(crate) enum Kind {
    Table(Vec<(String, Node)>),
    Leaf(Value),
}

/// A whole shot, not yet understood.
#[derive(Clone, Debug)]
pub(crate) struct Tree {
    /// The file's name for messages.
    pub(super) name: String,
    root: Node,
    tables: Vec<&'static Table>,
    pub(super) keys: Keys,
}

impl Tree {
    /// Parses `text`; `name` stands for it in messages.
    pub(super) fn parse(name: &str, text: &str, tables: &[&'static Table]) -> Result<Tree, ShotError> {
        let ends: Vec<usize> = text.bytes().enumerate().filter(|(_, b)| *b == b'\n').map(|(at, _)| at).collect();
        let line = |at: usize| ends.partition_point(|end| *end < at) + 1;
        let table = DeTable::parse(text).map_err(|e| {
            let line = line(e.span().map_or(0, |span| span.start));
            ShotError::Wrong { place: format!("{name}:{line}"), message: one_line(e.message()) }
        })?;
        let kind = convert_table(table.get_ref(), &|at| Place::Line(line(at)));
        let mut root = Node { place: Place::Line(1), kind };
        read_colours(&mut root.kind, "");
        Ok(Tree { name: name.to_owned(), root, tables: tables.to_vec(), keys: Keys::new(tables) })
    }

    /// Overrides one key as `KEY=VALUE` says. The value is TOML; one that is not, and does not look as if it
    /// should be, is taken as a string.
    pub(super) fn set(&mut self, argument: &str) -> Result<(), ShotError> {
        let wrong = |message: String| ShotError::Wrong { place: format!("--set {argument}"), message };
        let Some((key, value)) = argument.split_once('=') else {
            return Err(wrong("expected KEY=VALUE, for example smoke.sigma=4".to_owned()));
        };
        let (key, value) = (key.trim(), value.trim());
        if self.keys.allowed(key).is_none() {
            return Err(wrong(self.unknown(key)));
        }
        let mut kind = match DeValue::parse(value) {
            Ok(parsed) => convert(parsed.get_ref(), &|_| Place::Set),
            Err(e) if value.is_empty() || value.starts_with(['[', '{', '"', '\'']) => {
                return Err(wrong(one_line(e.message())));
            }
            Err(_) => Kind::Leaf(Value::String(value.to_owned())),
        };
        read_colours(&mut kind, key);
        // Of what excludes each other, naming one on the command line takes the place of the file's.
        match key {
            "light.direction" => self.remove("light.position"),
            "light.position" => self.remove("light.direction"),
            "light.second.direction" => self.remove("light.second.position"),
            "light.second.position" => self.remove("light.second.direction"),
            "camera.file" => INSTEAD_OF_FILE.into_iter().for_each(|key| self.remove(key)),
            _ if INSTEAD_OF_FILE.contains(&key) => self.remove("camera.file"),
            _ => {
                let pairs = self.tables.iter().flat_map(|table| table.excluding);
                let others = pairs.filter(|pair| pair.contains(&key)).flatten().filter(|other| **other != key);
                let others: Vec<&str> = others.copied().collect();
                others.into_iter().for_each(|other| self.remove(other));
            }
        }
        self.insert(key, Node { place: Place::Set, kind });
        Ok(())
    }

    /// The node of key `path`.
    pub(crate) fn get(&self, path: &str) -> Option<&Node> {
        path.split('.').try_fold(&self.root, |node, name| match &node.kind {
            Kind::Table(entries) => entries.iter().find(|(key, _)| key == name).map(|(_, child)| child),
            Kind::Leaf(_) => None,
        })
    }

    /// Refuses unknown keys, tables where values belong and values where tables belong.
    pub(super) fn check_keys(&self) -> Result<(), ShotError> {
        self.check_node("", &self.root)
    }

    fn check_node(&self, path: &str, node: &Node) -> Result<(), ShotError> {
        let Kind::Table(entries) = &node.kind else { return Ok(()) };
        for (key, child) in entries {
            let path = if path.is_empty() { key.clone() } else { format!("{path}.{key}") };
            let Some(allowed) = self.keys.allowed(&path) else {
                return Err(ShotError::Wrong {
                    place: self.place_of(&child.place, &path),
                    message: self.unknown(&path),
                });
            };
            if matches!(child.kind, Kind::Table(_)) != self.keys.is_table(&path) {
                return Err(self.wrong(&path, format!("{path} = {}: allowed: {allowed}", shown(child))));
            }
            self.check_node(&path, child)?;
        }
        Ok(())
    }

    /// An error at key `path`, or at the nearest table around it that the shot has.
    pub(crate) fn wrong(&self, path: &str, message: String) -> ShotError {
        let mut at = Some(path);
        while let Some(path) = at {
            if let Some(node) = self.get(path) {
                return ShotError::Wrong { place: self.place_of(&node.place, path), message };
            }
            at = keys::parent(path);
        }
        ShotError::Wrong { place: self.name.clone(), message }
    }

    /// The error of a value that key `path` does not take.
    pub(crate) fn not_allowed(&self, path: &str) -> ShotError {
        let value = self.get(path).map_or_else(String::new, |node| format!(" = {}", shown(node)));
        self.wrong(path, format!("{path}{value}: allowed: {}", self.keys.allowed(path).unwrap_or("")))
    }

    fn unknown(&self, path: &str) -> String {
        format!("{path}: unknown key; did you mean {}?", self.keys.nearest(path))
    }

    fn place_of(&self, place: &Place, path: &str) -> String {
        match place {
            Place::Line(line) => format!("{}:{line}", self.name),
            Place::Set => format!("--set {path}"),
        }
    }

    fn insert(&mut self, path: &str, node: Node) {
        let mut at = &mut self.root;
        for name in path.split('.') {
            if !matches!(at.kind, Kind::Table(_)) {
                at.kind = Kind::Table(Vec::new());
            }
            let Kind::Table(entries) = &mut at.kind else { return };
            let index = entries.iter().position(|(key, _)| key == name).unwrap_or_else(|| {
                let kind = Kind::Table(Vec::new());
                entries.push((name.to_owned(), Node { place: Place::Set, kind }));
                entries.len() - 1
            });
            at = &mut entries[index].1;
        }
        *at = node;
    }

    fn remove(&mut self, path: &str) {
        let (parent, name) = path.rsplit_once('.').unwrap_or(("", path));
        let mut at = &mut self.root;
        for part in parent.split('.').filter(|p| !p.is_empty()) {
            let Kind::Table(entries) = &mut at.kind else { return };
            let Some((_, child)) = entries.iter_mut().find(|(key, _)| key == part) else { return };
            at = child;
        }
        if let Kind::Table(entries) = &mut at.kind {
            entries.retain(|(key, _)| key != name);
        }
    }
}

/// A node as TOML on one line, cut where it is long.
pub(super) fn shown(node: &Node) -> String {
    let text = match &node.kind {
        Kind::Table(entries) if entries.is_empty() => "{}".to_owned(),
        Kind::Table(_) => "{ ... }".to_owned(),
        Kind::Leaf(value) => one_line(&value.to_string()),
    };
    match text.char_indices().nth(80) {
        Some((cut, _)) => format!("{}...", &text[..cut]),
        None => text,
    }
}

/// The value of a node, tables included, for serde.
pub(super) fn value(node: &Node) -> Value {
    match &node.kind {
        Kind::Leaf(value) => value.clone(),
        Kind::Table(entries) => Value::Table(entries.iter().map(|(key, child)| (key.clone(), value(child))).collect()),
    }
}

fn one_line(text: &str) -> String {
    text.split_whitespace().collect::<Vec<_>>().join(" ")
}

/// Last parts of the names of keys that take colours.
const COLOURS: [&str; 4] = ["background", "colour", "tones", "tones_above"];

/// Makes linear RGB of colours as people pick them, `"#E07A5F"`, in sRGB.
fn read_colours(kind: &mut Kind, path: &str) {
    match kind {
        Kind::Table(entries) => entries.iter_mut().for_each(|(key, node)| read_colours(&mut node.kind, key)),
        Kind::Leaf(value) if COLOURS.contains(&path.rsplit('.').next().unwrap_or(path)) => read_colour(value),
        Kind::Leaf(_) => {}
    }
}

fn read_colour(value: &mut Value) {
    match value {
        Value::Array(values) => values.iter_mut().for_each(read_colour),
        Value::String(text) => {
            if let Some(colour) = picked(text) {
                *value = Value::Array(colour.map(Value::Float).into());
            }
        }
        _ => {}
    }
}

/// Linear RGB of `#rrggbb`.
fn picked(text: &str) -> Option<[f64; 3]> {
    let digits = text.strip_prefix('#').filter(|digits| digits.len() == 6)?;
    let codes = u32::from_str_radix(digits, 16).ok().filter(|_| !digits.starts_with('+'))?;
    let [_, r, g, b] = codes.to_be_bytes();
    Some([r, g, b].map(|code| linear_from_srgb(f64::from(code) / 255.0)))
}

fn convert_table(table: &DeTable, place: &dyn Fn(usize) -> Place) -> Kind {
    let entry = |key: &str, at: usize, value: &DeValue| {
        (key.to_owned(), Node { place: place(at), kind: convert(value, place) })
    };
    Kind::Table(table.iter().map(|(k, v)| entry(k.get_ref(), k.span().start, v.get_ref())).collect())
}

fn convert(value: &DeValue, place: &dyn Fn(usize) -> Place) -> Kind {
    match value {
        DeValue::Table(table) => convert_table(table, place),
        leaf => Kind::Leaf(convert_leaf(leaf)),
    }
}

fn convert_leaf(value: &DeValue) -> Value {
    match value {
        DeValue::String(text) => Value::String(text.to_string()),
        // A number too large for its type becomes a float: no key takes it, and its own error says what it does take.
        DeValue::Integer(number) => match i64::from_str_radix(number.as_str(), number.radix()) {
            Ok(number) => Value::Integer(number),
            Err(_) => Value::Float(number.as_str().parse().unwrap_or(f64::NAN)),
        },
        DeValue::Float(number) => Value::Float(number.as_str().parse().unwrap_or(f64::NAN)),
        DeValue::Boolean(flag) => Value::Boolean(*flag),
        DeValue::Datetime(date) => Value::Datetime(*date),
        DeValue::Array(array) => Value::Array(array.iter().map(|v| convert_leaf(v.get_ref())).collect()),
        DeValue::Table(table) => {
            Value::Table(table.iter().map(|(k, v)| (k.get_ref().to_string(), convert_leaf(v.get_ref()))).collect())
        }
    }
}
