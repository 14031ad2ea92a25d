//! Errors, said so that the reader knows what to change.

use std::borrow::Cow;

use ash::vk;

/// Result of the library's fallible functions.
pub type Result<T> = std::result::Result<T, Error>;

/// Errors of the library. Each names the setting, image, buffer or Vulkan call, and what to do about it.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum Error {
    /// A setting is outside what is allowed.
    #[error("{name} = {value}: {allowed}")]
    Setting {
        /// Key as in the shot file, e.g. `smoke.sigma`.
        name: Cow<'static, str>,
        /// The value that was given.
        value: String,
        /// The allowed values, with unit.
        allowed: String,
    },
    /// Something is larger than this device can take.
    #[error("{what} needs {needed}, this device allows {limit}; {advice}")]
    Limit {
        /// The quantity that is too large.
        what: &'static str,
        /// The need, with unit.
        needed: u64,
        /// The device's limit, same unit.
        limit: u64,
        /// The change that helps.
        advice: &'static str,
    },
    /// An image or a buffer that the host handed over does not fit.
    #[error("{name}: {why}")]
    HostResource {
        /// Which of the host's resources.
        name: &'static str,
        /// The fault, and what is expected.
        why: String,
    },
    /// The device lacks something; everything that is missing is named at once.
    #[error("the device cannot run celfx: {}", missing.join("; "))]
    Device {
        /// The missing capabilities, one entry each.
        missing: Vec<String>,
    },
    /// A Vulkan call failed.
    #[error("{call}{}: {result}", object.as_deref().map(|o| format!(" ({o})")).unwrap_or_default())]
    Vulkan {
        /// The call.
        call: &'static str,
        /// The object or pass it was for, if any.
        object: Option<String>,
        /// Vulkan's result.
        result: vk::Result,
    },
    /// The caller of a host without a window asked to stop while it waited.
    #[error("interrupted at {what}")]
    Interrupted {
        /// The work that was waited for, or would have been next.
        what: String,
    },
    /// Device memory could not be had.
    #[error("no memory for {name} ({bytes} bytes): {source}")]
    Allocation {
        /// The buffer or image.
        name: String,
        /// Its size in bytes.
        bytes: u64,
        /// The source's error.
        source: Box<dyn std::error::Error + Send + Sync>,
    },
}

impl Error {
    /// For `map_err`: names the call, and the object or pass it was for.
    pub(crate) fn vulkan(call: &'static str, object: impl Into<String>) -> impl FnOnce(vk::Result) -> Error {
        let object = object.into();
        move |result| Error::Vulkan { call, object: Some(object).filter(|o| !o.is_empty()), result }
    }

    /// Whether the device is lost, and so done with all that it was given.
    #[cfg(feature = "cli")]
    pub(crate) fn is_lost(&self) -> bool {
        matches!(self, Error::Vulkan { result: vk::Result::ERROR_DEVICE_LOST, .. })
    }

    /// A setting outside of what is allowed.
    pub(crate) fn setting(
        name: impl Into<Cow<'static, str>>,
        value: impl ToString,
        allowed: impl Into<String>,
    ) -> Error {
        Error::Setting { name: name.into(), value: value.to_string(), allowed: allowed.into() }
    }
}
