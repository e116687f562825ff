// SPDX-License-Identifier: Apache-2.0
#include "abaqus_sets.h"

#include <espalier/base/error.h>
#include <espalier/base/sort_unique.h>
#include <espalier/far/second_order_cells.h>

#include <algorithm>
#include <array>
#include <cstdint>

namespace espalier::io {
namespace {

/// The corners of the sides of an element; a side of a face has two.
using Sides = std::vector<std::vector<std::size_t>>;

/// Returns the sides S1, S2, … of a solid or a face as Abaqus numbers them.
const Sides& sidesOf(int dimension, std::size_t cornerCount) {
    static const Sides kNoSides;
    static const Sides kTriangle = {{0, 1}, {1, 2}, {2, 0}};
    static const Sides kQuadrilateral = {{0, 1}, {1, 2}, {2, 3}, {3, 0}};
    static const Sides kTetrahedron = {{0, 1, 2}, {0, 3, 1}, {1, 3, 2}, {2, 3, 0}};
    static const Sides kPyramid = {{0, 1, 2, 3}, {0, 4, 1}, {1, 4, 2}, {2, 4, 3}, {3, 4, 0}};
    static const Sides kWedge = {{0, 1, 2}, {3, 5, 4}, {0, 3, 4, 1}, {1, 4, 5, 2}, {2, 5, 3, 0}};
    static const Sides kHexahedron = {{0, 1, 2, 3}, {4, 7, 6, 5}, {0, 4, 5, 1},
                                      {1, 5, 6, 2}, {2, 6, 7, 3}, {3, 7, 4, 0}};
    if (dimension == 2) return cornerCount == 3 ? kTriangle : kQuadrilateral;
    if (dimension != 3) return kNoSides;
    switch (cornerCount) {
        case 4:
            return kTetrahedron;
        case 5:
            return kPyramid;
        case 6:
            return kWedge;
        default:
            return kHexahedron;
    }
}

/// Returns the number of corners of a face or a solid with this number of points.
std::size_t cornersOf(int dimension, std::size_t points) {
    if (dimension == 2) return points == 3 || points == 6 ? 3 : 4;
    return static_cast<std::size_t>(far::vertexCount(*far::kindOfCell(points)));
}

/// Returns the side that a label names; nothing for an unknown label.
std::optional<AbaqusSide> sideOf(std::string_view label) {
    const std::string text = lowerCase(label);
    if (text == "spos" || text == "sneg") return AbaqusSide{};
    std::size_t number = 0;
    if (text.size() < 2 || (text[0] != 's' && text[0] != 'e') ||
        !parseNumber(std::string_view(text).substr(1), number) || number < 1 || number > 6)
        return std::nullopt;
    return AbaqusSide{number, text[0] == 'e'};
}

bool isWholeNumber(std::string_view entry, std::int64_t& number) {
    return !entry.empty() && parseNumber(entry, number);
}

}  // namespace

AbaqusSets::AbaqusSets(const std::filesystem::path& path, std::string_view bytes,
                       const AbaqusNumbers& numbers)
    : numbers_(numbers) {
    const std::size_t elementCount = numbers.elementBlocks.back();
    // A set of all elements in each of many lines must not take all memory.
    constexpr std::size_t kMaxSets = 100;
    maxMembers_ = kMaxSets * (elementCount + static_cast<std::size_t>(numbers.nodeBlocks.back()));
    AbaqusFile file(path, bytes);
    std::size_t nodeBlock = 0, elementBlock = 0;
    const auto addBlock = [&](Sets& sets, std::span<const Index> blocks, std::size_t block,
                              const char* parameter) {
        const std::string_view name = file.keyword().nameIn(parameter);
        if (name.empty()) return;
        std::vector<Index>& members = setOf(sets, file.scopes().current(), name, false).members;
        countMembers(file, static_cast<std::size_t>(blocks[block + 1] - blocks[block]));
        for (Index i = blocks[block]; i < blocks[block + 1]; ++i) members.push_back(i);
    };
    while (file.next()) {
        const std::string& keyword = file.keyword().name;
        if (keyword == "node")
            addBlock(nodeSets_, numbers.nodeBlocks, nodeBlock++, "nset");
        else if (keyword == "element")
            addBlock(elementSets_, numbers.elementBlocks, elementBlock++, "elset");
        else if (keyword == "nset" || keyword == "elset")
            readSet(file, keyword == "nset");
        else if (keyword == "surface")
            readSurface(file);
    }
    setsOfElements_.resize(elementCount);
    for (std::size_t set = 0; set < elementSets_.all.size(); ++set) {
        if (elementSets_.all[set].isInternal) continue;
        for (const Index element : elementSets_.all[set].members)
            if (setsOfElements_[element].empty() || setsOfElements_[element].back() != set)
                setsOfElements_[element].push_back(set);
    }
    if (needsElements()) elements_.resize(elementCount);
}

/// Returns the set of a name in a scope; a new one if there is none.
AbaqusSets::Set& AbaqusSets::setOf(Sets& sets, std::size_t scope, std::string_view name,
                                   bool isInternal) {
    const auto [at, isNew] = sets.numbers.try_emplace({scope, lowerCase(name)}, sets.all.size());
    if (isNew) sets.all.push_back({std::string(name), isInternal});
    return sets.all[at->second];
}

/// Returns the scope whose numbers the data of a keyword name.
std::size_t AbaqusSets::scopeOf(const AbaqusFile& file) const {
    const auto instance = numbers_.instances.find(lowerCase(file.keyword().nameIn("instance")));
    return numbers_
        .partOf[instance == numbers_.instances.end() ? file.scopes().current() : instance->second];
}

void AbaqusSets::countMembers(const AbaqusFile& file, std::size_t members) {
    memberCount_ += members;
    if (memberCount_ > maxMembers_)
        file.fail(concat("the sets have more than ", maxMembers_,
                         " members, 100 for each node and element; this is not supported"));
}

/// Adds the members that an entry of a set names: a number, or a set; each perhaps of an instance,
/// "INSTANCE.NAME".
/// \param own the scope of the keyword, which may have the set
/// \param scope the scope of the numbers, which may have the set, too
void AbaqusSets::addMembers(std::vector<Index>& members, bool isOfNodes, std::size_t own,
                            std::size_t scope, std::string_view entry) const {
    const auto& ofKind = isOfNodes ? numbers_.nodes : numbers_.elements;
    const Sets& sets = isOfNodes ? nodeSets_ : elementSets_;
    const auto addFrom = [&](std::size_t from, std::string_view name) {
        std::int64_t number = 0;
        if (isWholeNumber(name, number)) {
            if (const auto member = ofKind[from].find(number)) members.push_back(*member);
            return true;
        }
        const auto found = sets.numbers.find({from, lowerCase(name)});
        if (found == sets.numbers.end()) return false;
        const std::vector<Index>& others = sets.all[found->second].members;
        members.insert(members.end(), others.begin(), others.end());
        return true;
    };
    std::int64_t number = 0;
    if (!isWholeNumber(entry, number) && own != scope && addFrom(own, entry)) return;
    // "1.5" is element 5 of the instance "1", and no number here.
    if (addFrom(scope, entry)) return;
    const std::size_t dot = entry.find('.');
    if (dot == std::string_view::npos) return;
    const auto instance = numbers_.instances.find(lowerCase(entry.substr(0, dot)));
    if (instance != numbers_.instances.end())
        addFrom(numbers_.partOf[instance->second], entry.substr(dot + 1));
}

void AbaqusSets::readSet(AbaqusFile& file, bool isOfNodes) {
    const AbaqusKeyword keyword = file.keyword();
    const std::string_view name = keyword.nameIn(isOfNodes ? "nset" : "elset");
    if (name.empty()) return;
    const bool isInternal = keyword.parameter("internal").has_value();
    const std::size_t scope = scopeOf(file), own = file.scopes().current();
    // The set is added at the end, since it may name others, which setOf() would move.
    std::vector<Index> members;
    if (const std::string_view elements = keyword.nameIn("elset"); isOfNodes && !elements.empty())
        return;  // The nodes of a set of elements, which is a group of its own.
    while (auto line = file.nextData()) {
        const std::size_t before = members.size();
        if (keyword.parameter("generate")) {
            const std::int64_t first = file.integer(takeAbaqusEntry(*line), "the first number");
            const auto end = takeAbaqusEntry(*line);
            const std::int64_t last = end ? file.integer(end, "the last number") : first;
            const auto between = takeAbaqusEntry(*line);
            const std::int64_t step =
                between && !between->empty() ? file.integer(between, "the step") : 1;
            if (step < 1) file.fail(concat("the step of a set is ", step, "; expected at least 1"));
            const auto& ofKind = isOfNodes ? numbers_.nodes : numbers_.elements;
            ofKind[scope].forEachBetween(first, last, step,
                                         [&](Index member) { members.push_back(member); });
        } else {
            while (const auto entry = takeAbaqusEntry(*line))
                addMembers(members, isOfNodes, own, scope, *entry);
        }
        countMembers(file, members.size() - before);
    }
    Set& set = setOf(isOfNodes ? nodeSets_ : elementSets_, own, name, isInternal);
    set.members.insert(set.members.end(), members.begin(), members.end());
    sortUnique(set.members);
}

void AbaqusSets::readSurface(AbaqusFile& file) {
    const AbaqusKeyword keyword = file.keyword();
    const std::string_view name = keyword.nameIn("name");
    const std::string type = lowerCase(keyword.parameter("type").value_or("element"));
    // Other types are made of no elements or nodes: of other surfaces, or analytically.
    if (name.empty() || (type != "element" && type != "node") || keyword.parameter("combine"))
        return;
    const std::size_t scope = scopeOf(file), own = file.scopes().current();
    Surface surface{std::string(name)};
    while (auto line = file.nextData()) {
        const std::string_view entry = takeAbaqusEntry(*line).value_or(std::string_view());
        const std::string_view label = takeAbaqusEntry(*line).value_or(std::string_view());
        std::vector<Index> members;
        const bool isOfNodes = type == "node";
        addMembers(members, isOfNodes, own, scope, entry);
        countMembers(file, members.size());
        if (isOfNodes) {
            surface.nodes.insert(surface.nodes.end(), members.begin(), members.end());
        } else if (const auto side = sideOf(label)) {
            for (const Index element : members) surface.sides.emplace_back(element, *side);
        }
    }
    surfaces_.push_back(std::move(surface));
}

bool AbaqusSets::setNames(Index element, std::vector<std::string>& names) {
    if (setsOfElements_[element] == current_) return false;
    current_ = setsOfElements_[element];
    names.clear();
    for (const std::size_t set : current_) names.push_back(elementSets_.all[set].name);
    return true;
}

void AbaqusSets::addElement(Index element, const AbaqusElement& type,
                            std::span<const Index> nodes) {
    elements_[element] = {type.dimension, type.isShell, {nodes.begin(), nodes.end()}};
}

void AbaqusSets::visitSide(Index element, const AbaqusSide& named, CellVisitor& visitor) const {
    const auto& [dimension, isShell, nodes] = elements_[element];
    if (nodes.empty()) return;
    std::size_t side = named.number;
    // CalculiX numbers the two faces of a shell before its edges.
    if (isShell && !named.isEdge) side = side <= 2 ? 0 : side - 2;
    const std::size_t cornerCount = cornersOf(dimension, nodes.size());
    if (side == 0) {
        const std::span<const Index> all(nodes);
        return visitor.groupSide(dimension, all.first(cornerCount), all);
    }
    const Sides& sides = sidesOf(dimension, cornerCount);
    if (side > sides.size()) return;
    std::vector<Index> corners, points;
    far::CornerBits bits = 0;
    for (const std::size_t corner : sides[side - 1]) {
        corners.push_back(nodes[corner]);
        bits |= far::between(corner);
    }
    points = corners;
    if (dimension == 3) {
        const auto places = far::cellPoints(nodes.size());
        for (std::size_t i = cornerCount; i < nodes.size(); ++i)
            if ((places[i] & ~bits) == 0) points.push_back(nodes[i]);
    } else if (nodes.size() >= 2 * cornerCount) {
        points.push_back(nodes[cornerCount + side - 1]);  // in the middle of the edge
    }
    visitor.groupSide(dimension - 1, corners, points);
}

void AbaqusSets::visit(CellVisitor& visitor) const {
    for (const Set& set : nodeSets_.all) {
        if (set.isInternal) continue;
        visitor.beginGroups(std::span(&set.name, 1));
        visitor.groupPoints(0, set.members);
    }
    for (const Surface& surface : surfaces_) {
        visitor.beginGroups(std::span(&surface.name, 1));
        visitor.groupPoints(0, surface.nodes);
        for (const auto& [element, side] : surface.sides) visitSide(element, side, visitor);
    }
    visitor.beginGroups({});
}

}  // namespace espalier::io
