# SPDX-License-Identifier: Apache-2.0

"""LuxCore: pictures are one row lower than the camera says.

A square lamp on black in front of a camera that looks at its middle. It covers the four middle rows and the
four middle columns of a picture of 16 x 16 pixels exactly.

    python3 luxcore_row.py        (with the module pyluxcore)

Expected: a square in the middle of the picture, in rows and columns 6 to 9, counted from 0.

Measured with 2.11.2, with the engines PATHCPU and BIDIRCPU, without a filter:

    rows 7 to 10 from the top, columns 6 to 9

The cause seems to be in perspective.cpp: InitRay() takes filmHeight - filmY - 1 for the height of a sample,
where filmY is a number between 0 and filmHeight, not the index of a pixel.
"""
import array
import time

import pyluxcore

SIDE = 16


def properties(values):
    result = pyluxcore.Properties()
    for key, value in values.items():
        result.Set(pyluxcore.Property(key, value))
    return result


def lamp():
    scene = pyluxcore.Scene()
    half = 0.25  # at distance 1, where the picture reaches from -1 to 1
    corners = [(-half, -half, 1.0), (-half, half, 1.0), (half, half, 1.0), (half, -half, 1.0)]
    scene.DefineMesh("lamp", corners, [(0, 1, 2), (0, 2, 3)], None, None, None, None)
    scene.Parse(properties({
        "scene.camera.lookat.orig": [0.0, 0.0, 0.0], "scene.camera.lookat.target": [0.0, 0.0, 1.0],
        "scene.camera.up": [0.0, 1.0, 0.0], "scene.camera.fieldofview": 90.0,
        "scene.materials.lamp.type": "matte", "scene.materials.lamp.kd": [0.0] * 3,
        "scene.materials.lamp.emission": [1.0] * 3,
        "scene.objects.lamp.shape": "lamp", "scene.objects.lamp.material": "lamp"}))
    return scene


def render(scene, engine):
    session = pyluxcore.RenderSession(pyluxcore.RenderConfig(properties({
        "renderengine.type": engine, "sampler.type": "RANDOM", "film.width": SIDE, "film.height": SIDE,
        "film.filter.type": "NONE", "batch.haltspp": 64}), scene))
    session.Start()
    while not session.HasDone():
        time.sleep(0.01)
        session.UpdateStats()
    session.Stop()
    values = array.array("f", bytes(12 * SIDE * SIDE))
    session.GetFilm().GetOutputFloat(pyluxcore.FilmOutputType.RGB, values)
    return [[values[3 * (y * SIDE + x)] for x in range(SIDE)] for y in reversed(range(SIDE))]  # from the top


pyluxcore.Init()
scene = lamp()
for engine in ("PATHCPU", "BIDIRCPU"):
    picture = render(scene, engine)
    rows = [y for y, row in enumerate(picture) if any(row)]
    columns = [x for x, column in enumerate(zip(*picture)) if any(column)]
    print(f"{engine}: rows {rows}, columns {columns}", flush=True)
