#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Manual pages and bash completion say what the program knows: manual.py PROGRAM BUILD FOLDER.

The program is asked for its verbs and options (`help VERB --json`), the files are those that
`cmake --install` puts into FOLDER.
"""
import json
import pathlib
import re
import shutil
import subprocess
import sys

COMPLETE = 'source "$1"; shift; COMP_WORDS=("$@"); COMP_CWORD=$(($# - 1)); _mcvisi; ' \
           'printf "%s\\n" "${COMPREPLY[@]}"'
failures = []


def expect(holds, sentence):
    if not holds:
        failures.append(sentence)


def output(*command, **options):
    return subprocess.run(command, check=True, capture_output=True, text=True, **options).stdout


def known_options(program):
    """Each verb with its options, and each option with its words or None."""
    verbs = re.findall(r"^  mcvisi ([a-z][a-z-]+)", output(program, "help"), re.M)
    schemas = {v: json.loads(output(program, "help", v, "--json"))["properties"] for v in verbs}
    # An experiment has keys of its own beside the options of its verb.
    for verb in ("sweep", "uncertainty", "optimize"):
        for key in ("rig", "fingerprint", "pod"):
            schemas[verb].pop(key, None)
    # True is a choice in JSON only: on the command line it is the option alone.
    return {
        v: {o: words_of(s) for o, s in schema.items()} for v, schema in schemas.items()
    }


def words_of(schema):
    words = schema.get("enum")
    return words and [w for w in words if isinstance(w, str)]


def check_pages(options, folder):
    groff, overview = shutil.which("groff"), (folder / "mcvisi.1").read_text()
    if not groff:
        print("manual pages: groff is not installed: its warnings are left out")
    expect(len(list(folder.iterdir())) == len(options) + 1, f"{folder}: one page per verb, and one")
    for verb, names in options.items():
        page = folder / f"mcvisi-{verb}.1"
        text = page.read_text().replace("\\-", "-")
        described = set(re.findall(r"^\.TP\n.*?\\fB\\&--([a-z-]+)\\fR", text, re.M))
        expect(f"mcvisi\\-{verb} (1)" in overview, f"mcvisi.1 lacks {verb}")
        expect(described == set(names), f"{page.name}: differs in {described ^ set(names)}")
    for page in sorted(folder.iterdir()) if groff else []:
        run = subprocess.run([groff, "-man", "-Tutf8", "-P-cbou", "-ww", page],
                             capture_output=True, text=True)
        expect(run.returncode == 0 and not run.stderr, f"groff: {run.stderr}")
        expect("NAME\n" in run.stdout, f"{page.name}: groff prints no page")


class Completion:
    def __init__(self, script, folder):
        self.script, self.folder = script, folder

    def words(self, *line):
        """What is offered for the last word of a command line."""
        command = ["bash", "--norc", "-c", COMPLETE, "bash", self.script, "mcvisi", *line]
        found = subprocess.run(command, cwd=self.folder, capture_output=True, text=True)
        expect(found.returncode == 0 and not found.stderr, f"mcvisi {line}: {found.stderr}")
        return sorted(w for w in found.stdout.splitlines() if w)

    def expect(self, line, words):
        found = self.words(*line)
        expect(found == sorted(words), f"mcvisi {' '.join(line)}: {found}, expected {words}")


def check_completion(options, script, folder):
    complete = Completion(script, folder)
    folder.mkdir(exist_ok=True)
    files = ["a part.stl", "scene.gltf"]
    for name in files:
        (folder / name).touch()
    complete.expect([""], ["--help", "--version", *options])
    complete.expect(["ren"], ["render"])
    for verb, names in options.items():
        complete.expect([verb, "--"], ["--help", *(f"--{n}" for n in names)])
        for name, words in names.items():
            if words:
                complete.expect([verb, f"--{name}", ""], words)
    complete.expect(["help", "mea"], ["measure"])
    complete.expect(["render", ""], files)
    complete.expect(["render", "--json", "--spp", "64", "sc"], ["scene.gltf"])
    complete.expect(["render", "--spp", ""], [])
    complete.expect(["render", "scene.gltf", ""], [])
    # Bash takes words apart at = and :.
    complete.expect(["render", "--sampler", "=", "so"], ["sobol"])
    complete.expect(["render", "--sampler", "="], ["random", "sobol"])
    complete.expect(["render", "--samples", "=", "0", ":", "64", "sc"], ["scene.gltf"])
    complete.expect(["render", "--set", "cam/fNumber", "=", "8", "sc"], ["scene.gltf"])
    complete.expect(["new", "tele"], ["telecentric"])
    complete.expect(["new", "telecentric", "a"], ["a part.stl"])
    complete.expect(["new", "--unit", ""], ["nm", "um", "mm", "cm", "m", "inch"])
    complete.expect(["camera", "x.exr", "--lens-mtf", ""], ["diffraction", "none", *files])
    complete.expect(["camera", "x.exr", "-o", "sc"], ["scene.gltf"])
    complete.expect(["compare", "scene.gltf", "a"], ["a part.stl"])
    complete.expect(["nothing", ""], [])


def main():
    program, build, folder = sys.argv[1], sys.argv[2], pathlib.Path(sys.argv[3])
    shutil.rmtree(folder, ignore_errors=True)
    output("cmake", "--install", build, "--component", "manual", "--prefix", folder)
    options = known_options(program)
    expect(len(options) > 5 and len(options["render"]) > 20, f"{program}: too few options")
    check_pages(options, folder / "share/man/man1")
    script = folder.resolve() / "share/bash-completion/completions/mcvisi"
    if shutil.which("bash"):
        check_completion(options, script, folder / "files")
    else:
        print("completion: bash is not installed: left out")
    print("\n".join(failures))
    sys.exit(bool(failures))


main()
