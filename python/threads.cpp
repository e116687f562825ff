// SPDX-License-Identifier: Apache-2.0
#include <espalier/far/error.h>
#include <espalier/far/parallel.h>

#include <memory>
#include <string>

#include "module.h"

namespace espalier::python {

using namespace py::literals;

namespace {

/// A far::ThreadLimit for the length of a `with` block.
class ThreadLimitBlock {
public:
    explicit ThreadLimitBlock(int threads) : threads_(threads) {
        if (threads < 0) throw Error("threads: expected 0 or more, got " + std::to_string(threads));
    }
    void enter() {
        if (limit_) throw Error("this ThreadLimit is in use already");
        limit_ = std::make_unique<far::ThreadLimit>(threads_);
    }
    void leave() { limit_.reset(); }

private:
    int threads_;
    std::unique_ptr<far::ThreadLimit> limit_;
};

}  // namespace

void addThreads(py::module_& module) {
    py::class_<ThreadLimitBlock>(module, "ThreadLimit", R"(
Limits the threads that Espalier uses, in a with block: `with espalier.ThreadLimit(2): ...`. Results do
not depend on their number, bit for bit.

threads : at most so many, of the whole process; 0 is one a core
)")
        .def(py::init<int>(), "threads"_a)
        .def("__enter__",
             [](py::object self) {
                 self.cast<ThreadLimitBlock&>().enter();
                 return self;
             })
        .def("__exit__", [](ThreadLimitBlock& self, const py::args&) { self.leave(); });
}

}  // namespace espalier::python
