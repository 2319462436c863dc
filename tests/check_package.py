#!/usr/bin/env python3
"""Makes the Debian packages, unpacks them and runs the program from there.

Usage: check_package.py CPACK BUILD. Exit code 77 where Debian's tools are missing.
"""

import os
import pathlib
import shutil
import subprocess
import sys
import tempfile


def field(package, name):
    return subprocess.run(["dpkg-deb", "-f", package, name], capture_output=True, text=True,
                          check=True).stdout.strip()


def main():
    cpack, build = sys.argv[1:3]
    if not shutil.which("dpkg-deb") or not shutil.which("dpkg-shlibdeps"):
        sys.exit(77)
    with tempfile.TemporaryDirectory(prefix="relume-package-") as name:
        folder = pathlib.Path(name)
        # Fast to pack: the test throws them away.
        subprocess.run([cpack, "-B", folder, "-D", "CPACK_DEBIAN_COMPRESSION_TYPE=none"], cwd=build,
                       check=True, capture_output=True)
        packages = {field(p, "Package"): p for p in folder.glob("*.deb")}
        assert {"relume", "librelume-dev"} <= set(packages), packages
        assert "libembree3" in field(packages["relume"], "Depends")
        assert "relume (= " in field(packages["librelume-dev"], "Depends")
        root = folder / "root"
        for package in packages.values():
            subprocess.run(["dpkg-deb", "-x", package, root], check=True)
        picture = folder / "frame.exr"
        subprocess.run([root / "usr/bin/relume", "render", "spheres", "-o", picture, "--width", "48",
                        "--height", "36", "--quiet"], check=True, stdout=subprocess.DEVNULL)
        assert picture.stat().st_size > 1000
        assert (root / "usr/include/relume/relume.h").is_file()
        library, = {p.resolve() for p in root.rglob("librelume.so*")}
        output = subprocess.run(["ldd", library], capture_output=True, text=True, check=True,
                                env={**os.environ, "LC_ALL": "C"}).stdout
        assert "not found" not in output, output


if __name__ == "__main__":
    main()
