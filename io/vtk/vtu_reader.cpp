// SPDX-License-Identifier: Apache-2.0
#include <espalier/base/error.h>
#include <espalier/io/files/file.h>
#include <espalier/io/vtk/vtu.h>

#include <algorithm>
#include <string>
#include <utility>

#include "../lattices/lattice_parts.h"
#include "../meshes/lattice_cells.h"
#include "vtk_cells.h"
#include "vtk_xml.h"
#include "vtu_cells.h"

namespace espalier::io {
namespace {

class VtuReader {
public:
    VtuReader(const std::filesystem::path& path, std::string bytes)
        : file_(VtkXmlFile::read(path, std::move(bytes), "UnstructuredGrid")) {}

    Lattice read(ReadNotes* notes) {
        for (const VtkPiece& piece : file_.pieces()) {
            const std::vector<Point3> points = readPoints(file_, piece);
            lattice_.positions.insert(lattice_.positions.end(), points.begin(), points.end());
            readPointData(piece);
        }
        const Index count = checkedIndex(file_.path(), lattice_.positions.size(), "points");
        LatticeCells cells(file_.path(), count);
        VtkCellReader reader(file_.path(), count, cells);
        readVtuCells(file_, reader);
        if (notes) notes->skippedCells = cells.skipped();
        readEdgeMarks(reader.maxEdges());
        lattice_.marks.vertices = vertexMarksFromFile(file_.path(), vertexSharpness_);
        return finishLattice(file_.path(), cells.takeBuilder(), std::move(lattice_), notes);
    }

private:
    /// Appends the attributes of a piece to the attributes of earlier pieces, which must have the
    /// same arrays.
    void readPointData(const VtkPiece& piece) {
        const std::size_t count = file_.count(piece, "NumberOfPoints");
        if (count == 0) return;
        const auto at = piece.sections.find("PointData");
        std::size_t attributeCount = 0;
        std::size_t integersCount = 0;
        bool hasSharpness = false;
        if (at != piece.sections.end())
            for (const VtkDataArray& array : at->second.arrays) {
                if (!array.type || array.name == kVtkGhosts) continue;
                if (array.name == kVertexSharpness && array.components == 1) {
                    hasSharpness = true;
                    append(vertexSharpness_, file_.reals(array, count));
                } else if (isInteger(*array.type)) {
                    append(integersOf(array, integersCount++).values, file_.integers(array, count));
                } else {
                    append(attributeOf(array, attributeCount++).values, file_.reals(array, count));
                }
            }
        if (!hasSharpness) vertexSharpness_.resize(lattice_.positions.size(), kUnmarkedInFile);
        const std::size_t known = attributeCount + integersCount;
        const std::size_t expected = lattice_.attributes.size() + lattice_.integers.size();
        if (known != expected)
            file_.fail(piece.line, concat("the piece has ", known,
                                          " arrays of PointData; the first one has ", expected));
        isFirstPiece_ = false;
    }

    VertexAttribute& attributeOf(const VtkDataArray& array, std::size_t number) {
        if (isFirstPiece_) {
            const auto components = checkedIndex(file_.path(), array.components, "components");
            lattice_.attributes.push_back({array.name, components, {}});
        }
        requireSame(lattice_.attributes, array, number);
        return lattice_.attributes[number];
    }

    VertexIntegers& integersOf(const VtkDataArray& array, std::size_t number) {
        const IntegerType type = integerTypeOf(*array.type);
        if (isFirstPiece_) {
            const auto components = checkedIndex(file_.path(), array.components, "components");
            lattice_.integers.push_back({array.name, components, type, {}});
        }
        requireSame(lattice_.integers, array, number);
        if (lattice_.integers[number].type != type)
            file_.fail(array.line, "the array " + inQuotes(array.name) + " holds " +
                                       xmlName(*array.type) + "; in the first piece it holds " +
                                       integerTypeName(lattice_.integers[number].type));
        return lattice_.integers[number];
    }

    /// Throws unless array `number` of the first piece has the same name and components.
    template <class Attribute>
    void requireSame(const std::vector<Attribute>& attributes, const VtkDataArray& array,
                     std::size_t number) {
        if (number >= attributes.size() || attributes[number].name != array.name ||
            std::cmp_not_equal(attributes[number].components, array.components))
            file_.fail(array.line, "the array " + inQuotes(array.name) +
                                       " is not in the PointData of the first piece");
    }

    template <class Value>
    static void append(std::vector<Value>& values, const std::vector<Value>& more) {
        values.insert(values.end(), more.begin(), more.end());
    }

    /// \param maxEdges an upper bound of the number of edges that can be marked
    void readEdgeMarks(std::size_t maxEdges) {
        const VtkDataArray* ends = file_.fieldData().find(kEdgeVertices);
        const VtkDataArray* sharpness = file_.fieldData().find(kEdgeSharpness);
        if (!ends && !sharpness) return;
        if (!ends || !sharpness || ends->components != 2 || sharpness->components != 1)
            file_.fail(file_.fieldData().line, std::string("marks need both arrays, ") +
                                                   kEdgeVertices + " of 2 components and " +
                                                   kEdgeSharpness + " of 1");
        const auto vertices =
            file_.integersUpTo(*ends, maxEdges, "as the cells have no more edges");
        const auto values = file_.reals(*sharpness, vertices.size() / 2,
                                        "one an edge of " + inQuotes(kEdgeVertices));
        for (std::size_t mark = 0; mark < values.size(); ++mark) {
            if (!isMarkInFile(file_.path(), kEdgeSharpness, mark, values[mark])) continue;
            lattice_.marks.edges.push_back({{markedVertex(*ends, vertices[2 * mark]),
                                             markedVertex(*ends, vertices[2 * mark + 1])},
                                            sharpnessFromFile(values[mark])});
        }
    }

    Index markedVertex(const VtkDataArray& array, std::int64_t vertex) {
        if (vertex < 0 || static_cast<std::uint64_t>(vertex) >= lattice_.positions.size())
            file_.fail(array.line, concat("a mark names vertex ", vertex, "; there are ",
                                          lattice_.positions.size()));
        return static_cast<Index>(vertex);
    }

    VtkXmlFile file_;
    std::vector<double> vertexSharpness_;
    Lattice lattice_;  ///< the lattice without its complex
    bool isFirstPiece_ = true;
};

}  // namespace

Lattice readVtu(const std::filesystem::path& path, std::string_view bytes, ReadNotes* notes) {
    return VtuReader(path, std::string(bytes)).read(notes);
}

}  // namespace espalier::io
