// SPDX-License-Identifier: Apache-2.0
#include <espalier/compare/agreement.h>
#include <espalier/compare/face_varying_comparison.h>

#include <random>

#include "compare/shapes.h"
#include "support/test.h"

namespace espalier::compare {
namespace {

/// Ways to give values to the corners of a mesh.
enum class Seams {
    Charts,   ///< faces are in one of two charts at random
    Corners,  ///< every sixth corner has another value, so seams end inside the mesh
    Shared    ///< as Corners, and vertices share values
};

std::vector<Index> randomValues(const Lattice& mesh, Seams seams, unsigned seed) {
    std::mt19937 random(seed);
    std::vector<Index> values;
    for (Index face = 0; face < mesh.complex.count(2); ++face) {
        const auto chart = static_cast<Index>(random() % 2);
        for (const Index vertex : mesh.complex.relation(2, 0)[face]) {
            const bool isOther = seams == Seams::Charts ? chart == 1 : random() % 6 == 0;
            values.push_back(2 * (seams == Seams::Shared ? vertex / 2 : vertex) + (isOther ? 1 : 0));
        }
    }
    return values;
}

void expectFaceVaryingAgreement(const std::string& name, const Lattice& mesh, int level) {
    const TopologyRefiner refiner = refined(mesh, level);
    unsigned seed = 1;
    for (const Seams seams : {Seams::Charts, Seams::Corners, Seams::Shared})
        for (const auto& [word, linear] : far::kFaceVaryingLinearWords) {
            const auto differences =
                faceVaryingDifferences(refiner, randomValues(mesh, seams, seed++), linear);
            EXPECT_EQ(differences.size(), std::size_t(level));
            for (const double difference : differences)
                EXPECT_LE(difference, Bounds().weight)
                    << name << ", " << word << ", seams " << int(seams);
        }
}

TEST(FaceVaryingAgreement, OfEveryKindOfMesh) {
    for (const auto& [name, mesh] : meshZoo())
        if (name.find("360") == std::string::npos) expectFaceVaryingAgreement(name, mesh, 3);
}

}  // namespace
}  // namespace espalier::compare
