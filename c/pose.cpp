// SPDX-License-Identifier: Apache-2.0
#include <espalier/io/pose_file.h>
#include <espalier/shapes/cell_selection.h>
#include <espalier/shapes/held.h>
#include <espalier/shapes/limb.h>
#include <espalier/shapes/pose.h>
#include <espalier/shapes/selection.h>

#include <algorithm>
#include <cstdint>
#include <cstdlib>
#include <cstring>
#include <optional>
#include <span>
#include <vector>

#include "espalier_pose.h"
#include "handles.h"

using namespace espalier;

static_assert(static_cast<int>(shapes::Falloff::Profile::Smooth) == ESPALIER_FALLOFF_SMOOTH);

namespace espalier::c {
namespace {

shapes::Falloff falloffOf(const espalier_falloff* falloff) {
    if (falloff == nullptr) return {};
    return {choice(falloff->profile, shapes::Falloff::Profile::Smooth, "profile"), falloff->radius};
}

/// Writes the weights that select(positions, falloff) returns.
template <class Select>
espalier_status select(std::int32_t count, const double* given, const espalier_falloff* falloff,
                       double* weights, const Select& select) {
    return guarded([&] {
        const auto from = positions(given, count, "positions");
        const auto to = array(weights, count, "weights");
        const shapes::Falloff decrease = falloffOf(falloff);
        std::ranges::copy(select(from, decrease), to.begin());
    });
}

/// Writes the weights that select(complex, positions, falloff) returns.
template <class Select>
espalier_status selectAlong(const espalier_lattice* lattice, std::int32_t count,
                            const double* given, const espalier_falloff* falloff, double* weights,
                            const Select& select) {
    return guarded([&] {
        const auto& complex = deref(lattice, "lattice").lattice.complex;
        const auto from = positions(given, count, "positions");
        const auto to = array(weights, count, "weights");
        const shapes::Falloff decrease = falloffOf(falloff);
        std::ranges::copy(select(complex, from, decrease), to.begin());
    });
}

void put(const shapes::Section& from, espalier_section* to) {
    if (to == nullptr) return;
    to->area = from.area;
    std::ranges::copy(from.center, to->center);
}

/// Returns the vertices with a weight above 0.
std::vector<Index> selectedBy(const double* weights, std::int32_t count) {
    const auto given = array(weights, count, "weights");
    std::vector<Index> vertices;
    for (std::size_t v = 0; v < given.size(); ++v) {
        if (!(given[v] >= 0 && given[v] <= 1))
            throw Error(concat("weights[", v, "] is ", given[v], "; expected 0 to 1"));
        if (given[v] > 0) vertices.push_back(static_cast<Index>(v));
    }
    return vertices;
}

shapes::pose::Options optionsOf(std::int32_t count, const espalier_pose_options* options) {
    const auto chosen = optionsOrDefaults(options, espalier_default_pose_options(),
                                          "espalier_default_pose_options");
    shapes::pose::Options made;
    if (chosen.weights != nullptr) made.weights = array(chosen.weights, count, "weights");
    if (chosen.center != nullptr) made.center = point(chosen.center, "center");
    if (chosen.range != nullptr) made.range = {chosen.range[0], chosen.range[1]};
    return made;
}

void write(const std::vector<Point3>& points, std::span<double> to) {
    if (!points.empty()) std::memcpy(to.data(), points.data(), to.size_bytes());
}

/// Writes the positions that operate(positions, options) returns.
template <class Operate>
espalier_status operate(std::int32_t count, const double* given,
                        const espalier_pose_options* options, double* pose,
                        const Operate& operate) {
    return guarded([&] {
        const auto from = positions(given, count, "positions");
        const auto to = array(pose, count, "pose", 3);
        write(operate(from, optionsOf(count, options)), to);
    });
}

/// Writes the positions that read(path) returns.
template <class Read>
void readPose(const char* path, std::int32_t count, std::int64_t expected, double* pose,
              const Read& read) {
    checkCount(count, expected, "positions of vertices");
    const auto to = array(pose, count, "pose", 3);
    write(read(&deref(path, "path")), to);
}

}  // namespace
}  // namespace espalier::c

espalier_status espalier_select_box(int32_t vertex_count, const double* positions,
                                    const double corner[3], const double opposite[3],
                                    const espalier_falloff* falloff, double* weights) {
    return c::select(vertex_count, positions, falloff, weights,
                     [&](const auto& from, const auto& decrease) {
                         return shapes::selectBox(from, c::point(corner, "corner"),
                                                  c::point(opposite, "opposite"), decrease);
                     });
}

espalier_status espalier_select_ball(int32_t vertex_count, const double* positions,
                                     const double center[3], double radius,
                                     const espalier_falloff* falloff, double* weights) {
    return c::select(
        vertex_count, positions, falloff, weights, [&](const auto& from, const auto& decrease) {
            return shapes::selectBall(from, c::point(center, "center"), radius, decrease);
        });
}

espalier_status espalier_select_half_space(int32_t vertex_count, const double* positions,
                                           const double point[3], const double normal[3],
                                           const espalier_falloff* falloff, double* weights) {
    return c::select(vertex_count, positions, falloff, weights,
                     [&](const auto& from, const auto& decrease) {
                         return shapes::selectHalfSpace(from, c::point(point, "point"),
                                                        c::point(normal, "normal"), decrease);
                     });
}

espalier_status espalier_select_end(int32_t vertex_count, const double* positions,
                                    const double direction[3], const espalier_falloff* falloff,
                                    double* weights) {
    return c::select(vertex_count, positions, falloff, weights,
                     [&](const auto& from, const auto& decrease) {
                         return shapes::selectEnd(from, c::point(direction, "direction"), decrease);
                     });
}

espalier_status espalier_select_numbers(int32_t vertex_count, const double* positions,
                                        int64_t number_count, const int32_t* numbers,
                                        const espalier_falloff* falloff, double* weights) {
    return c::select(vertex_count, positions, falloff, weights,
                     [&](const auto& from, const auto& decrease) {
                         return shapes::selectNumbers(
                             from, c::array(numbers, number_count, "numbers"), decrease);
                     });
}

espalier_status espalier_select_limb(const espalier_lattice* lattice, int32_t vertex_count,
                                     const double* positions, const double point[3],
                                     const espalier_falloff* falloff, double* weights,
                                     espalier_section* section) {
    return c::selectAlong(
        lattice, vertex_count, positions, falloff, weights,
        [&](const auto& complex, const auto& from, const auto& decrease) {
            const auto limb = shapes::selectLimb(complex, from, c::point(point, "point"));
            auto result = shapes::selectAlongCells(complex, from, limb.vertices, decrease);
            c::put(limb.section, section);
            return result;
        });
}

espalier_status espalier_select_beyond(const espalier_lattice* lattice, int32_t vertex_count,
                                       const double* positions, int32_t face,
                                       const espalier_falloff* falloff, double* weights,
                                       espalier_section* section) {
    return c::selectAlong(lattice, vertex_count, positions, falloff, weights,
                          [&](const auto& complex, const auto& from, const auto& decrease) {
                              const auto part = shapes::selectBeyond(complex, from, face);
                              auto result =
                                  shapes::selectAlongCells(complex, from, part.vertices, decrease);
                              c::put(part.section, section);
                              return result;
                          });
}

espalier_status espalier_nearest_inner_face(const espalier_lattice* lattice, int32_t vertex_count,
                                            const double* positions, const double point[3],
                                            int32_t* face) {
    return c::result(face, "face", [&] {
        return shapes::nearestInnerFace(c::deref(lattice, "lattice").lattice.complex,
                                        c::positions(positions, vertex_count, "positions"),
                                        c::point(point, "point"));
    });
}

espalier_status espalier_select_near(const espalier_lattice* lattice, int32_t vertex_count,
                                     const double* positions, const double point[3], double radius,
                                     const espalier_falloff* falloff, double* weights) {
    return c::selectAlong(lattice, vertex_count, positions, falloff, weights,
                          [&](const auto& complex, const auto& from, const auto& decrease) {
                              return shapes::selectNear(complex, from, c::point(point, "point"),
                                                        radius, decrease);
                          });
}

espalier_status espalier_select_along_cells(const espalier_lattice* lattice, int32_t vertex_count,
                                            const double* positions, int64_t number_count,
                                            const int32_t* numbers, const espalier_falloff* falloff,
                                            double* weights) {
    return c::selectAlong(lattice, vertex_count, positions, falloff, weights,
                          [&](const auto& complex, const auto& from, const auto& decrease) {
                              return shapes::selectAlongCells(
                                  complex, from, c::array(numbers, number_count, "numbers"),
                                  decrease);
                          });
}

espalier_status espalier_selection_grow(const espalier_lattice* lattice, int32_t vertex_count,
                                        int32_t steps, double* weights) {
    return c::guarded([&] {
        const auto& complex = c::deref(lattice, "lattice").lattice.complex;
        c::checkCount(vertex_count, complex.count(0), "weights of vertices");
        const auto before = c::selectedBy(weights, vertex_count);
        // −steps overflows for the smallest number; as many steps as vertices reach all.
        const int count = std::min(std::abs(std::max(steps, -INT32_MAX)), vertex_count);
        const auto after = steps < 0 ? shapes::shrinkSelection(complex, before, count)
                                     : shapes::growSelection(complex, before, count);
        std::fill_n(weights, vertex_count, 0.0);
        for (const Index vertex : after) weights[vertex] = 1;
    });
}

espalier_status espalier_lattice_held_weights(const espalier_lattice* lattice, int32_t vertex_count,
                                              double* weights) {
    return c::guarded([&] {
        const auto& given = c::deref(lattice, "lattice").lattice;
        c::checkCount(vertex_count, given.complex.count(0), "weights of vertices");
        const auto out = c::array(weights, vertex_count, "weights");
        const auto changed = shapes::weightsWithHeld(given, out);
        std::ranges::copy(changed, out.begin());
    });
}

espalier_status espalier_selection_border(const espalier_lattice* lattice, int32_t vertex_count,
                                          const double* positions, const double* weights,
                                          espalier_section* section) {
    return c::guarded([&] {
        auto& out = c::deref(section, "section");
        const auto& complex = c::deref(lattice, "lattice").lattice.complex;
        const auto from = c::positions(positions, vertex_count, "positions");
        c::put(shapes::selectionBorder(complex, from, c::selectedBy(weights, vertex_count)), &out);
    });
}

espalier_status espalier_pose_move(int32_t vertex_count, const double* positions,
                                   const double offset[3], const espalier_pose_options* options,
                                   double* pose) {
    return c::operate(
        vertex_count, positions, options, pose, [&](const auto& from, const auto& chosen) {
            return shapes::pose::move(from, c::point(offset, "offset"), chosen.weights);
        });
}

espalier_status espalier_pose_rotate(int32_t vertex_count, const double* positions,
                                     const double axis[3], double angle,
                                     const espalier_pose_options* options, double* pose) {
    return c::operate(vertex_count, positions, options, pose,
                      [&](const auto& from, const auto& chosen) {
                          return shapes::pose::rotate(from, c::point(axis, "axis"), angle, chosen);
                      });
}

espalier_status espalier_pose_scale(int32_t vertex_count, const double* positions,
                                    const double factors[3], const espalier_pose_options* options,
                                    double* pose) {
    return c::operate(vertex_count, positions, options, pose,
                      [&](const auto& from, const auto& chosen) {
                          return shapes::pose::scale(from, c::point(factors, "factors"), chosen);
                      });
}

espalier_status espalier_pose_twist(int32_t vertex_count, const double* positions,
                                    const double axis[3], double angle,
                                    const espalier_pose_options* options, double* pose) {
    return c::operate(vertex_count, positions, options, pose,
                      [&](const auto& from, const auto& chosen) {
                          return shapes::pose::twist(from, c::point(axis, "axis"), angle, chosen);
                      });
}

espalier_status espalier_pose_bend(int32_t vertex_count, const double* positions,
                                   const double axis[3], double angle, const double toward[3],
                                   const espalier_pose_options* options, double* pose) {
    return c::operate(vertex_count, positions, options, pose,
                      [&](const auto& from, const auto& chosen) {
                          return shapes::pose::bend(from, c::point(axis, "axis"), angle,
                                                    c::point(toward, "toward"), chosen);
                      });
}

espalier_status espalier_pose_taper(int32_t vertex_count, const double* positions,
                                    const double axis[3], double factor,
                                    const espalier_pose_options* options, double* pose) {
    return c::operate(vertex_count, positions, options, pose,
                      [&](const auto& from, const auto& chosen) {
                          return shapes::pose::taper(from, c::point(axis, "axis"), factor, chosen);
                      });
}

espalier_status espalier_pose_mirror(int32_t vertex_count, const double* given, const double* rest,
                                     int32_t axis, const double* plane, const double* weights,
                                     double* pose, int32_t* without_image) {
    return c::guarded([&] {
        const auto from = c::positions(given, vertex_count, "positions");
        const auto atRest = c::positions(rest, vertex_count, "rest");
        const auto to = c::array(pose, vertex_count, "pose", 3);
        std::span<const double> chosen;
        if (weights != nullptr) chosen = c::array(weights, vertex_count, "weights");
        const auto result = shapes::pose::mirror(atRest, from, axis, chosen,
                                                 plane ? std::optional(*plane) : std::nullopt);
        c::write(result.positions, to);
        if (without_image != nullptr) *without_image = result.withoutImage;
    });
}

espalier_status espalier_lattice_write_editor_mesh(const espalier_lattice* lattice,
                                                   const char* path) {
    return c::guarded([&] {
        io::writeEditorMesh(&c::deref(path, "path"), c::deref(lattice, "lattice").lattice);
    });
}

espalier_status espalier_lattice_read_pose(const espalier_lattice* lattice, const char* path,
                                           int32_t vertex_count, double* pose) {
    return c::guarded([&] {
        const auto& own = c::deref(lattice, "lattice").lattice;
        c::readPose(path, vertex_count, std::ssize(own.positions), pose,
                    [&](const char* name) { return io::readPose(name, own); });
    });
}

espalier_status espalier_binding_read_pose(const espalier_binding* binding, const char* path,
                                           int32_t vertex_count, double* pose) {
    return c::guarded([&] {
        const io::BoundModel& own = *c::deref(binding, "binding").model;
        c::readPose(path, vertex_count, own.binding.table.columnCount(), pose,
                    [&](const char* name) { return io::readPose(name, own, "the binding"); });
    });
}
