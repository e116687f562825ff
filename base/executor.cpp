// SPDX-License-Identifier: Apache-2.0
#include <espalier/base/executor.h>
#include <espalier/base/loop_context.h>

#include <utility>

namespace espalier {

Executor::~Executor() = default;

void SerialExecutor::run(Offset count, FunctionRef<void(Offset)> task) {
    for (Offset i = 0; i < count; ++i) task(i);
}

ExecutorScope::ExecutorScope(Executor& executor)
    : outer_(std::exchange(loopContext().executor, &executor)) {}

ExecutorScope::~ExecutorScope() {
    loopContext().executor = outer_;
}

}  // namespace espalier
