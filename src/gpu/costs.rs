//! What pipelines cost on a device, as its driver says (`VK_KHR_pipeline_executable_properties`).

use ash::{khr, vk};

use crate::error::{Error, Result};
use crate::host::Host;

/// The cost of a pipeline.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct Cost {
    /// The pass that it was first made for, `effect.pass`.
    pub pass: &'static str,
    /// Its shaders, as paths below `glsl/`.
    pub shaders: Vec<&'static str>,
    /// Its specialisation constants 0, 1, 2..., in bits.
    pub specialisation: Vec<u32>,
    /// What the driver made of it: usually one a shader.
    pub executables: Vec<Executable>,
}

/// What a driver makes of a shader.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct Executable {
    /// The driver's name of it.
    pub name: String,
    /// Invocations of a subgroup.
    pub subgroup_size: u32,
    /// All that the driver says: names and values are its own.
    pub statistics: Vec<Statistic>,
}

/// A figure of a driver's.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct Statistic {
    /// Its name.
    pub name: String,
    /// Its value; 1 for true.
    pub value: f64,
}

/// What drivers say under names of their own: those of Mesa's RADV and ANV are known here. Others' are among the statistics.
impl Executable {
    /// Registers of an invocation.
    pub fn registers(&self) -> Option<f64> {
        self.first(&["VGPRs", "Max live registers"])
    }

    /// Registers that are kept in memory for want of room.
    pub fn spilled(&self) -> Option<f64> {
        let spills = self.statistics.iter().filter(|statistic| statistic.name.to_lowercase().contains("spill"));
        spills.map(|statistic| statistic.value).reduce(|a, b| a + b)
    }

    /// Bytes of memory of its own that a subgroup needs.
    pub fn scratch(&self) -> Option<f64> {
        self.first(&["Scratch size", "Scratch Memory Size"])
    }

    /// Bytes of shared memory of a workgroup.
    pub fn shared_memory(&self) -> Option<f64> {
        self.first(&["LDS size", "Workgroup Memory Size"])
    }

    /// How many subgroups a unit of the device can hold at a time.
    pub fn occupancy(&self) -> Option<f64> {
        self.first(&["Subgroups per SIMD"])
    }

    /// Bytes of code.
    pub fn code_size(&self) -> Option<f64> {
        self.first(&["Code size"])
    }

    /// The first of these statistics that there is.
    fn first(&self, names: &[&str]) -> Option<f64> {
        names.iter().find_map(|name| self.statistics.iter().find(|s| s.name == *name)).map(|s| s.value)
    }
}

/// What the driver made of a pipeline that was made with `CAPTURE_STATISTICS_KHR`.
///
/// # Safety
/// `host` holds valid handles, the extension is enabled, and `pipeline` belongs to its device.
pub(crate) unsafe fn executables(host: &Host, pipeline: vk::Pipeline) -> Result<Vec<Executable>> {
    let extension = khr::pipeline_executable_properties::Device::new(host.instance, host.device);
    // SAFETY: as above.
    let found = unsafe {
        let info = vk::PipelineInfoKHR::default().pipeline(pipeline);
        let properties = extension.get_pipeline_executable_properties(&info);
        properties.map_err(Error::vulkan("vkGetPipelineExecutablePropertiesKHR", ""))?
    };
    let executable = |(index, properties): (u32, vk::PipelineExecutablePropertiesKHR)| {
        let info = vk::PipelineExecutableInfoKHR::default().pipeline(pipeline).executable_index(index);
        // SAFETY: as above; there are so many executables.
        let statistics = unsafe { extension.get_pipeline_executable_statistics(&info) };
        let statistics = statistics.map_err(Error::vulkan("vkGetPipelineExecutableStatisticsKHR", ""))?;
        Ok(Executable {
            name: properties.name_as_c_str().unwrap_or_default().to_string_lossy().into_owned(),
            subgroup_size: properties.subgroup_size,
            statistics: statistics.iter().map(statistic).collect(),
        })
    };
    (0..).zip(found).map(executable).collect()
}

fn statistic(statistic: &vk::PipelineExecutableStatisticKHR) -> Statistic {
    use vk::PipelineExecutableStatisticFormatKHR as Format;
    // SAFETY: the format says which of the union's members is there; each bit pattern is a value of all but the first.
    let value = unsafe {
        match statistic.format {
            Format::BOOL32 => f64::from(u8::from(statistic.value.b32 != vk::FALSE)),
            Format::INT64 => statistic.value.i64 as f64,
            Format::UINT64 => statistic.value.u64 as f64,
            _ => statistic.value.f64,
        }
    };
    Statistic { name: statistic.name_as_c_str().unwrap_or_default().to_string_lossy().into_owned(), value }
}
