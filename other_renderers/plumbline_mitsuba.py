# SPDX-License-Identifier: Apache-2.0

"""Renders a scene file with Mitsuba 3.

    python3 plumbline_mitsuba.py cornell/scene.xml -o cornell.exr --spp 256 --seed 1

Mitsuba is installed by 'pip install mitsuba'. Its variant llvm_ad_rgb is used where there is an LLVM
that it works with (DRJIT_LIBLLVM_PATH names one), else scalar_rgb, which is slower.
"""

import argparse
import json
import pathlib
import subprocess
import sys
import time

TRIAL = """
import drjit, mitsuba
mitsuba.set_variant("llvm_ad_rgb")
drjit.eval(drjit.minimum(mitsuba.Float([1, 2]), 1))
"""


def parse_arguments():
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("scene", help="scene file", type=pathlib.Path)
    parser.add_argument("-o", dest="output", required=True, metavar="FILE", help="linear .exr")
    parser.add_argument("--spp", type=int, default=64, help="samples per pixel (default: 64)")
    parser.add_argument("--seed", type=int, default=0, help="another seed gives other noise")
    parser.add_argument("--bounces", type=int, help="light of at most N bounces (default: all)")
    parser.add_argument("--size", help="WxH (default: the scene's)")
    parser.add_argument("--x-fov", type=float, metavar="DEGREES",
                        help="of that size, along x (default: the scene's)")
    parser.add_argument("--threads", type=int, help="at most (default: one per processor)")
    parser.add_argument("--integrator", default="path", help="default: path")
    parser.add_argument("--variant", help="default: see above")
    return parser.parse_args()


def usable_variant():
    """Some versions of LLVM end the process, so that another one has to try."""
    trial = subprocess.run([sys.executable, "-c", TRIAL], capture_output=True, check=False)
    return "scalar_rgb" if trial.returncode else "llvm_ad_rgb"


def load_scene(mitsuba, file, size, x_fov):
    """The scene as it is, but for a sampler if it has none, and the size. Mitsuba makes the field
    of view along x from that of the file's own size, and then keeps it."""
    data = file.read_bytes()
    text = data.decode("utf-16" if data[:2] in (b"\xff\xfe", b"\xfe\xff") else "utf-8-sig")
    # The numbers of ldsampler depend on each other (findings/mitsuba_ldsampler.py).
    text = text.replace('type="ldsampler"', 'type="multijitter"')
    if "<sampler" not in text:
        text = text.replace("</sensor>", '<sampler type="multijitter"/></sensor>')
    mitsuba.file_resolver().append(str(file.parent))
    scene = mitsuba.load_string(text)
    parameters = mitsuba.traverse(scene.sensors()[0])
    wanted = [int(side) for side in size.split("x")] if size else list(parameters["film.size"])
    if list(parameters["film.size"]) != wanted:
        parameters["film.size"] = wanted
        if x_fov:
            parameters["x_fov"] = x_fov
        parameters.update()
    return scene


def main():
    arguments = parse_arguments()
    try:
        import drjit
        import mitsuba
    except ImportError:
        sys.exit("Mitsuba is not installed for this python3: pip install mitsuba")
    variant = arguments.variant or usable_variant()
    mitsuba.set_variant(variant)
    if arguments.threads:
        # With a single one it waits for ever.
        drjit.set_thread_count(max(2, arguments.threads))
    # Mitsuba counts the path's edges: emission seen directly has a depth of 1.
    depth = -1 if arguments.bounces is None else arguments.bounces + 1
    integrator = mitsuba.load_dict({"type": arguments.integrator, "max_depth": depth})
    scene = load_scene(mitsuba, arguments.scene, arguments.size, arguments.x_fov)

    def render(spp, seed):
        mitsuba.render(scene, integrator=integrator, spp=spp, seed=seed)
        # The film may be one of XYZ, or have an alpha.
        bitmap = scene.sensors()[0].film().bitmap()
        return bitmap.convert(mitsuba.Bitmap.PixelFormat.RGB, mitsuba.Struct.Type.Float32, False)

    render(arguments.spp, arguments.seed + 1)  # compiles
    begin = time.perf_counter()
    picture = render(arguments.spp, arguments.seed)
    seconds = time.perf_counter() - begin
    picture.write(arguments.output)
    settings = {"variant": variant, "sampler": "multijitter", "integrator": arguments.integrator,
                "max_depth": depth, "spp": arguments.spp, "seed": arguments.seed}
    report = {"program": f"Mitsuba {mitsuba.__version__}", "version": mitsuba.__version__,
              "seconds": seconds, "settings": settings}
    print("plumbline: " + json.dumps(report))


if __name__ == "__main__":
    main()
