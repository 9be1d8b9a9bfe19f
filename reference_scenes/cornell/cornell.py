# The scene cornell, from the scene file with SHA-1 626906eacbb4b174b3a608cec41737a0a87d592b. To draw it:
#   blender -b --python cornell.py -- -o cornell.exr --spp 256
# Coordinates are the scene file's, colours are linear RGB.
import os
import sys

sys.dont_write_bytecode = True
sys.path.insert(0, os.path.dirname(os.path.abspath(__file__)))
try:
    from plumbline_cycles import Camera, Mesh, Sphere, main
except ImportError as error:
    sys.exit(f"{error}: plumbline_cycles.py belongs beside this file")

main(
    "cornell",
    camera=Camera(
        origin=(278, 273, -800), forward=(0, 0, 1), right=(-1, -0, -0), up=(0, 1, 0),
        fov=39.3077, fov_axis="x", width=256, height=256),
    shapes=[
        Mesh("floor", diffuse=(0.73, 0.73, 0.73), polygons=[
            [(552.8, 0, 0), (0, 0, 0), (0, 0, 559.2), (549.6, 0, 559.2)],
        ]),
        Mesh("ceiling", diffuse=(0.73, 0.73, 0.73), polygons=[
            [(0, 548.8, 0), (556, 548.8, 0), (556, 548.8, 559.2), (0, 548.8, 559.2)],
        ]),
        Mesh("back_wall", diffuse=(0.73, 0.73, 0.73), polygons=[
            [(549.6, 0, 559.2), (0, 0, 559.2), (0, 548.8, 559.2), (556, 548.8, 559.2)],
        ]),
        Mesh("right_wall", diffuse=(0.14, 0.45, 0.091), polygons=[
            [(0, 0, 559.2), (0, 0, 0), (0, 548.8, 0), (0, 548.8, 559.2)],
        ]),
        Mesh("left_wall", diffuse=(0.63, 0.065, 0.05), polygons=[
            [(552.8, 0, 0), (549.6, 0, 559.2), (556, 548.8, 559.2)],
            [(552.8, 0, 0), (556, 548.8, 559.2), (556, 548.8, 0)],
        ]),
        Mesh("short_block", diffuse=(0.73, 0.73, 0.73), polygons=[
            [(130, 165, 65), (82, 165, 225), (240, 165, 272), (290, 165, 114)],
            [(290, 0, 114), (240, 0, 272), (82, 0, 225), (130, 0, 65)],
            [(82, 165, 225), (130, 165, 65), (130, 0, 65), (82, 0, 225)],
            [(240, 165, 272), (82, 165, 225), (82, 0, 225), (240, 0, 272)],
            [(290, 165, 114), (240, 165, 272), (240, 0, 272), (290, 0, 114)],
            [(130, 165, 65), (290, 165, 114), (290, 0, 114), (130, 0, 65)],
        ]),
        Mesh("tall_block", diffuse=(0.73, 0.73, 0.73), polygons=[
            [(423, 330, 247), (265, 330, 296), (314, 330, 456), (472, 330, 406)],
            [(472, 0, 406), (314, 0, 456), (265, 0, 296), (423, 0, 247)],
            [(265, 330, 296), (423, 330, 247), (423, 0, 247), (265, 0, 296)],
            [(314, 330, 456), (265, 330, 296), (265, 0, 296), (314, 0, 456)],
            [(472, 330, 406), (314, 330, 456), (314, 0, 456), (472, 0, 406)],
            [(423, 330, 247), (472, 330, 406), (472, 0, 406), (423, 0, 247)],
        ]),
        Mesh("lamp", diffuse=(0, 0, 0), radiance=(17, 12, 4), polygons=[
            [(213, 548.3, 227), (343, 548.3, 227), (343, 548.3, 332), (213, 548.3, 332)],
        ]),
    ])
