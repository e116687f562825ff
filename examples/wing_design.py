#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Lowers the induced drag of a wing at the same lift, by 20 variables of a lattice around it, and moves its mesh along.

    wing_design.py --work FOLDER [MESH.su2 --marker wing --span z]

A lattice is around the wing; its outer vertices stay. Five nodes of a reference axis turn and stretch the sections, and ten
shapes bend and thicken them. Each step moves the points of the whole mesh, checks all its cells, and computes lift and
drag by the panel method; Dᵀ carries the gradient by the points to the variables. Without MESH.su2 the program makes
the mesh of a straight wing.

Needs the Python module espalier, NumPy and SciPy.
"""

import argparse
import pathlib
import sys
import time

import numpy as np
import scipy.optimize
import scipy.sparse

import espalier
from espalier.dvgeometry import DVGeometry
from wing_flow import Wing
from wing_mesh import make_mesh, read_triangles, write_su2

NODES, STRIPS, PANELS, INCIDENCE = 5, 8, 60, np.radians(4)
STEPS = 10
#: The variables of a unit of the optimiser, and how far they may go.
GROUPS = {"twist": (3.0, 4.0), "chord": (0.1, 0.15), "camber": (0.02, 0.03), "thickness": (0.02, 0.03)}


def lattice_around(points, triangles, axis):
    """A box around the wing, a chord away from it, and the vertices that hold its sides and their tangents. The side in the
    plane of symmetry is free, but nothing moves along the span."""
    wing = points[np.unique(triangles)]
    low, high = wing.min(axis=0), wing.max(axis=0)
    chord, up = high[0] - low[0], 3 - axis
    middle = (low + high) / 2
    low[0], high[0] = low[0] - 0.9 * chord, high[0] + 0.9 * chord
    low[up], high[up] = middle[up] - 0.9 * chord, middle[up] + 0.9 * chord
    high[axis] += 0.35 * (high[axis] - low[axis])
    cells = np.zeros(3, int)
    cells[[0, up, axis]] = 12, 8, 11
    lattice = espalier.shapes.box(cells=cells.tolist(), min=low.tolist(), max=high.tolist())
    centres = np.array([lattice.positions[lattice.faces[face]].mean(axis=0) for face in lattice.boundary_faces])
    outer = lattice.boundary_faces[np.abs(centres[:, axis] - low[axis]) > 1e-9 * chord]
    return lattice, espalier.hold(lattice, faces=outer, continuity="c1")


def make_geometry(points, triangles, axis):
    """The lattice with its 20 variables."""
    lattice, held = lattice_around(points, triangles, axis)
    wing, up = points[np.unique(triangles)], 3 - axis
    ends = wing[:, axis].min(), wing[:, axis].max()
    nodes, chords = [], []
    for place in np.linspace(*ends, NODES):
        near = wing[np.abs(wing[:, axis] - place) < 0.06 * (ends[1] - ends[0])]
        chords.append(np.ptp(near[:, 0]))
        node = near.mean(axis=0)
        node[0], node[axis] = near[:, 0].min() + 0.25 * chords[-1], place
        nodes.append(node)
    # The vertices near the wing; between them and the sides, the lattice gives way.
    rest = lattice.positions
    quarter = np.array([np.interp(rest[:, axis], np.linspace(*ends, NODES), np.array(nodes)[:, c]) for c in range(3)])
    chord = np.interp(rest[:, axis], np.linspace(*ends, NODES), chords)
    along, above = (rest[:, 0] - quarter[0]) / chord + 0.25, (rest[:, up] - quarter[up]) / chord
    near = (np.abs(along - 0.5) < 0.75) & (np.abs(above) < 0.45)
    near[held] = False

    geo = DVGeometry(lattice, level=3, frozen=held)
    span = np.eye(3)[axis]
    geo.addRefAxis("axis", curve=nodes, axis=span, vertices=np.flatnonzero(near))
    turn = f"rot_{'xyz'[axis]}"
    # A turn about y raises the nose, and a turn about z lowers it.
    sign = 1 if axis == 1 else -1

    def twist(values, geo):
        getattr(geo, turn)["axis"].coef[:] = sign * values

    def chord_of(values, geo):
        geo.scale_x["axis"].coef[:] = values

    geo.addGlobalDV("twist", np.zeros(NODES), twist)
    geo.addGlobalDV("chord", np.ones(NODES), chord_of)
    camber, thickness = [], []
    bump = 4 * np.clip(along, 0, 1) * (1 - np.clip(along, 0, 1)) * chord
    for k in range(NODES):
        share = np.interp(rest[:, axis], np.linspace(*ends, NODES), np.eye(NODES)[k]) * bump
        rows = np.flatnonzero(near & (share > 0))
        vector = np.eye(3)[up]
        camber.append({v: share[v] * vector for v in rows})
        thickness.append({v: share[v] * np.sign(above[v]) * vector for v in rows if above[v] != 0})
    geo.addShapeFunctionDV("camber", camber)
    geo.addShapeFunctionDV("thickness", thickness)
    return geo


class Design:
    """The wing as a function of its variables, and the table of the steps."""

    def __init__(self, model, triangles, axis):
        self.model, self.points = model, np.array(model.positions)
        self.geo = make_geometry(self.points, triangles, axis)
        self.geo.addPointSet(self.points, "mesh")
        self.check = espalier.MeshCheck(model)
        self.wing = Wing(self.points, triangles, axis, STRIPS, PANELS, INCIDENCE)
        self.rest = self.geo.getValues()
        self.thick = [self.wing.sections[k].tocsr()[[PANELS // 4, PANELS - PANELS // 4]] for k in range(STRIPS)]
        self.rows, self.seen = [], (None, None)
        self.start = self.evaluate(np.zeros(self.geo.getNDV()))

    def unit(self, name):
        return GROUPS[name][0]

    def evaluate(self, variables):
        """Returns lift, drag and thicknesses, and their gradients by the variables."""
        if self.seen[0] is not None and np.array_equal(self.seen[0], variables):
            return self.seen[1]
        values, first = {}, 0
        for name, start in self.rest.items():
            values[name] = start + self.unit(name) * variables[first:first + len(start)]
            first += len(start)
        self.geo.setDesignVars(values)
        points = self.geo.update("mesh")
        lift, drag, by_lift, by_drag = self.wing.evaluate(points)
        places = np.vstack([rows @ points for rows in self.thick])
        pairs = np.arange(2 * STRIPS).reshape(-1, 2)
        thickness, by_places = espalier.constraints.distances(places, pairs)
        by_points = espalier.constraints.by_vertices(by_places, scipy.sparse.vstack(self.thick).tocsr())
        gradients = np.vstack([by_lift.reshape(1, -1), by_drag.reshape(1, -1), by_points.csr().toarray()])
        back = self.geo.totalSensitivity(gradients.reshape(len(gradients), -1, 3), "mesh")
        scaled = np.hstack([self.unit(name) * each for name, each in back.items()])
        self.seen = variables.copy(), (lift, drag, thickness, scaled[0], scaled[1], scaled[2:], points)
        return self.seen[1]

    def note(self, variables):
        """Adds a row to the table. The mesh must be valid."""
        lift, drag, thickness, *_, points = self.evaluate(variables)
        validity = self.check.check(points)
        self.rows.append((lift, drag, (thickness / self.start[2]).min(), validity.smallest[1], len(validity.inverted)))
        print("{:4}  {:8.5f}  {:8.6f}  {:8.4f}  {:13.3f}  {:8}".format(len(self.rows) - 1, *self.rows[-1]), flush=True)

    def optimise(self, steps):
        """Runs sequential quadratic programming: less drag, the same lift, no section thinner than before."""
        print("step      lift      drag  thickness  volume ratio  inverted")
        lift, drag, thickness, *_ = self.start
        held = [{"type": "eq", "fun": lambda q: self.evaluate(q)[0] / lift - 1,
                 "jac": lambda q: self.evaluate(q)[3] / lift},
                {"type": "ineq", "fun": lambda q: self.evaluate(q)[2] / thickness - 1,
                 "jac": lambda q: self.evaluate(q)[5] / thickness[:, None]}]
        bounds = [(-far / unit, far / unit) for name, start in self.rest.items() for unit, far in [GROUPS[name]]
                  for _ in start]
        self.note(np.zeros(len(bounds)))
        return scipy.optimize.minimize(
            lambda q: self.evaluate(q)[1] / drag, np.zeros(len(bounds)), jac=lambda q: self.evaluate(q)[4] / drag,
            method="SLSQP", bounds=bounds, constraints=held, callback=self.note, options={"maxiter": steps, "ftol": 1e-10})


def parse_arguments():
    parser = argparse.ArgumentParser(description=__doc__.split("\n", maxsplit=1)[0])
    parser.add_argument("mesh", nargs="?", type=pathlib.Path, help="mesh of SU2; by default a straight wing")
    parser.add_argument("--marker", default="wing", help="the marker of the wing's surface (wing)")
    parser.add_argument("--span", choices="yz", default="z", help="the axis along the span, from the plane of symmetry (z)")
    parser.add_argument("--steps", type=int, default=STEPS, help=f"steps of the optimiser ({STEPS})")
    parser.add_argument("--work", type=pathlib.Path, required=True, help="for what is written")
    return parser.parse_args()


def main():
    arguments, start = parse_arguments(), time.perf_counter()
    arguments.work.mkdir(parents=True, exist_ok=True)
    mesh = arguments.mesh
    if mesh is None:
        mesh = arguments.work / "wing.su2"
        write_su2(mesh, *make_mesh())
    try:
        triangles = read_triangles(mesh, arguments.marker)
        design = Design(espalier.read_model(mesh), triangles, "xyz".index(arguments.span))
    except (OSError, ValueError) as error:
        sys.exit(f"wing_design.py: {error}")
    print(f"{len(design.points)} points, {design.check.cell_count} cells, {design.geo.getNDV()} variables, "
          f"{len(design.geo.lattice.positions)} vertices")
    before = design.wing.circulation
    result = design.optimise(arguments.steps)
    *_, points = design.evaluate(result.x)
    design.wing.evaluate(points)
    np.savetxt(arguments.work / "strips.txt", header="place along the span, circulation before, after",
               X=np.transpose([design.wing.middle, before, design.wing.circulation]))
    espalier.read_model(mesh).write(arguments.work / "optimised.su2", points)
    design.geo.lattice.write(arguments.work / "rest.vtu")
    design.geo.writeTecplot(arguments.work / "pose.vtu")
    print(f"{100 * (1 - design.rows[-1][1] / design.rows[0][1]):.1f} % less drag at {design.rows[-1][0]:.4f} of lift, in "
          f"{time.perf_counter() - start:.1f} s")
    if any(row[-1] for row in design.rows):
        sys.exit("wing_design.py: a step turned cells inside out")


if __name__ == "__main__":
    main()
