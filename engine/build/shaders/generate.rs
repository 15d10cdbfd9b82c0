//! The Rust that names every shader: modules, slots, blocks.

use std::collections::{BTreeMap, BTreeSet};
use std::fmt::Write;

use spirq::ty::AccessType;

use super::block::{Block, Blocks, Content};
use super::name;
use super::reflect::{Binding, Image, Interface, Kind, Shader};
use crate::prebuilt::SPIRV;
use crate::source::{ROOT, Stage};

/// Where the code finds itself.
const GENERATED: &str = "crate::shader::generated::";
const BLOCKS: &str = "crate::shader::generated::blocks::";

/// A folder's module.
#[derive(Default)]
struct Module<'a> {
    folders: BTreeMap<String, Module<'a>>,
    shaders: BTreeMap<String, &'a Shader>,
}

/// The whole of `shaders.rs`.
pub fn generate(shaders: &[Shader], blocks: &Blocks) -> Result<String, Vec<String>> {
    let mut problems = Vec::new();
    let mut root = Module::default();
    let mut all = Vec::new();
    for shader in shaders {
        match place(&mut root, shader) {
            Ok(path) => all.push(path),
            Err(problem) => problems.push(problem),
        }
        problems.extend(check_names(shader));
    }
    if !problems.is_empty() {
        return Err(problems);
    }
    let mut code = String::from("// Made by the build script from the GLSL: do not edit.\n\n");
    code.push_str("/// Every shader, by path.\npub static ALL: &[&crate::shader::Shader] = &[\n");
    for path in &all {
        let _ = writeln!(code, "    &{GENERATED}{path}::SHADER,");
    }
    code.push_str("];\n\n");
    write_blocks(&mut code, blocks);
    write_module(&mut code, &root);
    Ok(code)
}

/// Puts a shader in its module; gives the module's path.
fn place<'a>(root: &mut Module<'a>, shader: &'a Shader) -> Result<String, String> {
    let mut parts: Vec<String> = shader.path.split('/').map(name::module).collect();
    let path = parts.join("::");
    let taken =
        |what: &str| format!("{ROOT}/{}: its module's name, {path}, is also that of {what}; rename it", shader.path);
    if parts.first().is_some_and(|first| first == "blocks") {
        return Err(taken("the module of all blocks"));
    }
    let file = parts.pop().unwrap_or_default();
    let mut module = root;
    for folder in parts {
        if let Some(other) = module.shaders.get(&folder) {
            return Err(taken(&other.path));
        }
        module = module.folders.entry(folder).or_default();
    }
    if module.folders.contains_key(&file) {
        return Err(taken("a folder"));
    }
    match module.shaders.insert(file, shader) {
        Some(other) => Err(taken(&other.path)),
        None => Ok(path),
    }
}

/// Slots of a shader must have different names.
fn check_names(shader: &Shader) -> Vec<String> {
    let bindings = shader.bindings.iter().map(|binding| &binding.name);
    let outputs = shader.outputs.iter().map(|output| &output.name);
    let constants = shader.constants.iter().map(|(_, name, _)| name);
    let mut taken = BTreeSet::from(["SHADER".into(), "BINDINGS".into(), "OUTPUTS".into()]);
    let doubles = bindings.chain(outputs).chain(constants).filter(|slot| !taken.insert(name::constant(slot)));
    doubles
        .map(|slot| {
            format!("{ROOT}/{}: {slot}: another slot is called {}; rename it", shader.path, name::constant(slot))
        })
        .collect()
}

fn write_blocks(code: &mut String, blocks: &Blocks) {
    code.push_str("/// Blocks and structs of all shaders, with the shaders' own offsets.\npub mod blocks {\n");
    for (name, block) in &blocks.by_name {
        write_block(code, name, block);
    }
    code.push_str("}\n\n");
}

fn write_block(code: &mut String, block_name: &str, block: &Block) {
    let name = name::identifier(block_name);
    let mut fields = String::new();
    let mut asserts = format!("assert!(::core::mem::size_of::<{name}>() == {});", block.size);
    let mut end = 0;
    for field in &block.fields {
        let field_name = name::identifier(&field.name);
        write_padding(&mut fields, end, field.offset);
        let _ = writeln!(fields, "        /// `{}` at byte {}.", field.ty.glsl(), field.offset);
        let _ = writeln!(fields, "        pub {field_name}: {},", field.ty.rust(""));
        let _ = write!(asserts, " assert!(::core::mem::offset_of!({name}, {field_name}) == {});", field.offset);
        end = field.offset + field.ty.size();
    }
    write_padding(&mut fields, end, block.size);
    let _ = write!(
        code,
        "    /// `{block_name}`, {} bytes, as `{}` has it.
    #[repr(C)]
    #[derive(Clone, Copy, Debug, PartialEq, ::bytemuck::Pod, ::bytemuck::Zeroable)]
    pub struct {name} {{
{fields}    }}
    impl ::core::default::Default for {name} {{
        fn default() -> Self {{
            ::bytemuck::Zeroable::zeroed()
        }}
    }}
    const _: () = {{ {asserts} }};

",
        block.size, block.file
    );
}

/// Bytes between members are members: `Pod` allows no others.
fn write_padding(fields: &mut String, from: u32, to: u32) {
    if to > from {
        let _ = writeln!(fields, "        /// Padding.\n        pub _padding_{from}: [u8; {}],", to - from);
    }
}

fn write_module(code: &mut String, module: &Module) {
    for (name, folder) in &module.folders {
        let _ = writeln!(code, "pub mod {name} {{");
        write_module(code, folder);
        code.push_str("}\n");
    }
    for (name, shader) in &module.shaders {
        let _ = writeln!(code, "/// `{ROOT}/{}`.\npub mod {name} {{", shader.path);
        write_shader(code, shader);
        code.push_str("}\n");
    }
}

fn write_shader(code: &mut String, shader: &Shader) {
    let (spirv, path) = (format!("/{SPIRV}/{}.spv", shader.path), &shader.path);
    let stage = match shader.stage {
        Stage::Vertex => "Vertex",
        Stage::Geometry => "Geometry",
        Stage::Fragment => "Fragment",
        Stage::Compute => "Compute",
    };
    let push = shader.push.as_ref().map_or("None".into(), |(name, _, size)| {
        format!("Some(crate::shader::Push {{ name: {name:?}, size: {size} }})")
    });
    let _ = write!(
        code,
        "    /// The shader.
    pub static SHADER: crate::shader::Shader = crate::shader::Shader {{
        file: {path:?},
        stage: crate::shader::Stage::{stage},
        spirv: include_bytes!(concat!(env!(\"OUT_DIR\"), {spirv:?})),
        bindings: &BINDINGS,
        push: {push},
        inputs: &[{inputs}],
        outputs: &OUTPUTS,
        workgroup: {workgroup:?},
        capabilities: &{capabilities:?},
    }};
    const BINDINGS: [crate::shader::Binding; {binding_count}] = [{bindings}];
    const OUTPUTS: [crate::shader::Output; {output_count}] = [{outputs}];
",
        inputs = shader.inputs.iter().map(|input| interface("Input", input)).collect::<String>(),
        workgroup = shader.workgroup,
        capabilities = shader.capabilities,
        binding_count = shader.bindings.len(),
        bindings = shader.bindings.iter().map(binding).collect::<String>(),
        output_count = shader.outputs.len(),
        outputs = shader.outputs.iter().map(|output| interface("Output", output)).collect::<String>(),
    );
    for (index, binding) in shader.bindings.iter().enumerate() {
        let ((set, number), name) = (binding.place, name::constant(&binding.name));
        let ty = slot(&binding.kind);
        let _ = writeln!(code, "    /// `{}`: set {set}, binding {number}.", binding.name);
        let _ = writeln!(
            code,
            "    pub const {name}: crate::shader::{ty} = crate::shader::{}::new(BINDINGS[{index}], &SHADER);",
            ty.replacen('<', "::<", 1)
        );
    }
    for (index, output) in shader.outputs.iter().enumerate() {
        let _ = writeln!(code, "    /// `{}`: location {}.", output.name, output.location);
        let _ = writeln!(
            code,
            "    pub const {}: crate::shader::ColorSlot = crate::shader::ColorSlot::new(OUTPUTS[{index}], &SHADER);",
            name::constant(&output.name)
        );
    }
    for (id, name, ty) in &shader.constants {
        let _ = writeln!(code, "    /// `{name}`: specialization constant {id}.");
        let _ = writeln!(
            code,
            "    pub const {}: crate::shader::ConstantSlot<{ty}> = crate::shader::ConstantSlot::<{ty}>::new({id}, &SHADER);",
            name::constant(name)
        );
    }
    if let Some((_, content, _)) = &shader.push {
        let _ = writeln!(code, "    /// Push constants.\n    pub type Push = {};", content_type(content));
    }
}

fn binding(binding: &Binding) -> String {
    let (kind, access, image) = match &binding.kind {
        Kind::Uniform(_) => ("UniformBuffer", "Read", None),
        Kind::Storage(_, access) => ("StorageBuffer", access_name(*access), None),
        Kind::CombinedImageSampler(image) => ("CombinedImageSampler", "Read", Some(image)),
        Kind::SampledImage(image) => ("SampledImage", "Read", Some(image)),
        Kind::Sampler => ("Sampler", "Read", None),
        Kind::StorageImage(image, access) => ("StorageImage", access_name(*access), Some(image)),
        Kind::InputAttachment(image) => ("InputAttachment", "Read", Some(image)),
    };
    let (set, number) = binding.place;
    format!(
        "crate::shader::Binding {{ set: {set}, binding: {number}, name: {:?}, kind: crate::shader::BindingKind::{kind}, \
         access: crate::shader::ShaderAccess::{access}, count: {}, size: {}, image: {} }}, ",
        binding.name,
        binding.count,
        binding.size,
        image.map_or("None".into(), image_type),
    )
}

fn image_type(image: &Image) -> String {
    format!(
        "Some(crate::shader::ImageType {{ view: ::ash::vk::ImageViewType::{}, multisampled: {}, comparison: {}, \
         format: ::ash::vk::Format::{} }})",
        image.view,
        image.multisampled,
        image.comparison,
        image.format.as_deref().unwrap_or("UNDEFINED"),
    )
}

fn interface(ty: &str, interface: &Interface) -> String {
    format!(
        "crate::shader::{ty} {{ location: {}, name: {:?}, scalar: crate::shader::OutputScalar::{}, components: {} }}, ",
        interface.location, interface.name, interface.scalar, interface.components
    )
}

/// A slot's type, below `crate::shader::`.
fn slot(kind: &Kind) -> String {
    let access = |access: &AccessType| format!("crate::shader::{}", access_name(*access));
    match kind {
        Kind::Uniform(content) => format!("UniformSlot<{}>", content_type(content)),
        Kind::Storage(content, by) => format!("StorageSlot<{}, {}>", content_type(content), access(by)),
        Kind::CombinedImageSampler(_) | Kind::SampledImage(_) => "SampledSlot".into(),
        Kind::Sampler => "SamplerSlot".into(),
        Kind::InputAttachment(_) => "InputSlot".into(),
        Kind::StorageImage(_, by) => format!("ImageSlot<{}>", access(by)),
    }
}

fn content_type(content: &Content) -> String {
    match content {
        Content::One(ty) => ty.rust(BLOCKS),
        Content::Tail { head, element } => {
            format!("crate::shader::WithTail<{}, {}>", head.rust(BLOCKS), element.rust(BLOCKS))
        }
    }
}

fn access_name(access: AccessType) -> &'static str {
    match access {
        AccessType::ReadOnly => "Read",
        AccessType::WriteOnly => "Write",
        AccessType::ReadWrite => "ReadWrite",
    }
}
