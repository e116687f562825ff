// SPDX-License-Identifier: Apache-2.0
#include "work.h"

#include <espalier/base/progress.h>

namespace espalier::cages {

void Work::add(double steps) {
    checkCancelled();
    if (done_ + steps > limit_) throw WorkError("the bound on the work is reached");
    done_ += steps;
}

}  // namespace espalier::cages
