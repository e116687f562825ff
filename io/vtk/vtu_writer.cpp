// SPDX-License-Identifier: Apache-2.0
#include <espalier/base/error.h>
#include <espalier/io/files/file.h>
#include <espalier/io/vtk/vtu.h>

#include <ostream>

#include "../lattices/lattice_parts.h"
#include "vtk_cells.h"
#include "vtk_xml_output.h"

namespace espalier::io {
namespace {

class VtuWriter {
public:
    VtuWriter(std::ostream& out, VtuEncoding encoding)
        : out_(out, "UnstructuredGrid",
               encoding == VtuEncoding::Ascii ? VtkArrayForm::Ascii : VtkArrayForm::Base64,
               encoding == VtuEncoding::Compressed) {}

    void write(const Lattice& lattice, const far::Marks& marks) {
        out_.file([&] {
            writeEdgeMarks(marks);
            out_.piece(lattice.positions.size(), "Cells", lattice.complex.count(3), [&] {
                writePointData(lattice, marks);
                out_.section("Points",
                             [&] { out_.array("Points", 3, coordinatesOf(lattice.positions)); });
                writeCells(vtkCells(lattice.complex));
            });
        });
    }

private:
    void writeEdgeMarks(const far::Marks& marks) {
        if (marks.edges.empty()) return;
        std::vector<std::int64_t> vertices;
        std::vector<double> sharpness;
        for (const auto& mark : marks.edges) {
            vertices.insert(vertices.end(), mark.vertices.begin(), mark.vertices.end());
            sharpness.push_back(sharpnessToFile(mark.sharpness));
        }
        out_.section("FieldData", [&] {
            out_.array({kEdgeVertices, NumberType::Int64, 2, true}, vertices);
            out_.array({kEdgeSharpness, NumberType::Float64, 1, true}, sharpness);
        });
    }

    void writePointData(const Lattice& lattice, const far::Marks& marks) {
        out_.section("PointData", [&] {
            for (const VertexAttribute& attribute : lattice.attributes)
                out_.array(attribute.name, attribute.components, attribute.values);
            for (const VertexIntegers& integers : lattice.integers)
                out_.array({integers.name, numberOf(integers.type),
                            static_cast<std::size_t>(integers.components)},
                           integers.values);
            if (!marks.vertices.empty())
                out_.array(kVertexSharpness, 1, vertexSharpnessForFile(lattice.complex, marks));
        });
    }

    void writeCells(const VtkCells& cells) {
        out_.section("Cells", [&] {
            out_.array("connectivity", cells.connectivity);
            out_.array("offsets", cells.offsets);
            out_.array("types", cells.types);
            if (cells.havePolyhedra()) {
                out_.array("faces", cells.faces);
                out_.array("faceoffsets", cells.faceOffsets);
            }
        });
    }

    VtkXmlOutput out_;
};

}  // namespace

void writeVtu(const std::filesystem::path& path, const Lattice& lattice, VtuEncoding encoding) {
    const far::Marks marks = checkedForWriting(path, lattice);
    for (const VertexAttribute& attribute : lattice.attributes)
        if (!isXmlText(attribute.name))
            throw FileError(path, "cannot be written: the attribute " + inQuotes(attribute.name) +
                                      " has a name that XML cannot hold; expected UTF-8 without "
                                      "control characters. Rename the attribute");
    writeFile(path, [&](std::ostream& out) { VtuWriter(out, encoding).write(lattice, marks); });
}

}  // namespace espalier::io
