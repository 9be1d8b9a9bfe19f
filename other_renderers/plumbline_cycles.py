# SPDX-License-Identifier: Apache-2.0

"""Draws the scenes that `plumb export --to cycles` writes, in Blender 3.4 or later.

Here is what all scenes share: how Cycles expresses Plumbline's surfaces, lamps and camera, and the
settings without which its pictures are biased. The scene's own script holds its numbers.
"""

import argparse
import json
import math
import os
import sys
import time
import traceback
from typing import NamedTuple, Optional

import bpy
import bmesh  # comes with bpy, so after it
from mathutils import Matrix, Vector

MOST_BOUNCES = 1024  # Cycles counts no further
MOST_SAMPLES = 1 << 23
LARGEST_SIDE = 8192


class Camera(NamedTuple):
    """A pinhole. The vectors are orthonormal; `fov` is in degrees, along `fov_axis`."""

    origin: tuple
    forward: tuple
    right: tuple
    up: tuple
    fov: float
    fov_axis: str  # x, y, diagonal, smaller or larger
    width: int
    height: int
    gaussian_width: float = 0.0  # of Cycles' filter of that name, in pixels; 0: a box


class Mesh(NamedTuple):
    """Planar polygons, counter-clockwise seen from the front.

    A surface is diffuse, a mirror (of a metal if it has a complex index, of which `eta` are the
    real parts; rough, with that `alpha` of GGX, if it is not 0) or glass, that has the refractive index `glass` behind the surface and tints what
    it reflects by `mirror`, what goes through by `transmittance`. Its back is black unless it is
    two-sided. A lamp emits `radiance` from its front.
    """

    name: str
    polygons: list
    diffuse: tuple = (0.0, 0.0, 0.0)
    mirror: Optional[tuple] = None
    eta: Optional[tuple] = None
    k: Optional[tuple] = None
    alpha: float = 0.0
    glass: Optional[float] = None
    transmittance: Optional[tuple] = None
    two_sided: bool = False
    radiance: Optional[tuple] = None


class Sphere(NamedTuple):
    """Its front is its outside. The rest is as for Mesh."""

    name: str
    center: tuple
    radius: float
    diffuse: tuple = (0.0, 0.0, 0.0)
    mirror: Optional[tuple] = None
    eta: Optional[tuple] = None
    k: Optional[tuple] = None
    alpha: float = 0.0
    glass: Optional[float] = None
    transmittance: Optional[tuple] = None
    two_sided: bool = False
    radiance: Optional[tuple] = None


class Card:
    """Sets properties, and remembers what was set and what this version of Blender lacks."""

    def __init__(self):
        self.settings = {}
        self.missing = []

    def set(self, owner, path, *values):
        """Takes the first of `values` that this version of Blender knows."""
        label = f"{owner.bl_rna.identifier}.{path}"
        *holders, name = path.split(".")
        for holder in holders:
            owner = getattr(owner, holder)
        # Python lets attributes be set that Blender does not know.
        for value in values if name in owner.bl_rna.properties else ():
            try:
                setattr(owner, name, value)
            except TypeError:  # an enumeration without this value
                continue
            self.settings[label] = getattr(owner, name)
            return
        if label not in self.missing:
            self.missing.append(label)


class Nodes:
    """A material's nodes. What goes into one is a value or another's output."""

    def __init__(self, material):
        if material.node_tree is None:  # before 5.0
            material.use_nodes = True
        self.tree = material.node_tree
        self.tree.nodes.clear()

    def add(self, kind, *inputs):
        """Of its outputs, nearly always the first is wanted."""
        node = self.tree.nodes.new(f"ShaderNode{kind}")
        for value, socket in zip(inputs, node.inputs):
            if isinstance(value, bpy.types.NodeSocket):
                self.tree.links.new(value, socket)
            elif value is not None:
                socket.default_value = value
        return node.outputs[0] if node.outputs else None

    def lobe(self, kind, color, *more, roughness=0.0):
        is_value = not isinstance(color, bpy.types.NodeSocket)
        return self.add(f"Bsdf{kind}", (*color, 1.0) if is_value else color, roughness, *more)

    def glossy(self, color, alpha):
        """Without light that is reflected among the microfacets."""
        output = self.lobe("Glossy", color, roughness=math.sqrt(alpha))
        output.node.distribution = "GGX"
        return output

    def math(self, operation, *operands):
        output = self.add("Math", *operands)
        output.node.operation = operation
        return output

    def geometry(self, name):
        return self.add("NewGeometry").node.outputs[name]

    def metal(self, eta, k, cosine):
        """What Fresnel's equations say that the index eta + i k reflects at that cosine: with
        a + i b = sqrt((eta + i k)^2 - sin^2), of polarised light |cos - a - i b|^2 /
        |cos + a + i b|^2, and that times |a + i b - sin tan|^2 / |a + i b + sin tan|^2.
        """
        math = self.math

        def ratio(whole, part):
            return math("DIVIDE", math("SUBTRACT", whole, part), math("ADD", whole, part))

        cos2 = math("MULTIPLY", cosine, cosine)
        sin2 = math("SUBTRACT", 1.0, cos2)
        real = math("ADD", cos2, eta * eta - k * k - 1.0)
        size = math("SQRT", math("MULTIPLY_ADD", real, real, (2.0 * eta * k) ** 2))
        if k > eta:  # each where nothing cancels out
            b = math("SQRT", math("MULTIPLY", math("SUBTRACT", size, real), 0.5))
            a = math("DIVIDE", eta * k, b)
        else:
            a = math("SQRT", math("MULTIPLY", math("ADD", size, real), 0.5))
        part = math("MULTIPLY", math("MULTIPLY", a, cosine), 2.0)
        across = ratio(math("ADD", size, cos2), part)
        more = ratio(math("MULTIPLY_ADD", cos2, size, math("MULTIPLY", sin2, sin2)),
                     math("MULTIPLY", part, sin2))
        return math("MULTIPLY", across, math("MULTIPLY_ADD", more, 0.5, 0.5))


class Builder:
    """Turns shapes into Blender's objects, materials and lights."""

    def __init__(self, scene, card, camera, shapes, emission_only):
        self.scene = scene
        self.card = card
        self.eye = Vector(camera.origin)
        self.emission_only = emission_only
        points = [camera.origin]
        for shape in shapes:
            if isinstance(shape, Sphere):
                points += [[abs(x) + shape.radius for x in shape.center]]
            else:
                points += [corner for polygon in shape.polygons for corner in polygon]
        self.extent = max(abs(x) for point in points for x in point)
        # A hundred times what coordinates in float lose, and far below a pixel.
        self.gap = 1e-5 * self.extent

    def add(self, name, data):
        thing = bpy.data.objects.new(name, data)
        self.scene.collection.objects.link(thing)
        return thing

    def camera(self, camera, width, height):
        along_axis = {"x": width, "y": height, "diagonal": math.hypot(width, height),
                      "smaller": min(width, height), "larger": max(width, height)}
        tangent = math.tan(math.radians(camera.fov) / 2.0)
        half_width = tangent * width / along_axis[camera.fov_axis]
        data = bpy.data.cameras.new("camera")
        data.sensor_fit = "HORIZONTAL"
        data.lens = max(36.0, 18.0 / half_width)  # neither it nor the sensor may be below 1
        data.sensor_width = 2.0 * half_width * data.lens
        data.clip_start = 1e-6 * self.extent
        data.clip_end = 10.0 * self.extent
        self.scene.camera = self.add("camera", data)
        self.scene.camera.matrix_world = placed(
            camera.origin, Vector(camera.right), Vector(camera.up), -Vector(camera.forward))

    def shape(self, shape):
        if isinstance(shape, Sphere):
            inside = (Vector(shape.center) - self.eye).length <= shape.radius
            if inside or shape.two_sided or shape.radiance:
                self.ball(shape)
            else:
                self.point(shape)
        elif shape.radiance:
            for corners in shape.polygons:
                if is_rectangle(corners) and not shape.glass:
                    self.rectangle_lamp(shape, [Vector(corner) for corner in corners])
            others = [corners for corners in shape.polygons if shape.glass or not is_rectangle(corners)]
            if others:
                self.emission_sampling(self.mesh(shape._replace(polygons=others)), True)
        else:
            self.mesh(shape)

    def material(self, shape):
        material = bpy.data.materials.new(shape.name)
        nodes = Nodes(material)
        front = self.bsdf(nodes, shape)
        back = front if shape.two_sided else None
        if shape.radiance:
            front = nodes.add("AddShader", front, nodes.add("Emission", (*shape.radiance, 1.0)))
        # An open input is black.
        nodes.add("OutputMaterial",
                  nodes.add("MixShader", nodes.geometry("Backfacing"), front, back))
        return material

    def bsdf(self, nodes, shape):
        if self.emission_only:
            return nodes.lobe("Diffuse", (0.0, 0.0, 0.0))
        if shape.glass:
            # On the back these nodes take the index's reciprocal.
            return nodes.add("MixShader", nodes.add("Fresnel", shape.glass),
                             nodes.lobe("Refraction", shape.transmittance, shape.glass),
                             nodes.lobe("Glossy", shape.mirror))
        if shape.eta:
            dot = nodes.add("VectorMath", nodes.geometry("Incoming"), nodes.geometry("Normal")).node
            dot.operation = "DOT_PRODUCT"
            cosine = nodes.math("ABSOLUTE", dot.outputs["Value"])
            return nodes.glossy(nodes.add("CombineXYZ", *(
                nodes.math("MULTIPLY", nodes.metal(*index, cosine), reflectance)
                for *index, reflectance in zip(shape.eta, shape.k, shape.mirror))), shape.alpha)
        if shape.mirror:
            return nodes.glossy(shape.mirror, shape.alpha)
        return nodes.lobe("Diffuse", shape.diffuse)

    def sky(self, radiance):
        world = bpy.data.worlds.new("sky")
        self.scene.world = world
        nodes = Nodes(world)
        nodes.add("OutputWorld", nodes.add("Background", (*radiance, 1.0), 1.0))

    def point_lamp(self, position, intensity):
        """Of watts P, the radiant intensity is P / (4 pi)."""
        light = bpy.data.lights.new("point", "POINT")
        light.shadow_soft_size = 0.0
        brightest = max(intensity)
        light.color = [channel / brightest for channel in intensity]
        light.energy = 4.0 * math.pi * brightest
        self.add("point", light).location = position

    def emission_sampling(self, thing, front):
        material = thing.data.materials[0]
        self.card.set(material, "cycles.emission_sampling", "FRONT" if front else "NONE")
        self.card.set(material, "cycles.sample_as_light", front)  # before 3.5

    def mesh(self, shape):
        data = bpy.data.meshes.new(shape.name)
        corners, faces = [], []
        for polygon in shape.polygons:
            faces.append(range(len(corners), len(corners) + len(polygon)))
            corners += polygon
        data.from_pydata(corners, [], faces)
        data.materials.append(self.material(shape))
        return self.add(shape.name, data)

    def rectangle_lamp(self, shape, corners):
        """An area light, because meshes that emit are up to a percent too dark at grazing angles.

        The camera does not see area lights, and light passes through them. So a copy for the
        camera alone is in the same place, and what stops light a little behind. The copy of a lamp
        that reflects is a little before it, where it is not lit by its own light.
        """
        x, y = corners[1] - corners[0], corners[3] - corners[0]
        normal = x.cross(y).normalized()
        light = bpy.data.lights.new(shape.name, "AREA")
        light.shape = "RECTANGLE"
        light.size, light.size_y = x.length, y.length
        brightest = max(shape.radiance)
        light.color = [channel / brightest for channel in shape.radiance]
        # Of watts P and area A, the radiance is P / (pi A); before 4.0 it was P / (4 A).
        watts = math.pi if bpy.app.version >= (4, 0, 0) else 4.0
        light.energy = watts * x.length * y.length * brightest
        self.card.set(light, "spread", math.pi)
        self.add(shape.name, light).matrix_world = placed(
            (corners[0] + corners[2]) / 2.0, x.normalized(), -y.normalized(), -normal)

        gap = self.gap if shape.mirror or any(shape.diffuse) else 0.0
        front = self.mesh(shape._replace(
            polygons=[[corner + gap * normal for corner in corners]]))
        for ray in ("diffuse", "glossy", "transmission", "volume_scatter", "shadow"):
            setattr(front, f"visible_{ray}", False)
        self.emission_sampling(front, False)
        behind = [corner - self.gap * normal for corner in corners]
        self.mesh(shape._replace(polygons=[behind], radiance=None))

    def ball(self, shape):
        """A sphere of triangles, scaled to a sphere's area and with that to its mean outline.

        Blender 3.4 makes lamps of finer triangles too dark: by 0.1 % with 7 subdivisions.
        """
        data = bpy.data.meshes.new(shape.name)
        mesh = bmesh.new()
        subdivisions = 6 if shape.radiance else 7
        bmesh.ops.create_icosphere(mesh, subdivisions=subdivisions, radius=1.0)
        area = sum(face.calc_area() for face in mesh.faces)
        scale = shape.radius * math.sqrt(4.0 * math.pi / area)
        bmesh.ops.scale(mesh, vec=(scale, scale, scale), verts=mesh.verts)
        mesh.to_mesh(data)
        mesh.free()
        data.polygons.foreach_set("use_smooth", [True] * len(data.polygons))
        data.materials.append(self.material(shape))
        thing = self.add(shape.name, data)
        thing.location = shape.center
        if shape.radiance:
            self.emission_sampling(thing, True)

    def point(self, shape):
        """A point of a point cloud, which Cycles draws as a true sphere without an inside."""
        group = bpy.data.node_groups.new(shape.name, "GeometryNodeTree")
        if hasattr(group, "interface"):  # from 4.0
            group.interface.new_socket("Geometry", in_out="OUTPUT",
                                       socket_type="NodeSocketGeometry")
        else:
            group.outputs.new("NodeSocketGeometry", "Geometry")
        points = group.nodes.new("GeometryNodePoints")
        points.inputs["Position"].default_value = shape.center
        points.inputs["Radius"].default_value = shape.radius
        material = group.nodes.new("GeometryNodeSetMaterial")
        material.inputs["Material"].default_value = self.material(shape)
        group.links.new(points.outputs[0], material.inputs["Geometry"])
        group.links.new(material.outputs[0], group.nodes.new("NodeGroupOutput").inputs[0])
        thing = self.add(shape.name, bpy.data.meshes.new(shape.name))
        thing.modifiers.new(shape.name, "NODES").node_group = group


def is_rectangle(corners):
    """Up to what is lost in float, which area lights are placed in."""
    if len(corners) != 4:
        return False
    a, b, c, d = (Vector(corner) for corner in corners)
    size = (c - a).length
    return (a - b + c - d).length <= 1e-5 * size and abs((b - a).dot(d - a)) <= 1e-5 * size * size


def placed(origin, x, y, z):
    matrix = Matrix((x, y, z)).transposed().to_4x4()
    matrix.translation = origin
    return matrix


def apply_settings(scene, card, options, gaussian_width):
    """Sets what would make Cycles biased, correlated between pixels or another on each machine."""
    # Cycles counts reflections, and light arrives after the last.
    reflections = min(max(options.bounces - 1, 0), MOST_BOUNCES)
    # Sample 0 goes through the middle of every pixel, which is a bias of 1 / spp at edges: begin
    # later, at a power of two, where the samples of a Sobol sequence are as evenly spread.
    first = 1 << (options.spp - 1).bit_length()
    has_subset = "use_sample_subset" in scene.cycles.bl_rna.properties  # from 4.4
    for path, *values in (
            ("render.engine", "CYCLES"),
            ("cycles.device", "CPU"),
            ("cycles.samples", first + options.spp if has_subset else options.spp),
            ("cycles.sample_offset", first),
            ("cycles.use_sample_subset", True),
            ("cycles.sample_subset_length", options.spp),
            ("cycles.seed", options.seed),
            ("cycles.sampling_pattern", "TABULATED_SOBOL", "SOBOL"),  # never blue noise
            ("cycles.time_limit", 0.0),
            ("cycles.use_adaptive_sampling", False),
            ("cycles.use_denoising", False),
            ("cycles.use_guiding", False),
            ("cycles.use_light_tree", False),
            ("cycles.light_sampling_threshold", 0.0),
            ("cycles.sample_clamp_direct", 0.0),
            ("cycles.sample_clamp_indirect", 0.0),
            ("cycles.blur_glossy", 0.0),
            ("cycles.caustics_reflective", True),
            ("cycles.caustics_refractive", True),
            ("cycles.use_fast_gi", False),
            ("cycles.max_bounces", reflections),
            ("cycles.diffuse_bounces", reflections),
            ("cycles.glossy_bounces", reflections),
            ("cycles.transmission_bounces", reflections),
            ("cycles.transparent_max_bounces", MOST_BOUNCES),  # passing an area light is one
            ("cycles.min_light_bounces", 0),
            ("cycles.pixel_filter_type", "GAUSSIAN" if gaussian_width else "BOX"),
            ("cycles.filter_width", gaussian_width or 1.0),
            ("cycles.film_exposure", 1.0),
            ("cycles.use_auto_tile", False),
            ("render.resolution_x", options.size[0]),
            ("render.resolution_y", options.size[1]),
            ("render.resolution_percentage", 100),
            ("render.threads_mode", "FIXED" if options.threads else "AUTO"),
            ("render.threads", options.threads or scene.render.threads),
            ("render.dither_intensity", 0.0),
            ("render.use_compositing", False),
            ("render.use_sequencer", False),
            ("render.image_settings.media_type", "IMAGE"),
            ("render.image_settings.file_format", "OPEN_EXR"),
            ("render.image_settings.color_mode", "RGB"),
            ("render.image_settings.color_depth", "32"),
            ("render.image_settings.exr_codec", "ZIP")):
        card.set(scene, path, *values)
    for name, value in options.set:
        card.set(scene, f"cycles.{name}", value)
        if getattr(scene.cycles, name, None) != value:
            sys.exit(f"--set: Cycles has no {name} that could be {value}")


def whole_number(least, most):
    def parse(text):
        if not text.isdecimal() or not least <= int(text) <= most:
            raise argparse.ArgumentTypeError(f"{text}: not a whole number from {least} to {most}")
        return int(text)
    return parse


def image_size(text):
    side = whole_number(1, LARGEST_SIDE)
    width, _, height = text.partition("x")
    return side(width), side(height)


def exr_file(text):
    if not text.lower().endswith(".exr"):
        raise argparse.ArgumentTypeError(f"{text} does not end with .exr")
    file = os.path.abspath(text)
    if not os.path.isdir(os.path.dirname(file)):  # Blender would make it
        raise argparse.ArgumentTypeError(f"the folder of {text} does not exist")
    return file


def setting(text):
    name, _, value = text.partition("=")
    try:
        return name, json.loads(value)
    except ValueError as error:
        raise argparse.ArgumentTypeError(f"{text} is not NAME=NUMBER") from error


def read_options(name, camera):
    is_module = getattr(bpy.app, "module", False)
    arguments = sys.argv[1:] if is_module else []
    if "--" in sys.argv:
        arguments = sys.argv[sys.argv.index("--") + 1:]
    command = f"python {name}.py" if is_module else f"blender -b --python {name}.py --"
    parser = argparse.ArgumentParser(
        prog=command, description=f"Draw the scene {name} with Cycles.",
        epilog=f"Example: {command} -o {name}.exr --spp 256 --seed 1")
    add = parser.add_argument
    add("-o", "--output", metavar="FILE", type=exr_file, required=True, help="linear .exr")
    add("--spp", metavar="N", type=whole_number(1, MOST_SAMPLES), default=64,
        help="samples per pixel (default: 64)")
    add("--seed", metavar="N", type=whole_number(0, 2**31 - 1), default=0,
        help="another seed gives other noise (default: 0)")
    add("--bounces", metavar="N", type=whole_number(0, MOST_BOUNCES), default=MOST_BOUNCES,
        help="only light of at most N bounces: 0 is emission seen directly, 1 direct light "
        f"(default: {MOST_BOUNCES})")
    add("--size", metavar="WxH", type=image_size, default=(camera.width, camera.height),
        help="size (default: the scene's)")
    add("--threads", metavar="N", type=whole_number(1, 1024),
        help="threads at most (default: one per processor)")
    add("--set", metavar="NAME=NUMBER", type=setting, action="append", default=[],
        help="a setting of Cycles' own that differs, such as sample_clamp_indirect=10")
    return parser.parse_args(arguments)


def render(scene, file):
    """Returns the seconds that rendering took, without Blender's start and the file."""
    start = time.perf_counter()
    if "FINISHED" not in bpy.ops.render.render():
        raise RuntimeError("the rendering was interrupted")
    seconds = time.perf_counter() - start
    # Under another name first: a killed run leaves the old file or the new one.
    part = os.path.join(os.path.dirname(file), f".{os.getpid()}.part.exr")
    bpy.data.images["Render Result"].save_render(part, scene=scene)
    os.replace(part, file)
    return seconds


def draw(name, camera, shapes, sky, points):
    options = read_options(name, camera)
    bpy.ops.wm.read_factory_settings(use_empty=True)
    scene, card = bpy.context.scene, Card()
    apply_settings(scene, card, options, camera.gaussian_width)
    builder = Builder(scene, card, camera, shapes, emission_only=options.bounces == 0)
    builder.camera(camera, *options.size)
    for shape in shapes:
        builder.shape(shape)
    if sky:
        builder.sky(sky)
    for point in points if options.bounces else ():
        builder.point_lamp(*point)
    seconds = render(scene, options.output)
    version = bpy.app.version_string
    facts = {"program": f"Blender {version} Cycles", "version": version, "seconds": seconds,
             "settings": card.settings, "missing": card.missing}
    print(f"plumbline: {json.dumps(facts)}", flush=True)


def main(name, camera, shapes, sky=None, points=()):
    try:
        draw(name, camera, shapes, sky, points)
    except Exception:  # Blender would show it and end well
        traceback.print_exc()
        sys.stdout.flush()
        sys.stderr.flush()
        os._exit(2)
