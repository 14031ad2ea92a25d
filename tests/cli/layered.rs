//! One file a frame for compositing, against the files of each layer.

use std::collections::BTreeMap;

use celfx::io::image::read_exr;

use super::run::{self, Folder, has_device};
use super::{fails, succeeds};

/// The channels of a file, by their names.
fn channels(folder: &Folder, name: &str) -> BTreeMap<String, Vec<f32>> {
    read_exr(&folder.0.join(name)).expect(name).channels.into_iter().collect()
}

#[test]
fn one_file_has_the_picture_the_layers_and_who_is_where() {
    if !has_device() {
        return;
    }
    let folder = Folder::new();
    let render = ["render", "builtin:campfire", "-q", "--frames", "6", "--set", "size=[96, 96]", run::validate()];
    succeeds(&folder, &[&render[..], &["-o", "a.exr", "--layers", "each"]].concat());
    succeeds(&folder, &[&render[..], &["-o", "b.exr", "--layers", "comp.####.exr"]].concat());
    let one = channels(&folder, "comp.0006.exr");
    let picture = channels(&folder, "b.exr");
    assert_eq!(channels(&folder, "a.exr"), picture);
    // Halves are off by at most half of their last of 11 digits.
    let near = |half: &f32, float: &f32| (half - float).abs() <= float.abs() / 2048.0 + 1e-7;
    for name in ["R", "G", "B", "A"] {
        assert!(one[name].iter().zip(&picture[name]).all(|(half, float)| near(half, float)), "{name}");
    }
    let [smoke, flame] = ["smoke", "flame"].map(|name| channels(&folder, &format!("each/{name}.0006.exr")));
    let depth = channels(&folder, "each/smoke.depth.0006.exr");
    assert_eq!(one["smoke_depth.Y"], depth["Y"]);
    let shares = ["G", "A"].map(|name| &one[&format!("CryptoObject00.{name}")]);
    let (mut both, mut covered) = (0, 0);
    for pixel in 0..depth["Y"].len() {
        // Whichever is before the other, what both leave of a pixel is the same: but for the rounding of three products.
        let seen = 1.0 - (1.0 - smoke["A"][pixel]) * (1.0 - flame["A"][pixel]);
        let found = shares[0][pixel] + shares[1][pixel];
        assert!((found - seen).abs() < 1e-6, "{pixel}: {found} {seen}");
        both += u32::from(shares[1][pixel] > 0.0);
        covered += u32::from(seen > 0.0);
        assert_eq!(one["Z"][pixel] < 1e10, seen > 0.0, "{pixel}");
    }
    assert!(both > 0 && covered > 500, "{both} {covered}");
    // The picture is kept with it, and not without.
    let again = [&render[..], &["-o", "b.exr", "--layers", "comp.####.exr", "--resume"]].concat();
    let time = |name: &str| std::fs::metadata(folder.0.join(name)).and_then(|file| file.modified()).expect(name);
    let before = time("b.exr");
    succeeds(&folder, &again);
    assert_eq!(time("b.exr"), before);
    std::fs::remove_file(folder.0.join("comp.0006.exr")).expect("removed");
    succeeds(&folder, &again);
    assert_eq!(channels(&folder, "comp.0006.exr"), one);
}

#[test]
fn a_mesh_has_its_objects_and_depth_in_it() {
    if !has_device() {
        return;
    }
    let folder = Folder::new();
    // The first frame, in which nothing moves, and one that is smeared.
    for frame in ["1", "8"] {
        let render = ["render", "builtin:blur", "-q", "--frames", frame, "--set", "size=[96, 96]", run::validate()];
        succeeds(&folder, &[&render[..], &["-o", "plain.exr"]].concat());
        let one = ["-o", "b.exr", "--layers", "comp.####.exr", "--compression", "piz"];
        succeeds(&folder, &[&render[..], &one].concat());
        assert_eq!(channels(&folder, "plain.exr"), channels(&folder, "b.exr"), "frame {frame}: layers change no pixel");
        let one = channels(&folder, &format!("comp.000{frame}.exr"));
        let samples = ["R", "G", "B", "A"].map(|name| &one[&format!("blur_object.{name}")][..]);
        let ranks =
            ["CryptoObject00.G", "CryptoObject00.A", "CryptoObject01.G", "CryptoObject01.A"].map(|name| &one[name]);
        let (mut whole, mut edges) = (0, 0);
        for pixel in 0..96 * 96 {
            let seen = samples.iter().filter(|sample| sample[pixel] > 0.0).count();
            let shares = ranks.map(|rank| rank[pixel]);
            assert_eq!(shares.iter().sum::<f32>(), 0.25 * seen as f32, "frame {frame}, {pixel}");
            assert!(shares.is_sorted_by(|a, b| a >= b), "{shares:?}");
            assert_eq!(one["Z"][pixel] < 1e9, seen > 0, "frame {frame}, {pixel}");
            whole += usize::from(shares[0] == 1.0);
            edges += usize::from(shares[1] > 0.0);
        }
        assert!(whole > 300 && edges > 5, "frame {frame}: {whole}, {edges}");
    }
    let wrong = ["render", "builtin:blur", "--compression", "piz", "--layers", "folder"];
    fails(&folder, &wrong, 2, &["--compression", "--layers FILE.####.exr"]);
}
