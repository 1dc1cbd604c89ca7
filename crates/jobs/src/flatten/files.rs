//! Files of a flat BTF as their bytes say it.

use super::asset::AssetFile;
use crate::pack_files::{PackFile, pack_files};
use brdfc_formats::container::{Extent, TexelFormat};
use brdfc_shaders::DeviceNeeds;
use brdfc_source::InputError;
use brdfc_source::read::{MAX_FILE_BYTES, read_file};
use std::collections::BTreeMap;
use std::path::Path;

/// Parts that hold a view each, which on a GPU become the layers of one texture.
const VIEW: &str = "flat.";

impl AssetFile {
    /// The textures of all parts, by the names of their files. `path` is the asset's folder or list.
    ///
    /// # Errors
    /// Parts that cannot be read, or are no KTX2 files.
    pub fn pack_files(&self, path: &Path) -> Result<BTreeMap<String, PackFile>, InputError> {
        self.files_of(path, |_| true)
    }

    /// What its shader asks of a device.
    ///
    /// # Errors
    /// As [`Self::pack_files`].
    pub fn device_needs(&self, path: &Path) -> Result<DeviceNeeds, InputError> {
        // Drawn are those that take graphics memory.
        let drawn = self.files_of(path, |part| !part.starts_with(VIEW) && self.parts[part].gpu_bytes > 0)?;
        let needs = drawn.into_values().fold(DeviceNeeds::default(), |all, file| all.with(file.device));
        let views = self.parts.keys().filter(|part| part.starts_with(VIEW)).count() as u32;
        if views == 0 {
            return Ok(needs);
        }
        let tiles = (self.settings.lights.1 as f64).sqrt().ceil() as u32;
        let side = self.settings.flat_texels as u32 * tiles;
        Ok(needs.with(DeviceNeeds::of(TexelFormat::Rgb9E5, Extent::D2Array([side, side, views]))))
    }

    fn files_of(
        &self,
        path: &Path,
        is_wanted: impl Fn(&str) -> bool,
    ) -> Result<BTreeMap<String, PackFile>, InputError> {
        let folder = if path.is_dir() { path } else { path.parent().unwrap_or(Path::new("")) };
        let mut all = BTreeMap::new();
        for (_, part) in self.parts.iter().filter(|(part, _)| is_wanted(part)) {
            let file = folder.join(&part.file);
            let wrong = |error| InputError::Format { name: file.display().to_string(), error };
            all.append(&mut pack_files(&part.file, &read_file(&file, MAX_FILE_BYTES)?).map_err(wrong)?);
        }
        Ok(all)
    }
}
