#!/usr/bin/env python3
"""Installs a build into a folder of its own and uses it as a stranger would.

Usage: check_install.py SOURCE BUILD CMAKE CXX PYTHON PROGRAM (PYTHON: "" where the module is not
built; PROGRAM: 1, or 0 where the library is built alone). Runs the installed program, the C++ example
found by find_package and by pkg-config, and the Python example. The library alone must have been
built without a header of the window or the command line.
"""

import os
import pathlib
import re
import struct
import subprocess
import sys
import tempfile


def run(*command, **environment):
    result = subprocess.run([str(c) for c in command], env={**os.environ, **environment},
                            capture_output=True, text=True, check=False)
    if result.returncode != 0:
        sys.exit(f"{' '.join(str(c) for c in command)}\n{result.stdout}{result.stderr}")
    return result.stdout


def write_bmp(path):
    """One red pixel: read by relume-decode, which must be found where it is installed."""
    path.write_bytes(b"BM" + struct.pack("<IIIIiiHHIIiiII", 58, 0, 54, 40, 1, 1, 1, 24, 0, 4, 0, 0, 0, 0) + b"\0\0\xff\0")
    return path


def check_program(prefix):
    assert "relume" in run(prefix / "bin/relume", "--version")
    assert '.TH RELUME 1' in (prefix / "share/man/man1/relume.1").read_text(encoding="utf-8")
    assert (prefix / "share/bash-completion/completions/relume").is_file()
    bmp = write_bmp(prefix / "red.bmp")
    run(prefix / "bin/relume", "compare", bmp, bmp, "--fail", "0")


def check_library_alone(build, prefix):
    assert not (prefix / "bin").exists()
    # What Ninja knows of headers; other generators keep it elsewhere.
    if (build / ".ninja_deps").is_file():
        headers = run("ninja", "-C", build, "-t", "deps")
        found = sorted(set(re.findall(r"\S*/(?:GL|GLFW|CLI|imgui)/\S*", headers)))
        assert "glm/" in headers and not found, found[:5]


def generator_of(build):
    """Of the build: the machine may have no other."""
    cache = (build / "CMakeCache.txt").read_text(encoding="utf-8")
    return re.search(r"^CMAKE_GENERATOR:INTERNAL=(.+)$", cache, re.MULTILINE).group(1)


def check_find_package(examples, prefix, folder, cmake, compiler, generator):
    build = folder / "examples"
    run(cmake, "-S", examples, "-B", build, "-G", generator, f"-DCMAKE_PREFIX_PATH={prefix}",
        f"-DCMAKE_CXX_COMPILER={compiler}")
    run(cmake, "--build", build)
    print(run(build / "relight", folder), end="")


def check_pkg_config(examples, prefix, folder, compiler):
    pkg_config, = prefix.rglob("relume.pc")
    flags = run("pkg-config", "--cflags", "--libs", "relume",
                PKG_CONFIG_PATH=str(pkg_config.parent)).split()
    library = next(f[2:] for f in flags if f.startswith("-L"))
    run(compiler, "-std=c++17", "-Wall", "-Wextra", "-Werror", "-pedantic", "-fsyntax-only",
        examples / "relight.cpp", *flags)
    assert list(pathlib.Path(library).glob("librelume.so")), library


def check_python(examples, prefix, folder, python):
    module, = prefix.rglob("relume.*.so")
    print(run(python, examples / "relight.py", folder, PYTHONPATH=str(module.parent)), end="")
    picture = write_bmp(folder / "red.bmp")
    red = run(python, "-c", f"import relume; print(relume.read_image('{picture}').tolist())",
              PYTHONPATH=str(module.parent))
    assert red.strip() == "[[[1.0, 0.0, 0.0]]]", red


def main():
    source, build, cmake, compiler, python, program = sys.argv[1:7]
    examples = pathlib.Path(source) / "tests/examples"
    with tempfile.TemporaryDirectory(prefix="relume-install-") as name:
        folder = pathlib.Path(name)
        prefix = folder / "prefix"
        run(cmake, "--install", build, "--prefix", prefix)
        if program == "1":
            check_program(prefix)
        else:
            check_library_alone(pathlib.Path(build), prefix)
        check_find_package(examples, prefix, folder, cmake, compiler,
                           generator_of(pathlib.Path(build)))
        check_pkg_config(examples, prefix, folder, compiler)
        if python:
            check_python(examples, prefix, folder, python)


if __name__ == "__main__":
    main()
