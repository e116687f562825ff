// SPDX-License-Identifier: Apache-2.0
#include "error_picture.h"

#include <espalier/base/error.h>

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <iterator>
#include <limits>
#include <vector>

#include "error_scale.h"
#include "report_text.h"
#include "surface_view.h"

namespace espalier::compare {
namespace {

// Lengths in px of the picture: the surface over the legend.
constexpr int kWidth = 640;
constexpr int kHeight = 500;
constexpr int kMargin = 16;
constexpr int kSurfaceHeight = 418;
constexpr int kLineHeight = 18;
constexpr int kBarTop = 444;
constexpr int kBarHeight = 14;
constexpr int kBarLeft = 96;
constexpr int kBarWidth = 510;
constexpr int kExactLeft = 30;
constexpr int kExactWidth = 36;

/// Coordinates of the surface are whole numbers of this many a px: shorter than with a point.
constexpr int kUnits = 10;

/// The least brightness of a face; one that faces the light has 1.
constexpr double kAmbient = 0.6;

std::string svg(int height, const std::string& label, const std::string& content) {
    return fmt::format(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {} {}\" role=\"img\" "
        "aria-label=\"{}\" font-family=\"system-ui,sans-serif\" font-size=\"13\" "
        "fill=\"currentColor\">\n{}</svg>\n",
        kWidth, height, label, content);
}

std::string text(double x, double y, const std::string& anchor, const std::string& words) {
    return fmt::format("<text x=\"{:.1f}\" y=\"{:.1f}\" text-anchor=\"{}\">{}</text>\n", x, y,
                       anchor, words);
}

/// From the plane of a view to the picture.
class Placement {
public:
    /// \param top of the room for the surface, in px
    Placement(const SurfaceView& view, int top) : middle_((top + kSurfaceHeight) / 2.0) {
        for (std::size_t k = 0; k < 2; ++k) {
            const double extent = view.max[k] - view.min[k];
            const double room = (k == 0 ? kWidth : kSurfaceHeight - top) - 2 * kMargin;
            if (extent > 0) scale_ = std::min(scale_, room / extent);
            from_[k] = (view.min[k] + view.max[k]) / 2;
        }
        if (!std::isfinite(scale_)) scale_ = 1;
    }

    /// In units of 1/kUnits px.
    std::array<long, 2> operator()(const std::array<double, 2>& point) const {
        return {std::lround(((point[0] - from_[0]) * scale_ + kWidth / 2.0) * kUnits),
                std::lround(((point[1] - from_[1]) * scale_ + middle_) * kUnits)};
    }

private:
    double middle_;
    double scale_ = std::numeric_limits<double>::infinity();
    std::array<double, 2> from_ = {};
};

/// "3-4": two numbers of a path, the second set apart by its sign where it has one.
void appendPair(std::string& path, const std::array<long, 2>& pair) {
    fmt::format_to(std::back_inserter(path), "{}{}{}", pair[0], pair[1] < 0 ? "" : " ", pair[1]);
}

/// Strokes of the faces' own colours close the hairlines that would show between neighbours.
std::string drawnFaces(const SurfaceError& surface, const SurfaceView& view,
                       const Placement& placement, const ErrorScale& scale) {
    std::string group = fmt::format(
        "<g class=\"surface\" transform=\"scale({})\" fill=\"currentColor\" "
        "stroke=\"currentColor\" stroke-width=\"{}\" stroke-linejoin=\"round\">\n",
        1.0 / kUnits, 0.7 * kUnits);
    for (const SeenFace& seen : view.faces) {
        const std::array<Index, 4>& face = surface.faces[seen.face];
        double error = 0;
        for (const Index corner : face) {
            const double e = std::abs(surface.errors[corner]);
            // What is not a number counts as the largest.
            if (!(e <= error) && !std::isnan(error)) error = e;
        }
        const Colour colour = shaded(scale.colour(error), std::lerp(kAmbient, 1.0, seen.light));
        fmt::format_to(std::back_inserter(group), "<path color=\"{}\" d=\"M", hexText(colour));
        std::array<long, 2> last{};
        for (std::size_t i = 0; i < 4; ++i) {
            const auto point = placement(view.points[face[i]]);
            if (i == 1) group += 'l';
            if (i > 1 && point[0] >= last[0]) group += ' ';
            appendPair(group, {point[0] - last[0], point[1] - last[1]});
            last = point;
        }
        group += "z\"/>\n";
    }
    group += "</g>\n";
    return group;
}

/// Two strokes, one of them light, so that it shows on every colour.
std::string ring(const std::array<long, 2>& centre, bool isHidden) {
    const std::string circle = fmt::format(
        "<circle cx=\"{:.1f}\" cy=\"{:.1f}\" r=\"9\" fill=\"none\"{}",
        static_cast<double>(centre[0]) / kUnits, static_cast<double>(centre[1]) / kUnits,
        isHidden ? " stroke-dasharray=\"4.04 3.03\"" : "");
    return circle + " stroke=\"#fff\" stroke-width=\"4.5\"/>\n" + circle +
           " stroke=\"#111\" stroke-width=\"2\"/>\n";
}

std::string legend(const ErrorScale& scale, double bound, double largest) {
    constexpr int kSteps = 102;
    constexpr double kBarBottom = kBarTop + kBarHeight;
    std::string content = "<g class=\"legend\">\n";
    const auto block = [&](double x, double width, const Colour& colour) {
        content +=
            fmt::format("<rect x=\"{:g}\" y=\"{}\" width=\"{:g}\" height=\"{}\" fill=\"{}\"/>\n", x,
                        kBarTop, width, kBarHeight, hexText(colour));
    };
    block(kExactLeft, kExactWidth, ErrorScale::kExact);
    content += text(kExactLeft + kExactWidth / 2.0, kBarBottom + 18, "middle", "0");
    constexpr double kStep = static_cast<double>(kBarWidth) / kSteps;
    // Each is drawn to the end of the bar, and the next over it: no gaps here either.
    for (int i = 0; i < kSteps; ++i)
        block(kBarLeft + i * kStep, kBarWidth - i * kStep, scale.colourAt((i + 0.5) / kSteps));
    for (const ErrorScale::Tick& tick : scale.ticks(0.085)) {
        const double x = kBarLeft + tick.place * kBarWidth;
        content += fmt::format("<path d=\"M{:.1f} {}v{}\" stroke=\"currentColor\"/>\n", x,
                               kBarBottom, tick.label.empty() ? 3 : 5);
        if (tick.label.empty()) continue;
        const char* sign = tick.place == 0 ? "≤ " : tick.place == 1 ? "≥ " : "";
        content += text(x, kBarBottom + 18, "middle", sign + tick.label);
    }
    if (scale.place(bound) == ErrorScale::kBoundPlace) {
        const double x = kBarLeft + ErrorScale::kBoundPlace * kBarWidth;
        content +=
            fmt::format("<path d=\"M{:.1f} {}v{}\" stroke=\"currentColor\" stroke-width=\"2\"/>\n",
                        x, kBarTop - 6, kBarHeight + 6);
        content += text(x, kBarTop - 11, "middle", "bound");
    }
    const double at =
        largest == 0 ? kExactLeft + kExactWidth / 2.0 : kBarLeft + scale.place(largest) * kBarWidth;
    content +=
        fmt::format("<path class=\"largest\" d=\"M{:.1f} {}l-5-9h10z\"/>\n", at, kBarTop - 1);
    content +=
        text(kWidth / 2.0, kHeight - 6, "middle", "error, as a fraction of the size of the shape");
    content += "</g>\n";
    return content;
}

/// What is not as it should be, a line each.
std::vector<std::string> remarks(const SurfaceError& surface, const SurfaceView& view) {
    std::vector<std::string> lines;
    const std::size_t left = surface.faces.size() - view.faces.size();
    if (left > 0)
        lines.push_back(fmt::format("{} not drawn: a position is not finite.",
                                    counted(left, "face is", "faces are")));
    const auto bad = static_cast<std::size_t>(std::count_if(
        surface.errors.begin(), surface.errors.end(), [](double e) { return !std::isfinite(e); }));
    if (bad > 0)
        lines.push_back(fmt::format("{} not finite.", counted(bad, "error is", "errors are")));
    return lines;
}

}  // namespace

std::optional<Index> largestErrorVertex(const SurfaceError& surface) {
    std::optional<Index> vertex;
    double largest = 0;
    for (std::size_t i = 0; i < surface.errors.size(); ++i) {
        const double error = std::abs(surface.errors[i]);
        if (error <= largest) continue;
        vertex = static_cast<Index>(i);
        largest = error;
        if (std::isnan(error)) break;
    }
    return vertex;
}

std::string errorPicture(const SurfaceError& surface, const Bounds& bounds) {
    if (surface.errors.size() != surface.positions.size())
        throw Error(fmt::format("picture: {} errors for {} positions", surface.errors.size(),
                                surface.positions.size()));
    const SurfaceView view = viewOf(surface);
    const auto nothing = [](const std::string& why) {
        const std::string words = fmt::format("No picture: {}.", why);
        return svg(80, words, text(kWidth / 2.0, 45, "middle", words));
    };
    if (surface.faces.empty()) return nothing("the surface has no faces");
    if (view.faces.empty()) return nothing("every face has a position that is not finite");
    if (!(std::max(view.max[0] - view.min[0], view.max[1] - view.min[1]) > 0))
        return nothing("all positions are the same");

    const std::vector<std::string> lines = remarks(surface, view);
    const Placement placement(view, kLineHeight * static_cast<int>(lines.size()));
    const ErrorScale scale(bounds.position);
    const std::optional<Index> worst = largestErrorVertex(surface);
    const double largest = worst ? surface.errors[*worst] : 0;
    std::string content = drawnFaces(surface, view, placement, scale);
    const Sight sight = worst ? sightOf(surface, view, *worst) : Sight::Absent;
    if (sight != Sight::Absent)
        content += ring(placement(view.points[*worst]), sight == Sight::Hidden);
    content += legend(scale, bounds.position, largest);
    for (std::size_t i = 0; i < lines.size(); ++i)
        content += text(kMargin, 20 + kLineHeight * static_cast<double>(i), "start", lines[i]);
    return svg(kHeight,
               fmt::format("The surface at level {}, coloured by error: {}, the largest error {}.",
                           surface.level, counted(surface.faces.size(), "face", "faces"),
                           scientific(largest)),
               content);
}

}  // namespace espalier::compare
