"""Times moves of a light in Cycles over a ball of 60,000 hairs, 512 x 512, direct light only, data kept between renders:

    blender -b --factory-startup --python time_cycles.py -- FOLDER

Writes hairy.json for Relume, cycles_25.exr and cycles_truth.exr (256 samples) under one light, and cycles.json: seconds of each
move at 25 samples. Run by docs/measure_cycles.
"""

import json
import os
import sys
import time

import bpy

sys.path.insert(0, os.path.dirname(os.path.abspath(__file__)))
import export_relume  # noqa: E402
import make_example  # noqa: E402

PARENTS, CHILDREN = 20000, 3
PLACES = [(3.0, -2.0, 3.0), (2.8, -2.2, 3.1), (2.6, -2.4, 3.2), (-3.0, -1.5, 1.0)]


def make_scene():
    bpy.ops.wm.read_factory_settings(use_empty=True)
    make_example.make_ball()
    settings = bpy.data.objects["ball"].particle_systems[0].settings
    settings.count = PARENTS
    settings.rendered_child_count = settings.child_nbr = CHILDREN
    settings.hair_length = 0.3
    settings.radius_scale = 0.0016
    light = make_example.make_light("POINT", "key", PLACES[0], 500)
    light.shadow_soft_size = 0
    camera = bpy.data.objects.new("camera", bpy.data.cameras.new("camera"))
    bpy.context.collection.objects.link(camera)
    camera.location = (0, -4, 0.6)
    aim = camera.constraints.new("TRACK_TO")
    aim.target = bpy.data.objects["ball"]
    aim.track_axis, aim.up_axis = "TRACK_NEGATIVE_Z", "UP_Y"
    camera.data.lens = 60
    scene = bpy.context.scene
    scene.camera = camera
    scene.render.resolution_x = scene.render.resolution_y = 512
    scene.render.resolution_percentage = 100
    scene.render.use_persistent_data = True
    return scene


def render(scene, samples, path):
    start = time.perf_counter()
    make_example.render_by_cycles(scene, path, samples)
    return time.perf_counter() - start


if __name__ == "__main__":
    folder = os.path.abspath(sys.argv[sys.argv.index("--") + 1])
    os.makedirs(folder, exist_ok=True)
    scene = make_scene()
    bpy.context.view_layer.update()
    export_relume.export(bpy.context, os.path.join(folder, "hairy.json"))
    render(scene, 1, os.path.join(folder, "first.exr"))
    moves = []
    for place in PLACES[1:]:
        bpy.data.objects["key"].location = place
        moves.append(render(scene, 25, os.path.join(folder, "cycles_25.exr")))
    scene.cycles.seed = 1
    render(scene, 256, os.path.join(folder, "cycles_truth.exr"))
    with open(os.path.join(folder, "cycles.json"), "w", encoding="utf-8") as file:
        json.dump({"blender": bpy.app.version_string, "seconds_a_move": moves}, file)
