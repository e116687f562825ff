// SPDX-License-Identifier: Apache-2.0
#include "patch_pieces.h"

#include <espalier/base/disjoint_sets.h>
#include <espalier/base/sort_unique.h>
#include <espalier/base/vector3.h>

#include <algorithm>
#include <array>
#include <utility>

namespace espalier::solve {
namespace {

/// The cosine of 50 degrees. A cylinder of eight sides turns by 45 degrees, a prism of six by 60.
constexpr double kSmoothCosine = 0.6427876096865394;

/// Returns false if two directions, which may be zero, turn too much.
bool isSmooth(const Point3& a, const Point3& b) {
    const double sizes = length(a) * length(b);
    return !(sizes > 0) || dot(a, b) >= kSmoothCosine * sizes;
}

/// Adds the pieces of some faces or lines.
void addPieces(bool areLines, const far::Rows<Index>& rows, DisjointSets& sets,
               std::vector<PatchPiece>& pieces) {
    std::vector<std::pair<std::size_t, std::size_t>> order;
    for (std::size_t row = 0; row < rows.count(); ++row) order.emplace_back(sets.rootOf(row), row);
    std::ranges::sort(order);
    for (std::size_t i = 0; i < order.size(); ++i) {
        if (i == 0 || order[i].first != order[i - 1].first) pieces.push_back({areLines});
        const auto points = rows[order[i].second];
        pieces.back().points.insert(pieces.back().points.end(), points.begin(), points.end());
    }
}

void addPiecesOfFaces(const far::Rows<Index>& faces, std::span<const Point3> places,
                      std::vector<PatchPiece>& pieces) {
    struct EdgeUse {
        std::array<Index, 2> edge;
        std::size_t face;
        bool isForward;
    };
    std::vector<EdgeUse> uses;
    std::vector<Point3> normals, loop;
    for (std::size_t face = 0; face < faces.count(); ++face) {
        const auto corners = faces[face];
        loop.clear();
        for (std::size_t i = 0; i < corners.size(); ++i) {
            loop.push_back(places[corners[i]]);
            const Index from = corners[i], to = corners[(i + 1) % corners.size()];
            uses.push_back({{std::min(from, to), std::max(from, to)}, face, from < to});
        }
        normals.push_back(areaVector(loop));
    }
    std::ranges::sort(uses, [](const EdgeUse& a, const EdgeUse& b) {
        return std::pair(a.edge, a.face) < std::pair(b.edge, b.face);
    });
    DisjointSets sets(faces.count());
    for (std::size_t i = 0; i < uses.size(); ++i)
        for (std::size_t j = i + 1; j < uses.size() && uses[j].edge == uses[i].edge; ++j) {
            // Faces that go along the edge in one direction have opposite sides in front.
            const double side = uses[i].isForward == uses[j].isForward ? -1 : 1;
            if (isSmooth(normals[uses[i].face], scaled(normals[uses[j].face], side)))
                sets.join(uses[i].face, uses[j].face);
        }
    addPieces(false, faces, sets, pieces);
}

void addPiecesOfLines(const far::Rows<Index>& lines, std::span<const Point3> places,
                      std::vector<PatchPiece>& pieces) {
    struct EndUse {
        Index point;
        std::size_t line;
        bool isFirst;
    };
    std::vector<EndUse> uses;
    std::vector<Point3> directions;
    for (std::size_t line = 0; line < lines.count(); ++line) {
        const auto ends = lines[line];
        uses.push_back({ends[0], line, true});
        uses.push_back({ends[1], line, false});
        directions.push_back(difference(places[ends[1]], places[ends[0]]));
    }
    std::ranges::sort(uses, [](const EndUse& a, const EndUse& b) {
        return std::pair(a.point, a.line) < std::pair(b.point, b.line);
    });
    DisjointSets sets(lines.count());
    for (std::size_t i = 0; i < uses.size(); ++i)
        for (std::size_t j = i + 1; j < uses.size() && uses[j].point == uses[i].point; ++j) {
            const double side = uses[i].isFirst == uses[j].isFirst ? -1 : 1;
            if (isSmooth(directions[uses[i].line], scaled(directions[uses[j].line], side)))
                sets.join(uses[i].line, uses[j].line);
        }
    addPieces(true, lines, sets, pieces);
}

}  // namespace

std::vector<PatchPiece> piecesOf(const far::MeshPatch& patch, std::span<const Point3> places) {
    std::vector<PatchPiece> pieces;
    if (patch.faces.empty() && patch.lines.empty()) {
        pieces.push_back({patch.dimension == 1, patch.points});
        return pieces;
    }
    addPiecesOfFaces(patch.faces, places, pieces);
    addPiecesOfLines(patch.lines, places, pieces);
    for (PatchPiece& piece : pieces) sortUnique(piece.points);
    std::ranges::sort(pieces, [](const PatchPiece& a, const PatchPiece& b) {
        return a.points.size() > b.points.size() ||
               (a.points.size() == b.points.size() && a.points < b.points);
    });
    return pieces;
}

}  // namespace espalier::solve
