// SPDX-License-Identifier: Apache-2.0
#include <espalier/solve/mesh_check.h>

#include <algorithm>
#include <utility>

namespace espalier::solve {
namespace {

/// Returns the points at a share of the way from rest to a pose.
std::vector<Point3> atShare(std::span<const Point3> rest, std::span<const Point3> pose,
                            double share) {
    std::vector<Point3> points(rest.begin(), rest.end());
    for (std::size_t point = 0; point < points.size(); ++point)
        for (std::size_t c = 0; c < 3; ++c)
            points[point][c] += share * (pose[point][c] - points[point][c]);
    return points;
}

Index increase(Index before, Index now) {
    return std::max(Index{0}, now - before);
}

}  // namespace

MeshCheck::MeshCheck(far::SimulationMesh mesh, std::span<const Point3> rest,
                     MeshCheckOptions options)
    : mesh_(std::move(mesh)),
      options_(std::move(options)),
      rest_(rest.begin(), rest.end()),
      check_(mesh_.isSurface() ? ValidityCheck(mesh_.surface, rest)
                               : ValidityCheck(mesh_.volume, rest)),
      constraints_(mesh_.patches, rest),
      coupled_(constraints_.coupledFaces(mesh_.patches)),
      before_(qualityAt(rest)) {}

MeshQuality MeshCheck::qualityAt(std::span<const Point3> points) const {
    return mesh_.isSurface() ? surfaceQuality(mesh_.surface, rest_, points)
                             : meshQuality(mesh_.volume, points, coupled_);
}

Index MeshCheck::solverErrors(const MeshQuality& quality) const {
    const auto& before = before_.nonPositiveVolumes;
    Index errors = 0;
    for (const Index cell : quality.nonPositiveVolumes)
        errors += std::ranges::binary_search(before, cell) ? 0 : 1;
    if (!options_.isOpenFoam) return errors;
    return errors + increase(before_.negativePyramids, quality.negativePyramids) +
           increase(before_.beyondRightAngle, quality.beyondRightAngle);
}

bool MeshCheck::isSound(const PoseValidity& validity, const MeshQuality& quality) const {
    // OpenFOAM computes new centres of faces in the pose. With these centres, a polyhedron with
    // bent faces may have no positive volume, although each of its tetrahedra in `validity` is
    // valid.
    return validity.inverted.empty() &&
           std::ranges::includes(before_.nonPositiveVolumes, quality.nonPositiveVolumes);
}

bool MeshCheck::accepts(const MeshVerdict& verdict, Criterion criterion) const {
    for (const PatchDeviation& deviation : verdict.patches)
        if (deviation.isBroken) return false;
    return criterion == Criterion::Exact ? isSound(verdict.validity, verdict.whole)
                                         : solverErrors(verdict.whole) == 0;
}

std::vector<Point3> MeshCheck::stored(std::vector<Point3> points) const {
    return options_.stored ? options_.stored(std::move(points)) : points;
}

double MeshCheck::solverStep(std::span<const Point3> pose, double valid) const {
    constexpr double kPrecision = 1e-3;
    const auto isAccepted = [&](double share) {
        return solverErrors(qualityAt(stored(atShare(rest_, pose, share)))) == 0;
    };
    double accepted = valid > 0 && isAccepted(valid) ? valid : 0, refused = 1;
    while (refused - accepted > kPrecision) {
        const double middle = (accepted + refused) / 2;
        (isAccepted(middle) ? accepted : refused) = middle;
    }
    return accepted;
}

MeshVerdict MeshCheck::check(std::span<const Point3> points) const {
    MeshVerdict verdict;
    const std::vector<Point3> pose = stored({points.begin(), points.end()});
    verdict.validity = check_.check(pose);
    verdict.step = check_.largestStep(pose);
    verdict.whole = qualityAt(pose);
    verdict.quality = verdict.whole;
    // Rounding to the numbers of a file moves points out of every plane that is not across an axis.
    verdict.patches = constraints_.check(points);
    if (solverErrors(verdict.whole) > 0) verdict.solverStep = solverStep(pose, verdict.step.length);
    return verdict;
}

MeshVerdict MeshCheck::shorten(std::vector<Point3>& points, Criterion criterion) const {
    MeshVerdict verdict = check(points);
    const std::vector<Point3> pose = stored(points);
    const auto go = [&](double share) {
        verdict.written = share;
        points = share == 1 ? pose : stored(atShare(rest_, pose, share));
        verdict.quality = share == 1 ? verdict.whole : qualityAt(points);
    };
    if (criterion == Criterion::Solver) {
        go(verdict.solverStep);
        verdict.isRestValid = solverErrors(verdict.quality) == 0;
        return verdict;
    }
    // The step is proved for exact points. Rounding to the numbers of the file can make it
    // shorter; then it is shortened by ever larger parts.
    double share = verdict.step.length;
    for (double less = 0x1p-40; share > 0; less *= 2) {
        go(share);
        if (isSound(share == 1 ? verdict.validity : check_.check(points), verdict.quality))
            return verdict;
        share = std::max(0.0, verdict.step.length * (1 - less));
    }
    go(0);
    verdict.isRestValid = isSound(check_.check(points), verdict.quality);
    return verdict;
}

}  // namespace espalier::solve
