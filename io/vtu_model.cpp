// SPDX-License-Identifier: Apache-2.0
#include <espalier/io/coding_error.h>
#include <espalier/io/coordinates.h>
#include <espalier/io/file.h>
#include <espalier/io/point_arrays.h>
#include <espalier/io/vtk_xml_writer.h>
#include <espalier/io/vtu_model.h>

#include <algorithm>
#include <ostream>

namespace espalier::io {
namespace {

/// What stands before an element on its line, if that is white space only.
std::string_view indentOf(std::string_view bytes, std::size_t begin) {
    const std::size_t lineBegin = bytes.rfind('\n', begin) + 1;
    const std::string_view before = bytes.substr(lineBegin, begin - lineBegin);
    return before.find_first_not_of(" \t") == std::string_view::npos ? before : "";
}

/// The points as an array of their file holds them.
std::vector<Point3> rounded(std::span<const Point3> points, VtkNumber type,
                            std::size_t firstPoint) {
    std::vector<Point3> result(points.begin(), points.end());
    if (type == VtkNumber::Float32)
        for (std::size_t i = 0; i < result.size(); ++i)
            for (double& coordinate : result[i])
                coordinate = roundTo(Precision::Float, coordinate, firstPoint + i);
    return result;
}

std::string pointElement(const VtkXmlFile& file, const VtkDataArray& array, VtkNumber type,
                         std::span<const Point3> points) {
    const auto form =
        array.format == VtkDataArray::Format::Ascii ? VtkArrayForm::Ascii : VtkArrayForm::Base64;
    return dataArrayElement<double>({array.name, type, 3}, coordinatesOf(points), form,
                                    file.coding(), indentOf(file.bytes(), array.begin));
}

}  // namespace

VtuModel VtuModel::read(const std::filesystem::path& path) {
    return read(path, readFile(path));
}

VtuModel VtuModel::read(const std::filesystem::path& path, std::string bytes) {
    VtuModel model(VtkXmlFile::read(path, std::move(bytes), "UnstructuredGrid"));
    for (const VtkPiece& piece : model.file_.pieces()) {
        const std::size_t first = model.positions_.size();
        const std::vector<Point3> points = readPoints(model.file_, piece);
        if (points.empty()) continue;
        model.positions_.insert(model.positions_.end(), points.begin(), points.end());
        model.arrays_.push_back({pointArray(model.file_, piece), first, points.size()});
    }
    checkFinite(path, model.positions_);
    return model;
}

void VtuModel::write(const std::filesystem::path& path, std::span<const Point3> positions) const {
    if (positions.size() != positions_.size())
        throw Error("got " + std::to_string(positions.size()) + " positions for a model of " +
                    std::to_string(positions_.size()) + " points");
    const std::string_view bytes = file_.bytes();
    writeFile(path, [&](std::ostream& out) {
        std::size_t done = 0;
        for (const PointArray& points : arrays_) {
            const VtkDataArray& array = points.array;
            const VtkNumber type = isInteger(*array.type) ? VtkNumber::Float64 : *array.type;
            const std::vector<Point3> moved = rounded(
                positions.subspan(points.firstPoint, points.pointCount), type, points.firstPoint);
            if (std::equal(moved.begin(), moved.end(),
                           positions_.begin() + static_cast<std::ptrdiff_t>(points.firstPoint)))
                continue;
            out << bytes.substr(done, array.begin - done);
            try {
                out << pointElement(file_, array, type, moved);
            } catch (const CodingError& error) {
                throw FileError(path, error.what());
            }
            done = array.end;
        }
        out << bytes.substr(done);
    });
}

}  // namespace espalier::io
