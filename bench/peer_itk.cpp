// SPDX-License-Identifier: Apache-2.0
#include "peer_itk.h"

#include <itkBSplineTransform.h>

#include <algorithm>
#include <array>
#include <cmath>

namespace espalier::bench {

void moveByItk(std::span<const Point3> rest, std::span<const Point3> pose,
               std::span<const Point3> points, std::span<Point3> moved) {
    using Transform = itk::BSplineTransform<double, 3, 3>;
    const std::size_t side = std::lround(std::cbrt(rest.size()));
    const double spacing = 1 / static_cast<double>(side - 1);
    const auto made = Transform::New();
    // Three numbers of control points, three coordinates of the origin, three spacings, and a 3 × 3
    // matrix of directions.
    Transform::FixedParametersType grid(18);
    grid.Fill(0);
    for (unsigned axis = 0; axis < 3; ++axis) {
        grid[axis] = static_cast<double>(side);
        grid[6 + axis] = spacing;
        grid[9 + 4 * axis] = 1;
    }
    made->SetFixedParameters(grid);
    // The displacements along x come first, then the displacements along y and z.
    Transform::ParametersType displacements(made->GetNumberOfParameters());
    for (std::size_t vertex = 0; vertex < rest.size(); ++vertex) {
        std::array<std::size_t, 3> at;
        for (std::size_t axis = 0; axis < 3; ++axis)
            at[axis] = static_cast<std::size_t>(std::lround(rest[vertex][axis] / spacing));
        for (std::size_t axis = 0; axis < 3; ++axis)
            displacements[axis * rest.size() + at[0] + side * (at[1] + side * at[2])] =
                pose[vertex][axis] - rest[vertex][axis];
    }
    made->SetParameters(displacements);
    // Without these arrays, ITK would make arrays for each point.
    Transform::WeightsType weights(made->GetNumberOfWeights());
    Transform::ParameterIndexArrayType indices(made->GetNumberOfWeights());
    for (std::size_t i = 0; i < points.size(); ++i) {
        Transform::OutputPointType point;
        bool inside = false;
        made->TransformPoint(Transform::InputPointType(points[i].data()), point, weights, indices,
                             inside);
        std::copy_n(point.GetDataPointer(), 3, moved[i].begin());
    }
}

}  // namespace espalier::bench
