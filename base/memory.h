// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <espalier/base/api.h>
#include <espalier/base/error.h>

#include <cstddef>
#include <cstdint>
#include <limits>
#include <optional>
#include <string>

/// \file
/// Limits the memory that the process may use.

namespace espalier {

/// Thrown when work needs more memory than a MemoryLimit allows.
class ESPALIER_API MemoryError : public Error {
public:
    using Error::Error;
};

/// Limits the memory of the process while this object lives. A call that would need more throws
/// MemoryError and leaves all objects unchanged.
///
/// If a size is known beforehand (levels of a lattice, tables, sizes that a file claims), it is
/// checked before memory is allocated. Otherwise the memory of the process is checked every few
/// milliseconds, between the ranges of parallel loops. So the process may exceed the limit by the
/// memory of a few ranges.
///
/// All memory that the process holds is counted, whoever allocated it. Limits apply to the whole
/// process; if there are several, the lowest one applies. Without a limit, the library throws
/// std::bad_alloc when the system has no more memory.
class ESPALIER_API MemoryLimit {
public:
    explicit MemoryLimit(std::uint64_t bytes);
    ~MemoryLimit();
    MemoryLimit(const MemoryLimit&) = delete;
    MemoryLimit& operator=(const MemoryLimit&) = delete;

private:
    std::uint64_t bytes_;
};

/// Returns the limit that applies to this process; nothing if there is none.
ESPALIER_API std::optional<std::uint64_t> memoryLimit();

/// Returns the bytes that this process holds in memory (its resident set); 0 if the system does not
/// tell.
ESPALIER_API std::uint64_t residentMemory();

/// Throws if work that is about to allocate memory would exceed the limit, or what an address of
/// this machine can reach.
/// \param bytes a lower bound of the memory that the work will add; if it overflows, pass the
///        largest number
/// \param what the work, for the message: "level 15"
/// \throws MemoryError
ESPALIER_API void requireMemory(std::uint64_t bytes, const std::string& what);

/// Throws if the process exceeds the limit. Call it in work whose memory is not known in advance.
/// \throws MemoryError
/// \cost nothing without a limit. With a limit, one query of the clock, and one of the memory if
/// some milliseconds have passed since the last one
ESPALIER_API void checkMemory();

/// Returns a size as text: 1536 becomes "1.5 kB".
ESPALIER_API std::string formatBytes(std::uint64_t bytes);

/// Returns a number of values, of one byte or more each, as a size in memory.
/// \throws MemoryError if no address of this machine reaches so far, as may happen with 32 bits
inline std::size_t sizeInMemory(std::uint64_t count) {
    if (count > std::numeric_limits<std::size_t>::max())
        requireMemory(count, concat(count, " values"));
    return static_cast<std::size_t>(count);
}

}  // namespace espalier
