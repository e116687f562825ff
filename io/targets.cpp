// SPDX-License-Identifier: Apache-2.0
#include <espalier/io/files/file.h>
#include <espalier/io/files/text_reader.h>
#include <espalier/io/targets.h>

#include <cmath>
#include <string>

#include "files/other_content.h"
#include "format.h"

namespace espalier::io {

namespace {

std::vector<Target> readText(const std::filesystem::path& path, Index pointCount,
                             std::string_view bytes) {
    TextReader reader(path, bytes);
    reader.skipComments('#');
    std::vector<Target> targets;
    std::vector<std::size_t> lines(pointCount, 0);
    while (!reader.atEnd()) {
        Target target{};
        target.point = reader.number<Index>("the number of a point");
        target.line = reader.line();
        if (targets.size() > 0 && targets.back().line == target.line)
            reader.fail("expected one target on each line");
        if (target.point < 0 || target.point >= pointCount)
            reader.fail(concat("there is no point ", target.point, "; the model has ", pointCount,
                               " points, numbered from 0"));
        std::size_t& before = lines[target.point];
        if (before != 0)
            reader.fail(concat("point ", target.point, " has a target already, on line ", before));
        before = target.line;
        for (double& coordinate : target.position) {
            coordinate = reader.number<double>("a coordinate");
            if (reader.line() != target.line)
                throw FileError(path, target.line,
                                "expected the number of a point and three coordinates on the line");
            if (!std::isfinite(coordinate)) reader.fail("the coordinate is not finite");
        }
        targets.push_back(target);
    }
    if (targets.empty())
        throw FileError(
            path,
            "has no target; expected the number of a point and three coordinates on each line");
    return targets;
}

}  // namespace

std::vector<Target> readTargets(const std::filesystem::path& path, Index pointCount) {
    return readTargets(path, pointCount, readFile(path));
}

std::vector<Target> readTargets(const std::filesystem::path& path, Index pointCount,
                                std::string_view bytes) {
    return explainingContent(path, bytes, [&] { return readText(path, pointCount, bytes); });
}

const Format kTargetsFormat = {.extensions = {".txt"}, .isTargets = true};

}  // namespace espalier::io
