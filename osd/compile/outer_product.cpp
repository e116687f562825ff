// SPDX-License-Identifier: Apache-2.0
#include "outer_product.h"

#include <Eigen/Core>
#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstdint>
#include <limits>
#include <numeric>
#include <type_traits>

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
    // No spline has more columns than kMaxProductColumns: the search would take long and find
    // nothing.
    if (rows.empty() || rows[0].size() < 4 || rows[0].size() > kernels::kMaxProductColumns)
        return std::nullopt;
    // Skips rows with weights that are nearly 0, whose logarithms have no accuracy.
    std::vector<std::span<const Real>> samples;
    constexpr Real kMinWeight =
        std::numeric_limits<Real>::min() / std::numeric_limits<Real>::epsilon();
    for (const auto& weights : rows)
        if (areAtLeast(weights, kMinWeight)) samples.push_back(weights);
    if (samples.empty()) return std::nullopt;
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

namespace {

/// A type with more digits than Real. Float has double, which all processors compute with: long
/// double is emulated on ARM and in WebAssembly, and takes 20 times as long.
template <class Real>
using Wider = std::conditional_t<std::is_same_v<Real, float>, double, long double>;

/// Rows of weights side by side, and their factors.
///
/// Two rows are summed at once, in vectors: one row after another takes twice as long, since
/// each addition waits for the one before. The result of a row does not depend on the other rows.
template <class Real>
class RowBlock {
public:
    /// Number of rows. There are no vectors of long doubles.
    static constexpr std::size_t kRows = sizeof(Real) == sizeof(float) ? 2 : 1;

    /// \param positions for each weight of a row, its position among the columns of the product
    RowBlock(const OuterProduct& product, std::span<const Index> positions)
        : n_(product.size[0]),
          m_(product.size[1]),
          l_(product.size[2]),
          given_(positions.size() + 1, Given::Zero()),
          sources_(product.order.size(), positions.size()),
          weights_(product.order.size()) {
        std::vector<std::size_t> givenAt(product.order.size(), positions.size());
        for (std::size_t k = 0; k < positions.size(); ++k) givenAt[positions[k]] = k;
        for (std::size_t place = 0; place < sources_.size(); ++place)
            sources_[place] = givenAt[product.order[place]];
    }

    void setRows(const std::array<const Real*, kRows>& rows) {
        for (std::size_t k = 0; k + 1 < given_.size(); ++k)
            for (std::size_t row = 0; row < kRows; ++row) given_[k][row] = rows[row][k];
        const std::span<const Real> all(given_.data()->data(), given_.size() * kRows);
        Bits bits = 0;
        for (const Real weight : all) bits |= std::bit_cast<Bits>(weight);
        hasSign_ = bits >> (8 * sizeof(Bits) - 1) != 0;
    }

    /// Computes the factors of all rows.
    void factorize() {
        // Cubic splines have four factors along an axis.
        n_ == 4 ? factorize<4>() : factorize<0>();
    }

    /// Returns true if a row is an outer product.
    bool isProduct(std::size_t row) const {
        // Tiny weights have fewer digits, or are rounded to 0: they may be off by kTiny, which must
        // be far below the largest weight. The total is not finite if a weight is not.
        return largest_[row] * std::numeric_limits<Real>::epsilon() >= kTiny &&
               std::isfinite(total_[row]) && excess_[row] <= kTiny;
    }

    Real factor(std::size_t i, std::size_t row) const { return factors_[i][row]; }

private:
    using Wide = Wider<Real>;
    using Bits = BitsOf<Real>;
    using Given = Eigen::Array<Real, static_cast<int>(kRows), 1>;
    using Doubles = Eigen::Array<double, static_cast<int>(kRows), 1>;
    using Numbers = Eigen::Array<Wide, static_cast<int>(kRows), 1>;
    static constexpr Wide kTiny = std::numeric_limits<Real>::min();

    /// Computes the factors of all rows.
    /// \tparam fixed the size along axis 0, if it is known, so that sums stay in registers; or 0
    template <std::size_t fixed>
    void factorize() {
        addUp<fixed>();
        for (std::size_t i = 0; i < n_ + m_ + l_; ++i)
            factors_[i] = (i < n_ ? sums_[i] : Numbers(sums_[i] / total_)).template cast<Real>();
        if (hasSign_)
            for (std::size_t row = 0; row < kRows; ++row) setSigns(row);
        check<fixed>();
    }

    /// Adds up the absolute weights over two axes, for each place of the third.
    template <std::size_t fixed>
    void addUp() {
        // The factors follow from these sums. Each weight is rounded. The relative error of a sum
        // is smaller than the relative errors of its weights, if the sum itself is not rounded.
        const std::size_t n = fixed == 0 ? n_ : fixed, m = m_, l = l_;
        FirstFactors<fixed> first;
        std::fill_n(first.begin(), n, Numbers::Zero());
        Numbers *const second = sums_.data() + n, *const third = second + m;
        std::fill_n(second, m, Numbers::Zero());
        Numbers total = Numbers::Zero();
        Doubles largest = Doubles::Zero();
        const std::size_t* source = sources_.data();
        Doubles* weight = weights_.data();
        for (std::size_t k = 0; k < l; ++k) {
            Numbers plane = Numbers::Zero();
            for (std::size_t j = 0; j < m; ++j) {
                Numbers line = Numbers::Zero();
                for (std::size_t i = 0; i < n; ++i) {
                    const Doubles own = given_[*source++].template cast<double>();
                    *weight++ = own;
                    const Doubles size = own.abs();
                    largest = largest.max(size);
                    first[i] += size.template cast<Wide>();
                    line += size.template cast<Wide>();
                }
                second[j] += line;
                plane += line;
            }
            third[k] = plane;
            total += plane;
        }
        std::copy_n(first.begin(), n, sums_.begin());
        total_ = total;
        largest_ = largest;
    }

    /// Sets the signs of the factors. They follow from the three lines through the largest weight.
    /// The sign of that weight itself goes to the factor of axis 0.
    void setSigns(std::size_t row) {
        const auto found = std::find_if(
            weights_.begin(), weights_.end(),
            [&](const Doubles& weights) { return std::abs(weights[row]) == largest_[row]; });
        if (found == weights_.end()) return;  // no weight is a number
        const auto at = static_cast<std::size_t>(found - weights_.begin());
        const std::size_t i0 = at % n_, j0 = at / n_ % m_, k0 = at / n_ / m_;
        const auto isNegative = [&](std::size_t i, std::size_t j, std::size_t k) {
            return std::signbit(weights_[(k * m_ + j) * n_ + i][row]);
        };
        const bool isLargestNegative = isNegative(i0, j0, k0);
        for (std::size_t i = 0; i < n_; ++i)
            if (isNegative(i, j0, k0)) factors_[i][row] *= -1;
        for (std::size_t j = 0; j < m_; ++j)
            if (isNegative(i0, j, k0) != isLargestNegative) factors_[n_ + j][row] *= -1;
        for (std::size_t k = 0; k < l_; ++k)
            if (isNegative(i0, j0, k) != isLargestNegative) factors_[n_ + m_ + k][row] *= -1;
    }

    /// Compares the products with the weights.
    template <std::size_t fixed>
    void check() {
        constexpr Wide kBound = Wide{3} * std::numeric_limits<Real>::epsilon();
        const std::size_t n = fixed == 0 ? n_ : fixed, m = m_, l = l_;
        FirstFactors<fixed> first;
        for (std::size_t i = 0; i < n; ++i) first[i] = factors_[i].template cast<Wide>();
        Numbers excess = Numbers::Constant(-1);
        const Doubles* weight = weights_.data();
        for (std::size_t k = 0; k < l; ++k)
            for (std::size_t j = 0; j < m; ++j) {
                const Numbers other = factors_[n + j].template cast<Wide>() *
                                      factors_[n + m + k].template cast<Wide>();
                for (std::size_t i = 0; i < n; ++i, ++weight) {
                    const auto distance = (first[i] * other - weight->template cast<Wide>()).abs();
                    excess = excess.max(distance - kBound * weight->abs().template cast<Wide>());
                }
            }
        excess_ = excess;
    }

    /// A number for each factor of axis 0.
    template <std::size_t fixed>
    using FirstFactors =
        std::array<Numbers, fixed == 0 ? std::size_t{kernels::kMaxProductColumns} : fixed>;

    std::size_t n_, m_, l_;
    std::vector<Given> given_;          ///< the weights of the rows, and a 0
    std::vector<std::size_t> sources_;  ///< for each of weights_, its place in given_
    std::vector<Doubles> weights_;      ///< in the order of the product
    bool hasSign_ = false;              ///< true if any weight is negative or −0
    // The sum of three factors of kMaxProductColumns is largest if two of them are 1.
    std::array<Numbers, kernels::kMaxProductColumns + 2> sums_;
    std::array<Given, kernels::kMaxProductColumns + 2> factors_;
    Numbers total_;
    Doubles largest_;
    Numbers excess_;  ///< larger than kTiny if a product is farther from its weight than allowed
};

}  // namespace

template <class Real>
void factorizeRows(const OuterProduct& product, std::span<const Index> positions,
                   std::span<const std::span<const Real>> rows,
                   FunctionRef<void(std::size_t, std::span<const Real>)> use) {
    constexpr std::size_t kRows = RowBlock<Real>::kRows;
    RowBlock<Real> block(product, positions);
    std::vector<Real> factors(product.size[0] + product.size[1] + product.size[2]);
    for (std::size_t first = 0; first < rows.size(); first += kRows) {
        const std::size_t count = std::min(rows.size() - first, kRows);
        // If fewer rows are left, the block repeats the last one.
        std::array<const Real*, kRows> own;
        for (std::size_t row = 0; row < kRows; ++row)
            own[row] = rows[first + std::min(row, count - 1)].data();
        block.setRows(own);
        block.factorize();
        for (std::size_t row = 0; row < count; ++row) {
            const bool isProduct = block.isProduct(row);
            if (isProduct)
                for (std::size_t k = 0; k < factors.size(); ++k) factors[k] = block.factor(k, row);
            use(first + row, isProduct ? factors : std::span<const Real>());
        }
    }
}

template std::optional<OuterProduct> findOuterProduct(std::span<const std::span<const float>>);
template std::optional<OuterProduct> findOuterProduct(std::span<const std::span<const double>>);
template void factorizeRows(const OuterProduct&, std::span<const Index>,
                            std::span<const std::span<const float>>,
                            FunctionRef<void(std::size_t, std::span<const float>)>);
template void factorizeRows(const OuterProduct&, std::span<const Index>,
                            std::span<const std::span<const double>>,
                            FunctionRef<void(std::size_t, std::span<const double>)>);

}  // namespace espalier::osd
