// SPDX-License-Identifier: Apache-2.0
#include "io/files/other_content.h"

#include <espalier/io/lattice_file.h>
#include <espalier/io/matrices/matrix_file.h>
#include <espalier/io/targets.h>
#include <io/model_files.h>

namespace espalier::io {
namespace {

/// Returns an ASCII text in UTF-16.
std::string wide(const std::string& text, std::endian order, bool hasMark) {
    std::string bytes;
    if (hasMark) bytes = order == std::endian::little ? "\xFF\xFE" : "\xFE\xFF";
    for (const char c : text) {
        if (order == std::endian::big) bytes += '\0';
        bytes += c;
        if (order == std::endian::little) bytes += '\0';
    }
    return bytes;
}

TEST(Utf16, IsNamedInErrors) {
    const std::string cause = ": is a text in UTF-16; expected UTF-8: save it as UTF-8";
    for (const std::endian order : {std::endian::little, std::endian::big})
        for (const bool hasMark : {true, false}) {
            const auto of = [&](const std::string& text) { return wide(text, order, hasMark); };
            const std::string obj = of("# a model\nv 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n");
            EXPECT_REFUSED(FileError, "a.obj" + cause, readModel("a.obj", obj));
            EXPECT_REFUSED(FileError, "a.obj" + cause, readRefinable("a.obj", obj));
            for (const std::string name :
                 {"a.ply", "a.stl", "a.vtk", "a.vtu", "a.msh", "a.mesh", "a.su2", "a.xyz"})
                EXPECT_REFUSED(FileError, name + cause,
                               readModel(name, of("solid one\nand more and more and more")));
            EXPECT_REFUSED(FileError, "a.ovm" + cause,
                           readLattice("a.ovm", of("OVM ASCII\nVertices\n0\nEdges\n")));
            EXPECT_REFUSED(FileError, "a.mtx" + cause,
                           readMatrix("a.mtx", of("%%MatrixMarket matrix coordinate real\n")));
            EXPECT_REFUSED(FileError, "a.txt" + cause,
                           readTargets("a.txt", 3, of("# targets\n0 0.5 0.5 0.5\n")));
        }
}

TEST(Utf16, OtherTextsAreNot) {
    EXPECT_FALSE(isUtf16(""));
    EXPECT_FALSE(isUtf16("\xFF"));
    EXPECT_FALSE(isUtf16("\xEF\xBB\xBFv 0 0 0\n"));
    EXPECT_FALSE(isUtf16(std::string(100, '\0')));
    EXPECT_FALSE(isUtf16("a text of thirty-two bytes or more"));
    EXPECT_REFUSED(FileError, "is not a keyword of OBJ files", readModel("a.obj", "\x7f"));
}

TEST(LfsPointers, AreNamedInErrors) {
    const std::string pointer =
        "version https://git-lfs.github.com/spec/v1\noid sha256:"
        "4d7a214614ab2935c943f9e0ff69d22eadbb8f32b1258daaa5e2ca24d17e2393\nsize 12345\n";
    const std::string cause =
        ": is a pointer to a file of Git LFS, which is not here: run 'git lfs pull'";
    for (const std::string name : {"a.obj", "a.ply", "a.stl", "a.vtk", "a.vtu", "a.msh", "a.mesh",
                                   "a.su2", "a.xyz", "a.glb", "a.gltf"})
        EXPECT_REFUSED(FileError, name + cause, readModel(name, pointer));
    for (const std::string name : {"a.ovm", "a.vtu", "a.vtk"})
        EXPECT_REFUSED(FileError, name + cause, readLattice(name, pointer));
}

}  // namespace
}  // namespace espalier::io
