#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""The page of a sweep, as a browser reads it: sweep_page.py PROGRAM FOLDER.

A sweep of 8 x 8 sets: the page's policy names its style and script by their hashes and allows no
other; all links lead to places inside; each set has its picture; without pictures it has less than
100 kB; and the command of a set renders the picture that was kept, bit by bit. The page of `check --html`
has such a policy, too.
"""
import base64
import hashlib
import html.parser
import json
import pathlib
import shlex
import shutil
import subprocess
import sys

SIDE = 8
MOST_BYTES = 100_000

# A panel before a pinhole camera.
SCENE = {
    "asset": {"version": "2.0"}, "scene": 0, "scenes": [{"nodes": [0, 1]}],
    "extensionsUsed": ["MCVISI_sensors", "MCVISI_emitters"],
    "extensions": {
        "MCVISI_sensors": {"sensors": [{"name": "cam", "type": "pinhole", "imageDistance": 0.01,
                                        "resolution": [24, 16], "pixelSize": 0.0004}]},
        "MCVISI_emitters": {"emitters": [{"name": "panel", "type": "area", "size": [0.49, 0.33],
                                          "radiance": 2.5}]}},
    "nodes": [{"extensions": {"MCVISI_sensors": {"sensor": 0}}},
              {"name": "stand", "translation": [0, 0, -1], "rotation": [0, 1, 0, 0],
               "extensions": {"MCVISI_emitters": {"emitter": 0}}}]}


class Page(html.parser.HTMLParser):
    """What can load, run or be followed."""

    def __init__(self, text):
        super().__init__()
        self.policy, self.ids, self.links, self.pictures = "", [], [], []
        self.inline, self.commands, self.events = [], [], []
        self.inside = ""
        self.feed(text)

    def handle_starttag(self, tag, attrs):
        given = dict(attrs)
        self.inside = tag
        if given.get("http-equiv") == "Content-Security-Policy":
            self.policy = given["content"]
        if "id" in given:
            self.ids.append(given["id"])
        self.links += [given[key] for key in ("href", "xlink:href") if key in given]
        if "src" in given:
            self.pictures.append(given["src"])
        self.events += [key for key in given if key.startswith("on") or key == "style"]

    def handle_endtag(self, tag):
        self.inside = ""

    def handle_data(self, data):
        if self.inside in ("script", "style"):
            self.inline.append((self.inside, data))
        if self.inside == "pre":
            self.commands.append(data)


def run(folder, *words):
    done = subprocess.run(words, cwd=folder, capture_output=True, text=True, check=False)
    if done.returncode != 0:
        sys.exit("%s: exit code %d\n%s" % (shlex.join(words), done.returncode, done.stderr))
    return done.stdout


def check_policy(page, more):
    rules = dict(rule.split(None, 1) for rule in page.policy.split("; "))
    wanted = {"default-src": "'none'", **more}
    for kind, text in page.inline:
        digest = base64.b64encode(hashlib.sha256(text.encode()).digest()).decode()
        key = kind + "-src"
        wanted[key] = (wanted.get(key, "") + " 'sha256-%s'" % digest).strip()
    if rules != wanted or not page.inline:
        sys.exit("the policy is %s, must be %s" % (rules, wanted))
    if page.events:
        sys.exit("attributes that the policy forbids: %s" % page.events)


def check_links(page):
    if len(set(page.ids)) != len(page.ids):
        sys.exit("an id is there twice")
    for link in page.links:
        if not link.startswith("#") or link[1:] not in page.ids:
            sys.exit("%s: leads out of the page" % link)
    for number in range(SIDE * SIDE):
        # From the table, the heat map, and the plots over both parameters.
        if page.links.count("#s%d" % number) < 4:
            sys.exit("set %d: has no link in a plot" % number)


def check_pictures(page):
    start = "data:image/png;base64,"
    for picture in page.pictures:
        if not picture.startswith(start):
            sys.exit("%s: is no picture inside the page" % picture[:80])
        data = base64.b64decode(picture[len(start):], validate=True)
        # The signature, and width and height of IHDR: the picture is smaller than a thumbnail.
        if data[:8] != b"\x89PNG\r\n\x1a\n" or data[16:24] != bytes((0, 0, 0, 24, 0, 0, 0, 16)):
            sys.exit("a picture is no PNG of 24 x 16 pixels")
    if len(page.pictures) != SIDE * SIDE + 1:  # and that of the best set
        sys.exit("%d pictures" % len(page.pictures))


def check_command(program, folder, page, number):
    """What stands beside a set, run as it is, gives the kept picture."""
    name = "set-%05d.exr" % number
    command = next(words for words in page.commands if words.endswith(name))
    run(folder, program, *shlex.split(command)[1:], "--device", "reference")
    report = json.loads(run(folder, program, "measure", name, "--minus", "kept/" + name, "--json"))
    region = report["regions"][0]
    if region["smallest"] != 0 or region["largest"] != 0:
        sys.exit("%s: gives another picture" % command)


def main():
    program, folder = sys.argv[1], pathlib.Path(sys.argv[2])
    shutil.rmtree(folder, ignore_errors=True)
    folder.mkdir(parents=True)
    (folder / "rig 1.gltf").write_text(json.dumps(SCENE))
    run(folder, program, "sweep", "rig 1.gltf", "--vary", "emitters/panel/radiance=1..5:%d" % SIDE,
        "--vary", "sensors/cam/imageDistance=9mm..12mm:%d" % SIDE, "--region", "mid=8,6,8,4",
        "--metric", "mid.mean", "--metric", "mean", "--best", "mean=largest", "--until", "mean=0.1",
        "--spp", "64", "--seed", "3", "--images", "kept", "--device", "reference", "-o", "t.csv")
    text = (folder / "t.html").read_text()
    page = Page(text)
    size = len(text.encode()) - sum(map(len, page.pictures))
    if size > MOST_BYTES:
        sys.exit("%d bytes without pictures: must be at most %d" % (size, MOST_BYTES))
    for word in ("://", "javascript:", "@import"):
        if word in text:
            sys.exit("the page has %s" % word)
    check_policy(page, {"img-src": "data:"})
    check_links(page)
    check_pictures(page)
    # The table has ten digits, the command all: 1 + 4 · 3/7 has no end.
    for number in (0, 3 * SIDE + 2):
        check_command(program, folder, page, number)
    run(folder, program, "check", "rig 1.gltf", "--html", "rig.html")
    check_policy(Page((folder / "rig.html").read_text()), {})
    print("%d bytes without pictures, %d with" % (size, len(text.encode())))


main()
