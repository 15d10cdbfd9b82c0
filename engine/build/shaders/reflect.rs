//! What a shader binds, takes and gives, read from its SPIR-V.

use std::collections::BTreeMap;

use spirq::ReflectConfig;
use spirq::constant::ConstantValue;
use spirq::entry_point::EntryPoint;
use spirq::spirv::{Dim, ExecutionMode};
use spirq::ty::{AccessType, DescriptorType, ScalarType, StorageClass, StructType, Type};
use spirq::var::Variable;

use super::block::{Blocks, Content};
use super::words;
use crate::source::Stage;

/// Descriptor sets that every device has.
const SETS: u32 = 4;
/// Bytes of push constants that every device has.
const PUSH: u32 = 128;

/// A reflected shader.
pub struct Shader {
    /// Below the root.
    pub path: String,
    /// Its stage.
    pub stage: Stage,
    /// By set and binding.
    pub bindings: Vec<Binding>,
    /// Name, content and bytes of the push constants.
    pub push: Option<(String, Content, u32)>,
    /// Of vertex shaders, by location.
    pub inputs: Vec<Interface>,
    /// Of fragment shaders, by location.
    pub outputs: Vec<Interface>,
    /// Specialization constants: identifier, name, Rust type; by identifier.
    pub constants: Vec<(u32, String, &'static str)>,
    /// Zeros where it is no compute shader.
    pub workgroup: [u32; 3],
    /// Those that not every device has.
    pub capabilities: Vec<String>,
}

/// A descriptor.
pub struct Binding {
    /// Set, binding.
    pub place: (u32, u32),
    /// Of the variable, or of the block.
    pub name: String,
    /// Kind, with what its slot's type says.
    pub kind: Kind,
    /// Array length.
    pub count: u32,
    /// Bytes of a block's fixed part.
    pub size: u32,
}

/// Kind of descriptor.
pub enum Kind {
    /// `uniform` block.
    Uniform(Content),
    /// `buffer` block.
    Storage(Content, AccessType),
    /// Image and sampler in one.
    CombinedImageSampler(Image),
    /// Image to be sampled.
    SampledImage(Image),
    /// Sampler alone.
    Sampler,
    /// Image to be loaded and stored.
    StorageImage(Image, AccessType),
    /// The pass's colour attachment.
    InputAttachment(Image),
}

/// An image's type.
pub struct Image {
    /// Variant of `vk::ImageViewType`.
    pub view: &'static str,
    /// Whether it is a `…MS`.
    pub multisampled: bool,
    /// Whether it is a `…Shadow`.
    pub comparison: bool,
    /// Of storage images, as in the shader's `layout`.
    pub format: Option<String>,
}

/// A vertex input or a fragment output.
pub struct Interface {
    /// `layout(location = …)`.
    pub location: u32,
    /// As in the shader.
    pub name: String,
    /// `Float`, `Uint`, `Int`.
    pub scalar: &'static str,
    /// 1 to 4.
    pub components: u32,
}

/// Reflects one shader and takes its blocks in.
pub fn reflect(path: &str, stage: Stage, spirv: &[u32], blocks: &mut Blocks) -> Result<Shader, Vec<String>> {
    let (entry, pointees) = entry_point(spirv).map_err(|problem| vec![problem])?;
    let mut shader = Shader {
        path: path.to_owned(),
        stage,
        bindings: Vec::new(),
        push: None,
        inputs: Vec::new(),
        outputs: Vec::new(),
        constants: Vec::new(),
        workgroup: workgroup(&entry),
        capabilities: words::capabilities(spirv),
    };
    let mut problems = Vec::new();
    for variable in &entry.vars {
        problems.extend(add_variable(&mut shader, variable, blocks).err());
    }
    for block in &pointees {
        problems.extend(blocks.add(block, path).err());
    }
    shader.bindings.sort_by_key(|binding| binding.place);
    shader.inputs.sort_by_key(|input| input.location);
    shader.outputs.sort_by_key(|output| output.location);
    shader.constants.sort();
    problems.extend(shared_places(&shader.bindings));
    if problems.is_empty() { Ok(shader) } else { Err(problems) }
}

/// The entry point with its variables, and the blocks that `buffer_reference` pointers lead to.
fn entry_point(spirv: &[u32]) -> Result<(EntryPoint, Vec<StructType>), String> {
    let mut pointees = BTreeMap::new();
    let mut types_are_new = true;
    // The optimiser has removed what the shader does not use, so all variables of the module are its own.
    let entries = ReflectConfig::new()
        .spv(words::for_reflection(spirv))
        .ref_all_rscs(true)
        .reflect_inspect_by(|module, _| {
            // Called for every instruction of every function; by then all types are there.
            for (id, ty) in module.ty_reg.iter().take_while(|_| types_are_new) {
                if let Type::DevicePointer(pointer) = ty
                    && pointer.store_cls == StorageClass::PhysicalStorageBuffer
                    && let Type::Struct(block) = &*pointer.pointee_ty
                {
                    pointees.insert(*id, block.clone());
                }
            }
            types_are_new = false;
        })
        .map_err(|error| format!("cannot be reflected: {error}"))?;
    let entry = entries.into_iter().next().ok_or("has no entry point")?;
    Ok((entry, pointees.into_values().collect()))
}

fn workgroup(entry: &EntryPoint) -> [u32; 3] {
    let mut modes = entry.exec_modes.iter();
    let size = modes.rfind(|mode| matches!(mode.exec_mode, ExecutionMode::LocalSize | ExecutionMode::LocalSizeId));
    let mut workgroup = [0; 3];
    for (size, operand) in workgroup.iter_mut().zip(size.iter().flat_map(|mode| &mode.operands)) {
        if let ConstantValue::U32(value) = operand.value {
            *size = value;
        }
    }
    workgroup
}

fn add_variable(shader: &mut Shader, variable: &Variable, blocks: &mut Blocks) -> Result<(), String> {
    match variable {
        Variable::Descriptor { name, desc_bind, desc_ty, ty, nbind } => {
            let name = named(name, ty);
            let (set, binding) = (desc_bind.set(), desc_bind.bind());
            if set >= SETS {
                return Err(format!(
                    "{name} is in set {set}; there are sets 0 (the pass's), 1 (the material's), 2 and 3"
                ));
            }
            if *nbind == 0 {
                return Err(format!("{name} is an array without a length, which not every device can bind"));
            }
            if *nbind == words::SPECIALIZED {
                return Err(format!("{name} is as long as a specialization constant says: layouts need a number"));
            }
            let (kind, size) = kind(&name, desc_ty, ty, &shader.path, blocks)?;
            shader.bindings.push(Binding { place: (set, binding), name, kind, count: *nbind, size });
        }
        Variable::PushConstant { name, ty } => {
            let Type::Struct(block) = ty else { return Err("push constants that are no block".into()) };
            let name = named(name, ty);
            let (content, size) = blocks.add(block, &shader.path)?;
            if size > PUSH {
                return Err(format!("push constants {name}: {size} bytes; every device has {PUSH}"));
            }
            shader.push = Some((name, content, size));
        }
        Variable::Input { name, location, ty } if shader.stage == Stage::Vertex => {
            shader.inputs.push(interface("input", name, location.loc(), ty)?);
        }
        Variable::Output { name, location, ty } if shader.stage == Stage::Fragment => {
            shader.outputs.push(interface("output", name, location.loc(), ty)?);
        }
        // One without a name is a size of the workgroup (`local_size_x_id`).
        Variable::SpecConstant { name: Some(name), spec_id, ty } => {
            let ty = match ty {
                Type::Scalar(ScalarType::Boolean) => "bool",
                Type::Scalar(ScalarType::Float { bits: 32 }) => "f32",
                Type::Scalar(ScalarType::Integer { bits: 32, is_signed: true }) => "i32",
                Type::Scalar(ScalarType::Integer { bits: 32, is_signed: false }) => "u32",
                other => return Err(format!("constant {name}: a {other} cannot be specialized")),
            };
            shader.constants.push((*spec_id, name.clone(), ty));
        }
        Variable::Input { .. } | Variable::Output { .. } | Variable::SpecConstant { .. } => {}
    }
    Ok(())
}

/// A variable's name; that of its block where it has none.
fn named(name: &Option<String>, ty: &Type) -> String {
    let of_block = || match ty {
        Type::Struct(block) => block.name.clone(),
        _ => None,
    };
    name.clone().or_else(of_block).unwrap_or_else(|| "unnamed".into())
}

fn kind(
    name: &str,
    descriptor: &DescriptorType,
    ty: &Type,
    path: &str,
    blocks: &mut Blocks,
) -> Result<(Kind, u32), String> {
    let kind = match (descriptor, ty) {
        (DescriptorType::UniformBuffer(), Type::Struct(block)) => {
            let (content, size) = blocks.add(block, path)?;
            return Ok((Kind::Uniform(content), size));
        }
        (DescriptorType::StorageBuffer(access), Type::Struct(block)) => {
            let (content, size) = blocks.add(block, path)?;
            return Ok((Kind::Storage(content, *access), size));
        }
        (DescriptorType::CombinedImageSampler(), Type::CombinedImageSampler(ty)) => {
            let image = &ty.sampled_image_ty;
            let view = view(name, image.dim, image.is_array)?;
            let comparison = image.is_depth == Some(true);
            Kind::CombinedImageSampler(Image { view, multisampled: image.is_multisampled, comparison, format: None })
        }
        (DescriptorType::SampledImage(), Type::SampledImage(image)) => {
            let view = view(name, image.dim, image.is_array)?;
            let comparison = image.is_depth == Some(true);
            Kind::SampledImage(Image { view, multisampled: image.is_multisampled, comparison, format: None })
        }
        (DescriptorType::StorageImage(access), Type::StorageImage(image)) => {
            let view = view(name, image.dim, image.is_array)?;
            let format = super::name::format(&format!("{:?}", image.fmt));
            let image = Image { view, multisampled: image.is_multisampled, comparison: false, format };
            Kind::StorageImage(image, *access)
        }
        // A pass has one such attachment, at location 0.
        (DescriptorType::InputAttachment(0), Type::SubpassData(image)) => {
            let multisampled = image.is_multisampled;
            Kind::InputAttachment(Image { view: "TYPE_2D", multisampled, comparison: false, format: None })
        }
        (DescriptorType::Sampler(), _) => Kind::Sampler,
        (other, _) => return Err(format!("{name}: descriptors of the kind {other:?} are not supported")),
    };
    Ok((kind, 0))
}

fn view(name: &str, dimension: Dim, is_array: bool) -> Result<&'static str, String> {
    Ok(match (dimension, is_array) {
        (Dim::Dim1D, false) => "TYPE_1D",
        (Dim::Dim1D, true) => "TYPE_1D_ARRAY",
        (Dim::Dim2D, false) => "TYPE_2D",
        (Dim::Dim2D, true) => "TYPE_2D_ARRAY",
        (Dim::Dim3D, false) => "TYPE_3D",
        (Dim::DimCube, false) => "CUBE",
        (Dim::DimCube, true) => "CUBE_ARRAY",
        _ => return Err(format!("{name}: no image view is a {dimension:?}")),
    })
}

fn interface(what: &str, name: &Option<String>, location: u32, ty: &Type) -> Result<Interface, String> {
    let name = name.clone().unwrap_or_else(|| format!("{what}_{location}"));
    let (scalar, components) = match ty {
        Type::Scalar(scalar) => (scalar, 1),
        Type::Vector(vector) => (&vector.scalar_ty, vector.nscalar),
        other => return Err(format!("{what} {name}: a {other}; one location holds a scalar or a vector: split it")),
    };
    let scalar = match scalar {
        ScalarType::Float { .. } => "Float",
        ScalarType::Integer { is_signed: false, .. } => "Uint",
        ScalarType::Integer { is_signed: true, .. } => "Int",
        other => return Err(format!("{what} {name}: a {other} is not supported")),
    };
    Ok(Interface { location, name, scalar, components })
}

fn shared_places(bindings: &[Binding]) -> Vec<String> {
    let mut first: BTreeMap<(u32, u32), &str> = BTreeMap::new();
    let mut problems = Vec::new();
    for binding in bindings {
        let (set, number) = binding.place;
        if let Some(other) = first.insert(binding.place, &binding.name) {
            problems.push(format!("{other} and {} are both binding {number} of set {set}", binding.name));
        }
    }
    problems
}
