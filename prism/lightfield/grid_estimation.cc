// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
#include "prism/lightfield/grid_estimation.h"

#include <algorithm>
#include <cmath>
#include <complex>

#include <glog/logging.h>
#include <Eigen/Dense>
#include <opencv2/imgproc.hpp>

#include "prism/lightfield/micro_image_centers.h"

namespace prism {
namespace {

// Similarity (pitch, rotation, offset) by least squares with Cauchy weights; RMS of the inliers.
double FitSimilarity(const std::vector<MeasuredCenter>& measured,
                     int width,
                     int height,
                     MicroLensGrid* grid) {
  double rms = 0;
  double scale = 0.1 * grid->diameter_px;
  for (int iteration = 0; iteration < 10; ++iteration) {
    Eigen::Matrix4d H = Eigen::Matrix4d::Zero();
    Eigen::Vector4d b = Eigen::Vector4d::Zero();
    double sum = 0, weights = 0;
    std::vector<double> squares;
    for (const MeasuredCenter& m : measured) {
      const Eigen::Vector2d predicted = grid->MicroImageCenter(m.lens, width, height);
      const Eigen::Vector2d origin = grid->MicroImageCenter({0, 0}, width, height);
      const Eigen::Vector2d p = predicted - origin;
      const Eigen::Vector2d r = m.center - predicted;
      const double weight = m.weight / (1 + r.squaredNorm() / (scale * scale));
      // Unknowns: offset (raw px), relative pitch, rotation in y-down px.
      Eigen::Matrix<double, 2, 4> J;
      J << 1, 0, p.x(), -p.y(), 0, 1, p.y(), p.x();
      H += weight * J.transpose() * J;
      b += weight * J.transpose() * r;
      sum += weight * r.squaredNorm();
      weights += weight;
      squares.push_back(r.squaredNorm());
    }
    rms = std::sqrt(sum / weights);
    std::nth_element(squares.begin(),
                     squares.begin() + static_cast<std::ptrdiff_t>(squares.size() / 2),
                     squares.end());
    scale = std::max(2 * std::sqrt(squares[squares.size() / 2]), 0.01);
    const Eigen::Vector4d step = H.ldlt().solve(b);
    grid->offset_px += Eigen::Vector2d(step[0], -step[1]);
    grid->diameter_px *= std::hypot(1 + step[2], step[3]);
    grid->rotation -= std::atan2(step[3], 1 + step[2]);
    if (step.head<2>().norm() < 1e-5 && step.tail<2>().norm() < 1e-9) break;
  }
  return rms;
}

// Largest move of a micro-image centre, at a corner of the image as both are lattices.
double LargestChange(const MicroLensGrid& a, const MicroLensGrid& b, int width, int height) {
  double largest = 0;
  for (const int y : {0, height - 1}) {
    for (const int x : {0, width - 1}) {
      const LensIndex lens = b.NearestLens(Eigen::Vector2d(x, y), width, height);
      largest = std::max(
          largest,
          (a.MicroImageCenter(lens, width, height) - b.MicroImageCenter(lens, width, height))
              .norm());
    }
  }
  return largest;
}

double Contrast(const ImageF& image, const MicroLensGrid& grid) {
  double center_sum = 0, corner_sum = 0;
  const int width = image.width();
  const int height = image.height();
  for (const LensIndex& lens : LensesWithin(grid, width, height, 1e9)) {
    const Eigen::Vector2d a = grid.MicroImageCenter(lens, width, height);
    const Eigen::Vector2d b = grid.MicroImageCenter({lens.i + 1, lens.j}, width, height);
    const Eigen::Vector2d c = grid.MicroImageCenter({lens.i, lens.j + 1}, width, height);
    const Eigen::Vector2d d = grid.MicroImageCenter({lens.i + 1, lens.j + 1}, width, height);
    // Between the four lenses of a square, or three 60 degrees from each other on either base.
    const double cosine = grid.base_x.dot(grid.base_y);
    const Eigen::Vector2d corner = std::abs(cosine) < 0.25 ? Eigen::Vector2d((a + d) / 2)
                                   : cosine > 0            ? Eigen::Vector2d((a + b + c) / 3)
                                                           : Eigen::Vector2d((a + b + d) / 3);
    const auto inside = [&](const Eigen::Vector2d& p) {
      return image.view().Contains(p.x(), p.y(), 1);
    };
    if (!inside(a) || !inside(corner)) continue;
    center_sum += image(static_cast<int>(std::lround(a.x())), static_cast<int>(std::lround(a.y())));
    corner_sum +=
        image(static_cast<int>(std::lround(corner.x())), static_cast<int>(std::lround(corner.y())));
  }
  const double sum = center_sum + corner_sum;
  return sum > 0 ? (center_sum - corner_sum) / sum : 0;
}

constexpr size_t kMinLenses = 20;

// False if too few micro images are whole.
bool RefineByCentroids(const ImageF& image, double region, GridFit* fit) {
  for (int pass = 0; pass < 3; ++pass) {
    const std::vector<MeasuredCenter> measured = MeasureCentroids(image, fit->grid, region);
    if (measured.size() < kMinLenses) return false;
    fit->rms_px = FitSimilarity(measured, image.width(), image.height(), &fit->grid);
    fit->lenses = static_cast<int>(measured.size());
  }
  return true;
}

// After RefineByCentroids. Changes nothing if too few micro images have rims to measure by.
void RefineByProfile(const ImageF& image, GridFit* fit) {
  GridFit refined = *fit;
  for (int pass = 0; pass < 5; ++pass) {
    const std::vector<MeasuredCenter> measured = MeasureByProfile(image, refined.grid);
    if (measured.size() < kMinLenses || 2 * static_cast<int>(measured.size()) < fit->lenses) {
      return;
    }
    const MicroLensGrid before = refined.grid;
    refined.rms_px = FitSimilarity(measured, image.width(), image.height(), &refined.grid);
    refined.lenses = static_cast<int>(measured.size());
    if (LargestChange(before, refined.grid, image.width(), image.height()) < 0.002) break;
  }
  *fit = refined;
}

void CompareWithStart(const ImageF& image, const MicroLensGrid& start, GridFit* fit) {
  fit->contrast = Contrast(image, fit->grid);
  fit->max_change_px = LargestChange(start, fit->grid, image.width(), image.height());
  const double half_size = 0.5 * std::max(image.width(), image.height());
  fit->rotation_flipped =
      std::abs(start.rotation) * half_size > 0.5 &&
      std::abs(fit->grid.rotation + start.rotation) < std::abs(fit->grid.rotation - start.rotation);
}

}  // namespace

std::optional<GridFit> RefineGrid(const ImageF& white, const MicroLensGrid& start) {
  GridFit fit;
  fit.grid = start;
  MicroLensGrid flipped = start;
  flipped.rotation *= -1;
  if (Contrast(white, flipped) > Contrast(white, start)) fit.grid = flipped;
  if (!RefineByCentroids(white, 1e9, &fit)) return std::nullopt;
  CompareWithStart(white, start, &fit);
  return fit;
}

std::optional<GridFit> RefineGridOnFrames(const ImageF& mean_frame, const MicroLensGrid& start) {
  std::optional<GridFit> fit = RefineGrid(mean_frame, start);
  if (!fit) return std::nullopt;
  RefineByProfile(mean_frame, &*fit);
  CompareWithStart(mean_frame, start, &*fit);
  return fit;
}

namespace {

constexpr double kMinPitch = 6;  // px
constexpr double kMaxPitch = 120;

// The Fourier transform of the middle of an image under a Hann window.
class MiddleSpectrum {
 public:
  explicit MiddleSpectrum(const ImageF& image)
      : size_(std::min({image.width(), image.height(), 2048})),
        corner_((image.width() - size_) / 2, (image.height() - size_) / 2) {
    patch_ = cv::Mat(size_, size_, CV_32F);
    for (int y = 0; y < size_; ++y) {
      for (int x = 0; x < size_; ++x) {
        patch_.at<float>(y, x) = image(corner_.x() + x, corner_.y() + y);
      }
    }
    cv::Mat window;
    cv::createHanningWindow(window, patch_.size(), CV_32F);
    patch_ -= cv::mean(patch_);
    patch_ = patch_.mul(window);
    cv::Mat spectrum, parts[2];
    cv::dft(patch_, spectrum, cv::DFT_COMPLEX_OUTPUT);
    cv::split(spectrum, parts);
    const cv::Mat power = parts[0].mul(parts[0]) + parts[1].mul(parts[1]);
    constexpr int kAround = 7;  // bins
    constexpr int kPeak = 2;
    cv::Mat wrapped, around, near;
    cv::copyMakeBorder(power, wrapped, kAround, kAround, kAround, kAround, cv::BORDER_WRAP);
    const auto sum = [&](int reach) {
      cv::Mat sums;
      const cv::Size side(2 * reach + 1, 2 * reach + 1);
      cv::boxFilter(wrapped, sums, CV_64F, side, {-1, -1}, false);
      return cv::Mat(sums, {kAround, kAround, size_, size_}).clone();
    };
    constexpr int kRing = (2 * kAround + 1) * (2 * kAround + 1) - (2 * kPeak + 1) * (2 * kPeak + 1);
    background_ = (sum(kAround) - sum(kPeak)) / kRing;
    cv::dilate(power, power_, cv::Mat::ones(3, 3, CV_8U));
  }

  int size() const { return size_; }
  Eigen::Vector2d corner() const { return corner_.cast<double>(); }

  // At any frequency, cycles per px from the patch's corner.
  std::complex<double> At(const Eigen::Vector2d& k) const {
    std::complex<double> sum = 0;
    const std::complex<double> turn = std::polar(1.0, -2 * M_PI * k.x());
    for (int y = 0; y < size_; ++y) {
      std::complex<double> phase = std::polar(1.0, -2 * M_PI * k.y() * y);
      const float* row = patch_.ptr<float>(y);
      for (int x = 0; x < size_; ++x) {
        sum += static_cast<double>(row[x]) * phase;
        phase *= turn;
      }
    }
    return sum;
  }

  // The largest power within one bin of k, and how many times that of the bins around it is.
  struct Peak {
    double power, salience;
  };
  Peak PeakAt(const Eigen::Vector2d& k) const {
    const int u = (static_cast<int>(std::lround(k.x() * size_)) % size_ + size_) % size_;
    const int v = (static_cast<int>(std::lround(k.y() * size_)) % size_ + size_) % size_;
    const double power = power_.at<float>(v, u);
    return {power, power / std::max(background_.at<double>(v, u), 1e-9)};
  }

  // The frequency of the maximum near k.
  Eigen::Vector2d Climb(Eigen::Vector2d k) const {
    double best = std::abs(At(k));
    for (double step = 0.5 / size_; step > 0.01 / size_; step /= 2) {
      for (bool moved = true; moved;) {
        moved = false;
        for (const Eigen::Vector2d& d : {Eigen::Vector2d(step, 0),
                                         Eigen::Vector2d(-step, 0),
                                         Eigen::Vector2d(0, step),
                                         Eigen::Vector2d(0, -step)}) {
          const double value = std::abs(At(k + d));
          if (value > best) {
            best = value;
            k += d;
            moved = true;
          }
        }
      }
    }
    return k;
  }

 private:
  int size_;
  Eigen::Vector2i corner_;
  cv::Mat patch_, power_, background_;
};

// A lattice by the directions of its shortest reciprocal vectors, all of one length.
struct LatticeKind {
  double turn;             // between neighbouring reciprocal vectors, rad
  int vectors;             // of them in half a turn
  double pitch_of_unit;    // of a lattice whose reciprocal vectors have length 1
  double symmetry;         // turned by this it is the same
  Eigen::Vector2d base_y;  // to base_x = (1, 0)
};
const LatticeKind kHexagonal = {
    M_PI / 3, 3, 2 / std::sqrt(3.0), M_PI / 3, {0.5, 0.86602540378443864676}};
const LatticeKind kSquare = {M_PI / 2, 2, 1, M_PI / 2, {0, 1}};

struct Reciprocal {
  Eigen::Vector2d k = Eigen::Vector2d::Zero();
  double power = 0;  // geometric mean with those turned from it
};

// The shortest reciprocal vector of those that stand out together with the ones turned from it.
// Weaker ones are not taken: several lens types make a lattice of their own, wider than that of the
// lenses.
Reciprocal FindReciprocal(const MiddleSpectrum& spectrum, const LatticeKind& kind) {
  constexpr double kMinSalience = 20;
  constexpr double kWeak = 0.1;
  const int size = spectrum.size();
  std::vector<Reciprocal> candidates;
  double most = 0;
  for (int v = -size / 2; v < size / 2; ++v) {
    for (int u = 0; u < size / 2; ++u) {
      const Eigen::Vector2d k(static_cast<double>(u) / size, static_cast<double>(v) / size);
      const double pitch = kind.pitch_of_unit / std::max(k.norm(), 1e-9);
      if (pitch < kMinPitch || pitch > kMaxPitch) continue;
      double power = 1, salience = 1;
      for (int i = 0; i < kind.vectors; ++i) {
        const auto peak = spectrum.PeakAt(Eigen::Rotation2Dd(i * kind.turn) * k);
        power *= std::pow(peak.power, 1.0 / kind.vectors);
        salience *= std::pow(peak.salience, 1.0 / kind.vectors);
      }
      if (salience < kMinSalience) continue;
      candidates.push_back({k, power});
      most = std::max(most, power);
    }
  }
  const auto is_weak = [&](const Reciprocal& c) { return c.power < kWeak * most; };
  candidates.erase(std::remove_if(candidates.begin(), candidates.end(), is_weak), candidates.end());
  if (candidates.empty()) return {};
  const Reciprocal shortest = *std::min_element(
      candidates.begin(), candidates.end(), [](const Reciprocal& a, const Reciprocal& b) {
        return a.k.norm() < b.k.norm();
      });
  Reciprocal best = shortest;  // a bin on the flank of its peak
  for (const Reciprocal& candidate : candidates) {
    if ((candidate.k - shortest.k).norm() * size < 4 && candidate.power > best.power) {
      best = candidate;
    }
  }
  return best;
}

// The grid of the lattice with reciprocal vectors k1 and k2, by the phases of the spectrum.
std::optional<MicroLensGrid> GridOf(const MiddleSpectrum& spectrum,
                                    const LatticeKind& kind,
                                    const Eigen::Vector2d& k1,
                                    const ImageF& image) {
  const Eigen::Vector2d k2 = spectrum.Climb(Eigen::Rotation2Dd(kind.turn) * k1);
  if (std::abs(k2.norm() / k1.norm() - 1) > 0.05) return std::nullopt;
  // Lattice vectors a with a . k1, a . k2 integers.
  Eigen::Matrix2d reciprocal;
  reciprocal << k1.transpose(), k2.transpose();
  const Eigen::Matrix2d basis = reciprocal.inverse();
  const Eigen::Vector2d phases(-std::arg(spectrum.At(k1)) / (2 * M_PI),
                               -std::arg(spectrum.At(k2)) / (2 * M_PI));
  const Eigen::Vector2d middle(0.5 * (image.width() - 1), 0.5 * (image.height() - 1));
  const Eigen::Vector2d lattice = reciprocal * (middle - spectrum.corner()) - phases;
  const Eigen::Vector2d nearest =
      spectrum.corner() +
      basis * (Eigen::Vector2d(std::round(lattice.x()), std::round(lattice.y())) + phases);

  MicroLensGrid grid;
  grid.diameter_px = std::sqrt(basis.col(0).norm() * basis.col(1).norm());
  grid.offset_px = {nearest.x() - middle.x(), middle.y() - nearest.y()};
  grid.base_y = kind.base_y;
  // Orientation with y up, modulo the symmetry; a hexagonal lattice stands in rows (0) or columns.
  double angle = std::atan2(-basis(1, 0), basis(0, 0));
  angle -= kind.symmetry * std::round(angle / kind.symmetry);
  if (kind.vectors == 3 && std::abs(angle) > M_PI / 12) {
    grid.base_x = {0, 1};
    grid.base_y = {0.86602540378443864676, 0.5};
    angle -= angle > 0 ? M_PI / 6 : -M_PI / 6;
  }
  grid.rotation = angle;
  return grid;
}

// From the middle of the image outwards.
std::optional<GridFit> FindGrid(const ImageF& image) {
  if (std::min(image.width(), image.height()) < 64) return std::nullopt;
  const MiddleSpectrum spectrum(image);
  const Reciprocal hexagonal = FindReciprocal(spectrum, kHexagonal);
  const Reciprocal square = FindReciprocal(spectrum, kSquare);
  if (std::max(hexagonal.power, square.power) == 0) return std::nullopt;
  const bool is_square = square.power > hexagonal.power;
  const LatticeKind& kind = is_square ? kSquare : kHexagonal;
  const Eigen::Vector2d k1 = spectrum.Climb(is_square ? square.k : hexagonal.k);
  const std::optional<MicroLensGrid> grid = GridOf(spectrum, kind, k1, image);
  if (!grid) return std::nullopt;
  GridFit fit;
  fit.grid = *grid;
  for (double region = spectrum.size() / 2.0;; region *= 2) {
    if (!RefineByCentroids(image, region, &fit)) return std::nullopt;
    if (region > std::max(image.width(), image.height())) break;
  }
  fit.contrast = Contrast(image, fit.grid);
  return fit;
}

// Of what FindGrid finds in anything, only what is a grid.
std::optional<GridFit> OnlyIfItFits(std::optional<GridFit> fit) {
  constexpr double kMaxRms = 0.05;  // pitches
  constexpr double kMinContrast = 0.05;
  if (fit && fit->rms_px <= kMaxRms * fit->grid.diameter_px && fit->contrast >= kMinContrast) {
    return fit;
  }
  return std::nullopt;
}

}  // namespace

std::optional<GridFit> EstimateGrid(const ImageF& white) { return OnlyIfItFits(FindGrid(white)); }

std::optional<GridFit> EstimateGridOnFrames(const ImageF& mean_frame) {
  std::optional<GridFit> fit = FindGrid(mean_frame);
  if (!fit) return std::nullopt;
  RefineByProfile(mean_frame, &*fit);
  fit->contrast = Contrast(mean_frame, fit->grid);
  return OnlyIfItFits(fit);
}

ImageF MeanImage(const std::vector<cv::Mat>& images) {
  CHECK(!images.empty());
  ImageF mean(images[0].cols, images[0].rows, 0);
  cv::Mat sum(mean.height(), mean.width(), CV_32F, mean.data());
  for (const cv::Mat& image : images) {
    CHECK_EQ(image.cols, mean.width());
    CHECK_EQ(image.rows, mean.height());
    cv::Mat gray = image;
    if (image.channels() == 3) cv::cvtColor(image, gray, cv::COLOR_BGR2GRAY);
    cv::Mat scaled;
    const double count = static_cast<double>(images.size());
    gray.convertTo(scaled, CV_32F, (gray.depth() == CV_8U ? 1.0 : 1.0 / 257) / count);
    sum += scaled;
  }
  return mean;
}

}  // namespace prism
