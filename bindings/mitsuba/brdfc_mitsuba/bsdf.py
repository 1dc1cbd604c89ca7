"""The BSDF `brdfc` of Mitsuba 3."""

import brdfc
import drjit as dr
import mitsuba as mi

from .arithmetic import safe_direction
from .lobe import LobeDistribution
from .table import TableDecoder
from .wavelet import WaveletDecoder


def is_number(value):
    return isinstance(value, (int, float)) and not isinstance(value, bool)


# Decoders of packs, by kind.
DECODERS = {"table": TableDecoder, "wavelet": WaveletDecoder}


def pack_bsdf():
    """Makes the BSDF class of the current variant; each variant has its own base class."""

    class PackBSDF(mi.BSDF):
        """A table or wavelet pack, seen from its front.

        Parameters: `filename` of the pack; `lod`, the level of detail, from 0, the coarsest (default: the finest);
        `exchanged`, true to exchange light and viewer, as `measured` does with its files (default: false).

        Tangent and bitangent are those of the shading frame. The pack's incoming direction points to the light and its
        outgoing direction to the viewer, also for packs that are not reciprocal.

        Raises ValueError if the file is not such a pack, and OSError if it cannot be read.
        """

        # Fraction of samples drawn by the cosine alone, so that the density is above 0 for all directions of light.
        cosine_share = 0.1

        def __init__(self, props):
            mi.BSDF.__init__(self, props)
            self.name = str(mi.file_resolver().resolve(str(props["filename"])))
            material = brdfc.open(self.name)
            if not isinstance(material, brdfc.Material):
                raise ValueError(f"{self.name}: pack: found a {material.kind}, expected a pack of a BRDF")
            pack = material.pack()
            lod = props["lod"] if "lod" in props else None
            if lod is not None and not (is_number(lod) and 0.0 <= lod <= material.levels):
                found = f"{lod:g}" if is_number(lod) else lod
                raise ValueError(f"{self.name}: lod: found {found}, expected 0 to {material.levels}, the pack's levels")
            self.exchanged = props["exchanged"] if "exchanged" in props else False
            if not isinstance(self.exchanged, bool):
                raise ValueError(f"{self.name}: exchanged: found {self.exchanged}, expected true or false")
            if pack["kind"] not in DECODERS:
                allowed = ", ".join(DECODERS)
                raise ValueError(f"{self.name}: decoder of the pack: found {pack['kind']}, expected {allowed}")
            self.decoder = DECODERS[pack["kind"]](pack, lod)

            def of_drawn(drawn, given):
                pair = (given, drawn) if self.exchanged else (drawn, given)
                return material.eval(*pair, lod)

            self.lobe = LobeDistribution(of_drawn, material.isotropic)
            flags = mi.BSDFFlags.GlossyReflection | mi.BSDFFlags.FrontSide
            if not material.isotropic:
                flags |= mi.BSDFFlags.Anisotropic
            self.m_components = [flags]
            self.m_flags = flags

        def sample(self, ctx, si, sample1, sample2, active=True):
            active = active & self.is_enabled(ctx) & (si.wi.z > 0.0)
            by_cosine = mi.warp.square_to_cosine_hemisphere(sample2)
            by_lobe = self.lobe.sample(safe_direction(si.wi, active), sample2, active)
            result = dr.zeros(mi.BSDFSample3f)
            result.wo = dr.select(sample1 < self.cosine_share, by_cosine, by_lobe)
            result.eta = 1.0
            result.sampled_type = +mi.BSDFFlags.GlossyReflection
            result.sampled_component = 0
            value, result.pdf = self.eval_pdf(ctx, si, result.wo, active)
            drawn = active & (result.pdf > 0.0)
            value = value / dr.select(drawn, result.pdf, 1.0)
            return result, dr.select(drawn, value, mi.Color3f(0.0))

        def eval(self, ctx, si, wo, active=True):
            # Paths start at the viewer or at the light.
            from_viewer = ctx.mode == mi.TransportMode.Radiance
            light, viewer = (wo, si.wi) if from_viewer != self.exchanged else (si.wi, wo)
            return self.decoder.eval(light, viewer, active & self.is_enabled(ctx)) * dr.maximum(wo.z, 0.0)

        def pdf(self, ctx, si, wo, active=True):
            active = active & self.is_enabled(ctx) & (si.wi.z > 0.0) & (wo.z > 0.0)
            drawn, given = safe_direction(wo, active), safe_direction(si.wi, active)
            by_lobe = self.lobe.pdf(drawn, given, active)
            density = by_lobe + self.cosine_share * (drawn.z * dr.inv_pi - by_lobe)
            return dr.select(active, density, 0.0)

        def eval_pdf(self, ctx, si, wo, active=True):
            return self.eval(ctx, si, wo, active), self.pdf(ctx, si, wo, active)

        def is_enabled(self, ctx):
            return ctx.is_enabled(mi.BSDFFlags.GlossyReflection)

        def to_string(self):
            return f"PackBSDF[\n  filename = {self.name}\n]"

    return PackBSDF
