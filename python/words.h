// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <espalier/base/error.h>
#include <espalier/base/printable.h>

#include <initializer_list>
#include <string>
#include <utility>
#include <vector>

// Choices are words in Python, the same as the options of the program.
namespace espalier::python {

template <class Choice>
using Words = std::vector<std::pair<std::string, Choice>>;

/// The choice that a word names.
/// \throws Error naming the argument, the words that there are, and that which was given
template <class Choice>
Choice chosen(const Words<Choice>& words, const std::string& argument, const std::string& word) {
    std::string names;
    for (std::size_t i = 0; i < words.size(); ++i) {
        if (words[i].first == word) return words[i].second;
        names += (i == 0 ? "" : i + 1 == words.size() ? " or " : ", ") + words[i].first;
    }
    throw Error(argument + ": expected " + names + ", got \"" + printable(word) + "\"");
}

/// The word of a choice.
template <class Choice>
std::string wordOf(const Words<Choice>& words, Choice choice) {
    for (const auto& [word, each] : words)
        if (each == choice) return word;
    throw Error("a choice without a word");
}

}  // namespace espalier::python
