// SPDX-License-Identifier: Apache-2.0
#include <espalier/io/model.h>
#include <io/gradient_samples.h>
#include <io/model_files.h>

#include <cstdlib>
#include <sstream>

namespace espalier::io {
namespace {

using Gradients = std::vector<DeformationGradient>;

/// Maps y to z and z to -y.
constexpr DeformationGradient kTilt = {1, 0, 0, 0, 0, -1, 0, 1, 0};

/// Returns the text that the model writes with these gradients if its points stay.
std::string carriedBy(const Gradients& gradients, const std::string& text) {
    const auto model = readModel("a.obj", text);
    return written(*model, model->positions(), gradients);
}

/// A corner with a normal, as found by a reader that reads the file once.
struct Corner {
    std::size_t point = 0;
    std::size_t normal = 0;
    bool isForward = false;  ///< true if its normal comes later in the file
};

struct Read {
    std::vector<Point3> normals;
    std::vector<Corner> corners;
};

/// Reads a file that has no comments within lines, by simple independent code.
Read readIndependently(std::string text) {
    for (const std::string continued : {"\\\r\n", "\\\n"})
        for (std::size_t at = 0; (at = text.find(continued)) != std::string::npos;)
            text.replace(at, continued.size(), " ");
    Read read;
    std::size_t pointCount = 0;
    std::istringstream lines(text);
    for (std::string line; std::getline(lines, line);) {
        std::istringstream words(line);
        std::string word;
        words >> word;
        if (word == "v") ++pointCount;
        if (word == "vn") {
            Point3& normal = read.normals.emplace_back();
            words >> normal[0] >> normal[1] >> normal[2];
        }
        if (word != "f") continue;
        while (words >> word) {
            if (word.front() == '#') break;
            const std::size_t slash = word.rfind('/');
            if (slash == std::string::npos || slash == word.find('/')) continue;
            const auto indexOf = [](const std::string& number, std::size_t count) {
                const long value = std::strtol(number.c_str(), nullptr, 10);
                return value < 0 ? count - std::size_t(-value) : std::size_t(value) - 1;
            };
            const std::size_t normal = indexOf(word.substr(slash + 1), read.normals.size());
            read.corners.push_back({indexOf(word.substr(0, word.find('/')), pointCount), normal,
                                    normal >= read.normals.size()});
        }
    }
    return read;
}

/// Expects that every corner has its old normal carried by its gradient, and that a corner precedes
/// its normal only if it did before.
void expectCarried(const std::string& text, const Gradients& gradients) {
    const Read before = readIndependently(text);
    const Read after = readIndependently(carriedBy(gradients, text));
    SCOPED_TRACE(text.substr(0, 500));
    ASSERT_EQ(after.corners.size(), before.corners.size());
    for (std::size_t i = 0; i < before.corners.size(); ++i) {
        const Corner& was = before.corners[i];
        const Corner& is = after.corners[i];
        ASSERT_EQ(is.point, was.point) << "corner " << i;
        ASSERT_TRUE(was.isForward || !is.isForward) << "corner " << i;
        ASSERT_LT(is.normal, after.normals.size()) << "corner " << i;
        const Point3 expected = carryNormal(gradients[was.point], before.normals[was.normal]);
        // Normals are written with nine digits.
        for (std::size_t axis = 0; axis < 3; ++axis)
            ASSERT_NEAR(after.normals[is.normal][axis], expected[axis], 1e-9) << "corner " << i;
    }
}

/// Four points, and a different gradient for each.
const std::string kPoints = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\n";
const Gradients kGradients = {kIdentity, kQuarterTurn, kTilt, rotation({1, 1, 0}, 0.3)};

TEST(ObjNormals, CountAsDirections) {
    EXPECT_FALSE(readModel("a.obj", "v 0 0 0\n# vn 0 0 1\n")->hasDirections());
    EXPECT_TRUE(readModel("a.obj", "v 0 0 0\nvn 0 0 1\n")->hasDirections());
}

TEST(ObjNormals, AreRewrittenInPlaceUnderARotation) {
    const std::string before =
        "v 0 0 0\n"
        "vn\t1.000  0 -0.0 # x\r\n"
        "vn 0.6 \\\n 0 0.80\n"
        "f 1//1 1//2 1//1\n";
    EXPECT_EQ(carriedBy({kQuarterTurn}, before),
              "v 0 0 0\n"
              "vn\t0  1 -0.0 # x\r\n"
              "vn 0 \\\n 0.6 0.80\n"
              "f 1//1 1//2 1//1\n");
}

TEST(ObjNormals, AreCarriedWhilePointsMove) {
    const auto model = readModel("a.obj", "v 0 0 0\nvn 1 0 0\nv 1 0 0\nf 1//1 2//1 1//1\n");
    EXPECT_EQ(written(*model, std::vector<Point3>{{0, 0, 0}, {0, 1, 0}},
                      Gradients{kQuarterTurn, kQuarterTurn}),
              "v 0 0 0\nvn 0 1 0\nv 0 1 0\nf 1//1 2//1 1//1\n");
}

TEST(ObjNormals, KeepEveryByteUnderTheIdentity) {
    const std::string text =
        "\xEF\xBB\xBF# exported\n"
        "v 0 0 0\nv 1 0 0 0.5 0.5 0.5\n"
        "vn 0.57735026918962576 .5773502691896257645 0.577350\n"
        "vn 0 0 1e0 junk\nvn nan 0 0\nvn\nvn 1 2\nvn 0 0 0\n"
        "usemtl f\nf 1/1/+1 -1//-6 \\\r\n 2/2/2 1//3 2//6# f 1//1\n"
        "f 1//99 0//0 99//1 1//x //1 1/1 1 1/2/3/4\nfo 1//1 2//2 1//1";
    EXPECT_EQ(carriedBy({kIdentity, kIdentity}, text), text);
}

TEST(ObjNormals, AreSplitWhereCornersDiffer) {
    // Points 1 and 4 do not turn, so they share a normal. The first corner keeps the line; new
    // lines follow the last normal before the face.
    EXPECT_EQ(
        carriedBy({kIdentity, kQuarterTurn, kTilt, kIdentity}, kPoints + "vn 0 1 0\n"
                                                                         "vn 0 0 1 # the last\n"
                                                                         "g one\n"
                                                                         "f 1//1 2//1 3//1 4//1\n"
                                                                         "f 1/7/2  2/7/2 3/7/2\n"
                                                                         "f 3//1 2//1 1//1\n"),
        kPoints +
            "vn 0 1 0\n"
            "vn 0 0 1 # the last\n"
            "vn -1 0 0\n"
            "vn 0 0 1\n"
            "vn 0 -1 0\n"
            "g one\n"
            "f 1//1 2//3 3//4 4//1\n"
            "f 1/7/2  2/7/2 3/7/5\n"
            "f 3//4 2//3 1//1\n");
}

TEST(ObjNormals, FirstCornerKeepsTheLine) {
    EXPECT_EQ(carriedBy({kIdentity, kQuarterTurn},
                        "v 0 0 0\nv 1 0 0\nvn 0 1 0\n"
                        "f 2//1 1//1 2//1\n"),
              "v 0 0 0\nv 1 0 0\nvn -1 0 0\nvn 0 1 0\nf 2//1 1//2 2//1\n");
}

TEST(ObjNormals, NumbersThatCountBackStillCountBack) {
    // The new line follows the second normal, so the numbers -2 and -1 decrease by one where they
    // name a normal before it.
    EXPECT_EQ(carriedBy({kIdentity, kQuarterTurn, kIdentity, kIdentity},
                        kPoints + "vn 0 1 0\n"
                                  "vn 0 0 1\n"
                                  "f -4//-2 -3//-2 -2//-1\n"
                                  "vn 1 0 0\n"
                                  "f -4//-3 -3//-3 -2//-2 -1//-1\n"),
              kPoints +
                  "vn 0 1 0\n"
                  "vn 0 0 1\n"
                  "vn -1 0 0\n"
                  "f -4//-3 -3//-1 -2//-2\n"
                  "vn 1 0 0\n"
                  "f -4//-4 -3//-2 -2//-3 -1//-1\n");
}

TEST(ObjNormals, NormalsOfLaterObjectsAreRenumbered) {
    // Two objects, each with its own points, normals and faces; the first gets a new line.
    EXPECT_EQ(carriedBy({kIdentity, kQuarterTurn, kIdentity},
                        "v 0 0 0\nv 1 0 0\nvn 0 1 0\nf 1//1 2//1 1//1\n"
                        "v 2 0 0\nvn 0 0 1\nf 3//2 3//2 3//2\n"),
              "v 0 0 0\nv 1 0 0\nvn 0 1 0\nvn -1 0 0\nf 1//1 2//2 1//1\n"
              "v 2 0 0\nvn 0 0 1\nf 3//3 3//3 3//3\n");
}

TEST(ObjNormals, EveryCornerGetsItsCarriedNormal) {
    const std::string faces =
        "f 1//1 2//1 3//1 4//1\n"
        "f 4//2 3//2 2//2\n"
        "f -4/1/-1 -3/1/-2 \\\n-2/1/-1 # 1//1\n"
        "f 1/2 2/2 3//-1\n";
    const std::string first = "vn 0 1 0\nvn 0.36 -0.48 0.8\n";
    const std::string second = "vn 1 2 3\nvn -2 0 0\n";
    const std::string later = "f 1//3 2//4 3//1\nf 2//3 1//4 3//2 4//-4 4//-3 4//-2 4//-1\n";
    for (const std::string& text :
         {kPoints + first + faces,
          first + kPoints + faces,                   // normals before points
          kPoints + first + faces + second + later,  // objects
          kPoints + first + faces + second + later + faces,
          kPoints + first + second + later + faces,
          kPoints + "f 1//1 2//1 3//2\n" + first + faces,  // normals after their first use
          kPoints + first + "f 1//4 2//4 3//3 4//1\n" + second + later + faces,
          kPoints + "f 1//1 2//1 3//2 4//2\n" + first.substr(0, first.size() - 1)}) {
        expectCarried(text, kGradients);
        expectCarried(text, {kTilt, kIdentity, kTilt, kIdentity});
        std::string crlf;
        for (const char c : text) crlf += c == '\n' ? "\r\n" : std::string(1, c);
        expectCarried(crlf, kGradients);
        EXPECT_EQ(carriedBy(Gradients(4, kIdentity), text), text);
    }
}

TEST(ObjNormals, NewLinesCopyTheLineEndBefore) {
    const Gradients gradients = {kIdentity, kQuarterTurn};
    const std::string points = "v 0 0 0\nv 1 0 0\n";
    EXPECT_EQ(carriedBy(gradients, points + "vn 0 1 0\r\nf 1//1 2//1 1//1"),
              points + "vn 0 1 0\r\nvn -1 0 0\r\nf 1//1 2//2 1//1");
    // Faces precede their normals, and the last line has no end; a backslash there must not
    // continue it.
    EXPECT_EQ(carriedBy(gradients, points + "f 1//1 2//1 1//1\nvn 0 1 0"),
              points + "f 1//1 2//2 1//1\nvn 0 1 0\nvn -1 0 0");
    EXPECT_EQ(carriedBy(gradients, points + "f 1//1 2//1 1//1\nvn 0 1 0 \\"),
              points + "f 1//1 2//2 1//1\nvn 0 1 0 \\\n\nvn -1 0 0");
}

TEST(ObjNormals, NewLinesFollowANormalThatComesAfterItsCorner) {
    EXPECT_EQ(carriedBy({kIdentity, kQuarterTurn},
                        "v 0 0 0\nv 1 0 0\nvn 0 0 1\nf 1//2 2//2 1//1\nvn 0 1 0\nvn 1 0 0\n"),
              "v 0 0 0\nv 1 0 0\nvn 0 0 1\nf 1//2 2//3 1//1\nvn 0 1 0\nvn -1 0 0\nvn 1 0 0\n");
}

TEST(ObjNormals, StaySharedUnderARigidMotion) {
    // The gradients differ by rounding, as computed gradients do.
    Gradients gradients(4, rotation({1, 2, 3}, 1));
    for (std::size_t i = 0; i < gradients.size(); ++i)
        for (double& entry : gradients[i]) entry *= 1 + 1e-15 * double(i);
    const std::string text = kPoints + "vn 0 0 1\nf 1//1 2//1 3//1 4//1\n";
    const Read read = readIndependently(carriedBy(gradients, text));
    EXPECT_EQ(read.normals.size(), 1u);
    expectCarried(text, gradients);
}

TEST(ObjNormals, HaveNoNegativeZeros) {
    // cos 90° is 6e-17 here, and rounds to 0.
    EXPECT_EQ(carriedBy({rotation({0, 0, 1}, std::acos(0))}, "v 0 0 0\nvn -1 0 0\nf 1//1 1//1\n"),
              "v 0 0 0\nvn 0 -1 0\nf 1//1 1//1\n");
}

TEST(ObjNormals, KeepTheirLengths) {
    const Read read = readIndependently(carriedBy({rotation({1, 2, 3}, 1)},
                                                  "v 0 0 0\nvn 0 0 1\nvn 0 3e-5 4e-5\nvn 2e7 0 0\n"
                                                  "f 1//1 1//2 1//3\n"));
    const double expected[] = {1, 5e-5, 2e7};
    for (std::size_t i = 0; i < 3; ++i) {
        const Point3& normal = read.normals[i];
        // Nine digits are written.
        EXPECT_NEAR(std::hypot(normal[0], normal[1], normal[2]) / expected[i], 1, 2e-9);
    }
}

TEST(ObjNormals, UnusedNormalsAndVectorsThatAreNoDirectionStay) {
    const std::string text =
        "v 0 0 0\nvn 1 0 0\nvn 0 0 0\nvn nan 1 0\nvn 1e308 1e308 1e308\nvn 1 0\nvn x 1 0\n"
        "f 1//2 1//3 1//4 1//5 1//6\nl 1 1\np 1\nusemtl 1//1\n";
    EXPECT_EQ(carriedBy({kQuarterTurn}, text), text);
    // A corner whose point does not exist does not carry its normal, but its number is updated.
    EXPECT_EQ(carriedBy({kIdentity, kQuarterTurn},
                        "v 0 0 0\nv 1 0 0\nvn 0 1 0\nf 1//1 2//1 9//1\nvn 1 0 0\n"
                        "f 9//2 x//2 1//3 1//2/1\n"),
              "v 0 0 0\nv 1 0 0\nvn 0 1 0\nvn -1 0 0\nf 1//1 2//2 9//1\nvn 1 0 0\n"
              "f 9//3 x//3 1//3 1//2/1\n");
}

TEST(ObjNormals, CornersOfFoAndSurfAreCarriedToo) {
    EXPECT_EQ(carriedBy({kQuarterTurn, kIdentity},
                        "v 0 0 0\nv 0 0 1\nvn 1 0 0\nvn 0 1 0\nsurf 0 1 0 1 1//1 2//1\n"
                        "fo 1//2 1//2 1//2\n"),
              "v 0 0 0\nv 0 0 1\nvn 0 1 0\nvn -1 0 0\nvn 1 0 0\nsurf 0 1 0 1 1//1 2//3\n"
              "fo 1//2 1//2 1//2\n");
}

TEST(ObjNormals, OneNormalMayBeSplitForManyPoints) {
    constexpr int kCount = 20000;
    std::string text = "vn 0 0 1\n";
    Gradients gradients;
    for (int i = 0; i < kCount; ++i) {
        text += "v " + std::to_string(i) + " 0 0\nf -1//1 -1//-1 -1//1\n";
        gradients.push_back(rotation({1, 0, 0}, 1e-5 * i));
    }
    const Read read = readIndependently(carriedBy(gradients, text));
    EXPECT_EQ(read.normals.size(), std::size_t{kCount});
    expectCarried(text, gradients);
}

}  // namespace
}  // namespace espalier::io
