// SPDX-License-Identifier: Apache-2.0
#include <espalier/base/error.h>
#include <espalier/base/point.h>
#include <espalier/io/files/file.h>

#include <algorithm>
#include <array>
#include <filesystem>
#include <ostream>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "file_model.h"
#include "ply_header.h"
#include "ply_rows.h"
#include "surface_writers.h"

// PLY: ASCII, or binary of either byte order. Its points are the properties x,
// y and z of the element `vertex`, of type float or double. All other data is kept and not
// interpreted.
//
// The properties nx, ny and nz are a normal, and tx, ty and tz a tangent, if each of the three
// exists once and is a float or a double. In these properties a word that is no number is not an
// error.
//
// Likewise scale_0 to scale_2, rot_0 to rot_3 and, if there are 9, 24 or 45 of them, f_rest_0,
// f_rest_1, ... are a Gaussian splat (splats.h), in any order, if the vertices have no lists. Most
// programs write the normal 0 0 0 for each splat. If all normals of splats are 0, they do not
// count.
//
// The faces are the rows of the element `face`: its lists `vertex_indices` or `vertex_index`. The
// same lists of the element `tristrips` are strips of triangles: a strip ends at -1 or with its
// list, and every second triangle is wound the other way.
//
// The file must have exactly the rows that its header claims. In ASCII a row is a line; empty
// lines between and after rows are kept and ignored. In binary one line end may follow the rows.
//
// Lines of the header whose first word is not in the description of the format are kept, and a note
// counts them. So are further words in ASCII rows of elements other than `vertex`.
//
// Refused: x, y or z of an integer type, which could not hold a deformed position.

namespace espalier::io {
namespace {

bool isZero(const FileVectors& vectors) {
    return std::ranges::all_of(vectors.values,
                               [](const Point3& value) { return value == Point3{}; });
}

FileNumbers readPlyNumbers(const std::filesystem::path& path, std::string_view bytes) {
    const PlyHeader header = parsePlyHeader(path, bytes);
    FileNumbers numbers = readPlyRows(path, bytes, header);
    if (header.format != PlyFormat::Ascii) numbers.order = header.byteOrder();
    const auto& precisions = numbers.points.precisions;
    numbers.storage = storageOf(*std::min_element(precisions.begin(), precisions.end()));
    if (!header.oddLines.empty())
        numbers.notes.push_back("kept " + header.oddLines.phrase("whose first word no header of "
                                                                 "a PLY has"));
    if (!numbers.splats.rows.empty()) std::erase_if(numbers.directions, isZero);
    return numbers;
}

/// Returns true for a colour that is stored as a byte.
bool isColorByte(const PlyProperty& property) {
    constexpr std::string_view kColors[] = {"red", "green", "blue", "alpha"};
    return property.type == NumberType::UInt8 && std::ranges::count(kColors, property.name) > 0;
}

/// Reads one property of the points. Bytes of colours become 0 to 1.
std::vector<double> readPlyProperty(const FileView& file, std::size_t column) {
    const PlyHeader header = parsePlyHeader(file.path, file.bytes);
    PlyColumn numbers{column, {}};
    readPlyRows(file.path, file.bytes, header, nullptr, &numbers);
    if (isColorByte(header.vertices().properties[column]))
        for (double& value : numbers.values) value /= 255;
    return std::move(numbers.values);
}

/// The meaning of a property of the points.
struct PropertyMeaning {
    std::string_view name;
    PointAttribute::Kind kind;
    std::size_t component;
};

/// Returns the meaning of a property by its name: Kind::Numbers, unless it is a colour or a texture
/// coordinate.
PropertyMeaning meaningOf(const PlyProperty& property) {
    static constexpr PropertyMeaning kMeanings[] = {
        {"red", PointAttribute::Kind::Color, 0},
        {"green", PointAttribute::Kind::Color, 1},
        {"blue", PointAttribute::Kind::Color, 2},
        {"alpha", PointAttribute::Kind::Color, 3},
        {"s", PointAttribute::Kind::TextureCoordinate, 0},
        {"t", PointAttribute::Kind::TextureCoordinate, 1},
        {"u", PointAttribute::Kind::TextureCoordinate, 0},
        {"v", PointAttribute::Kind::TextureCoordinate, 1},
        {"texture_u", PointAttribute::Kind::TextureCoordinate, 0},
        {"texture_v", PointAttribute::Kind::TextureCoordinate, 1}};
    const auto found = std::ranges::find(kMeanings, property.name, &PropertyMeaning::name);
    if (found == std::end(kMeanings) || property.lengthType ||
        (isInteger(property.type) && !isColorByte(property)))
        return {property.name, PointAttribute::Kind::Numbers, 0};
    return *found;
}

/// Names the data of an element that are neither points, faces, texture coordinates nor normals.
/// \param used numbers of the properties of vertices that are points, normals or splats
void nameOtherData(const PlyHeader& header, const PlyElement& element,
                   const std::vector<std::size_t>& used, ModelSurface& surface) {
    if (element.count == 0) return;
    if (&element != &header.vertices() && !isFaces(element))
        surface.addOther("elements", element.name);
    else
        for (std::size_t column = 0; column < element.properties.size(); ++column) {
            const PlyProperty& property = element.properties[column];
            if (&element == &header.vertices()) {
                if (std::ranges::count(used, column) == 0)
                    surface.addOther(ModelSurface::OtherData::kPointProperties, property.name);
            } else if (!isCornerList(property) &&
                       !(isTextureList(property) && !surface.textureCorners.empty())) {
                surface.addOther("properties of faces", property.name);
            }
        }
}

ModelSurface readPlySurface(const FileView& file) {
    const PlyHeader header = parsePlyHeader(file.path, file.bytes);
    ModelSurface surface;
    readPlyRows(file.path, file.bytes, header, &surface);
    std::vector<std::size_t> used(header.axes.begin(), header.axes.end());
    surface.normals = normalsOf(file.numbers);
    for (const PlyDirection& direction : header.directions)
        if (direction.carry == carryNormal)
            used.insert(used.end(), direction.columns.begin(), direction.columns.end());
    if (!header.splats.columns.empty()) {
        surface.addOther("splats");
        used.insert(used.end(), header.splats.columns.begin(), header.splats.columns.end());
    }
    for (const PlyElement& element : header.elements) nameOtherData(header, element, used, surface);
    return surface;
}

std::vector<PointAttribute> plyAttributes(const FileView& file) {
    const PlyHeader header = parsePlyHeader(file.path, file.bytes);
    const auto& properties = header.vertices().properties;
    std::vector<PointAttribute> attributes;
    for (std::size_t column = 0; column < properties.size(); ++column) {
        if (properties[column].lengthType || std::ranges::count(header.axes, column) > 0) continue;
        const PropertyMeaning meaning = meaningOf(properties[column]);
        attributes.push_back({properties[column].name,
                              [file, column] { return readPlyProperty(file, column); },
                              meaning.kind, meaning.component});
    }
    return attributes;
}

constexpr FileModelFormat kPlyModel = {
    .readNumbers = readPlyNumbers, .readSurface = readPlySurface, .attributes = plyAttributes};

}  // namespace

const Format kPlyFormat = {.extensions = {".ply"},
                           .readModel = readFileModel<kPlyModel>,
                           .writeSurface = writePlySurface,
                           .isEditorMesh = true};

}  // namespace espalier::io
