// SPDX-License-Identifier: Apache-2.0
#include "abaqus_file.h"

#include <espalier/base/error.h>

#include <algorithm>

namespace espalier::io {

std::optional<std::string_view> takeAbaqusEntry(std::string_view& line) {
    if (line.data() == nullptr) return std::nullopt;
    const std::size_t comma = line.find(',');
    const std::string_view entry = trimmed(line.substr(0, comma));
    line = comma == std::string_view::npos ? std::string_view() : line.substr(comma + 1);
    // A comma at the end of a line begins no further entry.
    if (line.data() != nullptr && trimmed(line).empty()) line = std::string_view();
    return entry;
}

std::optional<std::string_view> AbaqusKeyword::parameter(std::string_view wanted) const {
    for (const auto& [key, value] : parameters)
        if (key == wanted) return value;
    return std::nullopt;
}

std::string_view AbaqusKeyword::nameIn(std::string_view wanted) const {
    std::string_view value = parameter(wanted).value_or(std::string_view());
    if (value.size() >= 2 && value.starts_with('"') && value.ends_with('"'))
        value = value.substr(1, value.size() - 2);
    return value;
}

void AbaqusScopes::update(std::string_view keyword) {
    constexpr std::string_view kNames[] = {"part", "instance", "assembly"};
    if (std::ranges::count(kNames, keyword) > 0) open_.push_back(count_++);
    if (keyword.starts_with("end") && std::ranges::count(kNames, keyword.substr(3)) > 0 &&
        open_.size() > 1)
        open_.pop_back();
}

/// Returns the next line that is no comment; nothing at the end of the file.
std::optional<std::string_view> AbaqusFile::nextLine() {
    if (pending_) return std::exchange(pending_, std::nullopt);
    while (!text_.atEnd()) {
        const std::string_view line = text_.restOfLine();
        if (!line.starts_with("**")) return line;
    }
    return std::nullopt;
}

std::optional<std::string_view> AbaqusFile::nextData() {
    while (auto line = nextLine()) {
        if (line->starts_with('*')) {
            pending_ = line;
            break;
        }
        if (!trimmed(*line).empty()) return line;
    }
    return std::nullopt;
}

bool AbaqusFile::next() {
    while (auto line = nextLine()) {
        if (!line->starts_with('*')) continue;
        keyword_ = {};
        bool isContinued = addParameters(line->substr(1));
        // A comma at the end continues the keyword in the next line.
        while (isContinued) {
            const auto more = nextData();
            if (!more) break;
            isContinued = addParameters(*more);
        }
        scopes_.update(keyword_.name);
        return true;
    }
    return false;
}

/// Adds the entries of a line to the keyword. Returns true if the line ends with a comma.
bool AbaqusFile::addParameters(std::string_view line) {
    const bool isContinued = trimmed(line).ends_with(',');
    while (const auto entry = takeAbaqusEntry(line)) {
        const std::size_t equals = entry->find('=');
        std::string key = lowerCase(entry->substr(0, equals));
        std::erase_if(key, [](char c) { return c == ' ' || c == '\t'; });
        if (keyword_.name.empty())
            keyword_.name = std::move(key);
        else
            keyword_.parameters.emplace_back(std::move(key),
                                             equals == std::string_view::npos
                                                 ? std::string_view()
                                                 : trimmed(entry->substr(equals + 1)));
    }
    return isContinued;
}

std::int64_t AbaqusFile::integer(std::optional<std::string_view> entry, const char* what) const {
    std::int64_t number = 0;
    if (!entry) fail(concat("the line ends; expected ", what));
    if (!parseNumber(*entry, number))
        fail(concat(inQuotes(*entry), " is not a number; expected ", what));
    return number;
}

}  // namespace espalier::io
