# SPDX-License-Identifier: Apache-2.0
"""Makes models to put cages around: limbs, handles, shells, thin plates and triangle soups.

    cage_models.py OUT_DIR [NAME...]

The result is the same on every run. Needs numpy only.
"""

import argparse
import dataclasses
import pathlib

import numpy as np

from surface_nets import polygonise, remove_ambiguity, sample


@dataclasses.dataclass
class Model:
    points: np.ndarray
    faces: list  # loops of points
    components: int = 1
    handles: int = 0
    is_solid: bool = True  # whether a volume can be compared


def capsule(points, a, b, radius):
    a, b = np.asarray(a, float), np.asarray(b, float)
    way = b - a
    t = np.clip((points - a) @ way / max(way @ way, 1e-30), 0, 1)
    return np.linalg.norm(points - a - t[:, None] * way, axis=1) - radius


def box(points, low, high, rounding=0.0):
    middle, half = (np.add(low, high)) / 2, (np.subtract(high, low)) / 2 - rounding
    over = np.abs(points - middle) - half
    outside = np.linalg.norm(np.maximum(over, 0), axis=1)
    return outside + np.minimum(over.max(axis=1), 0) - rounding


def ring(points, radius, thickness):
    """A torus around the z axis."""
    around = np.linalg.norm(points[:, :2], axis=1) - radius
    return np.hypot(around, points[:, 2]) - thickness


def solid(distance, low, high, spacing, **kind):
    low, high = np.asarray(low, float) - 2.5 * spacing, np.asarray(high, float) + 2.5 * spacing
    values = remove_ambiguity(sample(lambda p, _=0: distance(p), low, high, spacing))
    points, quads = polygonise(values, low, spacing)
    return Model(points, [list(q) for q in quads], **kind)


def ball(radius=1.0, centre=(0, 0, 0), rounds=3):
    """A sphere of triangles."""
    ends = [(1, 0, 0), (-1, 0, 0), (0, 1, 0), (0, -1, 0), (0, 0, 1), (0, 0, -1)]
    points = [np.array(e, float) for e in ends]
    faces = [(0, 2, 4), (2, 1, 4), (1, 3, 4), (3, 0, 4), (2, 0, 5), (1, 2, 5), (3, 1, 5), (0, 3, 5)]
    for _ in range(rounds):
        middles, finer = {}, []

        def middle(a, b):
            key = (min(a, b), max(a, b))
            if key not in middles:
                middles[key] = len(points)
                points.append((points[a] + points[b]) / 2)
                points[-1] /= np.linalg.norm(points[-1])
            return middles[key]

        for a, b, c in faces:
            ab, bc, ca = middle(a, b), middle(b, c), middle(c, a)
            finer += [(a, ab, ca), (ab, b, bc), (ca, bc, c), (ab, bc, ca)]
        faces = finer
    return np.array(points) * radius + centre, [list(f) for f in faces]


def joined(parts):
    """One list of points and faces of several."""
    points, faces = [], []
    for some, loops in parts:
        start = sum(len(p) for p in points)
        points.append(some)
        faces += [[v + start for v in loop] for loop in loops]
    return np.concatenate(points), faces


def hand():
    fingers = [((-0.45, 0.5, 0), (-0.65, 1.35, 0.05), 0.13), ((-0.15, 0.6, 0), (-0.2, 1.7, 0), 0.14),
               ((0.15, 0.6, 0), (0.22, 1.65, 0), 0.14), ((0.45, 0.5, 0), (0.68, 1.3, 0.05), 0.12),
               ((-0.5, -0.2, 0), (-1.15, 0.35, 0.25), 0.16)]

    def distance(p):
        return np.min([box(p, (-0.58, -0.7, -0.2), (0.58, 0.62, 0.2), 0.15)] +
                      [capsule(p, *finger) for finger in fingers], axis=0)
    return solid(distance, (-1.4, -0.8, -0.3), (0.9, 1.9, 0.5), 0.035)


def octopus():
    arms = []
    for k in range(8):
        angle = 2 * np.pi * k / 8
        way = np.array([np.cos(angle), np.sin(angle), 0])
        arms.append((0.5 * way + (0, 0, -0.2), 1.2 * way + (0, 0, -0.6), 0.16))
        arms.append((1.2 * way + (0, 0, -0.6), 1.9 * way + (0, 0, -0.3), 0.11))

    def distance(p):
        return np.min([np.linalg.norm(p, axis=1) - 0.7] + [capsule(p, *arm) for arm in arms], axis=0)
    return solid(distance, (-2.1, -2.1, -0.8), (2.1, 2.1, 0.75), 0.045)


def mug():
    def distance(p):
        around = np.linalg.norm(p[:, :2], axis=1)
        outer = np.maximum(around - 1, np.abs(p[:, 2]) - 1.1)
        inner = np.maximum(around - 0.78, -(p[:, 2] + 0.85))
        handle = ring((p - (1.1, 0, 0))[:, [0, 2, 1]], 0.62, 0.16)
        handle = np.maximum(handle, 0.85 - around)
        return np.minimum(np.maximum(outer, -inner), handle)
    return solid(distance, (-1.05, -1.05, -1.15), (1.95, 1.05, 1.15), 0.045, handles=1)


def torus():
    return solid(lambda p: ring(p, 1, 0.35), (-1.4, -1.4, -0.4), (1.4, 1.4, 0.4), 0.05, handles=1)


def bracket():
    """An angle of two plates with four holes."""
    def distance(p):
        plates = np.minimum(box(p, (-1, -1, -1), (1, -0.65, 1)), box(p, (-1, -1, -1), (-0.65, 1, 1)))
        holes = [np.linalg.norm(p[:, [0, 2]] - (0.35, z), axis=1) - 0.24 for z in (-0.5, 0.5)]
        holes += [np.linalg.norm(p[:, [1, 2]] - (0.35, z), axis=1) - 0.24 for z in (-0.5, 0.5)]
        holes[0] = np.maximum(holes[0], p[:, 1] + 0.5)
        holes[1] = np.maximum(holes[1], p[:, 1] + 0.5)
        holes[2] = np.maximum(holes[2], p[:, 0] + 0.5)
        holes[3] = np.maximum(holes[3], p[:, 0] + 0.5)
        return np.maximum(plates, -np.min(holes, axis=0))
    return solid(distance, (-1, -1, -1), (1, 1, 1), 0.05, handles=4)


def plate():
    return solid(lambda p: box(p, (-1.5, -1, -0.03), (1.5, 1, 0.03)), (-1.5, -1, -0.03),
                 (1.5, 1, 0.03), 0.02)


def fins():
    """A body with thin plates on it."""
    def distance(p):
        plates = [box(p, (-1 + 0.5 * k - 0.03, -0.6, 0), (-1 + 0.5 * k + 0.03, 0.6, 0.8))
                  for k in range(5)]
        return np.min([box(p, (-1.2, -0.7, -0.4), (1.2, 0.7, 0.1))] + plates, axis=0)
    return solid(distance, (-1.2, -0.7, -0.4), (1.2, 0.7, 0.8), 0.025)


def spring():
    """A wire along a helix."""
    turns, radius, wire, sides = 4, 1.0, 0.14, 12
    t = np.linspace(0, 2 * np.pi * turns, 48 * turns + 1)
    centre = np.stack([radius * np.cos(t), radius * np.sin(t), 0.62 * t / (2 * np.pi)], axis=1)
    out = np.stack([np.cos(t), np.sin(t), 0 * t], axis=1)
    along = np.gradient(centre, axis=0)
    along /= np.linalg.norm(along, axis=1, keepdims=True)
    up = np.cross(out, along)
    points, faces = [], []
    for c, o, u in zip(centre, out, up):
        for k in range(sides):
            angle = 2 * np.pi * k / sides
            points.append(c + wire * (np.cos(angle) * o + np.sin(angle) * u))
    for i in range(len(t) - 1):
        for k in range(sides):
            a, b = i * sides + k, i * sides + (k + 1) % sides
            faces.append([a, a + sides, b + sides, b])
    faces.append(list(range(sides)))
    faces.append([(len(t) - 1) * sides + k for k in reversed(range(sides))])
    return Model(np.array(points), faces)


def chain():
    """Three linked rings."""
    made = torus_mesh(1.0, 0.18, 48, 12)
    turned = made[0][:, [0, 2, 1]] * (1, 1, -1)
    return Model(*joined([made, (turned + (1.25, 0, 0), made[1]), (made[0] + (2.5, 0, 0), made[1])]),
                 components=3, handles=3)


def torus_mesh(radius, thickness, around, sides):
    points, faces = [], []
    for i in range(around):
        a = 2 * np.pi * i / around
        for k in range(sides):
            b = 2 * np.pi * k / sides
            r = radius + thickness * np.cos(b)
            points.append((r * np.cos(a), r * np.sin(a), thickness * np.sin(b)))
            i2, k2 = (i + 1) % around, (k + 1) % sides
            faces.append([i * sides + k, i2 * sides + k, i2 * sides + k2, i * sides + k2])
    return np.array(points), faces


def hollow():
    """A ball with a round cavity."""
    outer, inner = ball(1.0, rounds=4), ball(0.72, rounds=4)
    return Model(*joined([outer, (inner[0], [loop[::-1] for loop in inner[1]])]))


def bowl():
    """Half a sphere, without a thickness."""
    points, faces = ball(1.0, rounds=4)
    faces = np.array([loop for loop in faces if all(points[v][2] < 1e-9 for v in loop)])
    used, loops = np.unique(faces, return_inverse=True)
    return Model(points[used], loops.reshape(faces.shape).tolist(), is_solid=False)


def cloth():
    """A wavy sheet."""
    n = 40
    u, v = np.meshgrid(np.linspace(-1.5, 1.5, n), np.linspace(-1, 1, n), indexing="ij")
    points = np.stack([u, v, 0.3 * np.sin(2.5 * u) * np.cos(1.5 * v)], axis=-1).reshape(-1, 3)
    faces = [[i * n + j, (i + 1) * n + j, (i + 1) * n + j + 1, i * n + j + 1]
             for i in range(n - 1) for j in range(n - 1)]
    return Model(points, faces, is_solid=False)


def robot():
    """A figure of parts that intersect, each one a closed mesh, some of them inside out."""
    parts = [((0, 0, 0), (0.45, 0.3, 0.7)), ((0, 0, 0.95), (0.3, 0.28, 0.32)),
             ((0.65, 0, 0.35), (0.35, 0.14, 0.14)), ((-0.65, 0, 0.35), (0.35, 0.14, 0.14)),
             ((1.1, 0, 0.1), (0.13, 0.13, 0.4)), ((-1.1, 0, 0.1), (0.13, 0.13, 0.4)),
             ((0.24, 0, -1), (0.16, 0.17, 0.55)), ((-0.24, 0, -1), (0.16, 0.17, 0.55))]
    made = []
    for k, (centre, radii) in enumerate(parts):
        points, faces = ball(rounds=3)
        if k % 3 == 2:
            faces = [loop[::-1] for loop in faces]
        made.append((points * radii + centre, faces))
    return Model(*joined(made))


def house():
    """Walls and a roof of separate polygons with gaps, T-junctions and no common points."""
    rng = np.random.default_rng(1)
    faces3 = []
    for x in np.arange(-1, 1, 0.5):
        for y in (-0.7, 0.7):
            faces3.append([(x, y, -0.6), (x + 0.5, y, -0.6), (x + 0.5, y, 0.4), (x, y, 0.4)])
    for x in (-1, 1):
        faces3.append([(x, -0.7, -0.6), (x, 0.7, -0.6), (x, 0.7, 0.4), (x, -0.7, 0.4)])
        faces3.append([(x, -0.7, 0.4), (x, 0.7, 0.4), (x, 0, 0.9)])
    for side in (-1, 1):
        faces3.append([(-1, 0.7 * side, 0.4), (1, 0.7 * side, 0.4), (1, 0, 0.9), (-1, 0, 0.9)])
    faces3.append([(-1, -0.7, -0.6), (1, -0.7, -0.6), (1, 0.7, -0.6), (-1, 0.7, -0.6)])
    points, faces = [], []
    for face in faces3:
        faces.append(list(range(len(points), len(points) + len(face))))
        points += [np.add(p, rng.normal(0, 0.004, 3)) for p in face]
    return Model(np.array(points), faces, is_solid=False)


def splinters():
    """Triangles at random."""
    rng = np.random.default_rng(2)
    points = rng.uniform(-1, 1, (60, 1, 3)) + rng.normal(0, 0.35, (60, 3, 3))
    return Model(points.reshape(-1, 3), [[3 * k, 3 * k + 1, 3 * k + 2] for k in range(60)],
                 components=None, handles=None, is_solid=False)


def comb():
    """Teeth close to each other."""
    def distance(p):
        teeth = [box(p, (-1.5 + 0.6 * k, -0.2, 0), (-1.5 + 0.6 * k + 0.36, 0.2, 1.6), 0.05)
                 for k in range(6)]
        return np.min([box(p, (-1.6, -0.3, -0.5), (2.0, 0.3, 0.1), 0.05)] + teeth, axis=0)
    return solid(distance, (-1.6, -0.3, -0.5), (2.0, 0.3, 1.6), 0.03)


def pair():
    """Two balls with a narrow gap."""
    a = ball(0.6, (-0.65, 0, 0))
    b = ball(0.6, (0.65, 0, 0))
    return Model(*joined([a, b]), components=2)


MODELS = {made.__name__: made for made in (
    hand, octopus, mug, torus, bracket, plate, fins, spring, chain, hollow, bowl, cloth, robot,
    house, splinters, comb, pair)}


def write_obj(path, model):
    with open(path, "w") as out:
        for p in model.points:
            out.write("v {:.7g} {:.7g} {:.7g}\n".format(*p))
        for loop in model.faces:
            out.write("f " + " ".join(str(v + 1) for v in loop) + "\n")


def main():
    parser = argparse.ArgumentParser(description="Makes models to put cages around.")
    parser.add_argument("out_dir", type=pathlib.Path, metavar="OUT_DIR")
    parser.add_argument("names", nargs="*", metavar="NAME")
    arguments = parser.parse_args()
    arguments.out_dir.mkdir(parents=True, exist_ok=True)
    for name in arguments.names or MODELS:
        model = MODELS[name]()
        path = arguments.out_dir / f"{name}.obj"
        write_obj(path, model)
        print(f"{path}: {len(model.points)} points, {len(model.faces)} faces")


if __name__ == "__main__":
    main()
