// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <espalier/io/model.h>

#include <memory>
#include <span>
#include <string>
#include <vector>

namespace espalier::python {

/// The file of a model, and what is read from it.
struct ModelFile {
    std::string name;  ///< without folders
    std::string bytes;
    std::shared_ptr<const io::Model> model;
};

/// A copy of the points of a model.
std::vector<Point3> pointsOf(const ModelFile& file);

/// A model of points alone, as a file that says so: points.obj.
ModelFile modelOfPoints(std::span<const Point3> points);

/// \param name whose extension is that of the format
ModelFile modelOfBytes(std::string name, std::string bytes);

}  // namespace espalier::python
