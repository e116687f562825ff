// SPDX-License-Identifier: Apache-2.0
#include <espalier/base/sort_unique.h>

#include <bit>
#include <cstdint>

namespace espalier {
namespace {

/// Replaces numbers by the ascending numbers in them, with a bit for each value from `low` to
/// `high`.
void sortByBits(std::vector<Index>& numbers, Index low, std::size_t wordCount) {
    std::vector<std::uint64_t> words(wordCount, 0);
    for (const Index number : numbers) {
        const Offset bit = Offset{number} - low;
        words[bit / 64] |= std::uint64_t{1} << (bit % 64);
    }
    auto to = numbers.begin();
    for (std::size_t at = 0; at < wordCount; ++at)
        for (std::uint64_t word = words[at]; word != 0; word &= word - 1)
            *to++ = static_cast<Index>(low + static_cast<Offset>(at) * 64 + std::countr_zero(word));
    numbers.erase(to, numbers.end());
}

}  // namespace

void sortUnique(std::vector<Index>& numbers) {
    constexpr std::size_t kFew = 32;  // up to this number, sorting is faster
    if (numbers.size() > kFew) {
        const auto [low, high] = std::minmax_element(numbers.begin(), numbers.end());
        const std::size_t wordCount = (Offset{*high} - *low) / 64 + 1;
        if (wordCount <= numbers.size()) return sortByBits(numbers, *low, wordCount);
    }
    std::sort(numbers.begin(), numbers.end());
    numbers.erase(std::unique(numbers.begin(), numbers.end()), numbers.end());
}

}  // namespace espalier
