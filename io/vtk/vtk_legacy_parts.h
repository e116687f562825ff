// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <espalier/base/error.h>
#include <espalier/io/files/text_reader.h>

#include <algorithm>
#include <array>
#include <cstddef>
#include <filesystem>
#include <string>
#include <string_view>
#include <utility>

#include "../files/number_types.h"
#include "../meshes/structured_grid.h"
#include "vtk_legacy_data.h"

namespace espalier::io {

/// The head of an array in a legacy VTK file. Its numbers follow.
struct LegacyArray {
    enum class Owner { DataSet, Points, Cells };

    Owner owner = Owner::DataSet;
    /// The meaning of its keyword; Numbers for all other keywords.
    enum class Kind { Numbers, Normals, TextureCoordinates, Colors } kind = Kind::Numbers;
    std::string name;
    std::string type;  ///< the type in lower case: "float"
    std::size_t components = 1;
    std::size_t tuples = 0;

    std::size_t size() const { return saturatingProduct(components, tuples); }
};

/// Returns the cells of a structured grid as those of an unstructured one: hexahedra; in one layer,
/// quadrilaterals; in one row, lines.
inline LegacyCells cellsOfGrid(const Extent& extent) {
    constexpr std::int64_t kQuadrilateral = 9, kHexahedron = 12;
    LegacyCells cells;
    const auto add = [&](std::int64_t type) {
        return [&cells, type](const auto& points) { cells.add(type, points); };
    };
    const auto isLong = [](std::size_t along) { return along > 1; };
    if (std::ranges::count_if(extent, isLong) > 1) {
        if (isVolume(extent))
            forEachHexahedron(extent, 0, add(kHexahedron));
        else
            forEachQuadrilateral(extent, 0, add(kQuadrilateral));
    } else {
        for (Index i = 0; i + 1 < static_cast<Index>(pointCountOf(extent)); ++i)
            cells.add(kVtkLine, std::array{i, i + 1});
    }
    return cells;
}

/// Goes through the parts of a legacy VTK file, in their order. Derived classes read or skip the
/// numbers of each part. Skips METADATA, ids, edge flags and lookup tables.
class LegacyParts {
public:
    LegacyParts(const LegacyParts&) = delete;
    LegacyParts& operator=(const LegacyParts&) = delete;

protected:
    /// \param text must outlive the reader
    LegacyParts(const std::filesystem::path& path, std::string_view text) : data_(path, text) {}
    ~LegacyParts() = default;

    /// Reads from the head of the file to its end.
    void readParts() {
        dataSet_ = data_.readHeader();
        beginDataSet(dataSet_);
        while (!data_.text().atEnd()) readPart(data_.keyword("a keyword"));
    }

    LegacyData& data() { return data_; }
    const LegacyData& data() const { return data_; }
    TextReader& text() { return data_.text(); }
    const TextReader& text() const { return data_.text(); }

private:
    /// \param dataSet "unstructured_grid", "structured_grid" or "polydata"
    virtual void beginDataSet(const std::string& dataSet) = 0;
    /// Reads the numbers of POINTS.
    virtual void readPoints(std::size_t count, const std::string& type) = 0;
    /// Reads the rows of CELLS, or of a section of POLYDATA: "polygons".
    virtual void readRows(const std::string& keyword) = 0;
    virtual void readCellTypes(std::size_t count) = 0;
    /// Called after the points of a structured grid.
    /// \param extent number of points along each axis
    virtual void beginGrid(const Extent&) {}
    /// Checks the number of tuples of POINT_DATA or CELL_DATA.
    virtual void beginData(LegacyArray::Owner owner, std::size_t tuples) = 0;
    /// Reads the numbers of an array.
    virtual void readArray(const LegacyArray& array) = 0;
    /// Called for ids and edge flags, whose numbers are skipped.
    virtual void skippedArray(const LegacyArray&) {}

    void readPart(const std::string& keyword) {
        const bool isGrid = dataSet_ == "unstructured_grid";
        if (keyword == "metadata") {
            data_.skipMetadata();
        } else if (keyword == "points") {
            const std::size_t count = text().count("the number of points", 3);
            readPoints(count, data_.keyword("the type of the points"));
            if (dataSet_ == "structured_grid") checkGrid(count);
        } else if (dataSet_ == "structured_grid" && keyword == "dimensions") {
            for (std::size_t& along : extent_)
                along = sizeInMemory(text().number<std::uint64_t>("a dimension"));
        } else if (isGrid ? keyword == "cells"
                          : dataSet_ == "polydata" &&
                                (keyword == "vertices" || keyword == "lines" ||
                                 keyword == "polygons" || keyword == "triangle_strips")) {
            readRows(keyword);
        } else if (isGrid && keyword == "cell_types") {
            readCellTypes(text().count("the number of cell types", 1));
        } else if (keyword == "point_data") {
            beginArrays(LegacyArray::Owner::Points, "points");
        } else if (keyword == "cell_data") {
            beginArrays(LegacyArray::Owner::Cells, "cells");
        } else if (keyword == "field") {
            data_.readField([&](const std::string& name, const std::string& type,
                                std::size_t components, std::size_t tuples) {
                readArray({owner_, LegacyArray::Kind::Numbers, name, type, components, tuples});
            });
        } else if (owner_ != LegacyArray::Owner::DataSet) {
            readAttribute(keyword);
        } else {
            failAt(keyword);
        }
    }

    /// Passes the extent of a structured grid to the reader.
    void checkGrid(std::size_t pointCount) {
        if (pointCountOf(extent_) != pointCount)
            text().fail(concat("there are ", pointCount, " points, but DIMENSIONS has ", extent_[0],
                               " × ", extent_[1], " × ", extent_[2]));
        if (pointCount > 0) beginGrid(extent_);
    }

    void beginArrays(LegacyArray::Owner owner, const char* what) {
        owner_ = owner;
        tupleCount_ = text().number<std::uint64_t>(what);
        beginData(owner, tupleCount_);
    }

    void readAttribute(const std::string& keyword) {
        constexpr std::pair<std::string_view, std::size_t> kComponents[] = {
            {"scalars", 1},    {"color_scalars", 1},       {"lookup_table", 4}, {"vectors", 3},
            {"normals", 3},    {"texture_coordinates", 1}, {"tensors", 9},      {"tensors6", 6},
            {"global_ids", 1}, {"edge_flags", 1},          {"pedigree_ids", 1}};
        const auto known = std::ranges::find(kComponents, keyword,
                                             &std::pair<std::string_view, std::size_t>::first);
        if (known == std::end(kComponents)) failAt(keyword);
        const LegacyArray::Kind kind = keyword == "normals" ? LegacyArray::Kind::Normals
                                       : keyword == "texture_coordinates"
                                           ? LegacyArray::Kind::TextureCoordinates
                                       : keyword == "color_scalars" ? LegacyArray::Kind::Colors
                                                                    : LegacyArray::Kind::Numbers;
        LegacyArray array{owner_, kind, data_.name(), "", known->second, tupleCount_};
        if (keyword.ends_with("_ids") || keyword == "edge_flags") skippedArray(array);
        if (kind == LegacyArray::Kind::Colors) {
            array.components = text().count("the number of values", 1);
            array.type = data_.typeOfColours();
            return readArray(array);
        }
        if (keyword == "lookup_table")
            return data_.skipValues(
                data_.typeOfColours(),
                saturatingProduct(text().count("the number of colours", 1), array.components),
                "a colour");
        if (keyword == "texture_coordinates")
            array.components = text().count("the number of coordinates", 1);
        array.type = data_.keyword("a type");
        if (keyword == "scalars") {
            array.components = optionalCount(1);
            data_.expect("LOOKUP_TABLE");
            text().token("the name of a lookup table");
        }
        if (keyword.ends_with("_ids") || keyword == "edge_flags")
            return data_.skipValues(array.type, tupleCount_, "an id");
        readArray(array);
    }

    /// Reads a number from the rest of the line; returns `otherwise` if the line is empty.
    std::size_t optionalCount(std::size_t otherwise) {
        std::string_view rest = text().restOfLine();
        const std::string_view word = takeWord(rest);
        std::size_t count = otherwise;
        if (!word.empty() && (!parseNumber(word, count) || count == 0))
            text().fail(inQuotes(word) + " is not a number of components");
        return count;
    }

    [[noreturn]] void failAt(const std::string& keyword) const {
        data_.text().fail(inQuotes(keyword) + " is not a keyword that can stand here");
    }

    LegacyData data_;
    std::string dataSet_;
    Extent extent_ = {};  ///< of a structured grid; 0 before DIMENSIONS
    LegacyArray::Owner owner_ = LegacyArray::Owner::DataSet;
    std::size_t tupleCount_ = 0;
};

}  // namespace espalier::io
