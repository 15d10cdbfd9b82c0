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

use std::fs;
use std::path::{Path, PathBuf};

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

    fn code(&self) -> String {
        fs::read_to_string(self.out().join("shaders.rs")).unwrap()
    }
}

const HEAD: &str = "#version 460\n#extension GL_EXT_scalar_block_layout : require\n";

fn compute(declarations: &str, body: &str) -> String {
    format!("{HEAD}layout(local_size_x = 8, local_size_y = 4) in;\n{declarations}\nvoid main() {{\n{body}\n}}\n")
}

#[test]
fn look() {
    let project = Project::new(&[
        ("common/frame.glsl", "#ifndef F\n#define F\nstruct Light { vec3 position; float range; };\nlayout(set = 0, binding = 0, scalar) uniform Frame { mat4 clip_from_world; vec3 eye; uvec2 size; vec4 v; Light lights[3]; mat3 m; bool on; } frame;\n#endif\n"),
        ("shadow/cascaded/depth.vert", &format!("{HEAD}#include \"common/frame.glsl\"\nlayout(location=0) in vec3 position;\nstruct Object {{ mat4 world; uint type; }};\nlayout(set=0,binding=1,scalar) readonly buffer Objects {{ Object objects[]; }};\nlayout(push_constant, scalar) uniform Push {{ uint first; vec2 x; }} push;\nvoid main() {{ gl_Position = frame.clip_from_world * objects[gl_InstanceIndex + push.first].world * vec4(position, 1) + frame.v; }}\n")),
        ("shadow/cascaded/depth.frag", &format!("{HEAD}#include \"common/frame.glsl\"\nlayout(location=0) out vec4 color;layout(location=1) out uvec2 ids;\nlayout(set=1,binding=0) uniform sampler2DArrayShadow shadowMap;\nlayout(set=1,binding=1) uniform texture2D albedo; layout(set=1,binding=2) uniform sampler linear;\nvoid main() {{ color = vec4(texture(shadowMap, vec4(frame.eye, 1))) + texture(sampler2D(albedo, linear), vec2(0)); ids = uvec2(1,2); }}\n")),
        ("a.comp", &compute("#extension GL_EXT_buffer_reference : require\nstruct Node { uint next; float depth; };\nlayout(buffer_reference) buffer Link;\nlayout(buffer_reference, scalar) buffer Link { Link next; vec3 v; };\nlayout(set=0,binding=0,scalar) buffer List { uint count; Node nodes[]; };\nlayout(set=0,binding=1,r32ui) uniform uimage2D heads; layout(set=0,binding=2,rgba16f) readonly uniform image3D a; layout(set=0,binding=3) writeonly uniform image2DArray b;layout(set=0, binding=4,scalar) writeonly buffer Out { Link link; float x[]; } o;", "uint i = atomicAdd(count, 1); nodes[i].next = imageAtomicExchange(heads, ivec2(0), i); imageStore(b, ivec3(0), imageLoad(a, ivec3(1))); o.x[i] = 1; o.link.v = vec3(1); o.link.next.v = vec3(0);")),
    ]);
    match project.build() {
        Ok(report) => println!("{report:?}\n{}", project.code()),
        Err(problems) => panic!("{}", problems.join("\n")),
    }
}
