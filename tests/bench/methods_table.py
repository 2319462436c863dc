#!/usr/bin/env python3
"""Prints the unshadowed error of reduction methods as a Markdown table: TR2007-600 eq. 7 over covered
pixels, mean over random point lights that no method was trained on, as a multiple of the report's
K-means at the same k.

Usage: methods_table.py RELUME [--scenes hair plants spheres] [--records 8 4 2] [--lights 8]
                        [--width 256] [--methods ...] [--train-shadows]
Every figure comes from `relume prepare`, `relume render --shadow none` and `relume compare`.
"""

import argparse
import json
import pathlib
import random
import re
import subprocess
import tempfile

ROOT = pathlib.Path(__file__).resolve().parents[2]
METHODS = ["pure", "kmeans", "light-metric-1", "light-metric-2", "light-metric-3", "light-metric-4",
           "light-metric-5", "light-metric-6", "strong-kmeans", "kmedoids", "cmeans"]


def parse_arguments():
    parser = argparse.ArgumentParser(description=__doc__,
                                     formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("relume")
    parser.add_argument("--scenes", nargs="+", default=["hair", "plants", "spheres"])
    parser.add_argument("--records", nargs="+", type=int, default=[8, 4, 2])
    parser.add_argument("--lights", type=int, default=8)
    parser.add_argument("--width", type=int, default=256)
    parser.add_argument("--methods", nargs="+", default=METHODS)
    parser.add_argument("--train-shadows", action="store_true")
    return parser.parse_args()


def run(*arguments):
    return subprocess.run([str(a) for a in arguments], check=True, capture_output=True,
                          text=True).stdout


def load_scene(name):
    text = (ROOT / "scenes" / f"{name}.json").read_text(encoding="utf-8")
    return json.loads(re.sub(r"^\s*//.*$", "", text, flags=re.MULTILINE))


def make_light_files(scene, count, folder):
    """One file a light, each parameter anywhere between the two representatives."""
    low, high = scene["representative_lights"]
    rng = random.Random(7)
    files = []
    for i in range(count):
        light = {"name": f"test-{i}", "type": "point",
                 "position": [rng.uniform(a, b) for a, b in zip(low["position"], high["position"])],
                 "gain": rng.uniform(low["gain"], high["gain"])}
        files.append(folder / f"light_{i}.json")
        files[-1].write_text(json.dumps({"lights": [light]}), encoding="utf-8")
    return files


def prepare(args, scene, size, method, records, path):
    training = ["--train-shadows"] if args.train_shadows else []
    out = run(args.relume, "prepare", scene, "-o", path, "--method", method, "--records", records,
              "--width", size[0], "--height", size[1], "-q", "--json", *training)
    return json.loads(out)["rows"][0]


def measure(args, cache, lights, references, folder):
    """Mean error over lights, relative to the reference's mean brightness."""
    total = 0
    image = folder / "image.exr"
    for light, reference in zip(lights, references):
        run(args.relume, "render", cache, "-o", image, "--lights", light, "--shadow", "none", "-q")
        row = json.loads(run(args.relume, "compare", image, reference, "--json"))["rows"][0]
        total += row["error"] / (row["reference_mean"] * row["pixels"] / row["covered_pixels"])
    return total / len(lights)


def study_scene(args, name, folder):
    scene = load_scene(name)
    image = scene["image"]
    size = (args.width, args.width * image["height"] // image["width"])
    lights = make_light_files(scene, args.lights, folder)
    cache = folder / "cache.relume"
    prepare(args, name, size, "all", 8, cache)
    references = [folder / f"reference_{i}.exr" for i in range(len(lights))]
    for light, reference in zip(lights, references):
        run(args.relume, "render", cache, "-o", reference, "--lights", light, "--shadow", "none",
            "-q")
    cells = {}
    for method in args.methods:
        for records in args.records:
            stats = prepare(args, name, size, method, records, cache)
            cells[method, records] = (measure(args, cache, lights, references, folder),
                                      stats["thread_ms_reduce"] * 1e-3)
    return cells


def print_table(args, results):
    heads = [f"{scene} {k}" for scene in args.scenes for k in args.records]
    print("| method | " + " | ".join(heads) + " |")
    print("| --- |" + " --- |" * len(heads))
    for method in args.methods:
        row = []
        for scene in args.scenes:
            for k in args.records:
                error, seconds = results[scene][method, k]
                base = results[scene]["kmeans", k][0]
                row.append(f"{error * 250:.3g} ({error / base:.2f}) {seconds:.1f}s")
        print(f"| {method} | " + " | ".join(row) + " |", flush=True)


def main():
    args = parse_arguments()
    results = {}
    for scene in args.scenes:
        with tempfile.TemporaryDirectory() as folder:
            results[scene] = study_scene(args, scene, pathlib.Path(folder))
    print_table(args, results)


if __name__ == "__main__":
    main()
