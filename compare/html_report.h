// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <espalier/base/api.h>
#include <espalier/compare/agreement.h>

#include <string>
#include <vector>

// Writes an HTML report of comparisons with OpenSubdiv.
namespace espalier::compare {

struct ReportedShape {
    std::string name = {};
    Agreement agreement = {};
    std::string failure = {};  ///< reason why the shape could not be compared; empty if it was
};

struct Report {
    std::string title = {};
    std::string command = {};  ///< the command that made the report
    Bounds bounds = {};
    std::string openSubdivVersion = {};
    std::vector<ReportedShape> shapes = {};
};

/// Returns a page (HTML 5, and well-formed XML) that needs no external resources and no scripts. It
/// has the verdict; the largest differences beside their bounds; a table of all shapes and levels;
/// and a picture of the errors over each shape whose `picture` has faces.
///
/// The page depends on the report only, and has no date: the same report gives the same bytes. If a
/// shape has neither a failure nor levels, the page says that it could not be compared.
///
/// \throws Error as errorPicture()
/// \cost   O(size of the page): 60 to 70 bytes per face of a picture, 1 kB per level
ESPALIER_API std::string htmlReport(const Report& report);

}  // namespace espalier::compare
