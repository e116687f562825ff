// SPDX-License-Identifier: Apache-2.0
// The ready shapes: their sizes, which the form asks for, and the commands of the program that make them.

import type { Espalier, Lattice } from "../library/espalier.ts";

/** A number that a person chooses, or a word of a list. */
export type Size = {
  title: string;
  /** of `espalier shape`; sizes of one option follow each other */
  option: string;
} & (
  | { kind: "count"; value: number; least: number }
  | { kind: "length"; value: number }
  | { kind: "word"; value: string; words: string[] }
);

export type Sizes = Record<string, number | string>;

interface Shape {
  title: string;
  sizes: Record<string, Size>;
  /** options of the command that are always the same */
  fixed?: string;
  make(library: Espalier, sizes: any): Lattice;
}

const count = (title: string, option: string, value: number, least: number): Size => ({
  kind: "count",
  title,
  option,
  value,
  least,
});
const length = (title: string, option: string, value: number): Size => ({
  kind: "length",
  title,
  option,
  value,
});
const core = (value: "wedges" | "polygon"): Size => ({
  kind: "word",
  title: "Core",
  option: "--core",
  value,
  words: ["wedges", "polygon"],
});
const rings = count("Rings", "--rings", 1, 1);
const layers = (value: number) => count("Layers", "--layers", value, 1);

const solid = (title: string): Shape => ({
  title,
  sizes: { radius: length("Radius", "--radius", 1) },
  make: (library, { radius }) => library.regularSolid(title.toLowerCase() as "cube", radius),
});

const polygonal = (title: string): Shape => ({
  title,
  sizes: {
    sides: count("Sides", "--sides", 6, 3),
    radius: length("Radius", "--radius", 1),
    height: length("Height", "--height", 1),
  },
  make: (library, { sides, radius, height }) =>
    library.polygonalSolid(title.toLowerCase() as "prism", sides, radius, height),
});

const kJoints: [number, number, number, number][] = [
  [0, 0, 0, 0.3],
  [1, 0, 0, 0.25],
  [2, 0, 0, 0.2],
  [2.5, 0, 0, 0.2],
];

export const kShapes: Record<string, Shape> = {
  box: {
    title: "Box",
    sizes: {
      x: count("Cells x", "--cells", 3, 1),
      y: count("Cells y", "--cells", 3, 1),
      z: count("Cells z", "--cells", 3, 1),
    },
    fixed: "--min -1 -1 -1 --max 1 1 1",
    make: (library, { x, y, z }) => library.box([x, y, z], [-1, -1, -1], [1, 1, 1]),
  },
  cylinder: {
    title: "Cylinder",
    sizes: {
      sectors: count("Sectors", "--sectors", 8, 3),
      rings,
      layers: layers(3),
      core: core("wedges"),
      radius: length("Radius", "--radius", 1),
    },
    fixed: "--from 0 -1 0 --to 0 1 0",
    make: (library, sizes) => library.cylinder({ ...sizes, from: [0, -1, 0], to: [0, 1, 0] }),
  },
  torus: {
    title: "Torus",
    sizes: {
      segments: count("Segments", "--segments", 8, 3),
      gridCells: count("Cells across", "--grid", 1, 1),
      majorRadius: length("Radius", "--major-radius", 1),
      minorRadius: length("Thickness", "--minor-radius", 0.4),
    },
    make: (library, sizes) => library.torus(sizes),
  },
  star: {
    title: "Star",
    sizes: {
      points: count("Points", "--points", 5, 2),
      rings,
      layers: layers(1),
      core: core("wedges"),
      innerRadius: length("Notches", "--inner-radius", 0.5),
      outerRadius: length("Radius", "--outer-radius", 1),
      height: length("Height", "--height", 0.25),
    },
    make: (library, sizes) => library.star(sizes),
  },
  barbell: {
    title: "Barbell",
    sizes: {
      endSegments: count("End edges", "--end-segments", 6, 2),
      barSegments: count("Along", "--bar-segments", 2, 1),
      barAcross: count("Across", "--bar-across", 2, 1),
      rings,
      layers: layers(1),
      endRadius: length("Radius", "--end-radius", 1),
      barLength: length("Length", "--bar-length", 2),
      height: length("Height", "--height", 0.5),
    },
    make: (library, sizes) => library.barbell(sizes),
  },
  arm: {
    title: "Arm",
    sizes: {
      segments: count("Segments", "--segments", 2, 1),
      sides: count("Sides", "--sides", 4, 3),
      rings,
      core: core("polygon"),
    },
    fixed: kJoints.map((joint) => `--joint ${joint.join(" ")}`).join(" "),
    make: (library, sizes) =>
      library.arm({
        ...sizes,
        joints: kJoints.map(([x, y, z, radius]) => ({ position: [x, y, z], radius })),
      }),
  },
  tetrahedron: solid("Tetrahedron"),
  cube: solid("Cube"),
  octahedron: solid("Octahedron"),
  dodecahedron: solid("Dodecahedron"),
  icosahedron: solid("Icosahedron"),
  prism: polygonal("Prism"),
  pyramid: polygonal("Pyramid"),
  bipyramid: polygonal("Bipyramid"),
};

/** The command of the program that makes a shape as rest.vtu. */
export function shapeCommand(name: string, sizes: Sizes): string {
  const words = ["espalier shape", name];
  let last = "";
  for (const [key, { option }] of Object.entries(kShapes[name].sizes)) {
    if (option !== last) words.push(option);
    words.push(String(sizes[key]));
    last = option;
  }
  const { fixed } = kShapes[name];
  return [...words, ...(fixed ? [fixed] : []), "-o rest.vtu"].join(" ");
}
