//! EXR: one colour layer, placed into the display window.

use super::ask::{Ask, ImageReader, Purpose, rewind};
use super::colour::{Colour, Curve};
use super::header::Header;
use super::orientation::Orientation;
use super::raster::{Depth, Raster, Samples};
use brdfc_core::words::{join_truncated, one_line, one_of};
use brdfc_formats::FormatError;
use brdfc_formats::memory::{filled, summary};
use exr::block::reader::ChunksReader;
use exr::meta::BlockDescription;
use exr::meta::attribute::{ChannelDescription, SampleType};
use exr::meta::header::Header as Part;
use exr::prelude::{MetaData, Vec2, f16};
use std::collections::BTreeMap;
use std::io::{BufRead, Seek};

/// Maximum size of a block (a tile or a few lines with all channels) before compression, bytes: the decoder holds whole
/// blocks in memory.
const MAX_BLOCK_BYTES: u64 = 128 << 20;
/// Maximum width and height of a data window, pixels.
const MAX_DATA_SIDE: usize = 1 << 16;
/// Last part of the names of layers with the whole image, as Blender and other renderers write them.
const BEAUTY: [&str; 3] = ["Combined", "Beauty", "RGBA"];
/// Maximum number of layers or channels that an error names.
const MAX_NAMED: usize = 8;

/// Reads the headers of an EXR.
///
/// # Errors
/// Returns an error for files that are not EXR and for blocks of more than 128 MiB.
fn headers(bytes: impl BufRead + Seek, allowed: &str) -> Result<Vec<Part>, FormatError> {
    let meta = MetaData::read_from_buffered(bytes, false)
        .map_err(|error| FormatError::whole("EXR", one_line(&error), allowed).problem())?;
    for header in &meta.headers {
        let [width, height] = match header.blocks {
            BlockDescription::ScanLines => [header.layer_size.x(), header.compression.scan_lines_per_block()],
            BlockDescription::Tiles(tiles) => [tiles.tile_size.x(), tiles.tile_size.y()],
        };
        let sides = [width, height, header.channels.bytes_per_pixel].map(|side| side as u64);
        let size = sides.into_iter().fold(1, u64::saturating_mul);
        if size > MAX_BLOCK_BYTES {
            let channels = header.channels.list.len();
            let found = format!("{} in a block of {width} x {height} pixels of {channels} channels", summary(size));
            return Err(FormatError::whole("EXR", found, format!("at most {}", summary(MAX_BLOCK_BYTES))));
        }
    }
    Ok(meta.headers.into_iter().collect())
}

/// Channels to read: their part of the file, and their indices in it.
struct Layer {
    part: usize,
    name: String,
    channels: Vec<usize>,
    /// Reason for the choice; `None` for the only layer, without a name.
    note: Option<String>,
}

pub(super) fn header(reader: &mut impl ImageReader, ask: &Ask<'_>) -> Result<Header, FormatError> {
    let (parts, layer) = open(reader, ask)?;
    let part = &parts[layer.part];
    let (size, display, position) = windows(part);
    let [width, height] = [part.layer_size.x(), part.layer_size.y()];
    let colour = ask.colour(|| match part.shared_attributes.chromaticities {
        Some(all) => {
            let primaries = [all.red, all.green, all.blue, all.white].map(|Vec2(x, y)| [x, y].map(f64::from));
            Colour::of_curve("chromaticities of EXR", Curve::LINEAR, Some(primaries))
        }
        None => Ok(Colour::linear("linear (EXR)")),
    })?;
    let window = ([width, height] != size || position != display).then(|| {
        let [x, y] = [position[0] - display[0], position[1] - display[1]];
        format!("data window of {width} x {height} at ({x}, {y}) of {} x {}; 0 around it", size[0], size[1])
    });
    Ok(Header {
        size,
        channels: layer.channels.len(),
        depth: Depth::F32,
        colour,
        orientation: Orientation::UPRIGHT,
        notes: layer.note.into_iter().chain(window).collect(),
    })
}

/// Size of the display window, and the corners of it and of the data window.
fn windows(part: &Part) -> ([usize; 2], [i64; 2], [i64; 2]) {
    let display = part.shared_attributes.display_window;
    let corner = |Vec2(x, y): Vec2<i32>| [x, y].map(i64::from);
    ([display.size.x(), display.size.y()], corner(display.position), corner(part.own_attributes.layer_position))
}

/// Reads the headers, checks sizes, and chooses a layer.
fn open(reader: &mut impl ImageReader, ask: &Ask<'_>) -> Result<(Vec<Part>, Layer), FormatError> {
    let parts = headers(reader, ask.allowed)?;
    for part in &parts {
        let (display, data) = (windows(part).0, part.layer_size);
        ask.check_size(display)?;
        if data.x().max(data.y()) > MAX_DATA_SIDE {
            let found = format!("a data window of {} x {}", data.x(), data.y());
            return Err(FormatError::whole("EXR", found, format!("at most {MAX_DATA_SIDE} along each side")));
        }
    }
    let layer = if ask.purpose == Purpose::Heights { heights(&parts, ask)? } else { colours(&parts, ask)? };
    let part = &parts[layer.part];
    if part.deep {
        return Err(ask.found("deep data"));
    }
    for channel in &layer.channels {
        let ChannelDescription { name, sampling, .. } = &part.channels.list[*channel];
        if *sampling != Vec2(1, 1) {
            let found = format!("channel {name} has fewer samples than pixels");
            return Err(FormatError::whole("EXR", found, "one sample per pixel").problem());
        }
    }
    Ok((parts, layer))
}

/// Channels of one name up to the last point.
struct Group {
    part: usize,
    /// Name, after that of the part if there are several; empty without both.
    name: String,
    /// Names after the last point, and indices in the part.
    channels: Vec<(String, usize)>,
}

impl Group {
    fn channel(&self, label: &str) -> Option<usize> {
        self.channels.iter().find(|(name, _)| name.eq_ignore_ascii_case(label)).map(|(_, index)| *index)
    }

    /// Channel Y, unless it is of a vector, such as a normal.
    fn luminance(&self) -> Option<usize> {
        self.channel("Y").filter(|_| self.channel("X").is_none())
    }
}

fn groups(parts: &[Part]) -> Vec<Group> {
    let mut groups: BTreeMap<(usize, String), Vec<(String, usize)>> = BTreeMap::new();
    for (number, part) in parts.iter().enumerate() {
        for (index, channel) in part.channels.list.iter().enumerate() {
            let name = channel.name.to_string();
            let (of, suffix) = name.rsplit_once('.').unwrap_or(("", &name));
            groups.entry((number, of.to_owned())).or_default().push((suffix.to_owned(), index));
        }
    }
    let group = |((part, of), channels): ((usize, String), Vec<(String, usize)>)| {
        let parent = parts[part].own_attributes.layer_name.as_ref().filter(|_| parts.len() > 1);
        let names = parent.map(|name| name.to_string()).into_iter().chain([of]);
        let name = names.filter(|name| !name.is_empty()).collect::<Vec<_>>().join(".");
        Group { part, name, channels }
    };
    groups.into_iter().map(group).collect()
}

/// Takes the only layer, or else the one without a name, or else the only one whose name ends with one of `names`; `None`
/// without layers.
fn choose(mut layers: Vec<Layer>, of: &str, names: &[&str]) -> Option<Result<Layer, FormatError>> {
    let count = layers.len();
    let is_named = |layer: &Layer| {
        let last = layer.name.rsplit('.').next().unwrap_or("");
        names.iter().any(|name| last.eq_ignore_ascii_case(name))
    };
    let only = |is: &dyn Fn(&Layer) -> bool| {
        let mut found = (0..count).filter(|at| is(&layers[*at]));
        found.next().filter(|_| found.next().is_none())
    };
    let chosen = match count {
        0 => return None,
        1 => Some(0),
        _ => only(&|layer| layer.name.is_empty()).or_else(|| only(&is_named)),
    };
    let Some(chosen) = chosen else {
        let found: Vec<&String> = layers.iter().map(|layer| &layer.name).collect();
        let found = format!("layers {}", join_truncated(&found, MAX_NAMED));
        let named = if names.is_empty() { String::new() } else { format!(", or one named {}", one_of(names)) };
        let allowed = format!("one layer of {of}, or one without a name{named}");
        return Some(Err(FormatError::whole("EXR", found, allowed)));
    };
    let layer = layers.swap_remove(chosen);
    let name = if layer.name.is_empty() { "without a name" } else { &layer.name };
    let note = match count {
        1 => (!layer.name.is_empty()).then(|| format!("layer {name}")),
        _ => Some(format!("layer {name}, of {count} layers of {of}")),
    };
    Some(Ok(Layer { note, ..layer }))
}

/// Chooses the layer of R, G and B, or of Y.
fn colours(parts: &[Part], ask: &Ask<'_>) -> Result<Layer, FormatError> {
    let of = |group: Group| {
        let rgb: Option<Vec<usize>> = ["R", "G", "B"].iter().map(|name| group.channel(name)).collect();
        // Luminance with chroma is no grey.
        let is_grey = group.channel("RY").is_none() && group.channel("BY").is_none();
        let grey = group.luminance().filter(|_| is_grey).map(|y| vec![y]);
        rgb.or(grey).map(|channels| Layer { part: group.part, name: group.name, channels, note: None })
    };
    let found = groups(parts).into_iter().filter_map(of).collect();
    choose(found, "colours", &BEAUTY).unwrap_or_else(|| Err(ask.found(channel_names(parts))))
}

/// Chooses the channel of heights: Y, else R, else the only one.
fn heights(parts: &[Part], ask: &Ask<'_>) -> Result<Layer, FormatError> {
    let all = groups(parts);
    let layer = |group: &Group, channel| {
        let Group { part, ref name, .. } = *group;
        Layer { part, name: name.clone(), channels: vec![channel], note: None }
    };
    let of = |channel: &dyn Fn(&Group) -> Option<usize>| {
        all.iter().filter_map(|group| Some(layer(group, channel(group)?))).collect()
    };
    let single = match &all[..] {
        [group] if group.channels.len() == 1 => vec![layer(group, group.channels[0].1)],
        _ => Vec::new(),
    };
    let found = [of(&Group::luminance), of(&|group| group.channel("R")), single]
        .into_iter()
        .find_map(|layers| choose(layers, "heights", &[]));
    let allowed = "an EXR with a channel Y or R, or with one channel";
    found.unwrap_or_else(|| Err(FormatError::whole(ask.field, channel_names(parts), allowed)))
}

fn channel_names(parts: &[Part]) -> String {
    let names: Vec<String> = parts.iter().flat_map(|part| &part.channels.list).map(|c| c.name.to_string()).collect();
    format!("channels {}", join_truncated(&names, MAX_NAMED))
}

pub(super) fn samples(mut reader: impl ImageReader, ask: &Ask<'_>) -> Result<Raster, FormatError> {
    let (parts, layer) = open(&mut reader, ask)?;
    rewind(&mut reader, ask)?;
    let part = &parts[layer.part];
    let (size, display, position) = windows(part);
    let channels = layer.channels.len();
    let mut pixels = filled("pixels", size[0] * size[1] * channels, 0f32)?;
    let broken = |error: exr::error::Error| ask.broken(error);
    let chunks = exr::block::read(reader, false).map_err(broken)?;
    let chunks = chunks
        .filter_chunks(false, |_, tile, block| block.layer == layer.part && tile.level_index == Vec2(0, 0))
        .map_err(broken)?;
    let mut read = 0;
    for block in chunks.sequential_decompressor(false) {
        let block = block.map_err(broken)?;
        for line in block.lines(&part.channels) {
            let Some(channel) = layer.channels.iter().position(|channel| *channel == line.location.channel) else {
                continue;
            };
            read += line.location.sample_count;
            let row = line.location.position.y() as i64 + position[1] - display[1];
            let Some(row) = usize::try_from(row).ok().filter(|row| *row < size[1]) else { continue };
            let values: Vec<f32> = match part.channels.list[line.location.channel].sample_type {
                SampleType::F16 => line.read_samples::<f16>().map(|v| v.map(f16::to_f32)).collect::<Result<_, _>>(),
                SampleType::F32 => line.read_samples::<f32>().collect(),
                SampleType::U32 => line.read_samples::<u32>().map(|v| v.map(|v| v as f32)).collect(),
            }
            .map_err(broken)?;
            let first = line.location.position.x() as i64 + position[0] - display[0];
            for (column, value) in (first..).zip(values) {
                if let Some(column) = usize::try_from(column).ok().filter(|column| *column < size[0]) {
                    pixels[(row * size[0] + column) * channels + channel] = value;
                }
            }
        }
    }
    let expected = part.layer_size.area() * channels;
    if read != expected {
        return Err(ask.broken(format!("{read} of {expected} samples")));
    }
    Ok(Raster { size, channels, samples: Samples::F32(pixels) })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::meso::heights_from_exr;
    use crate::radiance_image::from_exr;
    use std::io::Cursor;

    /// A file with `channels` channels whose only block is too short.
    fn exr_of_channels(width: u32, height: u32, channels: usize) -> Vec<u8> {
        let mut bytes = Vec::from(20_000_630u32.to_le_bytes());
        bytes.extend(2u32.to_le_bytes());
        let mut attribute = |name: &str, kind: &str, value: &[u8]| {
            bytes.extend(format!("{name}\0{kind}\0").bytes());
            bytes.extend((value.len() as u32).to_le_bytes());
            bytes.extend(value);
        };
        let list = (0..channels).flat_map(|k| {
            let name = ["B", "G", "R", "Y"].get(k).map_or(format!("Z{k:06}"), |name| (*name).to_owned());
            let mut entry = format!("{name}\0").into_bytes();
            entry.extend([2, 0, 0, 0, 0, 0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0]);
            entry
        });
        attribute("channels", "chlist", &list.chain([0]).collect::<Vec<u8>>());
        attribute("compression", "compression", &[3]);
        let window = [0, 0, width - 1, height - 1].map(u32::to_le_bytes).concat();
        attribute("dataWindow", "box2i", &window);
        attribute("displayWindow", "box2i", &window);
        attribute("lineOrder", "lineOrder", &[0]);
        attribute("pixelAspectRatio", "float", &1f32.to_le_bytes());
        attribute("screenWindowCenter", "v2f", &[0; 8]);
        attribute("screenWindowWidth", "float", &1f32.to_le_bytes());
        bytes.push(0);
        let blocks = height.div_ceil(16) as usize;
        let data = bytes.len() + 8 * blocks;
        (0..blocks).for_each(|_| bytes.extend((data as u64).to_le_bytes()));
        // Deflate stream without data.
        bytes.extend([&[0; 4][..], &8u32.to_le_bytes(), &[0x78, 0x9c, 3, 0, 0, 0, 0, 1]].concat());
        bytes
    }

    #[test]
    fn blocks_are_of_a_size() {
        let few = exr_of_channels(1024, 16, 4);
        assert_eq!(headers(Cursor::new(&few), "an EXR").unwrap()[0].channels.list.len(), 4);
        let many = exr_of_channels(1024, 16, 200_000);
        let expected =
            "EXR: found 12.21 GiB in a block of 1024 x 16 pixels of 200000 channels, expected at most 128.00 MiB";
        assert_eq!(heights_from_exr(&many).unwrap_err().to_string(), expected);
        assert_eq!(from_exr(&many).unwrap_err().to_string(), expected);
        // The contents of the block do not matter: with fewer channels the pixels are the error.
        assert!(from_exr(&few).unwrap_err().to_string().ends_with("expected channels R, G and B, or Y"));
    }
}
