// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
#include "prism/verify/jacobian_check.h"

#include <algorithm>
#include <cmath>
#include <random>

#include <ceres/autodiff_cost_function.h>
#include <glog/logging.h>

#include "prism/base/random.h"
#include "prism/factors/frame_manifold.h"
#include "prism/factors/inverse_virtual_depth_term.h"
#include "prism/factors/photometric.h"
#include "prism/image/interpolation.h"
#include "prism/solver/linear_prior.h"
#include "prism/verify/autodiff_twins.h"
#include "prism/verify/numeric.h"
#include "prism/verify/term_check.h"

namespace prism {
namespace {

// Jacobian of one parameter block in the tangent space, from the cost's ambient Jacobians.
Eigen::MatrixXd TangentJacobian(const BlockKind::RowMajorMatrix& ambient, const double* block) {
  if (ambient.cols() != FrameState::kSize) return ambient;
  return ambient * FrameStateKind()->PlusJacobian(block);
}

struct Evaluation {
  Eigen::VectorXd residuals;
  std::vector<Eigen::MatrixXd> jacobians;  // tangent, one a block
};

Evaluation Evaluate(const ceres::CostFunction& cost, const std::vector<double*>& blocks) {
  Evaluation evaluation;
  evaluation.residuals.resize(cost.num_residuals());
  std::vector<BlockKind::RowMajorMatrix> ambient;
  std::vector<double*> jacobian_pointers;
  for (const int size : cost.parameter_block_sizes()) {
    ambient.emplace_back(cost.num_residuals(), size);
  }
  for (BlockKind::RowMajorMatrix& J : ambient) jacobian_pointers.push_back(J.data());
  CHECK(cost.Evaluate(blocks.data(), evaluation.residuals.data(), jacobian_pointers.data()));
  for (size_t i = 0; i < blocks.size(); ++i) {
    evaluation.jacobians.push_back(TangentJacobian(ambient[i], blocks[i]));
  }
  return evaluation;
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

// d (Exp(delta) x_C) / d delta at 0, tangent [translation; rotation] (Eq. (52), without its zero
// last row).
Eigen::Matrix<double, 3, 6> PointPoseJacobian(const Eigen::Vector3d& x_C) {
  Eigen::Matrix<double, 3, 6> J;
  J << Eigen::Matrix3d::Identity(), -Skew(x_C);
  return J;
}

constexpr double kSigma = 4;  // of the photometric residuals here, intensities

class Checker {
 public:
  Checker(const PlenopticCamera& model, const JacobianCheckOptions& options)
      : camera_(model), generator_(SeededGenerator(options.seed, 0)) {
    image_ = RandomSmoothImage(camera_.width, camera_.height, &generator_);
    for (int i = 0; i < options.samples; ++i) CheckSample(DrawState(camera_, &generator_));
    ComparePrinted();
  }

  const JacobianCheckResult& result() const { return result_; }

 private:
  void Record(const std::string& residual,
              const std::string& name,
              const Eigen::MatrixXd& analytic,
              const Eigen::MatrixXd& autodiff,
              const Eigen::MatrixXd& numeric) {
    const auto is_it = [&](const JacobianBlockCheck& block) {
      return block.residual == residual && block.block == name;
    };
    auto block = std::find_if(result_.blocks.begin(), result_.blocks.end(), is_it);
    if (block == result_.blocks.end()) {
      block = result_.blocks.insert(result_.blocks.end(), {residual, name, 0.0});
    }
    RaiseMixedError(analytic, autodiff, &*block->autodiff_error);
    RaiseMixedError(analytic, numeric, &block->numeric_error);
    block->largest_element = std::max(block->largest_element, analytic.cwiseAbs().maxCoeff());
  }

  // Pose and brightness of a frame state by themselves.
  void RecordFrame(const std::string& residual,
                   const std::string& frame,
                   const Eigen::MatrixXd& analytic,
                   const Eigen::MatrixXd& autodiff,
                   const Eigen::MatrixXd& numeric) {
    Record(
        residual, frame + " pose", analytic.leftCols(6), autodiff.leftCols(6), numeric.leftCols(6));
    Record(residual, frame + " affine a", analytic.col(6), autodiff.col(6), numeric.col(6));
    Record(residual, frame + " affine b", analytic.col(7), autodiff.col(7), numeric.col(7));
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

  void CheckSample(const RandomState& state) {
    PhotometricPatch patch;
    if (!ProjectsInsideAwayFromKinks(state) || !MakePatch(image_, state.px, &patch)) return;
    ++result_.valid_samples;
    CheckPhotometric(patch, state);
    CheckFirstEstimates(patch, state);
    CheckTracker(patch, state);
    CheckPrior(state);
    CheckDepth(state);
  }

  // Central differences of a cost over one of its blocks, a frame state or a number.
  template <typename Residuals>
  Eigen::MatrixXd Numeric(const RandomState& state, int block, const Residuals& residuals) const {
    return NumericTangentJacobian(
        [&](const Eigen::VectorXd& delta) -> Eigen::VectorXd {
          RandomState moved = state;
          if (block == 0) FrameManifold().Plus(state.host.data(), delta.data(), moved.host.data());
          if (block == 1) {
            FrameManifold().Plus(state.target.data(), delta.data(), moved.target.data());
          }
          if (block == 2) moved.rho += delta(0);
          return residuals(moved);
        },
        block == 2 ? 1 : FrameState::kTangentSize);
  }

  using PhotometricAutodiff = ceres::AutoDiffCostFunction<PhotometricTwin, kPatternSize, 9, 9, 1>;

  void CheckPhotometric(const PhotometricPatch& patch, RandomState state) {
    FramePair pair;
    pair.inverse_sigma = 1 / kSigma;
    const PhotometricCost cost(&patch, &pair, image_, &camera_);
    const PhotometricAutodiff twin(new PhotometricTwin{&patch, kSigma, image_, &camera_});
    const auto evaluate = [&](RandomState at) {
      pair.Update(at.host, at.target);
      return Evaluate(cost, {at.host.data(), at.target.data(), &at.rho});
    };
    const Evaluation analytic = evaluate(state);
    const Evaluation autodiff =
        Evaluate(twin, {state.host.data(), state.target.data(), &state.rho});
    const auto residuals = [&](const RandomState& at) { return evaluate(at).residuals; };
    for (int i = 0; i < 3; ++i) {
      const Eigen::MatrixXd numeric = Numeric(state, i, residuals);
      if (i == 2) {
        Record(
            "photometric", "inverse depth", analytic.jacobians[i], autodiff.jacobians[i], numeric);
      } else {
        RecordFrame("photometric",
                    i == 0 ? "host" : "target",
                    analytic.jacobians[i],
                    autodiff.jacobians[i],
                    numeric);
      }
    }
    // A twin that computes another residual would make its Jacobians worthless.
    Record("photometric", "residuals", analytic.residuals, autodiff.residuals, autodiff.residuals);
    // The search along the epipolar line evaluates the same with the frames held.
    PatternMatch match;
    pair.Update(state.host, state.target);
    CHECK(EvaluatePattern(patch, pair, image_, camera_, state.rho, &match));
    Record("photometric, frames held",
           "inverse depth",
           match.J_rho,
           autodiff.jacobians[2],
           Numeric(state, 2, residuals));
  }

  // Jacobians of geometry and brightness at other states than the image gradient's.
  void CheckFirstEstimates(const PhotometricPatch& patch, RandomState state) {
    RandomState first = state;
    std::normal_distribution<double> normal;
    Eigen::Matrix<double, FrameState::kTangentSize, 1> delta;
    for (FrameState RandomState::*frame : {&RandomState::host, &RandomState::target}) {
      for (int i = 0; i < delta.size(); ++i) delta(i) = (i < 6 ? 0.003 : 0.1) * normal(generator_);
      FrameManifold().Plus((state.*frame).data(), delta.data(), (first.*frame).data());
    }
    const SE3 target_from_host = state.target.pose() * state.host.pose().Inverse();
    Eigen::Matrix<double, kPatternSize, 2> gradient;
    for (int k = 0; k < kPatternSize; ++k) {
      Eigen::Vector3d x_V;
      const Eigen::Vector2d px = state.px + Eigen::Vector2d(kPattern[k][0], kPattern[k][1]);
      CHECK(ProjectBetweenFrames(camera_, px, state.rho, target_from_host, &x_V));
      const InterpolatedValue value = InterpolateBilinear(image_, x_V.x(), x_V.y());
      gradient.row(k) << value.dx, value.dy;
    }
    FramePair pair;
    pair.inverse_sigma = 1 / kSigma;
    pair.Update(state.host, state.target, &first.host, &first.target);
    const PhotometricCost cost(&patch, &pair, image_, &camera_);
    const Evaluation analytic =
        Evaluate(cost, {state.host.data(), state.target.data(), &state.rho});
    const PhotometricAutodiff twin(
        new PhotometricTwin{&patch, kSigma, image_, &camera_, &gradient});
    const auto evaluate = [&](RandomState at) {
      return Evaluate(twin, {at.host.data(), at.target.data(), &at.rho});
    };
    const Evaluation autodiff = evaluate(first);
    const auto residuals = [&](const RandomState& at) { return evaluate(at).residuals; };
    const std::string name = "photometric, first estimates";
    for (int i = 0; i < 2; ++i) {
      RecordFrame(name,
                  i == 0 ? "host" : "target",
                  analytic.jacobians[i],
                  autodiff.jacobians[i],
                  Numeric(first, i, residuals));
    }
    Record(name,
           "inverse depth",
           analytic.jacobians[2],
           autodiff.jacobians[2],
           Numeric(first, 2, residuals));
  }

  void CheckTracker(const PhotometricPatch& patch, RandomState state) {
    const ReferencePixel pixel{
        (state.px - camera_.c) * (camera_.s / camera_.f), patch.intensity[4], 1};
    FrameState relative(state.target.pose() * state.host.pose().Inverse(),
                        state.target.a() - state.host.a(),
                        state.target.b());
    ReferencePixels pixels(1);
    pixels.Set(0, pixel);
    const auto evaluate = [&](const FrameState& at, double rho) {
      const std::vector<double> depths(kPixelBatch, rho);
      PixelResiduals residuals;
      EvaluatePixels(pixels,
                     0,
                     depths.data(),
                     {at.pose(), std::exp(at.a()), at.b()},
                     camera_,
                     image_,
                     true,
                     &residuals);
      CHECK_EQ(residuals.seen[0], 1);
      return residuals;
    };
    const PixelResiduals analytic = evaluate(relative, state.rho);
    Eigen::Matrix<double, 1, 8> J_state;
    for (int k = 0; k < 8; ++k) J_state[k] = analytic.rows[k][0];
    const ceres::AutoDiffCostFunction<PixelTwin, 1, 9, 1> twin(
        new PixelTwin{&pixel, image_, &camera_});
    const Evaluation autodiff = Evaluate(twin, {relative.data(), &state.rho});
    const Eigen::MatrixXd over_state = NumericTangentJacobian(
        [&](const Eigen::VectorXd& delta) -> Eigen::VectorXd {
          FrameState moved;
          FrameManifold().Plus(relative.data(), delta.data(), moved.data());
          return Eigen::VectorXd::Constant(1, evaluate(moved, state.rho).value()[0]);
        },
        FrameState::kTangentSize);
    const Eigen::MatrixXd over_rho = NumericTangentJacobian(
        [&](const Eigen::VectorXd& delta) -> Eigen::VectorXd {
          return Eigen::VectorXd::Constant(1, evaluate(relative, state.rho + delta(0)).value()[0]);
        },
        1);
    RecordFrame("tracker", "target", J_state, autodiff.jacobians[0], over_state);
    Record("tracker",
           "inverse depth",
           Eigen::MatrixXd::Constant(1, 1, analytic.J_rho[0]),
           autodiff.jacobians[1],
           over_rho);
  }

  void CheckPrior(RandomState state) {
    LinearPrior prior;
    std::normal_distribution<double> normal;
    prior.A = Eigen::MatrixXd(10, FrameState::kTangentSize);
    for (Eigen::Index i = 0; i < prior.A.size(); ++i) prior.A.data()[i] = normal(generator_);
    prior.b = prior.A.col(0);
    prior.blocks = {{FrameStateKind(),
                     0,
                     Eigen::Map<const Eigen::VectorXd>(state.host.data(), FrameState::kSize)}};
    const LinearPriorCost cost(&prior);
    const ceres::AutoDiffCostFunction<FramePriorTwin, 10, 9> twin(
        new FramePriorTwin{prior.blocks[0].linearization.data(), prior.A});
    const auto residuals = [&](RandomState at) {
      return Evaluate(cost, {at.host.data()}).residuals;
    };
    RecordFrame("marginalization prior",
                "frame",
                Evaluate(cost, {state.host.data()}).jacobians[0],
                Evaluate(twin, {state.host.data()}).jacobians[0],
                Numeric(state, 0, residuals));
  }

  void CheckDepth(RandomState state) {
    const InverseVirtualDepthCost cost(0.4, 0.004, /*offset_gain=*/0, &camera_);
    const ceres::AutoDiffCostFunction<InverseVirtualDepthTwin, 1, 1> twin(
        new InverseVirtualDepthTwin{0.4, 0.004, &camera_});
    const auto residuals = [&](RandomState at) { return Evaluate(cost, {&at.rho}).residuals; };
    Record("inverse virtual depth",
           "inverse depth",
           Evaluate(cost, {&state.rho}).jacobians[0],
           Evaluate(twin, {&state.rho}).jacobians[0],
           Numeric(state, 2, residuals));
  }

  void ComparePrinted() {
    const Eigen::Vector3d x_C(0.3, -0.2, 2.5);
    Eigen::Vector3d x_V;
    Eigen::Matrix3d J_x;
    if (camera_.image != FocusedImage::kVirtualPoints || !Project(camera_, x_C, &x_V, &J_x)) return;
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

bool Agrees(const JacobianBlockCheck& block, const JacobianCheckOptions& options) {
  if (!(block.largest_element > 0)) return false;
  return block.autodiff_error ? *block.autodiff_error <= options.tolerance
                              : block.numeric_error <= options.numeric_tolerance;
}

JacobianCheckResult CheckJacobians(const PlenopticCamera& camera,
                                   const TermList& terms,
                                   const JacobianCheckOptions& options) {
  JacobianCheckResult result = Checker(camera, options).result();
  for (JacobianBlockCheck& block : CheckTerms(camera, terms, options)) {
    block.residual = "term: " + block.residual;
    result.blocks.push_back(std::move(block));
  }
  result.agrees =
      result.valid_samples > 0 &&
      std::all_of(result.blocks.begin(), result.blocks.end(), [&](const JacobianBlockCheck& block) {
        return Agrees(block, options);
      });
  return result;
}

}  // namespace prism
