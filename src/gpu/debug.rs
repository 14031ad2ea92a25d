//! Names of objects and labels of passes, for validation messages, RenderDoc and the like.
//!
//! Everything here does nothing where the host hands over no table of `VK_EXT_debug_utils`.

use std::ffi::{CStr, CString};

use ash::vk;

use crate::error::{Error, Result};
use crate::host::Host;

/// The functions of `VK_EXT_debug_utils`, or none where the loader lacks one of those that celfx calls (calling
/// a missing one through ash's table would end the process). For [`Host::debug`].
///
/// # Safety
///
/// `device` is a valid device of `instance`, and `VK_EXT_debug_utils` is enabled on `instance`.
pub unsafe fn table(instance: &ash::Instance, device: &ash::Device) -> Option<ash::ext::debug_utils::Device> {
    // SAFETY: the caller's.
    let missing = missing(|name| unsafe { has(instance, device, name) });
    missing.is_none().then(|| ash::ext::debug_utils::Device::new(instance, device))
}

unsafe fn has(instance: &ash::Instance, device: &ash::Device, name: &CStr) -> bool {
    // SAFETY: the caller's; the name ends in NUL.
    unsafe { (instance.fp_v1_0().get_device_proc_addr)(device.handle(), name.as_ptr()) }.is_some()
}

/// The first of the functions that celfx calls which is not there.
fn missing(has: impl Fn(&CStr) -> bool) -> Option<&'static CStr> {
    let called = [c"vkSetDebugUtilsObjectNameEXT", c"vkCmdBeginDebugUtilsLabelEXT", c"vkCmdEndDebugUtilsLabelEXT"];
    called.into_iter().find(|name| !has(name))
}

/// Refuses a table of the host's whose functions are not there: calling one would end the process.
///
/// # Safety
///
/// `host` holds valid handles.
pub(crate) unsafe fn check(host: &Host) -> Result<()> {
    // SAFETY: the caller's. A device answers for functions of extensions that are not enabled with none.
    let missing = host.debug.and_then(|_| missing(|name| unsafe { has(host.instance, host.device, name) }));
    match missing {
        None => Ok(()),
        Some(name) => {
            let name = name.to_string_lossy();
            let why = format!("the device has no {name}: enable VK_EXT_debug_utils on the instance, or leave it None");
            Err(Error::HostResource { name: "Host::debug", why })
        }
    }
}

/// Names an object. Meant for creation: long names allocate.
///
/// # Safety
///
/// `host` is valid and `object` belongs to its device.
pub unsafe fn set_name<T: vk::Handle>(host: &Host, object: T, name: &str) {
    let Some(debug) = host.debug else { return };
    let bytes: Vec<u8> = name.bytes().filter(|b| *b != 0).collect();
    let name = CString::new(bytes).unwrap_or_default();
    let info = vk::DebugUtilsObjectNameInfoEXT::default().object_handle(object).object_name(&name);
    // SAFETY: the caller's. A name that could not be kept does no harm.
    let _ = unsafe { debug.set_debug_utils_object_name(&info) };
}

/// Opens a label; allocates nothing. A name of more than [`LABEL_BYTES`] bytes is cut.
///
/// # Safety
///
/// `host` is valid and `commands` is in recording state. Each label is closed with [`end_label`] in the same command
/// buffer.
pub unsafe fn begin_label(host: &Host, commands: vk::CommandBuffer, name: &str) {
    let Some(debug) = host.debug else { return };
    let mut storage = [0; LABEL_BYTES + 1];
    let info = vk::DebugUtilsLabelEXT::default().label_name(c_string(name, &mut storage));
    // SAFETY: the caller's.
    unsafe { debug.cmd_begin_debug_utils_label(commands, &info) };
}

/// Closes the label that was opened last.
///
/// # Safety
///
/// `host` is valid, `commands` is in recording state, and [`begin_label`] was called on it.
pub unsafe fn end_label(host: &Host, commands: vk::CommandBuffer) {
    if let Some(debug) = host.debug {
        // SAFETY: the caller's.
        unsafe { debug.cmd_end_debug_utils_label(commands) };
    }
}

/// Longest label in bytes.
pub const LABEL_BYTES: usize = 127;

/// `name` up to its first NUL, cut at a character's border so that it fits, with a NUL behind it.
fn c_string<'a>(name: &str, storage: &'a mut [u8; LABEL_BYTES + 1]) -> &'a CStr {
    let mut length = name.len().min(LABEL_BYTES);
    while !name.is_char_boundary(length) {
        length -= 1;
    }
    storage[..length].copy_from_slice(&name.as_bytes()[..length]);
    storage[length] = 0;
    CStr::from_bytes_until_nul(storage).unwrap_or_default()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_table_has_all_that_is_called() {
        assert_eq!(missing(|_| true), None);
        assert_eq!(missing(|_| false), Some(c"vkSetDebugUtilsObjectNameEXT"));
        assert_eq!(missing(|name| name != c"vkCmdEndDebugUtilsLabelEXT"), Some(c"vkCmdEndDebugUtilsLabelEXT"));
    }

    #[test]
    fn labels_are_cut_at_a_character_and_end_in_nul() {
        let mut storage = [1; LABEL_BYTES + 1];
        assert_eq!(c_string("smoke.grow", &mut storage), c"smoke.grow");
        assert_eq!(c_string("", &mut storage), c"");
        assert_eq!(c_string("a\0b", &mut storage), c"a");
        let long = "\u{e9}".repeat(LABEL_BYTES);
        let cut = c_string(&long, &mut storage).to_str().expect("whole characters");
        assert_eq!(cut.len(), LABEL_BYTES - 1, "an odd limit cuts a two-byte character off");
    }
}
