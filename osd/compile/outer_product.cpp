// SPDX-License-Identifier: Apache-2.0
#include "outer_product.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstdint>
#include <iterator>
#include <limits>
#include <numeric>

#include "../kernels/scratch.h"
#include "number_bits.h"

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

/// Returns true if no number is smaller than a minimum, in size, and each is a number.
template <class Real>
bool areAtLeast(std::span<const Real> numbers, Real least) {
    // The bits of positive numbers have the order of the numbers; NaN is beyond infinity. The
    // differences are negative where a number is out of range. Without a branch for each number
    // this takes a fourth of the time.
    using Bits = BitsOf<Real>;
    constexpr Bits kSign = Bits{1} << (8 * sizeof(Bits) - 1);
    constexpr auto kInfinity = std::bit_cast<Bits>(std::numeric_limits<Real>::infinity());
    const auto low = std::bit_cast<Bits>(least);
    Bits outside = 0;
    for (const Real number : numbers) {
        const Bits size = std::bit_cast<Bits>(number) & ~kSign;
        outside |= (size - low) | (kInfinity - size);
    }
    return (outside & kSign) == 0;
}

/// Returns rows without weights that are nearly 0, whose logarithms have no accuracy; nothing if
/// there is no such row. They are spread over all rows; where there are few, some are taken twice.
template <class Real>
std::optional<std::array<const Real*, kSamples>> findSamples(std::span<const Real* const> rows,
                                                             std::size_t columnCount) {
    constexpr Real kMinWeight =
        std::numeric_limits<Real>::min() / std::numeric_limits<Real>::epsilon();
    const auto isFit = [&](const Real* weights) {
        return areAtLeast(std::span(weights, columnCount), kMinWeight);
    };
    std::array<const Real*, kSamples> samples;
    const auto spread = [&](std::span<const Real* const> from) {
        for (std::size_t s = 0; s < kSamples; ++s)
            samples[s] = from[s * (from.size() - 1) / (kSamples - 1)];
    };
    // Usually all rows are fit, and no others need be read.
    spread(rows);
    if (std::all_of(samples.begin(), samples.end(), isFit)) return samples;
    std::vector<const Real*> fit;
    std::copy_if(rows.begin(), rows.end(), std::back_inserter(fit), isFit);
    if (fit.empty()) return std::nullopt;
    spread(fit);
    return samples;
}

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
std::optional<OuterProduct> findOuterProduct(std::span<const Real* const> rows,
                                             std::size_t columnCount) {
    // No spline has more columns than kMaxProductColumns: the search would take long and find
    // nothing.
    if (rows.empty() || columnCount < 4 || columnCount > kernels::kMaxProductColumns)
        return std::nullopt;
    const auto samples = findSamples(rows, columnCount);
    if (!samples) return std::nullopt;
    std::vector<Logarithms> points(columnCount, Logarithms{});
    for (std::size_t s = 0; s < kSamples; ++s) {
        const Real* const weights = (*samples)[s];
        for (std::size_t column = 0; column < columnCount; ++column) {
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

template <class Real>
void factorizeRows(const kernels::Kernels<Real>& kernels, const OuterProduct& product,
                   std::span<const Index> positions, std::span<const Real* const> rows,
                   Array<Real>& factors, std::vector<char>& isProduct) {
    const auto noWeight = static_cast<Index>(positions.size());
    std::vector<Index> weightAt(product.order.size(), noWeight), sources;
    for (Index k = 0; k < noWeight; ++k) weightAt[positions[k]] = k;
    for (const Index column : product.order) sources.push_back(weightAt[column]);
    const auto& size = product.size;
    const std::size_t length = size[0] + size[1] + size[2];
    const std::size_t before = factors.size();
    factors.resize(before + rows.size() * length);
    isProduct.resize(rows.size());
    AlignedVector<Real> memory(
        kernels::factorizingCount<Real>(noWeight, static_cast<Offset>(length)));
    kernels.factorize({rows.data(),
                       static_cast<Index>(rows.size()),
                       noWeight,
                       sources.data(),
                       {size[0], size[1], size[2]},
                       memory.data()},
                      factors.data() + before, isProduct.data());
    const std::size_t count = std::count(isProduct.begin(), isProduct.end(), 1);
    factors.resize(before + count * length);
}

template std::optional<OuterProduct> findOuterProduct(std::span<const float* const>, std::size_t);
template std::optional<OuterProduct> findOuterProduct(std::span<const double* const>, std::size_t);
template void factorizeRows(const kernels::Kernels<float>&, const OuterProduct&,
                            std::span<const Index>, std::span<const float* const>, Array<float>&,
                            std::vector<char>&);
template void factorizeRows(const kernels::Kernels<double>&, const OuterProduct&,
                            std::span<const Index>, std::span<const double* const>, Array<double>&,
                            std::vector<char>&);

}  // namespace espalier::osd
