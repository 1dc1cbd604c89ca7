"""Packs of brdfc in Mitsuba 3: `{"type": "brdfc", "filename": "red.ktx2"}`.

    import mitsuba as mi
    mi.set_variant("llvm_ad_rgb")
    import brdfc_mitsuba
    brdfc_mitsuba.register()
"""

__all__ = ["register"]


def register():
    """Registers the plugin for the current variant; call it again after a change of the variant.

    Raises ValueError if the variant is not `scalar_rgb`, `llvm_ad_rgb` or `cuda_ad_rgb`, or if none is set.
    """
    import mitsuba as mi

    variant = mi.variant()
    if variant is None or not variant.endswith("_rgb"):
        raise ValueError(f"brdfc: found the variant {variant}, expected scalar_rgb, llvm_ad_rgb or cuda_ad_rgb")
    from .bsdf import pack_bsdf

    mi.register_bsdf("brdfc", pack_bsdf())
