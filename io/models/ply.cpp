// SPDX-License-Identifier: Apache-2.0
#include <espalier/base/error.h>
#include <espalier/base/point.h>
#include <espalier/base/progress.h>
#include <espalier/io/files/file.h>
#include <espalier/io/files/text_reader.h>
#include <espalier/io/models/ply.h>

#include <algorithm>
#include <array>
#include <cstdint>
#include <filesystem>
#include <ostream>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "../files/bytes.h"
#include "coordinates.h"
#include "ply_header.h"

namespace espalier::io {
namespace {

/// A vector of each vertex, and the offsets of its numbers in the file.
struct PlyVectors {
    std::array<Precision, 3> precisions;
    std::vector<Point3> values;
    std::vector<CoordinatePlaces> places;
};

struct PlyPoints {
    PlyVectors positions;
    /// One entry for each direction of the header. A word that is no number is NaN.
    std::vector<PlyVectors> directions;
};

/// Returns true if a list of the element `face` has the corners of the faces.
bool isCornerList(const PlyProperty& property) {
    return property.lengthType && isInteger(property.type) &&
           (property.name == "vertex_indices" || property.name == "vertex_index");
}

/// Reads the rows of all elements, and collects the points and directions.
class RowReader {
public:
    /// \param path, bytes, header must outlive the reader
    /// \param faces receives the faces; may be null
    RowReader(const std::filesystem::path& path, std::string_view bytes, const PlyHeader& header,
              ModelFaces* faces)
        : path_(path),
          bytes_(bytes),
          header_(header),
          faces_(faces),
          slots_(header.vertices().properties.size()) {
        points_.directions.resize(header.directions.size());
        setSlots(header.axes, points_.positions);
        for (std::size_t i = 0; i < header.directions.size(); ++i)
            setSlots(header.directions[i].columns, points_.directions[i]);
    }
    RowReader(const RowReader&) = delete;
    RowReader& operator=(const RowReader&) = delete;
    virtual ~RowReader() = default;

    PlyPoints read() {
        for (const PlyElement& element : header_.elements) {
            isVertex_ = &element == &header_.vertices();
            isFace_ = element.name == "face";
            // Rows without properties have no bytes in the file.
            if (element.properties.empty()) continue;
            checkClaim(element);
            if (!isVertex_ && skipRows(element)) continue;
            if (isVertex_) addVertices(points_.positions, element.count);
            for (PlyVectors& direction : points_.directions)
                if (isVertex_) addVertices(direction, element.count);
            for (row_ = 0; row_ < element.count; ++row_) {
                checkCancelledEvery(row_, 12);
                readRow(element);
            }
        }
        checkEnd();
        return std::move(points_);
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
        PlyVectors* vectors = nullptr;  ///< null if the column is skipped
        std::size_t axis = 0;
        Precision precision() const { return vectors->precisions[axis]; }
    };

    /// \return null if a column of the current element is skipped
    const Slot* slotOf(std::size_t column) const {
        return isVertex_ && slots_[column].vectors ? &slots_[column] : nullptr;
    }

    bool isPosition(const Slot& slot) const { return slot.vectors == &points_.positions; }

    void set(const Slot& slot, double value, std::size_t place) {
        slot.vectors->values[row_][slot.axis] = value;
        slot.vectors->places[row_][slot.axis] = place;
    }

    /// Returns true if a list of the current element has the corners of a face that is wanted.
    bool isFaceList(const PlyProperty& property) const {
        return faces_ && isFace_ && isCornerList(property);
    }

    /// Returns true if a corner of a face names a point, and adds it then.
    bool addCorner(std::int64_t point) {
        if (point < 0 || static_cast<std::uint64_t>(point) >= header_.vertices().count)
            return false;
        faces_->corners.push_back(static_cast<Index>(point));
        return true;
    }

    void endFace() { faces_->endFace(); }

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
    void setSlots(const std::array<std::size_t, 3>& columns, PlyVectors& vectors) {
        vectors.precisions = header_.precisions(columns);
        for (std::size_t axis = 0; axis < 3; ++axis) slots_[columns[axis]] = {&vectors, axis};
    }

    static void addVertices(PlyVectors& vectors, std::size_t count) {
        vectors.values.resize(count);
        vectors.places.resize(count);
    }

    PlyPoints points_;
    ModelFaces* faces_;
    std::vector<Slot> slots_;  ///< one for each column of the vertices
    bool isVertex_ = false;
    bool isFace_ = false;
};

class AsciiRows final : public RowReader {
public:
    AsciiRows(const std::filesystem::path& path, std::string_view bytes, const PlyHeader& header,
              ModelFaces* faces)
        : RowReader(path, bytes, header, faces),
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
        for (std::size_t column = 0; column < element.properties.size(); ++column) {
            const PlyProperty& property = element.properties[column];
            if (column > 0) word = needWord(line, property);
            if (property.lengthType)
                readList(line, word, property);
            else if (const Slot* slot = slotOf(column))
                set(*slot, parse(*slot, word), word.data() - bytes_.data());
        }
        if (const std::string_view more = takeWord(line); !more.empty())
            lines_.fail("expected the end of a row of the element " + inQuotes(element.name) +
                        ", got " + inQuotes(more));
    }

    void checkEnd() override {
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
            std::int64_t point = 0;
            if (isFace && (!parseNumber(word, point) || !addCorner(point)))
                lines_.fail("a face has the corner " + inQuotes(word) +
                            ", which is not the number of " + nameOfPoints());
        }
        if (isFace) endFace();
    }

    TextReader lines_;
};

class BinaryRows final : public RowReader {
public:
    BinaryRows(const std::filesystem::path& path, std::string_view bytes, const PlyHeader& header,
               ModelFaces* faces)
        : RowReader(path, bytes, header, faces), at_(header.size), order_(header.byteOrder()) {}

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
        for (std::size_t column = 0; column < element.properties.size(); ++column) {
            const PlyProperty& property = element.properties[column];
            const std::size_t size = byteSize(property.type);
            if (property.lengthType)
                readList(property);
            else if (const Slot* slot = slotOf(column))
                readReal(*slot, take(1, size, property));
            else
                take(1, size, property);
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
        if (!isFaceList(property)) return;
        for (std::size_t place = begin; place < at_; place += size) {
            const std::int64_t point = loadInteger(bytes_.data() + place, property.type, order_);
            if (!addCorner(point))
                fail(concat("a face has the corner ", point, ", which is not the number of ",
                            nameOfPoints()));
        }
        endFace();
    }

    void readReal(const Slot& slot, std::size_t at) {
        set(slot,
            isPosition(slot)
                ? loadCoordinate(bytes_, at, slot.precision(), order_, slot.axis, row_, path_)
                : loadReal(bytes_, at, slot.precision(), order_),
            at);
    }

    std::size_t at_;
    std::endian order_;
};

/// Reads all rows of a PLY file. Memory is allocated only for points that the file has bytes for,
/// whatever the header claims.
///
/// \param path for messages
/// \param bytes the whole file
/// \param faces receives the faces; may be null
/// \throws FileError with the line (ASCII) or the byte (binary) if there are fewer or more rows
///         than the header claims, if a row is malformed, or if a position is not finite
PlyPoints readPlyRows(const std::filesystem::path& path, std::string_view bytes,
                      const PlyHeader& header, ModelFaces* faces = nullptr) {
    if (header.format == PlyFormat::Ascii) return AsciiRows(path, bytes, header, faces).read();
    return BinaryRows(path, bytes, header, faces).read();
}

class PlyModel final : public Model {
public:
    PlyModel(const std::filesystem::path& path, std::string bytes)
        : path_(path),
          bytes_(std::move(bytes)),
          header_(parsePlyHeader(path, bytes_)),
          points_(readPlyRows(path, bytes_, header_)) {}

    std::span<const Point3> positions() const override { return points_.positions.values; }
    std::string_view extension() const override { return ".ply"; }
    bool hasDirections() const override { return !points_.directions.empty(); }
    CoordinateStorage storage() const override {
        return storageOf(narrowest(points_.positions.precisions));
    }

    ModelSurface readSurface() const override {
        ModelSurface surface;
        readPlyRows(path_, bytes_, header_, &surface.faces);
        const auto normals =
            std::ranges::find(header_.directions, Carry{carryNormal}, &PlyDirection::carry);
        std::vector<std::size_t> used(header_.axes.begin(), header_.axes.end());
        if (normals != header_.directions.end()) {
            surface.normals = points_.directions[normals - header_.directions.begin()].values;
            used.insert(used.end(), normals->columns.begin(), normals->columns.end());
        }
        for (const PlyElement& element : header_.elements) nameOtherData(element, used, surface);
        return surface;
    }

private:
    /// \param used numbers of the properties of vertices that are points or normals
    void nameOtherData(const PlyElement& element, const std::vector<std::size_t>& used,
                       ModelSurface& surface) const {
        if (element.count == 0) return;
        if (element.name == "tristrips")
            surface.otherShapes.push_back("strips of triangles");
        else if (&element != &header_.vertices() && element.name != "face")
            surface.addOther("elements", element.name);
        else
            for (std::size_t column = 0; column < element.properties.size(); ++column) {
                const PlyProperty& property = element.properties[column];
                if (&element == &header_.vertices()) {
                    if (std::ranges::count(used, column) == 0)
                        surface.addOther("properties of points", property.name);
                } else if (!isCornerList(property)) {
                    surface.addOther("properties of faces", property.name);
                }
            }
    }

    void writeChecked(const std::filesystem::path& path, std::span<const Point3> moved,
                      std::span<const DeformationGradient> gradients) const override {
        std::vector<VectorChange> changes = {changeOf(points_.positions, moved)};
        std::vector<std::vector<Point3>> turned;
        for (std::size_t i = 0; i < points_.directions.size() && !gradients.empty(); ++i) {
            const PlyVectors& vectors = points_.directions[i];
            turned.push_back(carried(vectors.values, gradients, header_.directions[i].carry,
                                     narrowest(vectors.precisions)));
            changes.push_back(changeOf(vectors, turned.back()));
        }
        writeFile(path, [&](std::ostream& out) {
            if (header_.format == PlyFormat::Ascii)
                writeChanged(out, bytes_, changes);
            else
                writeChangedBinary(out, bytes_, changes, header_.byteOrder());
        });
    }

    static VectorChange changeOf(const PlyVectors& vectors, std::span<const Point3> now) {
        return {vectors.places, vectors.values, now, vectors.precisions};
    }

    static Precision narrowest(const std::array<Precision, 3>& precisions) {
        return *std::min_element(precisions.begin(), precisions.end());
    }

    std::filesystem::path path_;  ///< path of the file that was read
    std::string bytes_;
    PlyHeader header_;
    PlyPoints points_;
};

}  // namespace

std::unique_ptr<Model> readPly(const std::filesystem::path& path, std::string bytes) {
    return std::make_unique<PlyModel>(path, std::move(bytes));
}

}  // namespace espalier::io
