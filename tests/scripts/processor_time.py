#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Processor time of each quick test on PoCL, and the share of it that compiling kernels takes.

    tests/scripts/processor_time.py BUILD [TABLE] [--tests REGEX] [--cache FOLDER]

Each test runs alone, on one thread, with a cache of kernels that the run shares from an empty
start: so a cold ./run test meets it. A test that compiled something runs a second time. The
difference is the time of compiling. TABLE gets a line per test: name, seconds cold, seconds warm,
new programs.
"""
import argparse
import json
import os
import pathlib
import re
import resource
import signal
import subprocess
import sys
import tempfile


def quick_tests(build, pattern):
    listing = subprocess.run(["ctest", "--test-dir", build, "--show-only=json-v1", "-LE", "^slow$"],
                             check=True, capture_output=True, text=True).stdout
    for test in json.loads(listing)["tests"]:
        if "command" in test and re.search(pattern, test["name"]):
            yield test["name"], test["command"], {p["name"]: p["value"] for p in test["properties"]}


def programs(cache):
    return sum(1 for _ in pathlib.Path(cache).rglob("program.bc"))


def hear_signals():
    """A shell in the background ignores these, and so would the tests, which send them."""
    for number in (signal.SIGHUP, signal.SIGINT, signal.SIGQUIT):
        signal.signal(number, signal.SIG_DFL)


def run(command, properties, cache):
    """Seconds of the test and of the processes that it started, and whether it passed."""
    environment = dict(os.environ, POCL_CACHE_DIR=cache, POCL_MAX_PTHREAD_COUNT="1")
    environment.update(pair.split("=", 1) for pair in properties.get("ENVIRONMENT", []))
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    done = subprocess.run(command, cwd=properties["WORKING_DIRECTORY"], env=environment,
                          check=False, stdin=subprocess.DEVNULL, capture_output=True,
                          preexec_fn=hear_signals)
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    return after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime, done.returncode == 0


def measure(tests, cache, table):
    for name, command, properties in tests:
        known = programs(cache)
        cold, passed = run(command, properties, cache)
        new = programs(cache) - known
        warm = min(run(command, properties, cache)[0], cold) if new else cold
        print(f"{name:32} {cold:7.2f} {warm:7.2f} {new:4d}{'' if passed else '  FAILED'}",
              file=table, flush=True)
        yield name, cold, warm, new


def main():
    parser = argparse.ArgumentParser(description=__doc__,
                                     formatter_class=argparse.RawTextHelpFormatter)
    parser.add_argument("build")
    parser.add_argument("table", nargs="?", type=argparse.FileType("w"), default=sys.stdout)
    parser.add_argument("--tests", default="", metavar="REGEX")
    parser.add_argument("--cache", metavar="FOLDER", help="kept kernels to begin with")
    arguments = parser.parse_args()
    with tempfile.TemporaryDirectory() as empty:
        rows = list(measure(quick_tests(arguments.build, arguments.tests), arguments.cache or empty,
                            arguments.table))
    cold = sum(row[1] for row in rows)
    warm = sum(row[2] for row in rows)
    print(f"{len(rows)} tests: {cold:.0f} s of processor time, {warm:.0f} s with kept kernels, "
          f"{sum(row[3] for row in rows)} programs; compiling takes "
          f"{(cold - warm) / max(cold, 1e-9):.0%}")


if __name__ == "__main__":
    main()
