// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
#include "prism/report/plot_canvas.h"

#include <algorithm>
#include <cmath>

#include <cairo-pdf.h>
#include <cairo-svg.h>
#include <cairo.h>
#include <glog/logging.h>

#include "prism/base/error.h"
#include "prism/io/atomic_file.h"

namespace prism {
namespace {

constexpr int kPngZoom = 2;
constexpr size_t kStrokePoints = 100;  // at once

void SetColor(cairo_t* context, Color color) {
  cairo_set_source_rgb(context, color.red / 255.0, color.green / 255.0, color.blue / 255.0);
}

// Paints the recording on a surface, which is finished and given back. `zoom`: of a unit.
cairo_status_t PaintOn(cairo_surface_t* surface,
                       cairo_surface_t* recording,
                       double zoom,
                       const char* png_path = nullptr) {
  cairo_t* const context = cairo_create(surface);
  cairo_scale(context, zoom, zoom);
  cairo_set_source_surface(context, recording, 0, 0);
  cairo_paint(context);
  cairo_status_t status = cairo_status(context);
  cairo_destroy(context);
  if (status == CAIRO_STATUS_SUCCESS && png_path != nullptr) {
    status = cairo_surface_write_to_png(surface, png_path);
  }
  cairo_surface_finish(surface);
  if (status == CAIRO_STATUS_SUCCESS) status = cairo_surface_status(surface);
  cairo_surface_destroy(surface);
  return status;
}

void RequireSuccess(cairo_status_t status, const std::string& path) {
  if (status == CAIRO_STATUS_SUCCESS) return;
  throw InputError(path, cairo_status_to_string(status), "a file that can be written");
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

// A cairo_write_func_t; `text` is a std::string.
cairo_status_t Append(void* text, const unsigned char* bytes, unsigned int count) {
  static_cast<std::string*>(text)->append(reinterpret_cast<const char*>(bytes), count);
  return CAIRO_STATUS_SUCCESS;
}

// Puts the texts of a drawing into its SVG.
void AddDescription(const std::vector<std::string>& texts, std::string* svg) {
  std::string description = "\n<desc>";
  for (const std::string& text : texts) description += EscapedXml(text) + "\n";
  const size_t root = svg->find("<svg");
  CHECK_NE(root, std::string::npos);
  svg->insert(svg->find('>', root) + 1, description + "</desc>");
}

}  // namespace

struct PlotCanvas::Drawing {
  int width, height;
  cairo_surface_t* recording;
  cairo_t* context;
  std::vector<std::string> texts;
};

PlotCanvas::PlotCanvas(int width, int height) {
  const cairo_rectangle_t extents = {0, 0, static_cast<double>(width), static_cast<double>(height)};
  cairo_surface_t* const recording =
      cairo_recording_surface_create(CAIRO_CONTENT_COLOR_ALPHA, &extents);
  drawing_ =
      std::make_unique<Drawing>(Drawing{width, height, recording, cairo_create(recording), {}});
  cairo_t* const context = drawing_->context;
  SetColor(context, {255, 255, 255});
  cairo_paint(context);
  cairo_set_line_join(context, CAIRO_LINE_JOIN_ROUND);
  cairo_select_font_face(context, "sans-serif", CAIRO_FONT_SLANT_NORMAL, CAIRO_FONT_WEIGHT_NORMAL);
}

PlotCanvas::~PlotCanvas() {
  cairo_destroy(drawing_->context);
  // Cairo 1.16 never lets go of what was painted on an SVG surface; this frees what is in it.
  cairo_surface_finish(drawing_->recording);
  cairo_surface_destroy(drawing_->recording);
}

void PlotCanvas::Polyline(const std::vector<PlotPoint>& points, Color color, double width) {
  cairo_t* const context = drawing_->context;
  SetColor(context, color);
  cairo_set_line_width(context, width);
  cairo_new_path(context);  // text leaves a point behind
  // Piece by piece: the time of a stroke rises with the square of what crosses itself in it. Pieces
  // share a segment, so that the joint is drawn.
  for (size_t begin = 0; begin + 1 < points.size(); begin += kStrokePoints - 2) {
    const size_t end = std::min(begin + kStrokePoints, points.size());
    for (size_t i = begin; i < end; ++i) cairo_line_to(context, points[i].x, points[i].y);
    cairo_stroke(context);
    if (end == points.size()) break;
  }
}

void PlotCanvas::Text(PlotPoint baseline,
                      const std::string& text,
                      TextAnchor anchor,
                      double size,
                      Color color,
                      bool vertical) {
  cairo_t* const context = drawing_->context;
  cairo_save(context);
  cairo_set_font_size(context, size);
  cairo_text_extents_t extents;
  cairo_text_extents(context, text.c_str(), &extents);
  cairo_translate(context, baseline.x, baseline.y);
  if (vertical) cairo_rotate(context, -M_PI / 2);
  cairo_move_to(context, -0.5 * static_cast<int>(anchor) * extents.x_advance, 0);
  SetColor(context, color);
  cairo_show_text(context, text.c_str());
  drawing_->texts.push_back(text);
  cairo_restore(context);
}

void PlotCanvas::SavePdf(const std::string& path) const {
  WriteFileAtomically(path, [&](const std::string& temporary_path) {
    cairo_surface_t* const surface =
        cairo_pdf_surface_create(temporary_path.c_str(), drawing_->width, drawing_->height);
    RequireSuccess(PaintOn(surface, drawing_->recording, 1), path);
  });
}

void PlotCanvas::SaveSvg(const std::string& path) const {
  std::string svg;
  cairo_surface_t* const surface =
      cairo_svg_surface_create_for_stream(Append, &svg, drawing_->width, drawing_->height);
  cairo_svg_surface_set_document_unit(surface, CAIRO_SVG_UNIT_PX);
  RequireSuccess(PaintOn(surface, drawing_->recording, 1), path);
  AddDescription(drawing_->texts, &svg);
  WriteTextAtomically(path, svg);
}

void PlotCanvas::SavePng(const std::string& path) const {
  WriteFileAtomically(path, [&](const std::string& temporary_path) {
    cairo_surface_t* const surface = cairo_image_surface_create(
        CAIRO_FORMAT_RGB24, kPngZoom * drawing_->width, kPngZoom * drawing_->height);
    RequireSuccess(PaintOn(surface, drawing_->recording, kPngZoom, temporary_path.c_str()), path);
  });
}

}  // namespace prism
