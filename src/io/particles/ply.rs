//! PLY: the element `vertex` of files in text and in bytes of either order; properties in any order.

use std::path::Path;

use super::table::{self, Rows, check_count};
use crate::data::Particles;
use crate::io::{ReadError, file};

/// The element whose rows are particles.
const VERTEX: &str = "vertex";
/// Bytes that a header has room in.
const MOST_HEADER: usize = 1 << 16;

#[derive(Clone, Copy, Debug, PartialEq)]
enum Format {
    Text,
    Bytes { is_big: bool },
}

/// Kinds of numbers.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Kind {
    I8,
    U8,
    I16,
    U16,
    I32,
    U32,
    F32,
    F64,
}

#[derive(Clone, Copy, Debug)]
enum Property {
    One(Kind),
    /// The kind of its length, and that of its numbers.
    List(Kind, Kind),
}

#[derive(Debug)]
struct Element {
    name: String,
    count: u64,
    properties: Vec<(String, Property)>,
}

#[derive(Debug)]
struct Header {
    format: Format,
    elements: Vec<Element>,
    /// Bytes, and lines, of it.
    size: usize,
    lines: usize,
}

pub(super) fn read(path: &Path) -> Result<Particles, ReadError> {
    let bytes = file::read(path, u64::MAX).map_err(|error| ReadError::file(path, error, "a file that can be read"))?;
    parse(path, &bytes)
}

/// [`read`] with the file in memory.
pub(super) fn parse(path: &Path, bytes: &[u8]) -> Result<Particles, ReadError> {
    let header = header(path, bytes)?;
    let Some(place) = header.elements.iter().position(|element| element.name == VERTEX) else {
        let names: Vec<&str> = header.elements.iter().map(|element| &element.name[..]).collect();
        return Err(ReadError::file(path, format!("has the elements {names:?}"), "an element `vertex`"));
    };
    let (before, vertex) = (&header.elements[..place], &header.elements[place]);
    check_count(path, vertex.count)?;
    table::read(path, "property", |choose| {
        let names: Vec<String> = vertex.properties.iter().map(|(name, _)| name.clone()).collect();
        let wanted = choose(&names)?;
        let mut slots = vec![None; names.len()];
        for (slot, column) in wanted.iter().enumerate() {
            if let (name, Property::List(..)) = &vertex.properties[*column] {
                return Err(ReadError::file(path, format!("property `{name}` is a list"), "a number"));
            }
            slots[*column] = Some(slot);
        }
        let body = &bytes[header.size..];
        match header.format {
            Format::Text => text_rows(path, body, header.lines, before, vertex, &slots, wanted.len()),
            Format::Bytes { is_big } => {
                let mut body = Body { path, bytes, at: header.size, is_big };
                for element in before {
                    (0..element.count).try_for_each(|_| body.row(element, |_, _| ()))?;
                }
                let least: usize = vertex.properties.iter().map(|(_, property)| property.least_bytes()).sum();
                body.check_room(least as u64 * vertex.count)?;
                let mut values = vec![0.0; vertex.count as usize * wanted.len()];
                for row in values.chunks_exact_mut(wanted.len()) {
                    body.row(vertex, |column, value| slots[column].into_iter().for_each(|slot| row[slot] = value))?;
                }
                Ok(Rows { width: wanted.len(), values })
            }
        }
    })
}

impl Kind {
    fn named(name: &str) -> Option<Kind> {
        Some(match name {
            "char" | "int8" => Kind::I8,
            "uchar" | "uint8" => Kind::U8,
            "short" | "int16" => Kind::I16,
            "ushort" | "uint16" => Kind::U16,
            "int" | "int32" => Kind::I32,
            "uint" | "uint32" => Kind::U32,
            "float" | "float32" => Kind::F32,
            "double" | "float64" => Kind::F64,
            _ => return None,
        })
    }

    fn bytes(self) -> usize {
        match self {
            Kind::I8 | Kind::U8 => 1,
            Kind::I16 | Kind::U16 => 2,
            Kind::I32 | Kind::U32 | Kind::F32 => 4,
            Kind::F64 => 8,
        }
    }
}

impl Property {
    /// Bytes that it has at least.
    fn least_bytes(self) -> usize {
        match self {
            Property::One(kind) | Property::List(kind, _) => kind.bytes(),
        }
    }
}

fn header(path: &Path, bytes: &[u8]) -> Result<Header, ReadError> {
    let (mut format, mut elements, mut size) = (None, Vec::<Element>::new(), 0);
    for (number, line) in bytes[..bytes.len().min(MOST_HEADER)].split_inclusive(|byte| *byte == b'\n').enumerate() {
        size += line.len();
        let line = String::from_utf8_lossy(line);
        let words: Vec<&str> = line.split_whitespace().collect();
        let fault = |expected: &str| {
            ReadError::at(path, format!("line {}", number + 1), format!("is `{}`", line.trim()), expected)
        };
        match (number, &words[..]) {
            (0, ["ply"]) | (_, ["comment" | "obj_info", ..] | []) => {}
            (0, _) => return Err(ReadError::file(path, "is no PLY file", "a file whose first line is `ply`")),
            (_, ["format", name, _]) => {
                format = Some(match *name {
                    "ascii" => Format::Text,
                    "binary_little_endian" => Format::Bytes { is_big: false },
                    "binary_big_endian" => Format::Bytes { is_big: true },
                    _ => return Err(fault("ascii, binary_little_endian or binary_big_endian")),
                });
            }
            (_, ["element", name, count]) => {
                let count = count.parse().map_err(|_| fault("`element NAME COUNT`"))?;
                elements.push(Element { name: (*name).to_owned(), count, properties: Vec::new() });
            }
            (_, ["property", rest @ ..]) => {
                let kind = |name: &str| Kind::named(name).ok_or_else(|| fault("char to double, int8 to float64"));
                let (name, property) = match rest {
                    ["list", count, of, name] => (name, Property::List(kind(count)?, kind(of)?)),
                    [of, name] => (name, Property::One(kind(of)?)),
                    _ => return Err(fault("`property TYPE NAME`")),
                };
                let element = elements.last_mut().ok_or_else(|| fault("an element before it"))?;
                element.properties.push(((*name).to_owned(), property));
            }
            (_, ["end_header"]) => {
                let format = format.ok_or_else(|| fault("a line `format` before it"))?;
                return Ok(Header { format, elements, size, lines: number + 1 });
            }
            _ => return Err(fault("format, element, property, comment or end_header")),
        }
    }
    Err(ReadError::file(
        path,
        "ends within its header, or has none",
        format!("`end_header` within {MOST_HEADER} bytes"),
    ))
}

/// What follows the header, in bytes.
struct Body<'f> {
    path: &'f Path,
    bytes: &'f [u8],
    at: usize,
    is_big: bool,
}

impl Body<'_> {
    fn check_room(&self, count: u64) -> Result<(), ReadError> {
        match count > (self.bytes.len() - self.at) as u64 {
            true => {
                let why = format!("ends after {} of {count} bytes", self.bytes.len() - self.at);
                Err(ReadError::at(
                    self.path,
                    format!("byte {}", self.at),
                    why,
                    "all of them: it is cut off, or damaged",
                ))
            }
            false => Ok(()),
        }
    }

    fn number(&mut self, kind: Kind) -> Result<f64, ReadError> {
        fn number<const N: usize>(bytes: &[u8], is_big: bool) -> [u8; N] {
            let mut own: [u8; N] = bytes.try_into().unwrap_or([0; N]);
            if is_big {
                own.reverse();
            }
            own
        }
        self.check_room(kind.bytes() as u64)?;
        let bytes = &self.bytes[self.at..self.at + kind.bytes()];
        self.at += kind.bytes();
        Ok(match kind {
            Kind::I8 => f64::from(bytes[0].cast_signed()),
            Kind::U8 => f64::from(bytes[0]),
            Kind::I16 => f64::from(i16::from_le_bytes(number(bytes, self.is_big))),
            Kind::U16 => f64::from(u16::from_le_bytes(number(bytes, self.is_big))),
            Kind::I32 => f64::from(i32::from_le_bytes(number(bytes, self.is_big))),
            Kind::U32 => f64::from(u32::from_le_bytes(number(bytes, self.is_big))),
            Kind::F32 => f64::from(f32::from_le_bytes(number(bytes, self.is_big))),
            Kind::F64 => f64::from_le_bytes(number(bytes, self.is_big)),
        })
    }

    /// The numbers of a row that are no lists, each with its property.
    fn row(&mut self, element: &Element, mut with: impl FnMut(usize, f64)) -> Result<(), ReadError> {
        for (column, (_, property)) in element.properties.iter().enumerate() {
            match *property {
                Property::One(kind) => with(column, self.number(kind)?),
                Property::List(length, of) => {
                    let count = self.number(length)?.max(0.0) as u64 * of.bytes() as u64;
                    self.check_room(count)?;
                    self.at += count as usize;
                }
            }
        }
        Ok(())
    }
}

/// Rows of text, a line each; those of the elements before them are passed over.
fn text_rows(
    path: &Path,
    body: &[u8],
    lines: usize,
    before: &[Element],
    vertex: &Element,
    slots: &[Option<usize>],
    width: usize,
) -> Result<Rows, ReadError> {
    let text = String::from_utf8_lossy(body);
    let passed: u64 = before.iter().map(|element| element.count).sum();
    let all = text.lines().enumerate().filter(|(_, line)| !line.trim().is_empty());
    let mut all = all.skip(usize::try_from(passed).unwrap_or(usize::MAX));
    let mut values = Vec::new();
    for row in 0..vertex.count {
        let Some((number, line)) = all.next() else {
            return Err(ReadError::file(path, format!("ends after {row} of {} vertices", vertex.count), "all of them"));
        };
        let mut words = line.split_whitespace();
        let from = values.len();
        values.resize(from + width, 0.0);
        for ((name, property), slot) in vertex.properties.iter().zip(slots) {
            let fault = |word: Option<&str>| {
                let why = word.map_or("is missing".to_owned(), |word| format!("is `{word}`"));
                ReadError::at(path, format!("line {}, property `{name}`", lines + number + 1), why, "a number")
            };
            let mut next = || {
                let word = words.next();
                word.and_then(|word| word.parse::<f64>().ok()).ok_or_else(|| fault(word))
            };
            match property {
                Property::One(_) => {
                    let value = next()?;
                    slot.iter().for_each(|slot| values[from + slot] = value);
                }
                Property::List(..) => {
                    let count = next()?;
                    // No more than the line has.
                    (0..line.len()).take(count.max(0.0) as usize).try_for_each(|_| next().map(|_| ()))?;
                }
            }
        }
    }
    Ok(Rows { width, values })
}

#[cfg(test)]
mod tests;
