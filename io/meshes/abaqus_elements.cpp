// SPDX-License-Identifier: Apache-2.0
#include "abaqus_elements.h"

#include <espalier/io/files/text_reader.h>

#include <algorithm>
#include <string>

namespace espalier::io {
namespace {

/// A family of elements: the begin of their names, before the number of nodes.
struct AbaqusFamily {
    std::string_view begin;
    int dimension;
    bool isShell = false;
};

constexpr AbaqusFamily kFamilies[] = {
    // Continua: stress, heat, sound, electricity, pores. SC are shells with the shape of solids.
    {"c3d", 3},
    {"dc3d", 3},
    {"dcc3d", 3},
    {"ac3d", 3},
    {"q3d", 3},
    {"ec3d", 3},
    {"emc3d", 3},
    {"pc3d", 3},
    {"f3d", 3},
    {"fc3d", 3},
    {"sc", 3},
    // Plane stress and strain, axial symmetry.
    {"cps", 2},
    {"cpe", 2},
    {"cpeg", 2},
    {"cax", 2},
    {"cgax", 2},
    {"dc2d", 2},
    {"dcc2d", 2},
    {"dcax", 2},
    {"dccax", 2},
    {"ac2d", 2},
    {"acax", 2},
    {"emc2d", 2},
    // Shells, membranes, rigid and other surfaces.
    {"s", 2, true},
    {"stri", 2, true},
    {"ds", 2, true},
    {"m3d", 2, true},
    {"r3d", 2, true},
    {"sfm3d", 2, true},
    // Beams, trusses, springs and the like, whose elements need no check.
    {"b2", 1},
    {"b3", 1},
    {"t2d", 1},
    {"t3d", 1},
    {"dc1d", 1},
    {"pipe2", 1},
    {"pipe3", 1},
    {"r2d", 1},
    {"rb2d", 1},
    {"rb3d", 1},
    {"rax", 1},
    {"sax", 1},
    {"dsax", 1},
    {"max", 1},
    {"conn2d", 1},
    {"conn3d", 1},
    {"spring", 1},
    {"dashpot", 1},
    {"gapuni", 1},
    {"mass", 0},
    {"rotaryi", 0},
    {"heatcap", 0},
};

bool isDigitOfType(char c) {
    return c >= '0' && c <= '9';
}

}  // namespace

AbaqusElement abaqusElement(std::string_view name) {
    const std::string text = lowerCase(name);
    if (text == "d") return {.dimension = 1};  // a pipe of CalculiX
    // The longest family that the name begins with: "dc3d" is not the dimension of "d".
    const AbaqusFamily* family = nullptr;
    for (const AbaqusFamily& other : kFamilies)
        if (text.starts_with(other.begin) && (!family || other.begin.size() > family->begin.size()))
            family = &other;
    if (!family) return {};
    if (family->dimension < 2) return {.dimension = family->dimension};
    std::string_view rest = std::string_view(text).substr(family->begin.size());
    const auto end = std::find_if_not(rest.begin(), rest.end(), isDigitOfType);
    const std::string_view digits = rest.substr(0, end - rest.begin());
    rest.remove_prefix(digits.size());
    std::size_t nodes = 0;
    if (!parseNumber(digits, nodes)) return {};
    // STRI65 has 6 nodes with 5 degrees of freedom each; S8R5 likewise has 8.
    if (text == "stri65") nodes = 6;
    const bool isShell = family->isShell;
    if (family->begin == "s" && rest.ends_with("r5")) rest.remove_suffix(1);
    // C3D15V and C3D27 have further nodes, whose number may vary.
    if (rest.find('v') != std::string_view::npos || std::ranges::any_of(rest, isDigitOfType))
        return {};
    if (family->dimension == 3) {
        for (const std::size_t known : {4, 5, 6, 8})
            if (nodes == known) return {3, nodes, false};
        for (const std::size_t known : {10, 13, 15, 20})
            if (nodes == known) return {3, nodes, true};
        return {};
    }
    for (const std::size_t known : {3, 4})
        if (nodes == known) return {2, nodes, false, isShell};
    for (const std::size_t known : {6, 8, 9})
        if (nodes == known) return {2, nodes, true, isShell};
    return {};
}

}  // namespace espalier::io
