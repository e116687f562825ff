// SPDX-License-Identifier: Apache-2.0
#include <espalier/io/lattice_file.h>
#include <espalier/io/model.h>
#include <espalier/io/pose_file.h>
#include <espalier/io/read_notes.h>
#include <espalier/shapes/inventory.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <vector>

#include "fuzz_target.h"
#include "support/temporary_folder.h"
#include "written.h"

namespace espalier::fuzz {
namespace {

/// Makes gradients from the bytes of an input. They have all sizes and signs, and some are
/// singular.
std::vector<DeformationGradient> gradientsFrom(std::string_view bytes, std::size_t count) {
    std::vector<DeformationGradient> gradients(count);
    std::size_t next = 0;
    for (DeformationGradient& gradient : gradients) {
        for (double& entry : gradient) {
            const auto byte = static_cast<unsigned char>(bytes[next++ % bytes.size()]);
            entry = std::scalbn(static_cast<double>(byte % 8) - 3, byte >= 0xFC ? 900 : byte / 64);
        }
    }
    return gradients;
}

/// Requires that a model is written in another format with all its points, or that it is refused
/// with the reason.
void requireConverted(const io::Model& model, const io::ModelSurface& surface,
                      const std::string& name) {
    const auto losses = readResult(name, [&] { return model.checkTarget(name); });
    if (!losses) return;
    if (!losses->empty()) requireOneLine(*losses);
    const auto bytes = resultOf([&] {
        return written(name, [&](const auto& path) { model.write(path, model.positions()); });
    });
    // Only floats may be too small for a point.
    const bool isStl = name.ends_with(".stl");
    require(bytes || isStl || name.ends_with(".glb"), "a model that can be converted is converted",
            name);
    if (!bytes) return;
    const auto back = io::readModel(name, *bytes);
    const io::ModelSurface copy = back->readSurface();
    if (isStl) {
        require(back->positions().size() == 3 * copy.faces.count(), "an STL has triangles");
        return;
    }
    require(copy.others.empty(), "a converted model has nothing but points, faces and normals");
    // glTF splits points, and rounds them.
    if (surface.dropsLoosePoints || name.ends_with(".glb")) return;
    require(std::ranges::equal(back->positions(), model.positions()), "points come back");
    require(copy.faces.count() <= surface.faces.count(), "no face is added");
}

/// Requires that each attribute has a number for each point, and that groups have points that
/// exist. Few of them: the header of a small file may claim thousands of columns.
void requireParts(const std::string& name, const io::Model& model) {
    constexpr std::size_t kMost = 4;
    const std::size_t pointCount = model.positions().size();
    const auto attributes = readResult(name, [&] { return model.attributes(); });
    for (std::size_t i = 0; attributes && i < std::min(attributes->size(), kMost); ++i)
        if (const auto numbers = readResult(name, [&] { return (*attributes)[i].read(); }))
            require(numbers->size() == pointCount, "an attribute has a number for each point");
    const auto groups = readResult(name, [&] { return model.groups(); });
    for (std::size_t i = 0; groups && i < std::min(groups->size(), kMost); ++i)
        if (const auto points = readResult(name, [&] { return (*groups)[i].read(); }))
            for (const Index point : *points)
                require(point >= 0 && static_cast<std::size_t>(point) < pointCount,
                        "the points of a group exist");
}

/// Requires that a model is refused, or is written unchanged if no point moves and all gradients
/// are the identity, and otherwise with all its points at their new positions.
/// \param name file name, whose extension gives the format
void runModel(const std::string& name, std::string_view bytes) {
    const auto read = readResult(name, [&] { return io::readModel(name, std::string(bytes)); });
    if (!read) return;
    const io::Model& model = **read;
    if (const std::string notes = io::describe(name, model); !notes.empty()) requireOneLine(notes);
    for (const Point3& point : model.positions())
        for (const double coordinate : point)
            require(std::isfinite(coordinate), "points are finite");
    const auto writtenWith = [&](const io::Model& of, const auto&... arguments) {
        return written(name, [&](const auto& path) { of.write(path, arguments...); });
    };
    require(writtenWith(model, model.positions()) == bytes,
            "a model that has not moved is written byte for byte");
    const std::vector<DeformationGradient> still(model.positions().size(),
                                                 {1, 0, 0, 0, 1, 0, 0, 0, 1});
    require(writtenWith(model, model.positions(), still) == bytes,
            "a model whose directions have not turned is written byte for byte");

    // Positions are halved, so that no point leaves the range of its numbers.
    std::vector<Point3> moved(model.positions().begin(), model.positions().end());
    for (Point3& point : moved)
        for (double& coordinate : point) coordinate = coordinate / 2 + 1;
    // A mesh of two dimensions stays in its plane.
    if (!resultOf([&] { return writtenWith(model, moved); }))
        for (Point3& point : moved) point[2] = 0;
    const std::vector<Point3> stored = model.stored(moved);
    const auto requireMoved = [&](const std::string& once) {
        const auto back = io::readModel(name, once);
        require(back->hasDirections() == model.hasDirections(), "a moved model has its directions");
        require(back->positions().size() == moved.size(), "a moved model has all its points");
        for (std::size_t i = 0; i < moved.size(); ++i)
            for (std::size_t axis = 0; axis < 3; ++axis) {
                const double wanted = moved[i][axis];
                const double got = back->positions()[i][axis];
                require(got == wanted || got == stored[i][axis] ||
                            got == double{static_cast<float>(wanted)},
                        "a moved point is where it was put");
            }
    };
    requireMoved(writtenWith(model, moved));
    requireMoved(writtenWith(model, moved, gradientsFrom(bytes, moved.size())));

    requireParts(name, model);
    const auto surface = readResult(name, [&] { return model.readSurface(); });
    if (!surface) return;
    for (const Index corner : surface->faces.corners)
        require(corner >= 0 && static_cast<std::size_t>(corner) < moved.size(),
                "the corners of faces are points");
    for (const std::string extension : {".obj", ".ply", ".stl", ".glb", ".vtu", ".vtp", ".vtk"})
        if (extension != model.extension()) requireConverted(model, *surface, "b" + extension);
}

/// Requires that a glTF file is refused, or is written byte for byte at rest and else with all its
/// points. The coordinates are not compared: they go through matrices of any kind.
void runGltf(std::string_view bytes) {
    const std::string name = bytes.starts_with("glTF") ? "a.glb" : "a.gltf";
    const auto read = readResult(name, [&] { return io::readModel(name, std::string(bytes)); });
    if (!read) return;
    const io::Model& model = **read;
    if (const std::string notes = io::describe(name, model); !notes.empty()) requireOneLine(notes);
    const auto writtenWith = [&](const std::string& target, const auto&... arguments) {
        return written(target, [&](const auto& path) { model.write(path, arguments...); });
    };
    require(writtenWith(name, model.positions()) == bytes,
            "a model that has not moved is written byte for byte");
    std::vector<Point3> moved(model.positions().begin(), model.positions().end());
    for (Point3& point : moved)
        for (double& coordinate : point) coordinate = coordinate / 2 + 1;
    // Matrices can take a point beyond the floats.
    const auto once =
        resultOf([&] { return writtenWith("b.glb", moved, gradientsFrom(bytes, moved.size())); });
    if (once)
        require(io::readModel("b.glb", *once)->positions().size() == moved.size(),
                "a moved model has all its points");
    requireParts(name, model);
    const auto surface = readResult(name, [&] { return model.readSurface(); });
    if (!surface) return;
    for (const Index corner : surface->faces.corners)
        require(corner >= 0 && static_cast<std::size_t>(corner) < moved.size(),
                "the corners of faces are points");
    for (const std::string extension : {".obj", ".ply", ".stl"})
        requireConverted(model, *surface, "b" + extension);
}

/// Requires that an editor mesh is refused as a pose, or gives a position for each vertex.
void runEditorMesh(std::string_view bytes) {
    static const Lattice rest = shapes::box({.cells = {2, 1, 1}});
    static const test::TemporaryFolder folder;
    const auto path = folder / (bytes.starts_with("ply") ? "a.ply" : "a.obj");
    std::ofstream(path, std::ios::binary) << bytes;
    const auto pose = readResult(path.string(), [&] { return io::readPose(path, rest); });
    if (!pose) return;
    require(pose->size() == rest.positions.size(), "a pose has a position for each vertex");
}

/// Reads the faces and the cells of a mesh, also as a lattice; each is refused or valid.
void runMesh(const std::string& name, std::string_view bytes) {
    runModel(name, bytes);
    const auto read = resultOf([&] { return io::readModel(name, std::string(bytes)); });
    if (!read) return;
    const auto pointCount = static_cast<Index>((*read)->positions().size());
    if (const auto volume = readResult(name, [&] { return (*read)->readCells(); })) {
        const far::VolumeMesh& mesh = volume->volume;
        require(mesh.cellCount() == 0 || mesh.pointCount() == pointCount,
                "a volume has the points of its model");
        for (Index face = 0; face < mesh.faceCount(); ++face)
            for (const Index point : mesh.face(face))
                require(point >= 0 && point < pointCount, "a face names points that exist");
    }
    readResult(name, [&] { return (*read)->readSurface(); });
    if (const auto lattice = readResult(name, [&] { return io::readLattice(name, bytes); }))
        far::validate(lattice->complex);
}

const Target kObj("obj", [](std::string_view bytes) { runModel("a.obj", bytes); });
const Target kPly("ply", [](std::string_view bytes) { runModel("a.ply", bytes); });
const Target kGltf("gltf", runGltf);
const Target kStl("stl", [](std::string_view bytes) { runModel("a.stl", bytes); });
const Target kVtuModel("vtu_model", [](std::string_view bytes) { runMesh("a.vtu", bytes); });
const Target kVtp("vtp", [](std::string_view bytes) { runModel("a.vtp", bytes); });
const Target kVtkModel("vtk_model", [](std::string_view bytes) { runModel("a.vtk", bytes); });
const Target kEditorMesh("editor_mesh", runEditorMesh);
const Target kSu2("su2", [](std::string_view bytes) { runMesh("a.su2", bytes); });
const Target kGmsh("msh", [](std::string_view bytes) { runMesh("a.msh", bytes); });
const Target kMedit("mesh", [](std::string_view bytes) { runMesh("a.mesh", bytes); });
const Target kNastran("bdf", [](std::string_view bytes) { runMesh("a.bdf", bytes); });
const Target kAbaqus("inp", [](std::string_view bytes) { runMesh("a.inp", bytes); });
const Target kIdeas("unv", [](std::string_view bytes) { runMesh("a.unv", bytes); });
const Target kFluent("fluent", [](std::string_view bytes) { runMesh("a.cas", bytes); });
const Target kPlot3d("plot3d", [](std::string_view bytes) { runMesh("a.xyz", bytes); });
const Target kFoam("foam", [](std::string_view bytes) { runModel("points", bytes); });

}  // namespace
}  // namespace espalier::fuzz
