"""Measured BRDFs, models and packs as functions of direction pairs."""

import os
from typing import Any, Literal, TypedDict, Union, final

import numpy as np
from numpy.typing import ArrayLike, NDArray

__version__: str

class _TablePack(TypedDict):
    """A table pack; `formats/src/table/spec.md` describes each field."""

    kind: Literal["table"]
    channels: int
    """1 or 3."""
    symmetry: int
    """Sum of 1 (reciprocal), 2 (mirror), 4 (half turn) and 8 (reflected)."""
    nodes: tuple[int, int, int, int]
    """Number of nodes along θ_h, θ_d, φ_d and φ_h, for the whole table."""
    first: tuple[int, int]
    """First column and row of the texture; nonzero only for cropped packs."""
    size: tuple[int, int]
    """Columns and rows of the texture."""
    mean: float
    """μ, 1/sr."""
    bias: float
    """ε."""
    low: NDArray[np.float32]
    """(3,): ln(f / μ + ε) of a texel of 0."""
    span: NDArray[np.float32]
    """(3,): difference of ln(f / μ + ε) between texels of 1 and 0."""
    slope: float
    knots: NDArray[np.float32]
    """(17,)."""
    values: NDArray[np.float32]
    """(layers, slices, rows, columns, 3): texels, 0 to 1, grey ones three times."""
    curve: Union[NDArray[np.float32], None]
    """(levels + 1, nodes, 3), the finest level first: added to the logarithm. Only for factored packs."""

class _WaveletPack(TypedDict):
    """A wavelet pack; `formats/src/wavelet/spec.md` describes each field."""

    kind: Literal["wavelet"]
    channels: int
    """1 or 3."""
    parameterisation: Literal["tangent-pole", "half-difference"]
    levels: int
    """N: hemispheres have 2^N x 2^N cells."""
    stored_levels: int
    bits: int
    first: tuple[int, int]
    """First column and row of outer cells in the slices; nonzero only for cropped packs."""
    size: tuple[int, int]
    """Columns and rows of the slices."""
    mean: float
    """μ, 1/sr."""
    bias: float
    """ε."""
    index: NDArray[np.uint16]
    """The slice of each coefficient, 0 if it has none: 4^N, then those of other trees if the pack is energy-preserving."""
    scales: NDArray[np.float32]
    """(slices, 2): scale and offset."""
    texels: Union[NDArray[np.uint8], NDArray[np.uint16]]
    """(slices, rows, columns, 1 or 4): the largest integer represents 1."""
    energy_preserving: bool
    """True if each level l below the stored ones has a tree of its own, from coefficient 4^N + (4^l - 1) / 3 on."""

@final
class Material:
    """A measured file, a model or a pack: f_r at direction pairs."""

    def eval(self, wi: ArrayLike, wo: ArrayLike, lod: Union[float, None] = None) -> NDArray[np.float32]:
        """Returns f_r at direction pairs, in 1/sr, linear RGB (Rec. 709): float32 of shape (..., 3).

        wi (to the light) and wo (to the viewer) are unit vectors in the frame x = tangent, y = bitangent, z = normal, of
        shape (..., 3); shapes are broadcast by the rules of NumPy. Lengths may be off by 1 %. Values are 0 if a direction
        is at or below the horizon; values of measurements may be slightly negative. lod is the level of detail of a pack:
        0, the coarsest, to `levels`, the finest (default: the finest).

        Raises ValueError for other shapes, vectors of other lengths, and levels out of range.
        """

    def pack(self) -> Union[_TablePack, _WaveletPack]:
        """Header and texels of a pack, for other decoders. Raises ValueError if the material is not a pack."""

    @property
    def kind(self) -> str:
        """Kind of the material, as in `brdfc info --json`: "merl", "table-pack" and so on."""

    @property
    def isotropic(self) -> bool:
        """True if the material is known to be isotropic. False for all wavelet packs, which do not store it."""

    @property
    def reciprocal(self) -> bool:
        """True if the material is known to be reciprocal."""

    @property
    def grey(self) -> bool:
        """True if the three channels are equal everywhere."""

    @property
    def levels(self) -> int:
        """Number of levels of detail coarser than the finest; 0 for materials that are not packs."""

    @property
    def facts(self) -> dict[str, Any]:
        """The facts of `brdfc info --json`."""

@final
class Relightable:
    """A polynomial wavelet tree (one view, or all views of a BTF, under any light) or a flat BTF (any view)."""

    def eval(
        self, uv: ArrayLike, wi: ArrayLike, wo: Union[ArrayLike, None] = None, lod: Union[float, None] = None
    ) -> NDArray[np.float32]:
        """Returns linear RGB at positions, 1 is white: float32 of shape (..., 3).

        uv, of shape (..., 2), is 0 to 1, across and down, and may exceed this range. wi (to the light) and wo (to the
        viewer, only if there are several views) are unit vectors as in `Material.eval`, of shape (..., 3); shapes are broadcast by the
        rules of NumPy. lod is the level of detail: 0, the coarsest, to `levels`, the finest (default: the finest).

        Raises ValueError for other shapes, vectors of other lengths, levels out of range, and a missing wo.
        """

    @property
    def kind(self) -> Literal["pwt", "flat-btf"]:
        """Kind of the pack."""

    @property
    def has_views(self) -> bool:
        """True if values depend on the view, so that `eval` needs wo."""

    @property
    def levels(self) -> int:
        """Number of levels of detail coarser than the finest."""

def open(input: Union[str, os.PathLike[str]]) -> Union[Material, Relightable]:
    """Opens a measured file, a pack or an address such as `synth:ggx?alpha=0.3`.

    Returns a `Material`, which has values at direction pairs, or for flat BTFs and polynomial wavelet trees a
    `Relightable`, which has values at positions. Raises OSError if the file cannot be read, and ValueError if it does not
    follow its layout.
    """
