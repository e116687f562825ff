// SPDX-License-Identifier: Apache-2.0
#pragma once

namespace espalier::cli {

/// What the memory gives: bytes a second of a = b + s · c over three arrays of floats, 768 MB in
/// all so that no cache holds them. Counts two reads and one write a number.
///
/// \param threads at most
/// \param seconds for repeated runs, of which the quickest counts
double triadBytesPerSecond(int threads, double seconds);

}  // namespace espalier::cli
