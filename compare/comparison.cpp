// SPDX-License-Identifier: Apache-2.0
#include <espalier/base/bounding_box.h>
#include <espalier/base/error.h>
#include <espalier/base/memory.h>
#include <espalier/base/point.h>
#include <espalier/compare/agreement.h>
#include <espalier/compare/comparison.h>
#include <espalier/compare/open_subdiv_tables.h>
#include <espalier/osd/cpu_evaluator.h>
#include <espalier/osd/evaluation.h>
#include <espalier/stencils/composition.h>
#include <espalier/stencils/stencil_table.h>

#include <opensubdiv/far/primvarRefiner.h>
#include <opensubdiv/far/stencilTableFactory.h>
#include <opensubdiv/osd/cpuEvaluator.h>
#include <opensubdiv/version.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <random>
#include <span>
#include <vector>

#include "level_match.h"
#include "open_subdiv_refiner.h"

namespace espalier::compare {
namespace {

namespace Far = OpenSubdiv::Far;
using stencils::StencilTable;

/// A point in single precision.
using PointF = std::array<float, 3>;

/// Side of the cube that randomPositions() fill.
constexpr double kRandomSide = 2;

/// Multiplies a table by positions.
template <class Evaluator, class Real>
std::vector<std::array<Real, 3>> evaluate(const StencilTable<Real>& table,
                                          std::span<const std::array<Real, 3>> positions) {
    std::vector<std::array<Real, 3>> result(table.rowCount());
    const auto layout = osd::BufferDescriptor::packed(3);
    Evaluator::evaluate(table, std::span(positions.data()->data(), 3 * positions.size()), layout,
                        std::span(result.data()->data(), 3 * result.size()), layout,
                        {0, table.rowCount()});
    return result;
}

/// Returns the larger of two numbers; NaN if one is NaN.
double larger(double a, double b) {
    return b > a || std::isnan(b) ? b : a;
}

/// Returns the largest difference of a coordinate between two equally long lists of points; NaN if
/// any difference is.
template <class Point>
double largestDifference(const std::vector<Point>& a, const std::vector<Point>& b) {
    double largest = 0;
    for (std::size_t i = 0; i < a.size(); ++i)
        for (std::size_t axis = 0; axis < 3; ++axis)
            largest = larger(largest, std::abs(a[i][axis] - b[i][axis]));
    return largest;
}

/// Returns the largest difference of a weight between two tables of the same size.
double largestDifference(const StencilTable<double>& a, const StencilTable<double>& b) {
    double largest = 0;
    for (Index row = 0; row < a.rowCount(); ++row) {
        const auto aColumns = a.columns(row), bColumns = b.columns(row);
        const auto aWeights = a.weights(row), bWeights = b.weights(row);
        for (std::size_t i = 0, j = 0; i < aColumns.size() || j < bColumns.size();) {
            const bool useA =
                j == bColumns.size() || (i < aColumns.size() && aColumns[i] <= bColumns[j]);
            const bool useB =
                i == aColumns.size() || (j < bColumns.size() && bColumns[j] <= aColumns[i]);
            const double difference = (useA ? aWeights[i++] : 0) - (useB ? bWeights[j++] : 0);
            largest = larger(largest, std::abs(difference));
        }
    }
    return largest;
}

/// Multiplies a table by positions with our evaluator.
std::vector<PointF> evaluateWithEspalier(const StencilTable<double>& table,
                                         std::span<const PointF> positions) {
    return evaluate<osd::CpuEvaluator, float>(stencils::convertTable<float>(table), positions);
}

std::vector<PointF> evaluateWithOpenSubdiv(const OpenSubdivTable<float>& table,
                                           std::span<const PointF> positions) {
    std::vector<PointF> result(table.GetNumStencils());
    const OpenSubdiv::Osd::BufferDescriptor layout(0, 3, 3);
    OpenSubdiv::Osd::CpuEvaluator::EvalStencils(
        positions.data()->data(), layout, result.data()->data(), layout, table.GetSizes().data(),
        table.GetOffsets().data(), table.GetControlIndices().data(), table.GetWeights().data(), 0,
        table.GetNumStencils());
    return result;
}

/// Returns random positions from −1 to 1, the same on every platform.
std::vector<Point3> randomPositions(Index count) {
    std::mt19937 random(1);
    std::vector<Point3> positions(count);
    for (Point3& position : positions)
        for (double& coordinate : position)
            coordinate = 2 * (static_cast<double>(random()) / 4294967295.0) - 1;
    return positions;
}

std::vector<PointF> toSingle(std::span<const Point3> positions) {
    std::vector<PointF> single;
    single.reserve(positions.size());
    for (const Point3& p : positions)
        single.push_back(
            {static_cast<float>(p[0]), static_cast<float>(p[1]), static_cast<float>(p[2])});
    return single;
}

}  // namespace

bool LevelAgreement::isWithin(const Bounds& bounds) const {
    return counts == openSubdivCounts && topologyDifference.empty() &&
           positionDifference <= bounds.position && weightDifference <= bounds.weight &&
           evaluatorDifference <= bounds.evaluator;
}

bool Agreement::isWithin(const Bounds& bounds) const {
    return !levels.empty() &&
           std::all_of(levels.begin(), levels.end(),
                       [&](const LevelAgreement& level) { return level.isWithin(bounds); });
}

std::string openSubdivVersion() {
    return concat(OPENSUBDIV_VERSION_MAJOR, ".", OPENSUBDIV_VERSION_MINOR, ".",
                  OPENSUBDIV_VERSION_PATCH);
}

struct Comparison::Data {
    const far::TopologyRefiner& ours;
    Surface base;
    OpenSubdivRefiner openSubdiv;
    std::vector<LevelMatch> matches;                             ///< one per level
    std::vector<Surface> regions;                                ///< one per level
    std::unique_ptr<const Far::StencilTableReal<double>> table;  ///< null for level 0

    Far::TopologyLevel openSubdivLevel(int level) const {
        return openSubdiv.refiner->GetLevel(level);
    }

    int maxLevel() const { return static_cast<int>(regions.size()) - 1; }

    const Surface& region(int level) const {
        if (level < 0 || level > maxLevel())
            throw Error(
                concat("level ", level, " was not compared; levels 0 to ", maxLevel(), " were"));
        return regions[level];
    }

    /// Returns OpenSubdiv's vertex for one of our vertices on the surface.
    Index openSubdivVertex(int level, Index vertex) const {
        if (const auto match = matches[level].of({0, vertex})) return *match;
        throw Error(concat("vertex ", vertex, " of level ", level,
                           " has no match in OpenSubdiv's refinement"));
    }

    /// Returns the row of the first vertex of a level in the table.
    Index firstRow(int level) const {
        Index row = 0;
        for (int k = 1; k < level; ++k) row += openSubdivLevel(k).GetNumVertices();
        return row;
    }
};

Comparison::Comparison(const far::TopologyRefiner& refiner) {
    if (refiner.dimension() == 3 && refiner.boundary() == far::Boundary::Open)
        throw Error(
            "with the boundary mode 'open' the boundary of a refined lattice is not a subdivision "
            "surface, so OpenSubdiv has nothing to compare it with");
    const far::CellComplex& base = refiner.level(0).complex;
    auto data = std::make_unique<Data>(Data{refiner, surfaceOf(base), {}, {}, {}, nullptr});
    data->openSubdiv = makeOpenSubdivRefiner(refiner, data->base);
    for (int level = 0; level <= refiner.maxLevel(); ++level) {
        checkMemory();
        if (level == refiner.maxLevel()) requireForMatch(refiner, level);
        data->matches.push_back(level == 0
                                    ? matchBase(base, data->base, data->openSubdivLevel(0))
                                    : matchChildren(refiner.level(level - 1).complex,
                                                    data->matches.back(), refiner.refinement(level),
                                                    data->openSubdivLevel(level - 1)));
        data->regions.push_back(
            comparedRegion(refiner, level, data->matches.back(), data->openSubdivLevel(level)));
    }
    if (refiner.maxLevel() > 0) {
        requireForTable(refiner, data->regions);
        using Factory = Far::StencilTableFactoryReal<double>;
        Factory::Options options;
        options.maxLevel = static_cast<unsigned>(refiner.maxLevel()) & 15U;
        data->table.reset(Factory::Create(*data->openSubdiv.refiner, options));
        checkMemory();
    }
    data_ = std::move(data);
}

Comparison::~Comparison() = default;

const std::vector<Index>& Comparison::vertices(int level) const {
    return data_->region(level).vertices;
}

Index Comparison::correctedCorners() const {
    return data_->openSubdiv.correctedCorners;
}

StencilTable<double> Comparison::openSubdivTable(int level) const {
    if (level < 1) throw Error("OpenSubdiv has stencils of levels 1 and on");
    const std::vector<Index>& ours = vertices(level);
    const StencilTable<double> openSubdiv = fromOpenSubdiv(
        *data_->table, data_->firstRow(level), data_->openSubdivLevel(level).GetNumVertices());
    Array<Offset> offsets = {0};
    Array<Index> columns;
    Array<double> weights;
    for (const Index vertex : ours) {
        const Index row = data_->openSubdivVertex(level, vertex);
        // OpenSubdiv's base vertices are our surface vertices in the same order, so that columns
        // stay ascending.
        for (const Index column : openSubdiv.columns(row))
            columns.push_back(data_->base.vertices[column]);
        weights.insert(weights.end(), openSubdiv.weights(row).begin(),
                       openSubdiv.weights(row).end());
        offsets.push_back(static_cast<Offset>(columns.size()));
    }
    return StencilTable<double>(data_->ours.level(0).complex.count(0), std::move(offsets),
                                std::move(columns), std::move(weights));
}

namespace {

/// A point as OpenSubdiv's PrimvarRefiner takes it.
struct Primvar {
    Point3 point = {};
    void Clear() { point = {}; }
    void AddWithWeight(const Primvar& other, double weight) {
        for (std::size_t axis = 0; axis < 3; ++axis) point[axis] += weight * other.point[axis];
    }
};

}  // namespace

std::vector<Point3> Comparison::openSubdivPoints(int level,
                                                 std::span<const Point3> positions) const {
    const Index baseCount = data_->ours.level(0).complex.count(0);
    if (std::ssize(positions) != baseCount)
        throw Error(concat("got ", positions.size(), " positions for ", baseCount, " vertices"));
    const std::vector<Index>& ours = vertices(level);
    std::vector<Primvar> points;
    for (const Index vertex : data_->base.vertices) points.push_back({positions[vertex]});
    const Far::PrimvarRefinerReal<double> refiner(*data_->openSubdiv.refiner);
    for (int k = 1; k <= level; ++k) {
        std::vector<Primvar> next(data_->openSubdivLevel(k).GetNumVertices());
        Primvar* destination = next.data();
        refiner.Interpolate(k, points.data(), destination);
        points = std::move(next);
    }
    std::vector<Point3> result;
    for (const Index vertex : ours)
        result.push_back(points[data_->openSubdivVertex(level, vertex)].point);
    return result;
}

/// Evaluates OpenSubdiv's own table, unchanged, with its own evaluator.
std::vector<PointF> Comparison::evaluateOpenSubdivTable(int level,
                                                        std::span<const PointF> positions) const {
    std::vector<PointF> base;
    for (const Index vertex : data_->base.vertices) base.push_back(positions[vertex]);
    const OpenSubdivTable<float> table(*data_->table, data_->firstRow(level),
                                       data_->openSubdivLevel(level).GetNumVertices());
    const std::vector<PointF> all = evaluateWithOpenSubdiv(table, base);
    std::vector<PointF> result;
    for (const Index vertex : vertices(level))
        result.push_back(all[data_->openSubdivVertex(level, vertex)]);
    return result;
}

LevelAgreement Comparison::compare(int level, const StencilTable<double>& table) const {
    const Index baseCount = data_->ours.level(0).complex.count(0);
    if (table.rowCount() != std::ssize(vertices(level)) || table.columnCount() != baseCount)
        throw Error(concat("got a table of ", table.rowCount(), " × ", table.columnCount(),
                           "; level ", level, " takes one of ", vertices(level).size(), " × ",
                           baseCount));
    const Surface& region = data_->region(level);
    const LevelMatch& match = data_->matches[level];
    LevelAgreement agreement;
    agreement.level = level;
    agreement.counts = {static_cast<Index>(region.vertices.size()),
                        static_cast<Index>(region.edges.size()),
                        static_cast<Index>(region.faces.size())};
    agreement.openSubdivCounts =
        countOpenSubdiv(data_->ours.boundary(), data_->openSubdivLevel(level));
    agreement.topologyDifference =
        describeDifference(data_->ours, level, region, match, data_->openSubdivLevel(level));
    if (region.vertices.empty()) return agreement;
    if (std::any_of(region.vertices.begin(), region.vertices.end(), [&](Index vertex) {
            return !match.of({0, vertex});
        })) {
        agreement.positionDifference = agreement.weightDifference = agreement.evaluatorDifference =
            std::numeric_limits<double>::infinity();
        return agreement;
    }

    requireForComparison(level, table.entryCount());
    const std::vector<Point3> positions = randomPositions(baseCount);
    const StencilTable<double> openSubdiv = openSubdivTable(level);
    agreement.weightDifference = largestDifference(table, openSubdiv);
    agreement.positionDifference =
        largestDifference(evaluate<osd::ReferenceEvaluator, double>(table, positions),
                          openSubdivPoints(level, positions)) /
        kRandomSide;
    const std::vector<PointF> single = toSingle(positions);
    const OpenSubdivTable<float> exported(stencils::convertTable<float>(table));
    agreement.evaluatorDifference =
        larger(largestDifference(evaluateWithEspalier(table, single),
                                 evaluateWithOpenSubdiv(exported, single)),
               largestDifference(evaluateWithEspalier(openSubdiv, single),
                                 evaluateOpenSubdivTable(level, single))) /
        kRandomSide;
    return agreement;
}

namespace {

/// A level with more faces is not drawn: its picture would be too fine, and its file large.
constexpr std::size_t kMaxFaces = 8000;

SurfaceError drawError(const far::TopologyRefiner& refiner, int level, const Surface& region,
                       std::span<const Point3> base, std::vector<Point3> ours,
                       std::span<const Point3> openSubdiv) {
    SurfaceError picture{level, std::move(ours), {}, {}, region.vertices};
    const double size = BoundingBox(base).diagonal();
    for (std::size_t i = 0; i < openSubdiv.size(); ++i) {
        const Point3 &a = picture.positions[i], &b = openSubdiv[i];
        const double distance = std::hypot(a[0] - b[0], a[1] - b[1], a[2] - b[2]);
        picture.errors.push_back(size > 0 ? distance / size : distance);
    }
    for (const Index face : region.faces) {
        const std::vector<Index> loop = surfaceLoop(refiner.level(level).complex, face);
        std::array<Index, 4> corners = {};
        for (std::size_t i = 0; i < 4; ++i) {
            const auto place =
                std::lower_bound(region.vertices.begin(), region.vertices.end(), loop[i]);
            corners[i] = static_cast<Index>(place - region.vertices.begin());
        }
        picture.faces.push_back(corners);
    }
    return picture;
}

}  // namespace

std::string Comparison::noteOn(const Agreement& agreement) const {
    std::string note;
    if (const Index count = correctedCorners(); count > 0)
        note = concat("OpenSubdiv ", openSubdivVersion(), " treats ", count,
                      count == 1 ? " non-manifold vertex" : " non-manifold vertices",
                      " as on a crease, although no crease passes there (corrected in its release "
                      "3.6.1); for "
                      "the comparison they are marked as corners. ");
    // True if weights differ by the rounding of single precision.
    const bool isRounded =
        std::any_of(agreement.levels.begin(), agreement.levels.end(), [](const auto& level) {
            return level.weightDifference > Bounds().weight && level.weightDifference < 1e-6;
        });
    if (isRounded && data_->ours.level(0).strata.hasSemiSharp())
        note +=
            "OpenSubdiv adds three or more semi-sharp values at a vertex in another order, in "
            "single "
            "precision: this may explain the difference. ";
    if (!note.empty()) note.pop_back();
    return note;
}

Agreement Comparison::compareAll(std::span<const Point3> positions) const {
    const far::Rules rules = data_->ours.rules();
    if (rules == far::Rules::Rats || rules == far::Rules::Mlca)
        throw Error(std::string("OpenSubdiv does not have the rules of ") +
                    (rules == far::Rules::Rats ? "RATS" : "MLCA") +
                    ": there is nothing to compare");
    if (vertices(data_->maxLevel()).empty())
        throw Error(
            "OpenSubdiv leaves out every face, since each has a vertex on the boundary: there is "
            "nothing to compare");
    Agreement agreement;
    for (int level = 1; level <= data_->maxLevel(); ++level) {
        checkMemory();
        const StencilTable<double> table =
            stencils::buildStencils(data_->ours, level, vertices(level));
        checkMemory();
        agreement.levels.push_back(compare(level, table));
        checkMemory();
        const bool isMatched = std::isfinite(agreement.levels.back().positionDifference);
        const Surface& region = data_->regions[level];
        if (isMatched && !region.faces.empty() && region.faces.size() <= kMaxFaces)
            agreement.picture =
                drawError(data_->ours, level, region, positions,
                          evaluate<osd::ReferenceEvaluator, double>(table, positions),
                          openSubdivPoints(level, positions));
    }
    agreement.note = noteOn(agreement);
    return agreement;
}

}  // namespace espalier::compare
