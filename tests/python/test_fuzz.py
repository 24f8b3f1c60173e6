# SPDX-License-Identifier: Apache-2.0
"""Wrong values everywhere: each call succeeds, or raises the package's exception with a sentence.

A crash of the interpreter fails the test by itself.
"""

import inspect
import random

import mcvisi as mv
import numpy as np
import pytest

CALLS = 60
# What takes long, or leaves files.
LEFT_OUT = {"threads", "device", "precision", "output", "html", "images", "grid", "time", "spp"}
USUAL = {"spp": 4, "progress": False}


def junk(numbers):
    return numbers.choice(
        [None, 0, -1, 1, 2**70, 1.5, float("nan"), float("inf"), "", "x", "8", "a\0b", "\ud800"]
        + [b"bytes", [], [None], {}, {"a": 1}, {"a": (1, 2, 3, 4)}, {"a": [[1, 2, 3, 4]]}, object()]
        + [np.zeros(3), np.float32(3), np.zeros((4, 4)), (1, 2), (0, 0, 96, 64), lambda: 1, True]
        + ["8,34,18,16", "@part:0mm,0mm,0mm,1mm,1mm", "96x64", "image", "sensors/camera"]
    )


def options(numbers, function):
    names = [
        name
        for name, parameter in inspect.signature(function).parameters.items()
        if parameter.kind == parameter.KEYWORD_ONLY and name not in LEFT_OUT
    ]
    count = min(len(names), numbers.randint(0, 3))
    return {name: junk(numbers) for name in numbers.sample(names, count)}


def change_and_render(numbers, rig, image):
    copy = rig.copy()
    copy[numbers.choice(rig.paths())] = junk(numbers)
    copy.check()
    copy.render(**USUAL)


def sweep(numbers, rig, image):
    vary = numbers.choice([junk(numbers), {"sensors/camera/fNumber": junk(numbers)}])
    usual = {"spp": 4, "time": 2, "edges": {"l": (8, 34, 18, 16)}, "metrics": ["l.bright"]}
    for _ in rig.sweep(vary, **{**usual, **options(numbers, rig.sweep)}):
        break


WORK = {
    "get": lambda n, rig, image: rig[n.choice([junk(n), "sensors/" + str(junk(n))])],
    "change": change_and_render,
    "render": lambda n, rig, image: rig.render(**{**USUAL, **options(n, rig.render)}),
    "check": lambda n, rig, image: rig.check(**options(n, rig.check)),
    "sweep": sweep,
    "trace": lambda n, rig, image: rig.trace(junk(n), **options(n, rig.trace)),
    "rig": lambda n, rig, image: mv.Rig(junk(n), folder=n.choice([None, junk(n)])).check(),
    "load": lambda n, rig, image: mv.load(junk(n)),
    "new": lambda n, rig, image: mv.new(
        n.choice(["telecentric", junk(n)]), junk(n), **options(n, mv.new)
    ),
    "camera": lambda n, rig, image: image.camera(**{"expose_to": 0.8, **options(n, image.camera)}),
    "measure": lambda n, rig, image: image.measure(**options(n, image.measure)),
    "image": lambda n, rig, image: mv.Image(
        n.choice([np.ones((8, 8)), junk(n)]), junk(n), n.choice([None, junk(n)])
    ).measure(),
    "read": lambda n, rig, image: mv.read(junk(n)),
    "save": lambda n, rig, image: image.save(junk(n), preview=junk(n)),
    "part": lambda n, rig, image: image.part(junk(n)),
    "views": lambda n, rig, image: image.views(**options(n, image.views)),
    "gradient": lambda n, rig, image: image.emd_gradient(**options(n, image.emd_gradient)),
    "compare": lambda n, rig, image: mv.compare(image, n.choice([image, junk(n)])),
    "triangulate": lambda n, rig, image: mv.triangulate(
        n.choice([image, [image, image], junk(n)]), junk(n), **options(n, mv.triangulate)
    ),
    "session": lambda n, rig, image: mv.Session(device=junk(n), schedule=junk(n)),
}


@pytest.mark.parametrize("work", WORK)
def test_wrong_values(rig, image, tmp_path, monkeypatch, work):
    monkeypatch.chdir(tmp_path)
    numbers = random.Random(work)
    done = 0
    for number in range(CALLS):
        try:
            WORK[work](numbers, rig, image)
            done += 1
        except mv.Error as error:
            assert len(str(error)) >= 12, "call %d: %r" % (number, error)
    print("%s: %d of %d succeed" % (work, done, CALLS))
    # What was used is whole.
    assert np.array_equal(np.asarray(rig.render(spp=16, progress=False)), np.asarray(image))
