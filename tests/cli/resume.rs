//! `--resume`: frames of these settings and this input are kept, others are not.

use std::fs;

use celfx::data::Volume;
use celfx::io::display::Display;
use celfx::io::picture;
use celfx::io::volume::write_npz;

use super::run::{Folder, celfx, has_device};
use super::{fails, succeeds};

const SHOT: &str = "size = [48, 48]\nframes = [1, 4]\n[smoke]\nvolume = \"v.####.npz\"\nparticles = 60\n";

fn write_volume(folder: &Folder, frame: u32, density: f32) {
    let volume = Volume {
        dimensions: [4; 3],
        voxel_size: [0.25; 3],
        origin: [-0.5, 0.5, -0.5],
        density: (0..64).map(|i| density * f32::from(i as u8)).collect(),
        velocity: None,
    };
    write_npz(&folder.0.join(format!("v.{frame:04}.npz")), &volume).expect("temporary folder");
}

fn folder() -> Folder {
    let folder = Folder::new();
    folder.write("shot.toml", SHOT);
    (1..=4).for_each(|frame| write_volume(&folder, frame, 1.0));
    folder
}

/// Last line of the table, and what is said beside it.
fn resumed(folder: &Folder, pattern: &str, more: &[&str]) -> (String, String) {
    let arguments = [&["render", "shot.toml", "-o", pattern, "--resume"], more].concat();
    let output = celfx(folder, &arguments).output().expect("the program runs");
    let [out, error] = [output.stdout, output.stderr].map(|bytes| String::from_utf8(bytes).expect("UTF-8"));
    assert!(output.status.success(), "{arguments:?}\n{error}");
    (out.lines().last().unwrap_or_default().to_owned(), error)
}

#[test]
fn frames_of_other_settings_or_input_are_rendered_again() {
    if !has_device() {
        return;
    }
    for pattern in ["o/####.png", "o/####.exr"] {
        let folder = folder();
        succeeds(&folder, &["render", "shot.toml", "-q", "-o", pattern]);
        let kept = |more: &[&str]| resumed(&folder, pattern, more);
        // What changes no pixel: other files, threads, a range.
        for more in [&[][..], &["--threads", "1"], &["--frames", "1-4"], &["--sheet", "s.png"], &["--set", "seed=0"]] {
            let (last, said) = kept(more);
            assert!(last.contains("0 frames rendered, 4 kept") && said.is_empty(), "{more:?}: {last} {said}");
        }
        let (last, said) = kept(&["--set", "smoke.sigma=3", "--frames", "2-3"]);
        assert!(last.contains("2 frames rendered:"), "{last}");
        assert!(said.contains("2 frames are rendered again") && said.contains("0002.png") | said.contains("0002.exr"));
        let (last, said) = kept(&[]);
        assert!(last.contains("2 frames rendered, 2 kept") && said.contains("2 frames are rendered again"), "{last}");
        // A volume that is another one from now on, in place of the file or of the name.
        write_volume(&folder, 3, 2.0);
        let (last, _) = kept(&[]);
        assert!(last.contains("2 frames rendered, 2 kept"), "{last}");
        let whole = |name: &str| fs::read(folder.0.join("o").join(name)).expect(name);
        let names = folder_names(&folder, "o");
        let resumed: Vec<Vec<u8>> = names.iter().map(|name| whole(name)).collect();
        succeeds(&folder, &["render", "shot.toml", "-q", "-o", pattern]);
        for (name, resumed) in names.iter().zip(resumed) {
            assert!(resumed == whole(name), "{name}: as if it had been rendered at once");
        }
    }
}

fn folder_names(folder: &Folder, of: &str) -> Vec<String> {
    super::run::names(&folder.0.join(of))
}

#[test]
fn strict_refuses_frames_of_other_settings() {
    if !has_device() {
        return;
    }
    let folder = folder();
    let render = ["render", "shot.toml", "-q", "-o", "o/####.png"];
    succeeds(&folder, &[&render[..], &["--frames", "1-2"]].concat());
    let strict = [&render[..], &["--resume=strict"]].concat();
    succeeds(&folder, &[&strict[..], &["--frames", "1-3"]].concat());
    let before = ["1", "2", "3"].map(|frame| fs::read(folder.0.join(format!("o/000{frame}.png"))).expect(frame));
    let other = [&strict[..], &["--set", "seed=7"]].concat();
    fails(&folder, &other, 2, &["--resume=strict", "o/0001.png was not made from", "2 more frames"]);
    // A frame of an older version says nothing.
    let pixels = picture::read(&folder.0.join("o/0003.png")).expect("readable").pixels;
    picture::write(&folder.0.join("o/0003.png"), picture::Format::Png, [48, 48], &pixels, &Display::Srgb, None)
        .expect("written");
    fails(&folder, &strict, 2, &["o/0003.png was not made from"]);
    let after = ["1", "2"].map(|frame| fs::read(folder.0.join(format!("o/000{frame}.png"))).expect(frame));
    assert!(before[..2] == after && folder_names(&folder, "o").len() == 3, "nothing was rendered");
    let (last, said) = resumed(&folder, "o/####.png", &[]);
    assert!(last.contains("2 frames rendered, 2 kept") && said.contains("1 frame is rendered again"), "{last} {said}");
    assert!(fs::read(folder.0.join("o/0003.png")).expect("rendered") == before[2]);
    fails(&folder, &[&render[..], &["--resume=always"]].concat(), 2, &["always", "strict"]);
}

#[test]
fn layers_of_other_settings_are_rendered_again() {
    if !has_device() {
        return;
    }
    let folder = folder();
    let render = ["render", "shot.toml", "-q", "-o", "o/####.png", "--layers", "l", "--frames", "1-2"];
    succeeds(&folder, &render);
    // A run with other settings that was ended between a frame's layers and its picture.
    let [depth, spheres] = ["l/smoke.depth.0001.exr", "l/smoke.spheres.0002.npy"].map(|name| folder.0.join(name));
    let right = [fs::read(&depth).expect("rendered"), fs::read(&spheres).expect("rendered")];
    let other =
        ["render", "shot.toml", "-q", "-o", "x/####.png", "--layers", "x", "--frames", "1-2", "--set", "seed=5"];
    succeeds(&folder, &other);
    fs::copy(folder.0.join("x/smoke.depth.0001.exr"), &depth).expect("temporary folder");
    fs::copy(folder.0.join("x/smoke.spheres.0002.npy"), &spheres).expect("temporary folder");
    let (last, _) = resumed(&folder, "o/####.png", &["--frames", "1-2"]);
    assert!(last.contains("0 frames rendered, 2 kept"), "pictures are right: {last}");
    let (last, _) = resumed(&folder, "o/####.png", &["--frames", "1-2", "--layers", "l"]);
    assert!(last.contains("2 frames rendered"), "{last}");
    assert!(right == [fs::read(&depth).expect("rendered"), fs::read(&spheres).expect("rendered")]);
}
