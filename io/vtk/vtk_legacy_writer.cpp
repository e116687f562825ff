// SPDX-License-Identifier: Apache-2.0
#include <espalier/base/progress.h>
#include <espalier/io/files/file.h>
#include <espalier/io/vtk/vtk_legacy.h>

#include <span>
#include <string>
#include <vector>

#include "../files/text_output.h"
#include "../lattices/lattice_parts.h"
#include "vtk_cells.h"
#include "vtk_xml.h"

namespace espalier::io {
namespace {

/// Returns a name as one word. Characters that could end the word become "%20" and the like.
std::string encodedName(const std::string& name) {
    constexpr std::string_view kDigits = "0123456789ABCDEF";
    std::string result;
    for (const char c : name) {
        const auto code = static_cast<unsigned char>(c);
        if (code <= 0x20 || code >= 0x7f || c == '%' || c == '"') {
            result += '%';
            result += kDigits[code >> 4];
            result += kDigits[code & 15];
        } else {
            result += c;
        }
    }
    return result;
}

class LegacyWriter {
public:
    explicit LegacyWriter(std::ostream& out) : out_(out) {}

    void write(const Lattice& lattice, const far::Marks& marks) {
        out_.put(
            "# vtk DataFile Version 3.0\nEspalier lattice\nASCII\nDATASET UNSTRUCTURED_GRID\n");
        writeEdgeMarks(marks);
        out_.put("POINTS ", lattice.positions.size(), " double\n");
        out_.rows(coordinatesOf(lattice.positions), 3);
        writeCells(vtkCells(lattice.complex));
        writePointData(lattice, marks);
    }

private:
    void beginField(std::size_t arrayCount) { out_.put("FIELD FieldData ", arrayCount, "\n"); }

    template <class Value>
    void array(const std::string& name, std::size_t components, const char* type,
               const std::vector<Value>& values) {
        out_.put(encodedName(name), " ", components, " ", values.size() / components, " ", type,
                 "\n");
        out_.rows(values, components);
    }

    void writeEdgeMarks(const far::Marks& marks) {
        if (marks.edges.empty()) return;
        std::vector<Index> vertices;
        std::vector<double> sharpness;
        for (const auto& mark : marks.edges) {
            vertices.insert(vertices.end(), mark.vertices.begin(), mark.vertices.end());
            sharpness.push_back(sharpnessToFile(mark.sharpness));
        }
        beginField(2);
        array(kEdgeVertices, 2, "int", vertices);
        array(kEdgeSharpness, 1, "double", sharpness);
    }

    void writePointData(const Lattice& lattice, const far::Marks& marks) {
        const std::size_t arrayCount =
            lattice.attributes.size() + lattice.integers.size() + (marks.vertices.empty() ? 0 : 1);
        if (arrayCount == 0) return;
        out_.put("POINT_DATA ", lattice.positions.size(), "\n");
        beginField(arrayCount);
        for (const VertexAttribute& attribute : lattice.attributes)
            array(attribute.name, attribute.components, "double", attribute.values);
        for (const VertexIntegers& integers : lattice.integers) writeIntegers(integers);
        if (!marks.vertices.empty())
            array(kVertexSharpness, 1, "double", vertexSharpnessForFile(lattice.complex, marks));
    }

    void writeIntegers(const VertexIntegers& integers) {
        const std::size_t components = integers.components;
        const char* const type = legacyName(numberOf(integers.type));
        if (integers.type == IntegerType::UInt64)
            array(integers.name, components, type,
                  std::vector<std::uint64_t>(integers.values.begin(), integers.values.end()));
        else
            array(integers.name, components, type, integers.values);
    }

    /// Writes one line per cell. A polyhedron is written as its face stream.
    void writeCells(const VtkCells& cells) {
        std::vector<std::span<const Index>> lines;
        std::size_t numberCount = 0;
        std::size_t vertex = 0;
        std::size_t face = 0;
        for (std::size_t cell = 0; cell < cells.types.size(); ++cell) {
            checkCancelledEvery(cell, 14);
            const auto take = [](const std::vector<Index>& list, std::size_t& begin,
                                 std::int64_t endOffset) {
                const std::size_t end = endOffset;
                const auto row = std::span(list).subspan(begin, end - begin);
                begin = end;
                return row;
            };
            auto line = take(cells.connectivity, vertex, cells.offsets[cell]);
            if (cells.types[cell] == kVtkPolyhedron)
                line = take(cells.faces, face, cells.faceOffsets[cell]);
            numberCount += line.size() + 1;
            lines.push_back(line);
        }
        out_.put("CELLS ", lines.size(), " ", numberCount, "\n");
        for (const auto line : lines) {
            out_.put(line.size());
            for (const Index number : line) {
                out_.put(" ", number);
            }
            out_.put("\n");
        }
        out_.put("CELL_TYPES ", lines.size(), "\n");
        out_.rows(cells.types, 1);
    }

    TextOutput out_;
};

}  // namespace

void writeVtkLegacy(const std::filesystem::path& path, const Lattice& lattice) {
    const far::Marks marks = checkedForWriting(path, lattice);
    writeFile(path, [&](std::ostream& out) { LegacyWriter(out).write(lattice, marks); });
}

}  // namespace espalier::io
