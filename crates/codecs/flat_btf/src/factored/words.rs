//! Values of texels as views hold them.

/// Words of some texels in a view: `first` and following of each light; lights are `stride` apart.
#[derive(Debug, Clone, Copy)]
pub(super) struct ViewWords<'a> {
    pub(super) view: usize,
    pub(super) words: &'a [u32],
    pub(super) first: usize,
    pub(super) stride: usize,
}
