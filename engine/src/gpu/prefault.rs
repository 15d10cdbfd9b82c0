//! Pages of memory that a software driver will write, made ready by a thread that has nothing else to do.
//!
//! Memory that was just allocated has no pages behind it; whoever touches a page first waits for the system to find
//! and clear one. Where the driver is software that is its queue's one thread, copying megabytes of contents back while
//! the thread that submitted waits.

use std::ptr::NonNull;

/// Makes the pages of this memory ready to be written; their contents stay. Does nothing where the system cannot.
///
/// # Safety
/// The bytes are one allocation that stays mapped during the call.
pub(super) unsafe fn prefault(first: NonNull<u8>, size: usize) {
    #[cfg(target_os = "linux")]
    {
        use rustix::mm::{Advice, madvise};
        // Whole pages inside the memory alone: neighbours on its first and last page are not asked for.
        let page = rustix::param::page_size();
        let before = first.as_ptr().align_offset(page);
        let Some(whole) = size.checked_sub(before).map(|rest| rest / page * page).filter(|&whole| whole > 0) else {
            return;
        };
        // SAFETY: the pages lie in memory that the caller vouches for, and populating changes no byte of it. A system
        // or a mapping that cannot do it says so; then the pages come one by one, as they would have.
        let _ = unsafe { madvise(first.as_ptr().add(before).cast(), whole, Advice::LinuxPopulateWrite) };
    }
    #[cfg(not(target_os = "linux"))]
    let _ = (first, size);
}
