// SPDX-License-Identifier: Apache-2.0
#include "gltf_writer.h"

#include <espalier/base/error.h>
#include <espalier/base/progress.h>
#include <espalier/io/directions.h>
#include <espalier/io/files/base64.h>
#include <espalier/io/files/file.h>
#include <espalier/io/files/text_reader.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <ostream>
#include <string>
#include <utility>
#include <vector>

#include "../animations/frames.h"
#include "../files/bytes.h"
#include "../models/coordinates.h"
#include "../models/model_conversion.h"
#include "gltf_file.h"

namespace espalier::io {
namespace {

// Numbers of the specification.
constexpr int kFloat = 5126, kUnsignedInt = 5125, kArrayBuffer = 34962, kElementArrayBuffer = 34963,
              kPointsMode = 0;
constexpr Index kNone = -1;

/// A new file: its JSON, and the bytes of its buffer.
class GltfBuilder {
public:
    /// Adds numbers and returns the number of their accessor.
    /// \param components numbers of an element
    /// \param target of the view; 0 for none
    template <class Number>
    std::size_t add(std::span<const Number> numbers, std::size_t components, int target,
                    bool hasBounds = false) {
        constexpr const char* kTypes[] = {"", "SCALAR", "VEC2", "VEC3", "VEC4"};
        Json view = {
            {"buffer", 0}, {"byteOffset", data_.size()}, {"byteLength", numbers.size_bytes()}};
        if (target != 0) view["target"] = target;
        Json accessor = {{"bufferView", views_.size()},
                         {"componentType", std::is_same_v<Number, float> ? kFloat : kUnsignedInt},
                         {"count", numbers.size() / components},
                         {"type", kTypes[components]}};
        if (hasBounds) {
            std::vector<Number> low(numbers.begin(), numbers.begin() + std::ptrdiff_t(components));
            std::vector<Number> high = low;
            for (std::size_t i = 0; i < numbers.size(); ++i) {
                low[i % components] = std::min(low[i % components], numbers[i]);
                high[i % components] = std::max(high[i % components], numbers[i]);
            }
            accessor["min"] = low;
            accessor["max"] = high;
        }
        views_.push_back(std::move(view));
        accessors_.push_back(std::move(accessor));
        const std::size_t begin = data_.size();
        data_.resize(begin + numbers.size_bytes());
        for (std::size_t i = 0; i < numbers.size(); ++i)
            storeNumber(data_.data() + begin + i * sizeof(Number), numbers[i], std::endian::little);
        return accessors_.size() - 1;
    }

    std::size_t addVectors(const std::vector<float>& numbers, bool hasBounds = false) {
        return add(std::span<const float>(numbers), 3, kArrayBuffer, hasBounds);
    }

    /// Writes the file as .glb, or as text with its data if the path ends in .gltf.
    /// \param json all but buffers, views and accessors
    void write(std::ostream& out, const std::filesystem::path& path, Json json) const {
        json["buffers"] = Json::array({Json{{"byteLength", data_.size()}}});
        json["bufferViews"] = views_;
        json["accessors"] = accessors_;
        if (lowerCase(path.extension().string()) != ".gltf") {
            out << binaryGltf(path, textOf(json), data_);
            return;
        }
        json["buffers"][0]["uri"] = "data:application/octet-stream;base64," + encodeBase64(data_);
        out << textOf(json, 2) << '\n';
    }

private:
    Json views_ = Json::array(), accessors_ = Json::array();
    std::string data_;
};

/// A vertex of glTF: a point with one normal and one pair of texture coordinates.
struct Vertex {
    Index point = kNone, normal = kNone, texture = kNone;

    bool operator==(const Vertex&) const = default;
};

/// The vertices and triangles of a surface.
struct Vertices {
    std::vector<Vertex> vertices;
    std::vector<std::uint32_t> corners;  ///< of all triangles
};

/// Makes a vertex of each different corner of a point, in the order of the points.
Vertices verticesOf(const SurfaceView& surface) {
    Vertices result;
    const ModelFaces& faces = surface.faces;
    if (faces.count() == 0) {
        for (std::size_t point = 0; point < surface.points.size(); ++point)
            result.vertices.push_back({static_cast<Index>(point)});
        return result;
    }
    const bool hasTextures = surface.appearance && !surface.appearance->textureCorners.empty();
    // The vertices of a point are a list: the first, and for each vertex the next.
    std::vector<Index> first(surface.points.size(), kNone), next, vertexOfCorner;
    std::vector<Vertex> found;
    for (std::size_t corner = 0; corner < faces.corners.size(); ++corner) {
        checkCancelledEvery(corner, 14);
        const Index point = faces.corners[corner];
        const Vertex vertex = {
            point, surface.normalCorners.empty() ? kNone : surface.normalCorners[corner],
            hasTextures ? surface.appearance->textureCorners[corner] : kNone};
        Index at = first[point];
        while (at != kNone && found[at] != vertex) at = next[at];
        if (at == kNone) {
            at = static_cast<Index>(found.size());
            found.push_back(vertex);
            next.push_back(std::exchange(first[point], at));
        }
        vertexOfCorner.push_back(at);
    }
    std::vector<std::uint32_t> numbers(found.size());
    for (const Index head : first)
        for (Index at = head; at != kNone; at = next[at]) {
            numbers[at] = static_cast<std::uint32_t>(result.vertices.size());
            result.vertices.push_back(found[at]);
        }
    for (const Index vertex : vertexOfCorner) result.corners.push_back(numbers[vertex]);
    return result;
}

/// Returns the points of all vertices relative to the centre, as floats.
std::vector<float> floatsAt(const std::vector<Vertex>& vertices, std::span<const Point3> points,
                            const Point3& centre) {
    std::vector<float> floats;
    floats.reserve(3 * vertices.size());
    for (std::size_t i = 0; i < vertices.size(); ++i) {
        checkCancelledEvery(i, 16);
        const Index point = vertices[i].point;
        for (std::size_t axis = 0; axis < 3; ++axis)
            floats.push_back(static_cast<float>(
                roundTo(Precision::Float, points[point][axis] - centre[axis], point)));
    }
    return floats;
}

/// Returns a vector of length 1 in this direction; (0, 0, 1) if there is none, since glTF has only
/// normals of length 1.
Point3 unit(Point3 vector) {
    const double size = length(vector);
    if (!(size > 0) || !std::isfinite(size)) return {0, 0, 1};
    for (double& number : vector) number /= size;
    return vector;
}

/// Returns the normals of all vertices, carried by the gradients of their points if there are any.
std::vector<float> normalsAt(const std::vector<Vertex>& vertices, std::span<const Point3> normals,
                             std::span<const DeformationGradient> gradients = {}) {
    std::vector<float> floats;
    floats.reserve(3 * vertices.size());
    for (std::size_t i = 0; i < vertices.size(); ++i) {
        checkCancelledEvery(i, 14);
        Point3 normal = unit(normals[vertices[i].normal]);
        if (!gradients.empty()) normal = unit(carryNormal(gradients[vertices[i].point], normal));
        for (const double number : normal) floats.push_back(static_cast<float>(number));
    }
    return floats;
}

/// Returns a number as a float; 0 if it is not finite, which glTF forbids.
float finite(double number) {
    const auto value = static_cast<float>(number);
    return std::isfinite(value) ? value : 0.0f;
}

/// Returns the intensity of light that an sRGB value from 0 to 1 stands for (IEC 61966-2-1).
float linearOf(float value) {
    const double v = value;
    return static_cast<float>(v <= 0.04045 ? v / 12.92 : std::pow((v + 0.055) / 1.055, 2.4));
}

/// Adds the surface at rest. Returns its primitives.
Json addPrimitives(GltfBuilder& builder, const SurfaceView& surface, const Vertices& made,
                   const std::vector<float>& positions, Json& materials) {
    const ModelSurface* appearance = surface.appearance;
    const std::vector<Vertex>& vertices = made.vertices;

    // The triangles of each material follow each other.
    std::vector<std::vector<std::uint32_t>> corners(1);
    if (appearance && !appearance->faceMaterials.empty()) {
        corners.resize(1 + appearance->materials.size());
        for (std::size_t face = 0; face < appearance->faceMaterials.size(); ++face)
            for (std::size_t i = 0; i < 3; ++i)
                corners[static_cast<std::size_t>(appearance->faceMaterials[face] + 1)].push_back(
                    made.corners[3 * face + i]);
        for (const std::string& name : appearance->materials)
            materials.push_back(Json{{"name", name}});
    } else {
        corners[0] = made.corners;
    }
    Json primitives = Json::array();
    for (std::size_t material = 0; material < corners.size(); ++material) {
        if (corners[material].empty()) continue;
        Json& primitive = primitives.emplace_back(Json{{"attributes", Json::object()}});
        primitive["indices"] =
            builder.add(std::span<const std::uint32_t>(corners[material]), 1, kElementArrayBuffer);
        if (material > 0) primitive["material"] = material - 1;
    }
    if (primitives.empty())
        primitives.push_back({{"attributes", Json::object()}, {"mode", kPointsMode}});

    Json attributes = {{"POSITION", builder.addVectors(positions, true)}};
    if (!surface.normalCorners.empty())
        attributes["NORMAL"] = builder.addVectors(normalsAt(vertices, surface.normals));
    if (appearance && !appearance->textureCorners.empty()) {
        std::vector<float> textures;
        for (const Vertex& vertex : vertices) {
            const auto& [u, v] = appearance->textures[vertex.texture];
            textures.push_back(finite(u));
            textures.push_back(finite(1 - v));  // glTF counts v downwards
        }
        attributes["TEXCOORD_0"] = builder.add(std::span<const float>(textures), 2, kArrayBuffer);
    }
    if (appearance && !appearance->colors.empty()) {
        std::vector<float> colors;
        for (const Vertex& vertex : vertices) {
            const auto& [red, green, blue, opacity] = appearance->colors[vertex.point];
            colors.insert(colors.end(), {linearOf(red), linearOf(green), linearOf(blue), opacity});
        }
        attributes["COLOR_0"] = builder.add(std::span<const float>(colors), 4, kArrayBuffer);
    }
    for (Json& primitive : primitives) primitive["attributes"] = attributes;
    return primitives;
}

/// Returns the JSON of a file of one node with one mesh.
Json sceneOf(Json primitives, const Point3& centre, Json materials) {
    Json node = {{"mesh", 0}, {"name", "model"}};
    if (centre != Point3{}) node["translation"] = centre;
    Json json = {{"asset", {{"version", "2.0"}, {"generator", "Espalier"}}},
                 {"scene", 0},
                 {"scenes", Json::array({Json{{"nodes", {0}}}})},
                 {"nodes", Json::array({node})},
                 {"meshes", Json::array({Json{{"primitives", std::move(primitives)}}})}};
    if (!materials.empty()) json["materials"] = std::move(materials);
    return json;
}

/// \throws FileError if a file of this size is too large
void checkSize(const std::filesystem::path& path, std::size_t frameCount, double bytes) {
    if (bytes > std::numeric_limits<std::uint32_t>::max())
        throw FileError(path, concat("cannot be written: a glTF file of ", frameCount,
                                     " poses would have ", formatNumber(bytes),
                                     " bytes or more, and at most 4294967295 are possible"));
}

}  // namespace

Point3 gltfCentre(std::span<const Point3> points) {
    Point3 low = points.empty() ? Point3{} : points[0], high = low;
    double largest = 0, size = 0;
    for (const Point3& point : points)
        for (std::size_t axis = 0; axis < 3; ++axis) {
            low[axis] = std::min(low[axis], point[axis]);
            high[axis] = std::max(high[axis], point[axis]);
        }
    Point3 centre;
    for (std::size_t axis = 0; axis < 3; ++axis) {
        largest = std::max({largest, std::abs(low[axis]), std::abs(high[axis])});
        size = std::max(size, high[axis] - low[axis]);
        // Programs hold it as a float, too.
        centre[axis] = static_cast<float>(low[axis] + (high[axis] - low[axis]) / 2);
    }
    const bool isFar = largest > 4 * size && std::isfinite(static_cast<float>(largest));
    return isFar ? centre : Point3{};
}

void writeGltfSurface(std::ostream& out, const SurfaceView& surface) {
    const Vertices made = verticesOf(surface);
    const Point3 centre = gltfCentre(surface.points);
    GltfBuilder builder;
    Json materials = Json::array();
    Json primitives = addPrimitives(builder, surface, made,
                                    floatsAt(made.vertices, surface.points, centre), materials);
    builder.write(out, surface.path, sceneOf(std::move(primitives), centre, std::move(materials)));
}

void writeMorphTargets(const std::filesystem::path& path, const Model& model,
                       const Animation& animation) {
    const ModelConversion conversion(model, kGltfFormat, path);
    const std::vector<Point3> restPoints = conversion.pointsOf(model.positions());
    const SurfaceView surface = conversion.restSurface(path, restPoints);
    const Vertices made = verticesOf(surface);
    const std::size_t frameCount = animation.frameCount;
    const bool hasNormals = animation.gradients && !surface.normalCorners.empty();
    // Refuse what cannot be written before the frames are computed. The texts come on top.
    checkSize(path, frameCount,
              4.0 * static_cast<double>(made.corners.size()) +
                  (hasNormals ? 24.0 : 12.0) * static_cast<double>(made.vertices.size()) *
                      (static_cast<double>(frameCount) + 1) +
                  4.0 * static_cast<double>(frameCount) * (static_cast<double>(frameCount) + 1));
    const std::vector<float> times = timesOf(animation);
    const Point3 centre = gltfCentre(restPoints);
    const std::vector<float> rest = floatsAt(made.vertices, restPoints, centre);
    GltfBuilder builder;
    Json materials = Json::array();
    Json primitives = addPrimitives(builder, surface, made, rest, materials);
    std::vector<float> restNormals;
    if (hasNormals) restNormals = normalsAt(made.vertices, surface.normals);

    Json targets = Json::array(), names = Json::array();
    const auto pointOf = [&](std::size_t number) { return made.vertices[number / 3].point; };
    for (std::size_t frame = 0; frame < frameCount; ++frame) {
        const std::vector<Point3> points = animation.frame(frame);
        checkFrame(points, model.positions().size(), frame);
        std::vector<float> moves = floatsAt(made.vertices, conversion.pointsOf(points), centre);
        for (std::size_t i = 0; i < moves.size(); ++i) {
            checkCancelledEvery(i, 16);
            moves[i] -= rest[i];
            if (!std::isfinite(moves[i]))
                throw Error(concat("in frame ", frame, ", point ", pointOf(i), " moves from ",
                                   formatNumber(rest[i]), " by more than a float can hold"));
        }
        Json target = {{"POSITION", builder.addVectors(moves, true)}};
        if (hasNormals) {
            const std::vector<DeformationGradient> gradients = animation.gradients(frame);
            std::vector<float> turns = normalsAt(made.vertices, surface.normals,
                                                 conversion.valuesOf(std::span(gradients)));
            for (std::size_t i = 0; i < turns.size(); ++i) turns[i] -= restNormals[i];
            target["NORMAL"] = builder.addVectors(turns);
        }
        targets.push_back(std::move(target));
        names.push_back(concat("pose ", frame));
    }
    // Frame i has weight 1 for target i, and 0 for all others.
    std::vector<float> weights(frameCount * frameCount, 0.0F);
    for (std::size_t frame = 0; frame < frameCount; ++frame)
        weights[frame * frameCount + frame] = 1;
    const std::size_t timesAt = builder.add(std::span<const float>(times), 1, 0, true);
    const std::size_t weightsAt = builder.add(std::span<const float>(weights), 1, 0);

    for (Json& primitive : primitives) primitive["targets"] = targets;
    Json json = sceneOf(std::move(primitives), centre, std::move(materials));
    json["meshes"][0]["weights"] = std::vector<int>(frameCount, 0);
    json["meshes"][0]["extras"] = {{"targetNames", names}};
    json["animations"] = Json::array({Json{
        {"name", "poses"},
        {"samplers", Json::array({Json{
                         {"input", timesAt}, {"output", weightsAt}, {"interpolation", "LINEAR"}}})},
        {"channels",
         Json::array({Json{{"sampler", 0}, {"target", {{"node", 0}, {"path", "weights"}}}}})}}});
    writeFile(path, [&](std::ostream& out) { builder.write(out, path, std::move(json)); });
}

}  // namespace espalier::io
