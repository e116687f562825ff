// SPDX-License-Identifier: Apache-2.0
#include <espalier/base/executor.h>
#include <espalier/embed/local_binding.h>
#include <espalier/far/topology_match.h>
#include <espalier/io/displacements.h>
#include <espalier/io/matrices/matrix_file.h>
#include <espalier/io/matrices/matrix_market.h>
#include <espalier/io/pose_file.h>
#include <espalier/io/targets.h>
#include <espalier/osd/binding_evaluator.h>
#include <espalier/shapes/inventory.h>
#include <espalier/stencils/composition.h>
#include <io/every_writer.h>

#include <tuple>

#include "exhaustion.h"
#include "support/folder_contents.h"
#include "support/test.h"

// Failing allocations while files are read and written.
namespace espalier {
namespace {

namespace fs = std::filesystem;
using test::failEachAllocation;

/// Returns true for formats that are not tested here. Destructors of nlohmann-json's values
/// allocate memory, and so end the process if the last bytes of it are gone.
bool isJson(const fs::path& path) {
    return path.extension() == ".glb" || path.extension() == ".gltf";
}

class IoMemory : public testing::Test {
protected:
    SerialExecutor serial;
    const ExecutorScope scope{serial};
    const test::TemporaryFolder folder;
};

TEST_F(IoMemory, EveryWriterKeepsTheOldFile) {
    for (const test::Writer& writer : test::everyWriter(3)) {
        if (isJson(writer.name)) continue;
        SCOPED_TRACE(writer.name);
        const test::TemporaryFolder own;
        const fs::path path = own / writer.name;
        writer.write(path);
        const auto written = test::contentsOf(own.path());
        auto old = written;
        for (auto& [name, bytes] : old) test::putLatticeFile(own / name, bytes = "old");
        failEachAllocation(
            [&] {
                writer.write(path);
                return true;
            },
            [&] {
                // The new file must be complete, and nothing else in the folder.
                const auto now = test::contentsOf(own.path());
                if (now == old) return;
                EXPECT_TRUE(now == written);
                for (const auto& [name, bytes] : old) test::putLatticeFile(own / name, bytes);
            });
    }
}

TEST_F(IoMemory, Lattices) {
    const Lattice lattice = test::withMarksAndAttributes(test::polyhedralLattice());
    std::vector<fs::path> paths;
    for (const char* name : {"a.ovm", "a.vtk"}) paths.push_back(folder / name);
    for (const fs::path& path : paths) io::writeLattice(path, lattice);
    // VTK wrote these files.
    const fs::path data = fs::path(ESPALIER_SOURCE_DIR) / "tests/io/data";
    for (const char* name : {"ascii.vtu", "base64-le-32.vtu", "base64-zlib-be-64.vtu",
                             "raw-zlib-be-32.vtu", "legacy-binary-42.vtk", "legacy-binary-51.vtk"})
        paths.push_back(data / name);
    for (const fs::path& path : paths) {
        SCOPED_TRACE(path);
        failEachAllocation([&] {
            const Lattice read = io::readLattice(path);
            return std::tuple(test::bitsOf(read.positions), read.marks,
                              far::topologyHash(read.complex), read.attributes.size());
        });
    }
}

TEST_F(IoMemory, Meshes) {
    const fs::path path = folder / "mesh.obj";
    test::putLatticeFile(path,
                         "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nv 2 0 0\nv 2 1 0\nf 1 2 3 4\n"
                         "f 2 5 6 3\nt crease 2/1/0 1 2 2.5\nt corner 1/1/0 0 10\n"
                         "t hole 1/0/0 1\nt interpolateboundary 1/0/0 2\n");
    failEachAllocation([&] {
        const Lattice mesh = io::readRefinable(path);
        return std::tuple(mesh.positions, mesh.marks);
    });
    const Lattice mesh = io::readRefinable(path);
    failEachAllocation([&] {
        io::writeRefinable(folder / "out.obj", mesh);
        return true;
    });
}

TEST_F(IoMemory, Models) {
    std::string ply =
        "ply\nformat binary_little_endian 1.0\nelement vertex 3\nproperty float x\n"
        "property float y\nproperty float z\nend_header\n";
    ply += std::string(36, '\0');
    std::string stl(80, ' ');
    stl += std::string("\1\0\0\0", 4) + std::string(50, '\0');
    std::vector<std::pair<std::string, std::string>> files = {{"b.ply", ply}, {"b.stl", stl}};
    files.emplace_back("faces.obj", test::modelText(".obj", 3) + test::facesOfObj(3));
    for (const std::string& extension : test::modelExtensions())
        files.emplace_back("a" + extension, test::modelText(extension, 3));
    for (const std::string extension : test::kMeshExtensions)
        files.emplace_back(test::fileOfMesh(extension), test::meshText(extension, 3));
    for (const auto& [name, bytes] : files) {
        if (isJson(name)) continue;
        SCOPED_TRACE(name);
        const fs::path path = folder / name;
        test::putLatticeFile(path, bytes);
        failEachAllocation([&] {
            const auto model = io::readModel(path);
            const io::ModelSurface surface = model->readSurface();
            return std::tuple(std::vector(model->positions().begin(), model->positions().end()),
                              surface.faces.corners, surface.normals);
        });
    }
}

TEST_F(IoMemory, EditorMeshes) {
    const Lattice rest = test::rowOfCells(2);
    for (const char* name : {"editor.obj", "editor.ply"}) {
        io::writeEditorMesh(folder / name, rest);
        failEachAllocation([&] { return io::readPose(folder / name, rest); });
    }
}

TEST_F(IoMemory, OtherFiles) {
    for (const test::Writer& writer : test::everyWriter(3)) writer.write(folder / writer.name);
    failEachAllocation([&] { return io::readBoundModel(folder / "a.espb").binding; });
    failEachAllocation([&] { return io::readMatrix(folder / "D.mtx"); });
    test::putLatticeFile(folder / "t.txt",
                         "# point, and where it should go\n1 0.5 0.5 1\n0 1 2 3\n");
    failEachAllocation([&] { return io::readTargets(folder / "t.txt", 2).size(); });
    failEachAllocation([&] { return io::readDisplacements("d.csv", 2, "1,0,0,1\n").size(); });
}

TEST_F(IoMemory, ReadBindAndWrite) {
    io::writeLattice(folder / "rest.vtu", shapes::box());
    test::putLatticeFile(folder / "model.obj", "v 0.5 0.5 0.5\nv 0.25 0.75 0.1\nv 7 7 7\n");
    failEachAllocation([&] {
        const auto model = io::readModel(folder / "model.obj");
        const Lattice rest = io::readLattice(folder / "rest.vtu");
        TopologyRefiner refiner(rest.complex, {.marks = rest.marks});
        const auto binding =
            bind::bindPoints({refiner, rest.positions}, model->positions(), bind::Level{1});
        refiner.refineUniform(1);
        const auto table = stencils::buildStencils(refiner, 1);
        io::writeMatrix(folder / "S.npy", table);
        model->write(folder / "moved.obj", osd::evaluateBinding(binding, rest.positions));
        return binding;
    });
    EXPECT_EQ(test::contentsOf(folder.path()).size(), 6u) << "no file that is half written";
}

// A bad file gives its usual error, or std::bad_alloc, and never another error.
TEST_F(IoMemory, Refusals) {
    for (const auto& [name, bytes] :
         {std::pair("a.ovm", "OVM ASCII\nVertices\n2\n0 0 0\n1 x 0\n"),
          std::pair("a.vtk", "# vtk DataFile Version 3.0\n\nASCII\nx"),
          std::pair("a.vtu", "<VTKFile><a></b></VTKFile>"), std::pair("a.obj", "v 0 0\n")}) {
        const fs::path path = folder / name;
        test::putLatticeFile(path, bytes);
        const auto message = [&] {
            return test::messageOf<io::FileError>([&] { io::readRefinable(path); });
        };
        EXPECT_TRUE(message().starts_with(path.string() + ":")) << message();
        failEachAllocation(message);
    }
}

}  // namespace
}  // namespace espalier
