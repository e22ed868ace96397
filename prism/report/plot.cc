// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
#include "prism/report/plot.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <limits>

#include <glog/logging.h>

#include "prism/report/plot_canvas.h"

namespace prism {
namespace {

constexpr int kWidth = 800;
constexpr int kHeight = 500;
constexpr double kLeft = 75;
constexpr double kRight = 20;
constexpr double kTop = 40;
constexpr double kBottom = 55;
constexpr double kTextSize = 13;
constexpr double kThinning_px = 0.4;  // points nearer to the last drawn one add nothing
constexpr size_t kMaxPointsDrawn = 10000;
constexpr Color kInk{40, 40, 40};
constexpr Color kGrid{225, 225, 225};
constexpr Color kReference{150, 150, 150};
// Okabe and Ito's colours, which colour-blind readers can tell apart.
constexpr std::array<Color, 7> kColors = {{{0, 114, 178},
                                           {213, 94, 0},
                                           {0, 158, 115},
                                           {204, 121, 167},
                                           {230, 159, 0},
                                           {86, 180, 233},
                                           {0, 0, 0}}};

struct Range {
  double low = std::numeric_limits<double>::infinity();
  double high = -std::numeric_limits<double>::infinity();

  void Include(double value) {
    low = std::min(low, value);
    high = std::max(high, value);
  }
  double size() const { return high - low; }
  // Some air at both ends; a range that is empty or a single value gets a size of its own.
  void Pad() {
    if (!(low <= high)) *this = {0, 1};
    const double margin = size() > 0 ? 0.04 * size() : std::max(0.5, 0.1 * std::abs(low));
    low -= margin;
    high += margin;
  }
  void GrowTo(double new_size) {
    const double growth = (new_size - size()) / 2;
    low -= growth;
    high += growth;
  }
};

bool IsFinite(const PlotPoint& point) { return std::isfinite(point.x) && std::isfinite(point.y); }

// Half the length of the error bar of a point; 0: it has none.
double ErrorOf(const PlotSeries& series, size_t point) {
  if (series.y_errors.empty()) return 0;
  const double error = series.y_errors.at(point);
  return std::isfinite(error) ? error : 0;
}

// The part of a canvas that one plot is drawn on, with coordinates of its own.
class Panel {
 public:
  Panel(PlotPoint origin, PlotCanvas* canvas) : origin_(origin), canvas_(canvas) {}

  void Polyline(std::vector<PlotPoint> points, Color color, double width) const {
    for (PlotPoint& point : points) point = Shifted(point);
    canvas_->Polyline(points, color, width);
  }
  void Text(PlotPoint baseline,
            const std::string& text,
            TextAnchor anchor,
            double size,
            Color color,
            bool vertical) const {
    canvas_->Text(Shifted(baseline), text, anchor, size, color, vertical);
  }

 private:
  PlotPoint Shifted(PlotPoint point) const { return {point.x + origin_.x, point.y + origin_.y}; }

  PlotPoint origin_;
  PlotCanvas* canvas_;
};

// From the data's units to the canvas.
class Axes {
 public:
  explicit Axes(const Plot& plot) {
    for (const PlotSeries& series : plot.series) {
      for (size_t i = 0; i < series.points.size(); ++i) {
        const PlotPoint& point = series.points[i];
        if (!IsFinite(point)) continue;
        x_.Include(point.x);
        y_.Include(point.y - ErrorOf(series, i));
        y_.Include(point.y + ErrorOf(series, i));
      }
    }
    if (!plot.x_categories.empty()) {
      x_.Include(0);
      x_.Include(static_cast<double>(plot.x_categories.size()) - 1);
    }
    if (plot.y_from_zero && y_.low <= y_.high) y_.Include(0);
    const bool starts_at_zero = plot.y_from_zero && y_.low == 0;
    x_.Pad();
    y_.Pad();
    if (starts_at_zero) y_.low = 0;
    if (plot.equal_scale) {
      const double unit = std::max(x_.size() / kInnerWidth, y_.size() / kInnerHeight);
      x_.GrowTo(unit * kInnerWidth);
      y_.GrowTo(unit * kInnerHeight);
    }
  }

  double X(double x) const { return kLeft + (x - x_.low) / x_.size() * kInnerWidth; }
  double Y(double y) const { return kHeight - kBottom - (y - y_.low) / y_.size() * kInnerHeight; }
  const Range& x() const { return x_; }
  const Range& y() const { return y_; }

 private:
  static constexpr double kInnerWidth = kWidth - kLeft - kRight;
  static constexpr double kInnerHeight = kHeight - kTop - kBottom;
  Range x_;
  Range y_;
};

std::string TickLabel(double value) {
  char text[32];
  std::snprintf(text, sizeof(text), "%g", value);
  return text;
}

struct Tick {
  double value;
  std::string label;
};

std::vector<Tick> TicksOfX(const Plot& plot, const Axes& axes) {
  std::vector<Tick> ticks;
  for (const std::string& category : plot.x_categories) {
    ticks.push_back({static_cast<double>(ticks.size()), category});
  }
  if (!ticks.empty()) return ticks;
  for (const double x : AxisTicks(axes.x().low, axes.x().high, 8)) {
    ticks.push_back({x, TickLabel(x)});
  }
  return ticks;
}

void DrawFrame(const Plot& plot, const Axes& axes, const Panel& panel) {
  const double bottom = kHeight - kBottom;
  const double right = kWidth - kRight;
  for (const Tick& tick : TicksOfX(plot, axes)) {
    const double x = axes.X(tick.value);
    panel.Polyline({{x, kTop}, {x, bottom}}, kGrid, 1);
    panel.Text({x, bottom + 17}, tick.label, TextAnchor::kMiddle, kTextSize, kInk, false);
  }
  for (const double y : AxisTicks(axes.y().low, axes.y().high, 6)) {
    panel.Polyline({{kLeft, axes.Y(y)}, {right, axes.Y(y)}}, kGrid, 1);
    const PlotPoint beside{kLeft - 6, axes.Y(y) + 4};
    panel.Text(beside, TickLabel(y), TextAnchor::kEnd, kTextSize, kInk, false);
  }
  panel.Polyline({{kLeft, kTop}, {kLeft, bottom}, {right, bottom}}, kInk, 1);
  const double middle_x = (kLeft + right) / 2;
  const double middle_y = (kTop + bottom) / 2;
  panel.Text({middle_x, 24}, plot.title, TextAnchor::kMiddle, 16, kInk, false);
  panel.Text({middle_x, kHeight - 12.0}, plot.x_label, TextAnchor::kMiddle, kTextSize, kInk, false);
  panel.Text({18, middle_y}, plot.y_label, TextAnchor::kMiddle, kTextSize, kInk, true);
}

// Points that follow each other in a column of half a pixel are one vertical stroke: the first, the
// lowest, the highest and the last draw it. So long a line over time keeps all its peaks.
std::vector<PlotPoint> JoinColumns(const std::vector<PlotPoint>& line) {
  const auto column = [](const PlotPoint& point) { return std::floor(2 * point.x); };
  std::vector<PlotPoint> joined;
  for (size_t begin = 0; begin < line.size();) {
    size_t end = begin;
    size_t low = begin;
    size_t high = begin;
    for (; end < line.size() && column(line[end]) == column(line[begin]); ++end) {
      if (line[end].y < line[low].y) low = end;
      if (line[end].y > line[high].y) high = end;
    }
    std::array<size_t, 4> kept = {begin, std::min(low, high), std::max(low, high), end - 1};
    for (size_t k = 0; k < kept.size(); ++k) {
      if (k == 0 || kept[k] != kept[k - 1]) joined.push_back(line[kept[k]]);
    }
    begin = end;
  }
  return joined;
}

// What is left to draw of a line: no more points than an eye can tell apart.
std::vector<PlotPoint> Thinned(const std::vector<PlotPoint>& line) {
  const std::vector<PlotPoint> joined = JoinColumns(line);
  const size_t step = joined.size() / kMaxPointsDrawn + 1;
  std::vector<PlotPoint> thinned;
  for (size_t i = 0; i < joined.size(); i += step) {
    const PlotPoint& point = joined[i];
    if (!thinned.empty() &&
        std::hypot(point.x - thinned.back().x, point.y - thinned.back().y) < kThinning_px) {
      continue;
    }
    thinned.push_back(point);
  }
  if (!joined.empty()) thinned.push_back(joined.back());
  return thinned;
}

void DrawErrorBars(const PlotSeries& series, Color color, const Axes& axes, const Panel& panel) {
  constexpr double kCap = 4;  // half its width
  for (size_t i = 0; i < series.points.size(); ++i) {
    const double error = ErrorOf(series, i);
    if (error == 0 || !IsFinite(series.points[i])) continue;
    const double x = axes.X(series.points[i].x);
    const double low = axes.Y(series.points[i].y - error);
    const double high = axes.Y(series.points[i].y + error);
    panel.Polyline({{x, low}, {x, high}}, color, 1.5);
    for (const double y : {low, high}) {
      panel.Polyline({{x - kCap, y}, {x + kCap, y}}, color, 1.5);
    }
  }
}

void DrawSeries(const PlotSeries& series, Color color, const Axes& axes, const Panel& panel) {
  const double width = series.is_reference ? 2.5 : 1.5;
  std::vector<PlotPoint> line;
  for (const PlotPoint& point : series.points) {
    if (IsFinite(point)) {
      line.push_back({axes.X(point.x), axes.Y(point.y)});
    } else {
      panel.Polyline(Thinned(line), color, width);
      line.clear();
    }
  }
  panel.Polyline(Thinned(line), color, width);
  DrawErrorBars(series, color, axes, panel);
}

void Draw(const Plot& plot, const Panel& panel) {
  const Axes axes(plot);
  DrawFrame(plot, axes, panel);
  std::vector<Color> colors;
  size_t next = 0;
  for (const PlotSeries& series : plot.series) {
    colors.push_back(series.is_reference ? kReference : kColors[next++ % kColors.size()]);
  }
  for (const bool reference : {true, false}) {
    for (size_t i = 0; i < plot.series.size(); ++i) {
      if (plot.series[i].is_reference == reference) {
        DrawSeries(plot.series[i], colors[i], axes, panel);
      }
    }
  }
  constexpr double kLine = 18;
  const double height = kLine * static_cast<double>(plot.series.size());
  double y = plot.legend_at_bottom ? kHeight - kBottom - height + 6 : kTop + 16;
  for (size_t i = 0; i < plot.series.size(); ++i, y += kLine) {
    const double x = kWidth - kRight - 8;
    panel.Polyline({{x - 24, y - 4}, {x, y - 4}}, colors[i], 2.5);
    panel.Text({x - 30, y}, plot.series[i].label, TextAnchor::kEnd, kTextSize, colors[i], false);
  }
}

}  // namespace

std::vector<double> AxisTicks(double low, double high, int count) {
  CHECK_LT(low, high);
  CHECK_GT(count, 0);
  const double rough = (high - low) / count;
  const double power = std::pow(10.0, std::floor(std::log10(rough)));
  double step = 10 * power;
  for (const double factor : {1.0, 2.0, 5.0}) {
    if (factor * power >= rough) {
      step = factor * power;
      break;
    }
  }
  std::vector<double> ticks;
  const double first = std::ceil(low / step - 1e-9);
  const double last = std::floor(high / step + 1e-9);
  for (double i = first; i <= last; ++i) ticks.push_back(i == 0 ? 0.0 : i * step);
  return ticks;
}

void WritePlot(const std::string& path_without_extension, const Plot& plot) {
  WritePlotPage(path_without_extension, {plot}, 1);
}

void WritePlotPage(const std::string& path_without_extension,
                   const std::vector<Plot>& plots,
                   int columns) {
  CHECK_GT(columns, 0);
  const int rows = (static_cast<int>(plots.size()) + columns - 1) / columns;
  PlotCanvas canvas(columns * kWidth, rows * kHeight);
  for (int i = 0; i < static_cast<int>(plots.size()); ++i) {
    const int row = i / columns;
    const PlotPoint origin{static_cast<double>(i % columns * kWidth),
                           static_cast<double>(row * kHeight)};
    Draw(plots[i], Panel(origin, &canvas));
  }
  canvas.SavePdf(path_without_extension + ".pdf");
  canvas.SaveSvg(path_without_extension + ".svg");
  canvas.SavePng(path_without_extension + ".png");
}

}  // namespace prism
