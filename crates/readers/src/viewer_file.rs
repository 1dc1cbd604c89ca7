//! Files that hold a function of the light's direction for each pixel of one view: `.ptm` and `.rti`.

use crate::ptm::Ptm;
use brdfc_formats::pwt::{LightBasis, LightCoordinates};

/// RGB of a pixel in 8-bit levels, not clamped. Its argument is `row * width + column`, rows counted from the top.
pub type Levels<'a> = Box<dyn Fn(usize) -> [f64; 3] + Sync + 'a>;

/// A function of the light's direction for each pixel.
pub trait ViewerFile: Send + Sync {
    /// Width and height, pixels.
    fn size(&self) -> [u32; 2];

    /// Terms of the functions.
    fn basis(&self) -> LightBasis;

    /// The file, if it is a polynomial texture map.
    fn as_polynomials(&self) -> Option<&Ptm> {
        None
    }

    /// Values of all pixels under a light, given as a unit vector above the horizon.
    fn under(&self, light: [f32; 3]) -> Levels<'_>;
}

impl ViewerFile for Ptm {
    fn as_polynomials(&self) -> Option<&Ptm> {
        Some(self)
    }

    fn size(&self) -> [u32; 2] {
        Ptm::size(self)
    }

    fn basis(&self) -> LightBasis {
        LightBasis { coordinates: LightCoordinates::Projected, degree: 2 }
    }

    fn under(&self, [x, y, _]: [f32; 3]) -> Levels<'_> {
        Box::new(move |pixel| Ptm::polynomials(self, pixel, [x, y]))
    }
}
