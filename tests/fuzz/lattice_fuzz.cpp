// SPDX-License-Identifier: Apache-2.0
#include <espalier/far/topology_match.h>
#include <espalier/io/lattice_file.h>
#include <espalier/shapes/refiner_options.h>
#include <espalier/stencils/refined_lattice.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "fuzz_target.h"
#include "support/lattice_identity.h"
#include "written.h"

namespace espalier::fuzz {
namespace {

/// Returns the bits of numbers. All NaNs have the bits of the same NaN, because text does not
/// distinguish them.
std::vector<std::uint64_t> bitsInText(std::vector<double> values) {
    for (double& value : values)
        if (std::isnan(value)) value = std::numeric_limits<double>::quiet_NaN();
    return test::bitsOf(values);
}

void requireSame(const Lattice& got, const Lattice& expected) {
    const int dimension = expected.complex.dimension();
    require(got.complex.dimension() == dimension, "the dimension comes back");
    for (int d = 0; d <= dimension; ++d)
        require(got.complex.count(d) == expected.complex.count(d), "all entities come back");
    if (dimension == 3)
        require(test::orientedCells(got.complex) == test::orientedCells(expected.complex),
                "cells come back, turned as they were");
    if (dimension == 2)
        require(!far::topologyDifference(got.complex, expected.complex), "faces come back");
    require(test::bitsOf(got.positions) == test::bitsOf(expected.positions),
            "positions come back bit for bit");
    require(got.marks == expected.marks, "marks come back");
    require(got.tags == expected.tags, "tags come back");
    const auto& textures = expected.textureCoordinates;
    require(got.textureCoordinates.corners == textures.corners, "corners keep their textures");
    if (!textures.empty())
        require(test::bitsOf(got.textureCoordinates.values) == test::bitsOf(textures.values),
                "texture coordinates come back bit for bit");
    require(got.attributes.size() == expected.attributes.size(), "attributes come back");
    for (std::size_t i = 0; i < got.attributes.size(); ++i) {
        const VertexAttribute &one = got.attributes[i], &other = expected.attributes[i];
        require(one.name == other.name && one.components == other.components &&
                    bitsInText(one.values) == bitsInText(other.values),
                "an attribute comes back bit for bit", other.name);
    }
    require(got.integers.size() == expected.integers.size(), "integers come back");
    for (std::size_t i = 0; i < got.integers.size(); ++i) {
        const VertexIntegers &one = got.integers[i], &other = expected.integers[i];
        require(one.name == other.name && one.components == other.components &&
                    one.values == other.values,
                "integers come back", other.name);
    }
}

/// Requires that a file of a curve, a mesh or a lattice is refused, or gives a valid one that is
/// the same after writing and reading it.
/// \param name file name, whose extension gives the format
void runLattice(const std::string& name, std::string_view bytes) {
    const auto lattice = readResult(name, [&] { return io::readRefinable(name, bytes); });
    if (!lattice) return;
    far::validate(lattice->complex);
    far::readMarks(lattice->complex, lattice->marks);
    const auto vertexCount = static_cast<std::size_t>(lattice->complex.count(0));
    require(lattice->positions.size() == vertexCount, "a position for each vertex");
    for (const VertexAttribute& attribute : lattice->attributes)
        require(
            attribute.values.size() == vertexCount * static_cast<std::size_t>(attribute.components),
            "an attribute has its values for each vertex", attribute.name);

    // Writers refuse some lattices that readers accept: OBJ refuses positions that are not finite,
    // other formats some names of attributes.
    const auto once = resultOf([&] {
        return written(name, [&](const auto& path) { io::writeRefinable(path, *lattice); });
    });
    if (!once) return;
    requireSame(io::readRefinable(name, *once), *lattice);
}

/// Refines a mesh once. Requires that each corner of its faces names a texture coordinate, that the
/// texture coordinates stay near the texture coordinates of the file, and that the mode is kept.
/// \param bytes the mode, and then an OBJ
void runFaceVarying(std::string_view bytes) {
    constexpr Index kMaxFaces = 200;  // refining more takes too long
    Input input(bytes);
    const auto mode = far::kFaceVaryingLinearWords[input.choice(6)].choice;
    const auto mesh = resultOf([&] {
        return io::readRefinable("a.obj", bytes.substr(std::min<std::size_t>(1, bytes.size())));
    });
    if (!mesh || mesh->textureCoordinates.empty() || mesh->complex.count(2) > kMaxFaces) return;
    const auto refined = resultOf([&] {
        far::TopologyRefiner refiner(mesh->complex, refinerOptions(*mesh));
        refiner.refineUniform(1);
        return stencils::refinedLattice(refiner, 1, *mesh, mode);
    });
    if (!refined) return;
    const FaceVaryingAttribute& textures = refined->textureCoordinates;
    require(textures.corners.size() == refined->complex.relation(2, 0).values().size(),
            "each corner has a texture coordinate");
    require(refined->tags.faceVarying == mode, "the refined mesh has the mode");
    double largest = 0;
    for (const double value : mesh->textureCoordinates.values)
        largest = std::max(largest, std::abs(value));
    // Weights of surfaces are at most 2 in sum of absolute values: (n - 3)/n is -2 for n = 1.
    if (largest < 1e300)
        for (const double value : textures.values)
            require(std::abs(value) <= 8 * largest, "texture coordinates stay near those before");
    for (const Index corner : textures.corners)
        require(corner >= 0 && 2 * static_cast<std::size_t>(corner) + 1 < textures.values.size(),
                "corners name texture coordinates");
}

const Target kOvm("ovm", [](std::string_view bytes) { runLattice("a.ovm", bytes); });
const Target kVtu("vtu", [](std::string_view bytes) { runLattice("a.vtu", bytes); });
const Target kVtk("vtk", [](std::string_view bytes) { runLattice("a.vtk", bytes); });
const Target kObjMesh("obj_mesh", [](std::string_view bytes) { runLattice("a.obj", bytes); });
const Target kFaceVarying("face_varying", runFaceVarying);

}  // namespace
}  // namespace espalier::fuzz
