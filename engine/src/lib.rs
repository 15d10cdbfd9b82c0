//! Explicit Vulkan rendering with a render graph, made to answer visibility questions: from the eye, from the lights,
//! and from many points to many points. Every buffer of a frame can be captured.
//!
//! A frame is *described* by techniques that take handles and settings and give handles, *planned* by pure functions,
//! *executed* on a Vulkan 1.3 device, and reported. The floors of the house, each of which uses only those below it:
//!
//! | module | what it holds |
//! |---|---|
//! | [`capture`] | OpenEXR, flat and deep, PNG, NumPy, voxels; read-back |
//! | [`frame`] | the assembled frame |
//! | [`techniques`] | one folder each, in families |
//! | [`scene`] | meshes, materials, lights, cameras, glTF, built-in scenes, GPU upload |
//! | [`graph`] | passes and resources, plan, execution, report |
//! | [`shader`] | generated bindings, programs |
//! | [`gpu`] | instance, device, memory, commands, validation messages |
//! | [`geometry`] | boxes and frusta on the host |
//! | [`error`] | one error type |
//!
//! ```no_run
//! use shadowgraph::prelude::*;
//!
//! # fn main() -> Result<(), Box<dyn std::error::Error>> {
//! let gpu = Gpu::headless(GpuOptions::default())?;
//! let scene = Scene::builtin("courtyard")?.upload(&gpu)?;
//! let settings = FrameSettings::new(scene.cameras[0].view([1280, 720]));
//! let mut graph = Graph::new("frame", gpu.caps());
//! let frame = settings.record(&mut graph, &scene);
//! let plan = graph.compile(&gpu)?;
//! let executed = Executor::new(&gpu).execute(&plan, graph)?;
//! println!("{} layers", frame.layers.len());
//! // World position, and distance along the view axis.
//! let positions: Vec<[f32; 4]> = executed.capture("position")?.texels()?;
//! # Ok(())
//! # }
//! ```
//!
//! The floors from [`graph`] down are a crate of their own, `shadowgraph-core`: it alone holds `unsafe` code, and an
//! edit of a technique or of a shader does not compile it again.
#![forbid(unsafe_code)]

pub mod capture;
pub mod frame;
pub mod prelude;
pub mod scene;
pub mod shader;
pub mod techniques;

use shadowgraph_core::parallel;
#[doc(inline)]
pub use shadowgraph_core::{Error, Result, error, geometry, gpu, graph};
