// SPDX-License-Identifier: Apache-2.0
#include "lattice_samples.h"

#include <filesystem>
#include <ostream>

#include "support/shared_data.h"
#include "support/test.h"

namespace espalier::test {
namespace {

struct Form {
    const char* file;
    io::VtuEncoding encoding = io::VtuEncoding::Compressed;

    friend void PrintTo(const Form& form, std::ostream* out) {
        *out << form.file << " " << int(form.encoding);
    }
};

class LatticeFile : public testing::TestWithParam<Form> {
protected:
    static std::string write(const Lattice& lattice) {
        return writtenLattice(GetParam().file, lattice, {GetParam().encoding});
    }
};

INSTANTIATE_TEST_SUITE_P(Forms, LatticeFile,
                         testing::Values(Form{"a.ovm"}, Form{"a.vtk"},
                                         Form{"a.vtu", io::VtuEncoding::Ascii},
                                         Form{"a.vtu", io::VtuEncoding::Binary},
                                         Form{"a.vtu", io::VtuEncoding::Compressed}));

TEST_P(LatticeFile, RoundTripIsExact) {
    for (const Lattice& lattice : sampleLattices())
        expectSameLattice(latticeOf(GetParam().file, write(lattice)), lattice);
}

TEST_P(LatticeFile, SecondRoundTripIsExact) {
    for (const Lattice& lattice : sampleLattices()) {
        const Lattice once = latticeOf(GetParam().file, write(lattice));
        const Lattice twice = latticeOf(GetParam().file, write(once));
        expectSameLattice(twice, lattice);
    }
}

TEST_P(LatticeFile, MarksComeBackInCanonicalForm) {
    Lattice lattice = boxLattice();
    // Edge 0–1 is marked twice, the second time as 1–0; the later mark wins.
    lattice.marks.edges = {{{7, 8}, 0}, {{0, 1}, 0}, {{1, 0}, 12}};
    lattice.marks.vertices = {{5, 0}, {3, far::kInfinitelySharp}, {5, 1}};
    const Lattice got = latticeOf(GetParam().file, write(lattice));
    // 12 is at least 10, and so infinite.
    EXPECT_EQ(got.marks.edges,
              (std::vector<far::Marks::Edge>{{{0, 1}, far::kInfinitelySharp}, {{7, 8}, 0}}));
    EXPECT_EQ(got.marks.vertices,
              (std::vector<far::Marks::Vertex>{{3, far::kInfinitelySharp}, {5, 1}}));
}

/// Tries twenty parts of each file, from nothing to all but the last twentieth.
TEST_P(LatticeFile, TruncatedFileIsRefused) {
    for (const Lattice& lattice : sampleLattices()) {
        const std::string bytes = write(lattice);
        for (std::size_t part = 0; part < 20; ++part)
            EXPECT_NE(refusalOf(GetParam().file, bytes.substr(0, bytes.size() * part / 20)), "")
                << "cut at " << part << " twentieths";
    }
}

/// A file with one byte changed is read or refused with an Error; reading never crashes.
TEST_P(LatticeFile, SurvivesDamage) {
    const std::string bytes = write(withMarksAndAttributes(polyhedralLattice()));
    for (std::size_t at = 0; at < bytes.size(); at += 1 + bytes.size() / 80)
        for (const char damage : {'9', '-', '\0'}) {
            std::string damaged = bytes;
            damaged[at] = damage;
            EXPECT_NO_THROW(refusalOf(GetParam().file, damaged)) << at;
        }
}

TEST_P(LatticeFile, RefusesToWriteInconsistentLattices) {
    const auto refusal = [&](const Lattice& lattice) { return messageOf([&] { write(lattice); }); };
    Lattice lattice = boxLattice();
    lattice.positions.pop_back();
    EXPECT_THAT(refusal(lattice), HasSubstr("12 vertices and 11 positions"));

    lattice = boxLattice();
    lattice.attributes.push_back({"heat", 2, {1, 2, 3}});
    EXPECT_THAT(refusal(lattice), HasSubstr("'heat' has 3 values for 12 vertices of 2 components"));

    lattice = boxLattice();
    lattice.attributes.push_back({"", 1, std::vector<double>(12)});
    EXPECT_THAT(refusal(lattice), HasSubstr("an attribute has no name"));

    // This name would be read as marks.
    lattice = boxLattice();
    lattice.attributes.push_back({"espalier:vertex_sharpness", 1, std::vector<double>(12)});
    EXPECT_THAT(refusal(lattice),
                HasSubstr("'espalier:vertex_sharpness' has a name that is reserved"));

    lattice = boxLattice();
    lattice.positions[7][1] = kNan;
    EXPECT_THAT(refusal(lattice), HasSubstr("point 7 is not finite"));

    lattice = boxLattice();
    lattice.marks.edges = {{{0, 4}, 0}};
    EXPECT_THAT(refusal(lattice), HasSubstr("a mark names edge (0, 4), which does not exist"));

    lattice = boxLattice();
    lattice.marks.vertices = {{12, 0}};
    EXPECT_THAT(refusal(lattice), HasSubstr("a mark names vertex 12; there are 12"));

    lattice = boxLattice();
    lattice.marks.vertices = {{1, -1}};
    EXPECT_THAT(refusal(lattice), HasSubstr("expected 0 (smooth) or more"));

    lattice.complex = far::buildCurve(12, false);
    EXPECT_THAT(refusal(lattice), HasSubstr("of dimension 1, not 3"));
}

TEST(LatticeFiles, ExtensionChoosesTheFormat) {
    const TemporaryFolder folder;
    for (const char* name : {"a.OVM", "a.Vtu", "a.VTK"}) {
        io::writeLattice(folder / name, mixedLattice());
        expectSameLattice(io::readLattice(folder / name), mixedLattice());
        EXPECT_NO_THROW(io::checkLatticeTarget(name));
    }
    EXPECT_THAT(io::readFile(folder / "a.OVM"), StartsWith("OVM ASCII\n"));
    EXPECT_THAT(io::readFile(folder / "a.Vtu"), StartsWith("<?xml"));
    EXPECT_THAT(io::readFile(folder / "a.VTK"), StartsWith("# vtk DataFile Version 3.0\n"));
}

TEST(LatticeFiles, UnknownExtensionsAreRefused) {
    for (const char* name : {"a.stl", "a", "vtu", "a.vtu.gz"}) {
        const auto expectRefusal = [&](auto call, const std::string& others = "") {
            EXPECT_EQ(messageOf<io::FileError>([&] { call(); }),
                      std::string(name) +
                          ": is not of a known lattice format; expected "
                          ".ovm, .vtu or .vtk" +
                          others);
        };
        expectRefusal(
            [&] { io::readLattice(name, ""); },
            ", or the mesh of a simulation (.msh, .su2, .mesh, .bdf, .nas, .fem, .inp, .unv, .cas, "
            ".xyz, .p3d, .fmt, .g, .x, "
            ".grd, .ufmt or an OpenFOAM case)");
        expectRefusal([&] { io::writeLattice(name, boxLattice()); });
        expectRefusal([&] { io::checkLatticeTarget(name); });
    }
}

/// VTK 9.1 wrote these files: see tests/io/data/README.md.
TEST(LatticeFiles, ReadsFilesWrittenByVtk) {
    const std::filesystem::path folder =
        std::filesystem::path(ESPALIER_SOURCE_DIR) / "tests/io/data";
    far::ComplexBuilder builder(3, 11);
    builder.addCell(far::StandardCell::Hexahedron, {0, 1, 2, 3, 4, 5, 6, 7});
    builder.addCell(far::StandardCell::Wedge, {4, 8, 5, 7, 9, 6});
    builder.addCell(far::StandardCell::Pyramid, {1, 2, 6, 5, 10});
    Lattice expected;
    expected.complex = builder.build();
    expected.positions = {{0, 0, 0},     {1, 0, 0},     {1, 1, 0},      {0, 1, 0},
                          {0, 0, 1},     {1, 0, 1},     {1, 1, 1},      {0, 1, 1},
                          {0.5, 0, 1.7}, {0.5, 1, 1.7}, {2.3, 0.1, 0.1}};
    expected.attributes = {{"uv", 2, {}}};
    expected.integers = {{"heat of day", 1, IntegerType::Int16, {}}};
    for (int i = 0; i < 22; ++i) expected.attributes[0].values.push_back(i / 8.0);
    for (int i = 0; i < 11; ++i) expected.integers[0].values.push_back(100 * i);

    int count = 0;
    for (const auto& entry : std::filesystem::directory_iterator(folder)) {
        if (entry.path().extension() == ".md") continue;
        SCOPED_TRACE(entry.path().filename());
        expectSameLattice(io::readLattice(entry.path()), expected);
        ++count;
    }
    EXPECT_EQ(count, 11);
}

/// Truncated files are refused, also with raw data. The only exception is a legacy file that is cut
/// between two sections, which looks like a whole file.
TEST(LatticeFiles, TruncatedFilesWrittenByVtkAreRefused) {
    const std::filesystem::path folder =
        std::filesystem::path(ESPALIER_SOURCE_DIR) / "tests/io/data";
    for (const auto& entry : std::filesystem::directory_iterator(folder)) {
        const std::string extension = entry.path().extension().string();
        if (extension == ".md") continue;
        const std::string bytes = io::readFile(entry.path());
        for (std::size_t part = 0; part < 20; ++part) {
            const std::size_t size = bytes.size() * part / 20;
            const std::string rest = bytes.substr(size);
            if (extension == ".vtk" &&
                (rest.starts_with("FIELD") || rest.starts_with("POINT_DATA")))
                continue;
            EXPECT_NE(refusalOf("a" + extension, bytes.substr(0, size)), "")
                << entry.path().filename() << " cut at " << part << " twentieths";
        }
    }
}

/// The folder of files shared between projects may be missing.
TEST(LatticeFiles, ReadsTheLatticesInTheSharedFolder) {
    const std::filesystem::path root = sharedData();
    if (!std::filesystem::exists(root / "lattices"))
        GTEST_SKIP() << "no shared data in " << root
                     << " (set ESPALIER_SHARED_DATA to the folder that has lattices/)";
    struct Expected {
        const char* name;
        Index vertices, faces, cells;
    };
    // Box of 3 × 2 × 2 cells: 4·3·3 vertices, 4·2·2 + 3·3·2 + 3·2·3 faces. Cylinder: 3 layers of
    // 17 vertices, 2 layers of 16 cells; per layer 8 triangles and 8 quadrilaterals in each of 3
    // levels, and 32 upright faces in each of 2.
    for (const Expected& expected : {Expected{"box-hexahedra-appended-base64-zlib.vtu", 36, 52, 12},
                                     {"box-hexahedra-legacy-binary.vtk", 36, 52, 12},
                                     {"cylinder-polyhedra-appended-raw.vtu", 51, 112, 32},
                                     {"cylinder-polyhedra-binary-zlib.vtu", 51, 112, 32},
                                     {"hex-pyramid-wedge-tet-ascii.vtu", 12, 17, 4},
                                     {"hex-pyramid-wedge-tet-legacy.vtk", 12, 17, 4}}) {
        const Lattice lattice = io::readLattice(root / "lattices" / expected.name);
        EXPECT_EQ(lattice.complex.count(0), expected.vertices) << expected.name;
        EXPECT_EQ(lattice.complex.count(2), expected.faces) << expected.name;
        EXPECT_EQ(lattice.complex.count(3), expected.cells) << expected.name;
    }
}

}  // namespace
}  // namespace espalier::test
