//! Reading glTF 2.0: from a [`Document`] to a topology and a rig.

mod shape;

use std::collections::HashMap;
use std::path::Path;
use std::rc::Rc;

use glam::{DAffine3, DMat4, DQuat, DVec3};

use self::shape::Shape;
use super::choice::{self, Choice};
use super::colour::Colours;
use super::document::Document;
use super::instances;
use super::json::{KeyKind, Mesh, TargetPath};
use super::rig::{Local, Node, Part, Rig, Skin};
use super::track::{Interpolation, Property, Track};
use super::{Animation, Contents, MAX_VERTICES, Note};
use crate::data::Topology;
use crate::io::{ReadError, file};

/// The content of a file.
pub(super) struct Scene {
    pub(super) topology: Topology,
    pub(super) rig: Rig,
    pub(super) contents: Contents,
}

/// Reads a `.glb` or `.gltf` file, of which that is played and looked through.
pub(super) fn read(path: &Path, choice: &Choice) -> Result<Scene, ReadError> {
    let file = file::read(path, u64::MAX).map_err(|error| ReadError::file(path, error, "a file that can be read"))?;
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
    let (topology, shapes) = (Topology { faceted: true, ..Topology::default() }, HashMap::new());
    let mut builder = Builder { document: &document, topology, rig, start, colours, shapes, notes };
    for node in (0..shown.len()).filter(|&node| shown[node]) {
        builder.add_node(node)?;
    }
    let Builder { mut topology, rig, mut notes, colours, .. } = builder;
    let (textures, own) = colours.into_textures();
    topology.textures = textures;
    notes.extend(own);
    let cameras = cameras.into_iter().map(|found| found.camera).collect();
    Ok(Scene { topology, rig, contents: Contents { animations, playing, cameras, camera, notes } })
}

fn nodes(document: &Document) -> Result<Vec<Node>, ReadError> {
    let root = &document.root;
    let targets = |mesh: &Mesh| mesh.primitives.iter().filter_map(|p| Some(p.targets.as_ref()?.len())).max();
    let targets: Vec<usize> = root.meshes.iter().map(|mesh| targets(mesh).unwrap_or(0)).collect();
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
            Some(index) => {
                let mesh = document.entry(&root.meshes, index, "mesh")?;
                let targets = targets[index.value()];
                // Twice: they are copied for each pose.
                let bytes = 2 * targets * size_of::<f64>();
                document.budget.keep(&format!("node {number}"), &format!("{targets} weights"), bytes as u64)?;
                let given = node.weights.as_ref().or(mesh.weights.as_ref()).into_iter().flatten();
                let mut weights: Vec<f64> = given.take(targets).map(|&w| f64::from(w)).collect();
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
    // Its matrices are made for each pose.
    let bytes = 2 * skin.joints.len() * size_of::<DAffine3>();
    document.budget.keep(&format!("skin {number}"), &format!("{} joints", skin.joints.len()), bytes as u64)?;
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
            matrices.iter().take(joints.len()).map(|m| DAffine3::from_mat4(DMat4::from_cols_array(m))).collect()
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

/// Tracks of the animations of those numbers, those of a later one after those of an earlier one.
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
        let bytes = size_of::<f64>() * (times.len() + values.len());
        document.budget.keep(&place, "its keys", bytes as u64)?;
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
    /// The part of meshes that does not depend on the node, by mesh and skin.
    shapes: HashMap<(usize, Option<usize>), Rc<[Shape]>>,
    notes: Vec<Note>,
}

impl Builder<'_> {
    /// Adds the object of a node, if it has a mesh; one for each instance if it has those.
    fn add_node(&mut self, number: usize) -> Result<(), ReadError> {
        let document = self.document;
        let root = &document.root;
        let node = &root.nodes[number];
        let Some(index) = node.mesh else { return Ok(()) };
        let mesh = document.entry(&root.meshes, index, "mesh")?;
        if let Some(skin) = node.skin {
            document.entry(&root.skins, skin, "skin")?;
        }
        let shapes = self.shapes(index.value(), node.skin.map(|skin| skin.value()))?;
        let place = format!("node {number}");
        let name = node.name.as_ref().or(mesh.name.as_ref()).filter(|name| !name.is_empty()).unwrap_or(&place);
        let instances = match (instances::of_node(document, number)?, node.skin) {
            (Some(instances), None) => instances.into_iter().map(Some).collect(),
            (Some(_), Some(_)) => {
                self.notes.push(Note::new(format!("{place} has instances and a skin: it is drawn once")));
                vec![None]
            }
            (None, _) => vec![None],
        };
        for (i, instance) in instances.into_iter().enumerate() {
            let name = instance.map_or_else(|| name.clone(), |_| format!("{name} {i}"));
            document.budget.keep(&place, "its name", (name.len() + size_of::<String>()) as u64)?;
            self.topology.objects.push(name);
            self.topology.double_sided.push(false);
            shapes.iter().try_for_each(|shape| self.add_part(number, instance, shape))?;
        }
        Ok(())
    }

    /// Adds a primitive in a node to the last object.
    fn add_part(&mut self, node: usize, instance: Option<DAffine3>, shape: &Shape) -> Result<(), ReadError> {
        let document = self.document;
        let (count, first) = (shape.base.len(), self.topology.object.len());
        let place = format!("node {node}");
        if first + count > MAX_VERTICES {
            return Err(document.fault(
                place,
                "brings the vertices above the limit",
                format!("{MAX_VERTICES} at most"),
            ));
        }
        document.budget.keep(&place, &format!("{count} vertices"), shape.placed_bytes())?;
        document.budget.work(&place, &format!("poses of {count} vertices"), shape.pose_bytes())?;
        let start = instance.map_or(self.start[node], |instance| self.start[node] * instance);
        let is_mirrored = shape.influences.is_none() && start.matrix3.determinant() < 0.0;
        // A mirror turns triangles over.
        let turned = |[a, b, c]: [u32; 3]| if is_mirrored { [a, c, b] } else { [a, b, c] };
        let topology = &mut self.topology;
        // No more than MAX_VERTICES of all of these.
        let object = topology.objects.len() as u32 - 1;
        let triangles = shape.triangles.iter().map(|corners| turned(corners.map(|corner| corner + first as u32)));
        topology.triangles.extend(triangles);
        topology.object.resize(first + count, object);
        topology.colour.extend(&shape.colours);
        match &shape.shares {
            Some(shares) => topology.share.extend(shares),
            None => topology.share.resize(first + count, 1.0),
        }
        topology.normal.extend(&shape.normals);
        topology.has_coordinates |= shape.coordinates.is_some();
        match &shape.coordinates {
            Some(coordinates) => topology.coordinates.extend(coordinates),
            None => topology.coordinates.resize(first + count, [0.0; 2]),
        }
        let number = shape.texture.as_ref().map(|texture| texture.number);
        topology.texture.resize(first + count, number);
        match &shape.texture {
            Some(texture) => topology.texture_place.extend(&texture.places),
            None => topology.texture_place.resize(first + count, [0.0; 2]),
        }
        let known = topology.materials.iter().position(|name| *name == shape.material);
        let material = known.unwrap_or_else(|| {
            topology.materials.push(shape.material.clone());
            topology.materials.len() - 1
        });
        topology.material.resize(first + count, material as u32);
        topology.double_sided[object as usize] |= shape.is_double_sided;
        let Shape { base, morphs, influences, .. } = shape;
        let (base, morphs, influences) = (base.clone(), morphs.clone(), influences.clone());
        self.rig.parts.push(Part { node, instance, base, morphs, influences });
        Ok(())
    }

    /// The primitives of a mesh with a skin or without; read once, however many nodes have them.
    fn shapes(&mut self, mesh: usize, skin: Option<usize>) -> Result<Rc<[Shape]>, ReadError> {
        if let Some(shapes) = self.shapes.get(&(mesh, skin)) {
            return Ok(shapes.clone());
        }
        let mut shapes = Vec::new();
        for (primitive, json) in self.document.root.meshes[mesh].primitives.iter().enumerate() {
            shapes.extend(self.shape(skin, &format!("mesh {mesh}, primitive {primitive}"), json)?);
        }
        let shapes: Rc<[Shape]> = shapes.into();
        self.shapes.insert((mesh, skin), shapes.clone());
        Ok(shapes)
    }
}
