//! Which devices there are, what each lacks, and which is used.

use std::ffi::CStr;
use std::fmt;

use ash::vk;
use serde::Serialize;

use super::NoDevice;
use super::instance::{Instance, failed};
use crate::gpu::capabilities::check_device;
use crate::host::{requirements, version};

/// A device, for people and scripts.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
#[non_exhaustive]
pub struct DeviceInfo {
    /// Place in the loader's list, from 0; what `--device` takes.
    pub index: usize,
    /// Its name.
    pub name: String,
    /// `discrete GPU`, `integrated GPU`, `virtual GPU`, `CPU` or `other`.
    #[serde(rename = "type")]
    pub kind: &'static str,
    /// Name of its driver.
    pub driver: String,
    /// The driver's own description, usually its version.
    pub driver_info: String,
    /// Version of Vulkan.
    pub api_version: String,
    /// The capabilities that it lacks to run celfx; empty if none.
    pub lacks: Vec<String>,
    /// Whether it is the one that would be used.
    pub used: bool,
}

impl fmt::Display for DeviceInfo {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let DeviceInfo { index, name, kind, driver, driver_info, api_version, lacks, used } = self;
        let mark = if *used { "*" } else { " " };
        write!(f, "{mark} {index}: {name} ({kind}), {driver} {driver_info}, Vulkan {api_version}")?;
        match lacks.is_empty() {
            true => Ok(()),
            false => write!(f, "\n     lacks {}", lacks.join("; ")),
        }
    }
}

/// The output of `celfx info`.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
#[non_exhaustive]
pub struct Report {
    /// Version of the Vulkan loader.
    pub loader: String,
    /// Version of the validation layer, if it is installed.
    pub validation_layer: Option<String>,
    /// All devices, in the loader's order.
    pub devices: Vec<DeviceInfo>,
}

impl fmt::Display for Report {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        writeln!(f, "Vulkan loader {}", self.loader)?;
        let layer = self.validation_layer.as_deref();
        writeln!(f, "validation layer {}", layer.unwrap_or("not installed (vulkan-validationlayers)"))?;
        writeln!(f, "devices (*: the one that is used)")?;
        self.devices.iter().try_for_each(|device| writeln!(f, "{device}"))
    }
}

/// All devices, what each lacks, and which would be used for `--device` of `wanted`. None is marked as used if none
/// can be.
pub fn report(wanted: Option<&str>) -> Result<Report, NoDevice> {
    let instance = Instance::new(false)?;
    let candidates = list(&instance)?;
    let used = match choose(&candidates, wanted) {
        Ok(used) => Some(used),
        Err(NoDevice::NoneUsable { .. }) => None,
        Err(error) => return Err(error),
    };
    let devices = candidates.into_iter().enumerate().map(|(i, c)| DeviceInfo { used: Some(i) == used, ..c.info });
    Ok(Report {
        loader: version(instance.loader),
        validation_layer: instance.validation_layer.map(version),
        devices: devices.collect(),
    })
}

/// Whether a device says what pipelines cost.
pub(super) fn has_costs(instance: &Instance, device: vk::PhysicalDevice) -> bool {
    let name = vk::KHR_PIPELINE_EXECUTABLE_PROPERTIES_NAME;
    // SAFETY: a device of this instance. A list that cannot be read has nothing.
    let extensions = unsafe { instance.raw.enumerate_device_extension_properties(device) }.unwrap_or_default();
    if !extensions.iter().any(|extension| extension.extension_name_as_c_str() == Ok(name)) {
        return false;
    }
    let mut executables = vk::PhysicalDevicePipelineExecutablePropertiesFeaturesKHR::default();
    let mut features = vk::PhysicalDeviceFeatures2::default().push_next(&mut executables);
    // SAFETY: as above; the extension is there.
    unsafe { instance.raw.get_physical_device_features2(device, &mut features) };
    executables.pipeline_executable_info == vk::TRUE
}

/// Whether all stages of a render pass can store to memory.
pub(super) fn has_stores(instance: &Instance, device: vk::PhysicalDevice) -> bool {
    // SAFETY: a device of this instance.
    let features = unsafe { instance.raw.get_physical_device_features(device) };
    features.fragment_stores_and_atomics == vk::TRUE && features.vertex_pipeline_stores_and_atomics == vk::TRUE
}

/// A device that may be used.
#[derive(Clone, Debug)]
pub(super) struct Candidate {
    pub info: DeviceInfo,
    pub physical_device: vk::PhysicalDevice,
    /// A family with graphics and compute; 0 if the device lacks one.
    pub queue_family: u32,
    /// Lower is better.
    rank: u32,
}

/// All devices in the loader's order, at least one.
pub(super) fn list(instance: &Instance) -> Result<Vec<Candidate>, NoDevice> {
    // SAFETY: the instance is valid.
    let devices = unsafe { instance.raw.enumerate_physical_devices() };
    let devices = devices.map_err(failed("vkEnumeratePhysicalDevices"))?;
    if devices.is_empty() {
        return Err(NoDevice::NoDriver("the loader lists no device".into()));
    }
    Ok(devices.into_iter().enumerate().map(|(index, device)| describe(instance, index, device)).collect())
}

fn describe(instance: &Instance, index: usize, physical_device: vk::PhysicalDevice) -> Candidate {
    let mut driver = vk::PhysicalDeviceDriverProperties::default();
    // SAFETY: a device of this instance, which was made for Vulkan 1.3; the driver's structure is core from 1.2 on.
    let (properties, families, lacks) = unsafe {
        let properties = instance.raw.get_physical_device_properties(physical_device);
        if properties.api_version >= vk::API_VERSION_1_2 {
            let mut chain = vk::PhysicalDeviceProperties2::default().push_next(&mut driver);
            instance.raw.get_physical_device_properties2(physical_device, &mut chain);
        }
        let families = instance.raw.get_physical_device_queue_family_properties(physical_device);
        (properties, families, check_device(&instance.raw, physical_device))
    };
    let needed = requirements().queue_flags;
    let queue_family = families.iter().position(|family| family.queue_flags.contains(needed)).unwrap_or(0) as u32;
    let (rank, kind) = match properties.device_type {
        vk::PhysicalDeviceType::DISCRETE_GPU => (0, "discrete GPU"),
        vk::PhysicalDeviceType::INTEGRATED_GPU => (1, "integrated GPU"),
        vk::PhysicalDeviceType::VIRTUAL_GPU => (2, "virtual GPU"),
        vk::PhysicalDeviceType::CPU => (4, "CPU"),
        _ => (3, "other"),
    };
    let text = |name: Result<&CStr, _>| name.map(CStr::to_string_lossy).unwrap_or_default().into_owned();
    let info = DeviceInfo {
        index,
        name: text(properties.device_name_as_c_str()),
        kind,
        driver: text(driver.driver_name_as_c_str()),
        driver_info: text(driver.driver_info_as_c_str()),
        api_version: version(properties.api_version),
        lacks,
        used: false,
    };
    Candidate { info, physical_device, queue_family, rank }
}

/// The best of those that match `wanted` (an index, or part of a name in any case) and lack nothing.
pub(super) fn choose(candidates: &[Candidate], wanted: Option<&str>) -> Result<usize, NoDevice> {
    let matches = |candidate: &Candidate| {
        let Some(wanted) = wanted else { return true };
        match wanted.parse::<usize>() {
            Ok(index) if index < candidates.len() => candidate.info.index == index,
            _ => candidate.info.name.to_lowercase().contains(&wanted.to_lowercase()),
        }
    };
    let lines =
        |candidates: &[&Candidate]| candidates.iter().map(|c| c.info.to_string()).collect::<Vec<_>>().join("\n");
    let matching: Vec<&Candidate> = candidates.iter().filter(|c| matches(c)).collect();
    if let (Some(wanted), true) = (wanted, matching.is_empty()) {
        let all: Vec<&Candidate> = candidates.iter().collect();
        return Err(NoDevice::NoMatch { wanted: wanted.into(), devices: lines(&all) });
    }
    let usable = matching.iter().filter(|c| c.info.lacks.is_empty());
    match usable.min_by_key(|c| (c.rank, c.info.index)) {
        Some(best) => Ok(best.info.index),
        None => Err(NoDevice::NoneUsable { tried: lines(&matching) }),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn candidate(index: usize, name: &str, rank: u32, lacks: &[&str]) -> Candidate {
        let info = DeviceInfo {
            index,
            name: name.into(),
            kind: "other",
            driver: "driver".into(),
            driver_info: "1.0".into(),
            api_version: "1.3.0".into(),
            lacks: lacks.iter().map(|s| (*s).into()).collect(),
            used: false,
        };
        Candidate { info, physical_device: vk::PhysicalDevice::null(), queue_family: 0, rank }
    }

    fn machine() -> Vec<Candidate> {
        vec![
            candidate(0, "llvmpipe (LLVM 15)", 4, &[]),
            candidate(1, "Old GPU 3", 0, &["feature synchronization2"]),
            candidate(2, "Integrated", 1, &[]),
            candidate(3, "Discrete 9000", 0, &[]),
            candidate(4, "Discrete 9001", 0, &[]),
        ]
    }

    #[test]
    fn gpus_come_before_cpus_and_what_lacks_something_is_passed_over() {
        assert_eq!(choose(&machine(), None).ok(), Some(3));
        assert_eq!(choose(&machine()[..3], None).ok(), Some(2));
        assert_eq!(choose(&machine()[..2], None).ok(), Some(0));
    }

    #[test]
    fn a_device_is_chosen_by_index_or_part_of_its_name() {
        assert_eq!(choose(&machine(), Some("0")).ok(), Some(0));
        assert_eq!(choose(&machine(), Some("LLVMPIPE")).ok(), Some(0));
        assert_eq!(choose(&machine(), Some("9001")).ok(), Some(4), "beyond the list, a number is part of a name");
        assert_eq!(choose(&machine(), Some("discrete")).ok(), Some(3));
    }

    #[test]
    fn errors_list_what_was_tried_and_what_each_lacks() {
        let Err(error) = choose(&machine(), Some("old")) else { panic!("it lacks a feature") };
        assert!(matches!(error, NoDevice::NoneUsable { .. }));
        let text = error.to_string();
        assert!(text.contains("1: Old GPU 3") && text.contains("lacks feature synchronization2"), "{text}");
        assert!(!text.contains("llvmpipe (LLVM") && text.contains("mesa-vulkan-drivers"), "{text}");
        let Err(error) = choose(&machine(), Some("radeon")) else { panic!("there is none") };
        let text = error.to_string();
        assert!(text.contains("\"radeon\"") && text.contains("4: Discrete 9001"), "{text}");
    }
}
