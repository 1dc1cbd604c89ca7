//! Images of several views, which are stacked.

use crate::stack::LightSamples;
use crate::views::Views;
use brdfc_formats::FormatError;
use brdfc_readers::pixels::Pixels;
use std::ops::Range;

impl LightSamples {
    /// Number of views, 1 or more.
    pub fn view_count(&self) -> usize {
        self.views.as_ref().map_or(1, Views::len)
    }

    /// Columns and rows of a view.
    pub fn view_size(&self) -> [usize; 2] {
        [self.size[0], self.size[1] / self.view_count()]
    }

    /// Pixels of a view in the image of a light.
    pub fn pixels_of_view(&self, view: usize) -> Range<usize> {
        let [width, height] = self.view_size();
        view * width * height..(view + 1) * width * height
    }

    /// The images of some of several views, in this order.
    ///
    /// # Errors
    /// Returns an error for fewer than two views, and as [`Views::new`].
    ///
    /// # Panics
    /// Panics if a view does not exist.
    pub fn only_views(&self, chosen: &[usize]) -> Result<Self, FormatError> {
        let one = || FormatError::whole("views", "1", "2 or more");
        let views = self.views.as_ref().ok_or_else(one)?.only(chosen)?;
        let [width, height] = self.view_size();
        let parts = |image: &Pixels| image.parts(chosen.iter().map(|view| self.pixels_of_view(*view)));
        let texels = |mask: &Vec<bool>| {
            chosen.iter().flat_map(|view| &mask[self.pixels_of_view(*view)]).copied().collect::<Vec<_>>()
        };
        Ok(Self {
            size: [width, height * chosen.len()],
            lights: self.lights.clone(),
            images: self.images.iter().map(parts).collect(),
            near: None,
            repeats: self.repeats,
            views: Some(views),
            defined: self.defined.as_ref().map(texels),
        })
    }

    /// Checks the number of views.
    pub(crate) fn check_views(&self) -> Result<(), FormatError> {
        let Some(views) = &self.views else { return Ok(()) };
        FormatError::check_range("views", views.len(), 2..=brdfc_formats::pwt::MAX_VIEWS as usize)?;
        let height = self.size[1];
        if !height.is_multiple_of(views.len()) {
            let allowed = format!("a multiple of {}, the number of views", views.len());
            return Err(FormatError::whole("rows of all views", height.to_string(), allowed));
        }
        if self.repeats && self.near.is_none() {
            return Ok(());
        }
        Err(FormatError::whole("images of several views", "no tiles", "tiles under distant lights").problem())
    }
}
