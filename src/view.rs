//! Pages that draw packs in a browser: `brdfc view`.

pub use brdfc_jobs::view::{ViewItem, ViewOptions, ViewPage, open_items, view_page};
