// SPDX-License-Identifier: Apache-2.0
#include <espalier/base/error.h>
#include <espalier/base/progress.h>
#include <espalier/io/files/file.h>
#include <espalier/io/files/text_reader.h>

#include <algorithm>
#include <cstdint>
#include <optional>

#include "../files/bytes.h"
#include "../files/number_types.h"
#include "foam_file.h"

namespace espalier::io {
namespace {

constexpr std::string_view kMarks = "(){};";

bool isMark(char c) {
    return kMarks.find(c) != std::string_view::npos;
}

}  // namespace

FoamFile::FoamFile(const std::filesystem::path& path, std::string_view bytes)
    : path_(&path), bytes_(bytes) {
    readHeader();
}

FoamFile::FoamFile(std::string_view block, std::size_t line, const FoamFile& before)
    : path_(before.path_),
      bytes_(block),
      line_(line),
      className_(before.isCollated() ? before.blockClass_ : before.className_),
      isBinary_(before.isCollated() ? before.hasBinaryBlocks_ : before.isBinary_),
      order_(before.order_),
      labelBytes_(before.labelBytes_),
      scalarBytes_(before.scalarBytes_) {
    skipSpace();
    if (bytes_.substr(position_).starts_with("FoamFile")) readHeader();
}

void FoamFile::readHeader() {
    if (word("FoamFile") != "FoamFile")
        fail("the file does not begin with FoamFile, as files of OpenFOAM do");
    expect("{");
    while (true) {
        const std::string_view key = word("an entry of the header, or }");
        if (key == "}") break;
        std::string value;
        for (std::string_view part = word("a value"); part != ";"; part = word("; after a value"))
            value += (value.empty() ? "" : " ") + std::string(part);
        if (key == "format" || key == "data.format") {
            if (value != "ascii" && value != "binary")
                fail("the format is " + inQuotes(value) + "; expected ascii or binary");
            (key == "format" ? isBinary_ : hasBinaryBlocks_) = value == "binary";
        } else if (key == "class") {
            className_ = value;
        } else if (key == "data.class") {
            blockClass_ = value;
        } else if (key == "arch") {
            const auto has = [&](const char* text) {
                return value.find(text) != std::string::npos;
            };
            order_ = has("MSB") ? std::endian::big : std::endian::little;
            labelBytes_ = has("label=64") ? 8 : 4;
            scalarBytes_ = has("scalar=32") ? 4 : 8;
        }
    }
}

void FoamFile::skipSpace() {
    while (position_ < bytes_.size()) {
        const char c = bytes_[position_];
        if (c == '\n') ++line_;
        if (static_cast<unsigned char>(c) <= ' ') {
            ++position_;
        } else if (bytes_.substr(position_, 2) == "//") {
            position_ = std::min(bytes_.find('\n', position_), bytes_.size());
        } else if (bytes_.substr(position_, 2) == "/*") {
            const std::size_t end = bytes_.find("*/", position_ + 2);
            if (end == std::string_view::npos) fail("a comment /* does not end");
            line_ += std::count(bytes_.begin() + static_cast<std::ptrdiff_t>(position_),
                                bytes_.begin() + static_cast<std::ptrdiff_t>(end), '\n');
            position_ = end + 2;
        } else {
            break;
        }
    }
}

std::string_view FoamFile::word(const char* what) {
    checkCancelledEvery(items_++, 12);
    skipSpace();
    if (position_ == bytes_.size()) fail(concat("the file ends; expected ", what));
    const std::size_t begin = position_;
    if (isMark(bytes_[position_])) return bytes_.substr(position_++, 1);
    if (bytes_[position_] == '"') {
        const std::size_t end = bytes_.find('"', begin + 1);
        if (end == std::string_view::npos) fail("a text in quotation marks does not end");
        position_ = end + 1;
    } else {
        while (position_ < bytes_.size() && static_cast<unsigned char>(bytes_[position_]) > ' ' &&
               !isMark(bytes_[position_]))
            ++position_;
    }
    return bytes_.substr(begin, position_ - begin);
}

void FoamFile::expect(std::string_view mark) {
    const std::string_view got = word(std::string(mark).c_str());
    if (got != mark) fail("expected " + std::string(mark) + ", got " + inQuotes(got));
}

std::size_t FoamFile::count(const char* what, std::size_t minBytes) {
    const std::string_view text = word(what);
    std::uint64_t number = 0;
    if (!parseNumber(text, number)) fail(inQuotes(text) + " is not a number; expected " + what);
    const std::size_t left = bytes_.size() - position_;
    if (number > (left + 1) / minBytes)
        fail(concat(what, " is ", number, ", but only ", left, " bytes are left"));
    return number;
}

Index FoamFile::label(const char* what, Index least) {
    if (!isBinary_) return textLabel(what, least);
    checkCancelledEvery(items_++, 12);
    if (bytes_.size() - position_ < labelBytes_) fail(concat("the file ends; expected ", what));
    const std::int64_t number = labelBytes_ == 4
                                    ? loadNumber<std::int32_t>(bytes_.data() + position_, order_)
                                    : loadNumber<std::int64_t>(bytes_.data() + position_, order_);
    position_ += labelBytes_;
    return checkedLabel(number, what, least);
}

Index FoamFile::textLabel(const char* what, Index least) {
    std::int64_t number = 0;
    const std::string_view text = word(what);
    if (!parseNumber(text, number)) fail(inQuotes(text) + " is not a number; expected " + what);
    return checkedLabel(number, what, least);
}

Index FoamFile::checkedLabel(std::int64_t number, const char* what, Index least) const {
    if (number < least || number > kMaxIndex)
        fail(concat(what, " is ", number, "; expected ", least, " to ", kMaxIndex));
    return static_cast<Index>(number);
}

double FoamFile::scalar(std::size_t axis, std::size_t& offset) {
    if (!isBinary_) {
        const std::string_view text = word("a coordinate");
        offset = text.data() - bytes_.data();
        return parseCoordinate(text, axis, Precision::Double, *path_, line_);
    }
    checkCancelledEvery(items_++, 12);
    if (bytes_.size() - position_ < scalarBytes_) fail("the file ends; expected a coordinate");
    offset = position_;
    position_ += scalarBytes_;
    return loadReal(bytes_, offset, scalarBytes_ == 4 ? Precision::Float : Precision::Double,
                    order_);
}

std::vector<FoamBlock> FoamFile::blocks() {
    std::vector<FoamBlock> blocks;
    while (true) {
        skipSpace();
        if (position_ == bytes_.size()) break;
        FoamBlock block{};
        block.sizeBegin = position_;
        const std::size_t size = count("the number of bytes of a process", 1);
        block.sizeEnd = position_;
        expect("(");
        block.begin = position_;
        block.line = line_;
        const std::size_t left = bytes_.size() - position_;
        if (size >= left)
            fail(concat("the number of bytes of a process is ", size, ", but only ", left,
                        " are left"));
        block.end = position_ += size;
        line_ += std::count(bytes_.begin() + static_cast<std::ptrdiff_t>(block.begin),
                            bytes_.begin() + static_cast<std::ptrdiff_t>(block.end), '\n');
        expect(")");
        blocks.push_back(block);
    }
    if (blocks.empty()) fail("has no blocks of processes");
    return blocks;
}

FileNumbers FoamFile::points() {
    FileNumbers numbers;
    if (isBinary_) {
        numbers.setBinary(order_, scalarBytes_ == 4 ? Precision::Float : Precision::Double);
    }
    const std::size_t size = count("the number of points", isBinary_ ? 3 * scalarBytes_ : 7);
    if (size == 0) return numbers;
    const std::string_view mark = word("( before the points");
    if (mark == "{")
        fail("all points are the same ({...} after their number); a mesh needs different ones");
    if (mark != "(") fail("expected ( before the points, got " + inQuotes(mark));
    numbers.points.resize(size);
    for (std::size_t point = 0; point < size; ++point) {
        if (!isBinary_) expect("(");
        for (std::size_t axis = 0; axis < 3; ++axis)
            numbers.points.values[point][axis] = scalar(axis, numbers.points.offsets[point][axis]);
        if (!isBinary_) expect(")");
    }
    expect(")");
    return numbers;
}

std::vector<Index> FoamFile::labels(const char* what, std::size_t limit, const char* limited,
                                    Index least) {
    const std::string_view text = word("the number of labels");
    std::uint64_t size = 0;
    if (!parseNumber(text, size))
        fail(inQuotes(text) + " is not a number; expected the number of labels");
    if (size == 0) {
        skipSpace();
        if (position_ < bytes_.size() && bytes_[position_] == '(') {
            expect("(");
            expect(")");
        }
        return {};
    }
    if (size > limit) fail(concat("has ", size, " labels, but there are ", limit, " ", limited));
    const std::string_view mark = word("( before labels");
    if (mark == "{") {
        const bool wasBinary = std::exchange(isBinary_, false);
        const Index value = label(what, least);
        isBinary_ = wasBinary;
        expect("}");
        return std::vector<Index>(size, value);
    }
    if (mark != "(") fail("expected ( before labels, got " + inQuotes(mark));
    const std::size_t left = bytes_.size() - position_;
    if (size > (left + 1) / (isBinary_ ? labelBytes_ : 2))
        fail(concat("the number of labels is ", size, ", but only ", left, " bytes are left"));
    std::vector<Index> labels;
    labels.reserve(size);
    for (std::size_t i = 0; i < size; ++i) labels.push_back(label(what, least));
    expect(")");
    return labels;
}

far::Rows<Index> FoamFile::faces() {
    far::Rows<Index> faces;
    if (className_ == "faceCompactList") {
        // Faces of a mesh differ, so their lists have bytes for each number.
        const std::size_t limit = bytes_.size();
        const std::vector<Index> offsets = labels("the begin of a face", limit, "bytes");
        const std::vector<Index> points = labels("a point of a face", limit, "bytes");
        if (offsets.empty()) return faces;
        faces.offsets.clear();
        Index before = 0;
        for (const Index offset : offsets) {
            if (offset < before || offset > std::ssize(points))
                fail(concat("a face begins at ", offset, " after one at ", before, "; there are ",
                            points.size(), " points of faces"));
            faces.offsets.push_back(offset);
            before = offset;
        }
        if (offsets.front() != 0 || before != std::ssize(points))
            fail(concat("the faces have the points ", offsets.front(), " to ", before, " of ",
                        points.size()));
        faces.values.assign(points.begin(), points.end());
        return faces;
    }
    if (isBinary_)
        fail("the class is " + inQuotes(className_) +
             ", which cannot be read in binary; expected faceCompactList: convert the mesh with "
             "foamFormatConvert");
    const std::size_t size = count("the number of faces", 5);
    expect("(");
    for (std::size_t face = 0; face < size; ++face) {
        const std::size_t corners = count("the number of points of a face", 2);
        expect("(");
        for (std::size_t i = 0; i < corners; ++i)
            faces.values.push_back(label("a point of a face"));
        expect(")");
        faces.offsets.push_back(static_cast<Offset>(faces.values.size()));
    }
    expect(")");
    return faces;
}

std::vector<FoamPatch> FoamFile::patches() {
    const std::size_t patchCount = count("the number of patches", 2);
    std::vector<FoamPatch> patches(patchCount);
    expect("(");
    for (FoamPatch& patch : patches) {
        patch.name = text("the name of a patch");
        expect("{");
        std::optional<Index> faceCount, startFace;
        while (true) {
            const std::string key(word("a keyword of a patch"));
            if (key == "}") break;
            if (key.starts_with('#') || key.starts_with('$'))
                fail(concat("the patch ", inQuotes(patch.name), " has ", inQuotes(key),
                            ", which cannot be read; write the file without macros"));
            if (key == "nFaces") {
                faceCount = textLabel("the number of faces of a patch");
                expect(";");
            } else if (key == "startFace") {
                startFace = textLabel("the first face of a patch");
                expect(";");
            } else if (key == "neighbProcNo") {
                patch.neighbour = textLabel("the number of a process");
                expect(";");
            } else if (key == "type" || key == "neighbourPatch" || key == "referPatch") {
                (key == "type"             ? patch.type
                 : key == "neighbourPatch" ? patch.neighbourPatch
                                           : patch.referPatch) = text(key.c_str());
                expect(";");
            } else {
                skipValue();
            }
        }
        if (patch.type.empty() || !faceCount || !startFace)
            fail(concat("the patch ", inQuotes(patch.name), " has no ",
                        patch.type.empty() ? "type"
                        : faceCount        ? "startFace"
                                           : "nFaces"));
        patch.faceCount = *faceCount;
        patch.startFace = *startFace;
    }
    expect(")");
    return patches;
}

std::string FoamFile::text(const char* what) {
    std::string_view text = word(what);
    if (text.size() > 1 && text.front() == '"' && text.back() == '"')
        text = text.substr(1, text.size() - 2);
    return std::string(text);
}

void FoamFile::skipValue() {
    int depth = 0;
    while (true) {
        const std::string_view next = word(";");
        if (next == "{") ++depth;
        if (next == "}" && --depth < 0) fail("expected ;, got }");
        // A dictionary ends without a semicolon.
        if (depth == 0 && (next == ";" || next == "}")) return;
    }
}

void FoamFile::expectEnd() {
    skipSpace();
    if (position_ != bytes_.size()) fail("expected the end of the file after the list");
}

void FoamFile::fail(const std::string& cause) const {
    throw FileError(*path_, line_, cause);
}

}  // namespace espalier::io
