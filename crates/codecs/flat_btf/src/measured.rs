//! Flat BTFs from measured images: an ordinary BTF, and a surface that explains its parallax.

use super::light_field::LightField;
use super::texels::TexelMap;
use super::tile_image::TileImage;
use brdfc_formats::direction::Vector;

/// Source of the images of a measured BTF.
pub trait ViewImages: Sync {
    /// Error of reading an image.
    type Error: Send;

    /// Image of a view under a light, of the tile rectified to the plane `z = 0`: radiance over the radiance of a white
    /// diffuser that faces the light.
    ///
    /// # Errors
    /// Returns an error if the image cannot be read.
    fn image(&self, view: usize, light: usize) -> Result<TileImage<3>, Self::Error>;
}

/// Values of texels looked up in images: a texel at `p` appears in the view along `v` where the line through `p` along `v`
/// crosses the plane.
pub struct MeasuredField<'a, I: ?Sized> {
    /// Images by view and light.
    pub images: &'a I,
    /// Surface points of the texels.
    pub texels: &'a TexelMap,
    /// Directions of the views.
    pub views: &'a [Vector],
}

/// A view of a [`MeasuredField`].
pub struct MeasuredView {
    view: usize,
    /// Positions of the texels in the rectified image, in tiles.
    places: Vec<[f64; 2]>,
}

impl<I: ViewImages + ?Sized> LightField for MeasuredField<'_, I> {
    type Error = I::Error;
    type View = MeasuredView;

    fn view(&self, view: usize, texels: Vec<u32>) -> Result<MeasuredView, I::Error> {
        let [x, y, z] = self.views[view];
        let place = |texel: &u32| {
            let p = self.texels.points[*texel as usize].position;
            [p[0] - p[2] * x / z, p[1] - p[2] * y / z]
        };
        Ok(MeasuredView { view, places: texels.iter().map(place).collect() })
    }

    fn values(&self, view: &MeasuredView, light: usize) -> Result<Vec<[f32; 3]>, I::Error> {
        let image = self.images.image(view.view, light)?;
        Ok(view.places.iter().map(|[x, y]| image.at(*x, *y).map(|v| v.max(0.0))).collect())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::light_field::{ComputedField, FlattenedView, Holes, visible};
    use crate::model::MesoModel;
    use crate::rebuild::ViewImage;
    use crate::surface::Appearance;
    use crate::testing::bumps;
    use brdfc_core::address::parse_synth;
    use brdfc_formats::direction::from_polar;

    struct Rendered<'a> {
        model: &'a MesoModel,
        appearance: &'a Appearance,
        directions: &'a [Vector],
        size: usize,
    }

    impl ViewImages for Rendered<'_> {
        type Error = std::convert::Infallible;

        fn image(&self, view: usize, light: usize) -> Result<TileImage<3>, Self::Error> {
            let seen = ViewImage::new(self.model, self.directions[view], self.size, 1);
            let up = seen.direct(self.model, self.appearance, self.directions[light]);
            let pixels = up.chunks_exact(self.size).rev().flatten().copied().collect();
            Ok(TileImage { width: self.size, height: self.size, pixels })
        }
    }

    #[test]
    fn images_of_a_surface_flatten_to_its_reflectance() {
        let model = MesoModel::new(bumps(32, 0.3), 0, &()).unwrap();
        let appearance =
            Appearance { sources: vec![parse_synth("synth:lambert?kd=0.6").unwrap()], ..Default::default() };
        let directions = [from_polar(0.7, 0.5), from_polar(0.3, 2.0)];
        let texels = model.texels(64);
        let [mask, lit] = directions.map(|direction| visible(&texels, &model.caster, direction));
        let both = [mask.clone(), lit];
        let computed = ComputedField::new(&texels, &appearance, &directions, &directions, &both);
        let Ok(truth) = FlattenedView::new(&computed, 0, &mask, Holes::PushPull).unwrap().image(1);
        let images = Rendered { model: &model, appearance: &appearance, directions: &directions, size: 256 };
        let error = |views: [Vector; 2]| {
            let measured = MeasuredField { images: &images, texels: &texels, views: &views };
            let Ok(found) = FlattenedView::new(&measured, 0, &mask, Holes::PushPull).unwrap().image(1);
            let off = |t: usize| f64::from((found[t][0] - truth[t][0]).abs());
            (0..64 * 64).filter(|t| mask[*t]).map(off).sum::<f64>() / (64.0 * 64.0)
        };
        let right = error(directions);
        assert!(right < 0.005, "{right}");
        // The negative control: treated as a view from above, parallax stays in the texels.
        assert!(error([[0.0, 0.0, 1.0]; 2]) > 5.0 * right);
    }
}
