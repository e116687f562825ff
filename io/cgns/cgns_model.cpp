// SPDX-License-Identifier: Apache-2.0
#include <espalier/base/error.h>
#include <espalier/far/second_order_cells.h>
#include <espalier/io/cgns/cgns_model.h>
#include <espalier/io/files/file.h>

#include <cgns_io.h>
#include <cgnslib.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cmath>
#include <cstdint>
#include <cstdlib>
#include <map>
#include <mutex>
#include <optional>
#include <span>
#include <utility>
#include <vector>

#include "../files/coding.h"
#include "../files/descriptor.h"
#include "../files/number_types.h"
#include "../format.h"
#include "../meshes/mesh_cells.h"
#include "../meshes/surface_faces.h"
#include "../models/coordinates.h"
#include "cgns_check.h"

namespace espalier::io {
namespace {

/// CGNS's library has global state.
std::mutex& libraryMutex() {
    static std::mutex mutex;
    return mutex;
}

/// A file with some bytes, which exists as long as this object.
class TemporaryFile {
public:
    explicit TemporaryFile(std::string_view bytes) {
        std::error_code error;
        path_ = (std::filesystem::temp_directory_path(error) / "espalier-XXXXXX").string();
        if (error) fail("the folder of temporary files cannot be found", error.value());
        const Descriptor file(::mkstemp(path_.data()));
        if (!file) fail("a temporary file cannot be made", errno);
        while (!bytes.empty()) {
            const auto written =
                uninterrupted([&] { return ::write(file.number(), bytes.data(), bytes.size()); });
            if (written < 0) {
                const int reason = errno;
                remove();
                fail("a temporary file cannot be written", reason);
            }
            bytes.remove_prefix(written);
        }
    }
    ~TemporaryFile() { remove(); }
    TemporaryFile(const TemporaryFile&) = delete;
    TemporaryFile& operator=(const TemporaryFile&) = delete;

    const char* path() const { return path_.c_str(); }

private:
    void remove() const {
        std::error_code ignored;
        std::filesystem::remove(path_, ignored);
    }
    [[noreturn]] void fail(const char* what, int error) const {
        throw FileError(path_, concat(what, ": ", systemMessage(error),
                                      "; the variable TMPDIR names another folder for it"));
    }

    std::string path_;
};

/// An array of coordinates of a zone.
struct CoordinateArray {
    std::string node;  ///< path from the root: "/Base/Zone/GridCoordinates/CoordinateX"
    Precision precision = Precision::Double;
};

struct Zone {
    int base, number;  ///< numbers from 1 on
    bool isStructured;
    std::vector<std::size_t> extent;  ///< the extent of the arrays of coordinates
    std::size_t firstPoint, pointCount;
    std::vector<CoordinateArray> coordinates;  ///< two or three
};

/// Opens a file by the library's lower level, which reads and writes whole nodes.
class NodeFile {
public:
    NodeFile(const std::filesystem::path& shown, const char* path, int mode)
        : shown_(shown), path_(path) {
        check(cgio_open_file(path, mode, CGIO_FILE_NONE, &number_));
        check(cgio_get_root_id(number_, &root_));
    }
    ~NodeFile() {
        if (number_ > 0) cgio_close_file(number_);
    }
    NodeFile(const NodeFile&) = delete;
    NodeFile& operator=(const NodeFile&) = delete;

    double node(const std::string& path) const {
        double id = 0;
        check(cgio_get_node_id(number_, root_, path.c_str(), &id));
        return id;
    }
    std::string typeOf(double id) const {
        std::array<char, CGIO_MAX_DATATYPE_LENGTH + 1> type{};
        check(cgio_get_data_type(number_, id, type.data()));
        return type.data();
    }
    std::vector<std::size_t> extentOf(double id) const {
        int count = 0;
        std::array<cgsize_t, CGIO_MAX_DIMENSIONS> sizes{};
        check(cgio_get_dimensions(number_, id, &count, sizes.data()));
        return {sizes.begin(), sizes.begin() + count};
    }
    template <class Real>
    std::vector<Real> read(double id, std::size_t count) const {
        std::vector<Real> values(count);
        check(cgio_read_all_data(number_, id, values.data()));
        return values;
    }
    template <class Real>
    void write(double id, const std::vector<Real>& values) const {
        checkWritten(cgio_write_all_data(number_, id, values.data()));
    }
    void close() {
        const int number = std::exchange(number_, 0);
        checkWritten(cgio_close_file(number));
    }

private:
    void check(int code) const {
        if (code != CGIO_ERR_NONE)
            throw FileError(shown_, "CGNS's library refuses the file: " + message());
    }
    void checkWritten(int code) const {
        if (code != CGIO_ERR_NONE)
            throw FileError(path_,
                            "CGNS's library cannot write this temporary file (is its disk "
                            "full?): " +
                                message());
    }
    static std::string message() {
        std::array<char, CGIO_MAX_ERROR_LENGTH + 1> text{};
        cgio_error_message(text.data());
        return text.data();
    }

    const std::filesystem::path& shown_;
    std::filesystem::path path_;
    int number_ = 0;
    double root_ = 0;
};

/// Throws if a file is too small for a number of values of four bytes or more. HDF5 may have
/// compressed them; but it may as well claim values that were never written.
void requireRoom(const std::filesystem::path& shown, std::size_t fileBytes, std::uint64_t count,
                 const std::string& what) {
    const std::uint64_t most = saturatingProduct<std::uint64_t>(fileBytes, kMaxInflation) / 4;
    if (count > most)
        throw FileError(shown, concat(what, " claims ", count, " values, but the ", fileBytes,
                                      " bytes of the file can hold at most ", most));
}

/// Opens a file by the library's middle level, which knows zones and elements.
class ZoneFile {
public:
    /// \param fileBytes size of the file
    ZoneFile(const std::filesystem::path& shown, const char* path, std::size_t fileBytes)
        : shown_(shown), fileBytes_(fileBytes) {
        check(cg_open(path, CG_MODE_READ, &number_));
    }
    ~ZoneFile() {
        if (number_ > 0) cg_close(number_);
    }
    ZoneFile(const ZoneFile&) = delete;
    ZoneFile& operator=(const ZoneFile&) = delete;

    int number() const { return number_; }
    void requireRoom(std::uint64_t count, const std::string& what) const {
        io::requireRoom(shown_, fileBytes_, count, what);
    }
    void check(int code) const {
        if (code != CG_OK)
            throw FileError(shown_, concat("CGNS's library refuses the file: ", cg_get_error()));
    }
    [[noreturn]] void fail(const std::string& cause) const { throw FileError(shown_, cause); }

    std::vector<Zone> zones() const {
        std::vector<Zone> zones;
        int baseCount = 0;
        check(cg_nbases(number_, &baseCount));
        for (int base = 1; base <= baseCount; ++base) {
            int zoneCount = 0;
            check(cg_nzones(number_, base, &zoneCount));
            for (int zone = 1; zone <= zoneCount; ++zone) addZone(zones, base, zone);
        }
        return zones;
    }

private:
    using Name = std::array<char, 33>;  // The library's longest name, and its end.

    void addZone(std::vector<Zone>& zones, int base, int number) const {
        Name baseName{}, zoneName{};
        int cellDimension = 0, spaceDimension = 0, coordinateCount = 0;
        std::array<cgsize_t, 9> sizes{};
        CGNS_ENUMT(ZoneType_t) type;
        check(cg_base_read(number_, base, baseName.data(), &cellDimension, &spaceDimension));
        check(cg_zone_read(number_, base, number, zoneName.data(), sizes.data()));
        check(cg_zone_type(number_, base, number, &type));
        check(cg_ncoords(number_, base, number, &coordinateCount));
        if (coordinateCount == 0) return;
        Zone zone{base, number, type == CGNS_ENUMV(Structured), {}, 0, 0, {}};
        const std::string place = concat("/", baseName.data(), "/", zoneName.data());
        for (const char* axis : {"CoordinateX", "CoordinateY", "CoordinateZ"}) {
            bool isThere = false;
            for (int i = 1; i <= coordinateCount; ++i) {
                Name name{};
                CGNS_ENUMT(DataType_t) stored;
                check(cg_coord_info(number_, base, number, i, &stored, name.data()));
                isThere = isThere || std::string_view(name.data()) == axis;
            }
            if (isThere) zone.coordinates.push_back({place + "/GridCoordinates/" + axis});
        }
        if (zone.coordinates.size() < 2)
            fail("the zone '" + std::string(zoneName.data()) +
                 "' has no coordinates CoordinateX and CoordinateY; others, such as CoordinateR, "
                 "cannot be deformed");
        zones.push_back(std::move(zone));
    }

    const std::filesystem::path& shown_;
    std::size_t fileBytes_;
    int number_ = 0;
};

/// Brings the points of a cell of second order into VTK's order; MeshCells turns wedges. The
/// places of points in tetrahedra and pyramids are VTK's; in wedges and hexahedra, the edges along
/// the axis come before the edges of the upper end, and faces go around the axis.
std::vector<Index> inVtkOrder(const std::vector<Index>& points) {
    using far::between;
    static constexpr far::CornerBits kWedge[] = {
        between(0),          between(1),          between(2),         between(3),    between(4),
        between(5),          between(0, 1),       between(1, 2),      between(2, 0), between(0, 3),
        between(1, 4),       between(2, 5),       between(3, 4),      between(4, 5), between(5, 3),
        between(0, 1, 4, 3), between(1, 2, 5, 4), between(2, 0, 3, 5)};
    static constexpr far::CornerBits kHexahedron[] = {
        between(0),          between(1),          between(2),
        between(3),          between(4),          between(5),
        between(6),          between(7),          between(0, 1),
        between(1, 2),       between(2, 3),       between(3, 0),
        between(0, 4),       between(1, 5),       between(2, 6),
        between(3, 7),       between(4, 5),       between(5, 6),
        between(6, 7),       between(7, 4),       between(0, 3, 2, 1),
        between(0, 1, 5, 4), between(1, 2, 6, 5), between(2, 3, 7, 6),
        between(0, 4, 7, 3), between(4, 5, 6, 7), between(0, 1, 2, 3, 4, 5, 6, 7)};
    static constexpr std::size_t kCorners[] = {0, 1, 2, 3, 4, 5, 6, 7};
    switch (far::kindOfCell(points.size()).value()) {
        case far::StandardCell::Wedge:
            return far::reorderedCell(points, kWedge, std::span(kCorners).first(6));
        case far::StandardCell::Hexahedron:
            return far::reorderedCell(points, kHexahedron, kCorners);
        default:
            return points;
    }
}

/// Passes the elements of a zone to a visitor.
class ZoneElements {
public:
    ZoneElements(const ZoneFile& file, const Zone& zone, CellVisitor& visitor)
        : file_(file), zone_(zone), visitor_(visitor) {}

    void visit() {
        if (zone_.isStructured)
            visitGrid();
        else
            visitSections();
    }

private:
    struct Section {
        std::string name;
        CGNS_ENUMT(ElementType_t) type;
        std::size_t first, count;
        std::vector<cgsize_t> elements;
        std::vector<cgsize_t>
            ends;  ///< offsets of MIXED, NGON_n and NFACE_n: one more than elements
    };

    void visitGrid() {
        visitor_.beginGroups({});
        std::array<std::size_t, 3> size = {1, 1, 1};
        for (std::size_t axis = 0; axis < std::min<std::size_t>(3, zone_.extent.size()); ++axis)
            size[axis] = zone_.extent[axis];
        const auto at = [&](std::size_t i, std::size_t j, std::size_t k) {
            return static_cast<Index>(zone_.firstPoint + i + size[0] * (j + size[1] * k));
        };
        for (std::size_t j = 0; size[2] == 1 && j + 1 < size[1]; ++j)
            for (std::size_t i = 0; i + 1 < size[0]; ++i)
                visitor_.face(
                    std::array{at(i, j, 0), at(i + 1, j, 0), at(i + 1, j + 1, 0), at(i, j + 1, 0)});
        for (std::size_t k = 0; k + 1 < size[2]; ++k)
            for (std::size_t j = 0; j + 1 < size[1]; ++j)
                for (std::size_t i = 0; i + 1 < size[0]; ++i)
                    visitor_.cell(far::StandardCell::Hexahedron,
                                  std::array{at(i, j, k), at(i + 1, j, k), at(i + 1, j + 1, k),
                                             at(i, j + 1, k), at(i, j, k + 1), at(i + 1, j, k + 1),
                                             at(i + 1, j + 1, k + 1), at(i, j + 1, k + 1)});
    }

    void visitSections() {
        const std::vector<Section> sections = readSections();
        const bool hasCellsOfFaces = std::ranges::any_of(
            sections, [](const Section& section) { return section.type == CGNS_ENUMV(NFACE_n); });
        std::map<cgsize_t, std::vector<Index>> loops;  ///< faces by the numbers of their elements
        for (const Section& section : sections) {
            if (section.type != CGNS_ENUMV(NGON_n)) continue;
            visitor_.beginGroups(std::span(&section.name, 1));
            for (std::size_t i = 0; i < section.count; ++i) {
                const std::vector<Index> loop = points(rowOf(section, i));
                if (hasCellsOfFaces)
                    loops[static_cast<cgsize_t>(section.first + i)] = loop;
                else
                    visitor_.face(loop);
            }
        }
        for (const Section& section : sections) {
            if (section.type == CGNS_ENUMV(NGON_n)) continue;
            visitor_.beginGroups(std::span(&section.name, 1));
            for (std::size_t i = 0; i < section.count; ++i) {
                auto row = rowOf(section, i);
                if (section.type == CGNS_ENUMV(NFACE_n)) {
                    visitPolyhedron(row, loops);
                } else if (section.type == CGNS_ENUMV(MIXED)) {
                    if (row.empty()) file_.fail("an element of a MIXED section is empty");
                    visitElement(typeOf(row.front()), row.subspan(1));
                } else {
                    visitElement(section.type, row);
                }
            }
        }
    }

    /// Returns the type of an element of a MIXED section.
    CGNS_ENUMT(ElementType_t) typeOf(cgsize_t number) const {
        if (number < 0 || number >= NofValidElementTypes)
            file_.fail(concat("an element of a MIXED section has the type ", number,
                              "; the types of CGNS are 0 to ", NofValidElementTypes - 1));
        return static_cast<CGNS_ENUMT(ElementType_t)>(number);
    }

    std::vector<Section> readSections() const {
        const int number = file_.number();
        int count = 0;
        file_.check(cg_nsections(number, zone_.base, zone_.number, &count));
        std::vector<Section> sections;
        for (int i = 1; i <= count; ++i) {
            std::array<char, 33> name{};
            cgsize_t start = 0, end = 0, size = 0;
            int boundary = 0, parents = 0;
            Section section{};
            file_.check(cg_section_read(number, zone_.base, zone_.number, i, name.data(),
                                        &section.type, &start, &end, &boundary, &parents));
            file_.check(cg_ElementDataSize(number, zone_.base, zone_.number, i, &size));
            if (const int type = section.type; type < 0 || type >= NofValidElementTypes)
                file_.fail(concat("the section '", name.data(), "' has elements of the type ", type,
                                  "; the types of CGNS are 0 to ", NofValidElementTypes - 1));
            if (end < start || size < 0)
                file_.fail(concat("the section '", name.data(), "' has no elements"));
            section.name = name.data();
            section.first = start;
            section.count = end - section.first + 1;
            const std::string what = concat("the section '", name.data(), "'");
            file_.requireRoom(size, what);
            file_.requireRoom(section.count, what);
            section.elements.resize(size);
            const bool hasOffsets = section.type == CGNS_ENUMV(MIXED) ||
                                    section.type == CGNS_ENUMV(NGON_n) ||
                                    section.type == CGNS_ENUMV(NFACE_n);
            if (hasOffsets) {
                section.ends.resize(section.count + 1);
                file_.check(cg_poly_elements_read(number, zone_.base, zone_.number, i,
                                                  section.elements.data(), section.ends.data(),
                                                  nullptr));
            } else {
                file_.check(cg_elements_read(number, zone_.base, zone_.number, i,
                                             section.elements.data(), nullptr));
            }
            sections.push_back(std::move(section));
        }
        return sections;
    }

    /// Returns the numbers of an element.
    std::span<const cgsize_t> rowOf(const Section& section, std::size_t element) const {
        cgsize_t begin = 0, end = 0;
        if (!section.ends.empty()) {
            begin = section.ends[element];
            end = section.ends[element + 1];
        } else {
            int nodes = 0;
            file_.check(cg_npe(section.type, &nodes));
            begin = static_cast<cgsize_t>(element) * nodes;
            end = begin + nodes;
        }
        if (begin < 0 || end < begin || end > static_cast<cgsize_t>(section.elements.size()))
            file_.fail(concat("element ", section.first + element, " has the numbers ", begin,
                              " to ", end, " of ", section.elements.size()));
        return std::span(section.elements).subspan(begin, end - begin);
    }

    std::vector<Index> points(std::span<const cgsize_t> numbers) const {
        std::vector<Index> points;
        for (const cgsize_t number : numbers) {
            if (number < 1 || number > static_cast<cgsize_t>(zone_.pointCount))
                file_.fail(concat("an element names point ", number, "; there are ",
                                  zone_.pointCount, ", counted from 1"));
            points.push_back(static_cast<Index>(zone_.firstPoint) + static_cast<Index>(number - 1));
        }
        return points;
    }

    void visitPolyhedron(std::span<const cgsize_t> faces,
                         const std::map<cgsize_t, std::vector<Index>>& loops) const {
        std::vector<std::vector<Index>> ofCell;
        for (const cgsize_t signedFace : faces) {
            const auto found = loops.find(std::abs(signedFace));
            if (found == loops.end())
                file_.fail(concat("a cell names face ", std::abs(signedFace),
                                  ", which no NGON_n section has"));
            ofCell.push_back(found->second);
            if (signedFace < 0) std::reverse(ofCell.back().begin(), ofCell.back().end());
        }
        visitor_.polyhedron(ofCell);
    }

    void visitElement(CGNS_ENUMT(ElementType_t) type, std::span<const cgsize_t> numbers) const {
        std::optional<far::StandardCell> kind;
        switch (type) {
            case CGNS_ENUMV(NODE):
                return visitor_.smallCell(0, {});
            case CGNS_ENUMV(BAR_2):
                return visitor_.smallCell(1, points(numbers));
            case CGNS_ENUMV(TRI_3):
            case CGNS_ENUMV(QUAD_4):
                return visitor_.face(points(numbers));
            case CGNS_ENUMV(TRI_6):
            case CGNS_ENUMV(QUAD_8):
            case CGNS_ENUMV(QUAD_9):
                return visitor_.curvedCell(2, points(checkedNumbers(type, numbers)));
            case CGNS_ENUMV(TETRA_10):
            case CGNS_ENUMV(PYRA_13):
            case CGNS_ENUMV(PYRA_14):
            case CGNS_ENUMV(PENTA_15):
            case CGNS_ENUMV(PENTA_18):
            case CGNS_ENUMV(HEXA_20):
            case CGNS_ENUMV(HEXA_27):
                return visitor_.curvedCell(3, inVtkOrder(points(checkedNumbers(type, numbers))));
            case CGNS_ENUMV(TETRA_4):
                kind = far::StandardCell::Tetrahedron;
                break;
            case CGNS_ENUMV(PYRA_5):
                kind = far::StandardCell::Pyramid;
                break;
            case CGNS_ENUMV(PENTA_6):
                kind = far::StandardCell::Wedge;
                break;
            case CGNS_ENUMV(HEXA_8):
                kind = far::StandardCell::Hexahedron;
                break;
            case CGNS_ENUMV(ElementTypeNull):
            case CGNS_ENUMV(ElementTypeUserDefined):
            case CGNS_ENUMV(MIXED):
            case CGNS_ENUMV(NGON_n):
            case CGNS_ENUMV(NFACE_n):
                file_.fail(concat("an element has the type ", ElementTypeName[type],
                                  ", whose points are not known"));
            default:
                return visitor_.curvedCell(dimensionOf(type), {});
        }
        visitor_.cell(*kind, points(checkedNumbers(type, numbers)));
    }

    std::span<const cgsize_t> checkedNumbers(CGNS_ENUMT(ElementType_t) type,
                                             std::span<const cgsize_t> numbers) const {
        int expected = 0;
        file_.check(cg_npe(type, &expected));
        if (std::ssize(numbers) != expected)
            file_.fail(concat("a cell has ", numbers.size(), " points; expected ", expected));
        return numbers;
    }

    static int dimensionOf(CGNS_ENUMT(ElementType_t) type) {
        const std::string_view name = ElementTypeName[type];
        if (name.starts_with("BAR")) return 1;
        return name.starts_with("TRI") || name.starts_with("QUAD") ? 2 : 3;
    }

    const ZoneFile& file_;
    const Zone& zone_;
    CellVisitor& visitor_;
};

class CgnsModel final : public Model {
public:
    CgnsModel(const Format& format, const std::filesystem::path& path, std::string bytes)
        : Model(format, path), path_(path), bytes_(std::move(bytes)) {
        const std::lock_guard lock(libraryMutex());
        const TemporaryFile file(bytes_);
        checkCgnsFile(path_, bytes_, file.path());
        zones_ = ZoneFile(path_, file.path(), bytes_.size()).zones();
        const NodeFile nodes(path_, file.path(), CGIO_MODE_READ);
        for (Zone& zone : zones_) readCoordinates(nodes, zone);
    }

    std::span<const Point3> positions() const override { return positions_; }
    DirectionCounts directions() const override { return {}; }

    CoordinateStorage storage() const override {
        for (const Zone& zone : zones_)
            for (const CoordinateArray& array : zone.coordinates)
                if (array.precision == Precision::Float) return CoordinateStorage::Float;
        return CoordinateStorage::Double;
    }

    std::vector<Point3> stored(std::vector<Point3> points) const override {
        for (const Zone& zone : zones_)
            for (std::size_t axis = 0; axis < zone.coordinates.size(); ++axis)
                if (zone.coordinates[axis].precision == Precision::Float)
                    for (std::size_t i = 0; i < zone.pointCount; ++i)
                        roundToFloat(points[zone.firstPoint + i][axis]);
        return points;
    }

    ModelSurface readSurface() const override {
        SurfaceFaces surface;
        visitCells(surface);
        return surface.take();
    }

    ModelCells readCells() const override {
        MeshCells cells;
        visitCells(cells);
        return cells.finish(positions_);
    }

    std::vector<PointGroup> groups() const override { return groupsOf(readCells().patches); }

private:
    void readCoordinates(const NodeFile& nodes, Zone& zone) {
        zone.firstPoint = positions_.size();
        for (std::size_t axis = 0; axis < zone.coordinates.size(); ++axis) {
            CoordinateArray& array = zone.coordinates[axis];
            const double id = nodes.node(array.node);
            const std::string type = nodes.typeOf(id);
            const std::vector<std::size_t> extent = nodes.extentOf(id);
            if (type != "R4" && type != "R8")
                throw FileError(path_, array.node + " is of the type " + type +
                                           "; expected R4 or R8 (single or double precision)");
            if (axis == 0) {
                zone.extent = extent;
                zone.pointCount = 1;
                for (const std::size_t size : extent)
                    zone.pointCount = saturatingProduct(zone.pointCount, size);
                requireRoom(path_, bytes_.size(), zone.pointCount, array.node);
                if (std::cmp_greater(zone.firstPoint + zone.pointCount, kMaxIndex))
                    throw FileError(path_, concat("has more than ", kMaxIndex, " points"));
                positions_.resize(zone.firstPoint + zone.pointCount, {0, 0, 0});
            } else if (extent != zone.extent) {
                throw FileError(path_, array.node + " has another size than CoordinateX");
            }
            array.precision = type == "R4" ? Precision::Float : Precision::Double;
            if (array.precision == Precision::Float)
                take(nodes.read<float>(id, zone.pointCount), zone, axis);
            else
                take(nodes.read<double>(id, zone.pointCount), zone, axis);
        }
    }

    template <class Real>
    void take(const std::vector<Real>& values, const Zone& zone, std::size_t axis) {
        for (std::size_t i = 0; i < values.size(); ++i) {
            if (!std::isfinite(values[i]))
                throw FileError(path_, concat(axisName(axis), " of point ", zone.firstPoint + i,
                                              " is not finite"));
            positions_[zone.firstPoint + i][axis] = static_cast<double>(values[i]);
        }
    }

    void visitCells(CellVisitor& visitor) const {
        const std::lock_guard lock(libraryMutex());
        const TemporaryFile temporary(bytes_);
        const ZoneFile file(path_, temporary.path(), bytes_.size());
        for (const Zone& zone : zones_) ZoneElements(file, zone, visitor).visit();
    }

    void writeChecked(const std::filesystem::path& path, std::span<const Point3> moved,
                      std::span<const DeformationGradient>) const override {
        const bool isMoved = !std::equal(moved.begin(), moved.end(), positions_.begin());
        const std::string bytes = isMoved ? bytesWith(moved) : bytes_;
        writeFile(path, [&](std::ostream& out) {
            out.write(bytes.data(), static_cast<std::streamsize>(bytes.size()));
        });
    }

    std::string bytesWith(std::span<const Point3> moved) const {
        for (const Zone& zone : zones_)
            for (std::size_t i = 0; zone.coordinates.size() == 2 && i < zone.pointCount; ++i)
                if (moved[zone.firstPoint + i][2] != 0)
                    throw Error(concat("the new position of point ", zone.firstPoint + i,
                                       " has a z other than 0, but its zone has two coordinates"));
        const std::lock_guard lock(libraryMutex());
        const TemporaryFile temporary(bytes_);
        NodeFile nodes(path_, temporary.path(), CGIO_MODE_MODIFY);
        for (const Zone& zone : zones_)
            for (std::size_t axis = 0; axis < zone.coordinates.size(); ++axis) {
                if (zone.coordinates[axis].precision == Precision::Float)
                    put<float>(nodes, zone, axis, moved);
                else
                    put<double>(nodes, zone, axis, moved);
            }
        nodes.close();
        return readFile(temporary.path());
    }

    /// Writes an array if one of its numbers changes.
    template <class Real>
    void put(const NodeFile& nodes, const Zone& zone, std::size_t axis,
             std::span<const Point3> moved) const {
        std::vector<Real> values(zone.pointCount);
        bool isChanged = false;
        for (std::size_t i = 0; i < values.size(); ++i) {
            const std::size_t point = zone.firstPoint + i;
            values[i] = static_cast<Real>(
                roundTo(zone.coordinates[axis].precision, moved[point][axis], point));
            isChanged = isChanged || values[i] != static_cast<Real>(positions_[point][axis]);
        }
        if (isChanged) nodes.write(nodes.node(zone.coordinates[axis].node), values);
    }

    std::filesystem::path path_;
    std::string bytes_;
    std::vector<Zone> zones_;
    std::vector<Point3> positions_;
};

constexpr Format kCgnsFormat = {
    .extensions = {".cgns"},
    .isMesh = true,
    .readModel = [](const Format& format, const std::filesystem::path& path,
                    std::string bytes) -> std::unique_ptr<Model> {
        return std::make_unique<CgnsModel>(format, path, std::move(bytes));
    }};

}  // namespace

void addCgnsModels() {
    addFormat(kCgnsFormat);
}

}  // namespace espalier::io
