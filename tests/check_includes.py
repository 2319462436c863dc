#!/usr/bin/env python3
"""Checks that includes point one way and that each library is included in its one place.

Usage: check_includes.py ROOT. Prints every violation as file:line and exits with 1 if there is any.
"""

import pathlib
import re
import sys

# Room -> rooms it may include (beside itself).
ALLOWED = {
    "core/base": [],
    "core/math": ["core/base"],
    "core/simd": ["core/base", "core/math"],
    "core/image": ["core/base", "core/math"],
    "core/scene": ["core/base", "core/math"],
    "core/trace": ["core/base", "core/math", "core/scene", "core/simd"],
    "core/samples": ["core/base", "core/math", "core/scene", "core/simd", "core/trace"],
    "core/shade": ["core/base", "core/math", "core/scene", "core/simd", "core/trace", "core/samples"],
    "core/relight": ["core/base", "core/math", "core/scene", "core/simd", "core/trace",
                     "core/samples", "core/shade", "core/image"],
    "reduction": ["core"],
    "shadow": ["core"],
    "viewer": ["core", "reduction", "shadow"],
    "tests": ["core", "reduction", "shadow", "viewer"],
}

# File -> extra includes it may have, with the reason in the file itself.
EXCEPTIONS = {
    "core/image/image_io.cpp": ["core/scene/io/texture_file.h", "core/scene/scene.h"],
}

# Header pattern -> files that may include it (prefixes).
LIBRARIES = {
    r"embree3/": ["core/trace/tracer.cpp"],
    r"(tbb|oneapi/tbb)/": ["core/base/parallel.cpp"],
    r"OpenImageIO/": ["core/image/"],
    r"(immintrin|x86intrin|arm_neon)\.h": ["core/simd/"],
    r"CLI/": ["viewer/commands/command_line.cpp"],
    r"tiny_gltf\.h": ["core/scene/io/gltf_file.cpp"],
    r"tiny_obj_loader\.h": ["core/scene/io/obj.cpp"],
    r"nlohmann/": ["core/scene/io/json_", "viewer/commands/json_output.cpp", "tests/"],
    r"xxhash\.h": ["core/samples/cache_info.cpp"],
    r"zlib\.h": ["core/scene/io/packed_file.cpp", "tests/core/scene_packed_file_test.cpp"],
    r"pybind11/": ["viewer/python/module.cpp"],
    r"glm/": ["core/math/vec.h"],
    r"(GLFW|backends/imgui_impl_glfw)": ["viewer/display/glfw_window.cpp", "tests/viewer/display_window.cpp"],
    r"GL/osmesa": ["viewer/display/osmesa_surface.cpp"],
    r"imgui": ["viewer/display/", "viewer/panels/", "tests/viewer/display_"],
    r"GL/gl": ["viewer/display/"],
}


def room_of(path):
    parts = path.split("/")
    return "/".join(parts[:2]) if parts[0] == "core" else parts[0]


def may_include(room, target):
    return any(target == r or target.startswith(r + "/") for r in ALLOWED[room] + [room])


def check_file(root, path):
    name = path.relative_to(root).as_posix()
    problems = []
    for number, line in enumerate(path.read_text(encoding="utf-8").splitlines(), 1):
        found = re.match(r'\s*#\s*include\s+[<"]([^>"]+)[>"]', line)
        if not found:
            continue
        header = found.group(1)
        if header.split("/")[0] in ("core", "reduction", "shadow", "viewer", "tests"):
            if not may_include(room_of(name), room_of(header)) and header not in EXCEPTIONS.get(name, []):
                problems.append(f"{name}:{number}: {room_of(name)} must not include {header}")
            continue
        for pattern, places in LIBRARIES.items():
            if re.match(pattern, header) and not any(name.startswith(p) for p in places):
                problems.append(f"{name}:{number}: {header} belongs in {', '.join(places)} only")
                break
    return problems


def main():
    root = pathlib.Path(sys.argv[1])
    files = [f for room in ("core", "reduction", "shadow", "viewer", "tests")
             for f in sorted((root / room).rglob("*")) if f.suffix in (".h", ".cpp")]
    if len(files) < 50:
        print(f"only {len(files)} source files under {root}: is this the right folder?")
        return 1
    problems = [p for f in files for p in check_file(root, f)]
    print("\n".join(problems) if problems else f"{len(files)} files: includes point one way")
    return 1 if problems else 0


if __name__ == "__main__":
    sys.exit(main())
