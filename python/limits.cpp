// SPDX-License-Identifier: Apache-2.0
#include <espalier/base/error.h>
#include <espalier/base/memory.h>
#include <espalier/base/parallel.h>

#include <cstdint>
#include <memory>
#include <utility>

#include "module.h"

namespace espalier::python {

namespace {

/// A limit of the library that holds during a `with` block.
template <class Limit, class Value>
class LimitBlock {
public:
    explicit LimitBlock(Value value) : value_(value) {}
    void enter() {
        if (limit_)
            throw Error("this limit is in use already: make a new one for a nested with block");
        limit_ = std::make_unique<Limit>(value_);
    }
    void leave() { limit_.reset(); }

private:
    Value value_;
    std::unique_ptr<Limit> limit_;
};

/// Adds the class of a limit.
/// \param parameter name of the parameter
/// \param least smallest value of the parameter
template <class Limit, class Value>
void addLimit(py::module_& module, const char* name, const char* parameter, std::int64_t least,
              const char* doc) {
    using Block = LimitBlock<Limit, Value>;
    py::class_<Block>(module, name, doc)
        .def(py::init([parameter, least](std::int64_t value) {
                 if (value < least || !std::in_range<Value>(value))
                     throw Error(concat(parameter, ": expected ", least, " or more, got ", value));
                 return Block(static_cast<Value>(value));
             }),
             py::arg(parameter))
        .def("__enter__",
             [](py::object self) {
                 self.cast<Block&>().enter();
                 return self;
             })
        .def("__exit__", [](Block& self, const py::args&) { self.leave(); });
}

}  // namespace

void addLimits(py::module_& module) {
    addLimit<ThreadLimit, int>(module, "ThreadLimit", "threads", 0, R"(
Limits the threads that Espalier uses, in a with block: `with espalier.ThreadLimit(2): ...`. Results do
not depend on their number, bit for bit.

threads : largest number of threads of the whole process; 0 is one for each core
)");
    addLimit<MemoryLimit, std::uint64_t>(module, "MemoryLimit", "bytes", 1, R"(
Limits the memory of the process, in a with block: `with espalier.MemoryLimit(4 * 10**9): ...`. Work
that would exceed the limit raises MemoryError: before it starts if the memory that it takes is known
then, otherwise soon after the limit is exceeded.

bytes : largest memory of the whole process, including Python and its arrays
)");
}

}  // namespace espalier::python
