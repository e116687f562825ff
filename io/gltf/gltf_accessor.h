// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <espalier/base/index.h>
#include <espalier/base/point.h>

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "../files/number_types.h"
#include "gltf_file.h"

// Accessors of glTF: typed numbers in a view of a buffer (glTF 2.0 Specification, section 3.6.2).

namespace espalier::io {

/// The description of an accessor, checked against the size of its buffer.
struct GltfAccessor {
    NumberType type = NumberType::Float32;
    std::size_t components = 3;  ///< numbers of an element: 3 for "VEC3"
    std::size_t count = 0;       ///< number of elements
    bool isNormalized = false;   ///< integers stand for numbers from -1 or 0 to 1
    bool isSparse = false;       ///< some elements are elsewhere

    /// Where the elements are; without a view, they are zero.
    struct View {
        std::size_t buffer = 0;
        std::size_t offset = 0;  ///< of the first element in the buffer
        std::size_t stride = 0;  ///< bytes from an element to the next
    };
    std::optional<View> view;

    std::size_t elementSize() const { return components * byteSize(type); }

    /// Returns true if its elements are plain floats that can be replaced where they are.
    bool isPlain() const { return view && !isSparse && type == NumberType::Float32; }

    /// Bytes from the first element to the end of the last.
    std::size_t extent() const {
        return count == 0 ? 0 : (count - 1) * view->stride + elementSize();
    }
};

/// Reads the description of an accessor.
/// \throws FileError if it does not exist, is malformed, or reaches beyond its view or buffer
GltfAccessor accessorOf(const GltfFile& file, std::size_t index);

/// Reads all numbers, one element after the other. Normalized integers become numbers from -1 or 0
/// to 1.
/// \throws FileError as accessorOf()
std::vector<double> numbersOf(const GltfFile& file, std::size_t index);

/// Reads the vectors of an accessor of three components, or the first three of four.
/// \param count expected number of elements
/// \param what for messages: "normals"
/// \throws FileError as accessorOf(), or if it has another type or count
std::vector<Point3> vectorsOf(const GltfFile& file, std::size_t index, const char* what,
                              std::optional<std::size_t> count = std::nullopt);

/// Reads the corners of a primitive.
/// \param count expected upper bound of the indices
/// \throws FileError as accessorOf(), or if it does not hold integers below `count`
std::vector<Index> indicesOf(const GltfFile& file, std::size_t index, std::size_t count);

/// Says whether other parts of a file use the numbers of an accessor.
struct GltfOwnership {
    bool isOwn = false;    ///< nothing else names the accessor
    bool isAlone = false;  ///< no other accessor has bytes of it
};

/// Replaces the first three numbers of all elements: where they are if they are floats that nothing
/// else uses; otherwise as floats in a new view, of this accessor or a new one. Updates the bounds.
/// \return number of the accessor that has the vectors
std::size_t writeVectors(GltfEdit& edit, const GltfFile& file, std::size_t index,
                         std::span<const Point3> vectors, GltfOwnership ownership);

/// Returns for each accessor of the file whether some of its bytes belong to another one, too.
/// \cost O(n log n) for n accessors that do not overlap
std::vector<bool> overlappingAccessors(const GltfFile& file);

}  // namespace espalier::io
