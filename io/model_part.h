// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <espalier/base/api.h>
#include <espalier/bind/point_weights.h>
#include <espalier/far/simulation_mesh.h>
#include <espalier/io/model.h>

#include <filesystem>
#include <string>
#include <vector>

namespace espalier::io {

/// The part of a model that follows a lattice.
struct ModelPart {
    /// The name of a PointAttribute of 0 to 1, by which the displacement of each point is
    /// multiplied; or empty.
    std::string weights = {};

    /// Names of groups (Model::groups()): the points in none of them stay. Or none, and the
    /// part is the whole model.
    std::vector<std::string> groups = {};

    /// Further weights, one per point, by which those of the attribute are multiplied; or none.
    std::vector<double> factors = {};

    /// Names of groups: the points in one of them stay, also if they are in one of `groups`.
    std::vector<std::string> holds = {};

    bool isWhole() const {
        return weights.empty() && groups.empty() && holds.empty() && factors.empty();
    }
};

/// Returns the names of attributes or groups.
template <class Items>
std::vector<std::string> namesOf(const Items& items) {
    std::vector<std::string> names;
    for (const auto& item : items) names.push_back(item.name);
    return names;
}

/// Reads an attribute of a model.
/// \param path for messages
/// \throws FileError if the model has no attribute of this name (the message lists its names)
ESPALIER_API std::vector<double> numbersOf(const std::filesystem::path& path, const Model& model,
                                           const std::string& name);

/// Returns a group as a patch, with its faces or lines: a patch of a mesh as readCells() gives it;
/// of another group the faces all of whose corners are in the group.
/// \param path for messages
/// \throws FileError if the model has no group of this name (the message lists its names)
ESPALIER_API far::MeshPatch patchOf(const std::filesystem::path& path, const Model& model,
                                    const std::string& name);

/// Returns the points that a part holds, ascending.
/// \throws FileError as weightsOf()
ESPALIER_API std::vector<Index> heldPointsOf(const std::filesystem::path& path, const Model& model,
                                             const ModelPart& part);

/// Returns the weights of the points of a part for bind::BindOptions: the attribute, and 0 for the
/// points in no group of the part, and for the points that it holds. Nothing if the part is the
/// whole model.
///
/// \param needSlopes makes the slopes, too, which normals need (withSlopes())
/// \throws FileError if the model has no attribute or group of a name (the message lists its
///         names), or a weight is below 0 or above 1 (the message names the first such point); as
///         readSurface()
/// \cost some passes over the file
ESPALIER_API bind::PointWeights weightsOf(const std::filesystem::path& path, const Model& model,
                                          const ModelPart& part, bool needSlopes);

/// Returns a note for the user if directions of a model turn without the slopes of their weights,
/// since the model has no faces; otherwise nothing.
/// \param path for the note
/// \param weights with slopes, if the model has faces (weightsOf() with needSlopes)
ESPALIER_API std::string noteOnSlopes(const std::filesystem::path& path, const Model& model,
                                      const bind::PointWeights& weights);

/// Returns weights with their slopes along the faces of the model; without, if it has no faces.
/// \param values one weight per point
/// \throws Error unless there is one for each point; FileError as readSurface()
ESPALIER_API bind::PointWeights withSlopes(const Model& model, std::vector<double> values);

}  // namespace espalier::io
