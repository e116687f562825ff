// SPDX-License-Identifier: Apache-2.0
#include <espalier/base/error.h>
#include <espalier/io/files/file.h>
#include <espalier/io/files/text_reader.h>
#include <espalier/io/matrices/matrix_market.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <iterator>
#include <limits>
#include <numeric>
#include <ostream>
#include <tuple>
#include <utility>
#include <vector>

#include "../files/text_output.h"
#include "../files/text_reader.h"
#include "matrix_rows.h"

namespace espalier::io {

using stencils::StencilTable;

namespace {

constexpr const char* kBanner = "%%MatrixMarket";

void writeComments(TextOutput& out, std::span<const std::string> comments) {
    for (std::string_view comment : comments) {
        while (true) {
            const std::size_t end = std::min(comment.find('\n'), comment.size());
            out.put("% ", comment.substr(0, end), "\n");
            if (end == comment.size()) break;
            comment.remove_prefix(end + 1);
        }
    }
}

template <class Real>
void writeEntries(TextOutput& out, const StencilTable<Real>& table) {
    for (Index row = 0; row < table.rowCount(); ++row) {
        const auto columns = table.columns(row);
        const auto weights = table.weights(row);
        for (std::size_t i = 0; i < columns.size(); ++i) {
            out.put(std::int64_t{row} + 1, " ", std::int64_t{columns[i]} + 1, " ",
                    double{weights[i]}, "\n");
        }
    }
}

struct Entry {
    Index row;
    Index column;
    double weight;
    std::size_t line;

    friend bool operator<(const Entry& a, const Entry& b) {
        return std::tie(a.row, a.column, a.line) < std::tie(b.row, b.column, b.line);
    }
};

class MatrixReader {
public:
    MatrixReader(const std::filesystem::path& path, std::string_view text)
        : path_(path), size_(text.size()), reader_(path, text) {}

    StencilTable<double> read() {
        readBanner();
        readSizes();
        readEntries();
        sortEntries();
        return makeTable();
    }

private:
    void readBanner() {
        std::string_view line = reader_.restOfLine();
        if (takeWord(line) != kBanner)
            reader_.fail(std::string("not a Matrix Market file; expected ") + kBanner);
        expectWord(line, "matrix");
        expectWord(line, "coordinate");
        const std::string_view field = takeWord(line);
        isInteger_ = lowerCase(field) == "integer";
        if (!isInteger_ && lowerCase(field) != "real")
            reader_.fail(inQuotes(field) + " is not supported; expected real or integer");
        expectWord(line, "general");
    }

    void expectWord(std::string_view& line, const char* expected) const {
        const std::string_view word = takeWord(line);
        if (lowerCase(word) != expected)
            reader_.fail(inQuotes(word) + " is not supported; expected " + expected);
    }

    void readSizes() {
        std::string_view line;
        std::string_view rows;
        while (rows.empty() || rows.starts_with('%')) {
            if (reader_.remaining() == 0)
                reader_.fail("the file ends; expected numbers of rows, columns and entries");
            line = reader_.restOfLine();
            rows = takeWord(line);
        }
        rowCount_ = size<Index>(rows, "rows");
        columnCount_ = size<Index>(takeWord(line), "columns");
        entryCount_ = size<std::size_t>(takeWord(line), "entries");
        checkClaims();
    }

    template <class Count>
    Count size(std::string_view word, const char* of) const {
        Count count = 0;
        if (!parseNumber(word, count) || std::cmp_less(count, 0))
            reader_.fail(concat(inQuotes(word), " is not a number of ", of, " from 0 to ",
                                std::numeric_limits<Count>::max()));
        return count;
    }

    /// Checks the claimed sizes before memory is allocated for them.
    void checkClaims() const {
        constexpr std::size_t kFreeRows = 1'000'000;
        if (std::cmp_greater(rowCount_, kFreeRows + size_))
            reader_.fail(concat("claims ", rowCount_, " rows, which a file of ", size_,
                                " bytes would leave empty"));
        // The shortest entry is "1 1 1" and a line end: 6 bytes.
        reader_.checkRoom(entryCount_, 6, "the number of entries");
    }

    void readEntries() {
        entries_.reserve(entryCount_);
        for (std::size_t i = 0; i < entryCount_; ++i) {
            const Index row = readIndex("row", rowCount_);
            const Index column = readIndex("column", columnCount_);
            const double weight = readWeight();
            entries_.push_back({row, column, weight, reader_.line()});
        }
        if (reader_.atEnd()) return;
        const std::string_view more = reader_.token("the end");
        reader_.fail(
            concat("expected the end after ", entryCount_, " entries, got ", inQuotes(more)));
    }

    Index readIndex(const char* what, Index count) {
        const Index number = reader_.number<Index>(what);
        if (number < 1 || number > count)
            reader_.fail(concat(what, " ", number, " does not exist; expected 1 to ", count));
        return number - 1;
    }

    double readWeight() {
        if (isInteger_) {
            constexpr std::int64_t kLargest = std::int64_t{1} << 53;
            const auto weight = reader_.number<std::int64_t>("an integer weight");
            if (weight < -kLargest || weight > kLargest)
                reader_.fail(concat(weight, " is more than a double holds exactly"));
            return static_cast<double>(weight);
        }
        const auto weight = reader_.number<double>("a weight");
        if (!std::isfinite(weight)) reader_.fail("the weight is not finite");
        return weight;
    }

    void sortEntries() {
        if (!std::is_sorted(entries_.begin(), entries_.end()))
            std::sort(entries_.begin(), entries_.end());
        const auto isSamePlace = [](const Entry& a, const Entry& b) {
            return a.row == b.row && a.column == b.column;
        };
        const auto twice = std::adjacent_find(entries_.begin(), entries_.end(), isSamePlace);
        if (twice == entries_.end()) return;
        const Entry& second = *std::next(twice);
        throw FileError(path_, second.line,
                        concat("row ", second.row + 1, " column ", second.column + 1,
                               " has an entry already, on line ", twice->line));
    }

    StencilTable<double> makeTable() const {
        Array<Offset> offsets(Offset{rowCount_} + 1, 0);
        Array<Index> columns;
        Array<double> weights;
        columns.reserve(entries_.size());
        weights.reserve(entries_.size());
        for (const Entry& entry : entries_) {
            ++offsets[entry.row + 1];
            columns.push_back(entry.column);
            weights.push_back(entry.weight);
        }
        std::partial_sum(offsets.begin(), offsets.end(), offsets.begin());
        return StencilTable<double>(columnCount_, std::move(offsets), std::move(columns),
                                    std::move(weights));
    }

    std::filesystem::path path_;
    std::size_t size_;
    TextReader reader_;
    bool isInteger_ = false;
    Index rowCount_ = 0;
    Index columnCount_ = 0;
    std::size_t entryCount_ = 0;
    std::vector<Entry> entries_;
};

}  // namespace

template <class Real>
void writeMatrixMarket(const std::filesystem::path& path, const StencilTable<Real>& table,
                       std::span<const std::string> comments) {
    checkFinite(table);
    writeFile(path, [&](std::ostream& stream) {
        TextOutput out(stream);
        out.put(kBanner, " matrix coordinate real general\n");
        writeComments(out, comments);
        out.put(table.rowCount(), " ", table.columnCount(), " ", table.entryCount(), "\n");
        writeEntries(out, table);
    });
}

template void writeMatrixMarket(const std::filesystem::path&, const StencilTable<float>&,
                                std::span<const std::string>);
template void writeMatrixMarket(const std::filesystem::path&, const StencilTable<double>&,
                                std::span<const std::string>);

StencilTable<double> readMatrixMarket(const std::filesystem::path& path, std::string_view bytes) {
    return MatrixReader(path, bytes).read();
}

}  // namespace espalier::io
