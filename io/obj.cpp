// SPDX-License-Identifier: Apache-2.0
#include <espalier/io/coordinates.h>
#include <espalier/io/file.h>
#include <espalier/io/obj.h>
#include <espalier/io/text_reader.h>
#include <espalier/io/words.h>

#include <ostream>
#include <string>
#include <utility>
#include <vector>

namespace espalier::io {
namespace {

/// The words of a statement, up to a comment.
class Words {
public:
    /// \param statement without its line end, but with those that a backslash continues
    explicit Words(std::string_view statement) : rest_(statement) {}

    /// The next word; empty when there is none.
    std::string_view next() {
        while (const std::size_t length = blankAt(0)) rest_.remove_prefix(length);
        std::size_t end = 0;
        while (end < rest_.size() && rest_[end] != '#' && blankAt(end) == 0) ++end;
        const std::string_view word = rest_.substr(0, end);
        rest_.remove_prefix(end);
        return word;
    }

private:
    /// Length of the white space or the continued line end that begins at `at`.
    std::size_t blankAt(std::size_t at) const {
        if (at == rest_.size()) return 0;
        const char c = rest_[at];
        if (c == ' ' || (c >= '\t' && c <= '\r')) return 1;
        if (c != '\\') return 0;
        const std::string_view after = rest_.substr(at + 1);
        return after.starts_with('\n') ? 2 : after.starts_with("\r\n") ? 3 : 0;
    }

    std::string_view rest_;
};

/// Reads lines to the end of a statement.
std::string_view readStatement(TextReader& reader) {
    const std::string_view first = reader.restOfLine();
    std::string_view last = first;
    // Paths in comments may end in a backslash; what follows them is not theirs.
    while (last.ends_with('\\') && last.find('#') == std::string_view::npos)
        last = reader.restOfLine();
    return {first.data(), static_cast<std::size_t>(last.data() + last.size() - first.data())};
}

class ObjModel final : public Model {
public:
    ObjModel(const std::filesystem::path& path, std::string text) : text_(std::move(text)) {
        constexpr std::string_view kByteOrderMark = "\xEF\xBB\xBF";
        TextReader reader(path, text_);
        if (text_.starts_with(kByteOrderMark)) reader.bytes(kByteOrderMark.size(), "a mark");
        for (std::size_t line = 1; reader.remaining() > 0; line = reader.line() + 1) {
            Words words(readStatement(reader));
            if (words.next() == "v") addPoint(words, path, line);
        }
    }

    std::span<const Point3> positions() const override { return positions_; }
    std::string_view extension() const override { return ".obj"; }

private:
    void addPoint(Words& words, const std::filesystem::path& path, std::size_t line) {
        Point3& point = positions_.emplace_back();
        CoordinatePlaces& place = places_.emplace_back();
        for (std::size_t axis = 0; axis < 3; ++axis) {
            const std::string_view word = words.next();
            point[axis] = parseCoordinate(word, axis, Precision::Double, path, line);
            place[axis] = static_cast<std::size_t>(word.data() - text_.data());
        }
        double ignored = 0;
        for (std::string_view word = words.next(); !word.empty(); word = words.next())
            if (!parseNumber(word, ignored))
                throw FileError(
                    path, line,
                    inQuotes(word) + " is not a number; expected w or a colour after x y z");
    }

    void writeChecked(const std::filesystem::path& path,
                      std::span<const Point3> moved) const override {
        writeFile(path, [&](std::ostream& out) {
            writeWithPositions(out, text_, places_, positions_, moved,
                               {Precision::Double, Precision::Double, Precision::Double});
        });
    }

    std::string text_;
    std::vector<Point3> positions_;
    std::vector<CoordinatePlaces> places_;
};

}  // namespace

std::unique_ptr<Model> readObj(const std::filesystem::path& path, std::string bytes) {
    return std::make_unique<ObjModel>(path, std::move(bytes));
}

}  // namespace espalier::io
