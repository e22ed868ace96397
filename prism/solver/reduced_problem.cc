// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
#include "prism/solver/reduced_problem.h"

#include <algorithm>
#include <cmath>

#include <glog/logging.h>
#include <tbb/parallel_for.h>

#include "prism/solver/gram_kernel.h"
#include "prism/solver/linearize.h"

namespace prism {
namespace {

constexpr int kPointsPerChunk = 64;

// Evaluates factors one after the other in buffers of its own.
class FactorEvaluator {
 public:
  FactorEvaluator(const FactorGraph& graph, const std::vector<const ceres::CostFunction*>& costs)
      : graph_(graph), costs_(costs) {}

  // With Jacobians of those blocks for which wants(block) holds; `point` (-1: none) has the value
  // `rho` instead of the graph's.
  template <typename Wants>
  void Evaluate(int index, int point, const double& rho, const Wants& wants) {
    const FactorGraph::Factor& factor = graph_.factors()[index];
    blocks_ = graph_.BlocksOf(factor);
    num_blocks_ = factor.num_blocks;
    num_rows_ = costs_[index]->num_residuals();
    residuals_.resize(num_rows_);
    size_t size = 0;
    for (int k = 0; k < num_blocks_; ++k) size += graph_.blocks()[blocks_[k]].kind->size;
    buffer_.resize(size * num_rows_);
    parameters_.clear();
    jacobians_.clear();
    double* jacobian = buffer_.data();
    for (int k = 0; k < num_blocks_; ++k) {
      const int block = blocks_[k];
      parameters_.push_back(block == point ? &rho : graph_.values(block));
      jacobians_.push_back(wants(block) ? jacobian : nullptr);
      jacobian += static_cast<size_t>(graph_.blocks()[block].kind->size) * num_rows_;
    }
    CHECK(costs_[index]->Evaluate(parameters_.data(), residuals_.data(), jacobians_.data()));
    double s = 0;
    for (const double r : residuals_) s += r * r;
    double loss[3] = {s, 1, 0};
    if (factor.loss != nullptr) factor.loss->Evaluate(s, loss);
    cost_ = 0.5 * loss[0];
    weight_ = loss[1];
  }

  int num_rows() const { return num_rows_; }
  int num_blocks() const { return num_blocks_; }
  int block(int k) const { return blocks_[k]; }
  int BlockSize(int k) const { return graph_.blocks()[blocks_[k]].kind->size; }
  const std::vector<double>& residuals() const { return residuals_; }
  const double* jacobian(int k) const { return jacobians_[k]; }  // row-major
  double cost() const { return cost_; }
  double weight() const { return weight_; }

 private:
  const FactorGraph& graph_;
  const std::vector<const ceres::CostFunction*>& costs_;
  std::vector<const double*> parameters_;
  std::vector<double*> jacobians_;
  std::vector<double> residuals_, buffer_;
  const int* blocks_ = nullptr;
  int num_blocks_ = 0, num_rows_ = 0;
  double cost_ = 0, weight_ = 1;
};

// Of the cost of one point's factors, over its one number.
struct Parabola {
  double cost = 0, g = 0, H = 0;
  int defined = 0;  // factors that depend on it
};

Parabola EvaluatePoint(int block,
                       const std::vector<int>& factors,
                       double rho,
                       FactorEvaluator* evaluator) {
  Parabola parabola;
  for (const int factor : factors) {
    evaluator->Evaluate(factor, block, rho, [&](int other) { return other == block; });
    parabola.cost += evaluator->cost();
    for (int k = 0; k < evaluator->num_blocks(); ++k) {
      const double* const J = evaluator->jacobian(k);
      if (J == nullptr) continue;
      double JJ = 0, Jr = 0;
      for (int row = 0; row < evaluator->num_rows(); ++row) {
        JJ += J[row] * J[row];
        Jr += J[row] * evaluator->residuals()[row];
      }
      parabola.H += evaluator->weight() * JJ;
      parabola.g += evaluator->weight() * Jr;
      parabola.defined += JJ > 0;
    }
  }
  return parabola;
}

struct Minimum {
  double value, cost;
  double cost_before;
};

// Where the factors of a point cost least, by Gauss and Newton's steps, shortened where they cost
// more. A step by which a factor is no longer defined, as where it leaves an image, is none.
Minimum MinimizePoint(int block,
                      const std::vector<int>& factors,
                      double value,
                      double tolerance,
                      FactorEvaluator* evaluator) {
  constexpr int kMaxSteps = 4;
  Parabola at = EvaluatePoint(block, factors, value, evaluator);
  const double cost_before = at.cost;
  double damping = 1;
  for (int i = 0; i < kMaxSteps; ++i) {
    if (!(at.H > 0) || 0.5 * at.g * at.g / at.H <= tolerance * at.cost) break;
    const double candidate = value - damping * at.g / at.H;
    const Parabola next = EvaluatePoint(block, factors, candidate, evaluator);
    if (next.cost < at.cost && next.defined >= at.defined) {
      value = candidate;
      at = next;
    } else {
      damping *= 0.3;
    }
  }
  return {value, at.cost, cost_before};
}

}  // namespace

// Sums over some of the factors. The stored numbers of all blocks, with the gradient as one column
// more: the upper triangle of [H, g; g^T, .].
struct ReducedProblem::Chunk {
  double cost = 0, cost_before = 0;
  Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor> H;
  // A column a point: its coupling to the other blocks and its gradient over sqrt(H_point).
  Eigen::MatrixXd coupling;

  void Reset(int size, int num_points) {
    H.setZero(size + 1, size + 1);
    coupling.setZero(size + 1, num_points);
  }

  // Adds a factor; the products with the column of the point go to `point_column` and `H_point`.
  void Add(const FactorEvaluator& factor,
           int point,
           const std::vector<int>& column_of,
           double* point_column,
           double* H_point) {
    columns.clear();
    for (int k = 0; k < factor.num_blocks(); ++k) {
      const bool is_point = factor.block(k) == point;
      const int column = is_point ? kPoint : column_of[factor.block(k)];
      for (int i = 0; i < factor.BlockSize(k) && (is_point || column >= 0); ++i) {
        columns.push_back(is_point ? kPoint : column + i);
      }
    }
    columns.push_back(static_cast<int>(H.rows()) - 1);
    const size_t width = columns.size();
    const size_t stride = (width + kGramLanes - 1) / kGramLanes * kGramLanes;
    FillRows(factor, point, column_of, stride);
    gram.resize(stride * stride);
    UpperGram(rows.data(), factor.num_rows(), width, stride, gram.data());
    for (size_t i = 0; i < width; ++i) {
      for (size_t j = i; j < width; ++j) {
        const double product = gram[i * stride + j];
        const int a = std::min(columns[i], columns[j]), b = std::max(columns[i], columns[j]);
        if (a != kPoint) {
          H(a, b) += product;
        } else if (b != kPoint) {
          point_column[b] += product;
        } else {
          *H_point += product;
        }
      }
    }
  }

 private:
  static constexpr int kPoint = -1;

  // sqrt(weight) [J, r], row by row.
  void FillRows(const FactorEvaluator& factor,
                int point,
                const std::vector<int>& column_of,
                size_t stride) {
    const double root = std::sqrt(factor.weight());
    rows.assign(stride * factor.num_rows(), 0);
    for (int row = 0; row < factor.num_rows(); ++row) {
      double* out = rows.data() + row * stride;
      for (int k = 0; k < factor.num_blocks(); ++k) {
        if (factor.block(k) != point && column_of[factor.block(k)] < 0) continue;
        const int size = factor.BlockSize(k);
        const double* const J = factor.jacobian(k) + static_cast<size_t>(row) * size;
        for (int i = 0; i < size; ++i) *out++ = root * J[i];
      }
      *out = root * factor.residuals()[row];
    }
  }

  std::vector<int> columns;  // of H, of each column of a factor
  std::vector<double> rows, gram;
};

ReducedProblem::ReducedProblem(FactorGraph* graph, double tolerance)
    : graph_(graph), tolerance_(tolerance) {
  const std::vector<bool> is_eliminated = FindEliminated();
  std::vector<int> number(graph->blocks().size(), -1);
  for (size_t i = 0; i < graph->factors().size(); ++i) {
    const FactorGraph::Factor& factor = graph->factors()[i];
    if (NeedsFirstEstimateCost(*graph, factor)) {
      wrapped_.push_back(std::make_unique<FirstEstimateCost>(*graph, factor));
      costs_.push_back(wrapped_.back().get());
    } else {
      costs_.push_back(factor.cost);
    }
    const int* const begin = graph->BlocksOf(factor);
    const int* const point =
        std::find_if(begin, begin + factor.num_blocks, [&](int b) { return is_eliminated[b]; });
    if (point == begin + factor.num_blocks) {
      other_factors_.push_back(static_cast<int>(i));
      continue;
    }
    if (number[*point] < 0) {
      number[*point] = static_cast<int>(points_.size());
      const double value = *graph->values(*point);
      points_.push_back({*point, {}, value, value});
    }
    points_[number[*point]].factors.push_back(static_cast<int>(i));
  }
  AssignColumns(is_eliminated);
}

ReducedProblem::~ReducedProblem() = default;

std::vector<bool> ReducedProblem::FindEliminated() const {
  std::vector<bool> is_eliminated;
  for (const FactorGraph::Block& block : graph_->blocks()) {
    is_eliminated.push_back(block.IsPoint() && !block.is_constant && block.kind->size == 1 &&
                            block.kind->manifold == nullptr);
  }
  for (const FactorGraph::Factor& factor : graph_->factors()) {
    bool has_one = false;
    for (int k = 0; k < factor.num_blocks; ++k) {
      const int block = graph_->BlocksOf(factor)[k];
      if (!is_eliminated[block]) continue;
      is_eliminated[block] = !has_one;
      has_one = true;
    }
  }
  return is_eliminated;
}

void ReducedProblem::AssignColumns(const std::vector<bool>& is_eliminated) {
  const std::vector<FactorGraph::Block>& blocks = graph_->blocks();
  std::vector<bool> has_factor(blocks.size(), false);
  for (const FactorGraph::Factor& factor : graph_->factors()) {
    for (int k = 0; k < factor.num_blocks; ++k) has_factor[graph_->BlocksOf(factor)[k]] = true;
  }
  column_.assign(blocks.size(), -1);
  for (size_t i = 0; i < blocks.size(); ++i) {
    if (is_eliminated[i] || blocks[i].is_constant || !has_factor[i]) continue;
    blocks_.push_back(static_cast<int>(i));
    column_[i] = stored_size_;
    stored_size_ += blocks[i].kind->size;
    tangent_size_ += blocks[i].kind->TangentSize();
  }
}

void ReducedProblem::EvaluateChunk(int index, bool is_new_state, bool linearize, Chunk* chunk) {
  FactorEvaluator evaluator(*graph_, costs_);
  const size_t first = static_cast<size_t>(index) * kPointsPerChunk;
  const size_t last = std::min(first + kPointsPerChunk, points_.size());
  if (linearize) chunk->Reset(stored_size_, static_cast<int>(last - first));
  for (size_t i = first; i < last; ++i) {
    EliminatedPoint& point = points_[i];
    const Minimum minimum = MinimizePoint(point.block,
                                          point.factors,
                                          is_new_state ? point.linearized : point.last,
                                          tolerance_,
                                          &evaluator);
    point.last = minimum.value;
    chunk->cost += minimum.cost;
    chunk->cost_before += minimum.cost_before;
    if (!linearize) continue;
    point.linearized = point.last;
    double* const coupling = chunk->coupling.col(static_cast<Eigen::Index>(i - first)).data();
    double H_point = 0;
    for (const int factor : point.factors) {
      evaluator.Evaluate(factor, point.block, point.last, [&](int block) {
        return block == point.block || column_[block] >= 0;
      });
      chunk->Add(evaluator, point.block, column_, coupling, &H_point);
    }
    const double scale = H_point > 0 ? 1 / std::sqrt(H_point) : 0;
    for (int k = 0; k <= stored_size_; ++k) coupling[k] *= scale;
  }
  if (linearize) chunk->H.selfadjointView<Eigen::Upper>().rankUpdate(chunk->coupling, -1);
}

double ReducedProblem::Evaluate(bool is_new_state, Linearization* linearization) {
  const bool linearize = linearization != nullptr;
  const int num_chunks = (static_cast<int>(points_.size()) + kPointsPerChunk - 1) / kPointsPerChunk;
  std::vector<Chunk> chunks(num_chunks);
  tbb::parallel_for(
      0, num_chunks, [&](int i) { EvaluateChunk(i, is_new_state, linearize, &chunks[i]); });
  Chunk sum;
  if (linearize) sum.Reset(stored_size_, 0);
  FactorEvaluator evaluator(*graph_, costs_);
  for (const int factor : other_factors_) {
    evaluator.Evaluate(factor, -1, 0, [&](int block) { return linearize && column_[block] >= 0; });
    sum.cost += evaluator.cost();
    if (linearize) sum.Add(evaluator, -1, column_, nullptr, nullptr);
  }
  sum.cost_before = sum.cost;
  for (const Chunk& chunk : chunks) {
    sum.cost += chunk.cost;
    sum.cost_before += chunk.cost_before;
    if (linearize) sum.H += chunk.H;
  }
  if (initial_cost_ < 0) initial_cost_ = sum.cost_before;
  if (linearize) {
    Eigen::MatrixXd H =
        sum.H.topLeftCorner(stored_size_, stored_size_).selfadjointView<Eigen::Upper>();
    ReduceToTangent(H, sum.H.col(stored_size_).head(stored_size_), linearization);
  }
  return sum.cost;
}

void ReducedProblem::ReduceToTangent(const Eigen::MatrixXd& H,
                                     const Eigen::VectorXd& g,
                                     Linearization* linearization) const {
  Eigen::MatrixXd plus = Eigen::MatrixXd::Zero(stored_size_, tangent_size_);
  int column = 0;
  for (const int i : blocks_) {
    const BlockKind& kind = *graph_->blocks()[i].kind;
    plus.block(column_[i], column, kind.size, kind.TangentSize()) =
        kind.PlusJacobian(graph_->values(i));
    column += kind.TangentSize();
  }
  linearization->H = plus.transpose() * H * plus;
  linearization->g = plus.transpose() * g;
}

void ReducedProblem::StorePoints() {
  for (const EliminatedPoint& point : points_) *graph_->values(point.block) = point.linearized;
}

}  // namespace prism
