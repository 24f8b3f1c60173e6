#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Is the documentation true where a program can tell? docs.py MCVISI SOURCES

The standard library alone, no network.

- README.md has at most 120 lines.
- Every relative link and image leads to a file, and #anchor to a heading of it.
- Every `./run` verb, `mcvisi` verb and option that stands in code is in `./run help` or
  `mcvisi help`.
- Every page of docs/ stands in the navigation of `./run docs`.
- Every verb, and every package that `./run` installs, has its line.
- No sentence is longer than two lines of 100 columns; code and tables are left out.
"""

import pathlib
import re
import subprocess
import sys
import unicodedata

MOST_LINES = 120
MOST_CHARACTERS = 200
LINK = re.compile(r"!?\[(?P<text>[^\]]*)\]\((?P<target>[^)\s]+)\)")
SPAN = re.compile(r"(`+)(?P<code>.+?)\1", re.S)
OPTION = re.compile(r"(?<![\w-])--[a-z][a-z0-9-]*")
# A line of code that calls another program has that program's options.
OTHERS = re.compile(
    r"(\w+=\S* )*(sudo |\$ )?(apt-get|cc|cmake|ctest|git|pip|python3?|parallel|build/release/bench/\S+)\b"
    r"|seq .*\| parallel |#SBATCH |--sshloginfile"
)
ITEM = re.compile(r"\s*([-*+]|\d+\.|:  ) ")

failures = []


def fail(page, what):
    failures.append("%s: %s" % (page, what))


class Page:
    """A Markdown file, taken apart into paragraphs of prose, lines of code, and headings."""

    def __init__(self, path):
        self.path, self.paragraphs, self.code, self.headings = path, [], [], []
        self.lines = path.read_text(encoding="utf-8").splitlines()
        # What is no code: paragraphs, headings and tables; there links count.
        self.text = ""
        paragraph, fence, blank = [], None, True
        for line in self.lines + [""]:
            mark = re.match(r" *(```+|~~~+)", line)
            if fence or mark:
                if fence and mark and mark[1].startswith(fence):
                    fence = None
                elif fence:
                    self.code.append(line.strip())
                else:
                    fence = mark[1]
                self.end(paragraph)
                continue
            # Only behind an empty line: what continues a list or a definition is indented as well.
            if line.startswith("    ") and blank and not ITEM.match(line):
                self.code.append(line.strip())
                continue
            blank = not line.strip()
            self.text += line + "\n"
            if line.startswith("#"):
                self.headings.append(line.lstrip("#").strip())
                blank = True
            if blank or line.startswith(("#", "|", "<!--")) or ITEM.match(line):
                self.end(paragraph)
            if not (blank or line.startswith(("#", "|", "<!--"))):
                paragraph.append(
                    (line[ITEM.match(line).end() :] if ITEM.match(line) else line).strip(" >")
                )
        self.end(paragraph)
        joined = re.sub(r"\\\n", " ", "\n".join(self.code))
        self.code = joined.splitlines() + [
            " ".join(span["code"].split()) for span in SPAN.finditer(self.text)
        ]

    def end(self, paragraph):
        if paragraph:
            self.paragraphs.append(" ".join(paragraph))
        paragraph.clear()

    def anchors(self):
        """As MkDocs and, where a heading is plain ASCII, GitHub make them."""
        for heading in self.headings:
            plain = LINK.sub(lambda link: link["text"], heading)
            ascii_only = unicodedata.normalize("NFKD", plain).encode("ascii", "ignore").decode()
            yield re.sub(r"[-\s]+", "-", re.sub(r"[^\w\s-]", "", ascii_only).strip().lower())


def check_links(name, page, root):
    without_code = SPAN.sub("", page.text)
    for link in LINK.finditer(without_code):
        target, _, anchor = link["target"].partition("#")
        if re.match(r"[a-z]+:", target):
            continue
        path = (page.path.parent / target).resolve() if target else page.path
        if not path.exists():
            fail(name, "the link %s leads nowhere" % link["target"])
        elif not path.is_relative_to(root):
            fail(name, "the link %s leads out of the sources" % link["target"])
        elif anchor and path.suffix == ".md" and anchor not in Page(path).anchors():
            fail(name, "%s has no heading for #%s" % (target or name, anchor))


def check_sentences(name, page):
    for paragraph in page.paragraphs:
        plain = LINK.sub(lambda link: link["text"], paragraph)
        for sentence in re.split(r"(?<=[.!?])[*_)\"'`]*\s+(?=[^a-z\s])", plain):
            if len(sentence) > MOST_CHARACTERS:
                fail(name, "%d characters in: %s" % (len(sentence), sentence))


class Program:
    """What `./run help` and `mcvisi help` say."""

    def __init__(self, mcvisi, root):
        def output(*words):
            return subprocess.run(
                words, capture_output=True, text=True, check=True, cwd=root
            ).stdout

        usage = output("./run", "help")
        self.run_verbs = {"help"} | set(re.findall(r"^\./run (\w+)", usage, re.M))
        self.run_options = set(OPTION.findall(usage))
        overview = output(mcvisi, "help")
        self.verbs = set(re.findall(r"^  mcvisi ([a-z][a-z-]*)", overview, re.M))
        self.options = {
            verb: set(OPTION.findall(output(mcvisi, "help", verb)))
            for verb in self.verbs - {"help"}
        }
        # The help of a verb as JSON: its schema.
        self.options["help"] = {"--json"}
        self.all = set(OPTION.findall(overview)).union(*self.options.values())

    def check(self, name, code):
        code = re.split(r"(?:^|\s)#\s", code)[0].strip()
        if OTHERS.match(code) and "./run" not in code:
            return
        words = code.split()
        for verb in re.findall(r"\./run ([a-z]+)", code):
            if verb not in self.run_verbs:
                fail(name, "`./run help` has no verb %s" % verb)
        known = self.run_options if "./run" in code else self.all | self.run_options
        if (
            words
            and words[0].endswith("mcvisi")
            and len(words) > 1
            and re.fullmatch(r"[a-z][a-z-]*", words[1])
        ):
            if words[1] not in self.verbs:
                fail(name, "`mcvisi help` has no verb %s" % words[1])
            known = self.options.get(words[1], set())
        for option in OPTION.findall(code):
            if option not in known:
                fail(name, "no help names %s, in: %s" % (option, code))


def check_complete(root, program):
    """Every verb and every package has its line."""
    start = (root / "docs/quick-start.md").read_text(encoding="utf-8")
    for verb in program.run_verbs - {"help"}:
        if "| `./run %s` |" % verb not in start:
            fail("docs/quick-start.md", "nothing about ./run %s" % verb)
    command_line = (root / "docs/command-line.md").read_text(encoding="utf-8")
    for verb in program.verbs:
        if "| `mcvisi %s" % verb not in command_line:
            fail("docs/command-line.md", "nothing about mcvisi %s" % verb)
    run = (root / "run").read_text(encoding="utf-8")
    lists = re.findall(r"^needed(?:_(?!peers)\w+)?=\(([^)]*)\)", run, re.M)
    packages = {
        word for words in lists for word in words.split() if re.fullmatch(r"[a-z][a-z0-9+-]*", word)
    }
    if len(packages) < 10:
        sys.exit("the packages could not be read from run: %s" % packages)
    for package in packages:
        if not re.search(r"^\|.*(?<![\w-])%s(?![\w-]).*\|" % re.escape(package), start, re.M):
            fail("docs/quick-start.md", "nothing about the package %s" % package)


def main():
    mcvisi, root = str(pathlib.Path(sys.argv[1]).resolve()), pathlib.Path(sys.argv[2]).resolve()
    pages = [root / name / "README.md" for name in ("", "bench", "scenes", "kernels")] + sorted(
        (root / "docs").rglob("*.md")
    )
    program = Program(mcvisi, root)
    if len(program.run_verbs) < 5 or len(program.verbs) < 5:
        sys.exit(
            "the verbs could not be read from the help: %s, %s" % (program.run_verbs, program.verbs)
        )
    navigation = re.findall(
        r"[\w-]+\.md", (root / "tools/docs/mkdocs.yml").read_text(encoding="utf-8")
    )
    codes = 0
    for path in pages:
        name, page = path.relative_to(root).as_posix(), Page(path)
        check_links(name, page, root)
        check_sentences(name, page)
        for code in page.code:
            program.check(name, code)
        codes += len(page.code)
        # A page that the navigation leaves out fails in `./run docs`.
        if path.parent == root / "docs" and path.name not in navigation:
            fail(name, "tools/docs/mkdocs.yml has no such page")
    check_complete(root, program)
    if len(Page(root / "README.md").lines) > MOST_LINES:
        fail("README.md", "more than %d lines" % MOST_LINES)
    if failures:
        sys.exit("\n".join(failures))
    print("%d pages, %d pieces of code" % (len(pages), codes))


if __name__ == "__main__":
    main()
