//! Environment of a page.

use super::item::DEFAULT_SCENE;
use crate::environment::prefilter_image;
use crate::error::Error;
use brdfc_core::progress::Progress;
use brdfc_core::words::bytes;
use brdfc_formats::environment::EnvironmentPack;

/// A prefiltered environment, which lights all packs of lobes of a page.
#[derive(Debug, Clone)]
pub struct ViewEnvironment {
    /// Name of the environment on the page.
    pub name: String,
    /// The cube map.
    pub pack: EnvironmentPack,
}

impl ViewEnvironment {
    /// The sky of the page's scenes, which is also that of `brdfc render`.
    ///
    /// # Errors
    /// Returns an error if cancelled.
    pub fn sky(progress: &dyn Progress) -> Result<Self, Error> {
        let pack = prefilter_image(&DEFAULT_SCENE.scene().environment, None, progress)?;
        Ok(Self { name: "the default sky".to_owned(), pack })
    }

    /// Description in one line.
    pub(super) fn facts(&self) -> String {
        let side = self.pack.header().side;
        format!("lights the lobes: 6 faces of {side} x {side} texels, {} on a GPU", bytes(self.pack.gpu_bytes()))
    }
}
