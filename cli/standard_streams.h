// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <system_error>

namespace espalier::cli {

/// Occupies the numbers of standard streams that are closed, so that no file gets such a number and
/// is overwritten by output. Using such a stream remains an error. Call this before anything else
/// in main().
void holdStandardStreams();

/// Flushes standard output.
/// \throws std::system_error if this fails, or an earlier write has failed
void flushOutput();

/// Prints "espalier: cause" to standard error, in one printable line; or "out of memory" if there
/// is no memory for it. Does nothing if standard error cannot be written to.
void printError(const char* cause) noexcept;

/// Does the same for a cause that is known to be printable. Allocates nothing.
void printPrintableError(const char* cause) noexcept;

/// Prints an error of the system. Says so if it is standard output that has failed.
void printError(const std::system_error& error) noexcept;

}  // namespace espalier::cli
