// SPDX-License-Identifier: Apache-2.0
#include <espalier/embed/continuity.h>

#include <algorithm>
#include <vector>

#include "bind_options.h"
#include "espalier_solve.h"
#include "guard.h"
#include "handles.h"
#include "rows.h"

using namespace espalier;

static_assert(static_cast<int>(embed::Continuity::C2) == ESPALIER_CONTINUITY_C2);

namespace espalier::c {
namespace {

embed::Continuity continuityOf(std::int32_t value) {
    return choice(value, embed::Continuity::C2, "continuity");
}

/// Writes the vertices that `find` returns. Checks first that there is room for all vertices.
template <class Find>
void putHeld(std::int32_t room, std::int32_t all, std::int32_t* held, std::int32_t* count,
             const Find& find) {
    auto& outCount = deref(count, "held_count");
    checkCount(room, all, "vertices of room for the result");
    const auto out = array(held, room, "held");
    const std::vector<Index> vertices = find();
    std::copy(vertices.begin(), vertices.end(), out.begin());
    outCount = static_cast<std::int32_t>(vertices.size());
}

}  // namespace
}  // namespace espalier::c

espalier_status espalier_hold_faces(const espalier_refiner* refiner, int32_t face_count,
                                    const int32_t* faces, int32_t continuity, int32_t vertex_count,
                                    int32_t* held, int32_t* held_count) {
    return c::guarded([&] {
        const auto& own = c::deref(refiner, "refiner");
        const auto some = c::array(faces, face_count, "faces");
        const auto wanted = c::continuityOf(continuity);
        const auto base = c::baseOf(own.refiner);
        c::putHeld(vertex_count, base.level(0).complex.count(0), held, held_count,
                   [&] { return embed::verticesHoldingFaces(base, own.rules, some, wanted); });
    });
}

espalier_status espalier_hold_points(const espalier_refiner* refiner, int32_t vertex_count,
                                     const double* positions, int32_t point_count,
                                     const double* points, int32_t continuity,
                                     const espalier_bind_options* options, int32_t* held,
                                     int32_t* held_count) {
    return c::guarded([&] {
        const auto& own = c::deref(refiner, "refiner");
        const auto base = c::baseOf(own.refiner);
        const auto wanted = c::continuityOf(continuity);
        const auto chosen = c::levelOptionsOr(options, "points are held in a level");
        c::checkCount(vertex_count, base.level(0).complex.count(0), "positions of vertices");
        const auto rest = c::positions(positions, vertex_count, "positions");
        const auto model = c::positions(points, point_count, "points");
        c::putHeld(vertex_count, vertex_count, held, held_count, [&] {
            return embed::verticesHoldingPoints(base, rest, chosen.level, own.rules, model, wanted,
                                                c::embeddingOptions(chosen));
        });
    });
}

espalier_status espalier_hold_rows(const espalier_table* deformation, int32_t row_count,
                                   const int32_t* rows, int32_t vertex_count, int32_t* held,
                                   int32_t* held_count) {
    return c::guarded([&] {
        const auto& table = *c::deref(deformation, "deformation").table;
        c::putHeld(vertex_count, table.columnCount(), held, held_count, [&] {
            return c::withRows(table, row_count, rows, "rows",
                               [](const auto& some) { return embed::verticesHoldingRows(some); });
        });
    });
}
