// SPDX-License-Identifier: Apache-2.0
#include <espalier/base/error.h>
#include <espalier/io/files/file.h>
#include <espalier/io/vtk/vtu.h>

#include <ostream>

#include "../lattices/lattice_parts.h"
#include "vtk_cells.h"
#include "vtk_xml.h"

namespace espalier::io {
namespace {

/// Writes the elements of a .vtu file, each on separate lines.
class VtuWriter {
public:
    VtuWriter(std::ostream& out, VtuEncoding encoding)
        : out_(out),
          form_(encoding == VtuEncoding::Ascii ? VtkArrayForm::Ascii : VtkArrayForm::Base64) {
        coding_.isCompressed = encoding == VtuEncoding::Compressed;
    }

    void write(const Lattice& lattice, const far::Marks& marks) {
        out_ << "<?xml version=\"1.0\"?>\n"
                "<VTKFile type=\"UnstructuredGrid\" version=\"1.0\" byte_order=\"LittleEndian\" "
                "header_type=\"UInt64\""
             << (coding_.isCompressed ? " compressor=\"vtkZLibDataCompressor\"" : "")
             << ">\n  <UnstructuredGrid>\n";
        writeEdgeMarks(marks);
        out_ << "    <Piece NumberOfPoints=\"" << lattice.positions.size() << "\" NumberOfCells=\""
             << lattice.complex.count(3) << "\">\n";
        writePointData(lattice, marks);
        section("Points", [&] { array("Points", 3, coordinatesOf(lattice.positions)); });
        writeCells(vtkCells(lattice.complex));
        out_ << "    </Piece>\n  </UnstructuredGrid>\n</VTKFile>\n";
    }

private:
    template <class Content>
    void section(const char* name, Content content) {
        out_ << "      <" << name << ">\n";
        content();
        out_ << "      </" << name << ">\n";
    }

    void array(const std::string& name, std::size_t components, const std::vector<double>& values) {
        element({name, NumberType::Float64, components}, values);
    }

    void array(const std::string& name, const std::vector<std::int64_t>& values,
               NumberType type = NumberType::Int64) {
        element({name, type}, values);
    }

    template <class Value>
    void element(const VtkArrayHead& head, const std::vector<Value>& values) {
        constexpr const char* kIndent = "        ";
        out_ << kIndent << dataArrayElement<Value>(head, values, form_, coding_, kIndent) << "\n";
    }

    void writeEdgeMarks(const far::Marks& marks) {
        if (marks.edges.empty()) return;
        std::vector<std::int64_t> vertices;
        std::vector<double> sharpness;
        for (const auto& mark : marks.edges) {
            vertices.insert(vertices.end(), mark.vertices.begin(), mark.vertices.end());
            sharpness.push_back(sharpnessToFile(mark.sharpness));
        }
        section("FieldData", [&] {
            element({kEdgeVertices, NumberType::Int64, 2, true}, vertices);
            element({kEdgeSharpness, NumberType::Float64, 1, true}, sharpness);
        });
    }

    void writePointData(const Lattice& lattice, const far::Marks& marks) {
        section("PointData", [&] {
            for (const VertexAttribute& attribute : lattice.attributes)
                array(attribute.name, attribute.components, attribute.values);
            for (const VertexIntegers& integers : lattice.integers)
                element({integers.name, numberOf(integers.type),
                         static_cast<std::size_t>(integers.components)},
                        integers.values);
            if (!marks.vertices.empty())
                array(kVertexSharpness, 1, vertexSharpnessForFile(lattice.complex, marks));
        });
    }

    void writeCells(const VtkCells& cells) {
        section("Cells", [&] {
            array("connectivity", cells.connectivity);
            array("offsets", cells.offsets);
            array("types", cells.types, NumberType::UInt8);
            if (cells.havePolyhedra()) {
                array("faces", cells.faces);
                array("faceoffsets", cells.faceOffsets);
            }
        });
    }

    std::ostream& out_;
    VtkArrayForm form_;
    VtkCoding coding_;
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
