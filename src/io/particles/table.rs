//! Particles from files of named numbers, a row each: PLY and CSV.

use std::path::Path;

use super::{MAX_PARTICLES, checked};
use crate::data::Particles;
use crate::io::ReadError;

/// What of a table is read: columns of x, y and z, temperature, and, where there are some, id and velocity.
#[derive(Clone, Debug, PartialEq, Eq)]
struct Columns {
    position: [usize; 3],
    temperature: usize,
    id: Option<usize>,
    velocity: Option<[usize; 3]>,
}

/// Rows of the columns that are read.
#[derive(Debug)]
pub(super) struct Rows {
    /// Numbers of a row.
    pub(super) width: usize,
    /// Row by row.
    pub(super) values: Vec<f64>,
}

/// Names of positions and velocities before what says the axis, and what says it.
const POSITIONS: [&str; 5] = ["", "p", "pos", "position", "point"];
const VELOCITIES: [&str; 4] = ["v", "vel", "velocity", "motion"];
const TEMPERATURES: [&str; 3] = ["temperature", "temp", "t"];
const IDS: [&str; 3] = ["id", "pid", "particle_id"];

impl Columns {
    /// Those of these names, whatever their case. None: what is missing.
    fn of(names: &[String]) -> Result<Columns, &'static str> {
        let names: Vec<String> = names.iter().map(|name| name.trim().to_ascii_lowercase()).collect();
        let find = |wanted: &str| names.iter().position(|name| name == wanted);
        let one = |wanted: &[&str]| wanted.iter().find_map(|name| find(name));
        let three = |bases: &[&str]| {
            let named = |base: &str, axis: usize| {
                let (letter, number) = (["x", "y", "z"][axis], axis);
                let all = [
                    format!("{base}{letter}"),
                    format!("{base}_{letter}"),
                    format!("{base}.{letter}"),
                    format!("{base}[{letter}]"),
                    format!("{base}:{letter}"),
                    format!("{base}[{number}]"),
                    format!("{base}:{number}"),
                ];
                all.iter().find_map(|name| find(name))
            };
            bases.iter().find_map(|base| Some([named(base, 0)?, named(base, 1)?, named(base, 2)?]))
        };
        Ok(Columns {
            position: three(&POSITIONS).ok_or("x, y and z")?,
            temperature: one(&TEMPERATURES).ok_or("temperature")?,
            id: one(&IDS),
            velocity: three(&VELOCITIES),
        })
    }

    /// All of them, in the order in which [`Columns::particles`] takes them.
    fn all(&self) -> Vec<usize> {
        let Columns { position, temperature, id, velocity } = self;
        position.iter().chain([temperature]).chain(id).chain(velocity.iter().flatten()).copied().collect()
    }
}

/// Reads the particles of a table. `rows` reads the columns that it is given for the names that it has.
pub(super) fn read(
    path: &Path,
    what: &'static str,
    rows: impl FnOnce(&dyn Fn(&[String]) -> Result<Vec<usize>, ReadError>) -> Result<Rows, ReadError>,
) -> Result<Particles, ReadError> {
    let found = std::cell::OnceCell::new();
    let choose = |names: &[String]| {
        let columns = Columns::of(names).map_err(|missing| {
            let why = format!("has the {what} names {names:?}, and no {missing}");
            ReadError::file(path, why, "x, y, z and temperature, and maybe id and vx, vy, vz")
        })?;
        Ok(found.get_or_init(|| columns).all())
    };
    let Rows { width, values } = rows(&choose)?;
    let Some(columns) = found.get() else { return Ok(Particles::default()) };
    let rows = values.chunks_exact(width);
    let three =
        |at: usize| rows.clone().map(move |row| [0, 1, 2].map(|axis| row[at + axis] as f32)).collect::<Vec<_>>();
    let position = three(0);
    let temperature: Vec<f32> = rows.clone().map(|row| row[3] as f32).collect();
    checked::positions(path, &position)?;
    checked::temperatures(path, &temperature)?;
    let id = columns.id.map(|_| checked::ids(path, rows.clone().map(|row| row[4]))).transpose()?;
    let velocity = columns.velocity.map(|_| three(width - 3));
    velocity.iter().try_for_each(|values| checked::velocities(path, values))?;
    Ok(Particles { position, temperature, id, velocity })
}

/// An error if there are more particles than are read.
pub(super) fn check_count(path: &Path, count: u64) -> Result<(), ReadError> {
    match count > MAX_PARTICLES {
        true => Err(ReadError::file(path, format!("has {count} particles"), format!("{MAX_PARTICLES} at most"))),
        false => Ok(()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn columns_are_known_by_the_names_that_programs_give_them() {
        let of = |names: &str| Columns::of(&names.split(' ').map(str::to_owned).collect::<Vec<_>>());
        let columns = |position, temperature, id, velocity| Ok(Columns { position, temperature, id, velocity });
        assert_eq!(of("x y z temperature"), columns([0, 1, 2], 3, None, None));
        assert_eq!(of("ID Temp VX VY VZ X Y Z"), columns([5, 6, 7], 1, Some(0), Some([2, 3, 4])));
        assert_eq!(of("P[x] P[y] P[z] v[x] v[y] v[z] t"), columns([0, 1, 2], 6, None, Some([3, 4, 5])));
        assert_eq!(of("Position:0 Position:1 Position:2 Temperature"), columns([0, 1, 2], 3, None, None));
        // Two of three components are none.
        assert_eq!(of("x y z t vel_x vel_y"), columns([0, 1, 2], 3, None, None));
        assert_eq!(of("x y temperature"), Err("x, y and z"));
        assert_eq!(of("x y z heat"), Err("temperature"));
    }
}
