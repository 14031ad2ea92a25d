//! SPIR-V as words: what an instrumented shader has to know of the shader's types, constants and bindings.

use std::collections::HashMap;

/// Opcodes of SPIR-V 1.5.
pub(super) mod op {
    pub const EXT_INST: u32 = 12;
    pub const ENTRY_POINT: u32 = 15;
    pub const EXECUTION_MODE: u32 = 16;
    pub const TYPE_VOID: u32 = 19;
    pub const TYPE_BOOL: u32 = 20;
    pub const TYPE_INT: u32 = 21;
    pub const TYPE_FLOAT: u32 = 22;
    pub const TYPE_VECTOR: u32 = 23;
    pub const TYPE_MATRIX: u32 = 24;
    pub const TYPE_ARRAY: u32 = 28;
    pub const TYPE_RUNTIME_ARRAY: u32 = 29;
    pub const TYPE_STRUCT: u32 = 30;
    pub const TYPE_POINTER: u32 = 32;
    pub const TYPE_FORWARD_POINTER: u32 = 39;
    pub const CONSTANT_TRUE: u32 = 41;
    pub const CONSTANT: u32 = 43;
    pub const CONSTANT_NULL: u32 = 46;
    pub const SPEC_CONSTANT: u32 = 50;
    pub const SPEC_CONSTANT_OP: u32 = 52;
    pub const FUNCTION: u32 = 54;
    pub const FUNCTION_END: u32 = 56;
    pub const VARIABLE: u32 = 59;
    pub const LOAD: u32 = 61;
    pub const STORE: u32 = 62;
    pub const ACCESS_CHAIN: u32 = 65;
    pub const IN_BOUNDS_ACCESS_CHAIN: u32 = 66;
    pub const DECORATE: u32 = 71;
    pub const MEMBER_DECORATE: u32 = 72;
    pub const COMPOSITE_EXTRACT: u32 = 81;
    pub const IMAGE_FETCH: u32 = 95;
    pub const IMAGE_READ: u32 = 98;
    pub const IMAGE_WRITE: u32 = 99;
    pub const I_ADD: u32 = 128;
    pub const F_ADD: u32 = 129;
    pub const F_SUB: u32 = 131;
    pub const I_MUL: u32 = 132;
    pub const F_MUL: u32 = 133;
    pub const F_DIV: u32 = 136;
    pub const F_REM: u32 = 140;
    pub const F_MOD: u32 = 141;
    pub const VECTOR_TIMES_SCALAR: u32 = 142;
    pub const MATRIX_TIMES_SCALAR: u32 = 143;
    pub const VECTOR_TIMES_MATRIX: u32 = 144;
    pub const MATRIX_TIMES_VECTOR: u32 = 145;
    pub const DOT: u32 = 148;
    pub const SELECT: u32 = 169;
    pub const I_EQUAL: u32 = 170;
    pub const U_LESS_THAN: u32 = 176;
    pub const SHIFT_RIGHT: u32 = 194;
    pub const SHIFT_LEFT: u32 = 196;
    pub const BITWISE_AND: u32 = 199;
    pub const ATOMIC_LOAD: u32 = 227;
    pub const ATOMIC_STORE: u32 = 228;
    pub const ATOMIC_EXCHANGE: u32 = 229;
    pub const ATOMIC_ADD: u32 = 234;
    pub const ATOMIC_OR: u32 = 241;
    pub const ATOMIC_XOR: u32 = 242;
    pub const PHI: u32 = 245;
    pub const LOOP_MERGE: u32 = 246;
    pub const SELECTION_MERGE: u32 = 247;
    pub const LABEL: u32 = 248;
    pub const BRANCH: u32 = 249;
    pub const BRANCH_CONDITIONAL: u32 = 250;
    pub const KILL: u32 = 252;
    pub const RETURN: u32 = 253;
    pub const UNREACHABLE: u32 = 255;
}

pub(super) const UNIFORM_CONSTANT: u32 = 0;
pub(super) const PRIVATE: u32 = 6;
pub(super) const STORAGE_BUFFER: u32 = 12;
pub(super) const SPEC_ID: u32 = 1;
pub(super) const BLOCK: u32 = 2;
pub(super) const ARRAY_STRIDE: u32 = 6;
pub(super) const MATRIX_STRIDE: u32 = 7;
pub(super) const BINDING: u32 = 33;
pub(super) const DESCRIPTOR_SET: u32 = 34;
pub(super) const OFFSET: u32 = 35;
pub(super) const FRAGMENT: u32 = 4;
pub(super) const EARLY_FRAGMENT_TESTS: u32 = 9;
pub(super) const DEPTH_REPLACING: u32 = 12;
/// Words before the first instruction.
pub(super) const HEADER: usize = 5;

#[derive(Clone, Debug, PartialEq)]
pub(super) enum Type {
    /// A number of 32 bits.
    Scalar,
    /// Of its element, how many, and bytes from one to the next; a run-time array has none.
    Row {
        of: u32,
        count: u32,
        stride: u32,
    },
    /// Each member's type, offset, and bytes between the columns of a matrix.
    Struct(Vec<(u32, u32, u32)>),
    Pointer(u32),
}

/// Bytes of a binding that an instruction touches: from `constant`, and each index times its stride.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub(super) struct Place {
    pub(super) binding: u32,
    pub(super) constant: u32,
    pub(super) terms: Vec<(u32, Stride)>,
    pub(super) bytes: u32,
}

/// Bytes from one element to the next.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(super) enum Stride {
    Known(u32),
    /// Of the texels, rows or layers of the image that is bound.
    Axis(u32),
}

/// What is said before the first function.
#[derive(Debug, Default)]
pub(super) struct Module {
    types: HashMap<u32, Type>,
    constants: HashMap<u32, u32>,
    /// The type of each value.
    pub(super) type_of: HashMap<u32, u32>,
    /// Binding and type of each storage buffer.
    buffers: HashMap<u32, (u32, u32)>,
    /// Binding of each image.
    pub(super) images: HashMap<u32, u32>,
    pub(super) unsigned: Option<u32>,
    pub(super) boolean: Option<u32>,
}

/// The instructions of a module: opcode and all words.
pub(super) fn instructions(words: &[u32]) -> impl Iterator<Item = (u32, &[u32])> {
    instructions_of(words.get(HEADER..).unwrap_or_default())
}

/// The same without a header.
pub(super) fn instructions_of(words: &[u32]) -> impl Iterator<Item = (u32, &[u32])> {
    let mut rest = words;
    std::iter::from_fn(move || {
        let first = *rest.first()?;
        let (instruction, after) = rest.split_at_checked(((first >> 16) as usize).max(1))?;
        rest = after;
        Some((first & 0xffff, instruction))
    })
}

impl Module {
    pub(super) fn of(words: &[u32]) -> Module {
        let mut module = Module::default();
        let mut decorations: HashMap<(u32, u32), u32> = HashMap::new();
        let mut members: HashMap<(u32, u32, u32), u32> = HashMap::new();
        for (code, w) in instructions(words).take_while(|(code, _)| *code != op::FUNCTION) {
            match (code, w) {
                (op::DECORATE, [_, id, what, value, ..]) => _ = decorations.insert((*id, *what), *value),
                (op::MEMBER_DECORATE, [_, id, member, what, value, ..]) => {
                    members.insert((*id, *member, *what), *value);
                }
                (op::CONSTANT, [_, of, id, value]) => {
                    module.type_of.insert(*id, *of);
                    module.constants.insert(*id, *value);
                }
                (op::CONSTANT_TRUE..=op::SPEC_CONSTANT_OP, [_, of, id, ..]) => _ = module.type_of.insert(*id, *of),
                (op::VARIABLE, [_, of, id, class, ..]) => {
                    let Some(binding) = decorations.get(&(*id, BINDING)) else { continue };
                    match (*class, module.types.get(of)) {
                        (STORAGE_BUFFER, Some(Type::Pointer(to))) => _ = module.buffers.insert(*id, (*binding, *to)),
                        (UNIFORM_CONSTANT, _) => _ = module.images.insert(*id, *binding),
                        _ => {}
                    }
                }
                _ => module.declare(code, w, &decorations, &members),
            }
        }
        module
    }

    /// Takes a declaration of a type.
    fn declare(
        &mut self,
        code: u32,
        w: &[u32],
        decorations: &HashMap<(u32, u32), u32>,
        members: &HashMap<(u32, u32, u32), u32>,
    ) {
        let member = |id, place, what| members.get(&(id, place, what)).copied().unwrap_or_default();
        let made = match (code, w) {
            (op::TYPE_INT, [_, id, 32, 0]) => {
                self.unsigned = Some(*id);
                Type::Scalar
            }
            (op::TYPE_BOOL, [_, id]) => {
                self.boolean = Some(*id);
                Type::Scalar
            }
            (op::TYPE_INT | op::TYPE_FLOAT, _) => Type::Scalar,
            // The stride of a matrix is its structure's.
            (op::TYPE_VECTOR | op::TYPE_MATRIX, [_, _, of, count]) => {
                Type::Row { of: *of, count: *count, stride: self.bytes(*of) }
            }
            (op::TYPE_ARRAY, [_, id, of, count]) => {
                let stride = decorations.get(&(*id, ARRAY_STRIDE)).copied().unwrap_or_default();
                Type::Row { of: *of, count: self.constants.get(count).copied().unwrap_or_default(), stride }
            }
            (op::TYPE_RUNTIME_ARRAY, [_, id, of]) => {
                let stride = decorations.get(&(*id, ARRAY_STRIDE)).copied().unwrap_or_default();
                Type::Row { of: *of, count: 0, stride }
            }
            (op::TYPE_STRUCT, [_, id, of @ ..]) => {
                let place = |(i, of): (u32, &u32)| (*of, member(*id, i, OFFSET), member(*id, i, MATRIX_STRIDE));
                Type::Struct((0..).zip(of).map(place).collect())
            }
            (op::TYPE_POINTER, [_, _, _, to]) => Type::Pointer(*to),
            _ => return,
        };
        self.types.insert(w[1], made);
    }

    /// Bytes of a value in a buffer.
    fn bytes(&self, of: u32) -> u32 {
        match self.types.get(&of) {
            Some(Type::Row { count, stride, .. }) => count * stride,
            Some(Type::Struct(members)) => {
                members.iter().map(|(of, offset, _)| offset + self.bytes(*of)).max().unwrap_or_default()
            }
            Some(Type::Scalar) => 4,
            _ => 0,
        }
    }

    /// Numbers in a scalar or vector, or in the columns of a matrix.
    pub(super) fn components(&self, of: u32) -> u32 {
        match self.types.get(&of) {
            Some(Type::Row { of, count, .. }) => count * self.components(*of),
            _ => 1,
        }
    }

    /// The type of a vector's components, and how many there are.
    pub(super) fn vector(&self, of: u32) -> Option<(u32, u32)> {
        match self.types.get(&of) {
            Some(Type::Row { of, count, .. }) => Some((*of, *count)),
            _ => None,
        }
    }

    /// The place that an access chain into a storage buffer names.
    pub(super) fn place(&self, base: u32, indices: &[u32]) -> Option<Place> {
        let (binding, mut of) = *self.buffers.get(&base)?;
        let mut place = Place { binding, constant: 0, terms: Vec::new(), bytes: 0 };
        let mut columns = 0;
        for index in indices {
            let known = self.constants.get(index);
            match (self.types.get(&of)?, known) {
                (Type::Struct(members), Some(member)) => {
                    let (next, offset, matrix) = *members.get(*member as usize)?;
                    place.constant += offset;
                    (of, columns) = (next, matrix);
                }
                (Type::Row { of: next, stride, .. }, known) => {
                    let is_matrix = columns != 0 && matches!(self.types.get(next), Some(Type::Row { .. }));
                    let stride = if is_matrix { columns } else { *stride };
                    match known {
                        Some(known) => place.constant += known * stride,
                        None => place.terms.push((*index, Stride::Known(stride))),
                    }
                    of = *next;
                }
                _ => return None,
            }
        }
        place.bytes = self.bytes(of);
        Some(place)
    }
}
