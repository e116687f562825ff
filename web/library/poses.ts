// SPDX-License-Identifier: Apache-2.0
// Selections of vertices, and operations that move them (c/espalier_pose.h).

import {
  choice,
  integer,
  integers,
  numbers,
  options as object,
  countPoints,
  real,
} from "./arguments.ts";
import { Handle, type CLibrary } from "./c_library.ts";
import type { Lattice, Point } from "./lattice.ts";
import { doublesAt, type Scope } from "./memory.ts";

/** The decrease of weights outside a selected region. */
export interface Falloff {
  /** at and beyond this distance the weights are 0 */
  radius: number;
  /** default "smooth" */
  profile?: "linear" | "smooth";
}

export interface PoseOptions {
  /** one number for each vertex, 0 to 1: the part of the operation that it gets; default 1 for all */
  weights?: ArrayLike<number>;
  /** a point on the axis, or the fixed point; default: the middle of the box around the vertices that move */
  center?: Point;
  /** twist, bend and taper grow between these two coordinates along the axis; default: the interval of
   * the vertices that move */
  range?: [number, number];
}

/** Faces across a lattice: where a part of it joins the rest. */
export interface Section {
  area: number;
  /** the middle of the faces */
  center: Point;
}

/** A part of a lattice: a weight for each vertex, and the section that joins it to the rest. */
export interface SelectedPart {
  weights: Float64Array;
  section: Section;
}

/** The result of Poses.mirror(). */
export interface Mirrored {
  positions: Float64Array;
  /** the number of vertices with a weight above 0 that have no mirror image, and so stay */
  withoutImage: number;
}

/** Selections give one weight for each vertex; operations give new positions. Positions are three numbers for
 * each vertex; angles are in radians. */
export class Poses {
  constructor(private readonly library: CLibrary) {}

  selectBox(positions: Float64Array, corner: Point, opposite: Point, falloff?: Falloff) {
    return this.select("box", positions, falloff, (scope) => [
      scope.doubles(numbers("corner", corner, 3)),
      scope.doubles(numbers("opposite", opposite, 3)),
    ]);
  }

  selectBall(positions: Float64Array, center: Point, radius: number, falloff?: Falloff) {
    return this.select("ball", positions, falloff, (scope) => [
      scope.doubles(numbers("center", center, 3)),
      real("radius", radius),
    ]);
  }

  selectHalfSpace(positions: Float64Array, point: Point, normal: Point, falloff?: Falloff) {
    return this.select("half_space", positions, falloff, (scope) => [
      scope.doubles(numbers("point", point, 3)),
      scope.doubles(numbers("normal", normal, 3)),
    ]);
  }

  /** Selects the last layer of vertices along a direction. */
  selectEnd(positions: Float64Array, direction: Point, falloff?: Falloff) {
    return this.select("end", positions, falloff, (scope) => [
      scope.doubles(numbers("direction", direction, 3)),
    ]);
  }

  selectNumbers(positions: Float64Array, vertices: ArrayLike<number>, falloff?: Falloff) {
    return this.select("numbers", positions, falloff, (scope) => {
      const chosen = scope.integers(integers("vertices", vertices));
      return [BigInt(vertices.length), chosen];
    });
  }

  /** Selects the arm, leg or ear at a point, up to the section where it opens into the body. Falloffs of this and of
   * the next three functions are measured along the cells. */
  selectLimb(lattice: Lattice, positions: Float64Array, point: Point, falloff?: Falloff) {
    return this.selectPart("limb", lattice, positions, falloff, (scope) =>
      scope.doubles(numbers("point", point, 3)),
    );
  }

  /** Selects the smaller part of the lattice beyond a face between two cells. */
  selectBeyond(lattice: Lattice, positions: Float64Array, face: number, falloff?: Falloff) {
    return this.selectPart("beyond", lattice, positions, falloff, () => integer("face", face));
  }

  /** Selects the vertices within a distance of a point along the cells. */
  selectNear(
    lattice: Lattice,
    positions: Float64Array,
    point: Point,
    radius: number,
    falloff?: Falloff,
  ): Float64Array {
    return this.selectAlong("near", lattice, positions, falloff, (scope) => [
      scope.doubles(numbers("point", point, 3)),
      real("radius", radius),
    ]);
  }

  /** Selects vertices by number, with a falloff along the cells. */
  selectAlongCells(
    lattice: Lattice,
    positions: Float64Array,
    vertices: ArrayLike<number>,
    falloff?: Falloff,
  ): Float64Array {
    return this.selectAlong("along_cells", lattice, positions, falloff, (scope) => {
      const chosen = scope.integers(integers("vertices", vertices));
      return [BigInt(vertices.length), chosen];
    });
  }

  /** The face between two cells that is nearest to a point. */
  nearestInnerFace(lattice: Lattice, positions: Float64Array, point: Point): number {
    const latticeAt = Handle.addressOf("lattice", lattice, "lattice");
    const count = countPoints("positions", positions);
    return this.library.scoped((scope) => {
      const out = scope.allocate(4);
      const [from, at] = [scope.doubles(positions), scope.doubles(numbers("point", point, 3))];
      this.library.call("espalier_nearest_inner_face", latticeAt, count, from, at, out);
      return this.library.core.HEAP32[out / 4];
    });
  }

  /** Adds the vertices that `steps` edges join to those with a weight above 0, or, below 0, removes the outer ones. */
  growSelection(lattice: Lattice, weights: ArrayLike<number>, steps: number): Float64Array {
    const latticeAt = Handle.addressOf("lattice", lattice, "lattice");
    numbers("weights", weights);
    return this.library.scoped((scope) => {
      const grown = scope.doubles(weights);
      this.library.call(
        "espalier_selection_grow",
        latticeAt,
        weights.length,
        integer("steps", steps),
        grown,
      );
      return doublesAt(this.library.core, grown, weights.length);
    });
  }

  /** The weights with 0 for the vertices that the lattice holds, such as the outer ones of a collar. */
  withoutHeld(lattice: Lattice, weights: ArrayLike<number>): Float64Array {
    const latticeAt = Handle.addressOf("lattice", lattice, "lattice");
    numbers("weights", weights);
    return this.library.scoped((scope) => {
      const changed = scope.doubles(weights);
      this.library.call("espalier_lattice_held_weights", latticeAt, weights.length, changed);
      return doublesAt(this.library.core, changed, weights.length);
    });
  }

  /** The section between the vertices with a weight above 0 and the rest: the joint of a limb. */
  selectionBorder(
    lattice: Lattice,
    positions: Float64Array,
    weights: ArrayLike<number>,
  ): Section {
    const latticeAt = Handle.addressOf("lattice", lattice, "lattice");
    const count = countPoints("positions", positions);
    return this.library.scoped((scope) => {
      const out = scope.allocate(32);
      const from = scope.doubles(positions);
      const chosen = scope.doubles(numbers("weights", weights, count));
      this.library.call("espalier_selection_border", latticeAt, count, from, chosen, out);
      return this.sectionAt(out);
    });
  }

  move(positions: Float64Array, offset: Point, options: PoseOptions = {}) {
    return this.pose("move", positions, options, (scope) => [
      scope.doubles(numbers("offset", offset, 3)),
    ]);
  }

  /** Rotates about an axis through the centre, anticlockwise seen from its tip. */
  rotate(positions: Float64Array, axis: Point, angle: number, options: PoseOptions = {}) {
    return this.pose("rotate", positions, options, (scope) => [
      scope.doubles(numbers("axis", axis, 3)),
      real("angle", angle),
    ]);
  }

  scale(positions: Float64Array, factors: Point, options: PoseOptions = {}) {
    return this.pose("scale", positions, options, (scope) => [
      scope.doubles(numbers("factors", factors, 3)),
    ]);
  }

  twist(positions: Float64Array, axis: Point, angle: number, options: PoseOptions = {}) {
    return this.pose("twist", positions, options, (scope) => [
      scope.doubles(numbers("axis", axis, 3)),
      real("angle", angle),
    ]);
  }

  /** Bends an axis into an arc. @param toward direction that the end of the range bends to */
  bend(
    positions: Float64Array,
    axis: Point,
    angle: number,
    toward: Point,
    options: PoseOptions = {},
  ) {
    return this.pose("bend", positions, options, (scope) => [
      scope.doubles(numbers("axis", axis, 3)),
      real("angle", angle),
      scope.doubles(numbers("toward", toward, 3)),
    ]);
  }

  /** Scales across an axis: by 1 at the start of the range, by the factor at its end. */
  taper(positions: Float64Array, axis: Point, factor: number, options: PoseOptions = {}) {
    return this.pose("taper", positions, options, (scope) => [
      scope.doubles(numbers("axis", axis, 3)),
      real("factor", factor),
    ]);
  }

  /** Gives the mirror image of each vertex the mirrored place of the vertex. Of a vertex and its image, the one with
   * the larger weight leads; of equal weights, the one on the side where the weights have the larger sum.
   * @param rest the lattice at rest, where images are found
   * @param axis 0 to 2: the plane is across this axis
   * @param options weights, default 1 everywhere; and the coordinate of the plane, default the middle of the lattice
   */
  mirror(
    rest: Float64Array,
    positions: Float64Array,
    axis: number,
    options: { weights?: ArrayLike<number>; plane?: number } = {},
  ): Mirrored {
    const count = countPoints("positions", positions);
    numbers("rest", rest, 3 * count);
    const { weights, plane } = object("options", options);
    return this.library.scoped((scope) => {
      const out = scope.allocate(4);
      const pose = scope.doubles(positions);
      this.library.call(
        "espalier_pose_mirror",
        count,
        pose,
        scope.doubles(rest),
        integer("axis", axis),
        plane === undefined ? 0 : scope.doubles([real("plane", plane)]),
        weights === undefined ? 0 : scope.doubles(numbers("weights", weights, count)),
        pose,
        out,
      );
      const withoutImage = this.library.core.HEAP32[out / 4];
      return { positions: doublesAt(this.library.core, pose, 3 * count), withoutImage };
    });
  }

  private selectPart(
    kind: string,
    lattice: Lattice,
    positions: Float64Array,
    falloff: Falloff | undefined,
    place: (scope: Scope) => number,
  ): SelectedPart {
    return this.library.scoped((scope) => {
      const out = scope.allocate(32);
      const values = (inner: Scope) => [place(inner)];
      const weights = this.selectAlong(kind, lattice, positions, falloff, values, [out]);
      return { weights, section: this.sectionAt(out) };
    });
  }

  private sectionAt(pointer: number): Section {
    const [area, ...center] = doublesAt(this.library.core, pointer, 4);
    return { area, center: center as Point };
  }

  private selectAlong(
    kind: string,
    lattice: Lattice,
    positions: Float64Array,
    falloff: Falloff | undefined,
    values: (scope: Scope) => (number | bigint)[],
    results: number[] = [],
  ): Float64Array {
    const latticeAt = Handle.addressOf("lattice", lattice, "lattice");
    const count = countPoints("positions", positions);
    return this.library.scoped((scope) => {
      const weights = scope.allocate(8 * count);
      const decrease = this.falloffIn(scope, falloff);
      const from = scope.doubles(positions);
      this.library.call(
        `espalier_select_${kind}`,
        latticeAt,
        count,
        from,
        ...values(scope),
        decrease,
        weights,
        ...results,
      );
      return doublesAt(this.library.core, weights, count);
    });
  }

  private falloffIn(scope: Scope, falloff: Falloff | undefined): number {
    if (falloff === undefined) return 0;
    object("falloff", falloff);
    return scope.struct([
      ["i32", choice("falloff.profile", falloff.profile ?? "smooth", ["linear", "smooth"])],
      ["f64", real("falloff.radius", falloff.radius)],
    ]);
  }

  private select(
    kind: string,
    positions: Float64Array,
    falloff: Falloff | undefined,
    values: (scope: Scope) => (number | bigint)[],
  ): Float64Array {
    const count = countPoints("positions", positions);
    return this.library.scoped((scope) => {
      const weights = scope.allocate(8 * count);
      const decrease = this.falloffIn(scope, falloff);
      const from = scope.doubles(positions);
      this.library.call(`espalier_select_${kind}`, count, from, ...values(scope), decrease, weights);
      return doublesAt(this.library.core, weights, count);
    });
  }

  private pose(
    kind: string,
    positions: Float64Array,
    options: PoseOptions,
    values: (scope: Scope) => (number | bigint)[],
  ): Float64Array {
    const count = countPoints("positions", positions);
    const { weights, center, range } = object("options", options);
    return this.library.scoped((scope) => {
      const copied = (name: string, values: ArrayLike<number> | undefined, length: number) =>
        values === undefined ? 0 : scope.doubles(numbers(name, values, length));
      const chosen = scope.struct([
        ["size"],
        ["pointer", copied("weights", weights, count)],
        ["pointer", copied("center", center, 3)],
        ["pointer", copied("range", range, 2)],
      ]);
      const pose = scope.doubles(positions);
      this.library.call(`espalier_pose_${kind}`, count, pose, ...values(scope), chosen, pose);
      return doublesAt(this.library.core, pose, 3 * count);
    });
  }
}
