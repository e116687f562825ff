# SPDX-License-Identifier: Apache-2.0
r"""Draws the figures of docs/gallery.md from files that the program writes, and writes the page.

    xvfb-run -a python3 gallery.py --program espalier --examples FOLDER --work FOLDER \
        --docs FOLDER [NAME...]

With NAMEs, draws only these figures, and does not write the page.
"""

import argparse
import pathlib
import sys

import gallery_bases
import gallery_cages
import gallery_cells
import gallery_curves
import gallery_lattices
import gallery_patch
import gallery_polyhedra
import gallery_poses
import gallery_rats
import gallery_solvers
import gallery_splats
import gallery_wing
from gallery_page import Entry, demo_entries, write_page
from gallery_parts import Program
from palette import write_palette_png

#: Headings, figures of scripts/demo, and figures to draw.
SECTIONS = (
    ("Lattices and their cells", [], gallery_lattices.FIGURES + gallery_cells.FIGURES),
    ("Deformations", demo_entries(), gallery_poses.FIGURES + gallery_cages.FIGURES +
     gallery_splats.FIGURES + gallery_bases.FIGURES),
    ("Curves and a patch", [], gallery_curves.FIGURES + gallery_patch.FIGURES),
    ("Polyhedra", [], gallery_polyhedra.FIGURES),
    ("RATS splines", [], gallery_rats.FIGURES),
    ("Gradients and solvers", [], gallery_solvers.FIGURES + gallery_wing.FIGURES),
)


def parse_arguments():
    parser = argparse.ArgumentParser(description=__doc__.split("\n", maxsplit=1)[0])
    parser.add_argument("--program", type=pathlib.Path, required=True, help="espalier")
    parser.add_argument("--examples", type=pathlib.Path, required=True,
                        help="the folder of the examples that are built")
    parser.add_argument("--work", type=pathlib.Path, required=True, help="for what it writes")
    parser.add_argument("--docs", type=pathlib.Path, required=True,
                        help="the folder of gallery.md and figures/gallery")
    parser.add_argument("names", nargs="*", metavar="NAME")
    arguments = parser.parse_args()
    unknown = set(arguments.names) - {figure.name for _, _, figures in SECTIONS
                                      for figure in figures}
    if unknown:
        sys.exit(f"no figure is called {', '.join(sorted(unknown))}")
    return arguments


def draw(figure, arguments):
    """Draws a figure into its file, and returns its entry of the page."""
    print(figure.name, flush=True)
    folder = arguments.work / figure.name
    folder.mkdir(parents=True, exist_ok=True)
    scripts = pathlib.Path(__file__).resolve().parent.parent / "examples"
    places = [arguments.program.resolve().parent, arguments.examples.resolve(), scripts,
              pathlib.Path(sys.executable).parent]
    program = Program(places, folder)
    image = f"figures/gallery/{figure.name}.png"
    (arguments.docs / image).parent.mkdir(parents=True, exist_ok=True)
    write_palette_png(arguments.docs / image, figure.draw(program))
    caption = figure.caption.format(**program.numbers)
    return Entry(figure.title, figure.source, caption, image, program.commands)


def main():
    arguments = parse_arguments()
    page = []
    for heading, entries, figures in SECTIONS:
        chosen = [f for f in figures if not arguments.names or f.name in arguments.names]
        page.append((heading, entries + [draw(figure, arguments) for figure in chosen]))
    if not arguments.names:
        write_page(arguments.docs / "gallery.md", page)


if __name__ == "__main__":
    main()
