//! A fourth effect, of which the program knows nothing but its line in the registry: it is rendered, has layers, is timed
//! and measured as the others are.

use celfx::io::image::read_exr;

use super::run::{Folder, has_device};
use super::{fails, succeeds};

const SHOT: &str = "size = [64, 64]\nframes = [1, 2]\nbackground = [0.25, 0.5, 1.0]\n[smoke]\nparticles = 0\n";

#[test]
fn an_effect_is_its_folder_a_line_and_its_keys() {
    let folder = Folder::new();
    folder.write("plain.toml", SHOT);
    folder.write("dark.toml", &format!("{SHOT}[vignette]\nstrength = 0.75\nradius = 0.5\n"));
    folder.write("alone.toml", "[vignette]\n");
    fails(
        &folder,
        &["render", "dark.toml", "--set", "vignette.strength=2"],
        2,
        &["vignette.strength = 2", "0 (off) to 1"],
    );
    fails(&folder, &["render", "dark.toml", "--set", "vignette.strenght=1"], 2, &["did you mean vignette.strength?"]);
    fails(&folder, &["render", "alone.toml"], 2, &["[vignette]", "only with another effect"]);
    if !has_device() {
        return;
    }
    succeeds(&folder, &["render", "plain.toml", "-o", "plain.####.exr"]);
    let table = succeeds(
        &folder,
        &["render", "dark.toml", "-o", "dark.####.exr", "--layers", "layers", "--profile", "times.csv"],
    );
    let times = std::fs::read_to_string(folder.0.join("times.csv")).expect("a profile");
    for pass in ["vignette.darkness", "vignette.composite"] {
        assert!(table.contains(pass) && times.contains(pass), "{pass}:\n{table}\n{times}");
    }
    let channel = |name: &str, channel: &str| {
        let channels = read_exr(&folder.0.join(name)).expect("a picture").channels;
        channels.into_iter().find(|(name, _)| name == channel).expect(channel).1
    };
    let darkness = channel("layers/vignette.darkness.0001.exr", "Y");
    for name in ["R", "G", "B"] {
        let (plain, dark) = (channel("plain.0001.exr", name), channel("dark.0001.exr", name));
        for ((plain, dark), darkness) in plain.iter().zip(&dark).zip(&darkness) {
            // Two roundings of 32-bit floats.
            assert!((dark - plain * (1.0 - darkness)).abs() <= 1e-6, "{dark} of {plain}, {darkness}");
        }
    }
    // The centre stays, corners are 3/4 darker but for half a pixel.
    assert_eq!(darkness[32 * 64 + 32], 0.0);
    assert!((0.7..0.75).contains(&darkness[0]), "{}", darkness[0]);
    succeeds(&folder, &["bench", "vignette", "--quick", "-o", "bench"]);
    let rows = std::fs::read_to_string(folder.0.join("bench/bench.json")).expect("rows");
    let rows: serde_json::Value = serde_json::from_str(&rows).expect("JSON");
    let rows = rows["rows"].as_array().expect("rows");
    assert_eq!(rows.len(), 2);
    for row in rows {
        assert!(row["effect"] == "vignette" && row["pass"] == "darkness", "{row}");
        // The smooth step of a few roundings.
        assert!(row["error_max"].as_f64().is_some_and(|error| error < 1e-5), "{row}");
    }
}
