# SPDX-License-Identifier: Apache-2.0
"""What the program, C and Python must do alike: one list, which front_ends_test.py runs by all of them.

A scenario is a lattice, made by `espalier shape`; what its points are bound to; and what happens to points outside.
The words are those of the options of the program."""
from dataclasses import dataclass, field


@dataclass(frozen=True)
class Scenario:
    lattice: tuple  # arguments of `espalier shape`
    to: str = "level"  # "level", "limit" or a basis
    level: int = 2
    outside: str = "keep"
    refinement: dict = field(default_factory=dict)  # options of the program: {"rules": "cse96"}
    falloff: float = 0
    weights: str = ""  # a colour of the points
    marks: bool = False  # two semi-sharp edges with a common vertex, and a semi-sharp vertex

    def name(self):
        words = [" ".join(map(str, self.lattice)), self.to, self.level if self.to == "level" else "", self.outside,
                 f"falloff {self.falloff}" if self.falloff else "", self.weights,
                 *(f"{key} {value}" for key, value in self.refinement.items()), "marks" if self.marks else ""]
        return ", ".join(str(word) for word in words if word != "")


BOX = ("box", "--cells", 3, 4, 3, "--min", -1, -1, -1, "--max", 1, 1, 1)
FINE_BOX = ("box", "--cells", 6, 6, 6, "--min", -1, -1, -1, "--max", 1, 1, 1)
CYLINDER = ("cylinder", "--sectors", 5, "--layers", 2, "--from", 0, 0, -1, "--to", 0, 0, 1)

SCENARIOS = [
    Scenario(BOX, level=1),
    Scenario(BOX, level=3),
    Scenario(CYLINDER, level=3),
    Scenario(("star", "--rings", 2), level=2),
    Scenario(("dodecahedron",), level=3),
    Scenario(("torus", "--section", "disk", "--major-radius", 0.7), level=2),
    Scenario(("arm",), level=2),
    Scenario(BOX, to="limit"),
    Scenario(CYLINDER, to="limit"),
    Scenario(("octahedron",), to="limit", outside="nearest"),
    Scenario(BOX, to="bezier"),
    Scenario(FINE_BOX, to="bspline"),
    Scenario(FINE_BOX, to="bspline", outside="nearest"),
    Scenario(CYLINDER, level=2, outside="nearest"),
    Scenario(CYLINDER, falloff=2),
    Scenario(BOX, weights="green"),
    Scenario(("star", "--rings", 2), to="limit", falloff=1, weights="red"),
    Scenario(FINE_BOX, to="bezier", weights="blue"),
    Scenario(CYLINDER, refinement={"rules": "cse96"}),
    Scenario(CYLINDER, refinement={"rules": "mlca"}),
    Scenario(BOX, refinement={"boundary": "edge-only"}),
    Scenario(BOX, refinement={"boundary": "open"}),
    Scenario(CYLINDER, refinement={"sharp-edges": "literal"}),
    Scenario(("prism", "--sides", 3), refinement={"triangles": "smooth"}),
    Scenario(CYLINDER, marks=True),
    Scenario(CYLINDER, marks=True, refinement={"creasing": "chaikin"}),
    Scenario(CYLINDER, marks=True, to="limit"),
]
