# SPDX-License-Identifier: Apache-2.0

"""The command `plumb`, which lies within the package. It is started from here, outside, because
importing the package would take longer than the command's own start."""

import os
import pathlib
import sys


def main() -> None:
    program = pathlib.Path(__file__).parent / "plumbline" / "bin" / "plumb"
    os.execv(program, ["plumb", *sys.argv[1:]])
