//! Reading glTF 2.0: from a [`Document`] to a topology and a rig.

use std::fs;
use std::path::Path;

use super::choice::{self, Choice};
use super::colour::Colours;
use super::document::Document;
use super::json::{KeyKind, Mode, Primitive, TargetPath};
use super::rig::{Influences, Local, Node, Part, Rig, Skin};
use super::track::{Interpolation, Property, Track};
use super::{Animation, Contents, MAX_VERTICES, Note, Topology};
use crate::io::ReadError;
use glam::{DAffine3, DMat4, DQuat, DVec3};

/// What a file holds.
pub(super) struct Scene {
    pub(super) topology: Topology,
    pub(super) rig: Rig,
    pub(super) contents: Contents,
}

/// Reads a `.glb` or `.gltf` file, of which that is played and looked through.
pub(super) fn read(path: &Path, choice: &Choice) -> Result<Scene, ReadError> {
    let file = fs::read(path).map_err(|error| ReadError::file(path, error, "a file that can be read"))?;
    parse(path, &file, choice)
}

/// [`read`] with the file in memory; others that it names are found by its path.
pub(super) fn parse(path: &Path, file: &[u8], choice: &Choice) -> Result<Scene, ReadError> {
    let document = Document::new(path, file)?;
    let nodes = nodes(&document)?;
    let order = parents_first(&document, &nodes)?;
    let mut rig = Rig { nodes, order, ..Rig::default() };
    for number in 0..document.root.skins.len() {
        rig.skins.push(skin(&document, number)?);
    }
    let shown = shown(&document, &rig.nodes)?;
    let cameras = choice::cameras(&document, &shown)?;
    let camera = choice::camera(&document, &cameras, choice.camera.as_ref())?;
    rig.lens = camera.and_then(|camera| cameras[camera].lens);
    let animations = animations(&document)?;
    let mut notes = document.notes.clone();
    let mut playing = choice::animations(&document, &animations, &choice.animations, &mut notes)?;
    if let Some(lens) = rig.lens.filter(|_| choice.for_camera)
        && let Some(own) = choice::mover(&document, &rig.nodes, lens.node, &playing)
    {
        playing = vec![own];
    }
    rig.tracks = all_tracks(&document, &playing, &rig, &mut notes)?;
    let start = rig.skeleton(f64::NEG_INFINITY).global;
    let colours = Colours::new(&document);
    let topology = Topology { faceted: true, ..Topology::default() };
    let mut builder = Builder { document: &document, topology, rig, start, colours, notes };
    for node in (0..shown.len()).filter(|&node| shown[node]) {
        builder.add_node(node)?;
    }
    let Builder { topology, rig, mut notes, colours, .. } = builder;
    notes.extend(colours.into_notes());
    let cameras = cameras.into_iter().map(|found| found.camera).collect();
    Ok(Scene { topology, rig, contents: Contents { animations, playing, cameras, camera, notes } })
}

fn nodes(document: &Document) -> Result<Vec<Node>, ReadError> {
    let root = &document.root;
    let mut nodes = Vec::with_capacity(root.nodes.len());
    for (number, node) in root.nodes.iter().enumerate() {
        let rest = match node.matrix {
            Some(matrix) => Local::Matrix(DAffine3::from_mat4(DMat4::from_cols_array(&matrix.map(f64::from)))),
            None => {
                let vector = |v: [f32; 3]| DVec3::from(v.map(f64::from));
                let rotation = node.rotation.map_or(DQuat::IDENTITY, |q| DQuat::from_array(q.map(f64::from)));
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

/// What the animations of those numbers move, those of a later one after those of an earlier one.
fn all_tracks(
    document: &Document,
    playing: &[usize],
    rig: &Rig,
    notes: &mut Vec<Note>,
) -> Result<Vec<Track>, ReadError> {
    let tracks: Result<Vec<_>, _> = playing.iter().map(|number| tracks(document, *number, rig, notes)).collect();
    let tracks = tracks?;
    choice::note_overlap(&tracks, notes);
    Ok(tracks.into_iter().flatten().collect())
}

fn tracks(document: &Document, number: usize, rig: &Rig, notes: &mut Vec<Note>) -> Result<Vec<Track>, ReadError> {
    let animation = &document.root.animations[number];
    let mut tracks = Vec::new();
    let mut passed_over = 0;
    for (channel, json) in animation.channels.iter().enumerate() {
        let place = format!("animation {number}, channel {channel}");
        // Without a node an extension says what is moved, or nobody.
        let Some(node) = json.target.node.filter(|_| json.target.path != TargetPath::Other) else {
            passed_over += 1;
            continue;
        };
        let sampler = document.entry(&animation.samplers, json.sampler, "animation sampler")?;
        document.entry(&document.root.nodes, node, "node")?;
        let node = node.value();
        let (property, width) = match json.target.path {
            TargetPath::Translation => (Property::Translation, 3),
            TargetPath::Rotation => (Property::Rotation, 4),
            TargetPath::Scale => (Property::Scale, 3),
            TargetPath::Weights | TargetPath::Other => (Property::Weights, rig.nodes[node].weights.len()),
        };
        let (interpolation, rows) = match sampler.interpolation {
            KeyKind::Step => (Interpolation::Step, 1),
            KeyKind::Linear => (Interpolation::Linear, 1),
            KeyKind::CubicSpline => (Interpolation::CubicSpline, 3),
            KeyKind::Other => {
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
    if passed_over > 0 {
        let channels = animation.channels.len();
        let which = format!("animation {number}: {passed_over} of {channels} channels move no property of a node");
        notes.push(Note::new(format!("{which}: they are not played")));
    }
    Ok(tracks)
}

/// Gathers the vertices and triangles of the scene.
struct Builder<'d> {
    document: &'d Document<'d>,
    topology: Topology,
    rig: Rig,
    /// Where the nodes are before the first key.
    start: Vec<DAffine3>,
    colours: Colours<'d>,
    notes: Vec<Note>,
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
            mode @ (Mode::Triangles | Mode::TriangleStrip | Mode::TriangleFan) => mode,
            Mode::PointsOrLines => {
                self.notes.push(Note::new(format!("{place} is of points or lines: it is not drawn")));
                return Ok(());
            }
            Mode::Other => return Err(document.fault(place, "has an unknown mode", "0 to 6")),
        };
        let Some(positions) = primitive.attribute("POSITION") else {
            self.notes.push(Note::new(format!("{place} has no positions: it is not drawn")));
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
        let mut triangles = triangles(document, place, primitive, mode, count, &mut self.notes)?;
        let influences = self.influences(node, place, primitive, count)?;
        if influences.is_none() && self.start[node].matrix3.determinant() < 0.0 {
            // A mirror turns triangles over.
            triangles.iter_mut().for_each(|corners| corners.swap(1, 2));
        }
        let morphs = morphs(document, place, primitive, count)?;
        let colours = self.colours.of_vertices(primitive, count)?;
        let normals = match primitive.attribute("NORMAL") {
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
        &mut self,
        node: usize,
        place: &str,
        primitive: &Primitive,
        count: usize,
    ) -> Result<Option<Influences>, ReadError> {
        let document = self.document;
        let Some(skin) = document.root.nodes[node].skin.map(|skin| skin.value()) else { return Ok(None) };
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
