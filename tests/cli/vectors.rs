//! Motion vectors among the layers, where they are known in closed form.

use std::collections::BTreeMap;

use celfx::data::Volume;
use celfx::io::image::read_exr;
use celfx::io::volume;

use super::run::{self, Folder, has_device};
use super::{fails, succeeds};

/// Without perspective, 4 metres high: 16 pixels a metre. The camera goes right and up.
const HEAD: &str = "size = [64, 64]\nframes = [1, 3]\nbackground = \"none\"\n[camera]\northographic = 4.0\nfar = 20.0\n\
                    target = [[1, [0, 0, 0]], [3, [0.5, 0.25, 0]]]\neye = [[1, [0, 0, 5]], [3, [0.5, 0.25, 5]]]\n";
/// In pixels a frame, to the right and up: where what rests was earlier.
const CAMERA: [f32; 2] = [4.0, 2.0];

/// The motion vectors of a frame, by both ways to write them, each with how much of the pixel is covered.
fn vectors(folder: &Folder, frame: &str, layer: &str) -> Vec<([f32; 2], f32)> {
    let render = ["render", "a.toml", "-q", "--frames", frame, "--motion", run::validate()];
    succeeds(folder, &[&render[..], &["-o", "a.exr", "--layers", "each"]].concat());
    succeeds(folder, &[&render[..], &["-o", "a.exr", "--layers", "one.####.exr"]].concat());
    let read = |name: String| -> BTreeMap<String, Vec<f32>> {
        read_exr(&folder.0.join(&name)).expect(&name).channels.into_iter().collect()
    };
    let (each, one) = (read(format!("each/vector.000{frame}.exr")), read(format!("one.000{frame}.exr")));
    assert_eq!(["X", "Y"].map(|c| &each[c]), ["vector.X", "vector.Y"].map(|c| &one[c]));
    let alpha = &read(format!("each/{layer}.000{frame}.exr"))["A"];
    alpha.iter().enumerate().map(|(i, alpha)| ([each["X"][i], each["Y"][i]], *alpha)).collect()
}

/// All that is more than half covered moves so, the rest not at all.
fn all_move(folder: &Folder, frame: &str, layer: &str, expected: [f32; 2]) {
    let mut count = 0;
    for (vector, alpha) in vectors(folder, frame, layer) {
        let expected = if alpha > 0.5 { expected } else { [0.0; 2] };
        // Matrices are of 24 bits, and some pixels across.
        let off = [0, 1].map(|c| (vector[c] - expected[c]).abs());
        assert!(alpha == 0.5 || off.iter().all(|off| *off < 1e-3), "{layer} {frame}: {vector:?}, {alpha}");
        count += usize::from(alpha > 0.5);
    }
    assert!(count > 40, "{layer}: {count} pixels");
}

#[test]
fn motion_vectors_lead_to_where_things_were() {
    if !has_device() {
        return;
    }
    let folder = Folder::new();
    // Smoke that rests under a camera that moves.
    let density: Vec<f32> = (0..16 * 16 * 16).map(|i| if (4..12).contains(&(i % 16)) { 1.0 } else { 0.0 }).collect();
    let rests = Volume { dimensions: [16; 3], voxel_size: [0.125; 3], origin: [-1.0; 3], density, velocity: None };
    volume::write_npz(&folder.0.join("v.npz"), &rests).expect("written");
    folder.write("a.toml", &format!("{HEAD}[smoke]\nvolume = \"v.npz\"\nparticles = 400\n"));
    all_move(&folder, "1", "smoke", [0.0; 2]);
    all_move(&folder, "3", "smoke", CAMERA);
    // Fire that goes along with the camera to the right, and twice as fast down as that goes up.
    let row = |i: u32| format!("{},{},0,1500,6,-6,0\n", 0.05 * (i % 8) as f32 - 0.2, 0.1 * (i / 8) as f32 - 0.2);
    folder.write("p.csv", &format!("x,y,z,temperature,vx,vy,vz\n{}", (0..40).map(row).collect::<String>()));
    folder.write(
        "a.toml",
        &format!("{HEAD}[flame]\nparticles = \"p.csv\"\nlook = \"light\"\nsize = 0.3\nthreshold = 0.2\n"),
    );
    all_move(&folder, "3", "flame", [CAMERA[0] - 4.0, CAMERA[1] + 4.0]);
    // A blur's are of what moved on its own.
    let render = ["render", "builtin:blur", "-q", "--frames", "8", "--set", "size=[64, 64]", "--layers", "b.####.exr"];
    succeeds(&folder, &[&render[..], &["--motion", "-o", "b.png", run::validate()]].concat());
    let channels: BTreeMap<String, Vec<f32>> =
        read_exr(&folder.0.join("b.0008.exr")).expect("readable").channels.into_iter().collect();
    let moved = channels["vector.X"].iter().zip(&channels["Z"]).filter(|(x, _)| **x != 0.0);
    assert!(moved.clone().count() > 100 && moved.clone().all(|(_, z)| *z < 1e9));
    // It runs to the right of the picture.
    assert!(moved.clone().filter(|(x, _)| **x < 0.0).count() * 2 > moved.count());
    fails(&folder, &["render", "builtin:blur", "--motion"], 2, &["--layers"]);
}
