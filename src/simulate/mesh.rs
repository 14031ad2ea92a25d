//! Animated meshes in closed form: rigid parts, each of which is where a function of time puts it.
//!
//! So the truth between frames is known, to any precision and at any time.

mod runner;
mod shapes;

#[cfg(test)]
mod tests;

use std::f64::consts::TAU;

use glam::{DAffine3, DQuat, DVec3};

use self::shapes::Shape;
use crate::data::Topology;
use crate::view::Camera;

/// Meshes that the program makes itself. All stand on y = 0 or above it, about the origin.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Builtin {
    /// A figure of boxes and capsules that runs along +x, overtaking a camera that follows more slowly.
    Run,
    /// A rotor of bars that turns about the view axis.
    Spin,
    /// Two upright bars that pass each other, one behind the other.
    Crossing,
}

/// Turns of [`Builtin::Spin`] in a second, counter-clockwise as its camera sees it.
pub const SPIN_TURNS: f64 = 0.6;
/// Speed of each bar of [`Builtin::Crossing`] in m/s: the front one (object 0) towards +x, the other against it.
pub const CROSSING_SPEED: f64 = 1.2;
/// When the bars of [`Builtin::Crossing`] are both at x = 0, in seconds.
pub const CROSSING_TIME: f64 = 1.0;

/// Centre of the rotor and of the bars.
const CENTRE: DVec3 = DVec3::new(0.0, 1.0, 0.0);
/// Bars of the rotor.
const BLADES: u32 = 8;
/// Distance of the bars that cross from the plane between them, in metres.
const APART: f64 = 0.4;

/// Most vertices that may be asked for.
const MAX_VERTICES: u32 = 1 << 22;

impl Builtin {
    /// The mesh of that name (without `builtin:`).
    pub fn named(name: &str) -> Option<Builtin> {
        [Builtin::Run, Builtin::Spin, Builtin::Crossing].into_iter().find(|which| which.name() == name)
    }

    /// Its name.
    pub fn name(self) -> &'static str {
        match self {
            Builtin::Run => "run",
            Builtin::Spin => "spin",
            Builtin::Crossing => "crossing",
        }
    }

    /// The frame rate that it is made for: what moves fast moves some 20 to 60 of 1080 pixels a frame.
    pub fn fps(self) -> f64 {
        24.0
    }

    /// How many frames of [`Builtin::fps`] there is something to see, from 0 seconds on.
    pub fn frames(self) -> u32 {
        48
    }

    /// How many vertices it has unless otherwise asked for.
    pub fn usual_vertices(self) -> u32 {
        match self {
            Builtin::Run => 10_000,
            Builtin::Spin | Builtin::Crossing => 4_000,
        }
    }

    /// Where its parts are at a time.
    fn transforms(self, seconds: f64) -> Vec<DAffine3> {
        match self {
            Builtin::Run => runner::transforms(seconds),
            Builtin::Spin => {
                let turn = DQuat::from_rotation_z(TAU * (SPIN_TURNS * seconds).rem_euclid(1.0));
                vec![DAffine3::from_rotation_translation(turn, CENTRE)]
            }
            Builtin::Crossing => {
                let x = CROSSING_SPEED * (seconds - CROSSING_TIME);
                let place = |side: f64| DAffine3::from_translation(CENTRE + DVec3::new(side * x, 0.0, side * APART));
                vec![place(1.0), place(-1.0)]
            }
        }
    }

    /// Its parts at rest, of triangles about `edge` metres long.
    fn parts(self, edge: f64) -> Vec<Part> {
        match self {
            Builtin::Run => runner::parts(edge),
            Builtin::Spin => rotor(edge),
            Builtin::Crossing => bars(edge),
        }
    }

    fn objects(self) -> &'static [&'static str] {
        match self {
            Builtin::Run => &runner::OBJECTS,
            Builtin::Spin => &["rotor"],
            Builtin::Crossing => &["front", "rear"],
        }
    }
}

/// A part at rest: which transform it follows and which object it is of.
struct Part {
    transform: usize,
    object: u32,
    shape: Shape,
}

/// A mesh that can be posed.
#[derive(Clone, Debug)]
pub struct Model {
    which: Builtin,
    /// Transform and vertices at rest of each part.
    parts: Vec<(usize, Vec<DVec3>)>,
}

impl Model {
    /// Makes one of as nearly `vertices` vertices as its triangles allow (1 to 4,194,304; simple ones have a least
    /// number), and what of it does not change.
    pub fn new(which: Builtin, vertices: u32) -> (Model, Topology) {
        let wanted = f64::from(vertices.clamp(1, MAX_VERTICES));
        let count = |parts: &[Part]| parts.iter().map(|part| part.shape.positions.len()).sum::<usize>() as f64;
        let off = |parts: &[Part]| (count(parts) / wanted).ln().abs();
        // The number goes with the inverse square of the edge, but for rounding.
        let mut edge = 0.1;
        let mut best = which.parts(edge);
        let mut last = count(&best);
        for _ in 0..8 {
            edge = (edge * (last / wanted).sqrt()).clamp(1e-4, 10.0);
            let parts = which.parts(edge);
            last = count(&parts);
            if off(&parts) < off(&best) {
                best = parts;
            }
        }
        assemble(which, best)
    }

    /// World positions in metres at a time, one per vertex of `out`.
    pub fn positions(&self, seconds: f64, out: &mut [[f32; 3]]) {
        let transforms = self.which.transforms(seconds);
        let placed = self.parts.iter().flat_map(|(transform, rest)| {
            let transform = transforms[*transform];
            rest.iter().map(move |p| transform.transform_point3(*p))
        });
        out.iter_mut().zip(placed).for_each(|(out, p)| *out = p.as_vec3().to_array());
    }

    /// The transform that each vertex follows, and where it is at rest.
    pub fn rest(&self) -> Vec<(usize, [f32; 3])> {
        let parts = self.parts.iter();
        parts.flat_map(|(transform, rest)| rest.iter().map(|p| (*transform, p.as_vec3().to_array()))).collect()
    }

    /// The camera that it is made for.
    pub fn camera(&self, seconds: f64) -> Camera {
        match self.which {
            Builtin::Run => runner::camera(seconds),
            Builtin::Spin | Builtin::Crossing => {
                Camera { eye: CENTRE + DVec3::Z * 4.0, target: CENTRE, vertical_fov: 35.0, ..Camera::default() }
            }
        }
    }
}

fn assemble(which: Builtin, parts: Vec<Part>) -> (Model, Topology) {
    let mut topology = Topology {
        objects: which.objects().iter().map(ToString::to_string).collect(),
        double_sided: vec![false; which.objects().len()],
        ..Topology::default()
    };
    let mut model = Model { which, parts: Vec::new() };
    for Part { transform, object, shape } in parts {
        let first = topology.object.len() as u32;
        topology.triangles.extend(shape.triangles.iter().map(|corners| corners.map(|corner| first + corner)));
        topology.object.resize(topology.object.len() + shape.positions.len(), object);
        topology.colour.extend(&shape.colours);
        topology.normal.extend(shape.normals.iter().map(|n| n.as_vec3().to_array()));
        model.parts.push((transform, shape.positions));
    }
    let vertices = topology.object.len();
    (topology.share, topology.coordinates) = (vec![1.0; vertices], vec![[0.0; 2]; vertices]);
    // What has one colour is of one material.
    let mut colours: Vec<[f32; 3]> = Vec::new();
    for colour in &topology.colour {
        let known = colours.iter().position(|other| other == colour);
        topology.material.push(known.unwrap_or(colours.len()) as u32);
        if known.is_none() {
            colours.push(*colour);
        }
    }
    topology.materials = (1..=colours.len()).map(|number| format!("colour {number}")).collect();
    (topology.texture, topology.texture_place) = (vec![None; vertices], vec![[0.0; 2]; vertices]);
    (model, topology)
}

/// A hub and bars about the z axis.
fn rotor(edge: f64) -> Vec<Part> {
    const COLOURS: [[f32; 3]; 2] = [[0.80, 0.10, 0.06], [0.85, 0.65, 0.15]];
    let hub = Shape::cylinder(0.14, 0.16, edge, [0.06, 0.09, 0.16]);
    let hub = hub.moved(DAffine3::from_quat(DQuat::from_rotation_x(TAU / 4.0)));
    let blades = (0..BLADES).map(|blade| {
        let turn = DQuat::from_rotation_z(TAU * f64::from(blade) / f64::from(BLADES));
        let bar = Shape::cuboid(DVec3::new(0.43, 0.07, 0.03), edge, COLOURS[blade as usize % 2]);
        bar.moved(DAffine3::from_rotation_translation(turn, turn * DVec3::X * 0.55))
    });
    std::iter::once(hub).chain(blades).map(|shape| Part { transform: 0, object: 0, shape }).collect()
}

/// Two rounded bars of two colours each.
fn bars(edge: f64) -> Vec<Part> {
    const COLOURS: [[[f32; 3]; 2]; 2] =
        [[[0.85, 0.25, 0.05], [0.90, 0.78, 0.55]], [[0.02, 0.30, 0.30], [0.03, 0.06, 0.25]]];
    let bar = |object: usize| {
        let shape = Shape::banded_capsule(0.22, 1.2, 6, edge, COLOURS[object]);
        Part { transform: object, object: object as u32, shape }
    };
    vec![bar(0), bar(1)]
}
