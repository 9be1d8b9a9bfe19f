# SPDX-License-Identifier: Apache-2.0

"""Makes a wheel that has inside what it needs, for this Python and C libraries as old as this machine's.

    python3 python/make_wheel.py FOLDER     (in a virtual environment with what `make package` puts there)

Debian's OpenImageIO needs 250 libraries, 350 MB, some under the GPL. PyPI's needs none, but has no headers;
those are in its sources.
"""

import os
import pathlib
import re
import shutil
import subprocess
import sys
import zipfile

ROOT = pathlib.Path(__file__).resolve().parent.parent
BUILD = ROOT / "build" / "wheel"
OPENIMAGEIO = "3.2.2.0"
# Every Linux has those of the C++ compiler.
EVERYWHERE = {"libc6", "libgcc-s1", "libstdc++6"}


def run(*command, **environment):
    subprocess.run([str(word) for word in command], cwd=ROOT, check=True, env={**os.environ, **environment})


def pip(*words, **environment):
    run(sys.executable, "-m", "pip", "--quiet", "--disable-pip-version-check", *words, **environment)


def get_openimageio(folder):
    """Lays OpenImageIO out as an installation that pkg-config finds."""
    for kind in ("--only-binary", "--no-binary"):
        pip("download", "--no-deps", "--no-build-isolation", kind, "openimageio", "--dest", folder,
            f"openimageio=={OPENIMAGEIO}")
    with zipfile.ZipFile(next(folder.glob("*.whl"))) as wheel:
        wheel.extractall(folder / "wheel")
    run("tar", "-C", folder, "-xf", next(folder.glob("*.tar.gz")))
    libraries = folder / "wheel" / "OpenImageIO" / "lib"
    for library in list(libraries.glob("*.so.*")):
        (libraries / f"{library.name.partition('.')[0]}.so").symlink_to(library.name)
    include = next(folder.glob("openimageio-*/src/include"))
    configure_version(include / "OpenImageIO" / "oiioversion.h")
    (folder / "OpenImageIO.pc").write_text(
        f"Name: OpenImageIO\nDescription: of PyPI\nVersion: {OPENIMAGEIO}\nCflags: -I{include}\n"
        f"Libs: -L{libraries} -lOpenImageIO -lOpenImageIO_Util\n")
    return libraries


def configure_version(header):
    """Fills in what its build would have."""
    major, minor, patch, tweak = OPENIMAGEIO.split(".")
    known = {"PROJECT_VERSION_MAJOR": major, "PROJECT_VERSION_MINOR": minor, "PROJECT_VERSION_PATCH": patch,
             "PROJECT_VERSION_TWEAK": tweak, "PROJECT_VERSION_RELEASE_TYPE": "", "PROJ_NAMESPACE": "OpenImageIO",
             "PROJ_VERSION_NAMESPACE": f"v{major}_{minor}", "OIIO_USE_COMPILED_FMT_VALUE": "0",
             "Imath_VERSION_MAJOR": "3", "Imath_VERSION_MINOR": "1", "CMAKE_CXX_STANDARD": "17"}
    text = header.with_name("oiioversion.h.in").read_text()
    text = re.sub(r"@(\w+)@", lambda name: known[name[1]], text)
    header.write_text(re.sub(r"#cmakedefine01 (\w+)", r"#define \1 0", text))


def licences_of(program):
    """(name, text) of what Debian says of the libraries that go into the wheel."""
    linked = subprocess.run(["ldd", program], capture_output=True, text=True, check=True).stdout
    files = [os.path.realpath(file) for file in re.findall(r"=> (/usr/\S+|/lib/\S+)", linked)]
    owners = subprocess.run(["dpkg", "-S", *files], capture_output=True, text=True, check=False).stdout
    for package in sorted(set(re.findall(r"^([^:]+):", owners, re.MULTILINE)) - EVERYWHERE):
        yield package, pathlib.Path(f"/usr/share/doc/{package}/copyright").read_text()


def main():
    target = pathlib.Path(sys.argv[1]).resolve()
    given, made = BUILD / "openimageio", BUILD / "made"
    for folder in (given, made):
        shutil.rmtree(folder, ignore_errors=True)
        folder.mkdir(parents=True)
    libraries = get_openimageio(given)
    pip("wheel", "--no-deps", "--no-build-isolation", "--config-settings=build-dir=build/wheel/build",
        "--wheel-dir", made, ROOT, PKG_CONFIG_PATH=str(given))
    wheel = next(made.glob("*.whl"))
    with zipfile.ZipFile(wheel, "a") as archive:
        about = next(name for name in archive.namelist() if name.endswith(".dist-info/METADATA"))[:-len("METADATA")]
        for package, text in licences_of(BUILD / "build" / "plumb"):
            archive.writestr(f"{about}licenses/{package}", text)
        for file in (given / "wheel").glob("*.dist-info/licenses/*"):
            archive.write(file, f"{about}licenses/OpenImageIO-{file.name}")
    run(sys.executable, "-m", "auditwheel", "repair", "--wheel-dir", target, wheel, LD_LIBRARY_PATH=str(libraries),
        PATH=f"{pathlib.Path(sys.executable).parent}:{os.environ['PATH']}")


if __name__ == "__main__":
    if len(sys.argv) != 2:
        sys.exit(__doc__)
    main()
