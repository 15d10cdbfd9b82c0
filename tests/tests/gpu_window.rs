//! A window's images: what a swapchain gives and takes back, without the window. lavapipe's surfaces need a display.
#![allow(missing_docs, clippy::unwrap_used)]

mod gpu_support;

use ash::vk;
use gpu_support::{finish, options, read_image};
use shadowgraph::gpu::{Gpu, GpuOptions, ImageInfo};
use shadowgraph::graph::description::Access;
use shadowgraph::graph::{Executor, Graph};

/// The queue goes on when another one's semaphore says so, as an acquired image's does.
fn wait_for_acquired(gpu: &Gpu) {
    let device = gpu.raw();
    // SAFETY: live objects; the queue is used by this thread alone, and idle when the semaphore goes.
    unsafe {
        let queue = device.get_device_queue(gpu.caps().queue_family, 0);
        let acquired = device.create_semaphore(&vk::SemaphoreCreateInfo::default(), None).unwrap();
        let at = vk::PipelineStageFlags2::ALL_COMMANDS;
        let semaphore = [vk::SemaphoreSubmitInfo::default().semaphore(acquired).stage_mask(at)];
        let signal = vk::SubmitInfo2::default().signal_semaphore_infos(&semaphore);
        let wait = vk::SubmitInfo2::default().wait_semaphore_infos(&semaphore);
        device.queue_submit2(queue, &[signal, wait], vk::Fence::null()).unwrap();
        device.queue_wait_idle(queue).unwrap();
        device.destroy_semaphore(acquired, None);
    }
}

/// Draws a frame into an image of the application's that is presented then.
fn draw(gpu: &Gpu, executor: &mut Executor, raw: vk::Image, info: &ImageInfo, value: f32) {
    // SAFETY: made as `info` says, and alive to the end of the test.
    let window = unsafe { gpu.import_image(raw, info) };
    let mut graph: Graph = executor.graph("frame");
    let window = graph.import_image(&window, Access::NONE, Some(Access::present()));
    let window = graph.clear("draw", window, vk::ClearColorValue { float32: [value; 4] });
    graph.keep("shown", &window);
    let plan = executor.plan(&graph).unwrap();
    executor.execute(&plan, graph).unwrap();
}

#[test]
fn a_swapchain_s_images_take_turns_and_are_left_to_be_presented() {
    let of_windows = GpuOptions {
        instance_extensions: vec!["VK_KHR_surface".into()],
        device_extensions: vec!["VK_KHR_swapchain".into()],
        ..options()
    };
    let gpu = Gpu::headless(of_windows).unwrap();
    let info = ImageInfo {
        name: "window",
        format: vk::Format::R8_UNORM,
        extent: [16, 8, 1],
        usage: vk::ImageUsageFlags::TRANSFER_DST | vk::ImageUsageFlags::TRANSFER_SRC,
        ..Default::default()
    };
    let images = [(); 3].map(|()| gpu.create_image(&info).unwrap());
    let mut executor = Executor::new(&gpu);
    for frame in 0..7_u8 {
        let image = &images[usize::from(frame) % 3];
        wait_for_acquired(&gpu);
        draw(&gpu, &mut executor, image.raw(), &info, f32::from(frame) / 255.0);
        // What is presented holds what was drawn, in the layout of presentation.
        assert_eq!(read_image(&gpu, image, 0, 0, vk::ImageLayout::PRESENT_SRC_KHR), [frame; 128], "frame {frame}");
    }
    drop((executor, images));
    finish(gpu);
}
