# SPDX-License-Identifier: Apache-2.0
"""Writes docs/gallery.md: pictures, their captions, and the commands that made their files."""

import re
from dataclasses import dataclass

import scenes

INTRODUCTION = """# Gallery

The figures of the five papers, drawn again from files that the program writes, and pictures of the
examples. The commands under a picture are the ones that made its files. `scripts/figures` makes all
pictures and this page.

To repeat the commands, put the program and the examples on the path, and run them in the folder of
their inputs: `out/gallery/NAME/` for `figures/gallery/NAME.png`, and `out/` for the star, the
barbell, the arm and the cage. The colours are those of Okabe and Ito, which colour-blind readers can
tell apart.
"""

REFERENCES = """## The papers

- R. MacCracken, K. I. Joy. *Free-form deformations with lattices of arbitrary topology.*
  SIGGRAPH 96.
- K. I. Joy, R. MacCracken. *The refinement rules for Catmull-Clark solids.* UC Davis, CSE-96-1,
  1996.
- K. I. Joy. *Bicubic uniform B-spline surface refinement.* On-line geometric modeling notes.
- S. Z. Zaini Azlan, M. Y. Misro. *Construction of Catmull-Clark subdivision scheme.* 2021.
- A. Savva, G. J. Clapworthy. *The relation between RATS-splines and the Catmull and Clark
  B-splines.*
"""

MACCRACKEN_JOY = "MacCracken & Joy 1996, Figure {}"


@dataclass
class Entry:
    """A picture of the page."""

    title: str
    source: str
    caption: str
    image: str
    commands: list


def demo_entries():
    """The pictures that scripts/demo draws."""
    return [
        demo_entry("star", "A disk becomes a star",
                   MACCRACKEN_JOY.format(7),
                   "A round lattice of ten sectors, the refined lattice, the disk inside it, and "
                   "the result after the outermost vertices are moved out and in by turns. In this "
                   "picture and the next two, the model at rest is grey and the lattice has the "
                   "colours of the first picture; the deformed model has its own colours, and its "
                   "lattice is orange."),
        demo_entry("barbell", "A block becomes a barbell",
                   MACCRACKEN_JOY.format(8),
                   "The lattice is a flat mesh in the shape of a block, extruded. Its pose is a "
                   "barbell. The checkerboard runs without seams from the bar into the ends."),
        demo_entry("figure", "An arm is lifted",
                   MACCRACKEN_JOY.format(9),
                   "The lattice is built around the arm alone, along its bones. Its pose lifts the "
                   "arm and turns the palm to the viewer. Everything outside the lattice stays."),
        demo_entry("cage", "A figure waves",
                   "shape cage",
                   "A cage around the whole figure, made from the model alone. The arm and the head move by "
                   "their own vertices; no point of the legs and the hips moves by a bit."),
    ]


def demo_entry(scene, title, source, caption):
    model = scenes.MODELS[scene]
    commands = [f"# {model}.obj: the {model} of scripts/demo", *scenes.commands(scene)]
    return Entry(title, source, caption, f"figures/{scene}.png", commands)


def write_page(path, sections):
    """Writes the page. `sections` are pairs of a heading and entries."""
    parts = [INTRODUCTION]
    for heading, entries in sections:
        parts.append(f"## {heading}\n")
        parts += [entry_text(entry) for entry in entries]
    path.write_text("\n".join([*parts, REFERENCES]), encoding="utf-8")


def entry_text(entry):
    commands = "\n".join(wrapped(command) for command in entry.commands)
    return (f"### {entry.title}\n\n![{entry.title}]({entry.image})\n\n"
            f"{filled(f'**{entry.source}.** {entry.caption}')}\n\n```sh\n{commands}\n```\n")


def filled(text, width=100, between=" "):
    """Wraps text to lines of at most `width` characters, broken at `between`."""
    lines = [""]
    for part in re.split(between, text):
        if lines[-1] and len(lines[-1]) + 1 + len(part) > width:
            lines.append("")
        lines[-1] = f"{lines[-1]} {part}".strip()
    return "\n".join(lines)


def wrapped(command, width=100):
    """Wraps a command to lines that the shell joins, with each option next to its values."""
    return filled(command, width - 6, " (?=-[-a-z])").replace("\n", " \\\n    ")
