//! Which buffers and images an effect has, and the memory that they take.

use crate::gpu::buffer::BufferDesc;
use crate::gpu::image::ImageDesc;
use crate::gpu::scratch::{Lifetime, Overlay};
use crate::host::{HostBuffer, Memory};
use crate::plan::{BufferId, Resource};

/// Which buffers and images an effect has, by their ids: own ones first, then those that the host hands over.
pub trait Inventory {
    /// Description of the effect.
    type Desc;
    /// How many buffers the host hands over.
    const HOST_BUFFERS: usize;
    /// How many images the host hands over.
    const HOST_IMAGES: usize;

    /// The own buffers.
    fn buffers(&self, desc: &Self::Desc) -> Vec<BufferDesc>;

    /// The own images.
    fn images(&self, desc: &Self::Desc) -> Vec<ImageDesc>;

    /// Buffers of the host's that kernels read in place: they stay the same from frame to frame.
    fn bound(&self, _: &Self::Desc) -> Vec<(BufferId, HostBuffer)> {
        Vec::new()
    }

    /// What of their scratch lies in the same place, one after the other.
    fn overlays(&self, _: &Self::Desc) -> Vec<Overlay> {
        Vec::new()
    }

    /// The memory of both, before alignment.
    fn memory(&self, desc: &Self::Desc) -> Memory {
        let buffers = self.buffers(desc).into_iter().map(|buffer| (buffer.lifetime, buffer.size, 0));
        let images = self.images(desc).into_iter().map(|image| (image.lifetime, image.bytes(), image.bytes()));
        let mut memory = Memory::default();
        for (lifetime, bytes, of_images) in buffers.chain(images) {
            match lifetime {
                Lifetime::Scratch | Lifetime::Layer => memory.scratch += bytes,
                Lifetime::Sequence | Lifetime::Kept => memory.history += bytes,
            }
            memory.images += of_images;
        }
        for overlay in self.overlays(desc) {
            let group = |group: &Vec<Resource>| group.iter().map(|resource| self.bytes(desc, *resource)).sum::<u64>();
            let groups = || overlay.iter().map(group);
            memory.scratch -= groups().sum::<u64>() - groups().max().unwrap_or(0);
        }
        memory
    }

    /// Bytes of a buffer or image, before alignment.
    fn bytes(&self, desc: &Self::Desc, resource: Resource) -> u64 {
        match resource {
            Resource::Buffer(id) => self.buffers(desc)[usize::from(id.0)].size,
            Resource::Image(id) => self.images(desc)[usize::from(id.0)].bytes(),
        }
    }
}
