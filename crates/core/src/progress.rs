//! Progress and cancellation of long work. Stages know no clock, no terminal and no signal.

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
    Haar,
    Threshold,
    Quantise,
    MeasureOnGrid,
    MeasureOffGrid,
    Pack,
    BandwidthMap,
    ImportanceSamples,
    Parameterise,
    Layers,
    Indirections,
    Visibility,
    Shadows,
    Bounces,
    Guide,
    Views,
    Images,
    CrossValidate,
    Write,
    Verify,
    Prefilter,
    Lobes,
}

impl Stage {
    /// Name of the stage in progress lines and in the times of reports.
    pub fn name(self) -> &'static str {
        match self {
            Self::Read => "read",
            Self::Symmetry => "symmetry",
            Self::Resample => "resample",
            Self::Choose => "choose nodes",
            Self::Try => "try",
            Self::Fit => "fit",
            Self::LogEncode => "log-encode",
            Self::Haar => "haar",
            Self::Threshold => "threshold",
            Self::Quantise => "quantise",
            Self::MeasureOnGrid => "measure on the grid",
            Self::MeasureOffGrid => "measure at test directions",
            Self::Pack => "pack",
            Self::BandwidthMap => "bandwidth map",
            Self::ImportanceSamples => "importance samples",
            Self::Parameterise => "parameterise",
            Self::Layers => "layers",
            Self::Indirections => "indirections",
            Self::Visibility => "visibility",
            Self::Shadows => "shadows",
            Self::Bounces => "bounces",
            Self::Guide => "guide",
            Self::Views => "views",
            Self::Images => "images",
            Self::CrossValidate => "cross-validate",
            Self::Write => "write",
            Self::Verify => "verify",
            Self::Prefilter => "prefilter",
            Self::Lobes => "fit lobes",
        }
    }
}

/// Error of cancelled work.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
#[error("cancelled")]
pub struct Cancelled;

/// Observer of long work, which may cancel it. Calls may come from several threads.
pub trait Progress: Sync {
    /// Checks for cancellation.
    ///
    /// # Errors
    /// Returns an error if the work is cancelled, as all methods of this trait do.
    fn check(&self) -> Result<(), Cancelled> {
        Ok(())
    }

    /// Starts a stage of `steps` steps; the previous stage is done.
    fn stage(&self, _stage: Stage, _steps: usize) -> Result<(), Cancelled> {
        self.check()
    }

    /// Completes a step of the stage.
    fn step(&self) -> Result<(), Cancelled> {
        self.check()
    }

    /// Progress of a named part of the work, such as one of several materials. Observers without separate parts return
    /// `Box::new(self)`.
    fn part<'a>(&'a self, name: &'a str) -> Box<dyn Progress + 'a>;

    /// Ends the work; `succeeded` is its outcome.
    fn finished(&self, _succeeded: bool) {}

    /// Reports a cause for which the work has waited for a while, such as another process. Called once, before any part
    /// begins or after all parts ended.
    fn waits(&self, _for_what: &str) {}
}

/// Lets an observer of the whole work observe its parts, too.
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

/// Ignores all events.
impl Progress for () {
    fn part<'a>(&'a self, _: &'a str) -> Box<dyn Progress + 'a> {
        Box::new(())
    }
}
