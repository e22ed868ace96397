// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
#include "prism/report/plot_canvas.h"

#include <cmath>
#include <cstdio>

#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>

#include "prism/base/error.h"
#include "prism/io/atomic_file.h"

namespace prism {
namespace {

std::string Decimal(double value) {
  char text[32];
  std::snprintf(text, sizeof(text), "%.1f", value);
  return text;
}

std::string EscapedXml(const std::string& text) {
  std::string escaped;
  for (const char c : text) {
    if (c == '&') {
      escaped += "&amp;";
    } else if (c == '<') {
      escaped += "&lt;";
    } else if (c == '>') {
      escaped += "&gt;";
    } else {
      escaped += c;
    }
  }
  return escaped;
}

class SvgCanvas : public PlotCanvas {
 public:
  SvgCanvas(int width, int height) {
    const std::string size =
        "width=\"" + std::to_string(width) + "\" height=\"" + std::to_string(height) + "\"";
    body_ = "<svg xmlns=\"http://www.w3.org/2000/svg\" " + size + " viewBox=\"0 0 " +
            std::to_string(width) + " " + std::to_string(height) +
            "\" font-family=\"sans-serif\">\n<rect " + size + " fill=\"#fff\"/>\n";
  }

  void Polyline(const std::vector<PlotPoint>& points, Color color, double width) override {
    if (points.size() < 2) return;
    body_ += "<polyline fill=\"none\" stroke=\"" + Rgb(color) + "\" stroke-width=\"" +
             Decimal(width) + "\" stroke-linejoin=\"round\" points=\"";
    for (const PlotPoint& point : points) body_ += Decimal(point.x) + "," + Decimal(point.y) + " ";
    body_ += "\"/>\n";
  }

  void Text(PlotPoint baseline,
            const std::string& text,
            TextAnchor anchor,
            double size,
            Color color,
            bool vertical) override {
    static const char* const kAnchors[] = {"start", "middle", "end"};
    const std::string position = Decimal(baseline.x) + " " + Decimal(baseline.y);
    body_ += "<text transform=\"translate(" + position + ")" + (vertical ? " rotate(-90)" : "") +
             "\" text-anchor=\"" + kAnchors[static_cast<int>(anchor)] + "\" font-size=\"" +
             Decimal(size) + "\" fill=\"" + Rgb(color) + "\">" + EscapedXml(text) + "</text>\n";
  }

  void Save(const std::string& path) const override {
    WriteTextAtomically(path, body_ + "</svg>\n");
  }

 private:
  static std::string Rgb(Color color) {
    char text[32];
    std::snprintf(text, sizeof(text), "#%02x%02x%02x", color.red, color.green, color.blue);
    return text;
  }

  std::string body_;
};

class PngCanvas : public PlotCanvas {
 public:
  PngCanvas(int width, int height)
      : image_(height * kZoom, width * kZoom, CV_8UC3, cv::Scalar::all(255)) {}

  void Polyline(const std::vector<PlotPoint>& points, Color color, double width) override {
    std::vector<cv::Point> pixels;
    pixels.reserve(points.size());
    for (const PlotPoint& point : points) {
      pixels.emplace_back(Fixed(point.x), Fixed(point.y));
    }
    const int thickness = std::max(1, static_cast<int>(std::lround(width * kZoom)));
    cv::polylines(image_, pixels, false, Bgr(color), thickness, cv::LINE_AA, kShift);
  }

  void Text(PlotPoint baseline,
            const std::string& text,
            TextAnchor anchor,
            double size,
            Color color,
            bool vertical) override {
    constexpr int kFont = cv::FONT_HERSHEY_SIMPLEX;
    const double scale = size * kZoom / 30.0;  // capitals of this font are 21 px high
    const int thickness = size * kZoom > 25 ? 2 : 1;
    int below = 0;
    const cv::Size extent = cv::getTextSize(text, kFont, scale, thickness, &below);
    cv::Mat label(extent.height + 2 * below, extent.width + 2, CV_8UC3, cv::Scalar::all(255));
    const cv::Point origin(1, extent.height + below / 2);
    cv::putText(label, text, origin, kFont, scale, Bgr(color), thickness, cv::LINE_AA);
    const int shift = static_cast<int>(anchor) * extent.width / 2;
    cv::Point corner(static_cast<int>(baseline.x * kZoom) - shift,
                     static_cast<int>(baseline.y * kZoom) - origin.y);
    if (vertical) {
      cv::rotate(label, label, cv::ROTATE_90_COUNTERCLOCKWISE);
      corner = cv::Point(static_cast<int>(baseline.x * kZoom) - origin.y,
                         static_cast<int>(baseline.y * kZoom) - extent.width + shift);
    }
    // Darken only, so that a label's white does not erase what is drawn already.
    const cv::Rect whole(0, 0, image_.cols, image_.rows);
    const cv::Rect target = cv::Rect(corner, label.size()) & whole;
    if (target.empty()) return;
    cv::Mat region = image_(target);
    cv::min(region, label(target - corner), region);
  }

  void Save(const std::string& path) const override {
    WriteFileAtomically(path, [&](const std::string& temporary_path) {
      if (!cv::imwrite(temporary_path, image_)) {
        throw InputError(path, "an error on writing", "a folder that can be written");
      }
    });
  }

 private:
  static constexpr int kZoom = 2;
  static constexpr int kShift = 4;  // fractional bits of a coordinate

  static int Fixed(double x) { return static_cast<int>(std::lround(x * kZoom * (1 << kShift))); }
  static cv::Scalar Bgr(Color color) { return cv::Scalar(color.blue, color.green, color.red); }

  cv::Mat image_;
};

}  // namespace

std::unique_ptr<PlotCanvas> MakeSvgCanvas(int width, int height) {
  return std::make_unique<SvgCanvas>(width, height);
}

std::unique_ptr<PlotCanvas> MakePngCanvas(int width, int height) {
  return std::make_unique<PngCanvas>(width, height);
}

}  // namespace prism
