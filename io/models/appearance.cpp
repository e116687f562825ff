// SPDX-License-Identifier: Apache-2.0
#include <espalier/base/error.h>
#include <espalier/io/model.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <string>
#include <vector>

#include "splats.h"

namespace espalier::io {
namespace {

/// Returns the attribute with a component of a colour or of texture coordinates; null if there is
/// none.
const PointAttribute* findComponent(const std::vector<PointAttribute>& attributes,
                                    PointAttribute::Kind kind, std::size_t component) {
    const auto found = std::ranges::find_if(attributes, [&](const PointAttribute& attribute) {
        return attribute.kind == kind && attribute.component == component;
    });
    return found == attributes.end() ? nullptr : &*found;
}

/// Reads an attribute, and removes it from the other data of the surface.
std::vector<double> take(const PointAttribute& attribute, ModelSurface& surface) {
    surface.removePointData(attribute.name);
    surface.removePointData(attribute.name.substr(0, attribute.name.rfind(':')));  // an array
    return attribute.read();
}

/// Takes the colours of the points from attributes, if there are red, green and blue.
void readColors(const std::vector<PointAttribute>& attributes, std::size_t pointCount,
                ModelSurface& surface) {
    std::array<const PointAttribute*, 4> channels{};
    for (std::size_t component = 0; component < 4; ++component)
        channels[component] = findComponent(attributes, PointAttribute::Kind::Color, component);
    if (!channels[0] || !channels[1] || !channels[2]) return;
    surface.colors.assign(pointCount, {0, 0, 0, 1});
    for (std::size_t component = 0; component < 4; ++component) {
        if (!channels[component]) continue;
        const std::vector<double> values = take(*channels[component], surface);
        for (std::size_t i = 0; i < values.size(); ++i)
            if (!std::isnan(values[i]))
                surface.colors[i][component] = static_cast<float>(std::clamp(values[i], 0.0, 1.0));
    }
}

/// Takes the texture coordinates of the points from attributes, if there are u and v.
void readTextures(const std::vector<PointAttribute>& attributes, ModelSurface& surface) {
    const auto* u = findComponent(attributes, PointAttribute::Kind::TextureCoordinate, 0);
    const auto* v = findComponent(attributes, PointAttribute::Kind::TextureCoordinate, 1);
    if (!u || !v || surface.faces.count() == 0) return;
    const std::vector<double> us = take(*u, surface), vs = take(*v, surface);
    surface.textures.clear();
    for (std::size_t i = 0; i < us.size(); ++i) surface.textures.push_back({us[i], vs[i]});
    surface.textureCorners = surface.faces.corners;
}

/// Reads the numbers of attributes NAME_0, NAME_1, …
std::vector<std::vector<double>> readNumbered(const std::vector<PointAttribute>& attributes,
                                              const std::string& name, std::size_t count) {
    std::vector<std::vector<double>> numbers;
    for (std::size_t i = 0; i < count; ++i) {
        const auto found =
            std::ranges::find(attributes, concat(name, "_", i), &PointAttribute::name);
        if (found == attributes.end()) return {};
        numbers.push_back(found->read());
    }
    return numbers;
}

/// Reads the covariances of splats.
std::vector<std::array<float, 6>> readCovariances(const std::vector<PointAttribute>& attributes) {
    const auto sizes = readNumbered(attributes, "scale", 3);
    const auto turns = readNumbered(attributes, "rot", 4);
    std::vector<std::array<float, 6>> covariances;
    if (sizes.empty() || turns.empty()) return covariances;
    for (std::size_t i = 0; i < sizes[0].size(); ++i)
        covariances.push_back(
            splatCovariance({sizes[0][i], sizes[1][i], sizes[2][i]},
                            {turns[0][i], turns[1][i], turns[2][i], turns[3][i]}));
    return covariances;
}

/// Takes the colours of splats from all sides: the harmonic of degree 0, and the opacity.
void readSplatColors(const std::vector<PointAttribute>& attributes, ModelSurface& surface) {
    constexpr double kHarmonic = 0.28209479177387814;  // 1 / (2 √π)
    const auto harmonics = readNumbered(attributes, "f_dc", 3);
    const auto found = std::ranges::find(attributes, "opacity", &PointAttribute::name);
    if (harmonics.empty() || found == attributes.end()) return;
    for (const char* name : {"f_dc_0", "f_dc_1", "f_dc_2"}) surface.removePointData(name);
    const std::vector<double> opacities = take(*found, surface);
    for (std::size_t i = 0; i < opacities.size(); ++i) {
        auto& color = surface.colors.emplace_back();
        for (std::size_t c = 0; c < 3; ++c)
            color[c] = static_cast<float>(std::clamp(0.5 + kHarmonic * harmonics[c][i], 0.0, 1.0));
        color[3] = static_cast<float>(1 / (1 + std::exp(-opacities[i])));
    }
}

}  // namespace

void readAppearance(const Model& model, ModelSurface& surface) {
    const auto attributes = model.attributes();
    if (surface.colors.empty()) readColors(attributes, model.positions().size(), surface);
    if (surface.textureCorners.empty()) readTextures(attributes, surface);
    if (model.directions().splats == 0) return;
    surface.covariances = readCovariances(attributes);
    if (surface.colors.empty()) readSplatColors(attributes, surface);
}

}  // namespace espalier::io
