// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
#include "prism/calibration/bundle_adjustment.h"

#include <algorithm>
#include <cmath>

#include <ceres/ceres.h>
#include <Eigen/Eigenvalues>
#include <Eigen/SparseCore>

#include "prism/geometry/se3_manifold.h"

namespace prism {
namespace {

constexpr double kHuber = 2;  // standard deviations
constexpr int kNoiseRounds = 10;
constexpr double kSettled = 0.03;  // relative change of a standard deviation
// Of 1/v. Rendered boards, whose truth is known, share errors of this size; where few views or
// noise hide them they are there all the same.
constexpr double kSmallestOffsetSigma = 6e-5;

// Residuals of one corner: position, or slope. Blocks: camera, pose (7), depth offset.
class CornerCost {
 public:
  CornerCost(const FixedFigures& fixed,
             const Eigen::Vector3d& corner,
             const CornerObservation& observation,
             double px_scale,
             double slope_scale)
      : fixed_(fixed),
        corner_(corner),
        observation_(observation),
        px_sigma_(px_scale * observation.px_sigma),
        slope_sigma_(slope_scale * observation.slope_sigma) {}

  template <typename T>
  bool operator()(const T* camera, const T* pose, const T* offset, T* residuals) const {
    const Eigen::Map<const Eigen::Quaternion<T>> rotation(pose);
    const Eigen::Map<const Eigen::Matrix<T, 3, 1>> translation(pose + 4);
    const Eigen::Matrix<T, 3, 1> x_C = rotation * corner_.cast<T>() + translation;
    RawAppearance<T> appearance;
    if (!Appear(fixed_, camera, x_C, &appearance)) return false;
    const T slope = appearance.Slope(T(0.0));
    for (int i = 0; i < 2; ++i) {
      const T px = (1.0 - slope) * appearance.chief_px[i] + slope * observation_.micro_image_px[i];
      residuals[i] = (px - observation_.px[i]) / px_sigma_;
    }
    residuals[2] = (appearance.Slope(fixed_.sign * offset[0]) - observation_.slope) / slope_sigma_;
    return true;
  }

 private:
  FixedFigures fixed_;
  Eigen::Vector3d corner_;
  CornerObservation observation_;
  double px_sigma_, slope_sigma_;
};

// The residuals of a CornerCost from `first` on, `count` of them: a gross error of a position does
// not take the slope with it.
template <int first, int count>
class PartOfCorner {
 public:
  explicit PartOfCorner(const CornerCost& cost) : cost_(cost) {}
  template <typename T>
  bool operator()(const T* camera, const T* pose, const T* offset, T* residuals) const {
    T all[3];
    if (!cost_(camera, pose, offset, all)) return false;
    for (int i = 0; i < count; ++i) residuals[i] = all[first + i];
    return true;
  }

  static void AddTo(const CornerCost& cost,
                    double* camera,
                    double* pose,
                    double* offset,
                    ceres::Problem* problem) {
    problem->AddResidualBlock(
        new ceres::AutoDiffCostFunction<PartOfCorner, count, kNumCameraParameters, 7, 1>(
            new PartOfCorner(cost)),
        new ceres::HuberLoss(kHuber),
        camera,
        pose,
        offset);
  }

 private:
  CornerCost cost_;
};

class OffsetCost {
 public:
  explicit OffsetCost(double sigma) : inverse_sigma_(1 / sigma) {}
  template <typename T>
  bool operator()(const T* offset, T* residuals) const {
    residuals[0] = offset[0] * inverse_sigma_;
    return true;
  }

 private:
  double inverse_sigma_;
};

void Build(const CalibrationBoard& board,
           const std::vector<BoardView>& views,
           const FixedFigures& fixed,
           const AdjustmentOptions& options,
           const CalibrationNoise& noise,
           CalibrationState* state,
           ceres::Problem* problem) {
  problem->AddParameterBlock(state->camera.data(), kNumCameraParameters);
  std::vector<int> held;
  for (int i = 0; i < kNumCameraParameters; ++i) {
    if (options.held[i]) held.push_back(i);
  }
  if (held.size() == kNumCameraParameters) {
    problem->SetParameterBlockConstant(state->camera.data());
  } else if (!held.empty()) {
    problem->SetManifold(state->camera.data(),
                         new ceres::SubsetManifold(kNumCameraParameters, held));
  }
  for (size_t k = 0; k < views.size(); ++k) {
    if (views[k].corners.empty()) continue;
    double* const pose = state->cam_from_board[k].data();
    double* const offset = &state->depth_offsets[k];
    problem->AddParameterBlock(pose, 7, new SE3Manifold);
    for (const CornerObservation& observation : views[k].corners) {
      const CornerCost cost(fixed,
                            board.CornerPosition(observation.corner),
                            observation,
                            noise.px_scale[k],
                            noise.slope_scale[k]);
      PartOfCorner<0, 2>::AddTo(cost, state->camera.data(), pose, offset, problem);
      PartOfCorner<2, 1>::AddTo(cost, state->camera.data(), pose, offset, problem);
    }
    problem->AddResidualBlock(
        new ceres::AutoDiffCostFunction<OffsetCost, 1, 1>(new OffsetCost(noise.depth_offset_sigma)),
        nullptr,
        offset);
  }
}

// Sums of squared normalised residuals of a view, each weighted as the loss weights it.
struct ViewResiduals {
  double px_squares = 0, px_weights = 0;
  double slope_squares = 0, slope_weights = 0;
  double px_raw_squares = 0, depth_squares = 0;
  int corners = 0;
};

std::vector<ViewResiduals> Evaluate(const CalibrationBoard& board,
                                    const std::vector<BoardView>& views,
                                    const FixedFigures& fixed,
                                    const CalibrationNoise& noise,
                                    const CalibrationState& state) {
  std::vector<ViewResiduals> all(views.size());
  for (size_t k = 0; k < views.size(); ++k) {
    ViewResiduals& sums = all[k];
    for (const CornerObservation& observation : views[k].corners) {
      const CornerCost cost(fixed,
                            board.CornerPosition(observation.corner),
                            observation,
                            noise.px_scale[k],
                            noise.slope_scale[k]);
      double r[3];
      if (!cost(state.camera.data(), state.cam_from_board[k].data(), &state.depth_offsets[k], r)) {
        continue;
      }
      const double px = std::hypot(r[0], r[1]);
      const double px_weight = std::min(1.0, kHuber / std::max(px, 1e-12));
      const double slope_weight = std::min(1.0, kHuber / std::max(std::abs(r[2]), 1e-12));
      sums.px_squares += px_weight * px * px;
      sums.px_weights += 2 * px_weight;
      sums.slope_squares += slope_weight * r[2] * r[2];
      sums.slope_weights += slope_weight;
      const double px_sigma = noise.px_scale[k] * observation.px_sigma;
      const double slope_sigma = noise.slope_scale[k] * observation.slope_sigma;
      sums.px_raw_squares += px * px * px_sigma * px_sigma;
      sums.depth_squares += r[2] * r[2] * slope_sigma * slope_sigma;
      ++sums.corners;
    }
  }
  return all;
}

// The covariance of the camera parameters, and the variances of the depth offsets: the inverse of
// the Gauss-Newton information, made well conditioned by its diagonal. Nothing if it has none.
std::optional<Eigen::Matrix<double, kNumCameraParameters, kNumCameraParameters>> Covariance(
    const std::vector<BoardView>& views,
    const ParameterFlags& held,
    CalibrationState* state,
    ceres::Problem* problem,
    std::vector<double>* offset_variances) {
  constexpr double kSmallestEigenvalue = 1e-13;
  ceres::Problem::EvaluateOptions evaluation;
  int columns = 0;
  std::vector<int> camera_columns;
  if (!problem->IsParameterBlockConstant(state->camera.data())) {
    evaluation.parameter_blocks.push_back(state->camera.data());
    for (int i = 0; i < kNumCameraParameters; ++i) {
      if (!held[i]) camera_columns.push_back(i);
    }
    columns = static_cast<int>(camera_columns.size());
  }
  std::vector<int> offset_column(views.size(), -1);
  for (size_t k = 0; k < views.size(); ++k) {
    if (views[k].corners.empty()) continue;
    evaluation.parameter_blocks.push_back(state->cam_from_board[k].data());
    evaluation.parameter_blocks.push_back(&state->depth_offsets[k]);
    offset_column[k] = columns + 6;
    columns += 7;
  }
  ceres::CRSMatrix jacobian;
  if (!problem->Evaluate(evaluation, nullptr, nullptr, nullptr, &jacobian)) return std::nullopt;
  const Eigen::Map<const Eigen::SparseMatrix<double, Eigen::RowMajor>> J(jacobian.num_rows,
                                                                         jacobian.num_cols,
                                                                         jacobian.values.size(),
                                                                         jacobian.rows.data(),
                                                                         jacobian.cols.data(),
                                                                         jacobian.values.data());
  const Eigen::MatrixXd information = Eigen::SparseMatrix<double>(J.transpose() * J);
  if ((information.diagonal().array() <= 0).any()) return std::nullopt;
  const Eigen::VectorXd scale = information.diagonal().cwiseSqrt().cwiseInverse();
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> solver(scale.asDiagonal() * information *
                                                              scale.asDiagonal());
  if (solver.eigenvalues()[0] < kSmallestEigenvalue) return std::nullopt;
  const Eigen::MatrixXd root = scale.asDiagonal() * solver.eigenvectors() *
                               solver.eigenvalues().cwiseSqrt().cwiseInverse().asDiagonal();
  offset_variances->assign(views.size(), 0);
  for (size_t k = 0; k < views.size(); ++k) {
    if (offset_column[k] >= 0) {
      (*offset_variances)[k] = root.row(offset_column[k]).squaredNorm();
    }
  }
  Eigen::Matrix<double, kNumCameraParameters, kNumCameraParameters> covariance;
  covariance.setZero();
  for (size_t i = 0; i < camera_columns.size(); ++i) {
    for (size_t j = 0; j < camera_columns.size(); ++j) {
      covariance(camera_columns[i], camera_columns[j]) =
          root.row(static_cast<long>(i)).dot(root.row(static_cast<long>(j)));
    }
  }
  return covariance;
}

// Variance components: sums of squares over what is left of the observations beside unknowns. A
// view's own is held near that of all views by some observations that nobody made.
// Returns the largest relative change.
double UpdateNoise(const std::vector<BoardView>& views,
                   const std::vector<ViewResiduals>& residuals,
                   const std::vector<double>& offset_variances,
                   const CalibrationState& state,
                   CalibrationNoise* noise) {
  constexpr double kOfAllViews = 10;  // observations
  constexpr double kSmallest = 1e-3;
  double offset_free = 0, offset_squares = 0;
  const double offset_variance = noise->depth_offset_sigma * noise->depth_offset_sigma;
  double px = 0, px_free = 0, slope = 0, slope_free = 0;
  for (size_t k = 0; k < views.size(); ++k) {
    if (views[k].corners.empty()) continue;
    const ViewResiduals& sums = residuals[k];
    // An offset that the view does not tell stays at 0 and says nothing.
    offset_squares += state.depth_offsets[k] * state.depth_offsets[k];
    offset_free += 1 - std::min(1.0, offset_variances[k] / offset_variance);
    px += sums.px_squares * std::pow(noise->px_scale[k], 2);
    px_free += std::max(0.0, sums.px_weights - 6);  // the pose follows from positions
    slope += sums.slope_squares * std::pow(noise->slope_scale[k], 2);
    slope_free += std::max(0.0, sums.slope_weights - 1);  // and the offset from slopes
  }
  const CalibrationNoise before = *noise;
  const double px_variance = px / std::max(1.0, px_free);
  const double slope_variance = slope / std::max(1.0, slope_free);
  const auto scale = [&](double of_all, double squares, double free, double before) {
    const double variance =
        (kOfAllViews * of_all + squares * before * before) / (kOfAllViews + std::max(0.0, free));
    return std::max(kSmallest, std::sqrt(variance));
  };
  for (size_t k = 0; k < views.size(); ++k) {
    const ViewResiduals& sums = residuals[k];
    noise->px_scale[k] =
        scale(px_variance, sums.px_squares, sums.px_weights - 6, noise->px_scale[k]);
    noise->slope_scale[k] =
        scale(slope_variance, sums.slope_squares, sums.slope_weights - 1, noise->slope_scale[k]);
  }
  noise->depth_offset_sigma =
      std::max(kSmallestOffsetSigma, std::sqrt(offset_squares / std::max(0.1, offset_free)));
  double change = std::abs(noise->depth_offset_sigma / before.depth_offset_sigma - 1);
  for (size_t k = 0; k < views.size(); ++k) {
    if (views[k].corners.empty()) continue;
    change = std::max(change, std::abs(noise->px_scale[k] / before.px_scale[k] - 1));
    change = std::max(change, std::abs(noise->slope_scale[k] / before.slope_scale[k] - 1));
  }
  return change;
}

}  // namespace

CameraParameters ParametersOf(const PlenopticCamera& camera) {
  CameraParameters parameters{};
  parameters[kFocalLength] = camera.focal_length;
  parameters[kInfinityDepth] = camera.virtual_depth_sign() *
                               (camera.focal_length - camera.main_lens_mla_distance) /
                               camera.sensor_mla_distance;
  parameters[kSensorDistance] = camera.sensor_mla_distance;
  parameters[kPrincipalX] = camera.raw_principal_point.x();
  parameters[kPrincipalY] = camera.raw_principal_point.y();
  parameters[kRadial0] = camera.distortion.A0;
  parameters[kRadial1] = camera.distortion.A1;
  parameters[kTangential0] = camera.distortion.B0;
  parameters[kTangential1] = camera.distortion.B1;
  return parameters;
}

PlenopticCamera WithParameters(const PlenopticCamera& camera, const CameraParameters& parameters) {
  PlenopticCamera changed = camera;
  changed.focal_length = parameters[kFocalLength];
  changed.sensor_mla_distance = parameters[kSensorDistance];
  changed.main_lens_mla_distance = parameters[kFocalLength] - camera.virtual_depth_sign() *
                                                                  parameters[kInfinityDepth] *
                                                                  parameters[kSensorDistance];
  changed.raw_principal_point = {parameters[kPrincipalX], parameters[kPrincipalY]};
  changed.distortion = {parameters[kRadial0],
                        parameters[kRadial1],
                        parameters[kTangential0],
                        parameters[kTangential1]};
  return changed;
}

AdjustmentResult AdjustCalibration(const CalibrationBoard& board,
                                   const std::vector<BoardView>& views,
                                   const FixedFigures& fixed,
                                   const AdjustmentOptions& options,
                                   CalibrationNoise* noise,
                                   CalibrationState* state) {
  CHECK_EQ(state->cam_from_board.size(), views.size());
  CHECK_EQ(noise->px_scale.size(), views.size());
  AdjustmentResult result;
  const int rounds = options.estimate_noise ? kNoiseRounds : 1;
  for (int round = 0; round < rounds; ++round) {
    ceres::Problem problem;
    Build(board, views, fixed, options, *noise, state, &problem);
    ceres::Solver::Options solver;
    solver.linear_solver_type = ceres::DENSE_SCHUR;
    solver.max_num_iterations = options.max_iterations;
    solver.function_tolerance = 1e-8;
    solver.num_threads = 1;  // the same bytes on every machine
    solver.logging_type = ceres::SILENT;
    ceres::Solver::Summary summary;
    ceres::Solve(solver, &problem, &summary);
    result.converged = summary.termination_type == ceres::CONVERGENCE;
    result.cost = summary.final_cost;
    std::vector<double> offset_variances;
    const bool last = round + 1 == rounds;
    if (options.estimate_noise || last) {
      result.covariance = Covariance(views, options.held, state, &problem, &offset_variances);
    }
    const std::vector<ViewResiduals> residuals = Evaluate(board, views, fixed, *noise, *state);
    double px = 0, depth = 0;
    result.corners = 0;
    for (const ViewResiduals& sums : residuals) {
      px += sums.px_raw_squares;
      depth += sums.depth_squares;
      result.corners += sums.corners;
    }
    result.px_rms = std::sqrt(px / std::max(1, result.corners));
    result.depth_rms = std::sqrt(depth / std::max(1, result.corners));
    if (last || !result.covariance) break;
    if (UpdateNoise(views, residuals, offset_variances, *state, noise) < kSettled) break;
  }
  return result;
}

}  // namespace prism
