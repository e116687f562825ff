// SPDX-License-Identifier: Apache-2.0
#include <espalier/compare/agreement.h>
#include <espalier/compare/face_varying_comparison.h>
#include <espalier/io/lattice_file.h>

#include <filesystem>
#include <random>
#include <set>

#include "compare/shapes.h"
#include "support/shared_data.h"
#include "support/test.h"

namespace espalier::compare {
namespace {

/// Gives values to the corners of a mesh: two charts with a seam between them, and random vertices
/// where one corner, or each corner, has a separate value. OpenSubdiv's result depends on the order
/// of the faces if a value occurs in two fans at a vertex, so each corner of such vertices has a
/// separate value.
std::vector<Index> randomValues(const Lattice& mesh, unsigned seed) {
    const far::CellComplex& complex = mesh.complex;
    std::mt19937 random(seed);
    const auto firstOfSecond = static_cast<Index>(random() % std::uint32_t(complex.count(2)));
    const auto chartOf = [&](Index face) { return face < firstOfSecond ? 0 : 1; };
    enum class Kind { Charts, OneCorner, EachCorner };
    std::vector<Kind> kinds;
    for (Index vertex = 0; vertex < complex.count(0); ++vertex) {
        int changes = 0;
        bool isInside = true;
        for (const Index edge : complex.relation(0, 1)[vertex]) {
            const auto faces = complex.relation(1, 2)[edge];
            isInside &= faces.size() == 2;
            if (faces.size() == 2) changes += chartOf(faces[0]) != chartOf(faces[1]) ? 1 : 0;
        }
        const auto chance = random() % 6;
        kinds.push_back(changes > (isInside ? 2 : 1) || chance == 0 ? Kind::EachCorner
                        : isInside && changes == 0 && chance == 1   ? Kind::OneCorner
                                                                    : Kind::Charts);
    }
    const Index width = 2 + complex.count(2);
    std::vector<Index> values;
    for (Index face = 0; face < complex.count(2); ++face)
        for (const Index vertex : complex.relation(2, 0)[face]) {
            const Kind kind = kinds[vertex];
            const bool isFirst = complex.relation(0, 2)[vertex].front() == face;
            values.push_back(vertex * width + (kind == Kind::EachCorner ? 2 + face
                                               : kind == Kind::Charts   ? chartOf(face)
                                               : isFirst                ? 1
                                                                        : 0));
        }
    return values;
}

void expectFaceVaryingAgreement(const std::string& name, const Lattice& mesh, int level) {
    const TopologyRefiner refiner = refined(mesh, level);
    for (unsigned seed = 1; seed <= 3; ++seed)
        for (const auto& [word, linear] : far::kFaceVaryingLinearWords) {
            // The header of refineFaceVarying() names this difference.
            if (refiner.level(0).strata.hasSemiSharp() &&
                (linear == far::FaceVaryingLinear::CornersPlus1 ||
                 linear == far::FaceVaryingLinear::CornersPlus2))
                continue;
            const auto differences =
                faceVaryingDifferences(refiner, randomValues(mesh, seed), linear);
            EXPECT_EQ(differences.size(), std::size_t(level));
            for (const double difference : differences)
                EXPECT_LE(difference, Bounds().weight)
                    << name << ", " << word << ", seams " << seed;
        }
}

TEST(FaceVaryingAgreement, OfEveryKindOfMesh) {
    for (const auto& [name, mesh] : meshZoo())
        if (name.find("360") == std::string::npos && mesh.tags.creasing != far::Creasing::Chaikin)
            expectFaceVaryingAgreement(name, mesh, 2);
}

/// Returns true if the faces that have one value at a vertex form several fans.
bool hasSplitFans(const Lattice& mesh) {
    const auto cut =
        far::refineFaceVarying(TopologyRefiner(mesh.complex), mesh.textureCoordinates.corners,
                               far::FaceVaryingLinear::None);
    const far::CellComplex& complex = cut.refiner.level(0).complex;
    for (Index vertex = 0; vertex < complex.count(0); ++vertex) {
        // The faces that can be reached from the first one over edges at the vertex.
        std::set<Index> reached = {complex.relation(0, 2)[vertex][0]};
        for (std::size_t before = 0; before != reached.size();) {
            before = reached.size();
            for (const Index edge : complex.relation(0, 1)[vertex]) {
                const auto faces = complex.relation(1, 2)[edge];
                if (std::ranges::any_of(faces, [&](Index f) { return reached.contains(f); }))
                    reached.insert(faces.begin(), faces.end());
            }
        }
        if (reached.size() < complex.relation(0, 2)[vertex].size()) return true;
    }
    return false;
}

/// OpenSubdiv's regression shapes with their texture coordinates.
TEST(FaceVaryingAgreement, OfSharedSurfaces) {
    const std::filesystem::path folder = sharedData() / "surfaces";
    if (!std::filesystem::exists(folder))
        GTEST_SKIP() << folder << " is absent: set ESPALIER_SHARED_DATA to have it read";
    int count = 0, tagged = 0, split = 0;
    for (const auto& entry : std::filesystem::directory_iterator(folder)) {
        const Lattice mesh = io::readRefinable(entry.path());
        if (mesh.textureCoordinates.empty()) continue;
        ++count;
        if (mesh.tags.faceVarying) ++tagged;
        const bool isSplit = hasSplitFans(mesh);
        if (isSplit) ++split;
        const TopologyRefiner refiner = refined(mesh, mesh.complex.count(2) > 1000 ? 1 : 2);
        for (const auto& [word, linear] : far::kFaceVaryingLinearWords) {
            // The header of refineFaceVarying() names this difference.
            if (isSplit && linear == far::FaceVaryingLinear::None) continue;
            for (const double difference :
                 faceVaryingDifferences(refiner, mesh.textureCoordinates.corners, linear))
                EXPECT_LE(difference, Bounds().weight) << entry.path() << ", " << word;
        }
    }
    EXPECT_EQ(count, 22);
    EXPECT_EQ(tagged, 1);
    EXPECT_EQ(split, 4);
}

}  // namespace
}  // namespace espalier::compare
