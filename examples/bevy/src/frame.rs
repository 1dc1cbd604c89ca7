//! Writes one frame to a file, without a window.

use crate::Arguments;
use bevy::app::{PluginGroupBuilder, ScheduleRunnerPlugin};
use bevy::asset::LoadState;
use bevy::prelude::*;
use bevy::render::render_resource::{PipelineCache, TextureFormat};
use bevy::render::view::screenshot::{Screenshot, ScreenshotCaptured};
use bevy::render::{ExtractSchedule, MainWorld, RenderApp, RenderPlugin};
use bevy::window::{ExitCondition, WindowPlugin};
use std::time::Duration;

/// Frames without pending compilation before the frame is captured: pipelines are requested one frame after their material.
const QUIET_FRAMES: u32 = 10;
/// Timeout.
const MAX_WAIT: Duration = Duration::from_secs(300);

/// The materials that must be loaded before the frame is drawn.
#[derive(Resource)]
pub struct Awaited(pub Vec<UntypedHandle>);

/// Image that the camera draws to.
#[derive(Resource)]
pub struct Target(pub Handle<Image>);

/// Draws one frame, writes it and exits.
pub struct FramePlugin;

impl Plugin for FramePlugin {
    fn build(&self, app: &mut App) {
        app.add_plugins(ScheduleRunnerPlugin::default())
            .init_resource::<Progress>()
            .add_systems(Update, draw_when_ready);
        if let Some(render) = app.get_sub_app_mut(RenderApp) {
            render.add_systems(ExtractSchedule, count_quiet_frames);
        }
    }
}

/// Bevy's plugins without a window.
pub fn headless(plugins: impl PluginGroup) -> PluginGroupBuilder {
    let plugins = plugins
        .set(WindowPlugin { primary_window: None, exit_condition: ExitCondition::DontExit, ..default() })
        .set(RenderPlugin { synchronous_pipeline_compilation: true, ..default() });
    #[cfg(feature = "window")]
    let plugins = plugins.disable::<bevy::winit::WinitPlugin>();
    plugins
}

/// Makes an image for the camera.
pub fn target(size: UVec2) -> Image {
    Image::new_target_texture(size.x, size.y, TextureFormat::Rgba8UnormSrgb, None)
}

#[derive(Resource, Default)]
struct Progress {
    quiet_frames: u32,
    asked: bool,
}

/// Counts frames in which no pipeline waits for its shaders.
fn count_quiet_frames(mut main_world: ResMut<MainWorld>, pipelines: Res<PipelineCache>) {
    let quiet = pipelines.waiting_pipelines().next().is_none();
    if let Some(mut progress) = main_world.get_resource_mut::<Progress>() {
        progress.quiet_frames = if quiet { progress.quiet_frames + 1 } else { 0 };
    }
}

fn draw_when_ready(
    mut commands: Commands,
    mut progress: ResMut<Progress>,
    mut exit: MessageWriter<AppExit>,
    assets: Res<AssetServer>,
    time: Res<Time<Real>>,
    (awaited, target, arguments): (Res<Awaited>, Res<Target>, Res<Arguments>),
) {
    if awaited.0.iter().any(|asset| matches!(assets.load_state(asset), LoadState::Failed(_))) {
        // Bevy has reported the error.
        exit.write(AppExit::error());
    } else if time.elapsed() > MAX_WAIT {
        eprintln!("error: no frame after {} seconds", MAX_WAIT.as_secs());
        exit.write(AppExit::error());
    } else if !awaited.0.iter().all(|asset| assets.is_loaded_with_dependencies(asset)) {
        progress.quiet_frames = 0;
    } else if progress.quiet_frames >= QUIET_FRAMES && !progress.asked {
        progress.asked = true;
        let Some(path) = arguments.frame.clone() else { return };
        let write = move |captured: On<ScreenshotCaptured>, mut exit: MessageWriter<AppExit>| {
            let written = match captured.image.clone().try_into_dynamic() {
                Ok(image) => image.to_rgb8().save(&path).map_err(|error| error.to_string()),
                Err(error) => Err(error.to_string()),
            };
            exit.write(match written {
                Ok(()) => AppExit::Success,
                Err(error) => {
                    eprintln!("error: {}: {error}", path.display());
                    AppExit::error()
                }
            });
        };
        commands.spawn(Screenshot::image(target.0.clone())).observe(write);
    }
}
