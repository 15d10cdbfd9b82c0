//! The queue's side of [`super::Commands`]: what is recorded, in flight, and waiting to be freed.

use std::any::Any;
use std::collections::VecDeque;
use std::sync::Arc;

use ash::vk;

use super::device::{Device, Garbage, RawBuffer};
use super::{BufferInfo, Memory, lock};
use crate::{Error, Result};

/// Passes of a submission that leave breadcrumbs on the device; further ones count as the last of these.
const CRUMBS: usize = 4096;

/// A command buffer with its pool and its breadcrumbs: one word a pass, written by the device when the pass begins.
pub(super) struct Recorder {
    pub pool: vk::CommandPool,
    pub buffer: vk::CommandBuffer,
    pub crumbs: RawBuffer,
    /// Names of the passes, in recorded order.
    pub passes: Vec<String>,
}

/// A submission that the device has not finished.
struct InFlight {
    value: u64,
    recorder: Recorder,
    kept: Vec<Box<dyn Any + Send>>,
}

/// The order of things, under one lock.
#[derive(Default)]
pub(super) struct State {
    /// Value of the last submission.
    last: u64,
    /// Command buffers that are being recorded: what is dropped meanwhile may be in one of them.
    open: u32,
    free: Vec<Recorder>,
    in_flight: VecDeque<InFlight>,
    /// Dropped while something was being recorded.
    unkeyed: Vec<Garbage>,
    /// To be destroyed when the timeline has reached the value.
    keyed: VecDeque<(u64, Garbage)>,
    /// Last pass of the submissions that are done.
    last_done_pass: Option<String>,
    /// Set once the device is lost: the last pass that began.
    lost: Option<Option<String>>,
    /// See [`super::Gpu::inject_device_loss`].
    inject: Option<Option<String>>,
}

impl State {
    fn key_garbage(&mut self) {
        if self.open == 0 {
            let last = self.last;
            self.keyed.extend(self.unkeyed.drain(..).map(|g| (last, g)));
        }
    }

    /// The last pass that began, by what the device wrote.
    fn last_pass(&self) -> Option<String> {
        let of_recorder = |r: &Recorder| {
            let written = r.crumbs.allocation.as_ref().and_then(|a| a.mapped_slice()).unwrap_or_default();
            let begun = written.chunks_exact(4).take(r.passes.len()).rposition(|word| word != [0; 4]);
            begun.map(|i| r.passes[i].clone())
        };
        self.in_flight.iter().rev().find_map(|f| of_recorder(&f.recorder)).or_else(|| self.last_done_pass.clone())
    }

    /// SAFETY: the device is idle and nothing else uses its objects.
    pub(super) unsafe fn destroy(self, device: &Device) {
        for recorder in self.in_flight.into_iter().map(|f| f.recorder).chain(self.free) {
            // SAFETY: see above.
            unsafe { device.raw.destroy_command_pool(recorder.pool, None) };
            device.destroy(Garbage::Buffer(recorder.crumbs));
        }
        self.unkeyed.into_iter().chain(self.keyed.into_iter().map(|k| k.1)).for_each(|g| device.destroy(g));
    }
}

impl Device {
    /// Destroys an object as soon as the device is done with it.
    pub(super) fn defer(&self, garbage: Garbage) {
        let now = {
            let mut state = lock(&self.state);
            if state.open == 0 && (state.lost.is_some() || self.completed() >= state.last) {
                Some(garbage)
            } else {
                state.unkeyed.push(garbage);
                state.key_garbage();
                None
            }
        };
        now.into_iter().for_each(|g| self.destroy(g));
    }

    /// Value of the last submission that is done. Of a lost device, 0.
    fn completed(&self) -> u64 {
        // SAFETY: a live timeline semaphore.
        unsafe { self.raw.get_semaphore_counter_value(self.timeline) }.unwrap_or(0)
    }

    /// Recycles and frees what the device is done with.
    pub(super) fn collect(&self) {
        let mut freed = Vec::new();
        {
            let mut state = lock(&self.state);
            let completed = if state.lost.is_some() { u64::MAX } else { self.completed() };
            while state.in_flight.front().is_some_and(|f| f.value <= completed)
                && let Some(InFlight { recorder, kept, .. }) = state.in_flight.pop_front()
            {
                if let Some(pass) = recorder.passes.last() {
                    state.last_done_pass = Some(pass.clone());
                }
                freed.push(Garbage::Kept(kept));
                state.free.push(recorder);
            }
            while state.keyed.front().is_some_and(|k| k.0 <= completed)
                && let Some((_, garbage)) = state.keyed.pop_front()
            {
                freed.push(garbage);
            }
        }
        // Outside of the lock: dropping kept objects defers what they hold.
        freed.into_iter().for_each(|g| self.destroy(g));
    }

    /// Marks the device as lost, and says so.
    pub(super) fn lost(&self) -> Error {
        let mut state = lock(&self.state);
        if state.lost.is_none() {
            state.lost = Some(state.last_pass());
        }
        Error::DeviceLost { last_pass: state.lost.clone().flatten() }
    }

    pub(super) fn check_lost(&self) -> Result<()> {
        match &lock(&self.state).lost {
            Some(last_pass) => Err(Error::DeviceLost { last_pass: last_pass.clone() }),
            None => Ok(()),
        }
    }

    /// A command buffer, begun. To be given to [`Device::submit`] or [`Device::abandon`].
    pub(super) fn begin(&self, name: &str) -> Result<Recorder> {
        self.check_lost()?;
        self.collect();
        let free = lock(&self.state).free.pop();
        let (mut recorder, is_new) = match free {
            Some(recorder) => (recorder, false),
            None => (self.make_recorder()?, true),
        };
        if (is_new || !recorder.passes.is_empty())
            && let Some(bytes) = recorder.crumbs.allocation.as_mut().and_then(|a| a.mapped_slice_mut())
        {
            bytes.fill(0);
        }
        recorder.passes.clear();
        let info = vk::CommandBufferBeginInfo::default().flags(vk::CommandBufferUsageFlags::ONE_TIME_SUBMIT);
        // SAFETY: the pool is ours and the device is done with its buffer.
        let begun = unsafe {
            self.raw
                .reset_command_pool(recorder.pool, vk::CommandPoolResetFlags::empty())
                .and_then(|()| self.raw.begin_command_buffer(recorder.buffer, &info))
        };
        if let Err(e) = begun {
            lock(&self.state).free.push(recorder);
            return Err(self.error("vkBeginCommandBuffer", name, e));
        }
        self.name(recorder.buffer, name);
        lock(&self.state).open += 1;
        Ok(recorder)
    }

    fn make_recorder(&self) -> Result<Recorder> {
        let crumbs = self.make_buffer(&BufferInfo {
            name: "breadcrumbs",
            size: (CRUMBS * 4) as u64,
            usage: vk::BufferUsageFlags::TRANSFER_DST,
            memory: Memory::Readback,
        })?;
        let info = vk::CommandPoolCreateInfo::default()
            .flags(vk::CommandPoolCreateFlags::TRANSIENT)
            .queue_family_index(self.caps.queue_family);
        // SAFETY: the family is one that the device was made with.
        let pool = unsafe { self.raw.create_command_pool(&info, None) };
        let made = pool.and_then(|pool| {
            let info = vk::CommandBufferAllocateInfo::default()
                .command_pool(pool)
                .level(vk::CommandBufferLevel::PRIMARY)
                .command_buffer_count(1);
            // SAFETY: the pool was just made; it is destroyed where it can give no buffer.
            unsafe {
                self.raw.allocate_command_buffers(&info).map(|b| (pool, b[0])).inspect_err(|_| {
                    self.raw.destroy_command_pool(pool, None);
                })
            }
        });
        match made {
            Ok((pool, buffer)) => Ok(Recorder { pool, buffer, crumbs, passes: Vec::new() }),
            Err(e) => {
                self.destroy(Garbage::Buffer(crumbs));
                Err(self.error("vkAllocateCommandBuffers", "a command buffer", e))
            }
        }
    }

    /// Notes that a pass begins and drops its breadcrumb.
    pub(super) fn crumb(&self, recorder: &mut Recorder, pass: &str) {
        let injected = {
            let state = lock(&self.state);
            matches!(&state.inject, Some(at) if at.is_none() || at.as_ref().is_some_and(|at| recorder.passes.contains(at)))
        };
        recorder.passes.push(pass.into());
        let slot = recorder.passes.len() - 1;
        if slot < CRUMBS && !injected {
            // SAFETY: the command buffer is being recorded, outside of rendering; the word is in the buffer, and no
            // other pass of this submission writes it.
            unsafe {
                self.raw.cmd_fill_buffer(recorder.buffer, recorder.crumbs.buffer, slot as u64 * 4, 4, 1);
            }
        }
    }

    /// Gives back what was begun and is not to be submitted.
    pub(super) fn abandon(&self, recorder: Recorder) {
        let mut state = lock(&self.state);
        state.open = state.open.saturating_sub(1);
        state.key_garbage();
        state.free.push(recorder);
    }

    /// Ends and submits; gives the timeline's value.
    ///
    /// SAFETY: semaphores are as Vulkan asks.
    pub(super) unsafe fn submit(
        &self,
        name: &str,
        recorder: Recorder,
        kept: Vec<Box<dyn Any + Send>>,
        wait: &[vk::SemaphoreSubmitInfo<'_>],
        signal: &[vk::SemaphoreSubmitInfo<'_>],
    ) -> Result<u64> {
        // 1. What the device wrote is there for the host once it is done.
        let barrier = [vk::MemoryBarrier2::default()
            .src_stage_mask(vk::PipelineStageFlags2::ALL_COMMANDS)
            .src_access_mask(vk::AccessFlags2::MEMORY_WRITE)
            .dst_stage_mask(vk::PipelineStageFlags2::HOST)
            .dst_access_mask(vk::AccessFlags2::HOST_READ)];
        // SAFETY: the command buffer is being recorded, outside of rendering.
        let ended = unsafe {
            self.raw.cmd_pipeline_barrier2(recorder.buffer, &vk::DependencyInfo::default().memory_barriers(&barrier));
            self.raw.end_command_buffer(recorder.buffer)
        };
        if let Err(e) = ended {
            self.abandon(recorder);
            return Err(self.error("vkEndCommandBuffer", name, e));
        }

        // 2. Submission, in the order of the timeline's values.
        let mut guard = lock(&self.state);
        let state = &mut *guard;
        let inject = state.inject.take();
        if state.lost.is_some() || inject == Some(None) {
            drop(guard);
            self.abandon(recorder);
            drop(kept);
            return Err(self.lost());
        }
        let value = state.last + 1;
        let mut signals = signal.to_vec();
        signals.push(
            vk::SemaphoreSubmitInfo::default()
                .semaphore(self.timeline)
                .value(value)
                .stage_mask(vk::PipelineStageFlags2::ALL_COMMANDS),
        );
        let buffers = [vk::CommandBufferSubmitInfo::default().command_buffer(recorder.buffer)];
        let info = vk::SubmitInfo2::default()
            .wait_semaphore_infos(wait)
            .command_buffer_infos(&buffers)
            .signal_semaphore_infos(&signals);
        // SAFETY: the lock makes us the only user of the queue; the buffer is complete; for the semaphores, the
        // caller.
        let submitted = unsafe { self.raw.queue_submit2(self.queue, &[info], vk::Fence::null()) };
        state.open = state.open.saturating_sub(1);
        if let Err(e) = submitted {
            state.free.push(recorder);
            state.key_garbage();
            drop(guard);
            drop(kept);
            return Err(self.error("vkQueueSubmit2", name, e));
        }
        state.last = value;
        state.key_garbage();
        let lost_here = matches!(&inject, Some(Some(at)) if recorder.passes.contains(at));
        state.in_flight.push_back(InFlight { value, recorder, kept });
        if lost_here {
            drop(guard);
            self.wait_value(value, u64::MAX)?;
            self.lost();
        } else if inject.is_some() {
            state.inject = inject;
        }
        Ok(value)
    }

    /// Waits for a submission, `false` where that takes longer than so many nanoseconds.
    pub(super) fn wait_value(&self, value: u64, nanoseconds: u64) -> Result<bool> {
        self.check_lost()?;
        let (semaphores, values) = ([self.timeline], [value]);
        let info = vk::SemaphoreWaitInfo::default().semaphores(&semaphores).values(&values);
        // SAFETY: a live timeline semaphore.
        match unsafe { self.raw.wait_semaphores(&info, nanoseconds) } {
            Ok(()) => Ok(true),
            Err(vk::Result::TIMEOUT) => Ok(false),
            Err(e) => Err(self.error("vkWaitSemaphores", "the timeline", e)),
        }
    }

    /// Waits for all submissions, and frees what waited for them.
    pub(super) fn wait_all(self: &Arc<Self>) -> Result<()> {
        let last = lock(&self.state).last;
        let waited = self.wait_value(last, u64::MAX);
        self.collect();
        waited.map(|_| ())
    }

    pub(super) fn inject(&self, at: Option<&str>) {
        lock(&self.state).inject = Some(at.map(Into::into));
    }
}
