// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <espalier/base/error.h>
#include <espalier/io/model.h>

#include <cstddef>
#include <span>
#include <utility>
#include <vector>

#include "cell_visitor.h"

namespace espalier::io {

/// Collects the faces of surfaces, and counts the cells of volumes.
class SurfaceFaces final : public CellVisitor {
public:
    void cell(far::StandardCell, std::span<const Index>) override { ++cellCount_; }
    void polyhedron(std::span<const std::vector<Index>>) override { ++cellCount_; }
    void face(std::span<const Index> points) override {
        ModelFaces& faces = surface_.faces;
        faces.corners.insert(faces.corners.end(), points.begin(), points.end());
        faces.endFace();
    }
    void boundaryFace(std::span<const Index> points) override { face(points); }
    void smallCell(int, std::span<const Index>) override {}
    void curvedCell(int dimension, std::span<const Index>) override {
        cellCount_ += dimension == 3 ? 1 : 0;
    }

    void unknownElement(std::size_t, const std::string&) override { ++unknownCount_; }

    /// Returns the surface, which names the cells of volumes as other shapes. This must not be used
    /// afterwards.
    ModelSurface take() {
        if (cellCount_ > 0)
            surface_.otherShapes.push_back(
                concat(cellCount_, cellCount_ == 1 ? " cell" : " cells", " of a volume"));
        if (unknownCount_ > 0)
            surface_.otherShapes.push_back(concat(
                unknownCount_, unknownCount_ == 1 ? " element" : " elements", " of unknown types"));
        return std::move(surface_);
    }

private:
    ModelSurface surface_;
    std::size_t cellCount_ = 0;
    std::size_t unknownCount_ = 0;
};

}  // namespace espalier::io
