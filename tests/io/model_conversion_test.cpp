// SPDX-License-Identifier: Apache-2.0
#include <espalier/base/vector3.h>
#include <espalier/io/model.h>
#include <io/gradient_samples.h>
#include <io/model_files.h>

#include <atomic>
#include <set>

#include "io/format.h"

namespace espalier::io {
namespace {

using Loops = std::vector<std::vector<Index>>;

/// A model that is written to a file of this name, and the bytes of the file.
struct Converted {
    std::string bytes;
    std::unique_ptr<Model> model;
};

template <class... Arguments>
Converted converted(const Model& model, const std::string& name, const Arguments&... arguments) {
    const TemporaryFolder folder;
    model.write(folder / name, arguments...);
    const std::string bytes = readFile(folder / name);
    return {bytes, readModel(name, bytes)};
}

Loops loopsOf(const ModelSurface& surface) {
    Loops loops;
    for (std::size_t face = 0; face < surface.faces.count(); ++face)
        loops.emplace_back(surface.faces[face].begin(), surface.faces[face].end());
    return loops;
}

/// Returns the normal at each corner.
std::vector<Point3> cornerNormals(const ModelSurface& surface) {
    if (surface.normals.empty()) return {};
    const bool areOnePerPoint = surface.normalCorners.empty();
    std::vector<Point3> normals;
    for (const Index number : areOnePerPoint ? surface.faces.corners : surface.normalCorners)
        normals.push_back(surface.normals[number]);
    return normals;
}

/// A pentagon that is not convex (corner 1 is reflex), a square and a triangle, with a normal per
/// point. Point 8 is in no face. All numbers but one are floats.
const std::string kObj =
    "v 0 0 0\nv 1 0.5 0\nv 2 0 0\nv 2 2 0\nv 0 2 0\nv 2 4 0\nv 0 4 0\nv 1 5 0.1\nv 9 9 9\n"
    "vn 0 0 1\nvn 0 0 0.5\n"
    "f 1//1 2//1 3//1 4//1 5//1\nf 5//1 4//1 6//2 7//2\nf 7//2 6//2 8//2\n";
const Loops kLoops = {{0, 1, 2, 3, 4}, {4, 3, 5, 6}, {6, 5, 7}};

TEST(ModelConversion, KeepsPointsFacesAndNormalsThroughAllFormats) {
    const auto source = readModel("a.obj", kObj);
    const auto normals = cornerNormals(source->readSurface());
    for (const std::string first : {".obj", ".ply", ".vtp", ".vtu", ".vtk"})
        for (const std::string second : {".obj", ".ply", ".vtp", ".vtu", ".vtk"}) {
            SCOPED_TRACE(first + " to " + second);
            const auto model = converted(*source, "b" + first, source->positions()).model;
            const Converted twice = converted(*model, "c" + second, model->positions());
            EXPECT_EQ(copyOf(twice.model->positions()), copyOf(source->positions()));
            const ModelSurface surface = twice.model->readSurface();
            EXPECT_EQ(loopsOf(surface), kLoops);
            EXPECT_EQ(cornerNormals(surface), normals);
            EXPECT_TRUE(surface.others.empty());
            EXPECT_EQ(model->checkTarget("c" + second), "");
            // The same file again is the same, byte for byte.
            EXPECT_EQ(converted(*twice.model, "c" + second, model->positions()).bytes, twice.bytes);
        }
}

TEST(ModelConversion, ToStlSplitsFacesAndRoundsCoordinates) {
    const auto source = readModel("a.obj", kObj);
    EXPECT_EQ(source->checkTarget("out/a.stl"),
              "out/a.stl: the .obj has data that are not written: normals (triangles have their "
              "own), 1 point in no face; 2 faces are split into 5 triangles; coordinates are "
              "rounded to single precision");
    const auto stl = converted(*source, "a.stl", source->positions()).model;
    EXPECT_EQ(stl->storage(), CoordinateStorage::Float);
    // 3 + 2 + 1 triangles. No ear of the pentagon contains its reflex corner.
    const auto corners = stl->positions();
    ASSERT_EQ(corners.size(), 18u);
    double area = 0;
    for (std::size_t i = 0; i < corners.size(); i += 3) {
        const Point3 loop[] = {corners[i], corners[i + 1], corners[i + 2]};
        EXPECT_GT(areaVector(loop)[2], 0);
        area += areaVector(loop)[2];
    }
    // The pentagon has the area 4 - 0.5, the square 4, and the triangle 1.
    EXPECT_EQ(area, 8.5);
    EXPECT_EQ(corners[17], (Point3{1, 5, double{0.1f}}));
    // A binary file: 84 bytes and 50 for each facet, whose normal is the first vector.
    const std::string bytes = converted(*source, "a.stl", source->positions()).bytes;
    EXPECT_EQ(bytes.size(), 84u + 6 * 50);
    EXPECT_EQ(bytes.substr(84, 12), bytesOf(0.0f, std::endian::little) +
                                        bytesOf(0.0f, std::endian::little) +
                                        bytesOf(1.0f, std::endian::little));
    // The triangles are those of the model at rest, whatever the pose.
    auto moved = copyOf(source->positions());
    moved[1] = {1, -1, 0};
    const auto posed = converted(*source, "a.stl", moved).model;
    for (std::size_t i = 0; i < corners.size(); ++i)
        EXPECT_EQ(posed->positions()[i], (corners[i] == Point3{1, 0.5, 0} ? moved[1] : corners[i]));
    moved[1] = {1e39, 0, 0};
    EXPECT_REFUSED(Error,
                   "the new position of point 1 has the coordinate 1e+39, which is too large",
                   converted(*source, "a.stl", moved));
}

TEST(ModelConversion, FromStlWeldsTheCornersOfFacets) {
    const std::string facet = "facet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0 0\n";
    const auto stl = readModel("a.stl", "solid s\n" + facet + "vertex 1 1 0\nendloop\nendfacet\n" +
                                            facet + "vertex 0 -1 0\nendloop\nendfacet\nendsolid\n");
    auto moved = copyOf(stl->positions());
    for (Point3& point : moved) point[2] += 1;
    for (const std::string extension : {".obj", ".ply", ".vtp", ".vtu", ".vtk"}) {
        EXPECT_EQ(stl->checkTarget("b" + extension), "");
        const auto model = converted(*stl, "b" + extension, moved).model;
        EXPECT_EQ(copyOf(model->positions()),
                  (std::vector<Point3>{{0, 0, 1}, {1, 0, 1}, {1, 1, 1}, {0, -1, 1}}));
        EXPECT_EQ(loopsOf(model->readSurface()), (Loops{{0, 1, 2}, {0, 1, 3}}));
        EXPECT_TRUE(model->readSurface().normals.empty());
    }
}

TEST(ModelConversion, CarriesNormalsByGradients) {
    const auto source = readModel("a.obj",
                                  "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 1 1 0\nvn 1 0 0\nvn 0 0 1\n"
                                  "f 1//1 2//1 3//2\nf 3//2 2//1 4//2\n");
    const std::vector<DeformationGradient> gradients = {kIdentity, kQuarterTurn, kQuarterTurn,
                                                        kIdentity};
    const std::vector<Point3> expected = {{1, 0, 0}, {0, 1, 0}, {0, 0, 1},
                                          {0, 0, 1}, {0, 1, 0}, {0, 0, 1}};
    for (const std::string extension : {".ply", ".vtp", ".vtu", ".vtk"}) {
        const auto model =
            converted(*source, "b" + extension, source->positions(), gradients).model;
        EXPECT_EQ(cornerNormals(model->readSurface()), expected);
        // Back to corners.
        const Converted back = converted(*model, "c.obj", source->positions(),
                                         std::vector<DeformationGradient>(4, kIdentity));
        EXPECT_EQ(cornerNormals(back.model->readSurface()), expected);
        EXPECT_EQ(back.model->readSurface().normals.size(), 4u) << "one for each point, as before";
        // Without gradients, normals stay.
        EXPECT_EQ(
            cornerNormals(
                converted(*source, "b" + extension, source->positions()).model->readSurface()),
            cornerNormals(source->readSurface()));
    }
}

TEST(ModelConversion, NormalsThatHaveNoPlaceAreNamed) {
    const std::string points = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 1 1 0\nvn 1 0 0\nvn 0 0 1\nvn 0 0 1\n";
    // Point 1 has two different normals; point 2 has two equal ones.
    const auto split = readModel("a.obj", points + "f 1//1 2//1 3//2\nf 3//3 2//2 4//2\n");
    EXPECT_EQ(split->checkTarget("b.ply"),
              "b.ply: the .obj has data that are not written: normals (1 point has several, of "
              "which a .ply holds one)");
    EXPECT_FALSE(converted(*split, "b.ply", split->positions()).model->hasDirections());
    const auto shared = readModel("a.obj", points + "f 1//1 2//1 3//2\nf 3//3 2//1 4//2\n");
    EXPECT_EQ(shared->checkTarget("b.ply"), "");
    for (const std::string faces : {"f 1//1 2//1 3\n", "f 1//1 2//1 3//4\n", "f 1 2 3\n"})
        EXPECT_EQ(
            readModel("a.obj", points + faces)->checkTarget("b.vtp"),
            "b.vtp: the .obj has data that are not written: normals (some corners have none)");
    EXPECT_EQ(readModel("a.obj", points)->checkTarget("b.vtp"),
              "b.vtp: the .obj has data that are not written: normals (the model has no faces)");
    // Points without faces keep their normals where a format has normals of points.
    const std::string cloud =
        "ply\nformat ascii 1.0\nelement vertex 2\nproperty float x\nproperty float y\n"
        "property float z\nproperty float nx\nproperty float ny\nproperty float nz\nend_header\n"
        "0 0 0 1 0 0\n1 0 0 nan 0 0\n";
    const auto points2 = readModel("a.ply", cloud);
    EXPECT_EQ(points2->checkTarget("b.vtp"), "");
    EXPECT_EQ(converted(*points2, "b.vtp", points2->positions()).model->readSurface().normals,
              (std::vector<Point3>{{1, 0, 0}, {0, 0, 0}}));
    EXPECT_EQ(points2->checkTarget("b.obj"),
              "b.obj: the .ply has data that are not written: normals (the model has no faces)");
    EXPECT_EQ(converted(*points2, "b.obj", points2->positions()).bytes, "v 0 0 0\nv 1 0 0\n");
}

/// Returns the message about data of a file that are not written to `target`.
std::string lossesOf(const std::string& name, const std::string& bytes, const std::string& target) {
    std::string text = readModel(name, bytes)->checkTarget(target);
    const std::string head =
        target + ": the " + name.substr(1) + " has data that are not written: ";
    EXPECT_EQ(text.substr(0, head.size()), head);
    return text.substr(std::min(head.size(), text.size()));
}

TEST(ModelConversion, AllDataThatAreNotWrittenAreNamed) {
    EXPECT_EQ(lossesOf("a.obj",
                       "mtllib m\no a\nv 0 0 0 1\nv 1 0 0\nv 0 1 0 1 0 0\nvt 0 0\ng x\ns 1\n"
                       "usemtl m\nf 1/1 2/1 3/1\nl 1 2\np 1\nt corner 1/1/0 0 2\nlod 3\nlod 4\n",
                       "a.ply"),
              "material libraries, names of objects, groups, smoothing groups, lines, point "
              "elements, tags of subdivision, statements 'lod', weights or colours of points, "
              "texture coordinates, materials");
    EXPECT_EQ(lossesOf("a.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2\nf 1 2 3\nf 1\n", "a.ply"),
              "2 faces of fewer than three corners");
    // The normals of faces that are not written are not those of the points.
    const auto edge = readModel("a.obj", "v 0 0 0\nv 1 0 0\nvn 0 0 1\nf 1//1 2//1\n");
    EXPECT_EQ(edge->checkTarget("b.ply"),
              "b.ply: the .obj has data that are not written: 1 face of fewer than three corners");
    EXPECT_FALSE(converted(*edge, "b.ply", edge->positions()).model->hasDirections());
    EXPECT_EQ(
        lossesOf("a.ply",
                 "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\n"
                 "property float z\nproperty uchar red\nproperty float tx\nproperty float ty\n"
                 "property float tz\nelement face 1\nproperty list uchar int vertex_index\n"
                 "property float quality\nelement edge 1\nproperty int vertex1\n"
                 "element none 0\nproperty int a\nend_header\n"
                 "0 0 0 1 1 0 0\n1 0 0 1 1 0 0\n0 1 0 1 1 0 0\n3 0 1 2 0.5\n1\n",
                 "a.obj"),
        "properties of points 'red', 'tx', 'ty', 'tz', properties of faces 'quality', "
        "elements 'edge'");
    std::string stl(80, ' ');
    stl += bytesOf(std::uint32_t{1}, std::endian::little) + std::string(48, '\0') + "\1" + '\0';
    EXPECT_EQ(lossesOf("a.stl", stl, "a.obj"), "attribute bytes");
    const std::string solid =
        "solid\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nvertex 0 1 0\n"
        "endloop\nendfacet\nendsolid\n";
    EXPECT_EQ(lossesOf("a.stl", solid + solid, "a.obj"), "solids");
    EXPECT_EQ(readModel("a.stl", solid)->checkTarget("a.obj"), "");
    EXPECT_EQ(lossesOf("a.vtk",
                       "# vtk DataFile Version 2.0\na\nASCII\nDATASET POLYDATA\nFIELD f 1\n"
                       "time 1 1 float\n0\nPOINTS 3 float\n0 0 0 1 0 0 0 1 0\nVERTICES 1 2\n1 0\n"
                       "LINES 1 3\n2 0 1\nPOLYGONS 1 4\n3 0 1 2\nCELL_DATA 1\nSCALARS c int\n"
                       "LOOKUP_TABLE default\n1\nPOINT_DATA 3\nNORMALS n float\n"
                       "1 0 0 1 0 0 1 0 0\nNORMALS m float\n1 0 0 1 0 0 1 0 0\n"
                       "COLOR_SCALARS rgb 1\n0 0 0\n",
                       "a.obj"),
              "field data 'time', cell data 'c', point data 'm', 'rgb', vertex cells, lines");
    std::string arrays;
    for (const char* name : {"Normals", "a", "b", "c", "d", "e", "f"})
        arrays += "<DataArray type='Float32' Name='" + std::string(name) +
                  "' NumberOfComponents='3' format='ascii'>1 0 0 1 0 0 1 0 0</DataArray>";
    const std::string vtp =
        "<VTKFile type='PolyData'><PolyData><Piece NumberOfPoints='3' NumberOfVerts='1' "
        "NumberOfLines='1'><PointData>" +
        arrays +
        "</PointData><CellData Normals='n'>"
        "<DataArray type='Float32' Name='n' NumberOfComponents='3'>1 0 0 1 0 0</DataArray>"
        "</CellData><Points><DataArray type='Float32' NumberOfComponents='3'>0 0 0 1 0 0 0 1 0"
        "</DataArray></Points><Verts><DataArray type='Int32' Name='connectivity'>0</DataArray>"
        "<DataArray type='Int32' Name='offsets'>1</DataArray></Verts><Lines><DataArray "
        "type='Int32' "
        "Name='connectivity'>0 1</DataArray><DataArray type='Int32' Name='offsets'>2</DataArray>"
        "</Lines></Piece></PolyData></VTKFile>";
    EXPECT_EQ(lossesOf("a.vtp", vtp, "a.ply"),
              "vertex cells, lines, point data 'a', 'b', 'c', 'd', 'e', ..., cell data 'n'");
    // A model without any of these loses nothing.
    EXPECT_EQ(readModel("a.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3 # a comment\n")
                  ->checkTarget("a.vtk"),
              "");
}

TEST(ModelConversion, ShapesThatFacesCannotDescribeAreRefused) {
    const auto grid = readModel("a.vtk",
                                "# vtk DataFile Version 2.0\na\nASCII\nDATASET UNSTRUCTURED_GRID\n"
                                "POINTS 4 float\n0 0 0 1 0 0 0 1 0 0 0 1\nCELLS 4 15\n4 0 1 2 3\n"
                                "4 0 1 2 3\n3 0 1 2\n0\nCELL_TYPES 4\n10 10 22 0\n");
    for (const std::string extension : {".obj", ".stl", ".vtu"})
        EXPECT_REFUSED(FileError,
                       "out" + extension + ": a " + extension +
                           " cannot hold 2 cells of VTK's type 10 (tetrahedron) and 1 cell of "
                           "VTK's type 22 of the model; name the output out.vtk, or extract the "
                           "surface of the "
                           "model first",
                       grid->checkTarget("out" + extension));
    const TemporaryFolder folder;
    EXPECT_THROW(grid->write(folder / "a.obj", grid->positions()), FileError);
    EXPECT_NO_THROW(grid->write(folder / "a.vtk", grid->positions()));
    EXPECT_REFUSED(FileError, "a .ply cannot hold free-form curves and surfaces of the model",
                   readModel("a.obj", "v 0 0 0\nv 1 0 0\ncurv 0 1 1 2\ncurv 0 1 1 2\nend\n")
                       ->checkTarget("a.ply"));
    EXPECT_REFUSED(FileError,
                   "a .stl consists of triangles, and the model has no faces; name the output .obj "
                   "or .ply",
                   readModel("a.obj", "v 0 0 0\nf 1 1\n")->checkTarget("a.stl"));
    EXPECT_EQ(readModel("a.obj", "v 0 0 0\n")->checkTarget("a.ply"), "");
}

TEST(ModelConversion, OtherNamesKeepTheFormat) {
    const auto model = readModel("a.obj", kObj);
    for (const char* name : {"b.obj", "b.OBJ", "/dev/stdout", "b"})
        EXPECT_EQ(model->checkTarget(name), "");
    const TemporaryFolder folder;
    const std::string refusal =
        "b.fbx: .fbx is no known model format; expected .obj, .ply, .stl, .vtu, .vtp, .vtk, .glb "
        "or "
        ".gltf, or a name without extension, which is written as .obj";
    EXPECT_REFUSED(FileError, refusal, model->checkTarget("b.fbx"));
    EXPECT_REFUSED(FileError, ".fbx is no known model format",
                   model->write(folder / "b.fbx", model->positions()));
    EXPECT_FALSE(std::filesystem::exists(folder / "b.fbx"));
    // A number at the end names a pose, not a format.
    for (const char* name : {"b.0001", "b.7"}) EXPECT_EQ(model->checkTarget(name), "");
    for (const char* name : {"b.", "b.7z", "b.backup"})
        EXPECT_REFUSED(FileError, "no known model format", model->checkTarget(name));
    model->write(folder / "b", model->positions());
    EXPECT_EQ(readFile(folder / "b"), kObj);
}

/// A square. Counts how often its surface is read.
class CountingModel final : public Model {
public:
    CountingModel() : Model(kObjFormat, "a.obj") {}

    std::span<const Point3> positions() const override { return positions_; }
    ModelSurface readSurface() const override {
        ++reads;
        ModelSurface surface;
        surface.faces.corners = {0, 1, 2, 3};
        surface.faces.endFace();
        return surface;
    }
    CoordinateStorage storage() const override { return CoordinateStorage::Double; }
    DirectionCounts directions() const override { return {}; }

    mutable std::atomic<int> reads = 0;

private:
    void writeChecked(const std::filesystem::path&, std::span<const Point3>,
                      std::span<const DeformationGradient>) const override {}

    std::vector<Point3> positions_ = {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}};
};

TEST(ModelConversion, ReadsTheSurfaceOncePerFormat) {
    const TemporaryFolder folder;
    const CountingModel model;
    EXPECT_THAT(model.checkTarget("pose0.stl"), StartsWith("pose0.stl: "));
    EXPECT_THAT(model.checkTarget("pose1.stl"), StartsWith("pose1.stl: "));
    std::vector<Point3> pose = copyOf(model.positions());
    for (const char* name : {"pose0.stl", "pose1.stl", "pose2.stl"}) {
        pose[0][2] += 1;
        model.write(folder / name, pose);
        EXPECT_EQ(readModel(folder / name)->positions()[0], pose[0]) << name;
    }
    EXPECT_EQ(model.reads, 1);
    model.write(folder / "pose.ply", pose);
    EXPECT_EQ(loopsOf(readModel(folder / "pose.ply")->readSurface()), (Loops{{0, 1, 2, 3}}));
    EXPECT_EQ(model.reads, 2);
    // In its own format, a model is written without its surface.
    model.write(folder / "pose.obj", pose);
    EXPECT_EQ(model.reads, 2);
}

}  // namespace
}  // namespace espalier::io
