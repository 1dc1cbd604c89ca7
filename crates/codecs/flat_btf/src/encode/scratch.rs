//! Storage for the values of all views, which may exceed memory.

use super::error::EncodeError;
use brdfc_formats::FormatError;
use brdfc_formats::flat_btf::{FlatHeader, FlatView};
use std::collections::BTreeMap;
use std::convert::Infallible;
use std::sync::{Mutex, PoisonError};

/// Storage for the duration of one encoding. Several threads may call it at once, each for a different view.
pub trait Scratch: Sync {
    /// Error of writing or reading values.
    type Error: Send;

    /// Stores the values of a view.
    ///
    /// # Errors
    /// Returns an error if they cannot be stored.
    fn write_scratch(&self, view: u32, values: &[u8]) -> Result<(), Self::Error>;

    /// Returns the values written for a view. May be called any number of times.
    ///
    /// # Errors
    /// Returns an error if they cannot be read.
    fn read_scratch(&self, view: u32) -> Result<Vec<u8>, Self::Error>;
}

/// Scratch storage in memory, for small assets.
#[derive(Debug, Default)]
pub struct MemoryScratch(Mutex<BTreeMap<u32, Vec<u8>>>);

impl Scratch for MemoryScratch {
    type Error = Infallible;

    fn write_scratch(&self, view: u32, values: &[u8]) -> Result<(), Infallible> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner).insert(view, values.to_vec());
        Ok(())
    }

    fn read_scratch(&self, view: u32) -> Result<Vec<u8>, Infallible> {
        let views = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        Ok(views.get(&view).cloned().unwrap_or_default())
    }
}

/// All views of a flat BTF in scratch storage: the words of [`FlatView::texels`], little-endian.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct ScratchViews {
    header: FlatHeader,
}

impl ScratchViews {
    pub(super) fn new(header: FlatHeader) -> Self {
        Self { header }
    }

    /// Builds a view from its packed texels, light by light.
    pub(super) fn view(&self, view: u32, texels: Vec<u32>) -> Result<FlatView, FormatError> {
        FlatView::new(FlatHeader { view, ..self.header.clone() }, texels)
    }

    pub(super) fn write<E: Send>(&self, view: &FlatView, scratch: &dyn Scratch<Error = E>) -> Result<(), E> {
        let mut values = vec![0; 4 * view.texels().len()];
        values.as_chunks_mut::<4>().0.iter_mut().zip(view.texels()).for_each(|(to, texel)| *to = texel.to_le_bytes());
        scratch.write_scratch(view.header().view, &values)
    }

    /// Reads a view back.
    ///
    /// # Errors
    /// Returns errors of the storage, and an error if the number of bytes differs from the number written.
    pub(super) fn read<E: Send>(
        &self,
        view: u32,
        scratch: &dyn Scratch<Error = E>,
    ) -> Result<FlatView, EncodeError<E>> {
        let values = scratch.read_scratch(view).map_err(EncodeError::Outside)?;
        let length = 4 * (self.header.size as usize).pow(2) * self.header.lights.len();
        if values.len() != length {
            let (field, found) = (format!("scratch storage of view {view}"), format!("{} bytes", values.len()));
            return Err(FormatError::whole(field, found, format!("the {length} bytes that were written")).into());
        }
        let texels = values.as_chunks::<4>().0.iter().map(|word| u32::from_le_bytes(*word)).collect();
        Ok(self.view(view, texels)?)
    }
}
