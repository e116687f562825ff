// SPDX-License-Identifier: Apache-2.0
#include <espalier/base/error.h>
#include <espalier/io/files/file.h>
#include <espalier/io/lattices/ovm.h>

#include <cstdint>
#include <string>
#include <vector>

#include "../files/text_output.h"
#include "../format.h"
#include "../vtk/vtk_xml.h"
#include "lattice_parts.h"

namespace espalier::io {

namespace {

/// Returns the property type for integers. Types of one byte get a wider type, because
/// OpenVolumeMesh writes them as characters; UInt16 gets one, because OpenVolumeMesh has no such
/// type.
const char* propertyType(IntegerType type) {
    switch (type) {
        case IntegerType::UInt32:
            return "uint";
        case IntegerType::Int64:
            return "long";
        case IntegerType::UInt64:
            return "ulong";
        case IntegerType::Int8:
        case IntegerType::UInt8:
        case IntegerType::Int16:
            return "short";
        default:
            return "int";
    }
}

class OvmWriter {
public:
    explicit OvmWriter(std::ostream& out) : out_(out) {}

    void write(const Lattice& lattice, const far::Marks& marks) {
        const far::CellComplex& complex = lattice.complex;
        out_.put("OVM ASCII\n");
        beginSection("Vertices", complex.count(0));
        out_.rows(coordinatesOf(lattice.positions), 3);
        beginSection("Edges", complex.count(1));
        for (Index edge = 0; edge < complex.count(1); ++edge) {
            const auto ends = complex.relation(1, 0)[edge];
            out_.rows(std::vector<Index>(ends.begin(), ends.end()), 2);
        }
        // Odd numbers are reversed edges and faces. In a face, an edge of sign −1 is reversed. In a
        // polyhedron, a face of sign +1 is, because signs refer to the view from outside, and
        // half-faces to the view from inside.
        beginSection("Faces", complex.count(2));
        writeHalves(complex.boundary(2), -1);
        beginSection("Polyhedra", complex.count(3));
        writeHalves(complex.boundary(3), +1);
        for (const VertexAttribute& attribute : lattice.attributes) writeAttribute(attribute);
        for (const VertexIntegers& integers : lattice.integers) writeIntegers(integers);
        writeMarks(complex, marks);
    }

private:
    void beginSection(const char* name, Index count) { out_.put(name, "\n", count, "\n"); }

    void writeHalves(const far::SignedIncidence& boundary, int oddSign) {
        for (Index row = 0; row < boundary.unsignedRows().rowCount(); ++row) {
            const auto parts = boundary[row];
            const auto signs = boundary.signs(row);
            out_.put(parts.size());
            for (std::size_t i = 0; i < parts.size(); ++i) {
                out_.put(" ", 2 * std::int64_t{parts[i]} + (signs[i] == oddSign ? 1 : 0));
            }
            out_.put("\n");
        }
    }

    void writeAttribute(const VertexAttribute& attribute) {
        const std::size_t components = attribute.components;
        const bool isVector = components > 4;
        const std::string type = components == 1 ? "double"
                                 : isVector      ? "vector_double"
                                                 : concat("vec", components, "d");
        out_.put("VProp ", type, " \"", attribute.name, "\"\n");
        if (!isVector) {
            out_.rows(attribute.values, components);
            return;
        }
        // A vector is written as its length and its values, each on its own line.
        for (std::size_t i = 0; i < attribute.values.size(); ++i) {
            if (i % components == 0) out_.put(components, "\n");
            out_.put(attribute.values[i], "\n");
        }
    }

    /// \param integers of one component
    void writeIntegers(const VertexIntegers& integers) {
        out_.put("VProp ", propertyType(integers.type), " \"", integers.name, "\"\n");
        if (integers.type == IntegerType::UInt64)
            out_.rows(std::vector<std::uint64_t>(integers.values.begin(), integers.values.end()),
                      1);
        else
            out_.rows(integers.values, 1);
    }

    void writeMarks(const far::CellComplex& complex, const far::Marks& marks) {
        if (!marks.vertices.empty())
            writeAttribute({kVertexSharpness, 1, vertexSharpnessForFile(complex, marks)});
        if (marks.edges.empty()) return;
        out_.put("EProp double \"", kEdgeSharpness, "\"\n");
        out_.rows(edgeSharpness(complex, marks), 1);
    }

    static std::vector<double> edgeSharpness(const far::CellComplex& complex,
                                             const far::Marks& marks) {
        std::vector<double> sharpness(complex.count(1), kUnmarkedInFile);
        for (const auto& mark : marks.edges)
            for (const Index edge : complex.relation(0, 1)[mark.vertices[0]])
                if (far::contains(complex.relation(1, 0)[edge], mark.vertices[1]))
                    sharpness[edge] = sharpnessToFile(mark.sharpness);
        return sharpness;
    }

    TextOutput out_;
};

}  // namespace

void writeOvm(const std::filesystem::path& path, const Lattice& lattice) {
    const far::Marks marks = checkedForWriting(path, lattice);
    const auto checkName = [&](const std::string& name) {
        if (name.find_first_of("\r\n") != std::string::npos)
            throw FileError(path, "cannot be written: the name of the attribute " + inQuotes(name) +
                                      " has more than one line");
    };
    for (const VertexAttribute& attribute : lattice.attributes) checkName(attribute.name);
    for (const VertexIntegers& integers : lattice.integers) {
        checkName(integers.name);
        if (integers.components > 1)
            throw FileError(path, concat("cannot be written: the attribute ",
                                         inQuotes(integers.name), " has ", integers.components,
                                         " integers for each vertex, for which .ovm has no type; "
                                         "expected .vtu or .vtk"));
    }
    writeFile(path, [&](std::ostream& out) { OvmWriter(out).write(lattice, marks); });
}

const Format kOvmFormat = {
    .extensions = {".ovm"},
    .readLattice = readOvm,
    .writeLattice = [](const std::filesystem::path& path, const Lattice& lattice,
                       const WriteLatticeOptions&) { writeOvm(path, lattice); }};

}  // namespace espalier::io
