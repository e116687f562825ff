// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string_view>

namespace espalier {

/// Pairs a constant of an enumeration with its word. An array of pairs beside each enumeration,
/// such as far::kBoundaryWords, gives the words that the program and the Python module accept.
template <class Choice>
struct Word {
    std::string_view text;
    Choice choice;
};

}  // namespace espalier
