// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <espalier/base/index.h>

#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "ranked_bits.h"

namespace espalier::cages {

/// A set of voxels of a grid, one bit each. 64 neighbours along x are one word, so that operations
/// on rows take a 64th of the time of operations on voxels.
class VoxelSet {
public:
    /// \param counts of the grid, 1 or more
    explicit VoxelSet(const std::array<Index, 3>& counts);

    /// \param voxels the members by their numbers, x fastest
    VoxelSet(const std::array<Index, 3>& counts, const RankedBits& voxels);

    bool contains(const std::array<Index, 3>& voxel) const;

    /// Calls visit(voxel) for the members, by ascending numbers; x is fastest.
    template <class Visit>
    void forEach(Visit visit) const;

    VoxelSet complement() const;

    /// Returns the voxels whose centres are at most `radius` from the centre of a member.
    /// \param radius in edges of voxels, 0 or more
    /// \cost O(radius² · voxels / 64)
    VoxelSet within(double radius) const;

    /// Returns the members that are connected with the first voxel, over faces.
    VoxelSet connectedWithFirst() const;

private:
    using Word = std::uint64_t;
    using Row = std::span<Word>;
    bool findBorder(Index y, Index z, Row border) const;
    std::size_t rowCount() const { return Offset{counts_[1]} * counts_[2]; }
    Row row(std::size_t number) { return Row(words_).subspan(number * rowSize_, rowSize_); }
    std::span<const Word> row(std::size_t number) const {
        return std::span(words_).subspan(number * rowSize_, rowSize_);
    }

    std::array<Index, 3> counts_;
    std::size_t rowSize_;  ///< number of words in a row
    Word lastBits_;        ///< bits of the last word of a row that are voxels
    std::vector<Word> words_;
};

template <class Visit>
void VoxelSet::forEach(Visit visit) const {
    for (std::size_t number = 0; number < rowCount(); ++number)
        for (std::size_t i = 0; i < rowSize_; ++i)
            for (Word word = row(number)[i]; word != 0; word &= word - 1)
                visit(static_cast<Index>(number) * counts_[0] + static_cast<Index>(64 * i) +
                      std::countr_zero(word));
}

}  // namespace espalier::cages
