// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <espalier/base/index.h>
#include <espalier/base/point.h>
#include <espalier/shapes/lattice.h>
#include <espalier/shapes/limb.h>
#include <espalier/shapes/selection.h>

#include <functional>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

// The words of `espalier pose` that name directions, lengths, vertices, pivots and planes.
namespace espalier::cli {

inline constexpr const char* kSelect = "--select";

/// Returns the direction that a word names: x, +y, -z.
std::optional<Point3> directionOf(std::string_view word);

/// A length in the units of the lattice, or in hundredths of the diagonal of the box around it.
struct Length {
    double value = 0;
    bool ofDiagonal = false;

    double in(const Lattice& lattice) const;
};

/// Returns the length that a word names: "0.3", "10%".
std::optional<Length> lengthOf(const std::string& word);

/// A set of vertices that --select names. One of the three functions is there.
struct Selection {
    std::string text;  ///< the words
    std::function<std::vector<double>(const Lattice&, const shapes::Falloff&)> weights;
    /// Returns a part of the lattice.
    std::function<shapes::Limb(const Lattice&)> part;
    /// Returns the vertices that follow from the vertices selected before.
    std::function<std::vector<Index>(const Lattice&, std::span<const Index>)> change;
    bool takesFalloff = true;
    bool isExplicit = false;  ///< names each vertex, so that few are no surprise
};

/// Returns the selection that the words of a --select name.
/// \throws CLI::ValidationError with the words that were expected
Selection selectionOf(const std::vector<std::string>& words);

/// The point that --about names.
struct Pivot {
    enum class Kind { Point, Vertex, Border, Joint };
    Kind kind = Kind::Border;
    Point3 point = {0, 0, 0};  ///< for Point, and the point on the model for Joint
    Index vertex = 0;
};

/// Returns the pivot that the words of an --about name.
/// \throws CLI::ValidationError with the words that were expected
Pivot pivotOf(const std::vector<std::string>& words);

/// A plane across an axis: at a place, or in the middle of the lattice.
struct MirrorPlane {
    int axis = 0;
    std::optional<double> place = {};
};

/// Returns the plane that a word names: x, y=0.5.
std::optional<MirrorPlane> mirrorPlaneOf(const std::string& word);

}  // namespace espalier::cli
