//! File of a pack: its own texture, further images and uniform blocks as key/value data, and the list of bindings that
//! names them.

use super::text::{self, ENTRY, Kind, wrong};
use super::{Binding, Bindings, Resource, Stored, Texels};
use crate::FormatError;
use crate::container::{MAX_TEXEL_BYTES, PackedTexture, Texture, checksum, entries as container_entries};
use std::borrow::Cow;
use std::collections::BTreeMap;

/// Prefix of the key of an image, followed by the name of its binding. The value is a KTX2 file.
const IMAGE: &str = "brdfc.image.";
/// Prefix of the key of a uniform block, followed by the name of its binding. The value is the block.
const UNIFORM: &str = "brdfc.uniform.";

/// A pack whose bindings have been read, independent of its codec.
#[derive(Debug, Clone, PartialEq)]
pub struct PackFile {
    /// Bindings of the shader that decodes the pack.
    pub bindings: Bindings<'static>,
    /// Other `brdfc.*` key/value data, specific to the codec.
    pub entries: BTreeMap<String, Vec<u8>>,
}

impl Bindings<'_> {
    /// Contents of a KTX2 file with these bindings and the codec's own key/value data.
    ///
    /// # Panics
    /// Panics if no texture is stored as the texture of the file.
    pub fn to_file(&self, own: BTreeMap<String, Vec<u8>>, supercompress: bool) -> Vec<u8> {
        let mut entries = own;
        entries.insert(ENTRY.to_owned(), self.to_text().into_bytes());
        for binding in &self.all {
            match &binding.resource {
                Resource::Uniform(bytes) => {
                    entries.insert(format!("{UNIFORM}{}", binding.name), bytes.to_vec());
                }
                Resource::Texture(texels) if texels.stored == Stored::Entry => {
                    let image = texels.to_texture(BTreeMap::new()).to_bytes(supercompress);
                    entries.insert(format!("{IMAGE}{}", binding.name), image);
                }
                _ => {}
            }
        }
        let file = self.of_file().expect("a pack has a texture of its own");
        let mut texture = file.to_texture(entries);
        texture.entries.insert(checksum::ENTRY.to_owned(), vec![0; checksum::BYTES]);
        let mut bytes = texture.to_bytes(supercompress);
        checksum::seal(&mut bytes);
        bytes
    }
}

impl Texels<'_> {
    fn to_texture(&self, entries: BTreeMap<String, Vec<u8>>) -> Texture {
        self.clone().into_texture(entries)
    }

    fn into_texture(self, entries: BTreeMap<String, Vec<u8>>) -> Texture {
        let Self { format, extent, levels, bytes, .. } = self;
        Texture { format, extent, entries, levels, texels: bytes.into_owned() }
    }
}

impl PackFile {
    /// Reads a pack of any codec. Checks the checksum, the bindings, and that images match the bindings.
    ///
    /// # Errors
    /// Returns an error if the file is not a pack, is damaged, or has images that differ from its bindings.
    pub fn from_bytes(bytes: &[u8]) -> Result<Self, FormatError> {
        Self::from_packed(PackedTexture::from_bytes(bytes)?)
    }

    /// Same as [`Self::from_bytes`] for a file whose container has been read.
    ///
    /// # Errors
    /// Returns an error if the file is not a pack, is damaged, or has images that differ from its bindings.
    pub fn from_packed(mut packed: PackedTexture<'_>) -> Result<Self, FormatError> {
        let mut entries = std::mem::take(&mut packed.entries);
        let Some(list) = entries.remove(ENTRY) else {
            let keys: Vec<&str> = entries.keys().map(String::as_str).collect();
            return Err(container_entries::missing(ENTRY, &keys, "a pack"));
        };
        packed.check_sum(entries.remove(checksum::ENTRY).as_deref())?;
        let (decoder, version, lines) = text::parse(&list)?;
        // All sizes are checked before any texel is decompressed.
        let mut left = MAX_TEXEL_BYTES;
        for line in &lines {
            if let Kind::Texture { format, extent, levels, .. } = line.kind {
                let bytes = extent.texels_of_levels(levels) * format.texel_bytes() as u64;
                left = left.checked_sub(bytes).ok_or_else(|| {
                    let allowed = format!("at most {MAX_TEXEL_BYTES} for all images");
                    wrong(line.number, &format!("{bytes} more bytes of texels"), &allowed)
                })?;
            }
        }
        let mut own = Some(packed);
        let mut all = Vec::with_capacity(lines.len());
        for line in &lines {
            let resource = match &line.kind {
                Kind::Frame => Resource::Frame,
                Kind::Sampler { repeats } => Resource::Sampler { repeats: *repeats },
                Kind::Uniform { bytes } => {
                    let key = format!("{UNIFORM}{}", line.name);
                    let value = entries.remove(&key).ok_or_else(|| missing(line.number, &key))?;
                    if value.len() != *bytes as usize {
                        let allowed = format!("{bytes}, as {ENTRY} line {} says", line.number);
                        return Err(FormatError::whole(key, format!("{} bytes", value.len()), allowed));
                    }
                    Resource::Uniform(value.into())
                }
                Kind::Texture { stored, format, extent, levels, sampler } => {
                    let sampler = sampler.map(|name| Cow::Owned(name.to_owned()));
                    let expected = Texels { levels: *levels, sampler, ..Texels::empty(*format, *extent) };
                    Resource::Texture(match stored {
                        Stored::Empty => expected,
                        Stored::File => {
                            filled(own.take().expect("checked to be one"), expected, "texture", line.number)?
                        }
                        Stored::Entry => {
                            let key = format!("{IMAGE}{}", line.name);
                            let value = entries.remove(&key).ok_or_else(|| missing(line.number, &key))?;
                            let inside = |error: FormatError| FormatError {
                                field: format!("{key}, {}", error.field).into(),
                                ..error
                            };
                            let image = PackedTexture::from_bytes(&value).map_err(inside)?;
                            if let Some(entry) = image.entries.keys().next() {
                                return Err(inside(FormatError::whole("keys", entry.clone(), "no brdfc keys")));
                            }
                            let texels = filled(image, expected, &key, line.number).map_err(|error| {
                                match error.field == key {
                                    true => error,
                                    false => inside(error),
                                }
                            })?;
                            Texels { stored: Stored::Entry, ..texels }
                        }
                    })
                }
            };
            all.push(Binding { slot: line.slot, name: line.name.to_owned().into(), resource });
        }
        if let Some(key) = entries.keys().find(|key| key.starts_with(IMAGE) || key.starts_with(UNIFORM)) {
            let allowed = format!("keys that {ENTRY} names");
            return Err(FormatError::whole(key.clone(), "no binding names this key", allowed).problem());
        }
        let bindings = Bindings { decoder: decoder.to_owned().into(), version, all };
        Ok(Self { bindings, entries })
    }

    /// Name of a pack's decoder from the first [`Self::HEAD_BYTES`] of its file; `None` for other files.
    pub fn decoder_in(head: &[u8]) -> Option<&str> {
        let first = [ENTRY.as_bytes(), b"\0decoder "].concat();
        let at = head.windows(first.len()).position(|bytes| bytes == first)? + first.len();
        head.starts_with(b"\xabKTX 20\xbb").then_some(())?;
        std::str::from_utf8(head[at..].split(|byte| matches!(byte, b' ' | b'\n')).next()?).ok()
    }

    /// Length of the start of a file that contains the name of the decoder, bytes.
    pub const HEAD_BYTES: usize = 4096;

    /// Name of the decoder if the texture is a pack.
    pub(crate) fn decoder_of<'t>(packed: &'t PackedTexture<'_>) -> Option<&'t str> {
        let line = packed.entries.get(ENTRY)?.split(|byte| *byte == b'\n').next()?;
        std::str::from_utf8(line).ok()?.strip_prefix("decoder ")?.split(' ').next()
    }

    /// Checks that the bindings equal the bindings that the codec derives from the pack. Texels are not compared, as
    /// the pack was read from them.
    ///
    /// # Errors
    /// Returns an error that names the first line or block that differs.
    pub(crate) fn check_same(&self, made: &Bindings<'_>) -> Result<(), FormatError> {
        let (found, expected) = (self.bindings.to_text(), made.to_text());
        let [mut found, mut expected] = [&found, &expected].map(|text| text.trim_end_matches('\0').lines());
        for number in 1.. {
            match (found.next(), expected.next()) {
                (None, None) => break,
                (found, expected) if found == expected => {}
                (found, expected) => {
                    let allowed = format!("{}, as the codec's metadata says", expected.unwrap_or("no line"));
                    return Err(match found {
                        Some(found) => wrong(number, found, &allowed),
                        None => wrong(number, "missing", &allowed).problem(),
                    });
                }
            }
        }
        for (found, expected) in self.bindings.all.iter().zip(&made.all) {
            if let (Resource::Uniform(found_bytes), Resource::Uniform(expected_bytes)) =
                (&found.resource, &expected.resource)
                && let Some(at) = (0..expected_bytes.len()).find(|at| found_bytes[*at] != expected_bytes[*at])
            {
                let (at, key) = (at / 4 * 4, format!("{UNIFORM}{}", found.name));
                let word = |bytes: &[u8]| format!("{:02x?}", &bytes[at..at + 4]);
                let allowed = format!("{}, as the codec's metadata says", word(expected_bytes));
                return Err(FormatError::whole(format!("{key} byte {at}"), word(found_bytes), allowed));
            }
        }
        Ok(())
    }

    /// Takes the texels of a binding, with the codec's own key/value data; `None` if none are stored.
    pub(crate) fn take_texture(&mut self, name: &str) -> Option<Texture> {
        let binding = self.bindings.all.iter_mut().find(|binding| binding.name == name)?;
        match &mut binding.resource {
            Resource::Texture(texels) if texels.stored != Stored::Empty => {
                let bytes = std::mem::take(&mut texels.bytes);
                Some(Texels { bytes, ..texels.clone() }.into_texture(self.entries.clone()))
            }
            _ => None,
        }
    }

    /// Takes the texels of the file itself, with the codec's own key/value data.
    pub(crate) fn take_own(&mut self) -> Texture {
        let is_own = |binding: &&Binding<'_>| matches!(&binding.resource, Resource::Texture(texels) if texels.stored == Stored::File);
        let name = self.bindings.all.iter().find(is_own).map(|binding| binding.name.clone());
        name.and_then(|name| self.take_texture(&name)).expect("every pack has a texture of its own")
    }
}

/// Texels of an image whose format, extent and levels match its binding.
fn filled(
    image: PackedTexture<'_>,
    expected: Texels<'static>,
    key: &str,
    line: usize,
) -> Result<Texels<'static>, FormatError> {
    if (image.format, image.extent, image.levels) != (expected.format, expected.extent, expected.levels) {
        let found = format!("{} levels of {} texels of {}", image.levels, image.extent, image.format.name());
        let allowed = format!("{} levels of {} texels of {}", expected.levels, expected.extent, expected.format.name());
        return Err(FormatError::whole(key.to_owned(), found, format!("{allowed}, as {ENTRY} line {line} says")));
    }
    let texture = image.unpack_levels(MAX_TEXEL_BYTES)?;
    Ok(Texels { stored: Stored::File, bytes: texture.texels.into(), ..expected })
}

fn missing(line: usize, key: &str) -> FormatError {
    FormatError::whole(key.to_owned(), "missing", format!("a key of this name, as {ENTRY} line {line} says")).problem()
}
