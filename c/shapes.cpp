// SPDX-License-Identifier: Apache-2.0
#include <espalier/shapes/inventory.h>
#include <espalier/shapes/merge.h>

#include "arguments.h"
#include "guard.h"
#include "handles.h"

using namespace espalier;

namespace espalier::c {
namespace {

Point3 point(const double* values, const char* name) {
    const auto given = array(values, 1, name, 3);
    return {given[0], given[1], given[2]};
}

}  // namespace
}  // namespace espalier::c

espalier_status espalier_lattice_create_box(const int32_t cells[3], const double min[3],
                                            const double max[3], espalier_lattice** lattice) {
    return c::guarded([&] {
        auto& out = c::deref(lattice, "lattice");
        const auto counts = c::array(cells, 1, "cells", 3);
        out = new espalier_lattice{shapes::box(
            {{counts[0], counts[1], counts[2]}, c::point(min, "min"), c::point(max, "max")})};
    });
}

espalier_status espalier_lattice_create_cylinder(int32_t sectors, int32_t rings, int32_t layers,
                                                 double radius, const double from[3],
                                                 const double to[3], espalier_lattice** lattice) {
    return c::guarded([&] {
        auto& out = c::deref(lattice, "lattice");
        out = new espalier_lattice{shapes::cylinder({sectors,
                                                     {rings, shapes::Core::Wedges},
                                                     layers,
                                                     radius,
                                                     c::point(from, "from"),
                                                     c::point(to, "to")})};
    });
}

espalier_status espalier_lattice_create_merged(int64_t count,
                                               const espalier_lattice* const* lattices,
                                               double tolerance, espalier_lattice** lattice) {
    return c::guarded([&] {
        auto& out = c::deref(lattice, "lattice");
        std::vector<Lattice> parts;  // cheap: their complexes are shared
        for (const espalier_lattice* part : c::array(lattices, count, "lattices"))
            parts.push_back(c::deref(part, "one of the lattices").lattice);
        out = new espalier_lattice{shapes::merge(parts, {tolerance})};
    });
}
