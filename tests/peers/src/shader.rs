//! The pass of every chain: one source, so that every tool runs the same code.

use std::error::Error;

/// `red += 1/255`; alpha is what the frame pushed.
pub const WGSL: &str = r"
struct Push { mark: f32 }
var<immediate> push: Push;
@group(0) @binding(0) var from_image: texture_2d<f32>;
@group(0) @binding(1) var to_image: texture_storage_2d<rgba8unorm, write>;

@compute @workgroup_size(8, 8)
fn main(@builtin(global_invocation_id) id: vec3<u32>) {
    let red = textureLoad(from_image, id.xy, 0).r + 1.0 / 255.0;
    textureStore(to_image, id.xy, vec4(red, 0.0, 0.0, push.mark));
}
";

/// Width and height of the images.
pub const SIZE: u32 = 64;
/// Workgroups along each axis.
pub const GROUPS: u32 = SIZE / 8;

/// The same for Vulkan: push constants of 4 bytes; binding 0 of set 0 is a sampled image, binding 1 a storage image.
pub fn spirv() -> Result<Vec<u32>, Box<dyn Error>> {
    use naga::valid::{Capabilities, ValidationFlags, Validator};
    let module = naga::front::wgsl::parse_str(WGSL)?;
    let info = Validator::new(ValidationFlags::all(), Capabilities::all()).validate(&module)?;
    let stage = naga::ShaderStage::Compute;
    let pipeline = naga::back::spv::PipelineOptions { shader_stage: stage, entry_point: "main".into() };
    Ok(naga::back::spv::write_vec(&module, &info, &naga::back::spv::Options::default(), Some(&pipeline))?)
}

/// What a pass of a frame pushes: another value than the passes around it, and than in the frames around. That of the
/// last pass ends up in the result's alpha.
pub fn mark(frame: u32, pass: u32) -> u8 {
    ((frame + pass) % 255 + 1) as u8
}

/// As a push constant.
pub fn push(frame: u32, pass: u32) -> f32 {
    f32::from(mark(frame, pass)) / 255.0
}
