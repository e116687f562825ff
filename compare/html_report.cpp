// SPDX-License-Identifier: Apache-2.0
#include <espalier/compare/html_report.h>

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <optional>

#include "error_picture.h"
#include "report_text.h"

namespace espalier::compare {
namespace {

/// Style of a report. It has no '<' and no '&', so that the page is well-formed.
constexpr const char* kReportStyle = R"(
:root {
  color-scheme: light dark;
  --page: #ffffff; --text: #1c2128; --soft: #59636e; --line: #d5dae0; --panel: #f4f6f8;
  --link: #0b5cad; --good: #17653a; --good-panel: #e8f4ec; --bad: #a3211b; --bad-panel: #fcebe9;
}
@media (prefers-color-scheme: dark) {
  :root {
    --page: #14171b; --text: #e3e7eb; --soft: #9aa5b1; --line: #353c45; --panel: #1d2126;
    --link: #7ab7f5; --good: #7fd3a0; --good-panel: #16291e; --bad: #ff9b91; --bad-panel: #3a1b19;
  }
}
* { box-sizing: border-box; }
body {
  margin: 0 auto; padding: 2.5rem 1.5rem 4rem; max-width: 78rem;
  background: var(--page); color: var(--text);
  font: 1rem/1.5 system-ui, -apple-system, "Segoe UI", Roboto, "DejaVu Sans", sans-serif;
}
h1 { font-size: 1.9rem; line-height: 1.2; margin: 0 0 1.25rem; text-wrap: balance; }
h2 { font-size: 1.25rem; margin: 2.75rem 0 .5rem; }
p { margin: .5rem 0; max-width: 52rem; text-wrap: pretty; }
a { color: var(--link); text-underline-offset: .15em; }
.note, .theirs, figcaption { color: var(--soft); }
.note { font-size: .925rem; }
code {
  font: .9em ui-monospace, "DejaVu Sans Mono", Menlo, Consolas, monospace;
  overflow-wrap: anywhere;
}
.verdict {
  margin: 0 0 1.25rem; padding: .8rem 1.1rem; max-width: none; font-size: 1.1rem;
  border-left: .3rem solid; border-radius: .25rem;
}
.verdict.good { background: var(--good-panel); border-color: var(--good); }
.verdict.bad { background: var(--bad-panel); border-color: var(--bad); }
.good > strong, td.good { color: var(--good); }
.bad > strong, td.bad { color: var(--bad); }
td.bad, td.good { font-weight: 600; }
dl { display: grid; grid-template-columns: max-content 1fr; gap: .25rem 1.25rem; margin: 0; }
dt { color: var(--soft); }
dd { margin: 0; min-width: 0; }
.scroll { overflow-x: auto; margin: .9rem 0; }
table {
  border-collapse: collapse; width: 100%;
  font-size: .925rem; font-variant-numeric: tabular-nums;
}
th, td { padding: .32rem .7rem; text-align: left; vertical-align: top; }
th:first-child, td:first-child { padding-left: .4rem; }
thead th {
  color: var(--soft); font-weight: 600;
  border-bottom: 1px solid var(--line); vertical-align: bottom;
}
tbody { border-bottom: 1px solid var(--line); }
tbody th { font-weight: 600; }
th[scope=rowgroup] { min-width: 9rem; max-width: 18rem; overflow-wrap: break-word; }
.number { text-align: right; white-space: nowrap; }
.value { white-space: nowrap; }
.words { min-width: 9rem; }
td.note { min-width: 18rem; }
.verdicts { white-space: nowrap; }
.theirs { display: block; font-size: .85em; font-weight: 400; }
.figures {
  display: grid; gap: 1.5rem; margin-top: 1rem;
  grid-template-columns: repeat(auto-fill, minmax(min(27rem, 100%), 1fr));
}
figure {
  margin: 0; padding: .9rem 1rem 1rem; background: var(--panel); border-radius: .5rem;
  content-visibility: auto; contain-intrinsic-size: auto 30rem;
}
figure:target { outline: 2px solid var(--link); }
figure svg { display: block; width: 100%; height: auto; color: var(--text); }
figcaption { margin-top: .6rem; font-size: .925rem; }
figcaption strong { color: var(--text); font-size: 1rem; overflow-wrap: anywhere; }
@media print {
  :root {
    --page: #ffffff; --text: #000000; --soft: #444444; --line: #bbbbbb; --panel: #ffffff;
    --link: #000000; --good: #000000; --good-panel: #ffffff; --bad: #000000; --bad-panel: #ffffff;
  }
  @page { margin: 12mm; }
  html { font-size: 9pt; }
  body { padding: 0; max-width: none; }
  table { font-size: 7.5pt; }
  td.note { font-size: 1em; }
  th, td { padding: .15rem .3rem; }
  .words, td.note, th[scope=rowgroup] { min-width: 0; }
  a { text-decoration: none; }
  .scroll { overflow: visible; }
  thead { display: table-header-group; }
  tr, figure, .verdict { break-inside: avoid; }
  h2, h2 + .note { break-after: avoid; }
  .figures { grid-template-columns: 1fr 1fr; }
  figure { content-visibility: visible; border: 1px solid var(--line); }
  svg { print-color-adjust: exact; -webkit-print-color-adjust: exact; }
}
)";

/// One of the differences that are measured at each level.
struct Measure {
    const char* name;
    double LevelAgreement::*value;
    double Bounds::*bound;
    const char* what;
};

constexpr Measure kMeasures[] = {
    {"Positions", &LevelAgreement::positionDifference, &Bounds::position,
     "The largest distance between two matching vertices, for random positions of the control "
     "vertices in a cube, as a fraction of the side of the cube."},
    {"Weights", &LevelAgreement::weightDifference, &Bounds::weight,
     "The largest difference between two weights of matching stencils. A weight is the share of a "
     "control vertex in a vertex of the level."},
    {"Evaluators", &LevelAgreement::evaluatorDifference, &Bounds::evaluator,
     "The largest distance, measured as for positions, between the results of the two evaluators "
     "for the same stencil table. OpenSubdiv's evaluator computes in single precision."}};

/// True also for NaN.
bool isOver(const Measure& measure, const LevelAgreement& level, const Bounds& bounds) {
    return !(level.*measure.value <= bounds.*measure.bound);
}

std::string failureOf(const ReportedShape& shape) {
    if (!shape.failure.empty()) return shape.failure;
    return shape.agreement.levels.empty() ? "no level was compared" : "";
}

bool hasPicture(const ReportedShape& shape) {
    return !shape.agreement.picture.faces.empty();
}

/// Returns the name of a shape, with a link to its picture if there is one.
std::string linkedName(const Report& report, std::size_t index) {
    const ReportedShape& shape = report.shapes[index];
    const std::string name = escaped(shape.name);
    return hasPicture(shape) ? fmt::format("<a href=\"#shape-{}\">{}</a>", index + 1, name) : name;
}

/// Counts for the verdict.
struct Totals {
    std::size_t levels = 0;
    std::size_t levelsOver = 0;
    std::size_t shapesOver = 0;
    std::size_t failures = 0;

    explicit Totals(const Report& report) {
        for (const ReportedShape& shape : report.shapes) {
            levels += shape.agreement.levels.size();
            for (const LevelAgreement& level : shape.agreement.levels)
                levelsOver += !level.isWithin(report.bounds);
            shapesOver +=
                !shape.agreement.levels.empty() && !shape.agreement.isWithin(report.bounds);
            failures += !failureOf(shape).empty();
        }
    }
};

std::string verdict(const Report& report) {
    const Totals totals(report);
    const std::string openSubdiv = fmt::format("OpenSubdiv {}", escaped(report.openSubdivVersion));
    const std::string compared =
        fmt::format("{}, {}", counted(report.shapes.size(), "shape", "shapes"),
                    counted(totals.levels, "level", "levels"));
    const std::string over = fmt::format("{} not within the bounds ({})",
                                         counted(totals.shapesOver, "shape is", "shapes are"),
                                         counted(totals.levelsOver, "level", "levels"));
    const std::string failed =
        counted(totals.failures, "shape", "shapes") + " could not be compared";
    const auto paragraph = [](const char* kind, const std::string& head, const std::string& rest) {
        return fmt::format("<p class=\"verdict {}\"><strong>{}.</strong> {}</p>\n", kind, head,
                           rest);
    };
    if (report.shapes.empty()) return paragraph("bad", "Nothing was compared", "");
    if (totals.shapesOver > 0)
        return paragraph(
            "bad", "Does not agree with " + openSubdiv,
            fmt::format("{}: {}.", compared,
                        totals.failures > 0 ? fmt::format("{}; {}", over, failed) : over));
    if (totals.failures > 0)
        return paragraph("bad", "Could not all be compared with " + openSubdiv,
                         fmt::format("{}, all of them within the bounds; {}.", compared, failed));
    return paragraph("good", "Agrees with " + openSubdiv,
                     fmt::format("{}, all within the bounds.", compared));
}

/// Returns the row with the largest value of a measure over all shapes and levels, and where it is.
std::string largestRow(const Report& report, const Measure& measure) {
    std::optional<std::size_t> shape;
    LevelAgreement largest;
    bool isBad = false;
    for (std::size_t i = 0; i < report.shapes.size(); ++i)
        for (const LevelAgreement& level : report.shapes[i].agreement.levels) {
            isBad = isBad || isOver(measure, level, report.bounds);
            const double value = level.*measure.value;
            // NaN counts as the largest.
            if (std::isnan(largest.*measure.value) || value <= largest.*measure.value) continue;
            largest = level;
            shape = i;
        }
    const std::string where =
        shape ? fmt::format("{}, level {}", linkedName(report, *shape), largest.level) : "nowhere";
    return fmt::format(
        "<tr><th scope=\"row\">{}</th><td class=\"number{}\">{}</td><td class=\"number\">{}</td>"
        "<td class=\"words\">{}</td><td class=\"note\">{}</td></tr>\n",
        measure.name, isBad ? " bad" : "", scientific(largest.*measure.value),
        fmt::format("{:g}", report.bounds.*measure.bound), where, measure.what);
}

std::string largestDifferences(const Report& report) {
    if (Totals(report).levels == 0) return "";
    std::string rows;
    for (const Measure& measure : kMeasures) rows += largestRow(report, measure);
    return fmt::format(
        R"(<section>
<h2>Largest differences</h2>
<div class="scroll" role="region" aria-label="Largest differences" tabindex="0">
<table>
<thead><tr><th scope="col">Difference</th><th scope="col" class="number">Largest</th>
<th scope="col" class="number">Bound</th><th scope="col">Where</th>
<th scope="col">What it is</th></tr></thead>
<tbody>
{}</tbody>
</table>
</div>
<p class="note">Vertices, edges and faces of the two are matched by topology, through parents and
children, never by position.</p>
</section>
)",
        rows);
}

std::string countCell(Index ours, Index openSubdiv) {
    std::string cell = grouped(ours);
    if (ours != openSubdiv)
        cell += fmt::format("<span class=\"theirs\">OpenSubdiv: {}</span>", grouped(openSubdiv));
    return fmt::format("<td class=\"number{}\">{}</td>", ours != openSubdiv ? " bad" : "", cell);
}

std::string levelCells(const LevelAgreement& level, const Bounds& bounds) {
    std::string cells = fmt::format("<th scope=\"row\" class=\"number\">{}</th>", level.level);
    for (std::size_t k = 0; k < 3; ++k)
        cells += countCell(level.counts[k], level.openSubdivCounts[k]);
    const bool hasEqualCounts = level.counts == level.openSubdivCounts;
    const std::string difference = !level.topologyDifference.empty() || hasEqualCounts
                                       ? level.topologyDifference
                                       : "the counts differ";
    cells += difference.empty()
                 ? "<td class=\"words\">equal</td>"
                 : fmt::format("<td class=\"words bad\">{}</td>", escaped(difference));
    for (const Measure& measure : kMeasures)
        cells += fmt::format("<td class=\"number{}\">{}</td>",
                             isOver(measure, level, bounds) ? " bad" : "",
                             scientific(level.*measure.value));
    cells += level.isWithin(bounds) ? "<td class=\"verdicts good\">✓ agrees</td>"
                                    : "<td class=\"verdicts bad\">✗ differs</td>";
    return cells;
}

/// Returns a group of rows: the levels of a shape, and the failure that ended them, if any.
std::string shapeRows(const Report& report, std::size_t index) {
    const ReportedShape& shape = report.shapes[index];
    const std::string failure = failureOf(shape);
    const std::vector<LevelAgreement>& levels = shape.agreement.levels;
    std::vector<std::string> rows;
    rows.reserve(levels.size() + 2);
    for (const LevelAgreement& level : levels) rows.push_back(levelCells(level, report.bounds));
    if (!shape.agreement.note.empty())
        rows.push_back(fmt::format("<td colspan=\"9\" class=\"words note\">Note: {}</td>",
                                   escaped(shape.agreement.note)));
    if (!failure.empty())
        rows.push_back(
            fmt::format("<td colspan=\"8\" class=\"words bad\">could not be compared: "
                        "{}</td><td class=\"verdicts bad\">✗ not compared</td>",
                        escaped(failure)));
    std::string group =
        fmt::format("<tbody id=\"levels-{}\">\n<tr><th scope=\"rowgroup\" rowspan=\"{}\">{}</th>",
                    index + 1, rows.size(), linkedName(report, index));
    for (std::size_t i = 0; i < rows.size(); ++i)
        group += fmt::format("{}{}</tr>\n", i > 0 ? "<tr>" : "", rows[i]);
    group += "</tbody>\n";
    return group;
}

std::string allLevels(const Report& report) {
    if (report.shapes.empty()) return "";
    std::string table =
        "<section>\n<h2>Shapes and levels</h2>\n"
        "<div class=\"scroll\" role=\"region\" aria-label=\"Shapes and levels\" tabindex=\"0\">\n"
        "<table>\n<thead><tr><th scope=\"col\">Shape</th>";
    for (const char* name : {"Level", "Vertices", "Edges", "Faces"})
        table += fmt::format("<th scope=\"col\" class=\"number\">{}</th>", name);
    table += "<th scope=\"col\">Topology</th>";
    for (const Measure& measure : kMeasures)
        table += fmt::format("<th scope=\"col\" class=\"number\">{}</th>", measure.name);
    table += "<th scope=\"col\">Verdict</th></tr></thead>\n";
    for (std::size_t i = 0; i < report.shapes.size(); ++i) table += shapeRows(report, i);
    table += "</table>\n</div>\n</section>\n";
    return table;
}

std::string positionText(const Point3& p) {
    const double size = std::max({std::abs(p[0]), std::abs(p[1]), std::abs(p[2])});
    // Values within rounding are shown as 0.
    const auto shown = [&](double x) { return std::abs(x) < 1e-9 * size ? 0 : x; };
    return fmt::format("({:.4g}, {:.4g}, {:.4g})", shown(p[0]), shown(p[1]), shown(p[2]));
}

std::string figure(const Report& report, std::size_t index) {
    const ReportedShape& shape = report.shapes[index];
    const SurfaceError& picture = shape.agreement.picture;
    std::string caption = fmt::format("Level {}, {}. ", picture.level,
                                      counted(picture.faces.size(), "face", "faces"));
    if (const auto vertex = largestErrorVertex(picture)) {
        const std::size_t v = *vertex;
        caption += fmt::format(
            "Largest error <span class=\"value\">{}</span>, at vertex {}, "
            "<span class=\"value\">{}</span>.",
            scientific(picture.errors[v]), picture.vertices.empty() ? *vertex : picture.vertices[v],
            positionText(picture.positions[v]));
    } else {
        caption += "No vertex is off: all errors are 0.";
    }
    return fmt::format(
        "<figure id=\"shape-{0}\">\n{1}<figcaption><strong>{2}</strong><br/>{3} "
        "<a href=\"#levels-{0}\" aria-label=\"Levels of {2}\">Levels</a></figcaption>\n</figure>\n",
        index + 1, errorPicture(picture, report.bounds), escaped(shape.name), caption);
}

std::string pictures(const Report& report) {
    std::string figures;
    for (std::size_t i = 0; i < report.shapes.size(); ++i)
        if (hasPicture(report.shapes[i])) figures += figure(report, i);
    if (figures.empty()) return "";
    return fmt::format(R"(<section>
<h2>Error over the surface</h2>
<p class="note">How far the points of OpenSubdiv are from those of Espalier, as a fraction of the size of the
shape. A face has the colour of the largest error of its corners: grey where there is none, green to
blue up to the bound, red to purple above it. A ring is round the vertex of the largest error,
broken where that is behind the surface.</p>
<div class="figures">
{}</div>
</section>
)",
                       figures);
}

}  // namespace

std::string htmlReport(const Report& report) {
    return fmt::format(R"(<!DOCTYPE html>
<html lang="en">
<head>
<meta charset="utf-8"/>
<meta name="viewport" content="width=device-width, initial-scale=1"/>
<title>{0}</title>
<style>{1}</style>
</head>
<body>
<header>
<h1>{0}</h1>
{2}<dl>
<dt>Compared with</dt><dd>OpenSubdiv {3}</dd>
<dt>Made by</dt><dd><code>{4}</code></dd>
</dl>
</header>
<main>
{5}{6}{7}</main>
</body>
</html>
)",
                       escaped(report.title), kReportStyle, verdict(report),
                       escaped(report.openSubdivVersion), escaped(report.command),
                       largestDifferences(report), allLevels(report), pictures(report));
}

}  // namespace espalier::compare
