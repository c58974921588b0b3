"""The table of docs/clients.md: written, and compared with what is measured now."""

import math
import re
import sys
import tomllib
from pathlib import Path

import face
from kinds import KINDS

BEGIN, END = "<!-- `cargo xtask clients` writes what follows. -->\n", "<!-- Here it ends. -->\n"
HEAD = ["program", "file", "frames", "worst vertex", "worst normal", "looks"]
LOOKS = 2
# Numbers may grow by this factor, and by this much, before a row is worse: other processors round otherwise.
FACTOR, MILLIMETRES, DEGREES = 1.5, 0.001, 0.05
ERROR = "**error**"
# The sentences about cells that fall short: of which `programs`, `files` and `columns`, and what it `says`.
SENTENCES = Path(__file__).with_name("shortfalls.toml")


def cells(row):
    """A row as text. What falls short is bold."""
    name = [row.client, f"`{row.kind}`"]
    if row.error:
        return [*name, ERROR, "", "", ""]
    if not row.frames:
        return [*name, "valid", "", "", ""]
    short = shortfalls(row)
    values = {
        "frames": f"{row.frames} of {face.FRAMES}",
        "worst vertex": number(row.worst, "mm"),
        "worst normal": number(row.worst_normal, "°").replace(" °", "°"),
        "looks": f"{row.looks} of {LOOKS}",
    }
    return [*name, *(f"**{text}**" if column in short else text for column, text in values.items())]


def number(value, unit):
    """With two digits, and no exponent."""
    if value is None:
        return "none"
    if not math.isfinite(value):
        return "no number"
    if value < 0.0005:
        return "0 " + unit
    digits = max(0, 1 - math.floor(math.log10(value)))
    return f"{value:,.{min(digits, 4)}f} {unit}"


def shortfalls(row):
    """The columns in which a row falls short of what the file holds."""
    if row.error:
        return {"frames"}
    if not row.frames:
        return set()
    [kind] = [kind for kind in KINDS if kind.name == row.kind]
    is_near = lambda value, bound: value is not None and value <= bound
    fine = {
        "frames": row.frames == face.FRAMES,
        "worst vertex": is_near(row.worst, kind.error),
        "worst normal": is_near(row.worst_normal, kind.degrees),
        "looks": row.looks >= kind.looks,
    }
    return {column for column, is_fine in fine.items() if not is_fine}


def table(rows):
    lines = [HEAD, ["---"] * len(HEAD), *map(cells, rows)]
    return "".join("| " + " | ".join(line) + " |\n" for line in lines)


def sentences(rows):
    """The list below the table, and what is wrong with it: a cell without a sentence, a sentence without a cell."""
    written = tomllib.loads(SENTENCES.read_text())["shortfall"]
    short = {(row.client, row.kind, column) for row in rows for column in shortfalls(row)}
    wrong, said, lines = [], set(), []
    for sentence in written:
        about = {cell for cell in short if is_about(sentence, *cell)}
        said |= about
        for kind in set(sentence["files"]) - {of for _, of, _ in about}:
            wrong.append(f"{SENTENCES.name}: no longer true of {sentence['program']} with {kind}")
        files = ", ".join(f"`{kind}`" for kind in sentence["files"])
        lines.append(wrapped(f"- **{sentence['program']}**, {files}: {sentence['says']}"))
    wrong += [f"{SENTENCES.name} does not say why: {', '.join(cell)}" for cell in sorted(short - said)]
    return "".join(lines), wrong


def is_about(sentence, client, kind, column):
    """Whether a sentence explains a cell. The program may be the beginning of a name, or `any program`."""
    is_of = sentence["program"] == "any program" or client.startswith(sentence["program"])
    return is_of and kind in sentence["files"] and column in sentence["columns"]


def wrapped(line):
    """A list's item in lines of 120 columns."""
    lines = [""]
    for word in line.split(" "):
        if len(lines[-1]) + len(word) > 119:
            lines.append(" ")
        lines[-1] += (" " if lines[-1] else "") + word
    return "\n".join(lines) + "\n"


def write(page, rows):
    """Writes table and sentences between the marks. Returns an exit code."""
    before, rest = page.read_text().split(BEGIN)
    lines, wrong = sentences(rows)
    page.write_text(f"{before}{BEGIN}\n{table(rows)}\n{lines}\n{END}{rest.split(END)[1]}")
    for one in wrong:
        print(one, file=sys.stderr)
    return int(bool(wrong))


def check(page, rows):
    """Compares rows with those in the page. Returns an exit code."""
    stored = page.read_text().split(BEGIN)[1].split(END)[0]
    lines = [[cell.strip() for cell in line[1:-1].split("|")] for line in stored.splitlines() if line.startswith("| ")]
    kept = {(line[0], line[1].strip("`")): line[2:] for line in lines}
    # assimp is what the system has, and may be of another version.
    kept |= {(without_version(client), kind): values for (client, kind), values in kept.items()}
    faults = []
    for row in rows:
        name = f"{row.client} with {row.kind}"
        before = kept.get((row.client, row.kind)) or kept.get((without_version(row.client), row.kind))
        if before is None:
            faults.append(f"{name} is not in {page.name}")
        elif why := worse(cells(row)[2:], before):
            faults.append(f"{name}: {why} {row.error}".strip())
    for fault in faults:
        print(f"worse than {page}: {fault}", file=sys.stderr)
    if faults:
        print("if this is meant, run `cargo xtask clients`", file=sys.stderr)
    return int(bool(faults))


def without_version(client):
    return re.sub(r" \d.*", "", client)


def worse(now, before):
    """In what the cells of a row are worse than they were; None if in nothing."""
    if now[0] == ERROR or before[0] == ERROR:
        return "an error" if before[0] != ERROR else None
    if now[0] == before[0] == "valid":
        return None
    for column, is_worse in ((0, fewer), (1, larger(MILLIMETRES)), (2, larger(DEGREES)), (3, fewer)):
        if is_worse(now[column], before[column]):
            return f"{HEAD[2 + column]} {now[column]}, not {before[column]}"
    return None


def fewer(now, before):
    return value(now) < value(before)


def larger(by):
    return lambda now, before: value(now) > FACTOR * value(before) + by


def value(cell):
    """The first number of a cell; what has none is beyond all numbers."""
    found = re.match(r"[\d.,]+", cell.strip("*"))
    return float(found[0].replace(",", "")) if found else math.inf
