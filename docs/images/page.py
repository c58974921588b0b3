"""Cuts evaluate.png and plan.png out of the pages that `evaluate` and `coverage` write, as Chromium shows them.

    rhytid evaluate face.toml --truth dense.npy --take TAKE.csv --truth-frames frames.csv --report report
    chromium --headless --hide-scrollbars --window-size=1200,2600 --screenshot=page.png report/evaluation.html
    python docs/images/page.py page.png docs/images/evaluate.png

    rhytid coverage bare.safetensors TAKE.csv --plan 6 --report plan
    chromium --headless --hide-scrollbars --window-size=1200,1500 --screenshot=page.png plan/plan.html
    python docs/images/page.py page.png docs/images/plan.png
"""

import argparse

import numpy as np
from PIL import Image

# Rows of a page with less than this of ink are between its parts.
GAP = 2
# Parts that are at least as high are pictures.
PICTURE = 150
WIDTH = 900


def bands(image):
    """The parts of the page from top to bottom, as ranges of rows."""
    ink = (np.asarray(image.convert("L")) < 250).sum(axis=1) > GAP
    edges = np.flatnonzero(np.diff(np.concatenate([[0], ink.astype(np.int8), [0]])))
    return edges.reshape(-1, 2)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("page")
    parser.add_argument("output")
    arguments = parser.parse_args()
    page = Image.open(arguments.page).convert("RGB")
    # The first run of pictures with their captions: two rows of an evaluation, all of a plan.
    parts = bands(page)
    pictures = [i for i, (top, bottom) in enumerate(parts) if bottom - top >= PICTURE]
    rows = pictures[: 3 if "plan" in arguments.output else 2]
    last = rows[-1] + 1
    while last + 1 < len(parts) and parts[last + 1][0] - parts[last][1] < 12:
        last += 1
    top, bottom = parts[rows[0]][0], parts[min(last, len(parts) - 1)][1]
    cut = page.crop((0, max(top - 10, 0), page.width, bottom + 10))
    cut.resize((WIDTH, round(cut.height * WIDTH / cut.width)), Image.LANCZOS).save(arguments.output, optimize=True)


if __name__ == "__main__":
    main()
