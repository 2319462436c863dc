#!/usr/bin/env python3
"""Checks a study's documents against docs/study.schema.json and its pages in headless Chromium.

Usage: check_page.py ROOT RELUME. Runs small studies; each page must load without an error and without a request, a plot must
zoom, a table sort, pictures wipe, and nothing may stick out of a narrow window. Exits with 77 (skipped) without Chromium.
"""

import json
import pathlib
import re
import shutil
import subprocess
import sys
import tempfile

SMALL = ["spheres", "-q", "--width", "48", "--height", "48", "--lights", "3"]
STUDIES = {
    "rates": ["--records", "4", "2", "--methods", "kmeans", "pure"],
    "pictures": ["--records", "2", "--methods", "kmeans", "pure"],
    "shadows": ["--records", "2", "--methods", "kmeans", "--shadows", "ray", "--truth-spp", "9", "--spp", "4"],
    "tradeoff": ["--records", "2", "--methods", "kmeans", "--shadows", "ray", "--average-records", "0", "--truth-spp", "9"],
    "stability": ["--records", "2", "--spp", "4"],
}
CHROMIUM = shutil.which("chromium") or shutil.which("chromium-browser") or shutil.which("google-chrome")


def check_schema(root, document):
    try:
        import jsonschema
    except ImportError:
        return []
    schema = json.loads((root / "docs/study.schema.json").read_text())
    validator = jsonschema.validators.validator_for(schema)(schema)
    problems = [f"{'/'.join(map(str, e.absolute_path))}: {e.message[:200]}" for e in validator.iter_errors(document)]
    if validator.is_valid({**document, "rows": [{}]}) or validator.is_valid({**document, "seed": "x"}):
        problems.append("the schema accepts a wrong document")
    return problems


def open_page(root, page):
    """What page_test.js found."""
    script = (root / "tests/viewer/page_test.js").read_text()
    copy = page.with_suffix(".test.html")
    copy.write_text(page.read_text().replace("<head>", f"<head><script>{script}</script>", 1))
    with tempfile.TemporaryDirectory() as profile:
        dom = subprocess.run(
            [CHROMIUM, "--headless", "--no-sandbox", "--disable-gpu", f"--user-data-dir={profile}", "--window-size=500,900",
             "--host-resolver-rules=MAP * ~NOTFOUND", "--virtual-time-budget=20000", "--dump-dom", copy.as_uri()],
            capture_output=True, text=True, timeout=120).stdout
    found = re.search(r'<pre id="page-test">(.*?)</pre>', dom, flags=re.S)
    if not found:
        return {"errors": ["the page did not get to its end"]}
    return json.loads(found[1].replace("&lt;", "<").replace("&gt;", ">").replace("&amp;", "&"))


def width(axis):
    return axis[1] - axis[0]


def check_zoom(zoom):
    problems = []
    for axis in ("x", "y"):
        before, after, all_ = (width(zoom[key][axis]) for key in ("before", "after", "all"))
        if not 0.15 * before < after < 0.5 * before:
            problems.append(f"zoom of 30 % of {axis} shows {after:.3g} of {before:.3g}")
        if abs(all_ - before) > 0.01 * before:
            problems.append(f"'all' shows {all_:.3g} of {before:.3g} in {axis}")
    return problems


def key(text):
    try:
        return (0, float(text), "")
    except ValueError:
        return (1, 0.0, text)


def check_sorts(columns, sorts):
    problems = []
    for name, sort in zip(columns, sorts):
        up = [key(c) for c in sort["up"]["cells"] if c]
        down = [key(c) for c in sort["down"]["cells"] if c]
        if sort["up"]["sort"] != "ascending" or sort["down"]["sort"] != "descending":
            problems.append(f"column {name} does not say how it is sorted")
        if up != sorted(up) or down != sorted(down, reverse=True):
            problems.append(f"column {name} is not sorted: {sort}")
    if all(len(set(sort["up"]["cells"])) == 1 for sort in sorts):
        problems.append("no column has two values: nothing was sorted")
    return problems


def check_wipe(wipe):
    """clip-path cuts the upper picture from the right where the bar stands."""
    expected = [("inset(0px 75% 0px 0px)", "25%"), ("inset(0px 25% 0px 0px)", "75%")]
    found = [(state["clip"], state["bar"]) for state in (wipe["first"], wipe["second"])]
    problems = [] if found == expected else [f"wipe at {found}, expected {expected}"]
    return problems if wipe["loaded"] else problems + ["a picture did not load"]


def check_page(root, page):
    result = open_page(root, page)
    if result["errors"]:
        return result["errors"]
    problems = [f"the page asks for {name}" for name in result["requests"]]
    if result["overflow"] > 0:
        problems.append(f"{result['overflow']} pixels stick out of a narrow window")
    if result["plots"]:
        problems += check_zoom(result["zoom"])
    if result.get("wipe"):
        problems += check_wipe(result["wipe"])
    return problems + check_sorts(result["columns"], result["sorts"])


def main():
    root = pathlib.Path(sys.argv[1])
    if CHROMIUM is None:
        print("skipped: no Chromium (apt-get install chromium)")
        return 77
    failures = 0
    for path in sorted((root / "docs/studies/data").glob("*.json")):
        for problem in check_schema(root, json.loads(path.read_text())):
            print(f"{path}: {problem}")
            failures += 1
    with tempfile.TemporaryDirectory() as folder:
        out = pathlib.Path(folder)
        for name, options in STUDIES.items():
            subprocess.run([sys.argv[2], "study", name, *SMALL, *options, "-o", out], check=True, stdout=subprocess.DEVNULL)
            problems = check_schema(root, json.loads((out / f"{name}.json").read_text()))
            problems += check_page(root, out / f"{name}.html")
            for problem in problems:
                print(f"{name}: {problem}")
            failures += len(problems)
    print(f"{len(STUDIES)} pages: {failures} failures")
    return 1 if failures else 0


if __name__ == "__main__":
    sys.exit(main())
