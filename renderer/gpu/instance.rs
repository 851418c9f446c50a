//! The Vulkan instance, and the messages of its validation layers.

use std::ffi::{CStr, c_void};
use std::sync::{Arc, Mutex};

use ash::{ext, vk};

use super::GpuError;
use super::error::Call;

const VALIDATION_LAYER: &CStr = c"VK_LAYER_KHRONOS_validation";

/// Messages of the validation layers, as they came.
pub type Messages = Arc<Mutex<Vec<String>>>;

/// An instance. The loader stays alive as long as it does.
pub struct Instance {
    pub(crate) raw: ash::Instance,
    /// Present where labels and names are of use: under validation or a capture tool.
    pub(crate) debug_utils: bool,
    debug: Option<(ext::debug_utils::Instance, vk::DebugUtilsMessengerEXT)>,
    messages: Messages,
    #[cfg_attr(not(feature = "viewer"), expect(dead_code, reason = "held for the loader's sake; surfaces read it"))]
    pub(super) entry: ash::Entry,
    // Boxed so that the pointer handed to the driver stays valid however the instance moves.
    _callback_target: Box<Messages>,
}

impl Instance {
    /// Opens the loader and makes a Vulkan 1.2 (or later, where there is one) instance, with validation and
    /// synchronisation validation if asked. `surface_extensions` are those that a window needs, none without a window.
    pub fn new(validation: bool, surface_extensions: &[&CStr]) -> Result<Self, GpuError> {
        // SAFETY: the loader is the system's Vulkan library, whose initialisers have no preconditions.
        let entry = unsafe { ash::Entry::load() }.map_err(|e| GpuError::NoLoader(e.to_string()))?;
        if validation && !has_layer(&entry)? {
            return Err(GpuError::NoValidation);
        }
        let offered = offered_extensions(&entry)?;
        let debug_utils = offered.contains(ext::debug_utils::NAME);
        if validation && !debug_utils {
            return Err(GpuError::NoMessages);
        }
        if let Some(missing) = surface_extensions.iter().find(|name| !offered.contains(name)) {
            return Err(GpuError::NoSurfaces { missing: missing.to_string_lossy().into_owned() });
        }
        let messages = Messages::default();
        let mut callback_target = Box::new(messages.clone());

        let app = vk::ApplicationInfo::default()
            .application_name(c"nephroid")
            .engine_name(c"nephroid")
            .api_version(vk::API_VERSION_1_3);
        let layers = if validation { vec![VALIDATION_LAYER.as_ptr()] } else { vec![] };
        let mut extensions: Vec<_> = surface_extensions.iter().map(|name| name.as_ptr()).collect();
        if debug_utils {
            extensions.push(ext::debug_utils::NAME.as_ptr());
        }
        let enabled = [vk::ValidationFeatureEnableEXT::SYNCHRONIZATION_VALIDATION];
        let mut features = vk::ValidationFeaturesEXT::default().enabled_validation_features(&enabled);
        let mut messenger = messenger_info(&mut callback_target);
        let mut info = vk::InstanceCreateInfo::default()
            .application_info(&app)
            .enabled_layer_names(&layers)
            .enabled_extension_names(&extensions);
        if validation {
            info = info.push_next(&mut features);
            if debug_utils {
                info = info.push_next(&mut messenger);
            }
        }
        // SAFETY: every pointer in `info` outlives the call.
        let raw = match unsafe { entry.create_instance(&info, None) } {
            // The loader's answer where it has no driver at all.
            Err(vk::Result::ERROR_INCOMPATIBLE_DRIVER) => return Err(GpuError::NoDevice),
            other => other.call("vkCreateInstance")?,
        };
        let debug = if validation && debug_utils {
            let functions = ext::debug_utils::Instance::new(&entry, &raw);
            let info = messenger_info(&mut callback_target);
            // SAFETY: the user data points into a box that lives until after the messenger is destroyed.
            let handle = unsafe { functions.create_debug_utils_messenger(&info, None) }
                .call("vkCreateDebugUtilsMessengerEXT")?;
            Some((functions, handle))
        } else {
            None
        };
        Ok(Instance { raw, debug_utils, debug, messages, entry, _callback_target: callback_target })
    }

    /// The list of messages, to be read when all else is gone.
    #[cfg(feature = "viewer")]
    pub fn log(&self) -> Messages {
        self.messages.clone()
    }

    /// What the validation layers have said so far; empty without validation.
    pub fn messages(&self) -> Vec<String> {
        self.messages.lock().map(|m| m.clone()).unwrap_or_default()
    }
}

impl Drop for Instance {
    fn drop(&mut self) {
        if let Some((functions, messenger)) = self.debug.take() {
            // SAFETY: made by these functions and destroyed once.
            unsafe { functions.destroy_debug_utils_messenger(messenger, None) };
        }
        // SAFETY: devices hold the instance by reference count, so none is left.
        unsafe { self.raw.destroy_instance(None) };
    }
}

fn has_layer(entry: &ash::Entry) -> Result<bool, GpuError> {
    // SAFETY: no preconditions.
    let layers = unsafe { entry.enumerate_instance_layer_properties() }.call("vkEnumerateInstanceLayerProperties")?;
    Ok(layers.iter().any(|l| l.layer_name_as_c_str() == Ok(VALIDATION_LAYER)))
}

struct Extensions(Vec<vk::ExtensionProperties>);

impl Extensions {
    fn contains(&self, name: &CStr) -> bool {
        self.0.iter().any(|e| e.extension_name_as_c_str() == Ok(name))
    }
}

fn offered_extensions(entry: &ash::Entry) -> Result<Extensions, GpuError> {
    // SAFETY: no preconditions.
    let extensions = unsafe { entry.enumerate_instance_extension_properties(None) }
        .call("vkEnumerateInstanceExtensionProperties")?;
    Ok(Extensions(extensions))
}

fn messenger_info(target: &mut Box<Messages>) -> vk::DebugUtilsMessengerCreateInfoEXT<'static> {
    vk::DebugUtilsMessengerCreateInfoEXT::default()
        .message_severity(vk::DebugUtilsMessageSeverityFlagsEXT::ERROR | vk::DebugUtilsMessageSeverityFlagsEXT::WARNING)
        // Advice on performance is left out: images are in GENERAL on purpose.
        .message_type(vk::DebugUtilsMessageTypeFlagsEXT::VALIDATION)
        .pfn_user_callback(Some(collect))
        .user_data((&raw mut **target).cast())
}

/// Called by the layers, on any thread.
unsafe extern "system" fn collect(
    severity: vk::DebugUtilsMessageSeverityFlagsEXT,
    _kind: vk::DebugUtilsMessageTypeFlagsEXT,
    data: *const vk::DebugUtilsMessengerCallbackDataEXT<'_>,
    user: *mut c_void,
) -> vk::Bool32 {
    // SAFETY: the layers pass valid data, and `user` is the boxed list given at creation.
    let (data, messages) = unsafe { (&*data, &*user.cast::<Messages>()) };
    // SAFETY: null or a zero-terminated string, by the specification.
    let text = unsafe { data.message_as_c_str() }.unwrap_or(c"").to_string_lossy();
    if let Ok(mut messages) = messages.lock() {
        messages.push(format!("{severity:?}: {text}"));
    }
    vk::FALSE
}
