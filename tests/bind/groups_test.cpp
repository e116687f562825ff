// SPDX-License-Identifier: Apache-2.0
#include <espalier/bind/bind.h>
#include <espalier/osd/binding_evaluator.h>
#include <espalier/shapes/refiner_options.h>
#include <espalier/shapes/solids.h>

#include <atomic>
#include <mutex>
#include <random>

#include "support/refined_lattice.h"
#include "support/test.h"
#include "support/threads.h"
#include "support/zoo.h"

// Tests binding without D, group by group.
namespace espalier::bind {
namespace {

std::vector<Point3> pointsIn(const Lattice& lattice, int count) {
    Point3 low = lattice.positions.front(), high = low;
    for (const Point3& p : lattice.positions)
        for (std::size_t c = 0; c < 3; ++c) {
            low[c] = std::min(low[c], p[c]);
            high[c] = std::max(high[c], p[c]);
        }
    std::mt19937 random(11);
    std::uniform_real_distribution<double> share(-0.05, 1.05);
    std::vector<Point3> points(count);
    for (Point3& p : points)
        for (std::size_t c = 0; c < 3; ++c) p[c] = low[c] + share(random) * (high[c] - low[c]);
    return points;
}

struct Scene {
    std::string name;
    Lattice lattice;
    std::vector<Point3> points;
    Target target;
    BindOptions options = {};

    osd::DeformedPoints deformed(const std::vector<std::vector<Point3>>& poses) const {
        const TopologyRefiner base(lattice.complex, refinerOptions(lattice));
        return osd::deformPoints({base, lattice.positions}, points, target, options, poses);
    }
    Binding bound() const {
        const TopologyRefiner base(lattice.complex, refinerOptions(lattice));
        return bindPoints({base, lattice.positions}, points, target, options);
    }
};

PointWeights weightsOf(std::size_t count) {
    PointWeights weights;
    for (std::size_t i = 0; i < count; ++i) {
        weights.values.push_back(double(i % 5) / 4);
        weights.slopes.push_back({0.1, 0, i % 5 == 4 ? 0.0 : -0.2});
    }
    return weights;
}

/// Scenes for each way in which points get their rows. Regular cells have groups of 2,048 points;
/// other cells have groups of 128 or more, or all points at once if the level has few cells.
std::vector<Scene> scenes() {
    const Lattice box = shapes::box({.cells = {4, 4, 4}});
    const Lattice disk = shapes::cylinder({});
    const embed::EmbeddingOptions nearest{.outside = embed::OutsidePolicy::Nearest};
    std::vector<Scene> all;
    for (const Target& target : {Target(Level{2}), Target(Limit{}), Target(embed::Basis::Bezier),
                                 Target(embed::Basis::BSpline)}) {
        const auto name = "box, target " + std::to_string(all.size());
        all.push_back({name, box, pointsIn(box, 5000), target, {.embedding = nearest}});
        all.push_back({name + ", gradients",
                       box,
                       pointsIn(box, 5000),
                       target,
                       {.gradients = true, .falloff = 0.1}});
        all.back().options.weights = weightsOf(5000);
    }
    all.push_back({"disk, whole level", disk, pointsIn(disk, 5000), Level{1}, {}});
    all.push_back({"disk, groups", disk, pointsIn(disk, 3000), Level{6}, {.gradients = true}});
    all.push_back({"disk, limit", disk, pointsIn(disk, 300), Limit{}, {.embedding = nearest}});
    all.push_back({"disk, twice the whole level",
                   disk,
                   pointsIn(disk, (1 << 18) + 5000),
                   Level{1},
                   {.falloff = 0.2}});
    return all;
}

// The same bits as by D, for each pose, and the same statistics.
TEST(Groups, DeformAsTheTableDoes) {
    for (const Scene& scene : scenes()) {
        SCOPED_TRACE(scene.name);
        const Binding binding = scene.bound();
        const std::vector<std::vector<Point3>> poses = {test::bent(scene.lattice),
                                                        scene.lattice.positions};
        const osd::DeformedPoints deformed = scene.deformed(poses);
        ASSERT_EQ(deformed.poses.size(), 2u);
        EXPECT_EQ(deformed.poses[0].points, osd::evaluateBinding(binding, poses[0]));
        EXPECT_EQ(deformed.poses[1].points, scene.points);
        const BindingStatistics expected = statisticsOf(binding);
        EXPECT_EQ(deformed.statistics.statuses, expected.statuses);
        EXPECT_GT(deformed.statistics.count(embed::PointStatus::Inside), 0);
        EXPECT_EQ(deformed.statistics.rowCount, expected.rowCount);
        EXPECT_EQ(deformed.statistics.columnCount, expected.columnCount);
        EXPECT_EQ(deformed.statistics.entryCount, expected.entryCount);
        EXPECT_EQ(deformed.statistics.emptyRowCount, expected.emptyRowCount);
        EXPECT_EQ(deformed.statistics.emptyOutsideCount, expected.emptyOutsideCount);
        EXPECT_EQ(deformed.statistics.hasGradients, expected.hasGradients);
        EXPECT_EQ(deformed.statistics.identityCount, expected.identityCount);
        EXPECT_EQ(deformed.statistics.largestResidual, expected.largestResidual);
        if (!scene.options.gradients) {
            EXPECT_TRUE(deformed.poses[0].gradients.empty());
            continue;
        }
        const auto gradients = osd::evaluateGradients(binding, poses[0]);
        ASSERT_EQ(deformed.poses[0].gradients.size(), gradients.size());
        double largest = 0;
        for (std::size_t i = 0; i < gradients.size(); ++i)
            for (std::size_t k = 0; k < 9; ++k)
                largest = std::max(largest,
                                   std::abs(deformed.poses[0].gradients[i][k] - gradients[i][k]));
        // Groups may use vertices of the level where D uses those of the base: sums of 64 products
        // are rounded, and level 6 divides differences of vertices by its spacing of 1/64.
        EXPECT_LT(largest, 1e-12);
    }
}

// Each point that is sought is in one group, and the points with the weight 0 are in none.
TEST(Groups, HaveEachPointOnce) {
    for (const Scene& scene : scenes()) {
        SCOPED_TRACE(scene.name);
        const TopologyRefiner base(scene.lattice.complex, refinerOptions(scene.lattice));
        std::vector<int> counts(scene.points.size());
        std::mutex mutex;
        const auto sink = [&](std::span<const Index> numbers, WeightedRows rows) {
            const std::lock_guard lock(mutex);
            EXPECT_EQ(std::ssize(numbers), rows.table.rowCount());
            for (const Index number : numbers) ++counts[number];
        };
        bindInGroups({base, scene.lattice.positions}, scene.points, scene.target, scene.options,
                     sink);
        const auto& values = scene.options.weights.values;
        for (std::size_t i = 0; i < counts.size(); ++i)
            ASSERT_EQ(counts[i], values.empty() || values[i] > 0 ? 1 : 0) << i;
    }
}

TEST(Groups, DoNotDependOnTheNumberOfThreads) {
    const Scene scene = scenes()[1];
    const std::vector<std::vector<Point3>> poses = {test::bent(scene.lattice)};
    const auto expected = scene.deformed(poses);
    const ThreadLimit one(1);
    const auto again = scene.deformed(poses);
    EXPECT_EQ(again.poses[0].points, expected.poses[0].points);
    EXPECT_EQ(again.poses[0].gradients, expected.poses[0].gradients);
}

// The errors are those of bindPoints().
TEST(Groups, RefuseAsTheTableDoes) {
    Scene scene = scenes()[0];
    scene.options.embedding.outside = embed::OutsidePolicy::Error;
    const auto first = [](const auto& run) -> std::string {
        try {
            run();
        } catch (const Error& error) {
            return error.what();
        }
        return "no error";
    };
    const auto expectSame = [&] {
        const std::string message = first([&] { scene.deformed({scene.lattice.positions}); });
        EXPECT_NE(message, "no error");
        EXPECT_EQ(message, first([&] { scene.bound(); }));
    };
    for (const Target& target : {Target(Level{2}), Target(Limit{}), Target(embed::Basis::Bezier)}) {
        scene.target = target;
        expectSame();
    }
    scene.options.weights = weightsOf(scene.points.size());
    expectSame();
    scene.options.falloff = 1;
    expectSame();
    scene.options = {};
    scene.target = Level{0};
    expectSame();
    scene.target = embed::Basis::BSpline;
    scene.lattice = shapes::cylinder({});
    expectSame();
    EXPECT_REFUSED(Error, "the pose has 1 vertices; the model is bound to a lattice of",
                   scene.deformed({{{0, 0, 0}}}));
}

// With the weight 0 for each point, and without points, nothing moves and nothing fails.
TEST(Groups, MayBeNone) {
    Scene scene = scenes()[0];
    scene.options.weights.values.assign(scene.points.size(), 0);
    const auto still = scene.deformed({test::bent(scene.lattice)});
    EXPECT_EQ(still.poses[0].points, scene.points);
    EXPECT_EQ(still.statistics.count(embed::PointStatus::NotBound), 5000);
    scene.options = {};
    scene.points.clear();
    const auto none = scene.deformed({test::bent(scene.lattice)});
    EXPECT_TRUE(none.poses[0].points.empty());
    EXPECT_EQ(none.statistics.columnCount, std::ssize(scene.lattice.positions));
}

TEST(Groups, TellTheirProgress) {
    for (Scene& scene : std::vector<Scene>(scenes())) {
        SCOPED_TRACE(scene.name);
        std::atomic<Offset> most = 0;
        scene.options.progress = [&](Offset done) {
            for (Offset before = most; done > before && !most.compare_exchange_weak(before, done);)
                ;
        };
        scene.deformed({});
        const auto& values = scene.options.weights.values;
        const auto zeros = std::ranges::count(values, 0.0);
        EXPECT_EQ(most, std::ssize(scene.points) - zeros);
    }
}

}  // namespace
}  // namespace espalier::bind
