#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Run the commands of a tutorial and compare what the page says with what they print and draw.

tutorials.py MCVISI SOURCES PAGE.md FOLDER [--pictures]

Every block fenced as `sh` is run in turn in the empty FOLDER, with the program in PATH and the
sources in $MCVISI. The page is held against the output in five ways.

- A block fenced as `text` is an excerpt of what the block before it printed: each of its lines
  stands there, in this order. Words are the same. A number `V ± U` is off by U at most. Another
  number is off by 1 % at most: the same seed gives the same noise, but each device rounds in its
  own way. A line `…` leaves lines out.
- `V ± U <!-- measured PATTERN -->`: the first group of PATTERN in all output so far is V, to U.
  `± U %` is of V. The last match counts.
- `V <!-- known PATTERN -->`: V follows from geometry. The first group is V, to 4 times the standard
  uncertainty in the second group; a right program misses that once in 16 000 figures. `V ± U` adds
  U, the share of what the geometry leaves out. `measured x1000 PATTERN` and `known x1000 PATTERN`
  multiply what came out by 1000.
- `V <!-- formula EXPRESSION -->`: V is the value of a Python expression, rounded as V is.
- `<!-- needs MODULE -->`: a module of Python that the commands need, of the system or of
  `./run deps peers`. The page is skipped where it is missing.
- A picture `![…](STEM/F.png)` is what the commands left in F.png, in the mean to 3 of 255 levels,
  and below 200 kB. With --pictures the pictures of the page are made anew.
"""
import math
import os
import re
import resource
import shutil
import struct
import subprocess
import sys
import zlib

NUMBER = r"[-+]?(?:\d+\.?\d*|\.\d+)(?:e[-+]?\d+)?"
LARGEST_PICTURE = 200_000
FEWEST_FIGURES = 4
FEWEST_KNOWN = 1

failures = []


def check(fine, message):
    print(("  fine  " if fine else "  WRONG ") + message)
    if not fine:
        failures.append(message)


def is_number(word):
    return re.fullmatch(NUMBER, word) is not None


def alike(expected, line):
    """Whether a line of an excerpt is this line of the output."""
    token = NUMBER + r"(?![\w])|\S+?(?=[,;:]?(?:\s|$))|\S"
    a, b = (re.findall(token, text) for text in (expected, line))
    if len(a) != len(b):
        return False
    for i, (mine, theirs) in enumerate(zip(a, b)):
        if not (is_number(mine) and is_number(theirs)):
            if mine != theirs:
                return False
            continue
        if a[i + 1:i + 2] == ["±"] and is_number(a[i + 2]):
            bound = float(a[i + 2])
        elif a[i - 1:i] == ["±"]:
            # Of an uncertainty one digit may round away.
            bound = 0.2 * abs(float(mine))
        else:
            bound = 0.01 * abs(float(mine))
        # Half of the last digit that the page shows.
        digits = len(mine.split("e")[0].partition(".")[2])
        if not abs(float(mine) - float(theirs)) <= bound + 0.5 * 10.0 ** -digits:
            return False
    return True


def check_excerpt(text, output):
    """Lines in order; an excerpt is of the output of the block before it."""
    lines = output.splitlines()
    at = 0
    for expected in text.splitlines():
        if not expected.strip() or expected.strip() == "…":
            continue
        found = next((i for i in range(at, len(lines)) if alike(expected, lines[i])), None)
        check(found is not None, "the output has the line: " + " ".join(expected.split()))
        if found is not None:
            at = found + 1


def stated_before(text):
    """The last number before a marker, and what the page gives as its uncertainty, or None."""
    # A unit may stand before the uncertainty.
    pattern = r"(?<![\w.])(%s)(?:\s*[^\s\d±<]{,8}\s*±\s*(%s)\s*(%%)?)?" % (NUMBER, NUMBER)
    pairs = list(re.finditer(pattern, text[-120:]))
    if not pairs:
        sys.exit("no number before a marker: " + text[-120:])
    value, error, percent = pairs[-1].groups()
    if error is None:
        return value, None
    return value, float(error) * (abs(float(value)) / 100 if percent else 1)


def check_figure(kind, argument, before, output):
    # Of two markers in a row both are of the number before them.
    text, error = stated_before(re.sub(r"<!--.*?-->", "", before[-1000:], flags=re.DOTALL))
    value = float(text)
    if kind == "formula":
        predicted = eval(argument, {"__builtins__": {}}, vars(math))  # the page is ours
        digits = len(text.partition(".")[2])
        check(abs(value - predicted) <= 0.500001 * 10.0 ** -digits,
              "%s = %s is %.6g" % (text, argument, predicted))
        return
    factor, argument = re.fullmatch(r"(?:x(%s) )?(.*)" % NUMBER, argument, re.DOTALL).groups()
    found = re.findall(argument, output, re.MULTILINE | re.DOTALL)
    if not found:
        check(False, "the output has no %s" % argument)
        return
    groups = found[-1] if isinstance(found[-1], tuple) else (found[-1],)
    came_out, sigma = (float(group) * float(factor or 1) for group in (groups + ("0",))[:2])
    if kind == "measured":
        if error is None:
            sys.exit("no uncertainty before: " + argument)
        bound = error
    else:
        bound = 4 * sigma + (error or 0)
    check(abs(came_out - value) <= bound,
          "%s %s ± %.3g, came out as %.6g (%s)" % (kind, text, bound, came_out, argument))


def pixels_of(path):
    """Width, height, bytes a pixel and the bytes of a PNG of 8 bits without interlace."""
    data = open(path, "rb").read()
    width, height, bits, colour, _, _, interlace = struct.unpack(">IIBBBBB", data[16:29])
    size = {0: 1, 2: 3, 4: 2, 6: 4}.get(colour)
    if bits != 8 or interlace or not size:
        sys.exit("%s: only PNG of 8 bits" % path)
    packed, at = b"", 8
    while at < len(data):
        length, kind = struct.unpack(">I4s", data[at:at + 8])
        if kind == b"IDAT":
            packed += data[at + 8:at + 8 + length]
        at += length + 12
    raw, rows, above = zlib.decompress(packed), [], bytes(width * size)
    for j in range(height):
        way = raw[j * (width * size + 1)]
        row = bytearray(raw[j * (width * size + 1) + 1:(j + 1) * (width * size + 1)])
        if way:
            for i in range(len(row)):
                a, b = row[i - size] if i >= size else 0, above[i]
                if way == 4:
                    c = above[i - size] if i >= size else 0
                    p = a + b - c
                    a = min((abs(p - a), 0, a), (abs(p - b), 1, b), (abs(p - c), 2, c))[2]
                row[i] = row[i] + (a, b, (a + b) // 2, a)[way - 1] & 255
        rows.append(bytes(row))
        above = row
    return width, height, size, b"".join(rows)


def check_picture(committed, made):
    name = os.path.basename(made)
    if not os.path.exists(made) or not os.path.exists(committed):
        check(False, "%s is made by the commands and stands in the documentation" % name)
        return
    size = os.path.getsize(committed)
    check(size <= LARGEST_PICTURE, "%s has %d bytes" % (name, size))
    a, b = pixels_of(committed), pixels_of(made)
    off = sum(abs(x - y) for x, y in zip(a[3], b[3])) / len(a[3]) if a[:3] == b[:3] else 255
    check(off <= 3, "%s is the picture that the commands make: off by %.2f levels" % (name, off))


def check_pictures(page, text, again):
    for link in re.findall(r"!\[[^]]*\]\(([^)]+\.png)\)", text):
        committed, made = os.path.join(os.path.dirname(page), link), os.path.basename(link)
        if again:
            os.makedirs(os.path.dirname(committed), exist_ok=True)
            shutil.copyfile(made, committed)
        check_picture(committed, made)


def run_block(block, environment):
    result = subprocess.run(["sh", "-e", "-c", block], env=environment, text=True,
                            stdout=subprocess.PIPE, stderr=subprocess.STDOUT)
    print(block + result.stdout)
    if result.returncode != 0:
        sys.exit("exit code %d of:\n%s" % (result.returncode, block))
    return result.stdout


def run_page(text, environment):
    """Blocks, excerpts and figures in the order of the page."""
    output = last = ""
    figures = {"measured": 0, "known": 0, "formula": 0}
    parts = r"^```(\w+)\n(.*?)^```$|<!-- (measured|known|formula) (.*?) -->"
    for match in re.finditer(parts, text, re.MULTILINE | re.DOTALL):
        fence, block, kind, argument = match.groups()
        if fence == "sh":
            last = run_block(block, environment)
            output += last
        elif fence == "text":
            check_excerpt(block, last)
        elif kind:
            figures[kind] += 1
            check_figure(kind, argument, text[:match.start()], output)
    return figures


def find_module(module, sources, environment):
    """Puts a python3 that has the module into PATH; ends the test as skipped where none has."""
    peers = os.path.join(sources, "build", "peers", "bin")
    for folder in ("", peers):
        path = folder + os.pathsep + environment["PATH"] if folder else environment["PATH"]
        tried = dict(environment, PATH=path)
        if subprocess.run(["python3", "-c", "import " + module], env=tried, cwd="/",
                          stderr=subprocess.DEVNULL).returncode == 0:
            environment["PATH"] = path
            return
    print("skipped: Python has no %s: `./run deps peers` installs it" % module)
    sys.exit(0)


def main():
    arguments = [word for word in sys.argv[1:] if word != "--pictures"]
    program, sources, page, folder = (os.path.abspath(word) for word in arguments)
    shutil.rmtree(folder, ignore_errors=True)
    os.makedirs(folder)
    os.chdir(folder)
    environment = dict(os.environ, MCVISI=sources, LC_ALL="C.UTF-8")
    environment["PATH"] = os.path.dirname(program) + os.pathsep + environment["PATH"]
    text = open(page, encoding="utf-8").read()
    for module in re.findall(r"<!-- needs (\w+) -->", text):
        find_module(module, sources, environment)
    figures = run_page(text, environment)
    # A page whose markers were lost would pass unseen.
    count = sum(figures.values())
    check(count >= FEWEST_FIGURES, "%d figures are held against the output" % count)
    check(figures["known"] >= FEWEST_KNOWN, "%d figures follow from geometry" % figures["known"])
    check_pictures(page, text, "--pictures" in sys.argv)
    used = resource.getrusage(resource.RUSAGE_CHILDREN)
    print("%.1f s of processor time" % (used.ru_utime + used.ru_stime))
    if failures:
        sys.exit("the page says otherwise:\n  " + "\n  ".join(failures))


if __name__ == "__main__":
    main()
