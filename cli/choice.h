// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <CLI/CLI.hpp>
#include <map>
#include <string>

namespace espalier::cli {

/// An option that takes one of a few words; the help shows them and the default.
template <class Choice>
void addChoice(CLI::App& command, const std::string& name, Choice& value,
               const std::map<std::string, Choice>& words, const std::string& help) {
    std::string names, fallback;
    for (const auto& [word, choice] : words) {
        names += (names.empty() ? "" : "|") + word;
        if (choice == value) fallback = word;
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
