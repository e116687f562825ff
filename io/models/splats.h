// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <espalier/base/array.h>
#include <espalier/base/deformation_gradient.h>
#include <espalier/io/directions.h>

#include <array>
#include <bit>
#include <cstddef>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "coordinates.h"

/// \file
/// Carries Gaussian splats along with a deformation.
///
/// A splat is a Gaussian around a point, with the covariance Σ = R diag(e^s)² Rᵀ. The quaternion q
/// describes the rotation R. The numbers s are the logarithms of the standard deviations along the
/// axes of R. Spherical
/// harmonics describe how the colour depends on the direction of view (B. Kerbl, G. Kopanas, T.
/// Leimkühler, G. Drettakis, "3D Gaussian Splatting for Real-Time Radiance Field Rendering", 2023).

namespace espalier::io {

/// Functions take the numbers of a splat in this order: s (3 numbers); q as w, x, y, z, of any
/// length; then the harmonics of the degrees 1 to at most 3, first all of red, then green, then
/// blue. Harmonics have the order and the signs of the authors' program: degree 1 is (−y, z, −x).
inline constexpr std::size_t kSplatAxes = 3 + 4;

/// Returns the number of harmonics of the degrees 1 to `degree`, of three colours: 9, 24, 45.
constexpr std::size_t harmonicCount(std::size_t degree) {
    return 3 * degree * (degree + 2);
}
inline constexpr std::size_t kMaxSplatNumbers = kSplatAxes + harmonicCount(3);

/// Returns true if a splat may have this number of harmonics: 0, 9, 24 or 45.
bool isHarmonicCount(std::size_t count);

/// Carries a splat by a deformation gradient F.
///
/// The covariance becomes F Σ Fᵀ. A rotation F multiplies q by the quaternion of F and keeps s,
/// except for rounding, and the identity keeps all bits. If F is near a rotation, the axes keep
/// their order. q keeps its length. Where F flattens the splat to nothing along an axis, s becomes
/// the logarithm of the smallest normal float, unless it was less.
///
/// The colours turn with the rotation Q that is nearest to F, which is the rotation of its polar
/// decomposition if det F > 0: the splat has the colour in the direction d that it had in Qᵀ d. If
/// det F < 0, Q is a rotation all the same: colours are not mirrored.
///
/// \param gradient finite, of any size and determinant
/// \param numbers as above. They stay if q is 0; or if one of them, or of the results, is not
/// finite
///        or too large for a float
void carrySplat(const DeformationGradient& gradient, std::span<double> numbers);

/// Returns the covariance xx, xy, xz, yy, yz and zz of a splat.
/// \param logarithms s
/// \param quaternion q; if it is 0, the axes of the splat are x, y and z
std::array<float, 6> splatCovariance(const Point3& logarithms,
                                     const std::array<double, 4>& quaternion);

/// Says where a file has its splats, one per point. The file has the numbers of a splat in one row.
/// The model does not store the numbers, since they would take 400 bytes per splat: they are read
/// when the file is written.
struct FileSplats {
    /// Says where a row has a number of its splat.
    struct Column {
        std::size_t place;   ///< binary: bytes of the row before it; text: words before it
        std::size_t number;  ///< the number of the splat that it is
        Precision precision;
    };

    std::vector<Column> columns;  ///< in the order of the row
    Array<std::size_t> rows;      ///< where the row of each point begins in the file

    /// Number of harmonics that stay, because it is the number of no degree.
    std::size_t keptHarmonics = 0;
};

/// Carries the splats of a part of a binary file.
void carryBinary(const FileSplats& splats, std::span<const DeformationGradient> gradients,
                 BinaryPart& part);

/// Carries all splats of a text.
/// \param patch of the text
/// \param others changes of other numbers
void carryText(const FileSplats& splats, std::span<const DeformationGradient> gradients,
               std::string_view text, TextPatch& patch, TextChanges& others);

}  // namespace espalier::io
