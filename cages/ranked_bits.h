// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <espalier/base/index.h>

#include <algorithm>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace espalier::cages {

/// A set of numbers from 0 to size − 1, one bit each, that knows the rank of each number.
///
/// Most cubes of a grid around a model are empty. An array with one entry for each member, in the
/// order of the members, takes little memory and time, and `rank()` finds the entry.
class RankedBits {
public:
    RankedBits() = default;
    explicit RankedBits(std::size_t size) : size_(size), words_(size / 64 + 1, 0) {}

    std::size_t size() const { return size_; }

    bool operator[](std::size_t number) const {
        return (words_[number / 64] >> number % 64 & 1) != 0;
    }

    /// Adds a number. rank() and count() hold after the next makeRanks() only.
    void insert(std::size_t number) { words_[number / 64] |= Word{1} << number % 64; }

    /// Adds first + i for each bit i that is set.
    void insertBits(std::size_t first, std::uint64_t bits) {
        const std::size_t word = first / 64, shift = first % 64;
        words_[word] |= bits << shift;
        if (shift > 0 && bits >> (64 - shift) != 0) words_[word + 1] |= bits >> (64 - shift);
    }

    void makeRanks() {
        ranks_.resize(words_.size());
        count_ = 0;
        for (std::size_t i = 0; i < words_.size(); ++i) {
            ranks_[i] = static_cast<std::uint32_t>(count_);
            count_ += countOf(words_[i]);
        }
    }

    /// Returns the number of members.
    std::size_t count() const { return count_; }

    /// Returns the number of members below `number`, which is at most size().
    std::size_t rank(std::size_t number) const {
        const Word below = (Word{1} << number % 64) - 1;
        return ranks_[number / 64] + countOf(words_[number / 64] & below);
    }

    /// Returns the bits of the numbers from `first` on: bit i stands for `first` + i. Bits of
    /// numbers beyond the last one are 0.
    std::uint64_t from(std::size_t first) const {
        const std::size_t word = first / 64, shift = first % 64;
        if (word >= words_.size()) return 0;
        const Word low = words_[word] >> shift;
        if (shift == 0 || word + 1 == words_.size()) return low;
        return low | words_[word + 1] << (64 - shift);
    }

    /// Returns true if the set has a number from `first` to `last` − 1.
    bool hasAny(std::size_t first, std::size_t last) const {
        for (; first < last; first += 64) {
            const std::size_t count = std::min<std::size_t>(64, last - first);
            const Word mask = ~Word{0} >> (64 - count);
            if ((from(first) & mask) != 0) return true;
        }
        return false;
    }

    /// Calls visit(number) for the members, ascending.
    template <class Visit>
    void forEach(Visit visit) const {
        for (std::size_t i = 0; i < words_.size(); ++i)
            for (Word word = words_[i]; word != 0; word &= word - 1)
                visit(64 * i + static_cast<std::size_t>(std::countr_zero(word)));
    }

private:
    using Word = std::uint64_t;

    /// The same as std::popcount(), which is a call on processors without an instruction for it.
    static std::size_t countOf(Word word) {
        word -= word >> 1 & 0x5555555555555555;
        word = (word & 0x3333333333333333) + (word >> 2 & 0x3333333333333333);
        word = (word + (word >> 4)) & 0x0f0f0f0f0f0f0f0f;
        return word * 0x0101010101010101 >> 56;
    }

    std::size_t size_ = 0, count_ = 0;
    std::vector<Word> words_;
    std::vector<std::uint32_t> ranks_;  ///< the number of members in all words before each word
};

}  // namespace espalier::cages
