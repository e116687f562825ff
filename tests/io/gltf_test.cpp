// SPDX-License-Identifier: Apache-2.0
// Files of glTF 2.0 as models. The files are made here, number by number, and read again by a
// reader of this test, which knows nothing of io/gltf.
#include <espalier/io/files/base64.h>
#include <espalier/io/model_part.h>
#include <io/gradient_samples.h>
#include <io/model_files.h>

#include <cmath>
#include <nlohmann/json.hpp>

namespace espalier::io {
namespace {

using nlohmann::json;

/// A file under construction: JSON, and one buffer.
struct GltfSample {
    json root = {{"asset", {{"version", "2.0"}}},
                 {"bufferViews", json::array()},
                 {"accessors", json::array()}};
    std::string data;

    std::size_t view(const std::string& bytes, std::size_t stride = 0) {
        data.append((4 - data.size() % 4) % 4, '\0');
        root["bufferViews"].push_back(
            {{"buffer", 0}, {"byteOffset", data.size()}, {"byteLength", bytes.size()}});
        if (stride > 0) root["bufferViews"].back()["byteStride"] = stride;
        data += bytes;
        return root["bufferViews"].size() - 1;
    }

    /// \param type of the accessor: 5126 for floats
    std::size_t accessor(std::size_t view, std::size_t count, const char* shape = "VEC3",
                         int type = 5126, std::size_t offset = 0) {
        root["accessors"].push_back({{"bufferView", view},
                                     {"byteOffset", offset},
                                     {"componentType", type},
                                     {"count", count},
                                     {"type", shape}});
        return root["accessors"].size() - 1;
    }

    template <class Number>
    std::size_t add(const std::vector<Number>& numbers, const char* shape = "VEC3",
                    int type = 5126) {
        std::string bytes;
        for (const Number number : numbers) bytes += bytesOf(number, std::endian::little);
        const std::map<std::string, std::size_t> kSizes = {
            {"SCALAR", 1}, {"VEC2", 2}, {"VEC3", 3}, {"VEC4", 4}, {"MAT4", 16}};
        return accessor(view(bytes), numbers.size() / kSizes.at(shape), shape, type);
    }

    std::string text() const {
        json written = root;
        if (!data.empty())
            written["buffers"] = {
                {{"byteLength", data.size()},
                 {"uri", "data:application/octet-stream;base64," + encodeBase64(data)}}};
        return written.dump();
    }

    std::string binary() const {
        json written = root;
        written["buffers"] = {{{"byteLength", data.size()}}};
        std::string head = written.dump(), body = data;
        head.append((4 - head.size() % 4) % 4, ' ');
        body.append((4 - body.size() % 4) % 4, '\0');
        const auto word = [](std::size_t number) {
            return bytesOf(static_cast<std::uint32_t>(number), std::endian::little);
        };
        return "glTF" + word(2) + word(28 + head.size() + body.size()) + word(head.size()) +
               "JSON" + head + word(body.size()) + std::string("BIN\0", 4) + body;
    }
};

/// Reads floats of a file that has its data in the text, or that is a .glb.
struct ParsedGltf {
    json root;
    std::string data;

    explicit ParsedGltf(const std::string& bytes) {
        if (bytes.starts_with("glTF")) {
            std::uint32_t size;
            std::memcpy(&size, bytes.data() + 12, 4);
            root = json::parse(bytes.substr(20, size));
            data = bytes.substr(28 + size);
            return;
        }
        root = json::parse(bytes);
        const std::string uri = root["buffers"][0]["uri"];
        const std::string digits = uri.substr(uri.find(',') + 1);
        unsigned group = 0;
        for (std::size_t i = 0; i < digits.size() && digits[i] != '='; ++i) {
            group = group << 6 | unsigned(kBase64Alphabet.find(digits[i]));
            if (i % 4 != 0) data += char(group >> (6 - 2 * (i % 4)) & 0xff);
        }
    }

    std::vector<std::vector<float>> floats(std::size_t accessor) const {
        const json& a = root["accessors"][accessor];
        EXPECT_EQ(a["componentType"], 5126);
        const json& view = root["bufferViews"][a["bufferView"].get<std::size_t>()];
        const std::size_t width = a["type"] == "VEC3" ? 3 : a["type"] == "VEC4" ? 4 : 2;
        const std::size_t stride = view.value("byteStride", 4 * width);
        std::vector<std::vector<float>> rows;
        for (std::size_t i = 0; i < a["count"]; ++i) {
            auto& row = rows.emplace_back(width);
            std::memcpy(
                row.data(),
                data.data() + view.value("byteOffset", 0) + a.value("byteOffset", 0) + i * stride,
                4 * width);
        }
        return rows;
    }

    json attribute(const char* name, std::size_t mesh = 0, std::size_t primitive = 0) const {
        return root["meshes"][mesh]["primitives"][primitive]["attributes"][name];
    }
};

using FloatRows = std::vector<std::vector<float>>;

const std::vector<float> kGltfCorners = {0, 0, 0, 1, 0, 0, 0, 1, 0};
const std::vector<float> kGltfNormals = {0, 0, 1, 0, 0, 1, 0, 0, 1};

/// A triangle with normals and tangents, drawn by a node.
GltfSample triangle(const json& node = json::object()) {
    GltfSample sample;
    const auto points = sample.add(kGltfCorners);
    sample.root["accessors"][points].update({{"min", {0, 0, 0}}, {"max", {1, 1, 0}}});
    const auto normals = sample.add(kGltfNormals);
    const auto tangents =
        sample.add(std::vector<float>{1, 0, 0, -1, 1, 0, 0, -1, 1, 0, 0, 1}, "VEC4");
    sample.root["meshes"] = {
        {{"primitives",
          {{{"attributes", {{"POSITION", points}, {"NORMAL", normals}, {"TANGENT", tangents}}}}}}}};
    json drawn = node;
    drawn["mesh"] = 0;
    sample.root["nodes"] = json::array({drawn});
    sample.root["scenes"] = {{{"nodes", {0}}}};
    sample.root["extras"] = {{"kept", "as it was"}};
    return sample;
}

std::vector<Point3> movedBy(std::span<const Point3> points, const Point3& by) {
    std::vector<Point3> moved = copyOf(points);
    for (Point3& point : moved)
        for (std::size_t axis = 0; axis < 3; ++axis) point[axis] += by[axis];
    return moved;
}

std::string writtenAs(const Model& model, const std::string& name, std::span<const Point3> points,
                      std::span<const DeformationGradient> gradients = {}) {
    const TemporaryFolder folder;
    if (gradients.empty())
        model.write(folder / name, points);
    else
        model.write(folder / name, points, gradients);
    return readFile(folder / name);
}

TEST(Gltf, PointsAreWhereTheNodesDrawThem) {
    // The turn by 90 degrees about z comes after the scale, and the translation after both.
    const auto sample = triangle({{"translation", {10, 0, 0}},
                                  {"rotation", {0, 0, std::sqrt(0.5), std::sqrt(0.5)}},
                                  {"scale", {2, 3, 1}}});
    const auto model = readModel("a.gltf", sample.text());
    const std::vector<Point3> expected = {{10, 0, 0}, {10, 2, 0}, {7, 0, 0}};
    for (std::size_t i = 0; i < 3; ++i)
        for (std::size_t axis = 0; axis < 3; ++axis)
            EXPECT_NEAR(model->positions()[i][axis], expected[i][axis], 4e-15);
    // A matrix is stored column by column; children follow their parents.
    auto nested = triangle({{"matrix", {0, 1, 0, 0, -1, 0, 0, 0, 0, 0, 1, 0, 5, 6, 7, 1}}});
    nested.root["nodes"].push_back({{"translation", {0, 0, 1}}, {"children", {0}}});
    nested.root["scenes"][0]["nodes"] = {1};
    EXPECT_EQ(copyOf(readModel("a.gltf", nested.text())->positions()),
              (std::vector<Point3>{{5, 6, 8}, {5, 7, 8}, {4, 6, 8}}));
}

TEST(Gltf, AtRestTheFileIsTheSame) {
    const auto sample = triangle({{"scale", {0.1, 0.1, 0.1}}});
    const std::vector<DeformationGradient> still(3, test::kIdentity);
    for (const auto& [name, bytes] : {std::pair<std::string, std::string>{"a.glb", sample.binary()},
                                      {"a.gltf", sample.text()}}) {
        const auto model = readModel(name, bytes);
        EXPECT_EQ(writtenAs(*model, name, model->positions()), bytes);
        EXPECT_EQ(writtenAs(*model, name, model->positions(), still), bytes);
        EXPECT_EQ(writtenAs(*model, "no_extension", model->positions()), bytes);
    }
}

TEST(Gltf, NewPointsGoBackThroughTheNode) {
    const auto sample = triangle({{"translation", {10, 0, 0}}, {"scale", {2, 4, 1}}});
    const auto model = readModel("a.glb", sample.binary());
    const ParsedGltf moved(writtenAs(*model, "b.glb", movedBy(model->positions(), {2, 4, 8})));
    EXPECT_EQ(moved.floats(0), (FloatRows{{1, 1, 8}, {2, 1, 8}, {1, 2, 8}}));
    EXPECT_EQ(moved.root["accessors"][0]["min"], (json{1.0, 1.0, 8.0}));
    EXPECT_EQ(moved.root["accessors"][0]["max"], (json{2.0, 2.0, 8.0}));
    // Nothing else has changed: no accessor and no view is new.
    json expected = sample.root, now = moved.root;
    for (json* each : {&expected, &now}) {
        each->erase("buffers");
        (*each)["accessors"][0].erase("min");
        (*each)["accessors"][0].erase("max");
    }
    EXPECT_EQ(now, expected);
    EXPECT_EQ(moved.floats(1), ParsedGltf(sample.binary()).floats(1));
}

TEST(Gltf, DirectionsFollowInTheFrameOfTheNode) {
    // In the world, the node maps the normal z to x, and the tangent x to y. A quarter turn about z
    // takes x to y and y to -x: in the mesh, z becomes x and x becomes -z.
    const json node = {{"matrix", {0, 1, 0, 0, 0, 0, 1, 0, 1, 0, 0, 0, 0, 0, 0, 1}}};
    const auto sample = triangle(node);
    const auto model = readModel("a.gltf", sample.text());
    EXPECT_EQ(model->directions().normals, 3u);
    EXPECT_EQ(model->directions().tangents, 3u);
    const std::vector<DeformationGradient> turn(3, test::kQuarterTurn);
    const ParsedGltf moved(writtenAs(*model, "a.gltf", model->positions(), turn));
    EXPECT_EQ(moved.floats(1), (FloatRows{{1, 0, 0}, {1, 0, 0}, {1, 0, 0}}));
    EXPECT_EQ(moved.floats(2), (FloatRows{{0, 0, -1, -1}, {0, 0, -1, -1}, {0, 0, -1, 1}}));
}

TEST(Gltf, TheBitangentFollowsWhereAMapMirrors) {
    // The bitangent is w (n x t). It follows F with the same w, also for a mirror, because the
    // normal follows the cofactors.
    const auto model = readModel("a.gltf", triangle().text());
    const DeformationGradient mirror = {-1, 0, 0, 0, 1, 0, 0, 0, 1};
    const ParsedGltf moved(writtenAs(*model, "a.gltf", model->positions(),
                                     std::vector<DeformationGradient>(3, mirror)));
    const auto normal = moved.floats(1)[2], tangent = moved.floats(2)[2];
    EXPECT_EQ(normal, (std::vector<float>{0, 0, -1}));
    EXPECT_EQ(tangent, (std::vector<float>{-1, 0, 0, 1}));
    // n x t = (0, 1, 0) = F (0, 1, 0), where (0, 1, 0) was the bitangent.
    EXPECT_EQ(tangent[3] * (normal[2] * tangent[0] - normal[0] * tangent[2]), 1);
}

TEST(Gltf, AMeshAtSeveralPlacesBecomesSeveralMeshes) {
    auto sample = triangle();
    sample.root["nodes"].push_back({{"mesh", 0}, {"translation", {0, 0, 5}}});
    sample.root["nodes"].push_back({{"mesh", 0}, {"translation", {0, 0, 5}}});
    const auto model = readModel("a.gltf", sample.text());
    ASSERT_EQ(model->positions().size(), 6u);  // the third node draws at the place of the second
    auto points = copyOf(model->positions());
    points[4][0] = 7;
    const ParsedGltf moved(writtenAs(*model, "a.gltf", points));
    ASSERT_EQ(moved.root["meshes"].size(), 2u);
    EXPECT_EQ(moved.root["nodes"][0]["mesh"], 0);
    EXPECT_EQ(moved.root["nodes"][1]["mesh"], 1);
    EXPECT_EQ(moved.root["nodes"][2]["mesh"], 1);
    EXPECT_EQ(moved.floats(moved.attribute("POSITION", 0)),
              (FloatRows{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}}));
    EXPECT_EQ(moved.floats(moved.attribute("POSITION", 1)),
              (FloatRows{{0, 0, 0}, {7, 0, 0}, {0, 1, 0}}));
    EXPECT_EQ(moved.attribute("NORMAL", 1), moved.attribute("NORMAL", 0));
}

TEST(Gltf, NotesSayWhatStaysAndWhatIsCopied) {
    EXPECT_TRUE(readModel("a.gltf", triangle().text())->notes().empty());
    auto sample = triangle({{"scale", {1, 1, 0}}});
    sample.root["meshes"].push_back(sample.root["meshes"][0]);
    sample.root["nodes"].push_back({{"mesh", 0}, {"translation", {0, 0, 5}}});
    const auto model = readModel("a.gltf", sample.text());
    EXPECT_THAT(model->notes(),
                testing::ElementsAre(
                    "1 mesh stays, because no node draws it",
                    "1 mesh is drawn at several places, and becomes a mesh for each once its "
                    "points move",
                    "3 points stay, because the matrices that draw them have no inverse"));
    // They do stay, and the others move.
    const ParsedGltf moved(writtenAs(*model, "a.gltf", movedBy(model->positions(), {0, 0, 1})));
    EXPECT_EQ(moved.floats(moved.attribute("POSITION", 0)),
              (FloatRows{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}}));
    EXPECT_EQ(moved.floats(moved.attribute("POSITION", 2)),
              (FloatRows{{0, 0, 1}, {1, 0, 1}, {0, 1, 1}}));
}

TEST(Gltf, MorphTargetsFollowAsPoints) {
    auto sample = triangle();
    const auto moves = sample.add(std::vector<float>{0, 0, 1, 0, 0, 1, 0, 0, 3});
    const auto turns = sample.add(std::vector<float>{1, 0, -1, 1, 0, -1, 0, 0, 0});
    sample.root["meshes"][0]["primitives"][0]["targets"] = {
        {{"POSITION", moves}, {"NORMAL", turns}}};
    const auto model = readModel("a.gltf", sample.text());
    ASSERT_EQ(model->positions().size(), 6u);
    EXPECT_EQ(model->positions()[3], (Point3{0, 0, 1}));
    EXPECT_EQ(model->positions()[5], (Point3{0, 1, 3}));
    EXPECT_EQ(model->directions().normals, 6u);
    // The mesh moves by one in x, its target by two, and the normals of the target turn.
    auto points = copyOf(model->positions());
    for (std::size_t i = 0; i < 6; ++i) points[i][0] += i < 3 ? 1 : 2;
    std::vector<DeformationGradient> gradients(6, test::kIdentity);
    for (std::size_t i = 3; i < 6; ++i) gradients[i] = test::kQuarterTurn;
    const ParsedGltf moved(writtenAs(*model, "a.gltf", points, gradients));
    EXPECT_EQ(moved.floats(0), (FloatRows{{1, 0, 0}, {2, 0, 0}, {1, 1, 0}}));
    EXPECT_EQ(moved.floats(moves), (FloatRows{{1, 0, 1}, {1, 0, 1}, {1, 0, 3}}));
    EXPECT_EQ(moved.floats(turns), (FloatRows{{0, 1, -1}, {0, 1, -1}, {0, 0, 0}}));
}

TEST(Gltf, SkinnedMeshesFollowWhereTheirJointsDrawThem) {
    auto sample = triangle({{"translation", {100, 0, 0}}, {"skin", 0}});  // glTF ignores this node
    const auto joints =
        sample.add(std::vector<std::uint8_t>{0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0}, "VEC4", 5121);
    const auto weights =
        sample.add(std::vector<float>{1, 0, 0, 0, 1, 0, 0, 0, 0.5, 0.5, 0, 0}, "VEC4");
    const auto binds =
        sample.add(std::vector<float>{1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0,  0, 0, 1,
                                      1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, -1, 0, 0, 1},
                   "MAT4");
    auto& attributes = sample.root["meshes"][0]["primitives"][0]["attributes"];
    attributes["JOINTS_0"] = joints;
    attributes["WEIGHTS_0"] = weights;
    // Joint 0 moves by 2 in z. Joint 1 takes its origin (1, 0, 0) to (1, 0, 4), twice as large.
    sample.root["nodes"].push_back({{"translation", {0, 0, 2}}});
    sample.root["nodes"].push_back({{"translation", {1, 0, 4}}, {"scale", {2, 2, 2}}});
    sample.root["skins"] = {{{"joints", {1, 2}}, {"inverseBindMatrices", binds}}};
    const auto model = readModel("a.gltf", sample.text());
    // Point 2, at (0, 1, 0), is between (0, 1, 2) and (-1, 2, 4).
    EXPECT_EQ(copyOf(model->positions()),
              (std::vector<Point3>{{0, 0, 2}, {1, 0, 4}, {-0.5, 1.5, 3}}));
    const ParsedGltf moved(writtenAs(*model, "a.gltf", movedBy(model->positions(), {0, 0, 3})));
    EXPECT_EQ(moved.floats(0), (FloatRows{{0, 0, 3}, {1, 0, 1.5}, {0, 1, 2}}));
    EXPECT_EQ(moved.floats(weights), (FloatRows{{1, 0, 0, 0}, {1, 0, 0, 0}, {0.5, 0.5, 0, 0}}));
}

TEST(Gltf, ReadsInterleavedSparseAndNormalizedNumbers) {
    GltfSample sample;
    std::string interleaved;
    for (std::size_t i = 0; i < 3; ++i)
        for (const auto* values : {&kGltfCorners, &kGltfNormals})
            for (std::size_t axis = 0; axis < 3; ++axis)
                interleaved += bytesOf((*values)[3 * i + axis], std::endian::little);
    const auto view = sample.view(interleaved, 24);
    const auto points = sample.accessor(view, 3);
    const auto normals = sample.accessor(view, 3, "VEC3", 5126, 12);
    // Sparse: element 1 of three zeros. Normalized: 127 is 1, and -128 is -1.
    const auto sparse = sample.add(std::vector<float>(9));
    const auto where = sample.view(std::string("\1", 1));
    std::string value;
    for (const float x : {4.0F, 5.0F, 6.0F}) value += bytesOf(x, std::endian::little);
    sample.root["accessors"][sparse]["sparse"] = {
        {"count", 1},
        {"indices", {{"bufferView", where}, {"componentType", 5121}}},
        {"values", {{"bufferView", sample.view(value)}}}};
    const auto bytes =
        sample.add(std::vector<std::int8_t>{127, 0, 0, -128, 0, 0, 0, 127, 0}, "VEC3", 5120);
    sample.root["accessors"][bytes]["normalized"] = true;
    const auto mesh = [](std::size_t position, json more = json::object()) {
        more["POSITION"] = position;
        return json{{"primitives", {{{"attributes", more}}}}};
    };
    sample.root["meshes"] = {mesh(points, {{"NORMAL", normals}}), mesh(sparse), mesh(bytes)};
    sample.root["nodes"] = {{{"mesh", 0}}, {{"mesh", 1}}, {{"mesh", 2}}};
    const auto model = readModel("a.glb", sample.binary());
    EXPECT_EQ(
        copyOf(model->positions()),
        (std::vector<Point3>{
            {0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {}, {4, 5, 6}, {}, {1, 0, 0}, {-1, 0, 0}, {0, 1, 0}}));
    const std::vector<DeformationGradient> turn(9, test::kQuarterTurn);
    const ParsedGltf moved(
        writtenAs(*model, "a.glb", movedBy(model->positions(), {0, 0, 1}), turn));
    EXPECT_EQ(moved.floats(moved.attribute("POSITION")),
              (FloatRows{{0, 0, 1}, {1, 0, 1}, {0, 1, 1}}));
    EXPECT_EQ(moved.floats(moved.attribute("NORMAL")),
              (FloatRows{{0, 0, 1}, {0, 0, 1}, {0, 0, 1}}));
    EXPECT_EQ(moved.floats(moved.attribute("POSITION", 1)),
              (FloatRows{{0, 0, 1}, {4, 5, 7}, {0, 0, 1}}));
    EXPECT_EQ(moved.floats(moved.attribute("POSITION", 2)),
              (FloatRows{{1, 0, 1}, {-1, 0, 1}, {0, 1, 1}}));
    // The plain floats are replaced where they are; the others are floats now.
    EXPECT_EQ(moved.root["accessors"][0], sample.root["accessors"][0]);
    EXPECT_FALSE(moved.root["accessors"][sparse].contains("sparse"));
    EXPECT_FALSE(moved.root["accessors"][bytes].contains("normalized"));
}

TEST(Gltf, BytesThatOthersUseAreNotReplaced) {
    // Two accessors see the same bytes: one is drawn, the other is drawn elsewhere.
    auto sample = triangle();
    const auto other = sample.accessor(0, 3);
    sample.root["meshes"].push_back({{"primitives", {{{"attributes", {{"POSITION", other}}}}}}});
    sample.root["nodes"].push_back({{"mesh", 1}, {"translation", {0, 0, 1}}});
    const auto model = readModel("a.glb", sample.binary());
    auto points = copyOf(model->positions());
    points[0][0] = -1;
    const ParsedGltf moved(writtenAs(*model, "a.glb", points));
    EXPECT_EQ(moved.floats(moved.attribute("POSITION", 0))[0], (std::vector<float>{-1, 0, 0}));
    EXPECT_EQ(moved.floats(moved.attribute("POSITION", 1))[0], (std::vector<float>{0, 0, 0}));
    // An accessor that an undrawn mesh uses, too.
    auto shared = triangle();
    shared.root["meshes"].push_back({{"primitives", {{{"attributes", {{"POSITION", 0}}}}}}});
    const auto drawn = readModel("a.glb", shared.binary());
    const ParsedGltf second(writtenAs(*drawn, "a.glb", movedBy(drawn->positions(), {1, 0, 0})));
    EXPECT_NE(second.attribute("POSITION", 0), 0);
    EXPECT_EQ(second.attribute("POSITION", 1), 0);
    EXPECT_EQ(second.floats(0), (FloatRows{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}}));
}

TEST(Gltf, FacesAreTrianglesStripsAndFans) {
    GltfSample sample;
    const auto points = sample.add(std::vector<float>{0, 0, 0, 1, 0, 0, 0, 1, 0, 1, 1, 0});
    const auto indices = sample.add(std::vector<std::uint16_t>{3, 2, 1}, "SCALAR", 5123);
    json primitives = json::array();
    for (const int mode : {4, 5, 6, 0, 1})
        primitives.push_back({{"attributes", {{"POSITION", points}}}, {"mode", mode}});
    primitives[0]["indices"] = indices;
    sample.root["meshes"] = {{{"primitives", primitives}}};
    sample.root["nodes"] = {{{"mesh", 0}}};
    const auto model = readModel("a.gltf", sample.text());
    EXPECT_EQ(model->positions().size(), 4u);  // all primitives have the same points
    EXPECT_EQ(model->readSurface().faces.corners,
              (std::vector<Index>{3, 2, 1, 0, 1, 2, 1, 3, 2, 1, 2, 0, 2, 3, 0}));
    // A node that mirrors turns the faces over.
    sample.root["nodes"][0]["scale"] = {-1, 1, 1};
    EXPECT_EQ(readModel("a.gltf", sample.text())->readSurface().faces[0][1], 1);
}

TEST(Gltf, BuffersBesideTheFileAreReadAndWritten) {
    const TemporaryFolder folder;
    std::filesystem::create_directory(folder / "in here");
    std::filesystem::create_directory(folder / "out");
    auto sample = triangle();
    json root = sample.root;
    root["buffers"] = {{{"byteLength", sample.data.size()}, {"uri", "a%20b.bin"}}};
    root["images"] = {{{"uri", "picture.png"}}, {{"uri", "data:image/png;base64,AAEC"}}};
    test::putFile(folder / "in here/a.gltf", root.dump());
    test::putFile(folder / "in here/a b.bin", sample.data);
    const auto model = readModel(folder / "in here/a.gltf");
    // At rest, the buffer stays where it is, and is named from the new folder.
    model->write(folder / "out/b.gltf", model->positions());
    json written = json::parse(readFile(folder / "out/b.gltf"));
    EXPECT_EQ(written["buffers"][0]["uri"], "../in%20here/a%20b.bin");
    EXPECT_EQ(written["images"][0]["uri"], "../in%20here/picture.png");
    EXPECT_FALSE(std::filesystem::exists(folder / "out/b.bin"));
    EXPECT_TRUE(readModel(folder / "out/b.gltf")->positions()[1] == model->positions()[1]);
    // With new points, it becomes a file beside the new one, and the old one stays.
    model->write(folder / "out/b.gltf", movedBy(model->positions(), {0, 0, 1}));
    written = json::parse(readFile(folder / "out/b.gltf"));
    EXPECT_EQ(written["buffers"][0]["uri"], "b.bin");
    EXPECT_EQ(readModel(folder / "out/b.gltf")->positions()[1], (Point3{1, 0, 1}));
    EXPECT_EQ(readFile(folder / "in here/a b.bin"), sample.data);
    // A .glb has all in itself, but pictures in other files.
    model->write(folder / "out/c.glb", model->positions());
    const ParsedGltf packed(readFile(folder / "out/c.glb"));
    EXPECT_EQ(packed.floats(0), (FloatRows{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}}));
    EXPECT_FALSE(packed.root["buffers"][0].contains("uri"));
    EXPECT_EQ(packed.root["images"][0]["uri"], "../in%20here/picture.png");
    EXPECT_EQ(packed.root["images"][1]["mimeType"], "image/png");
    const json& view =
        packed.root["bufferViews"][packed.root["images"][1]["bufferView"].get<int>()];
    EXPECT_EQ(packed.data.substr(view["byteOffset"], view["byteLength"]), std::string("\0\1\2", 3));
}

TEST(Gltf, NoOtherFileIsOverwritten) {
    // The buffer of a picture has the name that the new buffer would get.
    const TemporaryFolder folder;
    const auto sample = triangle();
    json root = sample.root;
    root["buffers"] = json::array({json{{"byteLength", sample.data.size()}, {"uri", "c.bin"}},
                                   json{{"byteLength", 4}, {"uri", "b.bin"}}});
    test::putFile(folder / "a.gltf", root.dump());
    test::putFile(folder / "b.bin", "keep");
    test::putFile(folder / "c.bin", sample.data);
    const auto model = readModel(folder / "a.gltf");
    model->write(folder / "b.gltf", movedBy(model->positions(), {0, 0, 1}));
    EXPECT_EQ(readFile(folder / "b.bin"), "keep");
    const json written = json::parse(readFile(folder / "b.gltf"));
    EXPECT_EQ(written["buffers"][0]["uri"], "b_1.bin");
    EXPECT_EQ(written["buffers"][1]["uri"], "b.bin");
    EXPECT_EQ(readModel(folder / "b.gltf")->positions()[0][2], 1);
}

/// A description of sparse values in views.
json sparseValues(std::size_t indices, std::size_t values) {
    return {{"count", 1},
            {"indices", {{"bufferView", indices}, {"componentType", 5121}}},
            {"values", {{"bufferView", values}}}};
}

TEST(Gltf, SparseNumbersOfAFileBesideNeedNoView) {
    const TemporaryFolder folder;
    auto sample = triangle();
    const auto moves = sample.view(std::string(8, '\0') + bytesOf(1.0F, std::endian::little));
    const auto where = sample.view(std::string("\1", 1));
    // The file beside has more bytes than the text.
    constexpr std::size_t kCount = 5000;
    sample.data.resize(12 * kCount);
    json root = sample.root;
    root["buffers"] = json::array({json{{"byteLength", sample.data.size()}, {"uri", "a.bin"}}});
    root["accessors"][0] = {{"componentType", 5126},
                            {"count", kCount},
                            {"type", "VEC3"},
                            {"sparse", sparseValues(where, moves)}};
    root["meshes"][0]["primitives"][0]["attributes"] = {{"POSITION", 0}};
    test::putFile(folder / "a.gltf", root.dump());
    test::putFile(folder / "a.bin", sample.data);
    const auto model = readModel(folder / "a.gltf");
    EXPECT_EQ(model->positions().size(), kCount);
    EXPECT_EQ(model->positions()[1], (Point3{0, 0, 1}));
}

TEST(Gltf, BytesOfSparseValuesAreNotReplaced) {
    // The sparse values of an undrawn mesh are the bytes of the drawn positions.
    auto sample = triangle();
    const auto where = sample.view(std::string("\1", 1));
    const auto sparse = sample.add(std::vector<float>(9));
    sample.root["accessors"][sparse]["sparse"] = sparseValues(where, 0);
    sample.root["meshes"].push_back(sample.root["meshes"][0]);
    sample.root["meshes"][1]["primitives"][0]["attributes"] = {{"POSITION", sparse}};
    const auto model = readModel("a.glb", sample.binary());
    const ParsedGltf moved(writtenAs(*model, "a.glb", movedBy(model->positions(), {5, 0, 0})));
    EXPECT_NE(moved.root["accessors"][0]["bufferView"], 0);
    EXPECT_EQ(moved.data.substr(0, 36), sample.data.substr(0, 36));
}

TEST(Gltf, NamesAndTexturesOfOddObjFilesAreKept) {
    const auto model = readModel("a.obj",
                                 "v 0 0 0\nv 1 0 0\nv 0 1 0\nvt 0.5\nusemtl My Red\nf 1/1 2/1 3/1\n"
                                 "usemtl My Blue\nf 1/1 3/1 2/1\nusemtl M\xFC"
                                 "ller\nf 2/1 3/1 1/1\n");
    const ParsedGltf made(writtenAs(*model, "a.glb", model->positions()));
    EXPECT_EQ(made.root["materials"][0]["name"], "My Red");
    EXPECT_EQ(made.root["materials"][1]["name"], "My Blue");
    EXPECT_EQ(made.root["materials"][2]["name"], "M\uFFFDller");
    EXPECT_EQ(made.floats(made.attribute("TEXCOORD_0"))[0], (std::vector<float>{0.5, 1}));
    const auto odd = readModel("a.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nvt 1 nan\nf 1/1 2/1 3/1\n");
    EXPECT_TRUE(odd->readSurface().textures.empty());
    EXPECT_EQ(odd->readSurface().others[0].kind, "texture coordinates (some corners have none)");
}

TEST(Gltf, DamagedFilesAreRefusedAndNamed) {
    const std::string good = triangle().binary();
    test::expectPartsRefused("a.glb", good, good.size() - 1);
    const auto expectRefused = [](const std::string& message, const json& patch,
                                  const GltfSample& sample = triangle()) {
        GltfSample changed = sample;
        changed.root = changed.root.patch(patch);
        EXPECT_REFUSED(FileError, message, readModel("a.gltf", changed.text()));
    };
    const auto replace = [](const std::string& path, const json& value) {
        return json{{{"op", "add"}, {"path", path}, {"value", value}}};
    };
    EXPECT_REFUSED(FileError, "is no JSON", readModel("a.gltf", "{"));
    EXPECT_REFUSED(FileError, "no \"asset\"", readModel("a.gltf", "{}"));
    EXPECT_REFUSED(FileError, "nests more than",
                   readModel("a.gltf", std::string(1000, '[') + std::string(1000, ']')));
    expectRefused("is glTF '1.0'; expected 2.0", replace("/asset/version", "1.0"));
    expectRefused("is glTF 1.0; expected 2.0", replace("/asset/version", ""));
    expectRefused("item 99 of 'bufferViews' does not exist; there are 3",
                  replace("/accessors/0/bufferView", 99));
    expectRefused("needs 120 bytes at byte 0 of view 0, which has 36",
                  replace("/accessors/0/count", 10));
    expectRefused("of view 0", replace("/accessors/0/count", 9007199254740991));
    expectRefused("the component type 5124", replace("/accessors/0/componentType", 5124));
    expectRefused(
        "accessor 1 has 3 normals; expected 4, one per position",
        replace("/accessors/0", json{{"componentType", 5126}, {"count", 4}, {"type", "VEC3"}}));
    expectRefused("claims 1000000 elements without a view",
                  replace("/accessors/0",
                          json{{"componentType", 5126}, {"count", 1000000}, {"type", "VEC3"}}));
    expectRefused("item 5 of 'meshes' does not exist; there are 1", replace("/nodes/0/mesh", 5));
    expectRefused("children of their own descendants", replace("/nodes/0/children", {0}));
    expectRefused("has the child 7", replace("/nodes/0/children", {7}));
    expectRefused("malformed 'matrix'; expected 16 numbers", replace("/nodes/0/matrix", {1}));
    expectRefused("no node draws a mesh", replace("/nodes", json::array()));
    expectRefused(
        "EXT_mesh_gpu_instancing",
        replace("/nodes/0/extensions", json{{"EXT_mesh_gpu_instancing", json::object()}}));
    // Joints that another primitive with more points has, too.
    GltfSample skinned = triangle({{"skin", 0}});
    const auto joints = skinned.add(std::vector<std::uint8_t>(12), "VEC4", 5121);
    const auto weights = skinned.add(std::vector<float>(12, 0.25F), "VEC4");
    const auto longer = skinned.add(std::vector<float>(3000));
    json& primitives = skinned.root["meshes"][0]["primitives"];
    primitives[0]["attributes"] = {{"POSITION", 0}, {"JOINTS_0", joints}, {"WEIGHTS_0", weights}};
    primitives.push_back(json(primitives[0]));
    primitives[1]["attributes"]["POSITION"] = longer;
    skinned.root["skins"] = json::array({json{{"joints", json::array({0})}}});
    expectRefused("do not have 4 joints and weights for each of 1000 points", json::array(),
                  skinned);
    expectRefused("'POSITION' is '\"x\"'; expected a whole number",
                  replace("/meshes/0/primitives/0/attributes/POSITION", "x"));
    GltfSample remote = triangle();
    const std::string text = remote.text();
    const std::size_t at = text.find("data:");
    EXPECT_REFUSED(FileError, "expected data in the text, or a file beside the .gltf",
                   readModel("a.gltf", text.substr(0, at) + "https:" + text.substr(at + 5)));
    EXPECT_REFUSED(FileError, "its buffer is in another file",
                   readModel("a.gltf", text.substr(0, at) + "none" + text.substr(at + 5)));
}

// A tetrahedron with the corners 0, x, y and z, as Draco's and meshoptimizer's own encoders write
// it: 4 points, 12 indices.

void expectTetrahedron(const std::string& text) {
    std::unique_ptr<Model> model;
    try {
        model = readModel("a.gltf", text);
    } catch (const FileError& error) {
        // A build without the libraries says so.
        ASSERT_THAT(error.what(), HasSubstr("lacks the library that reads them"));
        GTEST_SKIP() << error.what();
    }
    auto points = copyOf(model->positions());
    std::sort(points.begin(), points.end());
    EXPECT_EQ(points, (std::vector<Point3>{{0, 0, 0}, {0, 0, 1}, {0, 1, 0}, {1, 0, 0}}));
    EXPECT_EQ(model->readSurface().faces.count(), 4u);
    EXPECT_EQ(writtenAs(*model, "a.gltf", model->positions()), text);
    const auto moved =
        readModel("b.glb", writtenAs(*model, "b.glb", movedBy(model->positions(), {0, 0, 1})));
    EXPECT_EQ(moved->readSurface().faces, model->readSurface().faces);
    EXPECT_EQ(moved->positions()[0][2], model->positions()[0][2] + 1);
    const ParsedGltf parsed(writtenAs(*model, "b.glb", movedBy(model->positions(), {0, 0, 1})));
    EXPECT_FALSE(parsed.root.contains("extensionsRequired"));
    EXPECT_EQ(parsed.root["buffers"].size(), 1u);
}

/// Describes a buffer whose bytes are this base64 text.
json dataBuffer(const std::string& digits, std::size_t size) {
    return {{"byteLength", size}, {"uri", "data:application/octet-stream;base64," + digits}};
}

TEST(Gltf, ReadsMeshesCompressedByDraco) {
    const json root = {
        {"asset", {{"version", "2.0"}}},
        {"extensionsUsed", {"KHR_draco_mesh_compression"}},
        {"extensionsRequired", {"KHR_draco_mesh_compression"}},
        {"buffers",
         {dataBuffer(
             "RFJBQ08CAgEBAAAABAQAAwAAAS8BARAB/wAAAQAJAwAAAAAAAAAAAAAAAACAPwAAAAAAAIA/AAAAAAAA"
             "AAAAAAAAAAAAAAAAgD8AAAAAAAAAAA==",
             82)}},
        {"bufferViews", {{{"buffer", 0}, {"byteLength", 82}}}},
        {"accessors",
         {{{"componentType", 5126},
           {"count", 4},
           {"type", "VEC3"},
           {"min", {0, 0, 0}},
           {"max", {1, 1, 1}}},
          {{"componentType", 5123}, {"count", 12}, {"type", "SCALAR"}}}},
        {"meshes",
         {{{"primitives",
            {{{"attributes", {{"POSITION", 0}}},
              {"indices", 1},
              {"extensions",
               {{"KHR_draco_mesh_compression",
                 {{"bufferView", 0}, {"attributes", {{"POSITION", 0}}}}}}}}}}}}},
        {"nodes", {{{"mesh", 0}}}}};
    expectTetrahedron(root.dump());
    if (IsSkipped()) return;
    // The bounds of a file are those before compression, which changes numbers and indices.
    json other = root;
    other["accessors"][0]["max"] = {2, 1, 1};
    other["accessors"][1]["min"] = {0};
    other["accessors"][1]["max"] = {7};
    const auto model = readModel("a.gltf", other.dump());
    const ParsedGltf plain(writtenAs(*model, "b.glb", model->positions()));
    EXPECT_EQ(plain.root["accessors"][0]["max"], (json{1.0, 1.0, 1.0}));
    EXPECT_EQ(plain.root["accessors"][1]["max"], (json{3}));
    json damaged = root;
    damaged["accessors"][0]["count"] = 5;
    EXPECT_REFUSED(FileError, "accessor 0 claims 5 elements", readModel("a.gltf", damaged.dump()));
    damaged = root;
    damaged["bufferViews"][0]["byteLength"] = 40;
    EXPECT_REFUSED(FileError, "KHR_draco_mesh_compression is damaged",
                   readModel("a.gltf", damaged.dump()));
}

TEST(Gltf, ReadsViewsCompressedByMeshopt) {
    const auto view = [](std::size_t buffer, std::size_t size, std::size_t stride,
                         std::size_t count, const char* mode) {
        return json{{"buffer", 2},
                    {"byteOffset", buffer == 0 ? 0 : 48},
                    {"byteLength", stride * count},
                    {"extensions",
                     {{"EXT_meshopt_compression",
                       {{"buffer", buffer},
                        {"byteLength", size},
                        {"byteStride", stride},
                        {"count", count},
                        {"mode", mode}}}}}};
    };
    const json root = {
        {"asset", {{"version", "2.0"}}},
        {"extensionsUsed", {"EXT_meshopt_compression"}},
        {"extensionsRequired", {"EXT_meshopt_compression"}},
        {"buffers",
         {dataBuffer("oAAAATwAAAD//wE8AAAAfn0AAAEPAAAA//8BDwAAAH59AAABAwAAAP8BAwAAAH4AAAAAAAAAAAAA"
                     "AAAAAAAAAAAAAAAAAAAAAAAAAAAAAA==",
                     79),
          dataBuffer("4f4OAhHwBAB2h1ZneKmGZYlomAFpAAA=", 23),
          {{"byteLength", 96},
           {"extensions", {{"EXT_meshopt_compression", {{"fallback", true}}}}}}}},
        {"bufferViews", {view(0, 79, 12, 4, "ATTRIBUTES"), view(1, 23, 4, 12, "TRIANGLES")}},
        {"accessors",
         {{{"bufferView", 0},
           {"componentType", 5126},
           {"count", 4},
           {"type", "VEC3"},
           {"min", {0, 0, 0}},
           {"max", {1, 1, 1}}},
          {{"bufferView", 1}, {"componentType", 5125}, {"count", 12}, {"type", "SCALAR"}}}},
        {"meshes", {{{"primitives", {{{"attributes", {{"POSITION", 0}}}, {"indices", 1}}}}}}},
        {"nodes", {{{"mesh", 0}}}}};
    expectTetrahedron(root.dump());
    if (IsSkipped()) return;
    json damaged = root;
    damaged["bufferViews"][0]["extensions"]["EXT_meshopt_compression"]["count"] = 4000000;
    EXPECT_REFUSED(FileError, "claims 4000000 elements, which 79 bytes cannot hold",
                   readModel("a.gltf", damaged.dump()));
    damaged = root;
    damaged["bufferViews"][0]["extensions"]["EXT_meshopt_compression"]["byteLength"] = 40;
    EXPECT_REFUSED(FileError, "is damaged, or of a newer version",
                   readModel("a.gltf", damaged.dump()));
}

// New files for models of other formats.

TEST(Gltf, ANewFileHasNormalsTexturesColorsAndMaterials) {
    // Point 1 has two normals, and so becomes two vertices. The quadrilateral is split.
    const auto model = readModel(
        "a.obj",
        "v 0 0 0 1 0 0\nv 1 0 0 0 1 0\nv 1 1 0 0 0 1\nv 0 1 0 1 1 1\nv 2 0 1 0.5 0.5 0.5\n"
        "vt 0 0\nvt 1 0.25\nvn 0 0 2\nvn 1 0 0\n"
        "usemtl red\nf 1/1/1 2/2/1 3/2/1 4/1/1\nusemtl blue\nf 2/2/2 5/1/2 3/2/1\n");
    const TemporaryFolder folder;
    EXPECT_THAT(
        model->checkTarget(folder / "a.glb"),
        testing::EndsWith("a.glb: 1 face is split into 2 triangles; coordinates are rounded "
                          "to single precision"));
    const ParsedGltf made(writtenAs(*model, "a.glb", model->positions()));
    EXPECT_EQ(made.root["materials"], (json{{{"name", "red"}}, {{"name", "blue"}}}));
    const json& primitives = made.root["meshes"][0]["primitives"];
    ASSERT_EQ(primitives.size(), 2u);
    EXPECT_EQ(primitives[0]["material"], 0);
    EXPECT_EQ(primitives[1]["material"], 1);
    const FloatRows points = made.floats(made.attribute("POSITION"));
    ASSERT_EQ(points.size(), 6u);
    EXPECT_EQ(points[1], points[2]);
    FloatRows normals = made.floats(made.attribute("NORMAL"));
    std::sort(normals.begin() + 1, normals.begin() + 3);
    EXPECT_EQ(normals,
              (FloatRows{{0, 0, 1}, {0, 0, 1}, {1, 0, 0}, {0, 0, 1}, {0, 0, 1}, {1, 0, 0}}));
    // v counts downwards in glTF.
    EXPECT_EQ(made.floats(made.attribute("TEXCOORD_0")),
              (FloatRows{{0, 1}, {1, 0.75}, {1, 0.75}, {1, 0.75}, {0, 1}, {0, 1}}));
    // sRGB 0.5 is 0.2140 of the light.
    const FloatRows colors = made.floats(made.attribute("COLOR_0"));
    EXPECT_EQ(colors[0], (std::vector<float>{1, 0, 0, 1}));
    EXPECT_NEAR(colors[5][1], 0.21404, 1e-5);
    const auto read = readModel("b.glb", writtenAs(*model, "b.glb", model->positions()));
    const ModelSurface back = read->readSurface();
    EXPECT_EQ(back.faces.count(), 3u);
    EXPECT_EQ(back.materials, (std::vector<std::string>{"red", "blue"}));
    EXPECT_EQ(back.faceMaterials, (std::vector<Index>{0, 0, 1}));
    const ModelSurface from = model->readSurface();
    ASSERT_EQ(back.textureCorners.size(), 9u);
    for (const std::size_t corner : {0u, 1u, 2u, 6u, 7u, 8u})
        EXPECT_EQ(back.textures[back.textureCorners[corner]],
                  from.textures[from.textureCorners[corner < 6 ? corner : corner - 2]]);
    ASSERT_EQ(back.colors.size(), 6u);
    for (std::size_t c = 0; c < 4; ++c) EXPECT_NEAR(back.colors[5][c], from.colors[4][c], 1e-6);
    // The same in a text.
    EXPECT_EQ(ParsedGltf(writtenAs(*model, "a.gltf", model->positions())).data, made.data);
    // Normals turn with the gradients.
    const ParsedGltf turned(
        writtenAs(*model, "a.glb", model->positions(),
                  std::vector<DeformationGradient>(5, {0, 0, 1, 0, 1, 0, -1, 0, 0})));
    EXPECT_EQ(turned.floats(turned.attribute("NORMAL"))[0], (std::vector<float>{1, 0, 0}));
}

// Colours in bytes are sRGB: 255 is 1, and 51 is 0.2, which is 0.0331 of the light. Texture
// coordinates count v downwards in glTF.
TEST(Gltf, ANewFileHasColorsAndTexturesOfPlyAndVtk) {
    const std::string ply =
        "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty "
        "float z\nproperty uchar green\nproperty uchar red\nproperty uchar blue\nproperty uchar "
        "alpha\nproperty float s\nproperty float t\nproperty int mark\nelement face 1\nproperty "
        "list "
        "uchar int vertex_indices\nend_header\n0 0 0 0 255 0 255 0 0 7\n1 0 0 255 0 0 51 1 0 7\n"
        "0 1 0 51 51 51 0 0 0.25 7\n3 0 1 2\n";
    const std::string legacy =
        "# vtk DataFile Version 3.0\nt\nASCII\nDATASET POLYDATA\nPOINTS 3 double\n0 0 0 1 0 0 0 1 "
        "0\n"
        "POLYGONS 1 4\n3 0 1 2\nPOINT_DATA 3\nSCALARS mark int\nLOOKUP_TABLE default\n7 7 7\n"
        "COLOR_SCALARS rgba 4\n1 0 0 1 0 1 0 0.2 0.2 0.2 0.2 0\n"
        "TEXTURE_COORDINATES st 2 float\n0 0 1 0 0 0.25\n";
    const std::string xml =
        "<VTKFile type=\"PolyData\"><PolyData><Piece NumberOfPoints=\"3\" NumberOfPolys=\"1\">"
        "<PointData TCoords=\"st\"><DataArray type=\"UInt8\" Name=\"rgba\" "
        "NumberOfComponents=\"4\" "
        "format=\"ascii\">255 0 0 255 0 255 0 51 51 51 51 0</DataArray>"
        "<DataArray type=\"Float32\" Name=\"st\" NumberOfComponents=\"2\" format=\"ascii\">"
        "0 0 1 0 0 0.25</DataArray><DataArray type=\"Int32\" Name=\"mark\" format=\"ascii\">7 7 7"
        "</DataArray></PointData><Points><DataArray type=\"Float64\" NumberOfComponents=\"3\" "
        "format=\"ascii\">0 0 0 1 0 0 0 1 0</DataArray></Points><Polys>"
        "<DataArray type=\"Int64\" Name=\"connectivity\" format=\"ascii\">0 1 2</DataArray>"
        "<DataArray type=\"Int64\" Name=\"offsets\" format=\"ascii\">3</DataArray></Polys>"
        "</Piece></PolyData></VTKFile>";
    for (const auto& [name, bytes] :
         {std::pair{"a.ply", ply}, std::pair{"a.vtk", legacy}, std::pair{"a.vtp", xml}}) {
        const auto model = readModel(name, bytes);
        // The other array is all that the new file lacks.
        const TemporaryFolder folder;
        const std::string line = model->checkTarget(folder / "a.glb");
        EXPECT_THAT(line, testing::HasSubstr("'mark'")) << name;
        EXPECT_THAT(line, testing::Not(testing::ContainsRegex("red|rgba|'s'|st'"))) << name;
        const ParsedGltf made(writtenAs(*model, "a.glb", model->positions()));
        const FloatRows colors = made.floats(made.attribute("COLOR_0"));
        const FloatRows expected = {{1, 0, 0, 1}, {0, 1, 0, 0.2f}, {0.0331f, 0.0331f, 0.0331f, 0}};
        ASSERT_EQ(colors.size(), 3u) << name;
        for (std::size_t i = 0; i < 3; ++i)
            for (std::size_t c = 0; c < 4; ++c)
                EXPECT_NEAR(colors[i][c], expected[i][c], 1e-5) << name;  // the digits above
        EXPECT_EQ(made.floats(made.attribute("TEXCOORD_0")), (FloatRows{{0, 1}, {1, 1}, {0, 0.75}}))
            << name;
        // A format without appearance says that they are missing.
        EXPECT_THAT(model->checkTarget(folder / "a.obj"),
                    testing::ContainsRegex(name == std::string("a.ply") ? "'red'.*'s'" : "'rgba'"))
            << name;
    }
}

// What is not taken is named: one colour alone, and data of cells that are named as data of points.
TEST(Gltf, ANewFileNamesColorsThatItLacks) {
    const TemporaryFolder folder;
    const auto red =
        readModel("a.ply",
                  "ply\nformat ascii 1.0\nelement vertex 1\nproperty float x\nproperty "
                  "float y\nproperty float z\nproperty uchar red\nend_header\n0 0 0 9\n");
    EXPECT_THAT(red->checkTarget(folder / "a.glb"),
                testing::HasSubstr("properties of points 'red'"));
    const auto cells = readModel("a.vtk",
                                 "# vtk DataFile Version 3.0\nt\nASCII\nDATASET POLYDATA\nPOINTS 3 "
                                 "double\n0 0 0 1 0 0 0 1 0\n"
                                 "POLYGONS 1 4\n3 0 1 2\nCELL_DATA 1\nCOLOR_SCALARS rgb 3\n1 0 0\n"
                                 "POINT_DATA 3\nCOLOR_SCALARS rgb 3\n1 0 0 0 1 0 0 0 1\n");
    const std::string line = cells->checkTarget(folder / "a.glb");
    EXPECT_THAT(line, testing::HasSubstr("cell data 'rgb'"));
    EXPECT_THAT(line, testing::Not(testing::HasSubstr("point data")));
}

// MeshLab writes the texture coordinates of the corners of a face as a list of the face.
TEST(Gltf, ANewFileHasTexturesOfTheCornersOfAPly) {
    const auto bytes = [](const std::string& second) {
        return "ply\nformat ascii 1.0\nelement vertex 4\nproperty float x\nproperty float y\n"
               "property float z\nelement face 2\nproperty list uchar int vertex_indices\nproperty "
               "list uchar float texcoord\nend_header\n0 0 0\n1 0 0\n1 1 0\n0 1 0\n"
               "3 0 1 2 6 0 0 1 0 1 1\n3 0 2 3 " +
               second + "\n";
    };
    const TemporaryFolder folder;
    const auto model = readModel("a.ply", bytes("6 0.5 0 1 1 0 1"));
    EXPECT_THAT(model->checkTarget(folder / "a.glb"),
                testing::Not(testing::HasSubstr("not written")));
    const ParsedGltf made(writtenAs(*model, "a.glb", model->positions()));
    // Corner 0 has two pairs of coordinates, and so point 0 becomes two vertices.
    EXPECT_EQ(made.floats(made.attribute("POSITION")).size(), 5u);
    EXPECT_EQ(made.floats(made.attribute("TEXCOORD_0"))[4], (std::vector<float>{0, 0}));
    // Without coordinates for one corner there are none.
    const auto part = readModel("a.ply", bytes("0"));
    EXPECT_THAT(part->checkTarget(folder / "a.glb"), testing::HasSubstr("faces 'texcoord'"));
    const ParsedGltf without(writtenAs(*part, "a.glb", part->positions()));
    EXPECT_FALSE(without.root["meshes"][0]["primitives"][0]["attributes"].contains("TEXCOORD_0"));
    EXPECT_REFUSED(FileError, "'foo' is not a texture coordinate",
                   readModel("a.ply", bytes("6 0 0 0 0 0 foo"))->checkTarget(folder / "a.glb"));
}

// Chunks of further kinds stay behind the chunks that the specification names.
TEST(Gltf, OtherChunksOfABinaryFileStay) {
    std::string bytes = triangle().binary();
    const std::string chunk = std::string("\4\0\0\0", 4) + "ABCDwxyz";
    bytes += chunk;
    const auto size = static_cast<std::uint32_t>(bytes.size());
    std::memcpy(bytes.data() + 8, &size, sizeof size);
    const auto model = readModel("a.glb", bytes);
    EXPECT_EQ(writtenAs(*model, "a.glb", model->positions()), bytes);
    const std::string moved = writtenAs(*model, "a.glb", movedBy(model->positions(), {1, 0, 0}));
    EXPECT_TRUE(moved.ends_with(chunk));
    EXPECT_NE(moved, bytes);
    EXPECT_EQ(readModel("b.glb", moved)->positions()[0], (Point3{1, 0, 0}));
}

TEST(Gltf, ANewFileOfPointsAloneHasPoints) {
    const auto model = readModel("a.obj", "v 0 0 0\nv 1 2 3\n");
    const std::string bytes = writtenAs(*model, "a.glb", model->positions());
    EXPECT_EQ(ParsedGltf(bytes).root["meshes"][0]["primitives"][0]["mode"], 0);
    EXPECT_EQ(copyOf(readModel("a.glb", bytes)->positions()), copyOf(model->positions()));
}

TEST(Gltf, CornersOfAnObjWithoutTextureCoordinatesGetZero) {
    const ModelSurface surface =
        readModel("a.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nvt 1 0.5\nf 1/1 2/7 3\nf 3/1 2/1 1/1\n")
            ->readSurface();
    EXPECT_EQ(surface.textures, (std::vector<std::array<double, 2>>{{1, 0.5}, {0, 0}}));
    EXPECT_EQ(surface.textureCorners, (std::vector<Index>{0, 1, 1, 0, 0, 0}));
    EXPECT_TRUE(surface.others.empty());
}

TEST(Gltf, ANewFileFarFromTheOriginKeepsItsPrecision) {
    // Floats are 0.5 apart at 5,432,198, but 1e-7 apart within a metre of a centre.
    const auto model = readModel(
        "a.obj",
        "v 432123.123456 5432198.25 10\nv 432124.5 5432199.111111 10.3\nv 432123.7 5432197.9 11\n"
        "f 1 2 3\n");
    const auto read = readModel("a.glb", writtenAs(*model, "a.glb", model->positions()));
    for (std::size_t i = 0; i < 3; ++i)
        for (std::size_t axis = 0; axis < 3; ++axis)
            EXPECT_NEAR(read->positions()[i][axis], model->positions()[i][axis], 2e-7);
    EXPECT_EQ(ParsedGltf(writtenAs(*readModel("b.obj", "v 0 0 0\nv 9 0 0\nv 9 9 1\nf 1 2 3\n"),
                                   "b.glb", std::vector<Point3>{{1, 0, 0}, {9, 0, 0}, {9, 9, 1}}))
                  .root["nodes"][0]
                  .contains("translation"),
              false);
}

// A box of two meshes: the first has a number of its own and colours in bytes, and a morph target;
// the second has neither, and counts as 0.
TEST(Gltf, AttributesAreNumbersOfThePoints) {
    auto sample = triangle({{"name", "left"}});
    json& first = sample.root["meshes"][0]["primitives"][0];
    first["attributes"]["_BEND"] = sample.add(std::vector<float>{0, 0.5F, 1}, "SCALAR");
    first["attributes"]["COLOR_0"] = sample.add(
        std::vector<std::uint8_t>{0, 51, 255, 255, 1, 2, 3, 4, 255, 0, 0, 0}, "VEC4", 5121);
    sample.root["accessors"].back()["normalized"] = true;
    first["targets"] = json::array({{{"POSITION", sample.add(std::vector<float>(9, 1.0F))}}});
    first["material"] = 0;
    sample.root["materials"] = {{{"name", "skin"}}};
    sample.root["meshes"][0]["name"] = "arm";
    sample.root["meshes"].push_back(
        {{"name", "hand"},
         {"primitives", {{{"attributes", {{"POSITION", sample.add(kGltfCorners)}}}}}}});
    sample.root["nodes"].push_back({{"mesh", 1}, {"name", "left"}});
    sample.root["scenes"][0]["nodes"] = {0, 1};
    const auto model = readModel("a.gltf", sample.text());
    EXPECT_EQ(
        namesOf(model->attributes()),
        (std::vector<std::string>{"COLOR_0:0", "COLOR_0:1", "COLOR_0:2", "COLOR_0:3", "_BEND"}));
    // Three points of the mesh, three of its target, three of the other mesh.
    EXPECT_EQ(numbersOf("a.gltf", *model, "_BEND"),
              (std::vector<double>{0, 0.5, 1, 0, 0.5, 1, 0, 0, 0}));
    EXPECT_EQ(numbersOf("a.gltf", *model, "COLOR_0:1"),
              (std::vector<double>{0.2, 2 / 255.0, 0, 0.2, 2 / 255.0, 0, 0, 0, 0}));
    std::map<std::string, std::vector<Index>> groups;
    for (const PointGroup& group : model->groups()) groups[group.name] = group.read();
    const std::vector<Index> firstSix = {0, 1, 2, 3, 4, 5}, all = {0, 1, 2, 3, 4, 5, 6, 7, 8};
    EXPECT_EQ(groups,
              (std::map<std::string, std::vector<Index>>{
                  {"arm", firstSix}, {"skin", firstSix}, {"left", all}, {"hand", {6, 7, 8}}}));
}

// Two primitives share an accessor of points, as exporters write one primitive for each material.
// Their colours have three and four components.
TEST(Gltf, GroupsOfASharedAccessorAreTheCornersOfTheirFaces) {
    auto sample = triangle();
    json& first = sample.root["meshes"][0]["primitives"][0];
    const auto points = sample.add(std::vector<float>{0, 0, 0, 1, 0, 0, 0, 1, 0, 1, 1, 0});
    first["attributes"] = {{"POSITION", points}};
    json second = first;
    first["indices"] = sample.add(std::vector<std::uint16_t>{0, 1, 2}, "SCALAR", 5123);
    second["indices"] = sample.add(std::vector<std::uint16_t>{2, 1, 3}, "SCALAR", 5123);
    first["attributes"]["COLOR_0"] = sample.add(std::vector<float>(12, 0.25F));
    second["attributes"]["COLOR_0"] = sample.add(std::vector<float>(16, 0.5F), "VEC4");
    first["material"] = 0;
    second["material"] = 1;
    sample.root["materials"] = {{{"name", "a"}}, {{"name", "b"}}};
    sample.root["meshes"][0]["primitives"].push_back(second);
    const auto model = readModel("a.gltf", sample.text());
    std::map<std::string, std::vector<Index>> groups;
    for (const PointGroup& group : model->groups()) groups[group.name] = group.read();
    EXPECT_EQ(groups,
              (std::map<std::string, std::vector<Index>>{{"a", {0, 1, 2}}, {"b", {1, 2, 3}}}));
    EXPECT_EQ(namesOf(model->attributes()),
              (std::vector<std::string>{"COLOR_0:0", "COLOR_0:1", "COLOR_0:2", "COLOR_0:3"}));
    EXPECT_EQ(numbersOf("a.gltf", *model, "COLOR_0:0"), std::vector<double>(4, 0.5));
    EXPECT_EQ(numbersOf("a.gltf", *model, "COLOR_0:3"), std::vector<double>(4, 1));
}

// Two of three primitives have a look of their own, of bytes and shorts.
TEST(Gltf, PrimitivesWithoutALookGetAPlainOne) {
    auto sample = triangle();
    json& first = sample.root["meshes"][0]["primitives"][0];
    const json plain = {{"attributes", {{"POSITION", sample.add(kGltfCorners)}}}};
    json second = plain;
    first["attributes"]["TEXCOORD_0"] =
        sample.add(std::vector<std::uint16_t>{0, 0, 65535, 0, 0, 65535}, "VEC2", 5123);
    sample.root["accessors"].back()["normalized"] = true;
    second["attributes"]["COLOR_0"] = sample.add(std::vector<float>(9, 0.25F));
    second["material"] = 1;
    sample.root["materials"] = {{{"name", "a"}}, json::object()};
    sample.root["meshes"][0]["primitives"].push_back(second);
    sample.root["meshes"][0]["primitives"].push_back(plain);
    const ModelSurface surface = readModel("a.gltf", sample.text())->readSurface();
    EXPECT_EQ(surface.materials, (std::vector<std::string>{"a", ""}));
    EXPECT_EQ(surface.faceMaterials, (std::vector<Index>{-1, 1, -1}));
    std::vector<std::array<double, 2>> textures;
    for (const Index pair : surface.textureCorners) textures.push_back(surface.textures[pair]);
    EXPECT_EQ(textures,
              (std::vector<std::array<double, 2>>{{0, 1}, {1, 1}, {0, 0}, {}, {}, {}, {}, {}, {}}));
    // The second and the third primitive have the same points.
    ASSERT_EQ(surface.colors.size(), 6u);
    EXPECT_EQ(surface.colors[0], (std::array<float, 4>{1, 1, 1, 1}));
    EXPECT_NEAR(surface.colors[5][2], 0.53710, 1e-5);  // sRGB of 0.25
    json& primitives = sample.root["meshes"][0]["primitives"];
    const json good = primitives;
    primitives[0]["attributes"]["TEXCOORD_0"] = sample.add(std::vector<float>(9, 0.5F));
    EXPECT_REFUSED(FileError, "expected 2 for each of 3 points",
                   readModel("a.gltf", sample.text())->readSurface());
    primitives = good;
    primitives[1]["attributes"]["COLOR_0"] = sample.add(std::vector<float>(6, 0.25F), "VEC2");
    EXPECT_REFUSED(FileError, "has no colours of 3 points",
                   readModel("a.gltf", sample.text())->readSurface());
}

TEST(Gltf, NumbersThatAreNoWeightsAreRefused) {
    for (const float wrong : {-0.5F, std::numeric_limits<float>::quiet_NaN(), 1.5F}) {
        auto sample = triangle();
        sample.root["meshes"][0]["primitives"][0]["attributes"]["_W"] =
            sample.add(std::vector<float>{1, wrong, 0}, "SCALAR");
        const auto model = readModel("a.gltf", sample.text());
        EXPECT_REFUSED(FileError, "at point 1; weights are 0 to 1",
                       weightsOf("a.gltf", *model, {"_W", {}}, false));
    }
}

// A morph target has the faces of its mesh, and so slopes of its own.
TEST(Gltf, WeightsHaveSlopesInMorphTargetsToo) {
    auto sample = triangle();
    json& primitive = sample.root["meshes"][0]["primitives"][0];
    primitive["attributes"]["_W"] = sample.add(std::vector<float>{0.25F, 1, 0.25F}, "SCALAR");
    // The target is twice as long along x.
    primitive["targets"] =
        json::array({{{"POSITION", sample.add(std::vector<float>{0, 0, 0, 1, 0, 0, 0, 0, 0})}}});
    const auto model = readModel("a.gltf", sample.text());
    const auto slopes = weightsOf("a.gltf", *model, {"_W", {}}, true).slopes;
    ASSERT_EQ(slopes.size(), 6U);
    for (std::size_t i = 0; i < 6; ++i) {
        EXPECT_NEAR(slopes[i][0], i < 3 ? 0.75 : 0.375, 1e-15) << i;
        EXPECT_NEAR(slopes[i][1], 0, 1e-15) << i;
    }
    EXPECT_EQ(model->readSurface().faces.count(), 1U);
}

}  // namespace
}  // namespace espalier::io
