// SPDX-License-Identifier: Apache-2.0
#include "binding.h"

#include <espalier/base/error.h>
#include <espalier/bind/bind.h>
#include <espalier/far/topology_match.h>
#include <espalier/io/files/file.h>
#include <espalier/io/model_part.h>
#include <espalier/io/pose_file.h>
#include <espalier/osd/binding_evaluator.h>
#include <pybind11/stl.h>
#include <pybind11/stl/filesystem.h>

#include <filesystem>
#include <string>
#include <utility>

#include "evaluation.h"
#include "module.h"
#include "pickling.h"
#include "refiner.h"

namespace espalier::python {

using namespace py::literals;

namespace {

using BoundPointer = std::shared_ptr<BoundPoints>;

std::vector<double> toWeights(const ArrayLike& object, std::size_t count) {
    const auto array = realArray<double>(object, "weights");
    if (array.ndim() != 1 || array.shape(0) != static_cast<py::ssize_t>(count))
        throw Error(concat("weights: expected an array of shape (", count, ",)"));
    return {array.data(), array.data() + count};
}

/// Returns the weights of a part of a model.
/// \param weights None, a name or an array
bind::PointWeights weightsOf(const ModelFile& file, const py::object& weights,
                             const std::vector<std::string>& only,
                             const std::vector<std::string>& hold, bool needSlopes) {
    io::ModelPart part{.groups = only, .holds = hold};
    if (py::isinstance<py::str>(weights))
        part.weights = weights.cast<std::string>();
    else if (!weights.is_none())
        part.factors = toWeights(weights, file.model->positions().size());
    auto result =
        withoutGil([&] { return io::weightsOf(file.name, *file.model, part, needSlopes); });
    if (needSlopes) warn(io::noteOnSlopes(file.name, *file.model, result));
    return result;
}

BoundPointer bind(const RefinerLike& lattice, const ArrayLike& points, int level,
                  const std::string& outside, double tolerance, const std::string& basis,
                  bool limit, std::optional<bool> gradients, const py::object& weights,
                  const std::vector<std::string>& only, double falloff,
                  const std::vector<std::string>& hold) {
    const auto refiner = refinerOf(lattice);
    const embed::EmbeddingOptions options{chosen(embed::kOutsidePolicyWords, "outside", outside),
                                          tolerance};
    const auto functions = chosen(embed::kBasisWords, "basis", basis);
    if (limit && functions)
        throw Error("limit: expected False with the basis \"" + basis +
                    "\", which has no levels and no limit");
    auto result = std::make_shared<BoundPoints>();
    std::vector<Point3> atRest;
    bool hasDirections = false;
    bind::PointWeights pointWeights;
    if (py::isinstance<ModelFile>(points)) {
        const auto& file = points.cast<const ModelFile&>();
        hasDirections = file.model->hasDirections();
        atRest = pointsOf(file);
        result->bound.modelName = file.name;
        result->bound.modelBytes = file.bytes;
        pointWeights = weightsOf(file, weights, only, hold, gradients.value_or(hasDirections));
    } else {
        atRest = toPoints(points, "points");
        if (py::isinstance<py::str>(weights) || !only.empty() || !hold.empty())
            throw Error(
                "weights, only, hold: names need a Model; for points give an array of weights");
        if (!weights.is_none()) pointWeights.values = toWeights(weights, atRest.size());
    }
    bind::Target target = bind::Level{level};
    if (functions) target = *functions;
    if (limit) target = bind::Limit{tolerance};
    withoutGil([&] {
        const Lattice& rest = *refiner->lattice();
        result->bound.binding = bind::bindPoints({refiner->base(), rest.positions}, atRest, target,
                                                 {.embedding = options,
                                                  .gradients = gradients.value_or(hasDirections),
                                                  .weights = std::move(pointWeights),
                                                  .falloff = falloff});
        result->bound.faces = io::facesOf(rest.complex);
    });
    return result;
}

BoundPointer load(const std::filesystem::path& path) {
    auto result = std::make_shared<BoundPoints>();
    result->bound = io::readBoundModel(path);
    return result;
}

/// Evaluates D or its adjoint: in float for an array of float32, otherwise in double.
/// \tparam Form osd::Deformer or osd::CompiledAdjoint
/// \param make makes the form; called with a number of its precision
/// \param run called with the form, the source and the result: of all sets if `runTakesAllSets`,
///        otherwise of each set
template <template <class> class Form, class Make, class Run>
py::array evaluateForm(BoundPoints& self, const char* name, Index from, Index to,
                       const ArrayLike& values, const std::optional<ArrayLike>& out, Make make,
                       Run run, bool runTakesAllSets) {
    const auto inPrecision = [&]<class Real>(Real number) {
        const auto runForm = [&](std::span<const Real> source, const osd::BufferDescriptor&,
                                 std::span<Real> result) {
            run(std::get<Lazy<Form<Real>>>(self.forms).get([&] { return make(number); }), source,
                result);
        };
        return evaluate<Real>({name, from, to, 3, runForm, runTakesAllSets}, values, out);
    };
    const bool isSingle = py::isinstance<py::array>(values) &&
                          isFloat32(py::reinterpret_borrow<py::array>(values).dtype());
    return isSingle ? inPrecision(float{}) : inPrecision(double{});
}

/// Returns the positions of a pose. If it is a Lattice, it must have the topology of the bound one.
ArrayLike positionsOf(const BoundPoints& self, const ArrayLike& pose) {
    if (!py::isinstance<Lattice>(pose)) return pose;
    const auto& lattice = pose.cast<const Lattice&>();
    const auto hash = withoutGil([&] { return far::topologyHash(lattice.complex); });
    if (hash != self.binding().topologyHash)
        throw Error("pose: its topology differs from the lattice that the points are bound to");
    return viewOf(lattice.positions, pose);
}

py::array gradientsAt(const BoundPoints& self, const ArrayLike& pose) {
    const auto positions =
        toPoints(positionsOf(self, pose), "pose", self.binding().table.columnCount());
    const auto gradients =
        withoutGil([&] { return osd::evaluateGradients(self.binding(), positions); });
    py::array_t<double> result(
        {static_cast<py::ssize_t>(gradients.size()), py::ssize_t{3}, py::ssize_t{3}});
    std::memcpy(result.mutable_data(), gradients.data(),
                gradients.size() * sizeof(DeformationGradient));
    return result;
}

py::array deform(BoundPoints& self, const ArrayLike& pose, const std::optional<ArrayLike>& out) {
    const bind::Binding& binding = self.binding();
    return evaluateForm<osd::Deformer>(
        self, "pose", binding.table.columnCount(), binding.table.rowCount(),
        positionsOf(self, pose), out,
        [&]<class Real>(Real) { return osd::Deformer<Real>(binding); },
        [](const auto& deformer, auto poses, auto points) { deformer.deform(poses, points); },
        true);
}

py::array adjoint(BoundPoints& self, const ArrayLike& gradients,
                  const std::optional<ArrayLike>& out) {
    const auto& table = self.binding().table;
    const auto run = [](const auto& compiled, auto source, auto result) {
        constexpr osd::BufferDescriptor kXyz{0, 3, 3};
        compiled.evaluate(source, kXyz, result, kXyz, {0, compiled.rowCount()});
    };
    return evaluateForm<osd::CompiledAdjoint>(
        self, "gradients", table.rowCount(), table.columnCount(), gradients, out,
        [&]<class Real>(Real) { return osd::compile<osd::CompiledAdjoint, Real>(table); }, run,
        false);
}

void addPoints(py::class_<BoundPoints, BoundPointer>& type) {
    type.def_property_readonly(
            "points",
            [](const py::object& self) {
                return viewOf(self.cast<const BoundPoints&>().binding().points, self);
            },
            "The positions of the points when they were bound: array (N, 3) of float64, read-only, "
            "not a copy.")
        .def_property_readonly(
            "kept",
            [](const BoundPoints& self) { return toArray(self.binding().table.emptyRows()); },
            "The points that stay where they are in every pose, since they are outside the "
            "lattice, could not be placed or have the weight 0; their rows of D are empty. New "
            "array (K,) of int32, "
            "ascending.")
        .def_property_readonly(
            "statuses",
            [](const py::object& self) {
                return viewOf(bytesOf(self.cast<const BoundPoints&>().binding().statuses), self);
            },
            "Whether each point is inside the lattice, outside, could not be placed, or has the "
            "weight 0: array (N,) of uint8, with the values of PointStatus.")
        .def_property_readonly(
            "largest_residual",
            [](const BoundPoints& self) { return self.binding().largestResidual; },
            "The largest distance of a point from its place in the lattice at rest, in the units "
            "of the lattice: float.");
}

}  // namespace

std::span<const std::uint8_t> bytesOf(const std::vector<embed::PointStatus>& statuses) {
    using embed::PointStatus;
    static_assert(sizeof(PointStatus) == sizeof(std::uint8_t) &&
                  static_cast<int>(PointStatus::Inside) == 0 &&
                  static_cast<int>(PointStatus::Outside) == 1 &&
                  static_cast<int>(PointStatus::NotConverged) == 2 &&
                  static_cast<int>(PointStatus::NotBound) == 3);
    return {reinterpret_cast<const std::uint8_t*>(statuses.data()), statuses.size()};
}

void addBinding(py::module_& module) {
    py::class_<BoundPoints, BoundPointer> type(module, "Binding", R"(
Points that are bound to a lattice. The sparse matrix D deforms them: x' = D @ p' for a pose p' of
the lattice. Made by bind() and load_binding(). Any number of threads may use it.
)");
    type.def_property_readonly(
            "shape",
            [](const BoundPoints& self) {
                const auto& table = self.binding().table;
                return std::pair(table.rowCount(), table.columnCount());
            },
            "Number of points, and number of lattice vertices: tuple of 2 int.")
        .def_property_readonly(
            "table", [](const Shared<BoundPoints>& self) { return tableIn(self); },
            "D as a StencilTable. A row sums to the weight of its point, usually 1; it is empty "
            "for a "
            "point in `kept`.")
        .def_property_readonly(
            "matrix", [](const Shared<BoundPoints>& self) { return csrOf(tableIn(self)); },
            "D as a scipy.sparse.csr_matrix (N, V) over the same memory: see StencilTable.csr(). "
            "Each access makes a new object.")
        .def("deform", &deform, "pose"_a, "out"_a = py::none(), R"(
Returns the positions of the points for a pose of the lattice: x + D @ (p' - p), where x and p are the
points and the lattice at rest. So points that no moved vertex influences, and points in `kept`, stay
exactly where they were.

pose : array (V, 3), or (P, V, 3) for P poses at once, or a Lattice; in the units of the points
out  : array (N, 3), or (P, N, 3), in C order, for the result; by default a new array
An array of float32 is evaluated in float32, with x and p rounded to float32; any other in float64.
P poses in one call and in P calls may differ by rounding.

The first call compiles D (see CompiledTable); the compiled form is kept for later calls. It adds the
products of a row in another order than `espalier deform`, `espalier apply` and
espalier_binding_apply() of C, which do not compile. So their results differ from these by rounding,
mostly by one unit in the last place.
)")
        .def("gradients", &gradientsAt, "pose"_a, R"(
Returns the deformation gradient F of each point for a pose of the lattice, F[n, i, j] = dx'_i / dX_j:
array (N, 3, 3). Model.write() turns normals, tangents and splats by it. A point in `kept` has the
identity.

pose : array (V, 3), or a Lattice; in the units of the points
Bind with gradients=True, or a Model that has normals, tangents or splats.
)")
        .def("adjoint", &adjoint, "gradients"_a, "out"_a = py::none(), R"(
Returns gradients with respect to the lattice vertices, given those with respect to the points:
D.T @ gradients.

gradients : array (N, 3), or (P, N, 3) for P arrays at once
out       : array (V, 3), or (P, V, 3), in C order, for the result; by default a new array
Precision, compiling and rounding are as in deform().
)")
        .def(
            "save",
            [](const BoundPoints& self, const std::filesystem::path& path) {
                withoutGil([&] { io::writeBoundModel(path, self.bound); });
            },
            "path"_a,
            "Writes the binding (.espb), for load_binding() and `espalier apply`. With gradients, "
            "apply also turns the normals, tangents and splats of a Model. Of points that did not "
            "come from a Model, apply makes a model points.obj.")
        .def("__repr__", [](const BoundPoints& self) {
            const auto& table = self.binding().table;
            return concat("<espalier.Binding: ", table.rowCount(), " points x ",
                          table.columnCount(), " vertices, ", table.emptyRows().size(),
                          " left in place>");
        });
    addPoints(type);
    addPickling(type, &stateOfBinding, &bindingOfState);
    module.def("bind", &bind, "lattice"_a, "points"_a, "level"_a = 3, py::kw_only(),
               "outside"_a = "keep", "tolerance"_a = 1e-6, "basis"_a = "subdivision",
               "limit"_a = false, "gradients"_a = py::none(), "weights"_a = py::none(),
               "only"_a = std::vector<std::string>(), "falloff"_a = 0.0,
               "hold"_a = std::vector<std::string>(), R"(
Binds points to a level of a lattice at rest, or to its limit. Returns a Binding.

lattice   : Lattice, or Refiner where the rules are not the usual ones
points    : array (N, 3), in the units of the lattice; or a Model
level     : the refinement level to bind to, 1 to 20
outside   : a point outside the lattice: "keep" leaves it where it is, "nearest" moves it with the
            nearest cell (it stays if the absolute values of its weights would sum to more than 8),
            "error" raises an error
tolerance : how far outside a point still counts as inside, as a fraction of the diagonal of the
            lattice's bounding box
basis     : "subdivision"; or, for a box lattice that is an evenly divided parallelepiped at rest,
            "bezier" or "bspline", which have no levels
limit     : whether to bind to the limit of refinement instead of a level. The tolerance, 1e-14 to
            0.1, is then also how close to the limit points are placed
gradients : whether to prepare Binding.gradients(), by which normals, tangents and splats turn: bool.
            Default: if `points` is a Model that has normals, tangents or splats
weights   : how far each point follows the lattice, 0 to 1: array (N,); or, for a Model, the name of one
            of its Model.attributes. Gradients use how the weights change along the faces of a Model.
            Default: all points follow fully
only      : names of Model.groups: the points in none of them stay. Default: no point stays
falloff   : above 0, points outside the lattice follow with the nearest cell, with a weight that falls
            smoothly from 1 at the lattice to 0 at this distance
hold      : names of Model.groups: the points in one of them stay, such as those of the patch of an inlet
)");
    module.def(
        "load_binding",
        [](const std::filesystem::path& path) { return withoutGil([&] { return load(path); }); },
        "path"_a, "Reads a Binding from .espb.");
}

}  // namespace espalier::python
