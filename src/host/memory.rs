//! Where memory comes from.

use std::any::Any;
use std::ffi::{CStr, CString, c_char, c_void};
use std::ptr::NonNull;

use ash::vk;
use gpu_allocator::MemoryLocation;
use gpu_allocator::vulkan::{AllocationCreateDesc, AllocationScheme, Allocator};

use crate::error::{Error, Result};

/// Where the memory of buffers and images comes from: [`Allocator`], [`MemoryCallbacks`], or the host's own.
///
/// Effects ask for memory in `new`, `change` and `resize` only, and give it back in `destroy`. Pipelines are made before: an allocator
/// that is locked is not held while they are, if the host has called [`crate::effect::Effect::compile`].
pub trait MemorySource {
    /// A range of device memory.
    ///
    /// # Errors
    /// [`Error::Allocation`]: there is none.
    fn allocate(&mut self, request: &MemoryRequest) -> Result<Allocation>;

    /// Takes a range back, whose buffer or image has been destroyed.
    fn free(&mut self, allocation: Allocation);
}

/// What memory is asked for.
#[derive(Clone, Copy, Debug)]
#[non_exhaustive]
pub struct MemoryRequest<'a> {
    /// Name of the buffer or image.
    pub name: &'a str,
    /// What Vulkan says of it.
    pub requirements: vk::MemoryRequirements,
    /// What the memory must be. Effects ask for `DEVICE_LOCAL` alone; memory that is `HOST_VISIBLE` is `HOST_COHERENT`, and must be
    /// mapped.
    pub properties: vk::MemoryPropertyFlags,
    /// Whether it is a buffer's, and not an image's: what lies on the same page of `bufferImageGranularity` must be of one kind.
    pub linear: bool,
}

/// A range of device memory.
#[derive(Debug)]
pub struct Allocation {
    /// The memory that it is a part of.
    pub memory: vk::DeviceMemory,
    /// Its first byte there.
    pub offset: u64,
    /// Its bytes.
    pub size: u64,
    /// Where the host sees it, if it does.
    pub mapped: Option<NonNull<u8>>,
    /// What its source knows it by.
    pub own: Box<dyn Any + Send + Sync>,
}

// SAFETY: what is mapped is reached through references to the allocation alone, which borrow rules guard.
unsafe impl Send for Allocation {}
// SAFETY: as above.
unsafe impl Sync for Allocation {}

impl MemoryRequest<'_> {
    /// The error that says that there is no such memory.
    pub fn refused(&self, source: impl Into<Box<dyn std::error::Error + Send + Sync>>) -> Error {
        Error::Allocation { name: self.name.to_owned(), bytes: self.requirements.size, source: source.into() }
    }
}

impl MemorySource for Allocator {
    fn allocate(&mut self, request: &MemoryRequest) -> Result<Allocation> {
        let is = |flag| request.properties.contains(flag);
        let location = match () {
            _ if !is(vk::MemoryPropertyFlags::HOST_VISIBLE) => MemoryLocation::GpuOnly,
            _ if is(vk::MemoryPropertyFlags::HOST_CACHED) => MemoryLocation::GpuToCpu,
            _ => MemoryLocation::CpuToGpu,
        };
        let description = AllocationCreateDesc {
            name: request.name,
            requirements: request.requirements,
            location,
            linear: request.linear,
            allocation_scheme: AllocationScheme::GpuAllocatorManaged,
        };
        let own = Allocator::allocate(self, &description).map_err(|source| request.refused(source))?;
        // SAFETY: not freed before the allocation is.
        let memory = unsafe { own.memory() };
        let (offset, size, mapped) = (own.offset(), own.size(), own.mapped_ptr().map(NonNull::cast));
        Ok(Allocation { memory, offset, size, mapped, own: Box::new(own) })
    }

    fn free(&mut self, allocation: Allocation) {
        if let Ok(own) = allocation.own.downcast::<gpu_allocator::vulkan::Allocation>() {
            // Freeing an allocation that the allocator made does not fail.
            let _ = Allocator::free(self, *own);
        }
    }
}

/// A [`MemoryRequest`] for functions of other languages.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct CallbackRequest {
    /// Name of the buffer or image, in UTF-8; valid during the call.
    pub name: *const c_char,
    /// As [`MemoryRequest::requirements`].
    pub requirements: vk::MemoryRequirements,
    /// As [`MemoryRequest::properties`].
    pub properties: vk::MemoryPropertyFlags,
    /// As [`MemoryRequest::linear`]: 0 or 1.
    pub linear: vk::Bool32,
}

/// An [`Allocation`] for functions of other languages.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct CallbackAllocation {
    /// As [`Allocation::memory`].
    pub memory: vk::DeviceMemory,
    /// As [`Allocation::offset`].
    pub offset: u64,
    /// As [`Allocation::size`].
    pub size: u64,
    /// As [`Allocation::mapped`]; null if the host does not see it.
    pub mapped: *mut c_void,
    /// What the source knows it by, such as a `VmaAllocation`.
    pub own: *mut c_void,
}

/// Memory from two functions, such as a pair that calls the Vulkan Memory Allocator.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct MemoryCallbacks {
    /// Handed to both.
    pub user: *mut c_void,
    /// Fills in an allocation; anything but `VK_SUCCESS` is an error, and nothing is filled in.
    pub allocate: unsafe extern "C" fn(*mut c_void, *const CallbackRequest, *mut CallbackAllocation) -> vk::Result,
    /// Takes one back.
    pub free: unsafe extern "C" fn(*mut c_void, *const CallbackAllocation),
}

/// The pointer by which a source knows an allocation.
struct Known(*mut c_void);

// SAFETY: it is only handed back to the source.
unsafe impl Send for Known {}
// SAFETY: as above.
unsafe impl Sync for Known {}

impl MemorySource for MemoryCallbacks {
    fn allocate(&mut self, request: &MemoryRequest) -> Result<Allocation> {
        let name = CString::new(request.name).unwrap_or_default();
        let asked = CallbackRequest {
            name: CStr::as_ptr(&name),
            requirements: request.requirements,
            properties: request.properties,
            linear: request.linear.into(),
        };
        let mut given = CallbackAllocation {
            memory: vk::DeviceMemory::null(),
            offset: 0,
            size: 0,
            mapped: std::ptr::null_mut(),
            own: std::ptr::null_mut(),
        };
        // SAFETY: the host's functions, with what they ask for.
        match unsafe { (self.allocate)(self.user, &asked, &mut given) } {
            vk::Result::SUCCESS => Ok(Allocation {
                memory: given.memory,
                offset: given.offset,
                size: given.size,
                mapped: NonNull::new(given.mapped.cast()),
                own: Box::new(Known(given.own)),
            }),
            result => Err(request.refused(result)),
        }
    }

    fn free(&mut self, allocation: Allocation) {
        let own = allocation.own.downcast::<Known>().map_or(std::ptr::null_mut(), |known| known.0);
        let mapped = allocation.mapped.map_or(std::ptr::null_mut(), |mapped| mapped.as_ptr().cast());
        let Allocation { memory, offset, size, .. } = allocation;
        let given = CallbackAllocation { memory, offset, size, mapped, own };
        // SAFETY: an allocation of the host's, which nothing uses any more.
        unsafe { (self.free)(self.user, &given) };
    }
}
