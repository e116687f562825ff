# SPDX-License-Identifier: Apache-2.0
"""Sizes of the demo's models and of the lattices around them, in metres. y is up, and the figure
faces +z, so that its left arm is at +x.

    scenes.py SCENE

prints the commands that make a scene (figure, star, barbell or cage), to run in the folder of its model.
scripts/demo runs them, and docs/gallery.md shows them. Both poses of a scene's lattice have the same
topology.
"""

import sys

import numpy as np


def along(start, direction, length):
    direction = np.asarray(direction, float)
    return np.asarray(start, float) + direction * (length / np.linalg.norm(direction))


def chain(start, bones):
    """The joints of a limb: `start`, then one at the end of each bone (direction, length)."""
    joints = [np.asarray(start, float)]
    for direction, length in bones:
        joints.append(along(joints[-1], direction, length))
    return joints


#: The model of each scene.
MODELS = {"figure": "figure", "star": "disk", "barbell": "block", "cage": "figure"}

# The figure's left arm is slightly away from the body.
SHOULDER, ELBOW, WRIST, HAND_TIP = chain(
    (0.226, 1.262, -0.010),
    [((0.70, -0.72, -0.02), 0.25), ((0.60, -0.79, 0.12), 0.22), ((0.58, -0.80, 0.10), 0.19)])

# Its right arm hangs down, and is not deformed.
RIGHT_SHOULDER, RIGHT_ELBOW, RIGHT_WRIST, RIGHT_HAND_TIP = chain(
    SHOULDER * (-1, 1, 1),
    [((-0.34, -0.94, -0.04), 0.25), ((-0.12, -0.97, 0.20), 0.22), ((-0.04, -0.98, 0.16), 0.19)])

# The disk has axis z.
DISK_RADIUS, DISK_HEIGHT = 1.0, 0.36

# The block has its longest side along x.
BLOCK_SIZE = np.array([3.0, 1.0, 1.0])


def figure_joints():
    """Returns the joints of the lattice around the left arm, at rest and posed: position, radius,
    twist in degrees.

    The first two bones and cross-sections are the same in both, so that the arm leaves the shoulder
    smoothly. The bend is distributed over the following joints.
    """
    upper, fore, hand = ELBOW - SHOULDER, WRIST - ELBOW, HAND_TIP - WRIST
    start = along(SHOULDER, upper, -0.06)
    radii = (0.088, 0.084, 0.082, 0.082, 0.085, 0.090, 0.105, 0.130, 0.130)
    fixed = [(upper, 0.085), (upper, 0.055)]
    hanging = [(upper, 0.08), (upper, 0.09), (fore, 0.11), (fore, 0.11), (hand, 0.11), (hand, 0.11)]
    lifted = [((0.99, 0.02, 0.05), 0.075), ((0.93, 0.36, 0.10), 0.09), ((0.44, 0.88, 0.14), 0.105),
              ((0.30, 0.94, 0.14), 0.11), ((0.18, 0.97, 0.10), 0.11), ((0.12, 0.98, 0.08), 0.11)]
    twists = (0, 0, 0, 0, -10, -35, -60, -75, -80)
    rest = list(zip(chain(start, fixed + hanging), radii, (0,) * 9))
    posed = list(zip(chain(start, fixed + lifted), radii, twists))
    return rest, posed


def arm(joints):
    words = [f"--joint={x:.4f},{y:.4f},{z:.4f},{radius:g},{twist:g}"
             for (x, y, z), radius, twist in joints]
    return ["arm", "--sides=6", "--rings=2", "--segments=1", "--up", "0", "0", "1", *words]


def star(inner, outer):
    """At rest it is round, and its region extends to 0.936 of the radius of its ten corners."""
    return ["star", "--points=5", f"--inner-radius={inner * DISK_RADIUS:g}",
            f"--outer-radius={outer * DISK_RADIUS:g}", f"--height={1.1 * DISK_HEIGHT:g}"]


def barbell(end, length, bar, roundness):
    """At rest it is a block, one tenth larger than the model in y and z."""
    return ["barbell", "--end-segments=12", "--bar-segments=3", f"--end-radius={end:g}",
            f"--bar-length={length:g}", f"--bar-half-width={bar:g}", f"--roundness={roundness:g}",
            f"--height={1.1 * BLOCK_SIZE[2]:g}"]


def shape_options():
    hanging, lifted = figure_joints()
    side = 0.55 * BLOCK_SIZE[1]
    return {
        ("figure", "rest"): arm(hanging),
        ("figure", "posed"): arm(lifted),
        ("star", "rest"): star(1.12, 1.12),
        ("star", "posed"): star(0.55, 1.75),
        ("barbell", "rest"): barbell(side, BLOCK_SIZE[0] + 0.1 - 4 * side, side, 0),
        ("barbell", "posed"): barbell(0.85, 1.3, 0.16, 1),
    }


def cage_commands():
    """A lattice around the whole figure. The left arm and the head move by their own vertices: the arm about the
    shoulder, the forearm and the hand about the elbow, the head about the neck."""
    arm, forearm = "box 0.31 0.5 -0.4 1 1.3 0.4", "box 0.44 0.5 -0.4 1 1.3 0.4"
    return ["espalier shape cage figure.obj --vertices 300 -o cage-rest.vtu",
            f"espalier pose cage-rest.vtu --select {arm} --falloff smooth 0.08 --center 0.26 1.2 0 "
            f"--rotate z 55 --select {forearm} --center 0.45 1.32 0 --rotate z 45 "
            "--select half-space 0 1.36 0 0 1 0 --center 0 1.3 0 --rotate y -35 -o cage-posed.vtu"]


def shape_commands(scene):
    options = shape_options()
    return [" ".join(["espalier shape", *options[scene, pose], f"-o {scene}-{pose}.vtu"])
            for pose in ("rest", "posed")]


def commands(scene):
    """The lattice in both poses, its refinement if the picture shows it, and the deformed model."""
    shapes = cage_commands() if scene == "cage" else shape_commands(scene)
    refined = [f"espalier refine {scene}-rest.vtu -n 2 -o {scene}-refined.vtu"] if scene != "cage" else []
    return [*shapes, *refined,
            f"espalier deform {MODELS[scene]}.obj --rest {scene}-rest.vtu --to {scene}-posed.vtu "
            f"-n 3 -o {scene}-deformed.obj"]


if __name__ == "__main__":
    if len(sys.argv) != 2 or sys.argv[1] not in MODELS:
        sys.exit(__doc__)
    print(*commands(sys.argv[1]), sep="\n")
