// SPDX-License-Identifier: Apache-2.0
#include <espalier/base/error.h>
#include <espalier/far/second_order_cells.h>

#include <algorithm>
#include <array>
#include <map>
#include <numeric>
#include <optional>
#include <span>
#include <utility>
#include <vector>

#include "cgns_elements.h"

namespace espalier::io {
namespace {

/// Brings the points of a cell of second order into VTK's order; MeshCells turns wedges. The
/// places of points in tetrahedra and pyramids are VTK's; in wedges and hexahedra, the edges along
/// the axis come before the edges of the upper end, and faces go around the axis.
std::vector<Index> inVtkOrder(const std::vector<Index>& points) {
    using far::between;
    static constexpr far::CornerBits kWedge[] = {
        between(0),          between(1),          between(2),         between(3),    between(4),
        between(5),          between(0, 1),       between(1, 2),      between(2, 0), between(0, 3),
        between(1, 4),       between(2, 5),       between(3, 4),      between(4, 5), between(5, 3),
        between(0, 1, 4, 3), between(1, 2, 5, 4), between(2, 0, 3, 5)};
    static constexpr far::CornerBits kHexahedron[] = {
        between(0),          between(1),          between(2),
        between(3),          between(4),          between(5),
        between(6),          between(7),          between(0, 1),
        between(1, 2),       between(2, 3),       between(3, 0),
        between(0, 4),       between(1, 5),       between(2, 6),
        between(3, 7),       between(4, 5),       between(5, 6),
        between(6, 7),       between(7, 4),       between(0, 3, 2, 1),
        between(0, 1, 5, 4), between(1, 2, 6, 5), between(2, 3, 7, 6),
        between(0, 4, 7, 3), between(4, 5, 6, 7), between(0, 1, 2, 3, 4, 5, 6, 7)};
    static constexpr std::size_t kCorners[] = {0, 1, 2, 3, 4, 5, 6, 7};
    switch (far::kindOfCell(points.size()).value()) {
        case far::StandardCell::Wedge:
            return far::reorderedCell(points, kWedge, std::span(kCorners).first(6));
        case far::StandardCell::Hexahedron:
            return far::reorderedCell(points, kHexahedron, kCorners);
        default:
            return points;
    }
}

/// Passes the elements of a zone to a visitor.
class ZoneElements {
public:
    ZoneElements(const ZoneFile& file, const Zone& zone,
                 const std::vector<CgnsCondition>& conditions, const std::set<std::string>& names,
                 CellVisitor& visitor)
        : file_(file),
          zone_(zone),
          allConditions_(conditions),
          conditions_(file, conditions),
          names_(names),
          visitor_(visitor) {}

    /// Returns the number of elements of conditions that do not exist.
    Index visit() {
        if (zone_.isStructured) {
            visitGrid();
            visitGridConditions(file_, zone_, allConditions_, visitor_);
            return 0;
        }
        visitSections();
        visitVertices();
        return conditions_.missing();
    }

private:
    struct Section {
        std::string name;
        CGNS_ENUMT(ElementType_t) type;
        std::size_t first, count;
        std::vector<cgsize_t> elements;
        std::vector<cgsize_t>
            ends;  ///< offsets of MIXED, NGON_n and NFACE_n: one more than elements
    };

    void visitGrid() {
        visitor_.beginGroups({});
        std::array<std::size_t, 3> size = {1, 1, 1};
        for (std::size_t axis = 0; axis < std::min<std::size_t>(3, zone_.extent.size()); ++axis)
            size[axis] = zone_.extent[axis];
        const auto at = [&](std::size_t i, std::size_t j, std::size_t k) {
            return static_cast<Index>(zone_.firstPoint + i + size[0] * (j + size[1] * k));
        };
        for (std::size_t j = 0; size[2] == 1 && j + 1 < size[1]; ++j)
            for (std::size_t i = 0; i + 1 < size[0]; ++i)
                visitor_.face(
                    std::array{at(i, j, 0), at(i + 1, j, 0), at(i + 1, j + 1, 0), at(i, j + 1, 0)});
        for (std::size_t k = 0; k + 1 < size[2]; ++k)
            for (std::size_t j = 0; j + 1 < size[1]; ++j)
                for (std::size_t i = 0; i + 1 < size[0]; ++i)
                    visitor_.cell(far::StandardCell::Hexahedron,
                                  std::array{at(i, j, k), at(i + 1, j, k), at(i + 1, j + 1, k),
                                             at(i, j + 1, k), at(i, j, k + 1), at(i + 1, j, k + 1),
                                             at(i + 1, j + 1, k + 1), at(i, j + 1, k + 1)});
    }

    /// Passes the points of conditions that name vertices.
    void visitVertices() {
        for (const CgnsCondition& condition : allConditions_) {
            if (condition.place != CgnsCondition::Place::Vertices) continue;
            visitor_.beginGroups(std::span(&condition.name, 1));
            std::vector<Index> all = points(condition.numbers);
            if (condition.isRange) {
                const Index first = std::min(all[0], all[1]), last = std::max(all[0], all[1]);
                all.resize(static_cast<std::size_t>(last - first) + 1);
                std::iota(all.begin(), all.end(), first);
            }
            visitor_.groupPoints(condition.dimension, all);
        }
    }

    /// Begins the groups of an element: its section, unless a condition has the same name, and its
    /// conditions.
    /// \param isFirst true for the first element of a section
    void beginGroups(const Section& section, std::size_t element, bool isFirst) {
        if (!conditions_.goTo(static_cast<cgsize_t>(section.first + element)) && !isFirst) return;
        groups_.clear();
        if (!names_.contains(section.name)) groups_.push_back(section.name);
        groups_.insert(groups_.end(), conditions_.names().begin(), conditions_.names().end());
        visitor_.beginGroups(groups_);
    }

    void visitSections() {
        const std::vector<Section> sections = readSections();
        const bool hasCellsOfFaces = std::ranges::any_of(
            sections, [](const Section& section) { return section.type == CGNS_ENUMV(NFACE_n); });
        std::map<cgsize_t, std::vector<Index>> loops;  ///< faces by the numbers of their elements
        for (const Section& section : sections) {
            if (section.type != CGNS_ENUMV(NGON_n)) continue;
            for (std::size_t i = 0; i < section.count; ++i) {
                const std::vector<Index> loop = points(rowOf(section, i));
                if (!hasCellsOfFaces) {
                    beginGroups(section, i, i == 0);
                    visitor_.face(loop);
                    continue;
                }
                loops[static_cast<cgsize_t>(section.first + i)] = loop;
                if (conditions_.goTo(static_cast<cgsize_t>(section.first + i)) || i == 0)
                    visitor_.beginGroups(conditions_.names());
                visitor_.groupSide(2, loop, loop);
            }
        }
        for (const Section& section : sections) {
            if (section.type == CGNS_ENUMV(NGON_n)) continue;
            for (std::size_t i = 0; i < section.count; ++i) {
                beginGroups(section, i, i == 0);
                auto row = rowOf(section, i);
                if (section.type == CGNS_ENUMV(NFACE_n)) {
                    visitPolyhedron(row, loops);
                } else if (section.type == CGNS_ENUMV(MIXED)) {
                    if (row.empty()) file_.fail("an element of a MIXED section is empty");
                    visitElement(typeOf(row.front()), row.subspan(1));
                } else {
                    visitElement(section.type, row);
                }
            }
        }
    }

    /// Returns the type of an element of a MIXED section.
    CGNS_ENUMT(ElementType_t) typeOf(cgsize_t number) const {
        if (number < 0 || number >= NofValidElementTypes)
            file_.fail(concat("an element of a MIXED section has the type ", number,
                              "; the types of CGNS are 0 to ", NofValidElementTypes - 1));
        return static_cast<CGNS_ENUMT(ElementType_t)>(number);
    }

    std::vector<Section> readSections() const {
        const int number = file_.number();
        int count = 0;
        file_.check(cg_nsections(number, zone_.base, zone_.number, &count));
        std::vector<Section> sections;
        for (int i = 1; i <= count; ++i) {
            std::array<char, 33> name{};
            cgsize_t start = 0, end = 0, size = 0;
            int boundary = 0, parents = 0;
            Section section{};
            file_.check(cg_section_read(number, zone_.base, zone_.number, i, name.data(),
                                        &section.type, &start, &end, &boundary, &parents));
            file_.check(cg_ElementDataSize(number, zone_.base, zone_.number, i, &size));
            if (const int type = section.type; type < 0 || type >= NofValidElementTypes)
                file_.fail(concat("the section '", name.data(), "' has elements of the type ", type,
                                  "; the types of CGNS are 0 to ", NofValidElementTypes - 1));
            if (end < start || size < 0)
                file_.fail(concat("the section '", name.data(), "' has no elements"));
            section.name = name.data();
            section.first = start;
            section.count = end - section.first + 1;
            const std::string what = concat("the section '", name.data(), "'");
            file_.requireRoom(size, what);
            file_.requireRoom(section.count, what);
            section.elements.resize(size);
            const bool hasOffsets = section.type == CGNS_ENUMV(MIXED) ||
                                    section.type == CGNS_ENUMV(NGON_n) ||
                                    section.type == CGNS_ENUMV(NFACE_n);
            if (hasOffsets) {
                section.ends.resize(section.count + 1);
                file_.check(cg_poly_elements_read(number, zone_.base, zone_.number, i,
                                                  section.elements.data(), section.ends.data(),
                                                  nullptr));
            } else {
                file_.check(cg_elements_read(number, zone_.base, zone_.number, i,
                                             section.elements.data(), nullptr));
            }
            sections.push_back(std::move(section));
        }
        return sections;
    }

    /// Returns the numbers of an element.
    std::span<const cgsize_t> rowOf(const Section& section, std::size_t element) const {
        cgsize_t begin = 0, end = 0;
        if (!section.ends.empty()) {
            begin = section.ends[element];
            end = section.ends[element + 1];
        } else {
            int nodes = 0;
            file_.check(cg_npe(section.type, &nodes));
            begin = static_cast<cgsize_t>(element) * nodes;
            end = begin + nodes;
        }
        if (begin < 0 || end < begin || end > static_cast<cgsize_t>(section.elements.size()))
            file_.fail(concat("element ", section.first + element, " has the numbers ", begin,
                              " to ", end, " of ", section.elements.size()));
        return std::span(section.elements).subspan(begin, end - begin);
    }

    std::vector<Index> points(std::span<const cgsize_t> numbers) const {
        std::vector<Index> points;
        for (const cgsize_t number : numbers) {
            if (number < 1 || number > static_cast<cgsize_t>(zone_.pointCount))
                file_.fail(concat("an element names point ", number, "; there are ",
                                  zone_.pointCount, ", counted from 1"));
            points.push_back(static_cast<Index>(zone_.firstPoint) + static_cast<Index>(number - 1));
        }
        return points;
    }

    void visitPolyhedron(std::span<const cgsize_t> faces,
                         const std::map<cgsize_t, std::vector<Index>>& loops) const {
        std::vector<std::vector<Index>> ofCell;
        for (const cgsize_t signedFace : faces) {
            const auto found = loops.find(std::abs(signedFace));
            if (found == loops.end())
                file_.fail(concat("a cell names face ", std::abs(signedFace),
                                  ", which no NGON_n section has"));
            ofCell.push_back(found->second);
            if (signedFace < 0) std::reverse(ofCell.back().begin(), ofCell.back().end());
        }
        visitor_.polyhedron(ofCell);
    }

    void visitElement(CGNS_ENUMT(ElementType_t) type, std::span<const cgsize_t> numbers) const {
        std::optional<far::StandardCell> kind;
        switch (type) {
            case CGNS_ENUMV(NODE):
                return visitor_.smallCell(0, {});
            case CGNS_ENUMV(BAR_2):
                return visitor_.smallCell(1, points(numbers));
            case CGNS_ENUMV(BAR_3):
                return visitor_.curvedCell(1, points(checkedNumbers(type, numbers)));
            case CGNS_ENUMV(TRI_3):
            case CGNS_ENUMV(QUAD_4):
                return visitor_.face(points(numbers));
            case CGNS_ENUMV(TRI_6):
            case CGNS_ENUMV(QUAD_8):
            case CGNS_ENUMV(QUAD_9):
                return visitor_.curvedCell(2, points(checkedNumbers(type, numbers)));
            case CGNS_ENUMV(TETRA_10):
            case CGNS_ENUMV(PYRA_13):
            case CGNS_ENUMV(PYRA_14):
            case CGNS_ENUMV(PENTA_15):
            case CGNS_ENUMV(PENTA_18):
            case CGNS_ENUMV(HEXA_20):
            case CGNS_ENUMV(HEXA_27):
                return visitor_.curvedCell(3, inVtkOrder(points(checkedNumbers(type, numbers))));
            case CGNS_ENUMV(TETRA_4):
                kind = far::StandardCell::Tetrahedron;
                break;
            case CGNS_ENUMV(PYRA_5):
                kind = far::StandardCell::Pyramid;
                break;
            case CGNS_ENUMV(PENTA_6):
                kind = far::StandardCell::Wedge;
                break;
            case CGNS_ENUMV(HEXA_8):
                kind = far::StandardCell::Hexahedron;
                break;
            case CGNS_ENUMV(ElementTypeNull):
            case CGNS_ENUMV(ElementTypeUserDefined):
            case CGNS_ENUMV(MIXED):
            case CGNS_ENUMV(NGON_n):
            case CGNS_ENUMV(NFACE_n):
                file_.fail(concat("an element has the type ", ElementTypeName[type],
                                  ", whose points are not known"));
            default:
                return visitor_.curvedCell(dimensionOf(type), {});
        }
        visitor_.cell(*kind, points(checkedNumbers(type, numbers)));
    }

    std::span<const cgsize_t> checkedNumbers(CGNS_ENUMT(ElementType_t) type,
                                             std::span<const cgsize_t> numbers) const {
        int expected = 0;
        file_.check(cg_npe(type, &expected));
        if (std::ssize(numbers) != expected)
            file_.fail(concat("a cell has ", numbers.size(), " points; expected ", expected));
        return numbers;
    }

    static int dimensionOf(CGNS_ENUMT(ElementType_t) type) {
        const std::string_view name = ElementTypeName[type];
        if (name.starts_with("BAR")) return 1;
        return name.starts_with("TRI") || name.starts_with("QUAD") ? 2 : 3;
    }

    const ZoneFile& file_;
    const Zone& zone_;
    const std::vector<CgnsCondition>& allConditions_;
    ElementConditions conditions_;
    const std::set<std::string>& names_;
    CellVisitor& visitor_;
    std::vector<std::string> groups_;  ///< of the current element
};

}  // namespace

Index visitElements(const ZoneFile& file, const Zone& zone,
                    const std::vector<CgnsCondition>& conditions,
                    const std::set<std::string>& names, CellVisitor& visitor) {
    return ZoneElements(file, zone, conditions, names, visitor).visit();
}

}  // namespace espalier::io
