"""Makes the example scene of scenes/blender: a ball with particle hair, a tuft of Curves with colours, a
table, three lights and a camera. Then exports it and renders it by Cycles, direct light only:

    blender -b --factory-startup --python make_example.py -- FOLDER
"""

import math
import os
import random
import sys

import bpy

sys.path.insert(0, os.path.dirname(os.path.abspath(__file__)))
import export_relume  # noqa: E402


def make_material(name, color, roughness, metallic=0.0):
    material = bpy.data.materials.new(name)
    material.use_nodes = True
    shader = material.node_tree.nodes["Principled BSDF"]
    shader.inputs["Base Color"].default_value = (*color, 1)
    shader.inputs["Roughness"].default_value = roughness
    shader.inputs["Metallic"].default_value = metallic
    return material


def make_ball():
    """A ball with 150 hairs, three children each."""
    bpy.ops.mesh.primitive_uv_sphere_add(segments=24, ring_count=12, radius=0.6, location=(0, 0, 0.6))
    ball = bpy.context.object
    ball.name = "ball"
    bpy.ops.object.shade_smooth()
    ball.data.materials.append(make_material("skin", (0.5, 0.3, 0.2), 0.6))
    ball.data.materials.append(make_material("hair", (0.35, 0.15, 0.05), 0.3))
    ball.modifiers.new("hair", "PARTICLE_SYSTEM")
    settings = ball.particle_systems[0].settings
    settings.type = "HAIR"
    settings.count = 150
    settings.hair_length = 0.5
    settings.material = 2
    settings.render_step = settings.display_step = 2
    settings.child_type = "INTERPOLATED"
    settings.rendered_child_count = settings.child_nbr = 3
    settings.root_radius = 1
    settings.tip_radius = 0.2
    settings.radius_scale = 0.01


def make_tuft():
    """An object of the new Curves type: 150 blades with a radius a point and a colour each."""
    bpy.ops.mesh.primitive_circle_add(vertices=12, radius=0.25, fill_type="NGON", location=(-1.5, -0.4, 0))
    patch = bpy.context.object
    patch.modifiers.new("blades", "PARTICLE_SYSTEM")
    settings = patch.particle_systems[0].settings
    settings.type = "HAIR"
    settings.count = 150
    settings.hair_length = 0.6
    settings.brownian_factor = 0.05
    settings.display_step = 3
    bpy.ops.curves.convert_from_particle_system()
    tuft = next(o for o in bpy.context.scene.objects if o.type == "CURVES")
    tuft.name = "tuft"
    bpy.data.objects.remove(patch)
    curves = tuft.data
    if "radius" not in curves.attributes:
        curves.attributes.new("radius", "FLOAT", "POINT")
    curves.attributes.new("color", "FLOAT_COLOR", "CURVE")
    for number, curve in enumerate(curves.curves):
        green = 0.2 + 0.3 * random.random()
        curves.attributes["color"].data[number].color = (0.4 * green, green, 0.1 * green, 1)
        last = curve.points_length - 1
        for i in range(curve.points_length):
            point = curves.attributes["radius"].data[curve.first_point_index + i]
            point.value = 0.006 * (1 - 0.8 * i / last)
    tuft.data.materials.append(make_material("grass", (0.1, 0.3, 0.03), 0.5))


def make_table_and_box():
    bpy.ops.mesh.primitive_plane_add(size=6)
    bpy.context.object.name = "table"
    bpy.context.object.data.materials.append(make_material("table", (0.4, 0.4, 0.45), 0.8))
    bpy.ops.mesh.primitive_cube_add(size=0.7, location=(1.4, 0.3, 0.35), rotation=(0, 0, 0.5))
    bpy.context.object.name = "box"
    bpy.context.object.data.materials.append(make_material("gold", (1.0, 0.77, 0.34), 0.35, 1.0))


def make_light(kind, name, location, energy, color=(1, 1, 1)):
    light = bpy.data.lights.new(name, kind)
    light.energy = energy
    light.color = color
    obj = bpy.data.objects.new(name, light)
    bpy.context.collection.objects.link(obj)
    obj.location = location
    aim = obj.constraints.new("TRACK_TO")
    aim.target = bpy.data.objects["ball"]
    aim.track_axis, aim.up_axis = "TRACK_NEGATIVE_Z", "UP_Y"
    light.use_shadow = True
    if kind in {"POINT", "SPOT"}:
        light.shadow_soft_size = 0
    return light


def make_scene():
    bpy.ops.wm.read_factory_settings(use_empty=True)
    make_ball()
    make_tuft()
    make_table_and_box()
    make_light("POINT", "key", (2.5, -2.5, 3.5), 400, (1, 0.9, 0.8))
    make_light("SPOT", "rim.001", (-2.5, 2, 2.5), 300, (0.6, 0.7, 1)).spot_size = math.radians(60)
    make_light("SUN", "sky", (0, -3, 2), 0.6).angle = 0
    camera = bpy.data.objects.new("camera", bpy.data.cameras.new("camera"))
    bpy.context.collection.objects.link(camera)
    camera.location = (1.2, -5, 2.2)
    aim = camera.constraints.new("TRACK_TO")
    aim.target = bpy.data.objects["ball"]
    aim.track_axis, aim.up_axis = "TRACK_NEGATIVE_Z", "UP_Y"
    camera.data.lens = 45
    scene = bpy.context.scene
    scene.camera = camera
    scene.render.resolution_x, scene.render.resolution_y = 480, 320
    scene.render.resolution_percentage = 100
    return scene


def render_by_cycles(scene, path, samples=64):
    scene.render.engine = "CYCLES"
    scene.cycles.device = "CPU"
    scene.cycles.samples = samples
    scene.cycles.use_denoising = False
    scene.cycles.max_bounces = 0
    scene.cycles_curves.shape = "RIBBONS"
    scene.world = bpy.data.worlds.get("black") or bpy.data.worlds.new("black")
    scene.world.use_nodes = False
    scene.world.color = (0, 0, 0)
    scene.render.image_settings.file_format = "OPEN_EXR"
    scene.render.filepath = path
    bpy.ops.render.render(write_still=True)


if __name__ == "__main__":
    folder = os.path.abspath(sys.argv[sys.argv.index("--") + 1])
    os.makedirs(folder, exist_ok=True)
    random.seed(1)
    scene = make_scene()
    bpy.context.view_layer.update()
    export_relume.export(bpy.context, os.path.join(folder, "ball.json"))
    render_by_cycles(scene, os.path.join(folder, "cycles.exr"))
