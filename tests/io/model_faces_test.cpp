// SPDX-License-Identifier: Apache-2.0
#include <espalier/io/model.h>
#include <io/model_files.h>

namespace espalier::io {
namespace {

/// Faces as lists of their corners.
std::vector<std::vector<Index>> facesOf(const std::string& name, const std::string& bytes) {
    const ModelFaces faces = readModel(name, bytes)->readSurface().faces;
    std::vector<std::vector<Index>> result;
    for (std::size_t face = 0; face < faces.count(); ++face)
        result.emplace_back(faces[face].begin(), faces[face].end());
    return result;
}

using Faces = std::vector<std::vector<Index>>;

const std::string kFivePoints = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nv 0 0 1\n";

const std::string kPlyHead =
    " 1.0\nelement vertex 4\nproperty float x\nproperty double y\nproperty float z\n"
    "element face 2\nproperty list uchar int other\nproperty list uchar uint vertex_indices\n"
    "end_header\n";

TEST(ModelFaces, ObjHasTheFacesOfItsStatements) {
    EXPECT_EQ(facesOf("a.obj", kFivePoints + "f 1/7/8 2//3 3/4 4\nl 1 2\nfo -1 -2 -3\n"),
              (Faces{{0, 1, 2, 3}, {4, 3, 2}}));
    EXPECT_EQ(facesOf("a.obj", "v 0 0 0\nv 1 0 0\nf -1 -2 3\nv 0 1 0\n"), (Faces{{1, 0, 2}}));
    EXPECT_EQ(facesOf("a.obj", kFivePoints), Faces());
    EXPECT_REFUSED(FileError, "a.obj:7: a face has the corner '6'",
                   facesOf("a.obj", kFivePoints + "f 1 2 3\nf 1 2 6\n"));
    EXPECT_REFUSED(FileError, "a.obj:6: a face has the corner 'x'",
                   facesOf("a.obj", kFivePoints + "f x 2 3\n"));
}

TEST(ModelFaces, PlyHasItsListsOfVertices) {
    const std::string points = "0 0 0\n1 0 0\n1 1 0\n0 1 0\n";
    const std::string head = "ply\nformat ascii" + kPlyHead + points;
    EXPECT_EQ(facesOf("a.ply", head + "1 99 3 0 1 2\n0 4 3 2 1 0\n"),
              (Faces{{0, 1, 2}, {3, 2, 1, 0}}));
    EXPECT_REFUSED(FileError, "a.ply:15: a face has the corner '4'",
                   facesOf("a.ply", head + "0 3 0 1 4\n0 3 0 1 2\n"));
    EXPECT_REFUSED(FileError, "a.ply:16: a face has the corner '-1'",
                   facesOf("a.ply", head + "0 3 0 1 2\n0 3 0 1 -1\n"));
    // A model whose faces nobody asks for may have wrong ones.
    EXPECT_EQ(readModel("a.ply", head + "0 3 0 1 4\n0 3 0 1 2\n")->positions().size(), 4u);
}

TEST(ModelFaces, BinaryPlyHasTheSameFacesInBothByteOrders) {
    for (const auto order : {std::endian::little, std::endian::big}) {
        const char* format =
            order == std::endian::big ? "binary_big_endian" : "binary_little_endian";
        std::string bytes = std::string("ply\nformat ") + format + kPlyHead;
        for (int point = 0; point < 4; ++point)
            bytes += bytesOf(static_cast<float>(point), order) + bytesOf(2.0, order) +
                     bytesOf(3.0f, order);
        const auto list = [&](std::initializer_list<std::uint32_t> corners) {
            std::string text(1, static_cast<char>(corners.size()));
            for (const std::uint32_t corner : corners) text += bytesOf(corner, order);
            return text;
        };
        const std::string first = list({7}) + list({0, 1, 2});
        EXPECT_EQ(facesOf("a.ply", bytes + first + list({}) + list({3, 2, 1, 0})),
                  (Faces{{0, 1, 2}, {3, 2, 1, 0}}));
        EXPECT_REFUSED(FileError, "a face has the corner 4, which is not the number of a point",
                       facesOf("a.ply", bytes + first + list({}) + list({3, 2, 4})));
    }
}

TEST(ModelFaces, CornersOfAnStlAtOnePlaceAreOnePoint) {
    const std::string facet = "facet normal 0 0 1\nouter loop\n";
    const std::string end = "endloop\nendfacet\n";
    const std::string text = "solid a\n" + facet + "vertex 0 0 0\nvertex 1 0 0\nvertex 0 1 0\n" +
                             end + facet + "vertex 1 0 0\nvertex 1 1 0\nvertex 0 1 -0\n" + end +
                             "endsolid\n";
    EXPECT_EQ(facesOf("a.stl", text), (Faces{{0, 1, 2}, {1, 4, 2}}));
}

std::string vtuOf(const std::string& kind, const std::string& pieces) {
    return "<VTKFile type='" + kind + "' version='1.0' byte_order='LittleEndian'>\n<" + kind + ">" +
           pieces + "</" + kind + "></VTKFile>\n";
}

std::string arrayOf(const std::string& name, const std::string& values,
                    const std::string& type = "Int64") {
    return "<DataArray type='" + type + "' Name='" + name + "' format='ascii'>" + values +
           "</DataArray>\n";
}

const std::string kFourPoints =
    "<Points><DataArray type='Float32' NumberOfComponents='3' format='ascii'>\n"
    "0 0 0 1 0 0 1 1 0 0 1 0\n</DataArray></Points>\n";

TEST(ModelFaces, VtuHasItsSurfaceCellsAndNoFacesOfVolumes) {
    const std::string cells =
        "<Piece NumberOfPoints='4' NumberOfCells='6'>" + kFourPoints + "<Cells>" +
        arrayOf("connectivity", "0 1 2  0 1 3 2  0 1 2 3  3 0 1 2  0 1  0 1 2 3") +
        arrayOf("offsets", "3 7 11 15 17 21") + arrayOf("types", "5 8 6 9 3 10") +
        "</Cells></Piece>";
    const Faces one = {{0, 1, 2}, {0, 1, 2, 3}, {0, 1, 2}, {2, 1, 3}, {3, 0, 1, 2}};
    Faces two = one;
    for (std::vector<Index> face : one) {
        for (Index& point : face) point += 4;
        two.push_back(face);
    }
    EXPECT_EQ(facesOf("a.vtu", vtuOf("UnstructuredGrid", cells)), one);
    EXPECT_EQ(facesOf("a.vtu", vtuOf("UnstructuredGrid", cells + cells)), two);
    const std::string wrong = "<Piece NumberOfPoints='4' NumberOfCells='1'>" + kFourPoints +
                              "<Cells>" + arrayOf("connectivity", "0 1 4") +
                              arrayOf("offsets", "3") + arrayOf("types", "5") + "</Cells></Piece>";
    EXPECT_REFUSED(FileError, "a.vtu: a face names point 4; there are 4 points",
                   facesOf("a.vtu", vtuOf("UnstructuredGrid", wrong)));
}

TEST(ModelFaces, VtpHasItsPolygonsAndStrips) {
    const std::string text = vtuOf(
        "PolyData",
        "<Piece NumberOfPoints='4' NumberOfVerts='1' NumberOfLines='0' "
        "NumberOfStrips='1' NumberOfPolys='2'>" +
            kFourPoints + "<Verts>" + arrayOf("connectivity", "0") + arrayOf("offsets", "1") +
            "</Verts><Strips>" + arrayOf("connectivity", "0 1 2 3") + arrayOf("offsets", "4") +
            "</Strips><Polys>" + arrayOf("connectivity", "0 1 2 0 1 2 3") +
            arrayOf("offsets", "3 7") + "</Polys></Piece>");
    const auto model = readModel("a.vtp", text);
    EXPECT_EQ(model->extension(), ".vtp");
    EXPECT_EQ(facesOf("a.VTP", text), (Faces{{0, 1, 2}, {0, 1, 2, 3}, {0, 1, 2}, {2, 1, 3}}));
    EXPECT_EQ(written(*model, model->positions()), text);
    auto moved = copyOf(model->positions());
    moved[2] = {2, 3, 4};
    const auto again = readModel("b.vtp", written(*model, moved));
    EXPECT_EQ(copyOf(again->positions()), moved);
    EXPECT_EQ(again->readSurface().faces, model->readSurface().faces);
    EXPECT_REFUSED(FileError, "PolyData", readModel("a.vtu", text));
}

TEST(ModelFaces, StorageIsTheTypeOfTheCoordinates) {
    EXPECT_EQ(readModel("a.obj", kFivePoints)->storage(), CoordinateStorage::Text);
    const auto ply = [](const std::string& x, const std::string& yz) {
        return readModel("a.ply", "ply\nformat ascii 1.0\nelement vertex 1\nproperty " + x +
                                      " x\nproperty " + yz + " y\nproperty " + yz +
                                      " z\nend_header\n0 0 0\n")
            ->storage();
    };
    EXPECT_EQ(ply("double", "double"), CoordinateStorage::Double);
    EXPECT_EQ(ply("double", "float"), CoordinateStorage::Float);
    std::string stl(84, '\0');
    stl[80] = 1;
    EXPECT_EQ(readModel("a.stl", stl + std::string(50, '\0'))->storage(), CoordinateStorage::Float);
    const auto vtu = [](const std::string& type) {
        std::string points = kFourPoints;
        points.replace(points.find("Float32"), 7, type);
        return readModel("a.vtu",
                         vtuOf("UnstructuredGrid", "<Piece NumberOfPoints='4' NumberOfCells='0'>" +
                                                       points + "<Cells/></Piece>"))
            ->storage();
    };
    EXPECT_EQ(vtu("Float32"), CoordinateStorage::Float);
    EXPECT_EQ(vtu("Float64"), CoordinateStorage::Double);
    EXPECT_EQ(vtu("Int32"), CoordinateStorage::Integer);
}

}  // namespace
}  // namespace espalier::io
