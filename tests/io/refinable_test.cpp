// SPDX-License-Identifier: Apache-2.0
#include "obj_mesh_samples.h"
#include "support/test.h"

namespace espalier::test {
namespace {

TEST(Refinable, MeshesAreReadFromObjAndLatticesFromOtherFormats) {
    const TemporaryFolder folder;
    const Lattice mesh = taggedMesh();
    io::writeRefinable(folder / "a.OBJ", mesh);
    EXPECT_THAT(io::readFile(folder / "a.OBJ"), StartsWith("v 0.1 "));
    expectSameMesh(io::readRefinable(folder / "a.OBJ"), mesh);
    for (const char* name : {"a.ovm", "a.Vtu", "a.vtk"}) {
        io::writeRefinable(folder / name, mixedLattice());
        expectSameLattice(io::readRefinable(folder / name), mixedLattice());
        EXPECT_NO_THROW(io::checkRefinableTarget(name, 3));
    }
    EXPECT_NO_THROW(io::checkRefinableTarget("a.obj", 2));
    // The options are passed on.
    io::writeRefinable(folder / "b.vtu", mixedLattice(), {io::VtuEncoding::Ascii});
    EXPECT_THAT(io::readFile(folder / "b.vtu"), HasSubstr("format=\"ascii\""));
}

TEST(Refinable, FormatsOfTheWrongDimensionAreRefused) {
    const TemporaryFolder folder;
    const auto expectRefused = [&](const std::string& name, const Lattice& lattice,
                                   const std::string& cause) {
        const auto path = folder / name;
        for (const bool onlyCheck : {true, false}) {
            EXPECT_EQ(messageOf<io::FileError>([&] {
                          if (onlyCheck)
                              io::checkRefinableTarget(path, lattice.complex.dimension());
                          else
                              io::writeRefinable(path, lattice);
                      }),
                      path.string() + ": " + cause);
        }
        EXPECT_FALSE(std::filesystem::exists(path));
    };
    for (const char* name : {"a.ovm", "a.vtu", "a.vtk", "a.stl", "a"})
        expectRefused(name, taggedMesh(), "a mesh cannot be written in this format; expected .obj");
    for (const char* name : {"a.obj", "a.stl", "a"})
        expectRefused(name, boxLattice(),
                      "a lattice cannot be written in this format; expected .ovm, .vtu or .vtk");
    Lattice curve;
    curve.complex = far::buildCurve(3, false);
    for (const char* name : {"a.ovm", "a.vtu", "a"})
        expectRefused(name, curve, "a curve cannot be written in this format; expected .obj");
    expectRefused(
        "a.obj", {},
        "a complex of dimension 0 cannot be written; expected a curve (1), a mesh (2) or a "
        "lattice (3)");
    EXPECT_EQ(messageOf<io::FileError>([&] { io::readRefinable("a.stl"); }),
              "a.stl: is not of a known format of curves, meshes or lattices; "
              "expected .obj, .ovm, .vtu or .vtk, or the mesh of a simulation (.msh, .su2, .mesh, "
              ".bdf, .nas, .fem, .inp, .unv, .cas, "
              ".xyz, .p3d, .fmt, .g, .x, .grd, .ufmt or an OpenFOAM case)");
}

/// Lattices have no holes, and a mark that the file cannot hold is not dropped silently.
TEST(Refinable, HolesOfLatticesAreRefused) {
    const TemporaryFolder folder;
    Lattice lattice = boxLattice();
    lattice.marks.holes = {0};
    for (const char* name : {"a.ovm", "a.vtu", "a.vtk"}) {
        EXPECT_REFUSED(far::TopologyError, "only a mesh can have holes",
                       io::writeRefinable(folder / name, lattice));
    }
}

}  // namespace
}  // namespace espalier::test
