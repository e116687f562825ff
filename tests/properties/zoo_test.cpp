// SPDX-License-Identifier: Apache-2.0
#include <espalier/shapes/refiner_options.h>
#include <espalier/stencils/composition.h>

#include <functional>

#include "far/surface_fans.h"
#include "support/meshes.h"
#include "support/random_lattices.h"
#include "support/test.h"

// Tests the meshes and lattices that are compared with OpenSubdiv: they are valid, have the
// features that they are made for, and refine into valid complexes.
namespace espalier::stencils {
namespace {

using far::Creasing;
using far::Strata;
using far::TriangleSubdivision;

constexpr unsigned kSeeds = 200;

TopologyRefiner refinerOf(const Lattice& lattice) {
    return TopologyRefiner(lattice.complex, refinerOptions(lattice));
}

Point3 image(const Point3& p) {
    return {p[0] - 2 * p[1] + 0.5 * p[2] + 3, 0.25 * p[0] + p[1] - 1, 2 * p[2] - p[0] + 0.5};
}

/// Returns a row of a table times some points.
Point3 product(const StencilTable<double>& table, Index row, const std::vector<Point3>& points) {
    Point3 sum = {0, 0, 0};
    for (std::size_t k = 0; k < table.columns(row).size(); ++k)
        for (std::size_t c = 0; c < 3; ++c)
            sum[c] += table.weights(row)[k] * points[table.columns(row)[k]][c];
    return sum;
}

void expectSound(const Lattice& lattice, int levels) {
    TopologyRefiner refiner = refinerOf(lattice);
    refiner.refineUniform(levels);
    for (int level = 0; level <= levels; ++level) {
        const CellComplex& complex = refiner.level(level).complex;
        far::validate(complex);
        // Without boundary control, the region shrinks and may fall into pieces.
        if (refiner.boundary() != Boundary::Open) {
            EXPECT_EQ(complex.eulerCharacteristic(), lattice.complex.eulerCharacteristic());
        }
    }
    std::vector<Point3> images;
    for (const Point3& p : lattice.positions) images.push_back(image(p));
    double sumDifference = 0, imageDifference = 0;
    for (const Rules rules : {Rules::Siggraph96, Rules::Mlca}) {
        if (rules == Rules::Mlca && refiner.options().triangles == TriangleSubdivision::Smooth)
            continue;
        const StencilTable<double> table = buildStencils(withRules(refiner, rules), levels);
        for (Index row = 0; row < table.rowCount(); ++row) {
            const auto weights = table.weights(row);
            const double sum = std::accumulate(weights.begin(), weights.end(), 0.0);
            sumDifference = std::max(sumDifference, std::abs(sum - 1));
            const Point3 expected = image(product(table, row, lattice.positions));
            const Point3 found = product(table, row, images);
            for (std::size_t c = 0; c < 3; ++c)
                imageDifference = std::max(imageDifference, std::abs(expected[c] - found[c]));
        }
    }
    // A pole of valence 360 has up to 721 weights: 721 · 2⁻⁵³ = 8e-14 in the worst case.
    EXPECT_LE(sumDifference, 1e-13);
    // Affine precision: the refined image of the rest pose equals the image of the refined rest
    // pose. These are the same sums, with coordinates below 32: 721 · 32 · 2⁻⁵³ = 2.6e-12.
    EXPECT_LE(imageDifference, 3e-12);
}

// Checks that sums of sharpness at a vertex do not depend on their order: at most two values meet
// there, or the values are equal, or they are multiples of 1/4. Under Chaikin's method, which
// divides by the number of edges minus one, that divisor must also be a power of two.
void expectExactSums(const Lattice& lattice) {
    const CellComplex& complex = lattice.complex;
    const Strata strata = refinerOf(lattice).level(0).strata;
    for (Index vertex = 0; vertex < complex.count(0); ++vertex) {
        std::vector<float> edges;
        for (const Index edge : complex.relation(0, 1)[vertex])
            if (far::isSemiSharp(strata.sharpness({1, edge})))
                edges.push_back(strata.sharpness({1, edge}));
        const float own = strata.sharpness({0, vertex});
        if (edges.size() + far::isSemiSharp(own) <= 2) continue;
        if (std::adjacent_find(edges.begin(), edges.end(), std::not_equal_to<>()) == edges.end())
            continue;
        edges.push_back(far::isSemiSharp(own) ? own : far::kSmooth);
        for (const float sharpness : edges)
            EXPECT_EQ(sharpness * 4, std::round(sharpness * 4)) << "vertex " << vertex;
        if (lattice.tags.creasing == Creasing::Chaikin) {
            EXPECT_TRUE((std::set<std::size_t>{2, 3, 5}).count(edges.size() - 1))
                << "vertex " << vertex;
        }
    }
}

void expectSound(const std::string& name, const Lattice& lattice, int levels) {
    SCOPED_TRACE(name);
    EXPECT_NO_THROW(expectSound(lattice, levels));
    expectExactSums(lattice);
}

TEST(Zoo, MeshesAreSound) {
    for (const auto& [name, mesh] : meshZoo()) expectSound(name, mesh, 2);
}

TEST(Zoo, FeatureLatticesAreSound) {
    for (const auto& [name, lattice] : featureLattices()) expectSound(name, lattice, 2);
}

TEST(Zoo, RandomLatticesAreSound) {
    for (unsigned seed = 0; seed < kSeeds; ++seed)
        expectSound("seed " + std::to_string(seed), randomLattice(seed), 1);
}

// Without boundary control, the rest of a shape is a valid complex: no edge or face remains whose
// vertices are all gone.
TEST(Zoo, OpenBoundariesLeaveValidComplexes) {
    std::vector<NamedLattice> shapes = zoo();
    for (auto& shape : featureLattices()) shapes.push_back(std::move(shape));
    for (auto& shape : meshZoo()) shapes.push_back(std::move(shape));
    for (unsigned seed = 0; seed < kSeeds; ++seed)
        shapes.push_back({"seed " + std::to_string(seed), randomLattice(seed)});
    int leftCount = 0;
    for (const auto& [name, lattice] : shapes) {
        SCOPED_TRACE(name);
        TopologyRefiner refiner(lattice.complex,
                                {.boundary = Boundary::Open, .marks = lattice.marks});
        try {
            refiner.refineUniform(1);
        } catch (const far::TopologyError& error) {
            EXPECT_EQ(error.cause(), far::TopologyCause::EmptyComplex);
            continue;
        }
        ++leftCount;
        EXPECT_NO_THROW(far::validate(refiner.level(1).complex));
    }
    EXPECT_GT(leftCount, shownBySome(200));
}

TEST(Zoo, NamesAreUnique) {
    std::vector<NamedLattice> lattices = zoo();
    for (const auto& named : featureLattices()) lattices.push_back(named);
    for (const auto& all : {meshZoo(), lattices}) {
        std::set<std::string> names;
        for (const auto& [name, lattice] : all) EXPECT_TRUE(names.insert(name).second) << name;
    }
}

/// Returns the numbers of edges at the vertices of a surface, or of each cell at its vertices.
std::set<Index> valences(const CellComplex& complex) {
    std::set<Index> all;
    const int dimension = complex.dimension();
    for (Index whole = 0; whole < (dimension == 2 ? 1 : complex.count(3)); ++whole)
        for (Index vertex = 0; vertex < complex.count(0); ++vertex) {
            Index edges = 0;
            for (const Index edge : complex.relation(0, 1)[vertex])
                edges += dimension == 2 || far::contains(complex.relation(1, 3)[edge], whole);
            all.insert(edges);
        }
    return all;
}

// The zoo has every feature; the names of the meshes tell how they are combined.
TEST(Zoo, MeshesHaveEveryFeature) {
    std::set<Index> faceSizes, valence;
    std::set<Boundary> boundaries;
    std::set<float> edgeSharpness, vertexSharpness;
    std::set<far::SurfaceFans::VertexKind> vertexKinds;
    std::set<Index> finCounts;
    int smooth = 0, chaikin = 0, holes = 0, turned = 0;
    for (const auto& [name, mesh] : meshZoo()) {
        const CellComplex& complex = mesh.complex;
        const Strata strata = refinerOf(mesh).level(0).strata;
        const far::SurfaceFans fans(complex, std::vector<std::uint8_t>(complex.count(2), 1));
        for (Index face = 0; face < complex.count(2); ++face)
            faceSizes.insert(Index(complex.boundary(2)[face].size()));
        valence.merge(valences(complex));
        boundaries.insert(mesh.tags.boundary.value_or(Boundary::Sharp));
        for (Index edge = 0; edge < complex.count(1); ++edge) {
            edgeSharpness.insert(strata.sharpness({1, edge}));
            finCounts.insert(fans.faceCount(edge));
            turned += fans.faceCount(edge) == 2 &&
                      fans.edge(edge) == far::SurfaceFans::EdgeKind::NonManifold;
        }
        for (Index vertex = 0; vertex < complex.count(0); ++vertex) {
            vertexSharpness.insert(strata.sharpness({0, vertex}));
            vertexKinds.insert(fans.vertex(vertex));
        }
        smooth += mesh.tags.triangles == far::TriangleSubdivision::Smooth;
        chaikin += mesh.tags.creasing == Creasing::Chaikin;
        holes += !mesh.marks.holes.empty();
    }
    for (const Index sides : {3, 4, 5, 6, 7, 8, 9, 360}) EXPECT_EQ(faceSizes.count(sides), 1u);
    for (const Index edges : {2, 3, 4, 5, 6, 7, 360}) EXPECT_EQ(valence.count(edges), 1u);
    for (const Index fins : {1, 2, 3, 4, 5}) EXPECT_EQ(finCounts.count(fins), 1u);
    EXPECT_EQ(boundaries.size(), 3u);
    for (const double sharpness : {0.1, 0.7, 1.0, 2.5, 4.7, 9.9, 10.0}) {
        EXPECT_EQ(edgeSharpness.count(far::storedSharpness(sharpness)), 1u) << sharpness;
        EXPECT_EQ(vertexSharpness.count(far::storedSharpness(sharpness)), 1u) << sharpness;
    }
    EXPECT_EQ(vertexKinds.count(far::SurfaceFans::VertexKind::Crease), 1u);
    EXPECT_EQ(vertexKinds.count(far::SurfaceFans::VertexKind::NonManifold), 1u);
    for (const int count : {smooth, chaikin, holes, turned}) EXPECT_GT(count, shownBySome(10));
}

TEST(Zoo, RandomLatticesAreOfAllKinds) {
    std::set<std::vector<Loops>> topologies;
    std::set<Index> types, faceSizes, cellCounts;
    int semiSharp = 0, smooth = 0;
    for (unsigned seed = 0; seed < kSeeds; ++seed) {
        const Lattice lattice = randomLattice(seed);
        topologies.insert(cellLoops(lattice.complex));
        types.merge(valences(lattice.complex));
        for (Index face = 0; face < lattice.complex.count(2); ++face)
            faceSizes.insert(Index(lattice.complex.boundary(2)[face].size()));
        cellCounts.insert(lattice.complex.count(3));
        semiSharp += refinerOf(lattice).level(0).strata.hasSemiSharp();
        smooth += std::any_of(lattice.marks.edges.begin(), lattice.marks.edges.end(),
                              [](const auto& mark) { return mark.sharpness == far::kSmooth; });
    }
    // Some of the smallest lattices occur twice.
    EXPECT_GE(topologies.size(), kSeeds - 10);
    for (const Index edges : {3, 4, 5, 6}) EXPECT_EQ(types.count(edges), 1u) << edges;
    for (const Index sides : {3, 4, 5, 6}) EXPECT_EQ(faceSizes.count(sides), 1u) << sides;
    for (const Index cells : {1, 2, 3, 4, 5, 6}) EXPECT_EQ(cellCounts.count(cells), 1u) << cells;
    EXPECT_GT(semiSharp, 100);
    EXPECT_GT(smooth, 50);
}

TEST(Zoo, RandomLatticesAreReproducible) {
    for (const unsigned seed : {1u, 2u, 3u}) {
        const Lattice first = randomLattice(seed), second = randomLattice(seed);
        EXPECT_EQ(cellLoops(first.complex), cellLoops(second.complex));
        EXPECT_EQ(first.positions, second.positions);
        EXPECT_EQ(first.marks, second.marks);
        EXPECT_EQ(first.tags, second.tags);
    }
}

// The standard specifies the 10,000th number of a default std::mt19937, [rand.predef].
TEST(Zoo, DrawsFollowTheStandard) {
    Draws draws(std::mt19937::default_seed);
    for (int i = 1; i < 10000; ++i) draws.below(2);
    EXPECT_EQ(draws.below(100000), 4123659995 % 100000);
}

}  // namespace
}  // namespace espalier::stencils
