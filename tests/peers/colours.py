"""Compares how brdfc reads colours and orientation of photographs with LittleCMS, the colour engine of Pillow.

usage: colours.py BRDFC

For each encoding, profile and orientation, the script writes an RTI capture, and a second one with the values that Pillow decodes,
LittleCMS converts to sRGB in doubles, and numpy turns; 'BRDFC compare' measures the ΔE between them. The exit code is 1 if a mean
exceeds 0.4. JPEGs with chroma at half resolution (jpg420) are measured, too, but not judged: JPEG leaves open how a decoder enlarges
chroma, and libjpeg, which Pillow uses, does it in another way than zune-jpeg.
"""

import ctypes
import glob
import json
import os
import struct
import subprocess
import sys
import tempfile
import zlib

import numpy
import PIL
from PIL import Image
import tifffile

LIMIT = 0.4
LIGHTS = [(0.0, 0.0, 1.0), (0.5, 0.0, 0.866), (-0.5, 0.0, 0.866), (0.0, 0.5, 0.866), (0.0, -0.5, 0.866), (0.4, 0.4, 0.825)]
D65, D50 = (0.3127, 0.329), (0.3457, 0.3585)
REC709 = [(0.64, 0.33), (0.3, 0.6), (0.15, 0.06)]
# Name, primaries, white and exponent; without an exponent, the curve is that of sRGB.
PROFILES = {
    "sRGB": (REC709, D65, None),
    "linear": (REC709, D65, 1.0),
    "gamma 1.8": (REC709, D65, 1.8),
    "Adobe RGB": ([(0.64, 0.33), (0.21, 0.71), (0.15, 0.06)], D65, 563 / 256),
    "Display P3": ([(0.68, 0.32), (0.265, 0.69), (0.15, 0.06)], D65, None),
    "Rec. 2020": ([(0.708, 0.292), (0.17, 0.797), (0.131, 0.046)], D65, 2.4),
    "ProPhoto": ([(0.7347, 0.2653), (0.1596, 0.8404), (0.0366, 0.0001)], D50, 1.8),
}
EXTENSIONS = {"png8": "png", "png16": "png", "jpg": "jpg", "jpg420": "jpg", "tif8": "tif", "tif16": "tif"}
# How numpy shows upright what a camera stored with each orientation of Exif.
UPRIGHT = {
    1: lambda a: a,
    2: numpy.fliplr,
    3: lambda a: numpy.rot90(a, 2),
    4: numpy.flipud,
    5: lambda a: a.transpose(1, 0, 2),
    6: lambda a: numpy.rot90(a, -1),
    7: lambda a: numpy.rot90(a, 2).transpose(1, 0, 2),
    8: lambda a: numpy.rot90(a, 1),
}

# Pillow's own LittleCMS converts 8 bits only; the same library does doubles.
cms = ctypes.CDLL(glob.glob(os.path.join(os.path.dirname(PIL.__file__), "..", "pillow.libs", "liblcms2*"))[0])
for function in ("cmsCreateRGBProfile", "cmsBuildGamma", "cmsBuildParametricToneCurve", "cmsCreateTransform"):
    getattr(cms, function).restype = ctypes.c_void_p
RGB_DOUBLE = 1 << 22 | 4 << 16 | 3 << 3
SRGB_CURVE = (ctypes.c_double * 5)(2.4, 1 / 1.055, 0.055 / 1.055, 1 / 12.92, 0.04045)


class XyY(ctypes.Structure):
    _fields_ = [("x", ctypes.c_double), ("y", ctypes.c_double), ("Y", ctypes.c_double)]


def profile(primaries, white, exponent):
    """A profile of LittleCMS with these primaries, white and curve."""
    if exponent is None:
        curve = cms.cmsBuildParametricToneCurve(None, 4, SRGB_CURVE)
    else:
        curve = cms.cmsBuildGamma(None, ctypes.c_double(exponent))
    curves = (ctypes.c_void_p * 3)(curve, curve, curve)
    xyy = (XyY * 3)(*[XyY(x, y, 1) for x, y in primaries])
    return cms.cmsCreateRGBProfile(ctypes.byref(XyY(*white, 1)), xyy, curves)


def icc(handle):
    """Bytes of a profile."""
    size = ctypes.c_uint32()
    cms.cmsSaveProfileToMem(ctypes.c_void_p(handle), None, ctypes.byref(size))
    data = ctypes.create_string_buffer(size.value)
    cms.cmsSaveProfileToMem(ctypes.c_void_p(handle), data, ctypes.byref(size))
    return data.raw


def convert(values, source, target):
    """Colours in 0 to 1, height x width x 3, from one profile to another, relative colorimetric."""
    inputs = numpy.ascontiguousarray(values, dtype="f8")
    outputs = numpy.empty_like(inputs)
    transform = cms.cmsCreateTransform(ctypes.c_void_p(source), RGB_DOUBLE, ctypes.c_void_p(target), RGB_DOUBLE, 1, 0x0140)
    cms.cmsDoTransform(ctypes.c_void_p(transform), inputs.ctypes.data_as(ctypes.c_void_p),
                       outputs.ctypes.data_as(ctypes.c_void_p), inputs.size // 3)
    return outputs


def png(values, bits, chunks):
    """Bytes of a PNG; Pillow writes no colours of 16 bits."""
    height, width, _ = values.shape
    rows = values.astype(">u2" if bits == 16 else "u1").reshape(height, -1)
    data = b"".join(b"\0" + row.tobytes() for row in rows)
    parts = [(b"IHDR", struct.pack(">IIBBBBB", width, height, bits, 2, 0, 0, 0)), *chunks]
    parts += [(b"IDAT", zlib.compress(data)), (b"IEND", b"")]
    return b"\x89PNG\r\n\x1a\n" + b"".join(
        struct.pack(">I", len(body)) + name + body + struct.pack(">I", zlib.crc32(name + body)) for name, body in parts)


def write(path, colours, encoding, embedded, orientation):
    """Writes colours in 0 to 1 as stored by a camera, and returns what a decoder finds in the file."""
    peak = 65535 if encoding.endswith("16") else 255
    codes = numpy.round(colours * peak).astype("u2" if peak > 255 else "u1")
    exif = Image.Exif()
    exif[0x0112] = orientation
    if encoding.startswith("png"):
        chunks = [(b"iCCP", b"icc\0\0" + zlib.compress(embedded))] if embedded else []
        chunks += [(b"eXIf", exif.tobytes().removeprefix(b"Exif\0\0"))] if orientation > 1 else []
        with open(path, "wb") as file:
            file.write(png(codes, 16 if peak > 255 else 8, chunks))
    elif encoding.startswith("jpg"):
        subsampling = 2 if encoding == "jpg420" else 0
        Image.fromarray(codes).save(path, quality=100, subsampling=subsampling, icc_profile=embedded, exif=exif)
        codes = numpy.asarray(Image.open(path))
    else:
        tifffile.imwrite(path, codes, photometric="rgb", iccprofile=embedded, extratags=[(274, "H", 1, orientation, True)])
    return codes / peak


def capture(folder, extension):
    """Makes a folder and the list of its photographs, and returns their paths."""
    os.mkdir(folder)
    names = [f"im{i}.{extension}" for i in range(len(LIGHTS))]
    with open(f"{folder}/dirs.lp", "w") as file:
        file.write(f"{len(names)}\n" + "".join(f"{n} {x} {y} {z}\n" for n, (x, y, z) in zip(names, LIGHTS)))
    return [f"{folder}/{name}" for name in names]


def scene(light):
    """Linear Rec. 709 colours of one photograph: gradients over the gamut, darker in one corner."""
    y, x = numpy.mgrid[0:32, 0:48] / [[[32.0]], [[48.0]]]
    turned = (x + light / len(LIGHTS)) % 1.0
    hues = 0.5 + 0.45 * numpy.cos(2 * numpy.pi * (turned[..., None] - numpy.array([0, 1 / 3, 2 / 3])))
    return hues * (0.1 + 0.9 * y[..., None])


def measured(brdfc, folder, encoding, name, orientation):
    """Mean ΔE of a capture against LittleCMS."""
    srgb, linear = profile(*PROFILES["sRGB"]), profile(*PROFILES["linear"])
    source = profile(*PROFILES[name or "sRGB"])
    theirs, ours = capture(f"{folder}/theirs", "png"), capture(f"{folder}/ours", EXTENSIONS[encoding])
    for light, (their, our) in enumerate(zip(theirs, ours)):
        colours = numpy.clip(convert(scene(light), linear, source), 0, 1)
        stored = write(our, colours, encoding, icc(source) if name else None, orientation)
        shown = UPRIGHT[orientation](numpy.clip(convert(stored, source, srgb), 0, 1))
        with open(their, "wb") as file:
            file.write(png(numpy.round(shown * 65535), 16, []))
    command = [brdfc, "compare", f"{folder}/theirs", f"{folder}/ours", "--json"]
    result = subprocess.run(command, capture_output=True, text=True)
    if result.returncode != 0:
        return float("inf"), result.stderr.strip()
    return json.loads(result.stdout)["delta_e"], ""


def main(brdfc):
    cases = [(e, n, o) for e in EXTENSIONS for n in [None, *PROFILES] for o in (1, 6)]
    cases += [(e, "Adobe RGB", o) for e in EXTENSIONS for o in (2, 3, 4, 5, 7, 8)]
    found = {encoding: [] for encoding in EXTENSIONS}
    for encoding, name, orientation in cases:
        with tempfile.TemporaryDirectory() as folder:
            delta_e, error = measured(brdfc, folder, encoding, name, orientation)
        found[encoding].append(delta_e)
        if error:
            print(f"{encoding}, {name or 'nothing stated'}, orientation {orientation}: {error}")
    judged = []
    print(f"encoding  files  mean ΔE at most {LIMIT}  worst")
    for encoding, values in found.items():
        within = sum(value <= LIMIT for value in values)
        print(f"{encoding:8}  {len(values):5}  {within:19}  {max(values):5.2f}")
        judged += values if encoding != "jpg420" else []
    return int(not all(value <= LIMIT for value in judged))


if __name__ == "__main__":
    sys.exit(main(*sys.argv[1:]))
