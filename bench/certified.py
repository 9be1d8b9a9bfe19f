# SPDX-License-Identifier: Apache-2.0

"""Certifies every described renderer that is installed, and writes the table of docs/certified.md.

    python3 bench/certified.py build/plumb [FOLDER]

FOLDER (out/certified) holds the certificates. One that is there already is not made anew. Rows of programs that are
not installed stay as they are.
"""

import json
import pathlib
import subprocess
import sys

ROOT = pathlib.Path(__file__).resolve().parent.parent
PAGE = ROOT / "docs/certified.md"
BEGIN, END = "<!-- made by bench/certified.py: begin -->\n", "<!-- end -->\n"
MARKS = ("right", "wrong", "can't", "too noisy to tell", "failed")
HEADINGS = ("program", "version", "passed", *MARKS, "first wrong", "seconds")


def renderers():
    return ["mitsuba", "cycles", "povray", *map(str, sorted((ROOT / "other_renderers/described").glob("*.toml")))]


def certify(plumb, renderer, folder):
    """The certificate; None if the program is not there."""
    page = folder / f"{pathlib.Path(renderer).stem}.html"
    certificate = page.with_suffix(".json")
    if not certificate.exists():
        subprocess.run([plumb, "certify", "--with", renderer, "--quick", "-o", page], cwd=ROOT, check=False)
    if not certificate.exists():
        return None
    found = json.loads(certificate.read_text(encoding="utf-8"))
    return found if found["answers"][0]["mark"] != "failed" else None


def passed(certificate):
    if certificate["passed"]:
        return "yes"
    is_bad = any(answer["mark"] in ("wrong", "failed") for answer in certificate["answers"])
    return "no" if is_bad or not certificate["complete"] else "open"


def row(certificate):
    answers = certificate["answers"]
    first = next((a for a in answers if a["mark"] in ("wrong", "failed")), None)
    finding = f"`{first['name']}`: {first['text'].split(';')[0]}" if first else ""
    version = " ".join(dict.fromkeys(certificate["version"].removeprefix(certificate["renderer"]).split()))
    counts = [sum(answer["mark"] == mark for answer in answers) for mark in MARKS]
    seconds = sum(answer["seconds"] for answer in answers)
    complete = "" if certificate["complete"] else f" (stopped after {len(answers)} answers)"
    return (certificate["renderer"] + complete, version, passed(certificate), *counts, finding, f"{seconds:.0f}")


def kept_rows(table, names):
    """The rows, with their line ends, of programs that are none of these."""
    rows = table.splitlines(keepends=True)[2:]
    return [line for line in rows if line.split("|")[1].strip().split(" (stopped")[0] not in names]


def main():
    plumb = str(pathlib.Path(sys.argv[1]).resolve())
    folder = pathlib.Path(sys.argv[2] if len(sys.argv) > 2 else ROOT / "out/certified").resolve()
    folder.mkdir(parents=True, exist_ok=True)
    certificates = [c for c in (certify(plumb, renderer, folder) for renderer in renderers()) if c]
    rows = [HEADINGS, ("---",) * len(HEADINGS), *map(row, certificates)]
    table = "".join("| " + " | ".join(map(str, cells)) + " |\n" for cells in rows)
    before, rest = PAGE.read_text(encoding="utf-8").split(BEGIN)
    old, after = rest.split(END)
    table += "".join(kept_rows(old, {c["renderer"] for c in certificates}))
    PAGE.write_text(before + BEGIN + table + END + after, encoding="utf-8")


if __name__ == "__main__":
    main()
