// SPDX-License-Identifier: Apache-2.0
#include <espalier/base/error.h>
#include <espalier/base/progress.h>
#include <espalier/io/animations/animation_file.h>
#include <espalier/io/files/file.h>
#include <espalier/io/files/text_reader.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <ostream>
#include <string>
#include <string_view>

#include "../files/bytes.h"
#include "morph_targets.h"

namespace espalier::io {
namespace {

enum class AnimationFormat { Pc2, Mdd, Glb };

AnimationFormat animationFormatOf(const std::filesystem::path& path) {
    const std::string extension = lowerCase(path.extension().string());
    if (extension == ".pc2") return AnimationFormat::Pc2;
    if (extension == ".mdd") return AnimationFormat::Mdd;
    if (extension == ".glb") return AnimationFormat::Glb;
    throw FileError(path, "is not of a known format of animations; expected .pc2, .mdd or .glb");
}

/// Writes the header of a point cache. Returns the byte order of the format.
std::endian writeHeader(std::ostream& out, AnimationFormat format, std::int32_t pointCount,
                        const Animation& animation) {
    const auto frameCount = static_cast<std::int32_t>(animation.frameCount);
    if (format == AnimationFormat::Pc2) {
        using namespace std::string_view_literals;
        ByteOutput bytes(out, std::endian::little);
        bytes.bytes("POINTCACHE2\0"sv);
        // Version, points, first frame, frames per sample, samples.
        bytes.number(std::int32_t{1}, pointCount, 0.0F, 1.0F, frameCount);
        return std::endian::little;
    }
    ByteOutput bytes(out, std::endian::big);
    bytes.number(frameCount, pointCount);
    bytes.numbers(std::span<const float>(timesOf(animation)));
    return std::endian::big;
}

}  // namespace

std::vector<float> floatsOf(std::span<const Point3> points, std::size_t expected,
                            std::size_t frame) {
    if (points.size() != expected)
        throw Error(
            concat("frame ", frame, " has ", points.size(), " points; the model has ", expected));
    std::vector<float> floats;
    floats.reserve(3 * points.size());
    for (std::size_t point = 0; point < points.size(); ++point) {
        checkCancelledEvery(point, 16);
        for (const double coordinate : points[point]) {
            if (!fitsFloat(coordinate))
                throw Error(concat("in frame ", frame, ", point ", point, " has the coordinate ",
                                   formatNumber(coordinate), ", which a float cannot hold"));
            floats.push_back(static_cast<float>(coordinate));
        }
    }
    return floats;
}

bool fitsFloat(double number) {
    // Numbers just above the largest float are rounded to it.
    return std::isfinite(static_cast<float>(number));
}

std::vector<float> timesOf(const Animation& animation) {
    std::vector<float> times;
    for (std::size_t frame = 0; frame < animation.frameCount; ++frame) {
        const double time = static_cast<double>(frame) / animation.framesPerSecond;
        if (!fitsFloat(time) || (frame > 0 && static_cast<float>(time) <= times.back()))
            throw Error(concat("with ", formatNumber(animation.framesPerSecond),
                               " frames per second, frame ", frame, " is at ", formatNumber(time),
                               " seconds, which a float cannot hold, or cannot tell from the "
                               "frame before"));
        times.push_back(static_cast<float>(time));
    }
    return times;
}

std::vector<Point3> storedInAnimation(const std::filesystem::path& path, const Model& model,
                                      std::vector<Point3> points) {
    const bool isGlb = animationFormatOf(path) == AnimationFormat::Glb;
    for (std::size_t point = 0; point < points.size(); ++point)
        for (std::size_t axis = 0; axis < 3; ++axis) {
            double& coordinate = points[point][axis];
            const auto now = static_cast<float>(coordinate);
            const auto rest = static_cast<float>(model.positions()[point][axis]);
            coordinate = isGlb ? rest + (now - rest) : now;
        }
    return points;
}

bool isAnimationFile(const std::filesystem::path& path) {
    const std::string extension = lowerCase(path.extension().string());
    return extension == ".pc2" || extension == ".mdd" || extension == ".glb";
}

void writeAnimation(const std::filesystem::path& path, const Model& model,
                    const Animation& animation) {
    const AnimationFormat format = animationFormatOf(path);
    constexpr std::size_t kMaxCount = std::numeric_limits<std::int32_t>::max();
    const std::size_t pointCount = model.positions().size();
    if (animation.frameCount == 0 || animation.frameCount > kMaxCount || pointCount > kMaxCount)
        throw Error(concat("an animation of ", animation.frameCount, " frames of ", pointCount,
                           " points cannot be written; expected 1 to ", kMaxCount));
    if (!(animation.framesPerSecond > 0 && std::isfinite(animation.framesPerSecond)))
        throw Error("the number of frames per second is not a number above 0");
    if (format == AnimationFormat::Glb) return writeMorphTargets(path, model, animation);
    writeFile(path, [&](std::ostream& out) {
        const std::endian order =
            writeHeader(out, format, static_cast<std::int32_t>(pointCount), animation);
        ByteOutput bytes(out, order);
        for (std::size_t frame = 0; frame < animation.frameCount; ++frame)
            bytes.numbers(
                std::span<const float>(floatsOf(animation.frame(frame), pointCount, frame)));
    });
}

}  // namespace espalier::io
