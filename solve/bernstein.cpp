// SPDX-License-Identifier: Apache-2.0
#include <espalier/base/vector3.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <tuple>
#include <vector>

#include "bernstein.h"

namespace espalier::solve {
namespace {

constexpr double binomial(std::size_t n, std::size_t k) {
    double result = 1;
    for (std::size_t i = 0; i < k; ++i)
        result = result * static_cast<double>(n - i) / static_cast<double>(i + 1);
    return result;
}

/// The degrees of a polynomial along the axes. Coefficients are ordered by their index along u,
/// then v, then w.
struct Degrees {
    std::array<std::size_t, 3> along;

    constexpr std::size_t count() const { return (along[0] + 1) * (along[1] + 1) * (along[2] + 1); }
    constexpr std::size_t at(std::size_t a, std::size_t b, std::size_t c) const {
        return a + (along[0] + 1) * (b + (along[1] + 1) * c);
    }
    /// Binomial factor of the basis function with this index.
    constexpr double factor(std::size_t a, std::size_t b, std::size_t c) const {
        return binomial(along[0], a) * binomial(along[1], b) * binomial(along[2], c);
    }

    template <class Visit>
    constexpr void forEach(Visit visit) const {
        for (std::size_t c = 0; c <= along[2]; ++c)
            for (std::size_t b = 0; b <= along[1]; ++b)
                for (std::size_t a = 0; a <= along[0]; ++a) visit(a, b, c);
    }
};

template <std::size_t Degree>
constexpr std::array<Degrees, 3> kDerivative = {{{{Degree - 1, Degree, Degree}},
                                                 {{Degree, Degree - 1, Degree}},
                                                 {{Degree, Degree, Degree - 1}}}};

/// Returns the binomial factors of all basis functions.
template <std::size_t Count>
constexpr std::array<double, Count> factorsOf(const Degrees& degrees) {
    std::array<double, Count> result{};
    degrees.forEach([&](std::size_t a, std::size_t b, std::size_t c) {
        result[degrees.at(a, b, c)] = degrees.factor(a, b, c);
    });
    return result;
}

/// Multiplies coefficients by their binomial factors. A product of polynomials is then a
/// convolution.
template <std::size_t Degree>
Derivatives<Degree> withFactors(const Derivatives<Degree>& derivatives) {
    constexpr std::size_t kCount = kDerivative<Degree>[0].count();
    constexpr std::array<std::array<double, kCount>, 3> kFactors = {
        factorsOf<kCount>(kDerivative<Degree>[0]), factorsOf<kCount>(kDerivative<Degree>[1]),
        factorsOf<kCount>(kDerivative<Degree>[2])};
    Derivatives<Degree> result = derivatives;
    for (std::size_t axis = 0; axis < 3; ++axis)
        for (std::size_t i = 0; i < kCount; ++i)
            for (double& coordinate : result[axis][i]) coordinate *= kFactors[axis][i];
    return result;
}

/// Returns the determinant of maps that are linear in time (2 ends) or constant (1 end): the cross
/// product of the derivatives by v and w, then its product with the derivative by u. Binomial
/// factors of degree 1, as in time, are 1.
template <std::size_t Degree, std::size_t Ends>
Trivariate<kDeterminantDegree<Degree>, 3 * Ends - 2> determinantOf(
    const std::array<const Derivatives<Degree>*, Ends>& maps) {
    constexpr std::size_t kTime = Ends - 1;
    constexpr Degrees kByU = kDerivative<Degree>[0], kByV = kDerivative<Degree>[1],
                      kByW = kDerivative<Degree>[2];
    constexpr Degrees kArea = {{2 * Degree, 2 * Degree - 1, 2 * Degree - 1}};
    constexpr std::size_t kWhole = kDeterminantDegree<Degree>;
    constexpr Degrees kResult = {{kWhole, kWhole, kWhole}};

    std::array<Derivatives<Degree>, Ends> scaled;
    for (std::size_t end = 0; end < Ends; ++end) scaled[end] = withFactors(*maps[end]);
    std::array<std::array<Point3, 2 * kTime + 1>, kArea.count()> area{};
    kByV.forEach([&](std::size_t a, std::size_t b, std::size_t c) {
        kByW.forEach([&](std::size_t i, std::size_t j, std::size_t k) {
            for (std::size_t s = 0; s < Ends; ++s)
                for (std::size_t t = 0; t < Ends; ++t) {
                    const Point3 product =
                        cross(scaled[s][1][kByV.at(a, b, c)], scaled[t][2][kByW.at(i, j, k)]);
                    Point3& sum = area[kArea.at(a + i, b + j, c + k)][s + t];
                    for (std::size_t x = 0; x < 3; ++x) sum[x] += product[x];
                }
        });
    });
    Trivariate<kWhole, 3 * Ends - 2> result{};
    kArea.forEach([&](std::size_t a, std::size_t b, std::size_t c) {
        kByU.forEach([&](std::size_t i, std::size_t j, std::size_t k) {
            for (std::size_t t = 0; t < 2 * kTime + 1; ++t)
                for (std::size_t s = 0; s < Ends; ++s)
                    result[kResult.at(a + i, b + j, c + k)][t + s] +=
                        dot(scaled[s][0][kByU.at(i, j, k)], area[kArea.at(a, b, c)][t]);
        });
    });
    constexpr auto kFactors = factorsOf<kResult.count()>(kResult);
    for (std::size_t i = 0; i < result.size(); ++i)
        for (std::size_t lane = 0; lane < result[i].size(); ++lane)
            result[i][lane] /= kFactors[i] * binomial(3 * kTime, lane);
    return result;
}

/// Splits a polynomial in one variable at `place`, between 0 and 1, by de Casteljau's algorithm.
template <std::size_t Count>
std::pair<std::array<double, Count>, std::array<double, Count>> cut(
    std::array<double, Count> coefficients, double place) {
    std::pair<std::array<double, Count>, std::array<double, Count>> result;
    for (std::size_t i = 0; i < Count; ++i) {
        result.first[i] = coefficients[0];
        result.second[Count - 1 - i] = coefficients[Count - 1 - i];
        for (std::size_t k = 0; k + 1 < Count - i; ++k)
            coefficients[k] = (1 - place) * coefficients[k] + place * coefficients[k + 1];
    }
    return result;
}

}  // namespace

template <std::size_t Degree>
Trivariate<kDeterminantDegree<Degree>, 1> determinant(const Derivatives<Degree>& derivatives) {
    return determinantOf<Degree, 1>({&derivatives});
}

template <std::size_t Degree>
Trivariate<kDeterminantDegree<Degree>, 4> determinant(const Derivatives<Degree>& first,
                                                      const Derivatives<Degree>& last) {
    return determinantOf<Degree, 2>({&first, &last});
}

template <std::size_t Degree, std::size_t Lanes>
std::pair<Trivariate<Degree, Lanes>, Trivariate<Degree, Lanes>> halves(
    const Trivariate<Degree, Lanes>& polynomials, std::size_t axis) {
    const std::size_t stride = kAxisStride<Degree>[axis];
    std::pair<Trivariate<Degree, Lanes>, Trivariate<Degree, Lanes>> result;
    for (std::size_t at = 0; at < polynomials.size(); ++at) {
        if (at / stride % (Degree + 1) != 0) continue;
        for (std::size_t lane = 0; lane < Lanes; ++lane) {
            std::array<double, Degree + 1> line;
            for (std::size_t i = 0; i <= Degree; ++i) line[i] = polynomials[at + i * stride][lane];
            const auto [lower, upper] = cut(line, 0.5);
            for (std::size_t i = 0; i <= Degree; ++i) {
                result.first[at + i * stride][lane] = lower[i];
                result.second[at + i * stride][lane] = upper[i];
            }
        }
    }
    return result;
}

template <std::size_t Degree>
std::pair<Trivariate<Degree, 4>, Trivariate<Degree, 4>> partsInTime(
    const Trivariate<Degree, 4>& polynomial, double time) {
    std::pair<Trivariate<Degree, 4>, Trivariate<Degree, 4>> result;
    for (std::size_t at = 0; at < polynomial.size(); ++at)
        std::tie(result.first[at], result.second[at]) = cut(polynomial[at], time);
    return result;
}

#define ESPALIER_INSTANTIATE_HALVES(Degree, Lanes)                                   \
    template std::pair<Trivariate<Degree, Lanes>, Trivariate<Degree, Lanes>> halves( \
        const Trivariate<Degree, Lanes>&, std::size_t);
#define ESPALIER_INSTANTIATE(Degree, DeterminantDegree)                                    \
    template Trivariate<DeterminantDegree, 1> determinant(const Derivatives<Degree>&);     \
    template Trivariate<DeterminantDegree, 4> determinant(const Derivatives<Degree>&,      \
                                                          const Derivatives<Degree>&);     \
    template std::pair<Trivariate<DeterminantDegree, 4>, Trivariate<DeterminantDegree, 4>> \
    partsInTime(const Trivariate<DeterminantDegree, 4>&, double);                          \
    ESPALIER_INSTANTIATE_HALVES(DeterminantDegree, 1)                                      \
    ESPALIER_INSTANTIATE_HALVES(DeterminantDegree, 2)                                      \
    ESPALIER_INSTANTIATE_HALVES(DeterminantDegree, 4)
ESPALIER_INSTANTIATE(1, 2)
ESPALIER_INSTANTIATE(2, 5)
ESPALIER_INSTANTIATE(3, 8)

namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();

/// Maximum number of halvings of a part of the cube. With 10 along each axis, the gap between
/// coefficients and values falls to 1e-6 of that in the whole cube.
constexpr int kMaxDepth = 30;

/// False for NaN.
constexpr bool isAboveZero(double value) {
    return value > 0;
}

/// True if all coefficients are positive, which proves that all values are.
template <std::size_t Degree, std::size_t Lanes>
bool isProvedPositive(const Trivariate<Degree, Lanes>& polynomials) {
    // Without a branch for each lane, and without a call: most polynomials are of degree 0.
    return std::all_of(polynomials.begin(), polynomials.end(), [](const auto& lanes) {
        bool areAboveZero = true;
        for (const double value : lanes) areAboveZero &= isAboveZero(value);
        return areAboveZero;
    });
}

/// True if a known value of a lane, at a corner, is not positive.
template <std::size_t Degree, std::size_t Lanes>
bool failsAtCorner(const Trivariate<Degree, Lanes>& polynomials, std::size_t lane) {
    const auto& corners = kCornerCoefficients<Degree>;
    return std::any_of(corners.begin(), corners.end(),
                       [&](std::size_t at) { return !isAboveZero(polynomials[at][lane]); });
}

/// Returns the deviation of a lane from linear along each axis. A polynomial that is linear along
/// all axes has its smallest coefficient at a corner, so that halving gains nothing.
template <std::size_t Degree, std::size_t Lanes>
std::array<double, 3> bends(const Trivariate<Degree, Lanes>& polynomials, std::size_t lane) {
    std::array<double, 3> result{};
    for (std::size_t axis = 0; axis < 3; ++axis) {
        const std::size_t stride = kAxisStride<Degree>[axis];
        for (std::size_t at = 0; at < polynomials.size(); ++at) {
            const std::size_t place = at / stride % (Degree + 1);
            if (place == 0 || place == Degree) continue;
            result[axis] = std::max(
                result[axis], std::abs(polynomials[at - stride][lane] - 2 * polynomials[at][lane] +
                                       polynomials[at + stride][lane]));
        }
    }
    return result;
}

template <std::size_t Count>
std::size_t largestOf(const std::array<double, Count>& values) {
    return std::max_element(values.begin(), values.end()) - values.begin();
}

/// A part of the cube.
template <std::size_t Degree, std::size_t Lanes>
struct Part {
    Trivariate<Degree, Lanes> polynomials;
    int depth = 0;

    std::pair<Part, Part> halved(std::size_t axis) const {
        const auto [lower, upper] = halves(polynomials, axis);
        return {{lower, depth + 1}, {upper, depth + 1}};
    }
};

/// A part of the cube, with bounds of the smallest quotient in it.
template <std::size_t Degree>
struct QuotientPart : Part<Degree, 2> {
    using Part<Degree, 2>::polynomials;

    double low = kInfinity;
    double high = kInfinity;

    explicit QuotientPart(const Part<Degree, 2>& part) : Part<Degree, 2>(part) {
        // The quotient is a weighted mean of the quotients of coefficients if all weights are
        // positive.
        for (const auto& [upper, lower] : polynomials)
            low = std::min(low, lower > 0 ? upper / lower : -kInfinity);
        for (const std::size_t at : kCornerCoefficients<Degree>)
            if (polynomials[at][1] > 0)
                high = std::min(high, polynomials[at][0] / polynomials[at][1]);
    }

    /// The axis along which the two polynomials, relative to their sizes, deviate most from linear.
    /// While some weights are not positive, only the second polynomial counts: isPositive() has
    /// proved by the same halvings that it is positive.
    std::size_t axis() const {
        std::array<double, 3> sum{};
        for (std::size_t lane = std::isinf(low) ? 1 : 0; lane < 2; ++lane) {
            double size = std::numeric_limits<double>::min();
            for (const auto& lanes : polynomials) size = std::max(size, std::abs(lanes[lane]));
            const auto ofLane = bends(polynomials, lane);
            for (std::size_t axis = 0; axis < 3; ++axis) sum[axis] += ofLane[axis] / size;
        }
        return largestOf(sum);
    }
};

/// A part of the cube during a part of the time.
template <std::size_t Degree>
struct MovingPart : Part<Degree, 4> {
    using Part<Degree, 4>::polynomials, Part<Degree, 4>::depth;

    double first = 0;
    double last = 1;

    /// True if the deviation from linear is larger in time than along each axis of space.
    bool isMostBentInTime() const { return largestOf(spaceAndTime()) == 3; }
    std::size_t axis() const {
        const auto all = spaceAndTime();
        return largestOf(std::array<double, 3>{all[0], all[1], all[2]});
    }

    std::pair<MovingPart, MovingPart> halvedInTime() const {
        const auto [before, after] = partsInTime(polynomials, 0.5);
        const double middle = (first + last) / 2;
        return {{{before, depth}, first, middle}, {{after, depth}, middle, last}};
    }
    std::pair<MovingPart, MovingPart> halvedInSpace() const {
        const auto [lower, upper] = this->halved(axis());
        return {{lower, first, last}, {upper, first, last}};
    }

private:
    std::array<double, 4> spaceAndTime() const {
        std::array<double, 4> result{};
        for (std::size_t lane = 0; lane < 4; ++lane) {
            const auto ofLane = bends(polynomials, lane);
            for (std::size_t axis = 0; axis < 3; ++axis)
                result[axis] = std::max(result[axis], ofLane[axis]);
        }
        for (const auto& lanes : polynomials)
            for (std::size_t i = 1; i < 3; ++i)
                result[3] =
                    std::max(result[3], std::abs(lanes[i - 1] - 2 * lanes[i] + lanes[i + 1]));
        return result;
    }
};

}  // namespace

template <std::size_t Degree>
bool isPositive(const Trivariate<Degree, 1>& polynomial) {
    constexpr int kMaxHalvings = 500;
    if (isProvedPositive(polynomial)) return true;
    if (Degree == 0) return false;
    std::vector<Part<Degree, 1>> open = {{polynomial, 0}};
    for (int halvings = 0; !open.empty(); ++halvings) {
        const Part<Degree, 1> part = open.back();
        open.pop_back();
        if (failsAtCorner(part.polynomials, 0) || part.depth == kMaxDepth ||
            halvings == kMaxHalvings)
            return false;
        const auto [lower, upper] = part.halved(largestOf(bends(part.polynomials, 0)));
        for (const auto& half : {lower, upper})
            if (!isProvedPositive(half.polynomials)) open.push_back(half);
    }
    return true;
}

template <std::size_t Degree>
double leastQuotient(const Trivariate<Degree, 2>& quotient) {
    if constexpr (Degree == 0) {
        const auto& [upper, lower] = quotient[0];
        return lower > 0 ? upper / lower : -kInfinity;
    }
    // This is more than isPositive() may need, so that the second polynomial is proved positive
    // here, too.
    constexpr int kMaxHalvings = 2000;
    constexpr double kPrecision = 1e-3, kSmall = 1e-6;
    QuotientPart<Degree> lowest({quotient, 0});
    double high = lowest.high;
    std::vector<QuotientPart<Degree>> others;
    const auto isHigher = [](const QuotientPart<Degree>& a, const QuotientPart<Degree>& b) {
        return a.low > b.low;
    };
    for (int halvings = 0; halvings < kMaxHalvings && lowest.depth < kMaxDepth; ++halvings) {
        const double gap = high - lowest.low;
        const bool hasSign = lowest.low > 0 || !(high > 0);
        if (hasSign &&
            !(gap > std::max(kSmall, kPrecision * std::max(std::abs(high), std::abs(lowest.low)))))
            break;
        const auto [lower, upper] = lowest.halved(lowest.axis());
        for (const auto& half : {lower, upper}) {
            others.emplace_back(half);
            high = std::min(high, others.back().high);
            std::push_heap(others.begin(), others.end(), isHigher);
        }
        std::pop_heap(others.begin(), others.end(), isHigher);
        lowest = others.back();
        others.pop_back();
    }
    return lowest.low;
}

double firstRoot(const std::array<double, 4>& coefficients, double upTo) {
    constexpr double kUnit = std::numeric_limits<double>::epsilon();
    struct Interval {
        std::array<double, 4> coefficients;
        double first, last;
    };
    std::vector<Interval> open;  // The earliest at the end.
    const auto keepUnlessPositive = [&](const Interval& interval) {
        if (!std::all_of(interval.coefficients.begin(), interval.coefficients.end(), isAboveZero))
            open.push_back(interval);
    };
    keepUnlessPositive({upTo < 1 ? cut(coefficients, upTo).first : coefficients, 0, upTo});
    while (!open.empty()) {
        const Interval interval = open.back();
        open.pop_back();
        const auto& [values, first, last] = interval;
        if (!isAboveZero(values[0]) || last - first <= kUnit * last) return first;
        const auto [before, after] = cut(values, 0.5);
        const double middle = (first + last) / 2;
        keepUnlessPositive({after, middle, last});
        keepUnlessPositive({before, first, middle});
    }
    return upTo;
}

namespace {

/// Finds the time up to which a polynomial is proved to be positive, within a millionth of it.
template <std::size_t Degree>
ProvedTime searchUpTo(const Trivariate<Degree, 4>& polynomial, double upTo) {
    using Moving = MovingPart<Degree>;
    constexpr int kMaxHalvings = 2000;
    constexpr double kPrecision = 1e-6, kNone = 1e-12;
    std::vector<Moving> open;  // A heap, the earliest first.
    const auto isLater = [](const Moving& a, const Moving& b) { return a.first > b.first; };
    const auto keepUnlessProved = [&](const Moving& part) {
        if (isProvedPositive(part.polynomials)) return;
        open.push_back(part);
        std::push_heap(open.begin(), open.end(), isLater);
    };
    keepUnlessProved({{upTo < 1 ? partsInTime(polynomial, upTo).first : polynomial, 0}, 0, upTo});
    for (int halvings = 0; !open.empty(); ++halvings) {
        std::pop_heap(open.begin(), open.end(), isLater);
        const Moving part = open.back();
        open.pop_back();
        // All earlier times are proved.
        const bool failsAtLast = failsAtCorner(part.polynomials, 3);
        const bool isMaxDepth = part.depth == kMaxDepth;
        const bool isShort =
            part.last - part.first <= kPrecision * part.first || part.last <= kNone;
        if (failsAtCorner(part.polynomials, 0) || (isShort && failsAtLast))
            return {part.first, true};
        if (halvings == kMaxHalvings || (isShort && isMaxDepth)) return {part.first, false};
        const bool takesTime = !isShort && (failsAtLast || isMaxDepth || part.isMostBentInTime());
        const auto [one, other] = takesTime ? part.halvedInTime() : part.halvedInSpace();
        keepUnlessProved(one);
        keepUnlessProved(other);
    }
    return {upTo, true};
}

}  // namespace

template <std::size_t Degree>
ProvedTime positiveUpTo(const Trivariate<Degree, 4>& polynomial, double upTo) {
    if constexpr (Degree == 0) return {firstRoot(polynomial[0], upTo), true};
    if (upTo == 1 && isProvedPositive(polynomial)) return {upTo, true};
    // First the corners, whose cubics are solved exactly. The search is precise to a millionth
    // only, but rarely has to find an earlier time. At the root itself rounding would hide the
    // proof.
    constexpr double kBeforeRoot = 1 - 1e-12;
    double root = upTo;
    for (const std::size_t at : kCornerCoefficients<Degree>)
        root = std::min(root, firstRoot(polynomial[at], root));
    if (!(root > 0)) return {0, true};
    return searchUpTo(polynomial, root < upTo ? root * kBeforeRoot : upTo);
}

template bool isPositive(const Trivariate<0, 1>&);
template bool isPositive(const Trivariate<2, 1>&);
template bool isPositive(const Trivariate<5, 1>&);
template bool isPositive(const Trivariate<8, 1>&);
template double leastQuotient(const Trivariate<0, 2>&);
template double leastQuotient(const Trivariate<2, 2>&);
template double leastQuotient(const Trivariate<5, 2>&);
template double leastQuotient(const Trivariate<8, 2>&);
template ProvedTime positiveUpTo(const Trivariate<0, 4>&, double);
template ProvedTime positiveUpTo(const Trivariate<2, 4>&, double);
template ProvedTime positiveUpTo(const Trivariate<5, 4>&, double);
template ProvedTime positiveUpTo(const Trivariate<8, 4>&, double);

}  // namespace espalier::solve
