"""Table packs: the twin of `formats/src/table/decode.rs` and `coordinates.rs`, whose functions have the same names."""

import drjit as dr
import mitsuba as mi

from .arithmetic import (
    HALF_PI, PI, TAU, Buffer, between, from_log, lower_and_weight, polynomial_atan2, safe_direction,
)


def length(v):
    return dr.sqrt(v.x * v.x + v.y * v.y + v.z * v.z)


def azimuth(y, x):
    """atan2(y, x), -π to π."""
    angle = polynomial_atan2(dr.abs(y), x)
    return dr.select(y < 0.0, -angle, angle)


class TableDecoder:
    """A table pack at one level of detail.

    `pack`: what `Material.pack()` says. `level`: 0, the coarsest, to the pack's levels; none: the finest.
    """

    def __init__(self, pack, level=None):
        self.half, self.difference, self.azimuth, self.layers = pack["nodes"]
        self.reciprocal, self.mirror, self.half_turn, self.reflected = (
            bool(pack["symmetry"] >> k & 1) for k in range(4)
        )
        self.first, self.size = pack["first"], pack["size"]
        self.slices = self.azimuth + (0 if self.mirror else 1)
        self.mean, self.bias, self.slope = pack["mean"], pack["bias"], pack["slope"]
        self.low, self.span = (mi.Color3f(pack[name].tolist()) for name in ("low", "span"))
        self.knots = Buffer(pack["knots"])
        self.values = Buffer(pack["values"].reshape(-1, 3))
        self.curve = None
        self.rows_below_finest = 0.0
        if pack["curve"] is not None:
            rows, self.curve_nodes, _ = pack["curve"].shape
            self.curve = Buffer(pack["curve"].reshape(-1, 3))
            levels = rows - 1
            self.rows_below_finest = 0.0 if level is None else min(max(levels - level, 0.0), float(levels))

    def eval(self, i, o, active=True):
        """f_r in 1/sr, linear RGB, of unit vectors to the light and to the viewer; 0 at and below the horizon."""
        active = (i.z > 0.0) & (o.z > 0.0) & active
        i, o = safe_direction(i, active), safe_direction(o, active)
        fine, coarse, coarse_weight = self.log_values(i, o)
        value = from_log(fine, self.mean, self.bias)
        if coarse_weight > 0.0:
            value = between(value, from_log(coarse, self.mean, self.bias), coarse_weight)
        return dr.select(active, value, mi.Color3f(0.0))

    def log_values(self, i, o):
        """ln(f / μ + ε) at the levels on either side of the level of detail, and the weight of the coarser one."""
        angles = self.angles(i, o)
        at, layers, layer_weight = self.position_of(angles)
        value = self.sample(at, layers[0])
        if self.layers > 1:
            value = between(value, self.sample(at, layers[1]), layer_weight)
        table = self.low + self.span * value
        if self.curve is None:
            return table, table, 0.0
        row = int(self.rows_below_finest)
        coarse_weight = self.rows_below_finest - row
        fine = table + self.along(row, angles[0])
        coarse = table + self.along(row + 1, angles[0]) if coarse_weight > 0.0 else fine
        return fine, coarse, coarse_weight

    def along(self, row, theta_half):
        """A row of the curve at θ_h."""
        at = dr.sqrt(dr.minimum(theta_half / HALF_PI, 1.0)) * (self.curve_nodes - 1)
        lower, weight = lower_and_weight(at, self.curve_nodes)
        first = row * self.curve_nodes + lower
        return between(self.curve[first], self.curve[first + 1], weight)

    def angles(self, i, o):
        """θ_h, φ_h, θ_d as a share of its largest, and φ_d."""
        total, apart = i + o, i - o
        sum_length = length(total)
        # Not a product with the reciprocal, which is rounded twice.
        h = mi.Vector3f(total.x / sum_length, total.y / sum_length, total.z / sum_length)
        square = h.x * h.x + h.y * h.y
        sine = dr.sqrt(square)
        theta_half = polynomial_atan2(sine, h.z)
        theta_difference = polynomial_atan2(length(apart), sum_length)
        x = h.z * (i.x * h.x + i.y * h.y) - i.z * square
        y = i.y * h.x - i.x * h.y
        x, y = dr.select(sine > 0.0, x, i.x), dr.select(sine > 0.0, y, i.y)
        across = dr.sqrt(x * x + y * y)
        cosine = dr.select(across > 0.0, dr.abs(x) / dr.select(across > 0.0, across, 1.0), 1.0)
        largest = polynomial_atan2(h.z, sine * cosine)
        smaller = theta_difference < largest
        ratio = dr.select(smaller, theta_difference / dr.select(smaller, largest, 1.0), 1.0)
        phi_half = azimuth(h.y, h.x) if self.layers > 1 else None
        return theta_half, phi_half, ratio, azimuth(y, x)

    def folded(self, phi_half, phi_difference):
        """φ_h and φ_d as shares of their periods, folded by the symmetry."""
        half, difference = phi_half, phi_difference
        if self.reflected and half is not None:
            if self.half_turn:
                half = dr.select(half < 0.0, half + PI, half)
                beyond = half > HALF_PI
                half = dr.select(beyond, PI - half, half)
            else:
                beyond = half < 0.0
                half = dr.abs(half)
            difference = dr.select(beyond, -difference, difference)
        if self.mirror:
            difference = dr.abs(difference)
            if self.reciprocal:
                difference = dr.select(difference > HALF_PI, PI - difference, difference)
        difference = difference / ((PI if self.mirror else TAU) / (2.0 if self.reciprocal else 1.0))
        difference = dr.minimum(difference, 1.0) if self.mirror else difference - dr.floor(difference)
        if half is not None:
            half = half / ((PI if self.reflected else TAU) / (2.0 if self.half_turn else 1.0))
            half = dr.minimum(half, 1.0) if self.reflected else half - dr.floor(half)
        return half, difference

    def column_share(self, theta_half):
        """Share of the columns below θ_h."""
        count = 17
        lower, weight = lower_and_weight(dr.sqrt(dr.minimum(theta_half / HALF_PI, 1.0)) * (count - 1), count)
        return between(self.knots[lower], self.knots[lower + 1], weight)

    def position_of(self, angles):
        """Column, row and slice; the layers on either side of φ_h, and the weight of the second."""
        theta_half, phi_half, ratio, phi_difference = angles
        half_share, difference_share = self.folded(phi_half, phi_difference)
        at = (
            self.column_share(theta_half) * (self.half - 1),
            ratio * (1.0 + self.slope * (1.0 - ratio)) * (self.difference - 1),
            difference_share * (self.azimuth - (1 if self.mirror else 0)),
        )
        if self.layers == 1:
            return at, (0, 0), 0.0
        steps = self.layers - (1 if self.reflected else 0)
        along = half_share * steps
        lower = dr.minimum(mi.UInt32(along), steps - 1)
        return at, (lower, (lower + 1) % self.layers), along - mi.Float(lower)

    def sample(self, at, layer):
        """Trilinear filtering; of cropped packs at the nearest position of the window."""
        columns, rows = self.size
        column, x = lower_and_weight(at[0] - self.first[0], columns)
        row, y = lower_and_weight(at[1] - self.first[1], rows)
        slice_, z = lower_and_weight(at[2], self.slices)

        def of_row(row, slice_):
            first = ((layer * self.slices + slice_) * rows + row) * columns + column
            return between(self.values[first], self.values[first + 1], x)

        def of_slice(slice_):
            return between(of_row(row, slice_), of_row(row + 1, slice_), y)

        return between(of_slice(slice_), of_slice(slice_ + 1), z)
