// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <espalier/base/api.h>
#include <espalier/base/error.h>

#include <cstdint>
#include <string>

namespace espalier {

/// More memory than a MemoryLimit allows.
class ESPALIER_API MemoryError : public Error {
public:
    using Error::Error;
};

/// While this object lives, work that takes the process beyond so many bytes of memory is refused:
/// the call throws MemoryError, and all objects are as they were before it.
///
/// Where the size of something is known beforehand (levels of a lattice, tables, what a file
/// claims), it is refused before memory is taken for it. Where it is not, what the process holds is
/// looked at every few milliseconds, between the ranges of parallel loops. So memory stays below
/// the limit but for what a few ranges take.
///
/// Counts what the process holds in memory, whoever took it. Of several limits the lowest counts;
/// they hold for the whole process. Without one, memory is as the system gives it, and the library
/// throws std::bad_alloc where there is no more.
class ESPALIER_API MemoryLimit {
public:
    explicit MemoryLimit(std::uint64_t bytes);
    ~MemoryLimit();
    MemoryLimit(const MemoryLimit&) = delete;
    MemoryLimit& operator=(const MemoryLimit&) = delete;

private:
    std::uint64_t bytes_;
};

/// Bytes that this process holds in memory (its resident set); 0 where the system does not say.
ESPALIER_API std::uint64_t residentMemory();

/// For work that is about to take memory, and knows how much.
/// \param bytes at least, beside what is held already; a size that overflows is the largest number
/// \param what takes it, for the message: "level 15"
/// \throws MemoryError if that is beyond the limit
ESPALIER_API void requireMemory(std::uint64_t bytes, const std::string& what);

/// For work that goes on, and does not know how much it will take.
/// \throws MemoryError if the process holds more than the limit
/// \cost without a limit nothing; with one, a look at the clock, and at the memory if some
///       milliseconds have passed since the last look
ESPALIER_API void checkMemory();

/// 1536 → "1.5 kB".
ESPALIER_API std::string formatBytes(std::uint64_t bytes);

}  // namespace espalier
