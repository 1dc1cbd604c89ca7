//! Names of the images of a BTF stack: one image per view and light. Layout: `crates/readers/src/btf_stack.md`.

use super::scan::quoted;
use brdfc_formats::FormatError;
use brdfc_formats::direction_set::{DirectionSet, MAX_DIRECTIONS, wrong_angle};
use std::collections::BTreeMap;

/// Extensions of images, in lower case; names may have any case.
pub const EXTENSIONS: [&str; 4] = ["png", "jpg", "jpeg", "exr"];

/// Maximum number of decimals of angles in names, degrees.
const DECIMALS: usize = 4;
/// Minimum number of digits of an angle before the point.
const DIGITS: usize = 3;
/// Longest run of digits that is accepted.
const MAX_DIGITS: usize = 16;

/// Directions of one image: polar angle from the normal and azimuth from the tangent, degrees.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ImageAngles {
    /// To the light: `tl`, `pl`.
    pub light: [f64; 2],
    /// To the viewer: `tv`, `pv`.
    pub view: [f64; 2],
}

/// Index of all images of a stack, sorted by direction.
#[derive(Debug, Clone, PartialEq)]
pub struct StackIndex {
    /// Directions to the viewer, by polar angle, then azimuth.
    pub views: DirectionSet,
    /// Directions to the light, by polar angle, then azimuth.
    pub lights: DirectionSet,
    /// Path of each image as given: view `v` and light `l` at `v * lights.len() + l`.
    pub files: Vec<String>,
}

/// Path of an image relative to the stack's folder: `tv030_pv030/00008 tl000 pl000 tv030 pv030.png`.
///
/// `number` is `light index * views + view index`; `extension` has no point. Angles are rounded to 1e-4 degrees,
/// azimuths wrapped to [0, 360).
pub fn image_name(number: usize, angles: ImageAngles, extension: &str) -> String {
    let [tl, pl] = angles.light.map(angle_text);
    let [tv, pv] = angles.view.map(angle_text);
    format!("tv{tv}_pv{pv}/{number:05} tl{tl} pl{pl} tv{tv} pv{pv}.{extension}")
}

/// Formats an angle with at least three digits, then decimals if there are any.
fn angle_text(degrees: f64) -> String {
    let scale = 10f64.powi(DECIMALS as i32);
    let rounded = ((degrees.rem_euclid(360.0) * scale).round() / scale).rem_euclid(360.0);
    let text = format!("{rounded:0width$.DECIMALS$}", width = DIGITS + 1 + DECIMALS);
    text.trim_end_matches('0').trim_end_matches('.').to_owned()
}

/// Parses the directions in an image's name. Folders and the extension do not count.
///
/// # Errors
/// Returns an error for parts that are missing, repeated or malformed, angles out of range, and anything else in the
/// name.
pub fn parse_name(path: &str) -> Result<ImageAngles, FormatError> {
    let name = path.rsplit('/').next().unwrap_or(path);
    // The last point may belong to an angle.
    let stem = match name.rsplit_once('.') {
        Some((stem, extension)) if !extension.starts_with(|c: char| c.is_ascii_digit()) => stem,
        _ => name,
    };
    let wrong = |field: &'static str, found: String, allowed: &str| FormatError::whole(field, found, allowed);
    let mut parts = [("tl", None), ("pl", None), ("tv", None), ("pv", None)];
    for (position, token) in stem.split([' ', '_']).filter(|token| !token.is_empty()).enumerate() {
        if position == 0 && token.bytes().all(|b| b.is_ascii_digit()) {
            continue;
        }
        let Some((part, slot)) = parts.iter_mut().find(|(part, _)| token.starts_with(part)) else {
            return Err(wrong("image name", quoted(token), "a number, then tl, pl, tv and pv with angles in degrees"));
        };
        if slot.is_some() {
            return Err(wrong(part, "appears twice".to_owned(), "each angle once").problem());
        }
        let number = number(&token[part.len()..]);
        *slot = Some(number.ok_or_else(|| {
            wrong(part, quoted(token), "at least three digits after it, decimals after a point: tl037.5")
        })?);
    }
    let angle = |(part, slot): (&'static str, Option<f64>)| {
        let allowed = "a name such as 00000 tl000 pl000 tv000 pv000.png";
        let missing = || wrong(part, format!("missing in {}", quoted(name)), allowed).problem();
        slot.ok_or_else(missing)
    };
    let [tl, pl, tv, pv] = parts;
    let direction = |theta: (&'static str, Option<f64>), phi: (&'static str, Option<f64>)| {
        let angles = [angle(theta)?, angle(phi)?];
        match wrong_angle(angles) {
            Some(("theta_deg", found, allowed)) => Err(wrong(theta.0, format!("{found} degrees"), allowed)),
            // Names have no signs.
            Some((_, found, _)) => Err(wrong(phi.0, format!("{found} degrees"), "0 to 360")),
            None => Ok(angles),
        }
    };
    Ok(ImageAngles { light: direction(tl, pl)?, view: direction(tv, pv)? })
}

/// Parses digits: at least three before the point, and at least one after it if there is one.
fn number(text: &str) -> Option<f64> {
    let (whole, decimals) = text.split_once('.').map_or((text, None), |(whole, decimals)| (whole, Some(decimals)));
    let digits = |part: &str, least: usize| {
        (least..=MAX_DIGITS).contains(&part.len()) && part.bytes().all(|b| b.is_ascii_digit())
    };
    let good = digits(whole, DIGITS) && decimals.is_none_or(|part| digits(part, 1));
    good.then(|| text.parse().ok()).flatten()
}

/// Returns true if a file counts as an image of a stack, by its extension.
pub fn is_image(path: &str) -> bool {
    let name = path.rsplit('/').next().unwrap_or(path);
    name.rsplit_once('.')
        .is_some_and(|(_, extension)| EXTENSIONS.iter().any(|known| extension.eq_ignore_ascii_case(known)))
}

/// Sort key of a direction: non-negative degrees sort by their bits.
type Key = [u64; 2];

/// Unique key of a direction: the azimuth at the normal is 0, and 360 is 0.
fn key([theta, phi]: [f64; 2]) -> Key {
    let phi = if theta == 0.0 || phi == 360.0 { 0.0 } else { phi };
    // Adding 0 turns -0 into 0.
    [(theta + 0.0).to_bits(), (phi + 0.0).to_bits()]
}

impl StackIndex {
    /// Sorts the images among `paths` (with `/` between folders, relative to the stack); other files are ignored. The
    /// order of `paths` does not matter.
    ///
    /// # Errors
    /// Returns an error for names that [`parse_name`] rejects, two images of one view and light, no images, missing
    /// images, more than [`MAX_DIRECTIONS`] views or lights, and directions closer than
    /// [`brdfc_formats::direction_set::SAME_DIRECTION`].
    pub fn new(paths: &[String]) -> Result<Self, FormatError> {
        let Found { views, lights, images } = Found::new(paths)?;
        check_complete(&views, &lights, &images)?;
        Ok(Self { views, lights, files: images.into_values().cloned().collect() })
    }

    /// Path of one image.
    ///
    /// # Panics
    /// Panics if the view or light does not exist.
    pub fn file(&self, view: usize, light: usize) -> &str {
        assert!(view < self.views.len() && light < self.lights.len(), "view {view}, light {light}");
        &self.files[view * self.lights.len() + light]
    }
}

/// Contents of a stack, complete or not.
#[derive(Debug, Clone, PartialEq)]
pub struct StackContents {
    /// Directions to the viewer, by polar angle, then azimuth.
    pub views: DirectionSet,
    /// Directions to the light, by polar angle, then azimuth.
    pub lights: DirectionSet,
    /// Paths of the images as given, by view, then light.
    pub files: Vec<String>,
    /// Number of pairs of views and lights without an image.
    pub missing: usize,
}

impl StackContents {
    /// Sorts the images among `paths` as [`StackIndex::new`] does.
    ///
    /// # Errors
    /// Returns the errors of [`StackIndex::new`], but accepts pairs of view and light without an image.
    pub fn new(paths: &[String]) -> Result<Self, FormatError> {
        let Found { views, lights, images } = Found::new(paths)?;
        let missing = views.len() * lights.len() - images.len();
        Ok(Self { views, lights, files: images.into_values().cloned().collect(), missing })
    }
}

/// Images by view and light.
struct Found<'a> {
    views: DirectionSet,
    lights: DirectionSet,
    images: BTreeMap<(Key, Key), &'a String>,
}

impl<'a> Found<'a> {
    fn new(paths: &'a [String]) -> Result<Self, FormatError> {
        let mut sorted: Vec<&String> = paths.iter().filter(|path| is_image(path)).collect();
        sorted.sort_unstable();
        let mut images: BTreeMap<(Key, Key), &'a String> = BTreeMap::new();
        // Images without angles in their names may be an RTI capture, with or without its list, which is next to them.
        let is_other = sorted.iter().all(|path| parse_name(path).is_err());
        let is_list = |path: &String| !path.contains('/') && path.to_ascii_lowercase().ends_with(".lp");
        let has_list = paths.iter().any(is_list);
        let hint = match (is_other, has_list) {
            (true, true) => "; with its list of lights (.lp) this is an RTI capture, not a BTF",
            (true, false) => "; an RTI capture requires a list of lights (.lp)",
            (false, _) => "",
        };
        for path in sorted {
            let angles = parse_name(path).map_err(|error| FormatError {
                field: format!("{path}: {}", error.field).into(),
                allowed: format!("{}{hint}", error.allowed).into(),
                ..error
            })?;
            if let Some(first) = images.insert((key(angles.view), key(angles.light)), path) {
                let found = format!("repeats the directions of {first}");
                return Err(FormatError::whole(path.clone(), found, "one image for each view and light").problem());
            }
        }
        if images.is_empty() {
            let allowed = format!("files .{}", EXTENSIONS.join(", ."));
            return Err(FormatError::whole("stack", "no images", allowed).problem());
        }
        let views = directions("views", images.keys().map(|(view, _)| *view))?;
        let lights = directions("lights", images.keys().map(|(_, light)| *light))?;
        Ok(Self { views, lights, images })
    }
}

fn directions(name: &'static str, keys: impl Iterator<Item = Key>) -> Result<DirectionSet, FormatError> {
    let keys: std::collections::BTreeSet<Key> = keys.collect();
    // Checked before all pairs are compared.
    if keys.len() > MAX_DIRECTIONS {
        return Err(FormatError::whole(name, keys.len().to_string(), format!("at most {MAX_DIRECTIONS}")));
    }
    let angles = keys.into_iter().map(|key| key.map(f64::from_bits)).collect();
    DirectionSet::new(name, angles)
        .map_err(|error| FormatError { field: format!("{name}, {}", error.field).into(), ..error })
}

fn check_complete(
    views: &DirectionSet,
    lights: &DirectionSet,
    images: &BTreeMap<(Key, Key), &String>,
) -> Result<(), FormatError> {
    let expected = views.len() * lights.len();
    let missing = expected - images.len();
    if missing == 0 {
        return Ok(());
    }
    let all = views.angles.iter().flat_map(|view| lights.angles.iter().map(move |light| (*view, *light)));
    let first = all.into_iter().find(|(view, light)| !images.contains_key(&(key(*view), key(*light))));
    let name = first.map_or(String::new(), |(view, light)| {
        let [[tl, pl], [tv, pv]] = [light.map(angle_text), view.map(angle_text)];
        format!(", the first at tl{tl} pl{pl} tv{tv} pv{pv}")
    });
    Err(FormatError::whole(
        "stack",
        format!("{missing} of {expected} images missing{name}"),
        format!("images of all {} views under all {} lights", views.len(), lights.len()),
    )
    .problem())
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn names(views: &DirectionSet, lights: &DirectionSet) -> Vec<String> {
        let mut names = Vec::new();
        for (l, light) in lights.angles.iter().enumerate() {
            for (v, view) in views.angles.iter().enumerate() {
                let angles = ImageAngles { light: *light, view: *view };
                names.push(image_name(l * views.len() + v, angles, "png"));
            }
        }
        names
    }

    #[test]
    fn names_of_the_database() {
        let angles = ImageAngles { light: [0.0, 0.0], view: [30.0, 30.0] };
        let name = "tv030_pv030/00008 tl000 pl000 tv030 pv030.png";
        assert_eq!(image_name(8, angles, "png"), name);
        assert_eq!(parse_name(name), Ok(angles));
        // Variants of the name: no number, no folder, underscores, no extension.
        for other in ["tl000 pl000 tv030 pv030.jpg", "7_tl000_pl000_tv030_pv030", "a b/1 pl000 tl000  tv030 pv030.exr"]
        {
            assert_eq!(parse_name(other), Ok(angles), "{other}");
        }
        let angles = ImageAngles { light: [37.5, 7.5], view: [11.0, 359.99999] };
        assert_eq!(image_name(123_456, angles, "exr"), "tv011_pv000/123456 tl037.5 pl007.5 tv011 pv000.exr");
        assert_eq!(parse_name("tl037.5 pl007.5 tv011 pv000").unwrap().light, [37.5, 7.5]);
        assert_eq!(parse_name("tl037.5 pl007.5 tv011 pv000.25").unwrap().view, [11.0, 0.25]);
    }

    #[test]
    fn errors_name_the_part() {
        let text = |name: &str| parse_name(name).unwrap_err().to_string();
        for (name, expected) in [
            ("1 pl000 tv000 pv000.png", "tl: missing in \"1 pl000 tv000 pv000.png\""),
            ("1 tl000 tv000 pv000.png", "pl: missing in"),
            ("1 tl000 pl000 pv000.png", "tv: missing in"),
            ("1 tl000 pl000 tv000.png", "pv: missing in"),
            ("1 tl00 pl000 tv000 pv000.png", "tl: found \"tl00\", expected at least three digits"),
            ("1 tl000 plx00 tv000 pv000.png", "pl: found \"plx00\""),
            ("1 tl000 pl000 tv-10 pv000.png", "tv: found \"tv-10\""),
            ("1 tl000 pl000 tv000 pv000..png", "pv: found \"pv000.\""),
            ("1 tl000 pl000 tv1e1 pv000.png", "tv: found \"tv1e1\""),
            ("1 tl090 pl000 tv000 pv000.png", "tl: found 90 degrees, expected 0 to less than 90"),
            ("1 tl000 pl000 tv000 pv361.png", "pv: found 361 degrees, expected 0 to 360"),
            ("1 tl000 tl000 tv000 pv000.png", "tl: appears twice"),
            ("x1 tl000 pl000 tv000 pv000.png", "image name: found \"x1\""),
            ("1 2 tl000 pl000 tv000 pv000.png", "image name: found \"2\""),
            ("1 tl000 pl000 tv000 pv000 é.png", "image name: found \"é\""),
            ("", "tl: missing in"),
        ] {
            assert!(text(name).starts_with(expected), "{name}: {}", text(name));
        }
        assert!(text(&format!("tl{} pl000 tv000 pv000", "0".repeat(400))).starts_with("tl: found"));
    }

    #[test]
    fn an_index_is_view_major_in_any_order_of_paths() {
        let (views, lights) = (DirectionSet::ubo2003(), DirectionSet::ubo2014());
        let mut paths = names(&views, &lights);
        paths.push("readme.txt".to_owned());
        paths.push("tv000_pv000/Thumbs.db".to_owned());
        let index = StackIndex::new(&paths).unwrap();
        assert_eq!((index.views.angles.clone(), index.lights.angles.clone()), (views.angles, lights.angles));
        assert_eq!(index.files.len(), 81 * 151);
        assert_eq!(index.file(8, 3), "tv030_pv030/00251 tl011 pl135 tv030 pv030.png");
        paths.reverse();
        assert_eq!(StackIndex::new(&paths).unwrap(), index);
    }

    #[test]
    fn one_direction_at_the_normal_and_one_at_full_turn() {
        let paths = ["tl000 pl000 tv000 pv090.png", "tl030 pl360 tv000 pv180.PNG", "tl030 pl010 tv000 pv000.JPeg"];
        let index = StackIndex::new(&paths.map(str::to_owned)).unwrap();
        assert_eq!(index.views.angles, [[0.0, 0.0]]);
        assert_eq!(index.lights.angles, [[0.0, 0.0], [30.0, 0.0], [30.0, 10.0]]);
        assert_eq!(index.file(0, 1), paths[1]);
    }

    #[test]
    fn incomplete_and_ambiguous_stacks() {
        let text = |paths: &[String]| StackIndex::new(paths).unwrap_err().to_string();
        let set = DirectionSet::grid(2, 3, 30.0).unwrap();
        let full = names(&set, &set);
        let mut paths = full.clone();
        paths.retain(|path| !path.contains("tl030 pl120 tv030") && !path.contains("tl030 pl000 tv030 pv240"));
        assert_eq!(
            text(&paths),
            "stack: 4 of 16 images missing, the first at tl030 pl120 tv030 pv000; \
             expected images of all 4 views under all 4 lights"
        );
        let mut paths = full.clone();
        paths.push("copy/tl000 pl005 tv030 pv000.png".to_owned());
        assert!(
            text(&paths).starts_with("tv030_pv000/00001 tl000 pl000 tv030 pv000.png: repeats the directions of copy/")
        );
        paths = full.clone();
        paths.push("tv000_pv000/preview.jpg".to_owned());
        assert!(text(&paths).starts_with("tv000_pv000/preview.jpg: image name: found \"preview\""));
        let hint = "; an RTI capture requires a list of lights (.lp)";
        assert!(!text(&paths).contains(hint) && text(&["a/IMG_7.jpg".to_owned()]).ends_with(hint));
        let capture = ["IMG_7.jpg", "dome.LP"].map(str::to_owned);
        assert!(text(&capture).ends_with("; with its list of lights (.lp) this is an RTI capture, not a BTF"));
        // Only the list of the folder itself is read.
        assert!(text(&capture.map(|path| format!("a/{path}"))).ends_with(hint));
        assert!(text(&[]).starts_with("stack: no images"));
        assert!(text(&["a.txt".to_owned()]).contains(".png, .jpg, .jpeg, .exr"));
        let near = ["tl000 pl000 tv000 pv000.png", "tl000.00001 pl000 tv000 pv000.png"].map(str::to_owned);
        assert!(text(&near).starts_with("lights, direction 1: equal to direction 0"), "{}", text(&near));
        let many: Vec<String> = (0..2049).map(|k| format!("tl010.{k:04} pl000 tv000 pv000.png")).collect();
        assert!(text(&many).starts_with("lights: found 2049, expected at most 2048"));
        assert!(StackIndex::new(&full).is_ok());
        let contents = StackContents::new(&full[..14]).unwrap();
        assert_eq!((contents.views.len(), contents.lights.len()), (4, 4));
        assert_eq!((contents.files.len(), contents.missing), (14, 2));
    }

    proptest! {
        #[test]
        fn names_round_trip(theta in 0.0f64..89.9, phi in -360.0f64..360.0, number in 0usize..200_000) {
            let angles = ImageAngles { light: [theta, phi], view: [phi.abs() / 5.0, theta] };
            let read = parse_name(&image_name(number, angles, "png")).unwrap();
            for (a, b) in [(read.light, angles.light), (read.view, angles.view)] {
                let turn = (a[1] - b[1]).rem_euclid(360.0);
                prop_assert!((a[0] - b[0]).abs() < 6e-5 && turn.min(360.0 - turn) < 6e-5, "{:?} {:?}", a, b);
            }
        }

        #[test]
        fn no_name_panics(name in "\\PC{0,40}", tokens in "(tl|pl|tv|pv| |_|\\.|0|9|é){0,36}") {
            let _ = parse_name(&name);
            let _ = StackIndex::new(&[format!("{name}.png"), format!("{tokens}.jpg")]);
        }
    }
}
