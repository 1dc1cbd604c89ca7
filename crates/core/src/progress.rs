//! What long work says of itself, and how it is stopped. Stages know no clock, no terminal and no signal.

/// Declares the stages with what reports call them.
macro_rules! stages {
    ($($stage:ident $name:literal)*) => {
        /// A stage of long work.
        #[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
        #[allow(missing_docs)]
        pub enum Stage {
            $($stage,)*
        }

        impl Stage {
            /// What reports call it.
            pub fn name(self) -> &'static str {
                match self {
                    $(Self::$stage => $name,)*
                }
            }
        }
    };
}

stages! {
    Read "read"
    Symmetry "symmetry"
    Resample "resample"
    Choose "choose nodes"
    Try "try"
    Fit "fit"
    LogEncode "log-encode"
    Smooth "smooth"
    Haar "haar"
    Threshold "threshold"
    Quantise "quantise"
    MeasureOnGrid "measure on the grid"
    MeasureOffGrid "measure off the grid"
    Pack "pack"
    BandwidthMap "bandwidth map"
    ImportanceSamples "importance samples"
    Parameterise "parameterise"
    Indirection "indirection"
    Visibility "visibility"
    Shadows "shadows"
    Bounces "bounces"
    Guide "guide"
    Views "views"
    Images "images"
    Write "write"
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
}

/// Ignores everything.
impl Progress for () {
    fn part<'a>(&'a self, _: &'a str) -> Box<dyn Progress + 'a> {
        Box::new(())
    }
}
