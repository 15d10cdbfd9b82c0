//! Textures on the device.

use std::collections::BTreeSet;

use ash::vk;

use super::{Filter, Scene, Texture, Wrap, depth, mips};
use crate::gpu::{Gpu, Image, ImageInfo, Sampler, SamplerInfo, Uploader};
use crate::{Error, Result, parallel};

/// How a texture's texels are meant.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(super) enum Encoding {
    Srgb,
    Linear,
    Normal,
}

/// Device images of the scene's textures, one for each encoding a texture is used in.
pub(super) struct TextureImages {
    made: Vec<[Option<Image>; 2]>,
}

impl TextureImages {
    /// Copies to the device what is `used`, mip levels and all.
    pub(super) fn upload(
        gpu: &Gpu,
        uploader: &mut Uploader,
        scene: &Scene,
        used: impl Iterator<Item = (usize, Encoding)>,
    ) -> Result<Self> {
        // 1. Mip levels, on all cores.
        let wanted: BTreeSet<_> = used.map(|(texture, encoding)| (texture, encoding == Encoding::Srgb)).collect();
        let wanted: Vec<(usize, bool)> = wanted.into_iter().collect();
        let levels = |index: usize| {
            let (texture, srgb) = wanted[index];
            let texture = &scene.textures[texture];
            Ok(texture.mip.map_or(Vec::new(), |_| mips::levels(texture, srgb)))
        };
        let fault = |index: usize| Error::invalid(&scene.textures[wanted[index].0].name, "has no mip levels");
        let levels = parallel::map(wanted.len(), levels, fault)?;
        // 2. Images.
        let mut made = vec![[None, None]; scene.textures.len()];
        for (&(index, srgb), levels) in wanted.iter().zip(levels) {
            let texture = &scene.textures[index];
            let image = gpu.create_image(&ImageInfo {
                name: &texture.name,
                format: if srgb { vk::Format::R8G8B8A8_SRGB } else { vk::Format::R8G8B8A8_UNORM },
                extent: [texture.size[0], texture.size[1], 1],
                mips: 1 + levels.len() as u32,
                usage: vk::ImageUsageFlags::SAMPLED | vk::ImageUsageFlags::TRANSFER_DST,
                ..ImageInfo::default()
            })?;
            uploader.image(&image, 0, 0, &texture.pixels)?;
            for (mip, texels) in (1..).zip(&levels) {
                uploader.image(&image, mip, 0, texels)?;
            }
            made[index][usize::from(srgb)] = Some(image);
        }
        Ok(Self { made })
    }

    /// A texture that was said to be used.
    pub(super) fn get(&self, index: usize, encoding: Encoding) -> Option<&Image> {
        self.made[index][usize::from(encoding == Encoding::Srgb)].as_ref()
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
    one_texel(gpu, uploader, name, vk::Format::R8G8B8A8_UNORM, &rgba)
}

pub(super) fn depth_texel(gpu: &Gpu, uploader: &mut Uploader) -> Result<Image> {
    one_texel(gpu, uploader, "scene.no_depth", vk::Format::D32_SFLOAT, bytemuck::bytes_of(&depth::CLEAR))
}

pub(super) fn words_texel(gpu: &Gpu, uploader: &mut Uploader) -> Result<Image> {
    one_texel(gpu, uploader, "scene.no_words", vk::Format::R32G32B32A32_UINT, &[0; 16])
}

fn one_texel(gpu: &Gpu, uploader: &mut Uploader, name: &str, format: vk::Format, bytes: &[u8]) -> Result<Image> {
    let usage = vk::ImageUsageFlags::SAMPLED | vk::ImageUsageFlags::TRANSFER_DST;
    let image = gpu.create_image(&ImageInfo { name, format, usage, ..ImageInfo::default() })?;
    uploader.image(&image, 0, 0, bytes)?;
    Ok(image)
}
