//! The figure of `builtin:run`: its parts, and how each moves.

use std::f64::consts::{PI, TAU};

use glam::{DAffine3, DQuat, DVec3};

use super::Part;
use super::shapes::Shape;
use crate::view::Camera;

/// Objects that clusters may not cross: a limb is one object, though its parts have colours of their own.
pub(super) const OBJECTS: [&str; 6] = ["head", "body", "right arm", "left arm", "right leg", "left leg"];

/// Speed of the run in m/s.
pub(super) const SPEED: f64 = 3.2;
/// Share of the speed at which the camera follows.
const FOLLOWED: f64 = 0.6;
/// Where the figure is at 0 seconds, seen from the middle of the picture.
const START: f64 = -1.25;
/// Strides (two steps each) in a second.
pub(super) const STRIDES: f64 = 1.4;
/// Height of the hips at their mean, so that the lowest sole touches the ground.
const HIPS: f64 = 0.973;
/// Half of how far the hips rise and fall, twice a stride.
const BOB: f64 = 0.035;
/// How far the body leans forward, in radians.
const LEAN: f64 = 0.22;

/// Lengths in metres.
const THIGH: f64 = 0.43;
const SHANK: f64 = 0.41;
const UPPER_ARM: f64 = 0.28;
const FOREARM: f64 = 0.24;
/// Half of the distance between the hips, and between the shoulders.
const HIP: f64 = 0.095;
const SHOULDER: f64 = 0.215;
/// Height of the shoulders and of the head's centre above the hips.
const CHEST: f64 = 0.46;
const HEAD: f64 = 0.70;

/// The figure looks along +x; its right side is at +z.
const SIDES: [f64; 2] = [1.0, -1.0];

/// A rigid part. A limb's follow those of the right side (0) and the left (1).
enum Bone {
    Pelvis,
    Chest,
    Head,
    UpperArm,
    Forearm,
    Thigh,
    Shank,
    Foot,
}

impl Bone {
    /// Its number among the transforms.
    fn of(self, side: usize) -> usize {
        let limb = |number: usize| 3 + 5 * side + number;
        match self {
            Bone::Pelvis => 0,
            Bone::Chest => 1,
            Bone::Head => 2,
            Bone::UpperArm => limb(0),
            Bone::Forearm => limb(1),
            Bone::Thigh => limb(2),
            Bone::Shank => limb(3),
            Bone::Foot => limb(4),
        }
    }
}

/// A joint: what hangs on it turns about z, forward if positive.
fn joint(place: DVec3, forward: f64) -> DAffine3 {
    DAffine3::from_rotation_translation(DQuat::from_rotation_z(forward), place)
}

/// Where all bones are at a time, in the order of [`Bone::of`].
pub(super) fn transforms(seconds: f64) -> Vec<DAffine3> {
    let stride = TAU * (STRIDES * seconds).rem_euclid(1.0);
    let hips = DVec3::new(START + SPEED * seconds, HIPS - BOB * (2.0 * stride).cos(), 0.0);
    let turned = |place: DVec3, lean: f64, twist: f64| {
        joint(place, -lean) * DAffine3::from_quat(DQuat::from_rotation_y(twist * stride.sin()))
    };
    // The shoulders turn against the hips.
    let pelvis = turned(hips, 0.4 * LEAN, 0.18);
    let chest = turned(hips, LEAN, -0.30);
    let head = turned(hips, LEAN, 0.0) * joint(DVec3::Y * HEAD, 0.8 * LEAN);
    let mut bones = vec![pelvis, chest, head];
    for (side, z) in SIDES.into_iter().enumerate() {
        let phase = stride + PI * side as f64;
        let spread = DAffine3::from_quat(DQuat::from_rotation_x(-0.16 * z));
        let upper_arm = chest
            * joint(DVec3::new(0.0, CHEST, SHOULDER * z), LEAN)
            * spread
            * joint(DVec3::ZERO, -0.15 - 0.85 * phase.sin());
        let forearm = upper_arm * joint(DVec3::NEG_Y * UPPER_ARM, 1.45 - 0.35 * phase.sin());
        let thigh = pelvis * joint(DVec3::Z * HIP * z, 0.4 * LEAN + 0.22 + 0.78 * phase.sin());
        let shank = thigh * joint(DVec3::NEG_Y * THIGH, -0.30 - 1.65 * (0.5 + 0.5 * (phase + 0.45).cos()).powi(2));
        let foot = shank * joint(DVec3::NEG_Y * SHANK, 0.10 + 0.35 * phase.sin());
        bones.extend([upper_arm, forearm, thigh, shank, foot]);
    }
    bones
}

/// A camera beside the track, a little ahead of the figure's pace at first and then behind it.
pub(super) fn camera(seconds: f64) -> Camera {
    let target = DVec3::new(FOLLOWED * SPEED * seconds, 0.96, 0.0);
    Camera { eye: target + DVec3::new(0.9, 0.25, 4.4), target, vertical_fov: 32.0, ..Camera::default() }
}

/// The parts at rest, of triangles about `edge` metres long.
pub(super) fn parts(edge: f64) -> Vec<Part> {
    const SKIN: [f32; 3] = [0.78, 0.42, 0.26];
    const HAIR: [f32; 3] = [0.10, 0.04, 0.02];
    const SHIRT: [f32; 3] = [0.75, 0.06, 0.04];
    const SHORTS: [f32; 3] = [0.04, 0.09, 0.38];
    const TROUSERS: [[f32; 3]; 2] = [[0.05, 0.13, 0.48], [0.03, 0.07, 0.28]];
    const SOCKS: [[f32; 3]; 2] = [[0.80, 0.80, 0.76], [0.48, 0.50, 0.52]];
    const SHOES: [[f32; 3]; 2] = [[0.90, 0.52, 0.03], [0.55, 0.28, 0.02]];
    const SLEEVES: [[f32; 3]; 2] = [[0.85, 0.16, 0.08], [0.45, 0.03, 0.03]];
    const ARMS: [[f32; 3]; 2] = [[0.78, 0.42, 0.26], [0.48, 0.24, 0.14]];

    let at = |shape: Shape, place: [f64; 3]| shape.moved(DAffine3::from_translation(DVec3::from(place)));
    let cuboid = |x: f64, y: f64, z: f64, colour| Shape::cuboid(DVec3::new(x, y, z), edge, colour);
    let mut parts = Vec::new();
    let mut add = |bone: usize, object: u32, shape: Shape| parts.push(Part { transform: bone, object, shape });
    add(Bone::Head.of(0), 0, Shape::ball(0.118, edge, SKIN));
    add(Bone::Head.of(0), 0, at(Shape::ball(0.122, edge, HAIR), [-0.022, 0.03, 0.0]));
    add(Bone::Head.of(0), 0, at(Shape::limb(0.05, 0.05, 0.10, edge, SKIN), [-0.01, -0.08, 0.0]));
    add(Bone::Chest.of(0), 1, at(cuboid(0.10, 0.20, 0.165, SHIRT), [0.0, 0.31, 0.0]));
    add(Bone::Pelvis.of(0), 1, at(cuboid(0.095, 0.11, 0.15, SHORTS), [0.0, 0.03, 0.0]));
    for side in 0..2 {
        let (arm, leg) = (2 + side as u32, 4 + side as u32);
        add(Bone::UpperArm.of(side), arm, Shape::limb(0.06, 0.047, UPPER_ARM, edge, SLEEVES[side]));
        add(Bone::Forearm.of(side), arm, Shape::limb(0.044, 0.034, FOREARM, edge, ARMS[side]));
        add(Bone::Forearm.of(side), arm, at(Shape::ball(0.052, edge, ARMS[side]), [0.0, -FOREARM - 0.04, 0.0]));
        add(Bone::Thigh.of(side), leg, Shape::limb(0.088, 0.062, THIGH, edge, TROUSERS[side]));
        add(Bone::Shank.of(side), leg, Shape::limb(0.058, 0.042, SHANK, edge, SOCKS[side]));
        add(Bone::Foot.of(side), leg, at(cuboid(0.125, 0.038, 0.048, SHOES[side]), [0.065, -0.03, 0.0]));
    }
    parts
}
