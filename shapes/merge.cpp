// SPDX-License-Identifier: Apache-2.0
#include <espalier/base/bounding_box.h>
#include <espalier/base/error.h>
#include <espalier/base/progress.h>
#include <espalier/far/complex_builder.h>
#include <espalier/far/topology_error.h>
#include <espalier/shapes/merge.h>

#include <algorithm>
#include <map>
#include <string>
#include <string_view>
#include <utility>

#include "cell_loops.h"
#include "checks.h"
#include "weld.h"

namespace espalier::shapes {
namespace {

std::string latticeName(const MergeOptions& options, std::size_t number) {
    return options.names.empty() ? concat("lattice ", number) : options.names[number];
}

// In the templates below, Attribute is VertexAttribute or VertexIntegers.

/// Attributes by their names.
template <class Attribute>
using ByName = std::map<std::string_view, const Attribute*>;

template <class Attribute>
ByName<Attribute> byName(const std::vector<Attribute>& attributes) {
    ByName<Attribute> result;
    for (const Attribute& attribute : attributes) result.emplace(attribute.name, &attribute);
    return result;
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
void requireAttribute(const Attribute& wanted, const std::string& owner,
                      const ByName<Attribute>& attributes, const std::string& name) {
    const auto at = attributes.find(wanted.name);
    if (at == attributes.end() || !isSameType(*at->second, wanted))
        throw Error(name + " lacks " + kindOf(wanted) + inQuotes(wanted.name) + ", which " + owner +
                    " has");
    const Attribute* found = at->second;
    if (found->components != wanted.components)
        throw Error(concat("attribute ", inQuotes(wanted.name), " has ", found->components,
                           " components in ", name, ", but ", wanted.components, " in ", owner));
}

/// Throws unless the first lattice and another one have the same attributes.
template <class Attribute>
void requireSame(const std::vector<Attribute>& ofFirst, const std::string& first,
                 const std::vector<Attribute>& others, const std::string& other) {
    const ByName<Attribute> namesOfFirst = byName(ofFirst), names = byName(others);
    for (const Attribute& attribute : ofFirst) requireAttribute(attribute, first, names, other);
    for (const Attribute& attribute : others)
        requireAttribute(attribute, other, namesOfFirst, first);
}

/// Returns the attributes without their values.
template <class Attribute>
std::vector<Attribute> withoutValues(std::vector<Attribute> attributes) {
    for (Attribute& attribute : attributes) attribute.values.clear();
    return attributes;
}

void check(std::span<const Lattice> lattices, const MergeOptions& options) {
    if (lattices.empty()) throw Error("there is no lattice; expected 1 or more");
    if (!(options.tolerance >= 0 && options.tolerance < 1))
        throw ArgumentError("merge", "tolerance", textOf(options.tolerance),
                            "a number from 0 to below 1, a fraction of the whole size");
    if (!options.names.empty() && options.names.size() != lattices.size())
        throw Error(
            concat("got ", options.names.size(), " names for ", lattices.size(), " lattices"));
    const std::string first = latticeName(options, 0);
    for (std::size_t number = 0; number < lattices.size(); ++number) {
        const std::string name = latticeName(options, number);
        requireConsistent("merge", name, lattices[number], lattices[0].complex.dimension());
        requireSame(lattices[0].attributes, first, lattices[number].attributes, name);
        requireSame(lattices[0].integers, first, lattices[number].integers, name);
    }
}

/// Throws if two vertices of a cell are welded.
void requireCellsKept(const far::CellComplex& complex, std::span<const Index> newVertex,
                      const std::string& name, double distance) {
    const int dimension = complex.dimension();
    std::vector<std::pair<Index, Index>> welded;  // new vertex, old vertex
    for (Index cell = 0; cell < complex.count(dimension); ++cell) {
        checkCancelledEvery(cell, 12);
        welded.clear();
        for (const Index vertex : complex.relation(dimension, 0)[cell])
            welded.emplace_back(newVertex[vertex], vertex);
        std::sort(welded.begin(), welded.end());
        const auto twice =
            std::adjacent_find(welded.begin(), welded.end(),
                               [](const auto& a, const auto& b) { return a.first == b.first; });
        if (twice == welded.end()) continue;
        throw far::TopologyError(far::TopologyCause::RepeatedVertex, {dimension, cell},
                                 concat("vertices ", twice->second, " and ", (twice + 1)->second,
                                        " of ", dimensionName(dimension), " ", cell, " of ", name,
                                        " would become one; they are within the distance of ",
                                        textOf(distance), " that the tolerance allows"));
    }
}

void appendMarks(const far::Marks& from, std::span<const Index> newVertex, far::Marks& to) {
    for (const far::Marks::Edge& mark : from.edges)
        to.edges.push_back(
            {{newVertex[mark.vertices[0]], newVertex[mark.vertices[1]]}, mark.sharpness});
    for (const far::Marks::Vertex& mark : from.vertices)
        to.vertices.push_back({newVertex[mark.vertex], mark.sharpness});
}

/// Appends to `to` the values of the vertices that appear first in `from`.
template <class Attribute>
void appendValues(const Attribute& from, std::span<const Index> newVertex, Attribute& to) {
    const std::size_t components = to.components;
    for (std::size_t vertex = 0; vertex < newVertex.size(); ++vertex) {
        // Vertices are numbered in the order of appearance, so a new vertex has the next number.
        if (newVertex[vertex] * components != to.values.size()) continue;
        const auto first = from.values.begin() + static_cast<std::ptrdiff_t>(vertex * components);
        to.values.insert(to.values.end(), first, first + to.components);
    }
}

/// The same for all attributes. `from` has those of `to`, in any order.
template <class Attribute>
void appendValues(const std::vector<Attribute>& from, std::span<const Index> newVertex,
                  std::vector<Attribute>& to) {
    const ByName<Attribute> names = byName(from);
    for (Attribute& attribute : to) appendValues(*names.at(attribute.name), newVertex, attribute);
}

/// A face or a cell of one of the lattices.
struct Origin {
    std::size_t lattice;
    Entity entity;
};

std::string nameOf(const Origin& origin, const MergeOptions& options) {
    return concat(dimensionName(origin.entity.dimension), " ", origin.entity.index, " of ",
                  latticeName(options, origin.lattice));
}

/// Returns the merged vertices of a face, ascending.
std::vector<Index> mergedVertices(const far::CellComplex& complex, Index face,
                                  std::span<const Index> newVertex) {
    std::vector<Index> vertices;
    for (const Index vertex : complex.relation(2, 0)[face]) vertices.push_back(newVertex[vertex]);
    std::sort(vertices.begin(), vertices.end());
    return vertices;
}

/// Finds faces of the lattices that become one face with more than two cells, and returns them up
/// to the face that adds the third cell. Empty if there are none.
std::vector<Origin> crowdedFace(std::span<const Lattice> lattices,
                                std::span<const Index> newIndex) {
    struct Faces {
        std::size_t cellCount = 0;
        std::vector<Origin> origins;
    };
    std::map<std::vector<Index>, Faces> merged;  // by the merged vertices
    for (std::size_t number = 0; number < lattices.size(); ++number) {
        const far::CellComplex& complex = lattices[number].complex;
        const auto newVertex = newIndex.first(lattices[number].positions.size());
        newIndex = newIndex.subspan(newVertex.size());
        for (Index face = 0; face < complex.count(2); ++face) {
            checkCancelledEvery(face, 12);
            Faces& faces = merged[mergedVertices(complex, face, newVertex)];
            faces.cellCount += complex.relation(2, 3)[face].size();
            faces.origins.push_back({number, {2, face}});
            if (faces.cellCount > 2) return faces.origins;
        }
    }
    return {};
}

/// Returns the first two cells of the lattices that get the same faces. Empty if there are none.
std::vector<Origin> repeatedCell(std::span<const Lattice> lattices,
                                 std::span<const Index> newIndex) {
    std::map<std::vector<std::vector<Index>>, Origin>
        merged;  // by the merged vertices of the faces
    for (std::size_t number = 0; number < lattices.size(); ++number) {
        const far::CellComplex& complex = lattices[number].complex;
        const auto newVertex = newIndex.first(lattices[number].positions.size());
        newIndex = newIndex.subspan(newVertex.size());
        for (Index cell = 0; cell < complex.count(3); ++cell) {
            checkCancelledEvery(cell, 12);
            std::vector<std::vector<Index>> faces;
            for (const Index face : complex.relation(3, 2)[cell])
                faces.push_back(mergedVertices(complex, face, newVertex));
            std::sort(faces.begin(), faces.end());
            const Origin origin = {number, {3, cell}};
            const auto [other, isNew] = merged.try_emplace(std::move(faces), origin);
            if (!isNew) return {other->second, origin};
        }
    }
    return {};
}

/// Builds the merged complex. Errors name faces and cells of the original lattices.
far::CellComplex buildMerged(const far::ComplexBuilder& builder, std::span<const Lattice> lattices,
                             std::span<const Index> newIndex, const MergeOptions& options) {
    try {
        return builder.build();
    } catch (const far::TopologyError& error) {
        const bool isCell = error.cause() == far::TopologyCause::RepeatedCell;
        std::vector<Origin> origins;
        if (isCell) origins = repeatedCell(lattices, newIndex);
        if (error.cause() == far::TopologyCause::CrowdedFace)
            origins = crowdedFace(lattices, newIndex);
        if (origins.empty())
            throw far::TopologyError(error.cause(), error.entity(),
                                     "in the merged lattice, " + std::string(error.what()));
        std::string names;
        for (const Origin& origin : origins)
            names += (names.empty() ? "" : ", ") + nameOf(origin, options);
        throw far::TopologyError(error.cause(), origins.back().entity,
                                 names + " would become one " +
                                     (isCell ? "cell; each cell may be in one lattice only"
                                             : "face of more than two cells"));
    }
}

}  // namespace

Lattice merge(std::span<const Lattice> lattices, const MergeOptions& options) {
    check(lattices, options);
    std::vector<Point3> points;
    for (const Lattice& lattice : lattices)
        points.insert(points.end(), lattice.positions.begin(), lattice.positions.end());
    requireCountable("merge", {static_cast<Offset>(points.size())});
    const double distance = options.tolerance * BoundingBox(points).diagonal();
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
        requireCellsKept(lattice.complex, newVertex, latticeName(options, number), distance);
        addAll(lattice.complex, newVertex, builder);
        appendMarks(lattice.marks, newVertex, result.marks);
        appendValues(lattice.attributes, newVertex, result.attributes);
        appendValues(lattice.integers, newVertex, result.integers);
    }
    result.complex = buildMerged(builder, lattices, welding.newIndex, options);
    result.positions = std::move(welding.positions);
    return result;
}

Lattice merge(const Lattice& first, const Lattice& second, const MergeOptions& options) {
    const Lattice lattices[] = {first, second};
    return merge(lattices, options);
}

MergeJoints findJoints(std::span<const Lattice> lattices, const Lattice& merged) {
    const int dimension = merged.complex.dimension();
    MergeJoints joints{.weldedVertices = -merged.complex.count(0)};
    std::vector<Index> lastCells;  // per lattice: the number after its last cell in the result
    for (const Lattice& lattice : lattices) {
        joints.weldedVertices += lattice.complex.count(0);
        joints.groups.push_back(joints.groups.size());
        lastCells.push_back((lastCells.empty() ? 0 : lastCells.back()) +
                            lattice.complex.count(dimension));
    }
    const auto latticeOf = [&](Index cell) {
        return std::ranges::upper_bound(lastCells, cell) - lastCells.begin();
    };
    for (Index face = 0; face < merged.complex.count(dimension - 1); ++face) {
        checkCancelledEvery(face, 14);
        const auto cells = merged.complex.relation(dimension - 1, dimension)[face];
        const auto first = latticeOf(cells.front());
        bool isShared = false;
        for (const Index cell : cells) {
            const auto other = latticeOf(cell);
            isShared |= other != first;
            const auto [low, high] = std::minmax(joints.groups[first], joints.groups[other]);
            if (low != high) std::ranges::replace(joints.groups, std::size_t{high}, low);
        }
        joints.sharedFaces += isShared;
    }
    return joints;
}

}  // namespace espalier::shapes
