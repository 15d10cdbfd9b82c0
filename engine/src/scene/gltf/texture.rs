//! Textures: images decoded on all cores, with their samplers. glTF 2.0, section 3.8.

use std::{
    collections::HashMap,
    io::Cursor,
    sync::{
        Arc,
        atomic::{AtomicU64, Ordering},
    },
};

use ::gltf::json::{
    texture::{MagFilter, MinFilter, WrappingMode},
    validation::Checked,
};
use image::{ImageFormat, ImageReader, Limits};

use super::{File, material::UsedTexture, place, uri};
use crate::{
    error::Result,
    parallel,
    scene::{Filter, Texture, Wrap},
};

/// Bytes of decoded images that a file may ask for: 64 images of 4096².
const DECODED_LIMIT: u64 = 4 << 30;
/// Texels a side.
const SIDE_LIMIT: u32 = 16384;

/// Decodes each image once and gives a texture for each use of it with a sampler.
pub fn load(file: &File, used: &[UsedTexture]) -> Result<Vec<Texture>> {
    let mut images: Vec<&UsedTexture> = Vec::new();
    let mut slots = HashMap::new();
    for texture in used {
        slots.entry(texture.image).or_insert_with(|| {
            images.push(texture);
            images.len() - 1
        });
    }
    let left = AtomicU64::new(DECODED_LIMIT);
    let at = |i: usize| format!("{}, {}", images[i].user, place("image", images[i].image, Some(&images[i].name)));
    let decoded = parallel::map(
        images.len(),
        |i| decode(file, images[i].image, &at(i), &left),
        |i| file.error(at(i), "the decoder gave up on this image"),
    )?;
    let textures = used.iter().filter_map(|texture| {
        let (size, pixels) = decoded.get(*slots.get(&texture.image)?)?;
        Some(sampled(file, texture, *size, pixels.clone()))
    });
    textures.collect()
}

/// Size and RGBA8 rows from the top. Colour-space chunks have no effect (section 3.9.2).
fn decode(file: &File, image: usize, at: &str, left: &AtomicU64) -> Result<([u32; 2], Arc<[u8]>)> {
    let Some(source) = file.root.images.get(image) else { return Err(file.error(at, "there is no such image")) };
    let mut at = at.to_owned();
    let read;
    let bytes: &[u8] = match (&source.uri, source.buffer_view) {
        (Some(text), _) => {
            read = match uri::parse(text).map_err(|what| file.error(&at, what))? {
                uri::Uri::Data(data) => data,
                uri::Uri::File(name) => {
                    let whole = file.path.with_file_name(&name);
                    at = format!("{at}, {}", name.display());
                    uri::read_file(&whole, DECODED_LIMIT).map_err(|error| file.error(&at, error.to_string()))?
                }
            };
            &read
        }
        (None, Some(view)) => file.view(view, &at)?,
        (None, None) => return Err(file.error(&at, "has neither a URI nor a bufferView")),
    };

    let fail = |error: image::ImageError| file.error(&at, format!("broken image: {error}"));
    let format = image::guess_format(bytes).ok();
    let Some(format) = format.filter(|format| matches!(format, ImageFormat::Png | ImageFormat::Jpeg)) else {
        return Err(file.error(&at, "is neither PNG nor JPEG"));
    };
    let reader = || ImageReader::with_format(Cursor::new(bytes), format);
    let (width, height) = reader().into_dimensions().map_err(fail)?;
    let bytes_decoded = (u64::from(width) * u64::from(height)).saturating_mul(4);
    let spend = |left: u64| left.checked_sub(bytes_decoded);
    if width > SIDE_LIMIT
        || height > SIDE_LIMIT
        || left.fetch_update(Ordering::Relaxed, Ordering::Relaxed, spend).is_err()
    {
        let what = format!(
            "{width}×{height} is too large: {SIDE_LIMIT} texels a side and {DECODED_LIMIT} bytes in all are allowed"
        );
        return Err(file.error(&at, what));
    }
    let mut reader = reader();
    let mut limits = Limits::default();
    limits.max_alloc = Some(2 << 30);
    reader.limits(limits);
    let pixels = reader.decode().map_err(fail)?.into_rgba8();
    let size = [pixels.width(), pixels.height()];
    if size.contains(&0) {
        return Err(file.error(&at, "has no texels"));
    }
    Ok((size, pixels.into_raw().into()))
}

fn sampled(file: &File, used: &UsedTexture, size: [u32; 2], pixels: Arc<[u8]>) -> Result<Texture> {
    let mut texture = Texture {
        name: used.name.clone(),
        size,
        pixels,
        wrap: [Wrap::Repeat; 2],
        magnify: Filter::Linear,
        minify: Filter::Linear,
        mip: Some(Filter::Linear),
    };
    let Some(sampler) = used.sampler.and_then(|sampler| file.root.samplers.get(sampler)) else { return Ok(texture) };
    let unknown =
        || file.error(place("sampler", used.sampler.unwrap_or(0), None), "has a value that glTF does not know");
    let wrap = |mode: Checked<WrappingMode>| match mode {
        Checked::Valid(WrappingMode::ClampToEdge) => Ok(Wrap::ClampToEdge),
        Checked::Valid(WrappingMode::MirroredRepeat) => Ok(Wrap::MirroredRepeat),
        Checked::Valid(WrappingMode::Repeat) => Ok(Wrap::Repeat),
        Checked::Invalid => Err(unknown()),
    };
    texture.wrap = [wrap(sampler.wrap_s)?, wrap(sampler.wrap_t)?];
    texture.magnify = match sampler.mag_filter {
        None | Some(Checked::Valid(MagFilter::Linear)) => Filter::Linear,
        Some(Checked::Valid(MagFilter::Nearest)) => Filter::Nearest,
        Some(Checked::Invalid) => return Err(unknown()),
    };
    (texture.minify, texture.mip) = match sampler.min_filter {
        None | Some(Checked::Valid(MinFilter::LinearMipmapLinear)) => (Filter::Linear, Some(Filter::Linear)),
        Some(Checked::Valid(MinFilter::Nearest)) => (Filter::Nearest, None),
        Some(Checked::Valid(MinFilter::Linear)) => (Filter::Linear, None),
        Some(Checked::Valid(MinFilter::NearestMipmapNearest)) => (Filter::Nearest, Some(Filter::Nearest)),
        Some(Checked::Valid(MinFilter::LinearMipmapNearest)) => (Filter::Linear, Some(Filter::Nearest)),
        Some(Checked::Valid(MinFilter::NearestMipmapLinear)) => (Filter::Nearest, Some(Filter::Linear)),
        Some(Checked::Invalid) => return Err(unknown()),
    };
    Ok(texture)
}
