// SPDX-License-Identifier: Apache-2.0
#include <espalier/base/error.h>
#include <espalier/far/topology_error.h>
#include <espalier/io/files/file.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <string>
#include <utility>

#include "../files/number_types.h"
#include "../vtk/vtk_xml.h"
#include "lattice_parts.h"

namespace espalier::io {

double sharpnessToFile(double sharpness) {
    return std::min(sharpness, far::kLeastInfinite);
}

double sharpnessFromFile(double value) {
    return value >= far::kLeastInfinite ? far::kInfinitelySharp : value;
}

bool isMarkInFile(const std::filesystem::path& path, const char* array, std::size_t place,
                  double value) {
    if (std::isnan(value))
        throw FileError(path, concat("value ", place, " of ", inQuotes(array),
                                     ", counted from 0, is NaN; expected a sharpness of 0 or more, "
                                     "or -1 for no mark"));
    return value >= 0;
}

bool isEdge(const far::CellComplex& complex, Index a, Index b) {
    const auto edges = complex.relation(0, 1)[a];
    return a != b && std::any_of(edges.begin(), edges.end(), [&](Index edge) {
               return far::contains(complex.relation(1, 0)[edge], b);
           });
}

far::Marks canonicalMarks(const far::CellComplex& complex, const far::Marks& marks) {
    far::readMarks(complex, marks);  // Throws if the marks are not valid.
    std::map<std::array<Index, 2>, double> edges;
    for (const auto& mark : marks.edges) {
        const auto [a, b] = mark.vertices;
        edges[{std::min(a, b), std::max(a, b)}] = mark.sharpness;
    }
    std::map<Index, double> vertices;
    for (const auto& mark : marks.vertices) vertices[mark.vertex] = mark.sharpness;
    far::Marks result;
    for (const auto& [ends, sharpness] : edges) result.edges.push_back({ends, sharpness});
    for (const auto& [vertex, sharpness] : vertices) result.vertices.push_back({vertex, sharpness});
    result.holes = far::readHoles(complex, marks);
    return result;
}

std::vector<double> vertexSharpnessForFile(const far::CellComplex& complex,
                                           const far::Marks& marks) {
    std::vector<double> sharpness(complex.count(0), kUnmarkedInFile);
    for (const auto& mark : marks.vertices)
        sharpness[mark.vertex] = sharpnessToFile(mark.sharpness);
    return sharpness;
}

std::vector<far::Marks::Vertex> vertexMarksFromFile(const std::filesystem::path& path,
                                                    const std::vector<double>& sharpness) {
    std::vector<far::Marks::Vertex> marks;
    for (std::size_t vertex = 0; vertex < sharpness.size(); ++vertex)
        if (isMarkInFile(path, kVertexSharpness, vertex, sharpness[vertex]))
            marks.push_back({static_cast<Index>(vertex), sharpnessFromFile(sharpness[vertex])});
    return marks;
}

Index checkedIndex(const std::filesystem::path& path, std::size_t count, const char* what) {
    if (std::cmp_greater(count, kMaxIndex))
        throw FileError(path, concat("has ", count, " ", what, "; the most is ", kMaxIndex));
    return static_cast<Index>(count);
}

std::optional<Index> numberWithout(std::span<const Index> dropped, Index vertex) {
    const auto at = std::lower_bound(dropped.begin(), dropped.end(), vertex);
    if (at != dropped.end() && *at == vertex) return std::nullopt;
    return vertex - static_cast<Index>(at - dropped.begin());
}

namespace {

/// Returns the marks with the vertex numbers that remain after the `dropped` vertices are removed,
/// and without the marks of dropped vertices.
/// \throws TopologyError naming, by the numbers of the file, a marked edge that the complex does
///         not have
far::Marks marksWithout(std::span<const Index> dropped, const far::CellComplex& complex,
                        const far::Marks& marks) {
    far::Marks result;
    for (const far::Marks::Edge& mark : marks.edges) {
        const auto a = numberWithout(dropped, mark.vertices[0]);
        const auto b = numberWithout(dropped, mark.vertices[1]);
        if (!a || !b || !isEdge(complex, *a, *b))
            throw far::TopologyError(far::TopologyCause::BadMark, {0, mark.vertices[0]},
                                     concat("a mark names edge (", mark.vertices[0], ", ",
                                            mark.vertices[1], "), which does not exist"));
        result.edges.push_back({{*a, *b}, mark.sharpness});
    }
    for (const far::Marks::Vertex& mark : marks.vertices)
        if (const auto vertex = numberWithout(dropped, mark.vertex))
            result.vertices.push_back({*vertex, mark.sharpness});
    return result;
}

}  // namespace

Lattice finishLattice(const std::filesystem::path& path, far::ComplexBuilder builder, Lattice parts,
                      ReadNotes* notes) {
    const std::vector<Index> dropped = builder.dropUnusedVertices();
    // Positions of dropped vertices need not be finite.
    for (const Index vertex : dropped) parts.positions[vertex] = {};
    checkFinite(path, parts.positions);
    for (const VertexAttribute& attribute : parts.attributes)
        if (attribute.name.starts_with(kReservedNames))
            throw FileError(
                path,
                concat("the attribute ", inQuotes(attribute.name), " has ", attribute.components,
                       " components and is not a known mark; names that begin with ",
                       inQuotes(kReservedNames), " are reserved for marks: rename the attribute"));
    parts.complex = withPathAndDroppedInErrors(path, dropped, [&] { return builder.build(); });
    parts.marks = withPathInErrors(path, [&] {
        return canonicalMarks(parts.complex, marksWithout(dropped, parts.complex, parts.marks));
    });
    eraseVertices(dropped, 1, parts.positions);
    for (VertexAttribute& attribute : parts.attributes)
        eraseVertices(dropped, attribute.components, attribute.values);
    for (VertexIntegers& integers : parts.integers)
        eraseVertices(dropped, integers.components, integers.values);
    if (notes) notes->droppedVertices = dropped;
    return parts;
}

far::Marks checkedForWriting(const std::filesystem::path& path, const Lattice& lattice,
                             int dimension) {
    if (lattice.complex.dimension() != dimension)
        throw FileError(path, concat("cannot be written: the lattice is of dimension ",
                                     lattice.complex.dimension(), ", not ", dimension));
    const std::size_t vertexCount = lattice.complex.count(0);
    if (lattice.positions.size() != vertexCount)
        throw FileError(path, concat("cannot be written: the lattice has ", vertexCount,
                                     " vertices and ", lattice.positions.size(), " positions"));
    checkFinite(path, lattice.positions);
    const auto checkAttribute = [&](const auto& attribute) {
        if (attribute.name.empty())
            throw FileError(path, "cannot be written: an attribute has no name");
        if (attribute.name.starts_with(kReservedNames))
            throw FileError(path,
                            "cannot be written: the attribute " + inQuotes(attribute.name) +
                                " has a name that is reserved for marks: rename the attribute");
        const std::size_t components = std::max(attribute.components, 0);
        if (components == 0 || attribute.values.size() != components * vertexCount)
            throw FileError(
                path, concat("cannot be written: the attribute ", inQuotes(attribute.name), " has ",
                             attribute.values.size(), " values for ", vertexCount, " vertices of ",
                             attribute.components, " components"));
    };
    for (const VertexAttribute& attribute : lattice.attributes) checkAttribute(attribute);
    for (const VertexIntegers& integers : lattice.integers) {
        checkAttribute(integers);
        for (const std::int64_t value : integers.values)
            if (!canHold(numberOf(integers.type), value))
                throw FileError(path,
                                concat("cannot be written: the attribute ", inQuotes(integers.name),
                                       " has ", value, ", which is out of the range of ",
                                       integerTypeName(integers.type)));
    }
    return withPathInErrors(path, [&] { return canonicalMarks(lattice.complex, lattice.marks); });
}

}  // namespace espalier::io
