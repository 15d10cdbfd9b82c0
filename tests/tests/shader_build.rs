//! The engine's build script: compilation, reflection, layouts, errors, cache.
#![allow(clippy::unwrap_used, dead_code)]

#[path = "../../engine/build/files.rs"]
mod files;
#[path = "../../engine/build/prebuilt.rs"]
mod prebuilt;
#[path = "../../engine/build/shaders/mod.rs"]
mod shaders;
#[path = "../../engine/build/source.rs"]
mod source;

/// What the build script makes of `data/shaders/every_type.comp`: compiled here, with its assertions.
mod blocks {
    include!("../data/shaders/blocks.rs");
}

use std::fs;
use std::path::{Path, PathBuf};
use std::time::SystemTime;

use proptest::prelude::*;
use shaders::block::{Blocks, Content, Type};
use shaders::reflect::{Kind, Shader};
use source::Stage;
use spirq::ty::AccessType;
use tempfile::TempDir;

/// A folder of GLSL and a folder of output.
struct Project {
    folder: TempDir,
}

impl Project {
    fn new(files: &[(&str, &str)]) -> Self {
        let project = Self { folder: TempDir::new().unwrap() };
        fs::create_dir_all(project.sources()).unwrap();
        for (path, text) in files {
            project.write(path, text);
        }
        project
    }

    fn sources(&self) -> PathBuf {
        self.folder.path().join("shaders_glsl")
    }

    fn out(&self) -> PathBuf {
        self.folder.path().join("out")
    }

    fn write(&self, path: &str, text: &str) {
        let path = self.sources().join(path);
        fs::create_dir_all(path.parent().unwrap()).unwrap();
        fs::write(path, text).unwrap();
    }

    fn build(&self) -> Result<shaders::Report, Vec<String>> {
        shaders::build(&self.sources(), &self.out())
    }

    /// Shaders that a build compiled.
    fn compiled(&self) -> Vec<String> {
        self.build().unwrap().compiled
    }

    fn problems(&self) -> Vec<String> {
        self.build().unwrap_err()
    }

    fn code(&self) -> String {
        fs::read_to_string(self.out().join("shaders.rs")).unwrap()
    }

    fn spirv(&self, shader: &str) -> Vec<u32> {
        let bytes = fs::read(self.out().join(format!("spv/{shader}.spv"))).unwrap();
        bytes.chunks_exact(4).map(|word| u32::from_le_bytes(word.try_into().unwrap())).collect()
    }
}

const HEAD: &str = "#version 460\n#extension GL_EXT_scalar_block_layout : require\n";

/// A compute shader; `declarations` begin in line 4.
fn compute(declarations: &str, body: &str) -> String {
    format!("{HEAD}layout(local_size_x = 8) in;\n{declarations}\nvoid main() {{\n{body}\n}}\n")
}

fn fragment(declarations: &str, body: &str) -> String {
    format!("{HEAD}layout(location = 0) out vec4 color;\n{declarations}\nvoid main() {{\n{body}\n}}\n")
}

/// Compiles and reflects one shader.
fn reflect(path: &str, stage: Stage, text: &str) -> (Shader, Blocks) {
    let project = Project::new(&[(path, text)]);
    project.build().unwrap_or_else(|problems| panic!("{}", problems.join("\n")));
    let mut blocks = Blocks::default();
    let shader = shaders::reflect::reflect(path, stage, &project.spirv(path), &mut blocks).unwrap();
    (shader, blocks)
}

fn every_type() -> String {
    fs::read_to_string(Path::new(env!("CARGO_MANIFEST_DIR")).join("data/shaders/every_type.comp")).unwrap()
}

// ---- Layouts

/// Offsets of scalar layout, by hand: each member follows the last at the alignment of its scalars.
#[test]
fn layouts_have_the_offsets_of_scalar_layout() {
    let (_, blocks) = reflect("every_type.comp", Stage::Compute, &every_type());
    let expected = [
        ("f", 0, "float"),
        ("v2", 4, "vec2"),
        ("v3", 12, "vec3"),
        ("v4", 24, "vec4"),
        ("i", 40, "int"),
        ("i2", 44, "ivec2"),
        ("i3", 52, "ivec3"),
        ("i4", 64, "ivec4"),
        ("u", 80, "uint"),
        ("u2", 84, "uvec2"),
        ("u3", 92, "uvec3"),
        ("u4", 104, "uvec4"),
        ("b", 120, "uint"),
        ("m2", 124, "mat2"),
        ("m3", 140, "mat3"),
        ("m4", 176, "mat4"),
        ("m34", 240, "mat3x4"),
        ("m43", 288, "mat4x3"),
        ("floats", 336, "float[5]"),
        ("grid", 356, "vec3[2][3]"),
        ("light", 428, "Light"),
        ("lights", 468, "Light[2]"),
        ("byte", 548, "int8_t"),
        ("d", 552, "double"),
        ("half_float", 560, "float16_t"),
        ("u16", 562, "uint16_t"),
        ("i64", 568, "int64_t"),
        ("type", 576, "uint64_t"),
        ("d3", 584, "dvec3"),
        ("link", 608, "device address"),
        ("last", 616, "uint"),
    ];
    let everything = &blocks.by_name["Everything"];
    let found: Vec<_> = everything.fields.iter().map(|f| (f.name.as_str(), f.offset, f.ty.glsl())).collect();
    let expected: Vec<_> = expected.iter().map(|(name, offset, ty)| (*name, *offset, (*ty).to_owned())).collect();
    assert_eq!(found, expected);
    // 620, and what the alignment of 8 adds.
    assert_eq!(everything.size, 624);

    let light: Vec<_> = blocks.by_name["Light"].fields.iter().map(|f| (f.name.as_str(), f.offset)).collect();
    assert_eq!(light, [("position", 0), ("range", 12), ("basis", 16)]);
    assert_eq!(blocks.by_name["Light"].size, 40);
    let link: Vec<_> = blocks.by_name["Link"].fields.iter().map(|f| (f.name.as_str(), f.offset)).collect();
    assert_eq!(link, [("next", 0), ("color", 8)], "the block that a pointer leads to");
}

/// The generated Rust is in the repository so that it is compiled here, where its assertions on sizes and offsets run.
#[test]
fn generated_blocks_are_those_of_the_repository() {
    let project = Project::new(&[("every_type.comp", &every_type())]);
    project.build().unwrap();
    let code = project.code();
    let start = code.find("pub mod blocks {\n").unwrap() + "pub mod blocks {\n".len();
    let found = &code[start..start + code[start..].find("\n}\n").unwrap() + 1];
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("data/shaders/blocks.rs");
    if found != fs::read_to_string(&path).unwrap() {
        let actual = Path::new(env!("CARGO_TARGET_TMPDIR")).join("blocks.rs");
        fs::write(&actual, found).unwrap();
        panic!("generated blocks have changed: compare {} with {}", actual.display(), path.display());
    }
}

/// Bytes land where the shader reads them, through `glam`'s types too.
#[test]
fn rust_values_have_the_shaders_bytes() {
    let matrix = glam::Mat4::from_cols_array(&std::array::from_fn(|i| i as f32));
    let value = blocks::Everything {
        v3: glam::Vec3::new(1.0, 2.0, 3.0),
        m4: matrix.to_cols_array_2d(),
        grid: [[glam::Vec3::ZERO; 3], [glam::Vec3::ZERO, glam::Vec3::splat(7.0), glam::Vec3::ZERO]],
        last: 99,
        ..Default::default()
    };
    let bytes = bytemuck::bytes_of(&value);
    let float = |offset: usize| f32::from_le_bytes(bytes[offset..offset + 4].try_into().unwrap());
    assert_eq!([float(12), float(16), float(20)], [1.0, 2.0, 3.0]);
    // Column 2, row 1.
    assert_eq!(float(176 + 2 * 16 + 4), 9.0);
    // grid[1][1]: the fifth of six.
    assert_eq!(float(356 + 4 * 12), 7.0);
    assert_eq!(bytes[616], 99);
    assert_eq!(bytes.len(), 624);
}

#[test]
fn storage_blocks_name_their_head_and_their_element() {
    let (shader, blocks) = reflect("every_type.comp", Stage::Compute, &every_type());
    let content = |index: usize| match &shader.bindings[index].kind {
        Kind::Storage(content, access) => (content, *access, shader.bindings[index].size),
        _ => panic!("no storage block"),
    };
    // Nothing but a run-time array: its element.
    let (Content::One(element), AccessType::ReadOnly, 0) = content(1) else { panic!() };
    assert_eq!(element.rust(""), "[f32; 4]");
    // Head and tail.
    let (Content::Tail { head, element }, AccessType::ReadWrite, 4) = content(2) else { panic!() };
    assert_eq!((head.rust(""), element.rust("")), ("Nodes".into(), "Light".into()));
    // The tail is aligned to 8, and so the head is as long.
    let (Content::Tail { head, element }, AccessType::WriteOnly, 8) = content(3) else { panic!() };
    assert_eq!((head.rust(""), element.rust("")), ("Sums".into(), "f64".into()));
    assert_eq!(blocks.by_name["Sums"].size, 8);
    assert!(!blocks.by_name.contains_key("Numbers"));
    assert_eq!(shader.workgroup, [8, 4, 2]);
}

#[test]
fn structs_with_gaps_keep_the_shaders_offsets() {
    let text = |members: &str| {
        compute(
            &format!(
                "struct Wide {{ double d; float f; }};
                 layout(set = 0, binding = 0, scalar) buffer Gaps {{ {members} }} gaps;"
            ),
            "gaps.g = gaps.w.f;",
        )
    };
    // Scalar layout puts `g` into the 4 bytes that end `Wide` in Rust.
    for members in ["Wide w; float g;", "Wide a[2]; Wide w; float g;"] {
        let problems = Project::new(&[("a.comp", &text(members))]).problems();
        assert!(problems[0].contains("member g: lies in the padding at the end of w"), "{problems:#?}");
    }
    let (_, blocks) =
        reflect("a.comp", Stage::Compute, &text("float g; Wide w; double h;").replace("gaps.g =", "gaps.h ="));
    let found: Vec<_> = blocks.by_name["Gaps"].fields.iter().map(|f| (f.name.as_str(), f.offset)).collect();
    assert_eq!(found, [("g", 0), ("w", 8), ("h", 24)]);
}

#[test]
fn strings_of_printf_stay() {
    let text = compute("#extension GL_EXT_debug_printf : require", "debugPrintfEXT(\"hello %d\", 1);");
    let project = Project::new(&[("a.comp", &text)]);
    project.build().unwrap();
    let bytes: Vec<u8> = project.spirv("a.comp").iter().flat_map(|word| word.to_le_bytes()).collect();
    assert!(bytes.windows(5).any(|window| window == b"hello"));
}

#[test]
fn specialization_constants_have_types_and_defaults() {
    let text = format!(
        "{HEAD}layout(local_size_x_id = 0, local_size_y = 2) in; layout(local_size_x = 16) in;
         layout(constant_id = 7) const bool EXACT = true;
         layout(constant_id = 1) const uint COUNT = 3u;
         layout(constant_id = 2) const float bias = 0.5;
         const uint STRIDE = EXACT ? COUNT * 2u : gl_WorkGroupSize.x;
         shared float tile[gl_WorkGroupSize.x + 2][COUNT];
         layout(set = 0, binding = 0, scalar) buffer Sum {{ uint count; float sum; }};
         void main() {{
             tile[gl_LocalInvocationID.x][0] = bias * float(STRIDE);
             barrier();
             sum = tile[0][COUNT - 1u];
             count = STRIDE;
         }}"
    );
    let (shader, blocks) = reflect("a.comp", Stage::Compute, &text);
    assert_eq!(shader.workgroup, [16, 2, 1]);
    assert_eq!(blocks.by_name["Sum"].size, 8);
    assert_eq!(shader.constants, [(1, "COUNT".into(), "u32"), (2, "bias".into(), "f32"), (7, "EXACT".into(), "bool")]);
}

/// A layout that specialization would change is none that Rust can have.
#[test]
fn specialization_constants_size_no_interface() {
    let constant = "layout(constant_id = 0) const uint COUNT = 3u;\n";
    for length in ["COUNT", "COUNT * 2u"] {
        let block =
            format!("{constant}layout(set = 0, binding = 0, scalar) buffer Sums {{ float a[{length}]; float b; }};");
        let images = format!("{constant}layout(set = 0, binding = 0, r32ui) uniform uimage2D images[{length}];");
        for (declarations, body, what) in [
            (block, "b = a[gl_LocalInvocationID.x];", "block Sums, member a"),
            (images, "imageStore(images[1], ivec2(0), uvec4(1));", "images"),
        ] {
            let problems = Project::new(&[("a.comp", &compute(&declarations, body))]).problems();
            assert!(problems[0].starts_with(&format!("shaders_glsl/a.comp: {what} is as long as")), "{problems:#?}");
        }
    }
}

#[test]
fn one_block_in_many_shaders_is_one_type() {
    let block = "layout(set = 0, binding = 0, scalar) uniform Frame { vec3 eye; float time; } frame;";
    let text = fragment("#include \"common/frame.glsl\"", "color = vec4(frame.eye, frame.time);");
    let project = Project::new(&[("common/frame.glsl", block), ("a.frag", &text), ("b/b.frag", &text)]);
    project.build().unwrap();
    let code = project.code();
    assert_eq!(code.matches("pub struct Frame ").count(), 1);
    assert_eq!(
        code.matches("pub const FRAME: crate::shader::UniformSlot<crate::shader::generated::blocks::Frame>").count(),
        2
    );
}

// ---- Reflection

#[test]
fn images_say_view_format_and_access() {
    let text = compute(
        "layout(set = 0, binding = 0, r32ui) uniform uimage2D heads;
         layout(set = 0, binding = 1, rgba16f) readonly uniform image3D volume;
         layout(set = 0, binding = 2) writeonly uniform image2DArray layers;
         layout(set = 1, binding = 0) uniform sampler2DArrayShadow shadows[3];
         layout(set = 1, binding = 1) uniform samplerCube sky;
         layout(set = 1, binding = 2) uniform sampler2DMS surface;
         layout(set = 1, binding = 3) uniform texture2D albedo;
         layout(set = 1, binding = 4) uniform sampler linear;",
        "float s = texture(shadows[1], vec4(0.5)) + textureLod(sky, vec3(1), 0.0).x + texelFetch(surface, ivec2(0), 1).x;
         s += textureLod(sampler2D(albedo, linear), vec2(0), 0.0).x;
         imageAtomicAdd(heads, ivec2(0), 1u);
         imageStore(layers, ivec3(0), s * imageLoad(volume, ivec3(0)));",
    );
    let (shader, _) = reflect("images.comp", Stage::Compute, &text);
    let found: Vec<_> = shader
        .bindings
        .iter()
        .map(|binding| {
            let (image, access) = match &binding.kind {
                Kind::StorageImage(image, access) => (Some(image), Some(*access)),
                Kind::CombinedImageSampler(image) | Kind::SampledImage(image) => (Some(image), None),
                _ => (None, None),
            };
            let image = image.map(|i| (i.view, i.multisampled, i.comparison, i.format.as_deref().unwrap_or("none")));
            (binding.place, binding.name.as_str(), binding.count, image, access)
        })
        .collect();
    let expected = [
        ((0, 0), "heads", 1, Some(("TYPE_2D", false, false, "R32_UINT")), Some(AccessType::ReadWrite)),
        ((0, 1), "volume", 1, Some(("TYPE_3D", false, false, "R16G16B16A16_SFLOAT")), Some(AccessType::ReadOnly)),
        ((0, 2), "layers", 1, Some(("TYPE_2D_ARRAY", false, false, "none")), Some(AccessType::WriteOnly)),
        ((1, 0), "shadows", 3, Some(("TYPE_2D_ARRAY", false, true, "none")), None),
        ((1, 1), "sky", 1, Some(("CUBE", false, false, "none")), None),
        ((1, 2), "surface", 1, Some(("TYPE_2D", true, false, "none")), None),
        ((1, 3), "albedo", 1, Some(("TYPE_2D", false, false, "none")), None),
        ((1, 4), "linear", 1, None, None),
    ];
    assert_eq!(found, expected);
    assert_eq!(shader.capabilities, ["StorageImageWriteWithoutFormat"]);
}

#[test]
fn every_storage_format_is_one_of_vulkan() {
    let names = [
        ("Rgba32f", "R32G32B32A32_SFLOAT"),
        ("R16f", "R16_SFLOAT"),
        ("Rgba8", "R8G8B8A8_UNORM"),
        ("Rg16", "R16G16_UNORM"),
        ("Rgba8Snorm", "R8G8B8A8_SNORM"),
        ("Rg32i", "R32G32_SINT"),
        ("R8ui", "R8_UINT"),
        ("R64ui", "R64_UINT"),
        ("Rgb10A2", "A2B10G10R10_UNORM_PACK32"),
        ("Rgb10a2ui", "A2B10G10R10_UINT_PACK32"),
        ("R11fG11fB10f", "B10G11R11_UFLOAT_PACK32"),
    ];
    for (spirv, vulkan) in names {
        assert_eq!(shaders::name::format(spirv).as_deref(), Some(vulkan));
    }
    assert_eq!(shaders::name::format("Unknown"), None);
}

#[test]
fn inputs_outputs_and_push_constants() {
    let vertex = format!(
        "{HEAD}layout(location = 3) in uvec2 ids; layout(location = 0) in vec3 position;
         layout(push_constant, scalar) uniform DrawPush {{ vec3 shift; uint first; }} push;
         layout(location = 0) flat out uvec2 id;
         void main() {{ gl_Position = vec4(position + push.shift, push.first); id = ids; }}"
    );
    let (shader, blocks) = reflect("a.vert", Stage::Vertex, &vertex);
    let inputs: Vec<_> = shader.inputs.iter().map(|i| (i.location, i.name.as_str(), i.scalar, i.components)).collect();
    assert_eq!(inputs, [(0, "position", "Float", 3), (3, "ids", "Uint", 2)]);
    assert!(shader.outputs.is_empty(), "what goes to the next stage is no colour output");
    let (name, content, size) = shader.push.unwrap();
    assert_eq!((name.as_str(), size), ("push", 16));
    assert_eq!(content, Content::One(Type::Struct("DrawPush".into(), 16, 4)));
    assert_eq!(blocks.by_name["DrawPush"].fields[1].offset, 12);

    let text = fragment(
        "layout(location = 2) out ivec3 ids; layout(location = 0) flat in uvec2 id;",
        "color = vec4(1); ids = ivec3(id, 1);",
    );
    let (shader, _) = reflect("a.frag", Stage::Fragment, &text);
    let outputs: Vec<_> =
        shader.outputs.iter().map(|o| (o.location, o.name.as_str(), o.scalar, o.components)).collect();
    assert_eq!(outputs, [(0, "color", "Float", 4), (2, "ids", "Int", 3)]);
    assert!(shader.inputs.is_empty() && shader.push.is_none());
    assert_eq!(shader.workgroup, [0; 3]);
}

#[test]
fn capabilities_are_those_that_not_every_device_has() {
    let geometry = format!(
        "{HEAD}layout(triangles) in; layout(triangle_strip, max_vertices = 3) out;
         void main() {{ gl_Layer = 1; gl_Position = gl_in[0].gl_Position; EmitVertex(); EndPrimitive(); }}"
    );
    assert_eq!(reflect("a.geom", Stage::Geometry, &geometry).0.capabilities, ["Geometry"]);
    let layer = format!(
        "{HEAD}#extension GL_ARB_shader_viewport_layer_array : require
         void main() {{ gl_Layer = gl_InstanceIndex; gl_Position = vec4(0); }}"
    );
    assert_eq!(reflect("a.vert", Stage::Vertex, &layer).0.capabilities, ["ShaderLayer"]);
}

#[test]
fn unused_bindings_are_no_slots() {
    let text = fragment(
        "layout(set = 0, binding = 0) uniform sampler2D used; layout(set = 0, binding = 1) uniform sampler2D unused;",
        "color = texture(used, vec2(0.5));",
    );
    let (shader, _) = reflect("a.frag", Stage::Fragment, &text);
    assert_eq!(shader.bindings.iter().map(|b| b.name.as_str()).collect::<Vec<_>>(), ["used"]);
}

#[test]
fn names_become_rust() {
    for (glsl, rust) in [
        ("shadowMap", "SHADOW_MAP"),
        ("Frame", "FRAME"),
        ("HTTPServer", "HTTP_SERVER"),
        ("N", "N"),
        ("lights_2", "LIGHTS_2"),
        ("worldFromView", "WORLD_FROM_VIEW"),
    ] {
        assert_eq!(shaders::name::constant(glsl), rust);
    }
    assert_eq!(shaders::name::module("depth-peel.vert"), "depth_peel_vert");
    assert_eq!(shaders::name::module("2d.frag"), "_2d_frag");
    assert_eq!(shaders::name::module("mod"), "r#mod");
    assert_eq!(shaders::name::identifier("type"), "r#type");
}

#[test]
fn modules_follow_folders() {
    let text = fragment("", "color = vec4(1);");
    let project =
        Project::new(&[("shadow/cascaded/depth.frag", &text), ("shadow/mask.frag", &text), ("z.frag", &text)]);
    project.build().unwrap();
    let code = project.code();
    let listed: Vec<&str> =
        code.lines().filter_map(|line| line.trim().strip_prefix('&')?.strip_suffix("::SHADER,")).collect();
    assert_eq!(
        listed,
        [
            "crate::shader::generated::shadow::cascaded::depth_frag",
            "crate::shader::generated::shadow::mask_frag",
            "crate::shader::generated::z_frag",
        ]
    );
    for line in ["pub mod shadow {", "pub mod cascaded {", "pub mod depth_frag {", "pub mod mask_frag {"] {
        assert_eq!(code.matches(line).count(), 1, "{line}");
    }
}

/// The engine's own.
#[test]
fn the_engine_lists_every_shader_of_the_tree() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("../shaders_glsl");
    let tree = source::Tree::read(&root).unwrap();
    let expected: Vec<&str> = tree.shaders().map(|(path, _)| path).collect();
    let all = shadowgraph::shader::generated::ALL;
    assert_eq!(all.iter().map(|shader| shader.file).collect::<Vec<_>>(), expected);
    assert!(!all.is_empty());
    for shader in all {
        assert_eq!(shader.words()[..2], [0x0723_0203, 0x0001_0600], "{}", shader.file);
        let places: Vec<_> = shader.bindings.iter().map(|binding| (binding.set, binding.binding)).collect();
        assert!(places.is_sorted(), "{}", shader.file);
    }
}

// ---- Errors

#[test]
fn broken_shaders_are_reported_all_at_once_with_file_and_line() {
    let project = Project::new(&[
        ("good.comp", &compute("", "")),
        ("a/wrong.frag", &fragment("", "color = nothing;\ncolor = vec3(1);")),
        ("wrong.comp", &compute("float f = ;", "")),
    ]);
    let problems = project.problems();
    let places: Vec<&str> = problems.iter().map(|problem| problem.split_once(": error: ").unwrap().0).collect();
    // The compiler has two things to say about line 6.
    let (first, second) = ("shaders_glsl/a/wrong.frag:6", "shaders_glsl/a/wrong.frag:7");
    assert_eq!(places, [first, first, second, "shaders_glsl/wrong.comp:4"], "{problems:#?}");
    assert!(problems[0].contains("'nothing' : undeclared identifier"), "{problems:#?}");
}

#[test]
fn a_broken_include_is_named_once() {
    let text = compute("#include \"common/x.glsl\"", "");
    let project = Project::new(&[
        ("common/x.glsl", "float one() { return 1.0; }\nfloat two() { return missing; }\n"),
        ("a.comp", &text),
        ("b/b.comp", &text),
    ]);
    let problems = project.problems();
    assert_eq!(problems.len(), 1, "{problems:#?}");
    assert!(problems[0].starts_with("shaders_glsl/common/x.glsl:2: error: 'missing'"), "{problems:#?}");
}

#[test]
fn a_missing_include_is_an_error_in_its_line() {
    let project = Project::new(&[("a/a.comp", &compute("\n#include \"common/none.glsl\"", ""))]);
    let problems = project.problems();
    assert!(problems[0].starts_with("shaders_glsl/a/a.comp:5: error:"), "{problems:#?}");
    assert!(problems[0].contains("none.glsl"), "{problems:#?}");
}

#[test]
fn includes_come_from_the_root_then_from_beside() {
    let project = Project::new(&[
        ("common/x.glsl", "#include \"y.glsl\"\nfloat x() { return y(); }"),
        ("common/y.glsl", "#ifndef Y\n#define Y\nfloat y() { return 1.0; }\n#endif"),
        (
            "a/a.comp",
            &compute(
                "#include \"common/x.glsl\"\n#include \"../common/y.glsl\"\n#include \"z.glsl\"",
                "float f = x() + z();",
            ),
        ),
        ("a/z.glsl", "float z() { return 2.0; }"),
    ]);
    assert_eq!(project.compiled(), ["a/a.comp"]);
    // A file of that name below the root goes first, and makes the shader stale.
    project.write("z.glsl", "float other() { return 2.0; }");
    assert!(project.problems()[0].contains("'z'"), "{:#?}", project.problems());
}

#[test]
fn a_block_must_say_scalar() {
    let project = Project::new(&[
        (
            "a.comp",
            &compute(
                "// uniform Comment {\n/* buffer Comment {\n*/ layout(set = 0, binding = 0)\nuniform Frame { float f[3]; } frame;",
                "float f = frame.f[1];",
            ),
        ),
        (
            "common/b.glsl",
            "struct Fine { float f; };\nlayout(set = 0, binding = 0, std430) readonly buffer Bad { float f; };",
        ),
    ]);
    let problems = project.problems();
    assert_eq!(
        problems,
        [
            "shaders_glsl/a.comp:7: error: block Frame: say layout(scalar, …), as every block must",
            "shaders_glsl/common/b.glsl:2: error: block Bad: say layout(scalar, …), as every block must",
        ]
    );
}

/// A block that a macro hides from the check of the text has a layout that Rust cannot have.
#[test]
fn a_hidden_block_without_scalar_is_found_by_its_layout() {
    let array = compute(
        "#define BLOCK uniform Frame\nlayout(set = 0, binding = 0) BLOCK { float f[3]; } frame;\nlayout(set = 0, binding = 1, scalar) buffer Out { float o; };",
        "o = frame.f[gl_LocalInvocationID.x];",
    );
    let matrix = compute(
        "#define BLOCK uniform Frame\nlayout(set = 0, binding = 0) BLOCK { mat3 m; } frame;\nlayout(set = 0, binding = 1, scalar) buffer Out { float o; };",
        "o = frame.m[gl_LocalInvocationID.x].x;",
    );
    for (text, member) in [(array, "f"), (matrix, "m")] {
        let problems = Project::new(&[("a.comp", &text)]).problems();
        assert!(
            problems[0].starts_with(&format!("shaders_glsl/a.comp: block Frame, member {member}:")),
            "{problems:#?}"
        );
        assert!(problems[0].contains("say layout(scalar"), "{problems:#?}");
    }
}

#[test]
fn two_layouts_under_one_name_are_an_error_that_names_both_files() {
    let shader = |members: &str| {
        fragment(
            &format!("layout(set = 0, binding = 0, scalar) uniform Frame {{ {members} }} frame;"),
            "color = vec4(frame.time);",
        )
    };
    let project =
        Project::new(&[("a.frag", &shader("vec3 eye; float time;")), ("b/b.frag", &shader("vec2 eye; float time;"))]);
    assert_eq!(
        project.problems(),
        [
            "shaders_glsl/b/b.frag: block Frame differs from that of shaders_glsl/a.frag: vec2 eye at 0, against vec3 eye at 0; \
          rename one, or put it in an include"
        ]
    );
    // One that goes on where the other ends.
    project.write("b/b.frag", &shader("vec3 eye; float time; uint more;"));
    assert!(project.problems()[0].contains("uint more at 16, against nothing"), "{:?}", project.problems());
    // A name of a member is part of it.
    project.write("b/b.frag", &shader("vec3 where; float time;"));
    assert!(project.problems()[0].contains("vec3 where at 0, against vec3 eye at 0"));
    project.write("b/b.frag", &shader("vec3 eye; float time;"));
    project.build().unwrap();
}

#[test]
fn what_not_every_device_binds_is_an_error() {
    let sampled =
        |declaration: &str, use_: &str| fragment(declaration, &format!("color = texture({use_}, vec2(0.5));"));
    let wide = fragment(
        "layout(push_constant, scalar) uniform WidePush { vec4 v[9]; } push;",
        "color = push.v[int(gl_FragCoord.x)];",
    );
    for (text, expected) in [
        (sampled("layout(set = 4, binding = 0) uniform sampler2D far;", "far"), "far is in set 4"),
        (wide, "push constants push: 144 bytes; every device has 128"),
        (
            sampled(
                "layout(set = 0, binding = 0) uniform sampler2D one; layout(set = 0, binding = 0) uniform sampler2D two;",
                "one, vec2(0)) + texture(two",
            ),
            "are both binding 0 of set 0",
        ),
        (
            sampled(
                "layout(set = 0, binding = 0) uniform sampler2D theMap; layout(set = 0, binding = 1) uniform sampler2D the_map;",
                "theMap, vec2(0)) + texture(the_map",
            ),
            "another slot is called THE_MAP",
        ),
        (
            fragment(
                "#extension GL_EXT_nonuniform_qualifier : require\nlayout(set = 0, binding = 0) uniform sampler2D all[];",
                "color = texture(all[int(gl_FragCoord.x)], vec2(0));",
            ),
            "all is an array without a length",
        ),
        (
            fragment("layout(set = 0, binding = 0) uniform samplerBuffer texels;", "color = texelFetch(texels, 0);"),
            "texels: descriptors of the kind UniformTexelBuffer are not supported",
        ),
        (
            fragment(
                "layout(set = 0, binding = 0, scalar, row_major) uniform Rows { mat4 m; } rows;",
                "color = rows.m[int(gl_FragCoord.x)];",
            ),
            "row_major is not supported",
        ),
    ] {
        let problems = Project::new(&[("a.frag", &text)]).problems();
        assert!(
            problems[0].starts_with("shaders_glsl/a.frag: ") && problems[0].contains(expected),
            "{expected}: {problems:#?}"
        );
    }
}

#[test]
fn modules_of_one_name_are_an_error() {
    let text = fragment("", "color = vec4(1);");
    for (one, two) in [("a-b.frag", "a_b.frag"), ("a.frag", "a_frag/b.frag"), ("x.frag", "blocks/b.frag")] {
        let problems = Project::new(&[(one, &text), (two, &text)]).problems();
        assert!(problems[0].contains("its module's name"), "{problems:#?}");
    }
}

#[test]
fn files_that_are_no_glsl_are_an_error() {
    let project =
        Project::new(&[("README.md", "fine"), (".hidden", "fine"), ("a.comp~", "fine"), ("a.txt", "not fine")]);
    fs::write(project.sources().join("b.glsl"), [0xff, 0xfe]).unwrap();
    project.write("c.comp", "fine\nnot\0fine");
    let problems = project.problems();
    assert_eq!(problems.len(), 3, "{problems:#?}");
    assert!(problems[0].starts_with("shaders_glsl/a.txt: unknown kind of file"));
    assert_eq!(problems[1], "shaders_glsl/b.glsl: not UTF-8");
    assert_eq!(problems[2], "shaders_glsl/c.comp:2: a NUL character");
}

// ---- Cache

/// Two shaders that include `x`, one of them through `y`, and one that includes nothing.
fn cached() -> Project {
    let project = Project::new(&[
        ("common/x.glsl", "float x() { return 1.0; }\n"),
        ("common/y.glsl", "#include \"x.glsl\"\nfloat y() { return x(); }\n"),
        ("a.frag", &fragment("#include \"common/x.glsl\"", "color = vec4(x());")),
        ("b.frag", &fragment("#include \"common/y.glsl\"", "color = vec4(y());")),
        ("c.frag", &fragment("", "color = vec4(1);")),
    ]);
    assert_eq!(project.compiled(), ["a.frag", "b.frag", "c.frag"]);
    project
}

#[test]
fn an_edit_recompiles_what_includes_the_file() {
    let project = cached();
    assert!(project.compiled().is_empty());
    project.write("common/y.glsl", "#include \"x.glsl\"\nfloat y() { return x() + 1.0; }\n");
    assert_eq!(project.compiled(), ["b.frag"]);
    project.write("common/x.glsl", "float x() { return 2.0; }\n");
    assert_eq!(project.compiled(), ["a.frag", "b.frag"]);
    project.write("c.frag", &fragment("", "color = vec4(2);"));
    assert_eq!(project.compiled(), ["c.frag"]);
    assert!(project.compiled().is_empty());
    // Contents count, not times.
    project.write("c.frag", &fragment("", "color = vec4(2);"));
    assert!(project.compiled().is_empty());
    // What is lost is made again.
    fs::remove_file(project.out().join("spv/a.frag.spv")).unwrap();
    assert_eq!(project.compiled(), ["a.frag"]);
}

#[test]
fn an_edit_of_a_body_changes_one_file() {
    let project = cached();
    let times = |project: &Project| -> Vec<SystemTime> {
        let files = ["shaders.rs", "spv/a.frag.spv", "spv/b.frag.spv", "spv/c.frag.spv"];
        files.iter().map(|file| fs::metadata(project.out().join(file)).unwrap().modified().unwrap()).collect()
    };
    let before = times(&project);
    project.write("c.frag", &fragment("", "color = vec4(3);"));
    project.build().unwrap();
    let after = times(&project);
    let changed: Vec<bool> = before.iter().zip(&after).map(|(before, after)| before != after).collect();
    assert_eq!(changed, [false, false, false, true]);
    // A comment compiles to the same words.
    project.write("c.frag", &fragment("// A comment.", "\n\n// Another.\ncolor = vec4(3);"));
    assert_eq!(project.compiled(), ["c.frag"]);
    assert_eq!(times(&project), after);
}

#[test]
fn a_failed_build_spoils_nothing() {
    let project = cached();
    let good = fragment("", "color = vec4(1);");
    project.write("c.frag", &fragment("", "color = nothing;"));
    let problems = project.problems();
    assert_eq!(project.problems(), problems, "an error stays one");
    project.write("c.frag", &good);
    project.build().unwrap();
}

#[test]
fn removed_shaders_leave_nothing() {
    let project = cached();
    fs::remove_file(project.sources().join("a.frag")).unwrap();
    assert!(project.compiled().is_empty());
    assert!(!project.out().join("spv/a.frag.spv").exists());
    assert!(!project.code().contains("a_frag"));
}

#[test]
fn words_hold_names_but_no_source() {
    let project = cached();
    let words = project.spirv("a.frag");
    let bytes: Vec<u8> = words.iter().flat_map(|word| word.to_le_bytes()).collect();
    let has = |text: &str| bytes.windows(text.len()).any(|window| window == text.as_bytes());
    assert_eq!(words[0], 0x0723_0203);
    assert_eq!(words[1], 0x0001_0600, "SPIR-V 1.6");
    assert!(has("color"));
    assert!(!has("#version") && !has("shaders_glsl"));
}

// ---- Prebuilt sets

#[test]
fn a_prebuilt_set_stands_in_for_the_compiler() {
    let project = cached();
    let folder = TempDir::new().unwrap();
    let (set, out) = (folder.path().join("prebuilt"), folder.path().join("out"));
    fs::create_dir_all(set.join("spv")).unwrap();
    fs::write(set.join("spv/old.frag.spv"), "old").unwrap();
    prebuilt::copy(&project.out(), &set).unwrap();
    assert!(!set.join("spv/old.frag.spv").exists());

    // With its sources at hand, and without.
    for sources in [project.sources(), folder.path().join("none")] {
        prebuilt::restore(&set, &sources, &out).unwrap();
        for file in ["shaders.rs", "manifest.txt", "spv/a.frag.spv", "spv/b.frag.spv", "spv/c.frag.spv"] {
            assert_eq!(fs::read(out.join(file)).unwrap(), fs::read(project.out().join(file)).unwrap(), "{file}");
        }
        fs::remove_dir_all(&out).unwrap();
    }

    // The sources have changed; there is no set; there is nothing.
    project.write("common/x.glsl", "float x() { return 5.0; }\n");
    let stale = prebuilt::restore(&set, &project.sources(), &out).unwrap_err();
    assert!(stale[0].contains("has changed") && stale[0].contains("--features compile-shaders"), "{stale:?}");
    let none = folder.path().join("none");
    let unmade = prebuilt::restore(&none, &project.sources(), &out).unwrap_err();
    assert!(
        unmade[0].contains("no compiled shaders") && unmade[0].contains("--features compile-shaders"),
        "{unmade:?}"
    );
    let nothing = prebuilt::restore(&none, &none, &out).unwrap_err();
    assert!(nothing[0].contains("published package"), "{nothing:?}");
    assert!(!out.exists());
}

// ---- Any text

proptest! {
    #![proptest_config(ProptestConfig { cases: 256, ..ProptestConfig::default() })]

    /// The readers of text take anything.
    #[test]
    fn any_text_is_read(
        before in prop::collection::vec("[a-z/#*{};(\\) \"é]{0,12}", 0..6),
        after in "\\PC*",
    ) {
        let text = format!("{}\n{after}", before.join("\n"));
        let project = Project::new(&[("a.glsl", &text), ("b.glsl", "#include \"a.glsl\"")]);
        let tree = source::Tree::read(&project.sources()).unwrap();
        shaders::scalar::check(&tree);
        prop_assert!(tree.closure("b.glsl").contains("a.glsl"));
        prop_assert_eq!(tree.key("b.glsl", "").len(), 32);
    }
}
