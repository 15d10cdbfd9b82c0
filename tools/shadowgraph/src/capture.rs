//! `capture`: renders a frame and writes its layers.

use std::fs;
use std::path::Path;
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread;
use std::time::Instant;

use serde::Serialize;
use shadowgraph::capture::{
    CapturedFrame, Compression, ExrOptions, FrameCapture, Part, PngOptions, auto_exposure, picture, write_deep_exr,
    write_exr, write_png,
};
use shadowgraph::frame::{Frame, Selection};
use shadowgraph::gpu::Gpu;
use shadowgraph::graph::{Executed, Executor, Graph};
use shadowgraph::scene::{Camera, GpuScene};

use crate::cli::CaptureArguments;
use crate::debug;
use crate::failure::{Failure, Result};
use crate::output::{check_name, print};
use crate::phases::{Phases, Start};
use crate::session::{self, Recipe};
use crate::view;

/// Renders and writes.
pub fn run(arguments: &CaptureArguments, start: Start) -> Result<()> {
    let files = [
        ("--output", &arguments.output, ".exr"),
        ("--png", &arguments.png, ".png"),
        ("--deep", &arguments.deep, ".exr"),
    ];
    for (option, path, end) in files {
        path.as_ref().map_or(Ok(()), |path| check_name(option, path, &[end]))?;
    }
    if let (Some(output), Some(deep)) = (&arguments.output, &arguments.deep)
        && output == deep
    {
        let message = format!("--deep {}: this is the file of --output too; give it another name", deep.display());
        return Err(Failure::input(message));
    }
    let mut phases = Phases::new(start);
    // 1. The scene, and the device meanwhile. Where the scene is bad, that is what there is to say.
    let (scene, gpu) = thread::scope(|scope| {
        let device = scope.spawn(|| {
            let began = Instant::now();
            (session::open(&arguments.frame.device), began.elapsed())
        });
        let scene = phases.time("loading", || session::load(&arguments.frame));
        let (gpu, time) = device.join().unwrap_or_else(|panic| std::panic::resume_unwind(panic));
        phases.add("device", time);
        (scene, gpu)
    });
    let scene = scene?;
    let camera = view::camera(&arguments.frame, &scene)?;
    let gpu = gpu?;
    // 2. All that holds on to the device goes before the device.
    let told = phases.time("loading", || scene.upload(&gpu)).map_err(Failure::from);
    let told = told.and_then(|scene| render_and_write(arguments, &gpu, &scene, &camera, &mut phases));
    // 3. Leaks and validation messages are failures too; the first failure is the one to tell.
    let closed = session::close(gpu);
    let told = told?;
    closed?;
    if arguments.phases {
        return print(serde_json::to_string(&phases.report()).map_err(Failure::failed)?);
    }
    told.into_iter().try_for_each(print)
}

/// Gives what there is to tell the user.
fn render_and_write(
    arguments: &CaptureArguments,
    gpu: &Gpu,
    scene: &GpuScene,
    camera: &Camera,
    phases: &mut Phases,
) -> Result<Vec<String>> {
    // 1. Render what is wanted, and the picture where a PNG is.
    let mut wanted = session::frame_settings(&arguments.frame, scene, camera)?;
    wanted.deep = arguments.deep.is_some();
    let mut settings = wanted.clone();
    if let (Some(_), Selection::Only(names)) = (&arguments.png, &mut settings.layers) {
        names.push("color".into());
    }
    let mut executor = Executor::new(gpu);
    executor.serialize(arguments.debug.serialize);
    let change = |graph: &mut Graph| debug::prepare(&arguments.debug, graph);
    let recipe = Recipe::new(&arguments.frame, camera, &wanted);
    let description = FrameCapture {
        scene,
        camera,
        view: &wanted.view,
        caps: gpu.caps(),
        settings: &recipe,
        float: arguments.frame.float,
        exposure: 1.0,
        reproducible: arguments.reproducible,
    };
    // What is there before the frame's end is compressed meanwhile: a core may idle there.
    let ended = AtomicBool::new(false);
    let (rendered, packed) = thread::scope(|scope| {
        let mut packing = None;
        let mut render = |last: bool| {
            session::render(&mut executor, gpu, scene, &settings, change, |frame, captures| {
                if last && arguments.output.is_some() {
                    let parts = description.parts_of(frame, captures);
                    packing = Some(scope.spawn(|| pack(parts?, arguments.compression, &ended)));
                }
            })
        };
        let rendered = match arguments.phases {
            true => render_twice(render, phases),
            false => phases.time("rendering", || render(true)),
        };
        ended.store(true, Ordering::Relaxed);
        (rendered, packing.map(|thread| thread.join().unwrap_or_else(|panic| std::panic::resume_unwind(panic))))
    });
    let (mut frame, executed) = rendered?;
    let packed = packed.transpose()?.unwrap_or_default();
    for warning in &frame.warnings {
        log::warn!("{}: {warning}", arguments.frame.scene);
    }
    // 2. Write the PNG, and meanwhile the rest.
    let size = arguments.frame.size.0;
    let pixels = match &arguments.png {
        Some(_) => phases.time("read-back", || picture(&frame, &executed))?,
        None => Vec::new(),
    };
    frame.layers.retain(|layer| wanted.layers.wants(&layer.name));
    let (mut told, png) = thread::scope(|scope| {
        // Memory of the frame's images goes back meanwhile: captures have their own.
        scope.spawn(move || drop(executor));
        let png = arguments.png.as_ref().map(|path| scope.spawn(|| write_picture(path, size, &pixels)));
        let told = write_layers(arguments, &description, (&frame, &executed, packed), phases);
        let png = png.map(|thread| thread.join().unwrap_or_else(|panic| std::panic::resume_unwind(panic)));
        (told, png.transpose())
    });
    png?;
    if let (Some(path), Ok(told)) = (&arguments.png, &mut told) {
        told.push(format!("wrote {}", path.display()));
    }
    told
}

/// Compresses parts until the frame has ended; those that are written then have all cores.
fn pack(mut parts: Vec<Part>, compression: Compression, ended: &AtomicBool) -> shadowgraph::Result<Vec<Part>> {
    for part in &mut parts {
        part.pack(compression, || !ended.load(Ordering::Relaxed))?;
    }
    Ok(parts)
}

fn write_picture(path: &Path, size: [u32; 2], pixels: &[[f32; 4]]) -> Result<()> {
    let options = PngOptions { exposure: auto_exposure(pixels), ..PngOptions::default() };
    Ok(write_png(path, size, pixels, &options)?)
}

/// Everything but the PNG. Gives what there is to tell the user.
fn write_layers<S: Serialize + Sync>(
    arguments: &CaptureArguments,
    description: &FrameCapture<S>,
    (frame, executed, packed): (&Frame, &Executed, Vec<Part>),
    phases: &mut Phases,
) -> Result<Vec<String>> {
    let mut told = Vec::new();
    if let Some(path) = &arguments.output {
        let mut captured = phases.time("read-back", || description.collect(frame, executed))?;
        for early in packed {
            if let Some(part) = captured.capture.parts.iter_mut().find(|part| part.name == early.name) {
                part.packed = early.packed;
            }
        }
        phases.time("writing", || {
            write_exr(path, &captured.capture, &ExrOptions { compression: arguments.compression })
        })?;
        warn_of_losses(&captured);
        told.push(summary(path, &captured)?);
    }
    if let Some(path) = &arguments.deep {
        let deep = phases.time("read-back", || description.collect_deep(frame, executed))?;
        phases.time("writing", || write_deep_exr(path, &deep))?;
        told.push(format!("wrote {}: {} samples", path.display(), deep.samples.len()));
    }
    if let Some(path) = arguments.output.as_ref().or(arguments.png.as_ref()).or(arguments.deep.as_ref()) {
        told.extend(phases.time("writing", || debug::write(&arguments.debug, executed, path))?);
    }
    Ok(told)
}

/// The driver compiles shaders at their first draw: what the first frame takes more than the second.
/// `render`: whether it is the last time.
fn render_twice<T>(mut render: impl FnMut(bool) -> Result<T>, phases: &mut Phases) -> Result<T> {
    let mut timed = |last| {
        let began = Instant::now();
        render(last).map(|rendered| (began.elapsed(), rendered))
    };
    let (first, _) = timed(false)?;
    let (second, rendered) = timed(true)?;
    phases.add("first-draw compilation", first.saturating_sub(second));
    phases.add("rendering", second);
    Ok(rendered)
}

/// Half-floats that could not hold their value are not lost in silence.
fn warn_of_losses(captured: &CapturedFrame) {
    for (channel, report) in &captured.lost {
        if report.clamped > 0 {
            log::warn!("{channel}: {} pixels exceed 65504 and were clamped; --float keeps them", report.clamped);
        }
        if report.not_a_number > 0 {
            log::warn!("{channel}: {} pixels are not a number", report.not_a_number);
        }
    }
}

fn summary(path: &Path, captured: &CapturedFrame) -> Result<String> {
    let parts = &captured.capture.parts;
    let channels: usize = parts.iter().map(|part| part.channels.len()).sum();
    let bytes = fs::metadata(path).map_err(|error| shadowgraph::Error::io("look at", path, error))?.len();
    let megabytes = bytes as f64 / 1e6;
    Ok(format!("wrote {}: {channels} channels in {} parts, {megabytes:.1} MB", path.display(), parts.len()))
}
