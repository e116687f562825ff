// SPDX-License-Identifier: Apache-2.0
#include <espalier/far/error.h>
#include <espalier/stencils/limit_binding.h>
#include <espalier/stencils/limit_table.h>

#include <Eigen/LU>
#include <numeric>
#include <string>

#include "bind_groups.h"
#include "level_rows.h"
#include "limit_search.h"
#include "table_builder.h"

namespace espalier::stencils {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

/// The rows of places of one level over its vertices: those of the positions, and behind them, if
/// gradients are asked for, those by x, by y and by z of the rest pose.
/// \param positions of the level at rest
/// \param scale what gradients by those positions are multiplied by
StencilTable<double> rowsOf(const PlaceRows& places, std::size_t placeCount,
                            std::span<const Point3> positions, bool gradients, double scale) {
    const std::size_t blocks = gradients ? 4 : 1;
    std::vector<Matrix3d> inverses;  // Of ∂X/∂(u, v, w); not finite where there is none.
    if (gradients)
        for (std::size_t i = 0; i < placeCount; ++i) {
            Matrix3d jacobian = Matrix3d::Zero();
            for (std::size_t axis = 0; axis < 3; ++axis)
                for (const auto& [vertex, weight] : places.weights(i, kFirst[axis]))
                    jacobian.col(static_cast<Eigen::Index>(axis)) +=
                        weight * Vector3d(positions[static_cast<std::size_t>(vertex)].data());
            inverses.push_back(scale * jacobian.inverse());
        }
    return buildTable<double>(
        static_cast<Index>(blocks * placeCount), static_cast<Index>(positions.size()),
        [&](Index row, RowAccumulator& accumulator) {
            const std::size_t i = static_cast<std::size_t>(row) % placeCount;
            const std::size_t block = static_cast<std::size_t>(row) / placeCount;
            if (block == 0) {
                for (const auto& [vertex, weight] : places.weights(i, kPosition))
                    accumulator.add(vertex, weight);
                return;
            }
            if (!inverses[i].allFinite()) return;
            for (std::size_t axis = 0; axis < 3; ++axis) {
                const double slope = inverses[i](static_cast<Eigen::Index>(axis),
                                                 static_cast<Eigen::Index>(block) - 1);
                for (const auto& [vertex, weight] : places.weights(i, kFirst[axis]))
                    accumulator.add(vertex, slope * weight);
            }
        });
}

std::vector<Point3> chosen(std::span<const Point3> points, const std::vector<Index>& numbers) {
    std::vector<Point3> result;
    for (const Index i : numbers) result.push_back(points[static_cast<std::size_t>(i)]);
    return result;
}

/// Binds groups of points to the limit volume.
template <class Real>
class LimitBinder : public GroupBinder<LimitTable<Real>> {
public:
    /// \param positions in units
    LimitBinder(const far::TopologyRefiner& base, std::span<const Point3> positions,
                const LengthUnit& unit, Rules rules, const LimitOptions& options)
        : rules_(rules),
          perLength_(unit.toUnits(1.0)),
          gradients_(options.gradients),
          search_(base, positions, rules, options) {}

    using Part = BoundPart<LimitTable<Real>>;

    std::vector<Part> bind(std::span<const Point3> points) const override {
        std::vector<Part> parts;
        std::vector<Index> left(points.size());
        std::iota(left.begin(), left.end(), Index{0});
        for (const Bounding bounding : {Bounding::Likely, Bounding::Future}) {
            std::vector<Index> unsettled;
            addParts(search_.findInside(chosen(points, left), bounding, unsettled), left, parts);
            for (Index& i : unsettled) i = left[static_cast<std::size_t>(i)];
            left = std::move(unsettled);
            if (left.empty()) return parts;
        }
        addParts(search_.findBeside(chosen(points, left)), left, parts);
        return parts;
    }

private:
    /// A part for the points of each level, and one for those without a place.
    /// \param numbers of the points
    void addParts(const FoundPlaces& found, const std::vector<Index>& numbers,
                  std::vector<Part>& parts) const {
        std::vector<Part> ofLevels(found.positions.size());
        std::vector<std::vector<LimitPlace>> places(ofLevels.size());
        Part without;
        for (std::size_t i = 0; i < found.points.size(); ++i) {
            const LocatedInLimit& located = found.points[i];
            Part& part =
                located.place ? ofLevels[static_cast<std::size_t>(located.place->level)] : without;
            part.points.push_back(numbers[i]);
            part.statuses.push_back(located.status);
            if (!located.place) continue;
            part.largestResidual = std::max(part.largestResidual, located.residual);
            places[static_cast<std::size_t>(located.place->level)].push_back(*located.place);
        }
        std::vector<StencilTable<double>> rows;
        for (std::size_t level = 0; level < ofLevels.size(); ++level) {
            const PlaceRows weights(found.descent.refiner, static_cast<int>(level), rules_,
                                    places[level]);
            rows.push_back(rowsOf(weights, places[level].size(), found.positions[level], gradients_,
                                  perLength_));
        }
        const auto tables = composeRows<Real>(found.descent.tables, std::move(rows));
        for (std::size_t level = 0; level < ofLevels.size(); ++level) {
            if (places[level].empty()) continue;
            const auto block = [&](std::size_t number) {
                std::vector<Index> of(places[level].size());
                std::iota(of.begin(), of.end(), static_cast<Index>(number * of.size()));
                return selectRows(tables[level], of);
            };
            LimitTable<Real>& table = ofLevels[level].table;
            table.points = block(0);
            for (std::size_t axis = 0; gradients_ && axis < 3; ++axis)
                table.gradients[axis] = block(axis + 1);
            parts.push_back(std::move(ofLevels[level]));
        }
        if (!without.points.empty()) parts.push_back(std::move(without));
    }

    Rules rules_;
    double perLength_;  ///< units in a length of 1
    bool gradients_;
    LimitSearch search_;
};

}  // namespace

template <class Real>
BoundModel<Real, LimitTable<Real>> bindLimit(const far::TopologyRefiner& base,
                                             std::span<const Point3> positions, Rules rules,
                                             std::span<const Point3> points,
                                             const LimitOptions& options,
                                             const std::function<void(Offset)>& progress) {
    checkLimitTolerance(options.tolerance);
    checkLimitRules(rules);
    checkBase(base, positions, 1);
    const LengthUnit unit(positions);
    const std::vector<Point3> inUnits = unit.toUnits(positions);
    const LimitBinder<Real> binder(base, inUnits, unit, rules, options);
    // As in a deep level: most points at irregular features share no cells with others.
    constexpr Offset kGroupSize = 1 << 12;
    auto model = bindGroups<Real, LimitTable<Real>>(binder, base, unit, points, kGroupSize,
                                                    options.embedding.outside, progress);
    if (!options.gradients) model.binding.table.gradients = {};
    return model;
}

template BoundModel<float, LimitTable<float>> bindLimit(const far::TopologyRefiner&,
                                                        std::span<const Point3>, Rules,
                                                        std::span<const Point3>,
                                                        const LimitOptions&,
                                                        const std::function<void(Offset)>&);
template BoundModel<double, LimitTable<double>> bindLimit(const far::TopologyRefiner&,
                                                          std::span<const Point3>, Rules,
                                                          std::span<const Point3>,
                                                          const LimitOptions&,
                                                          const std::function<void(Offset)>&);

}  // namespace espalier::stencils
