// SPDX-License-Identifier: Apache-2.0
#include <espalier/base/parallel.h>
#include <espalier/embed/embedding.h>
#include <espalier/embed/place_points.h>
#include <espalier/embed/point_location.h>
#include <espalier/embed/row_bound.h>
#include <espalier/embed/trilinear.h>
#include <espalier/far/standard_cells.h>
#include <espalier/stencils/composition.h>
#include <espalier/stencils/level_rows.h>
#include <espalier/stencils/table_builder.h>

#include <algorithm>
#include <array>
#include <cstdint>
#include <optional>
#include <utility>
#include <vector>

namespace espalier::embed {

namespace {

/// The corners of a hexahedron in the order of the rows of W: ascending.
struct SortedCorners {
    std::array<Index, 8> vertices;
    std::array<std::uint8_t, 8> positions;  ///< positions in far::hexahedronVertices()
};

std::optional<SortedCorners> sortedCorners(const far::CellComplex& complex, CellId cell) {
    const auto corners = far::hexahedronVertices(complex, cell);
    if (!corners) return std::nullopt;
    SortedCorners sorted;
    for (std::uint8_t i = 0; i < 8; ++i) {
        std::size_t before = 0;
        for (const Index other : *corners) before += other < (*corners)[i];
        sorted.vertices[before] = (*corners)[i];
        sorted.positions[before] = i;
    }
    return sorted;
}

Array<std::optional<SortedCorners>> allSortedCorners(const far::CellComplex& complex) {
    Array<std::optional<SortedCorners>> all(complex.count(3));
    parallelFor(complex.count(3), 4096, [&](Offset first, Offset last) {
        for (Offset cell = first; cell < last; ++cell)
            all[cell] = sortedCorners(complex, CellId(static_cast<Index>(cell)));
    });
    return all;
}

/// Finds the corners of cells that contain points.
class CornersOfCells {
public:
    /// \throws Error if the embedding is in a lattice with another number of vertices
    CornersOfCells(const far::CellComplex& complex, const Embedding& embedding)
        : complex_(complex) {
        checkVertexCount(embedding.vertexCount, complex.count(0));
        // With many points, looking up the corners of each cell once takes a quarter of the time.
        // With few points, looking up all cells would take longer.
        if (std::ssize(embedding.points) > complex.count(3) / 4) all_ = allSortedCorners(complex);
    }

    std::optional<SortedCorners> operator()(CellId cell) const {
        return all_.empty() ? sortedCorners(complex_, cell) : all_[cell.value];
    }

private:
    const far::CellComplex& complex_;
    Array<std::optional<SortedCorners>> all_;
};

void appendEntry(Index vertex, double weight, stencils::RowList& rows) {
    if (weight == 0) return;
    rows.columns.push_back(vertex);
    rows.weights.push_back(weight);
}

void appendHexahedron(const SortedCorners& corners, const Trilinear::Weights& weights,
                      stencils::RowList& rows) {
    for (std::size_t i = 0; i < 8; ++i)
        appendEntry(corners.vertices[i], weights[corners.positions[i]], rows);
}

/// The weights of a type-n cell contain a vertex of the tetrahedron twice; the row has the sum.
void appendSums(std::vector<VertexWeight> weights, stencils::RowList& rows) {
    std::sort(weights.begin(), weights.end(),
              [](const VertexWeight& a, const VertexWeight& b) { return a.vertex < b.vertex; });
    for (std::size_t i = 0; i < weights.size();) {
        const Index vertex = weights[i].vertex;
        double sum = 0;
        for (; i < weights.size() && weights[i].vertex == vertex; ++i) sum += weights[i].weight;
        appendEntry(vertex, sum, rows);
    }
}

}  // namespace

Embedding embedPoints(const far::CellComplex& complex, std::span<const Point3> positions,
                      std::span<const Point3> points, const EmbeddingOptions& options,
                      const std::function<void(Offset)>& progress) {
    checkPointCount(points);
    const PointLocator locator(complex, positions, options.tolerance);
    return locatePoints<CellPlace>(
        points, complex.count(0), options.outside, progress,
        [&](const Point3& point, bool seekNearest) { return locator.locate(point, seekNearest); },
        alongCurve(points));
}

stencils::StencilTable<double> buildEmbeddingTable(const far::CellComplex& complex,
                                                   const Embedding& embedding) {
    const auto pointCount = static_cast<Index>(embedding.points.size());
    const CornersOfCells cornersOf(complex, embedding);
    return stencils::buildTableInPlace(
        pointCount, complex.count(0), [&](Offset first, Offset last, stencils::RowList& rows) {
            const std::size_t count = last - first;
            rows.columns.reserve(8 * count);
            rows.weights.reserve(8 * count);
            rows.ends.reserve(count);
            for (Offset point = first; point < last; ++point) {
                const auto& place = embedding.points[point].place;
                if (place) {
                    if (const auto corners = cornersOf(place->cell))
                        appendHexahedron(*corners, hexahedronWeights(*place), rows);
                    else
                        appendSums(placeWeights(complex, *place), rows);
                }
                rows.endRow();
            }
        });
}

stencils::StencilTable<double> buildDirectionTable(const far::CellComplex& complex,
                                                   const Embedding& embedding) {
    const CornersOfCells cornersOf(complex, embedding);
    return stencils::buildTableInPlace(
        static_cast<Index>(3 * embedding.points.size()), complex.count(0),
        [&](Offset first, Offset last, stencils::RowList& rows) {
            const std::size_t count = last - first;
            rows.columns.reserve(8 * count);
            rows.weights.reserve(8 * count);
            rows.ends.reserve(count);
            Offset known = -1;  // The point whose corners and derivatives these are.
            std::optional<SortedCorners> corners;
            std::array<Trilinear::Weights, 3> derivatives;
            for (Offset row = first; row < last; ++row) {
                const auto& place = embedding.points[row / 3].place;
                if (place && row / 3 != std::exchange(known, row / 3)) {
                    corners = cornersOf(place->cell);
                    if (corners)
                        derivatives =
                            Trilinear::weightDerivatives(Eigen::Vector3d(place->uvw.data()));
                }
                const auto axis = static_cast<int>(row % 3);
                if (place && corners)
                    appendHexahedron(*corners, derivatives[static_cast<std::size_t>(axis)], rows);
                else if (place)
                    appendSums(directionWeights(complex, *place, axis), rows);
                rows.endRow();
            }
        });
}

stencils::RowOrder orderByBaseCell(const Embedding& embedding, std::span<const Index> baseCells,
                                   Index groupCount) {
    std::vector<Index> groups;
    groups.reserve(embedding.points.size());
    for (const LocatedPoint& point : embedding.points)
        groups.push_back(point.place ? baseCells[point.place->cell.value] : 0);
    return stencils::RowOrder(groups, groupCount);
}

namespace {

/// Returns W and S, compacted to the vertices that W uses.
/// \param stencilsFor returns the rows of S_level for some vertices of the level
template <class StencilsFor>
stencils::FactoredTable<double> factoredTable(const far::CellComplex& complex,
                                              const Embedding& embedding, StencilsFor stencilsFor) {
    stencils::CompactTable weights =
        stencils::compactColumns(buildEmbeddingTable(complex, embedding));
    return {stencilsFor(weights.columns), std::move(weights.table)};
}

stencils::FactoredTable<double> factorsOf(const far::TopologyRefiner& refiner, int level,
                                          const Embedding& embedding) {
    return factoredTable(refiner.level(level).complex, embedding,
                         [&](std::span<const Index> vertices) {
                             return stencils::buildStencils(refiner, level, vertices);
                         });
}

stencils::FactoredTable<double> factorsOf(const stencils::Levels& levels,
                                          const Embedding& embedding) {
    return factoredTable(
        levels.finestLevel().complex, embedding,
        [&](std::span<const Index> vertices) { return levels.stencils(vertices); });
}

/// Returns D, the product of its factors.
stencils::StencilTable<double> multiplied(const stencils::FactoredTable<double>& factors,
                                          const far::TopologyRefiner& refiner, int level,
                                          const Embedding& embedding) {
    const stencils::BaseEntities origins = stencils::baseEntities(refiner, level).back();
    return stencils::multiply(factors.points, factors.vertices,
                              orderByBaseCell(embedding, origins.of(3), origins.count()));
}

/// Computes D where rows of S are long: multiplies from the left, so that only rows of points are
/// carried to the base.
stencils::StencilTable<double> multipliedFromPoints(
    const far::TopologyRefiner& refiner, std::span<const stencils::StencilTable<double>> tables,
    const Embedding& embedding) {
    const int level = static_cast<int>(tables.size());
    std::vector<stencils::StencilTable<double>> rows;
    for (int k = 0; k < level; ++k)
        rows.push_back(stencils::buildTable(0, refiner.level(k).complex.count(0),
                                            [](Index, stencils::RowAccumulator&) {}));
    rows.push_back(buildEmbeddingTable(refiner.level(level).complex, embedding));
    return std::move(
        stencils::composeRows(tables, std::move(rows), stencils::Composition::FromRows).back());
}

bool hasLongRows(const far::TopologyRefiner& refiner) {
    return stencils::compositionAbove(refiner.level(0).complex) == stencils::Composition::FromRows;
}

}  // namespace

stencils::FactoredTable<double> buildFactoredTable(const far::TopologyRefiner& refiner, int level,
                                                   const Embedding& embedding) {
    return boundRows(factorsOf(refiner, level, embedding));
}

stencils::FactoredTable<double> buildFactoredTable(const stencils::Levels& levels,
                                                   const Embedding& embedding) {
    return boundRows(factorsOf(levels, embedding));
}

stencils::StencilTable<double> buildDeformationTable(const far::TopologyRefiner& refiner, int level,
                                                     const Embedding& embedding) {
    return boundRows(
        hasLongRows(refiner)
            ? multipliedFromPoints(refiner, stencils::buildLevelTables(refiner, level), embedding)
            : multiplied(factorsOf(refiner, level, embedding), refiner, level, embedding));
}

stencils::StencilTable<double> buildDeformationTable(const stencils::Levels& levels,
                                                     const Embedding& embedding) {
    const far::TopologyRefiner& refiner = levels.refiner();
    return boundRows(
        hasLongRows(refiner)
            ? multipliedFromPoints(refiner, levels.tables(), embedding)
            : multiplied(factorsOf(levels, embedding), refiner, levels.finest(), embedding));
}

}  // namespace espalier::embed
