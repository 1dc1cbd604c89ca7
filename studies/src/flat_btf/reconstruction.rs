//! Table 1: images rebuilt by equation 1, compared with images of the surface.

use super::rows::{AngleErrors, ImageErrors, ReconstructionRow, StudySettings};
use brdfc_flat_btf::model::MesoModel;
use brdfc_flat_btf::rebuild::{ViewImage, sample_bilinear};
use brdfc_flat_btf::vdim::{OVERSAMPLING, seen_through_texels};
use brdfc_formats::direction::Vector;
use brdfc_formats::flat_btf::Vdim;
use brdfc_metrics::lab::{distance_squared, lab};
use std::collections::BTreeMap;

/// Surface points visible through the texels of the plane in one view, and the places at which the flat BTF is looked
/// up for it.
pub(super) struct LookUps {
    pub(super) seen: ViewImage,
    blended: Vec<[f32; 2]>,
    compact: Vec<[f32; 2]>,
    unblended: Vec<[f32; 2]>,
}

impl LookUps {
    /// Look-ups of one view.
    pub(super) fn new(model: &MesoModel, maps: [&Vdim; 2], view: Vector, settings: &StudySettings) -> Self {
        let [blended, compact] = maps.map(|map| map.parameters(view.map(|c| c as f32)));
        Self {
            seen: ViewImage::new(model, view, settings.texels, settings.oversampling),
            blended,
            compact,
            unblended: seen_through_texels(model, view, settings.texels, OVERSAMPLING),
        }
    }

    /// Differences of the images of the view under one light: `direct` is the image of the surface, `inpainted` and
    /// `filled` are the flat images with holes filled by Poisson inpainting and by push-pull.
    pub(super) fn differences(
        &self,
        direct: &[[f32; 3]],
        inpainted: &[[f32; 3]],
        filled: &[[f32; 3]],
    ) -> ImageDifferences {
        let direct: Vec<[f32; 3]> = direct.iter().map(|value| lab(*value)).collect();
        let of = |rebuilt: Vec<[f32; 3]>| Difference::new(&direct, &rebuilt);
        ImageDifferences {
            through_map: of(sample_bilinear(inpainted, &self.blended)),
            compact: of(sample_bilinear(inpainted, &self.compact)),
            push_pull: of(sample_bilinear(filled, &self.blended)),
            unblended: of(sample_bilinear(inpainted, &self.unblended)),
            exact_rays: of(self.seen.rebuilt(inpainted)),
        }
    }
}

/// Difference of one image.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Difference {
    pub(super) mean: f64,
    max: f64,
}

impl Difference {
    /// Compares with `direct`, which is in L\*a\*b\*.
    fn new(direct: &[[f32; 3]], rebuilt: &[[f32; 3]]) -> Self {
        let (mut sum, mut max) = (0.0, 0.0f32);
        for (direct, rebuilt) in direct.iter().zip(rebuilt) {
            let difference = distance_squared(*direct, lab(*rebuilt)).sqrt();
            sum += f64::from(difference);
            max = max.max(difference);
        }
        Self { mean: sum / direct.len() as f64, max: f64::from(max) }
    }
}

/// Differences of one image, by look-up of the flat BTF and method of filling its holes.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct ImageDifferences {
    pub(super) through_map: Difference,
    compact: Difference,
    push_pull: Difference,
    unblended: Difference,
    pub(super) exact_rays: Difference,
}

/// The row of images that are added view by view, the same number for each view.
pub(super) fn row(images: &[ImageDifferences], views: &[Vector]) -> ReconstructionRow {
    let per_view = images.len() / views.len();
    let mut rings: BTreeMap<i32, Vec<usize>> = BTreeMap::new();
    for (view, direction) in views.iter().enumerate() {
        rings.entry((polar(*direction) / RING).round() as i32).or_default().push(view);
    }
    let ring = |views_of_ring: &Vec<usize>| {
        let of_views = |of: fn(&ImageDifferences) -> f64| {
            let images = views_of_ring.iter().flat_map(|view| &images[view * per_view..][..per_view]);
            mean(images.map(of))
        };
        AngleErrors {
            polar_angle: (mean(views_of_ring.iter().map(|view| polar(views[*view]))) * 1e3).round() / 1e3,
            views: views_of_ring.len(),
            through_map: of_views(|image| image.through_map.mean),
            unblended: of_views(|image| image.unblended.mean),
            exact_rays: of_views(|image| image.exact_rays.mean),
        }
    };
    ReconstructionRow {
        through_map: errors(images.iter().map(|image| image.through_map)),
        exact_rays: errors(images.iter().map(|image| image.exact_rays)),
        mean_compact: mean(images.iter().map(|image| image.compact.mean)),
        mean_push_pull: mean(images.iter().map(|image| image.push_pull.mean)),
        mean_unblended: mean(images.iter().map(|image| image.unblended.mean)),
        angles: rings.values().map(ring).collect(),
    }
}

/// Width in degrees of the bands of polar angles that have rows.
const RING: f64 = 5.0;

fn polar(direction: Vector) -> f64 {
    direction[0].hypot(direction[1]).atan2(direction[2]).to_degrees()
}

fn errors(images: impl Iterator<Item = Difference> + Clone) -> ImageErrors {
    let all = mean(images.clone().map(|image| image.mean));
    ImageErrors {
        mean: all,
        largest_image: images.clone().map(|image| image.mean).fold(0.0, f64::max),
        image_variance: mean(images.clone().map(|image| (image.mean - all).powi(2))),
        largest_texel: images.map(|image| image.max).fold(0.0, f64::max),
    }
}

fn mean(values: impl Iterator<Item = f64>) -> f64 {
    let (sum, count) = values.fold((0.0, 0u32), |(sum, count), value| (sum + value, count + 1));
    sum / f64::from(count.max(1))
}

#[cfg(test)]
mod tests {
    use super::*;
    use brdfc_flat_btf::light_field::{ComputedField, FlattenedView, Holes, visible};
    use brdfc_flat_btf::structures::Structure;
    use brdfc_flat_btf::surface::Appearance;
    use brdfc_flat_btf::vdim::MeasuredVdim;
    use brdfc_formats::direction::from_polar;
    use brdfc_formats::flat_btf::SeenPoint;

    fn settings(texels: usize, flat_texels: usize) -> StudySettings {
        StudySettings {
            texels,
            flat_texels,
            oversampling: 1,
            indirection: [8, 13],
            largest_angle: 80.0,
            rounds: 0,
            directions: String::new(),
            count: 1,
        }
    }

    struct Case {
        model: MesoModel,
        appearance: Appearance,
        settings: StudySettings,
        map: Vdim,
    }

    impl Case {
        fn new(address: &str, settings: StudySettings) -> Self {
            let structure = Structure::parse(address).unwrap();
            let model = MesoModel::new(structure.mesh(), 0, &()).unwrap();
            let map = MeasuredVdim::new(&model, settings.map_header(), OVERSAMPLING, &()).unwrap().map().unwrap();
            Self { model, appearance: structure.appearance(), settings, map }
        }

        /// Differences of one view and light through `map`.
        fn differences(&self, map: &Vdim, view: Vector) -> ImageDifferences {
            let (views, lights) = ([view], [from_polar(0.5, 2.0)]);
            let texels = self.model.texels(self.settings.flat_texels);
            let lit = [visible(&texels, &self.model.caster, lights[0])];
            let field = ComputedField::new(&texels, &self.appearance, &views, &lights, &lit);
            let mask = visible(&texels, &self.model.caster, view);
            let Ok(flat) = FlattenedView::new(&field, 0, &mask, Holes::PushPull).unwrap().image(0);
            let look_ups = LookUps::new(&self.model, [map, map], view, &self.settings);
            let direct = look_ups.seen.direct(&self.model, &self.appearance, lights[0]);
            look_ups.differences(&direct, &flat, &flat)
        }
    }

    /// Means through the map and by exact rays.
    fn means(found: ImageDifferences) -> [f64; 2] {
        [found.through_map.mean, found.exact_rays.mean]
    }

    #[test]
    fn a_plane_is_rebuilt_by_rays_and_through_its_map() {
        // The same number of texels: each texel of the plane is one of the flat BTF.
        let case = Case::new("knit?resolution=32&height=0", settings(16, 16));
        for view in [from_polar(0.0, 0.0), from_polar(0.7, 1.0), from_polar(1.3, 4.0)] {
            let found = means(case.differences(&case.map, view));
            assert!(found.iter().all(|mean| *mean < 0.01), "{found:?}");
        }
        // Half as many texels: both methods lose the detail between them.
        let coarse = Case::new("knit?resolution=32&height=0", settings(16, 8));
        let found = means(coarse.differences(&coarse.map, from_polar(0.7, 1.0)));
        assert!(found[0] > 0.1 && (found[0] - found[1]).abs() < 0.01, "{found:?}");
    }

    #[test]
    fn errors_of_a_map_affect_only_look_ups_through_it() {
        let case = Case::new("folds?resolution=48", settings(32, 64));
        let view = from_polar(0.8, 0.6);
        let good = case.differences(&case.map, view);
        let (map, header) = (&case.map, *case.map.header());
        let references = |moved: f32| -> Vec<[f32; 2]> {
            let reference = |at: u32| map.reference([at % header.size, at / header.size], 0);
            (0..header.size * header.size).map(|at| [reference(at)[0] + moved, reference(at)[1]]).collect()
        };
        let stored = |texel: [u32; 2], k, a| {
            let [polar, azimuth] = header.view_angles(k, a);
            let centre = texel.map(|at| (at as f32 + 0.5) / header.size as f32);
            let (seen, height) = map.seen(centre, from_polar(polar, azimuth).map(|c| c as f32), 0.0);
            let reference = map.reference(texel, 0);
            SeenPoint { displacement: [0, 1].map(|c| seen[c] - centre[c] - reference[c]), height }
        };
        let shifted = Vdim::of_views(header, references(0.2), stored).unwrap();
        let nearby = |_, _, _| SeenPoint { displacement: [0.0; 2], height: 0.0 };
        let without_distances = Vdim::of_views(header, references(0.0), nearby).unwrap();
        for wrong in [shifted, without_distances] {
            let bad = case.differences(&wrong, view);
            assert!(bad.through_map.mean > 2.0 * good.through_map.mean, "{bad:?} {good:?}");
            assert_eq!([bad.exact_rays, bad.unblended], [good.exact_rays, good.unblended]);
        }
    }

    #[test]
    fn from_above_the_map_agrees_with_rays() {
        let case = Case::new("knit?resolution=48", settings(32, 64));
        // The share of texels at which the two differ by less than a texel of the map; the rest are edges.
        let close = |case: &Case, view: Vector, through: Vector| {
            let size = case.settings.texels;
            let blended = case.map.parameters(through.map(|c| c as f32));
            let is_close = |texel: &usize| {
                let at = [texel % size, texel / size].map(|c| (c as f64 + 0.5) / size as f64);
                let real = case.model.seen(at, view).parameters;
                let off = [0, 1].map(|k| real[k] - f64::from(blended[*texel][k]));
                let off = off.map(|c| (c - c.round()) * size as f64);
                off[0].hypot(off[1]) < 1.0
            };
            (0..size * size).filter(is_close).count() as f64 / (size * size) as f64
        };
        let (above, side) = (from_polar(0.0, 0.0), from_polar(1.3, 0.4));
        assert!(close(&case, above, above) > 0.95, "{}", close(&case, above, above));
        // The control, with a taller relief: the map is evaluated for another view.
        let folds = Case::new("folds?resolution=48", settings(32, 64));
        let shares = [close(&folds, above, above), close(&folds, above, side)];
        assert!(shares[1] < 0.6 * shares[0], "{shares:?}");
        let [through_map, exact] = means(case.differences(&case.map, above));
        assert!((through_map - exact).abs() < 0.5, "{through_map} {exact}");
        // In oblique views, blending the views of a map loses detail that rays see.
        let [through_map, exact] = means(folds.differences(&folds.map, side));
        assert!(through_map > 2.0 * exact, "{through_map} {exact}");
    }

    #[test]
    fn rows_are_of_views_with_about_the_same_polar_angle() {
        let polar = [0.0f64, 14.8, 15.2, 75.0];
        let views = polar.map(|p| from_polar(p.to_radians(), 1.0));
        let of = |mean: f64| Difference { mean, max: 10.0 * mean };
        let images: Vec<ImageDifferences> = (0..8)
            .map(|k| {
                let through_map = of(f64::from(k));
                ImageDifferences {
                    through_map,
                    compact: of(3.0),
                    push_pull: of(2.0),
                    unblended: of(1.0),
                    exact_rays: of(0.5),
                }
            })
            .collect();
        let row = row(&images, &views);
        let expected = [(0.0, 1, 0.5), (15.0, 2, 3.5), (75.0, 1, 6.5)].map(|(polar_angle, views, through_map)| {
            AngleErrors { polar_angle, views, through_map, unblended: 1.0, exact_rays: 0.5 }
        });
        assert_eq!(row.angles, expected);
        let expected = ImageErrors { mean: 3.5, largest_image: 7.0, image_variance: 5.25, largest_texel: 70.0 };
        assert_eq!((row.through_map, row.mean_push_pull, row.mean_unblended), (expected, 2.0, 1.0));
        assert_eq!(row.mean_compact, 3.0);
    }
}
