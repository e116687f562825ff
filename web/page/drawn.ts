// SPDX-License-Identifier: Apache-2.0
// Makes the vertices that the page draws of a model. A point is drawn once for each of its texture coordinates and
// shades. Corners at one place have one shade, and so one normal, if the surface is smooth between them.

import type { Appearance, Polygons } from "../library/espalier.ts";
import type { DrawnModel, DrawnPart } from "./protocol.ts";

/** Normals of a file within 3 degrees of each other are one shade. */
const kSameNormal = Math.cos((3 * Math.PI) / 180);
/** Without normals in the file, an edge is sharp if its faces differ by more than 42 degrees. */
const kSmoothEdge = Math.cos((42 * Math.PI) / 180);

/** @param isDownward whether v of the pictures of the model points downwards, as in glTF */
export function drawnModel(
  points: Float64Array,
  { offsets, corners }: Polygons,
  appearance: Appearance,
  isDownward: boolean,
): DrawnModel {
  const pointCount = points.length / 3;
  const places = placesOf(points);
  const shades = appearance.normals
    ? shadesOfNormals(places, corners, appearance)
    : shadesOfFaces(places, points, offsets, corners);

  // The drawn vertices of a point are a list, which begins with the vertex of the same number.
  const next = new Int32Array(pointCount).fill(-1);
  const { textures, textureCorners, colors } = appearance;
  const uv = textures && textureCorners;
  const copies = grown(0);
  const later = grown(0); // the next of each copy
  const shadeOf = grown(pointCount, -1);
  const pairOf = grown(pointCount, -1);
  const samePair = (a: number, b: number) =>
    a === b ||
    (textures![2 * a] === textures![2 * b] && textures![2 * a + 1] === textures![2 * b + 1]);
  const drawn = new Int32Array(corners.length);
  for (let corner = 0; corner < corners.length; ++corner) {
    const point = corners[corner];
    const shade = shades[corner];
    const pair = uv ? textureCorners[corner] : -1;
    let at = point;
    if (shadeOf.values[at] < 0) {
      shadeOf.values[at] = shade;
      pairOf.values[at] = pair;
    }
    while (shadeOf.values[at] !== shade || !samePair(pairOf.values[at], pair)) {
      const following = at < pointCount ? next[at] : later.values[at - pointCount];
      if (following >= 0) {
        at = following;
        continue;
      }
      const made = pointCount + copies.count;
      if (at < pointCount) next[at] = made;
      else later.values[at - pointCount] = made;
      copies.push(point);
      later.push(-1);
      shadeOf.push(shade);
      pairOf.push(pair);
      at = made;
    }
    drawn[corner] = at;
  }

  const count = pointCount + copies.count;
  const source = (vertex: number) =>
    vertex < pointCount ? vertex : copies.values[vertex - pointCount];
  const { triangles, parts } = trianglesOf(offsets, drawn, appearance.faceMaterials);
  return {
    triangles,
    parts,
    copies: Uint32Array.from(copies.values.subarray(0, copies.count)),
    normalsFrom: firstOfEach(shadeOf.values.subarray(0, count)),
    textures: uv ? gathered(count, 2, textureNumber) : null,
    covariances: appearance.covariances,
    colors: colors ? gathered(count, 4, (v, c) => colors[4 * source(v) + c]) : null,
  };

  function textureNumber(vertex: number, component: number): number {
    const x = textures![2 * pairOf.values[vertex] + component] ?? 0; // A point in no face has no pair.
    return component === 1 && isDownward ? 1 - x : x;
  }
}

/** The covariances F Σ Fᵀ of splats. @param gradients F of each splat: nine numbers, row by row */
export function carriedCovariances(
  covariances: Float32Array,
  gradients: Float64Array,
): Float32Array {
  const result = new Float32Array(covariances.length);
  const half = new Float64Array(9); // F Σ
  for (let s = 0, f = 0; s < covariances.length; s += 6, f += 9) {
    const [xx, xy, xz] = [covariances[s], covariances[s + 1], covariances[s + 2]];
    const [yy, yz, zz] = [covariances[s + 3], covariances[s + 4], covariances[s + 5]];
    for (let row = 0; row < 9; row += 3) {
      const [x, y, z] = [gradients[f + row], gradients[f + row + 1], gradients[f + row + 2]];
      half[row] = x * xx + y * xy + z * xz;
      half[row + 1] = x * xy + y * yy + z * yz;
      half[row + 2] = x * xz + y * yz + z * zz;
    }
    let at = s;
    for (let i = 0; i < 9; i += 3)
      for (let j = i; j < 9; j += 3)
        result[at++] =
          half[i] * gradients[f + j] +
          half[i + 1] * gradients[f + j + 1] +
          half[i + 2] * gradients[f + j + 2];
  }
  return result;
}

/** An array of integers that grows. */
function grown(count: number, fill = 0) {
  const list = {
    values: new Int32Array(Math.max(16, count)).fill(fill),
    count,
    push(value: number): void {
      if (list.count === list.values.length) {
        const longer = new Int32Array(2 * list.count);
        longer.set(list.values);
        list.values = longer;
      }
      list.values[list.count++] = value;
    },
  };
  return list;
}

function gathered(
  count: number,
  size: number,
  value: (vertex: number, component: number) => number,
) {
  const result = new Float32Array(size * count);
  for (let v = 0; v < count; ++v) for (let c = 0; c < size; ++c) result[size * v + c] = value(v, c);
  return result;
}

/** For each vertex the first vertex with its shade; empty if that is the vertex itself everywhere. */
function firstOfEach(shades: Int32Array): Uint32Array {
  let last = -1;
  for (const shade of shades) last = Math.max(last, shade);
  const first = new Int32Array(last + 1).fill(-1);
  const result = new Uint32Array(shades.length);
  let isShared = false;
  for (let v = 0; v < shades.length; ++v) {
    const shade = shades[v];
    result[v] = v;
    if (shade < 0) continue;
    if (first[shade] < 0) first[shade] = v;
    else {
      result[v] = first[shade];
      isShared = true;
    }
  }
  return isShared ? result : new Uint32Array(0);
}

/** For each point the first point with its coordinates. */
function placesOf(points: Float64Array): Int32Array {
  const count = points.length / 3;
  const places = new Int32Array(count);
  const slots = new Int32Array(2 ** Math.ceil(Math.log2(2 * count + 1))).fill(-1);
  const mask = slots.length - 1;
  const numbers = new Float64Array(3);
  const words = new Int32Array(numbers.buffer);
  for (let point = 0; point < count; ++point) {
    for (let c = 0; c < 3; ++c) numbers[c] = points[3 * point + c] + 0; // -0 becomes 0.
    let hash = 0;
    for (let w = 0; w < 6; ++w) hash = Math.imul(hash ^ words[w], 0x9e3779b1) ^ (hash >>> 15);
    let slot = (hash ^ (hash >>> 13)) & mask;
    while (slots[slot] >= 0) {
      const other = 3 * slots[slot];
      if (
        points[other] === numbers[0] &&
        points[other + 1] === numbers[1] &&
        points[other + 2] === numbers[2]
      )
        break;
      slot = (slot + 1) & mask;
    }
    if (slots[slot] < 0) slots[slot] = point;
    places[point] = slots[slot];
  }
  return places;
}

/** For each corner its shade: corners at one place whose normals agree have the same. */
function shadesOfNormals(
  places: Int32Array,
  corners: Int32Array,
  { normals, normalCorners }: Appearance,
): Int32Array {
  const shades = new Int32Array(corners.length);
  // The shades at a place are a list. Each has the normal of its first corner.
  const first = new Int32Array(places.length).fill(-1);
  const next = grown(0);
  const normalOf = grown(0);
  const agree = (a: number, b: number) => {
    if (a === b) return true;
    const [x, y, z] = normals!.subarray(3 * a, 3 * a + 3);
    const [u, v, w] = normals!.subarray(3 * b, 3 * b + 3);
    return x * u + y * v + z * w >= kSameNormal * Math.hypot(x, y, z) * Math.hypot(u, v, w);
  };
  corners.forEach((point, corner) => {
    const normal = normalCorners ? normalCorners[corner] : point;
    const place = places[point];
    let shade = first[place];
    while (shade >= 0 && !agree(normalOf.values[shade], normal)) shade = next.values[shade];
    if (shade < 0) {
      shade = next.count;
      next.push(first[place]);
      normalOf.push(normal);
      first[place] = shade;
    }
    shades[corner] = shade;
  });
  return shades;
}

/** For each corner its shade: corners at one place have the same if smooth edges join their faces. */
function shadesOfFaces(
  places: Int32Array,
  points: Float64Array,
  offsets: Int32Array,
  corners: Int32Array,
): Int32Array {
  const normals = faceNormals(points, offsets, corners);
  const isSmooth = (f: number, g: number) =>
    normals[3 * f] * normals[3 * g] +
      normals[3 * f + 1] * normals[3 * g + 1] +
      normals[3 * f + 2] * normals[3 * g + 2] >=
    kSmoothEdge;

  // The corners at a place are a list.
  const first = new Int32Array(places.length).fill(-1);
  const next = new Int32Array(corners.length);
  const faceOf = new Int32Array(corners.length);
  for (let face = 0; face + 1 < offsets.length; ++face)
    for (let corner = offsets[face]; corner < offsets[face + 1]; ++corner) {
      faceOf[corner] = face;
      next[corner] = first[places[corners[corner]]];
      first[places[corners[corner]]] = corner;
    }

  const parents = Int32Array.from(corners.keys());
  const rootOf = (corner: number) => {
    while (parents[corner] !== corner) corner = parents[corner] = parents[parents[corner]];
    return corner;
  };
  // The corner at the current place whose face has the edge to a neighbour.
  const cornerTo = new Int32Array(places.length);
  const placeOfEdge = new Int32Array(places.length).fill(-1);
  for (let place = 0; place < places.length; ++place)
    for (let corner = first[place]; corner >= 0; corner = next[corner]) {
      const face = faceOf[corner];
      const [begin, end] = [offsets[face], offsets[face + 1]];
      const before = corner === begin ? end - 1 : corner - 1;
      const after = corner + 1 === end ? begin : corner + 1;
      for (const neighbour of [places[corners[before]], places[corners[after]]]) {
        if (placeOfEdge[neighbour] === place) {
          const other = cornerTo[neighbour];
          if (isSmooth(face, faceOf[other])) parents[rootOf(corner)] = rootOf(other);
        }
        placeOfEdge[neighbour] = place;
        cornerTo[neighbour] = corner;
      }
    }
  return parents.map((_, corner) => rootOf(corner));
}

/** The normals of faces, of length 1; 0 0 0 for a face without area. */
function faceNormals(points: Float64Array, offsets: Int32Array, corners: Int32Array): Float32Array {
  const normals = new Float32Array(3 * (offsets.length - 1));
  for (let face = 0; face + 1 < offsets.length; ++face) {
    let [x, y, z] = [0, 0, 0];
    const o = 3 * corners[offsets[face]];
    for (let i = offsets[face] + 1; i + 1 < offsets[face + 1]; ++i) {
      const [a, b] = [3 * corners[i], 3 * corners[i + 1]];
      const [ux, uy, uz] = [
        points[a] - points[o],
        points[a + 1] - points[o + 1],
        points[a + 2] - points[o + 2],
      ];
      const [vx, vy, vz] = [
        points[b] - points[o],
        points[b + 1] - points[o + 1],
        points[b + 2] - points[o + 2],
      ];
      x += uy * vz - uz * vy;
      y += uz * vx - ux * vz;
      z += ux * vy - uy * vx;
    }
    const length = Math.sqrt(x * x + y * y + z * z) || 1;
    normals[3 * face] = x / length;
    normals[3 * face + 1] = y / length;
    normals[3 * face + 2] = z / length;
  }
  return normals;
}

/** Cuts polygons into triangles that meet at the first corner of each. The triangles of a material are together.
 * @param drawn the drawn vertex of each corner
 */
function trianglesOf(offsets: Int32Array, drawn: Int32Array, materials: Int32Array | null) {
  const faceCount = offsets.length - 1;
  let count = 0;
  for (let face = 0; face < faceCount; ++face)
    count += Math.max(0, offsets[face + 1] - offsets[face] - 2);
  const triangles = new Uint32Array(3 * count);
  let end = 0;
  const add = (face: number) => {
    for (let i = offsets[face] + 1; i + 1 < offsets[face + 1]; ++i) {
      triangles[end++] = drawn[offsets[face]];
      triangles[end++] = drawn[i];
      triangles[end++] = drawn[i + 1];
    }
  };
  const parts: DrawnPart[] = [];
  if (!materials) for (let face = 0; face < faceCount; ++face) add(face);
  else {
    const facesOf = new Map<number, number[]>();
    materials.forEach((material, face) => {
      const faces = facesOf.get(material);
      if (faces) faces.push(face);
      else facesOf.set(material, [face]);
    });
    for (const [material, faces] of facesOf) {
      const start = end;
      faces.forEach(add);
      parts.push({ start, count: end - start, material });
    }
  }
  return { triangles, parts };
}
