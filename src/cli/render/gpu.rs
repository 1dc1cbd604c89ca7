//! Graphics adapter, and the interpolation in its shaders.

use super::arguments::Arguments;
use super::materials::Subject;
use crate::Error;
use brdfc::render::{AdapterChoice, DEFAULT_DISTANCE_SCALE, Decoding, Filter, Gpu, SliceFilter};

pub(super) fn open(arguments: &Arguments) -> Result<Gpu, Error> {
    let choice = arguments.adapter.clone().map_or(AdapterChoice::Best, AdapterChoice::Named);
    Ok(Gpu::open(&choice)?)
}

pub(super) fn decoding(arguments: &Arguments, subject: &Subject) -> Decoding {
    Decoding {
        filter: arguments.filter.unwrap_or(Filter::Bilinear),
        slices: if arguments.exact { SliceFilter::Exact } else { SliceFilter::Hardware },
        level: arguments.lod,
        distance_scale: subject.distance_scale().unwrap_or(DEFAULT_DISTANCE_SCALE),
    }
}
