// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
#include "tools/calibration_report.h"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <sstream>

#include <nlohmann/json.hpp>

#include "prism/base/format.h"
#include "prism/base/version.h"
#include "prism/io/atomic_file.h"
#include "prism/report/plot.h"
#include "prism/report/report_page.h"
#include "prism/report/text_table.h"
#include "tools/tool_main.h"

namespace prism {
namespace {

using Rows = std::vector<std::vector<std::string>>;

std::string Number(double value, int digits) { return Format("%.*f", digits, value); }

// Lengths in mm, as camera files have them.
double InFileUnits(const NamedFigure& figure, double value) {
  return figure.unit == "m" ? 1e3 * value : value;
}

std::string FiguresTable(const CameraFigures& figures) {
  Rows rows = {{"", "value", "+-", ""}};
  for (const NamedFigure& figure : figures.figures) {
    if (figure.held && figure.value == 0) continue;
    const int digits = figure.unit == "m" ? 4 : figure.unit == "px" ? 1 : 3;
    rows.push_back({figure.name,
                    Number(InFileUnits(figure, figure.value), digits),
                    figure.held ? "held" : Number(InFileUnits(figure, figure.sigma), digits),
                    figure.unit == "m" ? "mm" : figure.unit});
  }
  return FormatColumns(rows);
}

std::vector<double> DistancesOf(const CalibrationResult& result) {
  double low = INFINITY, high = 0;
  for (const CalibratedView& view : result.summaries) {
    if (view.corners == 0) continue;
    low = std::min(low, view.distance_m);
    high = std::max(high, view.distance_m);
  }
  std::vector<double> distances;
  for (const double z : {0.1, 0.2, 0.3, 0.5, 0.7, 1.0, 1.5, 2.0, 3.0, 5.0, 7.0, 10.0, 20.0}) {
    if (z >= 0.7 * low && z <= 3 * high) distances.push_back(z);
  }
  return distances;
}

nlohmann::json ViewToJson(const CalibratedView& summary, const SE3& cam_from_board) {
  nlohmann::json view = {{"name", summary.name}, {"corners", nlohmann::json::array()}};
  if (summary.corners == 0) return view;
  const Eigen::Quaterniond q = cam_from_board.rotation();
  const Eigen::Vector3d t = cam_from_board.translation();
  view["rotation"] = {q.x(), q.y(), q.z(), q.w()};
  view["position"] = {t.x(), t.y(), t.z()};
  view["distance_m"] = summary.distance_m;
  view["tilt_deg"] = summary.tilt_deg;
  view["px_rms"] = summary.px_rms;
  view["inverse_depth_rms"] = summary.depth_rms;
  view["inverse_depth_offset"] = summary.depth_offset;
  for (const CornerResidual& r : summary.residuals) {
    view["corners"].push_back({{"corner", r.corner},
                               {"px", {r.px.x(), r.px.y()}},
                               {"residual", {r.residual.x(), r.residual.y()}},
                               {"inverse_depth_residual", r.inverse_depth_residual}});
  }
  return view;
}

nlohmann::json ToJson(const CalibrationBoard& board,
                      const CalibrationResult& result,
                      const CalibrationReport& report) {
  const PlenopticCamera& camera = result.camera;
  const double image_distance = camera.main_lens_mla_distance + camera.sensor_mla_distance;
  nlohmann::json json = {{"version", kVersion},
                         {"git_hash", GitRevision()},
                         {"options", EffectiveOptions()},
                         {"board",
                          {{"pattern", ToString(board.pattern)},
                           {"columns", board.columns},
                           {"rows", board.rows},
                           {"square_m", board.square_m}}},
                         {"raw_size", {camera.raw_width, camera.raw_height}},
                         {"half_view_tangents",
                          {0.5 * camera.raw_width * camera.raw_pixel_size / image_distance,
                           0.5 * camera.raw_height * camera.raw_pixel_size / image_distance}},
                         {"findings", result.findings},
                         {"corners", result.adjustment.corners},
                         {"px_rms", result.adjustment.px_rms},
                         {"inverse_depth_rms", result.adjustment.depth_rms},
                         {"inverse_depth_offset_sigma", result.noise.depth_offset_sigma},
                         {"left_out_rms_in_sigmas", report.left_out_rms_in_sigmas}};
  for (const NamedFigure& figure : report.figures.figures) {
    json["figures"].push_back({{"name", figure.name},
                               {"unit", figure.unit == "m" ? "mm" : figure.unit},
                               {"value", InFileUnits(figure, figure.value)},
                               {"sigma", InFileUnits(figure, figure.sigma)},
                               {"held", figure.held}});
  }
  const Eigen::MatrixXd& correlations = report.figures.correlations;
  for (Eigen::Index i = 0; i < correlations.rows(); ++i) {
    nlohmann::json row;
    for (Eigen::Index j = 0; j < correlations.cols(); ++j) row.push_back(correlations(i, j));
    json["correlations"].push_back(row);
  }
  for (size_t k = 0; k < result.views.size(); ++k) {
    json["views"].push_back(ViewToJson(result.summaries[k], result.state.cam_from_board[k]));
  }
  json["left_out"] = nlohmann::json::array();
  for (const LeftOutView& view : report.left_out) {
    json["left_out"].push_back({{"name", view.name},
                                {"distance_m", view.distance_m},
                                {"relative_error", view.relative_error},
                                {"sigma", view.sigma}});
  }
  for (const double z : DistancesOf(result)) {
    json["distance_sigma"].push_back(
        {{"distance_m", z}, {"relative_sigma", RelativeDistanceSigma(result, z)}});
  }
  return json;
}

// What was adjusted, for whoever wants to adjust it with something else.
std::string ObservationsCsv(const CalibrationResult& result) {
  std::ostringstream csv;
  csv.precision(10);
  csv << "view,corner,micro_image_x,micro_image_y,x,y,slope,px_sigma,slope_sigma\n";
  for (size_t k = 0; k < result.views.size(); ++k) {
    for (const CornerObservation& c : result.views[k].corners) {
      csv << k << "," << c.corner << "," << c.micro_image_px.x() << "," << c.micro_image_px.y()
          << "," << c.px.x() << "," << c.px.y() << "," << c.slope << "," << c.px_sigma << ","
          << c.slope_sigma << "\n";
    }
  }
  return csv.str();
}

Plot DistanceErrorPlot(const CalibrationResult& result, const CalibrationReport& report) {
  Plot plot;
  plot.title = "Distance by depth against distance by the board";
  plot.x_label = "distance, m";
  plot.y_label = "error, %";
  const PlotPoint gap = {NAN, NAN};
  PlotSeries errors;
  errors.label = "pictures left out";
  for (const LeftOutView& view : report.left_out) {
    errors.points.insert(errors.points.end(), {{view.distance_m, 100 * view.relative_error}, gap});
    errors.y_errors.insert(errors.y_errors.end(), {100 * view.sigma, 0});
  }
  PlotSeries calibration;
  calibration.label = "calibration, 1 sigma";
  calibration.is_reference = true;
  for (const double sign : {1.0, -1.0}) {
    for (const double z : DistancesOf(result)) {
      calibration.points.push_back({z, sign * 100 * RelativeDistanceSigma(result, z)});
    }
    calibration.points.push_back(gap);
  }
  plot.series = {calibration, errors};
  return plot;
}

}  // namespace

CalibrationReport MakeCalibrationReport(const CalibrationBoard& board,
                                        const CalibrationResult& result) {
  CalibrationReport report;
  std::ostringstream text;
  Rows rows = {{"picture", "corners", "m", "tilt", "px rms", "1/v rms", "offset"}};
  for (const CalibratedView& view : result.summaries) {
    rows.push_back({view.name,
                    std::to_string(view.corners),
                    Number(view.distance_m, 3),
                    Number(view.tilt_deg, 0),
                    Number(view.px_rms, 3),
                    Number(view.depth_rms, 5),
                    Number(view.depth_offset, 5)});
  }
  text << FormatColumns(rows);
  for (const std::string& finding : result.findings) text << finding << "\n";
  if (!result.problem.empty() || !result.adjustment.covariance) {
    report.text = text.str();
    return report;
  }
  report.figures = FiguresOf(result);
  report.left_out = LeaveOneOut(board, result);
  text << FiguresTable(report.figures);
  text << "corners " << result.adjustment.corners << ", RMS " << Number(result.adjustment.px_rms, 3)
       << " raw px and " << Number(result.adjustment.depth_rms, 5)
       << " of 1/v; a picture's depths share an error of "
       << Number(result.noise.depth_offset_sigma, 5) << "\n";
  Rows error_rows = {{"left out", "m by the board", "error by depth, %", "stated, %"}};
  double squares = 0;
  for (const LeftOutView& view : report.left_out) {
    error_rows.push_back({view.name,
                          Number(view.distance_m, 3),
                          Number(100 * view.relative_error, 2),
                          Number(100 * view.sigma, 2)});
    squares += std::pow(view.relative_error / view.sigma, 2);
  }
  text << FormatColumns(error_rows);
  if (!report.left_out.empty()) {
    report.left_out_rms_in_sigmas = std::sqrt(squares / report.left_out.size());
    text << "RMS of error over stated: " << Number(report.left_out_rms_in_sigmas, 2) << "\n";
  }
  Rows distance_rows = {{"distance, m", "of the calibration, %"}};
  for (const double z : DistancesOf(result)) {
    distance_rows.push_back({Number(z, 1), Number(100 * RelativeDistanceSigma(result, z), 2)});
  }
  text << FormatColumns(distance_rows);
  report.text = text.str();
  return report;
}

void WriteCalibrationReport(const std::string& folder,
                            const CalibrationBoard& board,
                            const CalibrationResult& result,
                            const CalibrationReport& report) {
  const std::filesystem::path output(folder);
  const nlohmann::json json = ToJson(board, result, report);
  WriteTextAtomically((output / "calibration.json").string(), json.dump(1) + "\n");
  WriteTextAtomically((output / "observations.csv").string(), ObservationsCsv(result));
  WritePlot((output / "distance_error").string(), DistanceErrorPlot(result, report));
  WriteTextAtomically((output / "report.html").string(), PageWithData(kCalibrationPage, json));
}

}  // namespace prism
