// SPDX-License-Identifier: Apache-2.0
#include <espalier/base/disjoint_sets.h>
#include <espalier/base/error.h>
#include <espalier/base/sort_unique.h>
#include <espalier/far/cell_complex.h>
#include <espalier/far/topology_error.h>

#include <algorithm>
#include <string>
#include <utility>

#include "valid_lattice.h"

namespace espalier::far {
namespace {

[[noreturn]] void refuse(TopologyCause cause, Entity entity, const std::string& why) {
    throw TopologyError(cause, entity,
                        concat(dimensionName(entity.dimension), " ", entity.index, why));
}

std::string edgeName(const CellComplex& complex, Index edge) {
    const auto ends = complex.relation(1, 0)[edge];
    return concat("edge (", ends[0], ", ", ends[1], ")");
}

void checkEdge(const CellComplex& complex, Index edge) {
    const auto ends = complex.relation(1, 0)[edge];
    if (ends.size() != 2 || (ends[0] == ends[1] && complex.dimension() != 2))
        refuse(TopologyCause::RepeatedVertex, {1, edge}, " does not join two different vertices");
    const auto signs = complex.boundary(1).signs(edge);
    if (signs[0] != -1 || signs[1] != 1)
        refuse(TopologyCause::NotOrientable, {1, edge},
               " does not run from its first vertex to its second");
}

void checkFace(const CellComplex& complex, Index face) {
    const auto loop = complex.relation(2, 0)[face];
    const auto edges = complex.relation(2, 1)[face];
    const auto signs = complex.boundary(2).signs(face);
    if (loop.size() < 3)
        refuse(TopologyCause::TooFewVertices, {2, face}, " has fewer than three vertices");
    for (std::size_t i = 0; i < loop.size(); ++i) {
        const auto ends = complex.relation(1, 0)[edges[i]];
        if (ends[signs[i] > 0 ? 1 : 0] != loop[(i + 1) % loop.size()])
            refuse(TopologyCause::NotOrientable, {2, face}, " has edges that do not form a loop");
    }
    if (complex.dimension() == 2) return;
    if (const auto twice = repeatedIn(loop))
        refuse(TopologyCause::RepeatedVertex, {2, face},
               concat(" names vertex ", *twice, " twice"));
}

/// An edge of a face of a cell, seen from the cell.
struct FaceSide {
    Index edge;
    std::size_t face;    ///< position among the faces of the cell
    std::size_t corner;  ///< position of the edge in the face's loop
    int sign;            ///< +1 if the outward loop of the face runs from tail to head, else −1
};

/// Checks that the faces of one cell form a sphere.
void checkCell(const CellComplex& complex, Index cell) {
    const Entity entity{3, cell};
    const auto faces = complex.relation(3, 2)[cell];
    const auto cellSigns = complex.boundary(3).signs(cell);

    if (const auto twice = repeatedIn(faces))
        refuse(TopologyCause::RepeatedFace, entity, concat(" lists face ", *twice, " twice"));

    // The corners of all faces are numbered consecutively; firstCorner[f] is the first of face f.
    std::vector<std::size_t> firstCorner(faces.size() + 1, 0);
    std::vector<FaceSide> sides;
    for (std::size_t f = 0; f < faces.size(); ++f) {
        const auto edges = complex.relation(2, 1)[faces[f]];
        const auto edgeSigns = complex.boundary(2).signs(faces[f]);
        firstCorner[f + 1] = firstCorner[f] + edges.size();
        for (std::size_t i = 0; i < edges.size(); ++i)
            sides.push_back({edges[i], f, i, cellSigns[f] * edgeSigns[i]});
    }
    std::sort(sides.begin(), sides.end(), [](const FaceSide& a, const FaceSide& b) {
        return std::pair(a.edge, a.face) < std::pair(b.edge, b.face);
    });

    // Each edge joins two faces and, at each of its ends, one corner of each face.
    DisjointSets pieces(faces.size());
    DisjointSets fans(firstCorner.back());
    const auto cornerAt = [&](const FaceSide& side, Index vertex) {
        const auto loop = complex.relation(2, 0)[faces[side.face]];
        const std::size_t i =
            loop[side.corner] == vertex ? side.corner : (side.corner + 1) % loop.size();
        return firstCorner[side.face] + i;
    };
    for (std::size_t i = 0; i < sides.size();) {
        std::size_t end = i + 1;
        while (end < sides.size() && sides[end].edge == sides[i].edge) ++end;
        const auto name = [&] { return edgeName(complex, sides[i].edge); };
        if (end - i == 1)
            refuse(TopologyCause::OpenCell, entity,
                   concat(" is open: its ", name(), " lies in only one of its faces, face ",
                          faces[sides[i].face]));
        if (end - i > 2)
            refuse(TopologyCause::CrowdedEdge, entity,
                   concat(" has ", end - i, " faces at its ", name(), "; expected 2"));
        if (sides[i].sign == sides[i + 1].sign)
            refuse(TopologyCause::NotOrientable, entity,
                   " has faces whose directions disagree at its " + name());
        pieces.join(sides[i].face, sides[i + 1].face);
        for (const Index vertex : complex.relation(1, 0)[sides[i].edge])
            fans.join(cornerAt(sides[i], vertex), cornerAt(sides[i + 1], vertex));
        i = end;
    }
    if (pieces.setCount() != 1)
        refuse(TopologyCause::NotASphere, entity,
               concat(" has a surface of ", pieces.setCount(), " pieces; expected 1"));

    const auto vertices = complex.relation(3, 0)[cell];
    if (fans.setCount() != vertices.size()) {
        // Some vertex has more than one fan: find it for the message.
        std::vector<std::pair<Index, std::size_t>> fanOf;
        for (std::size_t f = 0; f < faces.size(); ++f) {
            const auto loop = complex.relation(2, 0)[faces[f]];
            for (std::size_t i = 0; i < loop.size(); ++i)
                fanOf.emplace_back(loop[i], fans.rootOf(firstCorner[f] + i));
        }
        std::sort(fanOf.begin(), fanOf.end());
        const auto pinch =
            std::adjacent_find(fanOf.begin(), fanOf.end(), [](const auto& a, const auto& b) {
                return a.first == b.first && a.second != b.second;
            });
        refuse(
            TopologyCause::PinchedCell, entity,
            concat(" is pinched: its faces at vertex ", pinch->first, " form more than one fan"));
    }
    const auto edgeCount = static_cast<std::ptrdiff_t>(sides.size() / 2);
    const std::ptrdiff_t euler = static_cast<std::ptrdiff_t>(vertices.size()) - edgeCount +
                                 static_cast<std::ptrdiff_t>(faces.size());
    if (euler != 2)
        refuse(TopologyCause::NotASphere, entity,
               concat(" has a surface that is no sphere: its Euler characteristic is ", euler,
                      "; expected 2"));
}

/// Checks that one or two cells contain a face, from opposite sides.
void checkCellsOfFace(const CellComplex& complex, Index face) {
    const auto cells = complex.relation(2, 3)[face];
    if (cells.size() > 2)
        refuse(
            TopologyCause::CrowdedFace, {2, face},
            concat(" bounds ", cells.size(), " cells (", listed(cells, 3), "); expected 1 or 2"));
    if (cells.size() < 2) return;
    const auto signIn = [&](Index cell) {
        const auto faces = complex.relation(3, 2)[cell];
        const auto at = std::find(faces.begin(), faces.end(), face) - faces.begin();
        return complex.boundary(3).signs(cell)[at];
    };
    if (signIn(cells[0]) == signIn(cells[1]))
        refuse(TopologyCause::NotOrientable, {2, face},
               concat(" has cells ", cells[0], " and ", cells[1],
                      " on the same side: the lattice cannot be oriented"));
}

/// Checks that no two cells have the same faces.
void checkRepeatedCell(const CellComplex& complex, Index cell) {
    const auto faces = complex.relation(3, 2)[cell];
    for (const Index other : complex.relation(2, 3)[faces[0]]) {
        if (other >= cell) continue;
        const auto otherFaces = complex.relation(3, 2)[other];
        if (std::is_permutation(faces.begin(), faces.end(), otherFaces.begin(), otherFaces.end()))
            refuse(TopologyCause::RepeatedCell, {3, cell},
                   concat(" has the same faces as cell ", other));
    }
}

/// Checks that a row of a boundary relation names entities that exist.
void checkRange(const CellComplex& complex, Entity entity) {
    const int side = entity.dimension - 1;
    for (const Index index : complex.boundary(entity.dimension)[entity.index])
        if (index < 0 || index >= complex.count(side))
            refuse(side == 0 ? TopologyCause::VertexOutOfRange : TopologyCause::EntityOutOfRange,
                   entity,
                   concat(" names ", dimensionName(side), " ", index, "; there are ",
                          complex.count(side)));
}

template <class Check>
void checkEach(const CellComplex& complex, int dimension, Check check) {
    parallelFor(complex.count(dimension), 1024, [&](Offset first, Offset last) {
        for (Offset index = first; index < last; ++index) check(complex, static_cast<Index>(index));
    });
}

}  // namespace

void validate(const CellComplex& complex) {
    if (!isValidLattice(complex)) requireValid(complex);
}

void requireValid(const CellComplex& complex) {
    const int dimension = complex.dimension();
    if (dimension < 1 || complex.count(dimension) == 0)
        throw TopologyError(
            TopologyCause::EmptyComplex, {std::max(dimension, 1), 0},
            std::string("there is no ") + dimensionName(std::max(dimension, 1)) + " to refine");
    for (int d = 1; d <= dimension; ++d)
        checkEach(complex, d, [d](const CellComplex& c, Index index) {
            checkRange(c, {d, index});
        });
    checkEach(complex, 1, checkEdge);
    if (dimension >= 2) checkEach(complex, 2, checkFace);
    for (int d = dimension - 1; d >= (dimension == 2 ? 1 : 0); --d)
        checkEach(complex, d, [d](const CellComplex& c, Index index) {
            if (c.relation(d, d + 1)[index].empty())
                refuse(TopologyCause::UnusedEntity, {d, index},
                       std::string(" belongs to no ") + dimensionName(d + 1));
        });
    if (dimension == 3) {
        // Crowded faces first: otherwise, a third cell at a face would be reported as a bad cell.
        checkEach(complex, 2, [](const CellComplex& c, Index face) {
            if (c.relation(2, 3)[face].size() > 2) checkCellsOfFace(c, face);
        });
        checkEach(complex, 3, checkCell);
        checkEach(complex, 3, checkRepeatedCell);
        checkEach(complex, 2, checkCellsOfFace);
    }
}

}  // namespace espalier::far
