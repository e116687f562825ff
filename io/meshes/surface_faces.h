// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <espalier/io/model.h>

#include <span>
#include <vector>

#include "cell_visitor.h"

namespace espalier::io {

/// Collects the faces of surfaces.
class SurfaceFaces final : public CellVisitor {
public:
    void cell(far::StandardCell, std::span<const Index>) override {}
    void polyhedron(std::span<const std::vector<Index>>) override {}
    void face(std::span<const Index> points) override {
        faces.corners.insert(faces.corners.end(), points.begin(), points.end());
        faces.endFace();
    }
    void boundaryFace(std::span<const Index> points) override { face(points); }
    void smallCell(int) override {}
    void curvedCell(int) override {}

    ModelFaces faces;
};

}  // namespace espalier::io
