//! Materials: inputs with reflectance.

use crate::{
    Budget, EncodeOptions, Error, Facts, FitLimits, Input, Pack, PackRecipe, Progress, SearchRecipe, Source,
    TableRecipe, WaveletRecipe,
};
use brdfc_jobs::encode::encode;
use brdfc_source::Reading;
use brdfc_source::open::{Opened, open as open_input};

/// An opened material: a measurement, an analytic model, or a pack.
pub struct Material {
    opened: Opened,
}

/// Opens a file (MERL, a scan, RGL, a pack) or an analytic model such as `synth:ggx?alpha=0.2`. An `OsString` is parsed like a
/// command-line argument: `-` is standard input.
///
/// # Errors
/// Returns an error if a file cannot be read ([`ErrorKind::Io`](crate::ErrorKind::Io)), or does not follow its layout, is of an
/// unknown kind, or has an invalid address ([`ErrorKind::Input`](crate::ErrorKind::Input)).
pub fn open(input: impl Into<Input>) -> Result<Material, Error> {
    open_with(input, Reading::default())
}

/// Same as [`open`], with a number of neighbours of fits to a scan, or a level of detail of a pack. Other inputs ignore them.
///
/// # Errors
/// Returns the errors of [`open`], and one for more neighbours than the scan has distinct direction pairs.
pub fn open_with(input: impl Into<Input>, reading: impl Into<Reading>) -> Result<Material, Error> {
    Ok(Material::new(open_input(input, reading)?))
}

/// Request for a pack: a [`Budget`], [`EncodeOptions`], or a complete recipe.
pub trait PackRequest {
    /// Resolves the recipe, and the limits of the fit to a scan.
    ///
    /// # Errors
    /// Returns an error if options are out of range or cannot be combined.
    fn resolve(self) -> Result<(PackRecipe, FitLimits), Error>;
}

macro_rules! requests {
    ($($request:ty)*) => {
        $(impl PackRequest for $request {
            fn resolve(self) -> Result<(PackRecipe, FitLimits), Error> {
                Ok((self.try_into()?, FitLimits::default()))
            }
        })*
    };
}

requests!(Budget PackRecipe SearchRecipe TableRecipe WaveletRecipe);

impl PackRequest for EncodeOptions {
    fn resolve(self) -> Result<(PackRecipe, FitLimits), Error> {
        let fit = self.fit_limits()?;
        Ok((self.try_into()?, fit))
    }
}

impl PackRequest for (PackRecipe, FitLimits) {
    fn resolve(self) -> Result<(PackRecipe, FitLimits), Error> {
        Ok(self)
    }
}

impl Material {
    pub(crate) fn new(opened: Opened) -> Self {
        Self { opened }
    }

    /// Encodes a pack within a [`Budget`], with [`EncodeOptions`], or with a complete [`PackRecipe`].
    ///
    /// # Errors
    /// Returns an error if no pack meets the limits, or if the fit to a scan dominates the error
    /// ([`ErrorKind::Check`](crate::ErrorKind::Check)), and if options are out of range or cannot be combined
    /// ([`ErrorKind::Usage`](crate::ErrorKind::Usage)).
    pub fn encode(&self, request: impl PackRequest) -> Result<Pack, Error> {
        let pack = self.encode_closest(request, &())?;
        match pack.missed_error() {
            Some(missed) => Err(missed),
            None => Ok(pack),
        }
    }

    /// Encodes like [`Self::encode`] and reports to `progress`. If no pack meets the limits, it returns the best candidate;
    /// [`Pack::missed`] describes what it misses.
    ///
    /// # Errors
    /// Returns the other errors of [`Self::encode`], and cancellation.
    pub fn encode_closest(&self, request: impl PackRequest, progress: &dyn Progress) -> Result<Pack, Error> {
        let (recipe, fit) = request.resolve()?;
        let encoded = encode(self.source(), &recipe, progress)?;
        Pack::new(encoded, &self.opened, fit, recipe.asked_errors(), progress)
    }

    /// Returns `f_r` and its global properties.
    pub fn source(&self) -> &dyn Source {
        self.opened.source.as_ref()
    }

    /// Returns the kind of input, with facts about it.
    pub fn facts(&self) -> &Facts {
        &self.opened.facts
    }
}
