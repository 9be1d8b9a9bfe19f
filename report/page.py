# SPDX-License-Identifier: Apache-2.0

"""Fills the report's page: one HTML file that holds style, script, pictures and numbers."""

import base64
import html
import json
import math
import pathlib
import re
import struct
import zlib

from . import sections

HERE = pathlib.Path(__file__).resolve().parent
LARGEST_HALF = 65504.0


def title_of(scene):
    """Of a folder of reference_scenes/."""
    return {"cornell": "Cornell box", "seed": "Seed scene"}.get(scene, scene.replace("_", " ").capitalize())


def encode_picture(planes, mantissa_bits=10):
    """Planes of floats as text: half precision, compressed, base64.

    Rows run from the top. A plane's low bytes stand before its high bytes, because only the high ones
    compress well. Fewer mantissa bits (10 is all of them) make the text shorter.
    """
    parts = []
    for plane in planes:
        clamped = [max(min(value, LARGEST_HALF), -LARGEST_HALF) for value in plane]
        halves = struct.pack(f"<{len(clamped)}e", *clamped)
        if mantissa_bits < 10:
            halves = _round(halves, 10 - mantissa_bits)
        parts += [halves[0::2], halves[1::2]]
    return base64.b64encode(zlib.compress(b"".join(parts), 9)).decode("ascii")


def _round(halves, dropped_bits):
    """Halves with their last bits rounded away; the sum carries into the exponent, as it should."""
    unit = 1 << dropped_bits
    largest = 0x7C00 - unit
    form = f"<{len(halves) // 2}H"
    rounded = []
    for half in struct.unpack(form, halves):
        sign, size = half & 0x8000, half & 0x7FFF
        size = min((size + unit // 2) // unit * unit, largest) if size < 0x7C00 else size
        rounded.append(sign | size)
    return struct.pack(form, *rounded)


def _json_value(value):
    """JSON has no NaN and no infinity: the page shows them as not known."""
    if isinstance(value, dict):
        return {key: _json_value(entry) for key, entry in value.items()}
    if isinstance(value, (list, tuple)):
        return [_json_value(entry) for entry in value]
    return None if isinstance(value, float) and not math.isfinite(value) else value


def _script(name):
    """A file of the page's script; the whole is no module, and exports nothing."""
    lines = (HERE / name).read_text("utf-8").splitlines(keepends=True)
    return "".join(line for line in lines if not line.startswith("export "))


def link_to_lessons(file):
    """A line of HTML for the page `file`, if the lessons' pages lie beside it."""
    if not (pathlib.Path(file).parent / "lessons" / "index.html").exists():
        return ""
    return '<p><a href="lessons/index.html">Lessons</a> on how light is computed, with live pictures.</p>'


def write_page(data, file):
    """Writes the page beside `file` and renames it: a killed run leaves the old page or the new one."""
    data = _json_value(data)
    pictures = [{"name": scene["name"], "pictures": [
        {name: picture[name] for name in ("title", "width", "height", "values", "errors")}
        for picture in scene["pictures"]]} for scene in data["scenes"]]
    parts = {
        "title": html.escape(data["title"]),
        "made": html.escape(f"Plumbline {data['version']} · {data['made']} · {data['host']}"),
        "incomplete": html.escape(data["incomplete"]),
        **{name: "".join(sections.text("li", line) for line in data[name]) for name in ("summary", "notes")},
        "front": sections.front(data["scenes"], data["programs"]) if "programs" in data else "",
        "tabs": "".join(map(sections.tab, data["scenes"])),
        "scenes": "\n".join(map(sections.section, data["scenes"])),
        "style": (HERE / "page.css").read_text("utf-8"),
        "script": _script("pictures.js") + _script("viewer.js") + _script("plots.js") + _script("page.js"),
        "lessons": link_to_lessons(file),
        # A "<" in the data would let a title end the script element.
        "data": json.dumps(pictures, separators=(",", ":")).replace("<", "\\u003c"),
    }
    page = re.sub("{{([a-z]+)}}", lambda match: parts[match[1]], (HERE / "page.html").read_text("utf-8"))
    file = pathlib.Path(file)
    unfinished = file.with_name(file.name + ".part")
    unfinished.write_text(page, "utf-8")
    unfinished.replace(file)
