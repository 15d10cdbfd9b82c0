//! Measuring one tool in one mode: the CPU time that its frames take.

use std::error::Error;

use crate::shader;

pub type Result<T> = std::result::Result<T, Box<dyn Error>>;

/// One tool in one mode, set up for a chain of so many passes.
pub trait Chain {
    /// A whole frame, until the device is done: all of it is measured.
    fn frame(&mut self, frame: u32) -> Result<()>;

    /// The texel that the last frame read back. Not measured.
    fn texel(&mut self) -> Result<[u8; 4]>;

    /// Bytes of the memory behind the chain's images; `None` where the tool does not say.
    fn transient_bytes(&self) -> Option<u64>;
}

/// CPU time of each frame in microseconds.
pub struct Times {
    /// Of the thread that submits.
    pub thread: Vec<f64>,
    /// Of the process: the software driver's threads included.
    pub process: Vec<f64>,
}

/// Frames before those that count.
const WARM_UP: u32 = 10;

/// Runs frames, each of which is checked.
pub fn measure(chain: &mut dyn Chain, passes: u32, frames: u32) -> Result<Times> {
    let mut times = Times { thread: Vec::new(), process: Vec::new() };
    for frame in 0..WARM_UP + frames {
        let before = [libc::CLOCK_THREAD_CPUTIME_ID, libc::CLOCK_PROCESS_CPUTIME_ID].map(clock);
        chain.frame(frame)?;
        let after = [libc::CLOCK_THREAD_CPUTIME_ID, libc::CLOCK_PROCESS_CPUTIME_ID].map(clock);
        let expected = [passes.min(255) as u8, 0, 0, shader::mark(frame, passes)];
        let found = chain.texel()?;
        if found != expected {
            return Err(format!("frame {frame} gave {found:?}, not {expected:?}").into());
        }
        if frame >= WARM_UP {
            times.thread.push(after[0] - before[0]);
            times.process.push(after[1] - before[1]);
        }
    }
    Ok(times)
}

/// Microseconds.
fn clock(id: libc::clockid_t) -> f64 {
    let mut time = libc::timespec { tv_sec: 0, tv_nsec: 0 };
    // SAFETY: it writes the structure it is given; both clocks exist on Linux.
    unsafe { libc::clock_gettime(id, &mut time) };
    time.tv_sec as f64 * 1e6 + time.tv_nsec as f64 * 1e-3
}

/// The middle one, or the mean of the two in the middle; 0 of nothing.
pub fn median(values: &[f64]) -> f64 {
    let mut values = values.to_vec();
    values.sort_by(f64::total_cmp);
    match values.len() {
        0 => 0.0,
        n if n % 2 == 1 => values[n / 2],
        n => (values[n / 2 - 1] + values[n / 2]) / 2.0,
    }
}
