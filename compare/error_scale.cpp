// SPDX-License-Identifier: Apache-2.0
#include "error_scale.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <span>

namespace espalier::compare {
namespace {

constexpr int kLeastExponent = -18;
constexpr int kMaxExponent = -6;

// Anchors at equal distances. CIE lightness falls all the way, in about equal steps: 93, 83, 70, 56
// and 42, then 42, 33 and 23. Neighbours are 19 to 27 apart in L*a*b*, the two sides of the bound
// 90.
constexpr std::array<Colour, 5> kWithin = {
    {{233, 239, 197}, {169, 218, 188}, {98, 184, 196}, {58, 143, 192}, {44, 100, 168}}};
constexpr std::array<Colour, 3> kAbove = {{{178, 60, 40}, {149, 30, 55}, {107, 13, 63}}};

/// \param t 0 to 1
Colour interpolated(std::span<const Colour> anchors, double t) {
    const double at = t * static_cast<double>(anchors.size() - 1);
    const std::size_t before = std::min(static_cast<std::size_t>(at), anchors.size() - 2);
    Colour colour{};
    for (std::size_t k = 0; k < 3; ++k)
        colour[k] = static_cast<int>(std::lround(std::lerp(
            anchors[before][k], anchors[before + 1][k], at - static_cast<double>(before))));
    return colour;
}

}  // namespace

std::string hexText(const Colour& colour) {
    return fmt::format("#{:02x}{:02x}{:02x}", colour[0], colour[1], colour[2]);
}

Colour shaded(const Colour& colour, double shade) {
    Colour darker{};
    for (std::size_t k = 0; k < 3; ++k)
        darker[k] = static_cast<int>(std::lround(colour[k] * std::clamp(shade, 0.0, 1.0)));
    return darker;
}

ErrorScale::ErrorScale(double bound)
    : logBound_(std::clamp(bound > 0 ? std::log10(bound) : kLeastExponent, kLeastExponent + 1.0,
                           kMaxExponent - 1.0)) {}

double ErrorScale::place(double error) const {
    const double size = std::abs(error);
    if (!(size < kMax)) return 1;
    if (size <= kLeast) return 0;
    const double log = std::log10(size);
    // The bracket makes it kBoundPlace, to the last bit, at the bound.
    if (log <= logBound_)
        return kBoundPlace * ((log - kLeastExponent) / (logBound_ - kLeastExponent));
    return kBoundPlace + (1 - kBoundPlace) * (log - logBound_) / (kMaxExponent - logBound_);
}

Colour ErrorScale::colour(double error) const {
    return error == 0 ? kExact : colourAt(place(error));
}

Colour ErrorScale::colourAt(double at) const {
    if (at <= kBoundPlace) return interpolated(kWithin, at / kBoundPlace);
    return interpolated(kAbove, (at - kBoundPlace) / (1 - kBoundPlace));
}

std::vector<ErrorScale::Tick> ErrorScale::ticks(double spacing) const {
    std::vector<Tick> ticks;
    double lastLabel = 0;
    for (int exponent = kLeastExponent; exponent <= kMaxExponent; ++exponent) {
        // The places are taken from the text, as those of errors are from what is read.
        const std::string label = fmt::format("1e{}", exponent);
        const double at = place(std::stod(label));
        const bool isEnd = exponent == kLeastExponent || exponent == kMaxExponent;
        const bool fits = at - lastLabel >= spacing && 1 - at >= spacing;
        ticks.push_back({at, isEnd || fits ? label : ""});
        if (!ticks.back().label.empty()) lastLabel = at;
    }
    return ticks;
}

}  // namespace espalier::compare
