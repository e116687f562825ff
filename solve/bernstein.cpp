// SPDX-License-Identifier: Apache-2.0
#include <espalier/far/vector3.h>
#include <espalier/solve/bernstein.h>

namespace espalier::solve {
namespace {

constexpr std::array<std::array<double, 4>, 4> kBinomial = {
    {{1, 0, 0, 0}, {1, 1, 0, 0}, {1, 2, 1, 0}, {1, 3, 3, 1}}};

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
    const std::size_t stride = kAxisStride[axis];
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

std::pair<Triquadratics<4>, Triquadratics<4>> partsInTime(const Triquadratics<4>& polynomial,
                                                          double time) {
    std::pair<Triquadratics<4>, Triquadratics<4>> result;
    for (std::size_t at = 0; at < 27; ++at) {
        std::array<double, 4> lanes = polynomial[at];
        for (std::size_t i = 0; i < 4; ++i) {
            result.first[at][i] = lanes[0];
            result.second[at][3 - i] = lanes[3 - i];
            for (std::size_t lane = 0; lane + 1 < 4 - i; ++lane)
                lanes[lane] = (1 - time) * lanes[lane] + time * lanes[lane + 1];
        }
    }
    return result;
}

template std::pair<Triquadratics<1>, Triquadratics<1>> halves(const Triquadratics<1>&, std::size_t);
template std::pair<Triquadratics<2>, Triquadratics<2>> halves(const Triquadratics<2>&, std::size_t);
template std::pair<Triquadratics<4>, Triquadratics<4>> halves(const Triquadratics<4>&, std::size_t);

}  // namespace espalier::solve
