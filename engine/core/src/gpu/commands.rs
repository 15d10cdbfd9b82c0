//! Recording and submission.

use std::any::Any;
use std::sync::Arc;
use std::time::Duration;

use ash::vk;

use super::device::{Device, c_string};
use super::submit::Recorder;
use super::{Gpu, messages};
use crate::Result;

/// A command buffer that is being recorded. Dropped without submission, it is recycled and nothing happens.
///
/// What is recorded has to live until [`Gpu::submit`]; after that the device's use of it is looked after.
pub struct Commands {
    device: Arc<Device>,
    /// Taken by submission.
    recorder: Option<Recorder>,
    buffer: vk::CommandBuffer,
    name: String,
    kept: Vec<Box<dyn Any + Send>>,
    labels: u32,
}

impl Commands {
    /// The Vulkan handle, in the recording state.
    pub fn raw(&self) -> vk::CommandBuffer {
        self.buffer
    }

    /// The device, for recording.
    pub fn device(&self) -> &ash::Device {
        &self.device.raw
    }

    pub(super) fn owner(&self) -> &Device {
        &self.device
    }

    /// Begins a pass: a debug label, and the breadcrumb that names it should the device be lost. Outside of
    /// rendering only (it records a small fill).
    pub fn begin_pass(&mut self, name: &str) {
        if let Some(recorder) = &mut self.recorder {
            self.device.crumb(recorder, name);
        }
        self.begin_label(name);
    }

    /// Ends the innermost pass.
    pub fn end_pass(&mut self) {
        self.end_label();
    }

    /// Begins a debug label within a pass, anywhere.
    pub fn begin_label(&mut self, name: &str) {
        self.labels += 1;
        if let Some(debug) = &self.device.debug {
            messages::label_begins(self.buffer, name);
            let name = c_string(name);
            // SAFETY: the command buffer is being recorded.
            unsafe {
                debug.cmd_begin_debug_utils_label(self.buffer, &vk::DebugUtilsLabelEXT::default().label_name(&name));
            }
        }
    }

    /// Ends it. Without one that is open it does nothing.
    pub fn end_label(&mut self) {
        if self.labels == 0 {
            return;
        }
        self.labels -= 1;
        if let Some(debug) = &self.device.debug {
            messages::label_ends(self.buffer);
            // SAFETY: the command buffer is being recorded, and a label is open.
            unsafe { debug.cmd_end_debug_utils_label(self.buffer) };
        }
    }

    /// Keeps an object (a clone of a buffer, an arena, …) until the device is done with these commands.
    pub fn keep(&mut self, object: impl Any + Send) {
        self.kept.push(Box::new(object));
    }
}

impl Drop for Commands {
    fn drop(&mut self) {
        messages::recording_ends(self.buffer);
        if let Some(recorder) = self.recorder.take() {
            self.device.abandon(recorder);
        }
    }
}

/// What a submission is known by. Later ones compare greater.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct SubmitToken(pub(super) u64);

/// A semaphore of the application's (of a swapchain, of another device) that a submission waits for or signals.
#[derive(Clone, Copy, Debug)]
pub struct SemaphoreAt {
    /// Binary or timeline.
    pub semaphore: vk::Semaphore,
    /// The timeline's value; not looked at for a binary one.
    pub value: u64,
    /// Stages that wait, or whose end signals.
    pub stages: vk::PipelineStageFlags2,
}

impl SemaphoreAt {
    fn info(&self) -> vk::SemaphoreSubmitInfo<'static> {
        vk::SemaphoreSubmitInfo::default().semaphore(self.semaphore).value(self.value).stage_mask(self.stages)
    }
}

impl Gpu {
    /// A command buffer, begun.
    ///
    /// # Errors
    /// [`crate::Error::DeviceLost`], [`crate::Error::Vulkan`].
    pub fn commands(&self, name: &str) -> Result<Commands> {
        let recorder = self.device.begin(name)?;
        Ok(Commands {
            device: self.device.clone(),
            buffer: recorder.buffer,
            recorder: Some(recorder),
            name: name.into(),
            kept: Vec::new(),
            labels: 0,
        })
    }

    /// Ends and submits. Submissions begin in order; what depends on an earlier one needs a barrier, not a wait.
    /// The last thing in each is a barrier that shows the device's writes to the host.
    ///
    /// # Errors
    /// [`crate::Error::DeviceLost`] naming the last pass that began, [`crate::Error::Vulkan`].
    pub fn submit(&self, commands: Commands) -> Result<SubmitToken> {
        // SAFETY: no foreign semaphores.
        unsafe { self.submit_with(commands, &[], &[]) }
    }

    /// As [`Gpu::submit`], with semaphores of the application's.
    ///
    /// # Safety
    /// The semaphores are of this device and are used as Vulkan asks.
    ///
    /// # Errors
    /// As [`Gpu::submit`].
    pub unsafe fn submit_with(
        &self,
        mut commands: Commands,
        wait: &[SemaphoreAt],
        signal: &[SemaphoreAt],
    ) -> Result<SubmitToken> {
        if !Arc::ptr_eq(&commands.device, &self.device) {
            return Err(crate::Error::invalid(&commands.name, "the commands are of another device"));
        }
        while commands.labels > 0 {
            commands.end_label();
        }
        let Some(recorder) = commands.recorder.take() else {
            return Err(crate::Error::invalid(&commands.name, "the commands were submitted before"));
        };
        let kept = std::mem::take(&mut commands.kept);
        let wait: Vec<_> = wait.iter().map(SemaphoreAt::info).collect();
        let signal: Vec<_> = signal.iter().map(SemaphoreAt::info).collect();
        // SAFETY: the caller's promise.
        unsafe { self.device.submit(&commands.name, recorder, kept, &wait, &signal) }.map(SubmitToken)
    }

    /// Waits for a submission, and frees what waited for it.
    ///
    /// # Errors
    /// [`crate::Error::DeviceLost`] naming the last pass that began.
    pub fn wait(&self, token: SubmitToken) -> Result<()> {
        let waited = self.device.wait_value(token.0, u64::MAX);
        self.device.collect();
        waited.map(|_| ())
    }

    /// Waits at most so long; `false` where the submission is not done by then. Zero asks only.
    ///
    /// # Errors
    /// As [`Gpu::wait`].
    pub fn wait_for(&self, token: SubmitToken, at_most: Duration) -> Result<bool> {
        let nanoseconds = u64::try_from(at_most.as_nanos()).unwrap_or(u64::MAX);
        let waited = self.device.wait_value(token.0, nanoseconds);
        self.device.collect();
        waited
    }

    /// For tests: the device is lost in the next submission that has a pass `at`, once that pass has begun; where
    /// `at` is `None`, at the next submission, before any of its passes. It behaves as lost from then on.
    #[doc(hidden)]
    pub fn inject_device_loss(&self, at: Option<&str>) {
        self.device.inject(at);
    }
}
