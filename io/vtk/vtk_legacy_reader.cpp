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
#include "vtk_legacy_parts.h"
#include "vtk_xml.h"

namespace espalier::io {
namespace {

class LegacyReader final : public LegacyParts {
public:
    LegacyReader(const std::filesystem::path& path, std::string_view bytes)
        : LegacyParts(path, bytes), path_(path) {}

    Lattice read(ReadNotes* notes) {
        readParts();
        const Index count = checkedIndex(path_, lattice_.positions.size(), "points");
        LatticeCells cells(path_, count);
        VtkCellReader reader(path_, count, cells);
        addLegacyCells(path_, cells_, reader);
        if (notes) notes->skippedCells = cells.skipped();
        lattice_.marks.vertices = vertexMarksFromFile(path_, vertexSharpness_);
        addEdgeMarks();
        return finishLattice(path_, cells.takeBuilder(), std::move(lattice_), notes);
    }

private:
    using Owner = LegacyArray::Owner;

    void beginDataSet(const std::string& dataSet) override {
        if (dataSet == "polydata")
            throw far::TopologyError(
                far::TopologyCause::EmptyComplex, {3, 0},
                shownPath(path_) +
                    ": holds a surface (POLYDATA) without cells of a volume; a lattice needs an "
                    "UNSTRUCTURED_GRID or a STRUCTURED_GRID");
    }

    void readPoints(std::size_t count, const std::string& type) override {
        lattice_.positions =
            pointsOf(data().numbers<double>(type, saturatingProduct(3, count), "a coordinate"));
    }

    void beginGrid(const Extent& extent) override { cells_ = cellsOfGrid(extent); }

    void readRows(const std::string&) override { cells_.rows = data().rows("CELLS"); }

    void readCellTypes(std::size_t count) override {
        cells_.types = data().numbers<std::int64_t>("int", count, "a cell type");
    }

    void beginData(Owner owner, std::size_t tuples) override {
        const bool isOfPoints = owner == Owner::Points;
        const std::size_t expected = isOfPoints ? lattice_.positions.size() : cells_.rows.count();
        if (tuples != expected)
            text().fail(concat("the data are for ", tuples, isOfPoints ? " points" : " cells",
                               ", but there are ", expected));
    }

    /// Reads an array, and keeps it if it is an attribute or holds marks.
    void readArray(const LegacyArray& array) override {
        const std::size_t line = text().line();
        const std::optional<NumberType> number = numberOfLegacyName(array.type);
        if (array.owner == Owner::Cells || array.kind == LegacyArray::Kind::Colors)
            return data().skipValues(array.type, array.size(), "a number");
        if (array.owner == Owner::Points && number && isInteger(*number) &&
            array.name != kVertexSharpness) {
            auto integers = data().numbers<std::int64_t>(array.type, array.size(), "an integer");
            checkTuples(line, array);
            if (array.name != kVtkGhosts)
                lattice_.integers.push_back({array.name,
                                             checkedIndex(path_, array.components, "components"),
                                             integerTypeOf(*number), std::move(integers)});
            return;
        }
        auto values = data().values(array.type, array.size(), "a number");
        if (!values) return;
        if (array.owner == Owner::DataSet) {
            if (array.name == kEdgeVertices && array.components == 2)
                edgeVertices_ = std::move(*values);
            else if (array.name == kEdgeSharpness && array.components == 1)
                edgeSharpness_ = std::move(*values);
            return;
        }
        checkTuples(line, array);
        if (array.name == kVertexSharpness && array.components == 1)
            vertexSharpness_ = std::move(*values);
        else
            lattice_.attributes.push_back({array.name,
                                           checkedIndex(path_, array.components, "components"),
                                           std::move(*values)});
    }

    void checkTuples(std::size_t line, const LegacyArray& array) {
        if (array.tuples != lattice_.positions.size() || array.components == 0)
            throw FileError(
                path_, line,
                concat("the array ", inQuotes(array.name), " has ", array.tuples, " tuples of ",
                       array.components, " for ", lattice_.positions.size(), " points"));
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

    std::filesystem::path path_;
    LegacyCells cells_;
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
