//! Devices for tests: one of its own where messages and leaks are judged, a shared one for sweeps.

use std::sync::OnceLock;

use shadowgraph::gpu::{Gpu, GpuOptions, Validation};

use crate::harness::{isolated, skip};

/// Opens a device with validation. Panics where there is none: `cargo xtask setup` installs what is missing.
pub fn open() -> Gpu {
    let options = GpuOptions { validation: Validation::On, ..GpuOptions::default() };
    Gpu::headless(options).unwrap_or_else(|error| panic!("{error}"))
}

/// Runs `body` with a device of its own, in a process of its own (see [`isolated`]), and fails on any validation
/// message and on anything that still lives when the device closes.
pub fn isolated_device(name: &str, body: impl FnOnce(&Gpu)) {
    isolated(name, || judged(open(), body));
}

fn judged(gpu: Gpu, body: impl FnOnce(&Gpu)) {
    body(&gpu);
    gpu.wait_idle().unwrap_or_else(|error| panic!("{error}"));
    let messages = gpu.messages().clone();
    silent(&gpu);
    gpu.close().unwrap_or_else(|error| panic!("{error}"));
    let last: Vec<_> = messages.take().iter().map(ToString::to_string).collect();
    assert!(last.is_empty(), "on closing the device:\n{}", last.join("\n"));
}

/// The device that the tests of a process share, with validation. It lives as long as the process.
pub fn shared() -> &'static Gpu {
    static SHARED: OnceLock<Gpu> = OnceLock::new();
    SHARED.get_or_init(open)
}

/// Whether a device snaps vertices to a grid of 1/256 pixel or finer. The tolerances against rays suppose that: a coarser
/// grid moves triangles, and with them depth and ids. Where it does not, the running test is skipped by name.
pub fn snaps_finely(gpu: &Gpu) -> bool {
    let bits = gpu.caps().limits.sub_pixel_bits;
    if bits < 8 {
        skip(&format!("{} snaps vertices to 1/{} pixel; the references suppose 1/256", gpu.caps().device, 1 << bits));
    }
    bits >= 8
}

/// Fails on any validation message since the last time.
pub fn silent(gpu: &Gpu) {
    let messages: Vec<_> = gpu.messages().take().iter().map(ToString::to_string).collect();
    assert!(messages.is_empty(), "{} validation messages:\n{}", messages.len(), messages.join("\n"));
}

#[cfg(test)]
mod tests {
    use super::*;
    use ash::vk;
    use shadowgraph::gpu::{BufferInfo, Memory};

    #[test]
    fn a_device_of_its_own_is_judged() {
        isolated_device("device::tests::a_device_of_its_own_is_judged", |gpu| {
            println!("on {}", gpu.caps().title());
        });
    }

    #[test]
    #[should_panic(expected = "a forgotten buffer")]
    fn a_leak_fails_the_test() {
        isolated_device("device::tests::a_leak_fails_the_test", |gpu| {
            let usage = vk::BufferUsageFlags::TRANSFER_DST;
            let info = BufferInfo { name: "a forgotten buffer", size: 16, usage, memory: Memory::Device };
            std::mem::forget(gpu.create_buffer(&info).unwrap());
        });
    }
}
