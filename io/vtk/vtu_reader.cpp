// SPDX-License-Identifier: Apache-2.0
#include <espalier/base/error.h>
#include <espalier/base/memory.h>
#include <espalier/io/files/file.h>
#include <espalier/io/vtk/vtu.h>

#include <algorithm>
#include <string>
#include <utility>

#include "../lattices/lattice_parts.h"
#include "vtk_cells.h"
#include "vtk_xml.h"

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
        VtkCellReader cells(file_.path(),
                            checkedIndex(file_.path(), lattice_.positions.size(), "points"));
        Index firstVertex = 0;
        for (const VtkPiece& piece : file_.pieces()) {
            const auto count = static_cast<Index>(file_.count(piece, "NumberOfPoints"));
            cells.beginPiece(firstVertex, count);
            readCells(piece, cells);
            firstVertex += count;
        }
        if (notes) notes->skippedCells = cells.skippedCells();
        readEdgeMarks(cells.maxEdges());
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
            static_cast<std::size_t>(attributes[number].components) != array.components)
            file_.fail(array.line, "the array " + inQuotes(array.name) +
                                       " is not in the PointData of the first piece");
    }

    template <class Value>
    static void append(std::vector<Value>& values, const std::vector<Value>& more) {
        values.insert(values.end(), more.begin(), more.end());
    }

    void readCells(const VtkPiece& piece, VtkCellReader& cells) {
        const std::size_t count = file_.count(piece, "NumberOfCells");
        if (count == 0) return;
        const VtkSection& section = file_.section(piece, "Cells");
        const auto types = file_.list(file_.array(section, "types"), count, kOneACell);
        const VtkRows vertices(file_, section, "connectivity", "offsets", count, kOneACell);
        const bool havePolyhedra =
            std::find(types.begin(), types.end(), kVtkPolyhedron) != types.end();
        const auto addStandard = [&](std::size_t cell) { cells.add(types[cell], vertices[cell]); };
        if (!havePolyhedra)
            for (std::size_t cell = 0; cell < count; ++cell) addStandard(cell);
        else if (section.find("polyhedron_offsets"))
            addWithFaceLists(section, types, addStandard, cells);
        else
            addWithFaceStreams(section, types, addStandard, cells);
    }

    /// Reads cells in the layout since VTK 9.4: faces are listed once, and polyhedra list faces.
    template <class AddStandard>
    void addWithFaceLists(const VtkSection& section, const std::vector<std::int64_t>& types,
                          AddStandard addStandard, VtkCellReader& cells) {
        const VtkRows faces(file_, section, "polyhedron_to_faces", "polyhedron_offsets",
                            types.size(), kOneACell);
        std::int64_t lastFace = -1;
        for (std::size_t cell = 0; cell < types.size(); ++cell)
            for (const std::int64_t face : faces[cell]) {
                if (face < 0)
                    file_.fail(section.line, concat("cell ", cell, " of the piece names face ",
                                                    face, "; expected 0 or more"));
                lastFace = std::max(lastFace, face);
            }
        const VtkRows loops(file_, section, "face_connectivity", "face_offsets",
                            sizeInMemory(static_cast<std::uint64_t>(lastFace) + 1),
                            concat("as the last face that a polyhedron names is ", lastFace));
        std::vector<std::span<const std::int64_t>> cellLoops;
        for (std::size_t cell = 0; cell < types.size(); ++cell) {
            if (types[cell] != kVtkPolyhedron) {
                addStandard(cell);
                continue;
            }
            cellLoops.clear();
            for (const std::int64_t face : faces[cell]) cellLoops.push_back(loops[face]);
            cells.addPolyhedron(cellLoops);
        }
    }

    /// Reads cells in the older layout: each polyhedron has a face stream; the offset of any other
    /// cell is −1.
    template <class AddStandard>
    void addWithFaceStreams(const VtkSection& section, const std::vector<std::int64_t>& types,
                            AddStandard addStandard, VtkCellReader& cells) {
        const VtkDataArray& offsets = file_.array(section, "faceoffsets");
        const auto ends = file_.list(offsets, types.size(), kOneACell);
        std::int64_t before = 0;
        for (std::size_t cell = 0; cell < types.size(); ++cell) {
            if (types[cell] != kVtkPolyhedron) continue;
            if (ends[cell] < before)
                file_.fail(offsets.line,
                           concat("the faces of cell ", cell, " of the piece run from ", before,
                                  " to ", ends[cell]));
            before = ends[cell];
        }
        const auto faces = file_.list(file_.array(section, "faces"),
                                      sizeInMemory(static_cast<std::uint64_t>(before)),
                                      "the last of 'faceoffsets'");
        std::size_t begin = 0;
        for (std::size_t cell = 0; cell < types.size(); ++cell) {
            if (types[cell] != kVtkPolyhedron) {
                addStandard(cell);
                continue;
            }
            const std::size_t end = ends[cell];
            cells.addPolyhedron(std::span(faces).subspan(begin, end - begin));
            begin = end;
        }
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
