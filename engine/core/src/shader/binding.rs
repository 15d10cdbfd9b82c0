//! What reflection knows of a shader.

use ash::vk;

/// Shader stage.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Stage {
    /// Vertex shader.
    Vertex,
    /// Geometry shader.
    Geometry,
    /// Fragment shader.
    Fragment,
    /// Compute shader.
    Compute,
}

/// Kind of a descriptor.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum BindingKind {
    /// `uniform` block.
    UniformBuffer,
    /// `buffer` block.
    StorageBuffer,
    /// `sampler2D` and relatives: image and sampler in one.
    CombinedImageSampler,
    /// `texture2D` and relatives.
    SampledImage,
    /// `sampler`.
    Sampler,
    /// `image2D` and relatives.
    StorageImage,
    /// `subpassInput`: a pass's colour attachment, read by its own fragments in primitive order.
    InputAttachment,
}

/// What a shader may do to a binding: from its `readonly` and `writeonly` qualifiers.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum ShaderAccess {
    /// Only loads.
    Read,
    /// Only stores.
    Write,
    /// Loads and stores, or atomics.
    ReadWrite,
}

/// One descriptor binding of a shader.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Binding {
    /// Descriptor set: 0 is the pass's and is bound by the render graph, 1 is the material's. At most 3.
    pub set: u32,
    /// Binding number in the set.
    pub binding: u32,
    /// Name in the shader: of the variable, or of the block where the block has no instance name.
    pub name: &'static str,
    /// Kind of descriptor.
    pub kind: BindingKind,
    /// What the shader may do to it.
    pub access: ShaderAccess,
    /// Array length; 1 where it is no array.
    pub count: u32,
    /// For blocks, bytes of the fixed part; a storage block's run-time array counts as 0. For others 0.
    pub size: u32,
    /// For images, sampled or stored, their type. For others `None`.
    pub image: Option<ImageType>,
}

/// What the shader takes an image for: the view bound to it must be this.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct ImageType {
    /// Kind of view: `sampler2DArray` takes a `TYPE_2D_ARRAY`, `image3D` a `TYPE_3D`.
    pub view: vk::ImageViewType,
    /// Whether it has several samples a texel (`sampler2DMS`).
    pub multisampled: bool,
    /// Whether its sampler compares (`sampler2DShadow`).
    pub comparison: bool,
    /// Format of a storage image, where its `layout` names one; else `UNDEFINED`.
    pub format: vk::Format,
}

/// A vertex shader's input.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Input {
    /// `layout(location = …)`.
    pub location: u32,
    /// Name in the shader.
    pub name: &'static str,
    /// Scalar kind of its components.
    pub scalar: OutputScalar,
    /// 1 to 4.
    pub components: u32,
}

/// A fragment shader's colour output.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Output {
    /// `layout(location = …)`.
    pub location: u32,
    /// Name in the shader.
    pub name: &'static str,
    /// Scalar kind of its components.
    pub scalar: OutputScalar,
    /// 1 to 4.
    pub components: u32,
}

/// Scalar kind of a fragment output or a vertex input.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum OutputScalar {
    /// Float, unorm and the like.
    Float,
    /// Unsigned integer.
    Uint,
    /// Signed integer.
    Int,
}

/// Push constants of a shader.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Push {
    /// Name of the block.
    pub name: &'static str,
    /// Bytes, from offset 0.
    pub size: u32,
}

/// A compiled shader of one stage.
#[derive(Clone, Copy, Debug)]
pub struct Shader {
    /// Path below `shaders_glsl/`, for messages.
    pub file: &'static str,
    /// Its stage.
    pub stage: Stage,
    /// The code, as a file has it (`words` gives it as Vulkan takes it); the entry point is `main`.
    pub spirv: &'static [u8],
    /// Its descriptors, by set and binding.
    pub bindings: &'static [Binding],
    /// Its push constants, where it has some.
    pub push: Option<Push>,
    /// Vertex inputs, by location; other stages have none here.
    pub inputs: &'static [Input],
    /// Fragment outputs, by location; other stages have none here.
    pub outputs: &'static [Output],
    /// Workgroup size, before specialization; `[0; 3]` where it is no compute shader.
    pub workgroup: [u32; 3],
    /// SPIR-V capabilities that Vulkan 1.3 does not promise of every device, by their SPIR-V names, sorted.
    pub capabilities: &'static [&'static str],
}

impl Shader {
    /// The code in words.
    pub fn words(&self) -> Vec<u32> {
        self.spirv.chunks_exact(4).map(|word| u32::from_le_bytes([word[0], word[1], word[2], word[3]])).collect()
    }
}
