//! Materials: whatever has reflectance.

use crate::{Error, Facts, Input, Pack, PackRecipe, Progress, Source};
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

impl Material {
    pub(crate) fn new(opened: Opened) -> Self {
        Self { opened }
    }

    /// A pack within a [`Budget`](crate::Budget), by [`EncodeOptions`](crate::EncodeOptions), or by a whole [`PackRecipe`].
    ///
    /// # Errors
    /// A budget that no pack meets ([`ErrorKind::Check`](crate::ErrorKind::Check)); options out of range or that do not go
    /// together ([`ErrorKind::Usage`](crate::ErrorKind::Usage)).
    pub fn encode<R>(&self, recipe: R) -> Result<Pack, Error>
    where
        R: TryInto<PackRecipe>,
        Error: From<R::Error>,
    {
        let pack = self.encode_closest(recipe, &())?;
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
    pub fn encode_closest<R>(&self, recipe: R, progress: &dyn Progress) -> Result<Pack, Error>
    where
        R: TryInto<PackRecipe>,
        Error: From<R::Error>,
    {
        let encoded = encode(self.source(), &recipe.try_into()?, progress)?;
        Ok(Pack::new(encoded, self.facts()))
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
