// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <espalier/io/model.h>

#include <cmath>
#include <vector>

#include "fuzz_target.h"
#include "written.h"

namespace espalier::fuzz {

/// That a model is refused, or is written as it was read where no point moves, and with all its
/// points where they have moved.
/// \param name gives the format
inline void runModelTarget(const std::string& name, std::string_view bytes) {
    const auto read = readResult(name, [&] { return io::readModel(name, std::string(bytes)); });
    if (!read) return;
    const io::Model& model = **read;
    for (const Point3& point : model.positions())
        for (const double coordinate : point)
            require(std::isfinite(coordinate), "points are finite");
    const auto writtenWith = [&](const io::Model& of, std::span<const Point3> points) {
        return written(name, [&](const auto& path) { of.write(path, points); });
    };
    require(writtenWith(model, model.positions()) == bytes,
            "a model that has not moved is written byte for byte");

    // Half of it, so that no point leaves the range of its numbers.
    std::vector<Point3> moved(model.positions().begin(), model.positions().end());
    for (Point3& point : moved)
        for (double& coordinate : point) coordinate = coordinate / 2 + 1;
    const std::string once = writtenWith(model, moved);
    const auto back = io::readModel(name, once);
    require(back->positions().size() == moved.size(), "a moved model has all its points");
    for (std::size_t i = 0; i < moved.size(); ++i)
        for (std::size_t axis = 0; axis < 3; ++axis) {
            const double wanted = moved[i][axis];
            const double got = back->positions()[i][axis];
            require(got == wanted || got == double{static_cast<float>(wanted)},
                    "a moved point is where it was put");
        }
}

}  // namespace espalier::fuzz
