//! A shader that counts what it does: floating-point operations, and the sectors of memory that it reads and writes.

use std::collections::{BTreeMap, HashMap, HashSet};

use super::module::{
    ARRAY_STRIDE, BINDING, BLOCK, DEPTH_REPLACING, DESCRIPTOR_SET, EARLY_FRAGMENT_TESTS, FRAGMENT, HEADER, Module,
    OFFSET, PRIVATE, Place, SPEC_ID, STORAGE_BUFFER, Stride, instructions, instructions_of, op,
};

/// The binding of the counts, beyond those of shaders. Its words are a sum of 64 bits, an [`Entry`] for each resource, and
/// a bit for each sector that is read, then for each that is written.
pub(super) const COUNTS: u32 = 63;
/// Bytes of a sector: less is not moved between memory and caches.
pub(super) const SECTOR: u32 = 32;
/// The specialisation constant of binding 0, beyond those of shaders: the word at which the entry of its resource is. Those
/// of other bindings follow.
pub(super) const FIRST_ID: u32 = 32;

/// A resource in the counts.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, bytemuck::Pod, bytemuck::Zeroable)]
#[repr(C)]
pub(super) struct Entry {
    /// Bit of its first sector, read.
    pub(super) read: u32,
    /// The same, written.
    pub(super) written: u32,
    /// Bytes from a texel to the next along x, y and layers.
    pub(super) strides: [u32; 3],
}

// Words of an entry.
const READ: u32 = 0;
const WRITTEN: u32 = 1;
const STRIDES: u32 = 2;

/// The instrumented module. What the optimiser leaves of a shader is one function.
pub(super) fn instrument(words: &[u32]) -> Vec<u32> {
    let mut module = Module::of(words);
    let Some(bound) = words.get(3) else { return words.to_vec() };
    let mut writer = Writer::new(*bound, &module);
    let mut code = Vec::new();
    let mut block: Vec<&[u32]> = Vec::new();
    let mut chains = HashMap::new();
    let functions = instructions(words).skip_while(|(code, _)| *code != op::FUNCTION);
    for (opcode, instruction) in functions {
        note_type(&mut module, opcode, instruction);
        match opcode {
            op::FUNCTION..=op::FUNCTION_END => code.extend_from_slice(instruction),
            _ => block.push(instruction),
        }
        if matches!(opcode, op::BRANCH..=op::UNREACHABLE) {
            writer.block(&module, &mut chains, &block, &mut code);
            block.clear();
        }
    }
    writer.assemble(words, &code)
}

fn note_type(module: &mut Module, opcode: u32, instruction: &[u32]) {
    let has_no_result = matches!(
        opcode,
        op::FUNCTION..=op::FUNCTION_END
            | op::STORE
            | op::IMAGE_WRITE
            | op::ATOMIC_STORE
            | op::LOOP_MERGE..=op::UNREACHABLE
    );
    if let ([_, of, id, ..], false) = (instruction, has_no_result) {
        module.type_of.entry(*id).or_insert(*of);
    }
}

/// Floating-point operations of an instruction: one a component, two a multiply-add. Comparisons, conversions and rounding
/// are none.
fn operations(module: &Module, opcode: u32, w: &[u32]) -> u32 {
    let [_, of, _, operands @ ..] = w else { return 0 };
    let components = module.components(*of);
    let of_operand = |place: usize| {
        let of = operands.get(place).and_then(|id| module.type_of.get(id));
        of.map_or(1, |of| module.components(*of))
    };
    match opcode {
        op::F_ADD
        | op::F_SUB
        | op::F_MUL
        | op::F_DIV
        | op::F_REM
        | op::F_MOD
        | op::VECTOR_TIMES_SCALAR
        | op::MATRIX_TIMES_SCALAR => components,
        op::DOT => 2 * of_operand(0) - 1,
        // Each column, or each row, is a dot product.
        op::VECTOR_TIMES_MATRIX => components * (2 * of_operand(0) - 1),
        op::MATRIX_TIMES_VECTOR => components * (2 * of_operand(1) - 1),
        op::EXT_INST => match operands.get(1) {
            // Trigonometric, exponential, root.
            Some(13..=32) => components,
            // mix as a difference and a multiply-add.
            Some(46) => 3 * components,
            // smoothstep: a share, and t * t * (3 - 2 t).
            Some(49) => 7 * components,
            Some(50) => 2 * components,
            // length, distance, cross, normalize; the vector is the first argument.
            Some(66) => 2 * of_operand(2),
            Some(67) => 3 * of_operand(2),
            Some(68) => 9,
            Some(69) => 3 * components,
            _ => 0,
        },
        _ => 0,
    }
}

/// Writes the code that counts, and the declarations that it needs.
struct Writer {
    /// Loads of words of entries, which the first block begins with: binding and word.
    entries: BTreeMap<(u32, u32), u32>,
    /// Where these come in the code.
    begin: Option<usize>,
    /// The block that a block ends as.
    ends: HashMap<u32, u32>,
    next: u32,
    unsigned: u32,
    boolean: u32,
    /// Of an unsigned number in the counts.
    pointer: u32,
    counts: u32,
    /// The sum of an invocation.
    own: u32,
    constants: BTreeMap<u32, u32>,
    specialised: BTreeMap<u32, u32>,
    /// Whether the module had these types.
    had: [bool; 2],
}

/// Whether an instruction reads, and whether it writes.
type Access = (bool, bool);

impl Writer {
    fn new(bound: u32, module: &Module) -> Writer {
        let mut next = bound;
        let mut id = || {
            next += 1;
            next - 1
        };
        let (unsigned, boolean) = (module.unsigned.unwrap_or_else(&mut id), module.boolean.unwrap_or_else(&mut id));
        let (pointer, counts, own) = (id(), id(), id());
        let had = [module.unsigned.is_some(), module.boolean.is_some()];
        let (constants, specialised) = (BTreeMap::new(), BTreeMap::new());
        let (entries, ends, begin) = (BTreeMap::new(), HashMap::new(), None);
        Writer { entries, begin, ends, next, unsigned, boolean, pointer, counts, own, constants, specialised, had }
    }

    fn id(&mut self) -> u32 {
        self.next += 1;
        self.next - 1
    }

    fn constant(&mut self, value: u32) -> u32 {
        if let Some(id) = self.constants.get(&value) {
            return *id;
        }
        let id = self.id();
        self.constants.insert(value, id);
        id
    }

    fn specialised(&mut self, number: u32) -> u32 {
        if let Some(id) = self.specialised.get(&number) {
            return *id;
        }
        let id = self.id();
        self.specialised.insert(number, id);
        id
    }

    /// Emits an instruction with an unsigned result.
    fn emit(&mut self, code: &mut Vec<u32>, opcode: u32, operands: &[u32]) -> u32 {
        let of = self.unsigned;
        self.emit_of(code, opcode, of, operands)
    }

    fn emit_of(&mut self, code: &mut Vec<u32>, opcode: u32, of: u32, operands: &[u32]) -> u32 {
        let id = self.id();
        put(code, opcode, &[&[of, id], operands].concat());
        id
    }

    /// A block of instructions: its sum at its begin, bits before each access, the invocation's sum before its end.
    fn block(&mut self, module: &Module, chains: &mut HashMap<u32, Touched>, block: &[&[u32]], code: &mut Vec<u32>) {
        let opcode = |instruction: &[u32]| instruction[0] & 0xffff;
        let is_first = |w: &&[u32]| matches!(opcode(w), op::LABEL | op::PHI | op::VARIABLE);
        let (first, rest) = block.split_at(block.iter().take_while(|w| is_first(w)).count());
        first.iter().for_each(|instruction| code.extend_from_slice(instruction));
        self.begin.get_or_insert(code.len());
        let sum: u32 = block.iter().map(|w| operations(module, opcode(w), w)).sum();
        if sum > 0 {
            let (own, sum) = (self.own, self.constant(sum));
            let before = self.emit(code, op::LOAD, &[own]);
            let after = self.emit(code, op::I_ADD, &[before, sum]);
            put(code, op::STORE, &[own, after]);
        }
        let mut marked = HashSet::new();
        // A loop goes back to the block that says so.
        let label = block.first().map(|w| w[1]).filter(|_| !block.iter().any(|w| opcode(w) == op::LOOP_MERGE));
        for w in rest {
            let opcode = opcode(w);
            match (opcode, *w) {
                (op::ACCESS_CHAIN | op::IN_BOUNDS_ACCESS_CHAIN, [_, _, id, base, indices @ ..]) => {
                    if let Some(place) = module.place(*base, indices) {
                        chains.insert(*id, Touched::Bytes(place));
                    }
                }
                (op::LOAD, [_, _, id, image, ..]) if module.images.contains_key(image) => {
                    chains.insert(*id, Touched::Image(module.images[image]));
                }
                _ => {
                    if let Some((place, access)) = self.access(module, chains, (opcode, w), code)
                        && marked.insert((place.clone(), access))
                    {
                        self.mark(&place, access, label, code);
                    }
                }
            }
            if matches!(opcode, op::KILL | op::RETURN) {
                self.finish(code);
            }
            code.extend_from_slice(w);
        }
    }

    /// What an instruction touches.
    fn access(
        &mut self,
        module: &Module,
        chains: &HashMap<u32, Touched>,
        (opcode, w): (u32, &[u32]),
        code: &mut Vec<u32>,
    ) -> Option<(Place, Access)> {
        let (target, access) = match (opcode, w) {
            (op::LOAD | op::ATOMIC_LOAD | op::IMAGE_FETCH | op::IMAGE_READ, [_, _, _, target, ..]) => {
                (target, (true, false))
            }
            (op::STORE | op::ATOMIC_STORE | op::IMAGE_WRITE, [_, target, ..]) => (target, (false, true)),
            (op::ATOMIC_EXCHANGE..=op::ATOMIC_XOR, [_, _, _, target, ..]) => (target, (true, true)),
            _ => return None,
        };
        match chains.get(target)? {
            Touched::Bytes(place) => Some((place.clone(), access)),
            Touched::Image(binding) => {
                let at = if opcode == op::IMAGE_WRITE { w[2] } else { w[4] };
                let (of, count) = module.vector(*module.type_of.get(&at)?)?;
                let index = |axis| (self.emit_of(code, op::COMPOSITE_EXTRACT, of, &[at, axis]), Stride::Axis(axis));
                let terms = (0..count).map(index).collect();
                // A texel lies in one sector.
                Some((Place { binding: *binding, constant: 0, terms, bytes: 4 }, access))
            }
        }
    }

    /// Sets the bits of a place. `block` may be divided.
    fn mark(&mut self, place: &Place, (reads, writes): Access, block: Option<u32>, code: &mut Vec<u32>) {
        let mut offset = self.constant(place.constant);
        for (index, stride) in &place.terms {
            let stride = match stride {
                Stride::Known(bytes) => self.constant(*bytes),
                Stride::Axis(axis) => self.entry(place.binding, STRIDES + axis),
            };
            let product = self.emit(code, op::I_MUL, &[*index, stride]);
            offset = self.emit(code, op::I_ADD, &[offset, product]);
        }
        // Every sector of it, wherever it begins. What is no longer than a vector is aligned.
        let last = place.bytes.saturating_sub(4);
        let mut places: Vec<u32> = (0..=last).step_by(SECTOR as usize).collect();
        if last > 12 && places.last() != Some(&last) {
            places.push(last);
        }
        for away in places {
            let [away, shift] = [away, SECTOR.ilog2()].map(|value| self.constant(value));
            let at = self.emit(code, op::I_ADD, &[offset, away]);
            let sector = self.emit(code, op::SHIFT_RIGHT, &[at, shift]);
            for (word, _) in [(READ, reads), (WRITTEN, writes)].into_iter().filter(|(_, is_done)| *is_done) {
                let first = self.entry(place.binding, word);
                let bit = self.emit(code, op::I_ADD, &[sector, first]);
                self.set(bit, block, code);
            }
        }
    }

    /// A word of the entry of a binding's resource.
    fn entry(&mut self, binding: u32, word: u32) -> u32 {
        if let Some(id) = self.entries.get(&(binding, word)) {
            return *id;
        }
        let id = self.id();
        self.entries.insert((binding, word), id);
        id
    }

    /// Sets a bit, if it is not: asking takes less than an atomic operation, most of which change nothing.
    fn set(&mut self, bit: u32, block: Option<u32>, code: &mut Vec<u32>) {
        let [zero, one, five, low] = [0, 1, 5, 31].map(|value| self.constant(value));
        let word = self.emit(code, op::SHIFT_RIGHT, &[bit, five]);
        let place = self.emit(code, op::BITWISE_AND, &[bit, low]);
        let mask = self.emit(code, op::SHIFT_LEFT, &[one, place]);
        let (pointer, counts, boolean) = (self.pointer, self.counts, self.boolean);
        let target = self.emit_of(code, op::ACCESS_CHAIN, pointer, &[counts, zero, word]);
        let after = block.map(|block| {
            let before = self.emit(code, op::LOAD, &[target]);
            let own = self.emit(code, op::BITWISE_AND, &[before, mask]);
            let is_clear = self.emit_of(code, op::I_EQUAL, boolean, &[own, zero]);
            let (set, after) = (self.id(), self.id());
            put(code, op::SELECTION_MERGE, &[after, 0]);
            put(code, op::BRANCH_CONDITIONAL, &[is_clear, set, after]);
            put(code, op::LABEL, &[set]);
            self.ends.insert(block, after);
            after
        });
        // Scope Device is 1, relaxed semantics are 0.
        self.emit(code, op::ATOMIC_OR, &[target, one, zero, mask]);
        if let Some(after) = after {
            put(code, op::BRANCH, &[after]);
            put(code, op::LABEL, &[after]);
        }
    }

    /// Adds the sum of the invocation to the 64-bit sum.
    fn finish(&mut self, code: &mut Vec<u32>) {
        let [zero, one] = [0, 1].map(|value| self.constant(value));
        let (pointer, counts, own, boolean) = (self.pointer, self.counts, self.own, self.boolean);
        let sum = self.emit(code, op::LOAD, &[own]);
        let low = self.emit_of(code, op::ACCESS_CHAIN, pointer, &[counts, zero, zero]);
        let high = self.emit_of(code, op::ACCESS_CHAIN, pointer, &[counts, zero, one]);
        let before = self.emit(code, op::ATOMIC_ADD, &[low, one, zero, sum]);
        let after = self.emit(code, op::I_ADD, &[before, sum]);
        let overflows = self.emit_of(code, op::U_LESS_THAN, boolean, &[after, before]);
        let carry = self.emit(code, op::SELECT, &[overflows, one, zero]);
        self.emit(code, op::ATOMIC_ADD, &[high, one, zero, carry]);
    }

    /// Puts loads of entries where they belong, and lets values come from the ends of divided blocks.
    fn complete(&mut self, code: &[u32]) -> Vec<u32> {
        let (before, after) = code.split_at(self.begin.unwrap_or_default());
        let mut made = before.to_vec();
        for ((binding, word), id) in self.entries.clone() {
            let (entry, [zero, word]) =
                (self.specialised(FIRST_ID + binding), [0, word].map(|value| self.constant(value)));
            let (pointer, counts, unsigned) = (self.pointer, self.counts, self.unsigned);
            let place = self.emit(&mut made, op::I_ADD, &[entry, word]);
            let place = self.emit_of(&mut made, op::ACCESS_CHAIN, pointer, &[counts, zero, place]);
            put(&mut made, op::LOAD, &[unsigned, id, place]);
        }
        for (opcode, instruction) in instructions_of(after) {
            let begin = made.len();
            made.extend_from_slice(instruction);
            if opcode == op::PHI {
                for from in made[begin + 3..].iter_mut().skip(1).step_by(2) {
                    *from = self.ends.get(from).copied().unwrap_or(*from);
                }
            }
        }
        made
    }

    /// The module with these functions.
    fn assemble(mut self, words: &[u32], functions: &[u32]) -> Vec<u32> {
        let functions = self.complete(functions);
        let (mut decorations, mut declarations) = (Vec::new(), Vec::new());
        self.declare(&mut decorations, &mut declarations);
        let mut made = words[..HEADER].to_vec();
        made[3] = self.next;
        let mut is_decorated = false;
        for (opcode, instruction) in instructions(words).take_while(|(code, _)| *code != op::FUNCTION) {
            let is_type = matches!(opcode, op::TYPE_VOID..=op::TYPE_FORWARD_POINTER);
            if is_type && !std::mem::replace(&mut is_decorated, true) {
                made.extend_from_slice(&decorations);
            }
            match opcode {
                op::ENTRY_POINT => {
                    put(&mut made, opcode, &[&instruction[1..], &[self.counts, self.own]].concat());
                    if tests_early(words) {
                        put(&mut made, op::EXECUTION_MODE, &[instruction[2], EARLY_FRAGMENT_TESTS]);
                    }
                }
                _ => made.extend_from_slice(instruction),
            }
        }
        made.extend_from_slice(&declarations);
        made.extend_from_slice(&functions);
        made
    }

    fn declare(&mut self, decorations: &mut Vec<u32>, declarations: &mut Vec<u32>) {
        let [array, block, block_pointer, own_pointer, null] = [(); 5].map(|()| self.id());
        let Writer { unsigned, boolean, pointer, counts, own, .. } = *self;
        put(decorations, op::DECORATE, &[array, ARRAY_STRIDE, 4]);
        put(decorations, op::DECORATE, &[block, BLOCK]);
        put(decorations, op::MEMBER_DECORATE, &[block, 0, OFFSET, 0]);
        put(decorations, op::DECORATE, &[counts, DESCRIPTOR_SET, 0]);
        put(decorations, op::DECORATE, &[counts, BINDING, COUNTS]);
        if !self.had[0] {
            put(declarations, op::TYPE_INT, &[unsigned, 32, 0]);
        }
        if !self.had[1] {
            put(declarations, op::TYPE_BOOL, &[boolean]);
        }
        put(declarations, op::TYPE_RUNTIME_ARRAY, &[array, unsigned]);
        put(declarations, op::TYPE_STRUCT, &[block, array]);
        put(declarations, op::TYPE_POINTER, &[block_pointer, STORAGE_BUFFER, block]);
        put(declarations, op::TYPE_POINTER, &[pointer, STORAGE_BUFFER, unsigned]);
        put(declarations, op::TYPE_POINTER, &[own_pointer, PRIVATE, unsigned]);
        put(declarations, op::CONSTANT_NULL, &[unsigned, null]);
        put(declarations, op::VARIABLE, &[block_pointer, counts, STORAGE_BUFFER]);
        put(declarations, op::VARIABLE, &[own_pointer, own, PRIVATE, null]);
        for (value, id) in &self.constants {
            put(declarations, op::CONSTANT, &[unsigned, *id, *value]);
        }
        for (number, id) in &self.specialised {
            put(decorations, op::DECORATE, &[*id, SPEC_ID, *number]);
            put(declarations, op::SPEC_CONSTANT, &[unsigned, *id, 0]);
        }
    }
}

/// Whether fragments were tested before they are shaded, which a shader that writes memory has to ask for.
fn tests_early(words: &[u32]) -> bool {
    let is_late = |(code, w): (u32, &[u32])| match (code, w) {
        (op::ENTRY_POINT, [_, stage, ..]) => *stage != FRAGMENT,
        (op::EXECUTION_MODE, [_, _, mode, ..]) => matches!(*mode, EARLY_FRAGMENT_TESTS | DEPTH_REPLACING),
        _ => code == op::KILL,
    };
    !instructions(words).any(is_late)
}

/// A value that names memory.
enum Touched {
    Bytes(Place),
    Image(u32),
}

fn put(code: &mut Vec<u32>, opcode: u32, operands: &[u32]) {
    code.push((operands.len() as u32 + 1) << 16 | opcode);
    code.extend_from_slice(operands);
}
