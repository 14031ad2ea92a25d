//! `on`: drawings that last for some frames.

use celfx::io::picture;
use celfx::io::volume::write_npz;

use super::run::{Folder, celfx, has_device};
use super::succeeds;

const SHOT: &str = "size = [48, 48]\nframes = [1, 6]\n[camera]\neye = [0, 0, 3]\ntarget = [0, 0, 0]\n\
                    [smoke]\nvolume = \"v.####.npz\"\nparticles = 60\nlifetime = 4\nfade = 2\n\
                    [flame]\nparticles = \"builtin:random\"\nflicker = 0.5\nlight = 1.0\n";

/// A ball of smoke that rises and turns, in a frame.
fn write_volume(folder: &Folder, name: &str, frame: u32) {
    let n = 12;
    let centre = [0.1 * frame as f32 - 0.3, 0.1 * frame as f32, 0.0];
    let place = |i: u32| [i % n, i / n % n, i / n / n].map(|i| (i as f32 + 0.5) * 0.2 - 1.2);
    let far = |p: [f32; 3]| (0..3).map(|a| (p[a] - centre[a]).powi(2)).sum::<f32>().sqrt();
    let volume = celfx::data::Volume {
        dimensions: [n; 3],
        voxel_size: [0.2; 3],
        origin: [-1.2; 3],
        density: (0..n * n * n).map(|i| (0.8 - far(place(i))).max(0.0)).collect(),
        velocity: Some((0..n * n * n).map(|i| [2.4 - place(i)[1], 2.4, place(i)[0]]).collect()),
    };
    write_npz(&folder.0.join(name), &volume).expect("temporary folder");
}

fn picture(folder: &Folder, out: &str, frame: u32) -> Vec<[f32; 4]> {
    picture::read(&folder.0.join(format!("{out}/{frame:04}.exr"))).expect("a picture").pixels
}

fn pictures(folder: &Folder, out: &str) -> Vec<Vec<[f32; 4]>> {
    (1..=6).map(|frame| picture(folder, out, frame)).collect()
}

/// On twos the effects are those of half the frame rate, each frame twice; volumes of frames between need not be there. The camera
/// goes on. A frame alone is that of the sequence.
#[test]
fn on_twos_every_drawing_lasts_two_frames() {
    if !has_device() {
        return;
    }
    let folder = Folder::new();
    folder.write("twos.toml", &format!("on = 2\n{SHOT}"));
    (1..=5).step_by(2).for_each(|frame| write_volume(&folder, &format!("v.{frame:04}.npz"), frame));
    succeeds(&folder, &["render", "twos.toml", "-q", "-o", "twos/####.exr"]);
    let twos = pictures(&folder, "twos");
    for drawing in [0, 2, 4] {
        assert!(twos[drawing] == twos[drawing + 1], "frame {} has a drawing of its own", drawing + 2);
    }
    assert!(twos[0] != twos[2] && twos[2] != twos[4]);

    succeeds(&folder, &["render", "twos.toml", "-q", "-o", "alone/####.exr", "--frames", "4-4"]);
    assert!(picture(&folder, "alone", 4) == twos[3]);

    let moving = "camera.eye=[[1, [0, 0, 3]], [6, [0.5, 0, 3]]]";
    succeeds(&folder, &["render", "twos.toml", "-q", "-o", "moving/####.exr", "--set", moving]);
    let moving = pictures(&folder, "moving");
    assert!(moving.windows(2).all(|pair| pair[0] != pair[1]), "the camera goes on");

    // Smoke alone, of half the frames: what counts frames counts drawings.
    let alone = SHOT.split("[flame]").next().unwrap_or_default();
    let half = alone.replace("frames = [1, 6]", "frames = [1, 3]\nfps = 12").replace("v.", "h.");
    folder.write("half.toml", &half.replace("lifetime = 4\nfade = 2", "lifetime = 2\nfade = 1\nstill = 1e-4"));
    (1..=3).for_each(|frame| write_volume(&folder, &format!("h.{frame:04}.npz"), 2 * frame - 1));
    succeeds(&folder, &["render", "half.toml", "-q", "-o", "half/####.exr", "--set", "smoke.range_smoothing=0.25"]);
    folder.write("smoke.toml", &format!("on = 2\n{alone}"));
    succeeds(
        &folder,
        &[
            "render",
            "smoke.toml",
            "-q",
            "-o",
            "smoke/####.exr",
            "--set",
            "smoke.still=5e-5",
            "--set",
            "smoke.range_smoothing=0.5",
        ],
    );
    for frame in 1..=3 {
        assert!(picture(&folder, "half", frame) == picture(&folder, "smoke", 2 * frame - 1), "frame {frame}");
    }
    assert!(celfx(&folder, &["render", "smoke.toml", "--set", "on=1"]).output().is_ok_and(|out| !out.status.success()));
}
