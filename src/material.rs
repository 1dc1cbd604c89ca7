//! Materials: whatever has reflectance.

use crate::{
    Budget, EncodeOptions, Error, Facts, FitLimits, Input, Pack, PackRecipe, Progress, SearchRecipe, Source,
    TableRecipe, WaveletRecipe,
};
use brdfc_jobs::encode::encode;
use brdfc_source::open::{Opened, open as open_input};

/// A material that was opened: a measurement, an analytic model, or a pack.
pub struct Material {
    opened: Opened,
}

/// Opens a file (MERL, a scan, RGL, a pack) or an analytic model such as `synth:ggx?alpha=0.2`. An `OsString` is read as a command
/// line has it: there `-` is standard input.
///
/// # Errors
/// Files that cannot be read ([`ErrorKind::Io`](crate::ErrorKind::Io)) or do not follow their layout, unknown kinds, wrong
/// addresses ([`ErrorKind::Input`](crate::ErrorKind::Input)).
pub fn open(input: impl Into<Input>) -> Result<Material, Error> {
    Ok(Material::new(open_input(input, None)?))
}

/// What a pack may be asked for by: a [`Budget`], [`EncodeOptions`], or a whole recipe.
pub trait PackRequest {
    /// The recipe, and what is asked of the fit to a scan.
    ///
    /// # Errors
    /// Options out of range or that do not go together.
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

    /// A pack within a [`Budget`], by [`EncodeOptions`], or by a whole [`PackRecipe`].
    ///
    /// # Errors
    /// A budget that no pack meets, or an error that says little because the fit to a scan is the weaker part
    /// ([`ErrorKind::Check`](crate::ErrorKind::Check)); options out of range or that do not go together
    /// ([`ErrorKind::Usage`](crate::ErrorKind::Usage)).
    pub fn encode(&self, request: impl PackRequest) -> Result<Pack, Error> {
        let pack = self.encode_closest(request, &())?;
        match pack.missed() {
            Some(missed) => Err(Error::check(missed)),
            None => Ok(pack),
        }
    }

    /// The same, reporting to `progress`; where no pack meets a budget, the best of those that were tried:
    /// [`Pack::missed`] says what it misses.
    ///
    /// # Errors
    /// As [`Self::encode`], and cancellation.
    pub fn encode_closest(&self, request: impl PackRequest, progress: &dyn Progress) -> Result<Pack, Error> {
        let (recipe, fit) = request.resolve()?;
        let encoded = encode(self.source(), &recipe, progress)?;
        Pack::new(encoded, &self.opened, fit, recipe.asked_errors(), progress)
    }

    /// `f_r` and what holds for all of it.
    pub fn source(&self) -> &dyn Source {
        self.opened.source.as_ref()
    }

    /// What kind of input it is, with what is worth knowing about it.
    pub fn facts(&self) -> &Facts {
        &self.opened.facts
    }
}
