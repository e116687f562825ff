// SPDX-License-Identifier: Apache-2.0
#include "splats.h"

#include <espalier/base/parallel.h>
#include <espalier/base/vector3.h>
#include <espalier/io/files/text_reader.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>
#include <utility>

#include "../files/text_output.h"

namespace espalier::io {
namespace {

using Quaternion = std::array<double, 4>;  ///< w x y z

/// A matrix by its columns.
using Columns = std::array<Point3, 3>;

constexpr Columns kAxes = {{{1, 0, 0}, {0, 1, 0}, {0, 0, 1}}};

Point3 times(const Columns& matrix, const Point3& vector) {
    return sum(sum(scaled(matrix[0], vector[0]), scaled(matrix[1], vector[1])),
               scaled(matrix[2], vector[2]));
}

/// Returns the matrix of a quaternion of length 1.
Columns matrixOf(const Quaternion& q) {
    const auto [w, x, y, z] = q;
    return {{{1 - 2 * (y * y + z * z), 2 * (x * y + w * z), 2 * (x * z - w * y)},
             {2 * (x * y - w * z), 1 - 2 * (x * x + z * z), 2 * (y * z + w * x)},
             {2 * (x * z + w * y), 2 * (y * z - w * x), 1 - 2 * (x * x + y * y)}}};
}

/// Returns the quaternion of a rotation, of length 1. Of the two, it is the one whose largest
/// number is positive.
Quaternion quaternionOf(const Columns& r) {
    // Four times the squares of w, x, y and z. One of them is at least 1.
    const std::array<double, 4> squares = {
        1 + r[0][0] + r[1][1] + r[2][2], 1 + r[0][0] - r[1][1] - r[2][2],
        1 - r[0][0] + r[1][1] - r[2][2], 1 - r[0][0] - r[1][1] + r[2][2]};
    const std::size_t largest = std::max_element(squares.begin(), squares.end()) - squares.begin();
    const double size = std::sqrt(squares[largest]), factor = 1 / (2 * size);
    Quaternion q;
    q[largest] = size / 2;
    // If i, j, k is an even permutation of the axes, r[i][j] is 2 (q_i q_j + w q_k), and r[j][i] is
    // 2 (q_i q_j − w q_k).
    for (std::size_t k = 0; k < 3; ++k) {
        const std::size_t i = (k + 1) % 3, j = (k + 2) % 3;
        const double withW = (r[i][j] - r[j][i]) * factor, pair = (r[i][j] + r[j][i]) * factor;
        if (largest == 0)
            q[k + 1] = withW;
        else if (largest == k + 1)
            q[0] = withW;
        else
            q[largest == i + 1 ? j + 1 : i + 1] = pair;
    }
    return q;
}

/// Turns pairs of columns of A until all are orthogonal: A becomes A V = U S, where U S Vᵀ is its
/// singular value decomposition. No turn exceeds 45°, so columns that are nearly orthogonal keep
/// their order. Short columns are as precise as long ones: J. Demmel, K. Veselić, "Jacobi's method
/// is more accurate than QR", 1992, algorithm 4.1.
/// \param v receives the product of v and V; may be null
void makeOrthogonal(Columns& a, Columns* v) {
    constexpr int kMaxSweeps = 30;  // 3 to 6, unless the columns are dependent
    constexpr double kRounding = 4 * std::numeric_limits<double>::epsilon();
    constexpr std::pair<std::size_t, std::size_t> kPairs[] = {{0, 1}, {0, 2}, {1, 2}};
    bool isDone = false;
    for (int sweep = 0; sweep < kMaxSweeps && !isDone; ++sweep) {
        isDone = true;
        for (const auto& [p, q] : kPairs) {
            const double pp = dot(a[p], a[p]), qq = dot(a[q], a[q]), pq = dot(a[p], a[q]);
            if (!(pq * pq > kRounding * kRounding * pp * qq)) continue;
            isDone = false;
            const double zeta = (qq - pp) / (2 * pq);
            const double tangent =
                std::copysign(1 / (std::abs(zeta) + std::sqrt(1 + zeta * zeta)), zeta);
            const double cosine = 1 / std::sqrt(1 + tangent * tangent), sine = cosine * tangent;
            const auto turn = [&, p = p, q = q](Columns& m) {
                const Point3 old = m[p];
                m[p] = difference(scaled(old, cosine), scaled(m[q], sine));
                m[q] = sum(scaled(old, sine), scaled(m[q], cosine));
            };
            turn(a);
            if (v) turn(*v);
        }
    }
}

/// Returns the rotation whose columns are along the orthogonal columns of A. If the determinant of
/// A is negative, the shortest column is reversed. A column of length 0 gets a direction near a
/// column of `hint`. \param hint a rotation
Columns rotationAlong(const Columns& a, const Columns& hint) {
    const std::array<double, 3> lengths = {length(a[0]), length(a[1]), length(a[2])};
    // If two columns have the same length, the column that points away from its hint counts as the
    // shorter one. So the mirror of an axis turns nothing.
    const auto isShorter = [&](std::size_t i, std::size_t j) {
        const bool isSame = std::abs(lengths[i] - lengths[j]) <= 1e-9 * lengths[j];
        return isSame ? dot(a[i], hint[i]) < dot(a[j], hint[j]) : lengths[i] < lengths[j];
    };
    std::size_t third = isShorter(1, 0) ? 1 : 0;
    if (isShorter(2, third)) third = 2;
    std::size_t first = (third + 1) % 3, second = (third + 2) % 3;
    const bool isSwapped = lengths[second] > lengths[first];
    if (isSwapped) std::swap(first, second);
    if (!(lengths[first] > 0)) return hint;
    Columns r;
    r[first] = scaled(a[first], 1 / lengths[first]);
    // Dependent columns are orthogonal only as far as rounding allows.
    const auto across = [&](const Point3& column) {
        return difference(column, scaled(r[first], dot(r[first], column)));
    };
    Point3 next = across(a[second]);
    if (!(length(next) > lengths[second] / 2)) {
        // At least one of two orthogonal directions is at an angle of 45° or more to the first.
        next = across(hint[second]);
        if (!(length(next) > 0.5)) next = across(hint[third]);
    }
    r[second] = scaled(next, 1 / length(next));
    r[third] = isSwapped ? cross(r[second], r[first]) : cross(r[first], r[second]);
    return r;
}

/// Returns the number of harmonics of a degree.
constexpr std::size_t bandSize(std::size_t degree) {
    return 2 * degree + 1;
}
constexpr std::size_t kMaxBand = bandSize(3);

using Band = std::array<double, kMaxBand>;

/// Returns the harmonics of a degree in a direction, times √(4π).
Band harmonics(std::size_t degree, const Point3& direction) {
    const auto [x, y, z] = direction;
    const double xx = x * x, yy = y * y, zz = z * z;
    if (degree == 1) {
        constexpr double kA = std::numbers::sqrt3;
        return {-kA * y, kA * z, -kA * x};
    }
    if (degree == 2) {
        static const double kA = std::sqrt(15.0), kB = std::sqrt(5.0) / 2;
        return {kA * x * y, -kA * y * z, kB * (2 * zz - xx - yy), -kA * x * z, kA / 2 * (xx - yy)};
    }
    static const double kA = std::sqrt(35.0 / 8), kB = std::sqrt(105.0), kC = std::sqrt(21.0 / 8),
                        kD = std::sqrt(7.0) / 2;
    return {-kA * y * (3 * xx - yy),      kB * x * y * z,
            -kC * y * (4 * zz - xx - yy), kD * z * (2 * zz - 3 * xx - 3 * yy),
            -kC * x * (4 * zz - xx - yy), kB / 2 * z * (xx - yy),
            -kA * x * (xx - 3 * yy)};
}

/// Directions whose first 2 · degree + 1 determine the harmonics of a degree by their values: the
/// condition number of the matrix of values is less than 3. (This holds for unit vectors. Harmonics
/// of one degree are homogeneous polynomials, so other lengths scale the rows.)
constexpr std::array<Point3, kMaxBand> kDirections = {
    {{0, 0, 1}, {1, 0, 0}, {0, 1, -1}, {1, -1, 0}, {1, 0, -1}, {0, 1, 0}, {1, -1, -1}}};

/// A matrix by its rows, of which a degree uses the first.
using BandMatrix = std::array<Band, kMaxBand>;

/// Returns the inverse of the matrix whose rows are the harmonics in kDirections.
BandMatrix inverseOfHarmonics(std::size_t degree) {
    const std::size_t size = bandSize(degree);
    BandMatrix matrix{}, inverse{};
    for (std::size_t k = 0; k < size; ++k) {
        matrix[k] = harmonics(degree, kDirections[k]);
        inverse[k][k] = 1;
    }
    for (std::size_t k = 0; k < size; ++k) {  // Gauss and Jordan, with pivots
        std::size_t pivot = k;
        for (std::size_t i = k + 1; i < size; ++i)
            if (std::abs(matrix[i][k]) > std::abs(matrix[pivot][k])) pivot = i;
        std::swap(matrix[k], matrix[pivot]);
        std::swap(inverse[k], inverse[pivot]);
        const auto subtract = [&](std::size_t from, double factor) {
            for (std::size_t j = 0; j < size; ++j) {
                matrix[from][j] -= factor * matrix[k][j];
                inverse[from][j] -= factor * inverse[k][j];
            }
        };
        for (std::size_t i = 0; i < size; ++i)
            if (i != k) subtract(i, matrix[i][k] / matrix[k][k]);
        subtract(k, 1 - 1 / matrix[k][k]);
    }
    return inverse;
}

/// Turns the harmonics of a degree, of the three colours.
/// \param all the harmonics of all colours and degrees
template <std::size_t degree>
void turnBand(const Columns& rotation, std::span<double> all) {
    static const BandMatrix kInverse = inverseOfHarmonics(degree);
    constexpr std::size_t kSize = bandSize(degree), kFirst = harmonicCount(degree - 1) / 3;
    BandMatrix seen;  // the harmonics in the directions from which kDirections come
    for (std::size_t k = 0; k < kSize; ++k) {
        const Point3& d = kDirections[k];
        seen[k] =
            harmonics(degree, {dot(rotation[0], d), dot(rotation[1], d), dot(rotation[2], d)});
    }
    for (std::size_t colour = 0; colour < 3; ++colour) {
        double* const band = all.data() + colour * all.size() / 3 + kFirst;
        Band values{};
        for (std::size_t k = 0; k < kSize; ++k)
            for (std::size_t m = 0; m < kSize; ++m) values[k] += seen[k][m] * band[m];
        for (std::size_t m = 0; m < kSize; ++m) {
            band[m] = 0;
            for (std::size_t k = 0; k < kSize; ++k) band[m] += kInverse[m][k] * values[k];
        }
    }
}

void turnHarmonics(const Columns& rotation, std::span<double> all) {
    if (all.size() >= harmonicCount(1)) turnBand<1>(rotation, all);
    if (all.size() >= harmonicCount(2)) turnBand<2>(rotation, all);
    if (all.size() >= harmonicCount(3)) turnBand<3>(rotation, all);
}

/// Returns the rotation that is nearest to a matrix: U Vᵀ of its singular value decomposition.
Columns nearestRotation(Columns matrix) {
    Columns v = kAxes;
    makeOrthogonal(matrix, &v);
    const Columns u = rotationAlong(matrix, v);
    Columns rotation;
    for (std::size_t j = 0; j < 3; ++j) rotation[j] = times(u, {v[0][j], v[1][j], v[2][j]});
    return rotation;
}

/// Carries the logarithms s and the quaternion q of a splat.
/// \param f F / 2^exponent
void carryAxes(const Columns& f, int exponent, std::span<double> s, std::span<double> q) {
    const double norm = length({length({q[0], q[1], q[2]}), q[3], 0});
    const Quaternion unit = {q[0] / norm, q[1] / norm, q[2] / norm, q[3] / norm};
    const Columns r = matrixOf(unit);
    // Fourth powers of lengths between e^-150 and 1 are in range.
    const double longest = std::max({s[0], s[1], s[2]});
    std::array<double, 3> relative;
    Columns a;
    for (std::size_t j = 0; j < 3; ++j) {
        relative[j] = std::max(s[j] - longest, -150.0);
        a[j] = scaled(times(f, r[j]), std::exp(relative[j]));
    }
    makeOrthogonal(a, nullptr);
    static const double kFlat = std::log(double{std::numeric_limits<float>::min()});
    for (std::size_t j = 0; j < 3; ++j) {
        const double growth = std::log(length(a[j])) - relative[j];
        s[j] = std::max(s[j] + growth + exponent * std::numbers::ln2, std::min(s[j], kFlat));
    }
    const Quaternion turned = quaternionOf(rotationAlong(a, r));
    double side = 0;
    for (std::size_t i = 0; i < 4; ++i) side += turned[i] * unit[i];
    for (std::size_t i = 0; i < 4; ++i) q[i] = std::copysign(norm, side) * turned[i];
}

bool areFinite(std::span<const double> numbers) {
    return std::ranges::all_of(numbers, [](double number) {
        return std::abs(number) <= std::numeric_limits<float>::max();
    });
}

double rounded(double value, Precision precision) {
    return precision == Precision::Float ? static_cast<float>(value) : value;
}

/// The numbers of a splat, before and after.
struct SplatChange {
    std::array<double, kMaxSplatNumbers> before{}, now{};

    /// Carries the splat whose numbers are in `before`.
    void carry(const FileSplats& splats, const DeformationGradient& gradient) {
        now = before;
        carrySplat(gradient, std::span(now).first(splats.columns.size()));
        for (const auto& [place, number, precision] : splats.columns)
            if (now[number] != before[number]) now[number] = rounded(now[number], precision);
    }

    bool changes(std::size_t number) const { return !isSame(before[number], now[number]); }
};

/// Calls with(column, word) for the numbers of a row of a text.
template <class With>
void forEachWord(const FileSplats& splats, std::string_view text, std::size_t point, With with) {
    std::string_view rest = text.substr(splats.rows[point]);
    rest = rest.substr(0, rest.find('\n'));
    std::size_t taken = 0;
    for (const FileSplats::Column& column : splats.columns) {
        std::string_view word;
        for (; taken <= column.place; ++taken) word = takeWord(rest);
        with(column, word);
    }
}

}  // namespace

bool isHarmonicCount(std::size_t count) {
    for (std::size_t degree = 0; degree <= 3; ++degree)
        if (count == harmonicCount(degree)) return true;
    return false;
}

void carrySplat(const DeformationGradient& gradient, std::span<double> numbers) {
    if (gradient == DeformationGradient{1, 0, 0, 0, 1, 0, 0, 0, 1}) return;
    std::array<double, kMaxSplatNumbers> result;
    std::ranges::copy(numbers, result.begin());
    const auto s = std::span(result).first(3), q = std::span(result).subspan(3, 4);
    const auto harmonics = std::span(result).first(numbers.size()).subspan(kSplatAxes);
    if (!areFinite(numbers) || std::ranges::count(q, 0.0) == 4) return;
    // Products of many entries near 1 are in range.
    double largest = 0;
    for (const double entry : gradient) largest = std::max(largest, std::abs(entry));
    const bool isNear = largest == 0 || (largest > 0x1p-10 && largest < 0x1p10);
    const int exponent = isNear ? 0 : std::ilogb(largest);
    Columns f;
    for (std::size_t i = 0; i < 9; ++i)
        f[i % 3][i / 3] = isNear ? gradient[i] : std::scalbn(gradient[i], -exponent);
    carryAxes(f, exponent, s, q);
    if (!harmonics.empty()) turnHarmonics(nearestRotation(f), harmonics);
    if (areFinite(std::span(result).first(numbers.size())))
        std::copy_n(result.begin(), numbers.size(), numbers.begin());
}

std::array<float, 6> splatCovariance(const Point3& logarithms, const Quaternion& quaternion) {
    double squares = 0;
    for (const double number : quaternion) squares += number * number;
    Quaternion unit = {1, 0, 0, 0};
    if (squares > 0)
        for (std::size_t i = 0; i < 4; ++i) unit[i] = quaternion[i] / std::sqrt(squares);
    const Columns axes = matrixOf(unit);
    std::array<float, 6> covariance;
    std::size_t at = 0;
    for (std::size_t i = 0; i < 3; ++i)
        for (std::size_t j = i; j < 3; ++j) {
            double entry = 0;
            for (std::size_t k = 0; k < 3; ++k)
                entry += std::exp(2 * logarithms[k]) * axes[k][i] * axes[k][j];
            covariance[at++] = static_cast<float>(entry);
        }
    return covariance;
}

void carryBinary(const FileSplats& splats, std::span<const DeformationGradient> gradients,
                 BinaryPart& part) {
    const auto count = static_cast<Offset>(part.endPoint - part.firstPoint);
    parallelFor(count, 1 << 10, [&](Offset first, Offset last) {
        SplatChange splat;
        for (Offset i = first; i < last; ++i) {
            const std::size_t point = part.firstPoint + i;
            const std::size_t row = splats.rows[point] - part.begin;
            for (const auto& [place, number, precision] : splats.columns)
                splat.before[number] = loadReal(part.bytes, row + place, precision, part.order);
            splat.carry(splats, gradients[point]);
            for (const auto& [place, number, precision] : splats.columns)
                if (splat.changes(number))
                    storeCoordinate(part.bytes, row + place, splat.now[number], precision,
                                    part.order);
        }
    });
}

void carryText(const FileSplats& splats, std::span<const DeformationGradient> gradients,
               std::string_view text, TextPatch& patch, TextChanges& others) {
    constexpr Offset kAtOnce = 1 << 12;
    const Offset count = std::ssize(splats.rows);
    std::vector<SplatChange> changes(std::min(kAtOnce, count));
    for (Offset begin = 0; begin < count; begin += kAtOnce) {
        const Offset size = std::min(kAtOnce, count - begin);
        parallelFor(size, 1 << 8, [&](Offset first, Offset last) {
            for (Offset i = first; i < last; ++i) {
                forEachWord(splats, text, begin + i, [&](const auto& column, auto word) {
                    changes[i].before[column.number] = parseReal(word, column.precision);
                });
                changes[i].carry(splats, gradients[begin + i]);
            }
        });
        for (Offset i = 0; i < size; ++i)
            forEachWord(splats, text, begin + i, [&](const auto& column, auto word) {
                if (!changes[i].changes(column.number)) return;
                others.applyUpTo(patch, word.data() - text.data());
                const double value = changes[i].now[column.number];
                if (column.precision == Precision::Float)
                    patch.replace(word, static_cast<float>(value));
                else
                    patch.replace(word, value);
            });
    }
}

}  // namespace espalier::io
