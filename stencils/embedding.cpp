// SPDX-License-Identifier: Apache-2.0
#include <espalier/far/error.h>
#include <espalier/stencils/composition.h>
#include <espalier/stencils/embedding.h>
#include <espalier/stencils/table_builder.h>

#include <algorithm>
#include <atomic>
#include <sstream>
#include <string>

namespace espalier::stencils {

Index Embedding::count(PointStatus status) const {
    return static_cast<Index>(
        std::count_if(points.begin(), points.end(),
                      [&](const LocatedPoint& point) { return point.status == status; }));
}

double Embedding::largestResidual() const {
    double largest = 0;
    for (const LocatedPoint& point : points)
        if (point.place) largest = std::max(largest, point.residual);
    return largest;
}

namespace {

[[noreturn]] void refusePoint(Offset index, const Point3& point, PointStatus status) {
    std::ostringstream message;
    message << "point " << index << " at (" << point[0] << ", " << point[1] << ", " << point[2]
            << ") "
            << (status == PointStatus::Outside
                    ? "is outside the lattice"
                    : "has no place in the lattice: its cell is degenerate, or it is not finite");
    throw Error(message.str());
}

}  // namespace

Embedding embedPoints(const far::CellComplex& complex, std::span<const Point3> positions,
                      std::span<const Point3> points, const EmbeddingOptions& options,
                      const std::function<void(Offset)>& progress) {
    if (points.size() > static_cast<std::size_t>(far::kMaxIndex))
        throw Error("got " + std::to_string(points.size()) + " points; the most is " +
                    std::to_string(far::kMaxIndex));
    const PointLocator locator(complex, positions, options.tolerance);
    Embedding embedding;
    embedding.points.resize(points.size());
    embedding.vertexCount = complex.count(0);
    std::atomic<Offset> done = 0;
    constexpr Offset kGrain = 1024;
    far::parallelFor(static_cast<Offset>(points.size()), kGrain, [&](Offset first, Offset last) {
        for (Offset i = first; i < last; ++i) {
            const Point3& point = points[static_cast<std::size_t>(i)];
            LocatedPoint& located = embedding.points[static_cast<std::size_t>(i)];
            located = locator.locate(point, options.outside == OutsidePolicy::Nearest);
            if (options.outside == OutsidePolicy::Error && located.status != PointStatus::Inside)
                refusePoint(i, point, located.status);
        }
        if (progress) progress(done += last - first);
    });
    return embedding;
}

StencilTable<double> buildEmbeddingTable(const far::CellComplex& complex,
                                         const Embedding& embedding) {
    if (embedding.vertexCount != complex.count(0))
        throw Error("the points were embedded in a lattice of " +
                    std::to_string(embedding.vertexCount) + " vertices, not of " +
                    std::to_string(complex.count(0)) + ": another level?");
    return buildTable<double>(static_cast<Index>(embedding.points.size()), complex.count(0),
                              [&](Index row, RowAccumulator& accumulator) {
                                  const auto& place =
                                      embedding.points[static_cast<std::size_t>(row)].place;
                                  if (!place) return;
                                  for (const auto& [vertex, weight] : placeWeights(complex, *place))
                                      accumulator.add(vertex, weight);
                              });
}

template <class Real>
StencilTable<Real> buildDeformationTable(const far::TopologyRefiner& refiner, int level,
                                         Rules rules, const Embedding& embedding) {
    const CompactTable weights =
        compactColumns(buildEmbeddingTable(refiner.level(level).complex, embedding));
    return multiply<Real>(weights.table,
                          buildStencils<double>(refiner, level, rules, weights.columns));
}

template StencilTable<float> buildDeformationTable(const far::TopologyRefiner&, int, Rules,
                                                   const Embedding&);
template StencilTable<double> buildDeformationTable(const far::TopologyRefiner&, int, Rules,
                                                    const Embedding&);

}  // namespace espalier::stencils
