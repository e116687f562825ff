// SPDX-License-Identifier: Apache-2.0
#include <espalier/base/error.h>
#include <espalier/io/cgns/cgns_model.h>
#include <espalier/io/files/file.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <map>
#include <mutex>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "../files/number_types.h"
#include "../format.h"
#include "../meshes/mesh_cells.h"
#include "../meshes/surface_faces.h"
#include "../models/coordinates.h"
#include "cgns_check.h"
#include "cgns_elements.h"
#include "cgns_file.h"

namespace espalier::io {
namespace {

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
        MeshCells visitor;
        std::map<std::string, std::string> types;
        const Index missing = visitCells(visitor, &types);
        ModelCells cells = visitor.finish(positions_);
        cells.missingElements = missing;
        for (far::MeshPatch& patch : cells.patches)
            if (const auto type = types.find(patch.name); type != types.end())
                patch.type = type->second;
        return cells;
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

    /// Passes the elements and boundary conditions of all zones to a visitor.
    /// \param types gets the types of the conditions, by their names; may be null
    /// \return the number of elements that conditions name, and that do not exist
    Index visitCells(CellVisitor& visitor,
                     std::map<std::string, std::string>* types = nullptr) const {
        const std::lock_guard lock(libraryMutex());
        const TemporaryFile temporary(bytes_);
        const ZoneFile file(path_, temporary.path(), bytes_.size());
        std::vector<std::vector<CgnsCondition>> conditions(zones_.size());
        std::set<std::string> names;
        for (std::size_t zone = 0; visitor.wantsGroups() && zone < zones_.size(); ++zone) {
            conditions[zone] = readConditions(file, zones_[zone]);
            for (const CgnsCondition& condition : conditions[zone]) {
                names.insert(condition.name);
                if (types && (*types)[condition.name].empty())
                    (*types)[condition.name] = condition.type;
            }
        }
        Index missing = 0;
        for (std::size_t zone = 0; zone < zones_.size(); ++zone)
            missing += visitElements(file, zones_[zone], conditions[zone], names, visitor);
        return missing;
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
