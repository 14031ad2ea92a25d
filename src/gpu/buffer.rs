//! Buffers with a name, and memory of their own or a place in scratch memory.

use ash::vk;

use crate::error::{Error, Result};
use crate::gpu::debug;
use crate::gpu::scratch::Lifetime;
use crate::host::{Allocation, Host, MemoryRequest, MemorySource};

/// Memory that the host writes and the device reads.
pub const UPLOADED: vk::MemoryPropertyFlags = vk::MemoryPropertyFlags::from_raw(
    vk::MemoryPropertyFlags::HOST_VISIBLE.as_raw() | vk::MemoryPropertyFlags::HOST_COHERENT.as_raw(),
);

/// Memory that the device writes and the host reads.
pub const READ_BACK: vk::MemoryPropertyFlags =
    vk::MemoryPropertyFlags::from_raw(UPLOADED.as_raw() | vk::MemoryPropertyFlags::HOST_CACHED.as_raw());

/// Description of a buffer.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BufferDesc {
    /// Debug name.
    pub name: &'static str,
    /// Bytes, above 0.
    pub size: u64,
    /// Its usage.
    pub usage: vk::BufferUsageFlags,
    /// Properties of its memory.
    pub properties: vk::MemoryPropertyFlags,
    /// How long what it holds is needed.
    pub lifetime: Lifetime,
}

impl BufferDesc {
    /// A storage buffer in device memory that can also be copied, filled and read as indirect arguments.
    pub fn storage(name: &'static str, size: u64) -> BufferDesc {
        let usage = vk::BufferUsageFlags::STORAGE_BUFFER
            | vk::BufferUsageFlags::INDIRECT_BUFFER
            | vk::BufferUsageFlags::TRANSFER_SRC
            | vk::BufferUsageFlags::TRANSFER_DST;
        BufferDesc { name, size, usage, properties: vk::MemoryPropertyFlags::DEVICE_LOCAL, lifetime: Lifetime::Kept }
    }

    /// A uniform buffer in device memory, written by updates.
    pub fn uniform(name: &'static str, size: u64) -> BufferDesc {
        let usage = vk::BufferUsageFlags::UNIFORM_BUFFER | vk::BufferUsageFlags::TRANSFER_DST;
        BufferDesc { name, size, usage, properties: vk::MemoryPropertyFlags::DEVICE_LOCAL, lifetime: Lifetime::Kept }
    }
}

/// A buffer that celfx made.
#[derive(Debug)]
pub struct Buffer {
    /// The handle.
    pub handle: vk::Buffer,
    /// Bytes.
    pub size: u64,
    /// What it was made as.
    pub desc: BufferDesc,
    /// Memory of its own, if it is not in scratch memory.
    allocation: Option<Allocation>,
}

impl Buffer {
    /// Creates the buffer and its memory; leaves nothing behind on error.
    ///
    /// # Safety
    /// `host` holds valid handles, and `allocator` belongs to its device.
    pub unsafe fn new(host: &Host, allocator: &mut dyn MemorySource, desc: &BufferDesc) -> Result<Buffer> {
        // SAFETY: the caller's; never used before it is destroyed.
        unsafe {
            let mut buffer = Buffer::unbound(host, desc)?;
            match buffer.bind_own(host, allocator) {
                Ok(()) => Ok(buffer),
                Err(error) => {
                    buffer.destroy(host, allocator);
                    Err(error)
                }
            }
        }
    }

    /// Creates the buffer alone.
    ///
    /// # Safety
    /// `host` holds valid handles.
    pub(crate) unsafe fn unbound(host: &Host, desc: &BufferDesc) -> Result<Buffer> {
        let info = vk::BufferCreateInfo::default().size(desc.size).usage(desc.usage);
        // SAFETY: the caller's.
        let handle = unsafe { host.device.create_buffer(&info, None) };
        let handle = handle.map_err(Error::vulkan("vkCreateBuffer", desc.name))?;
        // SAFETY: `handle` is valid.
        unsafe { debug::set_name(host, handle, desc.name) };
        Ok(Buffer { handle, size: desc.size, desc: *desc, allocation: None })
    }

    /// What its memory must be.
    ///
    /// # Safety
    /// `host` is the one it was made with.
    pub(crate) unsafe fn requirements(&self, host: &Host) -> vk::MemoryRequirements {
        // SAFETY: the caller's.
        unsafe { host.device.get_buffer_memory_requirements(self.handle) }
    }

    /// Takes memory of its own.
    ///
    /// # Safety
    /// As [`Buffer::new`]; it has none.
    pub(crate) unsafe fn bind_own(&mut self, host: &Host, allocator: &mut dyn MemorySource) -> Result<()> {
        let BufferDesc { name, properties, .. } = self.desc;
        // SAFETY: the caller's.
        let requirements = unsafe { self.requirements(host) };
        let allocation = allocator.allocate(&MemoryRequest { name, requirements, properties, linear: true })?;
        // SAFETY: fresh memory that fits the buffer's requirements.
        let bound = unsafe { self.bind(host, allocation.memory, allocation.offset) };
        self.allocation = Some(allocation);
        bound
    }

    /// Takes this memory.
    ///
    /// # Safety
    /// It has none; this fits its requirements.
    pub(crate) unsafe fn bind(&mut self, host: &Host, memory: vk::DeviceMemory, offset: u64) -> Result<()> {
        // SAFETY: the caller's.
        let bound = unsafe { host.device.bind_buffer_memory(self.handle, memory, offset) };
        bound.map_err(Error::vulkan("vkBindBufferMemory", self.desc.name))
    }

    /// Its memory, if the host can see it.
    pub fn mapped(&self) -> Option<&[u8]> {
        let mapped = self.allocation.as_ref()?.mapped?;
        // SAFETY: the source has mapped all of the allocation, which the buffer borrows.
        Some(unsafe { std::slice::from_raw_parts(mapped.as_ptr(), self.size as usize) })
    }

    /// Its memory for writing, if the host can see it.
    pub fn mapped_mut(&mut self) -> Option<&mut [u8]> {
        let mapped = self.allocation.as_mut()?.mapped?;
        // SAFETY: as above, and nothing else refers to it.
        Some(unsafe { std::slice::from_raw_parts_mut(mapped.as_ptr(), self.size as usize) })
    }

    /// Destroys the buffer and gives its memory back.
    ///
    /// # Safety
    /// The GPU is done with it; `host` and `allocator` are those it was made with.
    pub unsafe fn destroy(&mut self, host: &Host, allocator: &mut dyn MemorySource) {
        // SAFETY: the caller's.
        unsafe { host.device.destroy_buffer(self.handle, None) };
        self.handle = vk::Buffer::null();
        if let Some(allocation) = self.allocation.take() {
            allocator.free(allocation);
        }
    }
}
