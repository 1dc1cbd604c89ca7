//! Opens the inputs of flattening: geometry, materials, images.

use crate::error::Error;
use crate::report::fit::Reliability;
use brdfc_core::address::SYNTH_PREFIX;
use brdfc_core::progress::Progress;
use brdfc_core::words::{one_of, percent};
use brdfc_core::{PackSource, Source};
use brdfc_flat_btf::mesh::{MAX_MATERIALS, PeriodicMesh};
use brdfc_flat_btf::structures::Structure;
use brdfc_flat_btf::surface::Appearance;
use brdfc_flat_btf::tile_image::TileImage;
use brdfc_flat_btf::weld::{MesoError, WeldReport, from_heights, weld};
use brdfc_formats::crop::DirectionRange;
use brdfc_formats::wavelet::WaveletPack;
use brdfc_source::Input;
use brdfc_source::meso::{MesoInput, open_meso};
use brdfc_source::open::{Opened, open};
use brdfc_source::ordinary_btf::OrdinaryBtf;
use brdfc_source::photograph::CodeValues;
use brdfc_source::tile_image::{FileImage, open_colours, open_shares};
use brdfc_wavelet::encode::encode;
use brdfc_wavelet::recipe::{Recipe, Target};
use std::path::Path;

/// Name of the reference plane in reports.
pub const PLANE: &str = "the plane";
/// A structure without relief.
const FLAT: &str = "sponge?height=0&resolution=16";

/// Geometry and materials to flatten, with their scale.
#[derive(Debug, Clone, PartialEq)]
pub struct MesoOptions {
    /// A structure, a mesh or a height map; `None` for the reference plane, as for images without a relief.
    pub geometry: Option<Input>,
    /// The period of a mesh along x and y, in its unit.
    pub tile: f64,
    /// Tiles per unit of a height map.
    pub height_scale: f64,
    /// Height of a height map's 0, in tiles.
    pub height_offset: f64,
    /// Materials: optional name in the mesh, and source.
    pub materials: Vec<(Option<String>, Input)>,
    /// Image that multiplies the reflectance.
    pub colour: Option<Input>,
    /// Image whose channels are weights of the materials.
    pub weights: Option<Input>,
}

/// Statements of an image about its pixels, and what was done.
#[derive(Debug, Clone, PartialEq, Eq, serde::Serialize, schemars::JsonSchema)]
pub struct ImageFacts {
    /// Use of the image: `images`, `colour`, `weights` or `heights`.
    pub image: &'static str,
    /// Its colour, and other statements such as its orientation.
    pub conversions: Vec<String>,
}

/// Geometry of a surface.
pub struct Geometry {
    /// One tile of the surface, welded and periodic.
    pub mesh: PeriodicMesh,
    /// Repairs of a mesh from a file; `None` for other geometry.
    pub weld: Option<WeldReport>,
    /// Names of the mesh's materials, in the order of its weights; empty for meshes without names.
    pub material_names: Vec<String>,
    /// Materials of a structure.
    pub default_materials: Vec<String>,
    /// Name of the input in reports: an address with all parameters, or a file name without its folder.
    pub name: String,
    /// Name of the input in errors.
    pub input: String,
    /// Statements of a height map about its pixels, and what was done.
    pub conversions: Option<Vec<String>>,
}

/// Reads geometry.
///
/// # Errors
/// Returns an error if a file cannot be read, an address is invalid, or the geometry does not close.
pub fn open_geometry(options: &MesoOptions) -> Result<Geometry, Error> {
    let Some(input) = &options.geometry else {
        let mut mesh = Structure::parse(FLAT).expect("a valid address").mesh();
        // Removes rounding errors of the mean height.
        mesh.positions.iter_mut().for_each(|point| point[2] = 0.0);
        return Ok(Geometry {
            mesh,
            weld: None,
            material_names: Vec::new(),
            default_materials: Vec::new(),
            name: PLANE.to_owned(),
            input: PLANE.to_owned(),
            conversions: None,
        });
    };
    if let Some(structure) = structure(input)? {
        return Ok(Geometry {
            mesh: structure.mesh(),
            weld: None,
            material_names: Vec::new(),
            default_materials: structure.default_materials().iter().map(|m| (*m).to_owned()).collect(),
            name: structure.canonical(),
            input: input.to_string(),
            conversions: None,
        });
    }
    let name = input.short_name();
    let wrong = |error: MesoError| Error::input(error).prefixed(input);
    let mut conversions = None;
    let (mesh, weld, material_names) = match open_meso(input)? {
        MesoInput::Mesh(mesh) => {
            let (welded, report) = weld(&mesh, options.tile).map_err(wrong)?;
            (welded, Some(report), mesh.materials)
        }
        MesoInput::Heights(map) => {
            let (scale, offset) = (options.height_scale, options.height_offset);
            conversions = Some(map.conversions.clone());
            (from_heights(map.width, map.height, &map.heights, scale, offset).map_err(wrong)?, None, Vec::new())
        }
    };
    let (default_materials, input) = (Vec::new(), input.to_string());
    Ok(Geometry { mesh, weld, material_names, default_materials, name, input, conversions })
}

/// The structure at an address; `None` for files.
pub(super) fn structure(input: &Input) -> Result<Option<Structure>, Error> {
    let Some(address) = input.address() else { return Ok(None) };
    let text = address.strip_prefix(SYNTH_PREFIX).unwrap_or(address);
    Structure::parse(text).map(Some).map_err(|error| Error::input(error).prefixed(address))
}

/// Material of surfaces without one.
const DEFAULT_MATERIAL: &str = "synth:lambert?kd=0.5";

/// Sources of the materials, in the order of the surface's weights.
///
/// # Errors
/// Returns an error if a name is not in the mesh, or if the number of materials does not match the surface.
pub fn material_list(options: &MesoOptions, geometry: &Geometry) -> Result<Vec<Input>, Error> {
    let materials = listed(options, geometry)?;
    if options.weights.is_some() && materials.len() < 2 {
        return Err(Error::wrong_usage("--weights", "one material", "two or more, which the image blends"));
    }
    Ok(materials)
}

fn listed(options: &MesoOptions, geometry: &Geometry) -> Result<Vec<Input>, Error> {
    let names = &geometry.material_names;
    let unnamed: Vec<&Input> = options.materials.iter().filter(|(n, _)| n.is_none()).map(|(_, s)| s).collect();
    let named: Vec<&String> = options.materials.iter().filter_map(|(name, _)| name.as_ref()).collect();
    let wrong = |text: String| Err(Error::usage(format!("--material: {text}")));
    for (at, name) in named.iter().enumerate() {
        if named[..at].contains(name) {
            return wrong(format!("the name {name} is given twice; give each name once"));
        }
        if !names.contains(name) {
            return wrong(if names.is_empty() {
                format!("the surface has no names of materials; give the material without {name}=")
            } else {
                format!("found the name {name}, expected {}", one_of(names))
            });
        }
    }
    let count = unnamed.len();
    if count > MAX_MATERIALS {
        return wrong(format!("found {count} materials, expected at most {MAX_MATERIALS}"));
    }
    if !names.is_empty() {
        if count > 1 || (count > 0 && named.len() == names.len()) {
            let rest = names.iter().filter(|name| !named.contains(name)).map(String::as_str).collect::<Vec<_>>();
            return wrong(if rest.is_empty() {
                "a material without a name, but each part of the surface has one; leave it out".to_owned()
            } else {
                format!("found {count} materials without a name, expected one, for {}", rest.join(", "))
            });
        }
        // Materials of a mesh with names have their own source, or the unnamed one.
        let rest = unnamed.last().map_or_else(|| DEFAULT_MATERIAL.into(), |input| (*input).clone());
        let own = |name: &String| options.materials.iter().rev().find(|(n, _)| n.as_ref() == Some(name));
        return Ok(names.iter().map(|name| own(name).map_or(&rest, |(_, input)| input).clone()).collect());
    }
    let defaults = &geometry.default_materials;
    let needed = if options.weights.is_some() { count.max(1) } else { defaults.len().max(1) };
    if count > needed {
        let allowed = format!("at most {needed}, as many as the surface blends; use --weights to blend more");
        return wrong(format!("found {count} materials, expected {allowed}"));
    }
    let source = |k: usize| {
        // A single material covers the whole surface.
        let given = unnamed.get(k).or(if unnamed.len() == 1 { unnamed.first() } else { None });
        let default = || defaults.get(k).map_or(DEFAULT_MATERIAL, String::as_str).into();
        given.map_or_else(default, |input| (*input).clone())
    };
    Ok((0..needed).map(source).collect())
}

/// Opens the materials and images. Scans are tabulated first (unfiltered, 16 bits), because each of their evaluations is a fit.
///
/// # Errors
/// Returns an error if a material or an image cannot be opened, or if cancelled.
pub fn open_appearance(
    options: &MesoOptions,
    materials: &[Input],
    progress: &dyn Progress,
) -> Result<Appearance, Error> {
    open_observed(options, materials, &mut |_| Ok(()), progress).map(|(appearance, _)| appearance)
}

/// Same as [`open_appearance`], and calls `observe` with the source of each material before it is tabulated. Also returns the
/// statements of the images.
fn open_observed(
    options: &MesoOptions,
    materials: &[Input],
    observe: &mut dyn FnMut(&dyn Source) -> Result<(), Error>,
    progress: &dyn Progress,
) -> Result<(Appearance, Vec<ImageFacts>), Error> {
    let opened = |material| {
        let opened = open(material, None)?;
        observe(opened.source.as_ref())?;
        tabulated(opened, progress)
    };
    let sources = materials.iter().map(opened).collect::<Result<_, _>>()?;
    let colour = options.colour.as_ref().map(open_colours).transpose()?;
    let weights = options.weights.as_ref().map(|input| open_weights(input, materials.len())).transpose()?;
    let of_colour = colour.as_ref().map(|image| ("colour", image.conversions.clone()));
    let of_weights = weights.as_ref().map(|image| ("weights", image.conversions.clone()));
    let images = [of_colour, of_weights].into_iter().flatten();
    let images = images.map(|(image, conversions)| ImageFacts { image, conversions }).collect();
    Ok((Appearance { sources, colour: colour.map(tile_image), weights: weights.map(tile_image) }, images))
}

/// Mean difference of channels of images that are grey, with noise of a few levels of 255.
const GREY: f64 = 0.01;

/// Reads an image of weights of some materials.
///
/// # Errors
/// Returns an error for a file that cannot be read, and for channels that are no weights: equal ones, and alpha of 1 everywhere.
fn open_weights(input: &Input, materials: usize) -> Result<FileImage<4>, Error> {
    let mut image = open_shares(input)?;
    let refused = |found: &str| {
        let channels = ["red", "green", "blue", "alpha"][..materials].join(", ");
        Err(Error::input(format!(
            "{input}: weights: found {found}; expected the weights of {materials} materials in {channels}"
        )))
    };
    let pixels = &image.pixels;
    let grey =
        |pixel: &[f32; 4]| pixel[1..materials].iter().map(|weight| (weight - pixel[0]).abs()).fold(0.0, f32::max);
    let differences = pixels.iter().map(|pixel| f64::from(grey(pixel))).sum::<f64>();
    if differences <= GREY * pixels.len() as f64 {
        return refused("nearly the same weight of all materials at every texel, as in a grey image");
    }
    if materials == MAX_MATERIALS && pixels.iter().all(|pixel| pixel[3] >= 1.0) {
        return refused("alpha of 1 at every texel, as in an image without transparency");
    }
    let empty = pixels.iter().filter(|pixel| pixel[..materials].iter().sum::<f32>() <= 0.0).count();
    if empty > 0 {
        let share = percent(empty as f64 / pixels.len() as f64);
        image.conversions.push(format!("{share} of the texels have no weight: they are of the first material"));
    }
    Ok(image)
}

fn tile_image<const N: usize>(FileImage { width, height, pixels, .. }: FileImage<N>) -> TileImage<N> {
    TileImage { width, height, pixels }
}

/// The source of a material; a table of it for a scan.
fn tabulated(opened: Opened, progress: &dyn Progress) -> Result<Box<dyn Source>, Error> {
    if opened.source.completion().is_none() {
        return Ok(opened.source);
    }
    let recipe = Recipe { target: Target::Ratio(1.0), bits: 16, supercompress: false, ..Recipe::default() };
    let encoded = encode(opened.source.as_ref(), &recipe, progress)?;
    let pack = WaveletPack::from_bytes(&encoded.bytes).expect("our own pack");
    Ok(Box::new(PackSource::new(&pack, None)))
}

/// Source of the values of texels.
pub enum Values {
    /// Computed from materials of the surface.
    Computed(Appearance),
    /// Measured, from images of an ordinary BTF.
    Measured(OrdinaryBtf),
}

/// A surface and the values of its texels.
pub struct Surface {
    /// Shape of the surface.
    pub geometry: Geometry,
    /// Sources of its materials; empty for an ordinary BTF.
    pub materials: Vec<String>,
    /// Source of the values of texels.
    pub values: Values,
    /// Statements of the images about their pixels.
    pub images: Vec<ImageFacts>,
    /// Properties of the materials on which the meaning of errors against them depends; empty for an ordinary BTF.
    pub reliability: Vec<Reliability>,
}

impl Surface {
    /// Reads geometry and materials, or geometry and an ordinary BTF (a folder of images, or a .btf file). `codes` is the
    /// meaning of the code values of BTF images in spite of what they state.
    ///
    /// # Errors
    /// Returns an error if a file cannot be read, an address is invalid, the geometry does not close, or the materials do not
    /// match it.
    pub fn open(
        options: &MesoOptions,
        btf: Option<&Path>,
        codes: Option<CodeValues>,
        progress: &dyn Progress,
    ) -> Result<Self, Error> {
        let Some(path) = btf else {
            let geometry = open_geometry(options)?;
            let inputs = material_list(options, &geometry)?;
            let mut reliability = Vec::new();
            let mut observe = |source: &dyn Source| -> Result<(), Error> {
                reliability.push(Reliability::measure(source, DirectionRange::ALL, progress)?);
                Ok(())
            };
            let (appearance, images) = open_observed(options, &inputs, &mut observe, progress)?;
            let materials = inputs.iter().map(Input::short_name).collect();
            let values = Values::Computed(appearance);
            return Ok(Self { images: with_heights(&geometry, images), geometry, materials, values, reliability });
        };
        let stack = OrdinaryBtf::open_as(path, codes)?;
        let mut geometry = open_geometry(options)?;
        let folder = path.canonicalize().ok();
        let folder = folder.as_deref().and_then(Path::file_name).map(|n| n.to_string_lossy().into_owned());
        geometry.name = format!("{} over {}", folder.unwrap_or_else(|| "images".to_owned()), geometry.name);
        let conversions = stack.colour().map(str::to_owned).into_iter().chain(stack.notes().iter().cloned()).collect();
        let images = stack.colour().map(|_| ImageFacts { image: "images", conversions }).into_iter().collect();
        let images = with_heights(&geometry, images);
        Ok(Self { geometry, materials: Vec::new(), values: Values::Measured(stack), images, reliability: Vec::new() })
    }
}

fn with_heights(geometry: &Geometry, mut images: Vec<ImageFacts>) -> Vec<ImageFacts> {
    let heights = geometry.conversions.clone();
    images.extend(heights.map(|conversions| ImageFacts { image: "heights", conversions }));
    images
}
