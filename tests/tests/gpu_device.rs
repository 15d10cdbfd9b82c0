//! Opening a device, what it says, and how it ends.
#![allow(missing_docs, clippy::unwrap_used)]

mod gpu_support;

use ash::vk;
use gpu_support::{buffer, finish, full_barrier, gpu, options};
use shadowgraph::Error;
use shadowgraph::gpu::{Caps, Feature, Gpu, GpuOptions, Memory, Severity, Validation};

#[test]
fn a_device_opens_and_closes() {
    let gpu = gpu();
    let caps = gpu.caps();
    println!("{}", caps.title());
    assert!(!caps.device.is_empty() && !caps.driver.is_empty());
    assert!(caps.api_version >= [1, 3, 0]);
    assert!(caps.limits.max_image_dimension_2d >= 4096);
    assert!(caps.queue_families[caps.queue_family as usize].graphics);
    assert!(caps.has(Feature::Timestamps));
    assert!(serde_json::to_string(caps).unwrap().contains("max_image_dimension_2d"));
    finish(gpu);
}

#[test]
fn without_validation_there_is_no_layer() {
    let gpu = Gpu::headless(GpuOptions::default()).unwrap();
    let bad = buffer(&gpu, "b", 16, vk::BufferUsageFlags::STORAGE_BUFFER, Memory::Device);
    let commands = gpu.commands("bad").unwrap();
    // SAFETY: wrong on purpose (no TRANSFER_DST); harmless on the drivers that tests run on.
    unsafe { gpu.raw().cmd_fill_buffer(commands.raw(), bad.raw(), 0, 4, 1) };
    drop(commands);
    assert!(gpu.messages().is_empty());
    drop(bad);
    gpu.close().unwrap();
}

#[test]
fn gpu_assisted_validation_opens() {
    let gpu = Gpu::headless(GpuOptions { validation: Validation::GpuAssisted, ..Default::default() }).unwrap();
    // Without 64-bit integers the layer says what it leaves out.
    let said = gpu.messages().take();
    let int64 = gpu.caps().has(Feature::Int64);
    assert!(said.iter().all(|m| !int64 && m.text.contains("shaderInt64")), "{said:?}");
    finish(gpu);
}

#[test]
fn a_device_is_chosen_by_a_part_of_its_name() {
    let first = gpu();
    let name = first.caps().device.to_uppercase();
    let part = name[..4].to_string();
    let second = Gpu::headless(GpuOptions { device: Some(part), ..options() }).unwrap();
    assert_eq!(first.caps(), second.caps());
    finish(first);
    finish(second);

    let none = Gpu::headless(GpuOptions { device: Some("no such device".into()), ..options() });
    let error = none.unwrap_err();
    assert!(matches!(error, Error::NoDevice { .. }));
    let text = error.to_string().to_uppercase();
    assert!(text.contains("NO SUCH DEVICE") && text.contains(&name), "{text}");
}

/// The environment is read in a process of its own, since a test must not change its own.
#[test]
fn the_environment_names_a_device() {
    let child = |value: &str| {
        std::process::Command::new(std::env::current_exe().unwrap())
            .args(["--exact", "child_opens_a_device", "--ignored"])
            .env("SHADOWGRAPH_DEVICE", value)
            .output()
            .unwrap()
    };
    assert!(child("").status.success());
    let refused = child("no such device");
    assert!(!refused.status.success());
    assert!(String::from_utf8_lossy(&refused.stdout).contains("no such device"), "{refused:?}");
}

#[test]
#[ignore = "run by the_environment_names_a_device"]
fn child_opens_a_device() {
    Gpu::headless(GpuOptions::default()).unwrap();
}

#[test]
fn all_that_is_missing_is_said_at_once() {
    let caps = Caps { device: "toaster".into(), features: [Feature::LogicOp].into(), ..Default::default() };
    caps.require("XOR voxels", &[Feature::LogicOp]).unwrap();
    let error = caps.require("XOR voxels", &[Feature::Int64, Feature::LogicOp, Feature::GeometryShader]);
    let text = error.unwrap_err().to_string();
    for part in ["toaster", "XOR voxels", "shaderInt64", "geometryShader"] {
        assert!(text.contains(part), "{text}");
    }
    assert!(!text.contains("logicOp"), "{text}");

    let wanted = GpuOptions {
        device_extensions: vec!["VK_ONE_missing".into(), "VK_TWO_missing".into()],
        instance_extensions: vec![],
        ..options()
    };
    let text = Gpu::headless(wanted).unwrap_err().to_string();
    assert!(text.contains("VK_ONE_missing") && text.contains("VK_TWO_missing"), "{text}");
    let wanted = GpuOptions { instance_extensions: vec!["VK_THREE_missing".into()], ..options() };
    assert!(Gpu::headless(wanted).unwrap_err().to_string().contains("VK_THREE_missing"));
}

#[test]
fn a_message_names_object_and_pass() {
    let gpu = gpu();
    let target = buffer(&gpu, "lonely", 16, vk::BufferUsageFlags::STORAGE_BUFFER, Memory::Device);
    let mut commands = gpu.commands("frame").unwrap();
    commands.begin_pass("outer");
    commands.begin_label("inner");
    // SAFETY: wrong on purpose: the buffer lacks TRANSFER_DST.
    unsafe { gpu.raw().cmd_fill_buffer(commands.raw(), target.raw(), 0, 16, 7) };
    commands.end_label();
    commands.end_pass();
    drop(commands);
    let messages = gpu.messages().take();
    assert_eq!(messages.len(), 1, "{messages:?}");
    let message = &messages[0];
    assert_eq!(message.severity, Severity::Error);
    assert!(message.id_name.starts_with("VUID-vkCmdFillBuffer-dstBuffer"), "{message}");
    assert!(message.objects.iter().any(|o| o == "buffer \"lonely\""), "{message:?}");
    assert_eq!(message.labels, ["inner", "outer"]);
    assert!(gpu.messages().is_empty());
    drop(target);
    finish(gpu);
}

#[test]
fn synchronisation_is_validated() {
    let gpu = gpu();
    let usage = vk::BufferUsageFlags::TRANSFER_DST | vk::BufferUsageFlags::TRANSFER_SRC;
    let [a, b] = ["a", "b"].map(|n| buffer(&gpu, n, 64, usage, Memory::Device));
    for ordered in [true, false] {
        let mut commands = gpu.commands("frame").unwrap();
        commands.begin_pass("fill and copy");
        // SAFETY: live buffers; the hazard is on purpose.
        unsafe {
            gpu.raw().cmd_fill_buffer(commands.raw(), a.raw(), 0, 64, 7);
            if ordered {
                full_barrier(&commands);
            }
            let region = [vk::BufferCopy { src_offset: 0, dst_offset: 0, size: 64 }];
            gpu.raw().cmd_copy_buffer(commands.raw(), a.raw(), b.raw(), &region);
        }
        drop(commands);
        let messages = gpu.messages().take();
        assert_eq!(messages.len(), usize::from(!ordered), "{messages:?}");
        if let Some(message) = messages.first() {
            assert_eq!(message.id_name, "SYNC-HAZARD-READ-AFTER-WRITE");
            assert_eq!(message.labels, ["fill and copy"]);
            assert!(message.objects.contains(&"buffer \"a\"".into()), "{message:?}");
        }
    }
    drop((a, b));
    finish(gpu);
}

#[test]
fn a_leak_is_named() {
    let gpu = gpu();
    let messages = gpu.messages().clone();
    let kept = buffer(&gpu, "forgotten", 16, vk::BufferUsageFlags::STORAGE_BUFFER, Memory::Device);
    let clone = kept.clone();
    drop(kept);
    assert_eq!(gpu.live_objects(), ["buffer \"forgotten\""]);
    let text = gpu.close().unwrap_err().to_string();
    assert!(text.contains("buffer \"forgotten\""), "{text}");
    // The device goes with the last object, in order.
    assert_eq!(clone.size(), 16);
    drop(clone);
    assert!(messages.is_empty(), "{:?}", messages.take());
}

#[test]
fn a_dropped_object_lives_until_the_device_is_done() {
    let gpu = gpu();
    let usage = vk::BufferUsageFlags::TRANSFER_DST | vk::BufferUsageFlags::TRANSFER_SRC;
    let result = buffer(&gpu, "result", 64, vk::BufferUsageFlags::TRANSFER_DST, Memory::Readback);
    for round in 0..20u32 {
        let source = buffer(&gpu, "source", 64, usage, Memory::Device);
        let commands = gpu.commands("frame").unwrap();
        // SAFETY: live buffers.
        unsafe {
            full_barrier(&commands);
            gpu.raw().cmd_fill_buffer(commands.raw(), source.raw(), 0, 64, round);
            full_barrier(&commands);
            let region = [vk::BufferCopy { src_offset: 0, dst_offset: 0, size: 64 }];
            gpu.raw().cmd_copy_buffer(commands.raw(), source.raw(), result.raw(), &region);
        }
        // Dropped while recorded in one round, in flight in the next.
        let early = (round % 2 == 0).then(|| source.clone());
        if round % 2 == 0 {
            let mut commands = commands;
            commands.keep(source);
            gpu.submit(commands).unwrap();
        } else {
            let token = gpu.submit(commands).unwrap();
            drop(source);
            gpu.wait(token).unwrap();
            let words: Vec<u32> = bytemuck::pod_collect_to_vec(&result.read().unwrap());
            assert_eq!(words, [round; 16]);
        }
        drop(early);
    }
    gpu.wait_idle().unwrap();
    assert_eq!(gpu.live_objects(), ["buffer \"result\""]);
    drop(result);
    finish(gpu);
}

#[test]
fn a_lost_device_names_its_last_pass() {
    let gpu = gpu();
    gpu.inject_device_loss(Some("lighting"));
    let mut commands = gpu.commands("frame").unwrap();
    for pass in ["depth", "lighting", "post"] {
        commands.begin_pass(pass);
        commands.end_pass();
    }
    let token = gpu.submit(commands).unwrap();
    let lost = |e: Error| match e {
        Error::DeviceLost { last_pass } => last_pass,
        other => panic!("{other}"),
    };
    assert_eq!(lost(gpu.wait(token).unwrap_err()).as_deref(), Some("lighting"));
    assert_eq!(lost(gpu.commands("next").err().unwrap()).as_deref(), Some("lighting"));
    let messages = gpu.messages().clone();
    assert_eq!(lost(gpu.close().unwrap_err()).as_deref(), Some("lighting"));
    assert!(messages.is_empty(), "{:?}", messages.take());
}

#[test]
fn a_device_lost_at_submission_names_the_pass_before() {
    let gpu = gpu();
    let mut commands = gpu.commands("first frame").unwrap();
    commands.begin_pass("only");
    gpu.wait(gpu.submit(commands).unwrap()).unwrap();
    gpu.inject_device_loss(None);
    let mut commands = gpu.commands("second frame").unwrap();
    commands.begin_pass("never begun");
    let error = gpu.submit(commands).unwrap_err();
    assert!(matches!(&error, Error::DeviceLost { last_pass: Some(pass) } if pass == "only"), "{error}");
    let messages = gpu.messages().clone();
    drop(gpu);
    assert!(messages.is_empty(), "{:?}", messages.take());
}

#[test]
fn the_pipeline_cache_survives_damage() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("below/pipelines.bin");
    let open = || Gpu::headless(GpuOptions { pipeline_cache: Some(path.clone()), ..options() }).unwrap();
    finish(open());
    let good = std::fs::read(&path).unwrap();
    assert!(good.len() >= 16 + 32, "{} bytes", good.len());
    for bad in [&good[..good.len() - 1], &[0xff; 100], &[]] {
        std::fs::write(&path, bad).unwrap();
        finish(open());
        assert_eq!(std::fs::read(&path).unwrap().len(), good.len());
    }
    assert_eq!(std::fs::read_dir(path.parent().unwrap()).unwrap().count(), 1, "a temporary file is left");
}

#[test]
fn a_cache_that_cannot_be_written_is_an_error() {
    let folder = tempfile::tempdir().unwrap();
    let gpu = Gpu::headless(GpuOptions { pipeline_cache: Some(folder.path().into()), ..options() }).unwrap();
    let text = gpu.close().unwrap_err().to_string();
    assert!(text.contains(&*folder.path().to_string_lossy()), "{text}");
}

#[test]
fn an_application_s_device_is_left_alone() {
    // An application's device: opened by another `Gpu` here.
    let owner = gpu();
    let family = owner.caps().queue_family;
    // SAFETY: the handles are of `owner`, which outlives `guest` and submits nothing meanwhile.
    let guest = unsafe {
        Gpu::from_raw(shadowgraph::gpu::RawGpu {
            entry: ash::Entry::load().unwrap(),
            instance: owner.raw_instance().clone(),
            physical_device: owner.raw_physical_device(),
            device: owner.raw().clone(),
            queue: owner.raw().get_device_queue(family, 0),
            queue_family: family,
            features: [Feature::LogicOp].into(),
            debug_utils: true,
            pipeline_cache: None,
        })
        .unwrap()
    };
    assert!(!guest.caps().has(Feature::GeometryShader));
    let data = buffer(&guest, "data", 16, vk::BufferUsageFlags::TRANSFER_DST, Memory::Device);
    let token = guest.upload_buffer(&data, &[1; 16]).unwrap();
    guest.wait(token).unwrap();
    drop(data);
    guest.close().unwrap();
    owner.wait_idle().unwrap();
    finish(owner);
}

#[test]
fn objects_cross_threads() {
    fn send_and_sync<T: Send + Sync>() {}
    fn send<T: Send>() {}
    use shadowgraph::gpu::*;
    send_and_sync::<Gpu>();
    send_and_sync::<Buffer>();
    send_and_sync::<Image>();
    send_and_sync::<Heap>();
    send_and_sync::<Pipeline>();
    send_and_sync::<DescriptorSet>();
    send_and_sync::<DescriptorArena>();
    send_and_sync::<QueryPool>();
    send_and_sync::<SetLayout>();
    send_and_sync::<Messages>();
    send::<Commands>();
    send::<Uploader<'static>>();

    let gpu = gpu();
    std::thread::scope(|scope| {
        for thread in 0..4u8 {
            let gpu = &gpu;
            scope.spawn(move || {
                for _ in 0..10 {
                    let usage = vk::BufferUsageFlags::TRANSFER_DST;
                    let data = buffer(gpu, "data", 4096, usage, Memory::Device);
                    let token = gpu.upload_buffer(&data, &[thread; 4096]).unwrap();
                    gpu.wait(token).unwrap();
                }
            });
        }
    });
    finish(gpu);
}
