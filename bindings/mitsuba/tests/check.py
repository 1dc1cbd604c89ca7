"""All checks of the plugin, one line each. Run by ../check; exits with 1 if one fails.

usage: check.py DATA [IMAGE.png]
"""

import os
import sys
import tempfile

import mitsuba as mi

import brdfc_mitsuba
import loading
import renderings
import sampling
import twin
from common import Results

# Pairs in the scalar variant, which calls Python for each.
FEW = 200


def main():
    data, rendering = sys.argv[1], sys.argv[2] if len(sys.argv) > 2 and sys.argv[2] else None
    results = Results()
    print(f"Mitsuba {mi.__version__}")
    with tempfile.TemporaryDirectory() as folder:
        mi.set_variant("scalar_rgb")
        brdfc_mitsuba.register()
        loading.check(results, folder)
        twin.check(results, folder, FEW, most=4)
        # Without the library the variant cannot be set; with an old one the process exits.
        if not os.path.isfile(os.environ.get("DRJIT_LIBLLVM_PATH", "")):
            for what in ("decoders (llvm_ad_rgb)", "sampling", "renderings"):
                results.skip(what, "no libLLVM 17 or newer; on Debian or Ubuntu: apt-get install libllvm19")
            sys.exit(results.finish())
        mi.set_variant("llvm_ad_rgb")
        brdfc_mitsuba.register()
        twin.check(results, folder, twin.COUNT)
        sampling.check(results, folder)
        renderings.check(results, folder, data, rendering)
    sys.exit(results.finish())


main()
