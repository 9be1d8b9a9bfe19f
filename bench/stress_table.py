# SPDX-License-Identifier: Apache-2.0

"""Writes the tables of docs/stability.md.

    python3 bench/stress_table.py PLUMB    (which is 'make stress')

Has PLUMB try every method and every installed program on every scene, 2 seconds each.
"""

import pathlib
import subprocess
import sys

ROOT = pathlib.Path(__file__).resolve().parent.parent
sys.path.insert(0, str(ROOT / "other_renderers"))
from table import other_renderers  # noqa: E402

DOCUMENT = ROOT / "docs" / "stability.md"
BEGIN = "<!-- tables: made by 'make stress' -->\n"
END = "<!-- end of tables -->"


def verdicts(lines):
    """A row for each scene and a column for each method or program."""
    scenes = {}
    columns = {}
    for cells in ([cell.strip() for cell in line.strip("|\n").split("|")] for line in lines):
        row = scenes.setdefault(cells[0], [])
        if cells[-1] != "-":  # else the program hasn't said its version
            columns[len(row)] = cells[1]
        columns.setdefault(len(row), cells[1])
        row.append(cells[-1])
    yield "| scene | " + " | ".join(columns.values()) + " |\n"
    yield "|---" * (len(columns) + 1) + "|\n"
    for scene, row in scenes.items():
        yield f"| {scene} | " + " | ".join(row) + " |\n"


def main():
    words = ",".join(renderer["word"] for renderer in other_renderers(sys.argv[1]))
    command = [sys.argv[1], "stress", "--with", words, "--time", "2"]
    result = subprocess.run(command, cwd=ROOT, stdout=subprocess.PIPE, text=True, check=False)
    if result.returncode > 1:
        return result.returncode
    lines = result.stdout.splitlines(keepends=True)
    head, rows = lines[:4], lines[4:]
    text = DOCUMENT.read_text(encoding="utf-8")
    before, rest = text.split(BEGIN)
    after = rest.split(END)[1]
    table = "".join([head[0], "\n", *verdicts(rows), "\n", *head[2:], *rows])
    DOCUMENT.write_text(f"{before}{BEGIN}\n{table}\n{END}{after}", encoding="utf-8")
    return result.returncode


if __name__ == "__main__":
    if len(sys.argv) != 2:
        sys.exit(__doc__)
    sys.exit(main())
