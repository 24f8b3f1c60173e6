#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""The element pages of docs/elements say what the program does.

element_pages.py MCVISI SOURCES FOLDER

- The drawings and the parameter tables are what their scripts make, byte for byte.
- Each element of the generated schemas has one table, and on its page a drawing, a formula and a
  scene that uses it; the overview lists it.
- Each scene of a page passes `mcvisi check` without a warning and is rendered, by the reference
  renderer, which compiles nothing: its image is not black.
- Each drawing is on a page, and the overview shows drawings that exist.
"""

import glob
import json
import math
import os
import re
import shutil
import subprocess
import sys

failures = []


def fail(*words):
    failures.append(" ".join(map(str, words)))


def read(path, mode="r"):
    with open(path, mode, **({} if "b" in mode else {"encoding": "utf-8"})) as file:
        return file.read()


def run_script(path, folder):
    shutil.rmtree(folder, ignore_errors=True)
    os.makedirs(folder)
    subprocess.run([sys.executable, "-B", path, folder], check=True)


def files(folder, ending):
    """The files below a folder, by their place in it."""
    found = glob.glob(os.path.join(folder, "**", "*" + ending), recursive=True)
    return {os.path.relpath(path, folder): path for path in found}


def compare(script, kept, made):
    """The files of two folders, byte for byte."""
    for name in sorted(set(kept) | set(made)):
        if name not in kept:
            fail(name, "is missing: run", script)
        elif name not in made:
            fail(kept[name], "is not made by", script)
        elif read(kept[name], "rb") != read(made[name], "rb"):
            fail(kept[name], "is not what", script, "makes: run it")


def elements(sources):
    """sensors/pinhole and so on, of all schemas that hold a list of types."""
    for name in ("sensors", "emitters", "materials", "surfaces", "defects"):
        path = os.path.join(sources, "include/mcvisi/schema/MCVISI_%s.schema.json" % name)
        for key in json.loads(read(path))["definitions"]:
            if key != "node":
                yield name, key


def scenes(text):
    """The complete scenes of a page."""
    blocks = [json.loads(block) for block in re.findall(r"```json\n(.*?)```", text, re.DOTALL)]
    return [block for block in blocks if "asset" in block]


def uses(scene, kind, key):
    if kind == "materials":
        found = (
            [m.get("extensions", {}).get("MCVISI_materials", {}) for m in scene["materials"]]
            if "materials" in scene
            else []
        )
    else:
        found = scene["extensions"].get("MCVISI_" + kind, {}).get(kind, [])
    return any(element.get("type") == key for element in found)


def check_elements(sources, pages):
    index = pages["index.md"]
    for kind, key in elements(sources):
        marker = "<!-- parameters: %s/%s -->\n" % (kind, key)
        holders = [name for name, text in pages.items() if marker in text]
        if len(holders) != 1:
            fail("%s/%s has %d parameter tables on the pages, not one" % (kind, key, len(holders)))
            continue
        text = pages[holders[0]]
        if "](../drawings/" not in text or "```text\n" not in text:
            fail(holders[0], "has no drawing or no formula for", key)
        if not any(uses(scene, kind, key) for scene in scenes(text)):
            fail(holders[0], "has no scene that uses %s/%s" % (kind, key))
        if not re.search(r"\[`%s`\]\(%s[)#]" % (key, re.escape(holders[0])), index):
            fail("index.md does not lead from", key, "to", holders[0])


def check_drawings(pages, drawings):
    """Each drawing is on a page, and each thumbnail is a drawing; links are the test docs's."""
    shown = set(re.findall(r"\]\(\.\./drawings/([^)]+)\)", "".join(pages.values())))
    for unused in sorted(set(drawings) - shown):
        fail("drawings/" + unused, "is on no page")
    for name in re.findall(r'<img src="drawings/([^"]+)"', pages["index.md"]):
        if name not in drawings:
            fail("index.md shows drawings/" + name, "which does not exist")


def run_scene(program, path):
    def run(*words):
        result = subprocess.run([program, *words, "--json"], capture_output=True, text=True)
        if result.returncode != 0:
            fail(os.path.basename(path), words[0], "exit code", result.returncode, result.stderr)
            return None
        return json.loads(result.stdout)

    checked = run("check", path)
    if not checked:
        return
    for finding in checked["findings"]:
        if finding["severity"] != "note":
            fail(os.path.basename(path), finding["severity"] + ":", finding["text"])
    image = path.replace(".gltf", ".exr")
    rendered = run(
        "render",
        path,
        "--device",
        "reference",
        "--threads",
        "1",
        "--resolution",
        "8x6",
        "--spp",
        "16",
        "-o",
        image,
    )
    if rendered and not (math.isfinite(rendered["mean"]) and rendered["mean"] > 0):
        fail(os.path.basename(path), "renders black: mean", rendered["mean"])


def main(program, sources, folder):
    docs = os.path.join(sources, "docs/elements")
    made = {kind: os.path.join(folder, kind) for kind in ("drawings", "pages", "scenes")}
    run_script(os.path.join(docs, "draw.py"), made["drawings"])
    run_script(os.path.join(docs, "tables.py"), made["pages"])
    drawings = files(made["drawings"], ".svg")
    compare("docs/elements/draw.py", files(os.path.join(docs, "drawings"), ".svg"), drawings)
    compare("docs/elements/tables.py", files(docs, ".md"), files(made["pages"], ".md"))
    pages = {name: read(path) for name, path in files(docs, ".md").items()}
    check_elements(sources, pages)
    check_drawings(pages, drawings)
    os.makedirs(made["scenes"], exist_ok=True)
    count = 0
    for name, text in sorted(pages.items()):
        for scene in scenes(text):
            count += 1
            path = os.path.join(
                made["scenes"], "%02d-%s.gltf" % (count, os.path.basename(name)[:-3])
            )
            with open(path, "w", encoding="utf-8") as file:
                json.dump(scene, file)
            run_scene(program, path)
    print("%d drawings, %d pages, %d scenes" % (len(drawings), len(pages), count))
    for failure in failures:
        print(failure)
    return 1 if failures else 0


if __name__ == "__main__":
    if len(sys.argv) != 4:
        sys.exit(__doc__)
    sys.exit(main(*sys.argv[1:]))
