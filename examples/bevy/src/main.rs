//! A ball of measured reflectance under a light or an environment, drawn by Bevy from packs of `brdfc`.

mod frame;
mod pack_material;
mod pack_resources;
mod pack_shader;

use bevy::asset::{AssetPath, UnapprovedPathMode};
use bevy::camera::{Exposure, RenderTarget};
use bevy::core_pipeline::tonemapping::{DebandDither, Tonemapping};
use bevy::light::NotShadowCaster;
use bevy::prelude::*;
use pack_material::{PackMaterial, PackMaterialPlugin, PackSettings};
use std::path::PathBuf;

const USAGE: &str = "\
usage: brdfc-bevy PACK.ktx2 [OPTION...]

Draws a ball from a pack of a BRDF or a flat BTF, or from lobes: in a window (cargo feature 'window'), or one frame to a file.

  --frame OUT.png       write one frame to this file
  --size WIDTHxHEIGHT   size of the frame in pixels, each 1 to 8192 (default: 256x256)
  --samples N           samples per pixel at outlines, 1 or 4 (default: 4)
  --repeat N            tiles of a flat BTF per unit of uv, 1 to 1000 (default: 1)
  --light KIND          point, spot, directional or none (default: point)
  --with PACK.ktx2      another pack of the ball's material, repeatable: lobes and a prefiltered environment
  --intensity X         factor of the environment's radiance, 0 or more (default: 1)
  --background E.ktx2   draw a prefiltered environment behind the ball
";

/// Radiant intensity and position of the light, W/sr. It points at the origin; a directional light is as bright there.
const INTENSITY: f32 = 60.0;
const LIGHT: Vec3 = Vec3::new(-3.0, 3.0, 4.0);
/// The camera of the scene 'sphere' of `brdfc render`; the field of view is vertical, in degrees.
const EYE: Vec3 = Vec3::new(0.0, 0.0, 4.6);
const FIELD_OF_VIEW: f32 = 31.0;
/// Radius of the sphere that shows the background.
const BACKGROUND_RADIUS: f32 = 100.0;

/// Kinds of lights.
#[derive(Debug, Clone, Copy, PartialEq)]
enum LightKind {
    Point,
    Spot,
    Directional,
    None,
}

/// Command-line arguments.
#[derive(Debug, Clone, PartialEq, Resource)]
struct Arguments {
    pack: PathBuf,
    frame: Option<PathBuf>,
    size: UVec2,
    repeat: u32,
    samples: u32,
    light: LightKind,
    with: Vec<PathBuf>,
    intensity: f32,
    background: Option<PathBuf>,
}

impl Arguments {
    /// Parses the arguments; `None` if help is requested.
    fn parse(mut words: impl Iterator<Item = String>) -> Result<Option<Self>, String> {
        let (mut pack, mut frame, mut size) = (None, None, UVec2::splat(256));
        let (mut repeat, mut samples, mut light) = (1, 4, LightKind::Point);
        let (mut with, mut intensity, mut background) = (Vec::new(), 1.0, None);
        while let Some(word) = words.next() {
            let mut value = || words.next().ok_or(format!("{word} needs a value"));
            match word.as_str() {
                "--help" | "-h" => return Ok(None),
                "--frame" => frame = Some(PathBuf::from(value()?)),
                "--with" => with.push(PathBuf::from(value()?)),
                "--background" => background = Some(PathBuf::from(value()?)),
                "--intensity" => {
                    let text = value()?;
                    intensity = text
                        .parse()
                        .ok()
                        .filter(|intensity: &f32| *intensity >= 0.0 && intensity.is_finite())
                        .ok_or(format!("--intensity: found {text}, expected a number, 0 or more"))?;
                }
                "--size" => {
                    let text = value()?;
                    let sides =
                        text.split_once('x').and_then(|(x, y)| Some(UVec2::new(x.parse().ok()?, y.parse().ok()?)));
                    size = sides
                        .filter(|size| size.min_element() > 0 && size.max_element() <= 8192)
                        .ok_or(format!("--size: found {text}, expected WIDTHxHEIGHT, each 1 to 8192"))?;
                }
                "--repeat" => {
                    let text = value()?;
                    repeat = text
                        .parse()
                        .ok()
                        .filter(|repeat| (1..=1000).contains(repeat))
                        .ok_or(format!("--repeat: found {text}, expected 1 to 1000"))?;
                }
                "--samples" => {
                    let text = value()?;
                    samples = text
                        .parse()
                        .ok()
                        .filter(|samples| [1, 4].contains(samples))
                        .ok_or(format!("--samples: found {text}, expected 1 or 4"))?;
                }
                "--light" => {
                    light = match value()?.as_str() {
                        "point" => LightKind::Point,
                        "spot" => LightKind::Spot,
                        "directional" => LightKind::Directional,
                        "none" => LightKind::None,
                        other => {
                            return Err(format!("--light: found {other}, expected point, spot, directional or none"));
                        }
                    };
                }
                _ if word.starts_with('-') => return Err(format!("unknown option {word}")),
                _ if pack.is_none() => pack = Some(PathBuf::from(word)),
                _ => return Err(format!("a second pack: {word}")),
            }
        }
        let pack = pack.ok_or("no pack is given")?;
        Ok(Some(Self { pack, frame, size, repeat, samples, light, with, intensity, background }))
    }
}

fn main() -> AppExit {
    let arguments = match Arguments::parse(std::env::args().skip(1)) {
        Ok(Some(arguments)) => arguments,
        Ok(None) => {
            print!("{USAGE}");
            return AppExit::Success;
        }
        Err(message) => {
            eprint!("error: {message}\n\n{USAGE}");
            return AppExit::from_code(2);
        }
    };
    let mut app = App::new();
    // The pack is given on the command line, not in a folder of assets.
    let assets = AssetPlugin { unapproved_path_mode: UnapprovedPathMode::Allow, ..default() };
    let plugins = DefaultPlugins.set(assets);
    match &arguments.frame {
        Some(_) => {
            app.add_plugins(frame::headless(plugins)).add_plugins(frame::FramePlugin);
        }
        None if cfg!(feature = "window") => {
            app.add_plugins(plugins).add_systems(Update, move_light);
        }
        None => {
            eprintln!("error: this build has no window; build with '--features window', or use '--frame OUT.png'");
            return AppExit::from_code(2);
        }
    }
    app.add_plugins(PackMaterialPlugin)
        .insert_resource(arguments)
        // The background of `brdfc render`.
        .insert_resource(ClearColor(Color::linear_rgb(0.1, 0.1, 0.11)))
        .add_systems(Startup, set_up)
        .run()
}

/// Moves around the ball in a window.
#[derive(Component)]
struct Moving;

/// Adds a ball with the pack, a light and a camera.
fn set_up(
    mut commands: Commands,
    arguments: Res<Arguments>,
    assets: Res<AssetServer>,
    mut meshes: ResMut<Assets<Mesh>>,
    mut images: ResMut<Assets<Image>>,
) -> Result {
    // Anisotropic materials need tangents: along circles of latitude, after the poles of Bevy's ball are turned to top and bottom.
    let ball = Sphere::new(1.0).mesh().uv(144, 72).with_generated_tangents()?;
    let upright = Transform::from_rotation(Quat::from_rotation_x(-std::f32::consts::FRAC_PI_2));
    let path = |path: &PathBuf| std::path::absolute(path).map(AssetPath::from_path_buf);
    let repeat = Vec2::splat(arguments.repeat as f32);
    let packs = arguments.with.iter().map(|pack| Ok(path(pack)?.to_string())).collect::<Result<Vec<String>>>()?;
    let intensity = arguments.intensity;
    let settings = move |settings: &mut PackSettings| {
        settings.repeat = repeat;
        settings.environment_intensity = intensity;
        settings.packs.clone_from(&packs);
    };
    let material: Handle<PackMaterial> = assets.load_builder().with_settings(settings).load(path(&arguments.pack)?);
    commands.spawn((Mesh3d(meshes.add(ball)), MeshMaterial3d(material.clone()), upright));
    let mut awaited = vec![material.untyped()];
    if let Some(environment) = &arguments.background {
        let background: Handle<PackMaterial> = assets
            .load_builder()
            .with_settings(move |settings: &mut PackSettings| settings.environment_intensity = intensity)
            .load(path(environment)?);
        let around = meshes.add(Sphere::new(BACKGROUND_RADIUS).mesh().uv(32, 16));
        commands.spawn((Mesh3d(around), MeshMaterial3d(background.clone()), NotShadowCaster));
        awaited.push(background.untyped());
    }
    commands.insert_resource(frame::Awaited(awaited));

    // Bevy expects the flux over the whole sphere, also for spot lights.
    let (intensity, range) = (4.0 * std::f32::consts::PI * INTENSITY, 1000.0);
    let mut light = commands.spawn((Moving, Transform::from_translation(LIGHT).looking_at(Vec3::ZERO, Vec3::Y)));
    match arguments.light {
        LightKind::Point => light.insert(PointLight { intensity, range, ..default() }),
        LightKind::Spot => {
            light.insert(SpotLight { intensity, range, inner_angle: 0.4, outer_angle: 0.5, ..default() })
        }
        LightKind::Directional => {
            light.insert(DirectionalLight { illuminance: INTENSITY / LIGHT.length_squared(), ..default() })
        }
        LightKind::None => &mut light,
    };

    let msaa = if arguments.samples == 1 { Msaa::Off } else { Msaa::Sample4 };
    let mut camera = commands.spawn((
        Camera3d::default(),
        Projection::from(PerspectiveProjection { fov: FIELD_OF_VIEW.to_radians(), ..default() }),
        Transform::from_translation(EYE).looking_at(Vec3::ZERO, Vec3::Y),
        // Radiance of 1 and above is white.
        Exposure { ev100: -f32::log2(1.2) },
        Tonemapping::None,
        DebandDither::Disabled,
        msaa,
    ));
    if arguments.frame.is_some() {
        let target = images.add(frame::target(arguments.size));
        camera.insert(RenderTarget::from(target.clone()));
        commands.insert_resource(frame::Target(target));
    }
    Ok(())
}

/// Moves the light around once in 10 seconds.
fn move_light(time: Res<Time>, mut lights: Query<&mut Transform, With<Moving>>) {
    let turn = Quat::from_rotation_y(time.elapsed_secs() * std::f32::consts::TAU / 10.0);
    for mut light in &mut lights {
        *light = Transform::from_translation(turn * LIGHT).looking_at(Vec3::ZERO, Vec3::Y);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn parsed(line: &str) -> Result<Option<Arguments>, String> {
        Arguments::parse(line.split_whitespace().map(str::to_owned))
    }

    #[test]
    fn command_lines() {
        let arguments = parsed("red.ktx2 --frame out.png --size 320x240").unwrap().unwrap();
        assert_eq!(arguments.size, UVec2::new(320, 240));
        assert_eq!(arguments.frame, Some("out.png".into()));
        let arguments = parsed("red.ktx2 --with red.lobes.ktx2 --with sky.ktx2 --light none").unwrap().unwrap();
        assert_eq!(arguments.with, [PathBuf::from("red.lobes.ktx2"), "sky.ktx2".into()]);
        assert_eq!(parsed("--help"), Ok(None));
        for (line, said) in [
            ("", "no pack is given"),
            ("a.ktx2 b.ktx2", "a second pack: b.ktx2"),
            ("a.ktx2 --frame", "--frame needs a value"),
            ("a.ktx2 --size 0x5", "--size: found 0x5, expected WIDTHxHEIGHT, each 1 to 8192"),
            ("a.ktx2 --repeat 0", "--repeat: found 0, expected 1 to 1000"),
            ("a.ktx2 --samples 2", "--samples: found 2, expected 1 or 4"),
            ("a.ktx2 --light sun", "--light: found sun, expected point, spot, directional or none"),
            ("a.ktx2 --intensity -1", "--intensity: found -1, expected a number, 0 or more"),
            ("a.ktx2 --fast", "unknown option --fast"),
        ] {
            assert_eq!(parsed(line), Err(said.to_owned()));
        }
    }
}
