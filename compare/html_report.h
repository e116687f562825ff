// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <espalier/base/api.h>
#include <espalier/compare/agreement.h>

#include <string>
#include <vector>

namespace espalier::compare {

struct ReportedShape {
    std::string name = {};
    Agreement agreement = {};
    std::string failure = {};  ///< why it could not be compared; empty if it was
};

struct Report {
    std::string title = {};
    std::string command = {};  ///< that the report was made by
    Bounds bounds = {};
    std::string openSubdivVersion = {};
    std::vector<ReportedShape> shapes = {};
};

/// A page (HTML 5, and well-formed XML) that needs nothing from outside and no scripts: the
/// verdict; the largest differences beside their bounds; a table of all shapes and levels; and a
/// picture of the errors over each shape that has one, that is, whose `picture` has faces.
///
/// It depends on the report alone, and holds no date: the same report gives the same bytes. A shape
/// that has neither a failure nor levels counts as one that could not be compared.
///
/// \throws Error as errorPicture() does
/// \cost   O(size of the page): 60 to 70 bytes a face of a picture, 1 kB a level
ESPALIER_API std::string htmlReport(const Report& report);

}  // namespace espalier::compare
