// SPDX-License-Identifier: Apache-2.0
#include "io/models/coordinates.h"

#include <espalier/io/files/text_reader.h>

#include <algorithm>
#include <map>
#include <random>
#include <sstream>
#include <string>
#include <vector>

#include "io/files/text_output.h"
#include "support/test.h"

namespace espalier::io {
namespace {

/// Vectors in a text, and the vectors that replace them.
struct Vectors {
    std::vector<CoordinateOffsets> offsets;
    std::vector<Point3> before, now;

    VectorChange change() const { return {offsets, before, now}; }
};

/// A text with the numbers of several vectors per point, in a random order.
struct NumberText {
    std::string text;
    std::vector<Vectors> vectors;
    std::size_t dimension;

    NumberText(std::size_t vectorCount, std::size_t pointCount, std::size_t axes, bool isShuffled,
               std::mt19937& random)
        : vectors(vectorCount), dimension(axes) {
        struct Number {
            std::size_t vector, point, axis;
        };
        std::vector<Number> numbers;
        for (std::size_t point = 0; point < pointCount; ++point)
            for (std::size_t vector = 0; vector < vectorCount; ++vector)
                for (std::size_t axis = 0; axis < axes; ++axis)
                    numbers.push_back({vector, point, axis});
        if (isShuffled) std::ranges::shuffle(numbers, random);
        std::uniform_int_distribution<int> digit(0, 9);
        for (Vectors& each : vectors) {
            each.offsets.resize(pointCount);
            each.before.assign(pointCount, {0, 0, 0});
            each.now = each.before;
        }
        for (const auto& [vector, point, axis] : numbers) {
            text += digit(random) < 3 ? "\n" : " ";
            vectors[vector].offsets[point][axis] = text.size();
            const std::string number = std::to_string(digit(random)) + ".50";
            text += number;
            vectors[vector].before[point][axis] = std::stod(number);
            // A third of the numbers stay.
            vectors[vector].now[point][axis] =
                digit(random) < 3 ? std::stod(number) : digit(random) + 100.25;
        }
        text += " end\n";
    }

    /// Returns the new text, by the obvious way: from the last number to the first.
    std::string replaced() const {
        std::map<std::size_t, std::string, std::greater<>> changed;
        for (const Vectors& each : vectors)
            for (std::size_t point = 0; point < each.before.size(); ++point)
                for (std::size_t axis = 0; axis < dimension; ++axis)
                    if (each.now[point][axis] != each.before[point][axis])
                        changed[each.offsets[point][axis]] = formatNumber(each.now[point][axis]);
        std::string result = text;
        for (const auto& [offset, number] : changed) result.replace(offset, 4, number);
        return result;
    }

    /// Writes the new text, by TextChanges.
    void write(std::ostream& out) const {
        const std::vector<VectorChange> all = changes();
        TextPatch patch(out, text);
        TextChanges(text, all, dimension).applyUpTo(patch, text.size());
        patch.finish();
    }

    std::vector<VectorChange> changes() const {
        std::vector<VectorChange> result;
        for (const Vectors& each : vectors) result.push_back(each.change());
        return result;
    }
};

TEST(TextChanges, ReplaceNumbersInAnyOrder) {
    std::mt19937 random(51);
    for (const bool isShuffled : {false, true})
        for (const std::size_t vectorCount : {1, 2, 3})
            for (const std::size_t axes : {2, 3})
                for (const std::size_t pointCount : {0, 1, 2, 50}) {
                    const NumberText sample(vectorCount, pointCount, axes, isShuffled, random);
                    std::ostringstream out;
                    sample.write(out);
                    EXPECT_EQ(out.str(), sample.replaced());
                }
}

TEST(TextChanges, StopBeforeAnOffset) {
    std::mt19937 random(52);
    const NumberText sample(2, 40, 3, true, random);
    const std::vector<VectorChange> changes = sample.changes();
    std::ostringstream out;
    {
        TextPatch patch(out, sample.text);
        TextChanges numbers(sample.text, changes);
        for (std::size_t end = 0; end < sample.text.size(); end += 7) numbers.applyUpTo(patch, end);
        numbers.applyUpTo(patch, sample.text.size());
        patch.finish();
    }
    EXPECT_EQ(out.str(), sample.replaced());
}

}  // namespace
}  // namespace espalier::io
