// SPDX-FileCopyrightText: 2026 The cloud_colorizer authors
// SPDX-License-Identifier: BSD-3-Clause
#include "color/conjugate_gradients.hpp"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>

#include "cloud_colorizer/base/check.hpp"
#include "color/singular.hpp"

namespace cloud_colorizer {
namespace {

using Eigen::Index;

/// Of the error, relative to the solution: 0.001 of 255 levels.
constexpr double kTolerance = 1e-5;
/// A squared norm below it is that of a column that is done.
constexpr double kNothing = 1e-200;
constexpr int kMaxIterations = 20000;

/// The eigenvalues that conjugate gradients see of their matrix: those of the tridiagonal matrix of Lanczos' iteration.
/// Y. Saad, "Iterative methods for sparse linear systems", 2nd edition, 2003, section 6.7.3.
class RitzValues {
 public:
  void add(double alpha, double beta) {
    diagonal_.push_back(1 / alpha + coupling_);
    beside_.push_back(std::sqrt(beta) / alpha);
    coupling_ = beta / alpha;
  }

  double smallest() const {
    const auto size = static_cast<Index>(diagonal_.size());
    Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> solver;
    solver.computeFromTridiagonal(Eigen::Map<const Eigen::VectorXd>(diagonal_.data(), size),
                                  Eigen::Map<const Eigen::VectorXd>(beside_.data(), size - 1), Eigen::EigenvaluesOnly);
    return solver.eigenvalues()[0];
  }

 private:
  std::vector<double> diagonal_, beside_;
  double coupling_ = 0;
};

}  // namespace

ConjugateGradients::ConjugateGradients(const Eigen::SparseMatrix<double>& lower) : size_(lower.cols()) {
  scale_.reserve(static_cast<std::size_t>(size_));
  offsets_.reserve(static_cast<std::size_t>(size_) + 1);
  rows_.reserve(static_cast<std::size_t>(lower.nonZeros() - size_));
  values_.reserve(rows_.capacity());
  const int* begins = lower.outerIndexPtr();
  for (Index j = 0; j < size_; ++j) {
    const double diagonal = lower.innerIndexPtr()[begins[j]] == j ? lower.valuePtr()[begins[j]] : 0;
    require(diagonal > 0, "the system of ", size_, " points is not positive definite: row ", j, " has ", diagonal,
            " on its diagonal");
    scale_.push_back(1 / std::sqrt(diagonal));
  }
  offsets_.assign(1, 0);
  for (Index j = 0; j < size_; ++j) {
    for (int k = begins[j] + 1; k < begins[j + 1]; ++k) {
      const int i = lower.innerIndexPtr()[k];
      rows_.push_back(i);
      values_.push_back(lower.valuePtr()[k] * scale_[static_cast<std::size_t>(i)] *
                        scale_[static_cast<std::size_t>(j)]);
    }
    offsets_.push_back(static_cast<int>(rows_.size()));
  }
  constant_quotient_ = constantQuotient();
}

/// The Rayleigh quotient of equal values everywhere, which few anchors hardly hold. The iteration may see nothing of
/// them until all else is done.
double ConjugateGradients::constantQuotient() const {
  double sum = 0, norm = 0;
  for (Index j = 0; j < size_; ++j) {
    double backward = 1 / scale_[j];  // (1 + L') x
    for (int k = offsets_[j]; k < offsets_[j + 1]; ++k) backward += values_[k] / scale_[rows_[k]];
    sum += (2 * backward - 1 / scale_[j]) / scale_[j];
    norm += backward * backward;
  }
  return std::clamp(sum / norm, kSingular, 1.0);
}

/// rhs becomes (1 + L)^-1 (rhs - (1 + L + L') solution).
void ConjugateGradients::toResidual(const LaneRows& solution, LaneRows& rhs) const {
  for (Index j = 0; j < size_; ++j) {
    Lanes at_j = rhs.row(j) - solution.row(j);
    for (int k = offsets_[j]; k < offsets_[j + 1]; ++k) at_j -= values_[k] * solution.row(rows_[k]);
    rhs.row(j) = at_j;
    at_j += solution.row(j);
    for (int k = offsets_[j]; k < offsets_[j + 1]; ++k) rhs.row(rows_[k]) -= values_[k] * at_j;
  }
}

/// direction = residual + beta direction, backward = (1 + L')^-1 direction, and the image of the direction:
///   (1 + L)^-1 (1 + L + L') (1 + L')^-1 direction = backward + (1 + L)^-1 (direction - backward)
/// Returns direction' image.
ConjugateGradients::Lanes ConjugateGradients::step(const Lanes& beta, const LaneRows& residual, LaneRows& direction,
                                                   LaneRows& backward, LaneRows& image) const {
  for (Index j = size_ - 1; j >= 0; --j) {
    const Lanes at_j = residual.row(j) + beta * direction.row(j);
    Lanes sum = at_j;
    for (int k = offsets_[j]; k < offsets_[j + 1]; ++k) sum -= values_[k] * backward.row(rows_[k]);
    direction.row(j) = at_j;
    backward.row(j) = sum;
    image.row(j) = at_j - sum;
  }
  Lanes product = Lanes::Zero();
  for (Index j = 0; j < size_; ++j) {
    Lanes at_j = image.row(j);
    for (int k = offsets_[j]; k < offsets_[j + 1]; ++k) image.row(rows_[k]) -= values_[k] * at_j;
    at_j += backward.row(j);
    image.row(j) = at_j;
    product += at_j * direction.row(j);
  }
  return product;
}

void ConjugateGradients::solveLanes(LaneRows& residual, LaneRows& solution) const {
  toResidual(solution, residual);
  Lanes norm = residual.square().colwise().sum(), beta = Lanes::Zero();
  const Lanes guess_norm = solution.square().colwise().sum();
  Lanes solution_norm;
  Index lane = 0;  // of the largest residual: its iteration tells the eigenvalues, which all lanes share
  norm.maxCoeff(&lane);
  RitzValues ritz;
  double smallest = constant_quotient_;  // eigenvalue; an error is at most as large as the residual divided by it
  const auto isEnough = [&] {
    return (norm <= std::pow(kTolerance * smallest, 2) * (guess_norm + solution_norm)).all();
  };
  LaneRows direction = LaneRows::Zero(size_, kLanes), backward(size_, kLanes), image(size_, kLanes);
  for (int i = 0; !(norm < kNothing).all(); ++i) {
    require(i < kMaxIterations && norm.isFinite().all(), "conjugate gradients do not converge on a system of ", size_,
            " points; set solver to cholmod");
    const Lanes product = step(beta, residual, direction, backward, image);
    requireRegular((norm < kNothing || product > kSingular * norm).all(), size_, "singular or indefinite");
    const Lanes alpha = (norm < kNothing).select(0, norm / product);
    Lanes next = Lanes::Zero();
    solution_norm.setZero();
    for (Index j = 0; j < size_; ++j) {
      const Lanes solution_j = solution.row(j) + alpha * backward.row(j);
      const Lanes residual_j = residual.row(j) - alpha * image.row(j);
      solution.row(j) = solution_j;
      residual.row(j) = residual_j;
      solution_norm += solution_j.square();
      next += residual_j.square();
    }
    beta = (norm < kNothing).select(0, next / norm);
    if (norm(lane) > kNothing) ritz.add(alpha(lane), beta(lane));
    norm = next;
    if (!isEnough()) continue;
    smallest = std::min(smallest, ritz.smallest());  // it sinks with every iteration, so it is looked for only now
    if (isEnough()) break;
  }
}

Eigen::MatrixXd ConjugateGradients::solve(const Eigen::MatrixXd& rhs, const Eigen::MatrixXd& guess) const {
  const Eigen::Map<const Eigen::ArrayXd> scale(scale_.data(), size_);
  Eigen::MatrixXd result(rhs.rows(), rhs.cols());
  for (Index first = 0; first < rhs.cols(); first += kLanes) {
    const Index count = std::min<Index>(kLanes, rhs.cols() - first);
    LaneRows residual = LaneRows::Zero(size_, kLanes), solution = LaneRows::Zero(size_, kLanes);
    residual.leftCols(count) = rhs.middleCols(first, count).array().colwise() * scale;
    solution.leftCols(count) = guess.middleCols(first, count).array().colwise() / scale;
    solveLanes(residual, solution);
    result.middleCols(first, count) = solution.leftCols(count).colwise() * scale;
  }
  return result;
}

}  // namespace cloud_colorizer
