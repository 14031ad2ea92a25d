//! What a compiled shader says of itself: workgroup size, bindings, and the blocks that the host fills.

use std::collections::BTreeMap;

use spirq::ty::{AccessType, DescriptorType, ScalarType, SpirvType, StructType, Type};
use spirq::{ReflectConfig, entry_point::EntryPoint, spirv, var::Variable};

/// The most bytes of push constants that every device has.
const PUSH_CONSTANT_BYTES: usize = 128;

/// Structures that host and shaders share, by name.
pub type Blocks = BTreeMap<String, Block>;

/// A structure as it lies in memory.
#[derive(Clone, PartialEq)]
pub struct Block {
    pub members: Vec<Member>,
    /// Bytes.
    pub size: usize,
    /// The feature without which nothing uses it.
    pub feature: Option<&'static str>,
}

/// A member of a [`Block`].
#[derive(Clone, PartialEq)]
pub struct Member {
    pub name: String,
    /// Its type in Rust.
    pub rust: String,
    /// Bytes from the block's start.
    pub offset: usize,
    /// Bytes.
    pub size: usize,
}

#[derive(Default)]
pub struct Reflection {
    pub local_size: [u32; 3],
    pub push_size: usize,
    /// binding -> (name, kind, access)
    pub bindings: BTreeMap<u32, (String, &'static str, &'static str)>,
    pub blocks: Blocks,
}

pub fn reflect(words: &[u32]) -> Result<Reflection, String> {
    let entries = ReflectConfig::new().spv(words).ref_all_rscs(true).reflect().map_err(|e| format!("{e:?}"))?;
    let entry = entries.first().ok_or("no entry point")?;
    let mut reflection = Reflection { local_size: local_size(entry), ..Reflection::default() };
    for variable in &entry.vars {
        match variable {
            Variable::Descriptor { name, desc_bind, desc_ty, ty, .. } => {
                let name = block_name(ty).or(name.clone()).ok_or("a binding without a name")?;
                if desc_bind.set() != 0 {
                    return Err(format!("{name}: only descriptor set 0 is used"));
                }
                let (kind, access) = descriptor(desc_ty).ok_or(format!("{name}: unsupported {desc_ty:?}"))?;
                let whole = matches!(desc_ty, DescriptorType::UniformBuffer());
                collect(ty, whole, &mut reflection.blocks)?;
                let binding = (name.clone(), kind, access);
                if let Some(other) = reflection.bindings.insert(desc_bind.bind(), binding) {
                    return Err(format!("{name} and {} share binding {}", other.0, desc_bind.bind()));
                }
            }
            Variable::PushConstant { ty, .. } => {
                reflection.push_size = ty.nbyte().ok_or("push constants without a size")?;
                if reflection.push_size > PUSH_CONSTANT_BYTES {
                    let (bytes, most) = (reflection.push_size, PUSH_CONSTANT_BYTES);
                    return Err(format!("{bytes} bytes of push constants; {most} are guaranteed"));
                }
                collect(ty, true, &mut reflection.blocks)?;
            }
            _ => {}
        }
    }
    Ok(reflection)
}

fn local_size(entry: &EntryPoint) -> [u32; 3] {
    let mode = entry.exec_modes.iter().find(|m| m.exec_mode == spirv::ExecutionMode::LocalSize);
    let mut size = [1; 3];
    if let Some(mode) = mode {
        for (to, operand) in size.iter_mut().zip(&mode.operands) {
            let bytes = operand.value.to_typeless().unwrap_or_default();
            *to = bytes.first_chunk().map_or(1, |b| u32::from_le_bytes(*b));
        }
    }
    size
}

fn descriptor(kind: &DescriptorType) -> Option<(&'static str, &'static str)> {
    let access = |a: &AccessType| match a {
        AccessType::ReadOnly => "Read",
        AccessType::WriteOnly => "Write",
        AccessType::ReadWrite => "ReadWrite",
    };
    match kind {
        DescriptorType::StorageBuffer(a) => Some(("StorageBuffer", access(a))),
        DescriptorType::StorageImage(a) => Some(("StorageImage", access(a))),
        DescriptorType::UniformBuffer() => Some(("UniformBuffer", "Read")),
        DescriptorType::SampledImage() => Some(("SampledImage", "Read")),
        _ => None,
    }
}

/// A buffer goes by the name of its block, an image by its own.
fn block_name(ty: &Type) -> Option<String> {
    match ty {
        Type::Struct(s) => s.name.clone(),
        _ => None,
    }
}

/// Collects the structures inside `ty`; the outermost one only if the host fills it as a `whole`.
fn collect(ty: &Type, whole: bool, blocks: &mut Blocks) -> Result<(), String> {
    match ty {
        Type::Array(array) => collect(&array.element_ty, true, blocks),
        Type::Struct(structure) => {
            for member in &structure.members {
                collect(&member.ty, true, blocks)?;
            }
            if whole {
                let name = structure.name.clone().ok_or("a block without a name")?;
                let made = block(&name, structure, blocks)?;
                match blocks.get(&name) {
                    Some(other) if *other != made => return Err(format!("{name} is two different blocks")),
                    _ => blocks.insert(name, made),
                };
            }
            Ok(())
        }
        _ => Ok(()),
    }
}

fn block(name: &str, structure: &StructType, blocks: &Blocks) -> Result<Block, String> {
    let mut members = Vec::new();
    for member in &structure.members {
        let field = member.name.clone().ok_or(format!("{name}: a member without a name"))?;
        let offset = member.offset.ok_or(format!("{name}.{field}: no offset"))?;
        let (rust, size) = rust_type(&member.ty, blocks).map_err(|why| format!("{name}.{field}: {why}"))?;
        members.push(Member { name: field, rust, offset, size });
    }
    Ok(Block { members, size: structure.nbyte().ok_or(format!("{name}: no size"))?, feature: None })
}

/// What a member is in Rust, and how many bytes that has.
fn rust_type(ty: &Type, blocks: &Blocks) -> Result<(String, usize), String> {
    match ty {
        Type::Scalar(scalar) => Ok((rust_scalar(scalar)?.to_owned(), 4)),
        Type::Vector(vector) if vector.nscalar == 3 => Err("no vec3 in shared blocks (its padding differs)".to_owned()),
        Type::Vector(vector) => {
            let count = vector.nscalar;
            Ok((format!("[{}; {count}]", rust_scalar(&vector.scalar_ty)?), 4 * count as usize))
        }
        Type::Array(array) => {
            let (element, size) = rust_type(&array.element_ty, blocks)?;
            let count = array.nelement.ok_or("an array without a length")? as usize;
            if array.stride.is_some_and(|stride| stride != size) {
                return Err("its elements are padded; use vectors of four".to_owned());
            }
            Ok((format!("[{element}; {count}]"), count * size))
        }
        Type::Struct(structure) => {
            let name = structure.name.clone().ok_or("a structure without a name")?;
            let size = blocks.get(&name).ok_or(format!("{name}: unknown"))?.size;
            Ok((name, size))
        }
        other => Err(format!("{other:?} cannot be shared with the host")),
    }
}

fn rust_scalar(scalar: &ScalarType) -> Result<&'static str, String> {
    match scalar {
        ScalarType::Float { bits: 32 } => Ok("f32"),
        ScalarType::Integer { bits: 32, is_signed: true } => Ok("i32"),
        ScalarType::Integer { bits: 32, is_signed: false } => Ok("u32"),
        other => Err(format!("{other:?} cannot be shared with the host")),
    }
}
