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

/// The check of a level, or of the limit, for poses of the base.
class PoseCheck {
public:
    /// \param limit whether to check the limit of the base's cells; features are refined to `level`
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
    int level_;  ///< of the cells
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
    py::class_<solve::PoseValidity>(
        module, "PoseValidity",
        "What a pose does to the cells of a level, or of a limit: see check().")
        .def_property_readonly(
            "ratios", &ratiosOf,
            "By what factor each cell's volume changes, the least over the "
            "cell: array (C,) of float64; nan for cells that are bad at rest, or "
            "shrink away in the limit.")
        .def_property_readonly(
            "inverted", [](const solve::PoseValidity& self) { return toArray(self.inverted); },
            "The cells that the pose turns inside out, ascending: array of int32.")
        .def_property_readonly(
            "smallest",
            [](const solve::PoseValidity& self) -> std::optional<std::pair<Index, double>> {
                if (!self.smallest) return std::nullopt;
                return std::pair(self.smallest->cell, self.smallest->value);
            },
            "The cell of the least ratio, and the ratio: tuple of int and float; None if all cells "
            "are bad at rest, or shrink away.");
    py::class_<solve::LargestStep>(module, "LargestStep",
                                   "How far a lattice can go towards a pose.")
        .def_readonly("length", &solve::LargestStep::length,
                      "Up to here no cell is inverted, as a part of the way from rest to pose: "
                      "float.")
        .def_readonly("limiting_cell", &solve::LargestStep::limitingCell,
                      "A cell of the level that could not be proved valid further on: int; None "
                      "where the length is the most.")
        .def_readonly("is_tight", &solve::LargestStep::isTight,
                      "Whether that cell is sure to go bad right after: bool.");
}

}  // namespace

void addValidity(py::module_& module) {
    addResults(module);
    py::class_<PoseCheck>(module, "ValidityCheck", R"(
Tells where poses of a lattice turn cells of a level inside out. Cells are numbered as in
refine(lattice, level). In the limit they are those of the lattice itself.

lattice : Lattice at rest, or Refiner
level   : 1 or more; in the limit, how far irregular features are refined, 1 to 15
limit   : whether to check the limit volume of the lattice's cells instead
)")
        .def(py::init(&makeCheck), "lattice"_a, "level"_a = 3, "limit"_a = false)
        .def_property_readonly(
            "bad_at_rest", [](const PoseCheck& self) { return toArray(self.badAtRest()); },
            "The cells that are flat or folded at rest, ascending: array of int32.")
        .def("check", &checkPose, "pose"_a,
             "What a pose, array (V, 3) of the base vertices, does: PoseValidity.")
        .def(
            "largest_step",
            [](const PoseCheck& self, const ArrayLike& pose, double most) {
                const auto points = self.toPose(pose);
                return withoutGil([&] { return self.largestStep(points, most); });
            },
            "pose"_a, "most"_a = 1.0, R"(
How far the lattice can go from rest towards a pose before a cell folds: LargestStep.

pose : array (V, 3); most : how far to look, 1 is the whole way, up to 1e6
)")
        .def("base_cell", &PoseCheck::baseCell, "cell"_a,
             "The cell of the base that a cell of the level descends from: int.");
    module.def(
        "check",
        [](const RefinerLike& lattice, const ArrayLike& pose, int level, bool limit) {
            return checkPose(*makeCheck(lattice, level, limit), pose);
        },
        "lattice"_a, "pose"_a, "level"_a = 3, "limit"_a = false, R"(
What a pose does to the cells of a level of a lattice: PoseValidity. For many poses: ValidityCheck.

lattice : Lattice at rest, or Refiner
pose    : array (V, 3)
level   : 1 or more
limit   : as of ValidityCheck
)");
}

}  // namespace espalier::python
