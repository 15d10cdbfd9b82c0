//! A scene on the device: shared geometry, one record an instance, textures, and the draws over them.

use std::collections::HashMap;
use std::ops::Deref;

use ash::vk;
use glam::{Mat3, Mat4, Vec3};

use super::draw::{Draw, DrawClass, DrawList};
use super::textures::{Encoding, TextureImages, depth_texel, sampler, texel, words_texel};
use super::{AlphaMode, Material, Mesh, Primitive, Scene, TextureSlot};
use crate::Result;
use crate::geometry::Aabb;
use crate::gpu::{Buffer, BufferInfo, Descriptor, DescriptorSet, Gpu, Image, Memory, SamplerInfo, SetLayout, Uploader};
use crate::shader::generated::{blocks, surface, transparency};

/// A scene in device memory. Dereferences to the scene itself.
pub struct GpuScene {
    scene: Scene,
    /// Object-space positions, three floats a vertex.
    pub positions: Buffer,
    /// What alpha needs: both texture coordinates and the colour, eight floats a vertex.
    pub alpha_attributes: Buffer,
    /// What shading needs besides: normal and tangent, seven floats a vertex.
    pub shading_attributes: Buffer,
    /// 32-bit indices, relative to a primitive's first vertex.
    pub indices: Buffer,
    /// `blocks::Instance` an instance.
    pub instances: Buffer,
    /// Set 1 of each material.
    pub material_sets: Vec<DescriptorSet>,
    /// Layout of set 1.
    pub material_layout: SetLayout,
    /// One white texel with one layer, to stand in for what is not there.
    pub white: Image,
    /// One texel of depth 0 (nothing), likewise.
    pub no_depth: Image,
    /// One texel of four 32-bit words 0, likewise.
    pub no_words: Image,
    /// All draws.
    pub draws: DrawList,
    /// World-space bounds; a point at the origin where there is nothing.
    pub bounds: Aabb,
}

impl Deref for GpuScene {
    type Target = Scene;

    fn deref(&self) -> &Scene {
        &self.scene
    }
}

/// Attributes that an alpha test reads.
#[repr(C)]
#[derive(Clone, Copy, bytemuck::Pod, bytemuck::Zeroable)]
pub struct AlphaVertex {
    uvs: [[f32; 2]; 2],
    color: [f32; 4],
}

/// Attributes that shading reads besides.
#[repr(C)]
#[derive(Clone, Copy, bytemuck::Pod, bytemuck::Zeroable)]
pub struct ShadingVertex {
    normal: [f32; 3],
    tangent: [f32; 4],
}

impl Scene {
    /// Copies a scene to the device.
    ///
    /// # Errors
    /// [`crate::Error::OutOfMemory`] naming the buffer or the texture; [`crate::Error::Vulkan`].
    pub fn upload(self, gpu: &Gpu) -> Result<GpuScene> {
        let mut uploader = gpu.uploader(&format!("scene {}", self.name));

        // 1. Geometry, one after the other in shared buffers.
        let geometry = Geometry::gather(&self);
        let vertex = vk::BufferUsageFlags::VERTEX_BUFFER;
        let positions = buffer(gpu, &mut uploader, "scene.positions", vertex, &geometry.positions)?;
        let alpha_attributes = buffer(gpu, &mut uploader, "scene.alpha_attributes", vertex, &geometry.alpha)?;
        let shading_attributes = buffer(gpu, &mut uploader, "scene.shading_attributes", vertex, &geometry.shading)?;
        let indices =
            buffer(gpu, &mut uploader, "scene.indices", vk::BufferUsageFlags::INDEX_BUFFER, &geometry.indices)?;

        // 2. Instances in the order of the draws.
        let (draws, instances) = draws_and_instances(&self, &geometry);
        let instances = buffer(gpu, &mut uploader, "scene.instances", vertex, &instances)?;

        // 3. Materials and their textures.
        let stride = (size_of::<blocks::Material>() as u64)
            .next_multiple_of(gpu.caps().limits.min_uniform_buffer_offset_alignment.max(1));
        let materials = material_buffer(gpu, &mut uploader, &self.materials, stride)?;
        let white = texel(gpu, &mut uploader, "scene.white", [255; 4])?;
        let flat = texel(gpu, &mut uploader, "scene.flat_normal", [128, 128, 255, 255])?;
        let no_depth = depth_texel(gpu, &mut uploader)?;
        let no_words = words_texel(gpu, &mut uploader)?;
        let readers = [
            &surface::gbuffer::gbuffer_frag::SHADER,
            &surface::depth::masked_frag::SHADER,
            &transparency::sorted::sorted_frag::SHADER,
        ];
        let material_layout = gpu.set_layout(1, &readers)?;
        let used = self.materials.iter().flat_map(slots).filter_map(|(slot, encoding)| Some((slot?.texture, encoding)));
        let images = TextureImages::upload(gpu, &mut uploader, &self, used)?;
        let plain = gpu.sampler(&SamplerInfo::default())?;
        let mut material_sets = Vec::with_capacity(self.materials.len());
        for (index, material) in self.materials.iter().enumerate() {
            let mut descriptors = Vec::with_capacity(TEXTURES.len() + 1);
            for (binding, (slot, encoding)) in TEXTURES.into_iter().zip(slots(material)) {
                let image = slot.and_then(|slot| Some((slot.texture, images.get(slot.texture, encoding)?)));
                let descriptor = match image {
                    Some((index, image)) => Descriptor::texture(image, sampler(gpu, &self.textures[index])?),
                    None if encoding == Encoding::Normal => Descriptor::texture(&flat, plain),
                    None => Descriptor::texture(&white, plain),
                };
                descriptors.push((binding, descriptor));
            }
            let (offset, size) = (index as u64 * stride, size_of::<blocks::Material>() as u64);
            descriptors.push((FACTORS, Descriptor::Buffer { buffer: materials.clone(), offset, size }));
            material_sets.push(gpu.descriptor_set_of(&material.name, &material_layout, &descriptors)?);
        }

        gpu.wait(uploader.submit()?)?;
        let bounds = draws.bounds().unwrap_or(Aabb { min: Vec3::ZERO, max: Vec3::ZERO });
        Ok(GpuScene {
            scene: self,
            positions,
            alpha_attributes,
            shading_attributes,
            indices,
            instances,
            material_sets,
            material_layout,
            white,
            no_depth,
            no_words,
            draws,
            bounds,
        })
    }
}

/// All primitives' vertices and indices, and where each begins.
#[derive(Default)]
struct Geometry {
    positions: Vec<[f32; 3]>,
    alpha: Vec<AlphaVertex>,
    shading: Vec<ShadingVertex>,
    indices: Vec<u32>,
    /// By mesh and primitive: first vertex, first index.
    starts: Vec<Vec<(i32, u32)>>,
}

impl Geometry {
    fn gather(scene: &Scene) -> Self {
        let mut all = Self::default();
        for mesh in &scene.meshes {
            let starts = mesh.primitives.iter().map(|primitive| all.push(primitive)).collect();
            all.starts.push(starts);
        }
        all
    }

    fn push(&mut self, primitive: &Primitive) -> (i32, u32) {
        let start = (self.positions.len() as i32, self.indices.len() as u32);
        self.positions.extend(primitive.positions.iter().map(|p| p.to_array()));
        for i in 0..primitive.positions.len() {
            let uvs = [primitive.uvs[0][i].to_array(), primitive.uvs[1][i].to_array()];
            self.alpha.push(AlphaVertex { uvs, color: primitive.colors[i].to_array() });
            let (normal, tangent) = (primitive.normals[i].to_array(), primitive.tangents[i].to_array());
            self.shading.push(ShadingVertex { normal, tangent });
        }
        self.indices.extend_from_slice(&primitive.indices);
        start
    }
}

/// Instances of equal state and geometry stand side by side, so that one draw covers them.
fn draws_and_instances(scene: &Scene, geometry: &Geometry) -> (DrawList, Vec<blocks::Instance>) {
    struct Item {
        key: (DrawClass, bool, bool, usize, usize, usize),
        object: usize,
    }
    let mut items = Vec::new();
    for (index, object) in scene.objects.iter().enumerate() {
        let mirrored = Mat3::from_mat4(object.world_from_object).determinant() < 0.0;
        for (part, primitive) in scene.meshes[object.mesh].primitives.iter().enumerate() {
            if primitive.indices.is_empty() {
                continue;
            }
            let material = &scene.materials[primitive.material];
            let class = DrawClass::of(material);
            let key = (class, material.double_sided, mirrored, primitive.material, object.mesh, part);
            items.push(Item { key, object: index });
        }
    }
    // By mesh and primitive: its box, and the triangles before it.
    let parts: Vec<Vec<(Option<Aabb>, usize)>> = scene.meshes.iter().map(boxes_and_starts).collect();
    let first_blended = first_blended(scene);
    items.sort_by_key(|item| (item.key, item.object));

    let mut draws: Vec<Draw> = Vec::new();
    let mut instances = Vec::with_capacity(items.len());
    let mut instance_bounds = Vec::with_capacity(items.len());
    let mut last_key = None;
    for item in &items {
        let (class, double_sided, mirrored, material, mesh, part) = item.key;
        let object = &scene.objects[item.object];
        let primitives = &scene.meshes[mesh].primitives;
        let (Some(bounds), before) = parts[mesh][part] else { continue };
        let bounds = bounds.transformed(object.world_from_object);
        let start = geometry.starts[mesh][part];
        instance_bounds.push(bounds);
        let mut record = instance_record(&object.world_from_object, item.object, material, before, start);
        record.first_blended = first_blended.get(&(item.object, part)).copied().unwrap_or(0);
        instances.push(record);
        // Blended instances are sorted one by one, so each is a draw of its own.
        if last_key == Some(item.key) && class != DrawClass::Blend {
            let draw = draws.last_mut().expect("a key came with a draw");
            draw.instances.end += 1;
            draw.bounds = draw.bounds.union(bounds);
        } else {
            let (vertex_offset, first_index) = start;
            let index_count = primitives[part].indices.len() as u32;
            let at = instances.len() as u32 - 1;
            draws.push(Draw {
                class,
                double_sided,
                mirrored,
                material,
                textures: textures_of(&scene.materials[material]),
                indices: first_index..first_index + index_count,
                vertex_offset,
                instances: at..at + 1,
                bounds,
            });
        }
        last_key = Some(item.key);
    }
    (DrawList::new(draws, instance_bounds), instances)
}

fn boxes_and_starts(mesh: &Mesh) -> Vec<(Option<Aabb>, usize)> {
    let mut before = 0;
    let part = |primitive: &Primitive| {
        let start = before;
        before += primitive.indices.len() / 3;
        (Aabb::around(primitive.positions.iter().copied()), start)
    };
    mesh.primitives.iter().map(part).collect()
}

/// By object and primitive: how many blended triangles the scene has before. The order of draws has no say in it.
fn first_blended(scene: &Scene) -> HashMap<(usize, usize), u32> {
    let mut before = 0;
    let mut first = HashMap::new();
    for (index, object) in scene.objects.iter().enumerate() {
        for (part, primitive) in scene.meshes[object.mesh].primitives.iter().enumerate() {
            if scene.materials[primitive.material].is_blended() {
                first.insert((index, part), before);
                before += primitive.indices.len() as u32 / 3;
            }
        }
    }
    first
}

fn instance_record(
    world_from_object: &Mat4,
    object: usize,
    material: usize,
    first_primitive: usize,
    (vertex_offset, first_index): (i32, u32),
) -> blocks::Instance {
    let rows = world_from_object.transpose();
    let linear = Mat3::from_mat4(*world_from_object);
    let sign = if linear.determinant() < 0.0 { -1.0 } else { 1.0 };
    // The cofactor matrix turns normals as the inverse transpose does, and exists for singular transforms too.
    let (x, y, z) = (linear.x_axis, linear.y_axis, linear.z_axis);
    let cofactor = Mat3::from_cols(y.cross(z), z.cross(x), x.cross(y)) * sign;
    let normal_rows = cofactor.transpose();
    blocks::Instance {
        world_from_object: [rows.x_axis.to_array(), rows.y_axis.to_array(), rows.z_axis.to_array()],
        normal_from_object: [normal_rows.x_axis, normal_rows.y_axis, normal_rows.z_axis].map(Into::into),
        handedness: sign,
        object: object as u32 + 1,
        material: material as u32,
        first_primitive: first_primitive as u32,
        first_blended: 0,
        first_index,
        vertex_offset,
    }
}

/// Bindings of set 1: the textures in the order of [`slots`], and the factors.
const TEXTURES: [u32; 6] = [0, 1, 2, 3, 4, 6];
const FACTORS: u32 = 5;

/// A material's textures.
fn slots(material: &Material) -> [(Option<TextureSlot>, Encoding); 6] {
    [
        (material.base_color_texture, Encoding::Srgb),
        (material.metallic_roughness_texture, Encoding::Linear),
        (material.normal_texture, Encoding::Normal),
        (material.occlusion_texture, Encoding::Linear),
        (material.emissive_texture, Encoding::Srgb),
        (material.transmission_texture, Encoding::Linear),
    ]
}

/// Which textures a material has, as bits in the order of [`slots`].
fn textures_of(material: &Material) -> u32 {
    slots(material).iter().enumerate().map(|(i, (slot, _))| u32::from(slot.is_some()) << i).sum()
}

fn material_record(material: &Material) -> blocks::Material {
    let alpha = match material.alpha_mode {
        AlphaMode::Premultiplied => 1 << 17,
        AlphaMode::Add => 1 << 18,
        AlphaMode::Opaque => 1 << 19,
        AlphaMode::Mask { .. } | AlphaMode::Blend => 0,
    };
    let mut flags = u32::from(material.unlit) << 16 | alpha;
    let mut rows = [Vec3::ZERO; 12];
    for (i, (slot, _)) in slots(material).into_iter().enumerate() {
        let Some(slot) = slot else { continue };
        flags |= u32::from(slot.uv_set == 1) << (i + 8);
        let transform = slot.transform.transpose();
        (rows[2 * i], rows[2 * i + 1]) = (transform.x_axis, transform.y_axis);
    }
    blocks::Material {
        base_color: material.base_color.to_array(),
        emissive: material.emissive,
        metallic: material.metallic,
        roughness: material.roughness,
        normal_scale: material.normal_scale,
        occlusion_strength: material.occlusion_strength,
        alpha_cutoff: match material.alpha_mode {
            AlphaMode::Mask { cutoff } => cutoff,
            AlphaMode::Opaque | AlphaMode::Blend | AlphaMode::Premultiplied | AlphaMode::Add => 0.0,
        },
        uv_rows: rows.map(Into::into),
        flags,
        transmission: if material.is_blended() { material.transmission } else { 0.0 },
    }
}

/// The materials' uniform blocks, `stride` bytes apart.
fn material_buffer(gpu: &Gpu, uploader: &mut Uploader, materials: &[Material], stride: u64) -> Result<Buffer> {
    let mut bytes = vec![0; materials.len() * stride as usize];
    for (place, material) in bytes.chunks_exact_mut(stride as usize).zip(materials) {
        let record = material_record(material);
        place[..size_of_val(&record)].copy_from_slice(bytemuck::bytes_of(&record));
    }
    buffer(gpu, uploader, "scene.materials", vk::BufferUsageFlags::UNIFORM_BUFFER, &bytes)
}

/// A device buffer with these contents; at least one element long, for Vulkan has no empty buffers.
fn buffer<T: bytemuck::Pod>(
    gpu: &Gpu,
    uploader: &mut Uploader,
    name: &str,
    usage: vk::BufferUsageFlags,
    contents: &[T],
) -> Result<Buffer> {
    let bytes: &[u8] = bytemuck::cast_slice(contents);
    let usage = usage | vk::BufferUsageFlags::STORAGE_BUFFER | vk::BufferUsageFlags::TRANSFER_DST;
    let size = (bytes.len() as u64).max(size_of::<T>() as u64);
    let buffer = gpu.create_buffer(&BufferInfo { name, size, usage, memory: Memory::Device })?;
    if !bytes.is_empty() {
        uploader.buffer(&buffer, 0, bytes)?;
    }
    Ok(buffer)
}
