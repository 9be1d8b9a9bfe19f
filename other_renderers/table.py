# SPDX-License-Identifier: Apache-2.0

"""The table of other renderers, for Python."""

import json
import pathlib
import subprocess
import tomllib


def described(file):
    """The same of a renderer's description (docs/renderers.md), whose place is `with`."""
    path = pathlib.Path(file).resolve()
    description = tomllib.loads(path.read_text(encoding="utf-8"))
    return {"word": path.stem, "name": description.get("name", path.stem), "isInstalled": True,
            "hasSamples": any("{spp}" in word for word in description["command"]), "with": str(path)}


def other_renderers(plumb, descriptions=()):
    """What `plumb reference --list` says of each, in the order of their words; then others'."""
    result = subprocess.run([plumb, "reference", "--list"], capture_output=True, text=True,
                            check=True)
    known = sorted(json.loads(result.stdout), key=lambda renderer: renderer["word"])
    return [*({**renderer, "with": renderer["word"]} for renderer in known),
            *map(described, descriptions)]
