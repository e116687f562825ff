// SPDX-License-Identifier: Apache-2.0
#ifndef ESPALIER_SHAPES_H
#define ESPALIER_SHAPES_H

#include "espalier.h"

/// Lattices made by code, from C: the inventory of ready lattices (shapes/inventory.h,
/// shapes/solids.h), and lattices around a model (shapes/around.h, cages/cage.h). Each lattice is
/// valid, has no duplicate vertices, and has cells of positive volume. The topology of a lattice of
/// the inventory depends on the integer fields only: two calls that differ only in lengths and
/// positions give two poses of one lattice.
///
/// The rules of espalier.h on errors, ownership and threads apply. If a field is out of range, a
/// function fails with ESPALIER_ERROR_INPUT, and the message names the first such field.

#ifdef __cplusplus
extern "C" {
#endif

/// Makes a box of hexahedra (shapes/inventory.h). Vertex (i, j, k) has the number i + (cells[0] +
/// 1) (j + (cells[1] + 1) k).
///
/// \param cells number of cells along x, y and z: 1 or more each
/// \param min, max opposite corners; `max` is above `min` in each coordinate
ESPALIER_C_API espalier_status espalier_lattice_create_box(const int32_t cells[3],
                                                           const double min[3], const double max[3],
                                                           espalier_lattice** lattice);

/// A box of hexahedra around the points of a model (shapes/around.h). Start from
/// espalier_default_around_options(): later versions may add fields, and `size` tells the library
/// which fields exist.
///
/// The number of cells comes from the first of `cells`, `cell_size` and `cells_along_longest` that
/// is set.
typedef struct espalier_around_options {
    size_t size;       ///< sizeof(espalier_around_options)
    int32_t cells[3];  ///< cells along x, y and z: 1 or more each; default zeros: not set
    int32_t cells_along_longest;  ///< cells along the longest side, 1 or more; the other sides get
                                  ///< the numbers for which the cells are closest to cubes;
                                  ///< default 4
    int32_t oriented;  ///< nonzero: turn the box so that its volume is smallest, as far as a search
                       ///< finds it; default 0: the sides are parallel to the axes
    double cell_size;  ///< largest edge of a cell, in the units of the points, above 0; default 0:
                       ///< not set
    double margin;     ///< distance from the points to the sides of the box, as a fraction of the
                       ///< diagonal of the box around the points: 0 or more; default 0.05
    int32_t symmetry_axis;  ///< 0 to 2: faces of the box lie exactly in a plane across this axis, a
                            ///< side of the box if all points are on one side of it, else the
                            ///< middle; default -1: none. Not with `oriented`
    double symmetry_at;     ///< coordinate of that plane; default 0
} espalier_around_options;

static inline espalier_around_options espalier_default_around_options(void) {
    espalier_around_options options;
    options.size = sizeof options;
    options.cells[0] = options.cells[1] = options.cells[2] = 0;
    options.cells_along_longest = 4;
    options.oriented = 0;
    options.cell_size = 0;
    options.margin = 0.05;
    options.symmetry_axis = -1;
    options.symmetry_at = 0;
    return options;
}

/// Makes a box of hexahedra around points. It contains every point, and so do all refinements and
/// the limit of the lattice under the default rules. Where rounding leaves points outside, the
/// margin is doubled until all are inside.
///
/// \param point_count 1 or more
/// \param points 3 · point_count numbers
/// \param options null for the defaults
/// \retval ESPALIER_ERROR_INPUT an option is out of range; a point is not finite; all points are at
///         one place; or they lie in a plane and the margin is 0
/// \cost O(point_count); O(point_count · log point_count) if `oriented`
ESPALIER_C_API espalier_status
espalier_lattice_create_around(int64_t point_count, const double* points,
                               const espalier_around_options* options, espalier_lattice** lattice);

/// The planes about which a cage is symmetric, across the coordinate axes (cages/cage.h).
enum {
    ESPALIER_SYMMETRIC_AUTO = 0,  ///< all planes about which the model is symmetric
    ESPALIER_SYMMETRIC_NONE = 1,
    ESPALIER_SYMMETRIC_X = 2,  ///< the plane across x, whatever the model is like
    ESPALIER_SYMMETRIC_Y = 3,
    ESPALIER_SYMMETRIC_Z = 4,
    ESPALIER_SYMMETRIC_XY = 5,  ///< two planes
    ESPALIER_SYMMETRIC_XZ = 6,
    ESPALIER_SYMMETRIC_YZ = 7,
    ESPALIER_SYMMETRIC_XYZ = 8
};

/// A lattice that follows the shape of a model (cages/cage.h). Start from
/// espalier_default_cage_options(): later versions may add fields, and `size` tells the library
/// which fields exist.
typedef struct espalier_cage_options {
    size_t size;         ///< sizeof(espalier_cage_options)
    int32_t vertices;    ///< number of vertices, 8 to 100,000; the result has between 0.8 and 1.2
                         ///< times as many; default 200
    int32_t keep_apart;  ///< nonzero: parts of the model that are nearer to each other than a cell
                         ///< stay separate; default 0
    double cell_size;    ///< edge of the cells before they are fitted, in the units of the points,
                         ///< above 0; `vertices` is not used then; default 0: not set
    double margin;       ///< least distance from the model to the boundary of the limit volume, as
                         ///< a fraction of the diagonal of the box around the model: 0 to 1;
                         ///< default 0
    double shell;        ///< above 0: the lattice is made around the surface only, and contains all
                         ///< points within half of this distance; default 0: around the solid
    double symmetry;     ///< largest distance of a mirrored point from the model that counts as
                         ///< symmetric, as a fraction of the diagonal: 0 to 1; default 1e-4
    int32_t symmetric;   ///< ESPALIER_SYMMETRIC_...; default AUTO
} espalier_cage_options;

static inline espalier_cage_options espalier_default_cage_options(void) {
    espalier_cage_options options;
    options.size = sizeof options;
    options.vertices = 200;
    options.keep_apart = 0;
    options.cell_size = 0;
    options.margin = 0;
    options.shell = 0;
    options.symmetry = 1e-4;
    options.symmetric = ESPALIER_SYMMETRIC_AUTO;
    return options;
}

/// Makes a lattice of hexahedra that follows the shape of a model. The faces may be any polygons,
/// in any order, wound in any way; they may intersect, leave gaps, or occur several times. The
/// result is proved: it contains every point of the model, at level 3 and in the limit, and every
/// patch of its limit volume has a positive Jacobian.
///
/// \param points 3 · point_count numbers
/// \param options null for the defaults
/// \retval ESPALIER_ERROR_INPUT there are no faces; a face names a point that does not exist; a
/// point
///         is not finite; all points are at one place; an option is out of range; or no lattice of
///         about this size can be fitted, which happens for tangled models and few vertices
/// \cost on one thread about 5 s for 100,000 triangles and 500 vertices; docs/cages.md has times
ESPALIER_C_API espalier_status espalier_lattice_create_cage(int32_t point_count,
                                                            const double* points,
                                                            const espalier_polygons* faces,
                                                            const espalier_cage_options* options,
                                                            espalier_lattice** lattice);

/// A collar around a lattice (cages/collar.h). Start from espalier_default_collar_options(): later
/// versions may add fields, and `size` tells the library which fields exist. Set `reach` or
/// `until`.
typedef struct espalier_collar_options {
    size_t size;          ///< sizeof(espalier_collar_options)
    int32_t layers;       ///< layers of cells, 1 to 100; default 3
    int32_t held;         ///< outer layers of vertices that are held; default 0: two, or one if
                          ///< there is one layer of cells
    double reach;         ///< thickness of the collar, above 0, in the units of the lattice;
                          ///< default 0: not set
    const double* until;  ///< six numbers, two opposite corners of a box to reach to, or null (the
                          ///< default); only around a box along the axes
    int32_t open[6];  ///< nonzero: no collar on the side −x, +x, −y, +y, −z, +z; default zeros
} espalier_collar_options;

static inline espalier_collar_options espalier_default_collar_options(void) {
    espalier_collar_options options;
    options.size = sizeof options;
    options.layers = 3;
    options.held = 0;
    options.reach = 0;
    options.until = NULL;
    options.open[0] = options.open[1] = options.open[2] = 0;
    options.open[3] = options.open[4] = options.open[5] = 0;
    return options;
}

/// Makes a lattice with layers of cells around the given one, whose outer vertices are held
/// (espalier_lattice_held_weights(), espalier_lattice_fit()), so that its motion fades out: C² if
/// two layers of vertices are held, C⁰ if one is. Vertices and cells of the lattice keep their
/// numbers. No cell of the result is folded, except cells of the lattice that are folded without
/// the collar.
///
/// \retval ESPALIER_ERROR_INPUT an option is out of range, cells would fold, overlap or be thicker
///         than twice the reach (the message names a vertex), or the boundary of the lattice is not
///         a manifold
ESPALIER_C_API espalier_status
espalier_lattice_create_collar(const espalier_lattice* lattice,
                               const espalier_collar_options* options, espalier_lattice** result);

/// The cells in the middle of a disk (shapes/section.h).
enum {
    ESPALIER_CORE_WEDGES = 0,  ///< a vertex with triangles around it, which are swept to wedges
    ESPALIER_CORE_POLYGON = 1  ///< one face with as many sides as the disk, which is swept to a
                               ///< prism
};

/// Makes a disk that is swept along an axis, with wedges around the axis (shapes/inventory.h).
///
/// \param sectors number of sides of the disk, 3 or more
/// \param rings number of rings of cells in the disk, 1 or more
/// \param core ESPALIER_CORE_...
/// \param layers number of layers of cells along the axis, 1 or more
/// \param radius of the outermost vertices, above 0
/// \param from, to the centres of the two ends: x, y, z each
ESPALIER_C_API espalier_status espalier_lattice_create_cylinder(int32_t sectors, int32_t rings,
                                                                int32_t core, int32_t layers,
                                                                double radius, const double from[3],
                                                                const double to[3],
                                                                espalier_lattice** lattice);

/// The cross-section of a torus.
enum { ESPALIER_SECTION_GRID = 0, ESPALIER_SECTION_DISK = 1 };

/// A cross-section that is swept around the z axis, about the origin. Start from
/// espalier_default_torus_options(): later versions may add fields, and `size` tells the library
/// which fields exist.
typedef struct espalier_torus_options {
    size_t size;          ///< sizeof(espalier_torus_options)
    int32_t segments;     ///< cells around the torus: 3 or more; default 8
    int32_t section;      ///< ESPALIER_SECTION_...; default GRID
    int32_t grid_cells;   ///< cells along each side of the square of a grid: 1 or more; default 1
    int32_t sides;        ///< sides of a disk: 3 or more; default 6
    int32_t rings;        ///< rings of cells in a disk: 1 or more; default 1
    int32_t core;         ///< core of a disk: ESPALIER_CORE_...; default WEDGES
    double major_radius;  ///< radius of the circle along which the section is swept; default 1
    double minor_radius;  ///< half the side of the square, or the radius of the disk: above 0 and
                          ///< below major_radius; default 0.4
} espalier_torus_options;

static inline espalier_torus_options espalier_default_torus_options(void) {
    espalier_torus_options options;
    options.size = sizeof options;
    options.segments = 8;
    options.section = ESPALIER_SECTION_GRID;
    options.grid_cells = 1;
    options.sides = 6;
    options.rings = 1;
    options.core = ESPALIER_CORE_WEDGES;
    options.major_radius = 1;
    options.minor_radius = 0.4;
    return options;
}

/// Makes a torus.
/// \param options null for the defaults
ESPALIER_C_API espalier_status espalier_lattice_create_torus(const espalier_torus_options* options,
                                                             espalier_lattice** lattice);

/// A flat star: a disk in the plane z = 0, thickened to both sides. Its outermost vertices
/// alternate between outer_radius and inner_radius; the first is on the +x axis. With equal radii
/// it is the round rest pose of the same lattice.
typedef struct espalier_star_options {
    size_t size;          ///< sizeof(espalier_star_options)
    int32_t points;       ///< 2 or more; default 5
    int32_t rings;        ///< rings of cells in the disk: 1 or more; default 1
    int32_t core;         ///< ESPALIER_CORE_...; default WEDGES
    int32_t layers;       ///< 1 or more; default 1
    double inner_radius;  ///< above 0; default 0.5
    double outer_radius;  ///< above 0; default 1
    double height;        ///< above 0; default 0.25
} espalier_star_options;

static inline espalier_star_options espalier_default_star_options(void) {
    espalier_star_options options;
    options.size = sizeof options;
    options.points = 5;
    options.rings = 1;
    options.core = ESPALIER_CORE_WEDGES;
    options.layers = 1;
    options.inner_radius = 0.5;
    options.outer_radius = 1;
    options.height = 0.25;
    return options;
}

/// Makes a star.
/// \param options null for the defaults
ESPALIER_C_API espalier_status espalier_lattice_create_star(const espalier_star_options* options,
                                                            espalier_lattice** lattice);

/// Two ends joined by a bar along x, in the plane z = 0, thickened to both sides.
///
/// If roundness is 0, bar_half_width = end_radius, and end_segments is a multiple of 3, the barbell
/// is a rectangular block: the rest pose of a barbell with the same topology.
typedef struct espalier_barbell_options {
    size_t size;            ///< sizeof(espalier_barbell_options)
    int32_t end_segments;   ///< edges around an end, without the edges at the bar: 3 or more;
                            ///< default 6
    int32_t bar_segments;   ///< cells along the bar: 1 or more; default 2
    int32_t bar_across;     ///< cells across the bar: 1 or more; default 2
    int32_t rings;          ///< rings of cells in an end: 1 or more; default 1
    int32_t core;           ///< core of the ends: ESPALIER_CORE_...; default WEDGES
    int32_t layers;         ///< 1 or more; default 1
    double end_radius;      ///< radius of a round end, or half the side of a square one: above 0;
                            ///< default 1
    double bar_length;      ///< distance between the ends: above 0; default 2
    double bar_half_width;  ///< above 0 and at most end_radius, or below end_radius if roundness is
                            ///< 1; default 0.4
    double roundness;       ///< shape of the ends: 0 is square, 1 is round; default 1
    double height;          ///< above 0; default 0.5
} espalier_barbell_options;

static inline espalier_barbell_options espalier_default_barbell_options(void) {
    espalier_barbell_options options;
    options.size = sizeof options;
    options.end_segments = 6;
    options.bar_segments = 2;
    options.bar_across = 2;
    options.rings = 1;
    options.core = ESPALIER_CORE_WEDGES;
    options.layers = 1;
    options.end_radius = 1;
    options.bar_length = 2;
    options.bar_half_width = 0.4;
    options.roundness = 1;
    options.height = 0.5;
    return options;
}

/// Makes a barbell.
/// \param options null for the defaults
ESPALIER_C_API espalier_status espalier_lattice_create_barbell(
    const espalier_barbell_options* options, espalier_lattice** lattice);

/// A point of the polyline around which an arm is built.
typedef struct espalier_arm_joint {
    double position[3];
    double radius;  ///< radius of the cross-section, above 0
    double twist;   ///< rotation of the cross-section about the arm, in radians: anticlockwise when
                    ///< looking back from the end of the arm
} espalier_arm_joint;

/// A tube around an arm: shoulder, elbow, wrist, hand. Other positions and twists give a pose of
/// the same lattice. shapes/inventory.h describes the cross-sections at the joints.
typedef struct espalier_arm_options {
    size_t size;          ///< sizeof(espalier_arm_options)
    int32_t segments;     ///< cells from joint to joint: 1 or more; default 2
    int32_t sides;        ///< sides of the cross-section: 3 or more; default 4
    int32_t rings;        ///< rings of cells in the cross-section: 1 or more; default 1
    int32_t core;         ///< ESPALIER_CORE_...; default POLYGON
    int64_t joint_count;  ///< 2 or more; default 4
    const espalier_arm_joint* joints;  ///< consecutive joints are at different positions, and the
                                       ///< polyline does not turn back on itself; default a
                                       ///< straight arm of length 2.5 along x
    double up[3];  ///< direction from the first bone to the first vertex of the cross-section; not
                   ///< parallel to that bone; the same for all poses of a lattice; default +z
} espalier_arm_options;

static inline espalier_arm_options espalier_default_arm_options(void) {
    static const espalier_arm_joint joints[4] = {
        {{0, 0, 0}, 0.3, 0}, {{1, 0, 0}, 0.25, 0}, {{2, 0, 0}, 0.2, 0}, {{2.5, 0, 0}, 0.2, 0}};
    espalier_arm_options options;
    options.size = sizeof options;
    options.segments = 2;
    options.sides = 4;
    options.rings = 1;
    options.core = ESPALIER_CORE_POLYGON;
    options.joint_count = 4;
    options.joints = joints;
    options.up[0] = options.up[1] = 0;
    options.up[2] = 1;
    return options;
}

/// Makes an arm.
/// \param options null for the defaults
ESPALIER_C_API espalier_status espalier_lattice_create_arm(const espalier_arm_options* options,
                                                           espalier_lattice** lattice);

/// Regular solids centred at the origin (shapes/solids.h).
enum {
    ESPALIER_SOLID_TETRAHEDRON = 0,
    ESPALIER_SOLID_CUBE = 1,
    ESPALIER_SOLID_OCTAHEDRON = 2,
    ESPALIER_SOLID_DODECAHEDRON = 3,
    ESPALIER_SOLID_ICOSAHEDRON = 4
};

/// Makes a lattice of a single cell, which is a regular solid.
///
/// \param solid ESPALIER_SOLID_...
/// \param radius of the sphere through the vertices, above 0
ESPALIER_C_API espalier_status espalier_lattice_create_regular_solid(int32_t solid, double radius,
                                                                     espalier_lattice** lattice);

/// Solids over a regular polygon in a plane of constant z. The polygon has a vertex in the
/// direction of +x (shapes/solids.h).
enum {
    ESPALIER_SOLID_PRISM = 0,    ///< the polygon at the bottom and at the top
    ESPALIER_SOLID_PYRAMID = 1,  ///< the polygon at the bottom, and an apex at the top
    ESPALIER_SOLID_BIPYRAMID =
        2  ///< the polygon in the middle, an apex at the bottom and one at the top
};

/// Makes a lattice of a single cell over a regular polygon.
///
/// \param solid ESPALIER_SOLID_PRISM, PYRAMID or BIPYRAMID
/// \param sides number of sides of the polygon: 3 or more
/// \param radius of the circle through the vertices of the polygon, above 0
/// \param height above 0; the solid extends from −height / 2 to height / 2
ESPALIER_C_API espalier_status espalier_lattice_create_polygonal_solid(int32_t solid, int32_t sides,
                                                                       double radius, double height,
                                                                       espalier_lattice** lattice);

/// Makes a lattice with one more cell, a prism on a boundary face of the given lattice: the face,
/// moved by an offset, is the opposite face (shapes/attach.h). Vertices and cells keep their
/// numbers and marks. New vertices follow, in the order of the vertices of the face, and are not
/// welded to others: espalier_lattice_create_merged() does that.
///
/// \param face number of a face at level 0 (espalier_refiner_cells()), in one cell
/// \param offset to the outside
ESPALIER_C_API espalier_status espalier_lattice_create_with_prism(const espalier_lattice* lattice,
                                                                  int32_t face,
                                                                  const double offset[3],
                                                                  espalier_lattice** result);

/// Makes a lattice with one more cell, a pyramid on a boundary face, in the same way.
/// \param apex position of its one new vertex, outside the lattice
ESPALIER_C_API espalier_status espalier_lattice_create_with_pyramid(const espalier_lattice* lattice,
                                                                    int32_t face,
                                                                    const double apex[3],
                                                                    espalier_lattice** result);

/// Makes a lattice without some cells, and without the vertices that no other cell has
/// (shapes/remove_cells.h). The other vertices and cells keep their order and marks.
///
/// \retval ESPALIER_ERROR_INPUT a cell does not exist, or no cell would remain
ESPALIER_C_API espalier_status
espalier_lattice_create_without_cells(const espalier_lattice* lattice, int32_t cell_count,
                                      const int32_t* cells, espalier_lattice** result);

/// Joins lattices by welding vertices that coincide (shapes/merge.h).
///
/// \param count number of lattices, 1 or more
/// \param tolerance maximum distance of vertices that are welded, as a fraction of the diagonal of
///        the bounding box of all lattices; 1e-6 is usual
ESPALIER_C_API espalier_status
espalier_lattice_create_merged(int64_t count, const espalier_lattice* const* lattices,
                               double tolerance, espalier_lattice** lattice);

#ifdef __cplusplus
}
#endif

#endif
