//! `EXT_mesh_gpu_instancing`: a node that shows its mesh several times.

use glam::{DAffine3, DQuat, DVec3};

use super::document::Document;
use crate::io::ReadError;

/// Where the instances of a node are in relation to it; none if it shows its mesh once.
pub(super) fn of_node(document: &Document, node: usize) -> Result<Option<Vec<DAffine3>>, ReadError> {
    let Some(instancing) = &document.root.nodes[node].extensions.instancing else { return Ok(None) };
    let accessor = |name: &str| instancing.attributes.get(name).copied();
    let Some(any) = instancing.attributes.values().next() else { return Ok(None) };
    let place = format!("node {node}, its instances");
    let accessors = &document.root.accessors;
    let count = document.entry(accessors, *any, "accessor")?.count.0;
    for (name, &index) in &instancing.attributes {
        let own = document.entry(accessors, index, "accessor")?.count.0;
        if own != count {
            let why = format!("has {own} values of {name} and {count} of another");
            return Err(document.fault(place, why, "as many of each"));
        }
    }
    document.budget.keep(&place, &format!("{count} instances"), count.saturating_mul(size_of::<DAffine3>() as u64))?;
    let translations = accessor("TRANSLATION").map(|index| document.values::<3>(index)).transpose()?;
    let rotations = accessor("ROTATION").map(|index| document.values::<4>(index)).transpose()?;
    let scales = accessor("SCALE").map(|index| document.values::<3>(index)).transpose()?;
    let instance = |i: usize| {
        let translation = translations.as_ref().map_or(DVec3::ZERO, |all| DVec3::from(all[i]));
        let rotation = rotations.as_ref().map_or(DQuat::IDENTITY, |all| DQuat::from_array(all[i]));
        let rotation = if rotation.length() > 0.0 { rotation.normalize() } else { DQuat::IDENTITY };
        let scale = scales.as_ref().map_or(DVec3::ONE, |all| DVec3::from(all[i]));
        DAffine3::from_scale_rotation_translation(scale, rotation, translation)
    };
    // Within the budget, so within memory.
    Ok(Some((0..count as usize).map(instance).collect()))
}
