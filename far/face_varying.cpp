// SPDX-License-Identifier: Apache-2.0
#include <espalier/base/error.h>
#include <espalier/far/complex_builder.h>
#include <espalier/far/face_varying.h>

#include <algorithm>
#include <array>
#include <cstdint>
#include <utility>

#include <espalier/far/surface_fans.h>

namespace espalier::far {
namespace {

std::vector<std::uint8_t> allFaces(const CellComplex& complex) {
    return std::vector<std::uint8_t>(complex.count(2), 1);
}

/// The cut mesh at level 0. A vertex of it is a pair of a value and a vertex of the mesh.
struct CutMesh {
    CellComplex complex;
    std::vector<Index> values;  ///< one per vertex
};

CutMesh cutMesh(const CellComplex& mesh, std::span<const Index> cornerValues) {
    const std::span<const Index> corners = mesh.relation(2, 0).values();
    if (cornerValues.size() != corners.size())
        throw Error(concat("there are ", cornerValues.size(),
                           " face-varying values at corners; expected ", corners.size(),
                           ", one for each corner of each face"));
    std::vector<std::pair<Index, Index>> pairs;
    for (std::size_t i = 0; i < corners.size(); ++i) {
        if (cornerValues[i] < 0)
            throw Error(concat("corner ", i, " names the face-varying value ", cornerValues[i],
                               "; expected 0 or more"));
        pairs.emplace_back(cornerValues[i], corners[i]);
    }
    std::vector<std::pair<Index, Index>> vertices = pairs;
    std::sort(vertices.begin(), vertices.end());
    vertices.erase(std::unique(vertices.begin(), vertices.end()), vertices.end());

    ComplexBuilder builder(2, static_cast<Index>(vertices.size()));
    std::vector<Index> loop;
    auto pair = pairs.begin();
    for (Index face = 0; face < mesh.count(2); ++face) {
        loop.clear();
        for (std::size_t i = 0; i < mesh.relation(2, 0)[face].size(); ++i, ++pair)
            loop.push_back(static_cast<Index>(
                std::lower_bound(vertices.begin(), vertices.end(), *pair) - vertices.begin()));
        builder.addFace(loop);
    }
    CutMesh result{builder.build(), {}};
    for (const auto& [value, vertex] : vertices) result.values.push_back(value);
    return result;
}

/// Finds the strata of a level of the cut mesh from the same level of the mesh.
class CutStrata {
public:
    CutStrata(const Level& mesh, const CellComplex& cut, FaceVaryingLinear linear)
        : mesh_(mesh), cut_(cut), linear_(linear), fans_(cut, allFaces(cut)) {
        const SurfaceFans meshFans(mesh.complex, allFaces(mesh.complex));
        for (int d = 0; d <= 2; ++d) origins_[d].resize(cut.count(d));
        for (Index face = 0; face < cut.count(2); ++face) {
            origins_[2][face] = face;
            for (const int d : {0, 1})
                for (std::size_t i = 0; i < cut.relation(2, d)[face].size(); ++i)
                    origins_[d][cut.relation(2, d)[face][i]] = mesh.complex.relation(2, d)[face][i];
        }
        valuesOf_.resize(mesh.complex.count(0));
        for (Index vertex = 0; vertex < cut.count(0); ++vertex)
            valuesOf_[origins_[0][vertex]].push_back(vertex);
        isCut_.assign(mesh.complex.count(0), 0);
        for (Index edge = 0; edge < cut.count(1); ++edge)
            if (isSeam(edge))
                for (const Index vertex : cut.relation(1, 0)[edge]) isCut_[origins_[0][vertex]] = 1;
        isManifold_.resize(mesh.complex.count(0));
        for (Index vertex = 0; vertex < mesh.complex.count(0); ++vertex)
            isManifold_[vertex] = meshFans.vertex(vertex) == SurfaceFans::VertexKind::Fan;
    }

    /// \param creasing of the mesh
    Strata strata(Boundary boundary, Creasing creasing) const {
        SharpnessValues sharpness = edgesAndVertices();
        if (linear_ == FaceVaryingLinear::CornersPlus1 ||
            linear_ == FaceVaryingLinear::CornersPlus2)
            sharpenPairs(makeStrata(boundary, sharpness), creasing, sharpness);
        return makeStrata(boundary, std::move(sharpness));
    }

private:
    /// Returns true if an edge of the cut mesh is one side of a seam.
    bool isSeam(Index edge) const {
        return cut_.relation(1, 2)[edge].size() !=
               mesh_.complex.relation(1, 2)[origins_[1][edge]].size();
    }

    /// Returns true if a seam passes the vertex of the mesh.
    bool isOnSeam(Index vertex) const { return isCut_[origins_[0][vertex]] != 0; }

    bool isOfOneFace(Index vertex) const { return cut_.relation(0, 2)[vertex].size() == 1; }

    /// Returns true if the value at a vertex of the cut mesh is fixed, besides the sharpness that
    /// the mesh has.
    bool isFixed(Index vertex) const {
        if (linear_ == FaceVaryingLinear::All) return true;
        if (isOfOneFace(vertex) && linear_ != FaceVaryingLinear::None) return true;
        if (linear_ == FaceVaryingLinear::Boundaries) {
            const auto edges = cut_.relation(0, 1)[vertex];
            if (std::any_of(edges.begin(), edges.end(), [&](Index edge) {
                    return fans_.edge(edge) == SurfaceFans::EdgeKind::Boundary;
                }))
                return true;
        }
        if (!isOnSeam(vertex)) return false;
        if (linear_ == FaceVaryingLinear::Boundaries) return true;
        if (isManifold_[origins_[0][vertex]] == 0 ||
            fans_.vertex(vertex) != SurfaceFans::VertexKind::Fan)
            return true;
        const std::vector<Index>& values = valuesOf_[origins_[0][vertex]];
        const bool plus2 = linear_ == FaceVaryingLinear::CornersPlus2;
        if (plus2 || linear_ == FaceVaryingLinear::CornersPlus1)
            if (values.size() > 2) return true;
        if (!plus2) return false;
        return values.size() == 1 || std::any_of(values.begin(), values.end(),
                                                 [&](Index value) { return isOfOneFace(value); });
    }

    SharpnessValues edgesAndVertices() const {
        SharpnessValues sharpness;
        for (Index edge = 0; edge < cut_.count(1); ++edge)
            sharpness.edges.push_back(linear_ == FaceVaryingLinear::All || isSeam(edge)
                                          ? kInfinitelySharp
                                          : mesh_.strata.sharpness({1, origins_[1][edge]}));
        for (Index vertex = 0; vertex < cut_.count(0); ++vertex)
            sharpness.vertices.push_back(isFixed(vertex)
                                             ? kInfinitelySharp
                                             : mesh_.strata.sharpness({0, origins_[0][vertex]}));
        return sharpness;
    }

    /// At each vertex with two values: if sharp edges make one value sharp, gives the other value
    /// the same sharpness.
    void sharpenPairs(const Strata& strata, Creasing creasing, SharpnessValues& sharpness) const {
        for (const std::vector<Index>& values : valuesOf_) {
            if (values.size() != 2) continue;
            for (const auto& [from, to] :
                 {std::pair(values[0], values[1]), {values[1], values[0]}}) {
                if (isOfOneFace(from) || strata.of({0, from}) != 0 || strata.of({0, to}) == 0)
                    continue;
                // The other value fades with the same weight: a sharpness of at most 1 is the
                // weight of a vertex.
                const auto fading = fadingOf(cut_, strata, creasing, {0, from});
                sharpness.vertices[to] =
                    fading ? static_cast<float>(fading->weight) : kInfinitelySharp;
            }
        }
    }

    Strata makeStrata(Boundary boundary, SharpnessValues sharpness) const {
        Strata::Numbers smooth, isOpen;
        for (int d = 0; d <= 2; ++d) {
            smooth[d].assign(cut_.count(d), 2);
            if (boundary != Boundary::Open) continue;
            for (const Index origin : origins_[d])
                isOpen[d].push_back(mesh_.strata.isOpen({d, origin}) ? 1 : 0);
        }
        return Strata(cut_, std::move(smooth), std::move(isOpen), std::move(sharpness));
    }

    const Level& mesh_;
    const CellComplex& cut_;
    FaceVaryingLinear linear_;
    SurfaceFans fans_;
    std::array<std::vector<Index>, 3> origins_;  ///< the entity of the mesh, by dimension
    // For each vertex of the mesh:
    std::vector<std::vector<Index>> valuesOf_;  ///< its vertices here
    std::vector<std::uint8_t> isCut_;
    std::vector<std::uint8_t> isManifold_;  ///< its faces form one fan
};

}  // namespace

FaceVaryingTopology refineFaceVarying(const TopologyRefiner& refiner,
                                      std::span<const Index> cornerValues,
                                      FaceVaryingLinear linear) {
    if (refiner.dimension() != 2)
        throw Error("only meshes have face-varying values, not curves or lattices");
    if (!refiner.isUniform())
        throw Error("face-varying values need levels that are refined as a whole");
    const auto strataOf = [&](int level, const CellComplex& cut) {
        return CutStrata(refiner.level(level), cut, linear)
            .strata(refiner.boundary(), refiner.options().creasing);
    };
    auto [cut, values] = cutMesh(refiner.level(0).complex, cornerValues);
    Strata strata = strataOf(0, cut);
    // Marks name vertices of the mesh; the strata already have their sharpness.
    RefinerOptions options = refiner.options();
    options.marks = {};
    FaceVaryingTopology result{
        TopologyRefiner(Level{std::move(cut), std::move(strata), refiner.level(0).holes}, options),
        std::move(values)};
    for (int level = 1; level <= refiner.maxLevel(); ++level) {
        Refinement split =
            TopologyRefiner::splitWhole(result.refiner.level(level - 1), refiner.boundary());
        Strata next = strataOf(level, split.child());
        result.refiner.addLevel(std::move(split), std::move(next));
    }
    return result;
}

}  // namespace espalier::far
