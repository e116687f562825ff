// SPDX-License-Identifier: Apache-2.0
#include <espalier/base/argument_error.h>

#include <utility>

namespace espalier {
namespace {

/// Returns a message.
/// \param function, other their names may be empty
std::string messageOf(const std::string& function, const ArgumentError::Field& refused,
                      const std::string& expected, const ArgumentError::Field& other) {
    std::string text = function.empty() ? "" : function + ": ";
    text += refused.name + ": expected " + expected;
    if (!other.name.empty()) text += " " + other.name;
    if (!other.value.empty()) text += " (" + other.value + ")";
    return text + ", got " + refused.value;
}

}  // namespace

ArgumentError::ArgumentError(std::string function, std::string field, std::string got,
                             std::string expected, Field other)
    : Error(messageOf(function, {field, got}, expected, other)),
      function_(std::move(function)),
      field_(std::move(field)),
      got_(std::move(got)),
      expected_(std::move(expected)),
      other_(std::move(other)) {}

std::string ArgumentError::message(FunctionRef<std::string(const std::string&)> nameOf) const {
    const std::string text = messageOfField(nameOf);
    return function_.empty() ? text : nameOf(function_) + ": " + text;
}

std::string ArgumentError::messageOfField(
    FunctionRef<std::string(const std::string&)> nameOf) const {
    const std::string other = other_.name.empty() ? "" : nameOf(other_.name);
    return messageOf("", {nameOf(field_), got_}, expected_, {other, other_.value});
}

std::string separated(std::string_view name, char separator) {
    const auto isLower = [](char letter) { return letter >= 'a' && letter <= 'z'; };
    std::string text;
    for (const char letter : name) {
        const bool isCapital = letter >= 'A' && letter <= 'Z';
        if (isCapital && !text.empty() && isLower(text.back()))
            text += {separator, static_cast<char>(letter - 'A' + 'a')};
        else
            text += letter;
    }
    return text;
}

}  // namespace espalier
