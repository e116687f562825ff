// SPDX-License-Identifier: Apache-2.0
#include "model_samples.h"

#include <espalier/base/error.h>
#include <espalier/base/hash.h>
#include <espalier/base/progress.h>
#include <espalier/base/vector3.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdint>
#include <span>

#include "ranked_bits.h"
#include "surface_samples.h"

namespace espalier::cages {
namespace {

/// Steps of work for a sample.
constexpr double kPerVisit = 40;

/// Samples whose work is added at once.
constexpr std::size_t kAtOnce = 8192;

/// A set of numbers from 0 to 2⁶³ in one array, half of it empty at least.
class NumberSet {
public:
    explicit NumberSet(std::size_t most) : slots_(std::bit_ceil(2 * most + 2), kEmpty) {}

    /// Returns true if the number was not in the set.
    bool insert(std::uint64_t number) {
        const std::size_t mask = slots_.size() - 1;
        for (std::size_t at = appendedHash(0, number) >> 20 & mask;; at = (at + 1) & mask) {
            if (slots_[at] == number) return false;
            if (slots_[at] != kEmpty) continue;
            slots_[at] = number;
            return true;
        }
    }

    void clear() { std::fill(slots_.begin(), slots_.end(), kEmpty); }
    std::size_t size() const { return slots_.size(); }

private:
    static constexpr std::uint64_t kEmpty = ~std::uint64_t{0};
    std::vector<std::uint64_t> slots_;
};

class Sampler {
public:
    Sampler(const ModelSurface& surface, const ModelVoxels& voxels, const GridCells& cells,
            const SampleOptions& options, Work& work)
        : surface_(surface),
          voxels_(voxels),
          cells_(cells),
          options_(options),
          work_(work),
          knownVoxels_(voxels.used().size()),
          innerVoxels_(voxels.used().size()) {}

    bool areFew();
    std::vector<FitPoint> all();
    std::vector<FitPoint> few();

private:
    using Normal = std::array<float, 3>;

    template <class Visit>
    void forEachFace(Visit visit) const;
    template <class Visit>
    void forEachSampleOf(const Triangle& face, Visit visit);
    void add(const Point3& point, const Normal& normal);
    void addIfFar(const Point3& point, const Normal& normal);
    void leaveOut();
    Point3 localOf(const Point3& p) const {
        return {dot(options_.axes[0], p), dot(options_.axes[1], p), dot(options_.axes[2], p)};
    }
    bool isInner(const Point3& local);
    std::uint64_t placeOf(const Point3& point, const Normal& normal);

    const ModelSurface& surface_;
    const ModelVoxels& voxels_;
    const GridCells& cells_;
    const SampleOptions& options_;
    Work& work_;
    std::vector<FitPoint> samples_;
    RankedBits knownVoxels_, innerVoxels_;  ///< the voxels of samples; those that are inner

    // Used by few() only.
    NumberSet taken_{0};
    std::size_t modelPoints_ = 0;  ///< the first samples
    int parts_ = 4;                ///< along a voxel
};

/// Calls visit(face, normal) for all faces that count, until it returns false.
template <class Visit>
void Sampler::forEachFace(Visit visit) const {
    const auto& points = surface_.points();
    const auto visitAll = [&](std::span<const Triangle> triangles, double sign) {
        return std::ranges::all_of(triangles, [&](const Triangle& t) {
            Normal normal = {0, 0, 0};
            if (sign != 0) {
                const Point3 way = cross(difference(points[t[1]], points[t[0]]),
                                         difference(points[t[2]], points[t[0]]));
                const double size = length(way);
                for (std::size_t axis = 0; axis < 3; ++axis)
                    normal[axis] = size > 0 ? static_cast<float>(sign * way[axis] / size) : 0;
            }
            return visit(t, normal);
        });
    };
    if (options_.isShell) {
        visitAll(surface_.triangles(), 0);
        return;
    }
    for (std::size_t i = 0; i < surface_.closedPieces().size(); ++i) {
        const ModelSurface::ClosedPiece& piece = surface_.closedPieces()[i];
        const auto faces = std::span(piece.triangles).first(piece.capBegin);
        if (!visitAll(faces, voxels_.signs()[i])) return;
    }
    visitAll(surface_.openTriangles(), 0);
}

/// Calls visit(point) for the samples of a face.
template <class Visit>
void Sampler::forEachSampleOf(const Triangle& face, Visit visit) {
    std::size_t count = 0;
    forEachSample({&face, 1}, surface_.points(), options_.spacing,
                  [&](const Point3& point, std::size_t) {
                      if (++count % kAtOnce == 0) work_.add(kAtOnce * kPerVisit);
                      visit(point);
                  });
    work_.add(static_cast<double>(count % kAtOnce) * kPerVisit);
}

/// Returns true if all samples are not too many.
bool Sampler::areFew() {
    std::size_t count = 0;
    forEachFace([&](const Triangle& face, const Normal&) {
        forEachSampleOf(face, [&](const Point3&) { ++count; });
        return count <= options_.most;
    });
    return count <= options_.most;
}

void Sampler::add(const Point3& point, const Normal& normal) {
    const Point3 local = localOf(point);
    samples_.push_back({point, normal, cells_.cellOf(local), isInner(local)});
}

std::vector<FitPoint> Sampler::all() {
    forEachFace([&](const Triangle& face, const Normal& normal) {
        forEachSampleOf(face, [&](const Point3& point) { add(point, normal); });
        return true;
    });
    return std::move(samples_);
}

/// Returns the samples without those that are near to others.
std::vector<FitPoint> Sampler::few() {
    // The points of the model come first, so that they remain.
    std::vector<char> isAdded(surface_.points().size(), 0);
    forEachFace([&](const Triangle& face, const Normal& normal) {
        for (const Index corner : face) {
            checkCancelledEvery(samples_.size(), 10);
            if (isAdded[corner] != 0) continue;
            isAdded[corner] = 1;
            add(surface_.points()[corner], normal);
        }
        return true;
    });
    modelPoints_ = samples_.size();
    taken_ = NumberSet(modelPoints_ + options_.most);
    for (std::size_t i = 0; i < samples_.size(); ++i) {
        checkCancelledEvery(i, 12);
        taken_.insert(placeOf(samples_[i].position, samples_[i].normal));
    }
    forEachFace([&](const Triangle& face, const Normal& normal) {
        forEachSampleOf(face, [&](const Point3& point) { addIfFar(point, normal); });
        return true;
    });
    return std::move(samples_);
}

void Sampler::addIfFar(const Point3& point, const Normal& normal) {
    if (!taken_.insert(placeOf(point, normal))) return;
    add(point, normal);
    if (samples_.size() - modelPoints_ > options_.most) leaveOut();
}

/// Makes the parts of voxels larger, and leaves out samples.
void Sampler::leaveOut() {
    if (parts_ == 1)
        throw Error(concat("the faces of the model need more than ", options_.most,
                           " samples; ask for fewer vertices or larger cells"));
    parts_ /= 2;
    taken_.clear();
    std::size_t kept = 0;
    for (std::size_t i = 0; i < samples_.size(); ++i) {
        checkCancelledEvery(i, 12);
        if (taken_.insert(placeOf(samples_[i].position, samples_[i].normal)) || i < modelPoints_)
            samples_[kept++] = samples_[i];
    }
    samples_.resize(kept);
    work_.add(static_cast<double>(taken_.size()) * kPerVisit);
}

/// The same as ModelVoxels::isInner(), which takes longer than all else and depends on the voxel
/// only.
bool Sampler::isInner(const Point3& local) {
    const std::size_t voxel = voxels_.grid().cubeOf(local);
    if (!knownVoxels_[voxel]) {
        knownVoxels_.insert(voxel);
        if (voxels_.isInner(local)) innerVoxels_.insert(voxel);
    }
    return innerVoxels_[voxel];
}

/// Returns a number for the part of a voxel that holds a point, and for the side of a cube that its
/// normal looks to.
std::uint64_t Sampler::placeOf(const Point3& point, const Normal& normal) {
    const Point3 local = localOf(point);
    const CubeGrid& grid = voxels_.grid();
    const auto voxel = grid.coordinatesOf(local);
    const int parts = isInner(local) ? 1 : parts_;
    auto place = static_cast<std::uint64_t>(grid.cubeAt(voxel));
    std::uint64_t side = 0;  // if the normal is not known
    float most = 0;
    for (std::size_t axis = 0; axis < 3; ++axis) {
        const double inside = (local[axis] - grid.origin[axis]) / grid.size - voxel[axis];
        const int part = std::clamp(static_cast<int>(inside * parts), 0, parts - 1);
        place = 4 * place + static_cast<std::uint64_t>(part);
        if (std::abs(normal[axis]) <= most) continue;
        most = std::abs(normal[axis]);
        side = 1 + 2 * axis + (normal[axis] > 0 ? 1 : 0);
    }
    return 8 * place + side;
}

}  // namespace

std::vector<FitPoint> sampleModel(const ModelSurface& surface, const ModelVoxels& voxels,
                                  const GridCells& cells, const SampleOptions& options,
                                  Work& work) {
    Sampler sampler(surface, voxels, cells, options, work);
    return sampler.areFew() ? sampler.all() : sampler.few();
}

}  // namespace espalier::cages
