"""Reads public collections of meshes with Rhytid and with other programs, and tables where they differ.

`cargo xtask collections` runs it. Each file ends as one of these:

- same: as the reference reads it, in the order of vertices, faces and corners;
- said: other than the reference, and a warning of Rhytid says what is not read;
- refused: an error that names the file;
- silent: other than the reference, and nobody says so. This fails the run, as do panics and long waits.

Where the exact reference cannot read a file, trimesh's triangles and their box are compared.
"""

import argparse
import json
import queue
import re
import subprocess
import sys
import threading
from collections import Counter
from dataclasses import dataclass
from pathlib import Path

import exports
import fetch
import gltf_reading
import references
from reading import Refused, difference, loose_difference, of_json

SECONDS = 60
EXACT = {"obj": references.obj, "ply": references.ply, "glb": gltf_reading.gltf, "gltf": gltf_reading.gltf}
EXACT |= {"vrm": gltf_reading.gltf} | {ending: references.usd for ending in ("usd", "usda", "usdc", "usdz")}
# Words in the warnings that may explain a difference; others do not.
EXPLAINS = ["not followed", "is not read", "left out", "were skipped"]
ENDS = ["same", "said", "refused", "silent"]


@dataclass
class Outcome:
    path: Path
    end: str
    # What Rhytid said, or what differs.
    why: str = ""
    # What the reference did with a file that Rhytid refuses.
    reference: str = ""


class Reader:
    """The example mesh_json, which is started again after a file that ends it."""

    def __init__(self, program):
        self.program, self.process = program, None

    def read(self, path):
        """The line of JSON about a file; None if it takes too long or ends the program."""
        if self.process is None:
            self.process = subprocess.Popen([self.program], stdin=-1, stdout=-1, stderr=subprocess.DEVNULL, text=True)
            self.lines = queue.Queue()
            threading.Thread(target=self.gather, args=(self.process, self.lines), daemon=True).start()
        self.process.stdin.write(f"{path}\n")
        self.process.stdin.flush()
        try:
            line = self.lines.get(timeout=SECONDS)
        except queue.Empty:
            line = ""
        if not line:
            self.process.kill()
            self.process = None
            return None
        return json.loads(line)

    @staticmethod
    def gather(process, lines):
        for line in process.stdout:
            lines.put(line)
        lines.put("")


def outcome(reader, path):
    found = reader.read(path)
    if found is None or "panicked" in found:
        return Outcome(path, "silent", "panics, ends the program, or takes longer than a minute")
    said = "; ".join(found["warnings"])
    differs, reference = compare(found, path)
    if "refused" in found:
        names_file = found["refused"].startswith(str(path))
        return Outcome(path, "refused" if names_file else "silent", found["refused"], reference)
    if differs is None:
        return Outcome(path, "same", said, reference)
    if any(words in said for words in EXPLAINS):
        return Outcome(path, "said", f"{differs}: {said}", reference)
    return Outcome(path, "silent", differs, reference)


def compare(found, path):
    """What differs from the first reference that reads the file, and what that reference did."""
    failures = []
    for read, compared in ((EXACT[path.suffix.lower()[1:]], difference), (references.loosely, loose_difference)):
        try:
            expected = read(path)
        except Refused as refused:
            failures.append(f"{read.__name__}: {refused}")
        except Exception as error:
            # References fail in many ways on what they do not know.
            failures.append(f"{read.__name__}: {type(error).__name__} {error}"[:200])
        else:
            differs = None if "refused" in found else compared(of_json(found), expected)
            return differs, f"{read.__name__} reads it"
        if path.suffix.lower().startswith(".usd"):
            break
    return "no reference reads it", "; ".join(failures)


def collections(folder, blender):
    """The files of each collection by its label."""
    for package in fetch.PACKAGES:
        yield package.label(), fetch.meshes_below(fetch.fetch(package, folder), package.without)
    for label, made in exports.all_exports(folder, blender).items():
        yield label, fetch.meshes_below(made)


def kind(sentence):
    """A sentence without the file, the names and the numbers in it."""
    return re.sub(r'"[^"]*"|[\d.]+', "…", sentence.split(": ", 1)[-1])


def main():
    options = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    options.add_argument("--program", type=Path, required=True, help="the example mesh_json")
    options.add_argument("--blender", type=Path, required=True, help="a Python that has bpy")
    options.add_argument("--folder", type=Path, required=True, help="where collections are kept")
    options.add_argument("--only", default="", help="only files with this in their paths")
    options.add_argument("--json", type=Path, help="write every outcome to this file")
    given = options.parse_args()
    reader, rows, all_outcomes = Reader(given.program), [], []
    for label, files in collections(given.folder.resolve(), given.blender):
        outcomes = [outcome(reader, path) for path in files if given.only in str(path)]
        rows.append((label, Counter(one.end for one in outcomes)))
        all_outcomes += outcomes
        print(label, dict(rows[-1][1]), file=sys.stderr, flush=True)
    rows.append(("all", sum((ends for _, ends in rows), Counter())))
    print("| collection | files |", " | ".join(ENDS), "|\n| --- |", " --- |" * (len(ENDS) + 1))
    for label, ends in rows:
        print(f"| {label} | {sum(ends.values())} |", " | ".join(str(ends[end]) for end in ENDS), "|")
    for end in ("said", "refused"):
        kinds = Counter(kind(one.why) for one in all_outcomes if one.end == end)
        print(f"\n{end}:")
        for sentence, count in kinds.most_common():
            print(f"{count:5} {sentence[:200]}")
    silent = [one for one in all_outcomes if one.end == "silent"]
    for one in silent:
        print(f"silent: {one.path}: {one.why}")
    if given.json:
        lines = [{**vars(one), "path": str(one.path)} for one in all_outcomes]
        given.json.write_text("\n".join(map(json.dumps, lines)) + "\n")
    sys.exit(bool(silent))


if __name__ == "__main__":
    main()
