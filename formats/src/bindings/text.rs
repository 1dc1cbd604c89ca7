//! Text form of the list of bindings, one per line, under the key `brdfc.bindings`.

use super::{
    Bindings, FRAME_SLOT, MAX_BINDINGS, MAX_SLOTS, MAX_TEXTURES, MAX_UNIFORM_BYTES, MAX_UNIFORMS, Resource, Stored,
};
use crate::FormatError;
use crate::container::{CUBE_FACES, Extent, TexelFormat};
use crate::words::one_of;
use std::collections::BTreeSet;

/// Key that identifies a texture as a pack.
pub(super) const ENTRY: &str = "brdfc.bindings";

/// Maximum length of the name of a binding or a decoder.
const MAX_NAME: usize = 64;

/// A line that describes a binding, without its bytes.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Line<'t> {
    /// Line number, from 1.
    pub number: usize,
    pub slot: u32,
    pub name: &'t str,
    pub kind: Kind<'t>,
}

#[derive(Debug, Clone, PartialEq)]
pub(super) enum Kind<'t> {
    Frame,
    Uniform { bytes: u32 },
    Texture { stored: Stored, format: TexelFormat, extent: Extent, levels: u32, sampler: Option<&'t str> },
    Sampler { repeats: bool },
}

const STORED: [(&str, Stored); 3] = [("file", Stored::File), ("entry", Stored::Entry), ("empty", Stored::Empty)];
const ADDRESSING: [(&str, bool); 2] = [("clamp", false), ("repeat", true)];
/// Stands for the sampler of textures that the shader only loads.
const NO_SAMPLER: &str = "-";

impl Bindings<'_> {
    /// Value for [`ENTRY`].
    pub(super) fn to_text(&self) -> String {
        let mut text = format!("decoder {} {}\n", self.decoder, self.version);
        for binding in &self.all {
            let what = match &binding.resource {
                Resource::Frame => "frame".to_owned(),
                Resource::Uniform(bytes) => format!("uniform {}", bytes.len()),
                Resource::Sampler { repeats } => format!("sampler {}", ADDRESSING[usize::from(*repeats)].0),
                Resource::Texture(texels) => {
                    let stored =
                        STORED.iter().find(|(_, stored)| *stored == texels.stored).map_or("", |(name, _)| name);
                    let (dimension, format) = (texels.extent.dimension(), texels.format.name());
                    let [width, height, depth] = texels.extent.size();
                    let sampler = texels.sampler.as_deref().unwrap_or(NO_SAMPLER);
                    format!(
                        "texture {stored} {dimension} {format} {width} {height} {depth} {} {sampler}",
                        texels.levels
                    )
                }
            };
            text += &format!("{} {} {what}\n", binding.slot, binding.name);
        }
        text + "\0"
    }
}

/// Parses the value of [`ENTRY`]: decoder, version and lines. Checks each line and their combination.
///
/// # Errors
/// Returns an error that names the line, its contents and the expected contents.
pub(super) fn parse(value: &[u8]) -> Result<(&str, u32, Vec<Line<'_>>), FormatError> {
    let text = std::str::from_utf8(value).ok().and_then(|text| text.strip_suffix("\n\0"));
    let text = text.ok_or_else(|| {
        FormatError::whole(
            ENTRY,
            format!("{} bytes that are not valid text", value.len()),
            "lines of UTF-8 text that end with a zero byte",
        )
        .problem()
    })?;
    // `lines` would also accept carriage returns before line ends.
    let mut lines = text.split('\n');
    let first = lines.next().unwrap_or_default();
    let (decoder, version) = match first.split(' ').collect::<Vec<_>>()[..] {
        ["decoder", name, version] if is_name(name) => (name, number(1, version, 1..=u32::MAX)?),
        _ => return Err(wrong(1, first, "'decoder', its name and its version")),
    };
    let lines: Vec<&str> = lines.take(MAX_BINDINGS + 1).collect();
    let allowed = || format!("1 to {MAX_BINDINGS}");
    if lines.is_empty() {
        return Err(FormatError::whole(ENTRY, "no bindings", allowed()).problem());
    }
    if lines.len() > MAX_BINDINGS {
        return Err(FormatError::whole(format!("{ENTRY} bindings"), format!("more than {MAX_BINDINGS}"), allowed()));
    }
    let lines = (2..).zip(lines).map(|(at, line)| parse_line(at, line)).collect::<Result<Vec<_>, _>>()?;
    check_together(&lines)?;
    Ok((decoder, version, lines))
}

fn parse_line(at: usize, line: &str) -> Result<Line<'_>, FormatError> {
    let words: Vec<&str> = line.split(' ').collect();
    let [slot, name, kind, ref rest @ ..] = words[..] else {
        return Err(wrong(at, line, "a slot, a name and a resource"));
    };
    let slot = number(at, slot, 0..=MAX_SLOTS - 1)?;
    if !is_name(name) {
        return Err(wrong(at, name, "a name of a to z, 0 to 9, - and _"));
    }
    let kind = match (kind, rest) {
        ("frame", []) if slot == FRAME_SLOT => Kind::Frame,
        ("frame", []) => return Err(wrong(at, &slot.to_string(), "slot 0 for a frame")),
        ("uniform", [bytes]) => {
            let bytes = number(at, bytes, 16..=MAX_UNIFORM_BYTES)?;
            if bytes % 16 != 0 {
                return Err(wrong(at, &bytes.to_string(), "a multiple of 16"));
            }
            Kind::Uniform { bytes }
        }
        ("sampler", [mode]) => Kind::Sampler { repeats: named(at, mode, &ADDRESSING)? },
        ("texture", [stored, dimension, format, width, height, depth, levels, sampler]) => {
            let stored = named(at, stored, &STORED)?;
            let format =
                TexelFormat::from_name(format).ok_or_else(|| wrong(at, format, "a texel format that packs support"))?;
            let [width, height, depth] =
                [(width, 1), (height, 1), (depth, 1)].map(|(side, least)| number(at, side, least..=u32::MAX));
            let size = [width?, height?, depth?];
            let extent = Extent::from_dimension(dimension, size).ok_or_else(|| {
                wrong(at, &format!("{dimension} of {size:?}"), "2d, 2d-array, 3d or cube, of a size that packs support")
            })?;
            let levels = number(at, levels, 1..=extent.most_levels())?;
            // All faces of a cube map have their texel.
            let texels = if *dimension == "cube" { CUBE_FACES } else { 1 };
            if stored == Stored::Empty && (extent.texels() != u64::from(texels) || levels != 1) {
                return Err(wrong(at, &format!("{size:?}"), "one texel for an empty texture"));
            }
            let sampler = (*sampler != NO_SAMPLER).then_some(*sampler);
            Kind::Texture { stored, format, extent, levels, sampler }
        }
        _ => return Err(wrong(at, line, "frame, uniform, texture or sampler with its fields")),
    };
    Ok(Line { number: at, slot, name, kind })
}

fn check_together(lines: &[Line<'_>]) -> Result<(), FormatError> {
    let mut names = BTreeSet::new();
    for (k, line) in lines.iter().enumerate() {
        if k > 0 && line.slot <= lines[k - 1].slot {
            return Err(wrong(line.number, &format!("slot {}", line.slot), "slots in ascending order, each once"));
        }
        if !names.insert(line.name) {
            return Err(wrong(line.number, line.name, "a unique name"));
        }
        if let Kind::Texture { sampler: Some(sampler), format, .. } = &line.kind {
            let is_there =
                lines.iter().any(|other| other.name == *sampler && matches!(other.kind, Kind::Sampler { .. }));
            if !is_there {
                return Err(wrong(line.number, sampler, "the name of a sampler in the list, or -"));
            }
            if format.is_integer() {
                return Err(wrong(line.number, sampler, "-, because integers are not filtered"));
            }
        }
    }
    let count = |is: &dyn Fn(&Kind<'_>) -> bool| lines.iter().filter(|line| is(&line.kind)).count();
    for (what, found, most) in [
        ("textures", count(&|kind| matches!(kind, Kind::Texture { .. })), MAX_TEXTURES),
        ("samplers", count(&|kind| matches!(kind, Kind::Sampler { .. })), MAX_TEXTURES),
        ("uniform blocks", count(&|kind| matches!(kind, Kind::Uniform { .. } | Kind::Frame)), MAX_UNIFORMS),
    ] {
        if found > most {
            return Err(FormatError::whole(format!("{ENTRY} {what}"), found.to_string(), format!("at most {most}")));
        }
    }
    let of_file = count(&|kind| matches!(kind, Kind::Texture { stored: Stored::File, .. }));
    if of_file != 1 {
        let found = format!("{of_file} bindings of the file's own texture");
        return Err(FormatError::whole(ENTRY, found, "one"));
    }
    Ok(())
}

fn is_name(word: &str) -> bool {
    let is_letter = |letter: u8| matches!(letter, b'a'..=b'z' | b'0'..=b'9' | b'_' | b'-');
    (1..=MAX_NAME).contains(&word.len()) && word.bytes().all(is_letter)
}

/// Parses a number without leading zeros.
fn number(at: usize, word: &str, range: std::ops::RangeInclusive<u32>) -> Result<u32, FormatError> {
    let found = word.parse::<u32>().ok().filter(|found| found.to_string() == word && range.contains(found));
    found.ok_or_else(|| wrong(at, word, &format!("{} to {}", range.start(), range.end())))
}

fn named<T: Copy>(at: usize, word: &str, items: &[(&str, T)]) -> Result<T, FormatError> {
    let found = items.iter().find(|(name, _)| *name == word).map(|(_, value)| *value);
    found.ok_or_else(|| wrong(at, word, &one_of(&items.iter().map(|(name, _)| *name).collect::<Vec<_>>())))
}

pub(super) fn wrong(line: usize, found: &str, allowed: &str) -> FormatError {
    FormatError::whole(format!("{ENTRY} line {line}"), found, allowed)
}
