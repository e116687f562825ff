// SPDX-License-Identifier: Apache-2.0
#include <espalier/base/utf8.h>

#include <algorithm>
#include <charconv>
#include <cstdint>
#include <type_traits>

#include "vtk_xml_writer.h"

namespace espalier::io {
namespace {

template <class Number>
void append(std::string& text, Number number) {
    char digits[32];
    const auto end = std::to_chars(digits, digits + sizeof digits, number).ptr;
    text.append(digits, end);
}

/// One tuple a line, or some more of short ones.
template <class Value>
std::string asciiLines(const VtkArrayHead& head, std::span<const Value> values,
                       std::string_view indent) {
    constexpr std::size_t kNumbersOnALine = 12;
    const std::size_t onALine = head.components > 1 ? head.components : kNumbersOnALine;
    std::string text;
    for (std::size_t i = 0; i < values.size(); ++i) {
        if (i % onALine == 0)
            text.append("\n").append(indent).append("  ");
        else
            text += ' ';
        if (std::is_floating_point_v<Value> && head.type == VtkNumber::Float32)
            append(text, static_cast<float>(values[i]));
        else if (std::is_integral_v<Value> && head.type == VtkNumber::UInt64)
            append(text, static_cast<std::uint64_t>(values[i]));
        else
            append(text, values[i]);
    }
    return text;
}

}  // namespace

template <class Value>
std::string dataArrayElement(const VtkArrayHead& head, std::span<const Value> values,
                             VtkArrayForm form, const VtkCoding& coding, std::string_view indent) {
    const bool isAscii = form == VtkArrayForm::Ascii;
    std::string text = std::string("<DataArray type=\"") + xmlName(head.type) + "\" Name=\"" +
                       xmlEscaped(head.name) + "\"";
    if (head.components != 1)
        text += " NumberOfComponents=\"" + std::to_string(head.components) + "\"";
    if (head.hasTupleCount)
        text += " NumberOfTuples=\"" + std::to_string(values.size() / head.components) + "\"";
    text += isAscii ? " format=\"ascii\">" : " format=\"binary\">";
    if (isAscii) {
        text += asciiLines(head, values, indent);
    } else {
        text.append("\n").append(indent).append("  ");
        text += encodePayload(encodeNumbers(values, head.type, coding.byteOrder), coding);
    }
    return text.append("\n").append(indent).append("</DataArray>");
}

bool isXmlText(std::string_view text) {
    while (!text.empty()) {
        const CodePoint point = firstCodePoint(text);
        const std::uint32_t value = point.value;
        const bool isSpace = value == '\t' || value == '\n' || value == '\r';
        if (!point.isCharacter || (value < 0x20 && !isSpace) || value == 0xFFFE || value == 0xFFFF)
            return false;
        text.remove_prefix(point.size);
    }
    return true;
}

std::string xmlEscaped(std::string_view text) {
    std::string result;
    for (const char c : text) {
        const auto code = static_cast<unsigned char>(c);
        if (code < 0x20 || c == '&' || c == '<' || c == '>' || c == '"')
            result += "&#" + std::to_string(code) + ";";
        else
            result += c;
    }
    return result;
}

#define ESPALIER_INSTANTIATE(Value)                                                    \
    template std::string dataArrayElement(const VtkArrayHead&, std::span<const Value>, \
                                          VtkArrayForm, const VtkCoding&, std::string_view);
ESPALIER_INSTANTIATE(double)
ESPALIER_INSTANTIATE(std::int64_t)
#undef ESPALIER_INSTANTIATE

}  // namespace espalier::io
