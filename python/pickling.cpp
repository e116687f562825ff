// SPDX-License-Identifier: Apache-2.0
#include "pickling.h"

#include <espalier/far/cell_complex.h>
#include <espalier/far/marks.h>
#include <espalier/io/binding_file.h>
#include <pybind11/stl.h>

#include <algorithm>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "arguments.h"

namespace espalier::python {
namespace {

[[noreturn]] void refuseState() {
    throw Error("the pickled state was not made by this version of Espalier");
}

void requireState(bool isAsExpected) {
    if (!isAsExpected) refuseState();
}

std::string nameIn(const py::handle& object) {
    requireState(py::isinstance<py::str>(object));
    return nameOfStr(py::reinterpret_borrow<py::str>(object));
}

/// Returns the numbers of an array of any shape. Container is a vector or an Array.
template <class Container>
Container numbersOf(const py::handle& object) {
    using Number = typename Container::value_type;
    const auto array = py::array_t<Number, kReadable>::ensure(object);
    requireState(static_cast<bool>(array));
    return Container(array.data(), array.data() + array.size());
}

/// Returns the offsets of rows; or the length of a row, if all rows have the same length.
py::object lengthsOf(const far::Incidence& rows) {
    const Index count = rows.rowCount();
    std::vector<Offset> offsets{0};
    bool areAlike = count > 0 && rows.offset(1) > 0;
    for (Index row = 0; row < count; ++row) {
        offsets.push_back(rows.offset(row + 1));
        areAlike = areAlike && offsets.back() == rows.offset(1) * (row + 1);
    }
    if (areAlike) return py::int_(rows.offset(1));
    return toArray(std::move(offsets));
}

far::Incidence rowsOf(const py::handle& lengths, Array<Index> values) {
    const auto size = static_cast<Offset>(values.size());
    if (py::isinstance<py::int_>(lengths)) {
        const auto length = lengths.cast<Index>();
        requireState(length > 0 && size % length == 0 && std::in_range<Index>(size / length));
        return far::Incidence::uniform(length, std::move(values));
    }
    auto offsets = numbersOf<Array<Offset>>(lengths);
    requireState(!offsets.empty() && std::in_range<Index>(offsets.size() - 1) &&
                 offsets.front() == 0 && offsets.back() == size &&
                 std::is_sorted(offsets.begin(), offsets.end()));
    return far::Incidence({std::move(offsets), std::move(values)});
}

py::list boundariesOf(const far::CellComplex& complex, const py::object& owner) {
    py::list boundaries;
    for (int dimension = 1; dimension <= complex.dimension(); ++dimension) {
        const far::SignedIncidence& boundary = complex.boundary(dimension);
        boundaries.append(py::make_tuple(lengthsOf(boundary.unsignedRows()),
                                         viewOf(boundary.unsignedRows().values(), owner),
                                         viewOf(boundary.signs(), owner)));
    }
    return boundaries;
}

far::CellComplex complexOf(Index vertexCount, const py::sequence& boundaries) {
    far::CellComplex::Boundaries all;
    requireState(boundaries.size() <= all.size());
    for (std::size_t i = 0; i < boundaries.size(); ++i) {
        const py::tuple parts = boundaries[i];
        requireState(parts.size() == 3);
        auto rows = rowsOf(parts[0], numbersOf<Array<Index>>(parts[1]));
        auto signs = numbersOf<Array<std::int8_t>>(parts[2]);
        requireState(signs.size() == rows.values().size());
        for (const std::int8_t sign : signs) requireState(sign == 1 || sign == -1);
        all[i] = far::SignedIncidence(std::move(rows), std::move(signs));
    }
    const auto dimension = static_cast<int>(boundaries.size());
    return withoutGil([&] {
        far::CellComplex complex(dimension, vertexCount, std::move(all));
        far::validate(complex);
        return complex;
    });
}

py::tuple stateOfMarks(const far::Marks& marks) {
    std::vector<Index> ends, vertices;
    std::vector<double> ofEdges, ofVertices;
    for (const auto& mark : marks.edges) {
        ends.insert(ends.end(), mark.vertices.begin(), mark.vertices.end());
        ofEdges.push_back(mark.sharpness);
    }
    for (const auto& mark : marks.vertices) {
        vertices.push_back(mark.vertex);
        ofVertices.push_back(mark.sharpness);
    }
    return py::make_tuple(toArray(std::move(ends)), toArray(std::move(ofEdges)),
                          toArray(std::move(vertices)), toArray(std::move(ofVertices)),
                          toArray(std::vector<Index>(marks.holes)));
}

far::Marks marksOfState(const far::CellComplex& complex, const py::tuple& state) {
    requireState(state.size() == 5);
    const auto ends = numbersOf<std::vector<Index>>(state[0]);
    const auto ofEdges = numbersOf<std::vector<double>>(state[1]);
    const auto vertices = numbersOf<std::vector<Index>>(state[2]);
    const auto ofVertices = numbersOf<std::vector<double>>(state[3]);
    requireState(ends.size() == 2 * ofEdges.size() && vertices.size() == ofVertices.size());
    far::Marks marks;
    for (std::size_t i = 0; i < ofEdges.size(); ++i)
        marks.edges.push_back({{ends[2 * i], ends[2 * i + 1]}, ofEdges[i]});
    for (std::size_t i = 0; i < ofVertices.size(); ++i)
        marks.vertices.push_back({vertices[i], ofVertices[i]});
    marks.holes = numbersOf<std::vector<Index>>(state[4]);
    withoutGil([&] {
        far::readMarks(complex, marks);
        if (!marks.holes.empty()) far::readHoles(complex, marks);
    });
    return marks;
}

}  // namespace

py::tuple stateOfLattice(const py::object& self) {
    const auto& lattice = self.cast<const Lattice&>();
    py::list attributes;
    for (const VertexAttribute& attribute : lattice.attributes)
        attributes.append(py::make_tuple(strOfName(attribute.name), attribute.components,
                                         viewOf(std::span<const double>(attribute.values), self)));
    py::list integers;
    for (const VertexIntegers& each : lattice.integers)
        integers.append(py::make_tuple(strOfName(each.name), each.components,
                                       static_cast<int>(each.type),
                                       viewOf(std::span<const std::int64_t>(each.values), self)));
    const RefinementTags& tags = lattice.tags;
    const FaceVaryingAttribute& textures = lattice.textureCoordinates;
    return py::make_tuple(viewOf(lattice.positions, self), boundariesOf(lattice.complex, self),
                          stateOfMarks(lattice.marks), attributes,
                          py::make_tuple(wordOf(far::kBoundaryWords, tags.boundary),
                                         wordOf(far::kCreasingWords, tags.creasing),
                                         wordOf(far::kTriangleSubdivisionWords, tags.triangles),
                                         wordOf(far::kFaceVaryingLinearWords, tags.faceVarying)),
                          integers, viewOf(std::span<const double>(textures.values), self),
                          viewOf(std::span<const Index>(textures.corners), self));
}

std::shared_ptr<Lattice> latticeOfState(const py::tuple& state) {
    requireState(state.size() == 8);
    Lattice lattice;
    lattice.positions = toPoints(state[0], "positions");
    const std::size_t count = lattice.positions.size();
    requireState(std::in_range<Index>(count));
    lattice.complex = complexOf(static_cast<Index>(count), state[1]);
    lattice.marks = marksOfState(lattice.complex, state[2]);
    const auto partsOf = [](const py::handle& object, std::size_t size) {
        requireState(py::isinstance<py::tuple>(object) && py::len(object) == size);
        return py::reinterpret_borrow<py::tuple>(object);
    };
    // \param list the attributes, or the integers
    const auto add = [&](auto& list, auto each) {
        requireState(each.components > 0 && each.values.size() == count * each.components);
        list.push_back(std::move(each));
    };
    for (const py::handle each : py::list(state[3])) {
        const auto parts = partsOf(each, 3);
        add(lattice.attributes, VertexAttribute{nameIn(parts[0]), parts[1].cast<int>(),
                                                numbersOf<std::vector<double>>(parts[2])});
    }
    using Word = std::optional<std::string>;
    const py::tuple tags = state[4];
    requireState(tags.size() == 4);
    lattice.tags = {chosen(far::kBoundaryWords, "state", tags[0].cast<Word>()),
                    chosen(far::kCreasingWords, "state", tags[1].cast<Word>()),
                    chosen(far::kTriangleSubdivisionWords, "state", tags[2].cast<Word>()),
                    chosen(far::kFaceVaryingLinearWords, "state", tags[3].cast<Word>())};
    for (const py::handle each : py::list(state[5])) {
        const auto parts = partsOf(each, 4);
        const int type = parts[2].cast<int>();
        requireState(type >= static_cast<int>(IntegerType::Int8) &&
                     type <= static_cast<int>(IntegerType::UInt64));
        add(lattice.integers,
            VertexIntegers{nameIn(parts[0]), parts[1].cast<int>(), static_cast<IntegerType>(type),
                           numbersOf<std::vector<std::int64_t>>(parts[3])});
    }
    FaceVaryingAttribute& textures = lattice.textureCoordinates;
    textures.values = numbersOf<std::vector<double>>(state[6]);
    textures.corners = numbersOf<std::vector<Index>>(state[7]);
    const auto isTexture = [&](Index corner) {
        return corner >= 0 && corner < std::ssize(textures.values) / 2;
    };
    requireState(textures.values.size() % 2 == 0 &&
                 std::ranges::all_of(textures.corners, isTexture) &&
                 (textures.corners.empty() ||
                  (lattice.complex.dimension() == 2 &&
                   textures.corners.size() == lattice.complex.relation(2, 0).values().size())));
    return std::make_shared<Lattice>(std::move(lattice));
}

py::tuple stateOfTable(const py::object& self) {
    const auto& table = self.cast<const Table&>();
    return py::make_tuple(table.columnCount(), viewOf(table.offsets(), self),
                          viewOf(table.columns(), self), viewOf(table.weights(), self));
}

std::shared_ptr<Table> tableOfState(const py::tuple& state) {
    requireState(state.size() == 4);
    const auto columnCount = state[0].cast<Index>();
    auto offsets = numbersOf<Array<Offset>>(state[1]);
    auto columns = numbersOf<Array<Index>>(state[2]);
    auto weights = numbersOf<Array<double>>(state[3]);
    return sharedWithoutGil([&] {
        return Table(columnCount, std::move(offsets), std::move(columns), std::move(weights));
    });
}

py::tuple stateOfBinding(const py::object& self) {
    const auto& bound = self.cast<const BoundPoints&>().bound;
    return py::make_tuple(py::bytes(withoutGil([&] { return io::boundModelBytes(bound); })));
}

std::shared_ptr<BoundPoints> bindingOfState(const py::tuple& state) {
    requireState(state.size() == 1);
    const auto bytes = state[0].cast<std::string_view>();
    auto result = std::make_shared<BoundPoints>();
    result->bound = withoutGil([&] { return io::readBoundModel("the state of a Binding", bytes); });
    return result;
}

}  // namespace espalier::python
