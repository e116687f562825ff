# SPDX-License-Identifier: Apache-2.0
"""The demo's figure: a gentleman in a suit and a hat, his arms a little away from his body."""

import numpy as np

import scenes
from distance_fields import Drum, Ellipsoid, Frame, HalfSpace, RoundCone, Solid
from materials import divide
from quad_mesh import QuadMesh
from surface_nets import even_out, polygonise, project, remove_ambiguity, sample

SPACING = 0.0076


def front_of(solid, x, y):
    """The z of the solid's foremost point with the given x and y."""
    z = np.linspace(0, 0.3, 3001)
    inside = solid.distance(np.stack([np.full_like(z, x), np.full_like(z, y), z], axis=1)) < 0
    return z[np.flatnonzero(inside)[-1]]


def add_legs(solid):
    hip, knee, ankle = (0.088, 0.82, 0), (0.100, 0.45, 0.005), (0.108, 0.09, -0.018)
    solid.add_pair(RoundCone(hip, knee, 0.092, 0.076), "suit", 0.02)
    solid.add_pair(RoundCone(knee, ankle, 0.076, 0.064), "suit")
    cuff = Frame.along((0.108, 0.058, -0.018), (0, 1, 0), (0, 0, 1))
    solid.add_pair(Drum(cuff, 0.05, 0.073, 0.071, 0.012), "suit", 0.006)
    heel, ball, toe = (0.108, 0.034, -0.035), (0.116, 0.034, 0.07), (0.124, 0.032, 0.135)
    solid.add_pair(RoundCone(heel, ball, 0.052, 0.056), "shoe", 0.004)
    solid.add_pair(RoundCone(ball, toe, 0.056, 0.042), "shoe", 0.02)


def add_jacket(solid):
    solid.add(Ellipsoid((0, 1.13, -0.005), (0.178, 0.19, 0.128)), "suit", 0.03)
    solid.add(Ellipsoid((0, 0.96, 0.008), (0.160, 0.20, 0.132)), "suit", 0.10)
    solid.add(RoundCone((-0.160, 1.268, -0.012), (0.160, 1.268, -0.012), 0.064), "suit", 0.07)
    skirt = Frame.along((0, 0.70, 0), (0, 1, 0), (0, 0, 1))
    solid.add(Drum(skirt, 0.26, 0.208, 0.160, 0.02, (1, 0.76)), "suit", 0.025)
    for height in (1.045, 0.965, 0.885):
        place = (0, height, front_of(solid, 0, height))
        solid.add(Ellipsoid(place, (0.014, 0.014, 0.010)), "button", 0.003)


def add_head(solid):
    solid.add(RoundCone((0, 1.30, -0.012), (0, 1.43, 0), 0.058), "skin", 0.02)
    collar = Frame.along((0, 1.322, -0.010), (0, 1, 0.16), (0, 0, 1))
    solid.add(Drum(collar, 0.044, 0.083, 0.071, 0.012), "shirt", 0.010)
    solid.add(Ellipsoid((0, 1.545, 0.008), (0.112, 0.140, 0.122)), "skin", 0.03)
    solid.add(Ellipsoid((0, 1.455, 0.040), (0.074, 0.060, 0.078)), "skin", 0.05)
    solid.add(Ellipsoid((0, 1.520, 0.136), (0.021, 0.029, 0.026)), "skin", 0.02)
    solid.add_pair(Ellipsoid((0.112, 1.525, 0.0), (0.016, 0.034, 0.024)), "skin", 0.012)
    eye = (0.043, 1.562, front_of(solid, 0.043, 1.562) - 0.004)
    solid.add_pair(Ellipsoid(eye, (0.015, 0.021, 0.013)), "eye", 0.003)
    start, middle, end = [(x, y, front_of(solid, x, y) - 0.002)
                          for x, y in ((0.004, 1.479), (0.042, 1.470), (0.070, 1.486))]
    solid.add_pair(RoundCone(start, middle, 0.011, 0.0125), "eye", 0.004)
    solid.add_pair(RoundCone(middle, end, 0.0125, 0.006), "eye", 0.004)


def add_hat(solid):
    tilt = Frame.along((0, 1.600, 0.004), (0.10, 1, -0.10), (0, 0, 1))
    brim = Drum(tilt, 0.025, 0.205, 0.205, 0.022, (0.93, 1.08),
                lambda x, z: 3.2 * np.maximum(np.abs(x) - 0.09, 0) ** 2 - 0.35 * z * z - 0.06 * z)
    solid.add(brim, "hat", 0.004)
    crown = Drum(tilt, 0.155, 0.135, 0.112, 0.05, (0.93, 1.08))
    solid.add(crown, "hat", 0.014)
    solid.carve(Ellipsoid(tilt.world((0, 0.185, 0.01)), (0.030, 0.045, 0.10), tilt.axes), 0.05)
    for side in (-1, 1):
        pinch = tilt.world((side * 0.125, 0.13, 0.10))
        solid.carve(Ellipsoid(pinch, (0.05, 0.06, 0.06), tilt.axes), 0.05)
    return tilt, crown


def add_arm(solid, shoulder, elbow, wrist, tip):
    solid.add(RoundCone(shoulder, elbow, 0.060, 0.052), "suit", 0.025)
    forearm = Frame.along(wrist, wrist - elbow, (0, 0, 1))
    solid.add(RoundCone(elbow, forearm.world((0, -0.06, 0)), 0.052, 0.048), "suit")
    sleeve = Frame(forearm.world((0, -0.075, 0)), forearm.axes)
    solid.add(Drum(sleeve, 0.075, 0.0515, 0.055, 0.012), "suit", 0.012)
    cuff = Frame(forearm.world((0, -0.02, 0)), forearm.axes)
    solid.add(Drum(cuff, 0.040, 0.047, 0.047, 0.010), "shirt", 0.004)
    # The palm faces the body.
    hand = Frame.along(wrist, tip - wrist, (0, 0, 1))
    add_hand(solid, hand, np.linalg.norm(tip - wrist), np.sign(tip[0]))


def add_hand(solid, hand, length, side):
    """A hand along axis 1 of its frame, thumb towards axis 2, palm towards axis 0 times `side`."""
    def at(x, y, z):
        return hand.world((x * side, y * length, z))

    solid.add(RoundCone(at(0, 0.02, 0), at(0, 0.25, 0), 0.029, 0.030), "skin", 0.006)
    solid.add(Ellipsoid(at(0, 0.36, 0.0), (0.024, 0.064, 0.049), hand.axes), "skin", 0.03)
    fingers = ((-0.047, 0.78, 0.0145), (-0.0165, 0.90, 0.0165), (0.0155, 0.92, 0.0165),
               (0.047, 0.84, 0.016))
    for z, reach, radius in fingers:
        finger = RoundCone(at(0, 0.42, z * 0.85), at(0.004, reach, z), radius + 0.001, radius)
        solid.add(finger, "skin", 0.006)
    base, knuckle, end = at(0.004, 0.22, 0.028), at(0.014, 0.38, 0.068), at(0.020, 0.54, 0.080)
    solid.add(RoundCone(base, knuckle, 0.020, 0.017), "skin", 0.02)
    solid.add(RoundCone(knuckle, end, 0.017, 0.0155), "skin", 0.01)


class Figure:
    """The solid, and the material of each point of its surface."""

    def __init__(self):
        solid = Solid()
        add_legs(solid)
        add_jacket(solid)
        add_arm(solid, scenes.SHOULDER, scenes.ELBOW, scenes.WRIST, scenes.HAND_TIP)
        add_arm(solid, scenes.RIGHT_SHOULDER, scenes.RIGHT_ELBOW, scenes.RIGHT_WRIST,
                scenes.RIGHT_HAND_TIP)
        add_head(solid)
        self.hat, self.crown = add_hat(solid)
        solid.carve(HalfSpace(0.0), 0.012)
        self.solid = solid
        self.materials = solid.materials + ["tie", "band"]

    def material_fields(self, points):
        """Returns one column per material; a point has the material with the lowest value.

        Shirt, tie and hat band are only painted: they are not parts of the solid.
        """
        fields = dict(zip(self.solid.materials, self.solid.material_distances(points).T))
        x, y, z = points.T
        depth = 1.325 - y
        front = 0.02 - z
        opening = np.maximum(np.abs(x) - np.minimum(0.068 - 0.27 * depth, 0.074), front)
        fields["shirt"] = np.minimum(fields["shirt"], fields["suit"] + opening)
        width = np.where(depth < 0.025, 0.017, 0.011 + 0.07 * depth)
        # Further down the tie fills the opening, since a thin strip of shirt would be ragged.
        width += 2 * np.maximum(depth - 0.15, 0)
        tie = np.maximum(np.maximum(np.abs(x) - width, -depth - 0.03), front)
        fields["tie"] = np.minimum(fields["shirt"], fields["suit"]) + np.maximum(tie, opening)
        across = self.hat.local(points)[:, 1] - 0.042
        around = np.abs(across) - 0.022
        from_crown = self.crown.distance(points)
        # The band is on the crown only: its field grows beside the crown, without a kink there.
        fields["band"] = from_crown + 6 * np.maximum(from_crown - 0.001, 0) + around
        return np.stack([fields[m] for m in self.materials], axis=1)


#: Materials that are painted with the colour of another one.
PAINT = {"button": "hat", "eye": "shoe", "band": "shirt"}


def make_figure():
    figure = Figure()
    low, high = figure.solid.bounds()
    low, high = low - 3 * SPACING, high + 3 * SPACING
    low[1] = -3 * SPACING
    values = remove_ambiguity(sample(figure.solid.distance, low, high, SPACING))
    points, quads = polygonise(values, low, SPACING)
    points = even_out(project(points, figure.solid, 2), quads, figure.solid, 10)
    points, material = divide(points, quads, figure.solid, figure.material_fields, SPACING)
    names = [PAINT.get(name, name) for name in figure.materials]
    return QuadMesh(points, quads, np.array(names)[material])
