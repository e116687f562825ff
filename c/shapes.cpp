// SPDX-License-Identifier: Apache-2.0
#include <espalier/cages/cage.h>
#include <espalier/cages/collar.h>
#include <espalier/shapes/around.h>
#include <espalier/shapes/attach.h>
#include <espalier/shapes/inventory.h>
#include <espalier/shapes/merge.h>
#include <espalier/shapes/remove_cells.h>
#include <espalier/shapes/solids.h>

#include <utility>
#include <vector>

#include "espalier_shapes.h"
#include "handles.h"

using namespace espalier;

static_assert(static_cast<int>(shapes::Core::Polygon) == ESPALIER_CORE_POLYGON);
static_assert(static_cast<int>(cages::Symmetric::None) == ESPALIER_SYMMETRIC_NONE);
static_assert(static_cast<int>(cages::Symmetric::XYZ) == ESPALIER_SYMMETRIC_XYZ);
static_assert(static_cast<int>(shapes::TorusSection::Disk) == ESPALIER_SECTION_DISK);

namespace espalier::c {
namespace {

shapes::DiskPattern pattern(std::int32_t rings, std::int32_t core) {
    return {rings, choice(core, shapes::Core::Polygon, "core")};
}

/// Makes a lattice of the inventory.
template <class Options>
espalier_lattice* make(Lattice (*shape)(const Options&), const Options& options) {
    return new espalier_lattice{shape(options)};
}

using RegularSolid = Lattice (*)(const shapes::RegularSolidOptions&);
constexpr RegularSolid kRegularSolids[] = {shapes::tetrahedron, shapes::cube, shapes::octahedron,
                                           shapes::dodecahedron, shapes::icosahedron};

using PolygonalSolid = Lattice (*)(const shapes::PolygonalSolidOptions&);
constexpr PolygonalSolid kPolygonalSolids[] = {shapes::prism, shapes::pyramid, shapes::bipyramid};

}  // namespace
}  // namespace espalier::c

espalier_status espalier_lattice_create_box(const int32_t cells[3], const double min[3],
                                            const double max[3], espalier_lattice** lattice) {
    return c::result(lattice, "lattice", [&] {
        const auto counts = c::array(cells, 1, "cells", 3);
        return c::make(
            shapes::box,
            {{counts[0], counts[1], counts[2]}, c::point(min, "min"), c::point(max, "max")});
    });
}

espalier_status espalier_lattice_create_around(int64_t point_count, const double* points,
                                               const espalier_around_options* options,
                                               espalier_lattice** lattice) {
    return c::result(lattice, "lattice", [&] {
        const auto places = c::positions(points, point_count, "points");
        const auto chosen = c::optionsOrDefaults(options, espalier_default_around_options(),
                                                 "espalier_default_around_options",
                                                 offsetof(espalier_around_options, symmetry_axis));
        shapes::AroundOptions around{.cells = {chosen.cells[0], chosen.cells[1], chosen.cells[2]},
                                     .cellSize = chosen.cell_size,
                                     .cellsAlongLongest = chosen.cells_along_longest,
                                     .margin = chosen.margin,
                                     .oriented = chosen.oriented != 0};
        if (chosen.symmetry_axis != -1)
            around.symmetry = {chosen.symmetry_axis, chosen.symmetry_at};
        return new espalier_lattice{shapes::around(places, around)};
    });
}

espalier_status espalier_lattice_create_cage(int32_t point_count, const double* points,
                                             const espalier_polygons* faces,
                                             const espalier_cage_options* options,
                                             espalier_lattice** lattice) {
    return c::result(lattice, "lattice", [&] {
        const auto places = c::positions(points, point_count, "points");
        const auto& given = c::deref(faces, "faces");
        const auto offsets = c::checkedOffsets(given.offsets, given.face_count, "offsets");
        const auto corners = c::array(given.corners, offsets.back(), "corners");
        const auto chosen = c::optionsOrDefaults(options, espalier_default_cage_options(),
                                                 "espalier_default_cage_options");
        const std::vector<std::size_t> ends(offsets.begin() + 1, offsets.end());
        return new espalier_lattice{cages::cage(
            {places, corners, ends},
            {.vertices = chosen.vertices,
             .cellSize = chosen.cell_size,
             .margin = chosen.margin,
             .shell = chosen.shell,
             .keepApart = chosen.keep_apart != 0,
             .symmetric = c::choice(chosen.symmetric, cages::Symmetric::XYZ, "symmetric"),
             .symmetry = chosen.symmetry})};
    });
}

espalier_status espalier_lattice_create_collar(const espalier_lattice* lattice,
                                               const espalier_collar_options* options,
                                               espalier_lattice** result) {
    return c::result(result, "result", [&] {
        const auto& given = c::deref(lattice, "lattice").lattice;
        const auto chosen = c::optionsOrDefaults(options, espalier_default_collar_options(),
                                                 "espalier_default_collar_options");
        cages::CollarOptions collar{
            .layers = chosen.layers, .reach = chosen.reach, .held = chosen.held};
        if (chosen.until != nullptr) {
            const auto corners = c::positions(chosen.until, 2, "until");
            collar.until = {corners[0], corners[1]};
        }
        for (std::size_t side = 0; side < 6; ++side) collar.open[side] = chosen.open[side] != 0;
        return new espalier_lattice{cages::collar(given, collar).lattice};
    });
}

espalier_status espalier_lattice_create_cylinder(int32_t sectors, int32_t rings, int32_t core,
                                                 int32_t layers, double radius,
                                                 const double from[3], const double to[3],
                                                 espalier_lattice** lattice) {
    return c::result(lattice, "lattice", [&] {
        return c::make(shapes::cylinder, {sectors, c::pattern(rings, core), layers, radius,
                                          c::point(from, "from"), c::point(to, "to")});
    });
}

espalier_status espalier_lattice_create_torus(const espalier_torus_options* options,
                                              espalier_lattice** lattice) {
    return c::result(lattice, "lattice", [&] {
        const auto chosen = c::optionsOrDefaults(options, espalier_default_torus_options(),
                                                 "espalier_default_torus_options");
        return c::make(shapes::torus,
                       {.segments = chosen.segments,
                        .section = c::choice(chosen.section, shapes::TorusSection::Disk, "section"),
                        .gridCells = chosen.grid_cells,
                        .sides = chosen.sides,
                        .pattern = c::pattern(chosen.rings, chosen.core),
                        .majorRadius = chosen.major_radius,
                        .minorRadius = chosen.minor_radius});
    });
}

espalier_status espalier_lattice_create_star(const espalier_star_options* options,
                                             espalier_lattice** lattice) {
    return c::result(lattice, "lattice", [&] {
        const auto chosen = c::optionsOrDefaults(options, espalier_default_star_options(),
                                                 "espalier_default_star_options");
        return c::make(shapes::star, {.points = chosen.points,
                                      .pattern = c::pattern(chosen.rings, chosen.core),
                                      .layers = chosen.layers,
                                      .innerRadius = chosen.inner_radius,
                                      .outerRadius = chosen.outer_radius,
                                      .height = chosen.height});
    });
}

espalier_status espalier_lattice_create_barbell(const espalier_barbell_options* options,
                                                espalier_lattice** lattice) {
    return c::result(lattice, "lattice", [&] {
        const auto chosen = c::optionsOrDefaults(options, espalier_default_barbell_options(),
                                                 "espalier_default_barbell_options");
        return c::make(shapes::barbell, {.endSegments = chosen.end_segments,
                                         .barSegments = chosen.bar_segments,
                                         .barAcross = chosen.bar_across,
                                         .pattern = c::pattern(chosen.rings, chosen.core),
                                         .layers = chosen.layers,
                                         .endRadius = chosen.end_radius,
                                         .barLength = chosen.bar_length,
                                         .barHalfWidth = chosen.bar_half_width,
                                         .roundness = chosen.roundness,
                                         .height = chosen.height});
    });
}

espalier_status espalier_lattice_create_arm(const espalier_arm_options* options,
                                            espalier_lattice** lattice) {
    return c::result(lattice, "lattice", [&] {
        const auto chosen = c::optionsOrDefaults(options, espalier_default_arm_options(),
                                                 "espalier_default_arm_options");
        std::vector<shapes::ArmJoint> joints;
        for (const auto& joint : c::array(chosen.joints, chosen.joint_count, "joints"))
            joints.push_back({c::point(joint.position, "position"), joint.radius, joint.twist});
        return c::make(shapes::arm, {.joints = std::move(joints),
                                     .segments = chosen.segments,
                                     .sides = chosen.sides,
                                     .pattern = c::pattern(chosen.rings, chosen.core),
                                     .up = c::point(chosen.up, "up")});
    });
}

espalier_status espalier_lattice_create_regular_solid(int32_t solid, double radius,
                                                      espalier_lattice** lattice) {
    return c::result(lattice, "lattice", [&] {
        const auto number = c::choice(solid, std::int32_t{ESPALIER_SOLID_ICOSAHEDRON}, "solid");
        return c::make(c::kRegularSolids[number], {radius});
    });
}

espalier_status espalier_lattice_create_polygonal_solid(int32_t solid, int32_t sides, double radius,
                                                        double height, espalier_lattice** lattice) {
    return c::result(lattice, "lattice", [&] {
        const auto number = c::choice(solid, std::int32_t{ESPALIER_SOLID_BIPYRAMID}, "solid");
        return c::make(c::kPolygonalSolids[number], {sides, radius, height});
    });
}

espalier_status espalier_lattice_create_with_prism(const espalier_lattice* lattice, int32_t face,
                                                   const double offset[3],
                                                   espalier_lattice** result) {
    return c::result(result, "result", [&] {
        const Lattice& own = c::deref(lattice, "lattice").lattice;
        return new espalier_lattice{
            shapes::attachPrism(own, FaceId(face), c::point(offset, "offset"))};
    });
}

espalier_status espalier_lattice_create_with_pyramid(const espalier_lattice* lattice, int32_t face,
                                                     const double apex[3],
                                                     espalier_lattice** result) {
    return c::result(result, "result", [&] {
        const Lattice& own = c::deref(lattice, "lattice").lattice;
        return new espalier_lattice{
            shapes::attachPyramid(own, FaceId(face), c::point(apex, "apex"))};
    });
}

espalier_status espalier_lattice_create_without_cells(const espalier_lattice* lattice,
                                                      int32_t cell_count, const int32_t* cells,
                                                      espalier_lattice** result) {
    return c::result(result, "result", [&] {
        const Lattice& own = c::deref(lattice, "lattice").lattice;
        return new espalier_lattice{shapes::removeCells(own, c::array(cells, cell_count, "cells"))};
    });
}

espalier_status espalier_lattice_create_merged(int64_t count,
                                               const espalier_lattice* const* lattices,
                                               double tolerance, espalier_lattice** lattice) {
    return c::result(lattice, "lattice", [&] {
        std::vector<Lattice> parts;  // Copies are cheap, since lattices share their complexes.
        for (const espalier_lattice* part : c::array(lattices, count, "lattices"))
            parts.push_back(c::deref(part, "one of the lattices").lattice);
        return new espalier_lattice{shapes::merge(parts, {tolerance})};
    });
}
