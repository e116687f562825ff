// SPDX-License-Identifier: Apache-2.0
#include <espalier/io/formats.h>
#include <espalier/io/lattice_file.h>
#include <espalier/io/model.h>
#include <io/every_writer.h>

#include <algorithm>
#include <set>
#include <string>
#include <vector>

#include "support/temporary_folder.h"
#include "support/test.h"

namespace espalier::io {
namespace {

constexpr FileContent kContents[] = {
    FileContent::Lattice,    FileContent::Mesh,    FileContent::Model,
    FileContent::EditorMesh, FileContent::Matrix,  FileContent::Animation,
    FileContent::BoundModel, FileContent::Targets, FileContent::Displacements};

constexpr FileUse kUses[] = {FileUse::Read, FileUse::Write};

TEST(Formats, AreFoundByTheirExtensionInUpperAndLowerCase) {
    for (const FileContent content : kContents)
        for (const FileUse use : kUses)
            for (const std::string& extension : extensionsOf(content, use)) {
                std::string upper = extension;
                std::ranges::transform(upper, upper.begin(), [](char c) {
                    return c >= 'a' && c <= 'z' ? static_cast<char>(c - 'a' + 'A') : c;
                });
                EXPECT_TRUE(isFileOf(content, "folder/a.b" + extension, use)) << extension;
                EXPECT_TRUE(isFileOf(content, "a" + upper, use)) << upper;
                EXPECT_FALSE(isFileOf(content, "a" + extension + "x", use)) << extension;
            }
}

TEST(Formats, HaveNoExtensionTwice) {
    for (const FileContent content : kContents)
        for (const FileUse use : kUses) {
            const auto extensions = extensionsOf(content, use);
            EXPECT_EQ(std::set(extensions.begin(), extensions.end()).size(), extensions.size());
        }
}

TEST(Formats, OfLatticesAndModelsAreListedWithTheMeshesApart) {
    EXPECT_EQ(listOfFormats(FileContent::Lattice, FileUse::Write), ".ovm, .vtu or .vtk");
    EXPECT_EQ(listOfFormats(FileContent::Lattice, FileUse::Read),
              ".ovm, .vtu or .vtk, or the mesh of a simulation (.msh, .su2, .mesh, .bdf, .nas, "
              ".fem, .inp, .unv, .cas, .xyz, .p3d, .fmt, .g, .x, .grd, .ufmt or an OpenFOAM case)");
    EXPECT_EQ(listOfFormats(FileContent::Mesh, FileUse::Read), ".obj");
    EXPECT_EQ(listOfFormats(FileContent::Matrix, FileUse::Read), ".mtx, .npz or .petsc");
    EXPECT_EQ(listOfFormats(FileContent::Matrix, FileUse::Write), ".mtx, .npz, .npy or .petsc");
}

TEST(Formats, OfAFolderAreOpenFoams) {
    const test::TemporaryFolder folder;
    for (const FileContent content : {FileContent::Lattice, FileContent::Model}) {
        EXPECT_TRUE(isFileOf(content, folder.path()));
        EXPECT_TRUE(isFileOf(content, "case/constant/polyMesh/points"));
        EXPECT_TRUE(isFileOf(content, "case/case.foam"));
        EXPECT_FALSE(isFileOf(content, "case/faces"));
        EXPECT_FALSE(isFileOf(content, ""));
    }
    EXPECT_FALSE(isFileOf(FileContent::Matrix, folder.path()));
    // A case may have any name, also the extension of a format without lattices.
    const auto named = folder / "case.txt";
    std::filesystem::create_directory(named);
    EXPECT_TRUE(isFileOf(FileContent::Lattice, named));
    EXPECT_TRUE(isFileOf(FileContent::Model, named));
}

// A new format of models is in the tests of faults while files are written, if it is here.
TEST(Formats, OfModelsHaveASampleForTests) {
    std::set<std::string> samples;
    for (const std::string& extension : test::modelExtensions()) samples.insert(extension);
    for (const std::string extension : test::kMeshExtensions) samples.insert(extension);
    for (const std::string& extension : extensionsOf(FileContent::Model, FileUse::Read)) {
        // These are the same formats as .xyz and .bdf.
        const std::set<std::string> others = {".p3d", ".fmt",  ".g",   ".x",
                                              ".grd", ".ufmt", ".nas", ".fem"};
        if (others.contains(extension)) continue;
        EXPECT_TRUE(samples.contains(extension)) << extension;
    }
}

TEST(Formats, OfModelsThatAreTheSameNeedNoConversion) {
    const std::string bytes = test::meshText(".xyz", 3);
    const test::TemporaryFolder folder;
    const auto model = readModel("a.P3D", bytes);
    EXPECT_EQ(model->extension(), ".p3d");
    EXPECT_EQ(model->checkTarget(folder / "b.fmt"), "");
    model->write(folder / "b.fmt", model->positions());
    EXPECT_EQ(readFile(folder / "b.fmt"), bytes);
}

}  // namespace
}  // namespace espalier::io
