//! How a flat BTF is stored: each part a file of its own.

use super::error::FlattenError;
use super::parts::Parts;
use super::scratch::FolderScratch;
use brdfc_core::progress::{Progress, Stage};
use brdfc_flat_btf::encode::{FlatBtfEncoded, ScratchViews};
use brdfc_formats::container::Extent;
use brdfc_formats::flat_btf::factored::FactoredFlatBtf;
use brdfc_formats::flat_btf::{FlatPart, Indirection, view_part};
use rayon::prelude::*;

/// Adds the files of all parts; `zip`: compressed with Zstandard.
///
/// # Errors
/// Files that cannot be written, scratch storage that cannot be read; when the work is stopped.
pub(super) fn add_parts(
    encoded: &FlatBtfEncoded,
    scratch: &FolderScratch,
    zip: bool,
    files: &mut Parts<'_>,
    progress: &dyn Progress,
) -> Result<(), FlattenError> {
    let square = |size: u32| Extent::D2([size, size]);
    let (parts, position, mask) = (&encoded.parts, &encoded.position, &encoded.mask);
    let (reference, normal, diffuse) = (&parts.reference, &parts.normal, &parts.diffuse);
    files.add(FlatPart::Position.name(), &position.to_bytes(zip), square(position.size()), 1)?;
    files.add(FlatPart::Normal.name(), &normal.to_bytes(zip), square(normal.size()), 1)?;
    files.add(FlatPart::Reference.name(), &reference.to_bytes(zip), square(reference.size()), 1)?;
    files.add(FlatPart::Diffuse.name(), &diffuse.to_bytes(zip), square(diffuse.size()), 1)?;
    let layers = Extent::D2Array([mask.size(), mask.size(), mask.views()]);
    files.add(FlatPart::Mask.name(), &mask.to_bytes(zip), layers, 1)?;
    match &parts.indirection {
        Indirection::Samples(map) => {
            files.add(FlatPart::Indirection.name(), &map.to_bytes(zip), Extent::D2(map.header().extent()), 1)?;
        }
        Indirection::Compact(map) => {
            files.add_sized(FlatPart::Displacement.name(), &map.to_bytes(zip), map.gpu_bytes())?;
        }
    }
    if let Some(directions) = &encoded.directions {
        let extent = Extent::D2(directions.extent());
        files.add(FlatPart::Directions.name(), &directions.to_bytes(zip), extent, 1)?;
    }
    if let Some(asset) = parts.values.factored() {
        add_factors(asset, zip, files)?;
    }
    encoded.views.as_ref().map_or(Ok(()), |views| add_views(views, scratch, zip, files, progress))
}

fn add_factors(asset: &FactoredFlatBtf, zip: bool, files: &mut Parts<'_>) -> Result<(), FlattenError> {
    let header = asset.header();
    files.add(FlatPart::Basis.name(), &asset.basis().to_bytes(zip), Extent::D2(header.basis_extent()), 1)?;
    let weights = asset.weights().to_bytes(zip);
    files.add(FlatPart::Weights.name(), &weights, header.weights_extent(), header.levels)?;
    if let Some(shadow) = asset.shadow() {
        files.add(FlatPart::Shadow.name(), &shadow.to_bytes(zip), header.shadow_extent(), header.levels)?;
    }
    Ok(())
}

/// One file for each view, as many views in memory as there are threads.
fn add_views(
    views: &ScratchViews,
    scratch: &FolderScratch,
    zip: bool,
    files: &mut Parts<'_>,
    progress: &dyn Progress,
) -> Result<(), FlattenError> {
    let numbers: Vec<u32> = (0..views.count()).collect();
    progress.stage(Stage::Write, numbers.len())?;
    for batch in numbers.chunks(rayon::current_num_threads()) {
        let read = |number: &u32| {
            let view = views.read(*number, scratch)?;
            let ([width, lights], bytes) =
                ([view.header().size, view.header().lights.len() as u32], view.to_bytes(zip));
            Ok((Extent::D2Array([width, width, lights]), bytes))
        };
        let read: Vec<_> = batch.par_iter().map(read).collect::<Result<_, FlattenError>>()?;
        for (number, (extent, bytes)) in batch.iter().zip(read) {
            files.add(&view_part(*number, views.count()), &bytes, extent, 1)?;
            progress.step()?;
        }
    }
    Ok(())
}
