//! Results of a benchmark: `bench.json`, and a table for people.

use std::fmt::Write as _;

use serde::Serialize;

use super::look::rows::{self, LookRow};
use super::measure::{Deviation, Spread};

/// Everything that a run of the benchmark found.
#[derive(Clone, Debug, Serialize)]
pub(crate) struct Report {
    pub(crate) device: String,
    pub(crate) driver: String,
    pub(crate) limits: Limits,
    pub(crate) rows: Vec<Row>,
    /// Scenes whose look was measured.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub(crate) look: Vec<LookRow>,
}

/// Limits of the device, measured in the same run.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub(crate) struct Limits {
    /// 1e9 bytes a second read and written, together, by a kernel that copies.
    pub(crate) copy_gb_s: f64,
    /// 1e9 floating-point operations a second, two per multiply-add, by a kernel that computes in registers.
    pub(crate) fma_gflop_s: f64,
}

/// One variant of one pass at one workload.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub(crate) struct Row {
    pub(crate) effect: &'static str,
    pub(crate) pass: &'static str,
    pub(crate) variant: String,
    pub(crate) workload: String,
    /// Spheres; or sprites: render particles times repetitions; or vertices; or triangles.
    pub(crate) items: u64,
    /// Median.
    pub(crate) gpu_ms: f64,
    /// First quartile.
    pub(crate) gpu_ms_low: f64,
    /// Third quartile.
    pub(crate) gpu_ms_high: f64,
    /// Recording on the host, median.
    pub(crate) cpu_ms: f64,
    pub(crate) runs: u32,
    pub(crate) error_rms: Option<f64>,
    pub(crate) error_p99: Option<f64>,
    pub(crate) error_max: Option<f64>,
    /// The reference of the error, and its unit.
    pub(crate) error_of: Option<String>,
    /// Bytes that have to be moved: each sector of memory that is read, and each that is written, once.
    pub(crate) bytes: Option<u64>,
    /// Floating-point operations that shaders do, two per fused multiply-add.
    pub(crate) flops: Option<u64>,
    /// The larger share of the two limits that the run reached. Limits are those of memory, not of caches.
    pub(crate) of_limit: Option<f64>,
}

/// The subject of a row.
#[derive(Clone, Debug)]
pub(crate) struct Subject {
    pub(crate) pass: &'static str,
    pub(crate) variant: String,
    pub(crate) workload: String,
    pub(crate) items: u64,
}

/// An error and what it is measured against.
pub(crate) type Accuracy = Option<(Deviation, String)>;

/// Least work of a variant: bytes to move and operations to compute.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Work {
    pub(crate) bytes: Option<u64>,
    pub(crate) flops: Option<u64>,
}

impl Row {
    pub(crate) fn new(
        effect: &'static str,
        subject: Subject,
        times: &Spread,
        accuracy: &Accuracy,
        work: Work,
        limits: &Limits,
    ) -> Row {
        let Subject { pass, variant, workload, items } = subject;
        let share = |amount: Option<u64>, giga_a_second: f64| {
            let possible = giga_a_second * 1e6 * times.gpu_ms;
            amount.filter(|_| possible > 0.0).map(|amount| amount as f64 / possible)
        };
        let (moved, computed) = (share(work.bytes, limits.copy_gb_s), share(work.flops, limits.fma_gflop_s));
        let deviation = accuracy.as_ref().map(|(deviation, _)| deviation);
        Row {
            effect,
            pass,
            variant,
            workload,
            items,
            gpu_ms: times.gpu_ms,
            gpu_ms_low: times.low,
            gpu_ms_high: times.high,
            cpu_ms: times.cpu_ms,
            runs: times.runs,
            error_rms: deviation.map(|d| d.rms),
            error_p99: deviation.map(|d| d.p99),
            error_max: deviation.map(|d| d.max),
            error_of: accuracy.as_ref().map(|(_, of)| of.clone()),
            bytes: work.bytes,
            flops: work.flops,
            of_limit: moved.into_iter().chain(computed).reduce(f64::max),
        }
    }
}

impl Report {
    /// `bench.json`.
    pub(crate) fn json(&self) -> serde_json::Result<String> {
        serde_json::to_string_pretty(self)
    }

    /// A page of Markdown with the table, and the name of its file.
    pub(crate) fn page(&self, table: &str) -> (String, String) {
        let letter = |c: char| if c.is_ascii_alphanumeric() { c.to_ascii_lowercase() } else { ' ' };
        let words: String = self.device.chars().map(letter).collect();
        let name = words.split_whitespace().collect::<Vec<_>>().join("-");
        let text = format!(
            "# Performance on {}\n\n`celfx bench`, driver {}. Milliseconds are medians, with a full barrier around each step; \
             [performance.md](performance.md) says what is measured.\n\n```\n{}\n```\n",
            self.device,
            self.driver,
            table.trim_end()
        );
        (format!("performance-{name}.md"), text)
    }

    /// The table.
    pub(crate) fn table(&self) -> String {
        let Limits { copy_gb_s, fma_gflop_s } = self.limits;
        let mut text = format!("{}, {}\ncopy {copy_gb_s:.1} GB/s", self.device, self.driver);
        let _ = writeln!(text, ", multiply-add {fma_gflop_s:.1} Gflop/s");
        let mut group = None;
        let widest = |of: fn(&Row) -> &str| self.rows.iter().map(|row| of(row).len()).max().unwrap_or(0);
        let width = widest(|row| &row.variant).max("variant".len());
        for row in &self.rows {
            let next = (row.effect, row.pass, &row.workload);
            if group != Some(next) {
                group = Some(next);
                let of = row.error_of.as_deref().map_or(String::new(), |of| format!("; error: {of}"));
                let _ = writeln!(text, "\n{} {}: {}{of}", row.effect, row.pass, row.workload);
                let _ = writeln!(
                    text,
                    "{:width$} {:>10} {:>11} {:>23} {:>9} {:>5} {:>9} {:>9} {:>9} {:>8}",
                    "variant", "items", "median ms", "quartiles ms", "cpu ms", "runs", "rms", "p99", "max", "of limit"
                );
            }
            let quartiles = format!("{} - {}", number(row.gpu_ms_low), number(row.gpu_ms_high));
            let error = |value: Option<f64>| value.map_or("-".into(), |value| format!("{value:.2e}"));
            let _ = writeln!(
                text,
                "{:width$} {:>10} {:>11} {quartiles:>23} {:>9.3} {:>5} {:>9} {:>9} {:>9} {:>8}",
                row.variant,
                row.items,
                number(row.gpu_ms),
                row.cpu_ms,
                row.runs,
                error(row.error_rms),
                error(row.error_p99),
                error(row.error_max),
                row.of_limit.map_or("-".into(), |share| format!("{:.1} %", 100.0 * share)),
            );
        }
        text + &rows::table(&self.look)
    }
}

/// Four digits, whatever the size.
fn number(ms: f64) -> String {
    let digits = (3.0 - ms.max(1e-3).log10().floor()).clamp(0.0, 6.0) as usize;
    format!("{ms:.digits$}")
}

#[cfg(test)]
pub(crate) mod tests {
    use super::*;

    /// A report with rows as different as rows can be.
    pub(in crate::bench) fn sample() -> Report {
        let limits = Limits { copy_gb_s: 10.0, fma_gflop_s: 100.0 };
        let times = Spread { gpu_ms: 2.0, low: 1.5, high: 2.5, cpu_ms: 0.1, runs: 7 };
        let deviation = |rms| Some((Deviation { rms, p99: 2.0 * rms, max: 3.0 * rms }, "f64 reference".to_owned()));
        let row = |pass, variant: &str, ms, accuracy, work| {
            let (variant, workload) = (variant.to_owned(), "512x512 sigma 4".to_owned());
            let times = Spread { gpu_ms: ms, ..times };
            Row::new("smoke", Subject { pass, variant, workload, items: 500 }, &times, &accuracy, work, &limits)
        };
        let work = Work { bytes: Some(4_000_000), flops: Some(100_000_000) };
        let rows = vec![
            row("gaussian", "direct", 200.0, deviation(1e-7), work),
            row("gaussian", "naive", 20.0, deviation(2e-2), work),
            row("grow", "growth", 2.0, deviation(0.0), Work { bytes: Some(4), flops: None }),
            row("frame", "default", 5.0, None, Work::default()),
        ];
        Report { device: "a device".into(), driver: "a driver 1.0".into(), limits, rows, look: Vec::new() }
    }

    /// The names that `bench.json` is documented to have; other programs read it by them.
    #[test]
    fn json_has_every_documented_name() -> serde_json::Result<()> {
        let json: serde_json::Value = serde_json::from_str(&sample().json()?)?;
        for key in ["device", "driver", "limits", "rows"] {
            assert!(json.get(key).is_some(), "{key}");
        }
        assert_eq!(json["limits"]["copy_gb_s"], 10.0);
        assert_eq!(json["limits"]["fma_gflop_s"], 100.0);
        let names = "effect pass variant workload items gpu_ms gpu_ms_low gpu_ms_high cpu_ms runs error_rms error_p99 \
            error_max error_of bytes flops of_limit";
        for row in json["rows"].as_array().into_iter().flatten() {
            for name in names.split_whitespace() {
                assert!(row.get(name).is_some(), "{name} in {row}");
            }
            assert_eq!(row.as_object().map(|o| o.len()), Some(names.split_whitespace().count()));
        }
        assert_eq!(json["rows"].as_array().map(Vec::len), Some(4));
        Ok(())
    }

    #[test]
    fn a_page_goes_by_the_device() {
        let report = Report { device: "NVIDIA H100 (80 GB)".into(), ..sample() };
        let (name, text) = report.page(&report.table());
        assert_eq!(name, "performance-nvidia-h100-80-gb.md");
        assert!(text.starts_with("# Performance on NVIDIA H100 (80 GB)\n") && text.contains("smoke gaussian"));
    }

    #[test]
    fn the_limit_is_the_one_that_is_nearer() {
        let report = sample();
        // 4 MB at 10 GB/s take 0.4 ms, 100 Mflop at 100 Gflop/s 1 ms.
        assert_eq!(report.rows[1].of_limit, Some(0.05));
        assert_eq!(report.rows[3].of_limit, None);
    }

    #[test]
    fn the_table_has_every_row() {
        let table = sample().table();
        for text in ["a device", "a driver 1.0", "direct", "growth", "default", "200.0", "smoke gaussian", "5.0 %"] {
            assert!(table.contains(text), "{text} in\n{table}");
        }
        assert_eq!(
            (number(0.0), number(0.012_341), number(1234.2)),
            ("0.000000".into(), "0.01234".into(), "1234".into())
        );
    }
}
