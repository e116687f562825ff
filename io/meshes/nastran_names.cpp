// SPDX-License-Identifier: Apache-2.0
#include "nastran_names.h"

#include <espalier/io/files/text_reader.h>

#include <algorithm>
#include <optional>

#include "nastran_card.h"

namespace espalier::io {
namespace {

/// Removes a text from the front of another; returns false if the other begins with something else.
bool takePrefix(std::string_view& text, std::string_view prefix) {
    if (!text.starts_with(prefix)) return false;
    text.remove_prefix(prefix.size());
    return true;
}

/// Removes the digits at the front of a text.
std::optional<std::int64_t> takeDigits(std::string_view& text) {
    const std::string_view digits = text.substr(0, text.find_first_not_of("0123456789"));
    std::int64_t number = 0;
    if (!parseNumber(digits, number)) return std::nullopt;
    text.remove_prefix(digits.size());
    return number;
}

/// A property that a comment names. Without a number it is the next one in the file.
struct Named {
    std::optional<std::int64_t> number;
    std::string_view name;
};

/// Returns the property that a comment names; nothing for other comments.
std::optional<Named> namedIn(std::string_view comment) {
    std::string_view rest = comment;
    Named named;
    if (takePrefix(rest, "$HMNAME PROP")) {  // $HMNAME PROP       1"wall" 4
        rest = trimmed(rest);
        named.number = takeDigits(rest);
        if (!takePrefix(rest, "\"")) return std::nullopt;
        named.name = rest.substr(0, rest.find('"'));
    } else if (takePrefix(rest, "$ANSA_NAME_COMMENT;")) {  // $ANSA_NAME_COMMENT;1;PSHELL;wall;
        named.number = takeDigits(rest);
        if (!takePrefix(rest, ";P")) return std::nullopt;
        rest.remove_prefix(std::min(rest.find(';'), rest.size() - 1) + (rest.empty() ? 0 : 1));
        named.name = rest.substr(0, rest.find(';'));
    } else if (takePrefix(rest, "$ Femap")) {  // $ Femap with NX Nastran Property 1 : wall
        constexpr std::string_view kWord = " Property ";
        const std::size_t at = rest.find(kWord);
        if (at == std::string_view::npos) return std::nullopt;
        rest.remove_prefix(at + kWord.size());
        named.number = takeDigits(rest);
        if (!takePrefix(rest, " :")) return std::nullopt;
        named.name = rest;
    } else if (takePrefix(rest, "$ Elements and Element Properties for region :")) {  // Patran
        named.name = rest;
    } else if (takePrefix(rest,
                          "$*")) {  // $*  NX Property: wall; $*  I-DEAS property: 1  name: wall
        rest = trimmed(rest);
        if (takePrefix(rest, "NX Property:") || takePrefix(rest, "Property:")) {
            named.name = rest;
        } else if (takePrefix(rest, "I-DEAS property:")) {
            rest = trimmed(rest);
            named.number = takeDigits(rest);
            rest = trimmed(rest);
            if (!takePrefix(rest, "name:")) return std::nullopt;
            named.name = rest;
        }
    }
    named.name = trimmed(named.name);
    return named.name.empty() ? std::nullopt : std::optional(named);
}

}  // namespace

std::map<std::int64_t, std::string> nastranPropertyNames(std::string_view bytes) {
    std::map<std::int64_t, std::string> names;
    std::string_view ofNext;  ///< the name of the next property
    for (std::size_t at = 0; at < bytes.size();) {
        const std::size_t end = std::min(bytes.find('\n', at), bytes.size());
        const std::string_view line = bytes.substr(at, end - at);
        if (line.starts_with('$')) {
            if (const auto named = namedIn(line)) {
                if (named->number)
                    names[*named->number] = named->name;
                else
                    ofNext = named->name;
            }
        } else if (!ofNext.empty()) {
            std::int64_t number = 0;
            if ((line.starts_with('P') || line.starts_with('p')) &&
                parseNumber(nastranLineAt(bytes, at).field(0), number))
                names[number] = ofNext;
            ofNext = {};
        }
        at = end + 1;
    }
    return names;
}

}  // namespace espalier::io
