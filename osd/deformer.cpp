// SPDX-License-Identifier: Apache-2.0
#include <espalier/base/error.h>
#include <espalier/base/lazy.h>
#include <espalier/base/parallel.h>
#include <espalier/osd/change_evaluator.h>
#include <espalier/osd/compiled_chain.h>
#include <espalier/osd/compiled_table.h>
#include <espalier/osd/deformer.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <memory>
#include <utility>
#include <variant>
#include <vector>

#include "kernels/scratch.h"

namespace espalier::osd {
namespace {

/// The number of poses that are evaluated together: their 12 components fill whole registers.
constexpr Offset kTogether = 4;

/// Poses are evaluated together if D takes more than this many numbers for each point. Reading D
/// once then saves more than it costs to part the results of the poses: in float, the table of an
/// irregular model (40 numbers) took 0.67 of the time, the table of a regular one (13) 1.17, and
/// factors (8) 1.0 (bench/apply_benchmark.cpp).
constexpr Offset kManyNumbers = 24;

template <class Real>
using Form = std::variant<CompiledTable<Real>, CompiledChain<Real>>;

/// Returns the form that needs fewer bytes, which takes less time as a rule.
template <class Real>
Form<Real> fasterForm(const bind::Binding& binding) {
    auto table = compile<CompiledTable, Real>(binding.table);
    if (!binding.factors) return table;
    auto chain = compile<CompiledChain, Real>(*binding.factors);
    if (chain.byteCount() < table.byteCount()) return chain;
    return table;
}

template <class Real>
std::vector<Real> coordinates(const std::vector<Point3>& positions) {
    std::vector<Real> numbers;
    numbers.reserve(3 * positions.size());
    for (const Point3& position : positions)
        for (const double coordinate : position) numbers.push_back(static_cast<Real>(coordinate));
    return numbers;
}

/// The temporary memory of a call.
template <class Real>
struct Memory {
    AlignedVector<Real> displacements, together;
    Workspace workspace;
};

/// Memory that calls leave for later calls, without a lock. Calls at the same time have their own;
/// a few of them stay.
template <class Real>
class MemoryPool {
public:
    ~MemoryPool() {
        for (auto& slot : slots_) delete slot.load();
    }

    std::unique_ptr<Memory<Real>> take() {
        for (auto& slot : slots_)
            if (Memory<Real>* const memory = slot.exchange(nullptr))
                return std::unique_ptr<Memory<Real>>(memory);
        return std::make_unique<Memory<Real>>();
    }

    void giveBack(std::unique_ptr<Memory<Real>> memory) {
        for (auto& slot : slots_) {
            Memory<Real>* none = nullptr;
            if (!slot.compare_exchange_strong(none, memory.get())) continue;
            [[maybe_unused]] const auto* const owned = memory.release();
            return;
        }
    }

private:
    std::array<std::atomic<Memory<Real>*>, 8> slots_ = {};
};

}  // namespace

template <class Real>
struct Deformer<Real>::Data {
    Form<Real> form;
    std::vector<Real> points, rest;
    Index pointCount, vertexCount;
    mutable MemoryPool<Real> pool = {};
    mutable Lazy<ChangeEvaluator<Real>> changes = {};

    explicit Data(const bind::Binding& binding)
        : form((binding.checkParts(), fasterForm<Real>(binding))),
          points(coordinates<Real>(binding.points)),
          rest(coordinates<Real>(binding.rest)),
          pointCount(static_cast<Index>(std::ssize(binding.points))),
          vertexCount(static_cast<Index>(std::ssize(binding.rest))) {}

    std::size_t formBytes() const {
        return std::visit([](const auto& own) { return own.byteCount(); }, form);
    }

    /// Returns the number of whole poses.
    Offset poseCount(Values<Real> poses, MutableValues<Real> results) const {
        const Offset ofPose = std::ssize(rest),
                     count = ofPose == 0 ? 0 : std::ssize(poses) / ofPose;
        if (count * ofPose != std::ssize(poses))
            throw Error(concat("each pose of ", vertexCount, " vertices has ", ofPose,
                               " numbers; got ", poses.size(), " numbers"));
        if (count * std::ssize(points) != std::ssize(results))
            throw Error(concat("the points of ", count, count == 1 ? " pose" : " poses", " are ",
                               count * std::ssize(points), " numbers; there is room for ",
                               results.size()));
        return count;
    }

    /// Writes p' − p of several poses side by side, and returns the layout.
    BufferDescriptor setDisplacements(Memory<Real>& memory, const Real* poses, Offset count) const {
        const BufferDescriptor layout{0, 3 * count, paddedLength(3 * count)};
        // The kernels read the padding after the components, so it must have values.
        memory.displacements.assign(vertexCount * layout.stride, 0);
        for (Offset v = 0; v < vertexCount; ++v)
            for (Offset pose = 0; pose < count; ++pose)
                for (Offset c = 0; c < 3; ++c)
                    memory.displacements[v * layout.stride + 3 * pose + c] =
                        poses[(pose * vertexCount + v) * 3 + c] - rest[3 * v + c];
        return layout;
    }

    Addend<Real> atRest() const { return Addend<Real>::packed(points, 3); }

    /// Deforms `count` poses, at most kTogether.
    void deform(const Real* poses, Offset count, Real* results, Memory<Real>& memory) const {
        const BufferDescriptor from = setDisplacements(memory, poses, count);
        const auto evaluate = [&](MutableValues<Real> to) {
            std::visit(
                [&](const auto& own) {
                    own.evaluate(memory.displacements, from, to,
                                 BufferDescriptor::packed(from.length), {0, pointCount},
                                 memory.workspace, atRest());
                },
                form);
        };
        if (count == 1) return evaluate({results, points.size()});
        memory.together.resize(points.size() * count);
        evaluate(memory.together);
        constexpr Offset kGrain = 1 << 13;
        parallelFor(pointCount, kGrain, [&](Offset first, Offset last) {
            for (Offset pose = 0; pose < count; ++pose) {
                Real* const to = results + pose * pointCount * 3;
                for (Offset i = first; i < last; ++i)
                    std::copy_n(&memory.together[i * from.length + 3 * pose], 3, to + 3 * i);
            }
        });
    }

    void deformChanged(const CompiledTable<Real>& table, const Real* pose,
                       std::span<const Index> changed, MutableValues<Real> results,
                       Memory<Real>& memory) const {
        const auto& evaluator = changes.get([&] { return ChangeEvaluator<Real>(table); });
        const BufferDescriptor from = setDisplacements(memory, pose, 1);
        evaluator.evaluateChanged(memory.displacements, from, results, BufferDescriptor::packed(3),
                                  changed, memory.workspace, atRest());
    }
};

template <class Real>
Deformer<Real>::Deformer(const bind::Binding& binding)
    : data_(std::make_shared<const Data>(binding)) {}

template <class Real>
Index Deformer<Real>::pointCount() const {
    return data_->pointCount;
}

template <class Real>
Index Deformer<Real>::vertexCount() const {
    return data_->vertexCount;
}

template <class Real>
std::size_t Deformer<Real>::byteCount() const {
    return data_->formBytes() + (data_->points.size() + data_->rest.size()) * sizeof(Real);
}

template <class Real>
void Deformer<Real>::deform(Values<Real> poses, MutableValues<Real> points) const {
    const Offset count = data_->poseCount(poses, points);
    const Offset numbers = static_cast<Offset>(data_->formBytes() / sizeof(Real));
    const Offset together = numbers > kManyNumbers * pointCount() ? kTogether : 1;
    auto memory = data_->pool.take();
    for (Offset pose = 0; pose < count; pose += together)
        data_->deform(poses.data() + pose * std::ssize(data_->rest),
                      std::min(together, count - pose),
                      points.data() + pose * std::ssize(data_->points), *memory);
    data_->pool.giveBack(std::move(memory));
}

template <class Real>
void Deformer<Real>::deformChanged(Values<Real> pose, std::span<const Index> changed,
                                   MutableValues<Real> points) const {
    if (const Offset count = data_->poseCount(pose, points); count != 1)
        throw Error(concat("a change is of one pose; got ", count));
    for (const Index vertex : changed)
        if (vertex < 0 || vertex >= vertexCount())
            throw Error(concat("vertex ", vertex, " is not in the lattice, which has ",
                               vertexCount(), " vertices"));
    auto memory = data_->pool.take();
    if (const auto* table = std::get_if<CompiledTable<Real>>(&data_->form))
        data_->deformChanged(*table, pose.data(), changed, points, *memory);
    else
        data_->deform(pose.data(), 1, points.data(), *memory);
    data_->pool.giveBack(std::move(memory));
}

template class Deformer<float>;
template class Deformer<double>;

}  // namespace espalier::osd
