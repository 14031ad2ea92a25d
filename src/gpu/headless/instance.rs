//! Loader, instance and validation.

use std::ffi::{CStr, c_void};
use std::sync::{Arc, Mutex, PoisonError};

use ash::vk;

use super::NoDevice;
use crate::host::version;

/// Messages of validation.
pub type Messages = Arc<Mutex<Vec<String>>>;

/// The layer that validates.
pub const VALIDATION_LAYER: &CStr = c"VK_LAYER_KHRONOS_validation";

/// An instance of Vulkan 1.3, and what belongs to it.
pub(super) struct Instance {
    pub raw: ash::Instance,
    pub has_debug_utils: bool,
    pub messages: Messages,
    /// Version of the loader.
    pub loader: u32,
    /// Version of the validation layer that is installed.
    pub validation_layer: Option<u32>,
    messenger: Option<(ash::ext::debug_utils::Instance, vk::DebugUtilsMessengerEXT)>,
    /// Keeps the loader's library in memory: last.
    _entry: ash::Entry,
}

impl Instance {
    pub fn new(validate: bool) -> Result<Instance, NoDevice> {
        // SAFETY: the system's Vulkan loader is loaded as any program does; it stays loaded as long as the instance.
        let entry = unsafe { ash::Entry::load() }.map_err(|e| NoDevice::NoLoader(e.to_string()))?;
        // SAFETY: needs nothing but the entry.
        let loader = unsafe { entry.try_enumerate_instance_version() }
            .map_err(failed("vkEnumerateInstanceVersion"))?
            .unwrap_or(vk::API_VERSION_1_0);
        if loader < vk::API_VERSION_1_3 {
            return Err(NoDevice::OldLoader(version(loader)));
        }
        let validation_layer = layer_version(&entry)?;
        if validate && validation_layer.is_none() {
            return Err(NoDevice::NoLayer);
        }
        let available = extensions(&entry, validate)?;
        let messages = Messages::default();
        let raw = create(&entry, &available, validate, &messages)?;
        let has_debug_utils = available.iter().any(|name| name == vk::EXT_DEBUG_UTILS_NAME);
        let mut instance =
            Instance { raw, has_debug_utils, messages, loader, validation_layer, messenger: None, _entry: entry };
        if validate && has_debug_utils {
            let debug = ash::ext::debug_utils::Instance::new(&instance._entry, &instance.raw);
            // SAFETY: the extension is enabled, and the messages live longer than the instance.
            let messenger = unsafe { debug.create_debug_utils_messenger(&messenger_info(&instance.messages), None) };
            instance.messenger = Some((debug, messenger.map_err(failed("vkCreateDebugUtilsMessengerEXT"))?));
        }
        Ok(instance)
    }
}

impl Drop for Instance {
    fn drop(&mut self) {
        // SAFETY: the instance's children are gone; the messages and the loader go after it.
        unsafe {
            if let Some((debug, messenger)) = self.messenger.take() {
                debug.destroy_debug_utils_messenger(messenger, None);
            }
            self.raw.destroy_instance(None);
        }
    }
}

/// The error of a loader or driver call that returned `result`.
pub(super) fn failed(call: &'static str) -> impl FnOnce(vk::Result) -> NoDevice {
    move |result| match result {
        vk::Result::ERROR_INCOMPATIBLE_DRIVER => NoDevice::NoDriver(format!("{call} returned {result:?}")),
        vk::Result::ERROR_LAYER_NOT_PRESENT => NoDevice::NoLayer,
        // The loader says OUT_OF_HOST_MEMORY for a driver's description that it cannot read.
        _ => NoDevice::BrokenDriver { call, result },
    }
}

fn layer_version(entry: &ash::Entry) -> Result<Option<u32>, NoDevice> {
    // SAFETY: needs nothing but the entry.
    let layers = unsafe { entry.enumerate_instance_layer_properties() };
    let layers = layers.map_err(failed("vkEnumerateInstanceLayerProperties"))?;
    let layer = layers.iter().find(|layer| layer.layer_name_as_c_str() == Ok(VALIDATION_LAYER));
    Ok(layer.map(|layer| layer.spec_version))
}

/// The names of the extensions of the loader and drivers, and of the validation layer.
fn extensions(entry: &ash::Entry, validate: bool) -> Result<Vec<std::ffi::CString>, NoDevice> {
    let sources = [Some(None), validate.then_some(Some(VALIDATION_LAYER))];
    let mut names = Vec::new();
    for layer in sources.into_iter().flatten() {
        // SAFETY: the layer was found before.
        let found = unsafe { entry.enumerate_instance_extension_properties(layer) };
        for extension in found.map_err(failed("vkEnumerateInstanceExtensionProperties"))? {
            names.extend(extension.extension_name_as_c_str().map(CStr::to_owned));
        }
    }
    Ok(names)
}

fn create(
    entry: &ash::Entry,
    available: &[std::ffi::CString],
    validate: bool,
    messages: &Messages,
) -> Result<ash::Instance, NoDevice> {
    let has = |name: &CStr| available.iter().any(|other| other.as_c_str() == name);
    let application = vk::ApplicationInfo::default().application_name(c"celfx").api_version(vk::API_VERSION_1_3);
    let mut wanted = vec![vk::EXT_DEBUG_UTILS_NAME];
    let mut layers = Vec::new();
    if validate {
        // Not VK_EXT_layer_settings: older loaders refuse what they do not know, and a layer that has it takes the
        // settings without.
        wanted.push(vk::EXT_VALIDATION_FEATURES_NAME);
        layers.push(VALIDATION_LAYER.as_ptr());
    }
    wanted.retain(|name| has(name));
    let names: Vec<_> = wanted.iter().map(|name| name.as_ptr()).collect();

    let mut features = vk::ValidationFeaturesEXT::default()
        .enabled_validation_features(&[vk::ValidationFeatureEnableEXT::SYNCHRONIZATION_VALIDATION]);
    // Newer layers look at what shaders access only with this; older ones always do and do not know the setting.
    let on = vk::TRUE;
    let mut heuristic = vk::LayerSettingEXT::default()
        .layer_name(VALIDATION_LAYER)
        .setting_name(c"syncval_shader_accesses_heuristic")
        .ty(vk::LayerSettingTypeEXT::BOOL32);
    heuristic.value_count = 1;
    heuristic.p_values = std::ptr::from_ref(&on).cast();
    let heuristic = [heuristic];
    let mut settings = vk::LayerSettingsCreateInfoEXT::default().settings(&heuristic);
    let mut messenger = messenger_info(messages);

    let mut info = vk::InstanceCreateInfo::default()
        .application_info(&application)
        .enabled_layer_names(&layers)
        .enabled_extension_names(&names);
    if validate {
        if has(vk::EXT_VALIDATION_FEATURES_NAME) {
            info = info.push_next(&mut features);
        }
        if has(vk::EXT_LAYER_SETTINGS_NAME) {
            info = info.push_next(&mut settings);
        }
        if has(vk::EXT_DEBUG_UTILS_NAME) {
            // Hears of what happens while the instance itself is made and destroyed, such as leaks.
            info = info.push_next(&mut messenger);
        }
    }
    // SAFETY: everything that `info` points to lives to the end of this function, the messages longer than the
    // instance; only extensions and layers that were found are enabled.
    unsafe { entry.create_instance(&info, None) }.map_err(failed("vkCreateInstance"))
}

/// Collects warnings and errors into `messages`, which must outlive the messenger.
fn messenger_info(messages: &Messages) -> vk::DebugUtilsMessengerCreateInfoEXT<'static> {
    use vk::{DebugUtilsMessageSeverityFlagsEXT as Severity, DebugUtilsMessageTypeFlagsEXT as Type};
    vk::DebugUtilsMessengerCreateInfoEXT::default()
        .message_severity(Severity::WARNING | Severity::ERROR)
        // Not GENERAL: that is the loader talking about its search for layers and drivers.
        .message_type(Type::VALIDATION | Type::PERFORMANCE)
        .pfn_user_callback(Some(collect))
        .user_data(Arc::as_ptr(messages).cast_mut().cast())
}

/// Must not unwind into C: it neither indexes nor unwraps.
unsafe extern "system" fn collect(
    severity: vk::DebugUtilsMessageSeverityFlagsEXT,
    _types: vk::DebugUtilsMessageTypeFlagsEXT,
    data: *const vk::DebugUtilsMessengerCallbackDataEXT<'_>,
    messages: *mut c_void,
) -> vk::Bool32 {
    // SAFETY: the layer hands over valid data, and `messages` is what `messenger_info` was given, which is still alive.
    unsafe {
        let (Some(data), Some(messages)) = (data.as_ref(), messages.cast::<Mutex<Vec<String>>>().as_ref()) else {
            return vk::FALSE;
        };
        let text = |c: Option<&CStr>| c.map(CStr::to_string_lossy).unwrap_or_default().into_owned();
        let id = text(data.message_id_name_as_c_str());
        // The layer's remarks about its own settings are not about what it validates.
        if id != "VALIDATION-SETTINGS" {
            let line = format!("{severity:?} {id}: {}", text(data.message_as_c_str()));
            messages.lock().unwrap_or_else(PoisonError::into_inner).push(line);
        }
    }
    vk::FALSE
}
