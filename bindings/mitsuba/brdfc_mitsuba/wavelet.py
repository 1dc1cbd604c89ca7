"""Wavelet packs: the twin of `formats/src/wavelet/decode.rs`, whose functions have the same names."""

import drjit as dr
import mitsuba as mi
import numpy as np

from .arithmetic import PI, Buffer, from_log, polynomial_atan2, safe_direction

SQRT_2 = np.sqrt(np.float32(2.0)).item()


class WaveletDecoder:
    """A wavelet pack at one level of detail, filtered bilinearly on both hemispheres.

    `pack`: what `Material.pack()` says. `level`: 0, the coarsest, to the pack's levels; none: the finest.
    """

    def __init__(self, pack, level=None):
        self.levels, self.mean, self.bias = pack["levels"], pack["mean"], pack["bias"]
        self.half_difference = pack["parameterisation"] == "half-difference"
        self.first, self.size = pack["first"], pack["size"]
        level = float(self.levels) if level is None else min(max(float(level), 0.0), float(self.levels))
        self.whole, self.fraction = int(level), level - int(level)
        self.stored_levels = pack["stored_levels"]
        self.trees = self.stored_levels if pack["energy_preserving"] else 0
        texels = pack["texels"]
        unorm = texels.astype(np.float32) * np.float32(1.0 / np.iinfo(texels.dtype).max)
        unorm = np.repeat(unorm, 3, axis=-1) if pack["channels"] == 1 else unorm[..., :3]
        scale, offset = pack["scales"].T
        coefficients = offset[:, None, None, None] + scale[:, None, None, None] * unorm
        self.coefficients = Buffer(coefficients.reshape(-1, 3))
        self.index = Buffer(pack["index"].astype(np.uint32))

    def eval(self, i, o, active=True):
        """f_r in 1/sr, linear RGB, of unit vectors to the light and to the viewer; 0 at and below the horizon."""
        active = (i.z > 0.0) & (o.z > 0.0) & active
        value = from_log(self.log_value(safe_direction(i, active), safe_direction(o, active)), self.mean, self.bias)
        return dr.select(active, value, mi.Color3f(0.0))

    def log_value(self, i, o):
        """ln(f / μ + ε)."""
        outer, inner = self.axes(i, o)
        outer, (columns, rows) = self.footprint(*self.taps(outer)), self.taps(inner)
        log_value = mi.Color3f(0.0)
        for row, row_weight in rows:
            for column, column_weight in columns:
                log_value += row_weight * column_weight * self.reconstruct(outer, column, row)
        return log_value

    def reconstruct(self, outer, column, row):
        """An inner cell at the level of detail. Levels with trees of their own are blended between their values."""
        if self.whole >= self.trees:
            return self.path(0, self.levels, outer, column, row, self.whole, self.fraction)
        coarser = self.of_level(self.whole, outer, column, row)
        if self.fraction == 0.0:
            return coarser
        return coarser + self.fraction * (self.of_level(self.whole + 1, outer, column, row) - coarser)

    def of_level(self, level, outer, column, row):
        """An inner cell at a whole level of detail."""
        if level >= self.trees:
            return self.path(0, self.levels, outer, column, row, level, 0.0)
        first, shift = (1 << (2 * self.levels)) + ((1 << (2 * level)) - 1) // 3, self.levels - level
        return self.path(first, level, outer, column >> shift, row >> shift, level, 0.0)

    def path(self, first, levels, outer, column, row, whole, fraction):
        """Synthesis along one path of a tree, whose coefficients start at `first`."""
        value = self.coefficient(first, outer) * 2.0**-levels
        # Coefficients of finer levels are 0.
        for j in range(min(whole + (1 if fraction > 0.0 else 0), self.stored_levels)):
            child_column, child_row = column >> (levels - j - 1), row >> (levels - j - 1)
            parent_column, parent_row = child_column >> 1, child_row >> 1
            side = 1 << j
            latitude = first + side * side + parent_row * side + parent_column
            longitude = first + 2 * side * side + child_row * side + parent_column
            part = fraction if j == whole else 1.0
            weight = part * 2.0 ** (j - levels)
            a = weight * self.coefficient(latitude, outer)
            b = weight * SQRT_2 * self.coefficient(longitude, outer)
            value += dr.select((child_row & 1) == 0, a, -a) + dr.select((child_column & 1) == 0, b, -b)
        return value

    def coefficient(self, coefficient, outer):
        """A coefficient at the outer direction, through the index map; slice 0 is all zero."""
        columns, rows = self.size
        slice_ = self.index[mi.UInt32(coefficient)] * (columns * rows)
        value = mi.Color3f(0.0)
        for cell, weight in outer:
            value += weight * self.coefficients[slice_ + cell]
        return value

    def taps(self, direction):
        """Along longitude and colatitude: two cells, each with its weight."""
        n = 1 << self.levels
        x, z = direction.x, dr.maximum(direction.z, 0.0)
        longitude = polynomial_atan2(z, x)
        colatitude = polynomial_atan2(dr.sqrt(x * x + z * z), direction.y)

        def tap(angle):
            centred = dr.clip(angle / PI * n - 0.5, 0.0, float(n - 1))
            lower = dr.minimum(mi.UInt32(centred), n - 1)
            weight = centred - mi.Float(lower)
            return (lower, 1.0 - weight), (dr.minimum(lower + 1, n - 1), weight)

        return tap(longitude), tap(colatitude)

    def footprint(self, columns, rows):
        """The four outer cells of a slice, each with its weight; for cropped packs the nearest existing ones."""

        def stored(cell, axis):
            first, size = self.first[axis], self.size[axis]
            return dr.clip(cell, first, first + size - 1) - first

        return [
            (stored(row, 1) * self.size[0] + stored(column, 0), row_weight * column_weight)
            for row, row_weight in rows
            for column, column_weight in columns
        ]

    def axes(self, i, o):
        """Outer and inner hemisphere points."""
        if not self.half_difference:
            return i, o
        total = i + o
        length = dr.sqrt(total.x * total.x + total.y * total.y + total.z * total.z)
        h = mi.Vector3f(total.x / length, total.y / length, total.z / length)
        s = (h.x * i.x + h.y * i.y) / (1.0 + h.z) + i.z
        z = h.x * i.x + h.y * i.y + h.z * i.z
        return h, mi.Vector3f(i.x - h.x * s, i.y - h.y * s, z)
