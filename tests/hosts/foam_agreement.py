# SPDX-License-Identifier: Apache-2.0
"""Random poses of a case of OpenFOAM, judged by Espalier and by checkMesh: for the tests and for
bench/checkmesh_agreement.py."""

import collections
import json
import math
import random
import re
import subprocess

import foam_cases

# What checkMesh prints, after three asterisks, of the patches of a type. It has one message for edges across a mesh of two
# dimensions, whose sides are wedges or empty.
EDGES = "Number of edges not aligned with or perpendicular to"
FINDINGS = {"wedge": ("Cannot find opposite wedge", "Wedges do not have the same axis", "Wedge patch", EDGES),
            "empty": (EDGES,),
            "cyclic": ("Error in coupled point location",)}
# What checkMesh prints when it refuses a mesh because of a patch of a type.
REFUSALS = {"symmetryPlane": "Symmetry plane", "cyclic": "does not match neighbour", "wedge": "Wedge patch"}


def differences(ours, theirs):
    """Compares a report of `espalier deform` on a mesh with a finding of foam_cases.checked(): a list of texts."""
    found = []

    def compare(name, got, expected, isSame):
        if not isSame:
            found.append(f"{name}: {got!r}, checkMesh has {expected!r}")
    quality = ours["quality"]["after"]
    for name, got, expected in (
            ("negative volumes", quality["non_positive_volumes"], theirs["negative_volumes"]),
            ("wrong pyramids", quality["negative_pyramids"], theirs["wrong_pyramids"]),
            ("severely non-orthogonal faces", quality["severely_non_orthogonal"],
             theirs["severe"] + theirs["orthogonality_errors"])):
        if not ("cyclic" in theirs.get("refused", ()) and name.startswith("severely")):
            compare(name, got, expected, got == expected)
    for name, key, relative, absolute in (
            # checkMesh prints six digits, or as many as writePrecision says. A volume is a sum of terms that cancel.
            ("smallest volume", "smallest_volume", 1e-9, 1e-15),
            # checkMesh computes cosines, and an angle near 0 or 180 degrees has half of their digits.
            ("non-orthogonality", "non_orthogonality", 0, 1e-6),
            ("mean non-orthogonality", "mean_non_orthogonality", 0, 1e-6),
            ("skewness", "skewness", 1e-7, 1e-12)):
        # checkMesh measures nothing across a periodic patch that it refuses.
        if quality[key] is not None and not ("cyclic" in theirs.get("refused", ()) and key != "smallest_volume"):
            compare(name, quality[key], theirs[key],
                    math.isclose(quality[key], theirs[key], rel_tol=relative, abs_tol=absolute))
    if ours["inverted"]["count"] == 0:
        compare("valid poses have positive volumes", theirs["smallest_volume"], "> 0",
                theirs["negative_volumes"] == 0 and theirs["smallest_volume"] > 0)
    return found


def broken_types(ours):
    """The types of the patches that Espalier reports as broken."""
    return {patch["type"] for patch in ours["patches"] if patch["broken"]}


def types_found(theirs, types):
    """The types, among those of the patches, with which checkMesh finds something wrong."""
    errors = [line for line in theirs["text"].splitlines() if "***" in line]
    return theirs.get("refused", set()) | {
        kind for kind, words in FINDINGS.items()
        if kind in types and any(word in line for word in words for line in errors)}


class Mesh:
    """The points and the patches of a case in ASCII."""

    def __init__(self, case):
        folder = case / "constant/polyMesh"
        number = r"[-+0-9.eE]+"
        self.points = [tuple(map(float, match)) for match in re.findall(
            rf"\(({number}) ({number}) ({number})\)", (folder / "points").read_text())]
        faces = [tuple(map(int, match.split())) for match in re.findall(
            r"^\d+\(([\d ]+)\)$", (folder / "faces").read_text(), flags=re.M)]
        self.low = [min(column) for column in zip(*self.points)]
        self.high = [max(column) for column in zip(*self.points)]
        self.patches = {}  # name: (type, its points)
        for name, body in re.findall(r"(\S+)\s*\{([^{}]*nFaces[^{}]*)\}", (folder / "boundary").read_text()):
            value = dict(re.findall(r"^\s*(\w+)\s+([^;]+);", body, flags=re.M))
            first, count = int(value["startFace"]), int(value["nFaces"])
            if count > 0:
                self.patches[name] = (value["type"], {point for face in faces[first:first + count] for point in face})

    def types(self):
        return {kind for kind, _ in self.patches.values()}

    def sides_of(self, points):
        """The axes along which all points are at one end of the mesh or the other, and those along which all points
        have one coordinate."""
        ends, flat = set(), set()
        for axis in range(3):
            places = {round(self.points[point][axis], 12) for point in points}
            slack = 1e-9 * (self.high[axis] - self.low[axis])
            if all(min(abs(place - self.low[axis]), abs(place - self.high[axis])) <= slack for place in places):
                ends.add(axis)
            elif len(places) == 1:
                flat.add(axis)
        return ends, flat


def keeping_moves(mesh, rest, draws, size):
    """Random displacements of the vertices `rest` of a lattice that fills the box of the mesh, which keep all of its
    constraint patches; None if none are known for the mesh. They are the same at both ends of an axis with patches
    that are empty or periodic, and stay within the plane of a patch. About an axis of symmetry along x, the distances
    from the axis are scaled."""
    spans = [high - low for low, high in zip(mesh.low, mesh.high)]
    moves = {}

    def draw(key):
        if key not in moves:
            moves[key] = [draws.uniform(-size, size) for _ in range(3)]
        return moves[key]
    kinds = mesh.types()
    if "wedge" in kinds:
        if kinds & {"cyclic", "cyclicAMI", "symmetry", "symmetryPlane"}:
            return None
        # The axis is the line that all wedges share.
        wedges = [points for kind, points in mesh.patches.values() if kind == "wedge"]
        common = set.intersection(*wedges)
        along = next((axis for axis in range(3) if common and all(
            abs(mesh.points[point][other]) < 1e-9 * max(spans) for point in common for other in range(3)
            if other != axis)), None)
        if along is None:
            return None
        radial = max((axis for axis in range(3) if axis != along), key=lambda axis: spans[axis])
        result = []
        for place in rest:
            shift = draw(("shift", round(place[along], 9), round(place[radial], 9)))[0] * spans[along]
            scale = draw(("scale", round(place[along], 9)))[1]
            result.append([shift if axis == along else scale * place[axis] for axis in range(3)])
        return result
    same, flat_ends, flat = set(), set(), set()
    periodic = {}  # the ends of each axis that have periodic patches
    for kind, points in mesh.patches.values():
        if kind in ("empty", "symmetry", "symmetryPlane", "cyclic", "cyclicAMI"):
            ends, inner = mesh.sides_of(points)
            if not ends | inner:
                return None
            if kind in ("cyclic", "cyclicAMI"):
                for axis in ends:
                    periodic.setdefault(axis, set()).update(mesh.points[point][axis] > mesh.low[axis] for point in points)
            if kind in ("empty", "cyclic", "cyclicAMI"):
                same |= ends
            if kind in ("empty", "symmetry", "symmetryPlane"):
                flat_ends |= ends
                flat |= inner
    if any(len(ends) < 2 for ends in periodic.values()):  # a turn
        return None
    result = []
    for place in rest:
        isEnd = [min(abs(place[axis] - mesh.low[axis]), abs(place[axis] - mesh.high[axis])) <= 1e-9 * spans[axis]
                 for axis in range(3)]
        move = list(draw(tuple("end" if axis in same and isEnd[axis] else round(place[axis], 9) for axis in range(3))))
        result.append([0 if axis in flat or (axis in flat_ends and isEnd[axis]) else move[axis] * spans[axis]
                       for axis in range(3)])
    return result


class Comparison:
    """Compares poses of one case.

    case : a case without folders of times, in ASCII
    """

    CELLS = 3  # of the lattice, along each axis

    def __init__(self, program, case, seed=1):
        self.program, self.case, self.mesh = program, case, Mesh(case)
        self.draws = random.Random(seed)
        self.lattice = case.parent / (case.name + "-rest.ovm")
        spans = max(high - low for low, high in zip(self.mesh.low, self.mesh.high))
        self.run("shape", "box", "--cells", self.CELLS, self.CELLS, self.CELLS, "--min", *self.mesh.low, "--max",
                 *(high if high > low else low + 0.01 * spans for low, high in zip(self.mesh.low, self.mesh.high)),
                 "-o", self.lattice)
        lines = self.lattice.read_text().splitlines()
        at = lines.index("Vertices") + 2
        self.before, self.after = lines[:at], lines[at + int(lines[at - 1]):]
        self.rest = [tuple(map(float, line.split())) for line in lines[at:at + int(lines[at - 1])]]

    def run(self, *arguments):
        result = subprocess.run([self.program, *map(str, arguments)], text=True, capture_output=True, timeout=600)
        if result.returncode != 0:
            raise RuntimeError(f"{arguments}: {result.stderr}")
        return result.stdout

    def free_moves(self, size):
        spans = [high - low for low, high in zip(self.mesh.low, self.mesh.high)]
        return [[span * self.draws.uniform(-size, size) for span in spans] for _ in self.rest]

    def keeping_moves(self, size):
        return keeping_moves(self.mesh, self.rest, self.draws, size)

    def judge(self, moves, *options):
        """Deforms the case by displacements of the lattice, and returns [(our report, checkMesh's finding)]."""
        paths = []
        for number, each in enumerate(moves):
            paths.append(self.case.parent / f"{self.case.name}-{number:04d}.ovm")
            vertices = ["%.17g %.17g %.17g" % tuple(p + d for p, d in zip(place, move))
                        for place, move in zip(self.rest, each)]
            paths[-1].write_text("\n".join([*self.before, *vertices, *self.after]) + "\n")
            (self.case / str(number) / "polyMesh").mkdir(parents=True, exist_ok=True)
        text = self.run("deform", self.case, "--rest", self.lattice, "--to", *paths, "-n", 3, "-o",
                        self.case / "%d/polyMesh/points", "--report", "json", *options)
        return list(zip(json.loads(text)["meshes"], self.checked(len(paths))))

    def checked(self, count):
        """Returns what checkMesh finds in the times 0 to count - 1. It ends at a mesh that it refuses, such as one with a
        bent symmetryPlane or a periodic patch that does not match: the type of the patch is a finding, "refused", and the
        mesh is checked again without this type."""
        boundary = self.case / "constant/polyMesh/boundary"
        typed = boundary.read_text()
        found = []
        while len(found) < count:
            try:
                found += foam_cases.checked(self.case, "-time", f"{len(found)}:{count - 1}")
            except foam_cases.CheckFailed as failed:
                found += failed.found
                refused, text = set(), typed
                while failed:
                    new = {kind for kind, words in REFUSALS.items() if words in failed.output} - refused
                    if not new:
                        raise
                    refused |= new
                    text = re.sub(rf"(\btype\s+)({'|'.join(new)})\s*;", r"\1patch;", text)
                    boundary.write_text(text)
                    try:
                        each, = foam_cases.checked(self.case, "-time", str(len(found)))
                        failed = None
                    except foam_cases.CheckFailed as again:
                        failed = again
                boundary.write_text(typed)
                found.append({**each, "refused": refused})
        return found


class Tally:
    """Counts poses and differences."""

    def __init__(self):
        self.counts = collections.Counter()
        self.differences = []  # (pose, text)

    def add(self, pose, ours, theirs):
        self.counts["poses"] += 1
        self.counts["valid"] += ours["inverted"]["count"] == 0
        self.counts["negative"] += theirs["negative_volumes"] > 0
        self.counts["pyramids"] += theirs["wrong_pyramids"] > 0
        types = {patch["type"] for patch in ours["patches"]}
        own, their = broken_types(ours), types_found(theirs, types)
        self.counts["broken"] += bool(own)
        self.counts["broken for both"] += bool(own & their)
        # Wedges and empty patches share a message.
        for kinds in ({"wedge", "empty"}, {"cyclic"}, {"symmetryPlane"}):
            if kinds & types and bool(kinds & own) != bool(kinds & their):
                self.differences.append((pose, f"{' and '.join(sorted(kinds & types))}: broken for " + (
                    "Espalier only" if kinds & own else "checkMesh only")))
        for text in differences(ours, theirs):
            self.differences.append((pose, text))
