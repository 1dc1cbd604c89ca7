//! Images of an ordinary BTF as the flattening asks for them.

use brdfc_flat_btf::measured::ViewImages;
use brdfc_flat_btf::tile_image::TileImage;
use brdfc_source::InputError;
use brdfc_source::ordinary_btf::OrdinaryBtf;

/// Images of a folder, or those that a file's matrices give.
pub(super) struct StackImages<'a>(pub(super) &'a OrdinaryBtf);

impl ViewImages for StackImages<'_> {
    type Error = InputError;

    fn image(&self, view: usize, light: usize) -> Result<TileImage<3>, InputError> {
        let image = self.0.image(view, light)?;
        Ok(TileImage { width: image.width, height: image.height, pixels: image.pixels })
    }
}
