//! Images of an ordinary BTF as the flattening asks for them.

use crate::btf::measured::ViewImages;
use crate::btf::tile_image::TileImage;
use crate::source::btf_stack::BtfStack;
use crate::source::open::InputError;

/// Images of a stack.
pub(super) struct StackImages<'a>(pub(super) &'a BtfStack);

impl ViewImages for StackImages<'_> {
    type Error = InputError;

    fn image(&self, view: usize, light: usize) -> Result<TileImage<3>, InputError> {
        let image = self.0.view(view, light)?;
        Ok(TileImage { width: image.width, height: image.height, pixels: image.pixels })
    }
}
