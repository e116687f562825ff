// SPDX-License-Identifier: Apache-2.0
#include "cages/model_samples.h"

#include <espalier/base/vector3.h>
#include <gtest/gtest.h>

#include <algorithm>

#include "face_models.h"
#include "support/test.h"

namespace espalier::cages {
namespace {

using test::FaceModel;

constexpr double kCellSize = 0.8, kSampleSpacing = kCellSize / 8;

/// `count` copies of a square, each turned a little about its middle.
FaceModel turnedSquares(int count) {
    FaceModel model;
    for (int i = 0; i < count; ++i) {
        const double a = 0.01 * i;
        const auto first = static_cast<Index>(model.points.size());
        for (const auto& [x, y] : {std::pair{-1.0, -1.0}, {1.0, -1.0}, {1.0, 1.0}, {-1.0, 1.0}})
            model.points.push_back(
                {x * std::cos(a) - y * std::sin(a), x * std::sin(a) + y * std::cos(a), 0});
        model.addFace({first, first + 1, first + 2, first + 3});
    }
    return model;
}

std::vector<FitPoint> samplesOf(const FaceModel& model, std::size_t most, double maxWork = 1e18) {
    const ModelSurface surface(model);
    const ModelVoxels voxels(surface, surface.points(),
                             {.size = kSampleSpacing, .gap = kCellSize / 2});
    const GridCells cells(voxels, {.voxelsPerEdge = 8, .joinDistance = 6});
    Work work(maxWork);
    return sampleModel(surface, voxels, cells, {.spacing = kSampleSpacing, .most = most}, work);
}

double distanceTo(std::span<const FitPoint> samples, const Point3& point) {
    double least = kInfinity;
    for (const FitPoint& sample : samples)
        least = std::min(least, length(difference(sample.position, point)));
    return least;
}

TEST(SampleModel, leavesOutSamplesNearOthersIfThereWouldBeTooMany) {
    const FaceModel model = turnedSquares(60);
    const auto all = samplesOf(model, 1'000'000);
    ASSERT_GT(all.size(), 60u * 1000);  // 20 spacings along a side, two or more samples for each
    for (const std::size_t most : {20'000u, 4000u, 1500u}) {
        const auto few = samplesOf(model, most);
        EXPECT_LE(few.size(), most + model.points.size());
        // All points of the model remain.
        for (const Point3& point : model.points) ASSERT_EQ(distanceTo(few, point), 0) << most;
        // A sample that is left out is in one voxel, as wide as the spacing, with one that remains.
        for (std::size_t i = 0; i < all.size(); i += 97)
            ASSERT_LE(distanceTo(few, all[i].position), std::sqrt(3) * kSampleSpacing) << most;
    }
    // Samples are not changed where they are few enough.
    EXPECT_EQ(samplesOf(model, all.size()), all);
    EXPECT_LT(samplesOf(model, all.size() - 1).size(), all.size());
}

TEST(SampleModel, keepsBothSidesOfAThinSolid) {
    // Two squares, a thousandth of a voxel apart: the normals of the samples differ.
    const FaceModel thin = test::joined({test::ballModel(4, {1, 1, 1e-4})});
    const auto all = samplesOf(thin, 1'000'000), few = samplesOf(thin, 1500);
    ASSERT_GT(all.size(), few.size());
    for (const float side : {-1.0f, 1.0f}) {
        const auto looks = [&](const FitPoint& sample) { return sample.normal[2] * side > 0.5f; };
        EXPECT_GT(std::ranges::count_if(few, looks), 200) << side;
    }
}

TEST(SampleModel, refusesAModelThatFillsTooManyVoxels) {
    EXPECT_REFUSED(Error, "need more than 100 samples; ask for fewer vertices",
                   samplesOf(turnedSquares(60), 100));
}

TEST(SampleModel, countsItsWork) {
    EXPECT_THROW(samplesOf(turnedSquares(60), 1'000'000, 1e4), WorkError);
}

}  // namespace
}  // namespace espalier::cages
