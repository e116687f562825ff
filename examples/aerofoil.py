#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Optimises the shape of an aerofoil section with SciPy, through a lattice.

    aerofoil.py --program espalier --work FOLDER

A NACA 0012 section is in a lattice that is one cell thick. The lattice is deformed until the
pressure on the section is the pressure on NACA 4412 at the same incidence, while the section keeps
its area and both its ends. The program writes D once. Then the points are D · vertices, and Dᵀ
carries a gradient by the points to the vertices.

Needs NumPy and SciPy. Debian's packages (python3-numpy, python3-scipy) work with /usr/bin/python3
only; if python3 is a different one, run `/usr/bin/python3 aerofoil.py ...`.
"""

import argparse
import pathlib
import shutil
import subprocess
import sys

import numpy as np
import scipy.optimize
import scipy.sparse

from panel_method import Flow, area, naca

PANELS, INCIDENCE = 120, np.radians(2)
COMMANDS = ("shape box --cells 8 1 1 --min -0.1 -0.12 0 --max 1.1 0.12 0.1 -o rest.ovm",
            "stencils rest.ovm --points section.obj --outside error -n 3 -o D.npz",
            "deform section.obj --rest rest.ovm --to pose.ovm -n 3 -o optimised.obj")


class Design:
    """The section as a function of the variables. A variable moves one vertex of the lattice up,
    together with the vertex on the other side of the section.

    `weight` has the share of the chord of each panel.
    """

    def __init__(self, points, deformation, rest, wanted):
        self.points, self.deformation, self.wanted = points, deformation, wanted
        _, variable = np.unique(np.round(rest[:, :2], 9), axis=0, return_inverse=True)
        variable = variable.ravel()  # NumPy 2.0 returns an extra axis
        self.link = scipy.sparse.csr_matrix((np.ones(len(rest)), (range(len(rest)), variable)))
        self.weight = abs(np.roll(points.real, -1) - points.real)

    def section(self, variables):
        return self.points + 1j * (self.deformation @ (self.link @ variables))

    def pull_back(self, by_points):
        """Carries a gradient by the points to the vertices, by Dᵀ, and on to the variables."""
        return self.link.T @ (self.deformation.T @ by_points.imag)

    def objective(self, variables):
        """Half the squared difference of the pressure from the wanted pressure, along the chord,
        and its gradient."""
        flow = Flow(self.section(variables), INCIDENCE)
        miss = flow.pressure - self.wanted
        by_points = flow.gradient(-2 * flow.strength * self.weight * miss)
        return self.weight @ miss**2 / 2, self.pull_back(by_points)

    def area_gain(self, variables):
        """The growth of the area of the section, and its gradient."""
        value, by_points = area(self.section(variables))
        return value - area(self.points)[0], self.pull_back(by_points)

    def optimise(self):
        """Runs sequential quadratic programming, with the area and both ends fixed."""
        ends = (self.deformation @ self.link)[[0, PANELS // 2]].toarray()
        held = [{"type": "eq", "fun": lambda q: ends @ q, "jac": lambda q: ends},
                {"type": "eq", "fun": lambda q: self.area_gain(q)[0],
                 "jac": lambda q: self.area_gain(q)[1]}]
        return scipy.optimize.minimize(self.objective, np.zeros(self.link.shape[1]), jac=True,
                                       method="SLSQP", constraints=held, options={"ftol": 1e-9})


def wanted_pressure(points):
    """The pressure on the wanted section for each panel of `points`, at the same x and side."""
    x, flow = Flow(points, INCIDENCE).middle.real, Flow(naca(0.04, 0.12, PANELS), INCIDENCE)
    half = PANELS // 2
    above = np.interp(x[:half], flow.middle.real[half - 1::-1], flow.pressure[half - 1::-1])
    return np.append(above, np.interp(x[half:], flow.middle.real[half:], flow.pressure[half:]))


def write_section(path, points):
    lines = [f"v {p.real:.17g} {p.imag:.17g} 0.05" for p in points]
    loop = " ".join(str(i + 1) for i in [*range(len(points)), 0])
    path.write_text("\n".join([*lines, f"l {loop}\n"]), encoding="ascii")


def read_lattice(path):
    """Returns the lines of an .ovm file, the slice of the vertices, and their positions."""
    lines = path.read_text(encoding="ascii").splitlines()
    first = lines.index("Vertices") + 2
    rows = slice(first, first + int(lines[first - 1]))
    return lines, rows, np.array([line.split() for line in lines[rows]], float)


def parse_arguments():
    parser = argparse.ArgumentParser(description=__doc__.split("\n", maxsplit=1)[0])
    parser.add_argument("--program", default="espalier", help="name or path of espalier")
    parser.add_argument("--work", type=pathlib.Path, required=True, help="for what is written")
    return parser.parse_args()


def main():
    arguments = parse_arguments()
    work = arguments.work
    work.mkdir(parents=True, exist_ok=True)
    program = shutil.which(arguments.program) or sys.exit(f"{arguments.program}: not a program")

    def espalier(command):
        done = subprocess.run([pathlib.Path(program).resolve(), *command.split(), "--quiet"],
                              cwd=work, check=False)
        if done.returncode:  # the program has printed why
            sys.exit(f"{arguments.program} {' '.join(command.split()[:2])}: failed")

    points = naca(0, 0.12, PANELS)
    write_section(work / "section.obj", points)
    espalier(COMMANDS[0])
    espalier(COMMANDS[1])
    lines, rows, rest = read_lattice(work / "rest.ovm")
    design = Design(points, scipy.sparse.load_npz(work / "D.npz"), rest, wanted_pressure(points))
    result = design.optimise()
    if not result.success:
        sys.exit(f"no optimum was found: {result.message}")
    optimised = design.section(result.x)

    before, after = Flow(points, INCIDENCE), Flow(optimised, INCIDENCE)
    for name, flow, section, variables in (("before", before, points, 0 * result.x),
                                           ("after", after, optimised, result.x)):
        print(f"{name:6}  objective {design.objective(variables)[0]:.3e}  lift {flow.lift:.4f}  "
              f"area {area(section)[0]:.6f}")
    print(f"{result.nit} iterations, {result.nfev} flows")
    np.savetxt(work / "pressures.txt", header="x, pressure before, wanted, after",
               X=np.transpose([before.middle.real, before.pressure, design.wanted, after.pressure]))

    pose = rest.copy()
    pose[:, 1] += design.link @ result.x
    lines[rows] = [" ".join(f"{x:.17g}" for x in p) for p in pose]
    (work / "pose.ovm").write_text("\n".join(lines) + "\n", encoding="ascii")
    espalier(COMMANDS[2])


if __name__ == "__main__":
    main()
