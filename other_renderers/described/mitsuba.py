# SPDX-License-Identifier: Apache-2.0

"""Renders a scene file with any of Mitsuba 3's integrators and variants, for the descriptions here.

    python3 mitsuba.py SCENE -o OUT.exr --spp N --seed N --depth N --integrator NAME --variant NAME
"""

import argparse
import json
import pathlib
import sys
import time

# This file has the name of the module.
sys.path[:] = [path for path in sys.path if pathlib.Path(path or ".").resolve() != pathlib.Path(__file__).parent.resolve()]
import mitsuba  # noqa: E402


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("scene", type=pathlib.Path)
    parser.add_argument("-o", dest="output", required=True)
    for name in ("spp", "seed", "depth", "width", "height"):
        parser.add_argument(f"--{name}", type=int, required=True)
    parser.add_argument("--integrator", default="path")
    parser.add_argument("--variant", default="llvm_ad_rgb")
    arguments = parser.parse_args()
    mitsuba.set_variant(arguments.variant)
    integrator = mitsuba.load_dict({"type": arguments.integrator, "max_depth": arguments.depth})
    mitsuba.file_resolver().append(str(arguments.scene.parent))
    text = arguments.scene.read_text(encoding="utf-8")
    scene = mitsuba.load_string(text.replace("</sensor>", '<sampler type="independent"/></sensor>'))
    film = mitsuba.traverse(scene.sensors()[0])
    film["film.size"] = [arguments.width, arguments.height]
    film.update()
    begin = time.perf_counter()
    mitsuba.render(scene, integrator=integrator, spp=arguments.spp, seed=arguments.seed)
    bitmap = scene.sensors()[0].film().bitmap()
    bitmap.convert(mitsuba.Bitmap.PixelFormat.RGB, mitsuba.Struct.Type.Float32, False).write(arguments.output)
    print("plumbline: " + json.dumps({"version": mitsuba.__version__,
                                      "seconds": time.perf_counter() - begin}))


if __name__ == "__main__":
    main()
