//! Shaders of pages: WGSL assembled from parts, and its GLSL ES 3.00 translation from `programs.json`.

use super::item::{PHOTOGRAPHS, ViewItem};
use brdfc_formats::PackKind;
use brdfc_formats::environment::ENVIRONMENT_WGSL;
use brdfc_render::flat::cover_wgsl;
use brdfc_shaders::{Program, TranslatedProgram};
use std::collections::BTreeMap;
use std::sync::OnceLock;

/// Parameters of a rendering.
const VIEW_WGSL: &str = include_str!("shaders/view.wgsl");
/// Name of the shader that displays renderings.
const SHOW: &str = "show";

/// A shader of pages, before it is translated.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct PageShader {
    /// Name of the shader on the page.
    pub name: String,
    /// Source of the vertex and the fragment shader.
    pub wgsl: String,
    /// Entry point of the vertex shader.
    pub vertex: &'static str,
    /// Entry point of the fragment shader.
    pub fragment: &'static str,
}

impl PageShader {
    /// File with the GLSL ES 3.00 translations of all shaders. `./scripts/bless` writes it.
    pub const FILE: &str = "crates/jobs/src/view/programs.json";

    /// All shaders of pages.
    pub fn all() -> Vec<Self> {
        let of_kind = |kind: PackKind| {
            let may_be_wide = kind.descriptor().brdf.is_some_and(|shader| shader.may_be_wide);
            [false, true].into_iter().take(1 + usize::from(may_be_wide)).map(move |exact| Self::drawing(kind, exact))
        };
        let drawn = PackKind::ALL.into_iter().filter(|kind| drawing_wgsl(*kind, false).is_some());
        drawn.flat_map(of_kind).chain([Self::photographs(), Self::behind(), Self::showing()]).collect()
    }

    /// The shader that draws a kind of pack. With `exact`, the shader filters instead of a sampler. Each variant is a separate
    /// shader, because drivers compile, and some run, both sides of a branch.
    ///
    /// # Panics
    /// Panics for kinds of packs that pages do not draw.
    pub(super) fn drawing(decoder: PackKind, exact: bool) -> Self {
        let of_kind = drawing_wgsl(decoder, exact).expect("only packs that pages draw become items");
        // Decoders come with what they need: the surfaces that flat BTFs cover, the environment that lights lobes.
        let needed = match decoder {
            PackKind::FlatBtf | PackKind::FlatBtfTrees => cover_wgsl(decoder),
            PackKind::Lobes => ENVIRONMENT_WGSL.to_owned(),
            _ => String::new(),
        };
        let wgsl = assembled(&[&needed, &(decoder.descriptor().wgsl)(), &of_kind]);
        let name = if exact { format!("{}, exact", decoder.name()) } else { decoder.name().to_owned() };
        Self { name, wgsl, vertex: "project", fragment: "shade" }
    }

    /// The shader that draws a material.
    pub(super) fn of_item(item: &ViewItem, exact: bool) -> Self {
        item.decoder().map_or_else(Self::photographs, |decoder| Self::drawing(decoder, exact))
    }

    /// The shader that draws photographs.
    fn photographs() -> Self {
        let photographs = include_str!("shaders/photographs.wgsl");
        let wgsl = assembled(&[photographs, NO_ENVIRONMENT]);
        Self { name: PHOTOGRAPHS.to_owned(), wgsl, vertex: "project", fragment: "shade" }
    }

    /// The shader that draws the environment behind materials.
    pub(super) fn behind() -> Self {
        let behind = include_str!("shaders/behind.wgsl");
        let wgsl = [ENVIRONMENT_WGSL, brdfc_render::camera::CORNER_WGSL, VIEW_WGSL, behind].join("\n");
        Self { name: PackKind::Environment.name().to_owned(), wgsl, vertex: "project", fragment: "shade" }
    }

    /// The shader that displays renderings.
    pub(super) fn showing() -> Self {
        let colours = brdfc_render::rendering::RAMP.map(|rgb| {
            let [r, g, b] = rgb.map(|code| code / 255.0);
            format!("vec3<f32>({r:.6}, {g:.6}, {b:.6})")
        });
        let ramp = format!(
            "const FULL_SCALE: f32 = {:?};\nconst RAMP: array<vec3<f32>, {}> = array<vec3<f32>, {}>({});\n",
            brdfc_render::rendering::DELTA_E_FULL_SCALE,
            colours.len(),
            colours.len(),
            colours.join(", ")
        );
        let wgsl = ramp + include_str!("shaders/show.wgsl");
        Self { name: SHOW.to_owned(), wgsl, vertex: "cover", fragment: "show" }
    }

    /// The shader in both languages.
    pub(super) fn program(&self) -> Program {
        static ALL: OnceLock<BTreeMap<String, TranslatedProgram>> = OnceLock::new();
        let all = ALL.get_or_init(|| serde_json::from_str(include_str!("programs.json")).expect("written by a test"));
        let lacking = || panic!("{} lacks {}: ./scripts/bless", Self::FILE, self.name);
        Program::new(&self.wgsl, all.get(&self.name).unwrap_or_else(lacking))
    }
}

/// WGSL that draws a mesh, after a decoder and the functions of its kind.
fn assembled(of_kind: &[&str]) -> String {
    let (frame, corner) = (brdfc_render::shading_point::SHADING_POINT_WGSL, brdfc_render::camera::CORNER_WGSL);
    [of_kind, &[frame, corner, VIEW_WGSL, include_str!("shaders/shade.wgsl")]].concat().join("\n")
}

/// WGSL that places, evaluates and filters a kind of pack on a page; `None` for kinds that pages do not draw.
fn drawing_wgsl(kind: PackKind, exact: bool) -> Option<String> {
    let brdf = |value: &str, level: &str| {
        format!(
            "fn brdf(wi: vec3<f32>, wo: vec3<f32>, level: f32) -> vec3<f32> {{ return {value}; }}\n\
             fn brdf_level_of_detail(distance: f32) -> f32 {{ return {level}; }}\n{}",
            include_str!("shaders/brdf.wgsl")
        )
    };
    let (by_points, by_environment) = match (kind, kind.descriptor().brdf) {
        (_, Some(shader)) => {
            (brdf(if exact { shader.exact } else { shader.filtered }, shader.level_of_detail), NO_ENVIRONMENT)
        }
        (PackKind::FlatBtf | PackKind::FlatBtfTrees, _) => {
            (include_str!("shaders/flat_btf.wgsl").to_owned(), NO_ENVIRONMENT)
        }
        (PackKind::Pwt, _) => (include_str!("shaders/pwt.wgsl").to_owned(), NO_ENVIRONMENT),
        // Lobes reflect no light of points.
        (PackKind::Lobes, _) => (brdf("vec3<f32>(0.0)", "0.0"), include_str!("shaders/lobes.wgsl")),
        _ => return None,
    };
    Some([&by_points, by_environment].join("\n"))
}

/// WGSL of materials that no environment lights.
const NO_ENVIRONMENT: &str =
    "fn lit_by_environment(frame: mat3x3<f32>, wo: vec3<f32>) -> vec3<f32> { return vec3<f32>(0.0); }";

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn all_kinds_are_in_both_languages() {
        for shader in PageShader::all() {
            let made = shader.program();
            if shader.name == SHOW {
                assert_eq!(made.textures.len(), 3);
                continue;
            }
            assert!(made.textures.iter().all(|texture| texture.group == 1) && !made.textures.is_empty());
            assert!(made.blocks.iter().any(|block| block.group == 0));
        }
    }
}
