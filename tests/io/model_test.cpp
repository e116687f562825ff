// SPDX-License-Identifier: Apache-2.0
#include <espalier/io/lattice_file.h>
#include <espalier/io/model.h>
#include <io/gradient_samples.h>
#include <io/model_files.h>

#include "support/shared_data.h"

namespace espalier::io {
namespace {

const std::string kTriangle = "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n";

TEST(Model, ExtensionMayBeInUpperOrLowerCase) {
    EXPECT_EQ(readModel("a.obj", kTriangle)->extension(), ".obj");
    EXPECT_EQ(readModel("a.OBJ", kTriangle)->extension(), ".obj");
    EXPECT_EQ(readModel("a.b.Obj", kTriangle)->positions().size(), 3u);
}

TEST(Model, RefusesUnknownExtensionsAndListsKnownOnes) {
    for (const char* name : {"model.fbx", "model", "obj", ".obj"})
        EXPECT_REFUSED(FileError, ".obj, .ply, .stl, .vtu", readModel(name, kTriangle)) << name;
}

TEST(Model, MayBeAnUnstructuredGrid) {
    const std::string text =
        "<VTKFile type='UnstructuredGrid' version='1.0' byte_order='LittleEndian'>\n"
        "<UnstructuredGrid><Piece NumberOfPoints='1' NumberOfCells='0'>\n"
        "<Points><DataArray type='Float32' NumberOfComponents='3' format='ascii'>\n"
        "1 2 3.5\n"
        "</DataArray></Points><Cells/></Piece></UnstructuredGrid></VTKFile>\n";
    const auto model = readModel("a.VTU", text);
    EXPECT_EQ(model->extension(), ".vtu");
    EXPECT_THAT(model->positions(), ElementsAre(Point3{1, 2, 3.5}));
    EXPECT_EQ(written(*model, model->positions()), text);
    const auto again = readModel("b.vtu", written(*model, std::vector<Point3>{{4, 5, 6}}));
    EXPECT_THAT(again->positions(), ElementsAre(Point3{4, 5, 6}));
    EXPECT_REFUSED(FileError, "none.vtu:1: ", readModel("none.vtu", "<VTKFile"));
}

TEST(Model, IsReadFromAFileAsFromMemory) {
    const TemporaryFolder folder;
    putFile(folder / "a.obj", kTriangle);
    const auto model = readModel(folder / "a.obj");
    EXPECT_EQ(copyOf(model->positions()), copyOf(readModel("none/a.obj", kTriangle)->positions()));
    EXPECT_EQ(written(*model, model->positions()), kTriangle);
}

TEST(Model, RefusesAMissingFile) {
    const TemporaryFolder folder;
    EXPECT_REFUSED(FileError, "none.obj: cannot open", readModel(folder / "none.obj"));
}

TEST(Model, RefusesAModelWithoutPoints) {
    const std::string header =
        "ply\nformat ascii 1.0\nelement vertex 0\nproperty float x\n"
        "property float y\nproperty float z\nend_header\n";
    EXPECT_REFUSED(FileError, "no points", readModel("a.obj", "# nothing\n"));
    EXPECT_REFUSED(FileError, "no points", readModel("a.ply", header));
    EXPECT_REFUSED(FileError, "no points", readModel("a.stl", "solid\nendsolid\n"));
}

TEST(Model, WrongNumberOfPositionsIsRefusedWithBothNumbers) {
    const auto model = readModel("a.obj", kTriangle);
    const std::vector<Point3> two(2);
    EXPECT_THAT([&] { written(*model, two); },
                ThrowsMessage<Error>(AllOf(HasSubstr("2 positions"), HasSubstr("3 points"))));
}

TEST(Model, NonFinitePositionIsRefusedAndKeepsTheOldFile) {
    const TemporaryFolder folder;
    putFile(folder / "out.obj", "old");
    const auto model = readModel("a.obj", kTriangle);
    auto moved = copyOf(model->positions());
    moved[1][2] = kNan;
    EXPECT_REFUSED(Error, "point 1 is not finite", model->write(folder / "out.obj", moved));
    EXPECT_EQ(readFile(folder / "out.obj"), "old");
}

TEST(Model, RefusesGradientsOfWrongNumberOrNotFinite) {
    const auto model = readModel("a.obj", kTriangle);
    std::vector<DeformationGradient> gradients(2, kIdentity);
    const auto write = [&] { written(*model, model->positions(), gradients); };
    EXPECT_THAT(write,
                ThrowsMessage<Error>(AllOf(HasSubstr("2 gradients"), HasSubstr("3 points"))));
    gradients.clear();
    EXPECT_THAT(write, ThrowsMessage<Error>(HasSubstr("0 gradients")));
    gradients.assign(3, kIdentity);
    EXPECT_EQ(written(*model, model->positions(), gradients), kTriangle);
    gradients[2][5] = kInfinity;
    EXPECT_THAT(write, ThrowsMessage<Error>(HasSubstr("the gradient of point 2 is not finite")));
}

TEST(Model, OtherExtensionsAreRefused) {
    EXPECT_REFUSED(FileError,
                   "a.off: is not of a known model format; expected .obj, .ply, .stl, .vtu, .vtp, "
                   ".vtk, .glb or .gltf, or the mesh of a simulation (",
                   readModel("a.off", ""));
    for (const std::string name : {"a.vtm", "a.PVTU"})
        EXPECT_REFUSED(FileError,
                       name +
                           ": lists other files; name one of these files (.obj, .ply, .stl, "
                           ".vtu, .vtp, .vtk, .glb or .gltf)",
                       readModel(name, ""));
}

/// A name without the extension of a format may be the folder of a case.
TEST(Model, MissingFilesAndFoldersAreNamedAsSuch) {
    for (const std::string name : {"/tmp/no-case", "/tmp/no-case/", "no-case.1", "a.off"}) {
        const std::string cause = name + ": no such file or folder";
        EXPECT_REFUSED(FileError, cause, readModel(name));
        EXPECT_REFUSED(FileError, cause, readLattice(name));
        EXPECT_REFUSED(FileError, cause, readRefinable(name));
    }
    EXPECT_REFUSED(FileError, "no.msh: cannot open: No such file or directory",
                   readModel("no.msh"));
}

TEST(Model, SharedModelsRoundTripByteForByte) {
    const auto folder = sharedData() / "models";
    if (!std::filesystem::exists(folder))
        GTEST_SKIP() << folder << " is absent: set ESPALIER_SHARED_DATA to have it read";
    // The number of `v` lines in each file, counted by grep -c '^v '.
    const std::pair<const char*, std::size_t> expected[] = {
        {"rocker-arm.obj", 10044}, {"spot.obj", 2930}, {"stanford-bunny.obj", 35947}};
    for (const auto& [name, count] : expected) {
        const auto model = readModel(folder / name);
        EXPECT_EQ(model->positions().size(), count) << name;
        // On failure, EXPECT_EQ would print megabytes.
        EXPECT_TRUE(written(*model, model->positions()) == readFile(folder / name)) << name;
    }
}

}  // namespace
}  // namespace espalier::io
