#!/usr/bin/env python3
"""Checks every scene against docs/scene.schema.json, and that the schema refuses wrong ones.

Usage: check_schema.py ROOT. Exits with 77 (skipped) when the jsonschema package is absent.
"""

import json
import pathlib
import re
import sys

try:
    import jsonschema
except ImportError:
    print("skipped: no jsonschema package (apt-get install python3-jsonschema)")
    sys.exit(77)


def without_comments(text):
    """JSON with comments blanked; strings are kept as they are."""
    pattern = r'"(?:\\.|[^"\\])*"|//[^\n]*|/\*.*?\*/'
    return re.sub(pattern, lambda m: m[0] if m[0][0] == '"' else " ", text, flags=re.S)


def main():
    root = pathlib.Path(sys.argv[1])
    schema = json.loads((root / "docs/scene.schema.json").read_text())
    validator = jsonschema.Draft202012Validator(schema) \
        if hasattr(jsonschema, "Draft202012Validator") else jsonschema.Draft7Validator(schema)
    failures = 0
    scenes = sorted((root / "scenes").rglob("*.json"))
    for path in scenes:
        scene = json.loads(without_comments(path.read_text()))
        for error in validator.iter_errors(scene):
            where = "/" + "/".join(str(part) for part in error.absolute_path)
            print(f"{path}: {where}: {error.message[:200]}")
            failures += 1
        for key in ("lights", "geometry", "camera"):
            damaged = {k: v for k, v in scene.items() if k != key}
            if validator.is_valid(damaged) or validator.is_valid({**scene, "lamps": []}):
                print(f"{path}: the schema accepts a scene without {key} or with an unknown key")
                failures += 1
    print(f"{len(scenes)} scenes: {failures} failures")
    return 1 if failures or not scenes else 0


if __name__ == "__main__":
    sys.exit(main())
