"""Prepares a scene, moves its first light and compares the pictures, with NumPy.

Usage: relight.py FOLDER
"""

import sys

import numpy as np
import relume

folder = sys.argv[1] if len(sys.argv) > 1 else "."
cache = relume.prepare("spheres", records=4, width=96, height=72)
cache.save(folder + "/python.relume")

lights = cache.lights
relighter = relume.Relighter(cache, shadow="ray")
relighter.relight(lights)
frame = relighter.frame  # a view: it shows every later relight() too
before = frame.copy()

x, y, z = lights[0].position
lights[0].position = (x, 1.5 * y, z)
relighter.relight(lights)
moved = relume.compare(frame, before)
print(f"relume {relume.__version__}: {cache.record_count} records; the move changed {moved.error_image:g}")

layers = sum(relighter.layer(i).astype(np.float64) for i in range(len(lights)))
assert np.allclose(layers, frame, rtol=1e-5, atol=1e-6), "layers sum to the frame"

again = relume.Relighter(relume.load(folder + "/python.relume"))
again.relight(lights)
assert moved.error_image > 0
assert np.array_equal(again.frame, frame), "a cache's file gives the same picture"

lamp = """{"camera": {"eye": [0, 0, 5], "target": [0, 0, 0]},
  "materials": [{"name": "glow", "shader": "lambert", "diffuse": 0.5, "emission": [2, 1, 0.5]}],
  "geometry": [{"generator": "sphere", "material": "glow"}],
  "lights": [{"name": "key", "position": [2, 3, 4], "gain": 20}]}"""
with open(folder + "/lamp.json", "w", encoding="utf-8") as scene:
    scene.write(lamp)
glowing = relume.prepare(folder + "/lamp.json", width=48, height=48, records=2)
lit = relume.Relighter(glowing)
lit.relight(glowing.lights)
assert glowing.emission.shape == (48, 48, 3) and np.isclose(glowing.emission.max(), 2)
assert np.allclose(lit.layer(0) + glowing.emission, lit.frame, rtol=1e-5), "emission is in the frame"
assert not cache.emission.any()
