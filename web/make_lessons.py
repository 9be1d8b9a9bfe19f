# SPDX-License-Identifier: Apache-2.0

"""Makes pages of docs/lessons/*.md: python3 web/make_lessons.py build-web/plumbline.wasm out/lessons

The folder holds all that the pages need, and they open from a disk. docs/lessons/README.md becomes
its index.

A comment, <!-- live: {...} -->, after a picture and the paragraph that describes it, if there is one,
makes a live figure that takes their place. JSON:
  scene     a stored scene's folder, or a file in docs/lessons/
  pictures  by name, the settings of each: method, sampler, first and last (bounces; null: any), fault,
            light ({way: "by" or "from", ids}; null: all), and parameters (values of the scene's <default>s, the same for all pictures)
  settings  those of all pictures
  controls  a list of {title, values, start, isSlider}; values are settings by name, and count most
  size      the longer side in pixels: that of the scene, a half or a quarter of it
  exposure  in stops
  curve     "error" against the stored picture, or "noise"; noise is told in parts of the picture that
            `against` names
  share     true: tells what part of the stored picture's light is there
  caption
"""

import html
import json
import pathlib
import re
import shutil
import sys

import make_page

ROOT = make_page.ROOT
LESSONS = ROOT / "docs" / "lessons"
STORED = ROOT / "reference_scenes"
HEAD = """<!doctype html>
<html lang="en">
<head>
<meta charset="utf-8">
<meta name="viewport" content="width=device-width, initial-scale=1">
<link rel="icon" href="data:,">
<title>{title} · Plumbline</title>
<link rel="stylesheet" href="style.css">
<script src="live.js" defer></script>
</head>
<body>
<nav>{links}</nav>
<main>
{text}
</main>
<nav>{links}</nav>
</body>
</html>
"""


def order():
    """The lessons, in the index's order."""
    index = (LESSONS / "README.md").read_text("utf-8")
    return [LESSONS / name for name in re.findall(r"^\d+\. \[.*?\]\((\w+\.md)\)", index, re.MULTILINE)]


def title_of(file):
    return file.read_text("utf-8").split("\n", 1)[0].removeprefix("# ")


# A picture, perhaps a paragraph that describes it, and the comment.
LIVE = re.compile(r"!\[([^\]]*)\]\(([^)]+)\)\n(?:\n([^\n<]+(?:\n[^\n<]+)*)\n)?<!-- live:(.*?)-->", re.DOTALL)


def live_figures(text):
    """The settings of each."""
    return [json.loads(settings) for *_, settings in LIVE.findall(text)]


def figure(match):
    alt, picture, caption, settings = match.groups()
    data = html.escape(json.dumps(json.loads(settings)))
    return (f'<figure class="live" data-live="{data}"><img src="{picture}" alt="{html.escape(alt)}">'
            f"<figcaption>{html.escape(caption or '')}</figcaption></figure>\n")


def scene_file(name):
    """A stored scene, or one of the lessons' own."""
    return LESSONS / name if name.endswith(".xml") else STORED / name / "scene.xml"


def scene(name):
    file = scene_file(name)
    is_stored = file.parent != LESSONS
    files = {file.name: file.read_text("utf-8")}
    if is_stored:
        files |= {other.name: other.read_text("utf-8") for other in sorted(file.parent.glob("*.obj"))}
    stored = file.parent / "plumbline.exr" if is_stored else file.with_suffix(".exr")
    return {"name": file.name, "files": files,
            "picture": make_page.picture(stored, name, False) if stored.exists() else None}


def to_html(text):
    """Of a lesson in Markdown: live figures, answers that unfold, links that lead within the folder."""
    import markdown  # Debian's python3-markdown; live_figures() does without

    text = re.sub("<!--.*?-->", "", LIVE.sub(figure, text), flags=re.DOTALL)
    text = text.replace("<details>", '<details markdown="1">')
    page = markdown.markdown(text, extensions=["tables", "md_in_html"])
    page = page.replace("<table>", '<div class="wide"><table>').replace("</table>", "</table></div>")
    page = re.sub(r'<img ([^>]*?)src="\.\./pictures/', r'<img \1src="pictures/', page)
    page = re.sub(r'href="README\.md"', 'href="index.html"', page)
    page = re.sub(r'href="(\w+)\.md"', r'href="\1.html"', page)
    # What is elsewhere in the project is named: these pages may have been taken along without it.
    page = re.sub(r'<a href="\.\./([^"]*)">[^<]*\.md</a>', r"<code>docs/\1</code>", page)
    return re.sub(r'<a href="\.\./([^"]*)">(.*?)</a>', r"\2 (<code>docs/\1</code>)", page, flags=re.DOTALL)


def links(file, files):
    if file.name == "README.md":
        return ""
    at = files.index(file)
    around = [(files[i], word) for i, word in ((at - 1, "← "), (at + 1, "→ ")) if 0 <= i < len(files)]
    return ('<a href="index.html">Lessons</a>' +
            "".join(f' <a href="{other.stem}.html">{word}{html.escape(title_of(other))}</a>'
                    for other, word in around))


def main():
    core, out = map(pathlib.Path, sys.argv[1:])
    (out / "pictures").mkdir(parents=True, exist_ok=True)
    files, scenes = order(), {}
    for file in [LESSONS / "README.md", *files]:
        text = file.read_text("utf-8")
        for settings in live_figures(text):
            scenes.setdefault(settings["scene"], scene(settings["scene"]))
        page = to_html(text)
        for name in re.findall(r'src="pictures/([^"]+)"', page):
            shutil.copy(ROOT / "docs" / "pictures" / name, out / "pictures")
        target = "index" if file.name == "README.md" else file.stem
        (out / f"{target}.html").write_text(
            HEAD.format(title=html.escape(title_of(file)), links=links(file, files), text=page), "utf-8")
    data = {"core": make_page.packed(core), "worker": make_page.bundle("worker.js"), "scenes": scenes}
    (out / "live.js").write_text(
        f"globalThis.plumblineLessons={json.dumps(data, separators=(',', ':'))};\n{make_page.bundle('lesson.js')}",
        "utf-8")
    (out / "style.css").write_text("".join((make_page.HERE / name).read_text("utf-8")
                                           for name in ("page.css", "lesson.css")), "utf-8")
    size = sum(file.stat().st_size for file in out.rglob("*") if file.is_file())
    print(f"{out}/index.html: {len(files)} lessons, {size / 1e6:.2f} MB")


if __name__ == "__main__":
    main()
