// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cmath>
#include <numbers>
#include <random>
#include <vector>

#include "face_models.h"

// Models that no one makes on purpose.
namespace espalier::test {

/// A triangle soup: up to 40 triangles of very different sizes, and now and then a flat one, a
/// duplicate, or a point that occurs twice.
inline FaceModel randomSoup(unsigned seed) {
    std::mt19937 random(seed);
    std::uniform_real_distribution<double> place(-1, 1), unit(0, 1);
    FaceModel soup;
    const int count = std::uniform_int_distribution<int>(1, 40)(random);
    for (int t = 0; t < count; ++t) {
        const auto first = static_cast<Index>(soup.points.size());
        const double size = std::pow(10, -3 * unit(random));
        const Point3 centre = {place(random), place(random), place(random)};
        for (int i = 0; i < 3; ++i) {
            Point3 p = sum(centre, scaled({place(random), place(random), place(random)}, size));
            if (seed % 5 == 0) p[2] = 0;
            if (unit(random) < 0.1)
                p = soup.points.empty() ? p : soup.points[random() % soup.points.size()];
            soup.points.push_back(p);
        }
        if (unit(random) < 0.1)
            soup.addFace({first, first, first + 1});
        else
            soup.addFace({first, first + 1, first + 2});
        if (unit(random) < 0.1) soup.addFace({first + 2, first + 1, first});
    }
    return soup;
}

/// Triangles of three points each, made by corner(triangle, number).
template <class Corner>
FaceModel trianglesModel(int count, Corner corner) {
    FaceModel model;
    for (int t = 0; t < count; ++t) {
        for (int i = 0; i < 3; ++i) model.points.push_back(corner(t, i));
        const Index first = 3 * t;
        model.addFace({first, first + 1, first + 2});
    }
    return model;
}

/// The same faces, with points moved by move(point).
template <class Move>
FaceModel withPoints(FaceModel model, Move move) {
    for (Point3& p : model.points) p = move(p);
    return model;
}

struct DegenerateModel {
    const char* name;
    FaceModel model;
};

/// One model of each kind of degenerate geometry.
inline std::vector<DegenerateModel> degenerateModels() {
    std::mt19937 random(1);
    std::uniform_real_distribution<double> unit(-1, 1);
    const auto anywhere = [&] { return Point3{unit(random), unit(random), unit(random)}; };
    const auto ball = ballModel(2);
    std::vector<DegenerateModel> models;
    const auto add = [&](const char* name, FaceModel model) {
        models.push_back({name, std::move(model)});
    };
    add("one triangle", trianglesModel(1, [&](int, int i) {
            return Point3{i == 1 ? 1.0 : 0.0, i == 2 ? 1.0 : 0.0, 0.5};
        }));
    add("triangles without area", trianglesModel(20, [&](int t, int i) {
            return Point3{0.1 * t + i, 0.3 * (t % 5) + i, 0.2 * (t % 3) + i};
        }));
    add("needles", trianglesModel(20, [&](int t, int i) {
            return Point3{i == 2 ? 1.0 : -1.0, 0.1 * t + (i == 1 ? 1e-13 : 0.0), 0.01 * t * t};
        }));
    add("points on a line", trianglesModel(20, [&](int, int) {
            const double u = unit(random);
            return Point3{u, 2 * u, -u};
        }));
    add("points at few places", trianglesModel(50, [&](int, int) {
            return Point3{std::round(unit(random)), std::round(unit(random)), 0};
        }));
    FaceModel points;
    for (int i = 0; i < 50; ++i) {
        points.points.push_back(anywhere());
        if (i % 2 == 0) points.addFace({i});
    }
    add("points only", points);
    add("each face ten times", joined({ball, ball, ball, ball, ball, reversed(ball), reversed(ball),
                                       reversed(ball), reversed(ball), ball}));
    add("inside out", reversed(ball));
    add("a ball in a ball, inside out",
        reversed(joined({ball, reversed(ballModel(2, {0.5, 0.5, 0.5}))})));
    add("huge", withPoints(ball, [](const Point3& p) { return scaled(p, 1e39); }));
    add("tiny", withPoints(ball, [](const Point3& p) { return scaled(p, 1e-39); }));
    // Coordinates are multiples of 3e-8.
    add("far away", moved(ball, {2e8, -2e8, 2e8}));
    add("nearly flat", withPoints(ball, [](const Point3& p) {
            return Point3{p[0], p[1], 1e-9 * p[2]};
        }));
    add("nearly a line", withPoints(ball, [](const Point3& p) {
            return Point3{p[0], 1e-12 * p[1], 1e-9 * p[2]};
        }));
    add("thousands of tiny parts", trianglesModel(3000, [&, centre = Point3{}](int, int i) mutable {
            if (i == 0) centre = anywhere();
            return sum(centre, scaled(anywhere(), 1e-4));
        }));
    std::vector<FaceModel> balls;
    for (int i = 0; i < 300; ++i) balls.push_back(ballModel(0, {0.02, 0.02, 0.02}, anywhere()));
    add("hundreds of tiny balls", joined(balls));
    FaceModel spiked = ball;
    spiked.points.push_back({9, 0.3, 0.2});
    spiked.addFace({0, 1, static_cast<Index>(spiked.points.size()) - 1});
    add("a ball with a spike", spiked);
    add("sizes from 1 to 1e-6", joined({ball, ballModel(1, {1e-3, 1e-3, 1e-3}, {1.5, 0, 0}),
                                        ballModel(1, {1e-6, 1e-6, 1e-6}, {0, 2, 0})}));
    std::vector<FaceModel> shells;
    for (int i = 1; i <= 12; ++i) {
        const double r = i / 12.0;
        shells.push_back(i % 2 == 0 ? ballModel(2, {r, r, r}) : reversed(ballModel(2, {r, r, r})));
    }
    add("twelve shells", joined(shells));
    // A strip with half a turn, which has no two sides.
    FaceModel moebius;
    constexpr int kSteps = 40;
    for (int i = 0; i < kSteps; ++i) {
        const double a = 2 * std::numbers::pi * i / kSteps;
        for (const double w : {-0.3, 0.3}) {
            const double r = 1 + w * std::cos(a / 2);
            moebius.points.push_back({r * std::cos(a), r * std::sin(a), w * std::sin(a / 2)});
        }
        const Index at = 2 * i, next = 2 * ((i + 1) % kSteps), turn = i + 1 == kSteps ? 1 : 0;
        moebius.addFace({at, next + turn, next + 1 - turn, at + 1});
    }
    add("a Moebius strip", moebius);
    // Half planes around one edge.
    FaceModel book;
    book.points = {{0, 0, -1}, {0, 0, 1}};
    for (int i = 0; i < 7; ++i) {
        const double a = 2 * std::numbers::pi * i / 7;
        const Index first = 2 + 2 * i;
        book.points.push_back({std::cos(a), std::sin(a), -1});
        book.points.push_back({std::cos(a), std::sin(a), 1});
        book.addFace({0, first, first + 1, 1});
    }
    add("seven pages at an edge", book);
    // A polygon that winds around its centre twice and passes through itself.
    FaceModel star;
    for (int i = 0; i < 2001; ++i) {
        const double a = 4 * std::numbers::pi * i / 2001, r = i % 3 == 0 ? 1 : 0.5;
        star.points.push_back({r * std::cos(a), r * std::sin(a), 0.1 * std::sin(7 * a)});
        star.corners.push_back(i);
    }
    star.ends.push_back(star.corners.size());
    add("a polygon of 2001 corners", star);
    FaceModel open = ball;
    open.corners.resize(3 * 70);
    open.ends.resize(70);
    add("half a ball", open);
    // Cubes that share an edge, a corner and a face; the last one twice the same solid.
    const auto cube = [](const Point3& low) {
        FaceModel model;
        for (unsigned corner = 0; corner < 8; ++corner)
            model.points.push_back(
                {low[0] + (corner & 1), low[1] + (corner >> 1 & 1), low[2] + (corner >> 2 & 1)});
        for (const auto& f : {std::array<Index, 4>{0, 2, 3, 1},
                              {4, 5, 7, 6},
                              {0, 1, 5, 4},
                              {2, 6, 7, 3},
                              {0, 4, 6, 2},
                              {1, 3, 7, 5}})
            model.addFace({f[0], f[1], f[2], f[3]});
        return model;
    };
    add("cubes that touch", joined({cube({0, 0, 0}), cube({1, 1, 0}), cube({2, 2, 1}),
                                    cube({3, 2, 1}), cube({0, 0, 0})}));
    return models;
}

}  // namespace espalier::test
