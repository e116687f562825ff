// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string_view>

namespace espalier {

/// A choice and its word. An array of these beside each enumeration, such as far::kBoundaryWords,
/// gives the words that the program and the Python module accept.
template <class Choice>
struct Word {
    std::string_view text;
    Choice choice;
};

}  // namespace espalier
