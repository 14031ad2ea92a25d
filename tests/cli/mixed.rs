//! Shots of a blurred mesh with smoke and fire: what is nearer hides what is behind it.

use std::path::Path;

use celfx::data::Volume;
use celfx::io::image::read_exr;
use celfx::io::picture;
use celfx::io::volume::write_npz;

use super::blur::write_cache;
use super::run::{self, Folder, has_device};
use super::succeeds;

const SIZE: [u32; 2] = [96, 64];
const PIXELS: usize = (SIZE[0] * SIZE[1]) as usize;
/// A triangle of 1.6 m, seen from 4 m, that moves 0.2 m to the right in each frame.
const SHOT: &str = "size = [96, 64]\nframes = [1, 4]\nbackground = [0.2, 0.3, 0.5]\n[camera]\neye = [0, 0, 4]\n\
    target = [0, 0, 0]\n";
const BLUR: &str = "[blur]\nscene = \"mesh.npz\"\ntooth_width = 60\n";

fn folder() -> Folder {
    let folder = Folder::new();
    let corners = |frame: i32| {
        let x = 0.2 * frame as f32 - 0.4;
        [[x - 0.8, -0.7, 0.0], [x + 0.8, -0.7, 0.0], [x, 0.9, 0.0]].concat()
    };
    write_cache(&folder.0.join("mesh.npz"), 4, 3, &(0..4).flat_map(corners).collect::<Vec<_>>());
    for (name, z) in [("front", 1.0), ("behind", -1.0)] {
        write_wall(&folder.0.join(format!("fire.{name}.npz")), z);
        // Half of what is seen, so that some of it is beside the mesh.
        let origin = [-0.5, -1.0, z - 0.125];
        let volume = Volume {
            dimensions: [16, 16, 4],
            voxel_size: [0.0625; 3],
            origin,
            density: vec![1.0; 1024],
            velocity: None,
        };
        write_npz(&folder.0.join(format!("smoke.{name}.npz")), &volume).expect("temporary folder");
    }
    folder
}

/// Hot particles all over a square of 1 m.
fn write_wall(path: &Path, z: f32) {
    let place = |i: u16| [f32::from(i % 20) * 0.05 - 0.5, f32::from(i / 20) * 0.05 - 0.5, z];
    let mut archive = run::archive(path);
    run::add_array(&mut archive, "position", &[400, 3], (0..400).flat_map(place));
    run::add_array(&mut archive, "temperature", &[400], (0..400).map(|_| 3000.0_f32));
}

/// A frame of a shot with these tables, and a layer of it.
struct Rendered<'a> {
    folder: &'a Folder,
    name: &'a str,
    picture: Vec<[f32; 4]>,
}

impl Rendered<'_> {
    fn layer(&self, layer: &str) -> Vec<Vec<f32>> {
        let path = self.folder.0.join(format!("{}/{layer}.0003.exr", self.name));
        read_exr(&path).expect(layer).channels.into_iter().map(|(_, values)| values).collect()
    }

    fn colours(&self, layer: &str) -> Vec<[f32; 4]> {
        picture::read(&self.folder.0.join(format!("{}/{layer}.0003.exr", self.name))).expect(layer).pixels
    }
}

fn render<'a>(folder: &'a Folder, name: &'a str, tables: &str, more: &[&str]) -> Rendered<'a> {
    folder.write(&format!("{name}.toml"), &format!("{SHOT}{tables}"));
    let (shot, picture) = (format!("{name}.toml"), format!("{name}.exr"));
    let render = ["render", &shot, "-q", "--frames", "3", "-o", &picture, "--layers", name, run::validate()];
    succeeds(folder, &[&render[..], more].concat());
    let picture = picture::read(&folder.0.join(picture)).expect("a picture").pixels;
    assert_eq!(picture.len(), PIXELS);
    Rendered { folder, name, picture }
}

/// The options of a blur without skirt, of which nothing lies beside the mesh.
fn options(strength: &str) -> [&str; 4] {
    ["--set", strength, "--set", "blur.skirt=0"]
}

/// How much of each pixel the mesh covers.
fn shares(folder: &Folder, strength: &str) -> Vec<f32> {
    let more = [&options(strength)[..], &["--set", "background=none"]].concat();
    let shares: Vec<f32> = render(folder, "mesh", BLUR, &more).picture.iter().map(|pixel| pixel[3]).collect();
    let count = |is: &dyn Fn(f32) -> bool| shares.iter().filter(|share| is(**share)).count();
    assert!(count(&|share| share == 1.0) > 300 && count(&|share| share == 0.0) > 300, "{strength}");
    assert!(count(&|share| share > 0.2 && share < 0.8) > 30, "{strength}: edges");
    shares
}

/// Blurred, and as it is.
const STRENGTHS: [&str; 2] = ["blur.strength=1", "blur.strength=0"];

#[test]
fn a_mesh_hides_the_fire_behind_it_and_not_the_fire_before_it() {
    if !has_device() {
        return;
    }
    let folder = folder();
    for strength in STRENGTHS {
        let fire =
            |place: &str| format!("[flame]\nparticles = \"fire.{place}.npz\"\nspread = 0.05\nlook = \"light\"\n{BLUR}");
        let (shares, alone) = (shares(&folder, strength), render(&folder, "alone", BLUR, &options(strength)));
        let behind = render(&folder, "behind", &fire("behind"), &options(strength));
        let front = render(&folder, "front", &fire("front"), &options(strength));
        let coverage = [&behind, &front].map(|shot| shot.layer("flame.coverage").remove(0));
        let fire_alone = front.colours("flame");
        let mut counts = [0; 2];
        for pixel in 0..PIXELS {
            let is_mesh = shares[pixel] == 1.0;
            if is_mesh {
                assert!(behind.picture[pixel] == alone.picture[pixel], "{strength}, pixel {pixel}: hidden");
                assert!(coverage[0][pixel] == 0.0);
            }
            counts[0] += usize::from(!is_mesh && coverage[0][pixel] > 0.9);
            if is_mesh && coverage[1][pixel] == 1.0 {
                assert!(front.picture[pixel] == fire_alone[pixel], "{strength}, pixel {pixel}: covered");
                counts[1] += 1;
            }
        }
        assert!(counts[0] > 10 && counts[1] > 100, "{strength}: beside and before it: {counts:?}");
        // The blur's layer is the blur's alone.
        assert!([behind, front].iter().all(|shot| shot.colours("blur") == alone.picture), "{strength}");
    }
}

#[test]
fn a_mesh_hides_the_smoke_behind_it_and_not_the_smoke_before_it() {
    if !has_device() {
        return;
    }
    let folder = folder();
    let smoke =
        |place: &str| format!("[smoke]\nvolume = \"smoke.{place}.npz\"\nparticles = 300\nantialias = \"none\"\n");
    let [only_behind, only_front] = ["behind", "front"].map(|place| {
        let only = render(&folder, "only", &smoke(place), &[]);
        let depth = only.layer("smoke.depth").remove(0);
        (only.picture, depth)
    });
    for strength in STRENGTHS {
        let is_blurred = strength == STRENGTHS[0];
        let (shares, alone) = (shares(&folder, strength), render(&folder, "alone", BLUR, &options(strength)));
        for (place, is_behind, (only, depth)) in [("behind", true, &only_behind), ("front", false, &only_front)] {
            let both = render(&folder, place, &format!("{}{BLUR}", smoke(place)), &options(strength));
            let mut counts = [0; 3];
            for pixel in 0..PIXELS {
                let (share, has_smoke) = (shares[pixel], depth[pixel].is_finite());
                let (found, mesh) = (both.picture[pixel], alone.picture[pixel]);
                let kind = match (has_smoke, share) {
                    (true, 1.0) if is_behind => 0,
                    // What is blurred has something of its images' edges in its own, which cannot be told apart.
                    (true, share) if is_behind && share > 0.0 && is_blurred => continue,
                    (true, share) if is_behind && share > 0.0 => 1,
                    (true, _) => 2,
                    (false, _) => continue,
                };
                counts[kind] += 1;
                for channel in 0..3 {
                    let smoke = only[pixel][channel];
                    let background = [0.2, 0.3, 0.5][channel];
                    let (expected, slack) = match kind {
                        0 => (mesh[channel], 0.0),
                        // What was background is smoke. Halves have 11 bits.
                        1 => (mesh[channel] + (1.0 - share) * (smoke - background), 2e-3),
                        _ => (smoke, 0.0),
                    };
                    let off = (found[channel] - expected).abs();
                    assert!(off <= slack, "{strength}, {place}, pixel {pixel}, {share}: {off} off");
                }
            }
            let edges = if is_blurred { 0 } else { 15 };
            let least = if is_behind { [100, edges, 20] } else { [0, 0, 200] };
            assert!((0..3).all(|kind| counts[kind] >= least[kind]), "{strength}, {place}: {counts:?}");
        }
    }
}

/// A campfire that somebody runs through: no message of the validation, and the same frame alone.
#[test]
fn mesh_smoke_and_fire_are_in_one_shot() {
    if !has_device() {
        return;
    }
    let folder = Folder::new();
    let shot = "size = [96, 96]\nframes = [11, 13]\n[camera]\neye = [0, 1, 4]\ntarget = [0, 1, 0]\n[smoke]\n\
        particles = 100\n[flame]\nparticles = \"builtin:random\"\nlight = 2\n[blur]\nscene = \"builtin:run\"\n";
    folder.write("shot.toml", shot);
    let render = ["render", "shot.toml", "-q", run::validate()];
    succeeds(&folder, &[&render[..], &["-o", "all/####.exr", "--layers", "all"]].concat());
    succeeds(&folder, &[&render[..], &["-o", "alone/####.exr", "--frames", "13", "--layers", "alone"]].concat());
    for name in run::names(&folder.0.join("alone")) {
        let [all, alone] = ["all", "alone"].map(|of| std::fs::read(folder.0.join(of).join(&name)).expect(&name));
        assert!(all == alone, "{name} differs");
    }
}
