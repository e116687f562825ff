// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <ostream>
#include <string>
#include <utility>
#include <vector>

#include "../files/number_types.h"
#include "vtk_xml.h"

namespace espalier::io {

/// Writes the elements of one of VTK's XML files, each on separate lines. Files are little-endian,
/// with headers of 64 bits.
class VtkXmlOutput {
public:
    /// \param dataSet type of the data set: "UnstructuredGrid"
    VtkXmlOutput(std::ostream& out, std::string dataSet, VtkArrayForm form, bool isCompressed)
        : out_(out), dataSet_(std::move(dataSet)), form_(form) {
        coding_.isCompressed = isCompressed;
    }

    /// Writes the whole file: calls content(), which writes the sections and the piece.
    template <class Content>
    void file(Content content) {
        out_ << "<?xml version=\"1.0\"?>\n<VTKFile type=\"" << dataSet_
             << "\" version=\"1.0\" byte_order=\"LittleEndian\" header_type=\"UInt64\""
             << (coding_.isCompressed ? " compressor=\"vtkZLibDataCompressor\"" : "") << ">\n  <"
             << dataSet_ << ">\n";
        content();
        out_ << "  </" << dataSet_ << ">\n</VTKFile>\n";
    }

    /// Writes the piece of the file, whose sections content() writes.
    /// \param cellsName "Cells" or "Polys"
    template <class Content>
    void piece(std::size_t pointCount, const char* cellsName, std::size_t cellCount,
               Content content) {
        out_ << "    <Piece NumberOfPoints=\"" << pointCount << "\" NumberOf" << cellsName << "=\""
             << cellCount << "\">\n";
        content();
        out_ << "    </Piece>\n";
    }

    /// Writes a section, whose arrays content() writes.
    /// \param attributes text after the name of the element
    template <class Content>
    void section(const std::string& name, Content content, const std::string& attributes = {}) {
        out_ << "      <" << name << attributes << ">\n";
        content();
        out_ << "      </" << name << ">\n";
    }

    template <class Value>
    void array(const VtkArrayHead& head, const std::vector<Value>& values) {
        constexpr const char* kIndent = "        ";
        out_ << kIndent << dataArrayElement<Value>(head, values, form_, coding_, kIndent) << "\n";
    }

    void array(const std::string& name, std::size_t components, const std::vector<double>& values) {
        array<double>({name, NumberType::Float64, components}, values);
    }

    void array(const std::string& name, const std::vector<std::int64_t>& values) {
        array<std::int64_t>({name, NumberType::Int64}, values);
    }

    void array(const std::string& name, const std::vector<std::uint8_t>& values) {
        array<std::uint8_t>({name, NumberType::UInt8}, values);
    }

    void array(const std::string& name, const std::vector<Index>& values) {
        array<Index>({name, NumberType::Int64}, values);
    }

private:
    std::ostream& out_;
    std::string dataSet_;
    VtkArrayForm form_;
    VtkCoding coding_;
};

}  // namespace espalier::io
