// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <espalier/base/error.h>

namespace espalier::io {

/// Coded data that cannot be decoded. what() is the cause only; whoever knows the file and the line
/// makes a FileError of it.
class CodingError : public Error {
public:
    using Error::Error;
};

}  // namespace espalier::io
