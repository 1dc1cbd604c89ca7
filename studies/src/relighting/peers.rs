//! Methods that people relight with today: principal components of photographs over lights and channels in 8 bits, with
//! functions of the light that are interpolated between the lights, as the `relight` program of CNR-ISTI does.

use brdfc_formats::pwt::Domain;
use brdfc_pwt::LightSamples;
use brdfc_pwt::components::Components;
use brdfc_readers::pixels::Pixels;
use nalgebra::{DMatrix, DVector};
use rayon::prelude::*;

/// Number of texels from which components are computed.
const TEXELS: usize = 8192;
/// Candidates for the stiffness, added to the diagonal. Chosen as for trees, by lights that are left out.
const STIFFNESSES: [f64; 6] = [1e-6, 1e-4, 1e-3, 1e-2, 1e-1, 1.0];
/// Candidates for the width of Gaussians, in x and y of the light.
const WIDTHS: [f64; 4] = [0.2, 0.4, 0.8, 1.6];

/// Interpolation between the lights.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Between {
    /// Thin plates with a linear trend.
    ThinPlates,
    /// Gaussians with a constant trend.
    Gaussians,
}

impl Between {
    pub(super) fn name(self) -> &'static str {
        match self {
            Self::ThinPlates => "components, thin plates",
            Self::Gaussians => "components, Gaussians",
        }
    }
}

/// A choice of [`Between`].
#[derive(Debug, Clone, Copy)]
struct Kernel {
    between: Between,
    width: f64,
    stiffness: f64,
}

impl Kernel {
    fn value(&self, a: [f32; 3], b: [f32; 3]) -> f64 {
        let squared = f64::from(a[0] - b[0]).powi(2) + f64::from(a[1] - b[1]).powi(2);
        match self.between {
            Between::ThinPlates if squared > 0.0 => 0.5 * squared * squared.ln(),
            Between::ThinPlates => 0.0,
            Between::Gaussians => (-0.5 * squared / self.width.powi(2)).exp(),
        }
    }

    fn trend(&self, [x, y, _]: [f32; 3]) -> Vec<f64> {
        match self.between {
            Between::ThinPlates => vec![1.0, f64::from(x), f64::from(y)],
            Between::Gaussians => vec![1.0],
        }
    }

    /// Inverse of the system of the lights.
    fn inverse(&self, lights: &[[f32; 3]]) -> Option<DMatrix<f64>> {
        let (count, trends) = (lights.len(), self.trend([0.0; 3]).len());
        let entry = |i: usize, j: usize| match (i < count, j < count) {
            (true, true) => self.value(lights[i], lights[j]) + if i == j { self.stiffness } else { 0.0 },
            (true, false) => self.trend(lights[i])[j - count],
            (false, true) => self.trend(lights[j])[i - count],
            (false, false) => 0.0,
        };
        DMatrix::from_fn(count + trends, count + trends, entry).try_inverse()
    }
}

/// Components of photographs, rounded to 8 bits.
pub(super) struct PrincipalComponents {
    size: [usize; 2],
    lights: Vec<[f32; 3]>,
    planes: Vec<Vec<f32>>,
    /// The mean and the components at the lights: columns `3 term + channel`.
    at_lights: DMatrix<f64>,
    kernel: Kernel,
    inverse: DMatrix<f64>,
}

impl PrincipalComponents {
    /// Computes `count` components. The interpolation has the smallest error at lights that are left out.
    pub(super) fn new(samples: &LightSamples, count: usize, between: Between) -> Self {
        let lights = &samples.lights;
        let codes = |image: &Pixels| {
            let mut codes = image.clone().into_linear();
            Domain::Display.encode_each(codes.as_flattened_mut());
            codes
        };
        let codes: Vec<Vec<[f32; 3]>> = samples.images.par_iter().map(codes).collect();
        let texels = samples.spread_texels(TEXELS);
        // Entries are `channel lights + light`, which makes a term's entries three columns of lights.
        let at = |entry: usize, texel: usize| codes[entry % lights.len()][texels[texel]][entry / lights.len()];
        let values = DMatrix::from_fn(3 * lights.len(), texels.len(), |entry, texel| f64::from(at(entry, texel)));
        let components = Components::new(&values, DVector::from_element(values.nrows(), 1.0), count);
        let terms = components.axes.ncols() + 1;
        let numbers = components.mean.iter().chain(components.axes.iter()).copied();
        let at_lights = DMatrix::from_iterator(lights.len(), 3 * terms, numbers);
        let plane = |axis: usize| {
            let axis = components.axes.column(axis);
            let mut plane = vec![0.0f64; samples.size[0] * samples.size[1]];
            for (light, image) in codes.iter().enumerate() {
                for channel in 0..3 {
                    let entry = channel * lights.len() + light;
                    let (weight, mean) = (axis[entry], components.mean[entry]);
                    plane.iter_mut().zip(image).for_each(|(sum, v)| *sum += weight * (f64::from(v[channel]) - mean));
                }
            }
            rounded(&plane)
        };
        let planes = (0..terms - 1).into_par_iter().map(plane).collect();
        let seen = DMatrix::from_column_slice(lights.len(), 3 * texels.len(), values.as_slice());
        let (kernel, inverse) = chosen(between, lights, &seen);
        Self { size: samples.size, lights: lights.clone(), planes, at_lights, kernel, inverse }
    }

    /// Images under some lights.
    pub(super) fn images(&self, lights: Vec<[f32; 3]>) -> LightSamples {
        let image = |light: &[f32; 3]| {
            let count = self.lights.len();
            let kernel = DMatrix::from_fn(1, self.inverse.nrows(), |_, j| {
                if j < count { self.kernel.value(*light, self.lights[j]) } else { self.kernel.trend(*light)[j - count] }
            });
            let basis = kernel * self.inverse.columns(0, count) * &self.at_lights;
            let term = |k: usize| [0, 1, 2].map(|channel| basis[(0, 3 * k + channel)] as f32);
            let mut image = vec![term(0); self.size[0] * self.size[1]];
            for (k, plane) in self.planes.iter().enumerate() {
                let weight = term(k + 1);
                for (pixel, value) in image.iter_mut().zip(plane) {
                    (0..3).for_each(|channel| pixel[channel] += weight[channel] * value);
                }
            }
            Domain::Display.decode_each(image.as_flattened_mut());
            image
        };
        let images: Vec<_> = lights.par_iter().map(image).collect();
        LightSamples::new(self.size, lights, images)
    }
}

/// Rounds to 8 bits over the range.
fn rounded(plane: &[f64]) -> Vec<f32> {
    let (low, high) = plane.iter().fold((f64::MAX, f64::MIN), |(low, high), v| (low.min(*v), high.max(*v)));
    let step = ((high - low) / 255.0).max(f64::MIN_POSITIVE);
    plane.iter().map(|v| (low + step * ((v - low) / step).round()) as f32).collect()
}

/// The kernel with the smallest error at lights that are left out, and the inverse of its system.
fn chosen(between: Between, lights: &[[f32; 3]], values: &DMatrix<f64>) -> (Kernel, DMatrix<f64>) {
    let products = values * values.transpose();
    let widths: &[f64] = if between == Between::Gaussians { &WIDTHS } else { &[1.0] };
    let kernels = widths
        .iter()
        .flat_map(|width| STIFFNESSES.map(|stiffness| Kernel { between, width: *width, stiffness }))
        .filter_map(|kernel| Some((kernel, kernel.inverse(lights)?)));
    let squares = |inverse: &DMatrix<f64>| {
        let mut errors = inverse.view((0, 0), (lights.len(), lights.len())).into_owned();
        for i in 0..lights.len() {
            let diagonal = errors[(i, i)];
            errors.row_mut(i).iter_mut().for_each(|number| *number /= diagonal);
        }
        (&errors * &products).dot(&errors)
    };
    let all: Vec<(f64, Kernel, DMatrix<f64>)> =
        kernels.map(|(kernel, inverse)| (squares(&inverse), kernel, inverse)).collect();
    let best = all.into_iter().filter(|(error, ..)| error.is_finite()).min_by(|a, b| a.0.total_cmp(&b.0));
    let (_, kernel, inverse) = best.expect("a stiff kernel has an inverse");
    (kernel, inverse)
}
