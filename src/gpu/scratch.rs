//! Scratch memory: one range in which all lies that an effect writes anew in each frame. Effects that never run at once may
//! share it.

use ash::vk;

use crate::error::{Error, Result};
use crate::host::{Allocation, MemoryRequest, MemorySource};
use crate::plan::Resource;

/// How long what a buffer or image holds is needed.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Lifetime {
    /// A sequence goes on from it: without it the next frame is a first one.
    Sequence,
    /// Later frames or the host read it. It can be made anew.
    #[default]
    Kept,
    /// Each frame writes it before it reads it: nothing is there between frames.
    Scratch,
    /// As [`Lifetime::Scratch`], unless the effect keeps layers: then as [`Lifetime::Kept`].
    Layer,
}

impl Lifetime {
    /// What a layer is, too, of an effect that keeps layers or does not.
    pub(crate) fn with_layers(self, kept: bool) -> Lifetime {
        match self {
            Lifetime::Layer if kept => Lifetime::Kept,
            Lifetime::Layer => Lifetime::Scratch,
            Lifetime::Sequence | Lifetime::Kept | Lifetime::Scratch => self,
        }
    }
}

/// What scratch memory must be.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub struct ScratchNeeds {
    /// Its size.
    pub bytes: u64,
    /// What its first byte in a `VkDeviceMemory` is a multiple of.
    pub alignment: u64,
    /// The memory types that it can be of, as in `VkMemoryRequirements`.
    pub memory_types: u32,
}

impl ScratchNeeds {
    /// None: what every memory is enough for.
    pub const NONE: ScratchNeeds = ScratchNeeds { bytes: 0, alignment: 1, memory_types: u32::MAX };

    /// What is enough for either of two effects, which do not run at once.
    #[must_use]
    pub fn or(self, other: ScratchNeeds) -> ScratchNeeds {
        ScratchNeeds {
            bytes: self.bytes.max(other.bytes),
            alignment: self.alignment.max(other.alignment),
            memory_types: self.memory_types & other.memory_types,
        }
    }

    /// A range of device memory that is this.
    fn allocate(&self, source: &mut dyn MemorySource, name: &str) -> Result<Allocation> {
        let ScratchNeeds { bytes: size, alignment, memory_types: memory_type_bits } = *self;
        let requirements = vk::MemoryRequirements { size, alignment, memory_type_bits };
        let properties = vk::MemoryPropertyFlags::DEVICE_LOCAL;
        // It ends on a page of its own: its neighbours may be of either kind.
        source.allocate(&MemoryRequest { name, requirements, properties, linear: false })
    }
}

/// Where scratch memory is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub struct ScratchRange {
    /// The memory that it is a part of.
    pub memory: vk::DeviceMemory,
    /// Its first byte there.
    pub offset: u64,
    /// Its bytes.
    pub bytes: u64,
}

/// Scratch memory for any number of effects whose frames never run at once: those recorded one after the other and submitted to
/// one queue. Between frames it holds nothing that is needed, and may be used for anything else.
#[derive(Debug)]
pub struct ScratchPool {
    shared: Shared,
    allocation: Allocation,
}

/// A pool as effects know it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Shared {
    range: ScratchRange,
    needs: ScratchNeeds,
}

impl ScratchPool {
    /// Takes memory that is enough for what `needs` are of: [`crate::effect::Effect::scratch_needs`] of each effect,
    /// joined by [`ScratchNeeds::or`].
    ///
    /// # Errors
    /// [`Error::Allocation`]: there is none.
    pub fn new(source: &mut dyn MemorySource, needs: ScratchNeeds) -> Result<ScratchPool> {
        let needs = ScratchNeeds { bytes: needs.bytes.max(1), ..needs };
        let allocation = needs.allocate(source, "scratch pool")?;
        let range = ScratchRange { memory: allocation.memory, offset: allocation.offset, bytes: needs.bytes };
        Ok(ScratchPool { shared: Shared { range, needs }, allocation })
    }

    /// Where it is, for a host that puts other things there between frames.
    pub fn range(&self) -> ScratchRange {
        self.shared.range
    }

    pub(crate) fn shared(&self) -> Shared {
        self.shared
    }

    /// Gives the memory back.
    ///
    /// # Safety
    /// All effects in it and what they have handed back are destroyed; `source` is the one that it is from.
    pub unsafe fn destroy(self, source: &mut dyn MemorySource) {
        source.free(self.allocation);
    }
}

/// The scratch memory of one effect.
#[derive(Debug)]
pub(crate) struct Scratch {
    pub(crate) range: ScratchRange,
    pub(crate) shared: Option<Shared>,
    allocation: Option<Allocation>,
}

impl Scratch {
    /// The pool's, or a range of the effect's own.
    ///
    /// # Errors
    /// The pool is too small, or of the wrong memory; there is no memory.
    pub(crate) fn new(
        source: &mut dyn MemorySource,
        needs: &ScratchNeeds,
        name: &str,
        shared: Option<Shared>,
    ) -> Result<Scratch> {
        let Some(Shared { range, needs: made }) = shared else {
            let allocation = needs.allocate(source, name)?;
            let range = ScratchRange { memory: allocation.memory, offset: allocation.offset, bytes: needs.bytes };
            return Ok(Scratch { range, shared, allocation: Some(allocation) });
        };
        let refuse = |why: String| Err(Error::HostResource { name: "scratch pool", why });
        match () {
            _ if needs.bytes > made.bytes => refuse(format!(
                "{} bytes; {name} needs {}: make a pool of what scratch_needs says of all effects' new descriptions, and change_in it",
                made.bytes, needs.bytes
            )),
            _ if needs.alignment > made.alignment => {
                refuse(format!("aligned to {} bytes; {name} needs {}", made.alignment, needs.alignment))
            }
            _ if made.memory_types & !needs.memory_types != 0 => {
                refuse(format!("memory types {:#b}; {name} needs {:#b}", made.memory_types, needs.memory_types))
            }
            _ => Ok(Scratch { range, shared, allocation: None }),
        }
    }

    /// Gives memory of the effect's own back.
    pub(crate) fn destroy(self, source: &mut dyn MemorySource) {
        if let Some(allocation) = self.allocation {
            source.free(allocation);
        }
    }
}

/// Groups of resources that lie in the same place, one group after the other: in a frame, none of a group is used after one of a later
/// group is. Images are in the first.
pub type Overlay = Vec<Vec<Resource>>;

/// Places buffers, and then images, in a range. Pure.
#[derive(Debug)]
pub(crate) struct Placing {
    needs: ScratchNeeds,
    granularity: u64,
}

impl Placing {
    /// Nothing yet. `granularity`: `bufferImageGranularity` of the device.
    pub(crate) fn new(granularity: u64) -> Placing {
        Placing { needs: ScratchNeeds::NONE, granularity }
    }

    /// The offset of the next one; none if no memory suits it and all before it.
    pub(crate) fn place(&mut self, requirements: &vk::MemoryRequirements, is_image: bool) -> Option<u64> {
        let memory_types = self.needs.memory_types & requirements.memory_type_bits;
        if memory_types == 0 {
            return None;
        }
        // Buffers and images share no page.
        let page = if is_image { self.granularity } else { 1 };
        let alignment = requirements.alignment.max(page);
        let offset = self.needs.bytes.next_multiple_of(alignment);
        let alignment = self.needs.alignment.max(alignment);
        self.needs = ScratchNeeds { bytes: offset + requirements.size, alignment, memory_types };
        Some(offset)
    }

    /// The offsets of groups that lie in the same place, one behind the other within each: pages of their own.
    pub(crate) fn overlay(&mut self, groups: &[Vec<vk::MemoryRequirements>]) -> Vec<Option<u64>> {
        let begin = self.needs.bytes.next_multiple_of(self.granularity);
        let (mut end, mut places) = (begin, Vec::new());
        for group in groups {
            self.needs.bytes = begin;
            places.extend(group.iter().map(|requirements| self.place(requirements, true)));
            end = end.max(self.needs.bytes);
        }
        self.needs.bytes = end.next_multiple_of(self.granularity);
        places
    }

    /// What the range must be: whole pages.
    pub(crate) fn needs(&self) -> ScratchNeeds {
        match self.needs.bytes {
            0 => self.needs,
            bytes => ScratchNeeds {
                bytes: bytes.next_multiple_of(self.granularity),
                alignment: self.needs.alignment.max(self.granularity),
                ..self.needs
            },
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn requirements(size: u64, alignment: u64, memory_type_bits: u32) -> vk::MemoryRequirements {
        vk::MemoryRequirements { size, alignment, memory_type_bits }
    }

    #[test]
    fn what_is_placed_does_not_overlap_and_buffers_share_no_page_with_images() {
        let mut placing = Placing::new(1024);
        let places = [
            (requirements(100, 16, 0b111), false),
            (requirements(60, 64, 0b011), false),
            (requirements(5000, 256, 0b110), true),
            (requirements(8, 4096, 0b010), true),
        ]
        .map(|(requirements, is_image)| placing.place(&requirements, is_image));
        assert_eq!(places, [Some(0), Some(128), Some(1024), Some(8192)]);
        assert_eq!(placing.place(&requirements(8, 8, 0b101), true), None, "no type is left");
        assert_eq!(placing.needs(), ScratchNeeds { bytes: 9216, alignment: 4096, memory_types: 0b010 });
    }

    #[test]
    fn groups_lie_in_the_same_pages() {
        let mut placing = Placing::new(1024);
        assert_eq!(placing.place(&requirements(100, 16, 1), false), Some(0));
        let groups = [vec![requirements(1500, 64, 1)], vec![requirements(500, 64, 1), requirements(2000, 64, 1)]];
        assert_eq!(placing.overlay(&groups), [Some(1024), Some(1024), Some(2048)]);
        assert_eq!(placing.place(&requirements(8, 8, 1), false), Some(4096), "behind the longest");
    }

    #[test]
    fn either_of_two_fits() {
        let a = ScratchNeeds { bytes: 10, alignment: 256, memory_types: 0b110 };
        let b = ScratchNeeds { bytes: 30, alignment: 64, memory_types: 0b011 };
        assert_eq!(a.or(b), ScratchNeeds { bytes: 30, alignment: 256, memory_types: 0b010 });
        assert_eq!((a.or(b), a.or(ScratchNeeds::NONE)), (b.or(a), a));
        assert_eq!(Placing::new(64).needs(), ScratchNeeds::NONE);
    }
}
