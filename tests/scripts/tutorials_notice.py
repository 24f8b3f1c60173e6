#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""tutorials.py passes a page that is true, and refuses each of several that are not.

tutorials_notice.py TUTORIALS.py FOLDER

The pages need no renderer: their blocks print what a program would.
"""

import os
import struct
import subprocess
import sys
import zlib

TRUE = """# A page

```sh
printf 'width 60.0127 ± 0.0003 mm\\nheight 40 mm\\n1 of 2 edges\\n'
cp ../picture.png seen.png
```

```text
width 60.0126 ± 0.0003 mm
…
1 of 2 edges
```

The width is 60.0126 ± 0.0002 mm, <!-- measured width (\\S+) --> and geometry says
60.013 mm. <!-- known width (\\S+) ± (\\S+) --> It is 0.0600126 ± 1 % m. <!-- measured x1e-3 width (\\S+) -->
That is 6.37 ± 10 % <!-- formula 2 / (3 * pi) * 30 --> <!-- known x0.1 width (\\S+) --> µm.

![A picture](page/seen.png)
"""

# What is changed, and into what: the page is no longer true.
FAULTS = [
    ("width 60.0126 ± 0.0003 mm", "width 60.0123 ± 0.0003 mm"),  # off by more than its uncertainty
    ("width 60.0126 ± 0.0003 mm", "width 60.0126 ± 0.0005 mm"),  # another uncertainty
    ("…\n1 of 2 edges", "…\n1 of 3 edges"),
    ("…\n1 of 2 edges", "…\n1 of 2 lines"),
    ("…\n1 of 2 edges", "1 of 2 edges\nheight 40 mm"),  # another order
    ("is 60.0126 ± 0.0002", "is 60.0124 ± 0.0002"),
    ("measured width", "measured breadth"),  # not printed
    ("60.013 mm", "60.014 mm"),  # 4 uncertainties are 0.0012
    ("0.0600126 ± 1 %", "0.0610126 ± 1 %"),
    ("6.37 ± 10 %", "6.38 ± 10 %"),  # not what the formula gives
    ("known x0.1", "known x0.2"),
    ("page/seen.png", "page/other.png"),  # none such
    ("picture.png seen.png", "darker.png seen.png"),
    ("picture.png seen.png", "wider.png seen.png"),
    ("printf 'width", "false; printf 'width"),  # a command that fails
    ("<!-- formula 2 / (3 * pi) * 30 --> <!-- known x0.1 width (\\S+) -->", ""),  # too few figures
]


def write_png(path, width, level):
    def chunk(kind, data):
        return (
            struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))
        )

    rows = b"".join(b"\x00" + bytes([level]) * width for _ in range(8))
    with open(path, "wb") as file:
        file.write(
            b"\x89PNG\r\n\x1a\n"
            + chunk(b"IHDR", struct.pack(">IIBBBBB", width, 8, 8, 0, 0, 0, 0))
            + chunk(b"IDAT", zlib.compress(rows))
            + chunk(b"IEND", b"")
        )


def passes(script, text, folder):
    with open("page.md", "w", encoding="utf-8") as file:
        file.write(text)
    result = subprocess.run(
        [sys.executable, "-B", script, "mcvisi", ".", "page.md", folder],
        capture_output=True,
        text=True,
    )
    return result.returncode == 0, result.stdout + result.stderr


def main():
    script = os.path.abspath(sys.argv[1])
    os.makedirs(os.path.join(sys.argv[2], "page"), exist_ok=True)
    os.chdir(sys.argv[2])
    for name, width, level in (("picture", 8, 200), ("darker", 8, 196), ("wider", 9, 200)):
        write_png(name + ".png", width, level)
    write_png("page/seen.png", 8, 201)
    fine, output = passes(script, TRUE, "run")
    if not fine:
        sys.exit("a true page is refused:\n" + output)
    unseen = []
    for old, new in FAULTS:
        if TRUE.count(old) != 1:
            sys.exit("'%s' does not stand in the page once" % old)
        if passes(script, TRUE.replace(old, new), "run")[0]:
            unseen.append("'%s' instead of '%s'" % (new, old))
    if unseen:
        sys.exit("these faults pass:\n  " + "\n  ".join(unseen))
    print("%d faults are seen" % len(FAULTS))


if __name__ == "__main__":
    main()
