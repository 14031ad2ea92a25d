//! Run time against error: what `celfx bench` measures, and the files that it writes.
//!
//! Variants of one pass at one workload take turns in one run, with a full barrier around each step, after a warm-up:
//! drivers may compile a kernel at its first dispatch.

pub(crate) mod blur;
pub mod calibrate;
mod count;
pub(crate) mod flame;
mod limits;
pub mod look;
pub(crate) mod measure;
mod plot;
pub(crate) mod report;
pub(crate) mod rig;
pub(crate) mod smoke;

use std::io::Write;
use std::path::{Path, PathBuf};

use crate::error::Error;
use crate::gpu::headless::{Headless, Messages, NoDevice, Options};
use crate::io::{ReadError, WriteError, write_atomic};
use crate::program::InputError;
use report::{Limits, Report, Row};
use rig::Rig;

/// Measures an effect: adds rows to the session.
#[derive(Clone, Copy, Debug)]
pub struct Benchmark(pub(crate) fn(&mut Session) -> Outcome);

/// One run of the benchmark.
#[derive(Clone, Debug)]
pub struct Request {
    /// The benchmarks to run, besides what the device can do: copy and arithmetic.
    pub what: Vec<Benchmark>,
    /// Scenes whose look is measured: shares of pixels, not times.
    pub look: Vec<look::Scene>,
    /// One run each, and workloads and variants that take long are cut.
    pub quick: bool,
    /// Only rows whose `pass/variant/workload`, or scene, contains one of these; all of them if there is none.
    pub only: Vec<String>,
    /// Folder for a page of Markdown with the table, `performance-DEVICE.md`.
    pub page: Option<PathBuf>,
    /// The device.
    pub device: Options,
}

/// Why a benchmark ended early.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum BenchError {
    /// There is no device to measure.
    #[error(transparent)]
    NoDevice(#[from] NoDevice),
    /// The device failed.
    #[error(transparent)]
    Device(Error),
    /// Validation has said something.
    #[error("validation: {0}")]
    Validation(String),
    /// The input of a scene cannot be had.
    #[error(transparent)]
    Input(#[from] InputError),
    /// A file could not be written.
    #[error(transparent)]
    Write(#[from] WriteError),
    /// The caller asked to stop.
    #[error("interrupted")]
    Interrupted,
}

impl From<Error> for BenchError {
    fn from(error: Error) -> BenchError {
        match error {
            Error::Interrupted { .. } => BenchError::Interrupted,
            error => BenchError::Device(error),
        }
    }
}

impl From<ReadError> for BenchError {
    fn from(error: ReadError) -> BenchError {
        BenchError::Input(error.into())
    }
}

/// The caller's part while it runs: it is told of progress, and asked whether to go on.
pub trait Watch {
    /// Tells what is being measured now.
    fn progress(&self, text: &str);
    /// Whether to stop.
    fn is_interrupted(&self) -> bool;
}

/// Of a measurement, which adds rows to the session.
pub(crate) type Outcome = Result<(), BenchError>;

/// The common state of measurements.
pub(crate) struct Session<'a> {
    pub(crate) rig: Rig,
    pub(crate) quick: bool,
    pub(crate) only: &'a [String],
    pub(crate) limits: Limits,
    pub(crate) rows: Vec<Row>,
    /// Notes below the table's rows.
    pub(crate) notes: Vec<String>,
    watch: &'a dyn Watch,
}

impl Session<'_> {
    /// Says what is measured next; an error if the caller wants to stop.
    pub(crate) fn next(&self, text: &str) -> Outcome {
        if self.watch.is_interrupted() {
            return Err(BenchError::Interrupted);
        }
        self.watch.progress(text);
        Ok(())
    }

    /// A workload's name and size in pixels: with `--quick`, the sides are divided by `cut`, which the name says.
    pub(crate) fn picture(&self, name: &str, size: [u32; 2], cut: u32) -> (String, [u32; 2]) {
        match (self.quick, size.map(|side| side / cut)) {
            (true, size @ [width, height]) if cut > 1 => (format!("{name} (cut to {width}x{height})"), size),
            _ => (name.to_owned(), size),
        }
    }

    /// Those variants of a pass at a workload that were asked for.
    pub(crate) fn wanted<'v, T>(
        &self,
        pass: &str,
        workload: &str,
        variants: &'v [(&'v str, T)],
    ) -> Vec<&'v (&'v str, T)> {
        let chosen = |name: &str| {
            let row = format!("{pass}/{name}/{workload}");
            self.only.is_empty() || self.only.iter().any(|only| row.contains(only))
        };
        variants.iter().filter(|(name, _)| chosen(name)).collect()
    }
}

/// Measures, and writes `bench.json` and one plot an effect (`.svg` and `.png`) into `folder`, and pictures of scenes whose
/// look is measured into `folder/look`. The result is a table for people.
///
/// # Errors
/// No device, a failure of the device, a message of validation, a scene whose input cannot be had, a file that cannot be
/// written, an interruption.
pub fn run(request: &Request, folder: &Path, watch: &dyn Watch) -> Result<String, BenchError> {
    std::fs::create_dir_all(folder).map_err(|source| WriteError { path: folder.into(), source })?;
    let rig = Rig::new(Headless::new(&Options { stores: true, ..request.device.clone() })?)?;
    let messages = rig.messages();
    let (device, driver) = rig.device();
    let (quick, only) = (request.quick, &request.only[..]);
    let (rows, notes) = (Vec::new(), Vec::new());
    let mut session = Session { rig, quick, only, limits: Limits::default(), rows, notes, watch };
    session.limits = limits::measure(&mut session)?;
    for Benchmark(measure) in &request.what {
        measure(&mut session)?;
    }
    let Session { rig, limits, rows, notes, .. } = session;
    drop(rig);
    check(&messages)?;
    let look = match &request.look[..] {
        [] => None,
        scenes => Some(measure_look(request, scenes, watch)?),
    };
    let shown = look.as_ref().map(|look| look.write(folder)).transpose()?.unwrap_or_default();
    let report = Report { device, driver, limits, rows, look: look.map(|look| look.rows).unwrap_or_default() };
    write(&report, folder)?;
    let notes: String = notes.iter().map(|note| format!("\n{note}")).collect();
    let table = report.table() + &notes + &shown;
    if let Some(folder) = &request.page {
        let (name, text) = report.page(&table);
        write_atomic(&folder.join(name), |file| file.write_all(text.as_bytes()))?;
    }
    Ok(table)
}

fn measure_look(request: &Request, scenes: &[look::Scene], watch: &dyn Watch) -> Result<look::Look, BenchError> {
    let device = Headless::new(&request.device)?;
    let messages = device.messages();
    let found = look::measure(device, scenes, request.quick, &request.only, watch);
    check(&messages)?;
    found
}

/// A message of validation is an error.
fn check(messages: &Messages) -> Outcome {
    match messages.lock().unwrap_or_else(std::sync::PoisonError::into_inner).first() {
        Some(message) => Err(BenchError::Validation(message.clone())),
        None => Ok(()),
    }
}

fn write(report: &Report, folder: &Path) -> Outcome {
    let path = folder.join("bench.json");
    let json = report.json().map_err(|e| WriteError { path: path.clone(), source: e.into() })?;
    write_atomic(&path, |file| writeln!(file, "{json}"))?;
    let mut effects: Vec<&str> = report.rows.iter().map(|row| row.effect).collect();
    effects.dedup();
    for effect in effects {
        let rows: Vec<&Row> = report.rows.iter().filter(|row| row.effect == effect).collect();
        plot::write(effect, &rows, folder)?;
    }
    Ok(())
}
