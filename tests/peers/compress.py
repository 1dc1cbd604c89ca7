"""Compresses a table of floats with zfp and SZ3 at several tolerances, for 'brdfc-bench --study codecs'.

usage: compress.py TABLE OUT CHANNELS SHAPE... -- TOLERANCE...

TABLE holds CHANNELS arrays of little-endian 32-bit floats of this shape. Prints a line for each compressor and tolerance,
"codec tolerance bytes seconds file", and writes into OUT the file with what it decompresses to.
"""

import sys
import time
from pathlib import Path

import numpy
import zfpy
from pysz import sz, szConfig, szErrorBoundMode


def zfp(array, tolerance):
    compressed = zfpy.compress_numpy(array, tolerance=tolerance)
    return compressed, lambda: zfpy.decompress_numpy(compressed)


def sz3(array, tolerance):
    config = szConfig()
    config.errorBoundMode = szErrorBoundMode.ABS
    config.absErrorBound = tolerance
    compressed, _ = sz.compress(array, config)
    return compressed, lambda: sz.decompress(compressed, numpy.float32, array.shape)[0]


def main():
    table, out, channels, *rest = sys.argv[1:]
    split = rest.index("--")
    shape = [int(length) for length in rest[:split]]
    tolerances = [float(tolerance) for tolerance in rest[split + 1 :]]
    arrays = numpy.fromfile(table, dtype="<f4").reshape([int(channels), *shape])
    for name, compress in (("zfp", zfp), ("sz3", sz3)):
        for number, tolerance in enumerate(tolerances):
            start = time.perf_counter()
            parts = [compress(numpy.ascontiguousarray(array), tolerance) for array in arrays]
            seconds = time.perf_counter() - start
            size = sum(len(compressed) for compressed, _ in parts)
            path = Path(out) / f"{name}-{number}.f32"
            numpy.stack([decompress() for _, decompress in parts]).astype("<f4").tofile(path)
            print(name, tolerance, size, seconds, path.name)


main()
