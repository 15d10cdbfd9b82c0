//! Buffers, images, heaps, uploads and read-back.
#![allow(missing_docs, clippy::unwrap_used)]

mod gpu_support;

use ash::vk;
use gpu_support::{buffer, finish, full_barrier, gpu, read_image, transition};
use shadowgraph::gpu::{BufferInfo, FormatInfo, Gpu, Image, ImageInfo, Memory, Requirements, ViewInfo};

const READ_ONLY: vk::ImageLayout = vk::ImageLayout::SHADER_READ_ONLY_OPTIMAL;

fn transfer() -> vk::ImageUsageFlags {
    vk::ImageUsageFlags::TRANSFER_DST | vk::ImageUsageFlags::TRANSFER_SRC | vk::ImageUsageFlags::SAMPLED
}

/// Bytes that differ from place to place and from seed to seed.
fn noise(count: usize, seed: u64) -> Vec<u8> {
    let mut state = seed.wrapping_mul(0x9e37_79b9_7f4a_7c15) | 1;
    let step = |_| {
        state ^= state << 13;
        state ^= state >> 7;
        state ^= state << 17;
        (state >> 32) as u8
    };
    (0..count).map(step).collect()
}

fn image(gpu: &Gpu, name: &str, format: vk::Format, extent: [u32; 3], mips: u32, layers: u32) -> Image {
    gpu.create_image(&ImageInfo { name, format, extent, mips, layers, usage: transfer(), ..Default::default() })
        .unwrap()
}

#[test]
fn bytes_go_to_the_device_and_back() {
    let gpu = gpu();
    let bytes = noise(100_000, 1);
    let usage = vk::BufferUsageFlags::TRANSFER_DST | vk::BufferUsageFlags::TRANSFER_SRC;
    let device = buffer(&gpu, "device", 100_000, usage, Memory::Device);
    let back = buffer(&gpu, "back", 100_000, usage, Memory::Readback);
    // The whole, then a part over it, then a part over that: later uploads win.
    let mut uploader = gpu.uploader("upload");
    uploader.buffer(&device, 0, &noise(100_000, 2)).unwrap();
    uploader.buffer(&device, 0, &bytes[..60_000]).unwrap();
    uploader.buffer(&device, 60_000, &bytes[60_000..]).unwrap();
    uploader.submit().unwrap();
    let commands = gpu.commands("copy").unwrap();
    let region = [vk::BufferCopy { src_offset: 0, dst_offset: 0, size: 100_000 }];
    // SAFETY: live buffers.
    unsafe { gpu.raw().cmd_copy_buffer(commands.raw(), device.raw(), back.raw(), &region) };
    gpu.wait(gpu.submit(commands).unwrap()).unwrap();
    assert!(back.read().unwrap() == bytes);
    assert_eq!(back.read_with(|b| b[99_999]).unwrap(), bytes[99_999]);
    drop((device, back));
    finish(gpu);
}

#[test]
fn mapped_buffers_check_their_bounds() {
    let gpu = gpu();
    let usage = vk::BufferUsageFlags::TRANSFER_SRC;
    let mapped = buffer(&gpu, "mapped", 16, usage, Memory::Upload);
    mapped.write(12, &[1, 2, 3, 4]).unwrap();
    assert_eq!(mapped.read().unwrap()[12..], [1, 2, 3, 4]);
    for (offset, count) in [(13, 4), (17, 0), (u64::MAX, 1), (0, 17)] {
        let text = mapped.write(offset, &vec![0; count]).unwrap_err().to_string();
        assert!(text.contains("\"mapped\""), "{text}");
    }
    let device = buffer(&gpu, "device", 16, usage, Memory::Device);
    assert!(device.read().unwrap_err().to_string().contains("Memory::Readback"));
    assert!(device.write(0, &[1]).unwrap_err().to_string().contains("\"device\""));
    assert!(device.address().unwrap_err().to_string().contains("SHADER_DEVICE_ADDRESS"));
    let usage = usage | vk::BufferUsageFlags::SHADER_DEVICE_ADDRESS;
    assert_ne!(buffer(&gpu, "addressed", 16, usage, Memory::Device).address().unwrap(), 0);
    drop((mapped, device));
    finish(gpu);
}

#[test]
fn texels_go_to_the_device_and_back() {
    use vk::Format as F;
    let gpu = gpu();
    // Formats of every texel size, sizes that are odd, several levels and layers, three dimensions.
    let cases: [(F, [u32; 3], u32, u32); 9] = [
        (F::R8_UNORM, [13, 7, 1], 4, 3),
        (F::R8G8_UNORM, [5, 5, 1], 1, 2),
        (F::R16_SFLOAT, [9, 3, 1], 2, 1),
        (F::R8G8B8A8_SRGB, [17, 9, 1], 5, 6),
        (F::R32_UINT, [3, 31, 1], 5, 1),
        (F::R16G16B16A16_SFLOAT, [7, 6, 5], 3, 1),
        (F::R32G32_SFLOAT, [64, 1, 1], 7, 2),
        (F::R32G32B32A32_UINT, [11, 11, 1], 1, 1),
        (F::D32_SFLOAT, [8, 8, 1], 2, 2),
    ];
    for (case, (format, extent, mips, layers)) in cases.into_iter().enumerate() {
        let image = image(&gpu, "texels", format, extent, mips, layers);
        let texel = FormatInfo::of(format).unwrap();
        let bytes = |mip: u32, layer: u32| {
            let count = texel.bytes(image.mip_extent(mip)) as usize;
            let seed = u64::from(mip * 100 + layer) + 1000 * case as u64;
            // Depth is kept between 0 and 1.
            if format == F::D32_SFLOAT { [0, 0, 0, 0x3f].repeat(count / 4) } else { noise(count, seed) }
        };
        let mut uploader = gpu.uploader("upload");
        for mip in 0..mips {
            for layer in 0..layers {
                uploader.image(&image, mip, layer, &bytes(mip, layer)).unwrap();
            }
        }
        uploader.submit().unwrap();
        let mut layout = READ_ONLY;
        for mip in 0..mips {
            for layer in 0..layers {
                let back = read_image(&gpu, &image, mip, layer, layout);
                // NaN payloads of half floats may change; all else is kept.
                if format != F::R16_SFLOAT && format != F::R16G16B16A16_SFLOAT {
                    assert!(back == bytes(mip, layer), "{format:?} level {mip} layer {layer}");
                } else {
                    assert_eq!(back.len(), bytes(mip, layer).len());
                    let same = back.iter().zip(bytes(mip, layer)).filter(|(a, b)| **a == *b).count();
                    assert!(same * 10 > back.len() * 9, "{format:?} level {mip} layer {layer}");
                }
                layout = vk::ImageLayout::TRANSFER_SRC_OPTIMAL;
            }
        }
    }
    finish(gpu);
}

#[test]
fn wrong_uploads_are_errors() {
    let gpu = gpu();
    let target = image(&gpu, "target", vk::Format::R8G8B8A8_UNORM, [4, 4, 1], 3, 2);
    let plain = buffer(&gpu, "plain", 16, vk::BufferUsageFlags::STORAGE_BUFFER, Memory::Device);
    let sampled = gpu
        .create_image(&ImageInfo {
            name: "sampled",
            format: vk::Format::R32G32B32A32_UINT,
            extent: [4, 4, 1],
            mips: 2,
            usage: transfer(),
            ..Default::default()
        })
        .unwrap();
    let mut uploader = gpu.uploader("wrong");
    let texts = [
        uploader.image(&target, 0, 0, &[0; 63]).unwrap_err().to_string(),
        uploader.image(&target, 3, 0, &[0; 4]).unwrap_err().to_string(),
        uploader.image(&target, 0, 2, &[0; 64]).unwrap_err().to_string(),
        uploader.buffer(&plain, 0, &[0; 16]).unwrap_err().to_string(),
        gpu.upload_image(&target, &[0; 128]).unwrap_err().to_string(),
    ];
    for (text, part) in texts.iter().zip(["takes 64 bytes, not 63", "level 3", "layer 2", "TRANSFER_DST", "one by one"])
    {
        assert!(text.contains(part), "{text}");
    }
    // It goes on to work.
    uploader.image(&target, 0, 0, &[7; 64]).unwrap();
    uploader.image(&target, 0, 0, &[8; 64]).unwrap();
    uploader.image(&target, 0, 1, &[9; 64]).unwrap();
    uploader.image(&target, 2, 0, &[6; 4]).unwrap();
    uploader.submit().unwrap();
    assert_eq!(read_image(&gpu, &target, 0, 0, READ_ONLY), [8; 64]);
    assert_eq!(read_image(&gpu, &target, 2, 0, vk::ImageLayout::TRANSFER_SRC_OPTIMAL), [6; 4]);
    // One that is given up does nothing.
    let mut given_up = gpu.uploader("given up");
    given_up.image(&sampled, 0, 0, &[1; 256]).unwrap();
    drop(given_up);
    drop((target, plain, sampled));
    finish(gpu);
}

#[test]
fn much_is_uploaded_in_parts() {
    let gpu = gpu();
    let usage = vk::BufferUsageFlags::TRANSFER_DST | vk::BufferUsageFlags::TRANSFER_SRC;
    let target = buffer(&gpu, "target", 40 << 20, usage, Memory::Device);
    let bytes = noise(40 << 20, 9);
    let mut uploader = gpu.uploader("much");
    let picture = image(&gpu, "picture", vk::Format::R8_UNORM, [256, 256, 1], 1, 2);
    uploader.image(&picture, 0, 0, &bytes[..65536]).unwrap();
    for round in 0..5 {
        uploader.buffer(&target, 0, if round == 4 { &bytes } else { &bytes[1 << 20..] }).unwrap();
    }
    uploader.image(&picture, 0, 1, &bytes[65536..131_072]).unwrap();
    let token = uploader.submit().unwrap();
    let back = buffer(&gpu, "back", 40 << 20, usage, Memory::Readback);
    let commands = gpu.commands("copy").unwrap();
    let region = [vk::BufferCopy { src_offset: 0, dst_offset: 0, size: 40 << 20 }];
    // SAFETY: live buffers.
    unsafe { gpu.raw().cmd_copy_buffer(commands.raw(), target.raw(), back.raw(), &region) };
    let copied = gpu.submit(commands).unwrap();
    assert!(copied > token);
    gpu.wait(copied).unwrap();
    assert!(gpu.wait_for(token, std::time::Duration::ZERO).unwrap());
    assert!(back.read_with(|b| b == bytes).unwrap());
    assert!(read_image(&gpu, &picture, 0, 0, READ_ONLY) == bytes[..65536]);
    let source = vk::ImageLayout::TRANSFER_SRC_OPTIMAL;
    assert!(read_image(&gpu, &picture, 0, 1, source) == bytes[65536..131_072]);
    drop((target, picture, back));
    finish(gpu);
}

#[test]
fn two_images_share_a_place() {
    let gpu = gpu();
    let info = |name, format, extent| ImageInfo { name, format, extent, usage: transfer(), ..Default::default() };
    let (a, b) =
        (info("a", vk::Format::R8G8B8A8_UNORM, [64, 64, 1]), info("b", vk::Format::R32G32B32A32_SFLOAT, [32, 16, 1]));
    let c = BufferInfo { name: "c", size: 1000, usage: vk::BufferUsageFlags::TRANSFER_DST, memory: Memory::Device };
    let (needs_a, needs_b) = (gpu.image_requirements(&a).unwrap(), gpu.image_requirements(&b).unwrap());
    let needs_c = gpu.buffer_requirements(&c).unwrap();
    assert!(needs_a.size >= 64 * 64 * 4 && needs_b.size >= 32 * 16 * 16 && needs_c.size >= 1000);
    let both = needs_a.union(needs_b).union(needs_c);
    let granularity = gpu.caps().limits.buffer_image_granularity;
    let behind = both.size.next_multiple_of(both.alignment.max(granularity));
    let heap = gpu.create_heap("frame", Requirements { size: behind + needs_c.size, ..both }, Memory::Device).unwrap();
    assert_eq!(heap.size(), behind + needs_c.size);
    let (image_a, image_b) = (gpu.place_image(&heap, 0, &a).unwrap(), gpu.place_image(&heap, 0, &b).unwrap());
    let buffer_c = gpu.place_buffer(&heap, behind, &c).unwrap();

    // Each is written and read in its turn, though they overlap.
    let bytes = noise(64 * 64 * 4, 3);
    for round in 0..2 {
        gpu.upload_image(&image_a, &bytes).unwrap();
        assert!(read_image(&gpu, &image_a, 0, 0, READ_ONLY) == bytes, "round {round}");
        let commands = gpu.commands("between").unwrap();
        full_barrier(&commands);
        gpu.submit(commands).unwrap();
        let floats: Vec<f32> = (0..32 * 16 * 4).map(|i| i as f32).collect();
        gpu.upload_image(&image_b, bytemuck::cast_slice(&floats)).unwrap();
        assert!(read_image(&gpu, &image_b, 0, 0, READ_ONLY) == bytemuck::cast_slice::<f32, u8>(&floats));
    }

    // What does not fit is an error that names all.
    for (offset, part) in [(1, "multiple"), (heap.size().next_multiple_of(both.alignment), "do not fit")] {
        let text = gpu.place_image(&heap, offset, &a).unwrap_err().to_string();
        assert!(text.contains("image \"a\" in heap \"frame\"") && text.contains(part), "{text}");
    }
    assert!(gpu.place_buffer(&heap, behind + needs_c.alignment, &c).unwrap_err().to_string().contains("buffer \"c\""));
    let none = Requirements { size: 0, alignment: 1, type_bits: 1 };
    assert!(gpu.create_heap("none", none, Memory::Device).is_err());
    let unfitting = Requirements { type_bits: 0, ..both };
    assert!(gpu.create_heap("no type", unfitting, Memory::Device).unwrap_err().to_string().contains("no type"));

    // The heap lives as long as what lies in it.
    drop(heap);
    assert!(gpu.live_objects().contains(&"heap \"frame\"".to_string()));
    drop((image_a, image_b, buffer_c));
    assert!(gpu.live_objects().is_empty(), "{:?}", gpu.live_objects());
    finish(gpu);
}

#[test]
fn impossible_resources_are_errors() {
    let gpu = gpu();
    let good = ImageInfo {
        name: "impossible",
        format: vk::Format::R8G8B8A8_UNORM,
        extent: [16, 16, 1],
        usage: vk::ImageUsageFlags::SAMPLED,
        ..Default::default()
    };
    let bad = [
        ImageInfo { extent: [0, 16, 1], ..good },
        ImageInfo { mips: 6, ..good },
        ImageInfo { mips: 0, ..good },
        ImageInfo { layers: 0, ..good },
        ImageInfo { samples: 3, ..good },
        ImageInfo { samples: 64, usage: vk::ImageUsageFlags::COLOR_ATTACHMENT, ..good },
        ImageInfo { extent: [1 << 20, 1, 1], ..good },
        ImageInfo { cube: true, layers: 5, ..good },
        ImageInfo { array_2d: true, ..good },
        ImageInfo { usage: vk::ImageUsageFlags::DEPTH_STENCIL_ATTACHMENT, ..good },
        ImageInfo { format: vk::Format::UNDEFINED, ..good },
        ImageInfo { usage: vk::ImageUsageFlags::empty(), ..good },
    ];
    for info in bad {
        let text = gpu.create_image(&info).unwrap_err().to_string();
        assert!(text.contains("\"impossible\""), "{info:?}: {text}");
        assert!(gpu.image_requirements(&info).is_err());
    }
    for size in [0, u64::MAX] {
        let info =
            BufferInfo { name: "impossible", size, usage: vk::BufferUsageFlags::STORAGE_BUFFER, ..Default::default() };
        assert!(gpu.create_buffer(&info).unwrap_err().to_string().contains("\"impossible\""));
        assert!(gpu.buffer_requirements(&info).is_err());
    }
    finish(gpu);
}

#[test]
fn views_are_checked_and_kept() {
    let gpu = gpu();
    let usage = transfer() | vk::ImageUsageFlags::STORAGE;
    let cube = gpu
        .create_image(&ImageInfo {
            name: "cube",
            format: vk::Format::R8G8B8A8_UNORM,
            extent: [8, 8, 1],
            mips: 4,
            layers: 12,
            usage,
            cube: true,
            mutable_format: true,
            ..Default::default()
        })
        .unwrap();
    assert_eq!(cube.whole().kind, vk::ImageViewType::CUBE_ARRAY);
    let one = cube.view(&cube.whole().mip(1).layer(7)).unwrap();
    assert_eq!(one, cube.view(&cube.whole().mip(1).layer(7)).unwrap());
    assert_ne!(one, cube.view(&cube.whole().mip(2).layer(7)).unwrap());
    cube.view(&cube.whole().format(vk::Format::R8G8B8A8_SRGB)).unwrap();
    let whole = cube.whole();
    let bad = [
        ViewInfo { mips: [0, 5], ..whole },
        ViewInfo { mips: [2, 2], ..whole },
        ViewInfo { layers: [6, 13], ..whole },
        ViewInfo { layers: [0, 5], ..whole },
        whole.kind(vk::ImageViewType::TYPE_2D),
        whole.aspects(vk::ImageAspectFlags::DEPTH),
    ];
    for view in bad {
        assert!(cube.view(&view).unwrap_err().to_string().contains("\"cube\""), "{view:?}");
    }
    drop(cube);
    if gpu.caps().has(shadowgraph::gpu::Feature::ImageView2DOn3D) {
        let volume = gpu
            .create_image(&ImageInfo {
                name: "volume",
                format: vk::Format::R8G8B8A8_UNORM,
                extent: [8, 8, 8],
                mips: 2,
                usage: vk::ImageUsageFlags::COLOR_ATTACHMENT,
                array_2d: true,
                ..Default::default()
            })
            .unwrap();
        volume.view(&volume.whole().mip(1).layer(3)).unwrap();
        assert!(volume.view(&volume.whole().mip(1).layer(4)).is_err());
    }
    finish(gpu);
}

#[test]
fn one_sampler_for_one_description() {
    use shadowgraph::gpu::SamplerInfo;
    let gpu = gpu();
    let a = gpu.sampler(&SamplerInfo::default()).unwrap();
    assert_eq!(a, gpu.sampler(&SamplerInfo::default()).unwrap());
    assert_ne!(a, gpu.sampler(&SamplerInfo::nearest()).unwrap());
    let compare = SamplerInfo { compare: Some(vk::CompareOp::GREATER), ..SamplerInfo::default() };
    assert_ne!(a, gpu.sampler(&compare).unwrap());
    let minimum = SamplerInfo { reduction: vk::SamplerReductionMode::MIN, ..SamplerInfo::default() };
    let made = gpu.sampler(&minimum);
    assert_eq!(made.is_ok(), gpu.caps().has(shadowgraph::gpu::Feature::SamplerFilterMinmax));
    finish(gpu);
}

#[test]
fn imported_images_are_not_destroyed() {
    let gpu = gpu();
    let info = ImageInfo {
        name: "owner's",
        format: vk::Format::R8_UNORM,
        extent: [4, 4, 1],
        usage: transfer(),
        ..Default::default()
    };
    let owner = gpu.create_image(&info).unwrap();
    // SAFETY: made so, and alive to the end of the test.
    let guest = unsafe { gpu.import_image(owner.raw(), &ImageInfo { name: "guest", ..info }) };
    guest.view(&guest.whole()).unwrap();
    drop(guest);
    gpu.upload_image(&owner, &[5; 16]).unwrap();
    let commands = gpu.commands("still there").unwrap();
    transition(&commands, &owner, READ_ONLY, vk::ImageLayout::GENERAL);
    gpu.wait(gpu.submit(commands).unwrap()).unwrap();
    assert_eq!(read_image(&gpu, &owner, 0, 0, vk::ImageLayout::GENERAL), [5; 16]);
    drop(owner);
    finish(gpu);
}
