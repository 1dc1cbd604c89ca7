//! Indirection maps of all levels, of halves or compact.

use crate::compact::ParameterHeights;
use crate::model::MesoModel;
use crate::vdim::MeasuredVdim;
use brdfc_core::progress::{Cancelled, Progress};
use brdfc_formats::FormatError;
use brdfc_formats::flat_btf::{Vdim, VdimHeader};

/// Measures all levels of a map, with compact samples if `is_compact`. `progress` receives [`steps`] steps.
///
/// # Errors
/// Returns an error if the header or a number is out of range, or if `progress` cancels.
pub fn indirection<E: From<FormatError> + From<Cancelled>>(
    model: &MesoModel,
    header: VdimHeader,
    oversampling: usize,
    is_compact: bool,
    progress: &dyn Progress,
) -> Result<Vdim, E> {
    header.check()?;
    let heights = is_compact.then(|| ParameterHeights::new(model, &header));
    let of_level = |level| {
        let header = VdimHeader { size: header.side(level), levels: 1, ..header };
        let measured = MeasuredVdim::new(model, header, oversampling, progress)?;
        Ok(match &heights {
            Some(heights) => measured.compact(header.block, heights)?,
            None => measured.map()?,
        })
    };
    let levels = (0..header.levels).map(of_level).collect::<Result<Vec<_>, E>>()?;
    Ok(Vdim::of_levels(levels)?)
}

/// Progress steps of [`indirection`].
pub fn steps(header: &VdimHeader) -> usize {
    (0..header.levels).map(|level| header.side(level) as usize).sum()
}
