//! Materials of the RGL database (Dupuy and Jakob 2018, "An adaptive parameterization for efficient material
//! acquisition and rendering"), measured on a goniophotometer over a parameterisation adapted to each material.
//!
//! Layout: `crates/readers/src/rgl.md`.

use std::f64::consts::{FRAC_PI_2, TAU};

use super::tensor::{self, ElementKind, Elements, Tensor, TensorFile};
use crate::file_kind::{Begins, FileKind};
use brdfc_formats::FormatError;

/// Materials of the RGL database.
pub static KIND: FileKind =
    FileKind { description: "an RGL material (.bsdf)", extensions: &["bsdf"], begins: Begins::With(&[tensor::MAGIC]) };

/// Tolerance of angles at their limits, radians: files round them to single precision.
const ANGLE_SLACK: f64 = 1e-5;

/// Maximum distance between the middle of azimuths that cover a quadrant and the middle of the quadrant, radians.
const QUADRANT_SLACK: f64 = 0.1;

/// Shortest and longest valid wavelength, nanometres.
const WAVELENGTH_RANGE: [f32; 2] = [1.0, 100_000.0];

/// A table over the unit square, bilinear between its nodes, row-major: `values[row * columns + column]`.
///
/// Nodes include the border of the square: column 0 at u = 0, the last column at u = 1; rows likewise along v.
#[derive(Debug, Clone, PartialEq)]
pub struct Map {
    /// Nodes along v, at least 2.
    pub rows: usize,
    /// Nodes along u, at least 2.
    pub columns: usize,
    /// Values, `rows * columns`.
    pub values: Vec<f32>,
}

/// Values of the measurement in the warped unit square.
#[derive(Debug, Clone, PartialEq)]
pub enum Colour {
    /// Linear RGB, shape (phi_i, theta_i, 3, rows, columns).
    Rgb(Vec<f32>),
    /// One value for each wavelength, shape (phi_i, theta_i, wavelength, rows, columns).
    Spectra {
        /// Wavelengths, nanometres, strictly increasing.
        wavelengths: Vec<f64>,
        /// Values at these wavelengths.
        values: Vec<f32>,
    },
}

/// Range of the azimuths of incidence, which determines how direction pairs outside are mapped into it.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Azimuths {
    /// At most two azimuths: an isotropic material, tabulated over the azimuth relative to the incident direction.
    Isotropic,
    /// The whole circle: no symmetry about the normal is used.
    Full,
    /// Half a circle: the material is unchanged by half a turn about the normal.
    HalfTurn,
    /// A quadrant: the material is unchanged by mirroring in `x = 0` and in `y = 0`.
    Quadrant,
}

/// A checked RGL material.
#[derive(Debug, Clone, PartialEq)]
pub struct Rgl {
    /// Description of the measurement; bytes that are not UTF-8 become U+FFFD.
    pub description: String,
    /// Azimuths of the incident direction, radians, strictly increasing, in [-2π, 2π]; see `azimuths`.
    pub phi_i: Vec<f64>,
    /// Polar angles of the incident direction, radians, strictly increasing, in [0, π/2].
    pub theta_i: Vec<f64>,
    /// Range of the azimuths of the incident direction.
    pub azimuths: Azimuths,
    /// Distribution of microfacet normals, 1/sr, not negative; u is the polar angle, v the azimuth.
    pub ndf: Map,
    /// Projected area of the microfacets seen from a direction, not negative; u is the polar angle, v the azimuth.
    pub sigma: Map,
    /// Nodes of the visible normal distribution along v (azimuth), at least 2.
    pub vndf_rows: usize,
    /// Nodes of the visible normal distribution along u (polar angle), at least 2.
    pub vndf_columns: usize,
    /// Density of visible normals in the unit square, up to a factor for each incident direction; not negative and not
    /// all zero for any incident direction. Shape (phi_i, theta_i, vndf_rows, vndf_columns).
    pub vndf: Vec<f32>,
    /// Nodes of the colour tables along v, at least 2.
    pub colour_rows: usize,
    /// Nodes of the colour tables along u, at least 2.
    pub colour_columns: usize,
    /// The measurement. Values may be slightly negative.
    pub colour: Colour,
    /// True if the colours still have to be multiplied by `ndf / (4 sigma)`.
    pub jacobian: bool,
}

impl Rgl {
    /// Number of channels: 3 or the number of wavelengths.
    pub fn channels(&self) -> usize {
        match &self.colour {
            Colour::Rgb(_) => 3,
            Colour::Spectra { wavelengths, .. } => wavelengths.len(),
        }
    }

    /// Bytes of a file of RGB values, with the table of luminances for samplers.
    ///
    /// # Panics
    /// Panics if the values are spectra.
    pub fn to_bytes(&self) -> Vec<u8> {
        let Colour::Rgb(colours) = &self.colour else { panic!("a file of RGB values") };
        let nodes = self.colour_rows * self.colour_columns;
        let luminance = colours.chunks_exact(3 * nodes).flat_map(|rgb| {
            let of = move |k: usize| 0.2126 * rgb[k] + 0.7152 * rgb[nodes + k] + 0.0722 * rgb[2 * nodes + k];
            (0..nodes).map(move |k| of(k).max(0.0))
        });
        let luminance: Vec<f32> = luminance.collect();
        let single = |angles: &[f64]| angles.iter().map(|angle| *angle as f32).collect::<Vec<f32>>();
        let (phi_i, theta_i) = (single(&self.phi_i), single(&self.theta_i));
        let [p, t] = [phi_i.len(), theta_i.len()];
        let (rows, columns) = (self.colour_rows, self.colour_columns);
        let square = |map: &Map| vec![map.rows, map.columns];
        tensor::to_bytes(&[
            ("description", vec![self.description.len()], Elements::Bytes(self.description.as_bytes())),
            ("phi_i", vec![p], Elements::Floats(&phi_i)),
            ("theta_i", vec![t], Elements::Floats(&theta_i)),
            ("ndf", square(&self.ndf), Elements::Floats(&self.ndf.values)),
            ("sigma", square(&self.sigma), Elements::Floats(&self.sigma.values)),
            ("vndf", vec![p, t, self.vndf_rows, self.vndf_columns], Elements::Floats(&self.vndf)),
            ("luminance", vec![p, t, rows, columns], Elements::Floats(&luminance)),
            ("rgb", vec![p, t, 3, rows, columns], Elements::Floats(colours)),
            ("jacobian", vec![1], Elements::Bytes(&[u8::from(self.jacobian)])),
        ])
    }

    /// Reads a `.bsdf` file of the RGL database.
    ///
    /// Returns an error for a broken container (see [`TensorFile::parse`]), a missing field, element types or shapes
    /// that do not match, axes that do not increase strictly or are out of range, azimuths that cover neither the
    /// circle nor a half nor a quadrant of it, values that are not finite, negative densities, and a table of visible
    /// normals that is all zero.
    pub fn from_bytes(bytes: &[u8]) -> Result<Self, FormatError> {
        let file = TensorFile::parse(bytes)?;
        let phi_i = axis(file.require("phi_i")?, -TAU, TAU)?;
        let azimuths = azimuths(file.require("phi_i")?, &phi_i)?;
        let theta_i = axis(file.require("theta_i")?, 0.0, FRAC_PI_2)?;
        let incidences = [phi_i.len(), theta_i.len()];

        let ndf = map(file.require("ndf")?)?;
        let sigma = map(file.require("sigma")?)?;

        let tensor = file.require("vndf")?;
        let [vndf_rows, vndf_columns] = table_shape(tensor, &incidences)?;
        let vndf = tensor.floats(0.0, f32::MAX)?;
        for (slice, values) in vndf.chunks_exact(vndf_rows * vndf_columns).enumerate() {
            if values.iter().all(|v| *v == 0.0) {
                let index = slice * vndf_rows * vndf_columns;
                let found = "only zeros for an incident direction";
                return Err(tensor.element_error(index, found, "a positive value").problem());
            }
        }

        let (colour_tensor, wavelengths) = match (file.get("rgb"), file.get("spectra")) {
            (Some(rgb), None) => (rgb, None),
            (None, Some(spectra)) => (spectra, Some(read_wavelengths(file.require("wavelengths")?)?)),
            (Some(_), Some(spectra)) => {
                return Err(spectra.header_error("field", "conflicts with rgb", "one of rgb and spectra").problem());
            }
            (None, None) => {
                return Err(FormatError::whole("rgb or spectra", "missing", "one of rgb and spectra").problem());
            }
        };
        let channels = wavelengths.as_ref().map_or(3, Vec::len);
        let [colour_rows, colour_columns] = table_shape(colour_tensor, &[phi_i.len(), theta_i.len(), channels])?;
        let values = colour_tensor.floats(f32::MIN, f32::MAX)?;
        let colour = match wavelengths {
            None => Colour::Rgb(values),
            Some(wavelengths) => Colour::Spectra { wavelengths, values },
        };

        if let Some(luminance) = file.get("luminance") {
            luminance.expect_kind(ElementKind::F32)?;
            expect_shape(luminance, &[phi_i.len(), theta_i.len(), colour_rows, colour_columns])?;
        }

        let tensor = file.require("jacobian")?;
        let flag = tensor.bytes()?;
        expect_shape(tensor, &[1])?;
        if flag[0] > 1 {
            return Err(tensor.element_error(0, flag[0].to_string(), "0 or 1"));
        }

        let tensor = file.require("description")?;
        let description = String::from_utf8_lossy(tensor.bytes()?).into_owned();
        if tensor.shape.len() != 1 {
            return Err(tensor.header_error("shape", format!("{:?}", tensor.shape), "one axis"));
        }

        Ok(Self {
            description,
            phi_i,
            theta_i,
            azimuths,
            ndf,
            sigma,
            vndf_rows,
            vndf_columns,
            vndf,
            colour_rows,
            colour_columns,
            colour,
            jacobian: flag[0] == 1,
        })
    }
}

/// Range of the azimuths, from the rounded ratio of the circle to their span.
fn azimuths(tensor: &Tensor, phi_i: &[f64]) -> Result<Azimuths, FormatError> {
    if phi_i.len() <= 2 {
        return Ok(Azimuths::Isotropic);
    }
    let (first, last) = (phi_i[0], phi_i[phi_i.len() - 1]);
    let span = last - first;
    match (TAU / span).round() {
        1.0 if span <= TAU + ANGLE_SLACK => Ok(Azimuths::Full),
        2.0 => Ok(Azimuths::HalfTurn),
        4.0 => {
            // Mirroring maps only quadrants between two axes.
            let from_middle = ((first + last) / 2.0).rem_euclid(FRAC_PI_2) - FRAC_PI_2 / 2.0;
            if from_middle.abs() <= QUADRANT_SLACK {
                return Ok(Azimuths::Quadrant);
            }
            Err(tensor.header_error("range", format!("{first} to {last}"), "a quadrant between two axes"))
        }
        _ => Err(tensor.header_error("span", span.to_string(), "about 2π, π or π/2, and at most 2π")),
    }
}

fn expect_shape(tensor: &Tensor, shape: &[usize]) -> Result<(), FormatError> {
    if tensor.shape == shape {
        return Ok(());
    }
    Err(tensor.header_error("shape", format!("{:?}", tensor.shape), format!("{shape:?}")))
}

/// Rows and columns of a tensor whose leading axes have the extents `leading`.
fn table_shape(tensor: &Tensor, leading: &[usize]) -> Result<[usize; 2], FormatError> {
    match tensor.shape.strip_prefix(leading) {
        Some(&[rows, columns]) if rows >= 2 && columns >= 2 => Ok([rows, columns]),
        _ => Err(tensor.header_error(
            "shape",
            format!("{:?}", tensor.shape),
            format!("{leading:?} and two more extents, each at least 2"),
        )),
    }
}

fn map(tensor: &Tensor) -> Result<Map, FormatError> {
    let [rows, columns] = table_shape(tensor, &[])?;
    Ok(Map { rows, columns, values: tensor.floats(0.0, f32::MAX)? })
}

/// A strictly increasing axis with at least one element, in `[minimum, maximum]` within [`ANGLE_SLACK`].
fn axis(tensor: &Tensor, minimum: f64, maximum: f64) -> Result<Vec<f64>, FormatError> {
    let values = increasing(tensor, f32::MIN, f32::MAX)?;
    let out_of_range = |v: &f64| *v < minimum - ANGLE_SLACK || *v > maximum + ANGLE_SLACK;
    if let Some(index) = values.iter().position(out_of_range) {
        return Err(tensor.element_error(index, values[index].to_string(), format!("{minimum:.4} to {maximum:.4}")));
    }
    Ok(values)
}

fn read_wavelengths(tensor: &Tensor) -> Result<Vec<f64>, FormatError> {
    increasing(tensor, WAVELENGTH_RANGE[0], WAVELENGTH_RANGE[1])
}

fn increasing(tensor: &Tensor, minimum: f32, maximum: f32) -> Result<Vec<f64>, FormatError> {
    if tensor.shape.len() != 1 || tensor.shape[0] == 0 {
        return Err(tensor.header_error("shape", format!("{:?}", tensor.shape), "one axis with at least one element"));
    }
    let values: Vec<f64> = tensor.floats(minimum, maximum)?.into_iter().map(f64::from).collect();
    if let Some(index) = values.windows(2).position(|pair| pair[1] <= pair[0]) {
        return Err(tensor.element_error(
            index + 1,
            values[index + 1].to_string(),
            format!("more than {}, the element before", values[index]),
        ));
    }
    Ok(values)
}
