//! The animations and the camera that are used of a glTF file.

use std::collections::HashSet;

use super::document::Document;
use super::json::Index;
use super::rig::{Lens, Node};
use super::track::Track;
use super::{Animation, Note};
use crate::io::ReadError;
use crate::view::Camera;

/// The least near plane of an orthographic camera, in metres.
const LEAST_NEAR: f64 = 1e-6;

/// One of a file's animations or cameras.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Pick {
    /// By its name, the first of that name; one without a name is called by its number.
    Name(String),
    /// By its number, from 0.
    Number(u32),
}

/// The animations and the camera that are used of a glTF file.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Choice {
    /// The animations that are played, all at once: of two that move the same, the later one does. None: the file's
    /// first. One called `*`, where the file has none of that name, is all of them.
    pub animations: Vec<Pick>,
    /// The camera of the scene; none: the first perspective one, or else the first.
    pub camera: Option<Pick>,
    /// Whether the first animation that moves the camera is played where none of `animations` does.
    pub for_camera: bool,
}

/// A camera in a file's scene.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct NamedCamera {
    /// Its node's name, else its own; that of an unnamed one is its number among the scene's, from 0.
    pub name: String,
    /// Others are orthographic.
    pub is_perspective: bool,
}

/// A camera in the scene, and its lens, if its file says one.
pub(super) struct Found {
    pub(super) camera: NamedCamera,
    /// The camera's own name beside its node's.
    own_name: Option<String>,
    pub(super) lens: Option<Lens>,
}

/// The number of what is picked of those called so.
fn find(document: &Document, kind: &str, pick: &Pick, names: &[&str]) -> Result<usize, ReadError> {
    let (found, why) = match pick {
        Pick::Name(name) => (names.iter().position(|other| other == name), format!("none is called `{name}`")),
        Pick::Number(number) => {
            let found = Some(*number as usize).filter(|number| *number < names.len());
            (found, format!("there is no number {number}"))
        }
    };
    found.ok_or_else(|| {
        let expected = match names {
            [] => format!("a file with {kind}; this one has none"),
            [only] => format!("`{only}` or 0, the only one"),
            _ => format!("one of `{}`, or a number from 0 to {}", names.join("`, `"), names.len() - 1),
        };
        document.fault(kind, why, expected)
    })
}

/// The numbers of the animations that are to be played.
pub(super) fn animations(
    document: &Document,
    all: &[Animation],
    picks: &[Pick],
    notes: &mut Vec<Note>,
) -> Result<Vec<usize>, ReadError> {
    if picks.is_empty() {
        return Ok((0..all.len().min(1)).collect());
    }
    let names: Vec<&str> = all.iter().map(|animation| &animation.name[..]).collect();
    let mut chosen = Vec::new();
    for pick in picks {
        if *pick == Pick::Name("*".into()) && !names.is_empty() && !names.contains(&"*") {
            chosen.extend(0..all.len());
            continue;
        }
        let number = find(document, "animations", pick, &names)?;
        let namesakes = names.iter().filter(|name| **name == names[number]).count();
        if matches!(pick, Pick::Name(_)) && namesakes > 1 {
            let name = names[number];
            notes.push(Note::new(format!("{namesakes} animations are called `{name}`: number {number} is played")));
        }
        chosen.push(number);
    }
    Ok(chosen)
}

/// The first animation that moves a node or what it hangs on, unless one of those `chosen` does.
pub(super) fn mover(document: &Document, nodes: &[Node], node: usize, chosen: &[usize]) -> Option<usize> {
    let chain: HashSet<usize> = std::iter::successors(Some(node), |node| nodes[*node].parent).collect();
    let all = &document.root.animations;
    let moves = |animation: &usize| {
        let targets = all[*animation].channels.iter().filter_map(|channel| channel.target.node);
        targets.map(Index::value).any(|target| chain.contains(&target))
    };
    let is_moved = chosen.iter().any(moves);
    if is_moved { None } else { (0..all.len()).find(moves) }
}

/// Notes that animations are in each other's way. `tracks` are those of each.
pub(super) fn note_overlap(tracks: &[Vec<Track>], notes: &mut Vec<Note>) {
    let mut moved = HashSet::new();
    let overlaps = tracks.iter().any(|tracks| {
        let own: HashSet<_> = tracks.iter().map(|track| (track.node, track.property)).collect();
        let overlaps = !own.is_disjoint(&moved);
        moved.extend(own);
        overlaps
    });
    if overlaps {
        notes.push(Note::new("some of the animations move the same: what the later one says is played".into()));
    }
}

/// The cameras of the scene, in the order of its nodes.
pub(super) fn cameras(document: &Document, shown: &[bool]) -> Result<Vec<Found>, ReadError> {
    let root = &document.root;
    let mut cameras = Vec::new();
    for (node, json) in root.nodes.iter().enumerate().filter(|(node, _)| shown[*node]) {
        let Some(camera) = json.camera else { continue };
        let camera = document.entry(&root.cameras, camera, "camera")?;
        let [name, own_name] = [&json.name, &camera.name].map(|name| name.clone().filter(|name| !name.is_empty()));
        let perspective = camera.perspective.as_ref().map(|lens| Lens {
            node,
            vertical_fov: f64::from(lens.yfov),
            orthographic: None,
            near: f64::from(lens.znear),
            far: lens.zfar.map_or(f64::INFINITY, f64::from),
        });
        let is_perspective = perspective.is_some();
        let orthographic = camera.orthographic.as_ref().map(|lens| Lens {
            node,
            vertical_fov: Camera::default().vertical_fov.to_radians(),
            orthographic: Some(2.0 * f64::from(lens.ymag)),
            // It may be at the eye.
            near: f64::from(lens.znear).max(LEAST_NEAR),
            far: f64::from(lens.zfar),
        });
        let lens = perspective.or(orthographic);
        let name = name.or_else(|| own_name.clone()).unwrap_or_else(|| cameras.len().to_string());
        cameras.push(Found { camera: NamedCamera { name, is_perspective }, own_name, lens });
    }
    Ok(cameras)
}

/// The number of the camera that is looked through: without a word on it the first perspective one, or else the first.
pub(super) fn camera(document: &Document, all: &[Found], pick: Option<&Pick>) -> Result<Option<usize>, ReadError> {
    let Some(pick) = pick else {
        let perspective = all.iter().position(|found| found.camera.is_perspective);
        return Ok(perspective.or(all.iter().position(|found| found.lens.is_some())));
    };
    let own = |found: &Found| matches!(pick, Pick::Name(name) if found.own_name.as_ref() == Some(name));
    let names: Vec<&str> = all.iter().map(|found| &found.camera.name[..]).collect();
    let number = find(document, "cameras", pick, &names).or_else(|e| all.iter().position(own).ok_or(e))?;
    match all[number].lens {
        Some(_) => Ok(Some(number)),
        None => {
            let name = &all[number].camera.name;
            let expected = "`perspective` or `orthographic`";
            Err(document.fault(format!("camera `{name}`"), "does not say what it sees", expected))
        }
    }
}
