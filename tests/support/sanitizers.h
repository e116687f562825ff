// SPDX-License-Identifier: Apache-2.0
#pragma once

namespace espalier::test {

/// Whether this is a build under the address sanitizer, which takes ten times as long. A test that
/// goes through many shapes may leave some out there: what it is for is their memory, not their
/// numbers.
#ifdef __SANITIZE_ADDRESS__
inline constexpr bool kIsSlow = true;
#else
inline constexpr bool kIsSlow = false;
#endif

}  // namespace espalier::test
