//! What commands share: a device, a scene on it, and a frame.

use serde::Serialize;
use shadowgraph::Error;
use shadowgraph::frame::{ABUFFER_REPORT, Frame, FrameSettings, Selection, VoxelVisibility};
use shadowgraph::gpu::{Gpu, GpuOptions, Messages, Severity, Validation};
use shadowgraph::graph::{Capture, Executed, Executor, Graph};
use shadowgraph::scene::{Camera, GpuScene, Scene};
use shadowgraph::shader::generated::blocks::ABufferReport;
use shadowgraph::techniques::shadow::deep::DeepShadow;
use shadowgraph::techniques::surface::gbuffer::Precision;

use crate::arguments::SceneSource;
use crate::cache;
use crate::cli::{DeviceArguments, FrameArguments};
use crate::failure::{Failure, Result};
use crate::view;

/// Opens the device.
pub fn open(arguments: &DeviceArguments) -> Result<Gpu> {
    let validation = if arguments.validation { Validation::On } else { Validation::Off };
    let options = GpuOptions {
        device: arguments.device.clone(),
        validation,
        pipeline_cache: cache::pipelines(),
        ..GpuOptions::default()
    };
    Gpu::headless(options).map_err(|error| match (&error, &arguments.device) {
        (Error::NoDevice { .. }, Some(_)) => Failure::input(error),
        _ => error.into(),
    })
}

/// Frees the device. Leaks are failures, and so are validation messages, those of freeing included.
pub fn close(gpu: Gpu) -> Result<()> {
    let messages = gpu.messages().clone();
    gpu.close()?;
    refuse_messages(&messages)
}

fn refuse_messages(messages: &Messages) -> Result<()> {
    // They were told when they came; `Info` is what shaders print.
    let count = messages.take().iter().filter(|message| message.severity != Severity::Info).count();
    if count > 0 {
        return Err(Failure::failed(format!("the validation layer had {count} messages, printed above")));
    }
    Ok(())
}

/// Loads a scene, and tells its warnings.
pub fn scene(source: &SceneSource) -> Result<Scene> {
    let scene = match source {
        SceneSource::Builtin(name) => Scene::builtin(name),
        SceneSource::File(path) => Scene::load(path),
    }
    .map_err(Failure::input)?;
    for warning in &scene.warnings {
        log::warn!("{source}: {warning}");
    }
    Ok(scene)
}

/// Loads the scene of a frame and gives it a sun where it is to have one.
pub fn load(arguments: &FrameArguments) -> Result<Scene> {
    let mut loaded = scene(&arguments.scene)?;
    view::set_sun(&mut loaded, arguments.sun);
    Ok(loaded)
}

/// Bands that the A-buffer may be built in where its memory is given.
const MOST_BANDS: u32 = 64;

/// Settings of a frame as the arguments have them.
pub fn frame_settings(arguments: &FrameArguments, scene: &GpuScene, camera: &Camera) -> Result<FrameSettings> {
    let environment = arguments.environment.unwrap_or_else(|| view::sky(scene));
    Ok(FrameSettings {
        precision: if arguments.float { Precision::Float } else { Precision::Compact },
        environment: glam::Vec3::splat(environment),
        voxels: arguments.voxels.map(|resolution| VoxelVisibility::new(resolution, scene)),
        layers: arguments.layers.clone(),
        transparency: arguments.transparency()?,
        deep_shadow: arguments.deep_shadows.map(|resolution| DeepShadow { resolution }),
        abuffer_samples: arguments.abuffer_samples.unwrap_or(1),
        layer_bands: if arguments.layer_memory.is_some() { MOST_BANDS } else { 1 },
        layer_memory: arguments.layer_memory.map_or(u64::MAX, |mebibytes| mebibytes << 20),
        ..FrameSettings::new(camera.view(arguments.size.0))
    })
}

/// Layers that a frame has with an option alone.
const LAYERS_OF_OPTIONS: [(&str, &str); 3] = [
    (
        "abuffer",
        "--transparency abuffer, where something is blended: abuffer.count, abuffer.front.Z, abuffer.0 to abuffer.255",
    ),
    ("ambient_occlusion", "--voxels"),
    ("transmittance", "--deep-shadows, where something is blended"),
];

/// Records a frame. An unknown layer is bad usage, and the known ones are listed.
pub fn record<'f>(settings: &FrameSettings, graph: &mut Graph<'f>, scene: &'f GpuScene) -> Result<Frame> {
    let frame = settings.record(graph, scene);
    if let Selection::Only(names) = &settings.layers {
        let known = |wanted: &String| {
            let one = Selection::Only(vec![wanted.clone()]);
            frame.layers.iter().any(|layer| one.wants(&layer.name))
        };
        if let Some(unknown) = names.iter().find(|name| !known(name)) {
            let mut every = Graph::new("every layer", graph.caps());
            let all = FrameSettings { layers: Selection::All, ..settings.clone() }.record(&mut every, scene);
            let names: Vec<_> = all.layers.iter().map(|layer| layer.name.as_str()).collect();
            let first = unknown.split('.').next().unwrap_or_default();
            let comes_with = LAYERS_OF_OPTIONS.iter().find(|(layer, _)| *layer == first);
            let message = match comes_with {
                Some((_, option)) => format!("no layer {unknown:?} here: it comes with {option}"),
                None => format!("unknown layer {unknown:?}; this scene has {}", names.join(", ")),
            };
            return Err(Failure::input(message));
        }
    }
    Ok(frame)
}

/// Records a frame, lets `change` look into it, and runs it. `left`: [`Executor::execute_with`].
pub fn render(
    executor: &mut Executor,
    gpu: &Gpu,
    scene: &GpuScene,
    settings: &FrameSettings,
    change: impl FnOnce(&mut Graph) -> Result<()>,
    mut left: impl FnMut(&Frame, &[Capture]),
) -> Result<(Frame, Executed)> {
    let mut graph = Graph::new("frame", gpu.caps());
    let frame = record(settings, &mut graph, scene)?;
    change(&mut graph)?;
    let plan = graph.compile(gpu).map_err(Error::from)?;
    let executed =
        executor.execute_with(&plan, graph, &mut |captures| left(&frame, captures)).map_err(|error| match error {
            Error::OutOfMemory { .. } => {
                Failure::failed(format!("{error}; fewer --layers or a smaller --size need less"))
            }
            other => other.into(),
        })?;
    check_layers(&executed)?;
    Ok((frame, executed))
}

/// What the A-buffer could not hold is not lost in silence.
fn check_layers(executed: &Executed) -> Result<()> {
    let Some(report) = executed.captures.iter().find(|capture| capture.name == ABUFFER_REPORT) else { return Ok(()) };
    let report = report.texels::<ABufferReport>()?.first().copied();
    let Some(ABufferReport { lost_pixels, clamped_pixels, lost_nodes }) = report else { return Ok(()) };
    if lost_pixels > 0 {
        return Err(Failure::failed(format!("the A-buffer lost layers of {lost_pixels} pixels")));
    }
    if lost_nodes > 0 {
        return Err(Failure::failed(format!("the A-buffer lost {lost_nodes} layers")));
    }
    if clamped_pixels > 0 {
        log::warn!("{clamped_pixels} pixels have layers brighter than the A-buffer's nodes hold; --float keeps them");
    }
    Ok(())
}

/// How a frame was made, for the file's header: what the arguments say that the rest of the header does not.
#[derive(Serialize)]
pub struct Recipe {
    scene: String,
    camera: String,
    sun: Option<[f32; 4]>,
    environment: f32,
    /// Voxels along a side, where points see through them.
    #[serde(skip_serializing_if = "Option::is_none")]
    voxels: Option<u32>,
    float: bool,
    /// Texels a side.
    #[serde(skip_serializing_if = "Option::is_none")]
    deep_shadows: Option<u32>,
    /// As the command line has it.
    transparency: String,
    /// What it was set to, where it can be: layers kept, samples, number of the weight's equation, samples of the A-buffer.
    #[serde(skip_serializing_if = "Option::is_none")]
    transparency_setting: Option<u32>,
}

impl Recipe {
    /// Of these arguments.
    pub fn new(arguments: &FrameArguments, camera: &Camera, settings: &FrameSettings) -> Self {
        Self {
            scene: arguments.scene.to_string(),
            camera: camera.name.clone(),
            sun: arguments.sun.map(|sun| sun.direction.extend(sun.illuminance).to_array()),
            environment: settings.environment.x,
            voxels: settings.voxels.map(|voxels| voxels.resolution),
            float: arguments.float,
            deep_shadows: arguments.deep_shadows,
            transparency: settings.composited_by().name().replace('_', "-"),
            transparency_setting: (arguments.kept.or(arguments.samples).or(arguments.weight))
                .or(arguments.abuffer_samples.filter(|_| !settings.deep))
                .filter(|_| settings.composited_by() == settings.transparency),
        }
    }
}
