#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""The shared library exports what the public header declares: symbols.py LIBRARY HEADER.

- The exported symbols are the functions with MCV_API, no more and no less.
- Data that can be written is what KEPT lists: the library has no state of its own beside.

The second is not asked of a build with sanitizers, which add their own.
"""
import re
import subprocess
import sys

# Names of writable data, each with its reason.
KEPT = {
    "cache": "compiled programs of the process, behind a lock (host/cl/program_cache.c)",
}
# What compiler and linker put there; _ZStL8__ioinit is that of <iostream>, which headers of OpenEXR
# include.
OF_COMPILER = re.compile(r"^(__|_ZStL8__ioinit$|_GLOBAL_|DW\.ref\.|completed\.\d+$|\.(data|bss)$)")


def output(*command):
    return subprocess.run(command, check=True, capture_output=True, text=True).stdout


def declared(header):
    with open(header, encoding="utf-8") as file:
        text = re.sub(r"/\*.*?\*/", "", file.read(), flags=re.S)
    return set(re.findall(r"\bMCV_API\b[^;(]*?\b(mcv_\w+)\s*\(", text))


def exported(library):
    lines = output("nm", "-D", "--defined-only", library).splitlines()
    return {line.split()[-1].split("@")[0] for line in lines if line.split()[-2] != "A"}


def writable(library):
    """Objects in .data and .bss."""
    found = set()
    for line in output("objdump", "-t", library).splitlines():
        match = re.match(r"^[0-9a-f]+ .{7} (\.data|\.bss)\s+[0-9a-f]+\s+(?:\.hidden )?(\S+)$", line)
        if match and not OF_COMPILER.match(match.group(2)):
            found.add(match.group(2))
    return found


def main(library, header):
    failures = []
    wanted, got = declared(header), exported(library)
    if len(wanted) < 30:
        failures.append("%s: only %d functions were found: is the header read right?" %
                        (header, len(wanted)))
    failures += ["%s: is declared and not exported" % name for name in sorted(wanted - got)]
    failures += ["%s: is exported and not declared" % name for name in sorted(got - wanted)]
    if "__asan_init" not in output("nm", "-D", library):
        data = writable(library)
        failures += ["%s: is data that can be written: the library must have no such state" % name
                     for name in sorted(data - set(KEPT))]
        failures += ["%s: is no longer there: take it off KEPT" % name
                     for name in sorted(set(KEPT) - data)]
    for failure in failures:
        print(failure, file=sys.stderr)
    print("%d functions, %d findings" % (len(got), len(failures)))
    return 1 if failures else 0


if __name__ == "__main__":
    sys.exit(main(*sys.argv[1:]))
