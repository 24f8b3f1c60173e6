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
        + [np.zeros(3), np.float32(3), np.zeros((4, 4)), (1, 2), (0, 0, 96, 64), lambda *_: 1, True]
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


POD = {"size": "fNumber", "signal": "m", "threshold": 0.1}
DENT = {"node": "bracket", "at": "12mm,3mm,0", "size": "0.2mm"}


def study(numbers, work, vary, **more):
    usual = {"spp": 4, "time": 2, "edges": {"l": (8, 34, 18, 16)}, "metrics": {"m": "l.bright"}}
    for _ in work(vary, **{**usual, **more, **options(numbers, work)}):
        break


def matrix_work(numbers, rig):
    matrix = rig.transport(**{**USUAL, **options(numbers, rig.transport)})
    given = [junk(numbers) for _ in range(3)]
    numbers.choice(
        [
            lambda: matrix.relight(numbers.choice([given[0], {"light": given[0]}])),
            lambda: matrix.sequence(numbers.choice([given[0], {"type": given[0]}]), given[1]),
            lambda: matrix.fit(*given),
            lambda: matrix.inverse_pattern(*given),
            lambda: matrix.deflection(given[0]),
            lambda: matrix.elements(given[0]),
            lambda: matrix.save(given[0]),
            lambda: mv.Transport(given[0]),
        ]
    )()


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
    "uncertainty": lambda n, rig, image: study(
        n, rig.uncertainty, n.choice([junk(n), {"nodes/part/turnX": junk(n)}])
    ),
    "optimize": lambda n, rig, image: study(
        n, rig.optimize, n.choice([junk(n), {"sensors/camera/fNumber": junk(n)}])
    ),
    "pod": lambda n, rig, image: study(
        n, rig.pod, {"sensors/camera/fNumber": [4, 8]}, study=n.choice([junk(n), POD])
    ),
    "pod table": lambda n, rig, image: mv.pod_table(junk(n), **options(n, mv.pod_table)),
    "pod values": lambda n, rig, image: mv.pod_values(
        n.choice([np.arange(12), junk(n)]), junk(n), **options(n, mv.pod_values)
    ),
    "explain": lambda n, rig, image: rig.explain(
        n.choice([(4, 4), junk(n)]), **{"spp": 4, **options(n, rig.explain)}
    ),
    "transport": lambda n, rig, image: matrix_work(n, rig),
    "deflectometry": lambda n, rig, image: rig.deflectometry(
        **{"plane": "part", **USUAL, **options(n, rig.deflectometry)}
    ),
    "scan": lambda n, rig, image: rig.scan(**{**USUAL, "profiles": 2, **options(n, rig.scan)}),
    "camera model": lambda n, rig, image: rig.export_camera(**options(n, rig.export_camera)),
    "import camera": lambda n, rig, image: rig.copy().import_camera(
        junk(n), **options(n, rig.import_camera)
    ),
    "defect": lambda n, rig, image: rig.copy().add_defect(
        n.choice(["dent", junk(n)]), **{**DENT, **options(n, rig.add_defect)}
    ),
    "detect": lambda n, rig, image: image.detect(
        n.choice([image, junk(n)]), **options(n, image.detect)
    ),
    "merge": lambda n, rig, image: mv.merge(n.choice([junk(n), [junk(n)]]), **options(n, mv.merge)),
    "merge tables": lambda n, rig, image: mv.merge_tables(
        n.choice([junk(n), [junk(n)]]), n.choice(["t.csv", junk(n)])
    ),
    "lens": lambda n, rig, image: mv.import_lens(junk(n), **options(n, mv.import_lens)),
    "values": lambda n, rig, image: mv.log(junk(n), junk(n), junk(n)),
    "unit": lambda n, rig, image: mv.Value(1.0, 0.1, "m").to(junk(n)),
    "part to try": lambda n, rig, image: mv.examples.bracket(n.choice(["part.stl", b"a\0b", None])),
    "arguments": lambda n, rig, image: rig.render(spp=4, session=junk(n), progress=junk(n)),
    "bar": lambda n, rig, image: rig.sweep({"sensors/camera/fNumber": [8]}, progress=junk(n)),
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
