//! Where validation messages go.

use std::cell::RefCell;
use std::ffi::{CStr, c_void};
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::Mutex;

use ash::vk;

use super::lock;

/// How grave a message is.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Severity {
    /// Output of `debugPrintfEXT` in shaders.
    Info,
    /// Likely a mistake.
    Warning,
    /// Against the specification.
    Error,
}

/// One message of the validation layer.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Message {
    /// How grave it is.
    pub severity: Severity,
    /// Its identifier: `VUID-…` or `SYNC-HAZARD-…`.
    pub id_name: String,
    /// The layer's own words.
    pub text: String,
    /// The objects concerned, by kind and debug name: `buffer "counter"`; the handle in hexadecimal where one has
    /// no name.
    pub objects: Vec<String>,
    /// Names of the passes concerned (command buffer labels), innermost first.
    pub labels: Vec<String>,
}

impl std::fmt::Display for Message {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "{}", self.id_name)?;
        if !self.labels.is_empty() {
            write!(f, " in {}", self.labels.join(" < "))?;
        }
        if !self.objects.is_empty() {
            write!(f, " on {}", self.objects.join(", "))?;
        }
        write!(f, ": {}", self.text)
    }
}

/// Collects validation messages; they are logged too.
#[derive(Debug, Default)]
pub struct Messages {
    list: Mutex<Vec<Message>>,
}

impl Messages {
    /// All messages since the last call, in order.
    pub fn take(&self) -> Vec<Message> {
        std::mem::take(&mut lock(&self.list))
    }

    /// How many wait to be taken.
    pub fn len(&self) -> usize {
        lock(&self.list).len()
    }

    /// Whether none waits.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    fn add(&self, message: Message) {
        if is_old_layer_on_new_driver(&message) {
            log::debug!("left out: {message}");
            return;
        }
        match message.severity {
            Severity::Info => log::info!("{message}"),
            Severity::Warning => log::warn!("{message}"),
            Severity::Error => log::error!("{message}"),
        }
        lock(&self.list).push(message);
    }

    /// The messenger that fills this sink. It is to be destroyed before the sink.
    pub(super) fn messenger(&self) -> vk::DebugUtilsMessengerCreateInfoEXT<'static> {
        use vk::{DebugUtilsMessageSeverityFlagsEXT as S, DebugUtilsMessageTypeFlagsEXT as T};
        vk::DebugUtilsMessengerCreateInfoEXT::default()
            .message_severity(S::ERROR | S::WARNING | S::INFO)
            // General messages are the loader's (a driver's file that does not load, and the like).
            .message_type(T::VALIDATION | T::PERFORMANCE)
            .pfn_user_callback(Some(callback))
            .user_data(std::ptr::from_ref(self).cast_mut().cast())
    }
}

thread_local! {
    /// Labels that are open in command buffers which this thread records, outermost first.
    static RECORDING: RefCell<Vec<(vk::CommandBuffer, String)>> = const { RefCell::new(Vec::new()) };
}

/// Notes that a label begins.
pub(super) fn label_begins(buffer: vk::CommandBuffer, label: &str) {
    RECORDING.with_borrow_mut(|r| r.push((buffer, label.into())));
}

/// Notes that the innermost label of a command buffer ends.
pub(super) fn label_ends(buffer: vk::CommandBuffer) {
    RECORDING.with_borrow_mut(|r| {
        if let Some(at) = r.iter().rposition(|(b, _)| *b == buffer) {
            r.remove(at);
        }
    });
}

/// Notes that nothing more is recorded into a command buffer.
pub(super) fn recording_ends(buffer: vk::CommandBuffer) {
    // On a thread that is ending there is nothing to note.
    let _ = RECORDING.try_with(|r| r.borrow_mut().retain(|(b, _)| *b != buffer));
}

/// A layer older than the driver does not know the newer structures that the driver's own loader, or another layer,
/// chains to a query, and reports them under the query's `…-pNext-pNext` identifier with these words. The structures
/// are right; no other message is left out.
fn is_old_layer_on_new_driver(message: &Message) -> bool {
    message.id_name.ends_with("-pNext-pNext") && message.text.contains("unknown VkStructureType")
}

/// Called by the layer, on whatever thread made the call that is wrong. It must not unwind.
unsafe extern "system" fn callback(
    severity: vk::DebugUtilsMessageSeverityFlagsEXT,
    _types: vk::DebugUtilsMessageTypeFlagsEXT,
    data: *const vk::DebugUtilsMessengerCallbackDataEXT<'_>,
    user: *mut c_void,
) -> vk::Bool32 {
    let _ = catch_unwind(AssertUnwindSafe(|| {
        // SAFETY: the layer gives a valid structure for the time of the call, and our own pointer, whose sink
        // outlives the messenger.
        let (data, sink) = unsafe { (&*data, &*user.cast::<Messages>()) };
        // SAFETY: as above, the strings and arrays are the structure's.
        let Some(message) = (unsafe { message_of(severity, data) }) else { return };
        sink.add(message);
    }));
    // Going on with the call is what an application without the layer would see.
    vk::FALSE
}

/// SAFETY: `data` and all it points at are valid.
unsafe fn message_of(
    severity: vk::DebugUtilsMessageSeverityFlagsEXT,
    data: &vk::DebugUtilsMessengerCallbackDataEXT<'_>,
) -> Option<Message> {
    let string = |p: *const std::ffi::c_char| {
        if p.is_null() {
            return String::new();
        }
        // SAFETY: a C string, by the specification.
        unsafe { CStr::from_ptr(p) }.to_string_lossy().into_owned()
    };
    // SAFETY: pointers and counts belong together; an array of length 0 may be null.
    unsafe fn slice<'a, T>(first: *const T, count: u32) -> &'a [T] {
        if first.is_null() || count == 0 {
            return &[];
        }
        // SAFETY: see above.
        unsafe { std::slice::from_raw_parts(first, count as usize) }
    }
    let id_name = string(data.p_message_id_name);
    let severity = if severity.contains(vk::DebugUtilsMessageSeverityFlagsEXT::ERROR) {
        Severity::Error
    } else if severity.contains(vk::DebugUtilsMessageSeverityFlagsEXT::WARNING) {
        Severity::Warning
    } else if id_name.contains("DEBUG-PRINTF") {
        Severity::Info
    } else {
        return None;
    };
    // SAFETY: of the structure.
    let (objects, labels) =
        unsafe { (slice(data.p_objects, data.object_count), slice(data.p_cmd_buf_labels, data.cmd_buf_label_count)) };
    let object = |o: &vk::DebugUtilsObjectNameInfoEXT<'_>| {
        let kind = format!("{:?}", o.object_type).to_lowercase().replace('_', " ");
        if o.p_object_name.is_null() {
            format!("{kind} {:#x}", o.object_handle)
        } else {
            format!("{kind} {:?}", string(o.p_object_name))
        }
    };
    let mut labels: Vec<String> = labels.iter().map(|l| string(l.p_label_name)).collect();
    // Layer 1.3.239 lists each label twice.
    labels.dedup();
    if labels.is_empty() {
        // It lists none with synchronisation hazards: those of what this thread is recording.
        labels = RECORDING.with_borrow(|r| r.iter().rev().map(|(_, label)| label.clone()).collect());
    }
    Some(Message {
        severity,
        id_name,
        text: string(data.p_message),
        objects: objects.iter().map(object).collect(),
        labels,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn message(id_name: &str, text: &str) -> Message {
        Message {
            severity: Severity::Error,
            id_name: id_name.into(),
            text: text.into(),
            objects: vec![],
            labels: vec![],
        }
    }

    #[test]
    fn only_unknown_structures_are_left_out() {
        let sink = Messages::default();
        sink.add(message(
            "VUID-VkPhysicalDeviceProperties2-pNext-pNext",
            "pNext includes a structure with unknown VkStructureType (1000)",
        ));
        assert!(sink.is_empty());
        sink.add(message("VUID-VkPhysicalDeviceProperties2-pNext-pNext", "pNext includes the same structure twice"));
        sink.add(message("SYNC-HAZARD-READ-AFTER-WRITE", "unknown VkStructureType"));
        assert_eq!(sink.take().len(), 2);
        assert!(sink.is_empty());
    }
}
