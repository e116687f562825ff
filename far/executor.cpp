// SPDX-License-Identifier: Apache-2.0
#include <espalier/far/executor.h>
#include <espalier/far/loop_context.h>

#include <utility>

namespace espalier::far {

Executor::~Executor() = default;

void SerialExecutor::run(Offset count, FunctionRef<void(Offset)> task) {
    for (Offset i = 0; i < count; ++i) task(i);
}

ExecutorScope::ExecutorScope(Executor& executor)
    : outer_(std::exchange(loopContext().executor, &executor)) {}

ExecutorScope::~ExecutorScope() {
    loopContext().executor = outer_;
}

}  // namespace espalier::far
