#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""What ./run lint does by clang: lint.py STEP... with the build folder of MCV_LINT_BUILD or
build/lint.

programs   every OpenCL program compiles for every set of features and every target
headers    every header and stage of kernels/ and include/ compiles by itself as OpenCL C
tidy       clang-tidy, for each file that the build folder's compile_commands.json compiles
few        headers, for three sets of features: the test

programs, headers and few read sets of features, a line of -D options each, from standard input.
What had no finding is kept in BUILD/clean under a hash of all that it was made from, so that
only what has changed is looked at again. System headers are not in the hash; without that folder
everything is looked at. Python's standard library only.
"""

import concurrent.futures
import hashlib
import json
import os
import pathlib
import re
import shlex
import subprocess
import sys

ROOT = pathlib.Path(__file__).resolve().parent.parent
BUILD = pathlib.Path(os.environ.get("MCV_LINT_BUILD", ROOT / "build" / "lint"))
CLEAN = BUILD / "clean"
TARGETS = (
    "x86_64-unknown-linux-gnu",
    "x86_64-unknown-linux-gnu -mavx2 -mfma",
    "x86_64-unknown-linux-gnu -march=skylake-avx512",
    "spir64",
)
OPENCL = [
    "clang",
    "-x",
    "cl",
    "-cl-std=CL1.2",
    "-O0",
    "-Wall",
    "-Wextra",
    "-Werror",
    "-Xclang",
    "-finclude-default-header",
    "-Xclang",
    "-fdeclare-opencl-builtins",
    "-I",
    "include",
    "-I",
    "kernels",
]
HOST_ONLY = {"mcvisi.h"}  # the C API

# Files that do not compile by themselves yet: an entry that compiles is a finding, too.
NOT_BY_THEMSELVES = set()


def run(command, text=None):
    return subprocess.run(command, cwd=ROOT, input=text, capture_output=True, text=True)


def digest(*parts):
    return hashlib.sha256("\0".join(parts).encode(errors="surrogateescape")).hexdigest()


def is_clean(key):
    return (CLEAN / key).exists()


def keep_clean(key):
    CLEAN.mkdir(parents=True, exist_ok=True)
    (CLEAN / key).touch()


def side_by_side(function, cases):
    with concurrent.futures.ThreadPoolExecutor(len(os.sched_getaffinity(0))) as pool:
        return list(pool.map(function, cases))


def include_closure(path, seen):
    """All files that a source may include, whatever its features are."""
    if path in seen:
        return seen
    seen.add(path)
    for name in re.findall(r'^\s*#\s*include "(.+)"', (ROOT / path).read_text(), re.M):
        for folder in (path.parent, pathlib.Path("include"), pathlib.Path("kernels")):
            if (ROOT / folder / name).is_file():
                include_closure(folder / name, seen)
                break
    return seen


class Source:
    """An OpenCL source and the features that it can depend on."""

    def __init__(self, path):
        self.path = path
        # What a header defines for others may be unused, and its parameters without a feature.
        header = path.suffix == ".h"
        self.text = f'#include "{path}"\n' if header else (ROOT / path).read_text()
        self.flags = ["-Wno-unused", "-Wno-unused-parameter"] if header else [f"-I{path.parent}"]
        self.closure = [(ROOT / p).read_text() for p in sorted(include_closure(path, set()))]
        self.features = set(re.findall(r"MCV_WITH_\w+", "".join(self.closure)))

    def relevant(self, defines):
        """The -D options without those of features that the source does not name."""
        return [
            d
            for d in shlex.split(defines)
            if not d.startswith("-DMCV_WITH_") or d[2:].split("=")[0] in self.features
        ]


class Compilation:
    """One source for one set of features and one target."""

    def __init__(self, source, defines, target, codegen):
        self.source, self.target = source, target
        self.flags = [*source.flags, "-target", *target.split(), *source.relevant(defines)]
        self.back = ["-emit-llvm", "-c", "-o", "/dev/null"] if codegen else ["-fsyntax-only"]
        self.inputs = digest("inputs", CLANG, *OPENCL, *self.back, *self.flags, *source.closure)
        self.key = self.inputs

    def prepare(self):
        """Features and targets change little of most programs: their key is of the preprocessed
        text."""
        if self.source.path.suffix == ".h":
            return
        found = run([*OPENCL, *self.flags, "-E", "-P", "-"], self.source.text)
        if found.returncode == 0:
            target = self.target if "-c" in self.back else ""
            self.key = digest("text", CLANG, *OPENCL, *self.back, target, found.stdout)

    def findings(self):
        found = run([*OPENCL, *self.flags, *self.back, "-"], self.source.text)
        if found.returncode == 0:
            keep_clean(self.key)
            return ""
        return f"{self.source.path} for {' '.join(self.flags)}\n{found.stderr}"


def compile_all(cases):
    """Compiles what differs and is not known to be clean: the failures, by file name."""
    fresh = {c.inputs: c for c in reversed(cases) if not is_clean(c.inputs)}
    side_by_side(Compilation.prepare, fresh.values())
    left = {c.key: c for c in fresh.values() if not is_clean(c.key)}
    found = side_by_side(Compilation.findings, left.values())
    failed = {}
    for c, text in zip(left.values(), found):
        if text:
            failed.setdefault(c.source.path.name, text)
    for c in fresh.values():
        if is_clean(c.key):
            keep_clean(c.inputs)
    print(f"   {len(cases)} compilations, {len(fresh)} of them not known, {len(left)} distinct")
    return failed


def program_names():
    lists = (ROOT / "CMakeLists.txt").read_text()
    return re.search(r"^set\(MCV_PROGRAMS ([^)]*)\)", lists, re.M).group(1).split()


def check_programs(feature_sets):
    programs = [pathlib.Path("kernels", f"{name}.cl") for name in program_names()]
    print(f"== OpenCL programs: {', '.join(program_names())}; {len(feature_sets)} sets of features")
    # Code generation refuses little that the front end does not: all targets for all features.
    fullest = max(d.count("=1") for d in feature_sets)
    failed = compile_all(
        [
            Compilation(s, d, t, d.count("=1") == fullest)
            for s in map(Source, programs)
            for d in feature_sets
            for t in TARGETS
        ]
    )
    print("".join(failed.values()), end="")
    return not failed


def check_headers(feature_sets, all_sets=True):
    programs = {f"{name}.cl" for name in program_names()}
    tree = [
        p.relative_to(ROOT)
        for folder in ("include", "kernels")
        for p in sorted((ROOT / folder).rglob("*"))
        if p.suffix in (".h", ".cl")
    ]
    paths = [
        p
        for p in tree
        if p.name not in HOST_ONLY and p.relative_to(p.parts[0]).as_posix() not in programs
    ]
    print(f"== {len(paths)} headers and stages by themselves; {len(feature_sets)} sets of features")
    failed = compile_all(
        [Compilation(s, d, TARGETS[0], False) for s in map(Source, paths) for d in feature_sets]
    )
    for name in sorted(set(failed) - NOT_BY_THEMSELVES):
        print(failed[name])
    stale = NOT_BY_THEMSELVES - set(failed) if all_sets else set()
    for name in sorted(stale):
        print(f"tools/lint.py: {name} compiles by itself, or is gone: take it off the list")
    return not stale and set(failed) <= NOT_BY_THEMSELVES


def check_few(feature_sets):
    """All features of the first two kinds of sensor, and none."""
    none = re.sub(r"(-DMCV_WITH_\w+)=1", r"\1=0", feature_sets[0])
    return check_headers([*feature_sets[:2], none], all_sets=False)


def tidy_key(entry):
    """All that clang-tidy sees of a file, or None."""
    command = shlex.split(entry["command"])
    at = command.index("-o")
    kept = command[1:at] + [c for c in command[at + 2 :] if c not in ("-c", entry["file"])]
    found = subprocess.run(
        ["clang", *kept, "-MM", "-MT", "x", entry["file"]],
        cwd=entry["directory"],
        capture_output=True,
        text=True,
    )
    if found.returncode != 0:
        return None
    seen = shlex.split(found.stdout.replace("\\\n", " "))[1:]
    read = [pathlib.Path(entry["directory"], p).read_text() for p in seen]
    settings = [p.read_text() for p in sorted(ROOT.glob("**/.clang-tidy"))]
    return digest("tidy", TIDY, *settings, entry["file"], *kept, *seen, *read)


def tidy(entry):
    key = tidy_key(entry)
    if key and is_clean(key):
        return ""
    found = run(["clang-tidy", "--quiet", "-p", str(BUILD), entry["file"]])
    if found.returncode != 0:
        return found.stdout + found.stderr
    if key:
        keep_clean(key)
    return ""


def check_tidy():
    known = set(run(["git", "ls-files", "*.c", "*.cpp"]).stdout.split())
    entries = json.loads((BUILD / "compile_commands.json").read_text())
    ours = {e["file"]: e for e in entries if os.path.relpath(e["file"], ROOT) in known}
    print(f"== clang-tidy: {len(ours)} of {len(known)} sources")
    for name in sorted(known - {os.path.relpath(f, ROOT) for f in ours}):
        print(f"   not compiled here: {name}")
    found = [text for text in side_by_side(tidy, ours.values()) if text]
    # Its count of warnings in system headers, which it does not show, is no news.
    print(re.sub(r"^\d+ warnings? .*generated\.\n", "", "".join(found), flags=re.M), end="")
    return not found


def main():
    steps = {"programs": check_programs, "headers": check_headers, "few": check_few}
    if not sys.argv[1:] or set(sys.argv[1:]) - set(steps) - {"tidy"}:
        sys.exit(__doc__)
    feature_sets = [] if sys.argv[1:] == ["tidy"] else sys.stdin.read().splitlines()
    results = [check_tidy() if s == "tidy" else steps[s](feature_sets) for s in sys.argv[1:]]
    sys.exit(0 if all(results) else 1)


def version(program):
    return run([program, "--version"]).stdout


if __name__ == "__main__":
    CLANG, TIDY = version("clang"), version("clang-tidy")
    main()
