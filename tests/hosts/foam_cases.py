# SPDX-License-Identifier: Apache-2.0
"""Makes cases of OpenFOAM for the tests and the benchmark, by OpenFOAM's own programs."""

import os
import pathlib
import re
import shutil
import subprocess

# Debian's programs do not set this.
ENVIRONMENT = {"WM_PROJECT_DIR": "/usr/share/openfoam", **os.environ}
PROGRAMS = ("blockMesh", "checkMesh", "snappyHexMesh", "polyDualMesh", "gmshToFoam")


def is_installed():
    return all(shutil.which(program) for program in PROGRAMS)


def dictionary(name, text):
    return f"FoamFile\n{{\n version 2.0; format ascii; class dictionary; object {name};\n}}\n{text}\n"


class ProgramFailed(RuntimeError):
    def __init__(self, command, output):
        super().__init__(f"{command} failed:\n{output[-3000:]}")
        self.output = output


def run(case, *command, timeout=300):
    """Runs a program in the folder of a case, and returns what it prints."""
    result = subprocess.run(command, cwd=case, env=ENVIRONMENT, text=True, timeout=timeout,
                            stdout=subprocess.PIPE, stderr=subprocess.STDOUT)
    if result.returncode != 0:
        raise ProgramFailed(command, result.stdout)
    return result.stdout


def make_case(case, write_format="ascii", application="icoFoam"):
    """Makes the folders and dictionaries that all programs need."""
    case = pathlib.Path(case)
    (case / "system").mkdir(parents=True)
    (case / "constant").mkdir()
    texts = {
        "controlDict": f"""application {application}; startFrom startTime; startTime 0; stopAt endTime;
            endTime 1; deltaT 1; writeControl timeStep; writeInterval 1; writeFormat {write_format};
            writePrecision 15; timeFormat general; timePrecision 8; runTimeModifiable false;""",
        "fvSchemes": """ddtSchemes {default Euler;} gradSchemes {default Gauss linear;}
            divSchemes {default none;} laplacianSchemes {default Gauss linear corrected;}
            interpolationSchemes {default linear;} snGradSchemes {default corrected;}""",
        "fvSolution": "solvers {}",
    }
    for name, text in texts.items():
        (case / "system" / name).write_text(dictionary(name, text))
    return case


def block_mesh(case, cells=(6, 6, 6), grading=(1, 2, 4), **options):
    """A box of hexahedra with a boundary layer."""
    case = make_case(case, **options)
    (case / "system/blockMeshDict").write_text(dictionary("blockMeshDict", f"""scale 1;
        vertices ((0 0 0)(1 0 0)(1 1 0)(0 1 0)(0 0 1)(1 0 1)(1 1 1)(0 1 1));
        blocks (hex (0 1 2 3 4 5 6 7) ({' '.join(map(str, cells))})
                simpleGrading ({' '.join(map(str, grading))}));
        edges ();
        boundary
        (
            sides {{type wall; faces ((0 4 7 3)(2 6 5 1)(1 5 4 0)(3 7 6 2));}}
            bottom {{type wall; faces ((0 3 2 1));}}
            top {{type wall; faces ((4 5 6 7));}}
        );"""))
    run(case, "blockMesh")
    return case


def mesh_of_block(case, vertices, block, patches):
    """One block with patches of given types: {name: (type and further entries, faces)}."""
    case = make_case(case)
    boundary = "".join(f"{name} {{type {kind}; faces ({faces});}}\n" for name, (kind, faces) in patches.items())
    (case / "system/blockMeshDict").write_text(dictionary(
        "blockMeshDict", f"scale 1; vertices ({vertices}); blocks (hex {block} simpleGrading (1 2 1)); edges (); "
                         f"boundary ({boundary});"))
    run(case, "blockMesh")
    return case


BOX_VERTICES = "(0 0 0)(1 0 0)(1 1 0)(0 1 0)(0 0 1)(1 0 1)(1 1 1)(0 1 1)"


def flat_mesh(case):
    """A mesh of two dimensions, periodic along x, over a plane of symmetry."""
    return mesh_of_block(case, BOX_VERTICES, "(0 1 2 3 4 5 6 7) (6 5 1)", {
        "left": ("cyclic; neighbourPatch right", "(0 4 7 3)"), "right": ("cyclic; neighbourPatch left", "(2 6 5 1)"),
        "bottom": ("symmetryPlane", "(1 5 4 0)"), "top": ("wall", "(3 7 6 2)"),
        "frontAndBack": ("empty", "(0 3 2 1) (4 5 6 7)")})


def periodic_mesh(case):
    """A box that is periodic along x and z."""
    return mesh_of_block(case, BOX_VERTICES, "(0 1 2 3 4 5 6 7) (4 4 4)", {
        "left": ("cyclic; neighbourPatch right", "(0 4 7 3)"), "right": ("cyclic; neighbourPatch left", "(2 6 5 1)"),
        "back": ("cyclic; neighbourPatch front", "(0 3 2 1)"), "front": ("cyclic; neighbourPatch back", "(4 5 6 7)"),
        "bottom": ("symmetry", "(1 5 4 0)"), "top": ("wall", "(3 7 6 2)")})


def wedge_mesh(case):
    """A mesh with an axis of symmetry along x."""
    return mesh_of_block(case, "(0 0 0)(1 0 0)(1 0.5 -0.02)(0 0.5 -0.02)(1 0.5 0.02)(0 0.5 0.02)",
                         "(0 1 2 3 0 1 4 5) (8 5 1)", {
                             "back": ("wedge", "(0 3 2 1)"), "front": ("wedge", "(0 1 4 5)"),
                             "inlet": ("patch", "(0 0 5 3)"), "outlet": ("patch", "(1 2 4 1)"),
                             "hull": ("wall", "(3 5 4 2)"), "axis": ("empty", "(0 1 1 0)")})


def snappy_mesh(case, cells=5, levels=1, **options):
    """A box around a sphere, refined near it, with hanging nodes, and snapped to it: polyhedra."""
    block_mesh(case, (cells, cells, cells), (1, 1, 1), **options)
    (case / "system/snappyHexMeshDict").write_text(dictionary("snappyHexMeshDict", f"""
        castellatedMesh true; snap true; addLayers false;
        geometry {{ ball {{type searchableSphere; centre (0.5 0.5 0.5); radius 0.24;}} }}
        castellatedMeshControls
        {{
            maxLocalCells 100000; maxGlobalCells 1000000; minRefinementCells 0; nCellsBetweenLevels 1;
            features (); refinementSurfaces {{ ball {{level ({levels} {levels});}} }}
            resolveFeatureAngle 30; refinementRegions {{}} locationInMesh (0.03 0.04 0.05);
            allowFreeStandingZoneFaces true;
        }}
        snapControls
        {{ nSmoothPatch 3; tolerance 2; nSolveIter 20; nRelaxIter 5; nFeatureSnapIter 5; }}
        addLayersControls
        {{
            relativeSizes true; layers {{}} expansionRatio 1; finalLayerThickness 0.3; minThickness 0.1;
            nGrow 0; featureAngle 30; nRelaxIter 3; nSmoothSurfaceNormals 1; nSmoothNormals 3;
            nSmoothThickness 10; maxFaceThicknessRatio 0.5; maxThicknessToMedialRatio 0.3;
            minMedialAxisAngle 90; nBufferCellsNoExtrude 0; nLayerIter 50;
        }}
        meshQualityControls
        {{
            maxNonOrtho 65; maxBoundarySkewness 20; maxInternalSkewness 4; maxConcave 80; minVol 1e-13;
            minTetQuality 1e-15; minArea -1; minTwist 0.02; minDeterminant 0.001; minFaceWeight 0.05;
            minVolRatio 0.01; minTriangleTwist -1; nSmoothScale 4; errorReduction 0.75;
        }}
        mergeTolerance 1e-6;"""))
    run(case, "snappyHexMesh", "-overwrite")
    return case


GEOMETRY = """
SetFactory("OpenCASCADE");
Box(1) = {0, 0, 0, 1, 1, 0.5};
Mesh.CharacteristicLengthMin = %(size)g;
Mesh.CharacteristicLengthMax = %(size)g;
"""

# Layers of prisms on a triangulated square, a box of hexahedra, and tetrahedra.
LAYERED_GEOMETRY = """
Point(1) = {0, 0, 0, %(size)g}; Point(2) = {1, 0, 0, %(size)g};
Point(3) = {1, 1, 0, %(size)g}; Point(4) = {0, 1, 0, %(size)g};
Line(1) = {1, 2}; Line(2) = {2, 3}; Line(3) = {3, 4}; Line(4) = {4, 1};
Curve Loop(1) = {1, 2, 3, 4}; Plane Surface(1) = {1};
low[] = Extrude {0, 0, 0.25} { Surface{1}; Layers{2}; Recombine; };
high[] = Extrude {0, 0, 0.5} { Surface{low[0]}; };
Physical Volume("fluid") = {low[1], high[1]};
"""


def gmsh_mesh(case, size=0.3, geometry=LAYERED_GEOMETRY, **options):
    """Prisms and tetrahedra (and pyramids where they meet, if Gmsh makes some)."""
    case = make_case(case, **options)
    (case / "a.geo").write_text(geometry % {"size": size})
    run(case, "gmsh", "-3", "-format", "msh22", "a.geo", "-o", "a.msh")
    run(case, "gmshToFoam", "a.msh")
    return case


def dual_mesh(case, size=0.35, **options):
    """The polyhedra of the dual of a mesh of tetrahedra."""
    case = gmsh_mesh(case, size, GEOMETRY, **options)
    run(case, "polyDualMesh", "-overwrite", "75")
    return case


def shaken_case(case, rest, poses):
    """Makes the folders of times for a mesh that moves, one for each pose."""
    for i in range(poses):
        (case / str(i) / "polyMesh").mkdir(parents=True)


class CheckFailed(RuntimeError):
    """checkMesh ended at a time. Has its output, and the findings of the times before."""

    def __init__(self, output, found):
        super().__init__(f"checkMesh failed:\n{output[-3000:]}")
        self.output, self.found = output, found


def checked(case, *options):
    """Runs checkMesh on all times, and returns a list of its findings, one dictionary per time."""
    try:
        output, isDone = run(case, "checkMesh", *options), True
    except ProgramFailed as failed:
        output, isDone = failed.output, False
    found = []
    parts = re.split(r"^Time = ", output, flags=re.M)[1:]
    for part in parts if isDone else parts[:-1]:
        def number(pattern, none=None):
            """Returns the number that the pattern finds; 0 if checkMesh printed the text `none` instead."""
            match = re.search(pattern, part)
            if match:
                return float(match.group(1))
            if none is not None and none in part:
                return 0.0
            raise ValueError(f"checkMesh printed neither {pattern!r} nor {none!r}:\n{part}")

        found.append({
            "time": part.split("\n", 1)[0],
            "negative_volumes": int(number(r"Number of negative volume cells: (\d+)", "Cell volumes OK.")),
            "smallest_volume": number(r"[Mm]in(?:imum negative)? volume(?: =|:) (\S+?)[.,]?\s"),
            "wrong_pyramids": int(number(r"Error in face pyramids: (\d+) faces", "Face pyramids OK.")),
            "non_orthogonality": number(r"non-orthogonality Max: (\S+)"),
            "mean_non_orthogonality": number(r"non-orthogonality Max: \S+ average: (\S+)"),
            # This line is left out if there is no such face.
            "severe": int(number(r"severely non-orthogonal \(> 70 degrees\) faces: (\d+)", "non-orthogonality Max")),
            "orthogonality_errors": int(number(r"Number of non-orthogonality errors: (\d+)",
                                               "Non-orthogonality check OK.")),
            "skewness": number(r"Max skewness = ([^\s,]+)"),
            "is_good": "Mesh OK." in part,
            "text": part,
        })
    if not isDone:
        raise CheckFailed(output, found)
    return found
