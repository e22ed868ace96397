// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
#include "prism/residual/jacobian_check.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <random>

#include <ceres/autodiff_cost_function.h>

#include "prism/base/random.h"
#include "prism/residual/autodiff_twins.h"
#include "prism/residual/frame_manifold.h"

namespace prism {
namespace {

using RowMajorMatrix = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

void Compare(const Eigen::MatrixXd& analytic, const Eigen::MatrixXd& other, double* error) {
  for (Eigen::Index i = 0; i < analytic.size(); ++i) {
    const double a = analytic.data()[i];
    const double b = other.data()[i];
    // Written so that a NaN counts as the largest disagreement.
    const double mixed = std::abs(a - b) / (1 + std::max(std::abs(a), std::abs(b)));
    if (!(mixed <= *error)) *error = std::isnan(mixed) ? INFINITY : mixed;
  }
}

// Jacobian of one parameter block in the tangent space, from the cost's ambient Jacobians.
Eigen::MatrixXd TangentJacobian(const RowMajorMatrix& ambient, const double* block) {
  if (ambient.cols() != FrameState::kSize) return ambient;
  Eigen::Matrix<double, FrameState::kSize, FrameState::kTangentSize, Eigen::RowMajor> plus;
  FrameManifold().PlusJacobian(block, plus.data());
  return ambient * plus;
}

struct Evaluation {
  Eigen::VectorXd residuals;
  std::vector<Eigen::MatrixXd> jacobians;  // tangent, one a block
};

Evaluation Evaluate(const ceres::CostFunction& cost, const std::vector<double*>& blocks) {
  Evaluation evaluation;
  evaluation.residuals.resize(cost.num_residuals());
  std::vector<RowMajorMatrix> ambient;
  std::vector<double*> jacobian_pointers;
  for (const int size : cost.parameter_block_sizes()) {
    ambient.emplace_back(cost.num_residuals(), size);
  }
  for (RowMajorMatrix& J : ambient) jacobian_pointers.push_back(J.data());
  CHECK(cost.Evaluate(blocks.data(), evaluation.residuals.data(), jacobian_pointers.data()));
  for (size_t i = 0; i < blocks.size(); ++i) {
    evaluation.jacobians.push_back(TangentJacobian(ambient[i], blocks[i]));
  }
  return evaluation;
}

// Central differences with Richardson extrapolation. The step stays inside one pixel of the
// interpolant, whose derivative jumps at pixel borders.
Eigen::MatrixXd NumericTangentJacobian(
    const std::function<Eigen::VectorXd(const Eigen::VectorXd&)>& residuals_at, int dimension) {
  const auto difference = [&](int column, double h) -> Eigen::VectorXd {
    Eigen::VectorXd delta = Eigen::VectorXd::Zero(dimension);
    delta(column) = h;
    return (residuals_at(delta) - residuals_at(-delta)) / (2 * h);
  };
  constexpr double kStep = 2e-6;
  const Eigen::VectorXd first = difference(0, kStep);
  Eigen::MatrixXd J(first.size(), dimension);
  for (int column = 0; column < dimension; ++column) {
    J.col(column) = (4 * difference(column, kStep / 2) - difference(column, kStep)) / 3;
  }
  return J;
}

// Random states near each other, looking at one point.
struct RandomState {
  FrameState host, target;
  double rho;
  Eigen::Vector2d px;
};

RandomState DrawState(const PlenopticProjection& camera, std::mt19937_64* generator) {
  std::normal_distribution<double> normal;
  std::uniform_real_distribution<double> uniform(0, 1);
  const auto tangent = [&](double translation, double rotation) {
    Vector6d delta;
    for (int i = 0; i < 6; ++i) delta(i) = (i < 3 ? translation : rotation) * normal(*generator);
    return delta;
  };
  RandomState state;
  state.host =
      FrameState(SE3::Exp(tangent(2, 1)), 0.1 * normal(*generator), 5 * normal(*generator));
  state.target = FrameState(SE3::Exp(tangent(0.03, 0.02)) * state.host.pose(),
                            0.1 * normal(*generator),
                            5 * normal(*generator));
  state.rho = 0.05 + 2 * uniform(*generator);
  state.px = {camera.width * (0.15 + 0.7 * uniform(*generator)),
              camera.height * (0.15 + 0.7 * uniform(*generator))};
  return state;
}

ImageF RandomSmoothImage(int width, int height, std::mt19937_64* generator) {
  std::uniform_real_distribution<double> phase(0, 6.28);
  const double p0 = phase(*generator), p1 = phase(*generator);
  ImageF image(width, height);
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) {
      image(x, y) =
          static_cast<float>(128 + 60 * std::sin(0.11 * x + p0) * std::cos(0.07 * y + p1) +
                             30 * std::sin(0.05 * (x + 2 * y)));
    }
  }
  return image;
}

// Distance of a coordinate to the nearest pixel centre line, where the interpolant has a kink.
double DistanceToKink(double x) { return std::abs(x - std::round(x)); }

class Checker {
 public:
  Checker(const PlenopticCamera& model, const JacobianCheckOptions& options)
      : camera_(model), generator_(SeededGenerator(options.seed, 0)) {
    image_ = RandomSmoothImage(camera_.width, camera_.height, &generator_);
    for (const char* block : {"host pose",
                              "host affine a",
                              "host affine b",
                              "target pose",
                              "target affine a",
                              "target affine b",
                              "inverse depth"}) {
      result_.blocks.push_back({"photometric", block});
    }
    result_.blocks.push_back({"inverse virtual depth", "inverse depth"});
    for (int i = 0; i < options.samples; ++i) CheckSample(DrawState(camera_, &generator_));
    ComparePrinted();
    result_.agrees = result_.valid_samples > 0;
    for (const JacobianBlockCheck& block : result_.blocks) {
      result_.agrees &= block.autodiff_error <= options.tolerance && block.largest_element > 0;
    }
  }

  const JacobianCheckResult& result() const { return result_; }

 private:
  void Record(int index,
              const Eigen::MatrixXd& analytic,
              const Eigen::MatrixXd& autodiff,
              const Eigen::MatrixXd& numeric) {
    JacobianBlockCheck& block = result_.blocks[index];
    Compare(analytic, autodiff, &block.autodiff_error);
    Compare(analytic, numeric, &block.numeric_error);
    block.largest_element = std::max(block.largest_element, analytic.cwiseAbs().maxCoeff());
  }

  bool ProjectsInsideAwayFromKinks(const RandomState& state) const {
    const SE3 target_from_host = state.target.pose() * state.host.pose().Inverse();
    for (const auto& [dx, dy] : kPattern) {
      Eigen::Vector3d x_V;
      if (!ProjectBetweenFrames(
              camera_, state.px + Eigen::Vector2d(dx, dy), state.rho, target_from_host, &x_V) ||
          !image_.view().Contains(x_V.x(), x_V.y(), 1) ||
          std::min(DistanceToKink(x_V.x()), DistanceToKink(x_V.y())) < 0.02) {
        return false;
      }
    }
    return true;
  }

  void CheckSample(RandomState state) {
    PhotometricPatch patch;
    if (!ProjectsInsideAwayFromKinks(state) || !MakePatch(image_, state.px, {}, &patch)) return;
    ++result_.valid_samples;
    FramePair pair;
    const PhotometricCost cost(&patch, &pair, image_, &camera_);
    const ceres::AutoDiffCostFunction<PhotometricTwin, kPatternSize, 9, 9, 1> twin(
        new PhotometricTwin{&patch, image_, &camera_});
    const std::vector<double*> blocks = {state.host.data(), state.target.data(), &state.rho};
    pair.Update(state.host, state.target);
    const Evaluation analytic = Evaluate(cost, blocks);
    const Evaluation autodiff = Evaluate(twin, blocks);
    double residual_error = 0;
    Compare(analytic.residuals, autodiff.residuals, &residual_error);

    const auto frame_numeric = [&](FrameState RandomState::*member) {
      return NumericTangentJacobian(
          [&, member](const Eigen::VectorXd& delta) {
            RandomState moved = state;
            FrameManifold().Plus((state.*member).data(), delta.data(), (moved.*member).data());
            pair.Update(moved.host, moved.target);
            return Evaluate(cost, {moved.host.data(), moved.target.data(), &moved.rho}).residuals;
          },
          FrameState::kTangentSize);
    };
    const Eigen::MatrixXd numeric[2] = {frame_numeric(&RandomState::host),
                                        frame_numeric(&RandomState::target)};
    pair.Update(state.host, state.target);
    for (int frame = 0; frame < 2; ++frame) {
      const Eigen::MatrixXd& a = analytic.jacobians[frame];
      const Eigen::MatrixXd& b = autodiff.jacobians[frame];
      Record(3 * frame, a.leftCols(6), b.leftCols(6), numeric[frame].leftCols(6));
      Record(3 * frame + 1, a.col(6), b.col(6), numeric[frame].col(6));
      Record(3 * frame + 2, a.col(7), b.col(7), numeric[frame].col(7));
    }
    const auto rho_numeric = [&](const ceres::CostFunction& any_cost, std::vector<double*> any) {
      return NumericTangentJacobian(
          [&, any](const Eigen::VectorXd& delta) mutable {
            double rho = state.rho + delta(0);
            any.back() = &rho;
            return Evaluate(any_cost, any).residuals;
          },
          1);
    };
    Record(6, analytic.jacobians[2], autodiff.jacobians[2], rho_numeric(cost, blocks));
    // A twin that computes another residual would make its Jacobians worthless.
    for (int i = 0; i < 7; ++i) {
      result_.blocks[i].autodiff_error = std::max(result_.blocks[i].autodiff_error, residual_error);
    }

    const InverseVirtualDepthCost depth_cost(0.4, 0.004, &camera_);
    const ceres::AutoDiffCostFunction<InverseVirtualDepthTwin, 1, 1> depth_twin(
        new InverseVirtualDepthTwin{0.4, 0.004, &camera_});
    const Evaluation depth = Evaluate(depth_cost, {&state.rho});
    Record(7,
           depth.jacobians[0],
           Evaluate(depth_twin, {&state.rho}).jacobians[0],
           rho_numeric(depth_cost, {&state.rho}));
  }

  void ComparePrinted() {
    const Eigen::Vector3d x_C(0.3, -0.2, 2.5);
    Eigen::Vector3d x_V;
    Eigen::Matrix3d J_x;
    if (!Project(camera_, x_C, &x_V, &J_x)) return;
    const Eigen::Matrix<double, 3, 6> J = J_x * PointPoseJacobian(x_C);
    const double z = x_C.z();
    const double f = camera_.f;
    const double u = x_C.x() / z, v = x_C.y() / z;
    const double alpha = f / (camera_.s * (z - f));
    const double beta = -f * f / (camera_.B * (z - f) * (z - f));
    Eigen::Matrix<double, 3, 6> printed;
    printed << alpha, 0, -u * alpha, -u * v * alpha, (1 + u * u) * alpha, -v * alpha,  //
        0, alpha, -v * alpha, -(1 + v * v) * alpha, u * v * alpha, u * alpha,          //
        0, 0, beta, -v * beta, u * beta, 0;
    const char* const columns[] = {"t_x", "t_y", "t_z", "w_x", "w_y", "w_z"};
    for (int row = 0; row < 3; ++row) {
      for (int column = 0; column < 6; ++column) {
        if (J(row, column) == 0 && printed(row, column) == 0) continue;
        result_.printed.push_back({"(72)",
                                   "row " + std::to_string(row + 1) + ", " + columns[column],
                                   J(row, column),
                                   printed(row, column)});
      }
    }
    const double printed_66 = -v * f / camera_.B / (z - 2 * f + f * f / z);
    result_.printed.push_back({"(66)", "row 3, w_x", J(2, 3), printed_66});
  }

  PlenopticProjection camera_;
  std::mt19937_64 generator_;
  ImageF image_;
  JacobianCheckResult result_;
};

}  // namespace

JacobianCheckResult CheckJacobians(const PlenopticCamera& camera,
                                   const JacobianCheckOptions& options) {
  return Checker(camera, options).result();
}

}  // namespace prism
