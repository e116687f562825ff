// SPDX-License-Identifier: Apache-2.0
#include <espalier/far/error.h>
#include <espalier/far/memory.h>
#include <espalier/io/coding_error.h>
#include <espalier/io/file.h>
#include <espalier/io/vtk_xml.h>

#include <algorithm>
#include <type_traits>

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

std::string VtkXmlFile::payload(const VtkDataArray& array,
                                std::optional<std::size_t> tuples) const {
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
        if (tuples)
            checkTuples(array, claimedSize(text, form, coding_) / byteSize(*array.type), *tuples);
        return decodePayload(text, form, coding_);
    } catch (const CodingError& error) {
        failIn(array, std::string("cannot be decoded: ") + error.what());
    } catch (const far::MemoryError& error) {
        throw far::MemoryError(nameOf(array) + ": " + error.what());
    }
}

template <class Value>
std::vector<Value> VtkXmlFile::values(const VtkDataArray& array,
                                      std::optional<std::size_t> tuples) const {
    if (!array.type) failIn(array, "does not hold numbers that can be read");
    if (std::is_integral_v<Value> && !isInteger(*array.type))
        failIn(array, std::string("holds ") + xmlName(*array.type) + "; expected integers");
    std::vector<Value> values;
    if (array.format == VtkDataArray::Format::Ascii) {
        values = inlineText<Value>(array);
    } else {
        const std::string bytes = payload(array, tuples);
        if (bytes.size() % byteSize(*array.type) != 0)
            failIn(array, "has " + std::to_string(bytes.size()) +
                              " bytes, which are not a whole number of " + xmlName(*array.type));
        far::requireMemory(bytes.size() / byteSize(*array.type) * sizeof(Value), nameOf(array));
        values = decodeNumbers<Value>(bytes, *array.type, coding_.byteOrder);
    }
    if (values.size() % array.components != 0)
        failIn(array, "has " + std::to_string(values.size()) +
                          " numbers, which are not a whole number of tuples of " +
                          std::to_string(array.components));
    if (tuples) checkTuples(array, values.size(), *tuples);
    return values;
}

void VtkXmlFile::checkTuples(const VtkDataArray& array, std::size_t got, std::size_t tuples) const {
    if (got / array.components != tuples)
        failIn(array, "has " + std::to_string(got) + " numbers; expected " +
                          std::to_string(tuples) + " times " + std::to_string(array.components));
}

std::vector<double> VtkXmlFile::reals(const VtkDataArray& array) const {
    return values<double>(array);
}

std::vector<std::int64_t> VtkXmlFile::integers(const VtkDataArray& array) const {
    return values<std::int64_t>(array);
}

std::vector<double> VtkXmlFile::reals(const VtkDataArray& array, std::size_t tuples) const {
    return values<double>(array, tuples);
}

std::vector<std::int64_t> VtkXmlFile::integers(const VtkDataArray& array,
                                               std::size_t tuples) const {
    return values<std::int64_t>(array, tuples);
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
