//! Recording and submission.

use std::any::Any;
use std::time::Duration;

use ash::vk;

use super::Gpu;
use crate::Result;

/// A command buffer that is being recorded. Dropped without submission, it is recycled and nothing happens.
pub struct Commands {}

impl Commands {
    /// The Vulkan handle, in the recording state.
    pub fn raw(&self) -> vk::CommandBuffer {
        unimplemented!()
    }

    /// Begins a pass: a debug label, and the breadcrumb that names it should the device be lost. Outside of
    /// rendering only (it records a small fill).
    pub fn begin_pass(&mut self, _name: &str) {
        unimplemented!()
    }

    /// Ends the innermost pass.
    pub fn end_pass(&mut self) {
        unimplemented!()
    }

    /// Begins a debug label within a pass, anywhere.
    pub fn begin_label(&mut self, _name: &str) {
        unimplemented!()
    }

    /// Ends it.
    pub fn end_label(&mut self) {
        unimplemented!()
    }

    /// Keeps an object (a clone of a buffer, an arena, …) until the device is done with these commands.
    pub fn keep(&mut self, _object: impl Any + Send) {
        unimplemented!()
    }
}

/// What a submission is known by.
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

impl Gpu {
    /// A command buffer, begun.
    ///
    /// # Errors
    /// [`crate::Error::DeviceLost`], [`crate::Error::Vulkan`].
    pub fn commands(&self, _name: &str) -> Result<Commands> {
        unimplemented!()
    }

    /// Ends and submits. Submissions begin in order; what depends on an earlier one needs a barrier, not a wait.
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
        _commands: Commands,
        _wait: &[SemaphoreAt],
        _signal: &[SemaphoreAt],
    ) -> Result<SubmitToken> {
        unimplemented!()
    }

    /// Waits for a submission, and frees what waited for it.
    ///
    /// # Errors
    /// [`crate::Error::DeviceLost`] naming the last pass that began.
    pub fn wait(&self, _token: SubmitToken) -> Result<()> {
        unimplemented!()
    }

    /// Waits at most so long; `false` where the submission is not done by then. Zero asks only.
    ///
    /// # Errors
    /// As [`Gpu::wait`].
    pub fn wait_for(&self, _token: SubmitToken, _at_most: Duration) -> Result<bool> {
        unimplemented!()
    }

    /// For tests: the next submission is lost once the pass `at` has begun, or before its first pass where that is
    /// `None`. The device behaves as lost from then on.
    #[doc(hidden)]
    pub fn inject_device_loss(&self, _at: Option<&str>) {
        unimplemented!()
    }
}
