// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
#include "prism/lightfield/lens_type_estimation.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include <glog/logging.h>
#include <Eigen/Dense>

#include "prism/camera/projection.h"
#include "prism/lightfield/camera_trial.h"
#include "prism/lightfield/half_pixel_image.h"

namespace prism {
namespace {

constexpr int kLattices = 3;
constexpr double kBinWidth = 0.01;  // of 1/v
constexpr int kBins = 50;
constexpr int kMinPoints = 300;          // that a bin counts
constexpr double kEnoughPoints = 3000;   // more do not make a bin more certain
constexpr double kMinEvidence = 1.2;     // one type gives 1.04 to 1.13, three 1.29 and more
constexpr size_t kFramesOfOrder = 3;     // of one alone one type gave up to 1.21
constexpr double kMaxFocusSigma = 0.02;  // of 1/v
constexpr double kMinBlur = 0.9;  // px^2: of a pixel, of the filter and of the difference in it
constexpr double kMaxBlur = 20;

using Energies = std::array<double, kLattices>;

struct Bin {
  double points = 0;
  Energies energy{};
};
using Bins = std::array<Bin, kBins>;

// Squared gradient of the smoothed raw image at a pixel less what noise adds to it; false where the
// micro image does not hold it.
bool GradientEnergy(const ImageF& smooth,
                    const Image<uint8_t>& lens_colour,
                    double noise,
                    int colour,
                    int x,
                    int y,
                    double* energy) {
  // Of a component of the central difference under (1 2 1) x (1 2 1) / 16, over that of the noise.
  constexpr double kNoiseOfComponent = 0.0586;
  const auto is_good = [&](int u, int v) { return lens_colour(u, v) == colour + 1; };
  if (!smooth.view().Contains(x, y, 3) || !is_good(x - 2, y) || !is_good(x + 1, y) ||
      !is_good(x, y - 2) || !is_good(x, y + 1)) {
    return false;
  }
  const double dx = 0.5 * (smooth(x + 1, y) - smooth(x - 1, y));
  const double dy = 0.5 * (smooth(x, y + 1) - smooth(x, y - 1));
  *energy = dx * dx + dy * dy - 2 * kNoiseOfComponent * noise * noise;
  return true;
}

// Of points that lenses of all three lattices see.
void AddFrame(const LightFieldProcessor& processor, const LightFieldFrame& frame, Bins* bins) {
  const LensTable& lenses = processor.lenses();
  const ImageF smooth = FilterWholePixels(processor.prepared().gray);
  LensView views[LensTable::kMaxViews];
  for (int y = 0; y < frame.sigma.height(); ++y) {
    for (int x = 0; x < frame.sigma.width(); ++x) {
      const float w = frame.inverse_virtual_depth(x, y);
      if (frame.sigma(x, y) == 0 || w >= kBins * kBinWidth) continue;
      const Eigen::Vector2f point = lenses.VirtualPoint(
          RawFromFocused(processor.camera(), Eigen::Vector2d(x, y)).cast<float>(), w);
      const int count = lenses.ViewsOf(point.x(), point.y(), w, lenses.radius_px() - 2, 3, views);
      Energies sum{}, views_of{};
      for (int k = 0; k < count; ++k) {
        const int colour = lenses.lenses()[views[k].lens].colour;
        double energy;
        if (!GradientEnergy(smooth,
                            processor.prepared().lens_colour,
                            processor.noise(),
                            colour,
                            static_cast<int>(std::lround(views[k].x)),
                            static_cast<int>(std::lround(views[k].y)),
                            &energy)) {
          continue;
        }
        sum[colour] += energy;
        views_of[colour] += 1;
      }
      if (*std::min_element(views_of.begin(), views_of.end()) == 0) continue;
      Bin& bin = (*bins)[static_cast<size_t>(w / kBinWidth)];
      bin.points += 1;
      for (int k = 0; k < kLattices; ++k) bin.energy[k] += sum[k] / views_of[k];
    }
  }
}

// f_0, f_1, f_2, s^2.
using Parameters = Eigen::Vector4d;

// log(E_k / E) against the model, with the best A of each bin.
class FocusModel {
 public:
  FocusModel(const Bins& bins, double defocus_variance) : defocus_variance_(defocus_variance) {
    for (size_t b = 0; b < kBins; ++b) {
      const Energies& energy = bins[b].energy;
      if (bins[b].points < kMinPoints || *std::min_element(energy.begin(), energy.end()) <= 0) {
        continue;
      }
      Row row;
      row.w = (static_cast<double>(b) + 0.5) * kBinWidth;
      row.weight = std::min(bins[b].points, kEnoughPoints);
      double mean = 0;
      for (int k = 0; k < kLattices; ++k) {
        row.log_energy[k] = std::log(energy[k]);
        mean += row.log_energy[k] / kLattices;
      }
      for (double& value : row.log_energy) value -= mean;
      rows_.push_back(row);
    }
  }

  bool empty() const { return rows_.empty(); }

  // The weighted mean square of what is left over.
  double Cost(const Parameters& p) const {
    double sum = 0, weights = 0;
    for (const Row& row : rows_) {
      Energies residual;
      double mean = 0;
      for (int k = 0; k < kLattices; ++k) {
        const double defocus = row.w - p[k];
        residual[k] = row.log_energy[k] + std::log(p[3] + defocus_variance_ * defocus * defocus);
        mean += residual[k] / kLattices;
      }
      for (const double r : residual) sum += row.weight * (r - mean) * (r - mean);
      weights += row.weight;
    }
    return sum / weights;
  }

  Parameters Minimize() const {
    Parameters best = Parameters::Zero();
    double least = std::numeric_limits<double>::infinity();
    const auto consider = [&](const Parameters& p) {
      for (int k = 0; k < kLattices; ++k) {
        if (!(p[k] > 0 && p[k] <= 0.5)) return false;
      }
      if (!(p[3] >= kMinBlur && p[3] <= kMaxBlur)) return false;
      const double cost = Cost(p);
      if (!(cost < least)) return false;
      least = cost;
      best = p;
      return true;
    };
    for (double a = 0.05; a < 0.5; a += 0.04) {
      for (double b = 0.05; b < 0.5; b += 0.04) {
        for (double c = 0.05; c < 0.5; c += 0.04) {
          for (const double s : {1.0, 2.0, 4.0, 8.0}) consider({a, b, c, s});
        }
      }
    }
    Parameters step(0.02, 0.02, 0.02, 0.3 * best[3]);
    for (int halving = 0; halving < 10; ++halving, step *= 0.5) {
      for (bool moved = true; moved;) {
        moved = false;
        for (int i = 0; i < 4; ++i) {
          for (const double sign : {-1.0, 1.0}) {
            Parameters next = best;
            next[i] += sign * step[i];
            moved |= consider(next);
          }
        }
      }
    }
    return best;
  }

  // Of the least certain focus, taking what is left over for noise.
  double FocusSigma(const Parameters& p) const {
    const Parameters step(1e-3, 1e-3, 1e-3, 0.02 * p[3]);
    Eigen::Matrix4d hessian;
    for (int i = 0; i < 4; ++i) {
      for (int j = 0; j < 4; ++j) {
        const auto at = [&](double a, double b) {
          Parameters q = p;
          q[i] += a * step[i];
          q[j] += b * step[j];
          return Cost(q);
        };
        hessian(i, j) = (at(1, 1) - at(1, -1) - at(-1, 1) + at(-1, -1)) / (4 * step[i] * step[j]);
      }
    }
    const double freedom = std::max(2.0 * static_cast<double>(rows_.size()) - 4, 1.0);
    const Eigen::Matrix4d covariance = hessian.inverse() * (2 * Cost(p) / freedom);
    const double variance = covariance.diagonal().head<3>().maxCoeff();
    const bool is_minimum = covariance.diagonal().minCoeff() > 0;
    return is_minimum ? std::sqrt(variance) : std::numeric_limits<double>::infinity();
  }

 private:
  struct Row {
    double w = 0;
    double weight = 0;
    Energies log_energy{};
  };
  std::vector<Row> rows_;
  double defocus_variance_;
};

// A type in use half way to the next one, which its focus is in the middle of.
MicroLensType TypeAt(double focus, double to_next, const Eigen::Vector2d& offset) {
  const double reach = std::min({0.55 * to_next, 0.5 - focus, focus - 0.01});
  MicroLensType type;
  type.offset = offset;
  type.min_virtual_depth = 1 / (focus + reach);
  type.max_virtual_depth = 1 / (focus - reach);
  return type;
}

// An array whose lattice k has the type order[k].
std::vector<MicroLensType> InOrder(const MicroLensGrid& grid,
                                   const std::array<int, kLattices>& order) {
  constexpr double kRanges[kLattices][2] = {{1, 3.2}, {2.6, 4.2}, {3.5, 100}};
  const Eigen::Vector2d offsets[] = {Eigen::Vector2d::Zero(), grid.base_x, -grid.base_x};
  std::vector<MicroLensType> types;
  for (int k = 0; k < kLattices; ++k) {
    types.push_back({offsets[k], kRanges[order[k]][0], kRanges[order[k]][1]});
  }
  return types;
}

PlenopticCamera WithTypes(PlenopticCamera camera, const std::vector<MicroLensType>& types) {
  camera.micro_lens_grid->types = types;
  return camera;
}

// Sums over some of the frames, evenly among them.
CameraTrial TryTypes(const PlenopticCamera& camera,
                     const std::vector<MicroLensType>& types,
                     const cv::Mat& white,
                     const LightFieldOptions& options,
                     const std::vector<RawFrame>& frames) {
  const size_t count = std::min(frames.size(), kFramesOfOrder);
  CameraTrial sum;
  for (size_t i = 0; i < count; ++i) {
    const RawFrame& frame = frames[i * frames.size() / count];
    const CameraTrial trial = TryCamera(WithTypes(camera, types), white, options, frame);
    sum.measured += trial.measured;
    sum.information += trial.information;
    sum.gradient_energy += trial.gradient_energy;
  }
  return sum;
}

}  // namespace

LensTypeFit EstimateLensTypes(const PlenopticCamera& camera,
                              const cv::Mat& white,
                              const LightFieldOptions& options,
                              const std::vector<RawFrame>& frames) {
  CHECK(!frames.empty());
  LensTypeFit fit;
  double most = 0, least = std::numeric_limits<double>::infinity(), sharpest = 0;
  std::array<int, kLattices> order = {0, 1, 2};
  do {
    const std::vector<MicroLensType> types = InOrder(*camera.micro_lens_grid, order);
    const CameraTrial trial = TryTypes(camera, types, white, options, frames);
    most = std::max(most, trial.information);
    least = std::min(least, trial.information);
    if (trial.gradient_energy <= sharpest) continue;
    sharpest = trial.gradient_energy;
    fit.types = types;
  } while (std::next_permutation(order.begin(), order.end()));
  fit.evidence = least > 0 ? most / least : 1;
  if (fit.evidence < kMinEvidence) {
    fit.types = {MicroLensType{}};
    return fit;
  }

  LightFieldProcessor processor(WithTypes(camera, fit.types), white, options);
  Bins bins;
  for (const RawFrame& frame : frames) AddFrame(processor, processor.Process(frame), &bins);
  const FocusModel model(bins, processor.lenses().DefocusVariance());
  if (model.empty()) return fit;
  const Parameters best = model.Minimize();
  fit.focus_sigma = model.FocusSigma(best);
  if (!(fit.focus_sigma < kMaxFocusSigma)) return fit;
  std::vector<MicroLensType> measured;
  for (int k = 0; k < kLattices; ++k) {
    fit.focus[k] = best[k];
    const double to_next = std::min(std::abs(best[k] - best[(k + 1) % kLattices]),
                                    std::abs(best[k] - best[(k + 2) % kLattices]));
    measured.push_back(TypeAt(best[k], to_next, fit.types[k].offset));
  }
  const CameraTrial trial = TryTypes(camera, measured, white, options, frames);
  fit.focus_measured = trial.gradient_energy >= sharpest;
  if (fit.focus_measured) fit.types = measured;
  return fit;
}

}  // namespace prism
