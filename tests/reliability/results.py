"""Writes the figures of a check of reliability as JSON, for docs/write_reliability."""

import json
import subprocess


def write_results(path, schema, program, **values):
    """`values` with what `relume --version` says of the program."""
    words = subprocess.run([str(program), "--version"], capture_output=True, text=True, check=True).stdout.split()
    document = {"schema": schema, "version": words[1], "commit": words[2].strip("()"), **values}
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text(json.dumps(document, indent=1) + "\n")
