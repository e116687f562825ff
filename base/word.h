// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string_view>

namespace espalier {

/// The word of a choice. The program and the Python module take the words of an array of these,
/// which stands beside the enumeration: far::kBoundaryWords, for example.
template <class Choice>
struct Word {
    std::string_view text;
    Choice choice;
};

}  // namespace espalier
