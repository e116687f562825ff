// SPDX-License-Identifier: Apache-2.0
#include <espalier/io/displacements.h>
#include <espalier/io/files/file.h>

#include <cstdint>
#include <string>

#include "io/files/bytes.h"
#include "support/test.h"

namespace espalier::io {
namespace {

using testing::ElementsAre;
constexpr Point3 kNone = {0, 0, 0};

std::vector<Point3> csv(std::string_view text, Index vertexCount = 3) {
    return readDisplacements("step.csv", vertexCount, text);
}

/// Returns the bytes of a .npy file with these numbers.
template <class Number>
std::string npy(const std::string& type, const std::string& shape,
                std::initializer_list<Number> numbers, std::endian order = std::endian::little,
                bool isFortranOrder = false) {
    const std::string head = "{'descr': '" + type +
                             "', 'fortran_order': " + (isFortranOrder ? "True" : "False") +
                             ", 'shape': " + shape + ", }\n";
    std::string bytes = std::string("\x93NUMPY\x01\x00", 8) + static_cast<char>(head.size()) + '\0';
    bytes += head;
    for (const Number number : numbers) {
        char stored[sizeof number];
        storeNumber(stored, number, order);
        bytes.append(stored, sizeof stored);
    }
    return bytes;
}

std::vector<Point3> fromNpy(const std::string& bytes, Index vertexCount = 3) {
    return readDisplacements("step.npy", vertexCount, bytes);
}

const Point3 kA = {0.5, -1, 2}, kB = {1e-3, 0, 4};

TEST(Displacements, ReadsLinesInAnyOrder) {
    EXPECT_THAT(csv("vertex,dx,dy,dz\n2,0.5,-1,2\n0,1e-3,0,4\n"), ElementsAre(kB, kNone, kA));
    EXPECT_THAT(csv("2,0.5,-1,2"), ElementsAre(kNone, kNone, kA));
    // As spreadsheets, pandas and numpy.savetxt() write it.
    EXPECT_THAT(
        csv("\xEF\xBB\xBF\"Vertex\", \"DX\",dy ,dz\r\n\r\n# by hand\r\n 2 , 0.5,-1\t,2\r\n"),
        ElementsAre(kNone, kNone, kA));
    EXPECT_THAT(csv("# vertex,dx,dy,dz\n2.000e+00,5.0e-01,-1.0e+00,2.0e+00\n"),
                ElementsAre(kNone, kNone, kA));
}

TEST(Displacements, RefusesLinesByName) {
    const auto refused = [](std::string_view text, const std::string& why) {
        EXPECT_REFUSED(FileError, "step.csv:" + why, csv(text));
    };
    refused("0,1,2,3\n\n3,0,0,1\n",
            "3: there is no vertex 3; the lattice has 3 vertices, numbered from 0");
    refused("-1,0,0,1\n", "1: there is no vertex -1");
    refused("vertex,dx,dy,dz\n1,0,0,1\n0,0,0,1\n1,0,0,1\n",
            "4: vertex 1 has a displacement already, in line 2");
    refused("1.5,0,0,1\n", "1: expected the number of a vertex, got 1.5");
    refused("1,0,nan,1\n", "1: dy is not finite");
    refused("inf,0,0,1\n", "1: vertex is not finite");
    refused("1,0,,1\n", "1: expected a number for dy, got nothing");
    refused("0,0,0,1\nvertex,dx,dy,dz\n", "2: expected a number for vertex, got 'vertex'");
    refused("dx,dy,dz,vertex\n", "1: expected a number for vertex, got 'dx'");
    refused("1,0,0\n", "1: expected vertex,dx,dy,dz: four numbers with commas between");
    refused("1,0,0,1,\n", "1: expected vertex,dx,dy,dz");
    refused("1;0;0;1\n", "1: expected vertex,dx,dy,dz");
    refused("", " has no displacement; expected lines vertex,dx,dy,dz");
    refused("vertex,dx,dy,dz\n# nothing\n", " has no displacement");
    EXPECT_REFUSED(FileError, "step.csv: is a text in UTF-16",
                   csv(std::string_view("\xFF\xFE"
                                        "1\0,\0",
                                        6)));
}

TEST(Displacements, ReadsArraysOfNumPy) {
    const std::vector<Point3> expected = {kB, kNone, kA};
    EXPECT_EQ(fromNpy(npy<double>("<f8", "(2, 4)", {2, 0.5, -1, 2, 0, 1e-3, 0, 4})), expected);
    EXPECT_EQ(fromNpy(npy<double>("<f8", "(3, 3)", {1e-3, 0, 4, 0, 0, 0, 0.5, -1, 2})), expected);
    // The same array column by column, and in other number types.
    EXPECT_EQ(fromNpy(npy<double>("<f8", "(3, 3)", {1e-3, 0, 0.5, 0, 0, -1, 4, 0, 2},
                                  std::endian::little, true)),
              expected);
    EXPECT_THAT(fromNpy(npy<float>(">f4", "(1, 4)", {2, 0.5F, -1, 2}, std::endian::big)),
                ElementsAre(kNone, kNone, kA));
    EXPECT_THAT(fromNpy(npy<std::int32_t>("<i4", "(1, 4)", {1, 5, 6, 7})),
                ElementsAre(kNone, Point3{5, 6, 7}, kNone));
    // Four vertices with vectors are 4 × 3; four rows with numbers are 4 × 4.
    EXPECT_THAT(fromNpy(npy<double>("<f8", "(1, 4)", {3, 0.5, -1, 2}), 4),
                ElementsAre(kNone, kNone, kNone, kA));
}

TEST(Displacements, RefusesArraysByName) {
    const auto refused = [](const std::string& bytes, const std::string& why) {
        EXPECT_REFUSED(FileError, "step.npy: " + why, fromNpy(bytes));
    };
    refused(npy("<f8", "(2, 4)", {0., 1., 2., 3., 3., 0., 0., 1.}),
            "row 1: there is no vertex 3; the lattice has 3 vertices, numbered from 0");
    refused(npy("<f8", "(2, 4)", {1., 1., 2., 3., 1., 0., 0., 1.}),
            "row 1: vertex 1 has a displacement already, in row 0");
    refused(npy("<f8", "(2, 3)", {1., 2., 3., 4., 5., 6.}),
            "has 2 vectors; expected one for each of the 3 vertices of the lattice");
    refused(npy("<f8", "(1, 2)", {1., 2.}), "has the shape (1, 2); expected (3, 3)");
    refused(npy("<f8", "(3,)", {1., 2., 3.}), "has the shape (3,)");
    refused(npy("<f8", "(1, 1, 3)", {1., 2., 3.}), "has the shape (1, 1, 3)");
    refused(npy<double>("<f8", "(0, 4)", {}), "has no displacement");
    refused(npy<double>("<f8", "(1, 4)", {1, 0, NAN, 0}), "row 0: dy is not finite");
    refused(npy("<f8", "(1, 4)", {0.5, 0., 0., 0.}),
            "row 0: expected the number of a vertex, got 0.5");
    refused("vertex,dx", "is not an array of NumPy");
    EXPECT_REFUSED(FileError, "step.txt: is not a table of displacements; expected .npy or .csv",
                   readDisplacements("step.txt", 3, ""));
}

}  // namespace
}  // namespace espalier::io
