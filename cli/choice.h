// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <CLI/CLI.hpp>
#include <map>
#include <optional>
#include <string>

namespace espalier::cli {

/// An option that takes one of a few words; the help shows them and the default.
///
/// \param value a Choice, or a std::optional of one that says what is done without the option
template <class Choice, class Value>
void addChoice(CLI::App& command, const std::string& name, Value& value,
               const std::map<std::string, Choice>& words, const std::string& help,
               std::string fallback = {}) {
    std::string names;
    for (const auto& [word, choice] : words) {
        names += (names.empty() ? "" : "|") + word;
        if (value == choice) fallback = word;
    }
    // CLI11 reads an enumerator as its number.
    const CLI::Validator toNumber(
        [words, names](std::string& text) {
            const auto at = words.find(text);
            if (at == words.end()) return "expected " + names + ", got " + text;
            text = std::to_string(static_cast<int>(at->second));
            return std::string();
        },
        "");
    command.add_option(name, value, help)
        ->transform(toNumber)
        ->type_name(names)
        ->default_str(fallback);
}

}  // namespace espalier::cli
