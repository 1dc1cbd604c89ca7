//! Photographs under known lights as one pack that can be relit from any direction: `brdfc pwt`.
//!
//! [`LightInput::open`] reads them, [`make`] makes a polynomial wavelet tree, [`make_map`] a polynomial texture map (.ptm),
//! [`make_surface`] normals and albedo, [`make_web`] a relightable image for web viewers.

pub use brdfc_formats::pwt::LightCoordinates;
pub use brdfc_jobs::pwt::{
    HeldOut, HeldOutViews, HoldOut, LevelReport, LightInput, PwtMade, PwtOptions, PwtReport, SurfaceReport, ViewChoice,
    WebExport, WebReport, albedo_png, any_above_white, make, make_map, make_surface, make_web, make_web_of_map,
    normals_png, recipe_of_map,
};
pub use brdfc_pwt::measure::StackErrors;
pub use brdfc_pwt::normals::SurfaceMaps;
pub use brdfc_pwt::ptm::MapModel;
pub use brdfc_pwt::{DomainName, LightSamples, PwtRecipe, PwtTextureFacts, Target, Views, Wavelet};
pub use brdfc_readers::ptm::Ptm;
pub use brdfc_source::photograph::CodeValues;
pub use brdfc_source::ptm::EXTENSION as PTM;
