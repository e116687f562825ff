# SPDX-License-Identifier: Apache-2.0
"""Poses of whole meshes of second order, judged by Espalier and by Gmsh's plugin AnalyseMeshQuality: for
second_order_test.py and for bench/gmsh_agreement.py."""

import multiprocessing
import queue
import tempfile
from pathlib import Path

import gmsh
import numpy as np

# Of pyramids, the plugin of Gmsh 4.8.4 reports determinants of 0 where they are valid.
TETRAHEDRA, HEXAHEDRA, PRISMS = (11,), (12, 17), (13, 18)
TRIANGLES, QUADRANGLES = (9,), (10, 16)


def in_gmsh(function, *arguments):
    """Runs a function in a process of its own: the plugin aborts when it is run on a second type of elements."""
    def run():
        gmsh.initialize()
        gmsh.option.setNumber("General.Terminal", 0)
        results.put(function(*arguments))
    results = multiprocessing.Queue()
    process = multiprocessing.Process(target=run)
    process.start()
    while True:
        try:
            result = results.get(timeout=1)
            break
        except queue.Empty:
            if not process.is_alive():
                raise RuntimeError("Gmsh ended") from None
    process.join()
    return result


def smallest_determinants(dimension, count, path):
    """The smallest determinant of each of the `count` elements of the dimension of a file, relative to the largest one,
    and the sign of the determinant in the middle. The plugin needs a process for each file: it keeps what it has
    computed."""
    gmsh.open(str(path))
    for name, value in {"JacobianDeterminant": 1, "CreateView": 1, "DimensionOfElements": dimension}.items():
        gmsh.plugin.setNumber("AnalyseMeshQuality", name, value)
    gmsh.plugin.run("AnalyseMeshQuality")
    ratios = {}
    for view in gmsh.view.getTags():
        kind, tags, values, *_ = gmsh.view.getModelData(view, 0)
        if kind == "ElementData":
            ratios.update((tag, value[0]) for tag, value in zip(tags, values))
    if len(ratios) != count:
        raise RuntimeError(f"the plugin has determinants of {len(ratios)} elements; the file has {count}")
    signs = {}
    types, tags, _ = gmsh.model.mesh.getElements(dimension)
    for kind, ofKind in zip(types, tags):
        places = np.reshape(gmsh.model.mesh.getElementProperties(kind)[4], (-1, dimension))
        middle = np.zeros(3)
        middle[:dimension] = places.mean(axis=0)
        jacobians, determinants, _ = gmsh.model.mesh.getJacobians(kind, middle)
        if dimension == 2:
            # The determinant of a face is an area without a sign; that of its normal along z is.
            tangents = np.reshape(jacobians, (-1, 3, 3))
            determinants = np.cross(tangents[:, 0], tangents[:, 1])[:, 2]
        signs.update(zip(ofKind, np.sign(determinants)))
    return [(ratios[tag], signs[tag]) for tag in sorted(ratios)]


def elements_of(path):
    """The dimension of a mesh, and its numbers of elements of this dimension by type."""
    gmsh.open(str(path))
    dimension = 3 if len(gmsh.model.mesh.getElements(3)[0]) else 2
    types, tags, _ = gmsh.model.mesh.getElements(dimension)
    return dimension, {int(kind): len(each) for kind, each in zip(types, tags)}


def compare(espalier, path, poses, seed=1, largest=None):
    """Moves a mesh by random poses of a lattice of 3 x 3 x 3 cells around it, and compares the elements that Espalier and
    Gmsh call folded. Returns (dimension, elements by type, elements folded at rest, poses with folded elements, folded
    elements, [(pose, element, whether Espalier calls it folded, smallest determinant of Gmsh, relative to the largest)]).
    A pose of -1 is rest."""
    dimension, types = in_gmsh(elements_of, path)
    if largest is None:
        largest = 0.3 if dimension == 3 else 0.8  # of the size of the mesh
    count = sum(types.values())
    model = espalier.read_model(path)
    check = espalier.MeshCheck(model)
    if check.cell_count != count:
        raise RuntimeError(f"{check.cell_count} cells, Gmsh has {count} elements")
    points = model.positions
    low, high = points.min(axis=0), points.max(axis=0)
    spans = high - low
    thick = spans.max() * 0.01
    lattice = espalier.shapes.box(cells=(3, 3, 3), min=low - 0.01 * spans - thick, max=high + 0.01 * spans + thick)
    binding = espalier.bind(lattice, points)
    random = np.random.default_rng(seed)
    folded, deviations = np.zeros((poses, count), bool), []
    bad = np.zeros(count, bool)
    bad[check.bad_at_rest] = True
    with tempfile.TemporaryDirectory() as folder:
        model.write(Path(folder) / "rest.msh", points)
        paths = [Path(folder) / "rest.msh"]
        for i in range(poses):
            moves = random.uniform(-1, 1, lattice.positions.shape) * spans * largest * (i + 1) / poses
            if dimension == 2:
                moves[:, spans == 0] = 0
            pose = binding.deform(lattice.positions + moves)
            folded[i, check.check(pose).inverted] = True
            paths.append(Path(folder) / f"{i}.msh")
            model.write(paths[-1], pose)
        determinants = np.array([in_gmsh(smallest_determinants, dimension, count, each) for each in paths])
    ratios, signs = np.moveaxis(determinants, 2, 0)
    # A solid is left-handed if most of its elements are; a face may have any side in front.
    sides = np.full(count, np.sign(np.median(signs[0]))) if dimension == 3 else signs[0]
    theirs = ~((ratios > 0) & (signs == sides))
    for element in np.flatnonzero(bad != theirs[0]):
        deviations.append((-1, int(element), bool(bad[element]), float(ratios[0, element])))
    sound = ~(bad | theirs[0])
    for pose, element in zip(*np.nonzero((folded != theirs[1:]) & sound)):
        deviations.append((int(pose), int(element), bool(folded[pose, element]), float(ratios[pose + 1, element])))
    return (dimension, types, int(bad.sum()), int((folded & sound).any(axis=1).sum()), int((folded & sound).sum()),
            deviations)
