"""Sampling of light directions: a tabulated density of half vectors for each direction of view.

`u = sqrt(θ_h / (π/2))` and `v = φ_h / 2π + 1/2` of a half vector have a density that is continuous and bilinear between
nodes, and interpolated between directions of view, like those of `measured`. Half vectors of isotropic materials are
rotated so that the viewer is above the tangent.
"""

import drjit as dr
import mitsuba as mi
import numpy as np

# Nodes along the viewer's polar angle and azimuth, along u and v.
ISOTROPIC = (32, 1, 128, 65)
ANISOTROPIC = (12, 25, 64, 65)
# Largest polar angle of the viewer, because values are 0 at the horizon.
MAX_ANGLE = np.radians(89.5)


def half_vectors(u, v):
    """Half vectors of (u, v), and the solid angle of each over du dv: arrays of any one shape."""
    theta, phi = 0.5 * np.pi * u * u, 2.0 * np.pi * (v - 0.5)
    h = np.stack([np.sin(theta) * np.cos(phi), np.sin(theta) * np.sin(phi), np.cos(theta)], axis=-1)
    return h, np.sin(theta) * np.pi * u * 2.0 * np.pi


def node_densities(of_drawn, theta, phi, u, v):
    """f cos θ_i of each (v, u) for a viewer at `theta`, `phi`, as an unnormalised density over du dv."""
    h, area = half_vectors(*np.meshgrid(u, v))
    o = np.array([np.sin(theta) * np.cos(phi), np.sin(theta) * np.sin(phi), np.cos(theta)])
    cosine = h @ o
    i = 2.0 * cosine[..., None] * h - o
    lit = (i[..., 2] > 0.0) & (cosine > 0.0)
    density = np.zeros(lit.shape)
    count = np.count_nonzero(lit)
    value = of_drawn(i[lit], np.broadcast_to(o, (count, 3))).mean(axis=1)
    density[lit] = np.maximum(value, 0.0) * i[lit][:, 2] * area[lit] * 4.0 * cosine[lit]
    # A black material needs a density that can be normalised, too.
    return density if density.any() else np.ones(lit.shape)


class LobeDistribution:
    """Distribution of light directions for a direction of view, approximately proportional to `f cos θ_i`.

    `of_drawn(drawn, given)`: f_r at directions of light and of view of shape (N, 3). `isotropic`: rotating both about
    the normal does not change f_r.
    """

    def __init__(self, of_drawn, isotropic):
        self.isotropic = isotropic
        polar, azimuths, columns, rows = ISOTROPIC if isotropic else ANISOTROPIC
        thetas = np.linspace(0.0, MAX_ANGLE, polar)
        phis = np.linspace(-np.pi, np.pi, azimuths) if azimuths > 1 else np.zeros(1)
        u, v = np.linspace(0.0, 1.0, columns), np.linspace(0.0, 1.0, rows)
        data = np.array([[node_densities(of_drawn, theta, phi, u, v) for phi in phis] for theta in thetas])
        # Normalised, because tiny and huge numbers would lose digits.
        data = (data / data.max(axis=(2, 3), keepdims=True)).astype(np.float32)
        if isotropic:
            self.table = mi.MarginalContinuous2D1(np.ascontiguousarray(data[:, 0]), [thetas.tolist()])
        else:
            self.table = mi.MarginalContinuous2D2(data, [thetas.tolist(), phis.tolist()])

    def viewer(self, o):
        """Parameters of the density, and the azimuth by which half vectors are rotated."""
        theta, phi = dr.acos(dr.clip(o.z, -1.0, 1.0)), dr.atan2(o.y, o.x)
        return ([theta], phi) if self.isotropic else ([theta, phi], 0.0)

    def sample(self, o, sample, active=True):
        """Draws a direction, possibly below the horizon, from two numbers in [0, 1]."""
        given, turn = self.viewer(o)
        at, _ = self.table.sample(sample, given, active)
        theta, phi = 0.5 * dr.pi * at.x * at.x, dr.two_pi * (at.y - 0.5) + turn
        sine, cosine = dr.sincos(theta)
        h = mi.Vector3f(sine * dr.cos(phi), sine * dr.sin(phi), cosine)
        return 2.0 * dr.dot(o, h) * h - o

    def pdf(self, i, o, active=True):
        """Density of `sample` over solid angle, 1/sr. Both directions are unit vectors above the horizon."""
        given, turn = self.viewer(o)
        h = i + o
        h /= dr.norm(h)
        sine = dr.sqrt(h.x * h.x + h.y * h.y)
        u = dr.sqrt(dr.atan2(sine, h.z) / (0.5 * dr.pi))
        v = (dr.atan2(h.y, h.x) - turn) / dr.two_pi + 0.5
        v = v - dr.floor(v)
        area = sine * dr.pi * u * dr.two_pi * 4.0 * dr.dot(o, h)
        positive = area > 0.0
        density = self.table.eval(mi.Point2f(dr.minimum(u, 1.0), v), given, active)
        return dr.select(positive, density / dr.select(positive, area, 1.0), 0.0)
