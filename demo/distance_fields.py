# SPDX-License-Identifier: Apache-2.0
"""Solids as distance fields: negative inside, positive outside, of slope about one.

A solid is a list of parts that are joined one after the other by a smooth union, so that neighbours
blend over a chosen distance. Each part has a bounding box and is evaluated only for points near it:
a field of fifty parts costs little more than a field of five.
"""

import numpy as np

FAR = 1e3


def smooth_minimum(a, b, blend):
    """min(a, b), rounded where the two differ by less than `blend`; the plain minimum elsewhere."""
    if blend <= 0:
        return np.minimum(a, b)
    h = np.maximum(blend - np.abs(a - b), 0) / blend
    return np.minimum(a, b) - h * h * blend / 4


def smooth_maximum(a, b, blend):
    return -smooth_minimum(-a, -b, blend)


def unit(vector):
    vector = np.asarray(vector, float)
    return vector / np.linalg.norm(vector)


class Frame:
    """An origin and three orthonormal axes, the rows of `axes`."""

    def __init__(self, origin=(0, 0, 0), axes=None):
        self.origin = np.asarray(origin, float)
        self.axes = np.eye(3) if axes is None else np.asarray(axes, float)

    @classmethod
    def along(cls, origin, y_axis, z_hint):
        """Returns a frame with axis 1 along `y_axis` and axis 2 as close as possible to `z_hint`."""
        y = unit(y_axis)
        z = unit(np.asarray(z_hint, float) - y * np.dot(z_hint, y))
        return cls(origin, [np.cross(y, z), y, z])

    def local(self, points):
        return (points - self.origin) @ self.axes.T

    def world(self, point):
        return self.origin + np.asarray(point, float) @ self.axes


class RoundCone:
    """A capsule whose radius changes linearly: approximately the hull of two balls."""

    def __init__(self, a, b, radius_a, radius_b=None):
        self.a, self.b = np.asarray(a, float), np.asarray(b, float)
        self.radius_a = radius_a
        self.radius_b = radius_a if radius_b is None else radius_b

    def bounds(self):
        ends = np.array([self.a - self.radius_a, self.b - self.radius_b,
                         self.a + self.radius_a, self.b + self.radius_b])
        return ends.min(axis=0), ends.max(axis=0)

    def distance(self, points):
        axis = self.b - self.a
        t = np.clip((points - self.a) @ axis / (axis @ axis), 0, 1)
        nearest = self.a + t[:, None] * axis
        radius = self.radius_a + t * (self.radius_b - self.radius_a)
        return np.linalg.norm(points - nearest, axis=1) - radius


class Ellipsoid:
    def __init__(self, centre, radii, axes=None):
        self.frame = Frame(centre, axes)
        self.radii = np.asarray(radii, float)

    def bounds(self):
        reach = np.sqrt(((self.frame.axes * self.radii[:, None]) ** 2).sum(axis=0))
        return self.frame.origin - reach, self.frame.origin + reach

    def distance(self, points):
        local = self.frame.local(points)
        k0 = np.linalg.norm(local / self.radii, axis=1)
        k1 = np.linalg.norm(local / self.radii**2, axis=1)
        return np.where(k0 < 1e-9, -self.radii.min(), k0 * (k0 - 1) / np.maximum(k1, 1e-9))


class Drum:
    """A truncated elliptic cone with rounded rims, along axis 1 of a frame.

    It extends from the origin of the frame to `height`. Its radius changes from `radius_low` to
    `radius_high`, multiplied by `stretch` along axes 0 and 2. `lift(x, z)` raises it along its axis,
    in units of the frame, for example to curl a brim.
    """

    def __init__(self, frame, height, radius_low, radius_high, rounding, stretch=(1, 1), lift=None):
        self.frame, self.height, self.rounding = frame, height, rounding
        self.radius_low, self.radius_high = radius_low, radius_high
        self.stretch, self.lift = stretch, lift

    def bounds(self):
        reach = max(self.radius_low, self.radius_high) * max(self.stretch)
        corners = np.array([self.frame.world((x, y, z)) for x in (-reach, reach)
                            for y in (-reach / 3, self.height + reach / 3)
                            for z in (-reach, reach)])
        return corners.min(axis=0), corners.max(axis=0)

    def distance(self, points):
        x, y, z = self.frame.local(points).T
        if self.lift is not None:
            y = y - self.lift(x, z)
        t = np.clip(y / self.height, 0, 1)
        around = np.hypot(x / self.stretch[0], z / self.stretch[1])
        side = (around - (self.radius_low + t * (self.radius_high - self.radius_low)))
        side = side * min(self.stretch)
        ends = np.abs(y - self.height / 2) - self.height / 2
        return smooth_maximum(side, ends, self.rounding)


class HalfSpace:
    """All points below a horizontal plane."""

    def __init__(self, height):
        self.height = height

    def bounds(self):
        return np.array([-FAR, -FAR, -FAR]), np.array([FAR, self.height, FAR])

    def distance(self, points):
        return points[:, 1] - self.height


class Mirrored:
    """A part reflected in the plane x = 0."""

    def __init__(self, part):
        self.part = part

    def bounds(self):
        low, high = self.part.bounds()
        return np.array([-high[0], *low[1:]]), np.array([-low[0], *high[1:]])

    def distance(self, points):
        return self.part.distance(points * [-1, 1, 1])


class Solid:
    """Parts that are added or carved away in order, each with a material.

    distance(points, reach) is correct where it is below `reach` minus the largest blend in use, and
    a large number elsewhere.
    """

    def __init__(self):
        self.steps = []
        self.materials = []

    def add(self, part, material, blend=0.0):
        if material not in self.materials:
            self.materials.append(material)
        self.steps.append((part, material, blend, False))

    def add_pair(self, part, material, blend=0.0):
        """Adds a part and its mirror image."""
        self.add(part, material, blend)
        self.add(Mirrored(part), material, blend)

    def carve(self, part, blend=0.0):
        self.steps.append((part, None, blend, True))

    def bounds(self):
        boxes = [part.bounds() for part, _, _, carved in self.steps if not carved]
        return np.min([b[0] for b in boxes], axis=0), np.max([b[1] for b in boxes], axis=0)

    @staticmethod
    def _near(part, points, reach):
        low, high = part.bounds()
        return np.flatnonzero(((points > low - reach) & (points < high + reach)).all(axis=1))

    def distance(self, points, reach=0.1):
        field = np.full(len(points), FAR)
        for part, _, blend, carved in self.steps:
            near = self._near(part, points, reach)
            d = part.distance(points[near])
            if carved:
                field[near] = smooth_maximum(field[near], -d, blend)
            else:
                field[near] = smooth_minimum(field[near], d, blend)
        return field

    def material_distances(self, points, reach=0.1):
        """Returns the distance to the union of the parts of each material, one column per material."""
        fields = np.full((len(points), len(self.materials)), FAR)
        for part, material, blend, carved in self.steps:
            if carved:
                continue
            near = self._near(part, points, reach)
            column = self.materials.index(material)
            fields[near, column] = smooth_minimum(fields[near, column],
                                                  part.distance(points[near]), blend)
        return fields

    def gradient(self, points, step=1e-4, field=None):
        """Gradient of the distance (or of another field), by differences at the four corners of a
        tetrahedron."""
        field = self.distance if field is None else field
        corners = np.array([[1, 1, 1], [1, -1, -1], [-1, 1, -1], [-1, -1, 1]], float)
        values = [field(points + corner * step) for corner in corners]
        return sum(np.multiply.outer(v, c) for v, c in zip(values, corners)) / (4 * step)
