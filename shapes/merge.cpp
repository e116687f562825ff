// SPDX-License-Identifier: Apache-2.0
#include <espalier/far/complex_builder.h>
#include <espalier/far/error.h>
#include <espalier/shapes/cell_loops.h>
#include <espalier/shapes/checks.h>
#include <espalier/shapes/merge.h>
#include <espalier/shapes/weld.h>

#include <algorithm>
#include <map>
#include <string>
#include <utility>

namespace espalier::shapes {
namespace {

using far::Index;

std::string latticeName(std::size_t number) {
    return "lattice " + std::to_string(number);
}

// In what follows an Attribute is a VertexAttribute or VertexIntegers.

template <class Attribute>
const Attribute* findAttribute(const std::vector<Attribute>& attributes, const std::string& name) {
    for (const Attribute& attribute : attributes)
        if (attribute.name == name) return &attribute;
    return nullptr;
}

std::string kindOf(const VertexAttribute&) {
    return "attribute ";
}

std::string kindOf(const VertexIntegers& integers) {
    return std::string("attribute of ") + integerTypeName(integers.type) + " ";
}

bool isSameType(const VertexAttribute&, const VertexAttribute&) {
    return true;
}

bool isSameType(const VertexIntegers& a, const VertexIntegers& b) {
    return a.type == b.type;
}

template <class Attribute>
void requireAttribute(const Attribute& wanted, std::size_t owner,
                      const std::vector<Attribute>& attributes, std::size_t number) {
    const Attribute* found = findAttribute(attributes, wanted.name);
    if (found == nullptr || !isSameType(*found, wanted))
        throw Error("merge: " + latticeName(number) + " lacks " + kindOf(wanted) +
                    inQuotes(wanted.name) + ", which " + latticeName(owner) + " has");
    if (found->components != wanted.components)
        throw Error("merge: attribute " + inQuotes(wanted.name) + " has " +
                    std::to_string(found->components) + " components in " + latticeName(number) +
                    ", but " + std::to_string(wanted.components) + " in " + latticeName(owner));
}

/// That the first lattice and another one have the same attributes.
template <class Attribute>
void requireSame(const std::vector<Attribute>& ofFirst, const std::vector<Attribute>& others,
                 std::size_t number) {
    for (const Attribute& attribute : ofFirst) requireAttribute(attribute, 0, others, number);
    for (const Attribute& attribute : others) requireAttribute(attribute, number, ofFirst, 0);
}

/// The same attributes without values.
template <class Attribute>
std::vector<Attribute> withoutValues(std::vector<Attribute> attributes) {
    for (Attribute& attribute : attributes) attribute.values.clear();
    return attributes;
}

void check(std::span<const Lattice> lattices, const MergeOptions& options) {
    if (lattices.empty()) throw Error("merge: there is no lattice; expected 1 or more");
    if (!(options.tolerance >= 0 && options.tolerance < 1))
        refuseField("merge", "tolerance", textOf(options.tolerance),
                    "numbers from 0 to below 1, a fraction of the whole size");
    for (std::size_t number = 0; number < lattices.size(); ++number) {
        requireConsistent("merge", latticeName(number), lattices[number],
                          lattices[0].complex.dimension());
        requireSame(lattices[0].attributes, lattices[number].attributes, number);
        requireSame(lattices[0].integers, lattices[number].integers, number);
    }
}

/// That no cell loses a vertex.
void requireCellsKept(const far::CellComplex& complex, std::span<const Index> newVertex,
                      const std::string& name, double distance) {
    const int dimension = complex.dimension();
    std::vector<std::pair<Index, Index>> welded;  // new vertex, old vertex
    for (Index cell = 0; cell < complex.count(dimension); ++cell) {
        welded.clear();
        for (const Index vertex : complex.relation(dimension, 0)[cell])
            welded.emplace_back(newVertex[static_cast<std::size_t>(vertex)], vertex);
        std::sort(welded.begin(), welded.end());
        const auto twice =
            std::adjacent_find(welded.begin(), welded.end(),
                               [](const auto& a, const auto& b) { return a.first == b.first; });
        if (twice == welded.end()) continue;
        throw far::TopologyError(far::TopologyCause::RepeatedVertex, {dimension, cell},
                                 "merge: vertices " + std::to_string(twice->second) + " and " +
                                     std::to_string((twice + 1)->second) + " of " +
                                     far::dimensionName(dimension) + " " + std::to_string(cell) +
                                     " of " + name +
                                     " would become one; they are within the distance of " +
                                     textOf(distance) + " that the tolerance allows");
    }
}

void appendMarks(const far::Marks& from, std::span<const Index> newVertex, far::Marks& to) {
    const auto renamed = [&](Index vertex) { return newVertex[static_cast<std::size_t>(vertex)]; };
    for (const far::Marks::Edge& mark : from.edges)
        to.edges.push_back(
            {{renamed(mark.vertices[0]), renamed(mark.vertices[1])}, mark.sharpness});
    for (const far::Marks::Vertex& mark : from.vertices)
        to.vertices.push_back({renamed(mark.vertex), mark.sharpness});
}

/// Writes the values of vertices that first appear in `from`: those numbered `firstNew` and above.
template <class Attribute>
void appendValues(const Attribute& from, std::span<const Index> newVertex, Attribute& to) {
    const auto components = static_cast<std::size_t>(to.components);
    for (std::size_t vertex = 0; vertex < newVertex.size(); ++vertex) {
        // Numbers are given in the order of appearance, so a new vertex is the next one.
        if (static_cast<std::size_t>(newVertex[vertex]) * components != to.values.size()) continue;
        const auto first = from.values.begin() + static_cast<std::ptrdiff_t>(vertex * components);
        to.values.insert(to.values.end(), first, first + to.components);
    }
}

/// The faces of the lattices that become one face of more than two cells: "face 1 of lattice 0,
/// face 4 of lattice 1". Empty if there is none.
std::string crowdedFace(std::span<const Lattice> lattices, std::span<const Index> newIndex) {
    struct Faces {
        std::size_t cellCount = 0;
        std::string names;
    };
    std::map<std::vector<Index>, Faces> merged;  // by the new vertices, ascending
    for (std::size_t number = 0; number < lattices.size(); ++number) {
        const far::CellComplex& complex = lattices[number].complex;
        const auto newVertex = newIndex.first(lattices[number].positions.size());
        newIndex = newIndex.subspan(newVertex.size());
        for (Index face = 0; face < complex.count(2); ++face) {
            std::vector<Index> vertices;
            for (const Index vertex : complex.relation(2, 0)[face])
                vertices.push_back(newVertex[static_cast<std::size_t>(vertex)]);
            std::sort(vertices.begin(), vertices.end());
            Faces& faces = merged[std::move(vertices)];
            faces.cellCount += complex.relation(2, 3)[face].size();
            faces.names += (faces.names.empty() ? "face " : ", face ") + std::to_string(face) +
                           " of " + latticeName(number);
            if (faces.cellCount > 2) return faces.names;
        }
    }
    return {};
}

/// Builds the merged complex. Errors name faces of the lattices, not of the result.
far::CellComplex buildMerged(const far::ComplexBuilder& builder, std::span<const Lattice> lattices,
                             std::span<const Index> newIndex) {
    try {
        return builder.build();
    } catch (const far::TopologyError& error) {
        if (error.cause() != far::TopologyCause::CrowdedFace) throw;
        const std::string names = crowdedFace(lattices, newIndex);
        if (names.empty()) throw;
        throw far::TopologyError(
            error.cause(), error.entity(),
            "merge: " + names + " would become one face of more than two cells");
    }
}

}  // namespace

Lattice merge(std::span<const Lattice> lattices, const MergeOptions& options) {
    check(lattices, options);
    std::vector<Point3> points;
    for (const Lattice& lattice : lattices)
        points.insert(points.end(), lattice.positions.begin(), lattice.positions.end());
    requireCountable("merge", {static_cast<far::Offset>(points.size())});
    const double distance = options.tolerance * diagonal(points);
    Welding welding = weld(points, distance);

    Lattice result;
    result.attributes = withoutValues(lattices[0].attributes);
    result.integers = withoutValues(lattices[0].integers);
    far::ComplexBuilder builder(lattices[0].complex.dimension(),
                                static_cast<Index>(welding.positions.size()));
    std::span<const Index> remaining = welding.newIndex;
    for (std::size_t number = 0; number < lattices.size(); ++number) {
        const Lattice& lattice = lattices[number];
        const auto newVertex = remaining.first(lattice.positions.size());
        remaining = remaining.subspan(lattice.positions.size());
        requireCellsKept(lattice.complex, newVertex, latticeName(number), distance);
        addAll(lattice.complex, newVertex, builder);
        appendMarks(lattice.marks, newVertex, result.marks);
        for (VertexAttribute& attribute : result.attributes)
            appendValues(*findAttribute(lattice.attributes, attribute.name), newVertex, attribute);
        for (VertexIntegers& integers : result.integers)
            appendValues(*findAttribute(lattice.integers, integers.name), newVertex, integers);
    }
    result.complex = buildMerged(builder, lattices, welding.newIndex);
    result.positions = std::move(welding.positions);
    return result;
}

Lattice merge(const Lattice& first, const Lattice& second, const MergeOptions& options) {
    const Lattice lattices[] = {first, second};
    return merge(lattices, options);
}

}  // namespace espalier::shapes
