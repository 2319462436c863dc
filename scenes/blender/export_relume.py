"""Exports a Blender scene to Relume: a scene file with camera and lights, a GLB of the meshes and a
.hair file of each set of strands.

    blender -b shot.blend --python export_relume.py -- shot.json
    relume view shot.json

Tried with Blender 3.4. Exported are the active scene's camera, the lights, every mesh that renders
(through Blender's glTF exporter: Principled materials, textures, instances) and hair: particle
systems with their children, and objects of the new Curves type. Axes become y-up, lengths stay.
What is approximated or left out is printed, a line each.
"""

import json
import math
import os
import struct
import sys
from array import array

import bpy
from mathutils import Vector

SEGMENTS, POINTS, THICKNESS, COLORS = 1, 2, 4, 16  # bits of a .hair header


def note(text):
    print("export_relume: " + text, file=sys.stderr)


def y_up(v):
    """Blender's z-up coordinates as the scene file's, y-up."""
    return [v[0], v[2], -v[1]]


class Strands:
    """Strands of one material, in world space, as a .hair file has them."""

    def __init__(self):
        self.segments = array("H")
        self.points = array("f")
        self.thickness = array("f")  # diameter
        self.colors = array("f")  # a point, or empty

    def add(self, points, diameters, colors=None):
        """Adds one strand of 2 to 65536 points (vectors), with their diameters."""
        if len(points) < 2 or len(points) > 65536:
            return
        self.segments.append(len(points) - 1)
        for point in points:
            self.points.extend(y_up(point))
        self.thickness.extend(diameters)
        for color in colors or ():
            self.colors.extend(color[:3])

    def write(self, path):
        arrays = SEGMENTS | POINTS | THICKNESS | (COLORS if self.colors else 0)
        header = struct.pack("<4sIIIIfffff88s", b"HAIR", len(self.segments), len(self.thickness),
                             arrays, 0, 0, 0, 1, 1, 1, b"Blender, by export_relume.py")
        with open(path, "wb") as file:
            file.write(header)
            for values in (self.segments, self.points, self.thickness, self.colors):
                if sys.byteorder == "big":
                    values.byteswap()
                values.tofile(file)


def diameter_along(settings, t):
    """Diameter of particle hair at t in [0, 1] from root to tip, as Cycles has it."""
    if settings.use_close_tip and t >= 1:
        return 0.0
    shape = settings.shape
    width = (1 - t) ** (1 + shape if shape < 0 else 1 / max(1 - shape, 1e-3))
    root, tip = settings.root_radius, settings.tip_radius
    return settings.radius_scale * (width * (root - tip) + tip)


def particle_strands(obj, system):
    """Parents (unless only children are rendered) and children of an evaluated particle system."""
    settings = system.settings
    strands = Strands()
    parents = len(system.particles)
    children = len(system.child_particles)
    first = parents if children and not settings.use_parent_particles else 0
    steps = 2 ** settings.display_step
    diameters = [diameter_along(settings, i / steps) for i in range(steps + 1)]
    for number in range(first, parents + children):
        points = [system.co_hair(obj, particle_no=number, step=i) for i in range(steps + 1)]
        strands.add(points, diameters)
    return strands


def curves_strands(obj):
    """An object of type CURVES, with its radius and color attributes where it has them."""
    strands = Strands()
    data = obj.data
    radius = data.attributes.get("radius")
    color = data.attributes.get("color")
    if color is not None and color.data_type not in {"FLOAT_COLOR", "BYTE_COLOR"}:
        color = None
    scale = sum(abs(s) for s in obj.matrix_world.to_scale()) / 3
    if radius is None:
        note(f"{obj.name}: has no radius; 0.005 is used")
    for number, curve in enumerate(data.curves):
        first, count = curve.first_point_index, curve.points_length
        indices = range(first, first + count)
        points = [obj.matrix_world @ Vector(data.points[i].position) for i in indices]
        widths = [2 * scale * (radius.data[i].value if radius else 0.005) for i in indices]
        colors = None
        if color is not None:
            on_points = color.domain == "POINT"
            colors = [color.data[i if on_points else number].color for i in indices]
        strands.add(points, widths, colors)
    return strands


def input_of(node, names):
    """The first of these inputs that the node has."""
    return next((node.inputs[name] for name in names if name in node.inputs), None)


def strand_material(name, material, has_colors):
    """Kajiya-Kay with the colour of the material's first shader."""
    color, roughness = (0.5, 0.5, 0.5), 0.3
    if material is not None:
        color = tuple(material.diffuse_color[:3])
        nodes = material.node_tree.nodes if material.use_nodes and material.node_tree else ()
        shader = next((n for n in nodes if n.type.startswith("BSDF")), None)
        if shader is not None:
            base = input_of(shader, ("Base Color", "Color"))
            if base is not None and not base.is_linked:
                color = tuple(base.default_value[:3])
            rough = input_of(shader, ("Roughness", "RoughnessU"))
            if rough is not None and not rough.is_linked:
                roughness = rough.default_value
            if shader.type == "BSDF_HAIR_PRINCIPLED" and shader.parametrization != "COLOR":
                note(f"{name}: only the colour of Principled Hair is read")
    exponent = min(max(1 / max(roughness, 0.05) ** 2, 1), 1000)
    diffuse = [1, 1, 1] if has_colors else [min(max(c, 0), 1) for c in color]
    return {"name": name, "shader": "kajiya-kay", "diffuse": diffuse, "exponent": exponent}


def export_camera(scene):
    """The scene's camera and picture size."""
    render = scene.render
    part = render.resolution_percentage / 100
    image = {"width": max(1, round(render.resolution_x * part)),
             "height": max(1, round(render.resolution_y * part))}
    camera = scene.camera
    if camera is None:
        note("the scene has no camera: one that sees it all is used")
        return image, {"fit": True, "direction": [-0.5, -0.35, -0.8]}
    if camera.data.type != "PERSP":
        note("the camera is read as a perspective one")
    if camera.data.shift_x or camera.data.shift_y:
        note("the camera's shift is left out")
    matrix = camera.matrix_world
    eye = matrix.translation
    frame = camera.data.view_frame(scene=scene)
    height = max(v.y for v in frame) - min(v.y for v in frame)
    fov = 2 * math.atan2(height / 2, -frame[0].z) if camera.data.type == "PERSP" else math.radians(40)
    forward = matrix.to_3x3() @ Vector((0, 0, -1))
    up = matrix.to_3x3() @ Vector((0, 1, 0))
    return image, {"eye": y_up(eye), "target": y_up(eye + forward.normalized()),
                   "up": y_up(up.normalized()), "fov_y_deg": math.degrees(fov)}


def export_light(obj):
    """A light in Relume's units: watts over 4 pi for points and spots, irradiance for suns."""
    data = obj.data
    matrix = obj.matrix_world
    direction = (matrix.to_3x3() @ Vector((0, 0, -1))).normalized()
    light = {"name": obj.name.replace(".", "-"), "color": list(data.color),
             "casts_shadow": bool(data.use_shadow)}
    if data.type == "SUN":
        light.update(type="directional", direction=y_up(direction), gain=data.energy)
        return light
    light.update(type="point", position=y_up(matrix.translation), gain=data.energy / (4 * math.pi))
    if data.type == "SPOT":
        outer = math.degrees(data.spot_size) / 2
        light.update(type="spot", direction=y_up(direction),
                     outer_angle_deg=min(max(outer, 0.5), 90),
                     inner_angle_deg=min(outer * (1 - data.spot_blend), 90))
    elif data.type == "AREA":
        note(f"{obj.name}: an area light becomes a wide spot")
        light.update(type="spot", direction=y_up(direction), outer_angle_deg=90,
                     inner_angle_deg=0, gain=data.energy / math.pi)
    return light


def show_as_rendered(context):
    """Shows hair in full, as renders do; returns what sets it back."""
    before = []

    def change(owner, name, value):
        before.append((owner, name, getattr(owner, name)))
        setattr(owner, name, value)

    for settings in bpy.data.particles:
        change(settings, "display_step", settings.render_step)
        change(settings, "display_percentage", 100)
        change(settings, "child_nbr", settings.rendered_child_count)
    for obj in context.scene.objects:
        for modifier in obj.modifiers:
            if modifier.type == "PARTICLE_SYSTEM":
                change(modifier, "show_viewport", modifier.show_render)
        if obj.particle_systems and not obj.show_instancer_for_render:
            change(obj, "hide_render", True)
    context.view_layer.update()
    return before


def gather_strands(context):
    """Name, strands and material of each hair system that renders."""
    depsgraph = context.evaluated_depsgraph_get()
    found = []
    for obj in context.scene.objects:
        evaluated = obj.evaluated_get(depsgraph)
        for system in evaluated.particle_systems:
            settings = system.settings
            if settings.type != "HAIR" or settings.render_type != "PATH":
                continue
            slot = settings.material - 1
            slots = obj.material_slots
            material = slots[min(slot, len(slots) - 1)].material if slots else None
            found.append((f"{obj.name}-{system.name}", particle_strands(evaluated, system), material))
        if evaluated.type == "CURVES" and not obj.hide_render:
            found.append((obj.name, curves_strands(evaluated), obj.active_material))
    return [item for item in found if item[1].segments]


def tidy(value):
    """Numbers as a float has them, without the digits that it has not."""
    if isinstance(value, float):
        return float(f"{value:.7g}")
    if isinstance(value, dict):
        return {key: tidy(item) for key, item in value.items()}
    return [tidy(item) for item in value] if isinstance(value, list) else value


def export(context, path):
    """Writes `path` (.json) and, beside it, the files it names."""
    stem = os.path.splitext(os.path.abspath(path))[0]
    before = show_as_rendered(context)
    image, camera = export_camera(context.scene)
    materials, geometry = [], []
    lights = [export_light(obj) for obj in context.scene.objects
              if obj.type == "LIGHT" and not obj.hide_render]
    if any(o.type == "MESH" and not o.hide_render for o in context.scene.objects):
        bpy.ops.export_scene.gltf(filepath=stem + ".glb", export_format="GLB", export_apply=True,
                                  export_yup=True, use_renderable=True, export_animations=False)
        geometry.append({"file": os.path.basename(stem) + ".glb"})
    for number, (name, strands, material) in enumerate(gather_strands(context), 1):
        file = f"{stem}-{number}.hair"
        strands.write(file)
        materials.append(strand_material(name, material, bool(strands.colors)))
        geometry.append({"file": os.path.basename(file), "material": name, "name": name})
    for owner, attribute, value in reversed(before):
        setattr(owner, attribute, value)
    scene = {"image": image, "camera": camera, "materials": materials, "geometry": geometry,
             "lights": lights}
    with open(stem + ".json", "w", encoding="utf-8") as file:
        json.dump(tidy(scene), file, indent=2)
        file.write("\n")
    note(f"wrote {stem}.json")


if __name__ == "__main__":
    arguments = sys.argv[sys.argv.index("--") + 1:] if "--" in sys.argv else []
    if len(arguments) != 1:
        sys.exit("usage: blender -b SCENE.blend --python export_relume.py -- OUT.json")
    export(bpy.context, arguments[0])
