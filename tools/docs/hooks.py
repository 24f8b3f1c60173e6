# SPDX-License-Identifier: Apache-2.0
"""Hooks of `./run docs`.

The pages of docs/ link to files outside of it, as a reader of the sources needs them; MkDocs knows
docs/ alone.

- A Markdown file outside of docs/ that a page or the navigation names becomes a page, any other
  file a text beside the pages.
- A navigation entry that ends in / stands for all pages of that folder, its index.md first.
"""

import os
import pathlib
import posixpath
import re

from mkdocs.structure.files import File, InclusionLevel

ROOT = pathlib.Path(__file__).resolve().parents[2]
# Of the site alone.
OWN = ("style.css", "iframe-worker.js")
SHOWN = (".md", ".png", ".jpg", ".svg", ".html", ".pdf")
# [text](target) and ![text](target) outside of code; the target without its #anchor.
LINK = re.compile(r"(?P<head>!?\[[^\]]*\]\()(?P<target>[^)#\s:]+)(?P<tail>(?:#[^)\s]*)?\))")
# `a\|b` in a row of a table: GitHub wants the backslash, and MkDocs would print it.
CODE_IN_ROW = re.compile(r"(?<=[ |(])`[^`\n]*\\\|[^`\n]*`(?=[ ,;.)|])")


def site_path(path):
    """Where a file of the repository lies in the site."""
    if path.startswith("docs/"):
        return path[len("docs/") :]
    return path if path.endswith(SHOWN) else "sources/" + path + ".txt"


def source_path(uri):
    """The file of the repository that a page of the site comes from."""
    return uri if (ROOT / uri).is_file() and not (ROOT / "docs" / uri).is_file() else "docs/" + uri


def linked_from(source):
    """(link, file of the repository) of each relative link of a page that leads to a file."""
    text = (ROOT / source).read_text(encoding="utf-8")
    for link in LINK.finditer(text):
        target = posixpath.normpath(posixpath.join(posixpath.dirname(source), link["target"]))
        if (ROOT / target).is_file():
            yield target


def nav_pages(entry):
    if isinstance(entry, str):
        yield entry
    elif isinstance(entry, dict):
        for value in entry.values():
            yield from nav_pages(value)
    else:
        for value in entry:
            yield from nav_pages(value)


def folder(name):
    """All pages of a folder of docs/, index.md first; folders in it are sections."""
    here = ROOT / "docs" / name
    pages = sorted(here.glob("*.md"), key=lambda page: (page.name != "index.md", page.name))
    entries = [
        {"Overview": name + page.name} if page.name == "index.md" else name + page.name
        for page in pages
    ]
    for inner in sorted(
        path for path in here.iterdir() if path.is_dir() and any(path.glob("*.md"))
    ):
        entries.append({inner.name.capitalize(): folder(name + inner.name + "/")})
    return entries


def expanded(entry):
    if isinstance(entry, str):
        return folder(entry) if entry.endswith("/") else entry
    if isinstance(entry, dict):
        return {title: expanded(value) for title, value in entry.items()}
    return [expanded(value) for value in entry]


def on_config(config):
    # A page outside of docs/ that is not written yet stands in no navigation.
    present = [
        page
        for page in nav_pages(config["nav"])
        if page.endswith("/") or (ROOT / source_path(page)).is_file()
    ]

    def kept(entry):
        if isinstance(entry, str):
            return entry in present
        return not isinstance(entry, dict) or any(map(kept, entry.values()))

    def pruned(entry):
        if isinstance(entry, dict):
            return {title: pruned(value) for title, value in entry.items()}
        return (
            [pruned(value) for value in entry if kept(value)] if isinstance(entry, list) else entry
        )

    config["nav"] = expanded(pruned(config["nav"]))
    return config


def on_files(files, config):
    """Adds what pages name outside of docs/, and what those name in turn."""
    for name in OWN:
        files.append(
            File.generated(config, name, content=(pathlib.Path(__file__).parent / name).read_text())
        )
    waiting = [source_path(page) for page in nav_pages(config["nav"])]
    waiting += ["docs/" + file.src_uri for file in files if file.src_uri.endswith(".md")]
    done = set()
    while waiting:
        source = waiting.pop()
        if source in done:
            continue
        done.add(source)
        if not source.startswith("docs/"):
            content = (ROOT / source).read_bytes()
            files.append(
                File.generated(
                    config, site_path(source), content=content, inclusion=InclusionLevel.NOT_IN_NAV
                )
            )
        if source.endswith(".md"):
            waiting.extend(linked_from(source))
    return files


def on_page_markdown(markdown, page, config, files):
    """Relative links are those of the repository; the site has other places for files outside."""
    source = source_path(page.file.src_uri)
    here = posixpath.dirname(site_path(source))

    def moved(link):
        target = posixpath.normpath(posixpath.join(posixpath.dirname(source), link["target"]))
        if not os.path.isfile(ROOT / target):
            return link[0]  # MkDocs tells what is broken
        return link["head"] + posixpath.relpath(site_path(target), here or ".") + link["tail"]

    return CODE_IN_ROW.sub(lambda code: code[0].replace(r"\|", "|"), LINK.sub(moved, markdown))
