//! Reading glTF 2.0: from a [`Document`] to a topology and a rig.

use std::fs;
use std::path::Path;

use glam::{DAffine3, DMat4, DQuat, DVec3};
use gltf_json::Index;
use gltf_json::animation::{Interpolation as KeyKind, Property as Target};
use gltf_json::mesh::{Mode, Primitive, Semantic};
use gltf_json::validation::Checked;

use super::colour::Colours;
use super::document::Document;
use super::rig::{Influences, Lens, Local, Node, Part, Rig, Skin};
use super::track::{Interpolation, Property, Track};
use super::{Animation, MAX_VERTICES, Topology};
use crate::io::ReadError;

/// What a file holds.
pub(super) struct Scene {
    pub(super) topology: Topology,
    pub(super) rig: Rig,
    pub(super) animations: Vec<Animation>,
    /// What of the file was passed over.
    pub(super) notes: Vec<String>,
}

/// Reads a `.glb` or `.gltf` file; `animation` by its name, or the first.
pub(super) fn read(path: &Path, animation: Option<&str>) -> Result<Scene, ReadError> {
    let file = fs::read(path).map_err(|error| ReadError::file(path, error, "a file that can be read"))?;
    parse(path, &file, animation)
}

/// [`read`] with the file in memory; others that it names are found by its path.
pub(super) fn parse(path: &Path, file: &[u8], animation: Option<&str>) -> Result<Scene, ReadError> {
    let document = Document::new(path, file)?;
    let nodes = nodes(&document)?;
    let order = parents_first(&document, &nodes)?;
    let mut rig = Rig { nodes, order, ..Rig::default() };
    for number in 0..document.root.skins.len() {
        rig.skins.push(skin(&document, number)?);
    }
    let animations = animations(&document)?;
    let mut notes = Vec::new();
    if let Some(chosen) = choose(&document, &animations, animation)? {
        rig.tracks = tracks(&document, chosen, &rig, &mut notes)?;
    }
    let shown = shown(&document, &rig.nodes)?;
    rig.lens = lens(&document, &shown, &mut notes)?;
    let start = rig.skeleton(f64::NEG_INFINITY).global;
    let colours = Colours::new(&document);
    let mut builder = Builder { document: &document, topology: Topology::default(), rig, start, colours, notes };
    for node in (0..shown.len()).filter(|&node| shown[node]) {
        builder.add_node(node)?;
    }
    let Builder { topology, rig, mut notes, colours, .. } = builder;
    notes.extend(colours.into_notes());
    Ok(Scene { topology, rig, animations, notes })
}

fn nodes(document: &Document) -> Result<Vec<Node>, ReadError> {
    let root = &document.root;
    let mut nodes = Vec::with_capacity(root.nodes.len());
    for (number, node) in root.nodes.iter().enumerate() {
        let rest = match node.matrix {
            Some(matrix) => Local::Matrix(DAffine3::from_mat4(DMat4::from_cols_array(&matrix.map(f64::from)))),
            None => {
                let vector = |v: [f32; 3]| DVec3::from(v.map(f64::from));
                let rotation = node.rotation.map_or(DQuat::IDENTITY, |q| DQuat::from_array(q.0.map(f64::from)));
                Local::Parts {
                    translation: node.translation.map_or(DVec3::ZERO, vector),
                    rotation: if rotation.length() > 0.0 { rotation.normalize() } else { DQuat::IDENTITY },
                    scale: node.scale.map_or(DVec3::ONE, vector),
                }
            }
        };
        let weights = match node.mesh {
            Some(mesh) => {
                let mesh = document.entry(&root.meshes, mesh, "mesh")?;
                let targets =
                    mesh.primitives.iter().filter_map(|p| p.targets.as_ref().map(Vec::len)).max().unwrap_or(0);
                let given = node.weights.as_ref().or(mesh.weights.as_ref());
                let mut weights: Vec<f64> = given.into_iter().flatten().map(|&w| f64::from(w)).collect();
                weights.resize(targets, 0.0);
                weights
            }
            None => Vec::new(),
        };
        if !rest_is_finite(rest) || !weights.iter().all(|w| w.is_finite()) {
            return Err(document.fault(format!("node {number}"), "is not finite", "finite numbers"));
        }
        nodes.push(Node { parent: None, rest, weights });
    }
    for (parent, node) in root.nodes.iter().enumerate() {
        for child in node.children.iter().flatten() {
            document.entry(&root.nodes, *child, "node")?;
            if nodes[child.value()].parent.replace(parent).is_some() {
                let place = format!("node {}", child.value());
                return Err(document.fault(place, "is the child of two nodes", "nodes that form trees"));
            }
        }
    }
    Ok(nodes)
}

fn rest_is_finite(rest: Local) -> bool {
    match rest {
        Local::Matrix(matrix) => matrix.is_finite(),
        Local::Parts { translation, rotation, scale } => {
            translation.is_finite() && rotation.is_finite() && scale.is_finite()
        }
    }
}

/// The nodes, each after its parent.
fn parents_first(document: &Document, nodes: &[Node]) -> Result<Vec<usize>, ReadError> {
    let mut order: Vec<usize> = (0..nodes.len()).filter(|&node| nodes[node].parent.is_none()).collect();
    let mut done = 0;
    while done < order.len() {
        let children = document.root.nodes[order[done]].children.iter().flatten();
        order.extend(children.map(|child| child.value()));
        done += 1;
    }
    match order.len() == nodes.len() {
        true => Ok(order),
        // What no root leads to goes round.
        false => Err(document.fault("nodes", "a node is its own ancestor", "nodes that form trees")),
    }
}

/// Which nodes are in the scene: the default one, else the first, else everything.
fn shown(document: &Document, nodes: &[Node]) -> Result<Vec<bool>, ReadError> {
    let root = &document.root;
    let scene = match root.scene {
        Some(scene) => Some(document.entry(&root.scenes, scene, "scene")?),
        None => root.scenes.first(),
    };
    let Some(scene) = scene else { return Ok(vec![true; nodes.len()]) };
    let mut shown = vec![false; nodes.len()];
    let mut open = scene.nodes.clone();
    while let Some(node) = open.pop() {
        let children = &document.entry(&root.nodes, node, "node")?.children;
        if !std::mem::replace(&mut shown[node.value()], true) {
            open.extend(children.iter().flatten());
        }
    }
    Ok(shown)
}

fn skin(document: &Document, number: usize) -> Result<Skin, ReadError> {
    let skin = &document.root.skins[number];
    let mut joints = Vec::with_capacity(skin.joints.len());
    for joint in &skin.joints {
        document.entry(&document.root.nodes, *joint, "node")?;
        joints.push(joint.value());
    }
    let inverse_bind = match skin.inverse_bind_matrices {
        None => vec![DAffine3::IDENTITY; joints.len()],
        Some(accessor) => {
            let matrices = document.values::<16>(accessor)?;
            if matrices.len() < joints.len() {
                let why = format!("has {} inverse bind matrices", matrices.len());
                return Err(document.fault(
                    format!("skin {number}"),
                    why,
                    format!("one for each of {} joints", joints.len()),
                ));
            }
            matrices.iter().map(|m| DAffine3::from_mat4(DMat4::from_cols_array(m))).collect()
        }
    };
    Ok(Skin { joints, inverse_bind })
}

/// The animations' names and lengths; one without a name is called by its number.
fn animations(document: &Document) -> Result<Vec<Animation>, ReadError> {
    let mut animations = Vec::new();
    for (number, animation) in document.root.animations.iter().enumerate() {
        let mut seconds = 0.0f64;
        for sampler in &animation.samplers {
            let times = document.values::<1>(sampler.input)?;
            seconds = times.last().map_or(seconds, |[time]| seconds.max(*time));
        }
        let name = animation.name.clone().filter(|name| !name.is_empty());
        animations.push(Animation { name: name.unwrap_or_else(|| number.to_string()), seconds });
    }
    Ok(animations)
}

/// The number of the animation to play: that of the name, or the first; none where the file has none.
fn choose(document: &Document, animations: &[Animation], name: Option<&str>) -> Result<Option<usize>, ReadError> {
    let Some(name) = name else { return Ok((!animations.is_empty()).then_some(0)) };
    let found = animations.iter().position(|animation| animation.name == name);
    if found.is_none() {
        let names: Vec<&str> = animations.iter().map(|animation| &animation.name[..]).collect();
        let expected = match names.is_empty() {
            true => "a file with animations; this one has none".to_owned(),
            false => format!("one of `{}`", names.join("`, `")),
        };
        return Err(document.fault("animations", format!("none is called `{name}`"), expected));
    }
    Ok(found)
}

fn tracks(document: &Document, number: usize, rig: &Rig, notes: &mut Vec<String>) -> Result<Vec<Track>, ReadError> {
    let animation = &document.root.animations[number];
    let mut tracks = Vec::new();
    for (channel, json) in animation.channels.iter().enumerate() {
        let place = format!("animation {number}, channel {channel}");
        let sampler = document.entry(&animation.samplers, json.sampler, "animation sampler")?;
        document.entry(&document.root.nodes, json.target.node, "node")?;
        let node = json.target.node.value();
        let (property, width) = match json.target.path {
            Checked::Valid(Target::Translation) => (Property::Translation, 3),
            Checked::Valid(Target::Rotation) => (Property::Rotation, 4),
            Checked::Valid(Target::Scale) => (Property::Scale, 3),
            Checked::Valid(Target::MorphTargetWeights) => (Property::Weights, rig.nodes[node].weights.len()),
            Checked::Invalid => {
                notes.push(format!("{place} moves something unknown: it is not played"));
                continue;
            }
        };
        let (interpolation, rows) = match sampler.interpolation {
            Checked::Valid(KeyKind::Step) => (Interpolation::Step, 1),
            Checked::Valid(KeyKind::Linear) => (Interpolation::Linear, 1),
            Checked::Valid(KeyKind::CubicSpline) => (Interpolation::CubicSpline, 3),
            Checked::Invalid => {
                let expected = "STEP, LINEAR or CUBICSPLINE";
                return Err(document.fault(place, "has an unknown interpolation", expected));
            }
        };
        let times: Vec<f64> = document.values::<1>(sampler.input)?.into_iter().flatten().collect();
        if times.is_empty() || !times.is_sorted() {
            return Err(document.fault(place, "has times that do not ascend, or none", "ascending times in seconds"));
        }
        let values: Vec<f64> = match property {
            Property::Translation | Property::Scale => document.values::<3>(sampler.output)?.into_flattened(),
            Property::Rotation => document.values::<4>(sampler.output)?.into_flattened(),
            Property::Weights => document.values::<1>(sampler.output)?.into_flattened(),
        };
        if values.len() != times.len() * rows * width {
            let why = format!("has {} numbers for {} keys", values.len(), times.len());
            return Err(document.fault(place, why, format!("{} for each key", rows * width)));
        }
        tracks.push(Track { node, property, interpolation, times, values, width });
    }
    Ok(tracks)
}

/// The first perspective camera of the scene.
fn lens(document: &Document, shown: &[bool], notes: &mut Vec<String>) -> Result<Option<Lens>, ReadError> {
    let root = &document.root;
    for (node, json) in root.nodes.iter().enumerate().filter(|(node, _)| shown[*node]) {
        let Some(camera) = json.camera else { continue };
        match &document.entry(&root.cameras, camera, "camera")?.perspective {
            Some(lens) => {
                let far = lens.zfar.map_or(f64::INFINITY, f64::from);
                let (vertical_fov, near) = (f64::from(lens.yfov), f64::from(lens.znear));
                return Ok(Some(Lens { node, vertical_fov, near, far }));
            }
            None => notes.push(format!("camera {} is orthographic: it is not used", camera.value())),
        }
    }
    Ok(None)
}

/// Gathers the vertices and triangles of the scene.
struct Builder<'d> {
    document: &'d Document<'d>,
    topology: Topology,
    rig: Rig,
    /// Where the nodes are before the first key.
    start: Vec<DAffine3>,
    colours: Colours<'d>,
    notes: Vec<String>,
}

impl Builder<'_> {
    /// Adds the object of a node, if it has a mesh.
    fn add_node(&mut self, number: usize) -> Result<(), ReadError> {
        let root = &self.document.root;
        let node = &root.nodes[number];
        let Some(index) = node.mesh else { return Ok(()) };
        let mesh = self.document.entry(&root.meshes, index, "mesh")?;
        if let Some(skin) = node.skin {
            self.document.entry(&root.skins, skin, "skin")?;
        }
        let name = node.name.clone().or_else(|| mesh.name.clone()).filter(|name| !name.is_empty());
        self.topology.objects.push(name.unwrap_or_else(|| format!("node {number}")));
        self.topology.double_sided.push(false);
        for (primitive, json) in mesh.primitives.iter().enumerate() {
            let place = format!("mesh {}, primitive {primitive}", index.value());
            self.add_primitive(number, &place, json)?;
        }
        Ok(())
    }

    fn add_primitive(&mut self, node: usize, place: &str, primitive: &Primitive) -> Result<(), ReadError> {
        let document = self.document;
        let mode = match primitive.mode {
            Checked::Valid(mode @ (Mode::Triangles | Mode::TriangleStrip | Mode::TriangleFan)) => mode,
            Checked::Valid(_) => {
                self.notes.push(format!("{place} is of points or lines: it is not drawn"));
                return Ok(());
            }
            Checked::Invalid => return Err(document.fault(place, "has an unknown mode", "0 to 6")),
        };
        let Some(positions) = attribute(primitive, Semantic::Positions) else {
            self.notes.push(format!("{place} has no positions: it is not drawn"));
            return Ok(());
        };
        let base = narrow(document.values::<3>(positions)?);
        let count = base.len();
        let first = self.topology.object.len();
        if first + count > MAX_VERTICES {
            return Err(document.fault(
                place,
                "brings the vertices above the limit",
                format!("{MAX_VERTICES} at most"),
            ));
        }
        let mut triangles = triangles(document, place, primitive, mode, count)?;
        let influences = self.influences(node, place, primitive, count)?;
        if influences.is_none() && self.start[node].matrix3.determinant() < 0.0 {
            // A mirror turns triangles over.
            triangles.iter_mut().for_each(|corners| corners.swap(1, 2));
        }
        let morphs = morphs(document, place, primitive, count)?;
        let colours = self.colours.of_vertices(primitive, count)?;
        let normals = match attribute(primitive, Semantic::Normals) {
            Some(accessor) => sized(document, place, "normals", narrow(document.values::<3>(accessor)?), count)?,
            None => vec![[0.0; 3]; count],
        };

        let topology = &mut self.topology;
        // No more than MAX_VERTICES of all of these.
        let object = topology.objects.len() as u32 - 1;
        topology.triangles.extend(triangles.into_iter().map(|corners| corners.map(|corner| corner + first as u32)));
        topology.object.resize(first + count, object);
        topology.colour.extend(colours);
        topology.normal.extend(normals);
        topology.double_sided[object as usize] |= self.colours.is_double_sided(primitive)?;
        self.rig.parts.push(Part { node, base, morphs, influences });
        Ok(())
    }

    /// What joints the vertices follow; none where they follow the node.
    fn influences(
        &self,
        node: usize,
        place: &str,
        primitive: &Primitive,
        count: usize,
    ) -> Result<Option<Influences>, ReadError> {
        let document = self.document;
        let Some(skin) = document.root.nodes[node].skin.map(|skin| skin.value()) else { return Ok(None) };
        let mut sets: Vec<(Vec<u32>, Vec<f64>)> = Vec::new();
        while let Some(joints) = attribute(primitive, Semantic::Joints(sets.len() as u32)) {
            let Some(weights) = attribute(primitive, Semantic::Weights(sets.len() as u32)) else {
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
        for vertex in 0..count {
            let own = 4 * vertex..4 * vertex + 4;
            let sum: f64 = sets.iter().flat_map(|(_, weights)| &weights[own.clone()]).sum();
            if sum.is_nan() || sum <= 0.0 {
                let why = format!("vertex {vertex} has weights that add up to {sum}");
                return Err(document.fault(place, why, "weights that add up to 1"));
            }
            for (joints, weights) in &sets {
                for (&joint, &weight) in joints[own.clone()].iter().zip(&weights[own.clone()]) {
                    if weight != 0.0 && joint >= known {
                        let why = format!("vertex {vertex} follows joint {joint}");
                        return Err(document.fault(place, why, format!("a joint below {known}")));
                    }
                    influences.joints.push(if weight != 0.0 { joint } else { 0 });
                    influences.weights.push(weight / sum);
                }
            }
        }
        Ok(Some(influences))
    }
}

/// The accessor of an attribute.
pub(super) fn attribute(primitive: &Primitive, semantic: Semantic) -> Option<Index<gltf_json::Accessor>> {
    primitive.attributes.get(&Checked::Valid(semantic)).copied()
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
        let moved = match target.positions {
            Some(accessor) => narrow(document.values::<3>(accessor)?),
            None => Vec::new(),
        };
        let moves = moved.iter().any(|v| *v != [0.0; 3]);
        let moved = if moved.is_empty() { moved } else { sized(document, place, "displacements", moved, count)? };
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
                return Err(document.fault(place, format!("has {} indices", corners.len()), "a multiple of three"));
            }
            triangles.to_vec()
        }
    })
}
