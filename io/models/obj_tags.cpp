// SPDX-License-Identifier: Apache-2.0
#include <espalier/base/error.h>
#include <espalier/far/marks.h>
#include <espalier/io/files/file.h>

#include <algorithm>
#include <cmath>

#include "../lattices/lattice_parts.h"
#include "obj_tags.h"

namespace espalier::io {

namespace {

/// How many whole numbers, numbers and strings a tag has.
struct Counts {
    std::uint64_t ints = 0, floats = 0, strings = 0;

    std::uint64_t sum() const { return ints + floats + strings; }
    friend bool operator==(const Counts&, const Counts&) = default;
};

/// Whether `marks` marks have one sharpness each, or one for all.
bool fitMarks(const Counts& counts, std::uint64_t marks) {
    return marks > 0 && (counts.floats == 1 || counts.floats == marks) && counts.strings == 0;
}

// The counts that the kinds of tags may have.
bool areOfEdges(const Counts& counts) {
    return counts.ints % 2 == 0 && fitMarks(counts, counts.ints / 2);
}
bool areOfVertices(const Counts& counts) {
    return fitMarks(counts, counts.ints);
}
bool areOfFaces(const Counts& counts) {
    return counts.ints > 0 && counts == Counts{counts.ints, 0, 0};
}
bool areOneInt(const Counts& counts) {
    return counts == Counts{1, 0, 0};
}
bool areOneString(const Counts& counts) {
    return counts == Counts{0, 0, 1};
}

/// Reads "2/1/0".
bool parseCounts(std::string_view word, Counts& counts) {
    std::uint32_t parts[3] = {};
    for (std::size_t i = 0; i < 3; ++i) {
        const std::size_t end = i < 2 ? word.find('/') : word.size();
        if (end == std::string_view::npos || !parseNumber(word.substr(0, end), parts[i]))
            return false;
        word.remove_prefix(std::min(end + 1, word.size()));
    }
    counts = {parts[0], parts[1], parts[2]};
    return true;
}

/// A sharpness as it is stored, so that what is written reads back the same; 0 if it is negative.
bool parseSharpness(std::string_view word, double& sharpness) {
    if (!parseNumber(word, sharpness) || std::isnan(sharpness)) return false;
    // By way of a double it could be rounded twice. What is no float is huge.
    if (float single = 0; parseNumber(word, single)) sharpness = single;
    sharpness = far::storedSharpness(std::max(sharpness, 0.0));
    return true;
}

}  // namespace

/// A tag cut up by its counts.
struct ObjTags::Tag {
    std::size_t line;
    std::vector<std::int64_t> ints;
    std::vector<double> sharpness;
    std::vector<std::string_view> strings;

    /// Of mark i: there is one sharpness for each, or one for all.
    double sharpnessOf(std::size_t i) const { return sharpness[sharpness.size() > 1 ? i : 0]; }
};

struct ObjTags::Kind {
    std::string_view name;
    const char* counts;  ///< what they may be, for messages
    bool (*fits)(const Counts&);
    void (ObjTags::*take)(const Tag&);
};

void ObjTags::add(ObjWords& words, std::size_t line) {
    static constexpr Kind kKinds[] = {
        {"crease", "2k/1/0 or 2k/k/0 for k edges", areOfEdges, &ObjTags::addCreases},
        {"corner", "k/1/0 or k/k/0 for k vertices", areOfVertices, &ObjTags::addCorners},
        {"hole", "k/0/0 for k faces", areOfFaces, &ObjTags::addHoles},
        {"interpolateboundary", "1/0/0", areOneInt, &ObjTags::setBoundary},
        {"creasemethod", "0/0/1", areOneString, &ObjTags::setCreasing},
        {"smoothtriangles", "0/0/1", areOneString, &ObjTags::setTriangles}};
    const std::string_view name = words.next();
    if (name.empty()) throw FileError(path_, line, "the line ends; expected the name of a tag");
    for (const Kind& kind : kKinds)
        if (kind.name == name) (this->*kind.take)(parse(kind, words, line));
}

ObjTags::Tag ObjTags::parse(const Kind& kind, ObjWords& words, std::size_t line) const {
    const auto fail = [&](const std::string& cause) {
        throw FileError(path_, line, "the tag " + std::string(kind.name) + cause);
    };
    const std::string_view countsWord = words.next();
    Counts counts;
    if (!parseCounts(countsWord, counts) || !kind.fits(counts))
        fail(" has counts " + inQuotes(countsWord) + "; expected " + kind.counts);

    // No memory is taken for what is only claimed.
    Tag tag{line, {}, {}, {}};
    for (std::uint64_t i = 0; i < counts.sum(); ++i) {
        const std::string_view word = words.next();
        if (word.empty()) fail(concat(" ends after ", i, " words; expected ", counts.sum()));
        if (i < counts.ints) {
            if (!parseNumber(word, tag.ints.emplace_back()))
                fail(" has " + inQuotes(word) + "; expected a whole number");
        } else if (i < counts.ints + counts.floats) {
            if (!parseSharpness(word, tag.sharpness.emplace_back()))
                fail(" has " + inQuotes(word) + "; expected a sharpness");
        } else {
            tag.strings.push_back(word);
        }
    }
    if (const std::string_view word = words.next(); !word.empty())
        fail(concat(" goes on with ", inQuotes(word), " after ", counts.sum(),
                    " words; expected no more"));
    return tag;
}

void ObjTags::addCreases(const Tag& tag) {
    for (std::size_t i = 0; i < tag.ints.size() / 2; ++i)
        creases_.push_back({tag.line, {tag.ints[2 * i], tag.ints[2 * i + 1]}, tag.sharpnessOf(i)});
}

void ObjTags::addCorners(const Tag& tag) {
    for (std::size_t i = 0; i < tag.ints.size(); ++i)
        corners_.push_back({tag.line, {tag.ints[i]}, tag.sharpnessOf(i)});
}

void ObjTags::addHoles(const Tag& tag) {
    for (const std::int64_t face : tag.ints)
        holes_.push_back({tag.line, {face}, far::kInfinitelySharp});
}

void ObjTags::setBoundary(const Tag& tag) {
    switch (tag.ints[0]) {
        case 0:
            refinement_.boundary = far::Boundary::Open;
            break;
        case 1:
            refinement_.boundary = far::Boundary::Sharp;
            break;
        case 2:
            refinement_.boundary = far::Boundary::EdgeOnly;
            break;
        default:
            throw FileError(
                path_, tag.line,
                concat("the tag interpolateboundary is ", tag.ints[0], "; expected 0, 1 or 2"));
    }
}

void ObjTags::setCreasing(const Tag& tag) {
    if (tag.strings[0] == "normal")
        refinement_.creasing = far::Creasing::Uniform;
    else if (tag.strings[0] == "chaikin")
        refinement_.creasing = far::Creasing::Chaikin;
    else
        throw FileError(
            path_, tag.line,
            "the tag creasemethod is " + inQuotes(tag.strings[0]) + "; expected normal or chaikin");
}

void ObjTags::setTriangles(const Tag& tag) {
    if (tag.strings[0] == "catmark")
        refinement_.triangles = far::TriangleSubdivision::Catmark;
    else if (tag.strings[0] == "smooth")
        refinement_.triangles = far::TriangleSubdivision::Smooth;
    else
        throw FileError(path_, tag.line,
                        "the tag smoothtriangles is " + inQuotes(tag.strings[0]) +
                            "; expected catmark or smooth");
}

Index ObjTags::checkedNumber(std::int64_t number, Index count, const char* what,
                             std::size_t line) const {
    if (number < 0 || number >= count)
        throw FileError(
            path_, line,
            concat("a tag names ", what, " ", number,
                   count == 0 ? "; there are none" : concat("; expected 0 to ", count - 1)));
    return static_cast<Index>(number);
}

far::Marks ObjTags::marks(const far::CellComplex& mesh, std::span<const Index> dropped) const {
    const Index vertexCount = mesh.count(0) + static_cast<Index>(dropped.size());
    const auto vertexOf = [&](std::int64_t number, std::size_t line) {
        return numberWithout(dropped, checkedNumber(number, vertexCount, "vertex", line));
    };
    far::Marks marks;
    for (const auto& crease : creases_) {
        const auto a = vertexOf(crease.numbers[0], crease.line);
        const auto b = vertexOf(crease.numbers[1], crease.line);
        if (!a || !b || !isEdge(mesh, *a, *b))
            throw FileError(path_, crease.line,
                            concat("a tag names edge (", crease.numbers[0], ", ", crease.numbers[1],
                                   "); expected two neighbouring vertices of a face"));
        marks.edges.push_back({{*a, *b}, crease.sharpness});
    }
    for (const auto& corner : corners_)
        if (const auto vertex = vertexOf(corner.numbers[0], corner.line))
            marks.vertices.push_back({*vertex, corner.sharpness});
    for (const auto& hole : holes_)
        marks.holes.push_back(checkedNumber(hole.numbers[0], mesh.count(2), "face", hole.line));

    // After the later of two marks has won: a sharpness of 0 takes an earlier one back.
    marks = canonicalMarks(mesh, marks);
    const auto isSmooth = [](const auto& mark) { return mark.sharpness == far::kSmooth; };
    std::erase_if(marks.edges, isSmooth);
    std::erase_if(marks.vertices, isSmooth);
    return marks;
}

}  // namespace espalier::io
