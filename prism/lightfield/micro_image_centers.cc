// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
#include "prism/lightfield/micro_image_centers.h"

#include <algorithm>
#include <cmath>

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>
#include <Eigen/Dense>

namespace prism {
namespace {

// Centroid of the brightness within a disc that moves along with it; false if it leaves the image.
bool MeasureCentroid(const ImageF& image, double radius, Eigen::Vector2d* center) {
  const Eigen::Vector2d start = *center;
  constexpr int kIterations = 6;
  for (int iteration = 0; iteration < kIterations; ++iteration) {
    const int x0 = static_cast<int>(std::floor(center->x() - radius));
    const int y0 = static_cast<int>(std::floor(center->y() - radius));
    const int x1 = static_cast<int>(std::ceil(center->x() + radius));
    const int y1 = static_cast<int>(std::ceil(center->y() + radius));
    if (x0 < 0 || y0 < 0 || x1 >= image.width() || y1 >= image.height()) return false;
    double sum = 0, sum_x = 0, sum_y = 0;
    for (int y = y0; y <= y1; ++y) {
      for (int x = x0; x <= x1; ++x) {
        const double dx = x - center->x();
        const double dy = y - center->y();
        // A soft edge of one pixel keeps the centroid smooth in the centre.
        const double inside =
            std::clamp(radius - std::sqrt(dx * dx + dy * dy) + 0.5, 0.0, 1.0) * image(x, y);
        sum += inside;
        sum_x += inside * dx;
        sum_y += inside * dy;
      }
    }
    if (sum <= 0) return false;
    // The window takes about half of a shift away.
    const Eigen::Vector2d step = 2 * Eigen::Vector2d(sum_x, sum_y) / sum;
    *center += step;
    if (step.norm() < 1e-3) break;
  }
  return (*center - start).norm() < radius;
}

// The part of the plane nearest to one lens.
class Cell {
 public:
  Cell(const MicroLensGrid& grid, int width, int height) {
    const Eigen::Vector2d origin = grid.MicroImageCenter({0, 0}, width, height);
    for (int j = -2; j <= 2; ++j) {
      for (int i = -2; i <= 2; ++i) {
        const Eigen::Vector2d q = grid.MicroImageCenter({i, j}, width, height) - origin;
        const double length = q.norm();
        if (length > 0 && length < 1.5 * grid.diameter_px) sides_.push_back({q / length, length});
      }
    }
  }

  // The offsets (x, y) from the lens inside, `margin_px` from the rim, are those with x in
  // [first, last]; none if first > last.
  void Row(double y, double margin_px, double* first, double* last) const {
    *first = -1e9;
    *last = 1e9;
    for (const Side& side : sides_) {
      const double rest = 0.5 * side.length - margin_px - side.direction.y() * y;
      const double slope = side.direction.x();
      if (slope > 1e-6) {
        *last = std::min(*last, rest / slope);
      } else if (slope < -1e-6) {
        *first = std::max(*first, rest / slope);
      } else if (rest < 0) {
        *last = -1e9;
      }
    }
  }

 private:
  struct Side {
    Eigen::Vector2d direction;
    double length;
  };
  std::vector<Side> sides_;
};

// A function of the offset from a micro-image centre and its derivatives, on a grid of 1 px.
class Profile {
 public:
  explicit Profile(int reach) : reach_(reach), cells_(side() * side(), Eigen::Vector4d::Zero()) {}

  void Add(const Eigen::Vector2d& m, double value) {
    size_t index;
    double fx, fy;
    if (!Locate(m, &index, &fx, &fy)) return;
    const double weights[4] = {(1 - fx) * (1 - fy), fx * (1 - fy), (1 - fx) * fy, fx * fy};
    for (size_t k = 0; k < 4; ++k) {
      Eigen::Vector4d& cell = cells_[index + (k & 1) + (k & 2 ? side() : 0)];
      cell[0] += weights[k] * value;
      cell[3] += weights[k];
    }
  }

  void Finish() {
    for (Eigen::Vector4d& cell : cells_) cell[0] /= std::max(cell[3], 1e-9);
    for (size_t k = side() + 1; k + side() + 1 < cells_.size(); ++k) {
      cells_[k][1] = 0.5 * (cells_[k + 1][0] - cells_[k - 1][0]);
      cells_[k][2] = 0.5 * (cells_[k + side()][0] - cells_[k - side()][0]);
    }
  }

  // Value and derivatives in x and y.
  Eigen::Vector3d At(const Eigen::Vector2d& m) const {
    size_t index;
    double fx, fy;
    if (!Locate(m, &index, &fx, &fy)) return Eigen::Vector3d::Zero();
    const Eigen::Vector4d* v = &cells_[index];
    const Eigen::Vector4d above = (1 - fx) * v[0] + fx * v[1];
    const Eigen::Vector4d below = (1 - fx) * v[side()] + fx * v[side() + 1];
    return ((1 - fy) * above + fy * below).head<3>();
  }

 private:
  size_t side() const { return 2 * static_cast<size_t>(reach_) + 1; }
  bool Locate(const Eigen::Vector2d& m, size_t* index, double* fx, double* fy) const {
    const double x = m.x() + reach_;
    const double y = m.y() + reach_;
    if (!(x >= 0 && y >= 0 && x < 2 * reach_ && y < 2 * reach_)) return false;
    const auto x0 = static_cast<size_t>(x);
    const auto y0 = static_cast<size_t>(y);
    *index = y0 * side() + x0;
    *fx = x - static_cast<double>(x0);
    *fy = y - static_cast<double>(y0);
    return true;
  }

  int reach_;
  std::vector<Eigen::Vector4d> cells_;  // value, derivatives, weight
};

// Calls use(m, pixel) for the pixels of a cell around `center`.
template <typename Use>
void ForEachPixel(const ImageF& image,
                  const Cell& cell,
                  double margin_px,
                  int reach,
                  const Eigen::Vector2d& center,
                  const Use& use) {
  const int cx = static_cast<int>(std::lround(center.x()));
  const int cy = static_cast<int>(std::lround(center.y()));
  for (int y = cy - reach; y <= cy + reach; ++y) {
    double first, last;
    cell.Row(y - center.y(), margin_px, &first, &last);
    const int x0 = static_cast<int>(std::ceil(std::max<double>(cx - reach, center.x() + first)));
    const int x1 = static_cast<int>(std::floor(std::min<double>(cx + reach, center.x() + last)));
    for (int x = x0; x <= x1; ++x) {
      use(Eigen::Vector2d(x - center.x(), y - center.y()), image(x, y));
    }
  }
}

Profile MeanProfile(const ImageF& log_image,
                    const Cell& cell,
                    int reach,
                    const std::vector<MeasuredCenter>& lenses,
                    double pitch) {
  constexpr double kBeyondRim = -1.5;  // px, for the differences at the rim
  Profile profile(reach);
  for (const MeasuredCenter& lens : lenses) {
    double sum = 0;
    int count = 0;
    ForEachPixel(log_image, cell, 0.25 * pitch, reach, lens.center, [&](const auto&, float value) {
      sum += value;
      ++count;
    });
    const double mean = sum / std::max(count, 1);
    ForEachPixel(log_image, cell, kBeyondRim, reach, lens.center, [&](const auto& m, float value) {
      profile.Add(m, value - mean);
      profile.Add(-m, value - mean);
    });
  }
  profile.Finish();
  return profile;
}

// Moves the centre by d and sets the weight; false if d is not determined.
bool FitShift(const ImageF& log_image,
              const Cell& cell,
              int reach,
              const Profile& profile,
              double pitch,
              MeasuredCenter* lens) {
  using Vector5d = Eigen::Matrix<double, 5, 1>;
  using Matrix5d = Eigen::Matrix<double, 5, 5>;
  Matrix5d H = Matrix5d::Zero();
  Vector5d b = Vector5d::Zero();
  double squares = 0;
  int count = 0;
  ForEachPixel(log_image, cell, 0.5, reach, lens->center, [&](const auto& m, float value) {
    const Eigen::Vector3d p = profile.At(m);
    Vector5d J;  // unknowns: d, a, b
    J << -p[1], -p[2], 1, m.x() / pitch, m.y() / pitch;
    const double r = value - p[0];
    H += J * J.transpose();
    b += J * r;
    squares += r * r;
    ++count;
  });
  const Matrix5d inverse = H.inverse();
  // Rims that are steep against the middle tell d from b; without, a gradient looks like a shift.
  constexpr double kMaxInflation = 8;  // of the variance of d by b; 3 to 4 for real cameras
  const Eigen::Matrix3d without_gradient = H.topLeftCorner<3, 3>().inverse();
  const double inflation =
      (inverse(0, 0) + inverse(1, 1)) / (without_gradient(0, 0) + without_gradient(1, 1));
  const Vector5d solution = inverse * b;
  const double residual = std::max(squares - solution.dot(b), 0.0) / count;
  const double variance = residual * (inverse(0, 0) + inverse(1, 1));
  if (!(variance < 0.0625 * pitch * pitch && inflation < kMaxInflation)) return false;
  Eigen::Vector2d d = solution.head<2>();
  const double longest = 0.13 * pitch;  // as far as the profile is about linear
  if (d.norm() > longest) d *= longest / d.norm();
  lens->center += d;
  lens->weight = 1 / (variance + 0.01);
  return true;
}

}  // namespace

std::vector<LensIndex> LensesWithin(const MicroLensGrid& grid,
                                    int width,
                                    int height,
                                    double region) {
  std::vector<LensIndex> lenses;
  const int reach = static_cast<int>(1.6 * std::max(width, height) / grid.diameter_px) + 2;
  for (int j = -reach; j <= reach; ++j) {
    for (int i = -reach; i <= reach; ++i) {
      const Eigen::Vector2d center = grid.MicroImageCenter({i, j}, width, height);
      const Eigen::Vector2d middle(0.5 * (width - 1), 0.5 * (height - 1));
      if ((center - middle).cwiseAbs().maxCoeff() > region) continue;
      if (center.x() < 0 || center.y() < 0 || center.x() > width - 1 || center.y() > height - 1) {
        continue;
      }
      lenses.push_back({i, j});
    }
  }
  return lenses;
}

std::vector<MeasuredCenter> MeasureCentroids(const ImageF& image,
                                             const MicroLensGrid& grid,
                                             double region) {
  std::vector<MeasuredCenter> measured;
  for (const LensIndex& lens : LensesWithin(grid, image.width(), image.height(), region)) {
    MeasuredCenter m{lens, grid.MicroImageCenter(lens, image.width(), image.height())};
    if (MeasureCentroid(image, 0.45 * grid.diameter_px, &m.center)) measured.push_back(m);
  }
  return measured;
}

std::vector<MeasuredCenter> MeasureByProfile(const ImageF& image, const MicroLensGrid& grid) {
  const int width = image.width();
  const int height = image.height();
  const double pitch = grid.diameter_px;
  ImageF log_image(width, height);
  constexpr float kDark = 4;  // gray values: keeps the noise of dark pixels small
  std::transform(image.data(), image.data() + image.size(), log_image.data(), [](float value) {
    return std::log(std::max(value, 0.0f) + kDark);
  });
  const int reach = static_cast<int>(std::ceil(0.6 * pitch)) + 1;
  std::vector<MeasuredCenter> lenses;
  for (const LensIndex& lens : LensesWithin(grid, width, height, 1e9)) {
    const Eigen::Vector2d center = grid.MicroImageCenter(lens, width, height);
    if (image.view().Contains(center.x(), center.y(), reach + 1)) lenses.push_back({lens, center});
  }
  const Cell cell(grid, width, height);
  const Profile profile = MeanProfile(log_image, cell, reach, lenses, pitch);
  std::vector<char> determined(lenses.size());
  tbb::parallel_for(tbb::blocked_range<size_t>(0, lenses.size()), [&](const auto& range) {
    for (size_t k = range.begin(); k != range.end(); ++k) {
      determined[k] = FitShift(log_image, cell, reach, profile, pitch, &lenses[k]);
    }
  });
  std::vector<MeasuredCenter> measured;
  for (size_t k = 0; k < lenses.size(); ++k) {
    if (determined[k]) measured.push_back(lenses[k]);
  }
  return measured;
}

}  // namespace prism
