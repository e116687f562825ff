// SPDX-License-Identifier: Apache-2.0
#include <espalier/base/vector3.h>

#include <tuple>

#include "bernstein.h"

namespace espalier::solve {
namespace {

constexpr double binomial(std::size_t n, std::size_t k) {
    double result = 1;
    for (std::size_t i = 0; i < k; ++i)
        result = result * static_cast<double>(n - i) / static_cast<double>(i + 1);
    return result;
}

/// The degrees of a polynomial along the axes. Its coefficients are in order of places along u,
/// then v, then w.
struct Degrees {
    std::array<std::size_t, 3> along;

    constexpr std::size_t count() const { return (along[0] + 1) * (along[1] + 1) * (along[2] + 1); }
    constexpr std::size_t at(std::size_t a, std::size_t b, std::size_t c) const {
        return a + (along[0] + 1) * (b + (along[1] + 1) * c);
    }
    /// What the polynomial's basis function at a place has for a factor, beside its powers.
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

/// The factors of all places.
template <std::size_t Count>
constexpr std::array<double, Count> factorsOf(const Degrees& degrees) {
    std::array<double, Count> result{};
    degrees.forEach([&](std::size_t a, std::size_t b, std::size_t c) {
        result[degrees.at(a, b, c)] = degrees.factor(a, b, c);
    });
    return result;
}

/// Coefficients of the powers alone: in these, a product is a convolution.
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

/// The determinant of maps that are linear in time (2 ends) or do not change (1 end): first the
/// cross product of the derivatives by v and w, then its product with that by u. A factor linear in
/// time has no other factors than 1.
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

/// The coefficients of a polynomial in one variable up to a place between 0 and 1, and from there
/// on: by de Casteljau.
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
ESPALIER_INSTANTIATE(3, 8)

}  // namespace espalier::solve
