// SPDX-License-Identifier: Apache-2.0
#include "pose_selection.h"

#include <espalier/base/bounding_box.h>
#include <espalier/base/printable.h>
#include <espalier/shapes/cell_selection.h>
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <string_view>
#include <utility>

#include "options.h"

namespace espalier::cli {
namespace {

using Numbers = std::vector<double>;

/// Returns the words that are numbers, as numbers.
Numbers numbersIn(std::span<const std::string> words) {
    Numbers values;
    for (const std::string& word : words)
        if (const auto number = numberOf(word)) values.push_back(*number);
    return values;
}

/// Returns a whole number as an Index, so that the library can refuse it by its value.
Index numbered(double number, Index count) {
    return number >= 0 && number < count ? static_cast<Index>(number) : number < 0 ? -1 : count;
}

/// Returns the weights that an attribute holds.
/// \throws CLI::ValidationError if there is no such attribute, or a value is not a weight
std::vector<double> weightsIn(const Lattice& lattice, const std::string& name) {
    const auto hasName = [&](const auto& attribute) { return attribute.name == name; };
    const auto real = std::ranges::find_if(lattice.attributes, hasName);
    const auto whole = std::ranges::find_if(lattice.integers, hasName);
    std::vector<double> weights;
    if (real != lattice.attributes.end() && real->components == 1) {
        weights = real->values;
    } else if (whole != lattice.integers.end() && whole->components == 1) {
        weights.assign(whole->values.begin(), whole->values.end());
    } else {
        std::vector<std::string> names;
        for (const auto& attribute : lattice.attributes) names.push_back(printable(attribute.name));
        for (const auto& attribute : lattice.integers) names.push_back(printable(attribute.name));
        throw CLI::ValidationError(
            kSelect,
            fmt::format("the lattice has no attribute {} with one value for each vertex; its "
                        "attributes: {}",
                        printable(name),
                        names.empty() ? "none" : fmt::format("{}", fmt::join(names, ", "))));
    }
    for (std::size_t v = 0; v < weights.size(); ++v)
        if (!(weights[v] >= 0 && weights[v] <= 1))
            throw CLI::ValidationError(
                kSelect, fmt::format("attribute {} is {} at vertex {}; expected 0 to 1",
                                     printable(name), weights[v], v));
    return weights;
}

/// The kinds of selections, and the words that follow their names.
constexpr std::pair<std::string_view, std::string_view> kSelectionKinds[] = {
    {"box", "X0 Y0 Z0 X1 Y1 Z1"},
    {"ball", "X Y Z RADIUS"},
    {"near", "X Y Z RADIUS"},
    {"half-space", "X Y Z NX NY NZ"},
    {"end", "AXIS with a sign, such as +z"},
    {"limb", "X Y Z"},
    {"beyond", "FACE or X Y Z"},
    {"vertices", "NUMBER..."},
    {"attribute", "NAME"},
    {"grow", "N"},
    {"shrink", "N"}};

}  // namespace

std::optional<Length> lengthOf(const std::string& word) {
    const bool ofDiagonal = word.ends_with('%');
    const auto number = numberOf(ofDiagonal ? word.substr(0, word.size() - 1) : word);
    if (!number) return std::nullopt;
    return Length{*number, ofDiagonal};
}

double Length::in(const Lattice& lattice) const {
    return ofDiagonal ? value / 100 * BoundingBox(lattice.positions).diagonal() : value;
}

std::optional<Point3> directionOf(std::string_view word) {
    double sign = 1;
    if (!word.empty() && (word[0] == '+' || word[0] == '-')) {
        sign = word[0] == '-' ? -1 : 1;
        word.remove_prefix(1);
    }
    if (word.size() != 1 || word[0] < 'x' || word[0] > 'z') return std::nullopt;
    Point3 direction = {0, 0, 0};
    direction[word[0] - 'x'] = sign;
    return direction;
}

Selection selectionOf(const std::vector<std::string>& words) {
    const std::string kind = words.empty() ? "" : words[0];
    const auto known = std::ranges::find(kSelectionKinds, kind,
                                         &std::pair<std::string_view, std::string_view>::first);
    const auto refuse = [](const std::string& got, const std::string& expected) {
        throw CLI::ValidationError(kSelect, printable(got) + ": expected " + expected);
    };
    if (known == std::end(kSelectionKinds)) {
        std::vector<std::string> forms;
        for (const auto& [name, rest] : kSelectionKinds)
            forms.push_back(fmt::format("{} {}", name, rest));
        refuse(kind, fmt::format("{}", fmt::join(forms, "; ")));
    }
    const std::string text = fmt::format("{}", fmt::join(words, " "));
    const std::string form = fmt::format("{} {}", known->first, known->second);
    const auto numbers = [&](std::size_t count) {
        const Numbers values = numbersIn(std::span(words).subspan(1));
        if (values.size() != words.size() - 1 || values.size() != count) refuse(text, form);
        return values;
    };
    Selection result;
    result.text = text;
    if (kind == "box") {
        result.weights = [n = numbers(6)](const Lattice& lattice, const shapes::Falloff& falloff) {
            return shapes::selectBox(lattice.positions, {n[0], n[1], n[2]}, {n[3], n[4], n[5]},
                                     falloff);
        };
    } else if (kind == "ball" || kind == "near") {
        const auto radius = words.size() == 5 ? lengthOf(words[4]) : std::nullopt;
        const auto center = radius ? numbersIn(std::span(words).subspan(1, 3)) : Numbers();
        if (center.size() != 3) refuse(text, form);
        result.weights = [kind, radius = *radius, c = Point3{center[0], center[1], center[2]}](
                             const Lattice& lattice, const shapes::Falloff& falloff) {
            const double size = radius.in(lattice);
            return kind == "ball"
                       ? shapes::selectBall(lattice.positions, c, size, falloff)
                       : shapes::selectNear(lattice.complex, lattice.positions, c, size, falloff);
        };
    } else if (kind == "half-space") {
        result.weights = [n = numbers(6)](const Lattice& lattice, const shapes::Falloff& falloff) {
            return shapes::selectHalfSpace(lattice.positions, {n[0], n[1], n[2]},
                                           {n[3], n[4], n[5]}, falloff);
        };
    } else if (kind == "end") {
        const auto direction = words.size() == 2 ? directionOf(words[1]) : std::nullopt;
        if (!direction) refuse(text, form);
        result.weights = [d = *direction](const Lattice& lattice, const shapes::Falloff& falloff) {
            return shapes::selectEnd(lattice.positions, d, falloff);
        };
    } else if (kind == "vertices") {
        if (words.size() < 2) refuse(text, form);
        result.isExplicit = true;
        result.weights = [n = numbers(words.size() - 1), refuse, text](
                             const Lattice& lattice, const shapes::Falloff& falloff) {
            std::vector<Index> vertices;
            for (const double number : n) {
                if (!(number >= 0 && number < static_cast<double>(lattice.positions.size())) ||
                    number != std::floor(number))
                    refuse(text, fmt::format("numbers of vertices, 0 to {}",
                                             lattice.positions.size() - 1));
                vertices.push_back(static_cast<Index>(number));
            }
            return shapes::selectNumbers(lattice.positions, vertices, falloff);
        };
    } else if (kind == "limb") {
        result.part = [n = numbers(3)](const Lattice& lattice) {
            return shapes::selectLimb(lattice.complex, lattice.positions, {n[0], n[1], n[2]});
        };
    } else if (kind == "beyond") {
        const Numbers n = numbers(words.size() == 2 ? 1 : 3);
        if (n.size() == 1 && n[0] != std::floor(n[0])) refuse(text, form);
        result.part = [n](const Lattice& lattice) {
            const Index face = n.size() == 1
                                   ? numbered(n[0], lattice.complex.count(2))
                                   : shapes::nearestInnerFace(lattice.complex, lattice.positions,
                                                              {n[0], n[1], n[2]});
            return shapes::selectBeyond(lattice.complex, lattice.positions, face);
        };
    } else if (kind == "grow" || kind == "shrink") {
        constexpr double kMaxSteps = 1e6;
        const double steps = numbers(1).front();
        if (!(steps >= 1 && steps <= kMaxSteps) || steps != std::floor(steps))
            refuse(text, form + ", a whole number from 1 to 1000000");
        result.change = [kind, steps](const Lattice& lattice, std::span<const Index> vertices) {
            return kind == "grow"
                       ? shapes::growSelection(lattice.complex, vertices, static_cast<int>(steps))
                       : shapes::shrinkSelection(lattice.complex, vertices,
                                                 static_cast<int>(steps));
        };
    } else {
        if (words.size() != 2) refuse(text, form);
        result.takesFalloff = false;
        result.isExplicit = true;
        result.weights = [name = words[1]](const Lattice& lattice, const shapes::Falloff&) {
            return weightsIn(lattice, name);
        };
    }
    return result;
}

Pivot pivotOf(const std::vector<std::string>& words) {
    using Kind = Pivot::Kind;
    const std::string first = words.empty() ? "" : words[0];
    const std::size_t from = first == "vertex" || first == "border" || first == "joint" ? 1 : 0;
    std::vector<double> numbers;
    for (std::size_t i = from; i < words.size(); ++i)
        if (const auto number = numberOf(words[i])) numbers.push_back(*number);
    const std::size_t expected = first == "vertex" ? 1 : first == "border" ? 0 : 3;
    const bool isVertex = first == "vertex" && numbers.size() == 1 && numbers[0] >= 0 &&
                          numbers[0] < kMaxIndex && numbers[0] == std::floor(numbers[0]);
    if (numbers.size() != expected || words.size() != from + expected ||
        (first == "vertex" && !isVertex))
        throw CLI::ValidationError(
            "--about", fmt::format("expected vertex NUMBER; border; joint X Y Z; X Y Z; got {}",
                                   shown(printable(fmt::format("{}", fmt::join(words, " "))))));
    if (first == "vertex") return {Kind::Vertex, {}, static_cast<Index>(numbers[0])};
    if (first == "border") return {};
    return {from == 1 ? Kind::Joint : Kind::Point, {numbers[0], numbers[1], numbers[2]}, 0};
}

std::optional<MirrorPlane> mirrorPlaneOf(const std::string& word) {
    if (word.empty() || word[0] < 'x' || word[0] > 'z') return std::nullopt;
    const int axis = word[0] - 'x';
    if (word.size() == 1) return MirrorPlane{axis};
    const auto place = word[1] == '=' ? numberOf(word.substr(2)) : std::nullopt;
    return place ? std::optional(MirrorPlane{axis, *place}) : std::nullopt;
}

}  // namespace espalier::cli
