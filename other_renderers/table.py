# SPDX-License-Identifier: Apache-2.0

"""The table of other renderers, for Python."""

import json
import subprocess


def other_renderers(plumb):
    """What `plumb reference --list` says of each, in the order of their words."""
    result = subprocess.run([plumb, "reference", "--list"], capture_output=True, text=True,
                            check=True)
    return sorted(json.loads(result.stdout), key=lambda renderer: renderer["word"])
