//! Tables 1, 2 and 3 in one pass over the views.

use super::PAPER;
use super::apparent::{Apparent, ApparentSizes, summary};
use super::coherency::{ViewVariance, spread, texel_variances};
use super::figures::{ApparentBrdf, apparent_figure, variance_figure};
use super::grids::grid_errors;
use super::illustrations::Illustrations;
use super::reconstruction::{LookUps, row};
use super::rows::{CoherencyRow, ModelRow, StudySettings};
use brdfc_core::address::AddressError;
use brdfc_flat_btf::compact::{ParameterHeights, texels_of_block};
use brdfc_flat_btf::encode::EncodeError;
use brdfc_flat_btf::factored::known;
use brdfc_flat_btf::light_field::{ComputedField, FillGuide, FlattenedView, Holes, from_above, projected, visible};
use brdfc_flat_btf::model::MesoModel;
use brdfc_flat_btf::parameterise::ParameteriseError;
use brdfc_flat_btf::structures::Structure;
use brdfc_flat_btf::surface::{Appearance, SurfacePoint};
use brdfc_flat_btf::texels::texel_surface;
use brdfc_flat_btf::vdim::{MeasuredVdim, OVERSAMPLING};
use brdfc_formats::container::rgb9e5;
use brdfc_formats::direction::Vector;
use brdfc_formats::flat_btf::{FlatBtfDecoder, FlatBtfFile, FlatBtfParts, Relief, Vdim};
use brdfc_render::rendering::Panel;
use rayon::prelude::*;
use std::convert::Infallible;

/// Errors of studying a model.
#[derive(Debug, thiserror::Error)]
pub enum StudyError {
    /// The address is wrong.
    #[error(transparent)]
    Address(#[from] AddressError),
    /// The surface cannot be parameterised.
    #[error(transparent)]
    Parameterise(#[from] ParameteriseError),
    /// The surface cannot be encoded.
    #[error(transparent)]
    Encode(#[from] EncodeError<Infallible>),
}

/// Statistics for one light.
struct PerLight {
    btf: ViewVariance,
    push_pull: ViewVariance,
    poisson: ViewVariance,
    visible: ViewVariance,
}

/// Figures for one structure.
pub struct ModelFigures {
    /// Figure 11: variance over the views of the ordinary BTF, of the flat BTF with holes filled by push-pull, and of its
    /// seen texels; logarithmic.
    pub variance: Panel,
    /// Figures 13 and 14: apparent BRDFs, views by lights, of the ordinary and the flat BTF for a surface point, then for
    /// the same texel of both. Blue where a view does not see the texel.
    pub apparent: Panel,
    /// Figures 3, 4, 6, 7 and 9.
    pub illustrations: Illustrations,
}

impl ModelFigures {
    /// The figures with their names.
    pub fn named(&self) -> [(&'static str, &Panel); 7] {
        let Self { variance, apparent, illustrations: of } = self;
        [
            ("variance", variance),
            ("apparent", apparent),
            ("parameterisation", &of.parameterisation),
            ("holes", &of.holes),
            ("displacements", &of.displacements),
            ("layout", &of.layout),
            ("reconstruction", &of.reconstruction),
        ]
    }
}

/// Studies one structure. Calls `view_done` after each view.
///
/// # Errors
/// Returns an error for a wrong address, or a surface that cannot be parameterised.
pub fn study_model(
    address: &str,
    settings: &StudySettings,
    directions: &[Vector],
    view_done: &(dyn Fn() + Sync),
) -> Result<(ModelRow, ModelFigures), StudyError> {
    let structure = Structure::parse(address)?;
    let appearance = structure.appearance();
    let model = MesoModel::new(structure.mesh(), settings.rounds, &())?;
    let texels = model.texels(settings.flat_texels);
    let masks: Vec<Vec<bool>> = directions.iter().map(|view| visible(&texels, &model.caster, *view)).collect();
    let field = ComputedField::new(&texels, &appearance, directions, directions, &masks);
    let Ok(guide) = FillGuide::new(&field, &masks, &from_above(directions), directions.len());

    let plane = settings.texels * settings.texels;
    let flat = settings.flat_texels * settings.flat_texels;
    let mut lights: Vec<PerLight> = directions
        .iter()
        .map(|_| PerLight {
            btf: ViewVariance::new(plane),
            push_pull: ViewVariance::new(flat),
            poisson: ViewVariance::new(flat),
            visible: ViewVariance::new(flat),
        })
        .collect();
    let (chosen, flat_picks, btf_picks) = picks(&model, settings);
    let (mut flat_apparent, mut btf_apparent) = (Apparent::new(flat_picks), Apparent::new(btf_picks));
    let mut images = Vec::new();
    let files = stored_files(&model, &appearance, settings)?;
    let maps = files.each_ref().map(map_of);
    for (view, direction) in directions.iter().enumerate() {
        let look_ups = LookUps::new(&model, maps, *direction, settings);
        let Ok(push_pull) = FlattenedView::new(&field, view, &masks[view], Holes::PushPull);
        let Ok(poisson) = FlattenedView::new(&field, view, &masks[view], Holes::Poisson(&guide));
        let light = |(light, statistics): (usize, &mut PerLight)| {
            let Ok(filled) = push_pull.image(light).map(packed);
            let Ok(inpainted) = poisson.image(light).map(packed);
            let direct = look_ups.seen.direct(&model, &appearance, directions[light]);
            let differences = look_ups.differences(&direct, &inpainted, &filled);
            statistics.btf.add(&direct, None);
            statistics.push_pull.add(&filled, None);
            statistics.poisson.add(&inpainted, None);
            statistics.visible.add(&inpainted, Some(&masks[view]));
            (differences, flat_apparent.pick(&inpainted), btf_apparent.pick(&direct))
        };
        let done: Vec<_> = lights.par_iter_mut().enumerate().map(light).collect();
        for (differences, flat, btf) in done {
            images.push(differences);
            flat_apparent.add(flat);
            btf_apparent.add(btf);
        }
        view_done();
    }
    let means = |of: fn(&PerLight) -> &ViewVariance| texel_variances(lights.iter().map(of));
    let [btf, push_pull, poisson, visible] =
        [means(|l| &l.btf), means(|l| &l.push_pull), means(|l| &l.poisson), means(|l| &l.visible)];
    let count = directions.len();
    let apparent: ApparentSizes = summary(&flat_apparent.sizes(count), &btf_apparent.sizes(count), chosen);
    let brdfs = (0..chosen).flat_map(|k| {
        let seen = masks.iter().map(|mask| mask[flat_apparent.texel(k)]).collect();
        let flat = ApparentBrdf { values: flat_apparent.values(k).collect(), seen };
        [ApparentBrdf { values: btf_apparent.values(k).collect(), seen: vec![true; count] }, flat]
    });
    let figures = ModelFigures {
        variance: variance_figure([&btf, &push_pull, &visible]),
        apparent: apparent_figure(&brdfs.collect::<Vec<_>>(), count),
        illustrations: Illustrations::new(&model, &appearance, (&files[0], maps[0])),
    };
    let name = structure.info().name;
    let (_, paper_model, paper) =
        PAPER.into_iter().find(|(ours, ..)| *ours == name).expect("every structure is in the table");
    let row = ModelRow {
        model: structure.canonical(),
        paper_model,
        reconstruction: row(&images, directions),
        coherency: CoherencyRow {
            btf: spread(&btf),
            push_pull: spread(&push_pull),
            poisson: spread(&poisson),
            visible: spread(&visible),
        },
        apparent,
        grids: grid_errors(&model)?,
        parameterisation: model.parameterisation.report,
        seen: masks.iter().flatten().filter(|seen| **seen).count() as f64 / (count * flat) as f64,
        paper,
    };
    Ok((row, figures))
}

/// Files with the indirection map and with its compact form, read again, with the reflectance of the materials.
fn stored_files(
    model: &MesoModel,
    appearance: &Appearance,
    settings: &StudySettings,
) -> Result<[FlatBtfDecoder; 2], EncodeError<Infallible>> {
    let header = settings.map_header();
    let measured = MeasuredVdim::new(model, header, OVERSAMPLING, &())?;
    let heights = ParameterHeights::new(model, &header);
    let [map, compact] = [measured.map()?, measured.compact(texels_of_block(header.size), &heights)?];
    let shares = |point: &SurfacePoint| appearance.shares(point);
    let surface = texel_surface(&model.mesh, &model.parameterisation.coordinates, settings.flat_texels, shares);
    let counts = projected(&model.texels(settings.flat_texels), &model.caster);
    let made = known(&appearance.sources, &surface, settings.flat_texels as u32, &counts)?;
    let reflectance = made.expect("structures have at most two materials").asset;
    let stored = |map: Vdim| -> Result<FlatBtfDecoder, EncodeError<Infallible>> {
        let parts = FlatBtfParts::new(Relief::sampled(map, None)?, reflectance.clone());
        let file = FlatBtfFile::new(FlatBtfDecoder::new(parts))?.to_bytes(false);
        Ok(FlatBtfFile::from_bytes(&file)?.decoder)
    };
    Ok([stored(map)?, stored(compact)?])
}

fn map_of(file: &FlatBtfDecoder) -> &Vdim {
    match &file.parts().relief {
        Relief::Vdim(map, _) => map,
        Relief::Layers(_) => unreachable!("a file keeps its form of relief"),
    }
}

/// Texels whose apparent BRDFs are compared: first the paper's two (one surface point in both, then the same texel in
/// both), then a grid over the reference plane with the surface points that are visible there from above.
fn picks(model: &MesoModel, settings: &StudySettings) -> (usize, Vec<usize>, Vec<usize>) {
    let on = |size: usize, at: [f64; 2]| {
        let [x, y] = at.map(|c| ((c.rem_euclid(1.0) * size as f64) as usize).min(size - 1));
        y * size + x
    };
    let up = [0.0, 0.0, 1.0];
    let below = |at: [f64; 2]| on(settings.flat_texels, model.seen(at, up).parameters);
    let first = [0.37, 0.61];
    let mut flat = vec![below(first), on(settings.flat_texels, first)];
    let mut btf = vec![on(settings.texels, first); 2];
    for k in 0..64 {
        let at = [(f64::from(k % 8) + 0.5) / 8.0, (f64::from(k / 8) + 0.5) / 8.0];
        flat.push(below(at));
        btf.push(on(settings.texels, at));
    }
    (2, flat, btf)
}

/// Values as stored in packs.
fn packed(image: Vec<[f32; 3]>) -> Vec<[f32; 3]> {
    image.into_iter().map(|value| rgb9e5::decode(rgb9e5::encode(value))).collect()
}
