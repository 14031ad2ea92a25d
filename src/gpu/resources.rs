//! The resources behind plans' ids: the effect's own buffers and images, and those that the host hands over each frame.

use ash::vk;

use crate::error::Result;
use crate::gpu::buffer::{Buffer, BufferDesc};
use crate::gpu::image::{Image, ImageDesc};
use crate::gpu::scratch::{Lifetime, Overlay, Placing, Scratch, ScratchNeeds, Shared};
use crate::host::{Host, HostBuffer, HostImage, MemorySource, aspect_of};
use crate::plan::{BufferId, ImageId, Resource};

/// A buffer as the recorder sees it.
#[derive(Debug)]
pub enum BufferSlot {
    /// Made by celfx.
    Own(Buffer),
    /// The host's, for the frame being recorded.
    Host(Option<HostBuffer>),
}

/// An image as the recorder sees it.
#[derive(Debug)]
pub enum ImageSlot {
    /// Made by celfx; in layout GENERAL between frames, once initialised.
    Own(Image),
    /// The host's, for the frame being recorded.
    Host(Option<HostImage>),
}

/// Everything that an effect's plans name.
#[derive(Debug, Default)]
pub struct Resources {
    /// By [`BufferId`].
    pub buffers: Vec<BufferSlot>,
    /// By [`ImageId`].
    pub images: Vec<ImageSlot>,
    /// Where those of them lie that frames begin without.
    pub(crate) scratch: Option<Scratch>,
    /// What of it lies in the same place.
    pub(crate) overlays: Vec<Overlay>,
}

/// Which own buffers and images stay when a description changes, by their ids.
#[derive(Debug)]
pub struct Kept {
    buffers: Vec<bool>,
    images: Vec<bool>,
    /// Whether all does that a sequence goes on from.
    sequence: bool,
    /// Whether scratch memory does, with all in it.
    scratch: bool,
}

impl Kept {
    /// Those whose description stays the same; of those in scratch memory, which is to be that of `shared`, all or none.
    pub(crate) fn new(
        resources: &Resources,
        buffers: &[BufferDesc],
        images: &[ImageDesc],
        overlays: &[Overlay],
        shared: Option<Shared>,
    ) -> Kept {
        let buffer = |(id, new): (usize, &BufferDesc)| match resources.buffers.get(id) {
            Some(BufferSlot::Own(old)) => (new.lifetime, old.desc == *new),
            _ => (new.lifetime, false),
        };
        let image = |(id, new): (usize, &ImageDesc)| match resources.images.get(id) {
            Some(ImageSlot::Own(old)) => (new.lifetime, old.desc == *new),
            _ => (new.lifetime, false),
        };
        let buffers: Vec<_> = buffers.iter().enumerate().map(buffer).collect();
        let images: Vec<_> = images.iter().enumerate().map(image).collect();
        let all = |of: Lifetime| buffers.iter().chain(&images).all(|(lifetime, same)| *lifetime != of || *same);
        let is_there = resources.scratch.as_ref().is_some_and(|scratch| scratch.shared == shared);
        let in_place = is_there && resources.overlays == overlays;
        let (sequence, scratch) = (all(Lifetime::Sequence), in_place && all(Lifetime::Scratch));
        let stays = |(lifetime, same): &(Lifetime, bool)| *same && (*lifetime != Lifetime::Scratch || scratch);
        let [buffers, images] = [&buffers, &images].map(|slots| slots.iter().map(stays).collect());
        Kept { buffers, images, sequence, scratch }
    }

    /// Whether all stays that a sequence goes on from, with what it holds.
    pub fn sequence(&self) -> bool {
        self.sequence
    }

    /// Whether a buffer stays, with what it holds.
    pub fn buffer(&self, id: BufferId) -> bool {
        self.buffers.get(usize::from(id.0)).copied().unwrap_or(false)
    }

    /// Whether an image stays, with what it holds.
    pub fn image(&self, id: ImageId) -> bool {
        self.images.get(usize::from(id.0)).copied().unwrap_or(false)
    }

    /// Whether all of it stays.
    pub(crate) fn is_all(&self) -> bool {
        self.buffers.iter().chain(&self.images).all(|kept| *kept)
    }

    /// Exchanges what stays: it has one owner. Once more, and it is back.
    pub(crate) fn exchange(&self, a: &mut Resources, b: &mut Resources) {
        for (id, _) in self.buffers.iter().enumerate().filter(|(_, kept)| **kept) {
            std::mem::swap(&mut a.buffers[id], &mut b.buffers[id]);
        }
        for (id, _) in self.images.iter().enumerate().filter(|(_, kept)| **kept) {
            std::mem::swap(&mut a.images[id], &mut b.images[id]);
        }
        if self.scratch {
            std::mem::swap(&mut a.scratch, &mut b.scratch);
        }
    }
}

impl Resources {
    /// Makes a buffer; its id is the next.
    ///
    /// # Safety
    /// As [`Buffer::new`].
    pub unsafe fn add_buffer(
        &mut self,
        host: &Host,
        allocator: &mut dyn MemorySource,
        desc: &BufferDesc,
    ) -> Result<BufferId> {
        // SAFETY: the caller's.
        let buffer = unsafe { Buffer::new(host, allocator, desc)? };
        self.buffers.push(BufferSlot::Own(buffer));
        Ok(BufferId(self.buffers.len() as u16 - 1))
    }

    /// Makes an image; its id is the next.
    ///
    /// # Safety
    /// As [`Image::new`].
    pub unsafe fn add_image(
        &mut self,
        host: &Host,
        allocator: &mut dyn MemorySource,
        desc: &ImageDesc,
    ) -> Result<ImageId> {
        // SAFETY: the caller's.
        let image = unsafe { Image::new(host, allocator, desc)? };
        self.images.push(ImageSlot::Own(image));
        Ok(ImageId(self.images.len() as u16 - 1))
    }

    /// Makes a buffer that is to lie in scratch memory; its id is the next.
    ///
    /// # Safety
    /// As [`Buffer::unbound`].
    pub(crate) unsafe fn add_scratch_buffer(&mut self, host: &Host, desc: &BufferDesc) -> Result<()> {
        // SAFETY: the caller's.
        self.buffers.push(BufferSlot::Own(unsafe { Buffer::unbound(host, desc)? }));
        Ok(())
    }

    /// Makes an image that is to lie in scratch memory; its id is the next.
    ///
    /// # Safety
    /// As [`Image::unbound`].
    pub(crate) unsafe fn add_scratch_image(&mut self, host: &Host, desc: &ImageDesc) -> Result<()> {
        // SAFETY: the caller's.
        self.images.push(ImageSlot::Own(unsafe { Image::unbound(host, desc)? }));
        Ok(())
    }

    /// Where what is to lie in scratch memory would lie: nowhere, if no memory suits it and the rest.
    ///
    /// # Safety
    /// `host` is the one it was made with.
    pub(crate) unsafe fn place(&self, host: &Host) -> (ScratchNeeds, Vec<(Resource, Option<u64>)>) {
        // SAFETY: the caller's.
        let properties = unsafe { host.instance.get_physical_device_properties(host.physical_device) };
        let mut placing = Placing::new(properties.limits.buffer_image_granularity);
        let is_alone = |resource: &Resource| !self.overlays.iter().flatten().flatten().any(|over| over == resource);
        let buffers = (0..self.buffers.len() as u16).map(|id| Resource::Buffer(BufferId(id)));
        let images = (0..self.images.len() as u16).map(|id| Resource::Image(ImageId(id)));
        // SAFETY: the caller's.
        let requirements = |resource: &Resource| unsafe { self.scratch_requirements(host, *resource) };
        let mut places = Vec::new();
        for resource in buffers.filter(is_alone) {
            places.extend(requirements(&resource).map(|needs| (resource, placing.place(&needs, false))));
        }
        for overlay in &self.overlays {
            let groups: Vec<Vec<_>> =
                overlay.iter().map(|group| group.iter().filter_map(requirements).collect()).collect();
            let over = overlay.iter().flatten().filter(|resource| requirements(resource).is_some());
            places.extend(over.copied().zip(placing.overlay(&groups)));
        }
        for resource in images.filter(is_alone) {
            places.extend(requirements(&resource).map(|needs| (resource, placing.place(&needs, true))));
        }
        (placing.needs(), places)
    }

    /// What the memory of a buffer or image must be that is to lie in scratch memory; none of others.
    unsafe fn scratch_requirements(&self, host: &Host, resource: Resource) -> Option<vk::MemoryRequirements> {
        let is_scratch = |lifetime| lifetime == Lifetime::Scratch;
        // SAFETY: the caller's.
        unsafe {
            match resource {
                Resource::Buffer(id) => match &self.buffers[usize::from(id.0)] {
                    BufferSlot::Own(own) if is_scratch(own.desc.lifetime) => Some(own.requirements(host)),
                    _ => None,
                },
                Resource::Image(id) => match &self.images[usize::from(id.0)] {
                    ImageSlot::Own(own) if is_scratch(own.desc.lifetime) => Some(own.requirements(host)),
                    _ => None,
                },
            }
        }
    }

    /// Takes scratch memory for what is to lie there, if anything is, that is named so: that of `shared`, or of its own.
    ///
    /// # Safety
    /// As [`Buffer::new`]; nothing of it has memory.
    pub(crate) unsafe fn bind_scratch(
        &mut self,
        host: &Host,
        allocator: &mut dyn MemorySource,
        name: &str,
        shared: Option<Shared>,
    ) -> Result<()> {
        // SAFETY: the caller's.
        let (needs, places) = unsafe { self.place(host) };
        if places.is_empty() {
            return Ok(());
        }
        let range = self.scratch.insert(Scratch::new(allocator, &needs, name, shared)?).range;
        for (resource, place) in places {
            let offset = place.map(|place| range.offset + place);
            // SAFETY: each place fits what was placed there.
            unsafe {
                match resource {
                    Resource::Buffer(id) => match (&mut self.buffers[usize::from(id.0)], offset) {
                        (BufferSlot::Own(own), Some(offset)) => own.bind(host, range.memory, offset)?,
                        (BufferSlot::Own(own), None) => own.bind_own(host, allocator)?,
                        (BufferSlot::Host(_), _) => {}
                    },
                    Resource::Image(id) => match (&mut self.images[usize::from(id.0)], offset) {
                        (ImageSlot::Own(own), Some(offset)) => own.bind(host, range.memory, offset)?,
                        (ImageSlot::Own(own), None) => own.bind_own(host, allocator)?,
                        (ImageSlot::Host(_), _) => {}
                    },
                }
            }
        }
        Ok(())
    }

    /// Room for a buffer of the host's.
    pub fn add_host_buffer(&mut self) -> BufferId {
        self.buffers.push(BufferSlot::Host(None));
        BufferId(self.buffers.len() as u16 - 1)
    }

    /// Room for an image of the host's.
    pub fn add_host_image(&mut self) -> ImageId {
        self.images.push(ImageSlot::Host(None));
        ImageId(self.images.len() as u16 - 1)
    }

    /// Forgets what own images hold: they are initialised once more.
    pub(crate) fn forget(&mut self) {
        for slot in &mut self.images {
            if let ImageSlot::Own(image) = slot {
                image.initialised = false;
            }
        }
    }

    /// Takes all images of the host's back.
    #[cfg(feature = "cli")]
    pub(crate) fn take_back_images(&mut self) {
        for slot in &mut self.images {
            if let ImageSlot::Host(image) = slot {
                *image = None;
            }
        }
    }

    /// Hands over a buffer for the frame about to be recorded, or takes it back.
    pub fn set_host_buffer(&mut self, id: BufferId, buffer: Option<HostBuffer>) {
        self.buffers[usize::from(id.0)] = BufferSlot::Host(buffer);
    }

    /// Hands over an image for the frame about to be recorded, or takes it back.
    pub fn set_host_image(&mut self, id: ImageId, image: Option<HostImage>) {
        self.images[usize::from(id.0)] = ImageSlot::Host(image);
    }

    /// Handle, offset and size of a buffer; null if the host handed none over.
    pub fn buffer(&self, id: BufferId) -> (vk::Buffer, u64, u64) {
        match &self.buffers[usize::from(id.0)] {
            BufferSlot::Own(buffer) => (buffer.handle, 0, buffer.size),
            BufferSlot::Host(Some(buffer)) => (buffer.buffer, buffer.offset, buffer.size),
            BufferSlot::Host(None) => (vk::Buffer::null(), 0, 0),
        }
    }

    /// Handle of an image; null if the host handed none over.
    pub fn image(&self, id: ImageId) -> vk::Image {
        match &self.images[usize::from(id.0)] {
            ImageSlot::Own(image) => image.handle,
            ImageSlot::Host(image) => image.as_ref().map_or(vk::Image::null(), |i| i.image),
        }
    }

    /// The levels and layers of an image that plans touch; none if the host handed none over.
    pub fn range(&self, id: ImageId) -> vk::ImageSubresourceRange {
        match &self.images[usize::from(id.0)] {
            ImageSlot::Own(image) => range_of(image),
            ImageSlot::Host(Some(image)) => vk::ImageSubresourceRange {
                aspect_mask: aspect_of(image.format),
                base_mip_level: image.base_mip,
                level_count: 1,
                base_array_layer: image.base_layer,
                layer_count: 1,
            },
            ImageSlot::Host(None) => vk::ImageSubresourceRange::default(),
        }
    }

    /// Where the picture begins in an image.
    pub fn offset(&self, id: ImageId) -> [u32; 2] {
        match &self.images[usize::from(id.0)] {
            ImageSlot::Host(Some(image)) => image.offset,
            ImageSlot::Host(None) | ImageSlot::Own(_) => [0; 2],
        }
    }

    /// The view that a render pass attaches.
    pub fn attachment_view(&self, id: ImageId, layer: u32) -> vk::ImageView {
        match &self.images[usize::from(id.0)] {
            ImageSlot::Own(image) => image.layer_views[layer as usize],
            ImageSlot::Host(image) => image.as_ref().map_or(vk::ImageView::null(), |i| i.view),
        }
    }

    /// The view that a descriptor holds; only own images are bound.
    pub fn descriptor_view(&self, id: ImageId) -> vk::ImageView {
        match &self.images[usize::from(id.0)] {
            ImageSlot::Own(image) => image.view,
            ImageSlot::Host(_) => vk::ImageView::null(),
        }
    }

    /// Destroys what celfx made; the host's are only forgotten.
    ///
    /// # Safety
    /// The GPU is done with all of it; `host` and `allocator` are those it was made with.
    pub unsafe fn destroy(&mut self, host: &Host, allocator: &mut dyn MemorySource) {
        for slot in &mut self.buffers.drain(..) {
            if let BufferSlot::Own(mut buffer) = slot {
                // SAFETY: the caller's.
                unsafe { buffer.destroy(host, allocator) };
            }
        }
        for slot in &mut self.images.drain(..) {
            if let ImageSlot::Own(mut image) = slot {
                // SAFETY: the caller's.
                unsafe { image.destroy(host, allocator) };
            }
        }
        if let Some(scratch) = self.scratch.take() {
            scratch.destroy(allocator);
        }
    }
}

/// All of an own image.
pub(crate) fn range_of(image: &Image) -> vk::ImageSubresourceRange {
    vk::ImageSubresourceRange {
        aspect_mask: image.aspect,
        base_mip_level: 0,
        level_count: 1,
        base_array_layer: 0,
        layer_count: image.desc.layers,
    }
}
