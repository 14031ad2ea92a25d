//! Buffers with a name and memory of their own.

use ash::vk;
use gpu_allocator::MemoryLocation;
use gpu_allocator::vulkan::{Allocation, AllocationCreateDesc, AllocationScheme, Allocator};

use crate::error::{Error, Result};
use crate::gpu::debug;
use crate::host::Host;

/// Description of a buffer.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BufferDesc {
    /// Debug name.
    pub name: &'static str,
    /// Bytes, above 0.
    pub size: u64,
    /// Its usage.
    pub usage: vk::BufferUsageFlags,
    /// Where it lives.
    pub location: MemoryLocation,
}

impl BufferDesc {
    /// A storage buffer in device memory that can also be copied, filled and read as indirect arguments.
    pub fn storage(name: &'static str, size: u64) -> BufferDesc {
        let usage = vk::BufferUsageFlags::STORAGE_BUFFER
            | vk::BufferUsageFlags::INDIRECT_BUFFER
            | vk::BufferUsageFlags::TRANSFER_SRC
            | vk::BufferUsageFlags::TRANSFER_DST;
        BufferDesc { name, size, usage, location: MemoryLocation::GpuOnly }
    }

    /// A uniform buffer in device memory, written by updates.
    pub fn uniform(name: &'static str, size: u64) -> BufferDesc {
        let usage = vk::BufferUsageFlags::UNIFORM_BUFFER | vk::BufferUsageFlags::TRANSFER_DST;
        BufferDesc { name, size, usage, location: MemoryLocation::GpuOnly }
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
    allocation: Option<Allocation>,
}

impl Buffer {
    /// Creates the buffer and its memory; leaves nothing behind on error.
    ///
    /// # Safety
    /// `host` holds valid handles, and `allocator` belongs to its device.
    pub unsafe fn new(host: &Host, allocator: &mut Allocator, desc: &BufferDesc) -> Result<Buffer> {
        let info = vk::BufferCreateInfo::default().size(desc.size).usage(desc.usage);
        // SAFETY: the caller's.
        let handle = unsafe { host.device.create_buffer(&info, None) };
        let handle = handle.map_err(Error::vulkan("vkCreateBuffer", desc.name))?;
        // SAFETY: `handle` was just made.
        let requirements = unsafe { host.device.get_buffer_memory_requirements(handle) };
        let request = AllocationCreateDesc {
            name: desc.name,
            requirements,
            location: desc.location,
            linear: true,
            allocation_scheme: AllocationScheme::GpuAllocatorManaged,
        };
        let mut buffer = Buffer { handle, size: desc.size, desc: *desc, allocation: None };
        let bound = allocator
            .allocate(&request)
            .map_err(|source| Error::Allocation { name: desc.name.into(), bytes: requirements.size, source })
            .and_then(|allocation| {
                // SAFETY: fresh memory that fits the buffer's requirements.
                let result =
                    unsafe { host.device.bind_buffer_memory(handle, allocation.memory(), allocation.offset()) };
                buffer.allocation = Some(allocation);
                result.map_err(Error::vulkan("vkBindBufferMemory", desc.name))
            });
        if let Err(error) = bound {
            // SAFETY: never used.
            unsafe { buffer.destroy(host, allocator) };
            return Err(error);
        }
        // SAFETY: `handle` is valid.
        unsafe { debug::set_name(host, handle, desc.name) };
        Ok(buffer)
    }

    /// Its memory, if the host can see it.
    pub fn mapped(&self) -> Option<&[u8]> {
        self.allocation.as_ref()?.mapped_slice().map(|bytes| &bytes[..self.size as usize])
    }

    /// Its memory for writing, if the host can see it.
    pub fn mapped_mut(&mut self) -> Option<&mut [u8]> {
        let size = self.size as usize;
        self.allocation.as_mut()?.mapped_slice_mut().map(|bytes| &mut bytes[..size])
    }

    /// Destroys the buffer and gives its memory back.
    ///
    /// # Safety
    /// The GPU is done with it; `host` and `allocator` are those it was made with.
    pub unsafe fn destroy(&mut self, host: &Host, allocator: &mut Allocator) {
        // SAFETY: the caller's.
        unsafe { host.device.destroy_buffer(self.handle, None) };
        self.handle = vk::Buffer::null();
        if let Some(allocation) = self.allocation.take() {
            // Freeing an allocation that the allocator made does not fail.
            let _ = allocator.free(allocation);
        }
    }
}
