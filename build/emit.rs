//! The Rust text of a shader, of blocks and of constants.

use std::fmt::Write as _;

use super::reflect::{Block, Blocks, Reflection};
use super::source::{Comments, Constant};
use super::{Compiled, Feature, gate};

/// A shader as the module `module`.
pub fn shader(table: &mut String, file: &str, module: &str, Compiled { stage, reflection, .. }: &Compiled) {
    let Reflection { local_size, push_size, bindings, .. } = reflection;
    let _ = writeln!(table, "/// `glsl/{file}`.\npub mod {module} {{\nuse crate::plan::*;");
    // How many words there are depends on the compiler; the table does not.
    let bytes = format!("include_bytes!(\"{file}.spv\")");
    let _ = writeln!(table, "static WORDS: [u32; {bytes}.len() / 4] = bytemuck::must_cast(*{bytes});");
    let _ = writeln!(table, "/// SPIR-V and what it binds.\npub static SHADER: Shader = Shader {{");
    let _ = writeln!(table, "file: {file:?}, stage: Stage::{stage}, local_size: {local_size:?},");
    let _ = writeln!(table, "push_size: {push_size}, bindings: &[");
    for (name, ..) in bindings.values() {
        let _ = write!(table, "{},", upper_case(name));
    }
    let _ = writeln!(table, "], words: &WORDS }};");
    for (number, (name, kind, access)) in bindings {
        let constant = upper_case(name);
        let _ = writeln!(table, "/// `{name}`.\npub const {constant}: Binding = Binding {{");
        let _ = writeln!(
            table,
            "name: {name:?}, number: {number}, kind: DescriptorKind::{kind}, access: Access::{access} }};"
        );
    }
    table.push_str("}\n");
}

/// `LiveSpheres` and `live_spheres` become `LIVE_SPHERES`.
fn upper_case(name: &str) -> String {
    let mut out = String::new();
    let mut previous = '_';
    for c in name.chars() {
        if c.is_uppercase() && (previous.is_lowercase() || previous.is_ascii_digit()) {
            out.push('_');
        }
        out.extend(c.to_uppercase());
        previous = c;
    }
    out
}

/// Structures with the members, offsets and sizes of blocks, documented as the shaders document them.
/// `shared` names those that are declared for all folders.
pub fn blocks(table: &mut String, blocks: &Blocks, shared: &[(String, Feature)], comments: &Comments) {
    table.push_str("/// Structures that host and shaders share.\npub mod blocks {\nuse bytemuck::{Pod, Zeroable};\n");
    for (name, feature) in shared {
        let _ = writeln!(table, "{}pub use crate::shaders::shared::blocks::{name};", gate(*feature));
    }
    for (name, Block { members, size, feature }) in blocks {
        let comment = |member: &str| comments.get(&(name.clone(), member.to_owned())).filter(|text| !text.is_empty());
        let doc = |member: &str, shown: &str| match comment(member) {
            Some(text) => format!("#[doc = {text:?}]"),
            None => format!("/// `{shown}`."),
        };
        let derived = "#[repr(C)]\n#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]";
        table.push_str(gate(*feature));
        let _ = writeln!(table, "{}\n{derived}\npub struct {name} {{", doc("", name));
        let mut end = 0;
        for member in members {
            pad(table, end, member.offset);
            let _ = writeln!(table, "{}\npub {}: {},", doc(&member.name, &member.name), member.name, member.rust);
            end = member.offset + member.size;
        }
        pad(table, end, *size);
        table.push_str("}\n");
        table.push_str(gate(*feature));
        let _ = writeln!(table, "const _: () = {{\nassert!(size_of::<{name}>() == {size});");
        for member in members {
            let _ = writeln!(table, "assert!(core::mem::offset_of!({name}, {}) == {});", member.name, member.offset);
        }
        table.push_str("};\n");
    }
    table.push_str("}\n");
}

fn pad(table: &mut String, from: usize, to: usize) {
    if to > from {
        let _ = writeln!(table, "/// Unused.\npub padding_{from}: [u32; {}],", (to - from) / 4);
    }
}

/// Constants of GLSL files as those of Rust.
pub fn constants(table: &mut String, constants: &[Constant]) {
    table.push_str("/// Constants that host and shaders share.\npub mod constants {\n");
    for Constant { name, rust, value, comment, feature } in constants {
        table.push_str(gate(*feature));
        let doc = if comment.is_empty() { format!("`{name}`.") } else { comment.clone() };
        let _ = writeln!(table, "#[doc = {doc:?}]\npub const {name}: {rust} = {value};");
    }
    table.push_str("}\n");
}
