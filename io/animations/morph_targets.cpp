// SPDX-License-Identifier: Apache-2.0
#include <espalier/base/error.h>
#include <espalier/base/progress.h>
#include <espalier/io/files/file.h>
#include <espalier/io/files/text_reader.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <ostream>
#include <string>

#include "../files/bytes.h"
#include "../models/triangulation.h"
#include "morph_targets.h"

namespace espalier::io {
namespace {

// Constants of the specification of glTF 2.0.
constexpr int kFloat = 5126, kUnsignedInt = 5125, kArrayBuffer = 34962, kElementArrayBuffer = 34963;

/// Splits faces into triangles at rest. Faces of two corners or one are left out.
std::vector<std::uint32_t> trianglesOf(const ModelFaces& faces, std::span<const Point3> rest) {
    std::vector<std::uint32_t> corners;
    std::vector<Point3> polygon;
    for (std::size_t face = 0; face < faces.count(); ++face) {
        checkCancelledEvery(face, 10);
        const auto loop = faces[face];
        polygon.clear();
        for (const Index point : loop) polygon.push_back(rest[point]);
        for (const auto& triangle : triangulated(polygon))
            for (const std::size_t corner : triangle)
                corners.push_back(static_cast<std::uint32_t>(loop[corner]));
    }
    return corners;
}

/// Writes the smallest and the largest number along each axis: ,"min":[x,y,z],"max":[x,y,z].
std::string boundsOf(std::span<const float> points) {
    std::array<float, 3> low, high;
    low.fill(std::numeric_limits<float>::max());
    high.fill(std::numeric_limits<float>::lowest());
    for (std::size_t i = 0; i < points.size(); ++i) {
        low[i % 3] = std::min(low[i % 3], points[i]);
        high[i % 3] = std::max(high[i % 3], points[i]);
    }
    const auto list = [](const std::array<float, 3>& values) {
        return "[" + formatNumber(values[0]) + "," + formatNumber(values[1]) + "," +
               formatNumber(values[2]) + "]";
    };
    return ",\"min\":" + list(low) + ",\"max\":" + list(high);
}

/// \throws FileError if a file of this size is too large
void checkSize(const std::filesystem::path& path, std::size_t frameCount, double bytes) {
    if (bytes > std::numeric_limits<std::uint32_t>::max())
        throw FileError(path, concat("cannot be written: a .glb file of ", frameCount,
                                     " poses would have ", formatNumber(bytes),
                                     " bytes or more, and at most 4294967295 are possible"));
}

/// Collects the accessors of a file, each over a view of its own, and their data.
class GltfBuffer {
public:
    /// Adds numbers and returns the number of their accessor.
    /// \param type "SCALAR" or "VEC3"
    /// \param target of the view; 0 for none
    template <class Number>
    std::size_t add(std::span<const Number> numbers, const char* type, int target,
                    const std::string& bounds = {}) {
        constexpr bool kIsFloat = std::is_same_v<Number, float>;
        const std::size_t perElement = std::string_view(type) == "VEC3" ? 3 : 1;
        views_ += concat(views_.empty() ? "" : ",", "{\"buffer\":0,\"byteOffset\":", data_.size(),
                         ",\"byteLength\":", numbers.size_bytes(),
                         target != 0 ? concat(",\"target\":", target) : std::string(), "}");
        accessors_ += concat(count_ > 0 ? "," : "", "{\"bufferView\":", count_,
                             ",\"componentType\":", kIsFloat ? kFloat : kUnsignedInt,
                             ",\"count\":", numbers.size() / perElement, ",\"type\":\"", type, "\"",
                             bounds, "}");
        const std::size_t begin = data_.size();
        data_.resize(begin + numbers.size_bytes());
        for (std::size_t i = 0; i < numbers.size(); ++i)
            storeNumber(data_.data() + begin + i * sizeof(Number), numbers[i], std::endian::little);
        return count_++;
    }

    const std::string& views() const { return views_; }
    const std::string& accessors() const { return accessors_; }
    const std::string& data() const { return data_; }

private:
    std::string views_, accessors_;
    std::string data_;
    std::size_t count_ = 0;
};

}  // namespace

void writeMorphTargets(const std::filesystem::path& path, const Model& model,
                       const Animation& animation) {
    const std::vector<std::uint32_t> corners =
        trianglesOf(model.readSurface().faces, model.positions());
    if (corners.empty())
        throw FileError(path, "cannot be written: the model has no faces, and glTF holds faces");
    const std::size_t pointCount = model.positions().size();
    const std::size_t frameCount = animation.frameCount;
    // Refuse what cannot be written before the frames are computed. The texts come on top.
    checkSize(path, frameCount,
              4.0 * static_cast<double>(corners.size()) +
                  12.0 * static_cast<double>(pointCount) * (static_cast<double>(frameCount) + 1) +
                  4.0 * static_cast<double>(frameCount) * (static_cast<double>(frameCount) + 1));
    const std::vector<float> times = timesOf(animation);
    GltfBuffer buffer;
    const std::vector<float> rest = floatsOf(model.positions(), pointCount, 0);
    const std::size_t indices =
        buffer.add(std::span<const std::uint32_t>(corners), "SCALAR", kElementArrayBuffer);
    const std::size_t points =
        buffer.add(std::span<const float>(rest), "VEC3", kArrayBuffer, boundsOf(rest));
    std::string targets;
    for (std::size_t frame = 0; frame < frameCount; ++frame) {
        std::vector<float> moves = floatsOf(animation.frame(frame), pointCount, frame);
        for (std::size_t i = 0; i < moves.size(); ++i) {
            checkCancelledEvery(i, 16);
            moves[i] -= rest[i];
            if (!std::isfinite(moves[i]))
                throw Error(concat("in frame ", frame, ", point ", i / 3, " moves from ",
                                   formatNumber(rest[i]), " by more than a float can hold"));
        }
        targets += concat(
            frame > 0 ? "," : "", "{\"POSITION\":",
            buffer.add(std::span<const float>(moves), "VEC3", kArrayBuffer, boundsOf(moves)), "}");
    }
    // Frame i has weight 1 for target i, and 0 for all others.
    std::vector<float> weights(frameCount * frameCount, 0.0F);
    for (std::size_t frame = 0; frame < frameCount; ++frame)
        weights[frame * frameCount + frame] = 1;
    const std::size_t timesAt = buffer.add(std::span<const float>(times), "SCALAR", 0,
                                           concat(",\"min\":[", formatNumber(times.front()),
                                                  "],\"max\":[", formatNumber(times.back()), "]"));
    const std::size_t weightsAt = buffer.add(std::span<const float>(weights), "SCALAR", 0);

    std::string zeros, names;
    for (std::size_t frame = 0; frame < frameCount; ++frame) {
        zeros += frame > 0 ? ",0" : "0";
        names += concat(frame > 0 ? "," : "", "\"pose ", frame, "\"");
    }
    std::string json = concat(
        "{\"asset\":{\"version\":\"2.0\",\"generator\":\"Espalier\"},\"scene\":0,"
        "\"scenes\":[{\"nodes\":[0]}],\"nodes\":[{\"mesh\":0,\"name\":\"model\"}],"
        "\"meshes\":[{\"primitives\":[{\"attributes\":{\"POSITION\":",
        points, "},\"indices\":", indices, ",\"targets\":[", targets, "]}],\"weights\":[", zeros,
        "],\"extras\":{\"targetNames\":[", names,
        "]}}],\"animations\":[{\"name\":\"poses\",\"samplers\":[{\"input\":", timesAt,
        ",\"output\":", weightsAt,
        ",\"interpolation\":\"LINEAR\"}],\"channels\":[{\"sampler\":0,\"target\":{\"node\":0,"
        "\"path\":\"weights\"}}]}],\"buffers\":[{\"byteLength\":",
        buffer.data().size(), "}],\"bufferViews\":[", buffer.views(), "],\"accessors\":[",
        buffer.accessors(), "]}");
    json.append((4 - json.size() % 4) % 4, ' ');
    const std::size_t size = 12 + 8 + json.size() + 8 + buffer.data().size();
    checkSize(path, frameCount, static_cast<double>(size));
    constexpr std::uint32_t kMagic = 0x46546C67, kVersion = 2, kJson = 0x4E4F534A,
                            kBinary = 0x004E4942;
    writeFile(path, [&](std::ostream& out) {
        ByteOutput bytes(out, std::endian::little);
        bytes.number(kMagic, kVersion, static_cast<std::uint32_t>(size));
        bytes.number(static_cast<std::uint32_t>(json.size()), kJson);
        bytes.bytes(json);
        bytes.number(static_cast<std::uint32_t>(buffer.data().size()), kBinary);
        bytes.bytes(buffer.data());
    });
}

}  // namespace espalier::io
