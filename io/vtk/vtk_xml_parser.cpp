// SPDX-License-Identifier: Apache-2.0
#include <espalier/base/error.h>
#include <espalier/base/memory.h>
#include <espalier/io/files/file.h>

#include <algorithm>
#include <limits>
#include <new>
#include <pugixml.hpp>
#include <utility>

#include "vtk_xml.h"

namespace espalier::io {
namespace {

/// Finds the line number of a byte. Successive calls must have ascending offsets.
class LineCounter {
public:
    explicit LineCounter(std::string_view text) : text_(text) {}

    std::size_t at(std::size_t offset) {
        for (; position_ < std::min(offset, text_.size()); ++position_)
            if (text_[position_] == '\n') ++line_;
        return line_;
    }

private:
    std::string_view text_;
    std::size_t position_ = 0;
    std::size_t line_ = 1;
};

/// Returns the offset after the ">" of the tag that begins at `begin`; the end of the text if there
/// is no ">".
std::size_t endOfTag(std::string_view text, std::size_t begin) {
    char quote = 0;
    for (std::size_t at = begin; at < text.size(); ++at) {
        const char c = text[at];
        if (quote == 0 && c == '>') return at + 1;
        if (quote == 0 && (c == '"' || c == '\''))
            quote = c;
        else if (c == quote)
            quote = 0;
    }
    return text.size();
}

/// Returns the offset of a closing tag, "</DataArray", outside other tags and comments; the end of
/// the text if there is none.
std::size_t offsetOfClosingTag(std::string_view text, std::size_t from, std::string_view tag) {
    while (true) {
        const std::size_t at = text.find('<', from);
        if (at == std::string_view::npos) return text.size();
        const std::string_view rest = text.substr(at);
        if (rest.starts_with(tag)) return at;
        const std::string_view end = rest.starts_with("<!--")  ? "-->"
                                     : rest.starts_with("<![") ? "]]>"
                                                               : "";
        from = end.empty() ? endOfTag(text, at) : std::min(text.find(end, at), text.size());
    }
}

}  // namespace

/// Fills a VtkXmlFile from its bytes.
class VtkXmlParser {
public:
    explicit VtkXmlParser(VtkXmlFile& file) : file_(file), lines_(file.bytes_) {}

    void parse(const std::string& dataSet) {
        std::string head = cutAppendedData();
        // pugixml would stop at a byte 0.
        if (const std::size_t zero = head.find('\0'); zero != std::string::npos)
            failAt(offsetInFile(zero), "is not well-formed XML: it holds a byte 0");
        pugi::xml_document document;
        const pugi::xml_parse_result result = document.load_buffer_inplace(
            head.data(), head.size(), pugi::parse_default | pugi::parse_fragment,
            pugi::encoding_utf8);
        if (result.status == pugi::status_out_of_memory) throw std::bad_alloc();
        if (!result)
            failAt(offsetInFile(result.offset),
                   std::string("is not well-formed XML: ") + result.description());
        const pugi::xml_node root = document.child("VTKFile");
        if (!root) file_.fail(1, "is not a VTK XML file: it has no VTKFile element");
        for (const pugi::xml_node node : document.children())
            if (node != root)
                failAt(offsetInFile(textBegin(node)),
                       "there is more than a VTKFile element; expected nothing but comments before "
                       "and after it");
        readRoot(root, dataSet);
        readAppended(root.child("AppendedData"));
        readDataSet(root.child(dataSet.c_str()));
    }

private:
    /// Returns the offset in the parsed text where an element begins, or a text without its leading
    /// white space.
    static std::size_t textBegin(pugi::xml_node node) {
        const std::string_view text = node.value();
        return node.offset_debug() + std::min(text.find_first_not_of(" \t\r\n"), text.size());
    }

    /// Returns the file without its appended data, which need not be XML, and stores where the data
    /// is.
    std::string cutAppendedData() {
        const std::string_view bytes = file_.bytes_;
        const std::size_t tag = bytes.find("<AppendedData");
        if (tag == std::string_view::npos) return file_.bytes_;
        const std::size_t begin = endOfTag(bytes, tag);
        if (bytes[begin - 1] != '>') failAt(tag, "the file ends inside the AppendedData tag");
        if (bytes[begin - 2] == '/') return file_.bytes_;
        // The data are found by their offsets. VTK needs no tag after them, and some programs write
        // none; arrays that a cut file lacks are errors when they are read.
        const auto lastTag = [&](std::string_view name) {
            const std::size_t at = bytes.rfind(name);
            return at == std::string_view::npos || at < begin ? bytes.size() : at;
        };
        const std::size_t rootEnd = lastTag("</VTKFile");
        const std::size_t ownEnd = lastTag("</AppendedData");
        const std::size_t end = std::min(ownEnd, rootEnd);
        std::string rest = ownEnd == bytes.size() ? "</AppendedData>" : "";
        rest += bytes.substr(end);
        if (rootEnd == bytes.size()) rest += "</VTKFile>";
        const std::size_t mark = bytes.find_first_not_of(" \t\r\n", begin);
        if (mark >= end || bytes[mark] != '_')
            failAt(tag, "the appended data do not begin with '_'");
        file_.appendedBegin_ = mark + 1;
        file_.appendedEnd_ = end;
        cutBegin_ = begin;
        cutSize_ = end - begin;
        return std::string(bytes.substr(0, begin)) + rest;
    }

    void readRoot(pugi::xml_node root, const std::string& dataSet) {
        const std::string type = root.attribute("type").value();
        const std::size_t line = lineOf(root);
        if (type != dataSet) file_.fail(line, "holds " + inQuotes(type) + "; expected " + dataSet);
        if (!root.child(dataSet.c_str())) file_.fail(line, "has no " + dataSet + " element");
        file_.coding_.byteOrder = choose(root, "byte_order", {"LittleEndian", "BigEndian"}) == 0
                                      ? std::endian::little
                                      : std::endian::big;
        file_.coding_.has64BitHeader = choose(root, "header_type", {"UInt32", "UInt64"}) == 1;
        const std::string compressor = root.attribute("compressor").value();
        file_.coding_.isCompressed = compressor == "vtkZLibDataCompressor";
        if (!file_.coding_.isCompressed) file_.unknownCompressor_ = compressor;
    }

    /// Returns the position of an attribute's value in the list of allowed values; 0, the default,
    /// if the attribute is missing.
    std::size_t choose(pugi::xml_node node, const char* name,
                       std::initializer_list<std::string_view> values) {
        const std::string_view value = node.attribute(name).value();
        if (value.empty()) return 0;
        const auto at = std::find(values.begin(), values.end(), value);
        if (at != values.end()) return at - values.begin();
        std::string expected;
        for (const std::string_view one : values)
            expected += (expected.empty() ? "" : " or ") + std::string(one);
        file_.fail(lineOf(node),
                   std::string(name) + " is " + inQuotes(value) + "; expected " + expected);
    }

    void readAppended(pugi::xml_node appended) {
        if (!appended) return;
        const std::string_view encoding = appended.attribute("encoding").value();
        if (encoding == "base64")
            file_.appendedForm_ = PayloadForm::Base64;
        else if (encoding != "raw")
            failAt(offsetOf(appended), "the encoding of the appended data is " +
                                           inQuotes(encoding) + "; expected raw or base64");
    }

    void readDataSet(pugi::xml_node dataSet) {
        for (const pugi::xml_node child : dataSet.children()) {
            const std::string_view name = child.name();
            if (name == "FieldData") file_.fieldData_ = readSection(child);
            if (name == "Piece") file_.pieces_.push_back(readPiece(child));
        }
    }

    VtkPiece readPiece(pugi::xml_node node) {
        VtkPiece piece;
        piece.line = lineOf(node);
        for (const pugi::xml_attribute attribute : node.attributes()) {
            const std::string_view name = attribute.name();
            if (name.starts_with("NumberOf"))
                piece.counts[std::string(name)] = readCount(node, attribute);
        }
        for (const pugi::xml_node child : node.children())
            if (child.type() == pugi::node_element)
                piece.sections[child.name()] = readSection(child);
        return piece;
    }

    VtkSection readSection(pugi::xml_node node) {
        VtkSection section;
        section.line = lineOf(node);
        for (const pugi::xml_attribute attribute : node.attributes())
            section.active[attribute.name()] = attribute.value();
        for (const pugi::xml_node child : node.children()) {
            const std::string_view name = child.name();
            if (name == "DataArray" || name == "Array") section.arrays.push_back(readArray(child));
        }
        return section;
    }

    VtkDataArray readArray(pugi::xml_node node) {
        VtkDataArray array;
        array.line = lineOf(node);
        array.name = node.attribute("Name").value();
        if (std::string_view(node.name()) == "DataArray")
            array.type = numberOfXmlName(node.attribute("type").value());
        if (const auto components = node.attribute("NumberOfComponents"))
            array.components = std::max<std::size_t>(1, readCount(node, components));
        array.format = static_cast<VtkDataArray::Format>(
            choose(node, "format", {"ascii", "binary", "appended"}));
        if (array.format == VtkDataArray::Format::Appended)
            array.offset = readCount(node, node.attribute("offset"));
        findArrayEnds(array, offsetOf(node), node.name());
        return array;
    }

    void findArrayEnds(VtkDataArray& array, std::size_t begin, const char* element) {
        const std::string_view bytes = file_.bytes_;
        array.begin = begin;
        array.contentBegin = array.contentEnd = array.end = endOfTag(bytes, begin);
        if (bytes[array.end - 2] == '/') return;
        array.contentEnd = std::min(bytes.find('<', array.contentBegin), bytes.size());
        array.end = endOfTag(
            bytes, offsetOfClosingTag(bytes, array.contentEnd, std::string("</") + element));
    }

    std::size_t readCount(pugi::xml_node node, pugi::xml_attribute attribute) {
        std::uint64_t count = 0;
        if (!parseNumber(attribute.value(), count))
            file_.fail(lineOf(node), std::string(node.name()) + " has " +
                                         (attribute ? attribute.name() : "no offset") + " " +
                                         inQuotes(attribute.value()) + "; expected a whole number");
        return sizeInMemory(count);
    }

    /// Converts an offset in the text that pugixml parsed to an offset in the file.
    std::size_t offsetInFile(std::size_t offset) const {
        return offset < cutBegin_ ? offset : offset + cutSize_;
    }

    /// Returns the offset in the file of the "<" of an element.
    std::size_t offsetOf(pugi::xml_node node) const {
        return offsetInFile(node.offset_debug() - 1);
    }

    /// Returns the line of an element. Calls must follow the order of the file.
    std::size_t lineOf(pugi::xml_node node) { return lines_.at(offsetOf(node)); }

    [[noreturn]] void failAt(std::size_t offset, const std::string& cause) {
        file_.fail(LineCounter(file_.bytes_).at(offset), cause);
    }

    VtkXmlFile& file_;
    LineCounter lines_;
    std::size_t cutBegin_ = 0;
    std::size_t cutSize_ = 0;
};

VtkXmlFile VtkXmlFile::read(const std::filesystem::path& path, std::string bytes,
                            const std::string& dataSet) {
    VtkXmlFile file;
    file.path_ = path;
    file.bytes_ = std::move(bytes);
    VtkXmlParser(file).parse(dataSet);
    return file;
}

}  // namespace espalier::io
