// SPDX-License-Identifier: Apache-2.0
#include <espalier/base/error.h>
#include <espalier/io/files/file.h>
#include <espalier/io/files/text_reader.h>
#include <espalier/io/vtk/vtk_legacy.h>

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "../files/number_types.h"
#include "../lattices/lattice_parts.h"
#include "../meshes/lattice_cells.h"
#include "vtk_cells.h"
#include "vtk_legacy_data.h"
#include "vtk_xml.h"

namespace espalier::io {
namespace {

class LegacyReader {
public:
    LegacyReader(const std::filesystem::path& path, std::string_view bytes)
        : path_(path), data_(path, bytes) {}

    Lattice read(ReadNotes* notes) {
        if (data_.readHeader() == "polydata")
            throw far::TopologyError(
                far::TopologyCause::EmptyComplex, {3, 0},
                shownPath(path_) +
                    ": holds a surface (POLYDATA) without cells of a volume; a lattice needs an "
                    "UNSTRUCTURED_GRID");
        while (!text().atEnd()) readPart(data_.keyword("a keyword"));
        const Index count = checkedIndex(path_, lattice_.positions.size(), "points");
        LatticeCells cells(path_, count);
        VtkCellReader reader(path_, count, cells);
        addLegacyCells(path_, rows_, types_, reader);
        if (notes) notes->skippedCells = cells.skipped();
        lattice_.marks.vertices = vertexMarksFromFile(path_, vertexSharpness_);
        addEdgeMarks();
        return finishLattice(path_, cells.takeBuilder(), std::move(lattice_), notes);
    }

private:
    /// The owner of the arrays that follow.
    enum class Owner { DataSet, Points, Cells };

    TextReader& text() { return data_.text(); }

    void readPart(const std::string& keyword) {
        if (keyword == "metadata")
            data_.skipMetadata();
        else if (keyword == "points")
            readPoints();
        else if (keyword == "cells")
            rows_ = data_.rows("CELLS");
        else if (keyword == "cell_types")
            readCellTypes();
        else if (keyword == "point_data")
            beginData(Owner::Points, lattice_.positions.size(), "points");
        else if (keyword == "cell_data")
            beginData(Owner::Cells, rows_.count(), "cells");
        else if (keyword == "field")
            data_.readField([&](const auto&... array) { readArray(array...); });
        else if (owner_ != Owner::DataSet)
            readAttribute(keyword);
        else
            failAt(keyword);
    }

    void readPoints() {
        const std::size_t count = text().count("the number of points", 3);
        const std::string type = data_.keyword("the type of the points");
        lattice_.positions =
            pointsOf(data_.numbers<double>(type, saturatingProduct(3, count), "a coordinate"));
    }

    void readCellTypes() {
        const std::size_t count = text().count("the number of cell types", 1);
        types_ = data_.numbers<std::int64_t>("int", count, "a cell type");
    }

    void beginData(Owner owner, std::size_t expected, const char* what) {
        owner_ = owner;
        tupleCount_ = text().number<std::uint64_t>(what);
        if (tupleCount_ != expected)
            text().fail(
                concat("the data are for ", tupleCount_, " ", what, ", but there are ", expected));
    }

    void readAttribute(const std::string& keyword) {
        if (keyword == "scalars") {
            const std::string name = data_.name();
            const std::string type = data_.keyword("the type of SCALARS");
            const std::size_t components = optionalCount(1);
            data_.expect("LOOKUP_TABLE");
            text().token("the name of a lookup table");
            readArray(name, type, components, tupleCount_);
        } else if (keyword == "color_scalars") {
            data_.name();
            data_.skipColours(
                saturatingProduct(text().count("the number of values", 1), tupleCount_));
        } else if (keyword == "lookup_table") {
            data_.name();
            data_.skipColours(saturatingProduct(text().count("the number of colours", 1), 4));
        } else if (keyword == "texture_coordinates") {
            const std::string name = data_.name();
            const std::size_t components = text().count("the number of coordinates", 1);
            readArray(name, data_.keyword("a type"), components, tupleCount_);
        } else if (keyword == "global_ids" || keyword == "pedigree_ids" ||
                   keyword == "edge_flags") {
            data_.name();
            data_.values(data_.keyword("a type"), tupleCount_, "an id");
        } else {
            const std::size_t components = componentsOf(keyword);
            const std::string name = data_.name();
            readArray(name, data_.keyword("a type"), components, tupleCount_);
        }
    }

    std::size_t componentsOf(const std::string& keyword) {
        if (keyword == "vectors" || keyword == "normals") return 3;
        if (keyword == "tensors6") return 6;
        if (keyword == "tensors") return 9;
        failAt(keyword);
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

    /// Reads an array, and keeps it if it is an attribute or holds marks.
    void readArray(const std::string& name, const std::string& type, std::size_t components,
                   std::size_t tuples) {
        const std::size_t line = text().line();
        const std::optional<NumberType> number = numberOfLegacyName(type);
        if (owner_ == Owner::Points && number && isInteger(*number) && name != kVertexSharpness) {
            auto integers = data_.numbers<std::int64_t>(type, saturatingProduct(components, tuples),
                                                        "an integer");
            checkTuples(line, name, components, tuples);
            if (name != kVtkGhosts)
                lattice_.integers.push_back({name, checkedIndex(path_, components, "components"),
                                             integerTypeOf(*number), std::move(integers)});
            return;
        }
        auto values = data_.values(type, saturatingProduct(components, tuples), "a number");
        if (!values) return;
        if (owner_ == Owner::DataSet) {
            if (name == kEdgeVertices && components == 2)
                edgeVertices_ = std::move(*values);
            else if (name == kEdgeSharpness && components == 1)
                edgeSharpness_ = std::move(*values);
        } else if (owner_ == Owner::Points) {
            checkTuples(line, name, components, tuples);
            if (name == kVertexSharpness && components == 1)
                vertexSharpness_ = std::move(*values);
            else
                lattice_.attributes.push_back(
                    {name, checkedIndex(path_, components, "components"), std::move(*values)});
        }
    }

    void checkTuples(std::size_t line, const std::string& name, std::size_t components,
                     std::size_t tuples) {
        if (tuples != lattice_.positions.size() || components == 0)
            throw FileError(path_, line,
                            concat("the array ", inQuotes(name), " has ", tuples, " tuples of ",
                                   components, " for ", lattice_.positions.size(), " points"));
    }

    void addEdgeMarks() {
        if (edgeVertices_.size() != 2 * edgeSharpness_.size())
            throw FileError(path_, concat("has marks of ", edgeSharpness_.size(), " edges, and ",
                                          edgeVertices_.size(), " vertices of marked edges"));
        const auto markedVertex = [&](double vertex) {
            if (!(vertex >= 0 && vertex < static_cast<double>(lattice_.positions.size())))
                throw FileError(path_, concat("a mark names vertex ", formatNumber(vertex),
                                              "; there are ", lattice_.positions.size()));
            return static_cast<Index>(vertex);
        };
        for (std::size_t mark = 0; mark < edgeSharpness_.size(); ++mark)
            if (isMarkInFile(path_, kEdgeSharpness, mark, edgeSharpness_[mark]))
                lattice_.marks.edges.push_back({{markedVertex(edgeVertices_[2 * mark]),
                                                 markedVertex(edgeVertices_[2 * mark + 1])},
                                                sharpnessFromFile(edgeSharpness_[mark])});
    }

    [[noreturn]] void failAt(const std::string& keyword) {
        text().fail(inQuotes(keyword) + " is not a keyword that can stand here");
    }

    std::filesystem::path path_;
    LegacyData data_;
    Owner owner_ = Owner::DataSet;
    std::size_t tupleCount_ = 0;

    LegacyRows rows_;
    std::vector<std::int64_t> types_;
    std::vector<double> vertexSharpness_;
    std::vector<double> edgeVertices_;
    std::vector<double> edgeSharpness_;
    Lattice lattice_;  ///< the lattice without its complex
};

}  // namespace

Lattice readVtkLegacy(const std::filesystem::path& path, std::string_view bytes, ReadNotes* notes) {
    return LegacyReader(path, bytes).read(notes);
}

}  // namespace espalier::io
