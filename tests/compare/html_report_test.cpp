// SPDX-License-Identifier: Apache-2.0
#include <espalier/compare/html_report.h>

#include <pugixml.hpp>

#include "compare/report_text.h"
#include "support/test.h"

namespace espalier::test {
namespace {

using compare::LevelAgreement;
using compare::Report;
using compare::ReportedShape;
using testing::Not;

/// Returns a level of a cube: 6 · 4^level faces, twice as many edges, and 2 more vertices than
/// faces.
LevelAgreement cubeLevel(int level) {
    const Index faces = 6 << (2 * level);
    LevelAgreement agreement;
    agreement.level = level;
    agreement.counts = agreement.openSubdivCounts = {faces + 2, 2 * faces, faces};
    agreement.positionDifference = 1.1e-16 * level;
    agreement.weightDifference = 5.5e-17;
    agreement.evaluatorDifference = 1.2e-7;
    return agreement;
}

ReportedShape shape(const std::string& name, int levels) {
    ReportedShape shape{.name = name};
    for (int level = 1; level <= levels; ++level)
        shape.agreement.levels.push_back(cubeLevel(level));
    return shape;
}

/// Returns a shape with a picture of one square, whose last vertex has an error.
ReportedShape picturedShape(const std::string& name, int levels) {
    ReportedShape pictured = shape(name, levels);
    pictured.agreement.picture = {.level = levels,
                                  .positions = {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {1e-17, 1.5, 0}},
                                  .faces = {{0, 1, 2, 3}},
                                  .errors = {0, 0, 0, 2.5e-16}};
    return pictured;
}

Report reportOf(std::vector<ReportedShape> shapes) {
    return {.title = "Agreement",
            .command = "espalier compare cube.vtu",
            .bounds = {},
            .openSubdivVersion = "3.5.0",
            .shapes = std::move(shapes)};
}

std::string textOf(const pugi::xml_node& node) {
    std::string text = node.type() == pugi::node_pcdata ? node.value() : "";
    for (const auto child : node.children()) text += textOf(child);
    return text;
}

/// A page, parsed as XML.
struct Page {
    std::string html;
    pugi::xml_document document;

    explicit Page(const Report& report) : html(compare::htmlReport(report)) {
        // Text of spaces only matters: it separates words.
        const auto result = document.load_buffer(html.data(), html.size(),
                                                 pugi::parse_full | pugi::parse_ws_pcdata);
        EXPECT_TRUE(result) << result.description() << " at " << result.offset;
    }

    std::vector<std::string> texts(const char* path) const {
        std::vector<std::string> texts;
        for (const auto& found : document.select_nodes(path)) texts.push_back(textOf(found.node()));
        return texts;
    }

    std::string verdict() const { return texts("//p[contains(@class, 'verdict')]").at(0); }
    std::string verdictClass() const {
        return document.select_node("//p[contains(@class, 'verdict')]")
            .node()
            .attribute("class")
            .value();
    }

    /// Returns the cells of the row of a level, starting with the level.
    std::vector<std::string> row(std::size_t shape, int level) const {
        const std::string path = "//tbody[@id='levels-" + std::to_string(shape) +
                                 "']/tr[th[@scope='row']='" + std::to_string(level) +
                                 "']/*[not(@scope='rowgroup')]";
        return texts(path.c_str());
    }
};

TEST(HtmlReport, SaysInOneSentenceThatAllAgree) {
    const Page page(reportOf({shape("cube", 3), shape("torus", 2)}));
    EXPECT_EQ(page.verdict(),
              "Agrees with OpenSubdiv 3.5.0. 2 shapes, 5 levels, all within the bounds.");
    EXPECT_EQ(page.verdictClass(), "verdict good");
    EXPECT_EQ(Page(reportOf({shape("cube", 1)})).verdict(),
              "Agrees with OpenSubdiv 3.5.0. 1 shape, 1 level, all within the bounds.");
}

TEST(HtmlReport, SaysHowManyDoNotAgree) {
    Report report = reportOf({shape("cube", 3), shape("torus", 2)});
    report.shapes[1].agreement.levels[0].positionDifference = 2e-13;
    report.shapes[1].agreement.levels[1].weightDifference = 2e-14;
    const Page page(report);
    EXPECT_EQ(page.verdict(),
              "Does not agree with OpenSubdiv 3.5.0. 2 shapes, 5 levels: 1 shape is not within the "
              "bounds (2 levels).");
    EXPECT_EQ(page.verdictClass(), "verdict bad");
    report.shapes.push_back({.name = "lost", .failure = "lost: cannot be opened"});
    EXPECT_EQ(Page(report).verdict(),
              "Does not agree with OpenSubdiv 3.5.0. 3 shapes, 5 levels: 1 shape is not within the "
              "bounds (2 levels); 1 shape could not be compared.");
}

TEST(HtmlReport, SaysWhichShapesCouldNotBeCompared) {
    const Page page(reportOf(
        {shape("cube", 3),
         {.name = "lost", .agreement = {}, .failure = "lost.obj:3: not a number: \"x\""}}));
    EXPECT_EQ(page.verdict(),
              "Could not all be compared with OpenSubdiv 3.5.0. 2 shapes, 3 levels, all of them "
              "within the bounds; 1 shape could not be compared.");
    EXPECT_EQ(page.verdictClass(), "verdict bad");
    EXPECT_THAT(
        page.texts("//tbody[@id='levels-2']/tr/td"),
        ElementsAre("could not be compared: lost.obj:3: not a number: \"x\"", "✗ not compared"));
}

/// Levels that were compared before a failure are shown as well, and a shape with neither levels
/// nor a failure is not ignored.
TEST(HtmlReport, CountsAShapeWithoutLevelsAsAFailure) {
    Report report = reportOf({shape("none", 0), shape("half", 2)});
    report.shapes[1].failure = "level 3 has too many faces";
    const Page page(report);
    EXPECT_THAT(page.verdict(), HasSubstr("2 shapes could not be compared"));
    EXPECT_THAT(page.texts("//tbody[@id='levels-1']/tr/td").at(0), HasSubstr("no level"));
    EXPECT_THAT(page.texts("//tbody[@id='levels-2']/tr"), SizeIs(3));
}

TEST(HtmlReport, WithoutShapesDoesNotPass) {
    const Page page(reportOf({}));
    EXPECT_EQ(page.verdict(), "Nothing was compared. ");
    EXPECT_EQ(page.verdictClass(), "verdict bad");
    EXPECT_THAT(page.texts("//table"), IsEmpty());
}

TEST(HtmlReport, HasARowForEachShapeAndLevel) {
    const Page page(reportOf({shape("cube", 5), shape("torus", 2)}));
    EXPECT_THAT(page.texts("//th[@scope='rowgroup']"), ElementsAre("cube", "torus"));
    for (int level = 1; level <= 5; ++level)
        EXPECT_EQ(page.row(1, level).size(), 9u) << "level " << level;
    EXPECT_EQ(page.row(2, 2).size(), 9u);
    EXPECT_EQ(page.row(2, 3).size(), 0u);
    // 6 · 4^5 = 6144 faces.
    EXPECT_THAT(page.row(1, 5), ElementsAre("5", "6,146", "12,288", "6,144", "equal", "5.5e-16",
                                            "5.5e-17", "1.2e-07", "✓ agrees"));
    // There are as many headers as cells: the shape and nine more.
    EXPECT_THAT(page.texts("//section[h2='Shapes and levels']//th[@scope='col']"),
                ElementsAre("Shape", "Level", "Vertices", "Edges", "Faces", "Topology", "Positions",
                            "Weights", "Evaluators", "Verdict"));
}

TEST(HtmlReport, HighlightsDifferencesOverTheirBounds) {
    Report report = reportOf({shape("cube", 4)});
    report.shapes[0].agreement.levels[0].positionDifference = 2e-13;
    report.shapes[0].agreement.levels[1].weightDifference = 2e-14;
    report.shapes[0].agreement.levels[2].evaluatorDifference = 3e-6;
    report.shapes[0].agreement.levels[3].weightDifference = kNan;
    const Page page(report);
    const auto bad = [&](int level) {
        const std::string path =
            "//tr[th[@scope='row']='" + std::to_string(level) + "']/td[contains(@class, 'bad')]";
        return page.texts(path.c_str());
    };
    EXPECT_THAT(bad(1), ElementsAre("2.0e-13", "✗ differs"));
    EXPECT_THAT(bad(2), ElementsAre("2.0e-14", "✗ differs"));
    EXPECT_THAT(bad(3), ElementsAre("3.0e-06", "✗ differs"));
    EXPECT_THAT(bad(4), ElementsAre("not a number", "✗ differs"));
}

TEST(HtmlReport, ShowsDifferencesOfTopology) {
    Report report = reportOf({shape("cube", 2)});
    report.shapes[0].agreement.levels[0].topologyDifference = "face 3 is a hole, but not there";
    report.shapes[0].agreement.levels[1].openSubdivCounts[1] = 1234;
    const Page page(report);
    EXPECT_EQ(page.row(1, 1).at(4), "face 3 is a hole, but not there");
    EXPECT_EQ(page.row(1, 1).back(), "✗ differs");
    EXPECT_EQ(page.row(1, 2).at(2), "192OpenSubdiv: 1,234");
    EXPECT_EQ(page.row(1, 2).at(4), "the counts differ");
    EXPECT_EQ(page.row(1, 2).back(), "✗ differs");
}

TEST(HtmlReport, ShowsTheLargestDifferencesBesideTheirBounds) {
    Report report = reportOf({shape("cube", 3), shape("torus", 2)});
    report.shapes[1].agreement.levels[1].weightDifference = 8e-16;
    report.bounds.position = 3e-13;
    const Page page(report);
    const auto row = [&](const char* name) {
        const std::string path = std::string("//tr[th='") + name + "']/td[position() < 4]";
        return page.texts(path.c_str());
    };
    EXPECT_THAT(row("Positions"), ElementsAre("3.3e-16", "3e-13", "cube, level 3"));
    EXPECT_THAT(row("Weights"), ElementsAre("8.0e-16", "1e-14", "torus, level 2"));
    EXPECT_THAT(row("Evaluators"), ElementsAre("1.2e-07", "2e-06", "cube, level 1"));
}

TEST(HtmlReport, ShowsNotes) {
    Report report = reportOf({shape("cube", 1)});
    report.shapes[0].agreement.note = "2 vertices were marked";
    const Page page(report);
    EXPECT_THAT(page.texts("//tr/td[@colspan]"), ElementsAre("Note: 2 vertices were marked"));
    EXPECT_EQ(page.verdictClass(), "verdict good");
}

TEST(HtmlReport, HasAFigureForEachPicture) {
    const Page page(reportOf({picturedShape("sheet", 2), shape("cube", 1)}));
    EXPECT_EQ(page.document.select_nodes("//figure/svg[@role='img']").size(), 1u);
    // The x of the vertex, 1e-17, is a rounded 0.
    EXPECT_THAT(page.texts("//figcaption"),
                ElementsAre("sheetLevel 2, 1 face. Largest error 2.5e-16, at vertex 3, (0, 1.5, "
                            "0). Levels"));
    Report exact = reportOf({picturedShape("sheet", 2)});
    exact.shapes[0].agreement.picture.errors[3] = 0;
    EXPECT_THAT(Page(exact).texts("//figcaption").at(0), HasSubstr("all errors are 0"));
}

TEST(HtmlReport, LinksLeadSomewhere) {
    const Page page(reportOf(
        {picturedShape("a", 2), shape("b", 1), picturedShape("c", 1), picturedShape("c", 1)}));
    std::set<std::string> ids;
    for (const auto& node : page.document.select_nodes("//@id"))
        EXPECT_TRUE(ids.insert(node.attribute().value()).second) << node.attribute().value();
    std::size_t links = 0;
    for (const auto& node : page.document.select_nodes("//@href")) {
        const std::string target = node.attribute().value();
        EXPECT_EQ(target.substr(0, 1), "#");
        EXPECT_TRUE(ids.count(target.substr(1)) == 1) << target;
        ++links;
    }
    // Links go from three shapes to their pictures and back, and from three largest differences.
    EXPECT_EQ(links, 9u);
    EXPECT_THAT(page.texts("//th[@scope='rowgroup']/a"), ElementsAre("a", "c", "c"));
}

TEST(HtmlReport, EscapesNames) {
    const std::string name = "<b>&\"it's\"</b>]]>";
    Report report = reportOf({picturedShape(name, 1), {.name = name, .failure = name}});
    report.title = report.command = name;
    report.shapes[0].agreement.note = name;
    report.shapes[0].agreement.levels[0].topologyDifference = name;
    const Page page(report);
    EXPECT_THAT(page.html, Not(HasSubstr("<b>")));
    EXPECT_THAT(page.texts("//h1"), ElementsAre(name));
    EXPECT_THAT(page.texts("//title"), ElementsAre(name));
    EXPECT_THAT(page.texts("//code"), ElementsAre(name));
    EXPECT_THAT(page.texts("//th[@scope='rowgroup']"), ElementsAre(name, name));
    EXPECT_EQ(page.row(1, 1).at(4), name);
    EXPECT_THAT(page.texts("//figcaption/strong"), ElementsAre(name));
    EXPECT_EQ(page.document.select_node("//figcaption/a").node().attribute("aria-label").value(),
              "Levels of " + name);
}

TEST(HtmlReport, NeedsNoExternalResources) {
    Page page(reportOf({picturedShape("a", 2)}));
    EXPECT_THAT(page.html, StartsWith("<!DOCTYPE html>\n"));
    EXPECT_EQ(page.document.child("html").attribute("lang").value(), std::string("en"));
    EXPECT_EQ(page.document.select_nodes("//script | //link | //img | //@src").size(), 0u);
    for (const char* word : {"url(", "@import", "<!--"})
        EXPECT_THAT(page.html, Not(HasSubstr(word)));
    // The only address is the name of the SVG language, from which nothing is loaded.
    page.document.select_node("//svg").node().remove_attribute("xmlns");
    std::ostringstream rest;
    page.document.save(rest);
    EXPECT_THAT(rest.str(), Not(HasSubstr("http")));
}

TEST(HtmlReport, IsDeterministic) {
    const Report report = reportOf({picturedShape("a", 2), shape("b", 1)});
    EXPECT_EQ(compare::htmlReport(report), compare::htmlReport(report));
}

TEST(ReportText, IsUtf8WithoutControlCharacters) {
    EXPECT_EQ(compare::escaped("a\tb\nc"), "a\tb\nc");
    EXPECT_EQ(compare::escaped("é 立 𝔼"), "é 立 𝔼");
    const std::string replaced = "\uFFFD";
    EXPECT_EQ(compare::escaped(std::string_view("a\0b\x1b\x7f", 5)),
              "a" + replaced + "b" + replaced + replaced);
    // A lone continuation byte, an overlong '/', a surrogate, a code above U+10FFFF, and a
    // truncated sequence.
    EXPECT_EQ(compare::escaped("\x80."), replaced + ".");
    EXPECT_EQ(compare::escaped("\xC0\xAF."), replaced + replaced + ".");
    EXPECT_EQ(compare::escaped("\xED\xA0\x80."), replaced + replaced + replaced + ".");
    EXPECT_EQ(compare::escaped("\xF4\x90\x80\x80."),
              replaced + replaced + replaced + replaced + ".");
    EXPECT_EQ(compare::escaped("\xE7\xAB"), replaced + replaced);
}

TEST(ReportText, FormatsNumbers) {
    EXPECT_EQ(compare::scientific(0), "0");
    EXPECT_EQ(compare::scientific(1.24e-300), "1.2e-300");
    EXPECT_EQ(compare::scientific(kInfinity), "infinite");
    EXPECT_EQ(compare::grouped(0), "0");
    EXPECT_EQ(compare::grouped(999), "999");
    EXPECT_EQ(compare::grouped(1000), "1,000");
    EXPECT_EQ(compare::grouped(1234567), "1,234,567");
    EXPECT_EQ(compare::counted(1, "face", "faces"), "1 face");
    EXPECT_EQ(compare::counted(0, "face", "faces"), "0 faces");
}

}  // namespace
}  // namespace espalier::test
