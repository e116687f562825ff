// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <espalier/base/lazy.h>
#include <espalier/base/point.h>
#include <espalier/embed/point_location.h>
#include <espalier/io/binding_file.h>
#include <espalier/io/model.h>
#include <espalier/osd/compiled_adjoint.h>
#include <espalier/osd/compiled_table.h>

#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <tuple>
#include <vector>

#include "tables.h"

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

/// Points that are bound to a lattice; what io::BoundModel has, where they were, how binding went,
/// and the forms of D that were asked for.
struct BoundPoints {
    /// Without a name for the model where the points are those of an array, or of a model that is
    /// not there.
    io::BoundModel bound;
    std::optional<std::vector<Point3>> points = {};  ///< as far as they are known

    // A file tells neither of these.
    std::vector<embed::PointStatus> statuses = {};
    std::optional<double> largestResidual = {};

    std::tuple<Lazy<osd::CompiledTable<float>>, Lazy<osd::CompiledTable<double>>,
               Lazy<osd::CompiledAdjoint<float>>, Lazy<osd::CompiledAdjoint<double>>>
        forms = {};
};

/// How binding went, as NumPy has it: PointStatus in espalier/__init__.py.
std::span<const std::uint8_t> bytesOf(const std::vector<embed::PointStatus>& statuses);

/// The points of what was bound, where its model tells.
/// \throws Error if the model cannot be read, or has another number of points
std::optional<std::vector<Point3>> pointsIn(const io::BoundModel& bound);

/// D, which lives as long as the binding.
inline std::shared_ptr<Table> tableIn(const std::shared_ptr<BoundPoints>& bound) {
    return {bound, &bound->bound.binding.table};
}

}  // namespace espalier::python
