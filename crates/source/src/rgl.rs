//! Materials of the RGL database, evaluated as in Dupuy and Jakob 2018, "An adaptive parameterization for efficient
//! material acquisition and rendering", section 3. The equations are in `crates/readers/src/rgl.md`.

pub mod resample;
mod warp;

use std::f64::consts::{FRAC_2_PI, PI, TAU};

use brdfc_formats::FormatError;
use brdfc_formats::direction::{DirectionPair, Vector, half_vector};
use brdfc_formats::memory::reserved;
use brdfc_readers::colour::rgb_weights;
use brdfc_readers::rgl::{Azimuths, Colour, KIND, Map, Rgl};

use super::error::InputError;
use super::format::{Format, Opened};
use super::input::InputFile;
use super::smooth::{Axis, Grid, Smoothed, smooth};
use brdfc_core::Describe;
use brdfc_core::words::counted;
use brdfc_core::{Source, Symmetry, Tally};
use warp::{Cell, Incidence, VisibleNormals};

/// Directions within this squared distance of the normal have no azimuth except rounding noise.
const NO_AZIMUTH: f64 = 1e-24;

/// Largest relative difference of values that count as equal in tests of symmetry.
const SAME: f32 = 1e-6;

/// Facts about an RGL material.
#[derive(Debug, Clone, PartialEq, serde::Serialize, schemars::JsonSchema)]
pub struct RglFacts {
    /// Description in the file.
    pub description: String,
    /// Number of measured incoming azimuths.
    pub azimuths: usize,
    /// Number of measured incoming polar angles.
    pub polar_angles: usize,
    /// Rows and columns of the colour tensor per incoming direction.
    pub resolution: [usize; 2],
    /// Number of colour channels or wavelengths in the file.
    pub channels: usize,
    /// Smoothing, if it was requested.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub smoothed: Option<Smoothed>,
}

impl Describe for RglFacts {
    fn lines(&self) -> Vec<(&'static str, String)> {
        let Self { description, azimuths, polar_angles, resolution: [rows, columns], channels, smoothed } = self;
        let mut lines = vec![
            ("kind", "RGL material".to_owned()),
            ("description", description.clone()),
            ("incoming directions", format!("{azimuths} azimuths x {polar_angles} polar angles")),
            ("outgoing directions of each", format!("{rows} x {columns}")),
            ("channels", if *channels == 3 { "RGB".to_owned() } else { counted(*channels, "wavelength") }),
        ];
        lines.extend(smoothed.iter().flat_map(Smoothed::lines));
        lines
    }

    fn samples(&self) -> u64 {
        (self.azimuths * self.polar_angles * self.resolution[0] * self.resolution[1]) as u64
    }
}

/// RGL materials as inputs.
pub(crate) const fn format<F: From<RglFacts>>() -> Format<F> {
    Format { name: "RGL", kind: &KIND, open }
}

fn open<F: From<RglFacts>>(input: InputFile<'_>) -> Result<Opened<F>, InputError> {
    let reading = input.reading;
    input.parse(|bytes| {
        let smoothing = reading.smoothing()?;
        let rgl = Rgl::from_bytes(bytes)?;
        let (description, channels) = (rgl.description.clone(), rgl.channels());
        let mut source = RglSource::new(rgl, rgb_weights)?;
        let facts = RglFacts {
            description,
            azimuths: source.phi_i.len(),
            polar_angles: source.theta_i.len(),
            resolution: [source.colour_rows, source.colour_columns],
            channels,
            smoothed: smoothing.map(|radius| source.smooth(radius)),
        };
        Ok(Opened { source: Box::new(source), facts: facts.into() })
    })
}

/// An RGL material, ready for evaluation.
#[derive(Debug, Clone)]
pub struct RglSource {
    phi_i: Vec<f64>,
    theta_i: Vec<f64>,
    azimuths: Azimuths,
    /// Middle of `phi_i`, radians.
    middle: f64,
    ndf: Map,
    sigma: Map,
    visible: VisibleNormals,
    colour_rows: usize,
    colour_columns: usize,
    /// Linear RGB, shape (phi_i, theta_i, rows, columns).
    colours: Vec<[f32; 3]>,
    jacobian: bool,
    symmetry: Symmetry,
    grey: bool,
}

impl RglSource {
    /// Prepares a material. Spectra are converted to linear RGB here, once.
    ///
    /// `weights` is called with the wavelengths (nanometres, increasing) of a spectral file and returns the linear RGB
    /// contribution of a value of 1 at each of them: a colour is the sum of weight times value over the wavelengths. It
    /// is not called for an RGB file.
    ///
    /// Returns errors of `weights`, and an error for a wrong number of weights or colours beyond the range of single
    /// precision.
    pub fn new(rgl: Rgl, weights: impl Fn(&[f64]) -> Result<Vec<[f64; 3]>, FormatError>) -> Result<Self, FormatError> {
        let weights = match &rgl.colour {
            Colour::Rgb(_) => vec![[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]],
            Colour::Spectra { wavelengths, .. } => weights(wavelengths)?,
        };
        if weights.len() != rgl.channels() {
            return Err(FormatError::whole(
                "colour weights",
                format!("{} weights", weights.len()),
                format!("{}, one per wavelength", rgl.channels()),
            ));
        }
        let (Colour::Rgb(values) | Colour::Spectra { values, .. }) = &rgl.colour;
        let colours = combine(values, &weights, rgl.colour_rows * rgl.colour_columns)?;
        if let Some(colour) = colours.iter().flatten().find(|v| !v.is_finite()) {
            return Err(FormatError::whole("linear RGB", colour.to_string(), "a single-precision number"));
        }
        let visible = VisibleNormals::new(&rgl.vndf, rgl.vndf_rows, rgl.vndf_columns)?;
        let symmetry = symmetry(&rgl, &colours);
        let grey = colours.iter().all(|[r, g, b]| r == g && g == b);
        Ok(Self {
            middle: (rgl.phi_i[0] + rgl.phi_i[rgl.phi_i.len() - 1]) / 2.0,
            phi_i: rgl.phi_i,
            theta_i: rgl.theta_i,
            azimuths: rgl.azimuths,
            ndf: rgl.ndf,
            sigma: rgl.sigma,
            visible,
            colour_rows: rgl.colour_rows,
            colour_columns: rgl.colour_columns,
            colours,
            jacobian: rgl.jacobian,
            symmetry,
            grey,
        })
    }

    /// Smooths the colours of each incidence. Incidences are few and far apart, so that fits do not reach across them.
    fn smooth(&mut self, radius: Option<usize>) -> Smoothed {
        let [incidences, rows] = [self.phi_i.len() * self.theta_i.len(), self.colour_rows];
        let shape = [incidences, rows, self.colour_columns];
        smooth(&mut self.colours, Grid { shape, axes: [Axis::Separate, Axis::Open, Axis::Open] }, radius)
    }

    /// Maps `pair` by the symmetries of the material to an equivalent pair whose incident direction was measured.
    fn reduce(&self, pair: DirectionPair) -> DirectionPair {
        let [x, y, _] = pair.incoming;
        let (sin, cos) = self.middle.sin_cos();
        let [flip_x, flip_y] = match self.azimuths {
            Azimuths::Isotropic | Azimuths::Full => [false; 2],
            Azimuths::HalfTurn => [x * cos + y * sin < 0.0; 2],
            Azimuths::Quadrant => [x * cos < 0.0, y * sin < 0.0],
        };
        let flip = |[x, y, z]: Vector| [if flip_x { -x } else { x }, if flip_y { -y } else { y }, z];
        DirectionPair::new(flip(pair.incoming), flip(pair.outgoing))
    }

    /// Bilinear colour at a warped point.
    fn colour(&self, incidence: &Incidence, [s, t]: [f64; 2]) -> [f64; 3] {
        let column = Cell::new(s, self.colour_columns);
        let row = Cell::new(t, self.colour_rows);
        let mut sum = [0.0; 3];
        for &(slice, weight) in incidence.slices() {
            for (y, weight) in [(row.index, weight * (1.0 - row.fraction)), (row.index + 1, weight * row.fraction)] {
                let start = (slice * self.colour_rows + y) * self.colour_columns + column.index;
                let (left, right) = (self.colours[start], self.colours[start + 1]);
                let (a, b) = (weight * (1.0 - column.fraction), weight * column.fraction);
                for k in 0..3 {
                    sum[k] += a * f64::from(left[k]) + b * f64::from(right[k]);
                }
            }
        }
        sum
    }
}

impl Source for RglSource {
    fn eval(&self, pair: DirectionPair, tally: &mut Tally) -> [f64; 3] {
        tally.evaluations += 1;
        if !pair.is_above_horizon() {
            return [0.0; 3];
        }
        let pair = self.reduce(pair);
        let (theta_i, phi_i) = polar(pair.incoming);
        let isotropic = self.azimuths == Azimuths::Isotropic;
        let [u_m, v_m] = normal_to_unit(pair, isotropic);
        let phi_i = phi_i.unwrap_or(0.0);
        let turns = ((self.middle - phi_i) / TAU).round();
        let incidence = Incidence::new(&self.phi_i, phi_i + turns * TAU, &self.theta_i, theta_i);

        let mut scale = 1.0 / pair.outgoing[2];
        if self.jacobian {
            scale *= jacobian(&self.ndf, &self.sigma, pair, [theta_i, phi_i], isotropic);
        }
        self.colour(&incidence, self.visible.invert(&incidence, u_m, v_m)).map(|v| v * scale)
    }

    fn symmetry(&self) -> Symmetry {
        self.symmetry
    }

    fn is_grey(&self) -> bool {
        self.grey
    }
}

/// `ndf / (4 sigma)` of a pair, with polar angle and azimuth of its incoming direction: the factor that stored values
/// omit. 0 if no microfacet is visible, which occurs only at the horizon, in files that reach zero there.
fn jacobian(ndf: &Map, sigma: &Map, pair: DirectionPair, [theta_i, phi_i]: [f64; 2], isotropic: bool) -> f64 {
    let sigma = warp::bilinear(sigma, polar_to_unit(theta_i), azimuth_to_unit(phi_i));
    let [u_m, v_m] = normal_to_unit(pair, isotropic);
    if sigma <= 0.0 { 0.0 } else { warp::bilinear(ndf, u_m, v_m) / (4.0 * sigma) }
}

/// Position of the half vector of a pair in the unit square. The azimuth of isotropic materials is relative to the
/// azimuth of incidence.
fn normal_to_unit(pair: DirectionPair, isotropic: bool) -> [f64; 2] {
    let (theta_m, phi_m) = polar(half_vector(pair));
    let v = azimuth_to_unit(match (isotropic, phi_m, polar(pair.incoming).1) {
        (true, Some(m), Some(i)) => m - i,
        (true, ..) => 0.0,
        (_, m, _) => m.unwrap_or(0.0),
    });
    [polar_to_unit(theta_m), v]
}

/// Polar angle and azimuth, if defined, radians.
fn polar([x, y, z]: Vector) -> (f64, Option<f64>) {
    let squared = x * x + y * y;
    (squared.sqrt().atan2(z), (squared > NO_AZIMUTH).then(|| y.atan2(x)))
}

/// `u` of a polar angle in `[0, π/2]`: nodes are denser at the normal.
fn polar_to_unit(theta: f64) -> f64 {
    (theta * FRAC_2_PI).sqrt()
}

/// `v` of an azimuth: `-π` is 0, a full turn is 1, wrapped into `[0, 1]`.
fn azimuth_to_unit(phi: f64) -> f64 {
    let v = (phi + PI) / TAU;
    v - v.floor()
}

/// Weighted sums over the channel axis: shape (incidence, channel, node) to (incidence, node) of RGB.
fn combine(values: &[f32], weights: &[[f64; 3]], nodes: usize) -> Result<Vec<[f32; 3]>, FormatError> {
    let mut colours = reserved("colours", values.len() / weights.len())?;
    for channels in values.chunks_exact(weights.len() * nodes) {
        for node in 0..nodes {
            let mut sum = [0.0; 3];
            for (channel, weight) in weights.iter().enumerate() {
                for k in 0..3 {
                    sum[k] += weight[k] * f64::from(channels[channel * nodes + node]);
                }
            }
            colours.push(sum.map(|v| v as f32));
        }
    }
    Ok(colours)
}

/// Symmetry of the tables: isotropic if the file declares it and no table depends on the azimuth of incidence.
fn symmetry(rgl: &Rgl, colours: &[[f32; 3]]) -> Symmetry {
    let same = |a: f32, b: f32| (a - b).abs() <= SAME * a.abs().max(b.abs());
    let all_same = |values: &[f32], block: usize| {
        values.chunks_exact(block).skip(1).all(|later| later.iter().zip(values).all(|(a, b)| same(*a, *b)))
    };
    let colours = colours.as_flattened();
    let count = rgl.phi_i.len();
    let isotropic = rgl.azimuths == Azimuths::Isotropic
        && all_same(&rgl.vndf, rgl.vndf.len() / count)
        && all_same(colours, colours.len() / count)
        && (!rgl.jacobian || all_same(&rgl.sigma.values, rgl.sigma.columns));
    Symmetry { isotropic, ..Symmetry::NONE }
}
