# SPDX-License-Identifier: Apache-2.0
"""Gaussian splats in a lattice, drawn by a public viewer (splats/draw.mjs)."""

import json
import pathlib
import subprocess

import numpy as np

from gallery_parts import Figure
from images import captioned, read_png, row

TOOLS = pathlib.Path(__file__).resolve().parent / "splats"
VIEW = {"width": 500, "height": 560, "angle": 27, "position": [3.0, -6.6, 2.4],
        "target": [0.5, 0.22, -0.05], "up": [0, 0, 1]}
#: Colours of the stripes, by Okabe and Ito.
STRIPES = np.array([(0.84, 0.37, 0.00), (0.90, 0.62, 0.00), (0.94, 0.89, 0.26),
                    (0.00, 0.62, 0.45), (0.34, 0.71, 0.91), (0.00, 0.45, 0.70)])


def radius(height):
    """The profile of the vase, for heights from -1.3 to 1.3."""
    return 0.40 + 0.21 * np.sin(2.1 * height + 0.3) - 0.10 * height


def vase(count=5000):
    """Splats on a vase, as a dict of columns: long strokes along helices, thin along the normal."""
    rng = np.random.default_rng(5)
    height = rng.uniform(-1.3, 1.3, 6 * count)
    keep = rng.uniform(0, 0.75, len(height)) < radius(height)  # as many on each area
    z = height[keep][:count]
    angle = rng.uniform(0, 2 * np.pi, len(z))
    r, slope = radius(z), (radius(z + 1e-4) - radius(z - 1e-4)) / 2e-4
    c, s, zero = np.cos(angle), np.sin(angle), 0 * z
    up = np.stack([slope * c, slope * s, 1 + zero], 1)
    up /= np.linalg.norm(up, axis=1)[:, None]
    around = np.stack([-s, c, zero], 1)
    normal = np.cross(around, up)
    along = 0.55 * around + 0.835 * up
    across = np.cross(normal, along)
    stripe = ((angle / (2 * np.pi) * 6 - 1.1 * z + rng.normal(0, 0.06, len(z))) % 6).astype(int)
    colour = np.clip(STRIPES[stripe] + rng.normal(0, 0.035, (len(z), 1)), 0, 1)
    columns = dict(zip("xyz", np.stack([r * c, r * s, z], 1).T))
    columns |= {name: zero for name in ("nx", "ny", "nz")}
    columns |= {f"f_dc_{i}": (colour[:, i] - 0.78) / 0.28209479177387814 for i in range(3)}
    # Degree 1: brighter from the front than from the side. The harmonics are -y, z and -x of the
    # direction of view, which runs from the camera to the splat.
    for channel in range(3):
        for k, (axis, sign) in enumerate(((1, -1), (2, 1), (0, -1))):
            columns[f"f_rest_{3 * channel + k}"] = -0.75 * sign * normal[:, axis]
    columns["opacity"] = 6 + zero
    for i, size in enumerate((0.085, 0.017, 0.004)):
        columns[f"scale_{i}"] = np.log(size) + rng.normal(0, 0.12, len(z))
    columns |= {f"rot_{i}": q for i, q in enumerate(quaternions(along, across, normal))}
    return columns


def quaternions(x, y, z):
    """The quaternions w x y z of rotations with these columns."""
    matrices = np.stack([x, y, z], 2)
    # The eigenvector of the largest eigenvalue of a symmetric matrix of 4 × 4 (Bar-Itzhack 2000).
    m = matrices.transpose(0, 2, 1)
    k = np.empty((len(m), 4, 4))
    k[:, 1:, 1:] = m + m.transpose(0, 2, 1)
    k[:, 1:, 1:] -= np.trace(m, axis1=1, axis2=2)[:, None, None] * np.eye(3)
    skew = np.stack([m[:, 1, 2] - m[:, 2, 1], m[:, 2, 0] - m[:, 0, 2], m[:, 0, 1] - m[:, 1, 0]], 1)
    k[:, 0, 1:] = k[:, 1:, 0] = skew
    k[:, 0, 0] = np.trace(m, axis1=1, axis2=2)
    return np.linalg.eigh(k)[1][:, :, -1].T


def write_ply(path, columns):
    rows = np.stack(list(columns.values()), 1).astype("<f4")
    header = ["ply", "format binary_little_endian 1.0", f"element vertex {len(rows)}",
              *(f"property float {name}" for name in columns), "end_header", ""]
    path.write_bytes("\n".join(header).encode() + rows.tobytes())


def trimmed(image, margin=16):
    """An image without most of the white at its left and right."""
    used = np.nonzero((image < 0.98).any(axis=(0, 2)))[0]
    return image[:, max(used[0] - margin, 0):used[-1] + margin]


def draw_splats(program):
    columns = vase()
    write_ply(program.file("vase.ply"), columns)
    program.note(f"vase.ply: {len(columns['x']):,} splats, written by demo/gallery_splats.py")
    program.run("shape around vase.ply --cells 5 -o rest.vtu")
    program.run("pose rest.vtu --twist z 110 --bend z 95 -o posed.vtu")
    program.run("deform vase.ply --rest rest.vtu --to posed.vtu --limit -o bent.ply")
    program.run("deform vase.ply --rest rest.vtu --to posed.vtu --limit --keep-normals "
                "-o kept.ply")
    names = ("vase", "bent", "kept")
    if not (TOOLS / "node_modules").exists():
        subprocess.run(["npm", "ci", "--no-audit", "--no-fund"], cwd=TOOLS, check=True)
    subprocess.run(["node", TOOLS / "draw.mjs", json.dumps(VIEW),
                    *(program.file(name + end) for name in names for end in (".ply", ".png"))],
                   check=True)
    captions = ("The splats at rest", "Bent and twisted", "The same points, --keep-normals")
    return row([captioned(trimmed(read_png(program.file(name + ".png"))), caption, 17)
                for name, caption in zip(names, captions)], 50)


FIGURES = [
    Figure(
        "splats", "Gaussian splats bend",
        "deform",
        "A vase of 5,000 Gaussian splats: long strokes that are brighter from the front than from the "
        "side. In the middle the splats turn and stretch with the lattice. On the right they keep "
        "their shapes and colours, as --keep-normals asks: strokes stand off the surface, and the "
        "shading is that of the vase at rest. Drawn by the viewer GaussianSplats3D.",
        draw_splats),
]
