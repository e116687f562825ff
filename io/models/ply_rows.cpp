// SPDX-License-Identifier: Apache-2.0
#include "ply_rows.h"

#include <espalier/base/error.h>
#include <espalier/base/point.h>
#include <espalier/base/progress.h>
#include <espalier/io/files/file.h>
#include <espalier/io/files/text_reader.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cstdint>
#include <map>
#include <string>
#include <utility>

#include "../files/bytes.h"

namespace espalier::io {
namespace {

bool isStrips(const PlyElement& element) {
    return element.name == "tristrips";
}

}  // namespace

bool isFaces(const PlyElement& element) {
    return element.name == "face" || isStrips(element);
}

bool isCornerList(const PlyProperty& property) {
    return property.lengthType && isInteger(property.type) &&
           (property.name == "vertex_indices" || property.name == "vertex_index");
}

bool isTextureList(const PlyProperty& property) {
    return property.lengthType && !isInteger(property.type) && property.name == "texcoord";
}

namespace {

/// Reads the rows of all elements, and collects the points and directions.
class RowReader {
    static constexpr std::int64_t kEndOfStrip = -1;

public:
    /// \param path, bytes, header must outlive the reader
    /// \param surface receives the faces with their texture coordinates; may be null
    /// \param wanted receives a property of the points; may be null
    RowReader(const std::filesystem::path& path, std::string_view bytes, const PlyHeader& header,
              ModelSurface* surface, PlyColumn* wanted)
        : path_(path),
          bytes_(bytes),
          header_(header),
          surface_(surface),
          wanted_(wanted),
          slots_(header.vertices().properties.size()) {
        numbers_.directions.resize(header.directions.size());
        setSlots(header.axes, numbers_.points);
        for (std::size_t i = 0; i < header.directions.size(); ++i) {
            setSlots(header.directions[i].columns, numbers_.directions[i]);
            numbers_.directions[i].carry = header.directions[i].carry;
        }
        numbers_.splats = header.fileSplats();
    }
    RowReader(const RowReader&) = delete;
    RowReader& operator=(const RowReader&) = delete;
    virtual ~RowReader() = default;

    FileNumbers read() {
        for (const PlyElement& element : header_.elements) {
            isVertex_ = &element == &header_.vertices();
            isFace_ = isFaces(element);
            isStrip_ = isStrips(element);
            // Rows without properties have no bytes in the file.
            if (element.properties.empty()) continue;
            checkClaim(element);
            if (!isVertex_ && skipRows(element)) continue;
            if (isVertex_) numbers_.points.resize(element.count);
            for (FileVectors& direction : numbers_.directions)
                if (isVertex_) direction.resize(element.count);
            if (isVertex_ && !numbers_.splats.columns.empty())
                numbers_.splats.rows.resize(element.count);
            for (row_ = 0; row_ < element.count; ++row_) {
                checkCancelledEvery(row_, 12);
                readRow(element);
                if (isFace_ && !isStrip_ && surface_) endFaceRow();
            }
        }
        checkEnd();
        if (surface_ && !haveTextures_) surface_->textureCorners.clear();
        return std::move(numbers_);
    }

protected:
    /// Throws if the remaining bytes cannot hold the rows of an element even with empty lists.
    virtual void checkClaim(const PlyElement& element) const = 0;

    /// Skips all rows of an element if they need not be read one by one, and returns true then.
    virtual bool skipRows(const PlyElement& element) = 0;

    virtual void readRow(const PlyElement& element) = 0;

    /// Throws if anything but blank lines (ASCII) or one line end (binary) follows the last row.
    virtual void checkEnd() = 0;

    /// The vector and axis that a column of the vertices belongs to.
    struct Slot {
        FileVectors* vectors = nullptr;  ///< null if the column is skipped
        std::size_t axis = 0;
        Precision precision() const { return vectors->precisions[axis]; }
    };

    /// \return null if a column of the current element is skipped
    const Slot* slotOf(std::size_t column) const {
        return isVertex_ && slots_[column].vectors ? &slots_[column] : nullptr;
    }

    bool isVertex() const { return isVertex_; }

    void addNote(std::string note) { numbers_.notes.push_back(std::move(note)); }

    /// Returns true if a column of the current element is wanted.
    bool isWanted(std::size_t column) const {
        return isVertex_ && wanted_ && wanted_->column == column;
    }

    void addWanted(double value) { wanted_->values.push_back(value); }

    /// Remembers where the current row begins, if it has a splat.
    void beginRow(std::size_t offset) {
        if (isVertex_ && !numbers_.splats.rows.empty()) numbers_.splats.rows[row_] = offset;
    }

    bool isPosition(const Slot& slot) const { return slot.vectors == &numbers_.points; }

    void set(const Slot& slot, double value, std::size_t offset) {
        slot.vectors->values[row_][slot.axis] = value;
        slot.vectors->offsets[row_][slot.axis] = offset;
    }

    /// Returns true if a list of the current element has the corners of a face that is wanted.
    bool isFaceList(const PlyProperty& property) const {
        return surface_ && isFace_ && isCornerList(property);
    }

    /// Returns true if a list of the current element has texture coordinates that are wanted.
    bool areTextures(const PlyProperty& property) const {
        return surface_ && isFace_ && isTextureList(property);
    }

    void addTexture(double value) { textureRow_.push_back(value); }

    /// Returns true if a corner of a face names a point, and adds it then; or if it ends a strip.
    bool addCorner(std::int64_t point) {
        if (isStrip_ && point == kEndOfStrip) {
            endFace();
            return true;
        }
        if (point < 0 || static_cast<std::uint64_t>(point) >= header_.vertices().count)
            return false;
        (isStrip_ ? strip_ : surface_->faces.corners).push_back(static_cast<Index>(point));
        return true;
    }

    void endFace() {
        if (!isStrip_) return surface_->faces.endFace();
        surface_->faces.addStrip(strip_);
        strip_.clear();
    }

    std::string nameOfPoints() const {
        return concat("a point; there are ", header_.vertices().count);
    }

    /// Returns the beginning of a message about too few rows.
    static std::string claimOf(const PlyElement& element) {
        return concat("the file ends; the header claims ", element.count, " rows of the element ",
                      inQuotes(element.name));
    }

    const std::filesystem::path& path_;
    const std::string_view bytes_;
    const PlyHeader& header_;
    std::size_t row_ = 0;  ///< current row of the current element

private:
    void setSlots(const std::array<std::size_t, 3>& columns, FileVectors& vectors) {
        vectors.precisions = header_.precisions(columns);
        for (std::size_t axis = 0; axis < 3; ++axis) slots_[columns[axis]] = {&vectors, axis};
    }

    /// Gives the corners of the row the texture coordinates of the row: u and v for each. Without
    /// coordinates for a corner there are none for any corner.
    void endFaceRow() {
        const std::size_t corners = surface_->faces.corners.size();
        auto& textures = surface_->textures;
        for (std::size_t i = 0; i + 1 < textureRow_.size(); i += 2) {
            const std::array<double, 2> pair = {textureRow_[i], textureRow_[i + 1]};
            const auto [known, isNew] =
                textureOf_.try_emplace(std::bit_cast<std::array<std::uint64_t, 2>>(pair),
                                       static_cast<Index>(textures.size()));
            if (isNew) textures.push_back(pair);
            surface_->textureCorners.push_back(known->second);
        }
        haveTextures_ = haveTextures_ && surface_->textureCorners.size() == corners;
        textureRow_.clear();
    }

    FileNumbers numbers_;
    ModelSurface* surface_;
    PlyColumn* wanted_;
    std::vector<Slot> slots_;  ///< one for each column of the vertices
    bool isVertex_ = false;
    bool isFace_ = false;
    bool isStrip_ = false;
    std::vector<Index> strip_;  ///< the points of the current strip
    bool haveTextures_ = true;  ///< all corners so far have texture coordinates
    std::map<std::array<std::uint64_t, 2>, Index> textureOf_;  ///< by the bits of u and v
    std::vector<double> textureRow_;  ///< the texture coordinates of the current row
};

class AsciiRows final : public RowReader {
public:
    AsciiRows(const std::filesystem::path& path, std::string_view bytes, const PlyHeader& header,
              ModelSurface* surface, PlyColumn* wanted)
        : RowReader(path, bytes, header, surface, wanted),
          lines_(path, bytes.substr(header.size), header.lineCount + 1) {}

private:
    void checkClaim(const PlyElement& element) const override {
        // A number and its separator have at least two bytes.
        const std::string rows = "the number of rows of the element " + inQuotes(element.name);
        lines_.checkRoom(element.count, 2 * element.properties.size(), rows.c_str());
    }

    bool skipRows(const PlyElement&) override { return false; }

    void readRow(const PlyElement& element) override {
        std::string_view line;
        std::string_view word;
        while (word.empty()) {
            if (lines_.remaining() == 0) lines_.fail(concat(claimOf(element), ", got ", row_));
            line = lines_.restOfLine();
            word = takeWord(line);
        }
        beginRow(word.data() - bytes_.data());
        for (std::size_t column = 0; column < element.properties.size(); ++column) {
            const PlyProperty& property = element.properties[column];
            if (column > 0) word = needWord(line, property);
            if (isWanted(column)) {
                double number = 0;
                if (!parseNumber(word, number))
                    lines_.fail(inQuotes(word) + " is not a number; expected the property " +
                                inQuotes(property.name));
                addWanted(number);
            }
            if (property.lengthType)
                readList(line, word, property);
            else if (const Slot* slot = slotOf(column))
                set(*slot, parse(*slot, word), word.data() - bytes_.data());
        }
        const std::string_view more = takeWord(line);
        if (more.empty()) return;
        // Old versions of MeshLab write the colours of corners, which their header does not have.
        if (isVertex())
            lines_.fail("expected the end of a row of the element " + inQuotes(element.name) +
                        ", got " + inQuotes(more));
        longRows_.add(more, lines_.line());
    }

    void checkEnd() override {
        if (!longRows_.empty())
            addNote("kept " +
                    longRows_.phrase("with more words than the header has properties for"));
        while (lines_.remaining() > 0) {
            std::string_view line = lines_.restOfLine();
            if (const std::string_view word = takeWord(line); !word.empty())
                lines_.fail(
                    "expected the end of the file after all rows that the header claims, "
                    "got " +
                    inQuotes(word));
        }
    }

    double parse(const Slot& slot, std::string_view word) const {
        return isPosition(slot)
                   ? parseCoordinate(word, slot.axis, slot.precision(), path_, lines_.line())
                   : parseReal(word, slot.precision());
    }

    std::string_view needWord(std::string_view& line, const PlyProperty& property) const {
        const std::string_view word = takeWord(line);
        if (word.empty())
            lines_.fail("the line ends; expected the property " + inQuotes(property.name));
        return word;
    }

    void readList(std::string_view& line, std::string_view length, const PlyProperty& property) {
        std::uint64_t left = 0;
        if (!parseNumber(length, left))
            lines_.fail(inQuotes(length) + " is not a length; expected the length of the list " +
                        inQuotes(property.name));
        const bool isFace = isFaceList(property);
        for (; left > 0; --left) {
            const std::string_view word = needWord(line, property);
            if (double number = 0; areTextures(property)) {
                if (!parseNumber(word, number))
                    lines_.fail(inQuotes(word) + " is not a texture coordinate");
                addTexture(number);
            }
            std::int64_t point = 0;
            if (isFace && (!parseNumber(word, point) || !addCorner(point)))
                lines_.fail("a face has the corner " + inQuotes(word) +
                            ", which is not the number of " + nameOfPoints());
        }
        if (isFace) endFace();
    }

    TextReader lines_;
    OddLines longRows_;
};

class BinaryRows final : public RowReader {
public:
    BinaryRows(const std::filesystem::path& path, std::string_view bytes, const PlyHeader& header,
               ModelSurface* surface, PlyColumn* wanted)
        : RowReader(path, bytes, header, surface, wanted),
          at_(header.size),
          order_(header.byteOrder()) {}

private:
    [[noreturn]] void fail(const std::string& cause) const {
        throw FileError(path_, concat("byte ", at_, ": ", cause));
    }

    void checkClaim(const PlyElement& element) const override {
        const std::size_t bytesLeft = bytes_.size() - at_;
        if (element.count > bytesLeft / element.smallestRow())
            fail(concat(claimOf(element), ", of at least ", element.smallestRow(),
                        " bytes each; got ", bytesLeft, " bytes"));
    }

    bool skipRows(const PlyElement& element) override {
        if (element.hasLists()) return false;
        at_ += element.count * element.smallestRow();
        return true;
    }

    void readRow(const PlyElement& element) override {
        beginRow(at_);
        for (std::size_t column = 0; column < element.properties.size(); ++column) {
            const PlyProperty& property = element.properties[column];
            const std::size_t size = byteSize(property.type);
            if (property.lengthType) {
                readList(property);
                continue;
            }
            const std::size_t at = take(1, size, property);
            if (isWanted(column)) addWanted(load(at, property.type));
            if (const Slot* slot = slotOf(column)) readReal(*slot, at);
        }
    }

    void checkEnd() override {
        const std::string_view rest = bytes_.substr(at_);
        if (!rest.empty() && rest != "\n" && rest != "\r\n")
            fail(concat("expected the end of the file after all rows that the header claims, got ",
                        rest.size(), " more bytes"));
    }

    /// Skips `count` numbers of `size` bytes.
    /// \return offset of the first of them
    std::size_t take(std::uint64_t count, std::size_t size, const PlyProperty& property) {
        if (count > (bytes_.size() - at_) / size)
            fail(concat("the file ends; expected ", count, " numbers of ", size,
                        " bytes, the property ", inQuotes(property.name)));
        return std::exchange(at_, at_ + count * size);
    }

    void readList(const PlyProperty& property) {
        const NumberType type = *property.lengthType;
        const std::size_t at = take(1, byteSize(type), property);
        const std::int64_t length = loadInteger(bytes_.data() + at, type, order_);
        if (length < 0)
            fail(concat("a list ", inQuotes(property.name), " has the length ", length,
                        "; expected 0 or more"));
        const std::size_t size = byteSize(property.type);
        const std::size_t begin = take(static_cast<std::uint64_t>(length), size, property);
        if (areTextures(property))
            for (std::size_t offset = begin; offset < at_; offset += size)
                addTexture(load(offset, property.type));
        if (!isFaceList(property)) return;
        for (std::size_t offset = begin; offset < at_; offset += size) {
            const std::int64_t point = loadInteger(bytes_.data() + offset, property.type, order_);
            if (!addCorner(point))
                fail(concat("a face has the corner ", point, ", which is not the number of ",
                            nameOfPoints()));
        }
        endFace();
    }

    double load(std::size_t at, NumberType type) const {
        if (isInteger(type))
            return static_cast<double>(loadInteger(bytes_.data() + at, type, order_));
        return loadReal(bytes_, at,
                        type == NumberType::Float32 ? Precision::Float : Precision::Double, order_);
    }

    void readReal(const Slot& slot, std::size_t at) {
        set(slot, loadReal(bytes_, at, slot.precision(), order_), at);
    }

    std::size_t at_;
    std::endian order_;
};

}  // namespace

FileNumbers readPlyRows(const std::filesystem::path& path, std::string_view bytes,
                        const PlyHeader& header, ModelSurface* surface, PlyColumn* wanted) {
    if (header.format == PlyFormat::Ascii)
        return AsciiRows(path, bytes, header, surface, wanted).read();
    return BinaryRows(path, bytes, header, surface, wanted).read();
}

}  // namespace espalier::io
