//! CSV: a line of names, and a line a particle; separated by commas, semicolons, tabs, bars or spaces.

use std::path::Path;

use ::csv::{ReaderBuilder, Trim};

use super::table::{self, Rows, check_count};
use crate::data::Particles;
use crate::io::{ReadError, file};

/// What separates, whichever the first line has most of.
const SEPARATORS: [u8; 4] = [b',', b';', b'\t', b'|'];

pub(super) fn read(path: &Path) -> Result<Particles, ReadError> {
    let bytes = file::read(path, u64::MAX).map_err(|error| ReadError::file(path, error, "a file that can be read"))?;
    parse(path, &bytes)
}

/// [`read`] with the file in memory.
pub(super) fn parse(path: &Path, bytes: &[u8]) -> Result<Particles, ReadError> {
    // A mark that some programs begin text with, and one that makes names a comment.
    let bytes = bytes.strip_prefix(b"\xEF\xBB\xBF").unwrap_or(bytes);
    let bytes = bytes.strip_prefix(b"#").unwrap_or(bytes);
    let first = bytes.split(|byte| *byte == b'\n').next().unwrap_or_default();
    let count = |separator: &u8| first.iter().filter(|byte| *byte == separator).count();
    let most = SEPARATORS.into_iter().rev().max_by_key(count).filter(|separator| count(separator) > 0);
    let single;
    let (separator, bytes) = match most {
        Some(separator) => (separator, bytes),
        None => {
            // However many spaces there are, they are one.
            single = spaced(bytes);
            (b' ', &single[..])
        }
    };
    let mut reader = ReaderBuilder::new().delimiter(separator).trim(Trim::All).flexible(true).from_reader(bytes);
    let fault = |error: ::csv::Error| ReadError::file(path, error, "text of names and numbers");
    let names: Vec<String> = reader.headers().map_err(fault)?.iter().map(str::to_owned).collect();
    table::read(path, "column", |choose| {
        let wanted = choose(&names)?;
        let mut values = Vec::new();
        for (row, record) in reader.records().enumerate() {
            check_count(path, row as u64 + 1)?;
            let record = record.map_err(fault)?;
            for column in &wanted {
                let text = record.get(*column);
                let Some(value) = text.and_then(|text| text.parse::<f64>().ok()) else {
                    let line = record.position().map_or(0, ::csv::Position::line);
                    let why = text.map_or("is missing".to_owned(), |text| format!("is `{text}`"));
                    return Err(ReadError::at(
                        path,
                        format!("line {line}, column `{}`", names[*column]),
                        why,
                        "a number",
                    ));
                };
                values.push(value);
            }
        }
        Ok(Rows { width: wanted.len(), values })
    })
}

/// Text with one space for each run of them, and none where lines begin and end.
fn spaced(bytes: &[u8]) -> Vec<u8> {
    let lines = bytes.split(|byte| *byte == b'\n');
    let lines = lines.map(|line| {
        let words = line.split(u8::is_ascii_whitespace).filter(|word| !word.is_empty());
        words.collect::<Vec<_>>().join(&b' ')
    });
    lines.collect::<Vec<_>>().join(&b'\n')
}

#[cfg(test)]
mod tests {
    use super::*;

    fn parsed(text: &str) -> Result<Particles, String> {
        parse(Path::new("p.csv"), text.as_bytes()).map_err(|error| error.to_string())
    }

    #[test]
    fn tables_of_all_separators_are_read() {
        let expected = Particles {
            position: vec![[0.0, 1.5, -2.0], [1e-3, 4.0, 5.0]],
            temperature: vec![900.0, 3000.0],
            id: Some(vec![7, 4_294_967_295]),
            velocity: None,
        };
        let comma = "x,y,z,temperature,id\n0,1.5,-2,900,7\n1e-3,4,5,3000,4294967295\n";
        assert_eq!(parsed(comma), Ok(expected.clone()));
        for separator in [";", "\t", "|", " ", "   "] {
            assert_eq!(parsed(&comma.replace(',', separator)), Ok(expected.clone()), "{separator:?}");
        }
        // Other columns, in any order, with spaces, quotes, marks, and lines of another system.
        let other = "\u{FEFF}# \"id\" , Cd, temp ,P[x],\"P[y]\",P[z]\r\n7,\"red, dark\", 900 ,0,1.5,-2\r\n\r\n4294967295,,3000,1e-3,4,5\r\n";
        assert_eq!(parsed(&other.replace("# ", "")), Ok(expected.clone()));
        assert_eq!(parsed(&comma.replacen('x', "#x", 1)), Ok(expected));
        let moving = parsed("x y z t vx vy vz\n1 2 3 400 -1 0 .5\n").unwrap();
        assert_eq!((moving.velocity, moving.id), (Some(vec![[-1.0, 0.0, 0.5]]), None));
        assert_eq!(parsed("x,y,z,t\n").unwrap(), Particles { velocity: None, ..Particles::default() });
    }

    #[test]
    fn faults_name_line_and_column() {
        let says = |text: &str, words: &[&str]| {
            let error = parsed(text).unwrap_err();
            assert!(error.starts_with("p.csv: ") && words.iter().all(|word| error.contains(word)), "{error}");
        };
        says("x,y,z\n1,2,3\n", &["[\"x\", \"y\", \"z\"]", "no temperature", "expected x, y, z and temperature"]);
        says("", &["no x, y and z"]);
        says("x,y,z,t\n1,2,3,4\n1,oops,3,4\n", &["line 3, column `y`: is `oops`; expected a number"]);
        says("x,y,z,t\n1,2,3\n", &["line 2, column `t`: is missing"]);
        says("x,y,z,t\n1,2,3,4\n1,2,3,-4\n", &["`temperature`, row 1", "is -4 as f32", "kelvin, above 0"]);
        says("x,y,z,t\n1,2,inf,4\n", &["`position`, row 0", "none beyond 1e12 m"]);
        says("x,y,z,t,id\n1,2,3,4,1.5\n", &["`id`, row 0", "is 1.5", "0 to 4294967295"]);
    }
}
