//! Independent work on all cores.

use std::sync::{
    Mutex,
    atomic::{AtomicUsize, Ordering},
};

/// `work(0..count)`, in order. The error is that of the smallest index that fails. A panic within
/// `work` comes back as the error that `panicked` makes of its index.
pub fn map<T: Send, E: Send>(
    count: usize,
    work: impl Fn(usize) -> Result<T, E> + Sync,
    panicked: impl Fn(usize) -> E + Sync,
) -> Result<Vec<T>, E> {
    // The system is asked for its cores by opening files.
    if count == 0 {
        return Ok(Vec::new());
    }
    let workers = std::thread::available_parallelism().map_or(1, usize::from).min(count);
    let next = AtomicUsize::new(0);
    let done = Mutex::new(Vec::with_capacity(count));
    let run = || {
        loop {
            let index = next.fetch_add(1, Ordering::Relaxed);
            if index >= count {
                return;
            }
            // Third-party decoders run in here; a fault in one must stay an error.
            let result = std::panic::catch_unwind(std::panic::AssertUnwindSafe(|| work(index)));
            let result = result.unwrap_or_else(|_| Err(panicked(index)));
            if result.is_err() {
                next.store(count, Ordering::Relaxed);
            }
            done.lock().unwrap_or_else(|poisoned| poisoned.into_inner()).push((index, result));
        }
    };
    std::thread::scope(|scope| {
        for _ in 1..workers {
            // Where the system gives no thread, this one does all the work.
            let _ = std::thread::Builder::new().spawn_scoped(scope, run);
        }
        run();
    });
    let mut done = done.into_inner().unwrap_or_else(|poisoned| poisoned.into_inner());
    done.sort_by_key(|(index, _)| *index);
    done.into_iter().map(|(_, result)| result).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn results_keep_their_order() {
        let squares: Result<Vec<usize>, ()> = map(100, |i| Ok(i * i), |_| ());
        assert_eq!(squares, Ok((0..100).map(|i| i * i).collect()));
    }

    #[test]
    fn errors_and_panics_come_back() {
        assert_eq!(map(10, |i| if i == 3 { Err("three") } else { Ok(()) }, |_| "panic"), Err("three"));
        let hook = std::panic::take_hook();
        std::panic::set_hook(Box::new(|_| ()));
        let result =
            map(4, |i| if i == 2 { panic!("fault in a decoder") } else { Ok(()) }, |i| format!("panic in {i}"));
        std::panic::set_hook(hook);
        assert_eq!(result, Err("panic in 2".into()));
    }
}
