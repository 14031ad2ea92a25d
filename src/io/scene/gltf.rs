//! Reading glTF 2.0: from a [`Document`] to a topology and a rig.

use std::collections::HashMap;
use std::path::Path;
use std::rc::Rc;
use std::sync::Arc;

use glam::{DAffine3, DMat4, DQuat, DVec3};

use super::choice::{self, Choice};
use super::colour::{Colours, Textured};
use super::document::Document;
use super::instances;
use super::json::{KeyKind, Mesh, Mode, Primitive, TargetPath};
use super::rig::{Influences, Local, Node, Part, Rig, Skin};
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

/// A primitive of a mesh with a skin or without.
struct Shape {
    base: Arc<Vec<[f32; 3]>>,
    morphs: Arc<Vec<Vec<[f32; 3]>>>,
    influences: Option<Arc<Influences>>,
    triangles: Vec<[u32; 3]>,
    colours: Vec<[f32; 3]>,
    /// Shares of strength, if it says some.
    shares: Option<Vec<f32>>,
    /// The texture, and where vertices are in it.
    texture: Option<Textured>,
    /// TEXCOORD_0, if it has such.
    coordinates: Option<Vec<[f32; 2]>>,
    /// Name of its material.
    material: String,
    normals: Vec<[f32; 3]>,
    is_double_sided: bool,
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

    /// A primitive; none if it is not drawn.
    fn shape(&mut self, skin: Option<usize>, place: &str, primitive: &Primitive) -> Result<Option<Shape>, ReadError> {
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
    fn bytes(&self) -> u64 {
        let sets = usize::from(self.coordinates.is_some()) + usize::from(self.texture.is_some());
        let coordinates = sets * size_of::<[f32; 2]>();
        let vertex = 3 * size_of::<[f32; 3]>()
            + self.shares.as_ref().map_or(0, |_| size_of::<f32>())
            + coordinates
            + self.influences.as_ref().map_or(0, |i| i.per * Influences::BYTES);
        size_of::<Shape>() as u64 + (self.base.len() * vertex) as u64 + size_of_val(&self.triangles[..]) as u64
    }

    /// The memory that it takes again in each node, in bytes.
    fn placed_bytes(&self) -> u64 {
        let vertex =
            3 * size_of::<u32>() + size_of::<Option<u32>>() + 2 * size_of::<[f32; 2]>() + 2 * size_of::<[f32; 3]>();
        size_of::<Part>() as u64 + (self.base.len() * vertex) as u64 + size_of_val(&self.triangles[..]) as u64
    }

    /// Bytes that are read for a pose.
    fn pose_bytes(&self) -> u64 {
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
