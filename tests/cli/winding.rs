//! Which way triangles run in a file changes nothing: files differ in it, and mirrors turn all of them over.

use std::f32::consts::TAU;
use std::fs;
use std::ops::RangeInclusive;

use celfx::io::image;
use serde_json::{Value, json};

use super::run::{self, Folder, has_device};
use super::succeeds;

const SIZE: [u32; 2] = [96, 64];
const FRAMES: usize = 6;
/// The frames that are made of images, too: before and after what a mirror turns over.
const IMAGES: RangeInclusive<u32> = 3..=4;
/// The same of what nothing turns over on the way: one frame of images is like the next.
const STEADY: RangeInclusive<u32> = 4..=4;
const SHOT: &str = "size = [96, 64]\nframes = [1, 6]\nfps = 1\nbackground = [0.2, 0.3, 0.5]\n[camera]\neye = [0, 0.3, 4]\n\
    target = [0, 0, 0]\n[light]\nposition = [2, 3, 4]\n[blur]\ntooth_width = 60\n";

/// A surface at rest.
#[derive(Clone)]
struct Shape {
    points: Vec<[f32; 3]>,
    triangles: Vec<[u32; 3]>,
}

/// A ring, which hides parts of itself; its axis leans. Triangles are counter-clockwise seen from outside.
fn ring(size: f32) -> Shape {
    const AROUND: [u32; 2] = [20, 10];
    let point = |i: u32| {
        let [a, b] = [i / AROUND[1], i % AROUND[1]];
        let (sin, cos) = (a as f32 / AROUND[0] as f32 * TAU).sin_cos();
        let (up, out) = (b as f32 / AROUND[1] as f32 * TAU).sin_cos();
        let far = size * (0.7 + 0.3 * out);
        let (x, y, z) = (far * cos, far * sin, size * 0.3 * up);
        [x, 0.8 * y - 0.6 * z, 0.6 * y + 0.8 * z]
    };
    let at = |a: u32, b: u32| a % AROUND[0] * AROUND[1] + b % AROUND[1];
    let quad = |i: u32| {
        let (a, b) = (i / AROUND[1], i % AROUND[1]);
        [[at(a, b), at(a + 1, b), at(a + 1, b + 1)], [at(a, b), at(a + 1, b + 1), at(a, b + 1)]]
    };
    let count = AROUND[0] * AROUND[1];
    Shape { points: (0..count).map(point).collect(), triangles: (0..count).flat_map(quad).collect() }
}

/// Triangles turned over where that is wanted.
fn turned(triangles: &[[u32; 3]], is_turned: impl Fn(usize) -> bool) -> Vec<[u32; 3]> {
    let turn = |(i, [a, b, c]): (usize, &[u32; 3])| if is_turned(i) { [*a, *c, *b] } else { [*a, *b, *c] };
    triangles.iter().enumerate().map(turn).collect()
}

fn mixed(triangle: usize) -> bool {
    triangle.wrapping_mul(2_654_435_761) >> 7 & 1 == 1
}

/// It goes to the right and turns, scaled along x frame by frame before.
fn poses(points: &[[f32; 3]], scales: [f32; FRAMES]) -> Vec<[f32; 3]> {
    let pose = |frame: usize| {
        let (sin, cos) = (0.15 * frame as f32).sin_cos();
        let shift = 0.12 * frame as f32 - 0.3;
        let place = move |[x, y, z]: &[f32; 3]| {
            let x = x * scales[frame];
            [x * cos - y * sin + shift, x * sin + y * cos, *z]
        };
        points.iter().map(place).collect::<Vec<_>>()
    };
    (0..FRAMES).flat_map(pose).collect()
}

fn colours(points: usize) -> impl Iterator<Item = f32> {
    (0..points).flat_map(|i| [0.9, (i % 5) as f32 * 0.2, if i % 2 == 0 { 0.1 } else { 0.6 }])
}

/// A folder with shots of caches and other files, and with images of their frames.
struct Stage(Folder);

impl Stage {
    fn new() -> Stage {
        let folder = Folder::new();
        folder.write("shot.toml", SHOT);
        fs::create_dir(folder.0.join("in")).expect("temporary folder");
        for frame in 1..=FRAMES as u32 {
            // Colours of places change a little: where they change much, the search for the light looks at all of them.
            let pixel = |i: u32| {
                let [x, y] = [i % SIZE[0], i / SIZE[0]].map(|at| at as f32);
                let wave = |along: f32| (140.0 + 80.0 * (along / 9.0).sin() + 3.0 * frame as f32) as u8;
                [wave(x + y), wave(x - y), wave(x + 3.0 * y), 255]
            };
            let pixels: Vec<[u8; 4]> = (0..SIZE[0] * SIZE[1]).map(pixel).collect();
            let path = folder.0.join(format!("in/{frame:04}.png"));
            image::write_png8(&path, SIZE, &pixels).expect("temporary folder");
        }
        Stage(folder)
    }

    fn cache(&self, name: &str, positions: &[[f32; 3]], triangles: &[[u32; 3]]) {
        let points = positions.len() / FRAMES;
        let mut archive = run::archive(&self.0.0.join(format!("{name}.npz")));
        let shape = [FRAMES as u64, points as u64, 3];
        run::add_array(&mut archive, "position", &shape, positions.iter().flatten().copied());
        let rows = [triangles.len() as u64, 3];
        run::add_array(&mut archive, "triangle", &rows, triangles.iter().flatten().copied());
        run::add_array(&mut archive, "colour", &[points as u64, 3], colours(points));
    }

    /// A glTF file of a shape: these are merged into its node, its root, and the primitive's attributes follow.
    fn gltf(&self, name: &str, shape: &Shape, node: &Value, root: &Value, more: &[(&str, &[u8], Value)]) {
        let points = shape.points.len();
        let floats = |values: &mut dyn Iterator<Item = f32>| values.flat_map(f32::to_le_bytes).collect::<Vec<u8>>();
        let positions = floats(&mut shape.points.iter().flatten().copied());
        let paint = floats(&mut colours(points));
        let indices: Vec<u8> = shape.triangles.iter().flatten().flat_map(|i| i.to_le_bytes()).collect();
        let bounds = |pick: fn(f32, f32) -> f32, from: f32| {
            [0, 1, 2].map(|axis| shape.points.iter().map(|p| p[axis]).fold(from, pick))
        };
        let [low, high] = [bounds(f32::min, f32::MAX), bounds(f32::max, f32::MIN)];
        let vectors = json!({"componentType": 5126, "count": points, "type": "VEC3", "min": low, "max": high});
        let all = [
            ("POSITION", &positions[..], vectors),
            ("COLOR_0", &paint[..], json!({"componentType": 5126, "count": points, "type": "VEC3"})),
            ("", &indices[..], json!({"componentType": 5125, "count": 3 * shape.triangles.len(), "type": "SCALAR"})),
        ];
        let (mut bytes, mut views, mut accessors) = (Vec::<u8>::new(), Vec::new(), Vec::new());
        let mut attributes = json!({});
        for (i, (semantic, own, accessor)) in
            all.iter().map(|(s, b, a)| (*s, *b, a)).chain(more.iter().map(|(s, b, a)| (*s, *b, a))).enumerate()
        {
            views.push(json!({"buffer": 0, "byteOffset": bytes.len(), "byteLength": own.len()}));
            bytes.extend(own);
            let mut accessor = accessor.clone();
            accessor["bufferView"] = i.into();
            accessors.push(accessor);
            if semantic.chars().next().is_some_and(char::is_uppercase) {
                attributes[semantic] = i.into();
            }
        }
        let mut own = json!({"mesh": 0});
        let merge = |into: &mut Value, from: &Value| {
            for (key, value) in from.as_object().into_iter().flatten() {
                into[key] = value.clone();
            }
        };
        merge(&mut own, node);
        let mut file = json!({
            "asset": {"version": "2.0"}, "scene": 0, "scenes": [{"nodes": [0]}], "nodes": [own],
            "meshes": [{"primitives": [{"attributes": attributes, "indices": 2}]}],
            "bufferViews": views, "accessors": accessors,
            "buffers": [{"uri": format!("{name}.bin"), "byteLength": bytes.len()}],
        });
        merge(&mut file, root);
        fs::write(self.0.0.join(format!("{name}.bin")), bytes).expect("temporary folder");
        self.0.write(&format!("{name}.gltf"), &file.to_string());
    }

    /// Pictures and layers of a scene, by name: of frames that are drawn, and of two of images.
    fn render(&self, scene: &str) -> Vec<(String, Vec<u8>)> {
        self.render_frames(scene, 1..=FRAMES as u32, IMAGES, &[])
    }

    /// The same of a scene that nothing turns over on the way.
    fn render_steady(&self, scene: &str) -> Vec<(String, Vec<u8>)> {
        self.render_frames(scene, 1..=FRAMES as u32, STEADY, &[])
    }

    /// The same of some frames that are drawn, and of some of images, for which a light has to be found, which takes long;
    /// with options.
    fn render_frames(
        &self,
        scene: &str,
        drawn: RangeInclusive<u32>,
        images: RangeInclusive<u32>,
        more: &[&str],
    ) -> Vec<(String, Vec<u8>)> {
        let mut all = Vec::new();
        let count = drawn.clone().chain(images.clone()).count();
        let scene_key = format!("blur.scene={scene}");
        for (kind, key, frames) in [("drawn", "blur.strength=1", drawn), ("images", "blur.images=in/####.png", images)]
        {
            let out = format!("{scene}.{kind}");
            let frames = format!("{}-{}", frames.start(), frames.end());
            let picture = format!("{out}/####.exr");
            let set = ["--set", &scene_key, "--set", key, "--frames", &frames, "-o", &picture, "--layers", &out];
            let render = ["render", "shot.toml", "-q", run::validate()];
            succeeds(&self.0, &[&render[..], &set[..], more].concat());
            let read = |name: String| {
                let shown = run::shown(&self.0.0.join(&out).join(&name));
                (format!("{kind}/{name}"), shown)
            };
            all.extend(run::names(&self.0.0.join(&out)).into_iter().map(read));
        }
        assert_eq!(all.len(), 11 * count, "a picture and ten layers a frame");
        all
    }
}

/// Names of the files in which two runs differ.
fn differing(a: &[(String, Vec<u8>)], b: &[(String, Vec<u8>)]) -> Vec<String> {
    assert_eq!(a.len(), b.len());
    a.iter().zip(b).filter(|(a, b)| a != b).map(|(a, _)| a.0.clone()).collect()
}

fn none() -> Vec<String> {
    Vec::new()
}

#[test]
fn triangles_may_run_either_way_and_both() {
    if !has_device() {
        return;
    }
    let (stage, shape) = (Stage::new(), ring(1.0));
    // One that stays, one that is mirrored in the shot and flat in a frame of it, and one that begins mirrored.
    let scales = [[1.0; 6], [1.0, 0.6, 0.2, 0.0, -0.4, -0.9], [-1.0, -1.0, -0.5, 0.5, 1.0, 1.0]];
    for (number, scales) in scales.into_iter().enumerate() {
        let positions = poses(&shape.points, scales);
        let render = |name: &str, triangles: Vec<[u32; 3]>| {
            let name = format!("{name}{number}");
            stage.cache(&name, &positions, &triangles);
            let images = if scales == [1.0; 6] { STEADY } else { IMAGES };
            stage.render_frames(&format!("{name}.npz"), 1..=FRAMES as u32, images, &[])
        };
        let whole = render("counterclockwise", shape.triangles.clone());
        let pictures: Vec<_> = whole.iter().filter(|(name, _)| name.starts_with("drawn/000")).collect();
        assert!(pictures.len() == FRAMES && pictures.windows(2).all(|pair| pair[0].1 != pair[1].1), "all of them move");
        assert_eq!(differing(&render("clockwise", turned(&shape.triangles, |_| true)), &whole), none(), "{number}");
        assert_eq!(differing(&render("mixed", turned(&shape.triangles, mixed)), &whole), none(), "{number}");
    }
}

/// Pixels of a picture.
fn pixels(stage: &Stage, scene: &str, kind: &str, frame: u32) -> Vec<[f32; 4]> {
    let path = stage.0.0.join(format!("{scene}.{kind}/{frame:04}.exr"));
    celfx::io::picture::read(&path).expect("a picture").pixels
}

/// Share of pixels in which frames of two scenes differ by more than a tone's rounding.
fn share_of_differing(stage: &Stage, scenes: [&str; 2], frame: u32) -> f64 {
    let mut differing = 0;
    let kinds = if IMAGES.contains(&frame) { &["drawn", "images"][..] } else { &["drawn"] };
    for kind in kinds {
        let [a, b] = scenes.map(|scene| pixels(stage, scene, kind, frame));
        let off = |(a, b): (&[f32; 4], &[f32; 4])| a.iter().zip(b).any(|(a, b)| (a - b).abs() > 1e-3);
        differing += a.iter().zip(&b).filter(|pair| off(*pair)).count();
    }
    differing as f64 / f64::from(kinds.len() as u32 * SIZE[0] * SIZE[1])
}

/// Share of the picture that a triangle of the ring covers, about: the ring covers a third of it with half of its 400. What
/// was left out by mistake would be half of them.
const TRIANGLE: f64 = 1.0 / 3.0 / 200.0;

/// After the mirror a frame shows what it would with nothing left out, but for what is smeared over an outline: a surface
/// with a hole on its far side is drawn whole.
#[test]
fn nothing_is_missing_of_what_a_shot_turns_inside_out() {
    if !has_device() {
        return;
    }
    let (stage, shape) = (Stage::new(), ring(1.0));
    let positions = poses(&shape.points, [1.0, 0.6, 0.3, -0.3, -0.8, -1.0]);
    stage.cache("closed", &positions, &shape.triangles);
    // The lowest point of the ring's back is seen in no frame.
    let back = |i: &u32| shape.points[*i as usize][2];
    let far = (0..shape.triangles.len()).min_by(|a, b| {
        let depth = |t: &usize| shape.triangles[*t].iter().map(back).sum::<f32>();
        depth(a).total_cmp(&depth(b))
    });
    let mut open = shape.triangles.clone();
    open.remove(far.expect("triangles"));
    stage.cache("open", &positions, &open);
    for scene in ["closed.npz", "open.npz"] {
        stage.render(scene);
    }
    for frame in 2..=FRAMES as u32 {
        let share = share_of_differing(&stage, ["closed.npz", "open.npz"], frame);
        // Most where it passes through a plane: teeth of its back stand over the outline.
        assert!(share < 10.0 * TRIANGLE, "frame {frame}: {share}");
    }
}

/// The frames that are drawn, and options.
type View<'a> = (RangeInclusive<u32>, &'a [&'a str]);

/// A surface within another, which faces away from it or to it; and the eye within both.
#[test]
fn surfaces_within_others_may_run_either_way() {
    if !has_device() {
        return;
    }
    let stage = Stage::new();
    let (outer, inner) = (ring(1.0), ring(0.5));
    let points = [outer.points.clone(), inner.points.clone()].concat();
    let first = outer.points.len() as u32;
    let of_inner = inner.triangles.iter().map(|t| t.map(|point| point + first)).collect::<Vec<_>>();
    let triangles = [outer.triangles.clone(), of_inner].concat();
    let half = outer.triangles.len();
    let positions = poses(&points, [1.0; 6]);
    // What passes the eye so near would be divided for long, and in the other frames is.
    let within =
        ["--set", "camera.eye=[0, 0, 0.15]", "--set", "camera.target=[0, 1, 0.2]", "--set", "blur.tolerance=10000"];
    let within: View = (3..=5, &within);
    for (place, view) in [("beside", (1..=FRAMES as u32, &[][..])), ("within", within.clone())] {
        let cavity = |name: &str, is_turned: &dyn Fn(usize) -> bool| {
            let name = format!("{name}.{place}");
            stage.cache(&name, &positions, &turned(&triangles, is_turned));
            stage.render_frames(&format!("{name}.npz"), view.0.clone(), STEADY, view.1)
        };
        let solid = cavity("solid", &|_| false);
        assert_eq!(differing(&cavity("hollow", &|i| i >= half), &solid), none(), "{place}");
        assert_eq!(differing(&cavity("turned", &|_| true), &solid), none(), "{place}");
        assert_eq!(differing(&cavity("mixed", &mixed), &solid), none(), "{place}");
    }
    // From within, what has no inside to be told from the outside is seen: the same with a hole behind the eye.
    let mut open = triangles.clone();
    open.remove(0);
    stage.cache("open", &positions, &open);
    stage.render_frames("open.npz", within.0, STEADY, within.1);
    let share = share_of_differing(&stage, ["solid.within.npz", "open.npz"], 4);
    assert!(share < 4.0 * TRIANGLE, "{share}");
}

/// Nothing is left out of what has a border, whichever side it shows and whatever the file says of its material.
#[test]
fn open_surfaces_are_seen_from_both_sides() {
    if !has_device() {
        return;
    }
    let stage = Stage::new();
    let mut shape = ring(1.0);
    shape.triangles.retain(|[a, ..]| a / 10 % 10 < 7);
    let positions = poses(&shape.points, [1.0, 0.8, 0.5, -0.2, -0.5, -1.0]);
    for (name, triangles) in [
        ("counterclockwise", shape.triangles.clone()),
        ("clockwise", turned(&shape.triangles, |_| true)),
        ("mixed", turned(&shape.triangles, mixed)),
    ] {
        stage.cache(name, &positions, &triangles);
        stage.render(&format!("{name}.npz"));
    }
    for other in ["clockwise.npz", "mixed.npz"] {
        for frame in 1..=FRAMES as u32 {
            let share = share_of_differing(&stage, ["counterclockwise.npz", other], frame);
            assert!(share < TRIANGLE, "{other}, frame {frame}: {share}");
        }
    }
}

#[test]
fn mirrors_of_nodes_and_joints_turn_nothing_inside_out() {
    if !has_device() {
        return;
    }
    let (stage, shape) = (Stage::new(), ring(1.0));
    let points = shape.points.len();
    let mirrored = Shape { points: shape.points.iter().map(|[x, y, z]| [-x, *y, *z]).collect(), ..shape.clone() };
    let floats = |values: &[f32]| values.iter().flat_map(|v| v.to_le_bytes()).collect::<Vec<u8>>();
    let times = floats(&[0.0, 5.0]);
    let scalar = |count: usize| json!({"componentType": 5126, "count": count, "type": "SCALAR"});
    let vector = |count: usize| json!({"componentType": 5126, "count": count, "type": "VEC3"});
    let channel = |node: u32, path: &str, sampler: u32| {
        let channels = json!([{"sampler": sampler, "target": {"node": node, "path": path}}]);
        json!([{"channels": channels, "samplers": [{"input": 3, "output": 4}]}])
    };
    let shift = floats(&[-0.3, 0.0, 0.0, 0.5, 0.1, 0.0]);
    let moving = [("times", &times[..], scalar(2)), ("values", &shift[..], vector(2))];
    let moves = json!({"animations": channel(0, "translation", 0)});
    let render = |name: &str| stage.render(&format!("{name}.gltf"));
    let render_steady = |name: &str| stage.render_steady(&format!("{name}.gltf"));

    // The mirror is baked, in the node that moves, or in a joint.
    stage.gltf("baked", &mirrored, &json!({}), &moves, &moving);
    let baked = render_steady("baked");
    let two_sided = |shape: &Shape, name: &str| {
        let mut root = moves.clone();
        root["materials"] = json!([{"doubleSided": true}]);
        stage.gltf(name, shape, &json!({"scale": [-1, 1, 1]}), &root, &moving);
    };
    stage.gltf("node", &shape, &json!({"scale": [-1, 1, 1]}), &moves, &moving);
    assert_eq!(differing(&render_steady("node"), &baked), none());
    let other_way = Shape { triangles: turned(&shape.triangles, mixed), ..shape.clone() };
    stage.gltf("mixed", &other_way, &json!({"scale": [-1, 1, 1]}), &moves, &moving);
    assert_eq!(differing(&render_steady("mixed"), &baked), none());
    two_sided(&shape, "two_sided");
    assert_eq!(differing(&render_steady("two_sided"), &baked), none());
    let (joints, weights) = (vec![0_u8; 4 * points], floats(&[1.0, 0.0, 0.0, 0.0].repeat(points)));
    let skin = json!({
        "animations": channel(1, "translation", 0), "skins": [{"joints": [1]}], "scenes": [{"nodes": [0, 1]}],
        "nodes": [{"mesh": 0, "skin": 0}, {"scale": [-1, 1, 1]}],
    });
    let followed = [
        moving[0].clone(),
        moving[1].clone(),
        ("JOINTS_0", &joints[..], json!({"componentType": 5121, "count": points, "type": "VEC4"})),
        ("WEIGHTS_0", &weights[..], json!({"componentType": 5126, "count": points, "type": "VEC4"})),
    ];
    stage.gltf("joint", &shape, &json!({}), &skin, &followed);
    assert_eq!(differing(&render_steady("joint"), &baked), none());

    // A scale goes through 0 in a frame (the third of six), or between two.
    for (name, from) in [("at", 1.0_f32), ("between", 1.4)] {
        let scales = floats(&[from, 1.0, 1.0, from - 2.5, 1.0, 1.0]);
        let scaling = [("times", &times[..], scalar(2)), ("values", &scales[..], vector(2))];
        let root = json!({"animations": channel(0, "scale", 0)});
        let (plain, other) = (format!("{name}.plain"), format!("{name}.clockwise"));
        stage.gltf(&plain, &shape, &json!({"translation": [0.2, 0, 0]}), &root, &scaling);
        let clockwise = Shape { triangles: turned(&shape.triangles, |_| true), ..shape.clone() };
        stage.gltf(&other, &clockwise, &json!({"translation": [0.2, 0, 0]}), &root, &scaling);
        assert_eq!(differing(&render(&other), &render(&plain)), none(), "{name}");
    }
}
