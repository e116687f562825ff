// SPDX-License-Identifier: Apache-2.0
#include <espalier/solve/validity.h>
#include <espalier/stencils/composition.h>

#include <pybind11/stl.h>

#include <limits>
#include <memory>
#include <optional>
#include <utility>
#include <vector>

#include "arguments.h"
#include "refiner.h"

namespace espalier::python {

using namespace py::literals;

namespace {

/// Checks poses of a lattice at one of its levels, or in the limit.
class PoseCheck {
public:
    /// \param limit whether to check the limits of the lattice's cells; irregular places are then
    ///        refined to `level`
    PoseCheck(std::shared_ptr<const Refiner> refiner, int level, bool limit)
        : refiner_(std::move(refiner)),
          level_(limit ? 0 : level),
          levels_(refiner_->upTo(level_)),
          check_(limit ? solve::ValidityCheck(limit::LimitParts(*levels_, level),
                                              refiner_->lattice()->positions)
                       : solve::ValidityCheck(levels_->level(level_).complex,
                                              refined(refiner_->lattice()->positions))) {}

    const std::vector<Index>& badAtRest() const { return check_.badAtRest(); }

    solve::PoseValidity check(std::span<const Point3> pose) const {
        return check_.check(refined(pose));
    }
    solve::LargestStep largestStep(std::span<const Point3> pose, double most) const {
        return check_.largestStep(refined(pose), most);
    }
    Index baseCell(Index cell) const {
        const Index count = levels_->level(level_).complex.count(3);
        if (cell < 0 || cell >= count)
            throw Error(concat("cell: expected 0 to ", count - 1, ", got ", cell));
        return solve::baseCellOf(*levels_, level_, cell);
    }
    std::vector<Point3> toPose(const ArrayLike& pose) const {
        return toPoints(pose, "pose", refiner_->lattice()->positions.size());
    }

private:
    std::vector<Point3> refined(std::span<const Point3> positions) const {
        return stencils::refinePositions(*levels_, level_, positions);
    }

    std::shared_ptr<const Refiner> refiner_;
    int level_;  ///< level of the cells
    std::shared_ptr<const far::TopologyRefiner> levels_;
    solve::ValidityCheck check_;
};

std::unique_ptr<PoseCheck> makeCheck(const RefinerLike& lattice, int level, bool limit) {
    checkLevel(level);
    auto refiner = refinerOf(lattice);
    return withoutGil(
        [&] { return std::make_unique<PoseCheck>(std::move(refiner), level, limit); });
}

solve::PoseValidity checkPose(const PoseCheck& check, const ArrayLike& pose) {
    const auto points = check.toPose(pose);
    return withoutGil([&] { return check.check(points); });
}

py::array_t<double> ratiosOf(const solve::PoseValidity& validity) {
    std::vector<double> ratios;
    for (const auto& ratio : validity.ratios)
        ratios.push_back(ratio.value_or(std::numeric_limits<double>::quiet_NaN()));
    return toArray(std::move(ratios));
}

void addResults(py::module_& module) {
    py::class_<solve::PoseValidity>(module, "PoseValidity",
                                    "How a pose changes the volumes of cells: see check().")
        .def_property_readonly(
            "ratios", &ratiosOf,
            "For each cell the factor by which its volume changes, the smallest over the cell: "
            "array "
            "(C,) of float64; nan for cells that are flat or folded at rest, or that vanish in the "
            "limit.")
        .def_property_readonly(
            "inverted", [](const solve::PoseValidity& self) { return toArray(self.inverted); },
            "The cells that the pose turns inside out, ascending: array of int32.")
        .def_property_readonly(
            "smallest",
            [](const solve::PoseValidity& self) -> std::optional<std::pair<Index, double>> {
                if (!self.smallest) return std::nullopt;
                return std::pair(self.smallest->cell, self.smallest->value);
            },
            "The cell with the smallest ratio, and the ratio: tuple of int and float; None if no "
            "cell has a ratio.");
    py::class_<solve::LargestStep>(module, "LargestStep",
                                   "How far a lattice can move towards a pose before a cell folds.")
        .def_readonly("length", &solve::LargestStep::length,
                      "No cell is inverted up to this fraction of the way from rest to pose: "
                      "float.")
        .def_readonly("limiting_cell", &solve::LargestStep::limitingCell,
                      "A cell that could not be proved valid beyond the length: int; None if the "
                      "length is `most`.")
        .def_readonly("is_tight", &solve::LargestStep::isTight,
                      "Whether that cell certainly folds just beyond the length: bool.");
}

}  // namespace

void addValidity(py::module_& module) {
    addResults(module);
    py::class_<PoseCheck>(module, "ValidityCheck", R"(
Finds the cells of a level that poses of a lattice turn inside out. Cells are numbered as in
refine(lattice, level); with limit=True they are the cells of the lattice itself.

lattice : Lattice at rest, or Refiner
level   : 1 or more; with limit=True the level that irregular places are refined to, 1 to 15
limit   : whether to check the limits of the lattice's cells instead of the cells of a level
)")
        .def(py::init(&makeCheck), "lattice"_a, "level"_a = 3, "limit"_a = false)
        .def_property_readonly(
            "bad_at_rest", [](const PoseCheck& self) { return toArray(self.badAtRest()); },
            "The cells that are flat or folded at rest, ascending: array of int32.")
        .def("check", &checkPose, "pose"_a,
             "Checks a pose, array (V, 3) of the lattice vertices. Returns a PoseValidity.")
        .def(
            "largest_step",
            [](const PoseCheck& self, const ArrayLike& pose, double most) {
                const auto points = self.toPose(pose);
                return withoutGil([&] { return self.largestStep(points, most); });
            },
            "pose"_a, "most"_a = 1.0, R"(
Finds how far the lattice can move from rest towards a pose before a cell folds. Returns a
LargestStep.

pose : array (V, 3)
most : how far to look, up to 1e6; 1 is the whole way
)")
        .def("base_cell", &PoseCheck::baseCell, "cell"_a,
             "Returns the cell of the lattice that contains a cell of the level: int.");
    module.def(
        "check",
        [](const RefinerLike& lattice, const ArrayLike& pose, int level, bool limit) {
            return checkPose(*makeCheck(lattice, level, limit), pose);
        },
        "lattice"_a, "pose"_a, "level"_a = 3, "limit"_a = false, R"(
Finds the cells of a level that a pose of a lattice turns inside out. Returns a PoseValidity. For many
poses of one lattice use ValidityCheck.

lattice : Lattice at rest, or Refiner
pose    : array (V, 3)
level   : 1 or more
limit   : as for ValidityCheck
)");
}

}  // namespace espalier::python
