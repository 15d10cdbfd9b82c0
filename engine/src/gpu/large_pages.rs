//! A software device's memory is the process's own, and the first touch of each of its pages costs a fault: a frame
//! of 200 MB takes 50 000 of them. Large pages make that a hundred.

use gpu_allocator::vulkan::Allocation;

/// Asks the system to back an allocation with large pages. It may decline; nothing depends on it.
#[cfg(target_os = "linux")]
pub(super) fn ask(allocation: &Allocation) {
    const LARGE: usize = 2 << 20;
    let Some(start) = allocation.mapped_ptr() else { return };
    let first = (start.as_ptr() as usize).next_multiple_of(LARGE);
    let end = start.as_ptr() as usize + allocation.size() as usize;
    if end > first {
        // SAFETY: whole pages within one live mapping; the advice changes no contents.
        unsafe { libc::madvise(first as *mut libc::c_void, (end - first) / 4096 * 4096, libc::MADV_HUGEPAGE) };
    }
}

/// Other systems choose by themselves.
#[cfg(not(target_os = "linux"))]
pub(super) fn ask(_: &Allocation) {}
