#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Plants one fault at a time in a copy of the sources and runs the tests that should catch it.

Usage: tests/mutants/run.py [K/N] [--only TEXT]

mutants.toml says what is planted where; README.md beside it says what each test guards.
Python's standard library only.
"""

import argparse
import concurrent.futures
import fcntl
import fnmatch
import os
import pathlib
import queue
import re
import resource
import shutil
import signal
import subprocess
import sys
import threading
import time
import tomllib

HERE = pathlib.Path(__file__).resolve().parent
ROOT = HERE.parent.parent
WORK = ROOT / "build" / "mutants"
# What a copy needs to build the library, the program and the tests, and what the tests read.
COPIED = [
    "CMakeLists.txt",
    "CMakePresets.json",
    "README.md",
    "run",
    "docs",
    "host",
    "include",
    "kernels",
    "scenes",
    "tests",
    "tools",
]
DEVICE = (
    "kernels",
    "include",
)  # read by OpenCL's compiler at run time: nothing is built for a fault there
SECONDS = 300  # for one test


def pattern_of(text):
    """The text as it may stand in a source, however its lines are broken: in macros, too."""
    words = re.findall(r"\w+|[^\w\s]", text)
    gaps = [
        r"[\s\\]+" if a[-1].isalnum() and b[0].isalnum() else r"[\s\\]*"
        for a, b in zip(words, words[1:])
    ]
    return re.compile("".join(re.escape(w) + g for w, g in zip(words, gaps + [""])))


class Mutant:
    """A fault: a text, which occurs `times` times in the folder or file `where`, and its
    replacement. `built`: it is planted in what the tests themselves compile, not for the device."""

    def __init__(self, entry):
        known = {"name", "find", "replace", "where", "times", "tests", "built"}
        if unknown := set(entry) - known:
            raise ValueError(f"{entry.get('name')}: unknown key {', '.join(sorted(unknown))}")
        self.name, self.find, self.replace = entry["name"], entry["find"], entry["replace"]
        self.where, self.times, self.tests = entry["where"], entry.get("times", 1), entry["tests"]
        self.built = entry.get("built", False)
        self.pattern = pattern_of(self.find)
        if not self.tests or self.find == self.replace:
            raise ValueError(
                f"{self.name}: a fault needs tests, and a replacement that differs from the text"
            )

    @property
    def on_device(self):
        return not self.built and (
            self.where.split("/")[0] in DEVICE or self.where == "device"
        )

    def files(self, tree):
        """The files that hold the text, each with how often."""
        folders = DEVICE if self.where == "device" else (self.where,)
        paths = [
            p
            for f in folders
            for p in ([tree / f] if (tree / f).is_file() else sorted((tree / f).rglob("*.*")))
        ]
        found = [
            (p, len(self.pattern.findall(p.read_text())))
            for p in paths
            if p.suffix in (".c", ".cpp", ".h", ".cl")
        ]
        found = [(p, count) for p, count in found if count]
        total = sum(count for _, count in found)
        if total != self.times:
            raise LookupError(
                f'"{self.find}" is found {total} times in {self.where}, not {self.times}'
                + "".join(f"; {p.relative_to(tree)}: {c}" for p, c in found)
            )
        return [p for p, _ in found]


def test_text(path):
    """A test program's source, with the files beside it that it includes."""
    text = path.read_text()
    beside = [path.parent / name for name in re.findall(r'^#include "([^"/]+\.c)"', text, re.M)]
    return text + "".join(p.read_text() for p in beside)


def is_test(name):
    """Whether a program of that name, and the functions that the pattern behind it names, exist."""
    program, _, pattern = name.partition(":")
    sources = list((ROOT / "tests").glob(f"*/{program}.c"))
    functions = [
        t for p in sources for t in re.findall(r"cmocka_unit_test\w*\((\w+)", test_text(p))
    ]
    return bool(sources) and (not pattern or bool(fnmatch.filter(functions, pattern)))


def read_mutants(path):
    entries = tomllib.loads(path.read_text())["mutant"]
    mutants = [Mutant(e) for e in entries]
    names = [m.name for m in mutants]
    if doubled := {n for n in names if names.count(n) > 1}:
        raise ValueError(f'{path}: two mutants are called "{doubled.pop()}"')
    return mutants


class Worker:
    """A copy of the sources with a build folder of its own."""

    def __init__(self, number, jobs):
        self.tree = WORK / f"tree-{number}"
        self.device = WORK / f"device-{number}"
        self.build = self.tree / "build" / "release"
        self.jobs = jobs
        self.environment = dict(
            os.environ,
            CCACHE_BASEDIR=str(self.tree),
            CCACHE_NOHASHDIR="1",
            POCL_CACHE_DIR=str(WORK / "programs"),
            LC_ALL="C.UTF-8",
        )

    def prepare(self, targets):
        """Updates the copy: only files whose text differs, so that the others stay built."""
        for name in COPIED:
            mirror(ROOT / name, self.tree / name)
        for name in DEVICE:
            mirror(ROOT / name, self.device / name)
        configure = ["cmake", "--preset", "release", "-DMCV_TESTS=ON", "-DMCV_BENCH=OFF"]
        # A fault may leave a parameter, a function or a variable without a use.
        unused = ("parameter", "function", "variable", "but-set-variable", "const-variable")
        flags = " ".join(f"-Wno-error=unused-{kind}" for kind in unused)
        configure += [f"-DCMAKE_C_FLAGS={flags}", f"-DCMAKE_CXX_FLAGS={flags}"]
        if shutil.which("ccache"):
            configure += [
                "-DCMAKE_C_COMPILER_LAUNCHER=ccache",
                "-DCMAKE_CXX_COMPILER_LAUNCHER=ccache",
            ]
        for command in (configure, self.build_command(targets)):
            done = self.run(command, self.tree)
            if done.returncode:
                sys.exit(f"{' '.join(command)} failed in {self.tree}:\n{done.stdout[-4000:]}")

    def build_command(self, targets):
        return ["cmake", "--build", str(self.build), "-j", str(self.jobs), "--target", *targets]

    def run(self, command, folder, **more):
        """Runs a command in its own process group, so that all of it ends when its time is over."""
        with subprocess.Popen(
            command,
            cwd=folder,
            env=dict(self.environment, **more),
            stdout=subprocess.PIPE,
            stderr=subprocess.STDOUT,
            text=True,
            errors="replace",
            start_new_session=True,
        ) as process:
            try:
                out, _ = process.communicate(timeout=SECONDS)
            except subprocess.TimeoutExpired:
                os.killpg(process.pid, signal.SIGKILL)
                out, _ = process.communicate()
            return subprocess.CompletedProcess(command, process.returncode, out)

    def test(self, test, on_device):
        """Whether the test passes, and why not. It must run: an empty filter would pass."""
        program, _, pattern = test.partition(":")
        more = {"MCVISI_TEST_FILTER": pattern}
        if on_device:
            more["MCVISI_KERNEL_DIR"] = str(self.device)
        done = self.run([str(self.build / "tests" / program)], self.build / "tests", **more)
        count = re.search(r"Running (\d+) test", done.stdout)
        if not count or int(count[1]) == 0:
            return None, f"{test} runs no test: {last_words(done.stdout)}"
        return done.returncode == 0, last_words(done.stdout)

    def try_mutant(self, mutant):
        """The verdict, by which test, and what it says."""
        tree = self.device if mutant.on_device else self.tree
        try:
            files = mutant.files(tree)
        except LookupError as why:
            return "NOT PLANTED", "", str(why)
        before = {p: p.read_text() for p in files}
        try:
            for path, text in before.items():
                path.write_text(mutant.pattern.sub(lambda _: mutant.replace, text))
            if not mutant.on_device:
                done = self.run(self.build_command(targets_of([mutant])), self.tree)
                if done.returncode:
                    return "NOT BUILT", "", first_error(done.stdout)
            for test in mutant.tests:
                passed, words = self.test(test, mutant.on_device)
                if "clBuildProgram" in words:
                    return "NOT BUILT", test, words
                if passed is None:
                    return "NO TEST", test, words
                if not passed:
                    return "killed", test, words
            return "SURVIVED", "", ""
        finally:
            for path, text in before.items():
                path.write_text(text)


def mirror(source, target):
    """Makes target what source is; files that are equal keep their time."""
    if source.is_file():
        target.parent.mkdir(parents=True, exist_ok=True)
        if not target.exists() or target.read_bytes() != source.read_bytes():
            shutil.copy(source, target)
        return
    target.mkdir(parents=True, exist_ok=True)
    names = {p.name for p in source.iterdir() if p.name != "__pycache__"}
    for gone in [p for p in target.iterdir() if p.name not in names]:
        shutil.rmtree(gone) if gone.is_dir() else gone.unlink()
    for name in names:
        mirror(source / name, target / name)


def targets_of(mutants):
    """The tests' programs, and the program that some of them run."""
    return ["mcvisi_program", *sorted({t.partition(":")[0] for m in mutants for t in m.tests})]


def last_words(text):
    """What a failed test says: its message, else its last line."""
    lines = [line.strip() for line in text.splitlines() if line.strip()]
    told = [
        line
        for line in lines
        if re.match(r"\[\s+(ERROR|LINE)\s+\]|Error:|.*(clBuildProgram| != | not )", line)
    ]
    words = next(
        (re.sub(r"\[\s+\w+\s+\] (--- )?", "", t) for t in told), lines[-1] if lines else ""
    )
    return words[:200]


def first_error(text):
    return next((line for line in text.splitlines() if "error" in line), text[-200:])


def control(worker, mutants):
    """Without a fault, each named test must pass: for faults of the host without MCVISI_KERNEL_DIR,
    for those of the device with it."""
    wanted = dict.fromkeys((t, m.on_device) for m in mutants for t in m.tests)
    failed = 0
    for test, on_device in wanted:
        begun, used = time.monotonic(), processor_seconds()
        passed, words = worker.test(test, on_device)
        print(
            f"  {'passes' if passed else 'FAILS '} {time.monotonic() - begun:6.1f} s,"
            f" {processor_seconds() - used:6.1f} s of processor"
            f" {'device ' if on_device else 'host   '} {test}{'' if passed else ': ' + words}",
            flush=True,
        )
        failed += not passed
    return failed


def processor_seconds():
    used = resource.getrusage(resource.RUSAGE_CHILDREN)
    return used.ru_utime + used.ru_stime


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("part", nargs="?", default="1/1", help="K/N: of N parts the K-th")
    parser.add_argument(
        "--only",
        action="append",
        metavar="PATTERN",
        help="mutants whose names match (* and ?); may be repeated",
    )
    parser.add_argument(
        "--where", default="*", metavar="PATTERN", help="those whose `where` matches: device, host*"
    )
    parser.add_argument(
        "--workers",
        type=int,
        default=os.cpu_count(),
        metavar="N",
        help="copies of the sources that work at once",
    )
    parser.add_argument(
        "--list", action="store_true", help="check that every text and test is found, and end"
    )
    parser.add_argument(
        "--no-control", action="store_true", help="leave out the tests without a fault"
    )
    arguments = parser.parse_args()
    match = re.fullmatch(r"(\d+)/(\d+)", arguments.part)
    if not match or not 1 <= int(match[1]) <= int(match[2]):
        sys.exit(f"mutants: '{arguments.part}' is no part: K/N with 1 <= K <= N")
    part, parts = int(match[1]), int(match[2])
    try:
        mutants = read_mutants(HERE / "mutants.toml")
    except (ValueError, KeyError, tomllib.TOMLDecodeError) as why:
        sys.exit(f"mutants: mutants.toml: {why}")
    only = arguments.only or ["*"]
    mutants = [
        m
        for m in mutants
        if any(fnmatch.fnmatchcase(m.name, o) for o in only)
        and fnmatch.fnmatchcase(m.where, arguments.where)
    ]
    # Faults of the device come first, because they need no build: a fault of the host stays built
    # until the next build.
    mutants = sorted(mutants[part - 1 :: parts], key=lambda m: not m.on_device)
    lost = 0
    for mutant in mutants:
        try:
            files = mutant.files(ROOT)
            if arguments.list:
                print(f"{mutant.name}: {', '.join(str(p.relative_to(ROOT)) for p in files)}")
            for test in mutant.tests:
                if not is_test(test):
                    raise LookupError(f"there is no test {test}")
        except (LookupError, OSError) as why:
            print(f"{mutant.name}: {why}")
            lost += 1
    if lost or arguments.list or not mutants:
        sys.exit(f"mutants: {lost} cannot be planted" if lost else None)

    WORK.mkdir(parents=True, exist_ok=True)
    lock = open(WORK / "lock", "w")
    try:
        fcntl.flock(lock, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except OSError:
        sys.exit(f"mutants: another run works in {WORK}")
    begun = time.monotonic()
    count = max(1, min(arguments.workers, len(mutants)))
    jobs = max(1, (os.cpu_count() or 1) // count)
    idle = queue.SimpleQueue()
    workers = [Worker(i, jobs) for i in range(count)]
    with concurrent.futures.ThreadPoolExecutor(count) as pool:
        list(pool.map(lambda w: w.prepare(targets_of(mutants)), workers))
    print(
        f"== {count} {'copy' if count == 1 else 'copies'}"
        f" built in {time.monotonic() - begun:.0f} s",
        flush=True,
    )
    if not arguments.no_control:
        print("== no fault", flush=True)
        if failed := control(workers[0], mutants):
            sys.exit(f"mutants: {failed} tests fail without a fault: nothing can be said")

    for worker in workers:
        idle.put(worker)
    said = threading.Lock()

    def job(mutant):
        worker, start = idle.get(), time.monotonic()
        try:
            verdict, test, words = worker.try_mutant(mutant)
        finally:
            idle.put(worker)
        with said:
            print(
                f"{verdict:11} {time.monotonic() - start:6.1f} s  "
                f"{mutant.name}: {test}{': ' if words and test else ''}{words}",
                flush=True,
            )
        return verdict

    print(f"== {len(mutants)} faults", flush=True)
    with concurrent.futures.ThreadPoolExecutor(count) as pool:
        verdicts = list(pool.map(job, mutants))
    killed = verdicts.count("killed")
    print(f"== {killed} of {len(mutants)} are caught, in {time.monotonic() - begun:.0f} s")
    for mutant, verdict in zip(mutants, verdicts):
        if verdict != "killed":
            print(f"   {verdict}: {mutant.name}")
    sys.exit(killed != len(mutants))


if __name__ == "__main__":
    main()
