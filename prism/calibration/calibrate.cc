// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
#include "prism/calibration/calibrate.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "prism/base/format.h"
#include "prism/calibration/calibration_start.h"

namespace prism {
namespace {

// Beyond these the pictures do not determine a figure.
constexpr double kLargestFocalSigma = 0.02;      // of f_L
constexpr double kLargestSensorSigma = 0.05;     // of B
constexpr double kLargestPrincipalSigma = 0.02;  // of the image width
// Distortion is carried by the data where its standard deviation is a displacement of so many raw
// px at the rim of the image, and that of the principal point beside it so many.
constexpr double kCarriedSigma = 0.5;
constexpr double kPrincipalCarriedSigma = 0.005;  // of the image width
// Of B: no focus ring and no temperature change it by so much.
constexpr double kOtherB = 0.02;
constexpr double kOtherBSigmas = 5;
constexpr double kMostStrangers = 0.2;  // of the pictures: more are a mixture
constexpr double kOutlier = 6;          // standard deviations
constexpr double kSmallestPxScale = 1;  // for that test, of the stated deviation of a corner

class Calibration {
 public:
  Calibration(const CalibrationBoard& board,
              std::vector<BoardView> views,
              const PlenopticCamera& start,
              const CalibrateOptions& options)
      : board_(board), start_(start), options_(options), fixed_(start) {
    result_.views = std::move(views);
    result_.noise = CalibrationNoise(result_.views.size());
    result_.camera = start;
  }

  CalibrationResult Run() {
    LeaveOutStrangers();
    if (!result_.problem.empty()) return result_;
    const size_t pictures = CountViews();
    const auto state =
        StartCalibration(board_, start_, options_.hold_sensor_distance, &result_.views);
    if (CountViews() < pictures) {
      result_.findings.push_back(Format("%.0f of %.0f pictures show too little of the board",
                                        static_cast<double>(pictures - CountViews()),
                                        static_cast<double>(pictures)));
    }
    if (!state) {
      result_.problem =
          "no camera explains the corners and their depths: is it the right board, are squares of "
          "the size given, is the focal length right?";
      return result_;
    }
    result_.state = *state;
    Settle();
    if (result_.problem.empty()) ChooseDistortion();
    CompareSensorDistance();
    Finish();
    return result_;
  }

 private:
  size_t CountViews() const {
    return std::count_if(result_.views.begin(), result_.views.end(), [](const BoardView& view) {
      return !view.corners.empty();
    });
  }

  // Pictures of another camera, or with another focus: a few are left out, more are a problem.
  void LeaveOutStrangers() {
    const std::vector<int> strangers = FindStrangers(board_, start_, result_.views);
    if (strangers.empty()) return;
    std::string names;
    for (const int k : strangers) {
      names += (names.empty() ? "" : ", ") + result_.views[k].name;
    }
    const std::string found = Format(
        "depths and distances of %zu of %zu pictures do not fit those of the others (%s): "
        "they are of another camera, or focus, zoom or aperture were not the same",
        strangers.size(),
        CountViews(),
        names.c_str());
    if (static_cast<double>(strangers.size()) > kMostStrangers * CountViews()) {
      result_.problem = found;
      return;
    }
    result_.findings.push_back("left out: " + found);
    for (const int k : strangers) result_.views[k].corners.clear();
  }

  void Adjust() {
    AdjustmentOptions options;
    options.held = result_.held;
    result_.adjustment =
        AdjustCalibration(board_, result_.views, fixed_, options, &result_.noise, &result_.state);
  }

  double Sigma(CameraParameter parameter) const {
    const auto& covariance = result_.adjustment.covariance;
    return covariance ? std::sqrt((*covariance)(parameter, parameter)) : INFINITY;
  }

  // f_L, b_L0, B and principal point; what the pictures do not tell is held.
  void Settle() {
    ParameterFlags& held = result_.held;
    for (int i = kRadial0; i <= kTangential1; ++i) held[i] = true;
    held[kSensorDistance] = options_.hold_sensor_distance;
    held[kFocalLength] = held[kPrincipalX] = held[kPrincipalY] = true;
    Adjust();
    ChoosePoses();
    RemoveOutliers();
    held[kFocalLength] = options_.hold_focal_length;
    Adjust();
    ChoosePoses();
    Adjust();
    RemoveOutliers();
    HoldFocalLengthIfUnknown();
    held[kPrincipalX] = held[kPrincipalY] = false;
    const CalibrationState before = result_.state;
    Adjust();
    HoldFocalLengthIfUnknown();
    const double largest = kLargestPrincipalSigma * start_.raw_width;
    const double sigma = std::max(Sigma(kPrincipalX), Sigma(kPrincipalY));
    if (!(sigma <= largest)) {
      held[kPrincipalX] = held[kPrincipalY] = true;
      result_.state = before;
      result_.state.camera[kPrincipalX] = start_.raw_principal_point.x();
      result_.state.camera[kPrincipalY] = start_.raw_principal_point.y();
      result_.findings.push_back(
          Format("principal point held: the pictures tell it to %.0f px only; tilted boards near "
                 "the rims of the image would",
                 sigma));
      Adjust();
    }
    CheckDistances();
  }

  // A flat board seen from afar looks nearly the same when it is tilted the other way: of both
  // poses the one that fits better.
  void ChoosePoses() {
    for (size_t k = 0; k < result_.views.size(); ++k) {
      if (result_.views[k].corners.empty()) continue;
      const SE3 pose = result_.state.cam_from_board[k];
      const Eigen::Vector3d middle = MiddleOfCorners(board_, result_.views[k]);
      const Eigen::Vector3d at = pose * middle;
      const Eigen::Quaterniond half_turn(Eigen::AngleAxisd(M_PI, Eigen::Vector3d::UnitZ()));
      const Eigen::Quaterniond rotation =
          Eigen::Quaterniond(Eigen::AngleAxisd(M_PI, at.normalized())) * pose.rotation() *
          half_turn;
      const SE3 other(rotation, at - rotation * middle);
      CalibrationState as_is = result_.state, tilted = result_.state;
      tilted.cam_from_board[k] = other;
      if (CostOfView(k, &tilted) < CostOfView(k, &as_is)) result_.state = tilted;
    }
  }

  // With the camera held.
  double CostOfView(size_t k, CalibrationState* state) {
    std::vector<BoardView> alone(result_.views.size());
    alone[k] = result_.views[k];
    AdjustmentOptions options;
    options.held.fill(true);
    options.estimate_noise = false;
    CalibrationNoise noise = result_.noise;
    return AdjustCalibration(board_, alone, fixed_, options, &noise, state).cost;
  }

  void HoldFocalLengthIfUnknown() {
    if (result_.held[kFocalLength] || !result_.problem.empty()) return;
    const double relative = Sigma(kFocalLength) / result_.state.camera[kFocalLength];
    if (relative <= kLargestFocalSigma) return;
    const std::string found = Format(
        "the pictures tell f_L to %.1f %% only: boards tilted by 30 to 45 degrees, in "
        "several directions and near, would tell it",
        100 * std::min(relative, 9.99));
    if (!options_.focal_length_is_known) {
      result_.problem = found + "; or give the focal length engraved on the lens";
      return;
    }
    result_.findings.push_back("f_L held: " + found);
    result_.held[kFocalLength] = true;
    result_.state.camera[kFocalLength] = start_.focal_length;
    result_.held[kPrincipalX] = result_.held[kPrincipalY] = true;
    Restart();
  }

  // From the start with what is held now: a figure that ran away took the poses with it.
  void Restart() {
    result_.noise = CalibrationNoise(result_.views.size());
    const auto state =
        StartCalibration(board_, start_, options_.hold_sensor_distance, &result_.views);
    if (state) result_.state = *state;
    Adjust();
  }

  void CheckDistances() {
    if (result_.held[kSensorDistance] || !result_.problem.empty()) return;
    const double relative = Sigma(kSensorDistance) / result_.state.camera[kSensorDistance];
    if (relative <= kLargestSensorSigma) return;
    double low = INFINITY, high = 0;
    for (size_t k = 0; k < result_.views.size(); ++k) {
      if (result_.views[k].corners.empty()) continue;
      const double z = DistanceOf(k);
      low = std::min(low, z);
      high = std::max(high, z);
    }
    result_.problem =
        Format("the pictures tell b_L0 and B apart to %.0f %% only, ",
               100 * std::min(relative, 9.99)) +
        Format(
            "with boards at %.2f to %.2f m: boards at half and twice these distances would; or "
            "hold B at a value that is known",
            low,
            high);
  }

  // Coefficients are added as long as the pictures tell them.
  void ChooseDistortion() {
    const auto free = [&](std::initializer_list<CameraParameter> parameters, bool flag) {
      for (const CameraParameter p : parameters) result_.held[p] = !flag;
    };
    switch (options_.distortion) {
      case DistortionModel::kNone:
        return;
      case DistortionModel::kRadial:
        free({kRadial0, kRadial1}, true);
        Adjust();
        return;
      case DistortionModel::kFull:
        free({kRadial0, kRadial1, kTangential0, kTangential1}, true);
        Adjust();
        return;
      case DistortionModel::kAuto:
        break;
    }
    const std::vector<std::vector<CameraParameter>> steps = {
        {kRadial0}, {kTangential0, kTangential1}, {kRadial1}};
    for (const auto& step : steps) {
      const CalibrationResult before = result_;
      for (const CameraParameter p : step) result_.held[p] = false;
      Adjust();
      if (!Carries(step)) result_ = before;
    }
  }

  // Whether the pictures tell coefficients that were just set free. Those they do tell stay free
  // even where they are near 0: held, they would bend the other figures. A1 too small to be seen
  // puts A0 off by ten times what is stated.
  bool Carries(const std::vector<CameraParameter>& coefficients) const {
    const double rim = 0.5 * start_.raw_width * start_.raw_pixel_size;
    const double largest = kCarriedSigma * start_.raw_pixel_size;
    for (const CameraParameter p : coefficients) {
      if (p == kRadial0 && !(Sigma(p) * std::pow(rim, 3) < largest)) return false;
      if (p == kRadial1 && !(Sigma(p) * std::pow(rim, 5) < largest)) return false;
    }
    // Tangential distortion and the principal point stand for each other in narrow views.
    return result_.held[kPrincipalX] || std::max(Sigma(kPrincipalX), Sigma(kPrincipalY)) <
                                            kPrincipalCarriedSigma * start_.raw_width;
  }

  void RemoveOutliers() {
    int removed = 0;
    for (size_t k = 0; k < result_.views.size(); ++k) {
      auto& corners = result_.views[k].corners;
      const auto is_outlier = [&](const CornerObservation& corner) {
        const Eigen::Vector3d r = Residuals(k, corner);
        const double px_sigma =
            std::max(kSmallestPxScale, result_.noise.px_scale[k]) * corner.px_sigma;
        const double slope_sigma = result_.noise.slope_scale[k] * corner.slope_sigma;
        return !(r.head<2>().norm() < kOutlier * px_sigma &&
                 std::abs(r[2]) < kOutlier * slope_sigma);
      };
      const auto kept = std::remove_if(corners.begin(), corners.end(), is_outlier);
      removed += static_cast<int>(corners.end() - kept);
      corners.erase(kept, corners.end());
    }
    if (removed > 0) {
      result_.findings.push_back(Format("%.0f corners left out as outliers", removed));
      Adjust();
    }
  }

  // px (2) and slope, predicted minus observed.
  Eigen::Vector3d Residuals(size_t k, const CornerObservation& corner) const {
    const Eigen::Vector3d x_C =
        result_.state.cam_from_board[k] * board_.CornerPosition(corner.corner);
    RawAppearance<double> appearance;
    if (!Appear(fixed_, result_.state.camera.data(), x_C, &appearance)) {
      return Eigen::Vector3d::Constant(INFINITY);
    }
    const double slope = appearance.Slope(0);
    Eigen::Vector3d r;
    r.head<2>() = (1 - slope) * appearance.chief_px + slope * corner.micro_image_px - corner.px;
    r[2] = appearance.Slope(fixed_.sign * result_.state.depth_offsets[k]) - corner.slope;
    return r;
  }

  void CompareSensorDistance() {
    if (!options_.sensor_distance_is_known || result_.held[kSensorDistance]) return;
    const double ratio = result_.state.camera[kSensorDistance] / start_.sensor_mla_distance;
    const double sigma = Sigma(kSensorDistance) / result_.state.camera[kSensorDistance];
    if (!(std::abs(ratio - 1) > std::max(kOtherB, kOtherBSigmas * sigma))) return;
    result_.findings.push_back(
        Format("B is %.1f %% %s than that of the camera it started with: if that is right, squares "
               "are %.2f mm wide, not %.2f",
               100 * std::abs(ratio - 1),
               ratio > 1 ? "larger" : "smaller",
               1e3 * board_.square_m * ratio,
               1e3 * board_.square_m));
  }

  double DistanceOf(size_t k) const {
    return (result_.state.cam_from_board[k] * MiddleOfCorners(board_, result_.views[k])).z();
  }

  void Finish() {
    result_.camera = WithParameters(start_, result_.state.camera);
    if (result_.problem.empty() && !result_.adjustment.covariance) {
      result_.problem = "the pictures do not determine the camera";
    }
    std::string error;
    if (result_.problem.empty() && !result_.camera.HasMetricDepth(&error)) {
      result_.problem = "the camera found makes no sense: " + error;
    }
    for (size_t k = 0; k < result_.views.size(); ++k) {
      const BoardView& view = result_.views[k];
      CalibratedView summary;
      summary.name = view.name;
      summary.corners = static_cast<int>(view.corners.size());
      if (!view.corners.empty()) {
        summary.distance_m = DistanceOf(k);
        const Eigen::Matrix3d R = result_.state.cam_from_board[k].RotationMatrix();
        summary.tilt_deg = std::acos(std::min(1.0, std::abs(R(2, 2)))) * 180 / M_PI;
        summary.depth_offset = result_.state.depth_offsets[k];
        double px = 0, slope = 0;
        for (const CornerObservation& corner : view.corners) {
          const Eigen::Vector3d r = Residuals(k, corner);
          summary.residuals.push_back({corner.corner, corner.px, r.head<2>(), -fixed_.sign * r[2]});
          px += r.head<2>().squaredNorm();
          slope += r[2] * r[2];
        }
        summary.px_rms = std::sqrt(px / summary.corners);
        summary.depth_rms = std::sqrt(slope / summary.corners);
      }
      result_.summaries.push_back(summary);
    }
  }

  const CalibrationBoard& board_;
  const PlenopticCamera& start_;
  const CalibrateOptions& options_;
  FixedFigures fixed_;
  CalibrationResult result_;
};

}  // namespace

bool ParseDistortionModel(const std::string& text, DistortionModel* model) {
  const std::pair<const char*, DistortionModel> models[] = {{"auto", DistortionModel::kAuto},
                                                            {"none", DistortionModel::kNone},
                                                            {"radial", DistortionModel::kRadial},
                                                            {"full", DistortionModel::kFull}};
  for (const auto& [name, value] : models) {
    if (text != name) continue;
    *model = value;
    return true;
  }
  return false;
}

CalibrationResult Calibrate(const CalibrationBoard& board,
                            std::vector<BoardView> views,
                            const PlenopticCamera& start,
                            const CalibrateOptions& options) {
  return Calibration(board, std::move(views), start, options).Run();
}

}  // namespace prism
