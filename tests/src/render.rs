//! Pictures of scenes to be compared: what is shown, from where, and what the engine makes of it.

use glam::Vec3;
use shadowgraph::capture::{self, CapturedFrame, DeepPicture, FrameCapture};
use shadowgraph::frame::{Frame, FrameSettings, Selection};
use shadowgraph::gpu::Gpu;
use shadowgraph::graph::{Executed, Executor, Graph};
use shadowgraph::scene::{AlphaMode, Camera, GpuScene, Light, LightKind, Projection, Scene, View};
use shadowgraph::techniques::surface::gbuffer::Precision;

use crate::exr_file::{Channel, ExrFile, Part};
use crate::harness::require_scene;

/// A scene and a camera.
#[derive(Clone)]
pub struct Subject {
    /// For reports.
    pub name: String,
    /// What is shown.
    pub scene: Scene,
    /// From where.
    pub camera: Camera,
    /// Width and height of the picture.
    pub size: [u32; 2],
}

impl Subject {
    /// A scene as its first camera sees it; framed where it has none.
    pub fn new(scene: Scene, size: [u32; 2]) -> Self {
        let camera = scene.cameras.first().cloned();
        let camera = camera.unwrap_or_else(|| Camera::framing(bounds(&scene), 0.7, size[0] as f32 / size[1] as f32));
        Self { name: scene.name.clone(), scene, camera, size }
    }

    /// A built-in scene.
    pub fn builtin(name: &str, size: [u32; 2]) -> Self {
        Self::new(Scene::builtin(name).unwrap_or_else(|error| panic!("{error}")), size)
    }

    /// A scene `NAME/NAME.glb` of the scenes folder; `None`, said aloud, where it is not there.
    pub fn file(name: &str, size: [u32; 2]) -> Option<Self> {
        let path = require_scene(&format!("{name}/{name}.glb"))?;
        Some(Self::new(Scene::load(path).unwrap_or_else(|error| panic!("{error}")), size))
    }

    /// From another place.
    pub fn seen_from(mut self, eye: Vec3, target: Vec3) -> Self {
        self.camera = Camera::look_at(eye, target, Vec3::Y, 0.9, 0.05);
        self
    }

    /// Through a lens of a narrower field of view.
    pub fn zoomed(mut self, share: f32) -> Self {
        if let Projection::Perspective { fov_y, .. } = &mut self.camera.projection {
            *fov_y *= share;
        }
        self
    }

    /// With its blended materials opaque.
    pub fn without_blending(mut self) -> Self {
        for material in self.scene.materials.iter_mut().filter(|material| material.is_blended()) {
            (material.alpha_mode, material.transmission) = (AlphaMode::Opaque, 0.0);
        }
        self
    }

    /// With its cut-out materials whole: voxels are of whole triangles.
    pub fn without_cut_outs(mut self) -> Self {
        for material in self.scene.materials.iter_mut().filter(|m| matches!(m.alpha_mode, AlphaMode::Mask { .. })) {
            material.alpha_mode = AlphaMode::Opaque;
        }
        self.name += ", leaves whole";
        self
    }

    /// With what `change` does to it: a seeded mistake.
    pub fn changed(&self, change: impl FnOnce(&mut Self)) -> Self {
        let mut changed = self.clone();
        change(&mut changed);
        changed
    }

    /// Camera and size.
    pub fn view(&self) -> View {
        self.camera.view(self.size)
    }

    /// The light that casts cascaded shadows: the first directional one.
    pub fn sun(&self) -> &Light {
        let sun = self.scene.lights.iter().find(|light| matches!(light.kind, LightKind::Directional { .. }));
        sun.unwrap_or_else(|| panic!("{} has no sun", self.name))
    }

    /// The frame, all layers, through 32-bit floats, its parts as a file would hold them.
    pub fn capture(&self, gpu: &Gpu, change: impl FnOnce(&mut FrameSettings)) -> ExrFile {
        self.captured(gpu, change, |request, frame, executed| self.parts(request.collect(frame, executed)))
    }

    /// The deep picture of the frame, and the frame.
    pub fn capture_deep(&self, gpu: &Gpu, change: impl FnOnce(&mut FrameSettings)) -> (DeepPicture, ExrFile) {
        let change = |settings: &mut FrameSettings| {
            settings.deep = true;
            change(settings);
        };
        self.captured(gpu, change, |request, frame, executed| {
            let deep = request.collect_deep(frame, executed).unwrap_or_else(|error| panic!("{}: {error}", self.name));
            (deep, self.parts(request.collect(frame, executed)))
        })
    }

    fn captured<R>(
        &self,
        gpu: &Gpu,
        change: impl FnOnce(&mut FrameSettings),
        collect: impl FnOnce(&FrameCapture<()>, &Frame, &Executed) -> R,
    ) -> R {
        let mut settings = FrameSettings::new(self.view());
        settings.precision = Precision::Float;
        change(&mut settings);
        let mut frame = None;
        let executed = self.execute(gpu, |graph, scene| frame = Some(settings.record(graph, scene)));
        let frame = frame.unwrap_or_else(|| panic!("nothing was recorded"));
        let view = self.view();
        let request = FrameCapture {
            scene: &self.scene,
            camera: &self.camera,
            view: &view,
            caps: gpu.caps(),
            settings: &(),
            float: true,
            exposure: 1.0,
            reproducible: true,
        };
        collect(&request, &frame, &executed)
    }

    fn parts(&self, captured: shadowgraph::Result<CapturedFrame>) -> ExrFile {
        let captured = captured.unwrap_or_else(|error| panic!("{}: {error}", self.name));
        ExrFile { parts: captured.capture.parts.into_iter().map(part).collect() }
    }

    /// Records and runs a graph over the uploaded scene.
    pub fn execute(&self, gpu: &Gpu, record: impl for<'f> FnOnce(&mut Graph<'f>, &'f GpuScene)) -> Executed {
        let fail = |error: &dyn std::fmt::Display| -> ! { panic!("{}: {error}", self.name) };
        let scene = self.scene.clone().upload(gpu).unwrap_or_else(|error| fail(&error));
        let mut graph = Graph::new("frame", gpu.caps());
        record(&mut graph, &scene);
        let plan = graph.compile(gpu).unwrap_or_else(|error| fail(&error));
        Executor::new(gpu).execute(&plan, graph).unwrap_or_else(|error| fail(&error))
    }
}

/// For [`Subject::capture`]: layers of these names alone.
pub fn only(layers: &[&str]) -> impl FnOnce(&mut FrameSettings) + use<> {
    let names = layers.iter().map(|name| name.to_string()).collect();
    |settings| settings.layers = Selection::Only(names)
}

/// Turns a directional or spot light by so many degrees.
pub fn turn(light: &mut Light, degrees: f32) {
    if let LightKind::Directional { direction, .. } | LightKind::Spot { direction, .. } = &mut light.kind {
        let across = direction.any_orthonormal_vector();
        *direction = (*direction + across * degrees.to_radians().tan()).normalize();
    }
}

fn bounds(scene: &Scene) -> shadowgraph::geometry::Aabb {
    let points = scene.objects.iter().flat_map(|object| {
        let primitives = scene.meshes[object.mesh].primitives.iter();
        primitives.flat_map(|p| &p.positions).map(|p| object.world_from_object.transform_point3(*p))
    });
    let empty = (Vec3::INFINITY, Vec3::NEG_INFINITY);
    let (min, max) = points.fold(empty, |(min, max), p| (min.min(p), max.max(p)));
    shadowgraph::geometry::Aabb { min, max }
}

fn part(part: capture::Part) -> Part {
    let channel = |content: capture::Content| match content.into_samples().unwrap_or_else(|error| panic!("{error}")) {
        capture::Samples::F16(values) => Channel::Half(values.into_iter().map(f32::from).collect()),
        capture::Samples::F32(values) => Channel::Float(values),
        capture::Samples::U32(values) => Channel::Uint(values),
    };
    let channels = part.channels.into_iter().map(|c| (c.name, channel(c.content))).collect();
    Part { name: part.name, size: part.size, channels, texts: Default::default() }
}
