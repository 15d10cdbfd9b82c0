//! Textures on the device.

use ash::vk;

use super::{Filter, Scene, Texture, Wrap, depth};
use crate::Result;
use crate::gpu::{Gpu, Image, ImageInfo, Sampler, SamplerInfo, Uploader};

/// How a texture's texels are meant.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(super) enum Encoding {
    Srgb,
    Linear,
    Normal,
}

impl Encoding {
    fn format(self) -> vk::Format {
        match self {
            Self::Srgb => vk::Format::R8G8B8A8_SRGB,
            Self::Linear | Self::Normal => vk::Format::R8G8B8A8_UNORM,
        }
    }
}

/// Device images of the scene's textures, one for each encoding a texture is used in.
pub(super) struct TextureImages {
    made: Vec<[Option<Image>; 2]>,
}

impl TextureImages {
    pub(super) fn new(scene: &Scene) -> Self {
        Self { made: vec![[None, None]; scene.textures.len()] }
    }

    pub(super) fn get(
        &mut self,
        gpu: &Gpu,
        uploader: &mut Uploader,
        scene: &Scene,
        index: usize,
        encoding: Encoding,
    ) -> Result<Image> {
        let place = &mut self.made[index][usize::from(encoding == Encoding::Srgb)];
        if let Some(image) = place {
            return Ok(image.clone());
        }
        let texture = &scene.textures[index];
        let mips = match texture.mip {
            Some(_) => texture.size[0].max(texture.size[1]).max(1).ilog2() + 1,
            None => 1,
        };
        let transfer = vk::ImageUsageFlags::TRANSFER_DST | vk::ImageUsageFlags::TRANSFER_SRC;
        let image = gpu.create_image(&ImageInfo {
            name: &texture.name,
            format: encoding.format(),
            extent: [texture.size[0], texture.size[1], 1],
            mips,
            usage: vk::ImageUsageFlags::SAMPLED | transfer,
            ..ImageInfo::default()
        })?;
        uploader.image(&image, 0, 0, &texture.pixels)?;
        if mips > 1 {
            uploader.generate_mips(&image)?;
        }
        Ok(place.insert(image).clone())
    }
}

pub(super) fn sampler(gpu: &Gpu, texture: &Texture) -> Result<Sampler> {
    let filter = |filter| match filter {
        Filter::Nearest => vk::Filter::NEAREST,
        Filter::Linear => vk::Filter::LINEAR,
    };
    let wrap = |wrap| match wrap {
        Wrap::Repeat => vk::SamplerAddressMode::REPEAT,
        Wrap::MirroredRepeat => vk::SamplerAddressMode::MIRRORED_REPEAT,
        Wrap::ClampToEdge => vk::SamplerAddressMode::CLAMP_TO_EDGE,
    };
    gpu.sampler(&SamplerInfo {
        min: filter(texture.minify),
        mag: filter(texture.magnify),
        mip: match texture.mip {
            Some(Filter::Linear) => vk::SamplerMipmapMode::LINEAR,
            Some(Filter::Nearest) | None => vk::SamplerMipmapMode::NEAREST,
        },
        wrap: [wrap(texture.wrap[0]), wrap(texture.wrap[1]), vk::SamplerAddressMode::REPEAT],
        ..SamplerInfo::default()
    })
}

pub(super) fn texel(gpu: &Gpu, uploader: &mut Uploader, name: &str, rgba: [u8; 4]) -> Result<Image> {
    let usage = vk::ImageUsageFlags::SAMPLED | vk::ImageUsageFlags::TRANSFER_DST;
    let format = vk::Format::R8G8B8A8_UNORM;
    let image = gpu.create_image(&ImageInfo { name, format, usage, ..ImageInfo::default() })?;
    uploader.image(&image, 0, 0, &rgba)?;
    Ok(image)
}

pub(super) fn depth_texel(gpu: &Gpu, uploader: &mut Uploader) -> Result<Image> {
    let usage = vk::ImageUsageFlags::SAMPLED | vk::ImageUsageFlags::TRANSFER_DST;
    let format = vk::Format::D32_SFLOAT;
    let image = gpu.create_image(&ImageInfo { name: "scene.no_depth", format, usage, ..ImageInfo::default() })?;
    uploader.image(&image, 0, 0, bytemuck::bytes_of(&depth::CLEAR))?;
    Ok(image)
}
