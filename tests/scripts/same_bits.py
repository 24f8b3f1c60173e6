#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Every shipped scene, small, in both schedules, has the pixels that it had.

A change of structure must change no bit of an image. The digests of known devices lie in
same_bits.json, beside the commit that made them. Elsewhere the script builds that commit and
renders with it, too.

    same_bits.py PROGRAM            compare; exit code 1 where an image differs
    same_bits.py PROGRAM --write    write the digests of this device (after a mended fault,
                                    whose reason stands in the commit)
    same_bits.py PROGRAM --scenes caustic,prism    only these
"""

import argparse
import functools
import hashlib
import json
import pathlib
import struct
import subprocess
import sys
import tempfile
import zlib

ROOT = pathlib.Path(__file__).resolve().parents[2]
RECORD = pathlib.Path(__file__).with_suffix(".json")
PARTS_ONLY = {"2CylinderEngine"}  # a part, which scenes place: no scene of its own
SCHEDULES = ("tile", "stream")
OPTIONS = ["--spp", "16", "--replicates", "2", "--seed", "7", "--parts", "replicates", "--json"]
# Pixels, or macro pixels of 9 x 9 pixels.
RESOLUTIONS = {"lightField": "6x5"}
RESOLUTION = "24x18"
WRONG_USAGE = 2
MULTI_PART = 0x1000
ZIP = 3


def read_string(data, at):
    end = data.index(0, at)
    return data[at:end].decode(), end + 1


def read_header(data, at):
    """One part's attributes, and where they end."""
    attributes = {}
    while data[at]:
        name, at = read_string(data, at)
        _, at = read_string(data, at)
        (size,) = struct.unpack_from("<i", data, at)
        attributes[name] = data[at + 4 : at + 4 + size]
        at += 4 + size
    return attributes, at + 1


def pixels_digest(path):
    """Of the pixels of all parts, decompressed; headers hold times and versions and are left
    out."""
    data = path.read_bytes()
    if not struct.unpack_from("<i", data, 4)[0] & MULTI_PART:
        sys.exit(f"same_bits: {path}: expected an OpenEXR file of several parts")
    at, chunks, digest = 8, 0, hashlib.sha256()
    while data[at]:
        attributes, at = read_header(data, at)
        if attributes["compression"][0] != ZIP:
            sys.exit(f"same_bits: {path}: expected ZIP compression")
        chunks += struct.unpack("<i", attributes["chunkCount"])[0]
    at += 1 + 8 * chunks
    for _ in range(chunks):
        part, row, size = struct.unpack_from("<iii", data, at)
        chunk = data[at + 12 : at + 12 + size]
        try:
            chunk = zlib.decompress(chunk)
        except zlib.error:
            pass  # stored as it is, where that is shorter
        digest.update(struct.pack("<ii", part, row) + chunk)
        at += 12 + size
    return digest.hexdigest()[:16]


def scenes(names):
    found = sorted(
        p
        for p in (ROOT / "scenes").iterdir()
        if p.suffix in (".gltf", ".glb") and p.stem not in PARTS_ONLY
    )
    return [p for p in found if not names or p.stem in names]


@functools.cache
def light_paths_by_rule(program):
    """A pilot decides how many light paths a render has: here what they bring is compared."""
    known = subprocess.run(
        [program, "help", "render"], stdout=subprocess.PIPE, text=True, check=False
    ).stdout
    return (
        ["--light-paths", "on"] if "--light-paths" in known else []
    )  # older programs follow the rule


def render(program, scene, sensor, schedule, folder):
    """What the program says of a small image, whose digest is to be taken."""
    command = [
        program,
        "render",
        str(scene),
        "--sensor",
        sensor["name"],
        "--schedule",
        schedule,
        *OPTIONS,
    ]
    command += [*light_paths_by_rule(program), "-o", str(pathlib.Path(folder) / "image.exr")]
    small = ["--resolution", RESOLUTIONS.get(sensor["type"], RESOLUTION)]
    for options in (small, []):
        done = subprocess.run(
            command + options,
            stdout=subprocess.PIPE,
            stderr=subprocess.PIPE,
            text=True,
            check=False,
        )
        if done.returncode == 0:
            return json.loads(done.stdout)
        if (
            done.returncode != WRONG_USAGE
        ):  # sensors with a region of interest or binning keep their size
            break
    return sys.exit(
        f"same_bits: {' '.join(command)}: exit code {done.returncode}: {done.stderr.strip()}"
    )


def sensors(program, scene):
    check = subprocess.run(
        [program, "check", str(scene), "--json"], stdout=subprocess.PIPE, text=True, check=True
    )
    return json.loads(check.stdout)["sensors"]


def all_digests(program, names, tell):
    """{"device": {"scene sensor schedule": digest}} of one program."""
    device, digests = None, {}
    with tempfile.TemporaryDirectory() as folder:
        for scene in scenes(names):
            for sensor in sensors(program, scene):
                for schedule in SCHEDULES:
                    said = render(program, scene, sensor, schedule, folder)
                    device = said["device"]
                    key = f"{scene.stem} {sensor['name']} {schedule}"
                    digests[key] = pixels_digest(pathlib.Path(said["image"]))
                    tell(f"{key}: {digests[key]}")
    return device, digests


def build_base(commit):
    """The program of the recorded commit, in build/same_bits."""
    tree = ROOT / "build" / "same_bits"
    if not tree.exists():
        subprocess.run(
            ["git", "-C", str(ROOT), "worktree", "add", "--detach", str(tree), commit], check=True
        )
    subprocess.run(
        ["cmake", "--preset", "release", "-DMCV_TESTS=OFF"],
        cwd=tree,
        check=True,
        stdout=subprocess.DEVNULL,
    )
    subprocess.run(
        ["cmake", "--build", "--preset", "release", "--target", "mcvisi_program"],
        cwd=tree,
        check=True,
    )
    return str(tree / "build" / "release" / "mcvisi")


def main():
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("program")
    parser.add_argument("--write", action="store_true")
    parser.add_argument("--scenes", default="")
    arguments = parser.parse_args()
    names = set(filter(None, arguments.scenes.split(",")))
    record = json.loads(RECORD.read_text()) if RECORD.exists() else {"commit": "", "devices": {}}
    device, digests = all_digests(arguments.program, names, lambda line: print(line, flush=True))
    if arguments.write:
        commit = subprocess.run(
            ["git", "-C", str(ROOT), "rev-parse", "HEAD"],
            stdout=subprocess.PIPE,
            text=True,
            check=True,
        )
        record["commit"] = record["commit"] or commit.stdout.strip()
        record["devices"].setdefault(device, {}).update(digests)
        RECORD.write_text(json.dumps(record, indent=1, sort_keys=True) + "\n")
        return
    expected = record["devices"].get(device)
    if expected is None:
        print(f"no digests of {device}: building {record['commit']}", flush=True)
        base = build_base(record["commit"])
        known = {path.stem for path in (pathlib.Path(base).parents[2] / "scenes").glob("*.gl*")}
        names = {scene.stem for scene in scenes(names) if scene.stem in known}
        digests = {key: digest for key, digest in digests.items() if key.split()[0] in known}
        expected = all_digests(base, names, lambda line: None)[1] if names else {}
    differing = [key for key in digests if digests[key] != expected.get(key)]
    for key in differing:
        print(f"{key}: {digests[key]}, expected {expected.get(key)}")
    print(f"{len(digests)} images, {len(differing)} differ")
    sys.exit(1 if differing else 0)


if __name__ == "__main__":
    main()
