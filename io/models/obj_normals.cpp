// SPDX-License-Identifier: Apache-2.0
#include "obj_normals.h"

#include <espalier/base/cancellable_sort.h>
#include <espalier/base/vector3.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <functional>
#include <numeric>
#include <optional>
#include <ostream>
#include <string_view>
#include <unordered_map>
#include <utility>
#include <vector>

#include "../files/text_output.h"
#include "obj_statements.h"

// Corners of several points may share one `vn`, and the gradients at these points may carry it to
// different normals. These are the versions of the normal: the first version replaces the old `vn`,
// each other version gets a new line. A new line shifts the numbers of later normals, and the
// numbers that count back across it. A corner is rewritten only if its number no longer names its
// version.
//
//     normals_    the `vn` of the file, in its order, with the first version of each
//     additions_  the other versions, in the order of their first use
//     targets_    the version at each corner with a normal, in the order of the file: n for the
//                 first version of normal n, and the number of normals + a for addition a
//
// New lines follow the last `vn` before the corner that first needs them, because some readers
// resolve a corner as soon as they see it. In a file whose normals precede its faces, the old
// normals keep their numbers.

namespace espalier::io {
namespace {

/// Digits after the decimal point of a unit normal: finer than floats. With all digits of a double,
/// corners whose gradients differ only by rounding, as in a rigid motion, could no longer share a
/// normal.
constexpr int kDecimals = 9;

/// Returns the power of ten by which a vector of this length is multiplied before its components
/// are rounded to integers; infinite if the length is 0 or too small.
double decimalScale(double length) {
    return std::pow(10.0, kDecimals - std::floor(std::log10(length)));
}

Point3 rounded(Point3 direction, double scale) {
    if (!std::isfinite(scale)) return direction;
    // Adding 0 turns −0 into +0.
    for (double& component : direction) component = std::round(component * scale) / scale + 0.0;
    return direction;
}

/// Calls onPoint(counts), onNormal(words, counts) and onCorner(corner, counts) for each `v`, `vn`
/// and corner with a normal, in the order of the file.
template <class OnPoint, class OnNormal, class OnCorner>
void walk(const std::filesystem::path& path, std::string_view text, OnPoint onPoint,
          OnNormal onNormal, OnCorner onCorner) {
    CountsBefore counts;
    forEachObjStatement(path, text, [&](ObjWords& words, std::size_t) {
        const std::string_view keyword = words.next();
        if (keyword == "v") {
            onPoint(counts);
            ++counts.points;
        } else if (keyword == "vn") {
            onNormal(words, counts);
            ++counts.normals;
        } else if (keyword == "f" || keyword == "fo" || keyword == "surf") {
            for (std::string_view word = words.next(); !word.empty(); word = words.next())
                if (const auto corner = cornerOf(word)) onCorner(*corner, counts);
        }
    });
}

constexpr auto kPassOver = [](auto&&...) {};

struct Normal {
    Point3 value;
    double scale;                   ///< decimalScale(), by which its versions are rounded
    std::optional<Point3> carried;  ///< its first version
};

/// A version of a normal: the result of carrying it by the gradient of a point.
struct Version {
    std::size_t normal;
    Point3 value;
    bool operator==(const Version&) const = default;
};

struct VersionHash {
    std::size_t operator()(const Version& version) const {
        std::size_t hash = version.normal;
        for (const double number : version.value)
            hash = hash * 1000003 + std::hash<double>()(number);
        return hash;
    }
};

/// A version that gets a new line.
struct Addition {
    Point3 value;
    std::size_t anchor;    ///< the normal whose line it follows
    std::size_t rank = 0;  ///< its number in the order of the new file
};

class NormalWriter {
public:
    NormalWriter(const std::filesystem::path& path, std::string_view text,
                 std::span<const DeformationGradient> gradients)
        : path_(path), text_(text), gradients_(gradients) {
        walk(
            path_, text_, kPassOver,
            [&](ObjWords& words, const CountsBefore&) { normals_.push_back(readNormal(words)); },
            kPassOver);
        walk(path_, text_, kPassOver, kPassOver,
             [&](const ObjCorner& corner, const CountsBefore& before) {
                 if (const auto normal = normalOf(corner, before))
                     targets_.push_back(targetOf(corner, normal->index, before));
             });
        orderAdditions();
    }

    void write(std::ostream& out, const VectorChange& points) const {
        TextChanges moves(text_, {&points, 1});
        TextPatch patch(out, text_);
        std::size_t corners = 0;
        walk(
            path_, text_,
            [&](const CountsBefore& before) {
                moves.applyUpTo(patch, points.offsets[before.points][2] + 1);
            },
            [&](ObjWords& words, const CountsBefore& before) {
                replaceNormal(patch, words, normals_[before.normals]);
                insertAdditions(patch, words.end(), before.normals);
            },
            [&](const ObjCorner& corner, const CountsBefore& before) {
                const auto normal = normalOf(corner, before);
                if (!normal) return;
                const std::int64_t number = numberFor(targets_[corners++], *normal, before);
                if (number != normal->number) patch.replace(corner.normal, number);
            });
        patch.finish();
    }

private:
    static Normal readNormal(ObjWords& words) {
        Normal normal{};
        normal.value = readObjNormal(words);
        normal.scale = decimalScale(length(normal.value));
        return normal;
    }

    std::optional<ObjReference> normalOf(const ObjCorner& corner,
                                         const CountsBefore& before) const {
        return referenceOf(corner.normal, before.normals, normals_.size());
    }

    std::size_t targetOf(const ObjCorner& corner, std::size_t index, const CountsBefore& before) {
        Normal& normal = normals_[index];
        const auto point = referenceOf(corner.point, before.points, gradients_.size());
        if (!point || !isDirection(normal.value, Precision::Double)) return index;
        const Point3 carried =
            rounded(carryNormal(gradients_[point->index], normal.value), normal.scale);
        if (!normal.carried) normal.carried = carried;
        if (*normal.carried == carried) return index;
        const std::size_t next = normals_.size() + additions_.size();
        const auto [at, isNew] = added_.try_emplace({index, carried}, next);
        // If a corner precedes its normal, the new line follows the normal.
        if (isNew) additions_.push_back({carried, std::max(index + 1, before.normals) - 1});
        return at->second;
    }

    void orderAdditions() {
        order_.resize(additions_.size());
        std::iota(order_.begin(), order_.end(), std::size_t{0});
        stableSortCancellably(order_.begin(), order_.end(), [&](std::size_t a, std::size_t b) {
            return additions_[a].anchor < additions_[b].anchor;
        });
        additionsBefore_.assign(normals_.size() + 1, 0);
        for (std::size_t rank = 0; rank < order_.size(); ++rank) {
            Addition& addition = additions_[order_[rank]];
            addition.rank = rank;
            ++additionsBefore_[addition.anchor + 1];
        }
        std::partial_sum(additionsBefore_.begin(), additionsBefore_.end(),
                         additionsBefore_.begin());
    }

    /// Returns the number by which a corner names its version in the new file. It counts back if
    /// the old number did.
    std::int64_t numberFor(std::size_t target, const ObjReference& old,
                           const CountsBefore& before) const {
        std::size_t index = 0;
        if (target < normals_.size()) {
            index = target + additionsBefore_[target];
        } else {
            const Addition& addition = additions_[target - normals_.size()];
            index = addition.anchor + 1 + addition.rank;
        }
        const std::size_t nowBefore = before.normals + additionsBefore_[before.normals];
        return static_cast<std::int64_t>(index) -
               (old.number < 0 ? static_cast<std::int64_t>(nowBefore) : -1);
    }

    static void replaceNormal(TextPatch& patch, ObjWords& words, const Normal& normal) {
        if (!normal.carried) return;
        const Point3 before = rounded(normal.value, normal.scale);
        for (std::size_t axis = 0; axis < 3; ++axis) {
            const std::string_view word = words.next();
            if ((*normal.carried)[axis] != before[axis])
                patch.replace(word, (*normal.carried)[axis]);
        }
    }

    /// \param end end of the statement, without its line end
    void insertAdditions(TextPatch& patch, const char* end, std::size_t anchor) const {
        const std::size_t first = additionsBefore_[anchor];
        const std::size_t last = additionsBefore_[anchor + 1];
        if (first == last) return;
        const std::size_t offset = end - text_.data();
        const std::string_view lineEnd = text_.substr(offset).starts_with("\r\n") ? "\r\n" : "\n";
        const auto add = [&](std::string_view text) { patch.insert(offset, text); };
        // If the file ends in a backslash, it must not continue the statement with the new line.
        if (text_[offset - 1] == '\\') add(lineEnd);
        for (std::size_t i = first; i < last; ++i) {
            add(lineEnd);
            add("vn");
            for (const double component : additions_[order_[i]].value) {
                add(" ");
                add(formatNumber(component));
            }
        }
    }

    const std::filesystem::path& path_;
    std::string_view text_;
    std::span<const DeformationGradient> gradients_;
    std::vector<Normal> normals_;
    std::vector<Addition> additions_;
    std::unordered_map<Version, std::size_t, VersionHash> added_;  ///< target of each addition
    std::vector<std::size_t> targets_;
    std::vector<std::size_t> order_;            ///< the additions in the order of the new file
    std::vector<std::size_t> additionsBefore_;  ///< number before each normal; the total at the end
};

}  // namespace

void writeObjNormals(std::ostream& out, const FileView& file, std::span<const Point3> moved,
                     std::span<const DeformationGradient> gradients) {
    NormalWriter(file.path, file.bytes, gradients).write(out, file.numbers.points.changeTo(moved));
}

}  // namespace espalier::io
