//! The work that a run does at least, counted: not by a model of each kernel, but by a run of kernels that count.
//!
//! Operations are those that every invocation executes. Bytes are the sectors of memory that anything of the run reads,
//! and those that it writes, each once however often that happens: what a device with an endless cache would move.

mod instrument;
mod module;

use std::collections::HashMap;
use std::sync::{Mutex, PoisonError};

use ash::vk;

use super::report::Work;
use crate::gpu::buffer::BufferDesc;
use crate::gpu::image::texel_bytes;
use crate::gpu::resources::{ImageSlot, Resources};
use crate::plan::{Access, Binding, BufferId, Command, DescriptorKind, Kernel, Pass, Plan, Resource, Shader};
use instrument::{COUNTS, Entry, FIRST_ID, SECTOR, instrument};

/// Words of the sum of operations.
const SUM_WORDS: usize = 2;
const ENTRY_WORDS: usize = size_of::<Entry>() / 4;
const BINDING: Binding =
    Binding { name: "Counts", number: COUNTS, kind: DescriptorKind::StorageBuffer, access: Access::ReadWrite };

/// Where the counts of some passes are, and what they mean.
#[derive(Debug)]
pub(super) struct Counter {
    /// The buffer, which has the next id after those that passes use.
    pub(super) buffer: BufferId,
    /// Bytes of each resource and the place of its entry.
    resources: HashMap<Resource, (u64, usize)>,
    entries: Vec<Entry>,
    /// Words of the buffer.
    words: usize,
    /// Whether the device lets all stages write memory, not compute shaders alone.
    raster: bool,
}

impl Counter {
    pub(super) fn new(resources: &Resources, raster: bool) -> Counter {
        let buffers = (0..resources.buffers.len() as u16).map(|id| {
            let id = BufferId(id);
            (Resource::Buffer(id), resources.buffer(id).2, [0; 3])
        });
        let images = (0..).zip(&resources.images).map(|(id, slot)| {
            let (format, [width, height], layers) = match slot {
                ImageSlot::Own(image) => (image.desc.format, image.desc.extent, image.desc.layers),
                ImageSlot::Host(Some(image)) => (image.format, image.extent, 1),
                ImageSlot::Host(None) => (vk::Format::UNDEFINED, [0; 2], 0),
            };
            let texel = texel_bytes(format) as u32;
            let strides = [texel, texel * width, texel * width * height];
            (Resource::Image(crate::plan::ImageId(id)), u64::from(strides[2]) * u64::from(layers), strides)
        });
        let all: Vec<_> = buffers.chain(images).collect();
        let sectors = |bytes: u64| bytes.div_ceil(SECTOR.into()) as u32;
        let total: u32 = all.iter().map(|(_, bytes, _)| sectors(*bytes)).sum();
        let mut read = 32 * (SUM_WORDS + ENTRY_WORDS * all.len()) as u32;
        let words = (read + 2 * total).div_ceil(32) as usize;
        let (mut entries, mut places) = (Vec::new(), HashMap::new());
        for (resource, bytes, strides) in all {
            places.insert(resource, (bytes, entries.len()));
            entries.push(Entry { read, written: read + total, strides });
            read += sectors(bytes);
        }
        Counter { buffer: BufferId(resources.buffers.len() as u16), resources: places, entries, words, raster }
    }

    pub(super) fn desc(&self) -> BufferDesc {
        BufferDesc::storage("counts", 4 * self.words as u64)
    }

    pub(super) fn words(&self) -> usize {
        self.words
    }

    /// The first words before a run; the others are 0.
    pub(super) fn header(&self) -> Vec<u8> {
        [bytemuck::cast_slice(&[0_u32; SUM_WORDS]), bytemuck::cast_slice(&self.entries)].concat()
    }

    /// Makes a pass count.
    pub(super) fn instrument(&self, pass: &mut Pass) {
        match &mut pass.kernel {
            Kernel::Compute(shader) => *shader = counting(shader),
            Kernel::Raster(raster) if self.raster => {
                raster.vertex = counting(raster.vertex);
                raster.fragment = counting(raster.fragment);
            }
            Kernel::Raster(_) | Kernel::Transfer => return,
        }
        let last = pass.bindings.iter().map(|(binding, _)| binding.number).max().unwrap_or_default();
        pass.specialisation.resize((FIRST_ID + last + 1) as usize, 0);
        for (binding, resource) in &pass.bindings {
            if let Some((_, place)) = self.resources.get(resource) {
                let word = SUM_WORDS + ENTRY_WORDS * place;
                pass.specialisation[(FIRST_ID + binding.number) as usize] = word as u32;
            }
        }
        let whole = std::mem::replace(pass, Pass::transfer(""));
        *pass = whole.bind(BINDING, self.buffer);
    }

    /// The work of a run of a plan that left these words.
    pub(super) fn work(&self, passes: &[Pass], plan: &Plan, mut words: Vec<u32>) -> Work {
        for step in &plan.steps {
            let pass = &passes[usize::from(step.pass.0)];
            self.transfer(&step.command, &mut words);
            if let Kernel::Raster(raster) = &pass.kernel {
                let colour = raster.colour.filter(|colour| colour.clear.is_some()).map(|colour| colour.image);
                let depth = raster.depth.filter(|depth| depth.clear.is_some()).map(|depth| depth.image);
                let texels = u64::from(raster.extent[0]) * u64::from(raster.extent[1]);
                for image in colour.into_iter().chain(depth) {
                    self.set(&mut words, image.into(), (0, texels * self.texel(image.into())), false);
                }
            }
        }
        let flops = words.first().zip(words.get(1)).map(|(low, high)| u64::from(*high) << 32 | u64::from(*low));
        let bits = words.iter().skip(SUM_WORDS + ENTRY_WORDS * self.entries.len());
        let sectors: u64 = bits.map(|word| u64::from(word.count_ones())).sum();
        Work { bytes: Some(sectors * u64::from(SECTOR)), flops }
    }

    /// What clears, fills, updates and copies touch.
    fn transfer(&self, command: &Command, words: &mut [u32]) {
        let whole = (0, u64::MAX);
        let mut read = |resource: Resource, range| self.set(words, resource, range, true);
        match *command {
            Command::CopyBuffer { from, bytes, .. } => read(from.into(), (0, bytes)),
            Command::CopyRange { from: (from, first), bytes, .. } => read(from.into(), (first, bytes)),
            Command::CopyImage { from, .. } => read(from.into(), whole),
            Command::CopyDepth { from, .. } => read(from.into(), whole),
            _ => {}
        }
        let mut write = |resource: Resource, range| self.set(words, resource, range, false);
        match *command {
            Command::Fill { buffer, .. } => write(buffer.into(), whole),
            Command::Update { buffer, bytes, .. } => write(buffer.into(), (0, bytes as u64)),
            Command::Clear { image, .. } => write(image.into(), whole),
            Command::CopyBuffer { to, bytes, .. } => write(to.into(), (0, bytes)),
            Command::CopyRange { to: (to, first), bytes, .. } => write(to.into(), (first, bytes)),
            Command::CopyImage { to, .. } => write(to.into(), whole),
            Command::CopyDepth { to, extent: [width, height], .. } => {
                write(to.into(), (0, 4 * u64::from(width) * u64::from(height)));
            }
            _ => {}
        }
    }

    fn texel(&self, image: Resource) -> u64 {
        self.resources.get(&image).map_or(0, |(_, place)| self.entries[*place].strides[0].into())
    }

    /// Sets the bits of a range: its first byte and how many there are.
    fn set(&self, words: &mut [u32], resource: Resource, (first, count): (u64, u64), reads: bool) {
        let Some((bytes, place)) = self.resources.get(&resource) else { return };
        let Entry { read, written, .. } = self.entries[*place];
        let base = if reads { read } else { written };
        let end = first.saturating_add(count).min(*bytes);
        let sector = u64::from(SECTOR);
        for sector in first / sector..end.div_ceil(sector) {
            let bit = base as usize + sector as usize;
            words[bit / 32] |= 1 << (bit % 32);
        }
    }
}

/// The counting form of a shader. It is made once and lives as long as the program, as the shader itself: pipelines go by
/// where words are.
fn counting(shader: &'static Shader) -> &'static Shader {
    static MADE: Mutex<Option<HashMap<usize, &'static Shader>>> = Mutex::new(None);
    let mut made = MADE.lock().unwrap_or_else(PoisonError::into_inner);
    made.get_or_insert_default().entry(shader.words.as_ptr().addr()).or_insert_with(|| {
        let bindings = [shader.bindings, &[BINDING]].concat();
        let (words, bindings) = (instrument(shader.words).leak(), bindings.leak());
        Box::leak(Box::new(Shader { words, bindings, ..*shader }))
    })
}
