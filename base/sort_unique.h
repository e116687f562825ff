// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <espalier/base/api.h>
#include <espalier/base/index.h>

#include <algorithm>
#include <optional>
#include <span>
#include <vector>

namespace espalier {

/// Sorts numbers and removes duplicates.
/// \cost O(n) if the numbers are dense: at least one for each 64 values between the smallest and
///       the largest; otherwise O(n log n)
ESPALIER_API void sortUnique(std::vector<Index>& numbers);

/// Returns the smallest number that a list names twice; nothing if it names none twice.
inline std::optional<Index> repeatedIn(std::span<const Index> numbers) {
    constexpr std::size_t kFew = 16;  // up to this number, comparing all pairs is faster
    if (numbers.size() <= kFew) {
        bool areDifferent = true;
        for (std::size_t i = 1; i < numbers.size(); ++i)
            for (std::size_t j = 0; j < i; ++j) areDifferent &= numbers[i] != numbers[j];
        if (areDifferent) return std::nullopt;
    }
    std::vector<Index> sorted(numbers.begin(), numbers.end());
    std::sort(sorted.begin(), sorted.end());
    const auto twice = std::adjacent_find(sorted.begin(), sorted.end());
    return twice == sorted.end() ? std::nullopt : std::optional(*twice);
}

/// Returns the position of a value in ascending numbers that contain it.
inline Index indexIn(std::span<const Index> ascending, Index value) {
    return static_cast<Index>(std::lower_bound(ascending.begin(), ascending.end(), value) -
                              ascending.begin());
}

}  // namespace espalier
