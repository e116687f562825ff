// SPDX-License-Identifier: Apache-2.0
#include <espalier/solve/bernstein.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

namespace espalier::solve {
namespace {

/// How often a part of the cube is halved at most: 10 times along each axis, say; then the gap
/// between coefficients and values is 1e-6 of that in the whole.
constexpr int kDeepest = 30;

/// From one coefficient to the next along an axis.
constexpr std::array<std::size_t, 3> kStride = {1, 3, 9};

constexpr std::array<std::array<double, 4>, 4> kBinomial = {
    {{1, 0, 0, 0}, {1, 1, 0, 0}, {1, 2, 1, 0}, {1, 3, 3, 1}}};

Point3 cross(const Point3& a, const Point3& b) {
    return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
}

double dot(const Point3& a, const Point3& b) {
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

/// The product of Bernstein polynomials of degrees p and q has of coefficients i and j this part
/// at i + j.
double share(std::size_t p, std::size_t i, std::size_t q, std::size_t j) {
    return kBinomial[p][i] * kBinomial[q][j] / kBinomial[p + q][i + j];
}

/// The determinant of maps that are linear in time (2 ends) or do not change (1 end): first the
/// cross product of the derivatives by v and w, of degree (2, 1, 1) and twice that in time; then
/// its product with that by u.
template <std::size_t Ends>
Triquadratics<3 * Ends - 2> determinantOf(const std::array<const Derivatives*, Ends>& maps) {
    constexpr std::size_t kTime = Ends - 1;
    std::array<std::array<Point3, 2 * kTime + 1>, 12> area{};  // at a + 3 (b + 2 c)
    for (std::size_t s = 0; s < Ends; ++s)
        for (std::size_t t = 0; t < Ends; ++t)
            for (std::size_t alongV = 0; alongV < 4; ++alongV)
                for (std::size_t alongW = 0; alongW < 4; ++alongW) {
                    const std::size_t c = alongV % 2, b = alongW / 2;
                    const std::size_t a0 = alongV / 2, a1 = alongW % 2;
                    const double part = share(1, a0, 1, a1) * share(kTime, s, kTime, t);
                    const Point3 product = cross((*maps[s])[1][alongV], (*maps[t])[2][alongW]);
                    Point3& sum = area[a0 + a1 + 3 * (b + 2 * c)][s + t];
                    for (std::size_t i = 0; i < 3; ++i) sum[i] += part * product[i];
                }
    Triquadratics<3 * Ends - 2> result{};
    for (std::size_t c = 0; c < 2; ++c)
        for (std::size_t b = 0; b < 2; ++b)
            for (std::size_t alongU = 0; alongU < 4; ++alongU) {
                const std::size_t b1 = alongU % 2, c1 = alongU / 2;
                const double part = share(1, b, 1, b1) * share(1, c, 1, c1);
                for (std::size_t a = 0; a < 3; ++a)
                    for (std::size_t t = 0; t < 2 * kTime + 1; ++t)
                        for (std::size_t s = 0; s < Ends; ++s)
                            result[a + 3 * (b + b1 + 3 * (c + c1))][t + s] +=
                                part * share(2 * kTime, t, kTime, s) *
                                dot((*maps[s])[0][alongU], area[a + 3 * (b + 2 * c)][t]);
            }
    return result;
}

/// Whether a value that is known is not above a bound.
template <std::size_t Lanes>
bool isSeenBelow(const Triquadratics<Lanes>& polynomials, double bound) {
    return std::any_of(kCornerCoefficients.begin(), kCornerCoefficients.end(), [&](std::size_t at) {
        return std::any_of(polynomials[at].begin(), polynomials[at].end(), [&](double value) {
            return !(value > bound);  // nor is what is no number
        });
    });
}

/// Where the polynomials, each for its size, are furthest from linear: what is linear along each
/// axis has its least coefficient at a corner, so that nothing is gained by halving.
std::size_t mostBentAxis(const auto& polynomials, std::size_t firstLane = 0) {
    std::array<double, 3> bends{};
    for (std::size_t lane = firstLane; lane < polynomials[0].size(); ++lane) {
        double size = std::numeric_limits<double>::min();
        for (const auto& lanes : polynomials) size = std::max(size, std::abs(lanes[lane]));
        for (std::size_t axis = 0; axis < 3; ++axis) {
            double bend = 0;
            for (std::size_t at = 0; at < 27; ++at)
                if (at / kStride[axis] % 3 == 1)
                    bend = std::max(bend, std::abs(polynomials[at - kStride[axis]][lane] -
                                                   2 * polynomials[at][lane] +
                                                   polynomials[at + kStride[axis]][lane]));
            bends[axis] += bend / size;
        }
    }
    return static_cast<std::size_t>(std::max_element(bends.begin(), bends.end()) - bends.begin());
}

/// A part of the cube.
template <std::size_t Lanes>
struct Part {
    Triquadratics<Lanes> polynomials;
    int depth = 0;

    std::pair<Part, Part> halved(std::size_t axis) const {
        const auto [lower, upper] = halves(polynomials, axis);
        return {{lower, depth + 1}, {upper, depth + 1}};
    }
};

/// A part of the cube, and what the least quotient in it lies between.
struct QuotientPart : Part<2> {
    double low = std::numeric_limits<double>::infinity();
    double high = std::numeric_limits<double>::infinity();

    explicit QuotientPart(const Part<2>& part) : Part(part) {
        // The quotient is a mean of those of the coefficients, if all of its weights are positive.
        for (const auto& [upper, lower] : polynomials)
            low =
                std::min(low, lower > 0 ? upper / lower : -std::numeric_limits<double>::infinity());
        for (const std::size_t at : kCornerCoefficients)
            if (polynomials[at][1] > 0)
                high = std::min(high, polynomials[at][0] / polynomials[at][1]);
    }

    /// While weights are not positive, the way that isAbove() went to prove that they are.
    std::size_t axis() const { return mostBentAxis(polynomials, std::isinf(low) ? 1 : 0); }
};

}  // namespace

Triquadratics<1> determinant(const Derivatives& derivatives) {
    return determinantOf<1>({&derivatives});
}

Triquadratics<4> determinant(const Derivatives& first, const Derivatives& last) {
    return determinantOf<2>({&first, &last});
}

template <std::size_t Lanes>
std::pair<Triquadratics<Lanes>, Triquadratics<Lanes>> halves(
    const Triquadratics<Lanes>& polynomials, std::size_t axis) {
    const std::size_t stride = kStride[axis];
    std::pair<Triquadratics<Lanes>, Triquadratics<Lanes>> result;
    for (std::size_t at = 0; at < 27; ++at) {
        if (at / stride % 3 != 0) continue;
        for (std::size_t lane = 0; lane < Lanes; ++lane) {
            const double first = polynomials[at][lane], last = polynomials[at + 2 * stride][lane];
            const double middle = polynomials[at + stride][lane];
            const double lower = (first + middle) / 2, upper = (middle + last) / 2;
            result.first[at][lane] = first;
            result.first[at + stride][lane] = lower;
            result.first[at + 2 * stride][lane] = result.second[at][lane] = (lower + upper) / 2;
            result.second[at + stride][lane] = upper;
            result.second[at + 2 * stride][lane] = last;
        }
    }
    return result;
}

template <std::size_t Lanes>
bool isAbove(const Triquadratics<Lanes>& polynomials, double bound) {
    constexpr int kMostHalvings = 500;
    const auto isProved = [&](const Triquadratics<Lanes>& part) {
        return std::all_of(part.begin(), part.end(), [&](const auto& lanes) {
            return std::all_of(lanes.begin(), lanes.end(),
                               [&](double coefficient) { return coefficient > bound; });
        });
    };
    if (isProved(polynomials)) return true;
    std::vector<Part<Lanes>> open = {{polynomials, 0}};
    for (int halvings = 0; !open.empty(); ++halvings) {
        if (isSeenBelow(open.back().polynomials, bound) || open.back().depth == kDeepest ||
            halvings == kMostHalvings)
            return false;
        const auto [lower, upper] = open.back().halved(mostBentAxis(open.back().polynomials));
        open.pop_back();
        for (const auto& half : {lower, upper})
            if (!isProved(half.polynomials)) open.push_back(half);
    }
    return true;
}

double leastQuotient(const Triquadratics<2>& quotient) {
    // More than isAbove() may take to prove that the second is positive: then it shows here, too.
    constexpr int kMostHalvings = 2000;
    constexpr double kPrecision = 1e-3, kSmall = 1e-6;
    QuotientPart lowest({quotient, 0});
    double high = lowest.high;
    std::vector<QuotientPart> others;
    const auto isHigher = [](const QuotientPart& a, const QuotientPart& b) {
        return a.low > b.low;
    };
    for (int halvings = 0; halvings < kMostHalvings && lowest.depth < kDeepest; ++halvings) {
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

template std::pair<Triquadratics<1>, Triquadratics<1>> halves(const Triquadratics<1>&, std::size_t);
template std::pair<Triquadratics<2>, Triquadratics<2>> halves(const Triquadratics<2>&, std::size_t);
template std::pair<Triquadratics<4>, Triquadratics<4>> halves(const Triquadratics<4>&, std::size_t);
template bool isAbove(const Triquadratics<1>&, double);
template bool isAbove(const Triquadratics<4>&, double);

}  // namespace espalier::solve
