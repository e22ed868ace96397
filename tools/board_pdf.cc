// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
#include "tools/board_pdf.h"

#include <algorithm>
#include <cstdio>
#include <filesystem>

#include <cairo-pdf.h>
#include <opencv2/core.hpp>

#include "prism/base/error.h"

namespace prism {
namespace {

constexpr double kPointsPerMm = 72 / 25.4;
constexpr double kFooterMm = 14;
constexpr double kRulerMm = 100;

// Runs of black cells as rectangles, so that edges are exact at any resolution.
void DrawCells(const cv::Mat& cells, double left_mm, double top_mm, double cell_mm, cairo_t* page) {
  for (int y = 0; y < cells.rows; ++y) {
    for (int x = 0; x < cells.cols;) {
      int end = x;
      while (end < cells.cols && cells.at<uint8_t>(y, end) == 0) ++end;
      if (end > x) {
        cairo_rectangle(
            page, left_mm + x * cell_mm, top_mm + y * cell_mm, (end - x) * cell_mm, cell_mm);
      }
      x = std::max(end, x + 1);
    }
  }
  cairo_fill(page);
}

void DrawFooter(const CalibrationBoard& board, double left_mm, double baseline_mm, cairo_t* page) {
  char text[200];
  std::snprintf(text,
                sizeof(text),
                "%s, %dx%d squares of %g mm. Print at 100 %%; measure a row before use. 100 mm:",
                ToString(board.pattern),
                board.columns,
                board.rows,
                1e3 * board.square_m);
  cairo_select_font_face(page, "sans-serif", CAIRO_FONT_SLANT_NORMAL, CAIRO_FONT_WEIGHT_NORMAL);
  cairo_set_font_size(page, 3);
  cairo_move_to(page, left_mm, baseline_mm);
  cairo_show_text(page, text);
  cairo_set_line_width(page, 0.2);
  const double y = baseline_mm + 4;
  cairo_move_to(page, left_mm, y);
  cairo_line_to(page, left_mm + kRulerMm, y);
  for (int mm = 0; mm <= kRulerMm; mm += 10) {
    cairo_move_to(page, left_mm + mm, y - 1);
    cairo_line_to(page, left_mm + mm, y + 1);
  }
  cairo_stroke(page);
}

}  // namespace

void WriteBoardPdf(const std::string& path, const CalibrationBoard& board) {
  const double square_mm = 1e3 * board.square_m;
  const double margin_mm = std::max(square_mm / 2, 10.0);
  const double width_mm = std::max(board.columns * square_mm, kRulerMm) + 2 * margin_mm;
  const double height_mm = board.rows * square_mm + 2 * margin_mm + kFooterMm;
  const std::string temporary = path + ".tmp";
  cairo_surface_t* const surface = cairo_pdf_surface_create(
      temporary.c_str(), width_mm * kPointsPerMm, height_mm * kPointsPerMm);
  cairo_t* const page = cairo_create(surface);
  cairo_scale(page, kPointsPerMm, kPointsPerMm);
  DrawCells(DrawBoard(board, kBoardCellsPerSquare, 0),
            margin_mm,
            margin_mm,
            square_mm / kBoardCellsPerSquare,
            page);
  DrawFooter(board, margin_mm, height_mm - margin_mm / 2 - 4, page);
  cairo_destroy(page);
  cairo_surface_finish(surface);
  const cairo_status_t status = cairo_surface_status(surface);
  cairo_surface_destroy(surface);
  std::error_code error;
  if (status == CAIRO_STATUS_SUCCESS) std::filesystem::rename(temporary, path, error);
  if (status != CAIRO_STATUS_SUCCESS || error) {
    std::filesystem::remove(temporary, error);
    throw InputError(path, cairo_status_to_string(status), "a file that can be written");
  }
}

}  // namespace prism
