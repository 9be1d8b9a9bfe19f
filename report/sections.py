# SPDX-License-Identifier: Apache-2.0

"""What the report's page says of each scene, as HTML that needs no script."""

import base64
import html
import re
import struct
import urllib.parse
import zlib

VERDICTS = ("same", "different", "inconclusive")
NUMBER = re.compile(r"^[^a-z]*\d[^a-z]*(e[-−+]?\d+)?( ?%| s)?$", re.IGNORECASE)


def thumbnail(planes, width):
    """Of R, G and B, at half the size, as the address of a PNG."""
    height = len(planes[0]) // width
    rows = bytearray()
    for y in range(0, height - 1, 2):
        rows.append(0)  # no filter
        for i in range(y * width, (y + 1) * width - 1, 2):
            rows += bytes(_srgb((p[i] + p[i + 1] + p[i + width] + p[i + width + 1]) / 4) for p in planes)

    def chunk(kind, content):
        return struct.pack(">I", len(content)) + kind + content + struct.pack(">I", zlib.crc32(kind + content))
    png = (b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", struct.pack(">IIBBBBB", width // 2, height // 2, 8, 2, 0, 0, 0)) +
           chunk(b"IDAT", zlib.compress(bytes(rows), 9)) + chunk(b"IEND", b""))
    return "data:image/png;base64," + base64.b64encode(png).decode("ascii")


def _srgb(radiance):
    light = min(max(radiance, 0.0), 1.0)
    return round(255 * (12.92 * light if light <= 0.0031308 else 1.055 * light ** (1 / 2.4) - 0.055))


def number(value, digits=4):
    return "" if value is None else f"{value:.{digits}g}".replace("-", "−")


def percent(bias, confidence):
    if bias is None:
        return ""
    spread = "" if confidence is None else f" ± {100 * confidence:.3f}"
    return f"{100 * bias:+.3f}{spread} %".replace("-", "−")


def element(tag, content, **attributes):
    """`content` is HTML; attributes are text."""
    given = "".join(f' {name.rstrip("_")}="{html.escape(str(value))}"' for name, value in attributes.items() if value)
    return f"<{tag}{given}>{content}</{tag}>"


def text(tag, content, **attributes):
    return element(tag, html.escape(str(content)), **attributes)


def image(source, alt, **attributes):
    # What a caption describes has an empty alt, which element() would leave out.
    return f'<img src="{source}" alt="{html.escape(alt)}"' + element("img", "", **attributes)[4:-6]


def command(line):
    return text("pre", line, class_="command") if line else ""


def folded(title, content, **attributes):
    return element("details", text("summary", title) + content, **attributes)


def table(head, rows):
    """Cells that are numbers are set flush right."""
    def kind(cell):
        return "number" if NUMBER.match(str(cell)) else cell if cell in VERDICTS else ""
    first = rows[0] if rows else head
    heads = "".join(text("th", title, class_="number" if NUMBER.match(str(cell)) else "")
                    for title, cell in zip(head, first))
    body = "".join(element("tr", "".join(text("td", "" if cell is None else cell, class_=kind(cell)) for cell in row))
                   for row in rows)
    return element("div", element("table", element("thead", element("tr", heads)) + element("tbody", body)),
                   class_="wide")


def card(value):
    """Any JSON as names and values; lists and objects inside are folded away."""
    parts = []
    is_list = isinstance(value, list)
    for name, entry in ((str(i + 1), one) for i, one in enumerate(value)) if is_list else value.items():
        is_simple = isinstance(entry, list) and not any(isinstance(one, (dict, list)) for one in entry)
        if isinstance(entry, (dict, list)) and not is_simple:
            title = f"{name} ({len(entry)})" if isinstance(entry, list) else name
            fold = folded(title, card(entry), class_="list" if isinstance(entry, list) else "")
            parts.append(element("div", fold, class_="nested"))
        else:
            shown = ", ".join(map(str, entry)) if is_simple else entry
            parts.append(text("dt", name) + text("dd", shown))
    return element("dl", "".join(parts), class_="card")


def verdict_rows(verdict):
    whole = next((row for row in verdict["rows"] if row["where"] == "image" and row["channel"] == "all"), None)
    cells = (text("td", verdict["test"]) + text("td", verdict["reference"]) +
             text("td", verdict["verdict"], class_=verdict["verdict"]) +
             text("td", percent(whole["bias"], whole["confidence"]) if whole else "", class_="number") + "<td></td>")
    rows = [[row["where"], row["channel"], number(row["test"]), number(row["reference"]),
             percent(row["bias"], row["confidence"]), row["verdict"]] for row in verdict["rows"]]
    more = (text("p", verdict["explanation"], class_="explanation") +
            folded("Regions and channels",
                   table(["where", "channel", "test", "reference", "bias", "verdict"], rows)) +
            command(verdict["command"]))
    return element("tbody", element("tr", cells) + element("tr", element("td", more, colspan=5)), class_="verdict")


def verdicts(scene):
    if not scene["verdicts"]:
        return ""
    heads = "".join(text("th", title) for title in ("Test", "Reference", "Verdict", "Bias of the whole", ""))
    rows = "".join(map(verdict_rows, scene["verdicts"]))
    return "<h3>Verdicts</h3>" + element(
        "div", element("table", element("thead", element("tr", heads)) + rows, class_="verdicts"), class_="wide")


def drawn(title, result):
    # As an image of its own, because plots inlined side by side would share their ids; a script gives them others.
    return image("data:image/svg+xml;charset=utf-8," + urllib.parse.quote(result["svg"]),
                 f"{title}: {' '.join(result['sentences'])}", class_="plot")


def plot(title, result):
    if not result:
        return ""
    return (text("h3", title) + drawn(title, result) +
            "".join(text("p", sentence) for sentence in result["sentences"]) +
            (folded("Table", table(result["table"]["head"], result["table"]["rows"])) if result["table"]["rows"] else "") +
            command(result["command"]))


def overview(scenes, programs):
    """A row for each scene, a column for each program: every comparison that it has a part in."""
    def judged(verdict):
        whole = next(row for row in verdict["rows"] if row["where"] == "image" and row["channel"] == "all")
        return element("div", text("span", verdict["verdict"], class_=verdict["verdict"]) + " " +
                       text("span", percent(whole["bias"], whole["confidence"])),
                       title=f"{verdict['test']}, against {verdict['reference']}")

    def cell(scene, program):
        return element("td", "".join(judged(one) for one in scene["verdicts"] if one["program"] == program))
    programs = [one for one in programs if any(one == v["program"] for scene in scenes for v in scene["verdicts"])]
    if not programs:
        return ""
    head = "".join(text("th", title) for title in ("Scene", *programs))
    rows = "".join(element("tr", element("td", text("a", scene["title"], href=f"#{scene['name']}")) +
                           "".join(cell(scene, program) for program in programs)) for scene in scenes)
    table_ = element("table", element("thead", element("tr", head)) + element("tbody", rows), class_="overview")
    return "<h2>Who agrees</h2>" + text(
        "p", "Bias of the whole picture and its 95 % confidence interval. Which two pictures a line is about shows when the "
        "pointer rests on it.", class_="notes") + element("div", table_, class_="wide")


def front(scenes, programs):
    """What the page opens with: accuracy against speed in the first scene that has a chart, and all verdicts."""
    first = next((scene for scene in scenes if scene["chart"]), None)
    chart = text("h2", f"Accuracy against speed: {first['title']}") + drawn("Chart", first["chart"]) if first else ""
    return chart + overview(scenes, programs)


def name_of(picture):
    seconds = picture["seconds"]
    return picture["title"] + ("" if seconds is None else f", {number(seconds)}\u00a0s")


def figure(picture):
    return element("figure", image(picture["thumbnail"], "") + text("figcaption", name_of(picture)))


def section(scene):
    pictures = scene["pictures"]
    heading = [text("h2", scene["title"]), *(text("p", note, class_="notes") for note in scene["notes"])]
    if not pictures:
        return element("section", "".join(heading), class_="scene", id=scene["name"])
    return element("section", "".join([
        *heading,
        "<h3>Pictures</h3>", element("div", "".join(map(figure, pictures)), class_="pictures"),
        element("div", "".join([
            verdicts(scene), plot("Bias over runs", scene.get("history")), plot("Convergence", scene["convergence"]),
            plot("Speed against accuracy", scene["chart"]), "<h3>How the pictures were made</h3>",
            *(folded(name_of(picture), command(picture["command"]) + card(picture["card"] or {}))
              for picture in pictures)]), class_="results")]), class_="scene", id=scene["name"])


def tab(scene):
    return text("a", scene["title"], href=f"#{scene['name']}", id=f"tab-{scene['name']}")
