//! Work spread over the cores, a row at a time, with a result that does not depend on how.

use std::sync::Mutex;
use std::sync::atomic::{AtomicUsize, Ordering};

/// The rows `row(0)`, `row(1)`, … `row(count - 1)`, one after the other.
pub fn rows<T: Send>(count: usize, row: impl Fn(usize) -> Vec<T> + Sync) -> Vec<T> {
    let threads = std::thread::available_parallelism().map_or(1, |n| n.get()).min(count.max(1));
    let next = AtomicUsize::new(0);
    let done = Mutex::new(Vec::with_capacity(count));
    std::thread::scope(|scope| {
        for _ in 0..threads {
            scope.spawn(|| {
                loop {
                    let y = next.fetch_add(1, Ordering::Relaxed);
                    if y >= count {
                        break;
                    }
                    let values = row(y);
                    done.lock().unwrap_or_else(|poisoned| poisoned.into_inner()).push((y, values));
                }
            });
        }
    });
    let mut done = done.into_inner().unwrap_or_else(|poisoned| poisoned.into_inner());
    done.sort_by_key(|&(y, _)| y);
    done.into_iter().flat_map(|(_, values)| values).collect()
}

#[cfg(test)]
mod tests {
    #[test]
    fn rows_come_in_order_and_none_is_lost() {
        let all = super::rows(97, |y| (0..y % 5).map(|x| (y, x)).collect());
        let expected: Vec<_> = (0..97).flat_map(|y| (0..y % 5).map(move |x| (y, x))).collect();
        assert_eq!(all, expected);
        assert!(super::rows(0, |_| vec![0]).is_empty());
    }
}
