// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <espalier/base/api.h>

#include <stdexcept>
#include <string>
#include <string_view>

namespace espalier {

/// Base of every exception that Espalier throws on purpose but Cancelled (progress.h), which
/// is nobody's mistake. what() is one line that names the offender; the library never prints and
/// never aborts.
class ESPALIER_API Error : public std::runtime_error {
public:
    using std::runtime_error::runtime_error;
};

/// A word or a name from outside as messages show it: printable (printable.h), in quotes. One of
/// more than 40 bytes keeps its beginning and its end.
ESPALIER_API std::string inQuotes(std::string_view text);

}  // namespace espalier
