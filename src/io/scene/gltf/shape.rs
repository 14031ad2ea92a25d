//! Primitives of meshes: the vertices and triangles of a [`Shape`], before any node has it.

use std::sync::Arc;

use super::Builder;
use crate::io::ReadError;
use crate::io::scene::Note;
use crate::io::scene::colour::Textured;
use crate::io::scene::document::Document;
use crate::io::scene::json::{Mode, Primitive};
use crate::io::scene::rig::{Influences, Part};

/// A primitive of a mesh with a skin or without.
pub(super) struct Shape {
    pub(super) base: Arc<Vec<[f32; 3]>>,
    pub(super) morphs: Arc<Vec<Vec<[f32; 3]>>>,
    pub(super) influences: Option<Arc<Influences>>,
    pub(super) triangles: Vec<[u32; 3]>,
    pub(super) colours: Vec<[f32; 3]>,
    /// Shares of strength, if it says some.
    pub(super) shares: Option<Vec<f32>>,
    /// The texture, and where vertices are in it.
    pub(super) texture: Option<Textured>,
    /// TEXCOORD_0, if it has such.
    pub(super) coordinates: Option<Vec<[f32; 2]>>,
    /// Name of its material.
    pub(super) material: String,
    pub(super) normals: Vec<[f32; 3]>,
    pub(super) is_double_sided: bool,
}

impl Builder<'_> {
    /// A primitive; none if it is not drawn.
    pub(super) fn shape(
        &mut self,
        skin: Option<usize>,
        place: &str,
        primitive: &Primitive,
    ) -> Result<Option<Shape>, ReadError> {
        let document = self.document;
        let mode = match primitive.mode {
            mode @ (Mode::Triangles | Mode::TriangleStrip | Mode::TriangleFan) => mode,
            Mode::PointsOrLines => {
                self.notes.push(Note::new(format!("{place} is of points or lines: it is not drawn")));
                return Ok(None);
            }
            Mode::Other => return Err(document.fault(place, "has an unknown mode", "0 to 6")),
        };
        let Some(positions) = primitive.attribute("POSITION") else {
            self.notes.push(Note::new(format!("{place} has no positions: it is not drawn")));
            return Ok(None);
        };
        let base = narrow(document.values::<3>(positions)?);
        let count = base.len();
        let triangles = triangles(document, place, primitive, mode, count, &mut self.notes)?;
        let influences = self.influences(skin, place, primitive, count)?;
        let morphs = morphs(document, place, primitive, count)?;
        let colours = self.colours.of_vertices(primitive, count)?;
        let normals = match primitive.attribute("NORMAL") {
            Some(accessor) => sized(document, place, "normals", narrow(document.values::<3>(accessor)?), count)?,
            None => vec![[0.0; 3]; count],
        };
        let texture = self.colours.texture(primitive, count)?;
        let shares = self.shares(place, primitive, count)?;
        let coordinates = match primitive.attribute("TEXCOORD_0") {
            Some(accessor) => {
                let values = sized(document, place, "texture coordinates", document.values::<2>(accessor)?, count)?;
                Some(values.into_iter().map(|uv| uv.map(|x| x as f32)).collect())
            }
            None => None,
        };
        let material = self.colours.material_name(primitive)?;
        let is_double_sided = self.colours.is_double_sided(primitive)?;
        let (base, morphs, influences) = (Arc::new(base), Arc::new(morphs), influences.map(Arc::new));
        let shape = Shape {
            base,
            morphs,
            influences,
            triangles,
            colours,
            shares,
            texture,
            coordinates,
            material,
            normals,
            is_double_sided,
        };
        document.budget.keep(place, &format!("{count} vertices"), shape.bytes())?;
        Ok(Some(shape))
    }

    /// How much of strength the vertices have.
    fn shares(&self, place: &str, primitive: &Primitive, count: usize) -> Result<Option<Vec<f32>>, ReadError> {
        let document = self.document;
        let Some(accessor) = primitive.attribute("_SMEAR") else { return Ok(None) };
        let shares = sized(document, place, "values of _SMEAR", document.values::<1>(accessor)?, count)?;
        match shares.iter().position(|[share]| !(0.0..=1.0).contains(share)) {
            Some(vertex) => {
                let why = format!("vertex {vertex} has _SMEAR {}", shares[vertex][0]);
                Err(document.fault(place, why, "a share of strength, 0 to 1"))
            }
            None => Ok(Some(shares.into_iter().map(|[share]| share as f32).collect())),
        }
    }

    /// Joints that the vertices follow; none where they follow the node.
    fn influences(
        &mut self,
        skin: Option<usize>,
        place: &str,
        primitive: &Primitive,
        count: usize,
    ) -> Result<Option<Influences>, ReadError> {
        let document = self.document;
        let Some(skin) = skin else { return Ok(None) };
        let mut sets: Vec<(Vec<u32>, Vec<f64>)> = Vec::new();
        while let Some(joints) = primitive.attribute(&format!("JOINTS_{}", sets.len())) {
            let Some(weights) = primitive.attribute(&format!("WEIGHTS_{}", sets.len())) else {
                return Err(document.fault(place, format!("has JOINTS_{0} but no WEIGHTS_{0}", sets.len()), "both"));
            };
            let joints = sized(document, place, "joints", document.values::<4>(joints)?, count)?;
            let weights = sized(document, place, "weights", document.values::<4>(weights)?, count)?;
            let joints = joints.into_flattened().into_iter().map(|joint| joint as u32).collect();
            sets.push((joints, weights.into_flattened()));
        }
        if sets.is_empty() {
            return Ok(None);
        }
        let per = 4 * sets.len();
        let mut influences = Influences { skin, per, joints: Vec::new(), weights: Vec::new() };
        let known = self.rig.skins[skin].joints.len() as u32;
        let mut loose = 0;
        for vertex in 0..count {
            let own = 4 * vertex..4 * vertex + 4;
            let slots =
                || sets.iter().flat_map(|(joints, weights)| joints[own.clone()].iter().zip(&weights[own.clone()]));
            let sum: f64 = slots().map(|(_, weight)| weight).sum();
            // What follows nothing follows its first joint.
            let is_loose = slots().all(|(_, weight)| *weight == 0.0);
            loose += usize::from(is_loose);
            if !is_loose && (sum.is_nan() || sum <= 0.0) {
                let why = format!("vertex {vertex} has weights that add up to {sum}");
                return Err(document.fault(place, why, "weights that add up to 1"));
            }
            for (slot, (&joint, &weight)) in slots().enumerate() {
                let share = if is_loose { f64::from(u8::from(slot == 0)) } else { weight / sum };
                if share != 0.0 && joint >= known {
                    let why = format!("vertex {vertex} follows joint {joint}");
                    return Err(document.fault(place, why, format!("a joint below {known}")));
                }
                influences.joints.push(if share != 0.0 { joint } else { 0 });
                influences.weights.push(share);
            }
        }
        if loose > 0 {
            let which = format!("{place}: {loose} of {count} vertices have no weights");
            self.notes.push(Note::new(format!("{which}: they follow their first joint")));
        }
        Ok(Some(influences))
    }
}

impl Shape {
    /// Its memory in bytes, but for its morph targets.
    pub(super) fn bytes(&self) -> u64 {
        let sets = usize::from(self.coordinates.is_some()) + usize::from(self.texture.is_some());
        let coordinates = sets * size_of::<[f32; 2]>();
        let vertex = 3 * size_of::<[f32; 3]>()
            + self.shares.as_ref().map_or(0, |_| size_of::<f32>())
            + coordinates
            + self.influences.as_ref().map_or(0, |i| i.per * Influences::BYTES);
        size_of::<Shape>() as u64 + (self.base.len() * vertex) as u64 + size_of_val(&self.triangles[..]) as u64
    }

    /// The memory that it takes again in each node, in bytes.
    pub(super) fn placed_bytes(&self) -> u64 {
        let vertex =
            3 * size_of::<u32>() + size_of::<Option<u32>>() + 2 * size_of::<[f32; 2]>() + 2 * size_of::<[f32; 3]>();
        size_of::<Part>() as u64 + (self.base.len() * vertex) as u64 + size_of_val(&self.triangles[..]) as u64
    }

    /// Bytes that are read for a pose.
    pub(super) fn pose_bytes(&self) -> u64 {
        let morphs = self.morphs.iter().filter(|morph| !morph.is_empty()).count();
        let vertex = (1 + morphs) * size_of::<[f32; 3]>();
        let vertex = vertex + self.influences.as_ref().map_or(0, |i| i.per * Influences::BYTES);
        self.base.len() as u64 * vertex as u64
    }
}

fn narrow(values: Vec<[f64; 3]>) -> Vec<[f32; 3]> {
    values.into_iter().map(|v| v.map(|x| x as f32)).collect()
}

/// Refuses an attribute that is not of all vertices.
fn sized<T>(document: &Document, place: &str, what: &str, values: Vec<T>, count: usize) -> Result<Vec<T>, ReadError> {
    match values.len() == count {
        true => Ok(values),
        false => Err(document.fault(place, format!("has {} {what}", values.len()), format!("{count}, one a vertex"))),
    }
}

/// The displacements of each morph target.
fn morphs(
    document: &Document,
    place: &str,
    primitive: &Primitive,
    count: usize,
) -> Result<Vec<Vec<[f32; 3]>>, ReadError> {
    let mut morphs = Vec::new();
    for target in primitive.targets.iter().flatten() {
        let Some(accessor) = target.positions else {
            morphs.push(Vec::new());
            continue;
        };
        // Exporters write targets that move nothing without data.
        let moved = match document.zeros(accessor)? {
            Some(zeros) if zeros == count as u64 => Vec::new(),
            _ => sized(document, place, "displacements", narrow(document.values::<3>(accessor)?), count)?,
        };
        let moves = moved.iter().any(|v| *v != [0.0; 3]);
        document.budget.keep(place, "a morph target", if moves { size_of_val(&moved[..]) as u64 } else { 0 })?;
        morphs.push(if moves { moved } else { Vec::new() });
    }
    Ok(morphs)
}

/// The corners of a primitive's triangles; strips and fans are taken apart.
fn triangles(
    document: &Document,
    place: &str,
    primitive: &Primitive,
    mode: Mode,
    count: usize,
    notes: &mut Vec<Note>,
) -> Result<Vec<[u32; 3]>, ReadError> {
    let corners: Vec<u32> = match primitive.indices {
        Some(accessor) => document.indices(accessor)?,
        None => (0..count as u32).collect(),
    };
    if let Some(at) = corners.iter().position(|&corner| corner as usize >= count) {
        let why = format!("index {at} is vertex {}", corners[at]);
        return Err(document.fault(place, why, format!("a vertex below {count}")));
    }
    Ok(match mode {
        Mode::TriangleStrip => {
            let strip = corners.windows(3).enumerate();
            // Every other one is the other way round.
            strip.map(|(i, c)| if i % 2 == 0 { [c[0], c[1], c[2]] } else { [c[0], c[2], c[1]] }).collect()
        }
        Mode::TriangleFan => {
            let Some((&hub, rim)) = corners.split_first() else { return Ok(Vec::new()) };
            rim.windows(2).map(|c| [c[0], c[1], hub]).collect()
        }
        _ => {
            let (triangles, rest) = corners.as_chunks();
            if !rest.is_empty() {
                let (last, all) = (rest.len(), corners.len());
                notes.push(Note::new(format!("{place}: the last {last} of {all} indices fill no triangle")));
            }
            triangles.to_vec()
        }
    })
}
