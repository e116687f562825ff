// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <system_error>

namespace espalier::cli {

/// To be called first of all. A standard stream that is closed is taken up, so that no file that is
/// opened gets its number, and is written to in its stead. To use it is an error, as before.
void holdStandardStreams();

/// Hands all that was printed to the system.
/// \throws std::system_error if that fails, or has failed before
void flushOutput();

/// Says on standard error, in one printable line, what is wrong: "espalier: cause". Without memory
/// for a long line it says that instead. Does nothing if that stream cannot be written either.
void printError(const char* cause) noexcept;

/// The same of a cause that is printable as it is. Takes no memory.
void printPrintableError(const char* cause) noexcept;

/// The same of an error of the system: of standard output, if that is what has failed.
void printError(const std::system_error& error) noexcept;

}  // namespace espalier::cli
