// SPDX-License-Identifier: Apache-2.0
#include "voxel_set.h"

#include <espalier/base/progress.h>

#include <algorithm>
#include <cmath>

namespace espalier::cages {
namespace {

using Word = std::uint64_t;
constexpr Word kAllBits = ~Word{0};

/// Adds both neighbours of the members of a row. Bits after the last voxel may be set.
void widen(std::span<Word> row) {
    Word before = 0;  // the old word before the current one
    for (std::size_t i = 0; i < row.size(); ++i) {
        const Word word = row[i], after = i + 1 < row.size() ? row[i + 1] : 0;
        row[i] = word | word << 1 | before >> 63 | word >> 1 | after << 63;
        before = word;
    }
}

/// Adds the members of `free` that are connected with members of a row.
void spread(std::span<Word> row, std::span<const Word> free) {
    Word carry = 0;
    for (std::size_t i = 0; i < row.size(); ++i) {
        Word reached = row[i] | (carry & free[i]), open = free[i];
        for (int step = 1; step < 64; step *= 2) {
            reached |= open & reached << step;
            open &= open << step;
        }
        row[i] = reached;
        carry = reached >> 63;
    }
    carry = 0;
    for (std::size_t i = row.size(); i-- > 0;) {
        Word reached = row[i] | (carry & free[i]), open = free[i];
        for (int step = 1; step < 64; step *= 2) {
            reached |= open & reached >> step;
            open &= open >> step;
        }
        row[i] = reached;
        carry = reached << 63;
    }
}

}  // namespace

VoxelSet::VoxelSet(const std::array<Index, 3>& counts)
    : counts_(counts),
      rowSize_((Offset{counts[0]} + 63) / 64),
      lastBits_(kAllBits >> (64 * rowSize_ - counts[0])),
      words_(rowCount() * rowSize_, 0) {}

VoxelSet::VoxelSet(const std::array<Index, 3>& counts, const RankedBits& voxels)
    : VoxelSet(counts) {
    for (std::size_t number = 0; number < rowCount(); ++number) {
        const Row bits = row(number);
        for (std::size_t i = 0; i < rowSize_; ++i)
            bits[i] = voxels.from(number * counts[0] + 64 * i);
        bits.back() &= lastBits_;
    }
}

bool VoxelSet::contains(const std::array<Index, 3>& voxel) const {
    const auto [x, y, z] = voxel;
    return (row(Offset{z} * counts_[1] + y)[x / 64] >> x % 64 & 1) != 0;
}

VoxelSet VoxelSet::complement() const {
    VoxelSet result = *this;
    for (Word& word : result.words_) word = ~word;
    for (std::size_t number = 0; number < rowCount(); ++number)
        result.row(number).back() &= lastBits_;
    return result;
}

/// Finds the members of a row that have a neighbour in the grid that is no member. Only they are
/// nearest to other voxels.
/// \return true if there are any
bool VoxelSet::findBorder(Index y, Index z, Row border) const {
    const std::size_t ny = counts_[1];
    const std::size_t number = z * ny + y;
    const auto at = row(number), lower = row(y > 0 ? number - 1 : number),
               upper = row(y + 1 < counts_[1] ? number + 1 : number),
               below = row(z > 0 ? number - ny : number),
               above = row(z + 1 < counts_[2] ? number + ny : number);
    Word any = 0;
    for (std::size_t i = 0; i < rowSize_; ++i) {
        const bool isLast = i + 1 == rowSize_;
        const Word bits = isLast ? lastBits_ : kAllBits, word = at[i];
        // The voxels before the first and after the last one count as members.
        const Word left = word << 1 | (i > 0 ? at[i - 1] >> 63 : 1);
        const Word right = (word | ~bits) >> 1 | (isLast ? Word{1} : at[i + 1]) << 63;
        border[i] = word & ~(left & right & lower[i] & upper[i] & below[i] & above[i]);
        any |= border[i];
    }
    return any != 0;
}

VoxelSet VoxelSet::within(double radius) const {
    // The rows of a ball around a voxel, the shortest first.
    struct BallRow {
        Index reach, y, z;
    };
    std::vector<BallRow> ball;
    const double square = radius * radius;
    const auto far = static_cast<Index>(
        std::min<double>(radius, *std::max_element(counts_.begin(), counts_.end())));
    for (Index z = -far; z <= far; ++z)
        for (Index y = -far; y <= far; ++y) {
            const auto isInBall = [&](double x) { return x * x + y * y + z * z <= square; };
            if (!isInBall(0)) continue;
            Index reach = 0;
            while (reach < far && isInBall(reach + 1)) ++reach;
            ball.push_back({reach, y, z});
        }
    std::stable_sort(ball.begin(), ball.end(),
                     [](const BallRow& a, const BallRow& b) { return a.reach < b.reach; });

    VoxelSet result = *this;
    std::vector<char> isFull(rowCount(), 0);
    std::vector<Word> wide(rowSize_);
    for (Index z = 0; z < counts_[2]; ++z)
        for (Index y = 0; y < counts_[1]; ++y) {
            if (y % 16 == 0) checkCancelled();
            if (!findBorder(y, z, wide)) continue;
            Index width = 0;
            for (const BallRow& line : ball) {
                for (; width < line.reach; ++width) widen(wide);
                const Index toY = y + line.y, toZ = z + line.z;
                if (toY < 0 || toY >= counts_[1] || toZ < 0 || toZ >= counts_[2]) continue;
                const std::size_t to = Offset{toZ} * counts_[1] + toY;
                if (isFull[to] != 0) continue;
                const Row target = result.row(to);
                Word common = kAllBits;
                for (std::size_t i = 0; i < rowSize_; ++i) {
                    target[i] |= wide[i];
                    common &= i + 1 < rowSize_ ? target[i] : target[i] | ~lastBits_;
                }
                isFull[to] = common == kAllBits ? 1 : 0;
            }
        }
    for (std::size_t number = 0; number < rowCount(); ++number)
        result.row(number).back() &= lastBits_;
    return result;
}

VoxelSet VoxelSet::connectedWithFirst() const {
    VoxelSet result(counts_);
    if (!contains({0, 0, 0})) return result;
    result.words_[0] = 1;
    spread(result.row(0), row(0));
    std::vector<std::size_t> front = {0};
    std::vector<char> isInFront(rowCount(), 0);
    const std::size_t ny = counts_[1];
    for (std::size_t step = 0; !front.empty(); ++step) {
        checkCancelledEvery(step, 10);
        const std::size_t number = front.back();
        front.pop_back();
        isInFront[number] = 0;
        const auto visit = [&](bool exists, std::size_t next) {
            if (!exists) return;
            const auto source = result.row(number), target = result.row(next);
            const auto free = row(next);
            Word more = 0;
            for (std::size_t i = 0; i < rowSize_; ++i) {
                more |= source[i] & free[i] & ~target[i];
                target[i] |= source[i] & free[i];
            }
            if (more == 0) return;
            spread(target, free);
            if (isInFront[next] != 0) return;
            isInFront[next] = 1;
            front.push_back(next);
        };
        visit(number % ny > 0, number - 1);
        visit(number % ny + 1 < ny, number + 1);
        visit(number >= ny, number - ny);
        visit(number + ny < rowCount(), number + ny);
    }
    return result;
}

}  // namespace espalier::cages
