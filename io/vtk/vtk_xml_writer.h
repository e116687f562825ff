// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "vtk_numbers.h"
#include "vtk_payload.h"

#include <cstddef>
#include <span>
#include <string>
#include <string_view>

namespace espalier::io {

/// How an inline array is written.
enum class VtkArrayForm { Ascii, Base64 };

/// The attributes of a DataArray element.
struct VtkArrayHead {
    std::string name;
    VtkNumber type = VtkNumber::Float64;
    std::size_t components = 1;
    bool hasTupleCount = false;  ///< as arrays of FieldData need it
};

/// A DataArray element with its numbers in it, from "<DataArray" to "</DataArray>".
///
/// \tparam Value double for real types, std::int64_t for integers, within the range of the type
/// \param indent is put before each line but the first
/// \param coding of the file that the element is for
/// \throws CodingError if the array is too large for the file's header_type
template <class Value>
std::string dataArrayElement(const VtkArrayHead& head, std::span<const Value> values,
                             VtkArrayForm form, const VtkCoding& coding, std::string_view indent);

/// Whether XML 1.0 can hold a text (section 2.2): UTF-8 without control characters, but for tabs
/// and line ends, and without U+FFFE and U+FFFF.
bool isXmlText(std::string_view text);

/// A text as the value of an XML attribute. \param text such as isXmlText() accepts
std::string xmlEscaped(std::string_view text);

}  // namespace espalier::io
