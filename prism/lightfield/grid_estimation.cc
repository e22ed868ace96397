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
    // The third lens of a triangle is 60 degrees from the first two, on either base.
    const bool acute = grid.base_x.dot(grid.base_y) > 0;
    const Eigen::Vector2d c =
        grid.MicroImageCenter({lens.i + (acute ? 0 : 1), lens.j + 1}, width, height);
    const Eigen::Vector2d corner = (a + b + c) / 3;
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

std::optional<GridFit> EstimateGrid(const ImageF& white) {
  const int size = std::min({white.width(), white.height(), 512});
  if (size < 64) return std::nullopt;
  const int left = (white.width() - size) / 2;
  const int top = (white.height() - size) / 2;
  cv::Mat window;
  cv::createHanningWindow(window, cv::Size(size, size), CV_32F);
  cv::Mat patch(size, size, CV_32F);
  double mean = 0;
  for (int y = 0; y < size; ++y) {
    for (int x = 0; x < size; ++x) mean += white(left + x, top + y);
  }
  mean /= static_cast<double>(size) * size;
  for (int y = 0; y < size; ++y) {
    for (int x = 0; x < size; ++x) {
      patch.at<float>(y, x) =
          (white(left + x, top + y) - static_cast<float>(mean)) * window.at<float>(y, x);
    }
  }
  // Fourier coefficient at any frequency (cycles per px), by direct summation over a separable grid
  // of the transform near the peak would do; the peak itself is found on the FFT.
  cv::Mat spectrum;
  cv::dft(patch, spectrum, cv::DFT_COMPLEX_OUTPUT);
  const auto coefficient = [&](const Eigen::Vector2d& k) {
    std::complex<double> sum = 0;
    for (int y = 0; y < size; ++y) {
      std::complex<double> phase = std::polar(1.0, -2 * M_PI * (k.y() * y - k.x() * 0.0));
      const std::complex<double> turn = std::polar(1.0, -2 * M_PI * k.x());
      std::complex<double> row = 0;
      for (int x = 0; x < size; ++x) {
        row += static_cast<double>(patch.at<float>(y, x)) * phase;
        phase *= turn;
      }
      sum += row;
    }
    return sum;
  };
  Eigen::Vector2d k1(0, 0);
  double strongest = 0;
  for (int v = 0; v < size; ++v) {
    for (int u = 0; u <= size / 2; ++u) {
      const Eigen::Vector2d k(static_cast<double>(u) / size,
                              static_cast<double>(v < size / 2 ? v : v - size) / size);
      // A pitch D has reciprocal vectors of length 2 / (sqrt(3) D).
      const double pitch = 2 / (std::sqrt(3.0) * std::max(k.norm(), 1e-9));
      if (pitch < 6 || pitch > 120) continue;
      const cv::Vec2f c = spectrum.at<cv::Vec2f>(v, u);
      const double power = c[0] * c[0] + c[1] * c[1];
      if (power > strongest) {
        strongest = power;
        k1 = k;
      }
    }
  }
  if (strongest == 0) return std::nullopt;
  const auto climb = [&](Eigen::Vector2d k) {
    double best = std::abs(coefficient(k));
    for (double step = 0.5 / size; step > 0.01 / size; step /= 2) {
      for (bool moved = true; moved;) {
        moved = false;
        for (const Eigen::Vector2d& d : {Eigen::Vector2d(step, 0),
                                         Eigen::Vector2d(-step, 0),
                                         Eigen::Vector2d(0, step),
                                         Eigen::Vector2d(0, -step)}) {
          const double value = std::abs(coefficient(k + d));
          if (value > best) {
            best = value;
            k += d;
            moved = true;
          }
        }
      }
    }
    return k;
  };
  k1 = climb(k1);
  const Eigen::Vector2d k2 = climb(Eigen::Rotation2Dd(M_PI / 3) * k1);
  if (std::abs(k2.norm() / k1.norm() - 1) > 0.05 || std::norm(coefficient(k2)) < 0.1 * strongest) {
    return std::nullopt;
  }
  // Lattice vectors a with a . k1, a . k2 integers.
  Eigen::Matrix2d reciprocal;
  reciprocal << k1.transpose(), k2.transpose();
  const Eigen::Matrix2d basis = reciprocal.inverse();
  const Eigen::Vector2d phases(-std::arg(coefficient(k1)) / (2 * M_PI),
                               -std::arg(coefficient(k2)) / (2 * M_PI));
  const Eigen::Vector2d middle(0.5 * (white.width() - 1), 0.5 * (white.height() - 1));
  const Eigen::Vector2d corner(left, top);
  const Eigen::Vector2d lattice = reciprocal * (middle - corner) - phases;
  const Eigen::Vector2d nearest =
      corner + basis * (Eigen::Vector2d(std::round(lattice.x()), std::round(lattice.y())) + phases);

  GridFit fit;
  fit.grid.diameter_px = std::sqrt(basis.col(0).norm() * basis.col(1).norm());
  fit.grid.offset_px = {nearest.x() - middle.x(), middle.y() - nearest.y()};
  // Orientation of the lattice with y up, modulo 60 degrees; rows (0) or columns (30).
  double angle = std::atan2(-basis(1, 0), basis(0, 0));
  angle -= M_PI / 3 * std::round(angle / (M_PI / 3));  // -30 to 30 degrees
  if (std::abs(angle) > M_PI / 12) {
    fit.grid.base_x = {0, 1};
    fit.grid.base_y = {0.86602540378443864676, 0.5};
    angle -= angle > 0 ? M_PI / 6 : -M_PI / 6;
  }
  fit.grid.rotation = angle;
  for (double region = size / 2.0;; region *= 2) {
    if (!RefineByCentroids(white, region, &fit)) return std::nullopt;
    if (region > std::max(white.width(), white.height())) break;
  }
  fit.contrast = Contrast(white, fit.grid);
  return fit;
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
