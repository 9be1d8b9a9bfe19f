# SPDX-License-Identifier: Apache-2.0

"""Renders the pictures and plots of docs/lessons/ and puts its tables in.

    python3 bench/lesson_pictures.py PLUMB [LESSON ...]    (which is 'make lesson-pictures')

Some fifteen minutes on two cores. What is rendered stays in out/lesson_pictures.
"""

import json
import math
import pathlib
import re
import shutil
import subprocess
import sys

ROOT = pathlib.Path(__file__).resolve().parent.parent
sys.dont_write_bytecode = True  # nothing but sources in the folders
sys.path.insert(0, str(ROOT / "images"))
import exr  # noqa: E402

OUT = ROOT / "out" / "lesson_pictures"
PICTURES = ROOT / "docs" / "pictures"
LESSONS = ROOT / "docs" / "lessons"
SCENES = ROOT / "reference_scenes"


def plumb(*arguments, accept=(0,)):
    result = subprocess.run([PLUMB, *map(str, arguments)], capture_output=True, text=True,
                            check=False)
    if result.returncode not in accept:
        sys.exit(result.stderr)


def render(scene, *options):
    """The picture of a scene with these options, of which each is a file of its own."""
    name = re.sub(r"[^\w.]+", "_", " ".join(map(str, [scene.parent.name, scene.stem, *options])))
    file = OUT / f"{name}.exr"
    plumb("render", scene, *options, "-o", file)
    return file


def series(scene, counts, *options):
    """Pictures of so many samples: each is the one before and as many again."""
    before, files = 0, []
    for samples in counts:
        part = render(scene, *options, "--seed", 1, "--samples", f"{before}:{samples}")
        if files:
            whole = part.with_stem(f"{part.stem}_merged")
            plumb("merge", files[-1], part, "-o", whole)
            part = whole
        files.append(part)
        before = samples
    return files


def changed(scene, name, **parameters):
    """The scene with other values of its <default>s."""
    text = scene.read_text("utf-8")
    for parameter, value in parameters.items():
        text = re.sub(rf'(<default name="{parameter}" value=")[^"]*', rf"\g<1>{value}", text)
    file = OUT / f"{name}.xml"
    file.write_text(text, "utf-8")
    return file


def errors(files, reference, plot=None):
    """relMSE of every picture, by series; and what is said of them."""
    report = OUT / "converge.json"
    plumb("converge", *files, "--reference", reference, "--json", report,
          *(["-o", plot] if plot else []))
    found = json.loads(report.read_text("utf-8"))
    return ([[point["relMse"]["all"][0] for point in one["points"]] for one in found["series"]],
            found["sentences"])


def mosaic(files, columns, file, brighter, enlarged=(), reference=None, times=1):
    """Pictures side by side; below, if there is a reference, their differences from it, so many times."""
    command = ["oiiotool"]
    for difference in ([[], [reference, "--ch", "R,G,B", "--absdiff", "--mulc", times]] if reference else [[]]):
        for picture in files:
            command += [picture, "--ch", "R,G,B", *difference, *enlarged, "--mulc", brighter,
                        "--colorconvert", "linear", "sRGB"]
    rows = -(-len(files) // columns) * (2 if reference else 1)
    subprocess.run([*map(str, command), "--mosaic:pad=4", f"{columns}x{rows}", "-d", "uint8", "-o", file],
                   check=True)


def put(lesson, name, head, rows, sentences=()):
    """A table, and what is said of it, between its marks in the lesson."""
    lines = ["| " + " | ".join(map(str, row)) + " |" for row in (head, ["---"] * len(head), *rows)]
    lines += ["", *(f"    {sentence}" for sentence in sentences)] if sentences else []
    file = LESSONS / f"{lesson}.md"
    pattern = rf"(<!-- table: {name} -->\n).*?(\n<!-- end of table -->)"
    text, count = re.subn(pattern, lambda m: f"{m[1]}\n" + "\n".join(lines) + f"\n{m[2]}",
                          file.read_text("utf-8"), flags=re.DOTALL)
    if count != 1:
        sys.exit(f"{file} has no place for the table {name}")
    file.write_text(text, "utf-8")


def percent(value):
    return f"{float(f'{100 * value:.3g}'):g} %"


def noise():
    kinds = {"sobol": ["--sampler", "sobol"], "independent": ["--sampler", "independent"],
             "webgl-random": ["--fault", "webgl-random"], "webgl-demo": ["--fault", "webgl-demo"]}
    scene, counts = SCENES / "cornell" / "scene.xml", [16 << i for i in range(9)]
    reference = scene.with_name("plumbline.exr")
    files = {kind: series(scene, counts, *options) for kind, options in kinds.items()}
    mosaic([files[kind][-1] for kind in list(kinds)[1:]], 3, PICTURES / "noise.png", 2.8, reference=reference, times=20)
    found, sentences = errors([file for kind in kinds for file in files[kind]], reference, PICTURES / "noise.svg")
    put("noise", "noise", ["samples per pixel", *kinds],
        [[count, *(f"{value:.2e}" for value in row)] for count, *row in zip(counts, *found)], sentences)


def means(file, window=None):
    """Of red, green and blue, over the picture or a window (x, y, width, height) of it."""
    width, height, planes = exr.planes(file, ["R", "G", "B"])
    x, y, across, down = window or (0, 0, width, height)
    return [sum(sum(plane[row * width + x:row * width + x + across]) for row in range(y, y + down))
            / (across * down) for plane in planes]


def bleeding():
    scene = SCENES / "cornell" / "scene.xml"
    bounces = ["0:0", "1:1", "2:2", "3:3", "4:4", "5:"]
    files = [render(scene, "--bounces", bounce, "--spp", 2048) for bounce in bounces]
    mosaic(files, 3, PICTURES / "bleeding.png", 2.8)
    found = [means(file) for file in files]
    total = [sum(row[c] for row in found) for c in range(3)]
    put("bleeding", "bounces", ["bounces", "red", "green", "blue"],
        [[word, *(percent(value / all_light) for value, all_light in zip(row, total))]
         for word, row in zip(["0 (the lamp itself)", "1 (direct light)", "2", "3", "4", "5 and more"], found)])
    shapes = {"the red wall": "left_wall", "the green wall": "right_wall", "the back wall": "back_wall",
              "the floor": "floor", "the ceiling": "ceiling", "the tall block": "tall_block",
              "the short block": "short_block"}
    parts = {word: render(scene, "--by", shape, "--spp", 512) for word, shape in shapes.items()}
    reflected = [sum(row[c] for row in found[1:]) for c in range(3)]
    put("bleeding", "by", ["reflected by", "red", "green", "blue"],
        [[word, *(percent(value / light) for value, light in zip(means(file), reflected))] for word, file in parts.items()])
    # Patches of the back wall, above the blocks.
    patches = {"beside the red wall": (58, 70, 8, 16), "in the middle": (124, 70, 8, 16),
               "beside the green wall": (190, 70, 8, 16)}
    whole = render(scene, "--spp", 2048)
    mosaic([whole, parts["the red wall"], parts["the green wall"]], 3, PICTURES / "bleeding_by.png", 2.8)
    put("bleeding", "wall", ["back wall", "direct light, R : G", "2 bounces, R : G", "all light, R : G"],
        [[word, *(f"{red / green:.2f}" for red, green, _ in (means(file, window)
                                                             for file in (files[1], files[2], whole)))]
         for word, window in patches.items()])


def shadows():
    scene, sizes, power = LESSONS / "shadows.xml", [0.01, 0.1, 0.25, 0.5, 1, 2], 6
    views = [render(changed(scene, f"shadows_{size}", size=size, radiance=power / size ** 2), "--spp", 1024)
             for size in sizes]
    mosaic(views, 3, PICTURES / "shadows.png", 1.4)
    # A camera below the plate looks down on the shadow's edge, 0.9 m to both sides; rows run along z.
    below = {"eye": "0.75, 0.9, 0", "target": "0.75, 0, 0", "up": "0, 0, 1"}
    rows = []
    for size in sizes[:5]:
        ramp = []
        for plate in (0.5, 0.001):
            file = changed(scene, f"below_{size}_{plate}", size=size, radiance=power / size ** 2, plate=plate, **below)
            picture = render(file, "--size", "768x576", "--spp", 256, "--bounces", "1:1")
            width, height, (red, *_) = exr.planes(picture, ["R", "G", "B"])
            ramp.append([sum(red[y * width + x] for y in range(height // 2 - 8, height // 2 + 8))
                         for x in range(width)])
        seen = [shadowed / max(free, 1e-9) for shadowed, free in zip(*ramp)]
        # Half of the film is 0.9 m * tan(fov / 2) wide.
        pixel = 2 * 0.9 * 0.46631 / len(seen)
        tenths = [sum(part < level for part in seen) * pixel for level in (0.1, 0.9)]
        rows.append([f"{2 * size:g} m", f"{size:g} m", f"{abs(tenths[1] - tenths[0]) / 0.8:.3f} m"])
    put("shadows", "penumbra", ["side of the lamp", "width of the penumbra, computed", "measured"], rows)


METHODS = {"by chance (bsdf)": ["--method", "bsdf"], "sampled (nee)": ["--method", "nee"],
           "both (mis)": ["--method", "mis"]}


def by_method(lesson, name, bounces, methods, variants, shown, brighter, head="side of the lamp"):
    """A scene with several values of its parameters: its table, and the pictures of some, by each method."""
    rows, pictures = [], []
    for title, parameters in variants.items():
        scene = changed(LESSONS / f"{name}.xml", "_".join(map(str, [name, *parameters.values()])), **parameters)
        reference = render(scene, "--bounces", bounces, "--method", "mis", "--spp", 8192, "--seed", 0)
        found = []
        for method in methods.values():
            options = ["--bounces", bounces, *method, "--sampler", "independent"]
            (points,), _ = errors([render(scene, *options, "--spp", 64, "--seed", seed) for seed in range(1, 9)],
                                  reference)
            found.append((sum(points) / len(points)) ** 0.5)
            if title in shown:
                pictures.append(render(scene, *options, "--spp", 16))
        best = min(found)
        rows.append([title, *(f"**{percent(value)}**" if value == best else percent(value) for value in found)])
    mosaic(pictures, len(methods), PICTURES / f"{name}.png", brighter)
    put(lesson, name, [head, *methods], rows)


def lamp_of(half_side, radiance):
    """With this radiance the picture is about as bright as with other lamps."""
    return {"size": half_side, "radiance": radiance}


def lamp():
    by_method("lamp", "lamp", "0:1", METHODS,
              {"2 cm": lamp_of(0.01, 20000), "40 cm": lamp_of(0.2, 50), "2 m": lamp_of(1, 3),
               "6 m": lamp_of(3, 1.2), "20 m": lamp_of(10, 1)},
              ["2 cm", "2 m", "20 m"], 0.6)
    # The fault samples lamps, but does not look for them in mirrors.
    by_method("lamp", "mirrors", "0:2", METHODS | {"both, without mirrors": ["--fault", "webgl-random"]},
              {"2 cm": lamp_of(0.01, 20000), "20 cm": lamp_of(0.1, 200), "60 cm": lamp_of(0.3, 22)},
              ["20 cm"], 0.8)


def reflectance(angle, n):
    """Of unpolarised light by the smooth border of what is optically n times as dense: Fresnel's laws."""
    if math.sin(angle) >= n:
        return 1.0
    if angle == 0.0:
        return ((n - 1) / (n + 1)) ** 2
    beyond = math.asin(math.sin(angle) / n)
    return sum((f(angle - beyond) / f(angle + beyond)) ** 2 for f in (math.sin, math.tan)) / 2


def border(n, degrees=0, **light):
    """The radiance that the border of glass shows at an angle."""
    eye = f"{math.sin(math.radians(degrees))}, {math.cos(math.radians(degrees))}, 0"
    name = "_".join(map(str, ["border", f"{n:.4f}", degrees, *light]))
    return means(render(changed(LESSONS / "border.xml", name, n=n, eye=eye, **light), "--spp", 1 << 16))[0]


def glass():
    views = [render(changed(LESSONS / "glass.xml", f"glass_{n}", n=n), "--spp", 2048) for n in (1.1, 1.33, 1.5, 2.4)]
    mosaic(views, 4, PICTURES / "glass_balls.png", 0.8)
    put("glass", "reflectance", ["angle", "in air, computed", "measured", "in glass, computed", "measured"],
        [[f"{degrees}°", *(f"{100 * value:.3f} %" for n in (1.5, 1 / 1.5)
                           for value in (reflectance(math.radians(degrees), n), border(n, degrees)))]
         for degrees in (0, 20, 40, 41.5, 45, 60, 75, 85)])
    below = {"sky": 0, "lamp": 1}
    put("glass", "square", ["n", "lamp in glass, seen in air: (1 − R) / n²", "measured",
                            "lamp in air, seen in glass: (1 − R) · n²", "measured"],
        [[n, *(f"{value:.4f}" for ratio in (n, 1 / n)
               for value in ((1 - reflectance(0.0, ratio)) / ratio ** 2, border(ratio, **below)))]
         for n in (1, 1.33, 1.5, 2.4)])
    lamps = {"60 cm": lamp_of(0.3, 16), "20 cm": lamp_of(0.1, 144)}
    by_method("glass", "glass", "0:3", METHODS,
              {f"{ball}, {side}": {"ball": ball} | parameters for ball in ("steel", "glass")
               for side, parameters in lamps.items()},
              ["steel, 60 cm", "glass, 60 cm"], 0.8, "ball, side of the lamp")


def with_fault(name, scene, reference, fault):
    """The table and the plot of a scene with a fault and without; and the pictures of both."""
    counts = [4 << i for i in range(11)]
    right, wrong = series(scene, counts), series(scene, counts, "--fault", fault)
    found, sentences = errors([*right, *wrong], reference, PICTURES / f"bias_{name}.svg")
    put("bias", name, ["samples per pixel", "right", fault],
        [[count, *(percent(value ** 0.5) for value in row)] for count, *row in zip(counts, *found)], sentences)
    return right, wrong


def bias():
    cornell = SCENES / "cornell"
    with_fault("bounces", cornell / "scene.xml", cornell / "plumbline.exr", "five-bounces")
    caustic = LESSONS / "caustic.xml"
    reference = render(caustic, "--spp", 65536, "--seed", 0)
    # What the page needs of it.
    subprocess.run(["oiiotool", reference, "--ch", "R,G,B", "-d", "half", "--compression", "zip",
                    "--eraseattrib", ".*", "-o", caustic.with_suffix(".exr")], check=True)
    right, wrong = with_fault("clamp", caustic, reference, "clamp-indirect")
    mosaic([right[4], wrong[4], reference], 3, PICTURES / "bias_clamp.png", 1,
           enlarged=["--resize:filter=box", "256x256"])


def sweeps_until(error, rows, way):
    return next(row["sweeps"] for row in rows if row[way] <= error)


def radiosity():
    folder = OUT / "radiosity"
    plumb("radiosity", SCENES / "cornell" / "scene.xml", "--exposure", 1, "--teach", folder)
    for file in [*folder.glob("*.png"), *folder.glob("*.svg")]:
        shutil.copy(file, PICTURES / f"radiosity_{file.name}")
    goral = {bounces: OUT / f"goral_{number}.exr" for number, bounces in enumerate(("0:1", "0:2", "0:"))}
    for bounces, file in goral.items():
        plumb("radiosity", SCENES / "goral" / "scene.xml", "--bounces", bounces, "-o", file)
    mosaic(goral.values(), 3, PICTURES / "goral.png", 1)

    numbers = json.loads((folder / "lesson.json").read_text("utf-8"))
    factors = numbers["form_factors"]
    put("radiosity", "laws", ["", "from four points of each patch", "made reciprocal"],
        [["a row's sum differs from what the whole faces say by, at most",
          f"{factors['row_sum_error']:.1e}", f"{factors['row_sum_error_after']:.1e}"],
         ["A<sub>i</sub> F<sub>ij</sub> and A<sub>j</sub> F<sub>ji</sub> differ by, in the mean",
          percent(factors["lack_of_reciprocity"]), f"{factors['lack_of_reciprocity_after']:.1e}"],
         ["the matrix was changed by, in the mean", "", percent(factors["changed"])]])
    put("radiosity", "hemicubes", ["cells along an edge", "light that goes astray"],
        [[row["resolution"], percent(row["error"])] for row in numbers["hemicubes"]]
        + [["exact, but from the patch's middle", percent(numbers["hemicubes"][0]["middle"])]])
    bounces = numbers["bounces"]
    put("radiosity", "bounces", ["bounce", "share of red, green, blue light", "times the one before"],
        [[row["bounce"], ", ".join(map(percent, row["share"])),
          ", ".join(f"{ratio:.3f}" for ratio in row.get("ratio", []))] for row in bounces["rows"]
         if row["bounce"] <= 6 or row["bounce"] % 10 == 0]
        + [[title, "", ", ".join(f"{value:.3f}" for value in bounces[name])]
           for title, name in (("in the long run", "spectral_radius"), ("largest reflectance", "bound"))])
    shots = numbers["shooting"]
    put("radiosity", "shooting", ["shots", "not yet sent", "error", "with the ambient term"],
        [[row["shots"], *(percent(row[name]) for name in ("unshot", "error", "with_ambient"))]
         for row in shots if row["shots"] in (1, 10, 100, 1000) or row is shots[-1]])
    ways = {"Jacobi": "jacobi", "Gauss-Seidel": "gauss_seidel", "shooting": "shooting"}
    put("radiosity", "sweeps", ["sweeps until the error is", *ways],
        [[f"{error:.0e}", *(sweeps_until(error, numbers["sweeps"], way) for way in ways.values())]
         for error in (1e-1, 1e-2, 1e-3, 1e-5, 1e-7)])
    put("radiosity", "meshes", ["patches", "flat", "interpolated"],
        [[row["patches"], percent(row["flat"]), percent(row["interpolated"])] for row in numbers["meshes"]])


if __name__ == "__main__":
    ALL = {lesson.__name__: lesson for lesson in (noise, bleeding, shadows, lamp, glass, bias, radiosity)}
    if len(sys.argv) < 2 or not set(sys.argv[2:]) <= set(ALL):
        sys.exit(__doc__)
    PLUMB = sys.argv[1]
    OUT.mkdir(parents=True, exist_ok=True)
    for chosen in sys.argv[2:] or ALL:
        ALL[chosen]()
