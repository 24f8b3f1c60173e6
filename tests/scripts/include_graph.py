#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Do includes between folders go one way, and are the files of a size to read?

    include_graph.py SOURCES    prints the graph of folders, lowest first, and what is wrong
    include_graph.py --planted  plants each fault in a small tree, and sees that it is found

The standard library alone. What is wrong:

- a circle of includes between the folders of host/, include/ and kernels/, told with its files;
- an include of host/cli outside of host/cli: the library does not know the command line;
- an include in host/cli of anything but mcvisi/mcvisi.h, itself, the option list (host/options) and
  its ground (host/core): the command line is a client of the public header;
- an include that leads to no file;
- a file of host/ or include/ above 400 lines, of kernels/ above 250, test programs not counted; the
  public header is one file for those who use it, and may have 800;
- a line above 100 columns;
- a function of host/ or kernels/ above 60 lines, test programs not counted; in include/ lists stand
  for most functions.
"""

import pathlib
import re
import sys
import tempfile

MOST_LINES = {"host": 400, "include": 400, "kernels": 250}
MOST_COLUMNS = 100
MOST_FUNCTION_LINES = 60
PUBLIC = "mcvisi/mcvisi.h"
CLIENT = ("host/options", "host/core")  # folders that host/cli may include from
SUFFIXES = (".c", ".h", ".cl", ".cpp")
INCLUDE = re.compile(r'^\s*#\s*include\s+"([^"]+)"', re.M)
# What may hold a brace that ends nothing: comments keep their lines, and strings are emptied.
IGNORED = re.compile(r'/\*.*?\*/|//[^\n]*|"(?:\\.|[^"\\\n])*"|\'(?:\\.|[^\'\\\n])*\'', re.S)


def functions(text):
    """(name, first line, lines) of each function, from its first word to its brace, as clang-format
    sets it: both begin a line."""
    blank = IGNORED.sub(lambda found: re.sub(r"[^\n]", " ", found[0]), text)
    head = []  # the lines of a declaration so far
    opened = None
    for number, line in enumerate(blank.splitlines(), 1):
        if opened:
            if line.startswith("}"):
                yield opened[0], opened[1], number - opened[1] + 1
                opened = None
            continue
        if not line.strip() or line.startswith(("#", "}")):
            head = []
            continue
        head.append((number, line))
        words = " ".join(line for _, line in head)
        if line.rstrip().endswith("{") and not words.startswith(("typedef", "extern")):
            name = re.search(r"(\w+)\s*\((?:[^()]|\([^()]*\))*\)\s*\{$", words.rstrip())
            if name:
                opened = name[1], head[0][0]
        if line.rstrip().endswith((";", "{", "\\")):
            head = []


class Tree:
    """The sources below a folder, and what is wrong with them."""

    def __init__(self, root):
        self.root = pathlib.Path(root)
        self.failures = []
        self.edges = {}  # folder: {folder: (file, include)}
        self.files = sorted(
            path for top in MOST_LINES for path in (self.root / top).rglob("*")
            if path.suffix in SUFFIXES)
        if not self.files:
            self.fail("%s: there are no sources" % root)
        for path in self.files:
            self.read(path)

    def fail(self, what):
        self.failures.append(what)

    def folder(self, path):
        """host/NAME, include or kernels: the node of a file."""
        parts = path.relative_to(self.root).parts
        return "/".join(parts[:2]) if parts[0] == "host" and len(parts) > 2 else parts[0]

    def read(self, path):
        name = path.relative_to(self.root).as_posix()
        text = path.read_text(encoding="utf-8")
        lines = text.splitlines()
        if not name.startswith("kernels/test/"):
            most = MOST_LINES[name.split("/")[0]]
            self.measure(name, "lines", len(lines), 800 if name == "include/" + PUBLIC else most)
        widest = max(map(len, lines), default=0)
        if widest > MOST_COLUMNS:
            number = 1 + next(i for i, line in enumerate(lines) if len(line) > MOST_COLUMNS)
            self.measure("%s:%d" % (name, number), "columns", widest, MOST_COLUMNS)
        if not name.startswith(("kernels/test/", "include/")):
            for function, number, size in functions(text):
                self.measure("%s:%d: %s" % (name, number, function), "lines", size,
                             MOST_FUNCTION_LINES)
        for include in INCLUDE.findall(text):
            self.add(path, name, include)

    def measure(self, name, what, size, most):
        if size > most:
            self.fail("%s: has %d %s: must have at most %d" % (name, size, what, most))

    def add(self, path, name, include):
        places = (path.parent, self.root / "include", self.root / "host", self.root / "kernels",
                  self.root)
        found = next((p / include for p in places if (p / include).is_file()), None)
        if found is None:
            self.fail('%s: includes "%s", which is no file' % (name, include))
            return
        source, target = self.folder(path), self.folder(found.resolve())
        if source == target:
            return
        self.edges.setdefault(source, {}).setdefault(target, (name, include))
        if source == "host/cli" and target not in CLIENT and include != PUBLIC:
            self.fail('%s: includes "%s": the command line is a client of %s' %
                      (name, include, PUBLIC))
        if target == "host/cli":
            self.fail('%s: includes "%s": nothing but host/cli knows the command line' %
                      (name, include))

    def levels(self):
        """Folders with the number of folders that stand in a row below them; a circle is told."""
        level, way = {}, []

        def visit(node):
            if node in way:
                self.tell_circle(way[way.index(node):] + [node])
                return -1
            if node not in level:
                way.append(node)
                level[node] = 1 + max(map(visit, sorted(self.edges.get(node, {}))), default=-1)
                way.pop()
            return level[node]

        for node in sorted({self.folder(path) for path in self.files}):
            visit(node)
        return level

    def tell_circle(self, circle):
        steps = ['%s (%s includes "%s")' % ((a,) + self.edges[a][b])
                 for a, b in zip(circle, circle[1:])]
        self.fail("a circle: %s -> %s" % (" -> ".join(steps), circle[-1]))

    def report(self):
        level = self.levels()
        for node in sorted(level, key=lambda node: (level[node], node)):
            print("%2d  %-16s %s" % (level[node], node, " ".join(sorted(self.edges.get(node, {})))))
        for failure in self.failures:
            print(failure, file=sys.stderr)
        print("%d files in %d folders, %d findings" %
              (len(self.files), len(level), len(self.failures)))


# Each fault, by the files that make it, and what must be said of it.
PLANTED = (
    ({"host/a/a.c": '#include "b/b.h"\n', "host/b/b.h": '#include "a/a.h"\n', "host/a/a.h": ""},
     ("a circle: host/a (host/a/a.c includes \"b/b.h\") -> "
      "host/b (host/b/b.h includes \"a/a.h\") -> host/a",)),
    ({"host/a/a.h": '#include "b/b.h"\n', "host/b/b.h": '#include "c/c.h"\n',
      "host/c/c.h": '#include "mcvisi/d.h"\n', "include/mcvisi/d.h": '#include "a/a.h"\n'},
     ("a circle: host/a", "host/b (", "host/c (", "include (")),
    ({"host/cli/options.h": "", "host/a/a.c": '#include "cli/options.h"\n'},
     ('host/a/a.c: includes "cli/options.h": nothing but host/cli',)),
    ({"host/cli/a.c": '#include "render/r.h"\n', "host/render/r.h": ""},
     ('host/cli/a.c: includes "render/r.h": the command line is a client of mcvisi/mcvisi.h',)),
    ({"host/cli/a.c": '#include "mcvisi/events.h"\n', "include/mcvisi/events.h": ""},
     ('host/cli/a.c: includes "mcvisi/events.h": the command line is a client',)),
    ({"host/a/a.c": '#include "none.h"\n'}, ('includes "none.h", which is no file',)),
    ({"host/a/a.c": "\n" * 401}, ("host/a/a.c: has 401 lines",)),
    ({"include/mcvisi/a.h": "\n" * 401}, ("include/mcvisi/a.h: has 401 lines",)),
    ({"include/mcvisi/mcvisi.h": "\n" * 801}, ("include/mcvisi/mcvisi.h: has 801 lines",)),
    ({"kernels/a.cl": "\n" * 251}, ("kernels/a.cl: has 251 lines",)),
    ({"host/a/a.c": "static int f(int a,\n             int (*b)(int)) {" + "\n" * 59 + "}\n"},
     ("host/a/a.c:1: f: has 61 lines: must have at most 60",)),
    ({"kernels/a.cl": "int a;\n__kernel void\nf(uint a) {" + "\n" * 59 + "}\n"},
     ("kernels/a.cl:2: f: has 61 lines",)),
    ({"host/a/a.c": "int a;\n/* " + "µ" * 98 + "\n"}, ("host/a/a.c:2: has 101 columns",)),
)
SOUND = {"host/a/a.c": '#include "a.h"\n#include "b/b.h"\n', "host/a/a.h": "\n" * 400,
         "host/b/b.h": '#include "mcvisi/c.h"\n', "include/mcvisi/c.h": "/*" + "µ" * 98 + "\n",
         "host/cli/d.c": '#include "d.h"\n#include "options/o.h"\n#include "mcvisi/mcvisi.h"\n',
         "host/cli/d.h": '#include "core/f.h"\n', "host/options/o.h": "", "host/core/f.h": "",
         "include/mcvisi/mcvisi.h": "", "kernels/e.cl": '#include "mcvisi/c.h"\n' * 250,
         "host/a/f.c": "int f(void) {\n/* \n}\n*/" + "\n" * 56 + "}\nint f[] = {" + "\n" * 99 +
         "};\n",
         "kernels/test/f.cl": "\n" * 251}


def findings(files):
    with tempfile.TemporaryDirectory() as folder:
        for name, text in files.items():
            path = pathlib.Path(folder) / name
            path.parent.mkdir(parents=True, exist_ok=True)
            path.write_text(text, encoding="utf-8")
        tree = Tree(pathlib.Path(folder).resolve())
        tree.levels()
        return "\n".join(tree.failures)


def planted():
    wrong = 0
    if findings(SOUND):
        wrong += 1
        print("a sound tree is refused: %s" % findings(SOUND))
    for files, wanted in PLANTED:
        said = findings(files)
        for text in wanted:
            if text not in said:
                wrong += 1
                print("%s is not told of %s, but: %s" % (text, sorted(files), said))
    print("%d planted faults, %d not found" % (len(PLANTED), wrong))
    return 1 if wrong else 0


def main():
    if sys.argv[1:] == ["--planted"]:
        return planted()
    if len(sys.argv) != 2:
        print(__doc__, file=sys.stderr)
        return 2
    tree = Tree(pathlib.Path(sys.argv[1]).resolve())
    tree.report()
    return 1 if tree.failures else 0


if __name__ == "__main__":
    sys.exit(main())
