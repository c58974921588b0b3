"""Cuts rows out of the pages that `evaluate` and `coverage` write, as Chromium shows them.

    rhytid evaluate face.toml --truth dense.npy --take TAKE.csv --truth-frames frames.csv --report report
    chromium --headless --hide-scrollbars --window-size=900,2020 --screenshot=page.png report/evaluation.html
    python docs/images/page.py page.png docs/images/evaluate.png 1345 2020

    rhytid coverage bare.safetensors TAKE.csv --plan 6 --report plan
    chromium --headless --hide-scrollbars --window-size=900,1120 --screenshot=page.png plan/plan.html
    python docs/images/page.py page.png docs/images/plan.png 0 1120
"""

import argparse

from PIL import Image


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("page")
    parser.add_argument("output")
    parser.add_argument("top", type=int)
    parser.add_argument("bottom", type=int)
    arguments = parser.parse_args()
    page = Image.open(arguments.page).convert("RGB")
    cut = page.crop((0, arguments.top, page.width, arguments.bottom))
    cut.quantize(256).save(arguments.output, optimize=True)


if __name__ == "__main__":
    main()
