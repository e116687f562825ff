// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <espalier/base/index.h>

namespace espalier::osd {

/// How the values of an entry lie in a buffer of numbers, as OpenSubdiv's Osd::BufferDescriptor:
/// component c of entry i is at offset + i·stride + c.
struct BufferDescriptor {
    Offset offset = 0;  ///< of the first component of entry 0; 0 to the size
    Offset length = 0;  ///< components an entry; 1 to 2³¹ − 1
    Offset stride = 0;  ///< from one entry to the next; at least `length`

    /// Entries of `length` components, one behind the other.
    static BufferDescriptor packed(Offset length) { return {0, length, length}; }
};

}  // namespace espalier::osd
