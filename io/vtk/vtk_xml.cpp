// SPDX-License-Identifier: Apache-2.0
#include <espalier/base/error.h>
#include <espalier/base/memory.h>
#include <espalier/io/files/file.h>

#include <algorithm>
#include <type_traits>

#include "../files/coding_error.h"
#include "vtk_xml.h"

namespace espalier::io {

const VtkDataArray* VtkSection::find(std::string_view name) const {
    const auto at = std::find_if(arrays.begin(), arrays.end(),
                                 [&](const VtkDataArray& array) { return array.name == name; });
    return at == arrays.end() ? nullptr : &*at;
}

std::size_t VtkXmlFile::count(const VtkPiece& piece, const std::string& name) const {
    const auto at = piece.counts.find(name);
    if (at == piece.counts.end()) fail(piece.line, "the Piece has no " + name);
    return at->second;
}

const VtkSection& VtkXmlFile::section(const VtkPiece& piece, const std::string& name) const {
    const auto at = piece.sections.find(name);
    if (at == piece.sections.end()) fail(piece.line, "the Piece has no " + name);
    return at->second;
}

const VtkDataArray& VtkXmlFile::array(const VtkSection& section, const std::string& name) const {
    const VtkDataArray* array = section.find(name);
    if (!array) fail(section.line, "there is no array " + inQuotes(name));
    return *array;
}

template <class Value>
std::vector<Value> VtkXmlFile::inlineText(const VtkDataArray& array) const {
    const std::string_view bytes = bytes_;
    const std::string_view tag = bytes.substr(array.begin, array.contentBegin - array.begin);
    const auto tagLines = static_cast<std::size_t>(std::count(tag.begin(), tag.end(), '\n'));
    TextReader text(path_, bytes.substr(array.contentBegin, array.contentEnd - array.contentBegin),
                    array.line + tagLines);
    const std::string what = "a number of the array " + inQuotes(array.name);
    std::vector<Value> values;
    while (!text.atEnd()) values.push_back(readNumber<Value>(text, *array.type, what.c_str()));
    return values;
}

std::string VtkXmlFile::payload(const VtkDataArray& array, const Expected& expected) const {
    if (!unknownCompressor_.empty())
        failIn(array, "is compressed with " + inQuotes(unknownCompressor_) +
                          "; only vtkZLibDataCompressor and no compressor can be read");
    const std::string_view bytes = bytes_;
    const bool isAppended = array.format == VtkDataArray::Format::Appended;
    if (isAppended && array.offset > appendedEnd_ - appendedBegin_)
        failIn(array, "begins at offset " + std::to_string(array.offset) +
                          " of the appended data, which have " +
                          std::to_string(appendedEnd_ - appendedBegin_) + " bytes");
    const std::size_t begin = isAppended ? appendedBegin_ + array.offset : array.contentBegin;
    const std::size_t end = isAppended ? appendedEnd_ : array.contentEnd;
    const std::string_view text = bytes.substr(begin, end - begin);
    // Writers leave out the header of an array that holds nothing.
    if (text.find_first_not_of(" \t\r\n") == std::string_view::npos) return {};
    try {
        const PayloadForm form = isAppended ? appendedForm_ : PayloadForm::Base64;
        // A small file can claim a large array: the claim is compared before anything is inflated.
        checkCount(array, claimedSize(text, form, coding_) / byteSize(*array.type), expected);
        return decodePayload(text, form, coding_);
    } catch (const CodingError& error) {
        failIn(array, std::string("cannot be decoded: ") + error.what());
    } catch (const MemoryError& error) {
        throw MemoryError(nameOf(array) + ": " + error.what());
    }
}

template <class Value>
std::vector<Value> VtkXmlFile::values(const VtkDataArray& array, const Expected& expected) const {
    if (!array.type) failIn(array, "does not hold numbers that can be read");
    if (std::is_integral_v<Value> && !isInteger(*array.type))
        failIn(array, std::string("holds ") + xmlName(*array.type) + "; expected integers");
    std::vector<Value> values;
    if (array.format == VtkDataArray::Format::Ascii) {
        values = inlineText<Value>(array);
    } else {
        const std::string bytes = payload(array, expected);
        if (bytes.size() % byteSize(*array.type) != 0)
            failIn(array, "has " + std::to_string(bytes.size()) +
                              " bytes, which are not a whole number of " + xmlName(*array.type));
        requireMemory(bytes.size() / byteSize(*array.type) * sizeof(Value), nameOf(array));
        values = decodeNumbers<Value>(bytes, *array.type, coding_.byteOrder);
    }
    if (values.size() % array.components != 0)
        failIn(array, "has " + std::to_string(values.size()) +
                          " numbers, which are not a whole number of tuples of " +
                          std::to_string(array.components));
    checkCount(array, values.size(), expected);
    return values;
}

void VtkXmlFile::checkCount(const VtkDataArray& array, std::size_t got,
                            const Expected& expected) const {
    const std::size_t tuples = got / expected.components;
    if (tuples >= expected.leastTuples && tuples <= expected.mostTuples) return;
    std::string text = "has " + std::to_string(got) + " numbers; expected ";
    if (expected.leastTuples < expected.mostTuples) text += "at most ";
    text += std::to_string(expected.mostTuples);
    if (expected.components > 1) text += " times " + std::to_string(expected.components);
    if (!expected.reason.empty()) text += ", " + std::string(expected.reason);
    failIn(array, text);
}

std::vector<double> VtkXmlFile::reals(const VtkDataArray& array, std::size_t tuples,
                                      std::string_view reason) const {
    return values<double>(array, {tuples, tuples, array.components, reason});
}

std::vector<std::int64_t> VtkXmlFile::integers(const VtkDataArray& array, std::size_t tuples,
                                               std::string_view reason) const {
    return values<std::int64_t>(array, {tuples, tuples, array.components, reason});
}

std::vector<std::int64_t> VtkXmlFile::list(const VtkDataArray& array, std::size_t count,
                                           std::string_view reason) const {
    return values<std::int64_t>(array, {count, count, 1, reason});
}

std::vector<std::int64_t> VtkXmlFile::integersUpTo(const VtkDataArray& array,
                                                   std::size_t mostTuples,
                                                   std::string_view reason) const {
    return values<std::int64_t>(array, {0, mostTuples, array.components, reason});
}

void VtkXmlFile::fail(std::size_t line, const std::string& cause) const {
    throw FileError(path_, line, cause);
}

std::string VtkXmlFile::nameOf(const VtkDataArray& array) const {
    return shownPath(path_) + ":" + std::to_string(array.line) + ": the array " +
           inQuotes(array.name);
}

void VtkXmlFile::failIn(const VtkDataArray& array, const std::string& cause) const {
    fail(array.line, "the array " + inQuotes(array.name) + " " + cause);
}

}  // namespace espalier::io
