// SPDX-License-Identifier: Apache-2.0
#include <espalier/base/error.h>
#include <espalier/base/progress.h>
#include <espalier/io/displacements.h>
#include <espalier/io/files/file.h>
#include <espalier/io/files/text_reader.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <optional>
#include <string>
#include <utility>

#include "files/bytes.h"
#include "files/other_content.h"
#include "format.h"
#include "matrices/npy.h"

namespace espalier::io {
namespace {

constexpr std::array<std::string_view, 4> kColumns = {"vertex", "dx", "dy", "dz"};

/// Collects the displacements of a file, and refuses rows that no lattice of this size has.
class Displacements {
public:
    /// \param unit the name of a row in messages: "line" or "row"
    Displacements(Index vertexCount, std::string unit)
        : unit_(std::move(unit)), vectors_(vertexCount), rows_(vertexCount, kNone) {}

    /// Adds a row: the number of a vertex and the vector.
    /// \return why the row is refused; nothing if it is not
    std::optional<std::string> add(std::size_t row, const std::array<double, 4>& numbers) {
        for (std::size_t c = 0; c < numbers.size(); ++c)
            if (!std::isfinite(numbers[c])) return concat(kColumns[c], " is not finite");
        const double number = numbers[0];
        if (number != std::floor(number))
            return concat("expected the number of a vertex, got ", formatNumber(number));
        if (!(number >= 0 && number < static_cast<double>(vectors_.size())))
            return concat("there is no vertex ", formatNumber(number), "; the lattice has ",
                          vectors_.size(), " vertices, numbered from 0");
        const auto vertex = static_cast<std::size_t>(number);
        if (rows_[vertex] != kNone)
            return concat("vertex ", vertex, " has a displacement already, in ", unit_, " ",
                          rows_[vertex]);
        rows_[vertex] = row;
        vectors_[vertex] = {numbers[1], numbers[2], numbers[3]};
        isEmpty_ = false;
        return std::nullopt;
    }

    bool isEmpty() const { return isEmpty_; }
    std::vector<Point3> take() { return std::move(vectors_); }

private:
    static constexpr std::size_t kNone = static_cast<std::size_t>(-1);
    std::string unit_;
    std::vector<Point3> vectors_;
    std::vector<std::size_t> rows_;  ///< the row of each vertex in the file
    bool isEmpty_ = true;
};

/// Splits a line at commas.
/// \return the fields, at most one more than there should be
std::vector<std::string_view> fieldsOf(std::string_view line) {
    std::vector<std::string_view> fields;
    while (fields.size() <= kColumns.size()) {
        const std::size_t comma = line.find(',');
        fields.push_back(trimmed(line.substr(0, comma)));
        if (comma == line.npos) break;
        line.remove_prefix(comma + 1);
    }
    return fields;
}

bool isHeader(const std::vector<std::string_view>& fields) {
    if (fields.size() != kColumns.size()) return false;
    for (std::size_t i = 0; i < fields.size(); ++i) {
        std::string_view name = fields[i];
        if (name.size() > 1 && name.front() == '"' && name.back() == '"')
            name = name.substr(1, name.size() - 2);
        if (lowerCase(name) != kColumns[i]) return false;
    }
    return true;
}

std::vector<Point3> readCsv(const std::filesystem::path& path, Index vertexCount,
                            std::string_view bytes) {
    constexpr std::string_view kByteOrderMark = "\xEF\xBB\xBF";
    if (bytes.starts_with(kByteOrderMark)) bytes.remove_prefix(kByteOrderMark.size());
    TextReader reader(path, bytes);
    Displacements displacements(vertexCount, "line");
    bool isFirst = true;
    while (reader.remaining() > 0) {
        const std::string_view line = trimmed(reader.restOfLine());
        if (line.empty() || line.starts_with('#')) continue;
        const auto fields = fieldsOf(line);
        const bool mayBeHeader = isFirst;
        isFirst = false;
        if (mayBeHeader && isHeader(fields)) continue;
        if (fields.size() != kColumns.size())
            reader.fail("expected vertex,dx,dy,dz: four numbers with commas between");
        std::array<double, 4> numbers{};
        for (std::size_t c = 0; c < numbers.size(); ++c)
            if (!parseNumber(fields[c], numbers[c]))
                reader.fail(concat("expected a number for ", kColumns[c], ", got ",
                                   fields[c].empty() ? "nothing" : inQuotes(fields[c])));
        if (const auto refused = displacements.add(reader.line(), numbers)) reader.fail(*refused);
    }
    if (displacements.isEmpty())
        throw FileError(path, "has no displacement; expected lines vertex,dx,dy,dz");
    return displacements.take();
}

std::vector<Point3> readNpyRows(Index vertexCount, std::string_view bytes) {
    const NpyArray array = readNpy(bytes);
    const auto& shape = array.shape;
    const bool hasNumbers = shape.size() == 2 && shape[1] == kColumns.size();
    if (!hasNumbers && (shape.size() != 2 || shape[1] != 3))
        throw CodingError(concat("has the shape ", shapeText(shape), "; expected (", vertexCount,
                                 ", 3), a vector for each vertex, or (n, 4), rows vertex, dx, dy, "
                                 "dz"));
    const std::size_t count = shape[0];
    if (!hasNumbers && count != static_cast<std::size_t>(vertexCount))
        throw CodingError(
            concat("has ", count, " vectors; expected one for each of the ", vertexCount,
                   " vertices of the lattice, or rows vertex, dx, dy, dz, of the shape (n, 4)"));
    if (hasNumbers && count == 0) throw CodingError("has no displacement");
    const Array<double> numbers = npyMatrix(array);
    Displacements displacements(vertexCount, "row");
    const std::size_t width = shape[1];
    for (std::size_t row = 0; row < count; ++row) {
        checkCancelledEvery(row, 16);
        const double* const first = numbers.data() + row * width;
        const std::array<double, 4> one =
            hasNumbers ? std::array{first[0], first[1], first[2], first[3]}
                       : std::array{static_cast<double>(row), first[0], first[1], first[2]};
        if (const auto refused = displacements.add(row, one))
            throw CodingError(concat("row ", row, ": ", *refused));
    }
    return displacements.take();
}

}  // namespace

std::vector<Point3> readDisplacements(const std::filesystem::path& path, Index vertexCount) {
    return readDisplacements(path, vertexCount, readFile(path));
}

std::vector<Point3> readDisplacements(const std::filesystem::path& path, Index vertexCount,
                                      std::string_view bytes) {
    const Format* const format = findFormat(path, FileContent::Displacements);
    if (format == nullptr)
        throw FileError(path, "is not a table of displacements; expected " +
                                  listOfFormats(FileContent::Displacements, FileUse::Read));
    return explainingContent(path, bytes, [&] {
        if (format == &kCommaSeparatedFormat) return readCsv(path, vertexCount, bytes);
        return decodeFile(path, [&] { return readNpyRows(vertexCount, bytes); });
    });
}

const Format kCommaSeparatedFormat = {.extensions = {".csv"}, .isDisplacements = true};

}  // namespace espalier::io
