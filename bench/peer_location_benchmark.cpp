// SPDX-License-Identifier: Apache-2.0
#include <benchmark/benchmark.h>
#include <espalier/base/parallel.h>
#include <espalier/embed/embedding.h>
#include <espalier/embed/place_points.h>
#include <espalier/embed/trilinear.h>
#include <espalier/far/standard_cells.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <ctime>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "workloads.h"

#ifdef ESPALIER_WITH_EMBREE
#include <embree3/rtcore.h>
#endif
#ifdef ESPALIER_WITH_NANOFLANN
#include <nanoflann.hpp>
#endif

// Locates a million random points in the 512,000 cells of level 3 of a box, as embed/random/3 of
// bind_benchmark.cpp does. Embree and nanoflann find candidates; Newton's method of
// embed::Trilinear decides which candidate contains the point. Benchmarks are named locate/WHO.
// Times include building the search structure; the counter "building" is this part in ms.
namespace espalier {
namespace {

/// A point in a cell that contains it.
struct Found {
    Index cell = -1;
    Eigen::Vector3d uvw;
};

/// How far beyond 0 and 1 the coordinate of a point on a face may be, as in embed::CellSolver.
constexpr double kOnFace = 1e-10;

/// The corners of every cell of the level.
class Cells {
public:
    Cells() {
        const far::CellComplex& complex = box_.complex();
        for (Index cell = 0; cell < complex.count(3); ++cell)
            corners_.push_back(far::hexahedronVertices(complex, CellId(cell)).value());
    }

    const bench::RefinedBox& box() const { return box_; }
    Index count() const { return static_cast<Index>(corners_.size()); }
    const std::vector<Point3>& points() const { return points_; }

    /// Returns the corners of a cell relative to a point.
    embed::Trilinear::Corners corners(Index cell, const Point3& origin = {}) const {
        embed::Trilinear::Corners result;
        for (std::size_t i = 0; i < 8; ++i)
            result[i] = Eigen::Vector3d(box_.positions()[corners_[cell][i]].data()) -
                        Eigen::Vector3d(origin.data());
        return result;
    }

    /// Returns the place of a point in a cell, or nothing if the cell does not contain the point.
    std::optional<Found> find(Index cell, const Point3& point) const {
        const auto uvw = embed::Trilinear(corners(cell, point)).findOrigin();
        if (!uvw || !embed::isInUnitCube(*uvw, kOnFace)) return std::nullopt;
        return Found{cell, *uvw};
    }

    /// Returns true if every point has a place that reproduces it, and the cell is the cell that
    /// Espalier finds. A point on a face of several cells may be in any of them.
    bool agree(const std::vector<Found>& found) const {
        const auto ours = embed::embedPoints(box_.complex(), box_.positions(), points_).points;
        for (std::size_t i = 0; i < points_.size(); ++i) {
            const auto& [cell, uvw] = found[i];
            // 1e-12 is the residual that embed::LocatedPoint allows in a box of size 1.
            if (cell < 0 ||
                !(embed::Trilinear(corners(cell, points_[i])).position(uvw).norm() <= 1e-12))
                return false;
            const double inside = std::min(uvw.minCoeff(), 1 - uvw.maxCoeff());
            if (cell != ours[i].place->cell.value && std::abs(inside) > kOnFace) return false;
        }
        return true;
    }

private:
    bench::RefinedBox box_;
    std::vector<Point3> points_ = bench::randomPoints();
    std::vector<std::array<Index, 8>> corners_;
};

const Cells& cells() {
    static const Cells made;
    return made;
}

void locateByEspalier(benchmark::State& state) {
    const ThreadLimit limit(1);
    const bench::RefinedBox& box = cells().box();
    for (auto _ : state)
        benchmark::DoNotOptimize(
            embed::embedPoints(box.complex(), box.positions(), cells().points()));
}

/// Times making a Finder and calling its find() for each point: in the order of the points, or
/// along the curve that embed::embedPoints() follows, where consecutive points use the same memory.
template <class Finder, bool kAlongCurve>
void locate(benchmark::State& state) {
    const std::vector<Point3>& points = cells().points();
    std::vector<Found> found;
    std::clock_t building = 0;
    for (auto _ : state) {
        const std::clock_t begin = std::clock();
        const Finder finder;
        building += std::clock() - begin;
        found.resize(points.size());
        if (kAlongCurve)
            for (const Index i : embed::alongCurve(points)) found[i] = finder.find(points[i]);
        else
            for (std::size_t i = 0; i < points.size(); ++i) found[i] = finder.find(points[i]);
    }
    state.counters["building"] = 1e3 * static_cast<double>(building) / CLOCKS_PER_SEC /
                                 static_cast<double>(state.iterations());
    if (!cells().agree(found)) state.SkipWithError("the cells differ from the cells of Espalier");
}

#ifdef ESPALIER_WITH_EMBREE

/// A bounding volume hierarchy of the boxes of the cells.
class EmbreeFinder {
public:
    EmbreeFinder() : boxes_(static_cast<std::size_t>(cells().count())) {
        for (std::size_t cell = 0; cell < boxes_.size(); ++cell) boxes_[cell] = boxOf(cell);
        RTCGeometry geometry = rtcNewGeometry(device_, RTC_GEOMETRY_TYPE_USER);
        rtcSetGeometryUserPrimitiveCount(geometry, static_cast<unsigned>(boxes_.size()));
        rtcSetGeometryUserData(geometry, boxes_.data());
        rtcSetGeometryBoundsFunction(
            geometry,
            [](const RTCBoundsFunctionArguments* arguments) {
                *arguments->bounds_o =
                    static_cast<const RTCBounds*>(arguments->geometryUserPtr)[arguments->primID];
            },
            nullptr);
        rtcCommitGeometry(geometry);
        rtcAttachGeometry(scene_, geometry);
        rtcReleaseGeometry(geometry);
        rtcSetSceneBuildQuality(scene_, RTC_BUILD_QUALITY_LOW);
        rtcCommitScene(scene_);
    }
    EmbreeFinder(const EmbreeFinder&) = delete;
    EmbreeFinder& operator=(const EmbreeFinder&) = delete;
    ~EmbreeFinder() {
        rtcReleaseScene(scene_);
        rtcReleaseDevice(device_);
    }

    /// Returns the cell of lowest number that contains the point.
    Found find(const Point3& point) const {
        Query query{*this, point, {}};
        RTCPointQuery position{static_cast<float>(point[0]), static_cast<float>(point[1]),
                               static_cast<float>(point[2]), 0, 0};
        RTCPointQueryContext context;
        rtcInitPointQueryContext(&context);
        rtcPointQuery(scene_, &position, &context, &visit, &query);
        return query.found;
    }

private:
    struct Query {
        const EmbreeFinder& finder;
        const Point3& point;
        Found found;
    };

    /// Returns the box of a cell, larger by the rounding of points and corners to single precision:
    /// 6e-8 of coordinates of at most 1, each.
    static RTCBounds boxOf(std::size_t cell) {
        constexpr float kMargin = 2e-7F;
        Eigen::AlignedBox3d box;
        for (const Eigen::Vector3d& corner : cells().corners(static_cast<Index>(cell)))
            box.extend(corner);
        const Eigen::Vector3f low = box.min().cast<float>().array() - kMargin;
        const Eigen::Vector3f high = box.max().cast<float>().array() + kMargin;
        return {low[0], low[1], low[2], 0, high[0], high[1], high[2], 0};
    }

    /// Tries a candidate. Embree calls it for all boxes of a leaf, so it tests the box first.
    static bool visit(RTCPointQueryFunctionArguments* arguments) {
        auto& query = *static_cast<Query*>(arguments->userPtr);
        const auto cell = static_cast<Index>(arguments->primID);
        const RTCBounds& box = query.finder.boxes_[arguments->primID];
        const RTCPointQuery& at = *arguments->query;
        const bool isInBox = box.lower_x <= at.x && at.x <= box.upper_x && box.lower_y <= at.y &&
                             at.y <= box.upper_y && box.lower_z <= at.z && at.z <= box.upper_z;
        if (isInBox && (query.found.cell < 0 || cell < query.found.cell))
            query.found = cells().find(cell, query.point).value_or(query.found);
        return false;  // the radius of the query is as before
    }

    std::vector<RTCBounds> boxes_;
    RTCDevice device_ = rtcNewDevice("threads=1");
    RTCScene scene_ = rtcNewScene(device_);
};

#endif

#ifdef ESPALIER_WITH_NANOFLANN

/// A k-d tree of the centres of the cells.
class NanoflannFinder {
public:
    NanoflannFinder() {
        for (Index cell = 0; cell < cells().count(); ++cell) {
            Eigen::Vector3d sum = Eigen::Vector3d::Zero();
            for (const Eigen::Vector3d& corner : cells().corners(cell)) sum += corner;
            centres_.points.push_back({sum[0] / 8, sum[1] / 8, sum[2] / 8});
        }
        tree_ = std::make_unique<Tree>(3, centres_);
        tree_->buildIndex();
    }

    /// Returns the cell with the nearest centre that contains the point. Seeks the cell whose
    /// centre is nearest, and then more cells.
    Found find(const Point3& point) const {
        constexpr std::size_t kMaxCandidates = 64;
        std::array<Index, kMaxCandidates> candidates;
        std::array<double, kMaxCandidates> squares;
        std::size_t tried = 0;
        for (std::size_t count = 1; count <= kMaxCandidates; count *= 8) {
            tree_->knnSearch(point.data(), count, candidates.data(), squares.data());
            for (; tried < count; ++tried)
                if (const auto found = cells().find(candidates[tried], point)) return *found;
        }
        return {};
    }

private:
    struct Centres {
        std::vector<Point3> points;

        // The names are nanoflann's.
        std::size_t kdtree_get_point_count() const { return points.size(); }
        double kdtree_get_pt(std::size_t index, std::size_t axis) const {
            return points[index][axis];
        }
        template <class Box>
        bool kdtree_get_bbox(Box&) const {
            return false;
        }
    };
    using Tree =
        nanoflann::KDTreeSingleIndexAdaptor<nanoflann::L2_Simple_Adaptor<double, Centres, double>,
                                            Centres, 3, Index>;

    Centres centres_;
    std::unique_ptr<Tree> tree_;
};

#endif

const bool kRegistered = [] {
    const auto add = [](const std::string& who, void (*work)(benchmark::State&)) {
        benchmark::RegisterBenchmark(("locate/" + who).c_str(), work)
            ->MeasureProcessCPUTime()
            ->Unit(benchmark::kMillisecond)
            ->Iterations(1);
    };
    add("Espalier", locateByEspalier);
#ifdef ESPALIER_WITH_EMBREE
    add("Embree", locate<EmbreeFinder, false>);
    add("Embree along a curve", locate<EmbreeFinder, true>);
#endif
#ifdef ESPALIER_WITH_NANOFLANN
    add("nanoflann", locate<NanoflannFinder, false>);
    add("nanoflann along a curve", locate<NanoflannFinder, true>);
#endif
    return true;
}();

}  // namespace
}  // namespace espalier
