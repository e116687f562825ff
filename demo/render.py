# SPDX-License-Identifier: Apache-2.0
"""Draws lattices, and models deformed by them. Needs VTK 9 and a display:

    xvfb-run -a python3 render.py panel --model M.obj --rest L.vtu --refined R.vtu \\
                                        --posed P.vtu --deformed D.obj -o out.png
    xvfb-run -a python3 render.py pair --model M.obj --rest L.vtu \\
                                       --posed P.vtu --deformed D.obj -o out.png
    xvfb-run -a python3 render.py lattices L0.vtu L1.vtu L2.vtu -o out.png

All panels of a picture have the same view. Models are .obj files, lattices .vtu files.
"""

import argparse

from geometry_files import LatticeFile, points_of, read_model
from images import compose, write_png
from picture import LATTICE, STRATA, Drawing, LatticeStyle, Studio, View


def vector(length):
    def parse(text):
        numbers = tuple(float(word) for word in text.split(","))
        if len(numbers) != length:
            raise argparse.ArgumentTypeError(f"'{text}': expected {length} numbers")
        return numbers
    return parse


def parse_arguments():
    common = argparse.ArgumentParser(add_help=False)
    common.add_argument("-o", "--output", required=True, help="the .png to write")
    common.add_argument("--view", type=vector(3), default=(0.35, 0.25, 1), metavar="X,Y,Z",
                        help="direction to the viewer")
    common.add_argument("--up", type=vector(3), default=(0, 1, 0), metavar="X,Y,Z")
    common.add_argument("--crop", type=vector(4), default=(0, 0, 1, 1), metavar="L,B,R,T",
                        help="left, bottom, right and top of the part to show, as fractions")
    common.add_argument("--height", type=int, default=480, help="of a panel, in pixels")
    common.add_argument("--line", type=float, default=0.0025,
                        help="radius of a base lattice's edges, as a fraction of the height")
    with_model = argparse.ArgumentParser(add_help=False, parents=[common])
    with_model.add_argument("--strata", action="store_true",
                            help="the lattice around the model in the colours of its strata")
    with_model.add_argument("--ground", action="store_true", help="a soft shadow under the model")
    for name in ("model", "rest", "posed", "deformed"):
        with_model.add_argument(f"--{name}", required=True, metavar="FILE")

    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    commands = parser.add_subparsers(dest="command", required=True)
    panel = commands.add_parser("panel", parents=[with_model],
                                help="base lattice, refined lattice, model, deformed model")
    panel.add_argument("--refined", required=True, metavar="FILE")
    panel.set_defaults(draw=draw_panel)
    pair = commands.add_parser("pair", parents=[with_model], help="model and deformed model")
    pair.set_defaults(draw=draw_pair)
    lattices = commands.add_parser("lattices", parents=[common],
                                   help="a lattice and its levels, in the colours of their strata")
    lattices.add_argument("lattices", nargs="+", metavar="FILE")
    lattices.add_argument("--captions", nargs="+", help="one a lattice")
    lattices.set_defaults(draw=draw_lattices)
    return parser.parse_args()


class Page:
    """The style that all panels of a picture share, with equally thick lines."""

    def __init__(self, arguments, shown):
        point_sets = [points_of(thing) for thing in shown]
        self.view = View.around(point_sets, arguments.view, arguments.up, arguments.crop)
        self.arguments = arguments
        self.line = arguments.line * self.view.extent

    def base(self, **changes):
        return LatticeStyle(**{"tube": self.line, "ball": 2.3 * self.line, "colours": STRATA,
                               **changes})

    def refined(self):
        return LatticeStyle(tube=0.5 * self.line, ball=1.2 * self.line, only_corners=True,
                            colours=STRATA, inside=False, hull=1.0)

    def model_in_lattice(self, model, lattice):
        colours = STRATA if self.arguments.strata else (LATTICE,) * 4
        drawing = Drawing().add_model(model)
        drawing.add_lattice(lattice, self.base(inside=False, colours=colours))
        if self.arguments.ground:
            drawing.add_ground_shadow(model, self.arguments.up)
        return drawing

    def write(self, drawings):
        studio = Studio(self.view, self.arguments.height)
        images = [studio.render(drawing) for drawing, _ in drawings]
        write_png(self.arguments.output, compose(images, [caption for _, caption in drawings]))


def read_scene(arguments):
    return (read_model(arguments.model), LatticeFile(arguments.rest), LatticeFile(arguments.posed),
            read_model(arguments.deformed))


def draw_panel(arguments):
    model, rest, posed, deformed = read_scene(arguments)
    refined = LatticeFile(arguments.refined)
    page = Page(arguments, (model, rest, posed, deformed, refined))
    page.write([
        (Drawing().add_ghost(model).add_lattice(rest, page.base()), "Lattice"),
        (Drawing().add_ghost(model).add_lattice(refined, page.refined()), "Refined lattice"),
        (page.model_in_lattice(model, rest), "Model in the lattice"),
        (page.model_in_lattice(deformed, posed), "Deformed model"),
    ])


def draw_pair(arguments):
    model, rest, posed, deformed = read_scene(arguments)
    page = Page(arguments, (model, rest, posed, deformed))
    page.write([(page.model_in_lattice(model, rest), "Before"),
                (page.model_in_lattice(deformed, posed), "After")])


def draw_lattices(arguments):
    lattices = [LatticeFile(path) for path in arguments.lattices]
    captions = arguments.captions or [f"Level {i}" for i in range(len(lattices))]
    if len(captions) != len(lattices):
        raise SystemExit(f"{len(captions)} captions for {len(lattices)} lattices")
    page = Page(arguments, lattices)
    styles = [page.base()] + [page.refined()] * (len(lattices) - 1)
    page.write([(Drawing().add_lattice(lattice, style), caption)
                for lattice, style, caption in zip(lattices, styles, captions)])


if __name__ == "__main__":
    chosen = parse_arguments()
    chosen.draw(chosen)
