// SPDX-License-Identifier: Apache-2.0
#include <espalier/io/model.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <vector>

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

}  // namespace

void readAppearance(const Model& model, ModelSurface& surface) {
    const auto attributes = model.attributes();
    if (surface.colors.empty()) readColors(attributes, model.positions().size(), surface);
    if (surface.textureCorners.empty()) readTextures(attributes, surface);
}

}  // namespace espalier::io
