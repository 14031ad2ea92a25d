//! A tiny benchmark on the device: files and rows.
#![cfg(feature = "cli")]

#[allow(unused_imports, reason = "each test file uses its part")]
mod common;

use std::path::Path;

use celfx::bench::{Request, Watch, run};
use celfx::program::benchmarks;

struct Silent;

impl Watch for Silent {
    fn progress(&self, _: &str) {}

    fn is_interrupted(&self) -> bool {
        false
    }
}

struct Impatient;

impl Watch for Impatient {
    fn progress(&self, _: &str) {}

    fn is_interrupted(&self) -> bool {
        true
    }
}

fn request(effect: Option<&str>, only: &[&str]) -> Request {
    let only = only.iter().map(|only| String::from(*only)).collect();
    Request { what: benchmarks(effect), look: Vec::new(), quick: true, only, page: None, device: common::options() }
}

/// Rows of `bench.json` after one benchmark under validation; a message of it is an error. One for all that a test looks
/// at: each measures the device's limits first.
fn rows(effect: &str, only: &[&str], folder: &Path) -> Vec<serde_json::Value> {
    let table = run(&request(Some(effect), only), folder, &Silent).expect("a benchmark that succeeds");
    let json = std::fs::read_to_string(folder.join("bench.json")).expect("bench.json");
    let json: serde_json::Value = serde_json::from_str(&json).expect("JSON");
    for limit in ["copy_gb_s", "fma_gflop_s"] {
        assert!(json["limits"][limit].as_f64().is_some_and(|value| value > 0.0), "{limit}: {json}");
    }
    assert!(json["device"].as_str().is_some_and(|name| table.contains(name)), "{table}");
    for plot in ["svg", "png"].map(|kind| format!("{effect}.{kind}")) {
        assert!(std::fs::metadata(folder.join(&plot)).is_ok_and(|file| file.len() > 1000), "{plot}");
    }
    let rows = json["rows"].as_array().expect("rows").clone();
    for row in &rows {
        let work = ["bytes", "flops"].map(|amount| row[amount].as_u64().unwrap_or_default());
        assert!(work.iter().all(|amount| *amount > 0), "{row}");
        assert!(row["of_limit"].as_f64().is_some_and(|share| share > 0.0 && share <= 1.0), "{row}");
    }
    rows
}

/// Those of a pass.
fn of_pass<'a>(rows: &'a [serde_json::Value], pass: &str) -> Vec<&'a serde_json::Value> {
    rows.iter().filter(|row| row["pass"] == pass).collect()
}

#[test]
fn one_workload_of_each_pass() {
    if common::device().is_none() {
        return;
    }
    let folder = std::env::temp_dir().join(format!("celfx-bench-{}", std::process::id()));

    let all = rows("smoke", &["15x15x20", "/512x512 sigma 4", "shadow/exact/paper", "shadow/map 1024/paper"], &folder);
    // All ways to search a radius agree with the brute force to rounding, or with the fine search for the surface.
    let grow = of_pass(&all, "grow");
    let names: Vec<&str> = grow.iter().filter_map(|row| row["variant"].as_str()).collect();
    assert_eq!(names, ["growth", "field", "pyramid", "chosen", "surface", "surface_ball"]);
    for row in grow {
        assert_eq!((&row["workload"], &row["runs"]), (&"15x15x20/500".into(), &1.into()));
        assert!(row["gpu_ms"].as_f64().is_some_and(|ms| ms > 0.0), "{row}");
        // Half an ulp of a coordinate of 2 m, in voxels of 0.12 m, twice; or what a search up to the surface leaves open.
        let is_surface = row["variant"].as_str().is_some_and(|name| name.starts_with("surface"));
        let bound = if is_surface { 0.02 } else { 2e-6 };
        assert!(row["error_max"].as_f64().is_some_and(|error| error < bound), "{row}");
    }

    // The exact forms of the masked Gaussian are exact, the wrong one and the one without mask are not.
    let gaussian = of_pass(&all, "gaussian");
    assert!(gaussian.len() > 3, "{gaussian:?}");
    for row in gaussian {
        let error = row["error_max"].as_f64().expect("an error");
        match row["variant"].as_str().expect("a name") {
            "direct" | "per_id_image" | "per_id_tiles" | "soft_tiles" => assert!(error < 2e-6, "{row}"),
            _ => assert!(error > 0.05, "{row}"),
        }
        assert!(row["of_limit"].as_f64().is_some_and(|share| share > 0.0), "{row}");
    }

    // Exact shadows differ from those in f64 at borders only; a shadow map blurs them.
    let shadow = of_pass(&all, "shadow");
    assert_eq!(shadow.len(), 2, "{shadow:?}");
    for row in shadow {
        match row["variant"].as_str().expect("a name") {
            "exact" => assert!(row["error_p99"].as_f64().is_some_and(|error| error == 0.0), "{row}"),
            // Wrong by up to 1, at most at one pixel in a hundred: those within a texel of a shadow's border.
            _ => assert!(row["error_rms"].as_f64().is_some_and(|error| error > 0.0 && error < 0.1), "{row}"),
        }
    }
    std::fs::remove_dir_all(&folder).expect("the folder is removed");
}

#[test]
fn fire_by_repetitions_by_its_limit_and_by_blending() {
    if common::device().is_none() {
        return;
    }
    let folder = std::env::temp_dir().join(format!("celfx-bench-flame-{}", std::process::id()));
    let field = |row: &serde_json::Value, name: &str| row[name].as_f64().expect("a number");

    let accumulated = ["R=16/thin", "expected 32/thin", "ed/thin", "mboit 4/thin", "mboit 6/thin", "wavelet 3/thin"];
    let all = rows("flame", &[&accumulated[..], &["frame/R=10/paper"]].concat(), &folder);
    let thin = of_pass(&all, "accumulate");
    let (repetitions, others) = thin.split_at(3);
    let names: Vec<&str> = repetitions.iter().filter_map(|row| row["variant"].as_str()).collect();
    assert_eq!(names, ["raster R=16", "tiles R=16", "tiles sobol R=16"]);
    for row in repetitions {
        assert_eq!(
            (&row["effect"], &row["pass"], &row["workload"]),
            (&"flame".into(), &"accumulate".into(), &"thin".into())
        );
        assert!(field(row, "gpu_ms") > 0.0 && field(row, "items") > 16.0 * 600.0, "{row}");
        // A value between 0 and 1 has a variance of 1/4 at most, its mean of 16 a deviation of 1/8.
        assert!((f64::MIN_POSITIVE..0.125).contains(&field(row, "error_rms")), "{row}");
    }
    // Two ways to the same picture.
    let error = |row: &serde_json::Value| field(row, "error_rms");
    // Which is that of the same samples: sums differ in rounding only.
    assert!((error(repetitions[0]) - error(repetitions[1])).abs() < 1e-6);

    let (expected, blended) = (others[0], &others[1..]);
    assert_eq!(expected["variant"], "expected 32");
    assert!(error(expected) < 0.5 * error(repetitions[1]), "{expected}");
    let names: Vec<&str> = blended.iter().filter_map(|row| row["variant"].as_str()).collect();
    assert_eq!(names, ["sorted", "weighted", "mboit 4", "mboit 6", "wavelet 3"]);
    for row in blended {
        assert!((error(expected)..1.0).contains(&error(row)), "blending is biased: {row}");
    }
    let frame = of_pass(&all, "frame");
    assert_eq!((frame.len(), all.len()), (1, thin.len() + 1));
    std::fs::remove_dir_all(&folder).expect("the folder is removed");
}

#[test]
fn hulls_windows_and_fine_triangles() {
    if common::device().is_none() {
        return;
    }
    let folder = std::env::temp_dir().join(format!("celfx-bench-blur-{}", std::process::id()));
    let field = |row: &serde_json::Value, name: &str| row[name].as_f64().expect("a number");

    // The hull has the bits of brute force.
    let all = rows("blur", &["extent/hull/", "1/fox-like", "frame/default/paper"], &folder);
    let extent = of_pass(&all, "extent");
    assert_eq!((extent.len(), &extent[0]["workload"]), (2, &"10000".into()));
    assert!(extent.iter().all(|row| field(row, "error_max") == 0.0 && field(row, "items") >= 10_000.0), "{extent:?}");

    let refine = of_pass(&all, "refine");
    assert_eq!((refine.len(), &refine[0]["variant"]), (1, &"error 1".into()));
    assert!(field(refine[0], "error_p99") < 1.5 && field(refine[0], "items") > 1000.0, "{}", refine[0]);
    let frame = of_pass(&all, "frame");
    assert_eq!(all.len(), extent.len() + 2);
    assert_eq!((frame.len(), &frame[0]["effect"]), (1, &"blur".into()));
    // Edges are a tolerance of a pixel off, and few pixels are beside an edge: a hundredth, at most as much as 1.
    assert!(field(frame[0], "error_rms") < 0.1 && field(frame[0], "cpu_ms") > 0.0, "{}", frame[0]);
    std::fs::remove_dir_all(&folder).expect("the folder is removed");
}

#[test]
fn an_interruption_writes_nothing() {
    if common::device().is_none() {
        return;
    }
    let folder = std::env::temp_dir().join(format!("celfx-bench-interrupted-{}", std::process::id()));
    let ended = run(&request(None, &[]), &folder, &Impatient);
    assert!(matches!(ended, Err(celfx::bench::BenchError::Interrupted)), "{ended:?}");
    assert!(!folder.join("bench.json").exists());
    std::fs::remove_dir_all(&folder).expect("the folder is removed");
}
