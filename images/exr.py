# SPDX-License-Identifier: Apache-2.0

"""What the project's scripts read of an EXR: what it says about itself, and its pixels."""

import json
import pathlib
import struct
import subprocess
import tempfile


def _fields(data):
    """The header's attributes, name by name as (kind, bytes), and where the header ends."""
    found, at = {}, 8
    while data[at]:
        name, kind, rest = data[at:at + 600].split(b"\0", 2)
        at += len(name) + len(kind) + 2
        size = struct.unpack_from("<i", data, at)[0]
        found[name.decode()] = (kind, data[at + 4:at + 4 + size])
        at += 4 + size
    return found, at + 1


# Names in what provenance() returns, as provenance.cpp spells them.
SCENE_HASH, WALL_SECONDS, HOST, RUNS = "sceneHash", "wallSeconds", "host", "runs"


def provenance(file):
    """What the picture says of itself: the attributes 'plumbline:...' of an EXR file's header."""
    formats = {b"double": "<d", b"int": "<i"}
    prefix = "plumbline:"
    found = {name[len(prefix):]: (struct.unpack(formats[kind], value)[0] if kind in formats
                                  else value.decode())
             for name, (kind, value) in _fields(file.read_bytes())[0].items()
             if name.startswith(prefix)}
    if RUNS in found:
        found[RUNS] = json.loads(found[RUNS])
    return found


def channels(file):
    names, at = [], 0
    data = _fields(file.read_bytes())[0]["channels"][1]
    while data[at]:
        end = data.index(b"\0", at)
        names.append(data[at:end].decode())
        at = end + 17
    return names


def planes(file, names, power=1.0):
    """(width, height, a sequence of floats for each name, rows from the top), in half precision."""
    with tempfile.TemporaryDirectory() as folder:
        plain = pathlib.Path(folder) / "plain.exr"
        subprocess.run(["oiiotool", file, "--ch", ",".join(f"plane{i}={name}" for i, name in enumerate(names)),
                        "--powc", str(power), "-d", "half", "--compression", "none", "--scanline",
                        "-o", plain], check=True)
        data = plain.read_bytes()
    fields, begin = _fields(data)
    x0, y0, x1, y1 = struct.unpack("<4i", fields["dataWindow"][1])
    width, height = x1 - x0 + 1, y1 - y0 + 1
    found = [[] for _ in names]
    row = struct.Struct(f"<{width * len(names)}e")
    for y in range(height):
        # A table of the rows' places, and before each row its number and its size.
        values = row.unpack_from(data, begin + 8 * height + y * (8 + row.size) + 8)
        for c, plane in enumerate(found):
            plane.extend(values[c * width:(c + 1) * width])
    return width, height, found
