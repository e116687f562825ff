// SPDX-License-Identifier: Apache-2.0
#include "gltf_scene.h"

#include <espalier/base/error.h>
#include <espalier/base/progress.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <string>
#include <tuple>

#include "gltf_accessor.h"

namespace espalier::io {
namespace {

/// Returns the numbers of a list in a node; nothing if the node has no such list.
template <std::size_t count>
std::optional<std::array<double, count>> numbersIn(const GltfFile& file, const Json& node,
                                                   const char* key) {
    const auto found = node.find(key);
    if (found == node.end()) return std::nullopt;
    std::array<double, count> numbers;
    if (!found->is_array() || found->size() != count)
        file.fail(
            concat("a node has a malformed ", inQuotes(key), "; expected ", count, " numbers"));
    for (std::size_t i = 0; i < count; ++i) {
        if (!(*found)[i].is_number())
            file.fail(
                concat("a node has a malformed ", inQuotes(key), "; expected ", count, " numbers"));
        numbers[i] = (*found)[i].template get<double>();
    }
    return numbers;
}

/// Returns the map of a matrix of 16 numbers, column by column, whose last row is 0 0 0 1.
Affine affineOf(const double* columns) {
    Affine map;
    for (std::size_t i = 0; i < 3; ++i) {
        for (std::size_t j = 0; j < 3; ++j) map.linear[3 * i + j] = columns[4 * j + i];
        map.translation[i] = columns[12 + i];
    }
    return map;
}

DeformationGradient rotationOf(const std::array<double, 4>& quaternion) {
    const double norm =
        length({length({quaternion[0], quaternion[1], quaternion[2]}), quaternion[3], 0});
    if (!(norm > 0)) return kIdentity;
    const double x = quaternion[0] / norm, y = quaternion[1] / norm, z = quaternion[2] / norm,
                 w = quaternion[3] / norm;
    return {1 - 2 * (y * y + z * z), 2 * (x * y - z * w),     2 * (x * z + y * w),
            2 * (x * y + z * w),     1 - 2 * (x * x + z * z), 2 * (y * z - x * w),
            2 * (x * z - y * w),     2 * (y * z + x * w),     1 - 2 * (x * x + y * y)};
}

/// Returns the map of a node in its parent.
Affine localMap(const GltfFile& file, const Json& node) {
    if (const auto matrix = numbersIn<16>(file, node, "matrix")) return affineOf(matrix->data());
    Affine map;
    if (const auto rotation = numbersIn<4>(file, node, "rotation"))
        map.linear = rotationOf(*rotation);
    if (const auto scale = numbersIn<3>(file, node, "scale"))
        for (std::size_t i = 0; i < 9; ++i) map.linear[i] *= (*scale)[i % 3];
    if (const auto translation = numbersIn<3>(file, node, "translation"))
        map.translation = *translation;
    return map;
}

}  // namespace

Point3 operator*(const DeformationGradient& m, const Point3& v) {
    Point3 result;
    for (std::size_t i = 0; i < 3; ++i)
        result[i] = m[3 * i] * v[0] + m[3 * i + 1] * v[1] + m[3 * i + 2] * v[2];
    return result;
}

DeformationGradient operator*(const DeformationGradient& a, const DeformationGradient& b) {
    DeformationGradient product;
    for (std::size_t i = 0; i < 3; ++i)
        for (std::size_t j = 0; j < 3; ++j)
            product[3 * i + j] =
                a[3 * i] * b[j] + a[3 * i + 1] * b[3 + j] + a[3 * i + 2] * b[6 + j];
    return product;
}

Point3 operator*(const Affine& map, const Point3& point) {
    Point3 result = map.linear * point;
    for (std::size_t i = 0; i < 3; ++i) result[i] += map.translation[i];
    return result;
}

Affine operator*(const Affine& outer, const Affine& inner) {
    return {outer.linear * inner.linear, outer * inner.translation};
}

double determinant(const DeformationGradient& m) {
    return m[0] * (m[4] * m[8] - m[5] * m[7]) + m[1] * (m[5] * m[6] - m[3] * m[8]) +
           m[2] * (m[3] * m[7] - m[4] * m[6]);
}

std::optional<DeformationGradient> inverse(const DeformationGradient& m) {
    // A determinant this small beside the lengths of the rows is one of rounding.
    constexpr double kSingular = 1e-13;
    const double det = determinant(m);
    const double size =
        length({m[0], m[1], m[2]}) * length({m[3], m[4], m[5]}) * length({m[6], m[7], m[8]});
    if (!(std::abs(det) > kSingular * size)) return std::nullopt;
    DeformationGradient result;
    for (std::size_t i = 0; i < 3; ++i)
        for (std::size_t j = 0; j < 3; ++j) {
            const std::size_t a = (j + 1) % 3, b = (j + 2) % 3, c = (i + 1) % 3, d = (i + 2) % 3;
            result[3 * i + j] = (m[3 * a + c] * m[3 * b + d] - m[3 * a + d] * m[3 * b + c]) / det;
        }
    if (!std::ranges::all_of(result, [](double x) { return std::isfinite(x); }))
        return std::nullopt;
    return result;
}

std::vector<Affine> worldMaps(const GltfFile& file) {
    const std::size_t count = file.list("nodes").size();
    std::vector<std::optional<std::size_t>> parents(count);
    std::vector<std::size_t> order;  // parents before their children
    std::vector<std::vector<std::size_t>> children(count);
    for (std::size_t node = 0; node < count; ++node) {
        const Json& json = file.item("nodes", node);
        const auto found = json.find("children");
        if (found == json.end()) continue;
        if (!found->is_array()) file.fail(concat("node ", node, " has malformed children"));
        for (const Json& child : *found) {
            const std::size_t index = wholeNumber(child).value_or(count);
            if (index >= count)
                file.fail(concat("node ", node, " has the child ", child.dump().substr(0, 40),
                                 ", which does not exist; there are ", count, " nodes"));
            if (parents[index])
                file.fail(concat("node ", index, " is a child of node ", *parents[index],
                                 " and of node ", node, "; expected one parent at most"));
            parents[index] = node;
            children[node].push_back(index);
        }
    }
    for (std::size_t node = 0; node < count; ++node)
        if (!parents[node]) order.push_back(node);
    for (std::size_t i = 0; i < order.size(); ++i)
        order.insert(order.end(), children[order[i]].begin(), children[order[i]].end());
    if (order.size() < count) file.fail("some nodes are children of their own descendants");
    std::vector<Affine> maps(count);
    for (const std::size_t node : order) {
        const Affine local = localMap(file, file.item("nodes", node));
        maps[node] = parents[node] ? maps[*parents[node]] * local : local;
    }
    return maps;
}

std::vector<GltfDrawing> drawingsOf(const GltfFile& file, const std::vector<Affine>& world) {
    std::vector<GltfDrawing> drawings;
    std::map<std::tuple<std::size_t, std::optional<std::size_t>, DeformationGradient, Point3>,
             std::size_t>
        known;
    for (std::size_t i = 0; i < world.size(); ++i) {
        const Json& node = file.item("nodes", i);
        const auto mesh = file.number(node, "mesh");
        if (!mesh) continue;
        file.item("meshes", *mesh);
        if (GltfFile::extension(node, "EXT_mesh_gpu_instancing"))
            file.fail(concat("node ", i,
                             " draws its mesh many times by EXT_mesh_gpu_instancing, "
                             "which Espalier does not read; make nodes of the "
                             "instances"));
        GltfDrawing drawing{*mesh, {i}, file.number(node, "skin"), world[i]};
        if (drawing.skin) drawing.matrix = {};
        const auto [same, isNew] = known.try_emplace(
            {drawing.mesh, drawing.skin, drawing.matrix.linear, drawing.matrix.translation},
            drawings.size());
        if (isNew)
            drawings.push_back(drawing);
        else
            drawings[same->second].nodes.push_back(i);
    }
    return drawings;
}

std::vector<Affine> jointMaps(const GltfFile& file, const std::vector<Affine>& world,
                              std::size_t skin) {
    const Json& json = file.item("skins", skin);
    const auto joints = json.find("joints");
    if (joints == json.end() || !joints->is_array())
        file.fail(concat("skin ", skin, " has no joints"));
    std::vector<Affine> maps;
    for (const Json& joint : *joints) {
        const std::size_t node = wholeNumber(joint).value_or(world.size());
        if (node >= world.size())
            file.fail(concat("skin ", skin, " has the joint ", joint.dump().substr(0, 40),
                             ", which is not the number of a node; there are ", world.size()));
        maps.push_back(world[node]);
    }
    if (const auto binds = file.number(json, "inverseBindMatrices")) {
        const GltfAccessor accessor = accessorOf(file, *binds);
        if (accessor.components != 16 || accessor.count < maps.size())
            file.fail(concat("skin ", skin, " has ", maps.size(), " joints, and accessor ", *binds,
                             " no matrix for each of them"));
        const std::vector<double> numbers = numbersOf(file, *binds);
        for (std::size_t i = 0; i < maps.size(); ++i)
            maps[i] = maps[i] * affineOf(&numbers[16 * i]);
    }
    return maps;
}

std::vector<Affine> skinMaps(const GltfFile& file, const std::vector<Affine>& joints,
                             const Json& attributes, std::size_t count) {
    std::vector<Affine> maps;
    std::vector<double> sums;
    for (std::size_t set = 0;; ++set) {
        const auto jointsAt = file.number(attributes, concat("JOINTS_", set).c_str());
        const auto weightsAt = file.number(attributes, concat("WEIGHTS_", set).c_str());
        if (!jointsAt || !weightsAt) break;
        const GltfAccessor accessor = accessorOf(file, *jointsAt);
        if (accessor.components != 4 || accessor.count != count ||
            accessorOf(file, *weightsAt).components != 4 ||
            accessorOf(file, *weightsAt).count != count)
            file.fail(concat("accessors ", *jointsAt, " and ", *weightsAt,
                             " do not have 4 joints and weights for each of ", count, " points"));
        const std::vector<double> numbers = numbersOf(file, *jointsAt);
        const std::vector<double> weights = numbersOf(file, *weightsAt);
        maps.resize(count, Affine{{}, {}});
        sums.resize(count);
        for (std::size_t i = 0; i < numbers.size(); ++i) {
            checkCancelledEvery(i, 14);
            if (weights[i] == 0) continue;
            if (!(numbers[i] >= 0 && numbers[i] < static_cast<double>(joints.size())))
                file.fail(concat("point ", i / 4, " follows joint ", numbers[i],
                                 ", which does not exist; the skin has ", joints.size()));
            const Affine& joint = joints[static_cast<std::size_t>(numbers[i])];
            Affine& map = maps[i / 4];
            sums[i / 4] += weights[i];
            for (std::size_t k = 0; k < 9; ++k) map.linear[k] += weights[i] * joint.linear[k];
            for (std::size_t k = 0; k < 3; ++k)
                map.translation[k] += weights[i] * joint.translation[k];
        }
    }
    const Affine first = joints.empty() ? Affine{} : joints[0];
    if (maps.empty()) return {first};
    // Weights of bytes, and of careless exporters, do not quite add up to 1. Programs that draw
    // them divide by the sum.
    for (std::size_t i = 0; i < count; ++i) {
        if (!(sums[i] > 0)) {
            maps[i] = first;
            continue;
        }
        for (double& number : maps[i].linear) number /= sums[i];
        for (double& number : maps[i].translation) number /= sums[i];
    }
    const auto isFirst = [&](const Affine& map) { return map == maps[0]; };
    if (count > 0 && std::ranges::all_of(maps, isFirst)) maps.resize(1);
    return maps;
}

}  // namespace espalier::io
