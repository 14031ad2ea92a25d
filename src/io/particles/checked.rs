//! What particles may be; whatever file they come from.

use std::path::Path;

use crate::flame::settings::HOTTEST;
use crate::io::ReadError;
use crate::view::FARTHEST;

pub(super) fn positions(path: &Path, positions: &[[f32; 3]]) -> Result<(), ReadError> {
    vectors(path, "position", positions, "three finite numbers, none beyond 1e12 m")
}

pub(super) fn velocities(path: &Path, velocities: &[[f32; 3]]) -> Result<(), ReadError> {
    vectors(path, "velocity", velocities, "three finite numbers, none beyond 1e12 m/s")
}

fn vectors(path: &Path, name: &str, vectors: &[[f32; 3]], expected: &str) -> Result<(), ReadError> {
    match vectors.iter().position(|v| !v.iter().all(|x| x.abs() <= FARTHEST)) {
        Some(row) => Err(row_error(path, name, row, format!("is {:?} as f32", vectors[row]), expected)),
        None => Ok(()),
    }
}

pub(super) fn temperatures(path: &Path, temperatures: &[f32]) -> Result<(), ReadError> {
    match temperatures.iter().position(|t| !(*t > 0.0 && *t <= HOTTEST)) {
        Some(row) => {
            let why = format!("is {} as f32", temperatures[row]);
            Err(row_error(path, "temperature", row, why, "kelvin, above 0 and finite, at most 1e6"))
        }
        None => Ok(()),
    }
}

/// Whole numbers as ids. Every integer up to 2^53 is exact as f64, and none above it becomes one that is allowed.
pub(super) fn ids(path: &Path, ids: impl IntoIterator<Item = f64>) -> Result<Vec<u32>, ReadError> {
    let id = |(row, id): (usize, f64)| match (0.0..=f64::from(u32::MAX)).contains(&id) && id.fract() == 0.0 {
        true => Ok(id as u32),
        false => Err(row_error(path, "id", row, format!("is {id}"), "a whole number, 0 to 4294967295")),
    };
    ids.into_iter().enumerate().map(id).collect()
}

pub(super) fn row_error(path: &Path, name: &str, row: usize, why: String, expected: &str) -> ReadError {
    ReadError::at(path, format!("`{name}`, row {row}"), why, expected)
}
