//! What a device can do: asked here and nowhere else.

use std::collections::BTreeSet;

use serde::Serialize;

use crate::{Error, Result};

/// What a device is and can do. Plain data: plans are tested with made-up ones.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct Caps {
    /// Name of the device: `llvmpipe (LLVM 15.0.6, 256 bits)`.
    pub device: String,
    /// Kind of device.
    pub kind: DeviceKind,
    /// Name of the driver: `llvmpipe`.
    pub driver: String,
    /// The driver's own words on its build: `Mesa 22.3.6 (LLVM 15.0.6)`.
    pub driver_info: String,
    /// The driver's version number, in the vendor's packing.
    pub driver_version: u32,
    /// Vulkan version: major, minor, patch.
    pub api_version: [u32; 3],
    /// Vendor and device number.
    pub ids: [u32; 2],
    /// Optional features, all enabled where the device has them. Required ones are always there.
    pub features: BTreeSet<Feature>,
    /// Limits that the engine or its techniques look at.
    pub limits: Limits,
    /// Queue families, by index.
    pub queue_families: Vec<QueueFamily>,
    /// The family that the engine submits to.
    pub queue_family: u32,
}

/// Kind of device, worst first.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize)]
pub enum DeviceKind {
    /// Something else.
    #[default]
    Other,
    /// A software driver.
    Cpu,
    /// A part of a graphics card given to a virtual machine.
    Virtual,
    /// On the processor's die.
    Integrated,
    /// A graphics card.
    Discrete,
}

/// A queue family.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize)]
pub struct QueueFamily {
    /// Draws.
    pub graphics: bool,
    /// Dispatches.
    pub compute: bool,
    /// Copies.
    pub transfer: bool,
    /// Queues in it.
    pub count: u32,
    /// Valid bits of a timestamp; 0: no timestamps.
    pub timestamp_bits: u32,
}

impl Caps {
    /// Whether the device has an optional feature.
    pub fn has(&self, feature: Feature) -> bool {
        self.features.contains(&feature)
    }

    /// Demands optional features for `who` (a technique, a pipeline).
    ///
    /// # Errors
    /// One [`Error::Missing`] with all that the device lacks.
    pub fn require(&self, who: &str, features: &[Feature]) -> Result<()> {
        let missing: Vec<String> = features.iter().filter(|&&f| !self.has(f)).map(|f| f.describe()).collect();
        if missing.is_empty() {
            return Ok(());
        }
        Err(Error::Missing { device: self.title(), who: who.into(), missing })
    }

    /// Device and driver in one line.
    pub fn title(&self) -> String {
        format!("{} ({})", self.device, format!("{} {}", self.driver, self.driver_info).trim())
    }
}

macro_rules! features {
    ($($(#[$doc:meta])* $name:ident = $vulkan:literal,)*) => {
        /// Something that a technique may want and not every device has.
        #[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize)]
        #[non_exhaustive]
        pub enum Feature {
            $($(#[$doc])* #[doc = concat!("\n\n`", $vulkan, "`.")] #[serde(rename = $vulkan)] $name,)*
        }

        impl Feature {
            /// All of them.
            pub const ALL: &[Feature] = &[$(Feature::$name,)*];

            /// Vulkan's name for it: of a feature, or of the extension that brings it.
            pub fn vulkan_name(self) -> &'static str {
                match self {
                    $(Feature::$name => $vulkan,)*
                }
            }
        }
    };
}

features! {
    /// Geometry shaders.
    GeometryShader = "geometryShader",
    /// Tessellation shaders.
    TessellationShader = "tessellationShader",
    /// Logic operations on integer attachments.
    LogicOp = "logicOp",
    /// A vertex shader writes `gl_Layer`.
    LayerFromVertexShader = "shaderOutputLayer",
    /// A vertex shader writes `gl_ViewportIndex`.
    ViewportFromVertexShader = "shaderOutputViewportIndex",
    /// `gl_BaseInstance` and `gl_DrawID`.
    DrawParameters = "shaderDrawParameters",
    /// 64-bit integers in shaders.
    Int64 = "shaderInt64",
    /// 64-bit floats in shaders.
    Float64 = "shaderFloat64",
    /// 64-bit atomics on buffers.
    Int64BufferAtomics = "shaderBufferInt64Atomics",
    /// 64-bit atomics on shared memory.
    Int64SharedAtomics = "shaderSharedInt64Atomics",
    /// `atomicAdd` of floats in buffers.
    FloatBufferAtomicAdd = "shaderBufferFloat32AtomicAdd",
    /// `imageAtomicAdd` of floats.
    FloatImageAtomicAdd = "shaderImageFloat32AtomicAdd",
    /// Stores and atomics in vertex and geometry shaders.
    VertexStores = "vertexPipelineStoresAndAtomics",
    /// Precise occlusion queries.
    OcclusionQueryPrecise = "occlusionQueryPrecise",
    /// Pipeline statistics queries.
    PipelineStatistics = "pipelineStatisticsQuery",
    /// Timestamps on the queue.
    Timestamps = "timestampValidBits",
    /// Depth clamped in place of clipped.
    DepthClamp = "depthClamp",
    /// Depth bounds test.
    DepthBounds = "depthBounds",
    /// A largest depth bias.
    DepthBiasClamp = "depthBiasClamp",
    /// `gl_ClipDistance`.
    ClipDistance = "shaderClipDistance",
    /// `gl_CullDistance`.
    CullDistance = "shaderCullDistance",
    /// Arrays of sampled images indexed by a value that is the same over a draw.
    SampledImageDynamicIndexing = "shaderSampledImageArrayDynamicIndexing",
    /// Arrays of sampled images indexed by any value.
    SampledImageNonUniformIndexing = "shaderSampledImageArrayNonUniformIndexing",
    /// Arrays of storage images indexed by a value that is the same over a draw.
    StorageImageDynamicIndexing = "shaderStorageImageArrayDynamicIndexing",
    /// Arrays of storage buffers indexed by a value that is the same over a draw.
    StorageBufferDynamicIndexing = "shaderStorageBufferArrayDynamicIndexing",
    /// Arrays of uniform buffers indexed by a value that is the same over a draw.
    UniformBufferDynamicIndexing = "shaderUniformBufferArrayDynamicIndexing",
    /// Arrays of descriptors without a length.
    RuntimeDescriptorArray = "runtimeDescriptorArray",
    /// Descriptors that are not used may be unwritten.
    PartiallyBound = "descriptorBindingPartiallyBound",
    /// Samplers that give the least or the largest of the texels.
    SamplerFilterMinmax = "samplerFilterMinmax",
    /// Anisotropic filtering.
    SamplerAnisotropy = "samplerAnisotropy",
    /// The number of draws from a buffer.
    DrawIndirectCount = "drawIndirectCount",
    /// Several indirect draws in one command.
    MultiDrawIndirect = "multiDrawIndirect",
    /// Loads from storage images declared without a format.
    StorageReadWithoutFormat = "shaderStorageImageReadWithoutFormat",
    /// Stores to storage images declared without a format.
    StorageWriteWithoutFormat = "shaderStorageImageWriteWithoutFormat",
    /// More formats for storage images (`rg16f`, `r11f_g11f_b10f`, …).
    StorageImageExtendedFormats = "shaderStorageImageExtendedFormats",
    /// Storage images with several samples.
    StorageImageMultisample = "shaderStorageImageMultisample",
    /// `textureGather` with offsets that are not constant.
    ImageGatherExtended = "shaderImageGatherExtended",
    /// A fragment shader's two outputs for one attachment.
    DualSourceBlend = "dualSrcBlend",
    /// A fragment shader that runs a sample.
    SampleRateShading = "sampleRateShading",
    /// Several viewports.
    MultiViewport = "multiViewport",
    /// Triangles drawn as lines or points.
    FillModeNonSolid = "fillModeNonSolid",
    /// Lines wider than a pixel.
    WideLines = "wideLines",
    /// Points larger than a pixel.
    LargePoints = "largePoints",
    /// Geometry shaders in multiview.
    MultiviewGeometryShader = "multiviewGeometryShader",
    /// 16-bit floats in shaders.
    Float16 = "shaderFloat16",
    /// 16-bit integers in shaders.
    Int16 = "shaderInt16",
    /// 8-bit integers in shaders.
    Int8 = "shaderInt8",
    /// 16-bit values in storage buffers.
    StorageBuffer16Bit = "storageBuffer16BitAccess",
    /// 8-bit values in storage buffers.
    StorageBuffer8Bit = "storageBuffer8BitAccess",
    /// BC texture compression.
    TextureCompressionBc = "textureCompressionBC",
    /// Chosen subgroup sizes.
    SubgroupSizeControl = "subgroupSizeControl",
    /// Ballots among the fragments of a subgroup.
    FragmentBallot = "subgroupSupportedOperations",
    /// Vulkan's memory model.
    VulkanMemoryModel = "vulkanMemoryModel",
    /// Atomics over the whole device under Vulkan's memory model.
    VulkanMemoryModelDeviceScope = "vulkanMemoryModelDeviceScope",
    /// Descriptors written by commands.
    PushDescriptors = "VK_KHR_push_descriptor",
    /// A fragment shader writes the stencil.
    StencilExport = "VK_EXT_shader_stencil_export",
    /// Fragments of a pixel one after the other, in primitive order.
    FragmentShaderInterlock = "VK_EXT_fragment_shader_interlock",
    /// A fragment shader reads the colour attachment that it writes, in primitive order.
    OrderedAttachments = "VK_EXT_rasterization_order_attachment_access",
    /// Fragments for every pixel that a triangle touches.
    ConservativeRasterization = "VK_EXT_conservative_rasterization",
    /// `gl_SampleMaskIn` after an early depth test.
    PostDepthCoverage = "VK_EXT_post_depth_coverage",
    /// Depth of clip space from -1 to 1, and clipping apart from clamping.
    DepthClipEnable = "VK_EXT_depth_clip_enable",
    /// The sizes of heaps that are left to this process.
    MemoryBudget = "VK_EXT_memory_budget",
    /// Device and host timestamps that can be compared.
    CalibratedTimestamps = "VK_EXT_calibrated_timestamps",
    /// Fans of triangles; lacking only where Vulkan is a portability subset.
    TriangleFans = "triangleFans",
    /// Two-dimensional views of a 3D image's slices; lacking only where Vulkan is a portability subset.
    ImageView2DOn3D = "imageView2DOn3DImage",
    /// Comparison samplers that are not constant; lacking only where Vulkan is a portability subset.
    MutableComparisonSamplers = "mutableComparisonSamplers",
    /// Separate front and back stencil references; lacking only where Vulkan is a portability subset.
    SeparateStencilReference = "separateStencilMaskRef",
}

impl Feature {
    /// Its name with Vulkan's, for messages.
    pub fn describe(self) -> String {
        format!("{self:?} ({})", self.vulkan_name())
    }
}

/// Limits of a device; see Vulkan's `VkPhysicalDeviceLimits` for the meaning of each.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
#[allow(missing_docs)]
pub struct Limits {
    pub max_image_dimension_2d: u32,
    pub max_image_dimension_3d: u32,
    pub max_image_array_layers: u32,
    pub max_framebuffer_layers: u32,
    pub max_multiview_views: u32,
    pub max_buffer_size: u64,
    pub max_allocation_size: u64,
    pub max_uniform_buffer_range: u32,
    pub max_storage_buffer_range: u32,
    pub max_push_constants_size: u32,
    pub max_bound_descriptor_sets: u32,
    pub max_per_stage_uniform_buffers: u32,
    pub max_per_stage_storage_buffers: u32,
    pub max_per_stage_sampled_images: u32,
    pub max_per_stage_storage_images: u32,
    pub max_per_stage_samplers: u32,
    pub max_per_stage_resources: u32,
    pub max_vertex_attributes: u32,
    pub max_geometry_output_vertices: u32,
    pub max_color_attachments: u32,
    pub max_fragment_combined_output_resources: u32,
    pub max_compute_shared_memory_size: u32,
    pub max_compute_workgroup_count: [u32; 3],
    pub max_compute_workgroup_invocations: u32,
    pub max_compute_workgroup_size: [u32; 3],
    pub max_draw_indirect_count: u32,
    pub max_clip_distances: u32,
    pub max_viewports: u32,
    pub min_uniform_buffer_offset_alignment: u64,
    pub min_storage_buffer_offset_alignment: u64,
    pub optimal_buffer_copy_offset_alignment: u64,
    pub buffer_image_granularity: u64,
    pub non_coherent_atom_size: u64,
    pub subgroup_size: u32,
    pub sub_pixel_bits: u32,
    /// Nanoseconds a tick.
    pub timestamp_period: f32,
    /// Bit `n` set: `n` samples for colour and depth attachments both.
    pub framebuffer_sample_counts: u32,
    /// Whether samples lie where Vulkan says.
    pub standard_sample_locations: bool,
}

impl Caps {
    /// Vulkan features that every device must have for the engine to run on it, by Vulkan's names: those that
    /// lavapipe, SwiftShader, MoltenVK and current desktop drivers share.
    pub fn required() -> &'static [&'static str] {
        super::features::REQUIRED_NAMES
    }
}
