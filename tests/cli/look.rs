//! `celfx bench look`: what makes smoke, fire and smears look drawn, in shares of pixels.

use std::fs;

use celfx::io::picture;

use super::run::{Folder, has_device};
use super::{fails, succeeds};

#[test]
fn every_scene_has_its_shares_and_pictures() {
    if !has_device() {
        return;
    }
    let folder = Folder::new();
    // Smoke and fire together, in a shot that is shorter than what is measured of longer ones.
    folder.write("both.toml", "size = [320, 240]\nframes = [3, 8]\n[smoke]\n[flame]\n");
    let arguments =
        ["bench", "look", "builtin:smoke", "builtin:flame", "builtin:blur", "both.toml", "--quick", "-o", "out"];
    let table = succeeds(&folder, &arguments);
    let report = fs::read_to_string(folder.0.join("out/bench.json")).expect("rows");
    let report: serde_json::Value = serde_json::from_str(&report).expect("JSON");
    assert_eq!(report["rows"].as_array().map(Vec::len), Some(0), "nothing is timed");
    let rows = report["look"].as_array().expect("scenes");
    let expected = [
        ("builtin:smoke", [128, 128], [20, 22], "smoke"),
        ("builtin:flame", [128, 128], [20, 22], "flame"),
        ("builtin:blur", [128, 128], [20, 22], "blur"),
        ("both.toml", [80, 60], [3, 5], "both"),
    ];
    assert_eq!(rows.len(), expected.len());
    for (row, (scene, size, frames, file)) in rows.iter().zip(expected) {
        let found = (&row["scene"], &row["size"], &row["frames"]);
        assert_eq!(found, (&scene.into(), &serde_json::json!(size), &serde_json::json!(frames)));
        assert!(table.contains(scene), "{scene} in\n{table}");
        let has = |effect: &str| file == effect || (file == "both" && effect != "blur");
        for effect in ["smoke", "flame", "blur"] {
            assert_eq!(row[effect].is_null(), !has(effect), "{scene}: {effect}");
        }
        check_values(row);
        for file in [format!("out/look/{file}.png"), format!("out/look/{file}_faults.png")] {
            assert_eq!(picture::read(&folder.0.join(&file)).expect(&file).size, size, "{file}");
        }
    }
    let smoke = rows[0]["smoke"].as_object().expect("smoke");
    assert!(smoke.len() == 10 && smoke["ink"].as_f64() > Some(1.0), "{smoke:?}");
}

/// Shares are shares, counts are counts, and fire has detail at every distance.
fn check_values(row: &serde_json::Value) {
    for (name, value) in ["smoke", "blur"].iter().filter_map(|effect| row[effect].as_object()).flatten() {
        let most = if name.ends_with("specks") { 1e4 } else { 100.0 };
        assert!(value.as_f64().is_some_and(|value| (0.0..=most).contains(&value)), "{name} is {value}");
    }
    // Where smoke hides the fire, there is nothing to measure.
    let is_hidden = |value: &serde_json::Value| value.is_null() && !row["smoke"].is_null();
    for name in ["distance", "fine_detail"] {
        let values: Vec<_> = row["flame"][name].as_array().into_iter().flatten().collect();
        let are_there = values.iter().all(|value| value.as_f64() > Some(0.0) || is_hidden(value));
        assert!(row["flame"].is_null() || (values.len() == 5 && are_there), "{row}");
    }
}

#[test]
fn shots_that_cannot_be_measured_are_refused() {
    let folder = Folder::new();
    fails(&folder, &["bench", "look", "builtin:smoke", "--frames", "40-60"], 2, &["--frames 40-60", "frames 1 to 48"]);
    fails(&folder, &["bench", "look", "none.toml"], 3, &["none.toml"]);
    fails(&folder, &["bench", "smoke", "my.toml"], 2, &["my.toml", "celfx bench look"]);
    fails(&folder, &["bench", "smoke", "--set", "seed=1"], 2, &["--set seed=1", "celfx bench look"]);
}
