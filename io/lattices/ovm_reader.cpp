// SPDX-License-Identifier: Apache-2.0
#include <espalier/base/error.h>
#include <espalier/far/topology_error.h>
#include <espalier/io/files/file.h>
#include <espalier/io/files/text_reader.h>
#include <espalier/io/lattices/ovm.h>

#include <algorithm>
#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <utility>

#include "../files/number_types.h"
#include "lattice_parts.h"

namespace espalier::io {

namespace {

using Loop = std::vector<Index>;

/// A type of vertex properties that become attributes.
struct PropertyType {
    std::string_view name;
    int components;
    NumberType number;
};

constexpr PropertyType kPropertyTypes[] = {
    {"int", 1, NumberType::Int32},      {"short", 1, NumberType::Int16},
    {"uint", 1, NumberType::UInt32},    {"long", 1, NumberType::Int64},
    {"ulong", 1, NumberType::UInt64},   {"float", 1, NumberType::Float32},
    {"double", 1, NumberType::Float64}, {"vec2f", 2, NumberType::Float32},
    {"vec3f", 3, NumberType::Float32},  {"vec4f", 4, NumberType::Float32},
    {"vec2d", 2, NumberType::Float64},  {"vec3d", 3, NumberType::Float64},
    {"vec4d", 4, NumberType::Float64}};

constexpr std::string_view kVectorOfDoubles = "vector_double";

/// First words of the line that opens a property.
constexpr std::string_view kPropertyKinds[] = {"vprop", "eprop",           "heprop",
                                               "fprop", "hfprop",          "cprop",
                                               "mprop", "vertex_property", "edge_property"};

/// \param word in lower case
bool isPropertyKind(std::string_view word) {
    return std::find(std::begin(kPropertyKinds), std::end(kPropertyKinds), word) !=
           std::end(kPropertyKinds);
}

class OvmReader {
public:
    OvmReader(const std::filesystem::path& path, std::string_view bytes)
        : path_(path), text_(path, bytes) {
        text_.skipComments('#');
    }

    Lattice read(ReadNotes* notes) {
        readHeader();
        readVertices();
        readEdges();
        readFaces();
        far::ComplexBuilder builder(3, static_cast<Index>(lattice_.positions.size()));
        readPolyhedra(builder);
        while (!nextProperty_.empty() || !text_.atEnd()) readProperty();
        if (notes) notes->others = unused_;
        return finishLattice(path_, std::move(builder), std::move(lattice_), notes);
    }

private:
    void readHeader() {
        std::string word = lowerCase(text_.token("OVM"));
        if (word == "ovm") {
            word = lowerCase(text_.token("ASCII"));
            if (word != "ascii" && word != "vertices")
                text_.fail("is an OVM file of kind " + inQuotes(word) + "; only ASCII can be read");
            if (word == "ascii") word = lowerCase(text_.token("Vertices"));
        }
        // OpenVolumeMesh does not require the first line, and some programs omit it, or "ASCII".
        if (word != "vertices")
            text_.fail("is not an OVM file: expected Vertices, got " + inQuotes(word));
    }

    std::size_t beginSection(const char* name, std::size_t minBytes) {
        const std::string word(text_.token(name));
        if (lowerCase(word) != lowerCase(name))
            text_.fail(std::string("expected ") + name + ", got " + inQuotes(word));
        const std::size_t count = text_.count("the number of entries", minBytes);
        checkedIndex(path_, count, name);
        return count;
    }

    void readVertices() {
        const std::size_t count = text_.count("the number of vertices", 6);
        checkedIndex(path_, count, "vertices");
        lattice_.positions.resize(count);
        for (Point3& position : lattice_.positions)
            for (double& coordinate : position) coordinate = text_.number<double>("a coordinate");
    }

    /// Reads a number below `count`.
    std::size_t readIndex(std::size_t count, const char* what) {
        const auto index = text_.number<std::uint64_t>(what);
        if (index >= count) text_.fail(concat(what, " is ", index, "; there are ", count));
        return index;
    }

    void readEdges() {
        edges_.resize(beginSection("Edges", 4));
        for (auto& edge : edges_)
            for (Index& end : edge)
                end =
                    static_cast<Index>(readIndex(lattice_.positions.size(), "a vertex of an edge"));
        isEdgeUsed_.assign(edges_.size(), false);
    }

    void readFaces() {
        faces_.resize(beginSection("Faces", 2));
        for (std::size_t face = 0; face < faces_.size(); ++face) {
            const std::size_t valence = text_.count("the number of edges of a face", 2);
            Index firstTail = 0;
            Index before = 0;
            for (std::size_t i = 0; i < valence; ++i) {
                const std::size_t halfEdge = readIndex(2 * edges_.size(), "a half-edge");
                isEdgeUsed_[halfEdge / 2] = true;
                const Index tail = edges_[halfEdge / 2][halfEdge % 2];
                if (i == 0)
                    firstTail = tail;
                else if (tail != before)
                    failAtLoop(face);
                before = edges_[halfEdge / 2][1 - halfEdge % 2];
                faces_[face].push_back(tail);
            }
            if (before != firstTail) failAtLoop(face);
        }
        noteUnused(isEdgeUsed_, {"edge", "edges"}, "face");
        isFaceUsed_.assign(faces_.size(), false);
    }

    [[noreturn]] void failAtLoop(std::size_t face) {
        text_.fail(concat("the half-edges of face ", face, " do not form a loop"));
    }

    void readPolyhedra(far::ComplexBuilder& builder) {
        cellCount_ = beginSection("Polyhedra", 2);
        std::vector<Loop> loops;
        for (std::size_t cell = 0; cell < cellCount_; ++cell) {
            loops.resize(text_.count("the number of faces of a polyhedron", 2));
            for (Loop& loop : loops) {
                const std::size_t halfFace = readIndex(2 * faces_.size(), "a half-face");
                isFaceUsed_[halfFace / 2] = true;
                loop = faces_[halfFace / 2];
                // Half-faces run anticlockwise from inside; the builder takes loops from outside.
                if (halfFace % 2 == 0) std::reverse(loop.begin(), loop.end());
            }
            withPathInErrors(path_, [&] { return builder.addCell(loops); });
        }
        noteUnused(isFaceUsed_, {"face", "faces"}, "polyhedron");
    }

    /// Notes edges or faces that nothing uses: the lattice lacks them.
    /// \param names singular and plural
    void noteUnused(const std::vector<bool>& isUsed, const std::array<const char*, 2>& names,
                    const char* user) {
        const auto count = std::ranges::count(isUsed, false);
        if (count == 0) return;
        const auto first = std::ranges::find(isUsed, false) - isUsed.begin();
        unused_.push_back(concat("dropped ", count, " ", names[count > 1], " of no ", user,
                                 count > 1 ? " (the first is " : " (", names[0], " ", first, ")"));
    }

    void readProperty() {
        std::string kind = std::exchange(nextProperty_, {});
        if (kind.empty()) kind = lowerCase(text_.token("a property"));
        if (!isPropertyKind(kind)) text_.fail("expected a property, got " + inQuotes(kind));
        const std::string type = lowerCase(text_.token("the type of a property"));
        const std::string_view rest = text_.restOfLine();
        const std::size_t open = rest.find('"');
        const std::size_t close = rest.rfind('"');
        if (open == std::string_view::npos || open == close)
            text_.fail("a property has no name in quotes");
        const std::string name(rest.substr(open + 1, close - open - 1));
        const bool isOfVertices = kind == "vprop" || kind == "vertex_property";
        const bool isOfEdges = kind == "eprop" || kind == "edge_property";
        if (isOfVertices && name == kVertexSharpness && type == "double")
            lattice_.marks.vertices = vertexMarksFromFile(
                path_, readValues(lattice_.positions.size(), 1, NumberType::Float64));
        else if (isOfEdges && name == kEdgeSharpness && type == "double")
            readEdgeMarks();
        else if (isOfVertices && type == kVectorOfDoubles)
            readVectors(name);
        else if (const PropertyType* known = isOfVertices ? find(type) : nullptr)
            readAttribute(name, *known);
        else
            skipProperty(kind, type);
    }

    void readAttribute(const std::string& name, const PropertyType& type) {
        const std::size_t components = type.components;
        if (isInteger(type.number))
            lattice_.integers.push_back(
                {name, type.components, integerTypeOf(type.number),
                 readValues<std::int64_t>(lattice_.positions.size(), components, type.number)});
        else
            lattice_.attributes.push_back(
                {name, type.components,
                 readValues(lattice_.positions.size(), components, type.number)});
    }

    static const PropertyType* find(std::string_view name) {
        for (const PropertyType& type : kPropertyTypes)
            if (type.name == name) return &type;
        return nullptr;
    }

    template <class Value = double>
    std::vector<Value> readValues(std::size_t rows, std::size_t components, NumberType type) {
        const std::size_t count = saturatingProduct(rows, components);
        text_.checkRoom(count, 2, "the number of values of a property");
        std::vector<Value> values;
        values.reserve(count);
        for (std::size_t i = 0; i < count; ++i)
            values.push_back(readNumber<Value>(text_, type, "a value of a property"));
        return values;
    }

    void readEdgeMarks() {
        const std::vector<double> sharpness = readValues(edges_.size(), 1, NumberType::Float64);
        for (std::size_t edge = 0; edge < edges_.size(); ++edge)
            if (isMarkInFile(path_, kEdgeSharpness, edge, sharpness[edge]))
                lattice_.marks.edges.push_back({edges_[edge], sharpnessFromFile(sharpness[edge])});
    }

    /// Reads vectors, each preceded by its length. They become an attribute if all lengths are
    /// equal.
    void readVectors(const std::string& name) {
        std::vector<double> values;
        std::optional<std::size_t> length;
        bool haveOneLength = true;
        for (std::size_t vertex = 0; vertex < lattice_.positions.size(); ++vertex) {
            const std::size_t size = text_.count("the length of a vector", 2);
            haveOneLength = haveOneLength && size == length.value_or(size);
            length = size;
            for (std::size_t i = 0; i < size; ++i)
                values.push_back(text_.number<double>("a value of a property"));
        }
        if (haveOneLength && length.value_or(0) > 0)
            lattice_.attributes.push_back(
                {name, checkedIndex(path_, *length, "components"), std::move(values)});
    }

    void skipProperty(std::string_view kind, std::string_view type) {
        if (type == "string") {
            skipStrings(kind);
            return;
        }
        // Values of other types never look like the first word of a property.
        while (nextProperty_.empty() && !text_.atEnd()) {
            const std::string word = lowerCase(text_.token("a value of a property"));
            if (isPropertyKind(word))
                nextProperty_ = word;
            else
                text_.restOfLine();
        }
    }

    /// Skips strings. Each is written as its length, a colon and that number of arbitrary
    /// characters.
    void skipStrings(std::string_view kind) {
        for (std::size_t i = 0; i < countOf(kind); ++i) {
            text_.atEnd();
            std::size_t length = 0;
            for (char c = nextByte(); c != ':'; c = nextByte()) {
                if (c < '0' || c > '9' || length > text_.remaining())
                    text_.fail("a string does not begin with its length and a colon");
                length = 10 * length + (c - '0');
            }
            text_.bytes(length, "a string");
        }
    }

    char nextByte() { return text_.bytes(1, "a string")[0]; }

    std::size_t countOf(std::string_view kind) const {
        if (kind == "vprop" || kind == "vertex_property") return lattice_.positions.size();
        if (kind == "eprop" || kind == "edge_property") return edges_.size();
        if (kind == "heprop") return 2 * edges_.size();
        if (kind == "fprop") return faces_.size();
        if (kind == "hfprop") return 2 * faces_.size();
        return kind == "cprop" ? cellCount_ : 1;
    }

    std::filesystem::path path_;
    TextReader text_;
    std::vector<std::array<Index, 2>> edges_;
    std::vector<Loop> faces_;
    std::vector<bool> isEdgeUsed_;
    std::vector<bool> isFaceUsed_;
    std::vector<std::string> unused_;  ///< notes on edges and faces that nothing uses
    std::size_t cellCount_ = 0;
    std::string nextProperty_;  ///< first word of the next property, if it has been read already
    Lattice lattice_;           ///< the lattice without its complex
};

}  // namespace

Lattice readOvm(const std::filesystem::path& path, std::string_view bytes, ReadNotes* notes) {
    return OvmReader(path, bytes).read(notes);
}

}  // namespace espalier::io
