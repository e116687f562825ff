// SPDX-License-Identifier: Apache-2.0
#include <espalier/base/error.h>
#include <espalier/io/files/file.h>
#include <espalier/io/files/text_reader.h>
#include <espalier/io/model_part.h>

#include <algorithm>
#include <utility>

namespace espalier::io {
namespace {

/// Returns the item of a name.
/// \param kind for messages: "attribute"
/// \throws FileError that lists the names
template <class Item>
const Item& find(const std::filesystem::path& path, const std::vector<Item>& items,
                 const std::string& name, const char* kind) {
    const auto found = std::ranges::find(items, name, &Item::name);
    if (found != items.end()) return *found;
    constexpr std::size_t kMaxNames = 20;
    std::string names;
    for (std::size_t i = 0; i < std::min(items.size(), kMaxNames); ++i)
        names += concat(i == 0 ? "" : ", ", inQuotes(items[i].name));
    if (items.size() > kMaxNames) names += concat(" and ", items.size() - kMaxNames, " more");
    throw FileError(path, concat("has no ", kind, " ", inQuotes(name), " of points; ",
                                 items.empty() ? "there are none" : "it has " + names));
}

/// Returns for each point of a model if it is in one of the groups.
std::vector<bool> areInGroups(const std::filesystem::path& path, const Model& model,
                              const std::vector<std::string>& names) {
    const std::vector<PointGroup> groups = model.groups();
    std::vector<bool> areIn(model.positions().size());
    for (const std::string& name : names)
        for (const Index point : find(path, groups, name, "group").read()) areIn[point] = true;
    return areIn;
}

}  // namespace

std::vector<double> numbersOf(const std::filesystem::path& path, const Model& model,
                              const std::string& name) {
    const auto attributes = model.attributes();
    auto numbers = find(path, attributes, name, "attribute").read();
    if (const std::size_t count = model.positions().size(); numbers.size() != count)
        throw FileError(path, concat("has ", numbers.size(), " numbers ", inQuotes(name), " for ",
                                     count, " points"));
    return numbers;
}

far::MeshPatch patchOf(const std::filesystem::path& path, const Model& model,
                       const std::string& name) {
    std::vector<far::MeshPatch> patches = model.readCells().patches;
    const auto found = std::ranges::find(patches, name, &far::MeshPatch::name);
    if (found != patches.end()) return std::move(*found);
    const std::vector<bool> areIn = areInGroups(path, model, {name});
    far::MeshPatch patch{name};
    patch.dimension = 2;
    for (std::size_t i = 0; i < areIn.size(); ++i)
        if (areIn[i]) patch.points.push_back(static_cast<Index>(i));
    const ModelFaces faces = model.readSurface().faces;
    for (std::size_t face = 0; face < faces.count(); ++face)
        if (std::ranges::all_of(faces[face], [&](Index corner) { return areIn[corner]; }))
            patch.faces.push(faces[face]);
    return patch;
}

std::vector<Index> heldPointsOf(const std::filesystem::path& path, const Model& model,
                                const ModelPart& part) {
    std::vector<Index> points;
    if (part.holds.empty()) return points;
    const std::vector<bool> areHeld = areInGroups(path, model, part.holds);
    for (std::size_t i = 0; i < areHeld.size(); ++i)
        if (areHeld[i]) points.push_back(static_cast<Index>(i));
    return points;
}

bind::PointWeights weightsOf(const std::filesystem::path& path, const Model& model,
                             const ModelPart& part, bool needSlopes) {
    bind::PointWeights weights;
    if (part.isWhole()) return weights;
    const auto points = model.positions();
    weights.values.assign(points.size(), 1);
    const auto multiply = [&](const std::vector<double>& factors, const std::string& name) {
        if (factors.size() != points.size())
            throw Error(concat("got ", factors.size(), " weights for ", points.size(), " points"));
        for (std::size_t i = 0; i < factors.size(); ++i) {
            if (!(factors[i] >= 0 && factors[i] <= 1))
                throw FileError(path, concat("has ", name, " = ", formatNumber(factors[i]),
                                             " at point ", i, "; weights are 0 to 1"));
            weights.values[i] *= factors[i];
        }
    };
    if (!part.weights.empty())
        multiply(numbersOf(path, model, part.weights), inQuotes(part.weights));
    if (!part.factors.empty()) multiply(part.factors, "a weight");
    if (!part.groups.empty()) {
        const std::vector<bool> areIn = areInGroups(path, model, part.groups);
        for (std::size_t i = 0; i < points.size(); ++i)
            if (!areIn[i]) weights.values[i] = 0;
    }
    for (const Index point : heldPointsOf(path, model, part)) weights.values[point] = 0;
    return needSlopes ? withSlopes(model, std::move(weights.values)) : weights;
}

std::string noteOnSlopes(const std::filesystem::path& path, const Model& model,
                         const bind::PointWeights& weights) {
    if (!model.hasDirections() || weights.values.empty() || !weights.slopes.empty()) return {};
    return concat(shownPath(path), " has no faces, so the normals, tangents and splats of its ",
                  model.positions().size(),
                  " points turn as if the weights around each point were the same");
}

bind::PointWeights withSlopes(const Model& model, std::vector<double> values) {
    std::vector<Index> shapes;
    const ModelFaces faces = model.facesOfShapes(shapes);
    bind::PointWeights weights{std::move(values), {}};
    if (faces.count() > 0)
        weights.slopes = bind::slopesOnSurface(model.positions(), faces.corners, faces.ends,
                                               weights.values, shapes);
    return weights;
}

}  // namespace espalier::io
