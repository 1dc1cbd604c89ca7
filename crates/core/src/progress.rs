//! What long work says of itself, and how it is stopped. Stages know no clock, no terminal and no signal.

/// A stage of long work.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[allow(missing_docs)]
pub enum Stage {
    Read,
    Symmetry,
    Resample,
    Choose,
    Try,
    Fit,
    LogEncode,
    Smooth,
    Haar,
    Threshold,
    Quantise,
    MeasureOnGrid,
    MeasureOffGrid,
    Pack,
    BandwidthMap,
    ImportanceSamples,
    Parameterise,
    Indirection,
    Visibility,
    Shadows,
    Bounces,
    Guide,
    Views,
    Images,
    CrossValidate,
    Write,
    Verify,
}

impl Stage {
    /// What reports call it.
    pub fn name(self) -> &'static str {
        match self {
            Self::Read => "read",
            Self::Symmetry => "symmetry",
            Self::Resample => "resample",
            Self::Choose => "choose nodes",
            Self::Try => "try",
            Self::Fit => "fit",
            Self::LogEncode => "log-encode",
            Self::Smooth => "smooth",
            Self::Haar => "haar",
            Self::Threshold => "threshold",
            Self::Quantise => "quantise",
            Self::MeasureOnGrid => "measure on the grid",
            Self::MeasureOffGrid => "measure off the grid",
            Self::Pack => "pack",
            Self::BandwidthMap => "bandwidth map",
            Self::ImportanceSamples => "importance samples",
            Self::Parameterise => "parameterise",
            Self::Indirection => "indirection",
            Self::Visibility => "visibility",
            Self::Shadows => "shadows",
            Self::Bounces => "bounces",
            Self::Guide => "guide",
            Self::Views => "views",
            Self::Images => "images",
            Self::CrossValidate => "cross-validate",
            Self::Write => "write",
            Self::Verify => "verify",
        }
    }
}

/// The work was stopped by whoever asked for it.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
#[error("cancelled")]
pub struct Cancelled;

/// Hears of the progress of long work and may stop it. Calls may come from several threads.
pub trait Progress: Sync {
    /// Whether to carry on.
    ///
    /// # Errors
    /// When the work is to stop; so for all methods.
    fn check(&self) -> Result<(), Cancelled> {
        Ok(())
    }

    /// A stage of so many steps starts; the one before it is done.
    fn stage(&self, _stage: Stage, _steps: usize) -> Result<(), Cancelled> {
        self.check()
    }

    /// A step of the stage is done.
    fn step(&self) -> Result<(), Cancelled> {
        self.check()
    }

    /// The progress of a named part of the work, such as one of several materials: `Box::new(self)` where parts are nothing of their
    /// own.
    fn part<'a>(&'a self, name: &'a str) -> Box<dyn Progress + 'a>;

    /// The work is finished, and whether it succeeded.
    fn finished(&self, _succeeded: bool) {}

    /// The work has waited for a while for this, such as another process. Called once, before any part begins or after all ended.
    fn waits(&self, _for_what: &str) {}
}

/// So that whoever hears of the whole can hear of its parts, too.
impl<P: Progress + ?Sized> Progress for &P {
    fn check(&self) -> Result<(), Cancelled> {
        (**self).check()
    }

    fn stage(&self, stage: Stage, steps: usize) -> Result<(), Cancelled> {
        (**self).stage(stage, steps)
    }

    fn step(&self) -> Result<(), Cancelled> {
        (**self).step()
    }

    fn part<'a>(&'a self, name: &'a str) -> Box<dyn Progress + 'a> {
        (**self).part(name)
    }

    fn finished(&self, succeeded: bool) {
        (**self).finished(succeeded);
    }

    fn waits(&self, for_what: &str) {
        (**self).waits(for_what);
    }
}

/// Ignores everything.
impl Progress for () {
    fn part<'a>(&'a self, _: &'a str) -> Box<dyn Progress + 'a> {
        Box::new(())
    }
}
