// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <memory>
#include <new>

namespace espalier::osd {

/// Memory that an evaluation takes besides what it is given, kept for the next one.
///
/// An evaluation with a workspace allocates only if no earlier one has needed as much; and takes no
/// lock, if it runs on the calling thread (SerialExecutor). So in real time:
///
///     const osd::CompiledTable<float> table(binding.table);
///     osd::Workspace workspace = table.workspace(3);
///     SerialExecutor serial;
///     …
///     const ExecutorScope scope(serial);  // for each pose
///     table.evaluate(pose, xyz, points, xyz, {0, table.rowCount()}, workspace);
///
/// For one evaluation at a time: threads that evaluate at once have one each.
class Workspace {
public:
    Workspace() = default;
    explicit Workspace(std::size_t bytes) { reserve(bytes); }

    /// What it held is lost if it has to grow.
    /// \return at least so many bytes, aligned to 64
    std::byte* reserve(std::size_t bytes) {
        if (bytes > byteCount_) {
            byteCount_ = 0;
            memory_.reset();
            memory_.reset(static_cast<std::byte*>(::operator new(bytes, kAlignment)));
            byteCount_ = bytes;
        }
        return memory_.get();
    }

    std::size_t byteCount() const { return byteCount_; }

private:
    static constexpr std::align_val_t kAlignment{64};
    struct Free {
        void operator()(std::byte* memory) const { ::operator delete(memory, kAlignment); }
    };

    std::unique_ptr<std::byte, Free> memory_;
    std::size_t byteCount_ = 0;
};

}  // namespace espalier::osd
