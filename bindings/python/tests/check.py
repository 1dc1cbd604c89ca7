"""The wheel compared with the program: values bit for bit, the same error messages, speed. Run by ./check.

Exits with 1 where anything differs. BRDFC names the program, ROOT the repository.
"""

import multiprocessing
import os
import subprocess
import sys
import tempfile
import threading
import time

import numpy as np

import brdfc

PROGRAM, ROOT = os.environ["BRDFC"], os.environ["ROOT"]
DEMO = os.path.join(ROOT, "testdata/demo")
GOLDEN = os.path.join(ROOT, "formats/src")
DIRECTIONS = ["wi_x", "wi_y", "wi_z", "wo_x", "wo_y", "wo_z"]
failures = []


def check(what, passed, text=""):
    print(f"{'ok' if passed else 'FAILED':6}  {what}{': ' if text else ''}{text}")
    if not passed:
        failures.append(what)


def run(*arguments):
    return subprocess.run([PROGRAM, *arguments], capture_output=True, text=True)


def encode(source, output, *arguments):
    done = run("encode", source, "-o", output, "--quiet", *arguments)
    assert done.returncode == 0, done.stderr
    return output


def table_of(text):
    lines = [line.split(",") for line in text.split()]
    return {name: np.array([float(line[k]) for line in lines[1:]]) for k, name in enumerate(lines[0])}


def write(path, columns):
    rows = zip(*(column.tolist() for column in columns.values()))
    with open(path, "w", encoding="utf-8") as file:
        file.write(",".join(columns) + "\n")
        file.writelines(",".join(map(repr, row)) + "\n" for row in rows)


def by_program(name, path, columns, lod):
    """Values of `brdfc eval`, rounded to single precision."""
    done = run("eval", name, "--directions", path, *(["--lod", str(lod)] if lod is not None else []))
    assert done.returncode == 0, done.stderr
    found = table_of(done.stdout)
    return np.stack([found[column] for column in columns], axis=1).astype(np.float32)


def directions(random, count, lowest=-0.2):
    """Unit vectors, some below the horizon."""
    z, phi = random.uniform(lowest, 1.0, count), random.uniform(0.0, 2.0 * np.pi, count)
    sine = np.sqrt(1.0 - z * z)
    return np.stack([sine * np.cos(phi), sine * np.sin(phi), z], axis=1)


def same_bits(a, b):
    return a.dtype == b.dtype == np.float32 and a.shape == b.shape and np.array_equal(a.view(np.uint32), b.view(np.uint32))


def pairs_of(path):
    with open(path, encoding="utf-8") as file:
        table = table_of(file.read())
    return np.stack([table[name] for name in DIRECTIONS[:3]], axis=1), np.stack([table[name] for name in DIRECTIONS[3:]], axis=1)


def check_values(folder, random):
    wi, wo = directions(random, 2000), directions(random, 2000)
    many = os.path.join(folder, "many.csv")
    write(many, dict(zip(DIRECTIONS, np.hstack([wi, wo]).T)))
    demo = os.path.join(DEMO, "pairs.csv")
    red = os.path.join(DEMO, "red_plastic.binary")
    materials = {
        "scan": (os.path.join(DEMO, "blue_paint.brdf"), None),
        "MERL table": (red, None),
        "model": ("synth:ward?kd=0.2&ax=0.1&ay=0.4", None),
        "table pack": (encode(red, os.path.join(folder, "red.ktx2")), None),
        "wavelet pack": (encode("synth:ggx?alpha=0.4", os.path.join(folder, "ggx.ktx2"), "--codec", "wavelet"), None),
        "wavelet pack, level 2.25": (os.path.join(folder, "ggx.ktx2"), 2.25),
        "factored pack, level 0.5": (os.path.join(GOLDEN, "table/golden/levels-rgb.ktx2"), 0.5),
        "cropped pack": (os.path.join(GOLDEN, "table/golden/any-texels-symmetry-13-layers-3-cropped.ktx2"), None),
    }
    for what, (name, lod) in materials.items():
        material = brdfc.open(name)
        for path, (i, o) in {demo: pairs_of(demo), many: (wi, wo)}.items():
            expected = by_program(name, path, ["f_r", "f_g", "f_b"], lod)
            found = material.eval(i, o, lod)
            check(f"{what}, {os.path.basename(path)}", same_bits(found, expected), f"{len(i)} pairs, the same bits")
        # Exchanged directions of a material that is not reciprocal, or other ones, must be detected.
        check(f"{what}, other pairs are detected", not same_bits(material.eval(i[::-1], o, lod), expected))


def check_places(folder, random):
    count = 500
    uv, wi, wo = random.uniform(-0.5, 1.5, (count, 2)), directions(random, count), directions(random, count)
    path = os.path.join(folder, "places.csv")
    write(path, dict(zip(["u", "v", *DIRECTIONS], np.hstack([uv, wi, wo]).T)))
    wool = os.path.join(folder, "wool.ktx2")
    flatten = ["--texels", "16", "--views", "grid:2x6@50"]
    done = run("flatten", "synth:knit?resolution=48", "-o", os.path.join(folder, "wool"), *flatten, "--quiet")
    assert done.returncode == 0, done.stderr
    tree = os.path.join(GOLDEN, "pwt/golden/any-texels-tile-projected-linear.ktx2")
    for what, name, views in [("flat BTF", wool, [wo]), ("polynomial wavelet tree", tree, [])]:
        opened = brdfc.open(name)
        expected = by_program(name, path, ["r", "g", "b"], None)
        check(what, same_bits(opened.eval(uv, wi, *views), expected) and expected.any(), f"{count} places, the same bits")
        check(f"{what}, others are detected", not same_bits(opened.eval(uv[::-1], wi, *views), expected))


def check_arrays(random):
    material = brdfc.open("synth:ggx?alpha=0.4")
    wi, wo = directions(random, 1000), directions(random, 1000)
    expected = material.eval(wi, wo)
    wide = np.zeros((2000, 6))
    wide[::2, ::2] = wi
    check("strided arrays", same_bits(material.eval(wide[::2, ::2], np.asfortranarray(wo)), expected))
    check("lists", same_bits(material.eval(wi.tolist(), wo.tolist()), expected))
    single = wi.astype(np.float32), wo.astype(np.float32)
    check("float32 is widened", same_bits(material.eval(*single), material.eval(*(v.astype(np.float64) for v in single))))
    check("integers", same_bits(material.eval([[0, 0, 1]], [[0, 0, 1]]), material.eval([[0.0, 0.0, 1.0]], [[0.0, 0.0, 1.0]])))
    grid = material.eval(wi.reshape(20, 50, 3), wo.reshape(20, 50, 3))
    check("any shape", same_bits(grid.reshape(-1, 3), expected) and grid.shape == (20, 50, 3))
    check("a single pair", same_bits(material.eval(wi[7], wo[7]), expected[7]))
    table = material.eval(wi[:20, None], wo[None, :30])
    check("shapes are broadcast", table.shape == (20, 30, 3) and same_bits(table[7], material.eval(wi[7], wo[:30])))
    check("a masked array that masks nothing", same_bits(material.eval(np.ma.array(wi), wo), expected))
    check("no pairs", material.eval(np.zeros((0, 3)), np.zeros((0, 3))).shape == (0, 3))
    below = (wi[:, 2] <= 0.0) | (wo[:, 2] <= 0.0)
    check("below the horizon", below.any() and not expected[below].any() and expected[~below].all())
    check("lengths within 1 %", np.allclose(material.eval(1.005 * wi, wo), expected, rtol=1e-5))


def check_processes(random):
    """Forked processes evaluate and open files, although this process has had threads."""
    paint, wi = os.path.join(DEMO, "blue_paint.brdf"), directions(random, 1000, 0.0)
    expected = brdfc.open(paint).eval(wi, wi[::-1])
    with multiprocessing.get_context("fork").Pool(2) as pool:
        try:
            found = pool.starmap_async(opened_and_evaluated, [(paint, wi)] * 4).get(timeout=60)
        except multiprocessing.TimeoutError:
            found = []
    check("forked processes", len(found) == 4 and all(same_bits(values, expected) for values in found))


def opened_and_evaluated(name, wi):
    return brdfc.open(name).eval(wi, wi[::-1])


def check_facts(folder):
    material, pack = brdfc.open("synth:ward?ax=0.1&ay=0.4"), brdfc.open(os.path.join(folder, "red.ktx2"))
    check("a model's facts", (material.kind, material.isotropic, material.levels) == ("synth", False, 0))
    check("a pack's facts", (pack.kind, pack.isotropic, pack.levels) == ("table-pack", True, 0))
    fields = pack.pack()
    half, difference, *_ = fields["nodes"]
    check("a pack's texels", fields["values"].shape[2:] == (difference, half, 3) and 0.0 <= fields["values"].min())
    check("facts as `brdfc info` has them", pack.facts["axes"]["half"] == half)


def raised(call):
    try:
        call()
    except (ValueError, OSError) as error:
        return type(error), str(error)
    return None, ""


def check_errors(folder):
    broken = os.path.join(folder, "broken.ktx2")
    with open(broken, "wb") as file:
        file.write(b"\xabKTX 20\xbb\r\n\x1a\n")
    inputs = {
        "no file": (os.path.join(folder, "nothing.binary"), FileNotFoundError),
        "a folder": (folder, ValueError),
        "a broken pack": (broken, ValueError),
        "no such model": ("synth:nothing", ValueError),
        "no such parameter": ("synth:ggx?alfa=1", ValueError),
        "an unknown kind of file": (__file__, ValueError),
    }
    for what, (name, kind) in inputs.items():
        found, text = raised(lambda name=name: brdfc.open(name))
        by_eval = run("eval", name, "--directions", os.path.join(DEMO, "pairs.csv")).stderr.strip()
        check(what, found is kind and by_eval == f"brdfc: {text}", text)
    material, pack = brdfc.open("synth:lambert"), brdfc.open(os.path.join(folder, "ggx.ktx2"))
    up = [[0.0, 0.0, 1.0]]
    calls = {
        "wi: found an array of shape (), expected (..., 3)": lambda: material.eval(1.0, up),
        "wo: found an array of shape (1, 2), expected (..., 3)": lambda: material.eval(up, [[0.0, 1.0]]),
        "wo: found an array of shape (3, 3), expected a shape compatible with (2, 3) of wi": lambda: material.eval(up * 2, up * 3),
        "wi: masked numbers; fill or remove them": lambda: material.eval(
            np.ma.masked_less(up, 0.5), up
        ),
        "wi, row 1: found a vector of length 1.7321, expected unit vectors": lambda: material.eval(up + [[1, 1, 1]], up * 2),
        "wi, row 0: found [NaN, 0.0, 1.0], expected finite numbers": lambda: material.eval([[np.nan, 0, 1]], up),
        "wi: found an array of complex128, expected real numbers": lambda: material.eval([[0, 0, 1j]], up),
        "wi: found an array of object, expected real numbers": lambda: material.eval([[None, 0, 1]], up),
        "lod: only packs have levels of detail; omit lod": lambda: material.eval(up, up, 1),
        "lod: found 9, expected 0 to 5, the pack's levels": lambda: pack.eval(up, up, lod=9),
        "lod: found NaN, expected 0 to 5, the pack's levels": lambda: pack.eval(up, up, lod=np.nan),
        "pack: found synth:lambert (synth), expected a pack of a BRDF": material.pack,
    }
    for expected, call in calls.items():
        found, text = raised(call)
        check("refused", found is ValueError and text == expected, text)


def check_speed(folder, random):
    count = 1_000_000
    wi, wo = directions(random, count, 0.0), directions(random, count, 0.0)
    for what, name in [("model", "synth:ggx?alpha=0.4"), ("table pack", "red.ktx2"), ("wavelet pack", "ggx.ktx2")]:
        material = brdfc.open(name if what == "model" else os.path.join(folder, name))
        start = time.perf_counter()
        material.eval(wi, wo)
        print(f"speed   {what}: {count / (time.perf_counter() - start) / 1e6:.2f} million evaluations/s")
    # For the last one, the slowest.
    thread, steps = threading.Thread(target=material.eval, args=(wi, wo)), 0
    thread.start()
    while thread.is_alive():
        steps += 1
        time.sleep(0.001)
    check("other threads run meanwhile", steps > 10, f"{steps} steps")


def main():
    random = np.random.default_rng(1)
    print(f"brdfc {brdfc.__version__}, NumPy {np.__version__}, Python {sys.version.split()[0]}, {os.cpu_count()} threads")
    with tempfile.TemporaryDirectory() as folder:
        check_values(folder, random)
        check_places(folder, random)
        check_arrays(random)
        check_processes(random)
        check_facts(folder)
        check_errors(folder)
        check_speed(folder, random)
    print(f"{len(failures)} failed" if failures else "all passed")
    sys.exit(1 if failures else 0)


main()
