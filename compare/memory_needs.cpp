// SPDX-License-Identifier: Apache-2.0
#include <espalier/base/memory.h>
#include <espalier/stencils/composition.h>

#include <algorithm>
#include <cstdint>
#include <optional>
#include <string>

#include "memory_needs.h"

namespace espalier::compare {
namespace {

std::string levelsTo(int level) {
    return level == 1 ? "level 1" : concat("levels 1 to ", level);
}

}  // namespace

void requireForLevels(std::size_t cornerCount, int maxLevel) {
    // A face, with its share of two edges and one vertex, takes 177 bytes in the arrays of
    // OpenSubdiv's levels and 36 in the links from parents to children (214 measured, 131,000
    // faces).
    constexpr std::uint64_t kFaceBytes = 200;
    std::uint64_t faceCount = 0, ofLevel = cornerCount;
    for (int level = 1; level <= maxLevel; ++level, ofLevel *= 4) faceCount += ofLevel;
    requireMemory(kFaceBytes * faceCount, "OpenSubdiv's topology of " + levelsTo(maxLevel));
}

void requireForMatch(const far::TopologyRefiner& refiner, int level) {
    const far::CellComplex& complex = refiner.level(level).complex;
    std::uint64_t bytes = 0;
    for (int d = 0; d <= 2; ++d)
        bytes += sizeof(std::optional<Index>) * static_cast<std::uint64_t>(complex.count(d));
    // Face → vertices: offsets, values, and the values once more while they are gathered.
    const std::uint64_t offsets = sizeof(Offset) * static_cast<std::uint64_t>(complex.count(2));
    const auto valuesOf = [&](int dimension) {
        return sizeof(Index) * complex.boundary(dimension).unsignedRows().values().size();
    };
    bytes += offsets + 2 * valuesOf(2);
    // Face → cells: offsets and values, held meanwhile.
    if (complex.dimension() == 3) bytes += offsets + valuesOf(3);
    requireMemory(bytes, concat("matching level ", level, " with OpenSubdiv's"));
}

void requireForTable(const far::TopologyRefiner& refiner, std::span<const Surface> regions) {
    const int maxLevel = static_cast<int>(regions.size()) - 1;
    // Rows have no fewer entries on later levels: a new point has those of all points that it is a
    // mean of. After two levels they are nearly as long as they become.
    int countedLevels = 0;
    double entryCount = 0, rowLength = 0;
    for (int level = 1; level <= maxLevel; ++level) {
        const std::vector<Index>& vertices = regions[level].vertices;
        if (vertices.empty()) continue;
        const auto rowCount = static_cast<double>(vertices.size());
        if (++countedLevels <= 2)
            rowLength =
                static_cast<double>(
                    stencils::buildStencils(refiner, level, stencils::Rules::Siggraph96, vertices)
                        .entryCount()) /
                rowCount;
        entryCount += rowLength * rowCount;
    }
    // OpenSubdiv's factory gathers a source, a destination and a weight for each entry, and copies
    // them to a table of sources and weights (29 bytes an entry measured, 4 million entries).
    constexpr std::uint64_t kEntryBytes = 2 * (sizeof(int) + sizeof(double)) + sizeof(int);
    requireMemory(kEntryBytes * static_cast<std::uint64_t>(entryCount),
                  "OpenSubdiv's stencil table of " + levelsTo(maxLevel));
}

void requireForComparison(int level, Offset entryCount) {
    // OpenSubdiv's rows over our columns in double precision, while those over theirs are there;
    // then, in their place, each table for the evaluators, in single precision, and its copy.
    constexpr std::uint64_t kEntryBytes =
        sizeof(Index) + sizeof(double) +
        std::max(sizeof(Index) + sizeof(double), 2 * (sizeof(int) + sizeof(float)));
    requireMemory(kEntryBytes * static_cast<std::uint64_t>(entryCount),
                  concat("comparing the stencil tables of level ", level));
}

}  // namespace espalier::compare
