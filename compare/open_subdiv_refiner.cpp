// SPDX-License-Identifier: Apache-2.0
#include <espalier/base/error.h>
#include <espalier/base/memory.h>
#include <espalier/stencils/composition.h>

#include <opensubdiv/far/topologyDescriptor.h>
#include <opensubdiv/version.h>

#include <algorithm>
#include <cstdint>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "open_subdiv_refiner.h"

namespace espalier::compare {
namespace {

std::string levelsTo(int level) {
    return level == 1 ? "level 1" : concat("levels 1 to ", level);
}

}  // namespace

void requireForLevels(std::size_t cornerCount, int maxLevel) {
    // A face, with its share of two edges and one vertex, takes 177 bytes in the arrays of
    // OpenSubdiv's levels and 36 in the links from parents to children (214 measured, for 131,000
    // faces).
    constexpr std::uint64_t kFaceBytes = 200;
    std::uint64_t faceCount = 0, ofLevel = cornerCount;
    for (int level = 1; level <= maxLevel; ++level, ofLevel *= 4) faceCount += ofLevel;
    requireMemory(kFaceBytes * faceCount, "OpenSubdiv's topology of " + levelsTo(maxLevel));
}

void requireForMatch(const far::TopologyRefiner& refiner, int level) {
    const far::CellComplex& complex = refiner.level(level).complex;
    std::uint64_t bytes = 0;
    for (int d = 0; d <= 2; ++d)
        bytes += sizeof(std::optional<Index>) * static_cast<std::uint64_t>(complex.count(d));
    // Face → vertices: offsets, values, and a copy of the values while they are collected.
    const std::uint64_t offsets = sizeof(Offset) * static_cast<std::uint64_t>(complex.count(2));
    const auto valuesOf = [&](int dimension) {
        return sizeof(Index) * complex.boundary(dimension).unsignedRows().values().size();
    };
    bytes += offsets + 2 * valuesOf(2);
    // Face → cells: offsets and values, which exist at the same time.
    if (complex.dimension() == 3) bytes += offsets + valuesOf(3);
    requireMemory(bytes, concat("matching level ", level, " with OpenSubdiv's"));
}

void requireForTable(const far::TopologyRefiner& refiner, std::span<const Surface> regions) {
    const int maxLevel = static_cast<int>(regions.size()) - 1;
    // Rows get longer with the level, because a new point has the entries of all points that it is
    // a mean of. After two levels the rows have nearly their final length, so the row length of
    // level 2 stands for all further levels.
    int countedLevels = 0;
    double entryCount = 0, rowLength = 0;
    for (int level = 1; level <= maxLevel; ++level) {
        const std::vector<Index>& vertices = regions[level].vertices;
        if (vertices.empty()) continue;
        const auto rowCount = static_cast<double>(vertices.size());
        if (++countedLevels <= 2)
            rowLength = static_cast<double>(
                            stencils::buildStencils(refiner, level, vertices).entryCount()) /
                        rowCount;
        entryCount += rowLength * rowCount;
    }
    // OpenSubdiv's factory collects a source, a destination and a weight for each entry, and copies
    // sources and weights to a table (29 bytes per entry measured, for 4 million entries).
    constexpr std::uint64_t kEntryBytes = 2 * (sizeof(int) + sizeof(double)) + sizeof(int);
    requireMemory(kEntryBytes * static_cast<std::uint64_t>(entryCount),
                  "OpenSubdiv's stencil table of " + levelsTo(maxLevel));
}

void requireForComparison(int level, Offset entryCount) {
    // The comparison first holds OpenSubdiv's rows twice in double precision: over our columns, and
    // over OpenSubdiv's columns. Later it holds a table in single precision and a copy of this
    // table in place of the rows over OpenSubdiv's columns.
    constexpr std::uint64_t kEntryBytes =
        sizeof(Index) + sizeof(double) +
        std::max(sizeof(Index) + sizeof(double), 2 * (sizeof(int) + sizeof(float)));
    requireMemory(kEntryBytes * static_cast<std::uint64_t>(entryCount),
                  concat("comparing the stencil tables of level ", level));
}

namespace {

namespace Far = OpenSubdiv::Far;
namespace Sdc = OpenSubdiv::Sdc;

/// OpenSubdiv treats a sharpness from this value on as infinite, at every level.
constexpr auto kInfinite = static_cast<float>(far::kLeastInfinite);

/// The arrays that a Far::TopologyDescriptor points to.
struct Description {
    std::vector<int> faceSizes, faceVertices;
    std::vector<int> creasePairs, corners, holes;
    std::vector<float> creaseWeights, cornerWeights;
    std::vector<int> faceVaryingValues;                     ///< one per corner, or none
    Far::TopologyDescriptor::FVarChannel faceVarying = {};  ///< refers to faceVaryingValues

    void setFaceVarying(std::span<const Index> cornerValues) {
        faceVaryingValues.assign(cornerValues.begin(), cornerValues.end());
        faceVarying.numValues = 1 + *std::ranges::max_element(faceVaryingValues);
        faceVarying.valueIndices = faceVaryingValues.data();
    }
    void addCrease(int a, int b, float sharpness) {
        creasePairs.insert(creasePairs.end(), {a, b});
        creaseWeights.push_back(std::min(sharpness, kInfinite));
    }
    void addCorner(int vertex, float sharpness) {
        corners.push_back(vertex);
        cornerWeights.push_back(std::min(sharpness, kInfinite));
    }

    Far::TopologyDescriptor view(std::size_t vertexCount) const {
        Far::TopologyDescriptor view;
        view.numVertices = static_cast<int>(vertexCount);
        view.numFaces = static_cast<int>(faceSizes.size());
        view.numVertsPerFace = faceSizes.data();
        view.vertIndicesPerFace = faceVertices.data();
        view.numCreases = static_cast<int>(creaseWeights.size());
        view.creaseVertexIndexPairs = creasePairs.data();
        view.creaseWeights = creaseWeights.data();
        view.numCorners = static_cast<int>(corners.size());
        view.cornerVertexIndices = corners.data();
        view.cornerWeights = cornerWeights.data();
        view.numHoles = static_cast<int>(holes.size());
        view.holeIndices = holes.data();
        view.numFVarChannels = faceVaryingValues.empty() ? 0 : 1;
        view.fvarChannels = &faceVarying;
        return view;
    }
};

/// Returns as marks the sharpness that marks or rules give to the surface of a lattice. OpenSubdiv
/// itself finds the sharp edges and corners that follow from the topology of the surface.
far::MarkedSharpness chosenSharpness(const far::TopologyRefiner& refiner, const Surface& surface) {
    const far::CellComplex& complex = refiner.level(0).complex;
    const far::Strata& strata = refiner.level(0).strata;
    far::MarkedSharpness chosen;
    for (const Index edge : surface.edges) {
        const auto faces = complex.relation(1, 2)[edge];
        const auto onSurface = std::count_if(faces.begin(), faces.end(), [&](Index face) {
            return complex.relation(2, 3)[face].size() == 1;
        });
        if (onSurface == 2) chosen.edges[edge] = strata.sharpness({1, edge});
    }
    chosen.vertices = far::readMarks(complex, refiner.options().marks).vertices;
    for (const Index vertex : surface.vertices)
        if (complex.relation(0, 3)[vertex].size() == 1)
            chosen.vertices[vertex] = strata.sharpness({0, vertex});
    return chosen;
}

Description describe(const far::TopologyRefiner& refiner, const Surface& surface) {
    const auto& [complex, strata, holes] = refiner.level(0);
    const auto isOnSurface = [&](Index vertex) {
        return std::binary_search(surface.vertices.begin(), surface.vertices.end(), vertex);
    };
    const auto nameOf = [&](Index vertex) {
        const auto at = std::lower_bound(surface.vertices.begin(), surface.vertices.end(), vertex);
        return static_cast<int>(at - surface.vertices.begin());
    };
    Description description;
    for (const Index face : surface.faces) {
        const std::vector<Index> loop = surfaceLoop(complex, face);
        description.faceSizes.push_back(static_cast<int>(loop.size()));
        for (const Index vertex : loop) description.faceVertices.push_back(nameOf(vertex));
    }
    const far::MarkedSharpness marked = complex.dimension() == 2
                                            ? far::readMarks(complex, refiner.options().marks)
                                            : chosenSharpness(refiner, surface);
    for (const auto& [edge, sharpness] : marked.edges) {
        const auto ends = complex.relation(1, 0)[edge];
        description.addCrease(nameOf(ends[0]), nameOf(ends[1]), sharpness);
    }
    for (const auto& [vertex, sharpness] : marked.vertices)
        if (isOnSurface(vertex)) description.addCorner(nameOf(vertex), sharpness);
    description.holes.assign(holes.begin(), holes.end());
    return description;
}

Sdc::Options::FVarLinearInterpolation openSubdivMode(far::FaceVaryingLinear linear) {
    switch (linear) {
        case far::FaceVaryingLinear::None:
            return Sdc::Options::FVAR_LINEAR_NONE;
        case far::FaceVaryingLinear::CornersOnly:
            return Sdc::Options::FVAR_LINEAR_CORNERS_ONLY;
        case far::FaceVaryingLinear::CornersPlus1:
            return Sdc::Options::FVAR_LINEAR_CORNERS_PLUS1;
        case far::FaceVaryingLinear::CornersPlus2:
            return Sdc::Options::FVAR_LINEAR_CORNERS_PLUS2;
        case far::FaceVaryingLinear::Boundaries:
            return Sdc::Options::FVAR_LINEAR_BOUNDARIES;
        case far::FaceVaryingLinear::All:
            break;
    }
    return Sdc::Options::FVAR_LINEAR_ALL;
}

Sdc::Options schemeOptions(const far::TopologyRefiner& refiner) {
    Sdc::Options options;
    switch (refiner.boundary()) {
        case far::Boundary::Sharp:
            options.SetVtxBoundaryInterpolation(Sdc::Options::VTX_BOUNDARY_EDGE_AND_CORNER);
            break;
        case far::Boundary::EdgeOnly:
            options.SetVtxBoundaryInterpolation(Sdc::Options::VTX_BOUNDARY_EDGE_ONLY);
            break;
        case far::Boundary::Open:
            options.SetVtxBoundaryInterpolation(Sdc::Options::VTX_BOUNDARY_NONE);
    }
    if (refiner.options().creasing == far::Creasing::Chaikin)
        options.SetCreasingMethod(Sdc::Options::CREASE_CHAIKIN);
    if (refiner.options().triangles == far::TriangleSubdivision::Smooth)
        options.SetTriangleSubdivision(Sdc::Options::TRI_SUB_SMOOTH);
    return options;
}

std::unique_ptr<Far::TopologyRefiner> create(const Description& description,
                                             std::size_t vertexCount, Sdc::Options options) {
    using Factory = Far::TopologyRefinerFactory<Far::TopologyDescriptor>;
    std::unique_ptr<Far::TopologyRefiner> refiner(Factory::Create(
        description.view(vertexCount), Factory::Options(Sdc::SCHEME_CATMARK, options)));
    if (refiner == nullptr)
        throw Error(concat("OpenSubdiv refuses the surface of ", vertexCount, " vertices and ",
                           description.faceSizes.size(), " faces"));
    return refiner;
}

/// True if the faces at a vertex form a non-manifold crease by the definition of OpenSubdiv 3.6.1
/// and later: exactly two non-manifold edges meet in the vertex, both have the same number of
/// faces, and the faces at the vertex form fans that each run from one of these edges to the other.
/// It is computed from OpenSubdiv's relations.
bool isCreaseSince361(const Far::TopologyLevel& level, int vertex) {
    std::vector<int> creaseEdges;
    for (const int edge : level.GetVertexEdges(vertex)) {
        if (level.IsEdgeNonManifold(edge))
            creaseEdges.push_back(edge);
        else if (level.GetEdgeFaces(edge).size() != 2)
            return false;
    }
    if (creaseEdges.size() != 2 ||
        level.GetEdgeFaces(creaseEdges[0]).size() != level.GetEdgeFaces(creaseEdges[1]).size())
        return false;
    // Returns the other edge of a face at the vertex.
    const auto across = [&](int face, int edge) {
        for (const int other : level.GetFaceEdges(face)) {
            const auto ends = level.GetEdgeVertices(other);
            if (other != edge && (ends[0] == vertex || ends[1] == vertex)) return other;
        }
        return edge;
    };
    int faceCount = 0;
    for (int face : level.GetEdgeFaces(creaseEdges[0])) {
        int edge = creaseEdges[0];
        // If the walk has visited more faces than the vertex has, it would not end.
        while (faceCount++ <= level.GetVertexFaces(vertex).size()) {
            edge = across(face, edge);
            if (level.IsEdgeNonManifold(edge)) break;
            const auto faces = level.GetEdgeFaces(edge);
            face = faces[0] == face ? faces[1] : faces[0];
        }
        if (edge != creaseEdges[1]) return false;
    }
    return faceCount == level.GetVertexFaces(vertex).size();
}

/// Returns the vertices that releases of OpenSubdiv before 3.6.1 wrongly treat as non-manifold
/// creases.
std::vector<int> misjudgedCorners(const Far::TopologyRefiner& refiner) {
    std::vector<int> vertices;
    const Far::TopologyLevel& base = refiner.GetLevel(0);
    for (int vertex = 0; vertex < base.GetNumVertices(); ++vertex)
        if (base.IsVertexNonManifold(vertex) && !base.IsVertexInfSharp(vertex) &&
            !isCreaseSince361(base, vertex))
            vertices.push_back(vertex);
    return vertices;
}

/// Throws for entities with too many neighbours: OpenSubdiv counts them in 16 bits, and only prints
/// a warning if there are more.
void checkValences(const far::CellComplex& complex, const Surface& surface) {
    const auto check = [&](Entity entity, int around) {
        const std::size_t count = complex.relation(entity.dimension, around)[entity.index].size();
        if (std::cmp_greater(count, Far::VALENCE_LIMIT))
            throw Error(concat(dimensionName(entity.dimension), " ", entity.index, " meets ", count,
                               " ",
                               around == 0   ? "vertices"
                               : around == 1 ? "edges"
                                             : "faces",
                               ", more than OpenSubdiv can count (", Far::VALENCE_LIMIT, ")"));
    };
    for (const Index face : surface.faces) check({2, face}, 0);
    for (const Index edge : surface.edges) check({1, edge}, 2);
    for (const Index vertex : surface.vertices)
        for (const int around : {1, 2}) check({0, vertex}, around);
}

}  // namespace

OpenSubdivRefiner makeOpenSubdivRefiner(const far::TopologyRefiner& refiner, const Surface& surface,
                                        const FaceVaryingValues* faceVarying) {
    checkValences(refiner.level(0).complex, surface);
    Sdc::Options options = schemeOptions(refiner);
    Description description = describe(refiner, surface);
    if (faceVarying != nullptr) {
        description.setFaceVarying(faceVarying->cornerValues);
        options.SetFVarLinearInterpolation(openSubdivMode(faceVarying->linear));
    }
    OpenSubdivRefiner result{create(description, surface.vertices.size(), options)};
#if OPENSUBDIV_VERSION_NUMBER < 30601
    const std::vector<int> misjudged = misjudgedCorners(*result.refiner);
    if (!misjudged.empty()) {
        for (const int vertex : misjudged) description.addCorner(vertex, kInfinite);
        result.refiner = create(description, surface.vertices.size(), options);
        result.correctedCorners = static_cast<Index>(misjudged.size());
    }
#endif
    if (refiner.maxLevel() > 0) {
        requireForLevels(description.faceVertices.size(), refiner.maxLevel());
        Far::TopologyRefiner::UniformOptions uniform(refiner.maxLevel());
        uniform.fullTopologyInLastLevel = true;
        result.refiner->RefineUniform(uniform);
    }
    return result;
}

}  // namespace espalier::compare
