//! Looking into a frame: passes left out, full barriers, contents of any moment as NumPy arrays.

use std::path::{Path, PathBuf};

use shadowgraph::capture::{Samples, unpack, write_npy};
use shadowgraph::graph::description::{ImageShape, Shape};
use shadowgraph::graph::{Capture, Executed, Graph};

use crate::cli::DebugArguments;
use crate::failure::{Failure, Result};

/// Changes a frame that was recorded: leaves passes out, and asks for contents.
pub fn prepare(arguments: &DebugArguments, graph: &mut Graph) -> Result<()> {
    for pass in &arguments.without {
        graph.switch_off(pass).map_err(|error| Failure::input(format!("--without {pass}: {error}")))?;
    }
    for dump in &arguments.dump {
        let refused = |why: String| Failure::input(format!("--dump {dump}: {why}"));
        let (pass, resource) = dump.split_once(':').ok_or_else(|| refused("it is PASS:RESOURCE".into()))?;
        graph.capture_after(pass, resource).map_err(|error| refused(error.to_string()))?;
    }
    Ok(())
}

/// Writes what was asked for beside `output`, and says where.
pub fn write(arguments: &DebugArguments, executed: &Executed, output: &Path) -> Result<Vec<String>> {
    let mut told = Vec::new();
    for dump in &arguments.dump {
        let path = path(output, dump);
        write_array(&path, executed.capture(dump)?)?;
        told.push(format!("wrote {}", path.display()));
    }
    Ok(told)
}

/// `out.exr` and `gbuffer:depth` make `out.gbuffer.depth.npy`.
fn path(output: &Path, dump: &str) -> PathBuf {
    let plain = |letter: char| if letter.is_alphanumeric() || "_-".contains(letter) { letter } else { '-' };
    let names: Vec<String> = dump.splitn(2, ':').map(|name| name.chars().map(plain).collect()).collect();
    output.with_extension(format!("{}.npy", names.join(".")))
}

/// Images as [layers, height, width, components] of their first mip level, buffers as 32-bit words or as bytes.
fn write_array(path: &Path, capture: &Capture) -> Result<()> {
    match &capture.shape {
        Shape::Image(shape) => write_image(path, capture, shape),
        Shape::Buffer { size } if size % 4 == 0 => {
            let words: Vec<u32> = capture.texels()?;
            Ok(write_npy(path, &[words.len()], &words)?)
        }
        Shape::Buffer { .. } => Ok(capture.bytes(|bytes| write_npy(path, &[bytes.len()], bytes))??),
    }
}

fn write_image(path: &Path, capture: &Capture, shape: &ImageShape) -> Result<()> {
    let mut layers = Vec::new();
    for layer in 0..shape.layers {
        layers.push(capture.layer(layer, |bytes| unpack(shape.format, bytes))??);
    }
    let components = layers.first().map_or(0, Vec::len);
    let [width, height, depth] = shape.extent.map(|size| size as usize);
    let axes = [shape.layers as usize * depth, height, width, components];
    let is_uint = layers.iter().flatten().all(|plane| matches!(plane, Samples::U32(_)));
    if is_uint {
        let words = |plane| if let Samples::U32(values) = plane { values } else { Vec::new() };
        return Ok(write_npy(path, &axes, &interleaved(layers, words))?);
    }
    Ok(write_npy(path, &axes, &interleaved(layers, Samples::into_f32))?)
}

/// Planes of each layer as texels.
fn interleaved<T: Copy>(layers: Vec<Vec<Samples>>, values: impl Fn(Samples) -> Vec<T>) -> Vec<T> {
    let mut all = Vec::new();
    for planes in layers {
        let planes: Vec<Vec<T>> = planes.into_iter().map(&values).collect();
        let texels = planes.iter().map(Vec::len).min().unwrap_or(0);
        all.extend((0..texels).flat_map(|texel| planes.iter().map(move |plane| plane[texel])));
    }
    all
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn arrays_lie_beside_the_output() {
        let name = |dump| path(Path::new("out/frame.exr"), dump).display().to_string();
        assert_eq!(name("gbuffer:depth"), "out/frame.gbuffer.depth.npy");
        assert_eq!(name("a/b:spot of x:y"), "out/frame.a-b.spot-of-x-y.npy");
    }
}
