"""Measured BRDFs, models and packs as functions of direction pairs."""

import os
from typing import Any, Literal, TypedDict, Union, final

import numpy as np
from numpy.typing import ArrayLike, NDArray

__version__: str

class _TablePack(TypedDict):
    """A table pack: `formats/src/table/spec.md` has the meaning of each field."""

    kind: Literal["table"]
    channels: int
    """1 or 3."""
    symmetry: int
    """1 reciprocal, 2 mirror, 4 half turn, 8 reflected, added."""
    nodes: tuple[int, int, int, int]
    """Along θ_h, θ_d, φ_d and φ_h, of the whole table."""
    first: tuple[int, int]
    """First column and row that the texture has; not 0 of cropped packs alone."""
    size: tuple[int, int]
    """Columns and rows that it has."""
    mean: float
    """μ, 1/sr."""
    bias: float
    """ε."""
    low: NDArray[np.float32]
    """(3,): ln(f / μ + ε) of a texel of 0."""
    span: NDArray[np.float32]
    """(3,): from a texel of 0 to one of 1."""
    slope: float
    knots: NDArray[np.float32]
    """(17,)."""
    values: NDArray[np.float32]
    """(layers, slices, rows, columns, 3): texels, 0 to 1, grey ones three times."""
    curve: Union[NDArray[np.float32], None]
    """(levels + 1, nodes, 3) of factored packs, the finest level first: what is added to the logarithm."""

class _WaveletPack(TypedDict):
    """A wavelet pack: `formats/src/wavelet/spec.md` has the meaning of each field."""

    kind: Literal["wavelet"]
    channels: int
    """1 or 3."""
    parameterisation: Literal["tangent-pole", "half-difference"]
    levels: int
    """N: hemispheres have 2^N x 2^N cells."""
    stored_levels: int
    bits: int
    first: tuple[int, int]
    """First column and row of outer cells that slices have; not 0 of cropped packs alone."""
    size: tuple[int, int]
    """Columns and rows that they have."""
    mean: float
    """μ, 1/sr."""
    bias: float
    """ε."""
    index: NDArray[np.uint16]
    """(4^N,): the slice of each coefficient, 0 where it has none."""
    scales: NDArray[np.float32]
    """(slices, 2): scale and offset."""
    texels: Union[NDArray[np.uint8], NDArray[np.uint16]]
    """(slices, rows, columns, 1 or 4): the largest integer is 1."""
    lift: Union[NDArray[np.float32], None]
    """(4^N,) of lifted packs: what the lower half of a coefficient's pair counts of both."""

@final
class Material:
    """A measured file, a model or a pack: f_r at direction pairs."""

    def eval(self, wi: ArrayLike, wo: ArrayLike, lod: Union[float, None] = None) -> NDArray[np.float32]:
        """f_r at direction pairs, in 1/sr, linear RGB (Rec. 709): float32 of shape (..., 3).

        wi (to the light) and wo (to the viewer) are unit vectors in the frame x = tangent, y = bitangent, z = normal, of
        shape (..., 3); shapes are brought together as by NumPy's own functions. Lengths may be off by 1 %. Values are 0
        where a direction is at or below the horizon; those of measurements may be slightly negative. lod is the level of
        detail of a pack: 0, the coarsest, to `levels`, the finest, which is taken without it.

        Raises ValueError for other shapes, vectors of other lengths, and levels that there are not.
        """

    def pack(self) -> Union[_TablePack, _WaveletPack]:
        """Header and texels of a pack, for decoders elsewhere. Raises ValueError for all but packs."""

    @property
    def kind(self) -> str:
        """What it is, as `brdfc info --json` says: "merl", "table-pack" and so on."""

    @property
    def isotropic(self) -> bool:
        """Whether it is known to look the same when turned about the normal. False for all wavelet packs, which do not say."""

    @property
    def reciprocal(self) -> bool:
        """Whether it is known that light and viewer may be exchanged."""

    @property
    def grey(self) -> bool:
        """Whether the three channels are equal everywhere."""

    @property
    def levels(self) -> int:
        """Levels of detail besides the finest; 0 of all but packs."""

    @property
    def facts(self) -> dict[str, Any]:
        """What `brdfc info --json` says of it."""

@final
class Relightable:
    """A rendering under any light, or a surface with relief under any light and seen from anywhere."""

    def eval(
        self, uv: ArrayLike, wi: ArrayLike, wo: Union[ArrayLike, None] = None, lod: Union[float, None] = None
    ) -> NDArray[np.float32]:
        """Linear RGB, 1 is white, at places: float32 of shape (..., 3).

        uv, of shape (..., 2), is 0 to 1, across and down, and goes on beyond. wi (to the light) and wo (to the viewer, for
        flat BTFs alone) are unit vectors as those of `Material.eval`, of shape (..., 3); shapes are brought together as by
        NumPy's own functions. lod is the level of detail: 0, the coarsest, to `levels`, the finest, which is taken without
        it.

        Raises ValueError for other shapes, vectors of other lengths, levels that there are not, and where wo is missing.
        """

    @property
    def kind(self) -> Literal["pwt", "flat-btf"]:
        """What it is."""

    @property
    def has_views(self) -> bool:
        """Whether values depend on where they are seen from, so that `eval` needs wo."""

    @property
    def levels(self) -> int:
        """Levels of detail besides the finest."""

def open(input: Union[str, os.PathLike[str]]) -> Union[Material, Relightable]:
    """Opens a measured file, a pack or an address as in `synth:ggx?alpha=0.3`.

    A `Material` has values at direction pairs; a `Relightable`, of flat BTFs and polynomial wavelet trees, at places of a
    rendering. Raises OSError for what cannot be read, ValueError for what breaks its layout.
    """
