// SPDX-License-Identifier: Apache-2.0
#include <espalier/base/error.h>
#include <espalier/base/progress.h>
#include <espalier/io/animations/animation_file.h>
#include <espalier/io/files/file.h>
#include <espalier/io/files/text_reader.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <functional>
#include <limits>
#include <ostream>
#include <string>
#include <string_view>

#include "../files/bytes.h"
#include "../format.h"
#include "../gltf/gltf_writer.h"
#include "../models/model_conversion.h"
#include "frames.h"

namespace espalier::io {
namespace {

/// Returns true if a number rounded to a float is finite.
bool fitsFloat(double number) {
    // Numbers just above the largest float are rounded to it.
    return std::isfinite(static_cast<float>(number));
}

/// Rounds the points of a frame to floats.
std::vector<float> floatsOf(std::span<const Point3> points, std::size_t expected,
                            std::size_t frame) {
    checkFrame(points, expected, frame);
    std::vector<float> floats;
    floats.reserve(3 * points.size());
    for (const Point3& point : points)
        for (const double coordinate : point) floats.push_back(static_cast<float>(coordinate));
    return floats;
}

const Format& formatOf(const std::filesystem::path& path) {
    if (const Format* format = findFormat(path, FileContent::Animation, FileUse::Write))
        return *format;
    throw FileError(path, "is not of a known format of animations; expected " +
                              listOfFormats(FileContent::Animation, FileUse::Write));
}

/// Writes a point cache: a header, and the points of all frames.
void writeCache(const std::filesystem::path& path, const Model& model, const Animation& animation,
                std::endian order, const std::function<void(ByteOutput&)>& writeHeader) {
    writeFile(path, [&](std::ostream& out) {
        ByteOutput bytes(out, order);
        writeHeader(bytes);
        for (std::size_t frame = 0; frame < animation.frameCount; ++frame)
            bytes.numbers(std::span<const float>(
                floatsOf(animation.frame(frame), model.positions().size(), frame)));
    });
}

void writePointCache(const std::filesystem::path& path, const Model& model,
                     const Animation& animation) {
    writeCache(path, model, animation, std::endian::little, [&](ByteOutput& bytes) {
        using namespace std::string_view_literals;
        bytes.bytes("POINTCACHE2\0"sv);
        // Version, points, first frame, frames per sample, samples.
        bytes.number(std::int32_t{1}, static_cast<std::int32_t>(model.positions().size()), 0.0F,
                     1.0F, static_cast<std::int32_t>(animation.frameCount));
    });
}

void writeMotionDesigner(const std::filesystem::path& path, const Model& model,
                         const Animation& animation) {
    writeCache(path, model, animation, std::endian::big, [&](ByteOutput& bytes) {
        bytes.number(static_cast<std::int32_t>(animation.frameCount),
                     static_cast<std::int32_t>(model.positions().size()));
        bytes.numbers(std::span<const float>(timesOf(animation)));
    });
}

}  // namespace

void checkFrame(std::span<const Point3> points, std::size_t expected, std::size_t frame) {
    if (points.size() != expected)
        throw Error(
            concat("frame ", frame, " has ", points.size(), " points; the model has ", expected));
    for (std::size_t point = 0; point < points.size(); ++point) {
        checkCancelledEvery(point, 16);
        for (const double coordinate : points[point])
            if (!fitsFloat(coordinate))
                throw Error(concat("in frame ", frame, ", point ", point, " has the coordinate ",
                                   formatNumber(coordinate), ", which a float cannot hold"));
    }
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

bool isAnimation(const std::filesystem::path& path, std::size_t poseCount) {
    const Format* format = findFormat(path, FileContent::Animation, FileUse::Write);
    if (!format) return false;
    return !format->readModel ||
           (poseCount > 1 && path.filename().string().find('%') == std::string::npos);
}

std::vector<Point3> storedInAnimation(const std::filesystem::path& path, const Model& model,
                                      std::vector<Point3> points) {
    const bool isMovement = animationHoldsNormals(path);
    const Point3 centre = isMovement ? gltfCentre(model.positions()) : Point3{};
    for (std::size_t point = 0; point < points.size(); ++point)
        for (std::size_t axis = 0; axis < 3; ++axis) {
            double& coordinate = points[point][axis];
            const auto now = static_cast<float>(coordinate - centre[axis]);
            const auto rest = static_cast<float>(model.positions()[point][axis] - centre[axis]);
            coordinate = isMovement ? centre[axis] + double{rest + (now - rest)} : now;
        }
    return points;
}

const Format kPointCacheFormat = {.extensions = {".pc2"}, .writeAnimation = writePointCache};
const Format kMotionDesignerFormat = {.extensions = {".mdd"},
                                      .writeAnimation = writeMotionDesigner};

bool animationHoldsNormals(const std::filesystem::path& path) {
    return &formatOf(path) == &kGltfFormat;
}

std::string lossesInAnimation(const std::filesystem::path& path, const Model& model) {
    if (!animationHoldsNormals(path)) return {};
    return ModelConversion(model, kGltfFormat, path).losses(path);
}

void writeAnimation(const std::filesystem::path& path, const Model& model,
                    const Animation& animation) {
    const Format& format = formatOf(path);
    constexpr std::size_t kMaxCount = std::numeric_limits<std::int32_t>::max();
    const std::size_t pointCount = model.positions().size();
    if (animation.frameCount == 0 || animation.frameCount > kMaxCount || pointCount > kMaxCount)
        throw Error(concat("an animation of ", animation.frameCount, " frames of ", pointCount,
                           " points cannot be written; expected 1 to ", kMaxCount));
    if (!(animation.framesPerSecond > 0 && std::isfinite(animation.framesPerSecond)))
        throw Error("the number of frames per second is not a number above 0");
    format.writeAnimation(path, model, animation);
}

}  // namespace espalier::io
