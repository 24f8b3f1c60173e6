#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""
tables.py [FOLDER]   fills the parameter tables of the element pages, by default in place

A page holds a table between the lines

    <!-- parameters: sensors/pinhole -->
    <!-- end of parameters -->

The first line names a schema of include/mcvisi/schema and a way into it. The schemas are generated
from the X lists of the program's headers, so the tables say what the program takes. Python's
standard library only.
"""

import glob
import json
import math
import os
import re
import sys

HERE = os.path.dirname(os.path.abspath(__file__))
SCHEMAS = os.path.join(HERE, "..", "..", "include", "mcvisi", "schema")
BLOCK = re.compile(r"(<!-- parameters: (\S+) -->\n).*?(<!-- end of parameters -->\n)", re.DOTALL)
HIDDEN = ("type", "name")  # every element has them: index.md says what they are
UNBOUNDED = 1e30


def schema(name):
    with open(os.path.join(SCHEMAS, "MCVISI_%s.schema.json" % name), encoding="utf-8") as file:
        return json.load(file)


def step(node, key):
    """The part of a schema that a member of the scene file has: of a list its items, of a choice
    the one of this type."""
    if "oneOf" in node:
        return next(c for c in node["oneOf"] if c["properties"]["type"]["enum"] == [key])
    part = node["properties"][key]
    return part.get("items", part) if part.get("type") == "array" else part


def find(path):
    """The object schema that a path such as emitters/projector/pattern/phaseShift names."""
    name, *keys = path.split("/")
    node = schema(name)
    if keys and keys[0] in node.get("definitions", {}):
        node = node["definitions"][keys.pop(0)]
    for key in keys:
        node = step(node, key)
    return node


def scalar(part):
    """What one number of a parameter may be: the schema itself, or the first of its choices."""
    return part["anyOf"][0] if "anyOf" in part else part


def is_angle(part):
    return "deg" in scalar(part).get("pattern", "")


def is_image(part):
    return any("uri" in choice.get("properties", {}) for choice in part.get("anyOf", []))


def kind(part):
    """What is written there, in words; of a choice its options."""
    one = scalar(part)
    if is_image(part):
        return "index, name or object"
    if "oneOf" in part:
        return "object"
    if "enum" in scalar(part):
        words = ", ".join('`"%s"`' % option for option in scalar(part)["enum"])
        return words + ", or a list" if "anyOf" in part else words
    word = {"boolean": "true or false", "integer": "integer", "number": "number"}.get(
        one["type"] if isinstance(one["type"], str) else "", "")
    if "pattern" in one:
        word = "angle" if is_angle(part) else "length"
    if one["type"] == ["string", "integer"]:
        return "name or index"
    if one["type"] == "array":
        items = one["items"]
        if items.get("minItems") == 2:
            return "2 to %d pairs" % one["maxItems"]
        if items.get("type") == "array":
            return "up to %d rows of numbers: 0 … 1" % one["maxItems"]
        return "list" if "properties" in items else \
            "%s%d %ss" % ("" if "minItems" in one else "up to ", one["maxItems"], kind(items))
    count = part["anyOf"][1]["maxItems"] if "anyOf" in part else 1
    return {1: word, 2: "%s, or 2" % word, 3: "%s, or 3 (R, G, B)" % word}[count]


def figure(x):
    """A number as it is read."""
    text = "%.6g" % x
    if "e" in text:
        mantissa, exponent = text.split("e")
        text = "%s10%s" % ("" if mantissa == "1" else "-" if mantissa == "-1" else mantissa + "·",
                           "".join("⁰¹²³⁴⁵⁶⁷⁸⁹"[int(c)] if c.isdigit() else "⁻"
                                   for c in str(int(exponent))))
    return text.replace("-", "−")


def bound(x, part):
    """An end of a range; of an angle in degrees, unless it allows many turns."""
    return figure(math.degrees(x)) + "°" if is_angle(part) and abs(x) < 10 else figure(x)


def span(part):
    """The range of a number."""
    one = scalar(part)
    one = one.get("items", one)
    if is_image(part) or ("minimum" not in one and "maximum" not in one):
        return ""
    low, high = one.get("minimum"), one.get("maximum")
    first = "" if low is None else \
        ("> " if one.get("exclusiveMinimum") else "≥ ") + bound(low, part)
    if high is None or high >= UNBOUNDED:
        return first
    if one.get("exclusiveMinimum"):
        return "%s, ≤ %s" % (first, bound(high, part))
    return "%s … %s" % (bound(low, part), bound(high, part))


def default(part, required):
    if required:
        return "required"
    value = part.get("default")
    if value is None:
        return ""
    if isinstance(value, bool):
        return "`%s`" % str(value).lower()
    if isinstance(value, str):
        return '`"%s"`' % value
    return "%s (%s)" % (figure(value), bound(value, part)) if is_angle(part) and value else \
        figure(value)


def unit_and_meaning(part):
    """A description ends in its unit; of a choice that says two, both belong to the sentence."""
    text = re.sub(r"\{[^}]*\}", r"`\g<0>`", part.get("description", ""))
    match = re.fullmatch(r"(.*) \[([^\[\]]+)\]", text)
    return (match[2], match[1]) if match and "enum" not in scalar(part) else ("", text)


def rows(path):
    node = find(path)
    required = node.get("required", [])
    for key, part in node["properties"].items():
        if key in HIDDEN:
            continue
        unit, meaning = unit_and_meaning(part)
        value = ": ".join(filter(None, (kind(part), span(part))))
        yield ["`%s`" % key, meaning, unit, default(part, key in required), value]


def table(path):
    lines = ["| " + " | ".join(cell.replace("|", "\\|") for cell in cells) + " |"
             for cells in rows(path)]
    if not lines:
        return "It has no parameters.\n"
    return "\n".join(["| key | meaning | unit | default | value |",
                      "| --- | --- | --- | --- | --- |"] + lines) + "\n"


def filled(text):
    """A page with its tables made anew; blank lines around them, which Markdown needs."""
    return BLOCK.sub(lambda m: "%s\n%s\n%s" % (m[1], table(m[2]), m[3]), text)


def pages():
    """All pages, by their place below this folder."""
    found = glob.glob(os.path.join(HERE, "**", "*.md"), recursive=True)
    return sorted(os.path.relpath(path, HERE) for path in found)


def main(arguments):
    if len(arguments) > 1 or arguments[:1] in (["-h"], ["--help"]):
        print(__doc__.strip())
        return 0 if len(arguments) == 1 else 2
    folder = arguments[0] if arguments else HERE
    for page in pages():
        with open(os.path.join(HERE, page), encoding="utf-8") as file:
            text = filled(file.read())
        path = os.path.join(folder, page)
        os.makedirs(os.path.dirname(path), exist_ok=True)
        with open(path, "w", encoding="utf-8", newline="\n") as file:
            file.write(text)
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
