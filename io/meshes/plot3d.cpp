// SPDX-License-Identifier: Apache-2.0
#include <espalier/base/error.h>
#include <espalier/base/progress.h>
#include <espalier/far/complex_builder.h>
#include <espalier/io/files/file.h>
#include <espalier/io/files/text_reader.h>
#include <espalier/shapes/merge.h>

#include <algorithm>
#include <cstdint>
#include <optional>
#include <utility>

#include "../files/bytes.h"
#include "../files/number_types.h"
#include "../lattices/lattice_parts.h"
#include "../vtk/vtk_xml.h"
#include "mesh_format.h"
#include "structured_grid.h"

// Reads grids of PLOT3D (.xyz, .p3d, .fmt, .g, .x, .grd, .ufmt): text, Fortran's unformatted
// records, or plain binary. A grid has one block or several, two or three dimensions, single or
// double precision, either byte order, and may have iblank. The file does not state these
// properties; its length tells them.
//
// The points are those of all blocks, block after block, i fastest. Coordinates that blocks share
// are points of each of them.
//
// A grid of two dimensions has no z, so new positions must have z = 0. Blocks of more than one
// layer are cells; blocks of one layer are faces, and no lattice has them. A lattice welds points
// of different blocks that coincide, as shapes::merge() does. A text with repeat counts (3*0.0) is
// refused, since they cannot be replaced in place.

namespace espalier::io {
namespace {

/// The properties of a file that are not written in it.
struct Variant {
    bool hasBlockCount;     ///< the file begins with the number of blocks
    std::size_t dimension;  ///< 2 or 3
    bool hasBlank;          ///< an integer per point follows the coordinates of a block
};

constexpr Variant kVariants[] = {{true, 3, false},  {true, 3, true},  {false, 3, false},
                                 {false, 3, true},  {true, 2, false}, {true, 2, true},
                                 {false, 2, false}, {false, 2, true}};

/// A grid: its blocks, and its numbers.
struct Grid {
    std::vector<Extent> blocks;
    FileNumbers numbers;
};

/// Reads numbers of a text, between spaces or commas.
class Plot3dText {
public:
    Plot3dText(const std::filesystem::path& path, std::string_view bytes)
        : path_(path), bytes_(bytes) {}

    Grid read() {
        numbers_ = countNumbers();
        for (const Variant& variant : kVariants)
            if (const auto blocks = blocksOf(variant)) {
                position_ = headerEnd_;
                return gridOf(variant, *blocks);
            }
        throw FileError(path_, concat("is not a PLOT3D grid: its ", numbers_,
                                      " numbers are not those of a grid with the extents at its "
                                      "beginning, of one block or several"));
    }

private:
    static bool isSeparator(char c) { return static_cast<unsigned char>(c) <= ' ' || c == ','; }

    /// Returns the next word; empty at the end.
    std::string_view word() {
        checkCancelledEvery(words_++, 12);
        while (position_ < bytes_.size() && isSeparator(bytes_[position_])) {
            if (bytes_[position_] == '\n') ++line_;
            ++position_;
        }
        const std::size_t begin = position_;
        while (position_ < bytes_.size() && !isSeparator(bytes_[position_])) ++position_;
        return bytes_.substr(begin, position_ - begin);
    }

    std::size_t countNumbers() {
        std::size_t count = 0;
        position_ = 0;
        line_ = 1;
        while (true) {
            const std::string_view number = word();
            if (number.empty()) return count;
            if (number.find('*') != std::string_view::npos)
                throw FileError(path_, line_,
                                inQuotes(number) +
                                    " is a repeat count of Fortran, which cannot be replaced in "
                                    "place; write each number");
            ++count;
        }
    }

    std::optional<std::size_t> whole() {
        std::uint64_t number = 0;
        return parseNumber(word(), number) && number > 0 && number <= bytes_.size()
                   ? std::optional<std::size_t>(number)
                   : std::nullopt;
    }

    /// Returns the blocks if the file has the numbers of this variant, and sets headerEnd_.
    std::optional<std::vector<Extent>> blocksOf(const Variant& variant) {
        position_ = 0;
        line_ = 1;
        const auto blockCount = variant.hasBlockCount ? whole() : std::optional<std::size_t>(1);
        if (!blockCount || *blockCount > numbers_) return std::nullopt;
        std::vector<Extent> blocks;
        std::size_t expected = (variant.hasBlockCount ? 1 : 0) + variant.dimension * *blockCount;
        for (std::size_t block = 0; block < *blockCount; ++block) {
            Extent extent = {1, 1, 1};
            for (std::size_t axis = 0; axis < variant.dimension; ++axis) {
                const auto size = whole();
                if (!size) return std::nullopt;
                extent[axis] = *size;
            }
            const std::size_t perPoint = variant.dimension + (variant.hasBlank ? 1 : 0);
            const std::size_t inBlock = saturatingProduct(pointCountOf(extent), perPoint);
            if (inBlock > numbers_) return std::nullopt;
            expected += inBlock;
            blocks.push_back(extent);
        }
        headerEnd_ = position_;
        return expected == numbers_ ? std::optional(blocks) : std::nullopt;
    }

    Grid gridOf(const Variant& variant, const std::vector<Extent>& blocks) {
        Grid grid{blocks, {}};
        FileNumbers& numbers = grid.numbers;
        numbers.dimension = variant.dimension;
        for (const Extent& extent : blocks) {
            const std::size_t first = numbers.points.values.size(), count = pointCountOf(extent);
            numbers.points.values.resize(first + count, {0, 0, 0});
            numbers.points.offsets.resize(first + count);
            for (std::size_t axis = 0; axis < variant.dimension; ++axis)
                for (std::size_t i = first; i < first + count; ++i) {
                    const std::string_view number = word();
                    numbers.points.offsets[i][axis] = number.data() - bytes_.data();
                    numbers.points.values[i][axis] = parseCoordinate(
                        withExponent(number), axis, Precision::Double, path_, line_);
                }
            for (std::size_t i = 0; variant.hasBlank && i < count; ++i) word();
        }
        return grid;
    }

    /// Returns a number of Fortran, 1.5D+00, as C++ reads it.
    std::string withExponent(std::string_view number) const {
        std::string text(number);
        std::replace(text.begin(), text.end(), 'D', 'e');
        std::replace(text.begin(), text.end(), 'd', 'e');
        return text;
    }

    const std::filesystem::path& path_;
    std::string_view bytes_;
    std::size_t numbers_ = 0;
    std::size_t position_ = 0, line_ = 1;
    std::size_t words_ = 0;      ///< number of words read, for checkCancelledEvery()
    std::size_t headerEnd_ = 0;  ///< the end of the header in the variant that was tried last
};

/// Reads Fortran's unformatted records, or the same data without the lengths of records.
class Plot3dBinary {
public:
    Plot3dBinary(const std::filesystem::path& path, std::string_view bytes)
        : path_(path), bytes_(bytes) {}

    Grid read() {
        for (const std::endian order : {std::endian::little, std::endian::big})
            for (const bool hasMarkers : {true, false})
                for (const Variant& variant : kVariants)
                    for (const Precision precision : {Precision::Double, Precision::Float}) {
                        order_ = order;
                        hasMarkers_ = hasMarkers;
                        if (const auto grid = tryRead(variant, precision)) return *grid;
                    }
        throw FileError(path_, concat("is not a PLOT3D grid: its ", bytes_.size(),
                                      " bytes are not those of a grid with the extents at its "
                                      "beginning, of one block or several"));
    }

private:
    std::optional<std::size_t> whole() {
        if (bytes_.size() - position_ < sizeof(std::int32_t)) return std::nullopt;
        const auto number = loadNumber<std::int32_t>(bytes_.data() + position_, order_);
        position_ += sizeof number;
        return number > 0 ? std::optional<std::size_t>(number) : std::nullopt;
    }

    /// Reads the length before or after a record. Returns false if it is another one.
    bool marker(std::size_t length) { return !hasMarkers_ || whole() == length; }

    std::optional<Grid> tryRead(const Variant& variant, Precision precision) {
        position_ = 0;
        std::size_t blockCount = 1;
        if (variant.hasBlockCount) {
            if (!marker(sizeof(std::int32_t))) return std::nullopt;
            const auto count = whole();
            if (!count || !marker(sizeof(std::int32_t)) || *count > bytes_.size())
                return std::nullopt;
            blockCount = *count;
        }
        const std::size_t headerBytes = blockCount * variant.dimension * sizeof(std::int32_t);
        Grid grid;
        if (headerBytes > bytes_.size() || !marker(headerBytes)) return std::nullopt;
        const std::size_t width = precision == Precision::Float ? sizeof(float) : sizeof(double);
        const std::size_t perPoint =
            variant.dimension * width + (variant.hasBlank ? sizeof(std::int32_t) : 0);
        std::size_t expected = hasMarkers_ ? sizeof(std::int32_t) : 0;
        for (std::size_t block = 0; block < blockCount; ++block) {
            Extent extent = {1, 1, 1};
            for (std::size_t axis = 0; axis < variant.dimension; ++axis) {
                const auto size = whole();
                if (!size) return std::nullopt;
                extent[axis] = *size;
            }
            const std::size_t inBlock = saturatingProduct(pointCountOf(extent), perPoint);
            if (inBlock > bytes_.size()) return std::nullopt;
            expected += inBlock + (hasMarkers_ ? 2 * sizeof(std::int32_t) : 0);
            grid.blocks.push_back(extent);
        }
        if (bytes_.size() - position_ != expected || !marker(headerBytes)) return std::nullopt;

        FileNumbers& numbers = grid.numbers;
        numbers.dimension = variant.dimension;
        numbers.setBinary(order_, precision);
        for (const Extent& extent : grid.blocks) {
            const std::size_t first = numbers.points.values.size(), count = pointCountOf(extent);
            if (!marker(count * perPoint)) return std::nullopt;
            numbers.points.values.resize(first + count, {0, 0, 0});
            numbers.points.offsets.resize(first + count);
            for (std::size_t axis = 0; axis < variant.dimension; ++axis)
                for (std::size_t i = first; i < first + count; ++i) {
                    numbers.points.offsets[i][axis] = position_;
                    position_ += width;
                }
            if (variant.hasBlank) position_ += count * sizeof(std::int32_t);
            if (!marker(count * perPoint)) return std::nullopt;
        }
        for (std::size_t i = 0; i < numbers.points.offsets.size(); ++i) {
            checkCancelledEvery(i, 14);
            for (std::size_t axis = 0; axis < variant.dimension; ++axis)
                numbers.points.values[i][axis] =
                    loadReal(bytes_, numbers.points.offsets[i][axis], precision, order_);
        }
        return grid;
    }

    const std::filesystem::path& path_;
    std::string_view bytes_;
    std::endian order_ = std::endian::native;
    bool hasMarkers_ = false;
    std::size_t position_ = 0;
};

Grid readGrid(const std::filesystem::path& path, std::string_view bytes) {
    // A binary grid begins with an integer below 2²⁴ and so has a zero byte among its first four.
    const bool isBinary = bytes.substr(0, 4).find('\0') != std::string_view::npos;
    return isBinary ? Plot3dBinary(path, bytes).read() : Plot3dText(path, bytes).read();
}

constexpr MeshFormat kPlot3dMesh = {
    [](const std::filesystem::path& path, std::string_view bytes) {
        return readGrid(path, bytes).numbers;
    },
    [](const std::filesystem::path& path, std::string_view bytes, Index, CellVisitor& visitor) {
        const Grid grid = readGrid(path, bytes);
        std::size_t first = 0;
        for (const Extent& extent : grid.blocks) {
            if (isVolume(extent))
                forEachHexahedron(extent, first, [&](const auto& points) {
                    visitor.cell(far::StandardCell::Hexahedron, points);
                });
            else
                forEachQuadrilateral(extent, first,
                                     [&](const auto& points) { visitor.face(points); });
            first += pointCountOf(extent);
        }
    }};

Lattice readPlot3d(const std::filesystem::path& path, std::string_view bytes, ReadNotes*) {
    const Grid grid = readGrid(path, bytes);
    checkedIndex(path, grid.numbers.points.values.size(), "points");
    checkFinite(path, grid.numbers.points.values);
    std::vector<Lattice> blocks;
    shapes::MergeOptions options;
    std::size_t first = 0;
    for (const Extent& extent : grid.blocks) {
        if (!isVolume(extent))
            throw FileError(path, concat("block ", blocks.size(), " has ", extent[0], " × ",
                                         extent[1], " × ", extent[2],
                                         " points; a block of a lattice has at least 2 along each "
                                         "axis"));
        const std::size_t count = pointCountOf(extent);
        far::ComplexBuilder builder(3, static_cast<Index>(count));
        forEachHexahedron(extent, 0, [&](const auto& points) {
            builder.addCell(far::StandardCell::Hexahedron, points);
        });
        Lattice block;
        block.complex = builder.build();
        const auto begin = grid.numbers.points.values.begin() + static_cast<std::ptrdiff_t>(first);
        block.positions.assign(begin, begin + static_cast<std::ptrdiff_t>(count));
        options.names.push_back(concat("block ", blocks.size()));
        blocks.push_back(std::move(block));
        first += count;
    }
    return withPathInErrors(path, [&] { return shapes::merge(blocks, options); });
}

}  // namespace

const Format kPlot3dFormat = {.extensions = {".xyz", ".p3d", ".fmt", ".g", ".x", ".grd", ".ufmt"},
                              .isMesh = true,
                              .readModel = readMeshModel<kPlot3dMesh>,
                              .readLattice = readPlot3d};

}  // namespace espalier::io
