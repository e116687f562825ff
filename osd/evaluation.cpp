// SPDX-License-Identifier: Apache-2.0
#include <espalier/base/error.h>
#include <espalier/osd/evaluation.h>

#include <cstdint>
#include <limits>
#include <string>

namespace espalier::osd {
namespace {

/// Returns true if a buffer of `size` numbers holds all entries. Uses subtraction and division,
/// since sums and products could overflow, and 64 bits also where size_t has 32. An offset beyond
/// the buffer is rejected even if there are no entries, because evaluators add it to the address.
bool holds(const BufferDescriptor& layout, std::uint64_t size, Offset entries) {
    const std::uint64_t offset = layout.offset;
    const std::uint64_t length = layout.length;
    if (offset > size) return false;
    if (entries == 0) return true;
    if (length > size - offset) return false;
    return (size - offset - length) / static_cast<std::uint64_t>(layout.stride) >=
           static_cast<std::uint64_t>(entries - 1);
}

// Builds the message only when it throws, so that a valid evaluation allocates nothing here.
void checkLayout(const BufferDescriptor& layout, std::size_t size, Offset entries,
                 const char* name) {
    const auto refuse = [&](const std::string& what) {
        throw Error(std::string("the ") + name + " buffer " + what);
    };
    if (layout.offset < 0 || layout.length < 1 || layout.stride < layout.length)
        refuse(concat("has offset ", layout.offset, ", length ", layout.length, " and stride ",
                      layout.stride, "; expected offset ≥ 0 and stride ≥ length ≥ 1"));
    checkLength(layout.length);
    if (!holds(layout, size, entries))
        refuse(concat("holds ", size, " numbers: too few for ", entries, " entries at offset ",
                      layout.offset, " and stride ", layout.stride));
}

}  // namespace

void checkLength(Offset length) {
    constexpr Offset kMaxLength = std::numeric_limits<Index>::max();
    if (length < 1 || length > kMaxLength)
        throw Error(
            concat("an entry cannot have ", length, " components; expected 1 to ", kMaxLength));
}

void checkEvaluation(Index rowCount, Index columnCount, std::size_t sourceSize,
                     const BufferDescriptor& sourceLayout, std::size_t destinationSize,
                     const BufferDescriptor& destinationLayout, RowRange rows) {
    if (rows.first < 0 || rows.last < rows.first || rows.last > rowCount)
        throw Error(concat("rows ", rows.first, " to ", rows.last, " are not in a table of ",
                           rowCount, " rows"));
    checkLayout(sourceLayout, sourceSize, columnCount, "source");
    checkLayout(destinationLayout, destinationSize, rows.last, "destination");
    if (sourceLayout.length != destinationLayout.length)
        throw Error(concat("source entries have ", sourceLayout.length,
                           " components, destination entries ", destinationLayout.length));
}

void checkAddend(std::size_t size, const BufferDescriptor& layout,
                 const BufferDescriptor& destinationLayout, RowRange rows) {
    if (layout.length == 0) return;
    checkLayout(layout, size, rows.last, "addend");
    if (destinationLayout.length % layout.length != 0)
        throw Error(concat("destination entries have ", destinationLayout.length,
                           " components; expected a multiple of the ", layout.length,
                           " of the addend"));
}

}  // namespace espalier::osd
