// SPDX-License-Identifier: Apache-2.0
#include "outer_product.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <type_traits>

namespace espalier::osd {
namespace {

/// Number of rows that are sampled. With this number, sums do not agree in all sampled rows by
/// chance.
constexpr std::size_t kSamples = 6;

/// The logarithms of the absolute weights of one column in the sampled rows. Coordinate 0 is a
/// weighted mean of the logarithms. Columns are sorted by this mean, because two columns may agree
/// in one row by chance, but not in the mean.
constexpr std::size_t kCoordinates = kSamples + 1;
using Logarithms = std::array<double, kCoordinates>;
constexpr std::array<double, kSamples> kKeyWeights = {0.2371, 0.1193, 0.1689,
                                                      0.0971, 0.2137, 0.1639};

Logarithms operator+(const Logarithms& a, const Logarithms& b) {
    Logarithms sum;
    for (std::size_t s = 0; s < kCoordinates; ++s) sum[s] = a[s] + b[s];
    return sum;
}

/// A set of points, one for each column, whose coordinates are logarithms of weights. For an outer
/// product, the points are all sums of one point from each of three sets, one set for each axis.
/// The point with the least first coordinate is moved to 0. So each of the three sets contains 0,
/// and each of their points is itself one of the columns.
class SumSet {
public:
    /// \param tolerance by how much equal sums may differ
    SumSet(std::vector<Logarithms> points, double tolerance)
        : points_(std::move(points)), order_(points_.size()), tolerance_(tolerance) {
        std::iota(order_.begin(), order_.end(), Index{0});
        std::sort(order_.begin(), order_.end(),
                  [&](Index a, Index b) { return points_[a][0] < points_[b][0]; });
        const Logarithms least = points_[order_[0]];
        for (Logarithms& point : points_)
            for (std::size_t s = 0; s < kCoordinates; ++s) point[s] -= least[s];
    }

    std::size_t count() const { return points_.size(); }

    /// The columns by their first coordinate, ascending.
    const std::vector<Index>& ascending() const { return order_; }

    /// Returns the column whose point is the sum of the points of two columns, if there is one.
    std::optional<Index> sum(Index a, Index b) const { return find(points_[a] + points_[b]); }

    /// Returns true if a column is the sum of two others, neither of which is the one at 0.
    bool isSum(Index column) const {
        Logarithms rest;
        for (const Index other : order_) {
            if (other == order_[0]) continue;
            if (points_[other][0] > points_[column][0]) break;
            for (std::size_t s = 0; s < kCoordinates; ++s)
                rest[s] = points_[column][s] - points_[other][s];
            const auto found = find(rest);
            if (found && *found != order_[0] && other != column) return true;
        }
        return false;
    }

    /// Returns true if two columns are the same in all sampled rows: nothing tells them apart then.
    bool hasDuplicates() const {
        return std::adjacent_find(order_.begin(), order_.end(), [&](Index a, Index b) {
                   return isNear(points_[a], points_[b]);
               }) != order_.end();
    }

private:
    bool isNear(const Logarithms& a, const Logarithms& b) const {
        for (std::size_t s = 0; s < kCoordinates; ++s)
            if (std::abs(a[s] - b[s]) > tolerance_) return false;
        return true;
    }

    std::optional<Index> find(const Logarithms& point) const {
        auto near = std::lower_bound(
            order_.begin(), order_.end(), point[0] - tolerance_,
            [&](Index column, double value) { return points_[column][0] < value; });
        for (; near != order_.end() && points_[*near][0] <= point[0] + tolerance_; ++near) {
            if (isNear(points_[*near], point)) return *near;
        }
        return std::nullopt;
    }

    std::vector<Logarithms> points_;
    std::vector<Index> order_;
    double tolerance_;
};

/// Finds the points of each axis, without 0. A point that is not a sum of two others lies on an
/// axis. Two points of axes lie on the same axis if their sum is not a point of the set.
std::optional<std::vector<std::vector<Index>>> findAxes(const SumSet& set) {
    std::vector<std::vector<Index>> axes;
    for (const Index column : set.ascending()) {
        if (column == set.ascending()[0] || set.isSum(column)) continue;
        const auto own = std::find_if(axes.begin(), axes.end(), [&](const auto& axis) {
            return !set.sum(axis.front(), column);
        });
        if (own != axes.end())
            own->push_back(column);
        else if (axes.size() < 3)
            axes.push_back({column});
        else
            return std::nullopt;
    }
    std::sort(axes.begin(), axes.end(),
              [](const auto& a, const auto& b) { return a.size() > b.size(); });
    return axes;
}

}  // namespace

template <class Real>
std::optional<OuterProduct> findOuterProduct(std::span<const std::span<const Real>> rows) {
    // Skips rows with weights that are nearly 0, whose logarithms have no accuracy.
    std::vector<std::span<const Real>> samples;
    constexpr Real kMinWeight =
        std::numeric_limits<Real>::min() / std::numeric_limits<Real>::epsilon();
    for (const auto& weights : rows)
        if (std::all_of(weights.begin(), weights.end(),
                        [](Real weight) { return std::abs(weight) >= kMinWeight; }))
            samples.push_back(weights);
    // No spline has more columns than this: the search would take long and find nothing.
    if (samples.empty() || samples[0].size() < 4 || samples[0].size() > kernels::kMaxProductColumns)
        return std::nullopt;
    std::vector<Logarithms> points(samples[0].size(), Logarithms{});
    for (std::size_t s = 0; s < kSamples; ++s) {
        // Samples are spread over the rows; where there are few rows, some are taken twice.
        const auto& weights = samples[s * (samples.size() - 1) / (kSamples - 1)];
        for (std::size_t column = 0; column < weights.size(); ++column) {
            const double logarithm = std::log(std::abs(static_cast<double>(weights[column])));
            points[column][1 + s] = logarithm;
            points[column][0] += kKeyWeights[s] * logarithm;
        }
    }
    // Bounds the error of sums and differences of four logarithms, each of which is off by the
    // rounding of its weight and by its own.
    double largest = 0;
    for (const Logarithms& point : points)
        for (const double logarithm : point) largest = std::max(largest, std::abs(logarithm));
    const double tolerance = 4.0 * std::numeric_limits<Real>::epsilon() +
                             4 * largest * std::numeric_limits<double>::epsilon();
    const SumSet set(std::move(points), tolerance);
    if (set.hasDuplicates()) return std::nullopt;
    auto axes = findAxes(set);
    if (!axes || axes->size() < 2) return std::nullopt;
    axes->resize(3);
    OuterProduct product;
    for (std::size_t axis = 0; axis < 3; ++axis) {
        auto& own = (*axes)[axis];
        own.insert(own.begin(), set.ascending()[0]);
        product.size[axis] = static_cast<Index>(own.size());
    }
    if (static_cast<std::size_t>(product.size[0]) * product.size[1] * product.size[2] !=
        set.count())
        return std::nullopt;
    std::vector<bool> isUsed(set.count(), false);
    for (const Index third : (*axes)[2])
        for (const Index second : (*axes)[1])
            for (const Index first : (*axes)[0]) {
                const auto plane = set.sum(second, third);
                const auto column = plane ? set.sum(first, *plane) : std::nullopt;
                if (!column || isUsed[*column]) return std::nullopt;
                isUsed[*column] = true;
                product.order.push_back(*column);
            }
    return product;
}

/// A type with more digits than Real. Float has double, which all processors compute with: long
/// double is emulated on ARM and in WebAssembly, and takes 20 times as long.
template <class Real>
using Wider = std::conditional_t<std::is_same_v<Real, float>, double, long double>;

template <class Real>
bool factorizeRow(const OuterProduct& product, std::span<const Real> weights,
                  std::span<Real> factors) {
    const Index n = product.size[0], m = product.size[1], l = product.size[2];
    // The factors follow from sums of absolute weights over the other two axes. Each weight is
    // rounded. The relative error of a sum is smaller than the relative errors of its weights, if
    // the sum itself is not rounded.
    using Wide = Wider<Real>;
    // The sum of three factors of kMaxProductColumns is largest if two of them are 1.
    std::array<Wide, kernels::kMaxProductColumns + 2> sums;
    std::fill_n(sums.begin(), n + m + l, Wide{0});
    Wide total = 0, largest = 0;
    std::array<Index, 3> atLargest = {};
    const Index* next = product.order.data();
    for (Index k = 0; k < l; ++k)
        for (Index j = 0; j < m; ++j)
            for (Index i = 0; i < n; ++i) {
                const Wide size = std::abs(weights[*next++]);
                sums[i] += size;
                sums[n + j] += size;
                sums[n + m + k] += size;
                total += size;
                if (size > largest) {
                    largest = size;
                    atLargest = {i, j, k};
                }
            }
    // Tiny weights have fewer digits, or are rounded to 0: they may be off by kTiny, which must be
    // far below the largest weight.
    constexpr Wide kTiny = std::numeric_limits<Real>::min();
    if (largest * std::numeric_limits<Real>::epsilon() < kTiny) return false;
    for (Index i = 0; i < n + m + l; ++i)
        factors[i] = static_cast<Real>(i < n ? sums[i] : sums[i] / total);
    // Signs follow from the three lines through the largest weight. The sign of that weight itself
    // goes to the factor of axis 0.
    const auto isNegative = [&](Index i, Index j, Index k) {
        return std::signbit(weights[product.order[(k * m + j) * n + i]]);
    };
    const Index i0 = atLargest[0], j0 = atLargest[1], k0 = atLargest[2];
    const bool isLargestNegative = isNegative(i0, j0, k0);
    for (Index i = 0; i < n; ++i)
        if (isNegative(i, j0, k0)) factors[i] *= -1;
    for (Index j = 0; j < m; ++j)
        if (isNegative(i0, j, k0) != isLargestNegative) factors[n + j] *= -1;
    for (Index k = 0; k < l; ++k)
        if (isNegative(i0, j0, k) != isLargestNegative) factors[n + m + k] *= -1;
    constexpr Wide kBound = Wide{3} * std::numeric_limits<Real>::epsilon();
    next = product.order.data();
    for (Index k = 0; k < l; ++k)
        for (Index j = 0; j < m; ++j)
            for (Index i = 0; i < n; ++i) {
                const Wide weight = weights[*next++];
                const Wide found = Wide{factors[i]} * factors[n + j] * factors[n + m + k];
                if (!(std::abs(found - weight) <= kBound * std::abs(weight) + kTiny)) return false;
            }
    return true;
}

template std::optional<OuterProduct> findOuterProduct(std::span<const std::span<const float>>);
template std::optional<OuterProduct> findOuterProduct(std::span<const std::span<const double>>);
template bool factorizeRow(const OuterProduct&, std::span<const float>, std::span<float>);
template bool factorizeRow(const OuterProduct&, std::span<const double>, std::span<double>);

}  // namespace espalier::osd
