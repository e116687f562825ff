// SPDX-License-Identifier: Apache-2.0
#include <espalier/base/error.h>
#include <espalier/base/vector3.h>
#include <espalier/shapes/attach.h>
#include <espalier/shapes/new_vertices.h>

#include <numeric>
#include <string>

#include "cell_loops.h"
#include "checks.h"

namespace espalier::shapes {
namespace {

void check(const Lattice& lattice, std::span<const NewVertex> newVertices) {
    requireConsistent("attach", "the lattice", lattice, 3);
    const Index count = lattice.complex.count(0);
    requireCountable("attach", {count + static_cast<Offset>(newVertices.size())});
    for (const NewVertex& vertex : newVertices) {
        requireFinite("attach", "the position of a new vertex", vertex.position);
        for (const Index from : vertex.attributesFrom)
            if (from < 0 || from >= count)
                throw ArgumentError("attach", "attributesFrom", std::to_string(from),
                                    concat("vertex 0 to ", count - 1));
    }
}

/// A boundary face to which a cell is attached.
struct AttachmentFace {
    Loop loop;  ///< anticlockwise seen from outside the lattice
    std::vector<Point3> positions;

    AttachmentFace(const std::string& who, const Lattice& lattice, FaceId face) {
        requireConsistent(who, "the lattice", lattice, 3);
        const far::CellComplex& complex = lattice.complex;
        if (face.value < 0 || face.value >= complex.count(2))
            throw ArgumentError(who, "face", std::to_string(face.value),
                                concat("face 0 to ", complex.count(2) - 1));
        const auto cells = complex.relation(2, 3)[face.value];
        if (cells.size() != 1)
            throw Error(concat(who, ": face ", face.value, " is between cells ", cells[0], " and ",
                               cells[1], "; expected a boundary face"));
        const auto faces = complex.relation(3, 2)[cells[0]];
        for (std::size_t i = 0; i < faces.size(); ++i)
            if (faces[i] == face.value) loop = far::outwardLoops(complex, CellId(cells[0]))[i];
        for (const Index vertex : loop) positions.push_back(lattice.positions[vertex]);
    }

    /// Throws unless a vector from the face points to the outside.
    void requireOutward(const std::string& who, const std::string& field, const Point3& vector,
                        const Point3& value) const {
        requireFinite(who, field, value);
        if (!(dot(areaVector(positions), vector) > 0))
            throw ArgumentError(
                who, field, textOf(value),
                "a vector that points outwards from the face, so that the cell has a volume "
                "above 0");
    }

    Loop reversed() const { return Loop(loop.rbegin(), loop.rend()); }
};

}  // namespace

Lattice attachPrism(const Lattice& lattice, FaceId face, const Point3& offset) {
    const AttachmentFace site("attachPrism", lattice, face);
    site.requireOutward("attachPrism", "offset", offset, offset);
    const std::size_t n = site.loop.size();
    const Index firstNew = lattice.complex.count(0);
    std::vector<NewVertex> newVertices;
    std::vector<Loop> loops = {site.reversed(), {}};
    for (std::size_t i = 0; i < n; ++i) {
        const auto top = [&](std::size_t corner) {
            return firstNew + static_cast<Index>(corner % n);
        };
        newVertices.push_back({sum(site.positions[i], offset), {site.loop[i]}});
        loops[1].push_back(top(i));
        loops.push_back({site.loop[i], site.loop[(i + 1) % n], top(i + 1), top(i)});
    }
    return attachCell(lattice, loops, newVertices);
}

Lattice attachPyramid(const Lattice& lattice, FaceId face, const Point3& apex) {
    const AttachmentFace site("attachPyramid", lattice, face);
    site.requireOutward("attachPyramid", "apex", difference(apex, mean(site.positions)), apex);
    const std::size_t n = site.loop.size();
    const Index newVertex = lattice.complex.count(0);
    std::vector<Loop> loops = {site.reversed()};
    for (std::size_t i = 0; i < n; ++i)
        loops.push_back({site.loop[i], site.loop[(i + 1) % n], newVertex});
    const NewVertex newVertices[] = {{apex, site.loop}};
    return attachCell(lattice, loops, newVertices);
}

Lattice attachCell(const Lattice& lattice, std::span<const std::vector<Index>> loops,
                   std::span<const NewVertex> newVertices) {
    check(lattice, newVertices);
    Lattice result = withNewVertices(lattice, newVertices);
    std::vector<Index> sameNumber(lattice.positions.size());
    std::iota(sameNumber.begin(), sameNumber.end(), Index{0});
    far::ComplexBuilder builder(3, static_cast<Index>(result.positions.size()));
    addAll(lattice.complex, sameNumber, builder);
    builder.addCell(loops);
    result.complex = builder.build();
    return result;
}

Lattice attachCell(const Lattice& lattice, far::StandardCell cell, std::span<const Index> vertices,
                   std::span<const NewVertex> newVertices) {
    if (std::ssize(vertices) != far::vertexCount(cell))
        throw ArgumentError("attach", "vertices", std::to_string(vertices.size()),
                            std::to_string(far::vertexCount(cell)));
    std::vector<Loop> loops = far::faceLoops(cell);
    for (Loop& loop : loops)
        for (Index& vertex : loop) vertex = vertices[vertex];
    return attachCell(lattice, loops, newVertices);
}

}  // namespace espalier::shapes
