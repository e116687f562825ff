// SPDX-License-Identifier: Apache-2.0
#include <espalier/compare/open_subdiv_refiner.h>
#include <espalier/far/error.h>
#include <opensubdiv/far/topologyDescriptor.h>
#include <opensubdiv/version.h>

#include <algorithm>
#include <vector>

namespace espalier::compare {
namespace {

namespace Far = OpenSubdiv::Far;
namespace Sdc = OpenSubdiv::Sdc;

/// OpenSubdiv keeps a sharpness infinite from 10 on, at every level.
constexpr float kInfinite = 10;

/// What a Far::TopologyDescriptor points to.
struct Description {
    std::vector<int> faceSizes, faceVertices;
    std::vector<int> creasePairs, corners, holes;
    std::vector<float> creaseWeights, cornerWeights;

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
        return view;
    }
};

Description describe(const far::TopologyRefiner& refiner, const Surface& surface) {
    const auto& [complex, strata, holes] = refiner.level(0);
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
    const auto addCrease = [&](Index edge, float sharpness) {
        const auto ends = complex.relation(1, 0)[edge];
        description.addCrease(nameOf(ends[0]), nameOf(ends[1]), sharpness);
    };
    if (complex.dimension() == 2) {
        const far::MarkedSharpness marked = far::readMarks(complex, refiner.options().marks);
        for (const auto& [edge, sharpness] : marked.edges) addCrease(edge, sharpness);
        for (const auto& [vertex, sharpness] : marked.vertices)
            description.addCorner(nameOf(vertex), sharpness);
        description.holes.assign(holes.begin(), holes.end());
    } else {
        for (const Index edge : surface.edges)
            if (strata.sharpness({1, edge}) > far::kSmooth)
                addCrease(edge, strata.sharpness({1, edge}));
        for (const Index vertex : surface.vertices)
            if (strata.sharpness({0, vertex}) > far::kSmooth)
                description.addCorner(nameOf(vertex), strata.sharpness({0, vertex}));
    }
    return description;
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
        throw Error("OpenSubdiv refuses the surface of " + std::to_string(vertexCount) +
                    " vertices and " + std::to_string(description.faceSizes.size()) + " faces");
    return refiner;
}

/// Vertices that OpenSubdiv takes for non-manifold creases and we for corners.
std::vector<int> misjudgedCorners(const Far::TopologyRefiner& theirs,
                                  const far::TopologyRefiner& ours, const Surface& surface) {
    std::vector<int> vertices;
    const Far::TopologyLevel& base = theirs.GetLevel(0);
    for (int vertex = 0; vertex < base.GetNumVertices(); ++vertex) {
        const Index our = surface.vertices[static_cast<std::size_t>(vertex)];
        if (base.IsVertexNonManifold(vertex) && !base.IsVertexInfSharp(vertex) &&
            ours.level(0).strata.sharpness({0, our}) == far::kInfinitelySharp)
            vertices.push_back(vertex);
    }
    return vertices;
}

}  // namespace

OpenSubdivRefiner makeOpenSubdivRefiner(const far::TopologyRefiner& refiner,
                                        const Surface& surface) {
    const Sdc::Options options = schemeOptions(refiner);
    Description description = describe(refiner, surface);
    OpenSubdivRefiner result{create(description, surface.vertices.size(), options)};
#if OPENSUBDIV_VERSION_NUMBER < 30601
    const std::vector<int> misjudged = misjudgedCorners(*result.refiner, refiner, surface);
    if (!misjudged.empty()) {
        for (const int vertex : misjudged) description.addCorner(vertex, kInfinite);
        result.refiner = create(description, surface.vertices.size(), options);
        result.correctedCorners = static_cast<Index>(misjudged.size());
    }
#endif
    if (refiner.maxLevel() > 0) {
        Far::TopologyRefiner::UniformOptions uniform(refiner.maxLevel());
        uniform.fullTopologyInLastLevel = true;
        result.refiner->RefineUniform(uniform);
    }
    return result;
}

}  // namespace espalier::compare
