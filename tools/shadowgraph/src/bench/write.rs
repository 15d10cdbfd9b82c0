//! Writing of a capture, by compression: the layers of a frame and four shadow maps, made up.

use std::fs;
use std::time::Instant;

use shadowgraph::capture::{Capture, Channel, Compression, ExrOptions, Part, Samples, write_exr};

use crate::cli::BenchArguments;
use crate::failure::Result;

use super::{Measurement, median, milliseconds};

/// Side of a shadow map in texels.
const MAP: u32 = 2048;

/// Measures each compression: time, and size of the file.
pub fn run(arguments: &BenchArguments, tell: &mut impl FnMut(Measurement) -> Result<()>) -> Result<()> {
    let capture = capture(arguments.size.0);
    let path = std::env::temp_dir().join(format!("shadowgraph-bench-{}.exr", std::process::id()));
    for compression in Compression::ALL.into_iter().filter(|compression| arguments.wants(compression.name())) {
        let mut times = Vec::new();
        for _ in 0..arguments.runs {
            let began = Instant::now();
            write_exr(&path, &capture, &ExrOptions { compression })?;
            times.push(milliseconds(began.elapsed()));
        }
        let size = fs::metadata(&path).map_err(|error| shadowgraph::Error::io("look at", &path, error))?.len();
        let case = compression.name().to_string();
        let figure = |metric: &str, value, unit| Measurement {
            bench: "write",
            case: case.clone(),
            metric: metric.into(),
            value,
            unit,
        };
        tell(figure("time", median(times), "ms"))?;
        tell(figure("size", size as f64 / 1e6, "MB"))?;
    }
    fs::remove_file(&path).map_err(|error| shadowgraph::Error::io("remove", &path, error))?;
    Ok(())
}

/// A floor with tiles of a rough texture, seen at an angle under a smooth sky: some of each that compresses well and
/// badly.
fn capture(size: [u32; 2]) -> Capture {
    let [width, height] = size;
    let pixels = || (0..height).flat_map(move |y| (0..width).map(move |x| pixel(x, y, height)));
    let half = |value: fn(&Pixel) -> f32| Samples::F32(pixels().map(|pixel| value(&pixel)).collect()).into_half().0;
    let float = |value: fn(&Pixel) -> f32| Samples::F32(pixels().map(|pixel| value(&pixel)).collect());
    let id = |value: fn(&Pixel) -> u32| Samples::U32(pixels().map(|pixel| value(&pixel)).collect());
    let channels = vec![
        Channel::new("R", half(|p| p.texture[0] * p.light)),
        Channel::new("G", half(|p| p.texture[1] * p.light)),
        Channel::new("B", half(|p| p.texture[2] * p.light)),
        Channel::new("A", half(|p| p.covered)),
        Channel::new("Z", float(|p| p.depth)),
        Channel::new("N.X", half(|p| p.texture[0] * 0.1)),
        Channel::new("N.Y", half(|p| p.covered)),
        Channel::new("N.Z", half(|p| p.texture[1] * 0.1)),
        Channel::new("P.X", float(|p| p.position[0])),
        Channel::new("P.Y", float(|_| 0.0)),
        Channel::new("P.Z", float(|p| p.position[1])),
        Channel::new("albedo.R", half(|p| p.texture[0])),
        Channel::new("albedo.G", half(|p| p.texture[1])),
        Channel::new("albedo.B", half(|p| p.texture[2])),
        Channel::new("roughness", half(|p| p.texture[2])),
        Channel::new("metallic", half(|_| 0.0)),
        Channel::new("emissive.R", half(|_| 0.0)),
        Channel::new("emissive.G", half(|_| 0.0)),
        Channel::new("emissive.B", half(|_| 0.0)),
        Channel::new("direct.R", half(|p| p.texture[0] * p.light * 0.8)),
        Channel::new("direct.G", half(|p| p.texture[1] * p.light * 0.8)),
        Channel::new("direct.B", half(|p| p.texture[2] * p.light * 0.8)),
        Channel::new("shadow.sun", half(|p| p.lit)),
        Channel::new("cascade.index", half(|p| (p.depth * 0.2).min(3.0).floor())),
        Channel::new("id.object", id(|p| p.tile)),
        Channel::new("id.primitive", id(|p| p.tile * 2)),
        Channel::new("id.material", id(|p| p.tile % 7)),
    ];
    let mut parts = vec![Part { name: "frame".into(), size, channels, ..Part::default() }];
    parts.extend((0..4).map(|cascade| {
        let texel = |i: u32| {
            let (x, y) = ((i % MAP) as f32 / MAP as f32, (i / MAP) as f32 / MAP as f32);
            let bump = (x * 9.0).fract() < 0.5 && (y * 9.0).fract() < 0.5;
            0.3 + 0.1 * x + 0.05 * y * cascade as f32 + if bump { 0.2 } else { 0.0 }
        };
        let channels = vec![Channel::new("Z", Samples::F32((0..MAP * MAP).map(texel).collect()))];
        Part { name: format!("map.cascade.{cascade}"), size: [MAP; 2], channels, ..Part::default() }
    }));
    Capture { parts, ..Capture::default() }
}

struct Pixel {
    covered: f32,
    depth: f32,
    position: [f32; 2],
    texture: [f32; 3],
    light: f32,
    lit: f32,
    tile: u32,
}

fn pixel(x: u32, y: u32, height: u32) -> Pixel {
    let below = (y as f32 + 0.5) / height as f32 - 0.3;
    if below <= 0.0 {
        return Pixel {
            covered: 0.0,
            depth: f32::INFINITY,
            position: [0.0; 2],
            texture: [0.0; 3],
            light: 0.0,
            lit: 0.0,
            tile: 0,
        };
    }
    let depth = 1.0 / below;
    let position = [(x as f32 / height as f32 - 0.9) * depth, depth];
    let cell = position.map(|p| (p * 4.0).floor());
    let tile = 1 + ((cell[0] as i32 as u32).wrapping_mul(31).wrapping_add(cell[1] as u32)) % 64;
    // 8-bit noise on a base colour, as textures have it.
    let grain = position.map(|p| (p * 400.0) as i32 as u32);
    let hash = grain[0].wrapping_mul(0x9E37_79B1) ^ grain[1].wrapping_mul(0x85EB_CA77);
    let noise = |shift: u32| (hash.wrapping_mul(0x2C1B_3C6D) >> shift & 31) as f32;
    let texture = [9, 14, 19].map(|shift| (100.0 + (tile * 7 % 90) as f32 + noise(shift)).round() / 255.0);
    let lit = if (position[0] * 0.7).sin() + (position[1] * 0.9).cos() > 0.0 { 1.0 } else { 0.0 };
    Pixel { covered: 1.0, depth, position, texture, light: 2000.0 + 20000.0 * lit, lit, tile }
}
