//! Poses of a glTF scene at any time: node hierarchy, skins, morph targets (glTF 2.0, sections 3.5, 3.7 and 3.11).
//!
//! All arithmetic is in f64 and a vertex is rounded once.

use std::sync::Arc;

use glam::{DAffine3, DMat3, DQuat, DVec3};

use super::track::{Property, Track};
use super::weld::{self, Welder};
use crate::view::Camera;

/// Where a node is in relation to its parent.
#[derive(Clone, Copy, Debug)]
pub(super) enum Local {
    Matrix(DAffine3),
    Parts { translation: DVec3, rotation: DQuat, scale: DVec3 },
}

impl Local {
    fn affine(self) -> DAffine3 {
        match self {
            Local::Matrix(matrix) => matrix,
            Local::Parts { translation, rotation, scale } => {
                DAffine3::from_scale_rotation_translation(scale, rotation, translation)
            }
        }
    }

    /// Replaces a property by an animated value.
    fn set(&mut self, property: Property, value: &[f64]) {
        if let Local::Matrix(matrix) = *self {
            let (scale, rotation, translation) = matrix.to_scale_rotation_translation();
            *self = Local::Parts { translation, rotation, scale };
        }
        let Local::Parts { translation, rotation, scale } = self else { return };
        match (property, value) {
            (Property::Translation, &[x, y, z]) => *translation = DVec3::new(x, y, z),
            (Property::Rotation, &[x, y, z, w]) => *rotation = DQuat::from_xyzw(x, y, z, w),
            (Property::Scale, &[x, y, z]) => *scale = DVec3::new(x, y, z),
            _ => {}
        }
    }
}

/// A node of the hierarchy.
#[derive(Clone, Debug)]
pub(super) struct Node {
    pub(super) parent: Option<usize>,
    /// Without animation.
    pub(super) rest: Local,
    /// Of the morph targets of its mesh, without animation.
    pub(super) weights: Vec<f64>,
}

/// A skin: its joints' nodes, and what takes a vertex of the mesh into each joint's space.
#[derive(Clone, Debug)]
pub(super) struct Skin {
    pub(super) joints: Vec<usize>,
    pub(super) inverse_bind: Vec<DAffine3>,
}

/// Joints that a vertex follows: `per` each, with weights that add up to 1.
#[derive(Clone, Debug)]
pub(super) struct Influences {
    pub(super) skin: usize,
    pub(super) per: usize,
    pub(super) joints: Vec<u32>,
    pub(super) weights: Vec<f64>,
}

/// Vertices of one primitive in one node. Nodes and instances of one mesh share what does not depend on them.
#[derive(Clone, Debug)]
pub(super) struct Part {
    pub(super) node: usize,
    /// Where it is in relation to the node, if it is an instance.
    pub(super) instance: Option<DAffine3>,
    pub(super) base: Arc<Vec<[f32; 3]>>,
    /// Displacements at a weight of 1, one list per morph target; empty where a target moves nothing.
    pub(super) morphs: Arc<Vec<Vec<[f32; 3]>>>,
    /// None: the vertices follow the node.
    pub(super) influences: Option<Arc<Influences>>,
}

/// A camera in a node.
#[derive(Clone, Copy, Debug)]
pub(super) struct Lens {
    pub(super) node: usize,
    /// Radians.
    pub(super) vertical_fov: f64,
    /// Metres.
    pub(super) orthographic: Option<f64>,
    pub(super) near: f64,
    pub(super) far: f64,
}

/// A scene that can be posed. Every index in it is valid.
#[derive(Clone, Debug, Default)]
pub(super) struct Rig {
    pub(super) nodes: Vec<Node>,
    /// The nodes, each after its parent.
    pub(super) order: Vec<usize>,
    pub(super) tracks: Vec<Track>,
    pub(super) skins: Vec<Skin>,
    pub(super) parts: Vec<Part>,
    pub(super) lens: Option<Lens>,
}

/// The nodes at one time.
pub(super) struct Skeleton {
    pub(super) global: Vec<DAffine3>,
    weights: Vec<Vec<f64>>,
}

impl Rig {
    /// Where all nodes are.
    pub(super) fn skeleton(&self, seconds: f64) -> Skeleton {
        let mut local: Vec<Local> = self.nodes.iter().map(|node| node.rest).collect();
        let mut weights: Vec<Vec<f64>> = self.nodes.iter().map(|node| node.weights.clone()).collect();
        let mut value = Vec::new();
        for track in &self.tracks {
            value.clear();
            value.resize(track.width, 0.0);
            track.sample(seconds, &mut value);
            match track.property {
                Property::Weights => weights[track.node].clone_from(&value),
                _ => local[track.node].set(track.property, &value),
            }
        }
        let mut global = vec![DAffine3::IDENTITY; self.nodes.len()];
        for &node in &self.order {
            let above = self.nodes[node].parent.map_or(DAffine3::IDENTITY, |parent| global[parent]);
            global[node] = above * local[node].affine();
        }
        Skeleton { global, weights }
    }

    /// World positions of all vertices, part by part.
    pub(super) fn positions(&self, seconds: f64, out: &mut [[f32; 3]]) {
        let skeleton = self.skeleton(seconds);
        let joints: Vec<Vec<DAffine3>> = self.skins.iter().map(|skin| skin.matrices(&skeleton)).collect();
        let mut rest = out;
        for part in &self.parts {
            let (out, after) = rest.split_at_mut(part.base.len().min(rest.len()));
            part.pose(&skeleton, &joints, out);
            rest = after;
        }
    }

    /// Takes vertices apart that something can move apart: those that follow other nodes or joints, or the same ones by other
    /// shares, and those of other places or displacements. Morph targets whose weight is always 0 move nothing.
    pub(super) fn weld(&self, welder: &mut Welder) {
        let parts = || self.parts.iter().enumerate();
        let rows: Vec<(usize, usize)> =
            parts().flat_map(|(part, Part { base, .. })| (0..base.len()).map(move |row| (part, row))).collect();
        let of = |vertex: usize| (&self.parts[rows[vertex].0], rows[vertex].1);
        welder.split(|vertex| {
            let (part, row) = of(vertex);
            weld::place(part.base[row])
        });
        welder.split(|vertex| {
            let (part, row) = of(vertex);
            (part.node, part.influences.as_ref().map(|influences| influences.key(row)))
        });
        let moving = self.moving_targets();
        let moves = |part: &Part, target: usize| {
            moving[part.node].get(target) == Some(&true)
                && part.morphs.get(target).is_some_and(|morph| !morph.is_empty())
        };
        for target in 0..self.parts.iter().map(|part| part.morphs.len()).max().unwrap_or(0) {
            if self.parts.iter().any(|part| moves(part, target)) {
                welder.split(|vertex| {
                    let (part, row) = of(vertex);
                    if moves(part, target) { weld::place(part.morphs[target][row]) } else { [0; 3] }
                });
            }
        }
    }

    /// Whether the weight of each morph target of each node is ever another than 0.
    fn moving_targets(&self) -> Vec<Vec<bool>> {
        let rest = |node: &Node| node.weights.iter().map(|weight| *weight != 0.0).collect();
        let mut moving: Vec<Vec<bool>> = self.nodes.iter().map(rest).collect();
        for track in self.tracks.iter().filter(|track| track.property == Property::Weights && track.width > 0) {
            for row in track.values.chunks_exact(track.width) {
                moving[track.node].iter_mut().zip(row).for_each(|(moves, value)| *moves |= *value != 0.0);
            }
        }
        moving
    }

    /// The file's camera, if it has one.
    pub(super) fn camera(&self, seconds: f64) -> Option<Camera> {
        let lens = self.lens?;
        let node = self.skeleton(seconds).global[lens.node];
        // A camera looks along -z; its own scale does not matter.
        let eye = node.translation;
        Some(Camera {
            eye,
            target: eye - node.matrix3.z_axis.normalize_or_zero(),
            up: node.matrix3.y_axis.normalize_or_zero(),
            vertical_fov: lens.vertical_fov.to_degrees(),
            orthographic: lens.orthographic,
            near: lens.near,
            far: lens.far,
            ..Camera::default()
        })
    }
}

impl Skin {
    fn matrices(&self, skeleton: &Skeleton) -> Vec<DAffine3> {
        self.joints.iter().zip(&self.inverse_bind).map(|(&node, bind)| skeleton.global[node] * *bind).collect()
    }
}

impl Part {
    fn pose(&self, skeleton: &Skeleton, joints: &[Vec<DAffine3>], out: &mut [[f32; 3]]) {
        let weights = &skeleton.weights[self.node];
        let active: Vec<(f64, &[[f32; 3]])> = weights
            .iter()
            .zip(&self.morphs[..])
            .filter(|(weight, morph)| **weight != 0.0 && !morph.is_empty())
            .map(|(weight, morph)| (*weight, &morph[..]))
            .collect();
        let morphed = |vertex: usize| {
            let base = wide(self.base[vertex]);
            active.iter().fold(base, |sum, (weight, morph)| sum + *weight * wide(morph[vertex]))
        };
        let node = skeleton.global[self.node];
        let node = self.instance.map_or(node, |instance| node * instance);
        for (vertex, out) in out.iter_mut().enumerate() {
            let transform = match &self.influences {
                None => node,
                Some(influences) => influences.blend(&joints[influences.skin], vertex),
            };
            *out = transform.transform_point3(morphed(vertex)).as_vec3().to_array();
        }
    }
}

impl Influences {
    /// Bytes of a joint of a vertex.
    pub(super) const BYTES: usize = size_of::<u32>() + size_of::<f64>();

    /// Tells vertices apart that do not follow the same joints by the same shares. In whatever order the file has them.
    fn key(&self, vertex: usize) -> (usize, Vec<(u32, u64)>) {
        let range = vertex * self.per..(vertex + 1) * self.per;
        let all = self.joints[range.clone()].iter().zip(&self.weights[range]);
        let mut followed: Vec<(u32, u64)> =
            all.filter(|(_, weight)| **weight != 0.0).map(|(joint, weight)| (*joint, weight.to_bits())).collect();
        followed.sort_unstable();
        (self.skin, followed)
    }

    /// The weighted mean of the matrices of a vertex's joints.
    fn blend(&self, joints: &[DAffine3], vertex: usize) -> DAffine3 {
        let range = vertex * self.per..(vertex + 1) * self.per;
        let mut sum = DAffine3 { matrix3: DMat3::ZERO, translation: DVec3::ZERO };
        for (&joint, &weight) in self.joints[range.clone()].iter().zip(&self.weights[range]) {
            if weight != 0.0 {
                let matrix = joints[joint as usize];
                sum.matrix3 += matrix.matrix3 * weight;
                sum.translation += matrix.translation * weight;
            }
        }
        sum
    }
}

fn wide(p: [f32; 3]) -> DVec3 {
    DVec3::from(p.map(f64::from))
}
