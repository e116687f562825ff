// SPDX-License-Identifier: Apache-2.0
#include "cgns_conditions.h"

#include <espalier/base/error.h>
#include <espalier/base/progress.h>
#include <espalier/base/sort_unique.h>

#include <algorithm>
#include <array>
#include <limits>
#include <optional>
#include <set>
#include <utility>

namespace espalier::io {
namespace {

using Place = CgnsCondition::Place;

/// The longest path of a family, in a base with families of families.
constexpr std::size_t kLongestFamily = 1024;

/// Returns the word for a type; empty if it says nothing.
std::string typeName(CGNS_ENUMT(BCType_t) type) {
    if (type < 0 || type >= NofValidBCTypes || type == CGNS_ENUMV(BCTypeNull) ||
        type == CGNS_ENUMV(BCTypeUserDefined) || type == CGNS_ENUMV(FamilySpecified))
        return {};
    return BCTypeName[type];
}

/// Returns the type of the conditions of a family.
std::string typeOfFamily(const ZoneFile& file, int base, const std::string& family) {
    int count = 0;
    file.check(cg_nfamilies(file.number(), base, &count));
    for (int number = 1; number <= count; ++number) {
        std::array<char, kLongestFamily> name{}, condition{};
        int conditions = 0, geometries = 0;
        file.check(
            cg_family_read(file.number(), base, number, name.data(), &conditions, &geometries));
        if (name.data() != family || conditions == 0) continue;
        CGNS_ENUMT(BCType_t) type{};
        file.check(cg_fambc_read(file.number(), base, number, 1, condition.data(), &type));
        return typeName(type);
    }
    return {};
}

/// Reads one boundary condition; nothing if its points are at cells of a structured zone.
std::optional<CgnsCondition> readCondition(const ZoneFile& file, const Zone& zone, int number) {
    std::array<char, 33> name{};
    CGNS_ENUMT(BCType_t) type{};
    CGNS_ENUMT(PointSetType_t) set{};
    CGNS_ENUMT(GridLocation_t) location{};
    CGNS_ENUMT(DataType_t) normalType{};
    cgsize_t count = 0, normalSize = 0;
    std::array<int, 3> normalIndex{};
    int dataSets = 0;
    file.check(cg_boco_info(file.number(), zone.base, zone.number, number, name.data(), &type, &set,
                            &count, normalIndex.data(), &normalSize, &normalType, &dataSets));
    file.check(cg_boco_gridlocation_read(file.number(), zone.base, zone.number, number, &location));
    CgnsCondition condition{name.data(), typeName(type)};
    condition.isRange = set == CGNS_ENUMV(PointRange) || set == CGNS_ENUMV(ElementRange);
    const bool hasElements = set == CGNS_ENUMV(ElementRange) || set == CGNS_ENUMV(ElementList);
    switch (location) {
        case CGNS_ENUMV(Vertex):
            condition.place = hasElements ? Place::Elements : Place::Vertices;
            break;
        case CGNS_ENUMV(IFaceCenter):
        case CGNS_ENUMV(JFaceCenter):
        case CGNS_ENUMV(KFaceCenter):
            condition.axis = location == CGNS_ENUMV(IFaceCenter)   ? 0
                             : location == CGNS_ENUMV(JFaceCenter) ? 1
                                                                   : 2;
            condition.place = Place::Faces;
            break;
        case CGNS_ENUMV(FaceCenter):
        case CGNS_ENUMV(EdgeCenter):
            condition.place = zone.isStructured ? Place::Faces : Place::Elements;
            break;
        default:
            if (zone.isStructured) return std::nullopt;
            condition.place = Place::Elements;
    }
    if (zone.isStructured && condition.place == Place::Elements) return std::nullopt;

    std::array<char, 33> baseName{};
    int cellDimension = 0, spaceDimension = 0;
    file.check(
        cg_base_read(file.number(), zone.base, baseName.data(), &cellDimension, &spaceDimension));
    condition.dimension = std::clamp(cellDimension - 1, 1, 2);
    const std::string what = concat("the boundary condition '", name.data(), "'");
    const std::size_t axes = zone.isStructured ? zone.extent.size() : 1;
    file.requireRoom(saturatingProduct<std::uint64_t>(count, axes), what);
    if (count < 0 || (condition.isRange && count != 2))
        file.fail(concat(what, " has ", count, " points"));
    condition.numbers.resize(static_cast<std::size_t>(count) * axes);
    if (!condition.numbers.empty())
        file.check(cg_boco_read(file.number(), zone.base, zone.number, number,
                                condition.numbers.data(), nullptr));
    for (const cgsize_t each : condition.numbers)
        if (each < 1)
            file.fail(concat(what, " names point or element ", each, "; expected 1 or more"));

    std::array<char, kLongestFamily> family{};
    file.check(cg_goto(file.number(), zone.base, "Zone_t", zone.number, "ZoneBC_t", 1, "BC_t",
                       number, "end"));
    if (cg_famname_read(family.data()) == CG_OK) {
        condition.name = family.data();
        if (condition.type.empty()) condition.type = typeOfFamily(file, zone.base, condition.name);
    }
    return condition;
}

}  // namespace

std::vector<CgnsCondition> readConditions(const ZoneFile& file, const Zone& zone) {
    int count = 0;
    file.check(cg_nbocos(file.number(), zone.base, zone.number, &count));
    std::vector<CgnsCondition> conditions;
    for (int number = 1; number <= count; ++number)
        if (auto condition = readCondition(file, zone, number))
            conditions.push_back(std::move(*condition));
    return conditions;
}

void visitGridConditions(const ZoneFile& file, const Zone& zone,
                         const std::vector<CgnsCondition>& conditions, CellVisitor& visitor) {
    using Triple = std::array<std::size_t, 3>;
    const std::size_t axes = std::min<std::size_t>(3, zone.extent.size());
    Triple size = {1, 1, 1};
    for (std::size_t axis = 0; axis < axes; ++axis) size[axis] = zone.extent[axis];
    const auto at = [&](const Triple& place) {
        return static_cast<Index>(zone.firstPoint + place[0] +
                                  size[0] * (place[1] + size[1] * place[2]));
    };
    for (const CgnsCondition& condition : conditions) {
        visitor.beginGroups(std::span(&condition.name, 1));
        /// Returns the place of a point, counted from 0.
        const auto placeOf = [&](std::size_t point) {
            Triple place = {};
            for (std::size_t axis = 0; axis < axes; ++axis) {
                const auto number =
                    static_cast<std::size_t>(condition.numbers[point * zone.extent.size() + axis]);
                if (number > size[axis])
                    file.fail(concat("the boundary condition '", condition.name, "' names point ",
                                     number, " along an axis of ", size[axis], " points"));
                place[axis] = number - 1;
            }
            return place;
        };
        /// Passes the face that begins at a place, across an axis.
        const auto visitFace = [&](const Triple& place, std::size_t across) {
            const std::size_t u = (across + 1) % 3, v = (across + 2) % 3;
            if (axes < 3) {
                // The other axis of the plane.
                Triple end = place;
                ++end[1 - std::min<std::size_t>(across, 1)];
                if (end[0] < size[0] && end[1] < size[1]) {
                    const std::array ends = {at(place), at(end)};
                    visitor.groupSide(1, ends, ends);
                }
                return;
            }
            if (place[u] + 1 >= size[u] || place[v] + 1 >= size[v]) return;
            std::array<Triple, 4> corners = {place, place, place, place};
            ++corners[1][u];
            ++corners[2][u], ++corners[2][v];
            ++corners[3][v];
            const std::array face = {at(corners[0]), at(corners[1]), at(corners[2]),
                                     at(corners[3])};
            visitor.groupSide(2, face, face);
        };
        /// Returns the axis across the faces of a range: one with a single layer, at an end of the
        /// grid if there are several.
        const auto acrossOf = [&](const Triple& low, const Triple& high) {
            std::optional<std::size_t> across = condition.axis;
            for (const auto isLayer :
                 {+[](std::size_t layer, std::size_t count) { return layer + 1 == count; },
                  +[](std::size_t layer, std::size_t) { return layer == 0; },
                  +[](std::size_t, std::size_t) { return true; }})
                for (std::size_t axis = 0; axis < axes && !across; ++axis)
                    if (low[axis] == high[axis] && size[axis] > 1 && isLayer(low[axis], size[axis]))
                        across = axis;
            return across;
        };
        if (!condition.isRange) {
            for (std::size_t point = 0; point < condition.numbers.size() / zone.extent.size();
                 ++point) {
                checkCancelledEvery(point, 12);
                if (condition.place == Place::Vertices)
                    visitor.groupPoints(condition.dimension, std::array{at(placeOf(point))});
                else if (const auto across = acrossOf(placeOf(point), placeOf(point)))
                    visitFace(placeOf(point), *across);
            }
            continue;
        }
        Triple low = placeOf(0), high = placeOf(1);
        for (std::size_t axis = 0; axis < axes; ++axis)
            if (low[axis] > high[axis]) std::swap(low[axis], high[axis]);
        const auto across = acrossOf(low, high);
        const bool hasVertices = condition.place == Place::Vertices;
        std::size_t count = 0;
        Triple place;
        for (place[2] = low[2]; place[2] <= high[2]; ++place[2])
            for (place[1] = low[1]; place[1] <= high[1]; ++place[1])
                for (place[0] = low[0]; place[0] <= high[0]; ++place[0]) {
                    checkCancelledEvery(count++, 12);
                    if (hasVertices)
                        visitor.groupPoints(condition.dimension, std::array{at(place)});
                    // The last vertices along an axis begin no face.
                    const auto isLast = [&](std::size_t axis) {
                        return hasVertices && axis != across && place[axis] == high[axis];
                    };
                    if (across && axes == 3 && !isLast(0) && !isLast(1) && !isLast(2))
                        visitFace(place, *across);
                    else if (across && !hasVertices)
                        visitFace(place, *across);
                }
    }
}

ElementConditions::ElementConditions(const ZoneFile& file,
                                     const std::vector<CgnsCondition>& conditions)
    : conditions_(conditions) {
    /// Where a condition begins, or ends.
    struct Event {
        cgsize_t element;
        std::size_t condition;
        bool begins;
    };
    std::vector<Event> events;
    const auto add = [&](std::size_t condition, cgsize_t first, cgsize_t last) {
        events.push_back({first, condition, true});
        if (last < std::numeric_limits<cgsize_t>::max())
            events.push_back({last + 1, condition, false});
        total_ += static_cast<std::uint64_t>(last - first) + 1;
    };
    for (std::size_t i = 0; i < conditions.size(); ++i) {
        std::vector<cgsize_t> numbers = conditions[i].numbers;
        if (conditions[i].place != Place::Elements || numbers.empty()) continue;
        if (conditions[i].isRange) {
            add(i, std::min(numbers[0], numbers[1]), std::max(numbers[0], numbers[1]));
            continue;
        }
        sortUnique(numbers);
        for (std::size_t begin = 0, end = 0; begin < numbers.size(); begin = end) {
            end = begin + 1;
            while (end < numbers.size() && numbers[end] == numbers[end - 1] + 1) ++end;
            add(i, numbers[begin], numbers[end - 1]);
        }
    }
    std::sort(events.begin(), events.end(), [](const Event& a, const Event& b) {
        return std::pair(a.element, a.begins) < std::pair(b.element, b.begins);
    });
    constexpr std::size_t kMaxConditions = 100;
    std::set<std::size_t> open;
    for (std::size_t i = 0; i < events.size(); ++i) {
        if (events[i].begins)
            open.insert(events[i].condition);
        else
            open.erase(events[i].condition);
        if (open.size() > kMaxConditions)
            file.fail(concat("element ", events[i].element, " has more than ", kMaxConditions,
                             " boundary conditions"));
        if (i + 1 == events.size() || events[i + 1].element != events[i].element)
            changes_.push_back({events[i].element, {open.begin(), open.end()}});
    }
}

bool ElementConditions::goTo(cgsize_t element) {
    const auto next = std::upper_bound(
        changes_.begin(), changes_.end(), element,
        [](cgsize_t number, const Change& change) { return number < change.element; });
    const auto number = static_cast<std::size_t>(next - changes_.begin());
    if (number > 0) visited_ += changes_[number - 1].conditions.size();
    if (number == current_) return false;
    current_ = number;
    names_.clear();
    if (number > 0)
        for (const std::size_t condition : changes_[number - 1].conditions)
            names_.push_back(conditions_[condition].name);
    return true;
}

Index ElementConditions::missing() const {
    const std::uint64_t missing = total_ - std::min(visited_, total_);
    return static_cast<Index>(std::min<std::uint64_t>(missing, kMaxIndex));
}

}  // namespace espalier::io
