//! Pages that draw packs in a browser: `brdfc view`.
//!
//! Start with [`open_items`], which reads packs, builds and sources; [`view_page`] makes a page of its items. Packs of lobes
//! need a [`ViewEnvironment`].

pub use brdfc_jobs::view::{ViewEnvironment, ViewItem, ViewOptions, ViewPage, open_items, view_page};
