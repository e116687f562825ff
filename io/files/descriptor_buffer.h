// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <ios>
#include <streambuf>
#include <vector>

namespace espalier::io {

/// What a stream needs to write to a file that is open. Other than std::filebuf it says why it
/// failed, and a pipe that nobody reads or a limit on the size of files does not end the program.
class DescriptorBuffer final : public std::streambuf {
public:
    /// \param descriptor stays open longer than this
    explicit DescriptorBuffer(int descriptor);

    /// The error of the first write that failed; 0 if none has. After it nothing more is written.
    int error() const { return error_; }

protected:
    int_type overflow(int_type character) override;
    std::streamsize xsputn(const char* from, std::streamsize count) override;
    int sync() override;

private:
    bool write(const char* from, std::size_t count);

    int descriptor_;
    int error_ = 0;
    std::vector<char> buffer_;
};

}  // namespace espalier::io
