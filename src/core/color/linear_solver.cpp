// SPDX-FileCopyrightText: 2026 The cloud_colorizer authors
// SPDX-License-Identifier: BSD-3-Clause
#include "cloud_colorizer/color/linear_solver.hpp"

#include <Eigen/CholmodSupport>
#include <Eigen/SPQRSupport>
#include <utility>
#include <vector>

#include "cloud_colorizer/base/check.hpp"
#include "color/conjugate_gradients.hpp"
#include "color/singular.hpp"

namespace cloud_colorizer {

struct LinearSolver::Impl {
  explicit Impl(Eigen::Index n) : size(n) {}
  virtual ~Impl() = default;
  Impl(const Impl&) = delete;
  Impl& operator=(const Impl&) = delete;
  virtual Eigen::MatrixXd solve(const Eigen::MatrixXd& rhs, const Eigen::MatrixXd& guess) = 0;

  const Eigen::Index size;
};

namespace {

using Lower = Eigen::SparseMatrix<double>;

void checkStatus(int status, Eigen::Index size) {
  requireRegular(status != CHOLMOD_NOT_POSDEF, size, "not positive definite");
  require(status != CHOLMOD_OUT_OF_MEMORY, "out of memory while factoring ", size, " points; use smaller chunks");
  require(status != CHOLMOD_TOO_LARGE, "the factor of ", size, " points exceeds 32-bit indices; use smaller chunks");
  require(status >= CHOLMOD_OK, "CHOLMOD failed with status ", status, " on ", size, " points");
}

class ConjugateGradientsImpl : public LinearSolver::Impl {
 public:
  explicit ConjugateGradientsImpl(const Lower& lower) : Impl(lower.cols()), gradients_(lower) {}

  Eigen::MatrixXd solve(const Eigen::MatrixXd& rhs, const Eigen::MatrixXd& guess) override {
    return gradients_.solve(rhs, guess);
  }

 private:
  ConjugateGradients gradients_;
};

/// L L' of P A P'. A Z-order graph, which comes with its order, is nearly one-dimensional: simplicial, for it has no
/// dense blocks for a BLAS. For any other graph CHOLMOD chooses the ordering and the kind of factor.
class CholmodImpl : public LinearSolver::Impl {
 public:
  CholmodImpl(const Lower& lower, const std::vector<int>& order) : Impl(lower.cols()), permutation_(lower.cols()) {
    cholmod_common& common = factor_.cholmod();
    common.print = 0;
    if (order.empty()) {
      factor_.setMode(Eigen::CholmodAuto);
      common.final_ll = 1;  // L D L' would accept an indefinite matrix
      permutation_.setIdentity();
      factor(lower);
      return;
    }
    factor_.setMode(Eigen::CholmodSimplicialLLt);
    common.nmethods = 1;
    common.method[0].ordering = CHOLMOD_NATURAL;  // of what is permuted already
    common.postorder = 0;
    for (std::size_t i = 0; i < order.size(); ++i) permutation_.indices()[order[i]] = static_cast<int>(i);
    Lower permuted(size, size);
    permuted.selfadjointView<Eigen::Lower>() = lower.selfadjointView<Eigen::Lower>().twistedBy(permutation_);
    factor(Lower(permuted.transpose()).transpose());  // twice, to sort the rows
  }

  Eigen::MatrixXd solve(const Eigen::MatrixXd& rhs, const Eigen::MatrixXd&) override {
    const Eigen::MatrixXd solution = factor_.solve(permutation_ * rhs);
    checkStatus(factor_.cholmod().status, size);
    return permutation_.transpose() * solution;
  }

 private:
  struct Factor : Eigen::CholmodDecomposition<Lower, Eigen::Lower> {
    double reciprocalCondition() { return cholmod_rcond(m_cholmodFactor, &cholmod()); }
  };

  void factor(const Lower& lower) {
    factor_.analyzePattern(lower);
    checkStatus(factor_.cholmod().status, size);
    factor_.factorize(lower);
    checkStatus(factor_.cholmod().status, size);
    requireRegular(factor_.reciprocalCondition() > kSingular, size, "singular");
  }

  Eigen::PermutationMatrix<Eigen::Dynamic> permutation_;
  Factor factor_;
};

/// Q R of A. SuiteSparseQR has 64-bit indices only, and needs the whole matrix.
class SpqrImpl : public LinearSolver::Impl {
 public:
  explicit SpqrImpl(const Lower& lower) : Impl(lower.cols()) {
    const Lower whole = lower.selfadjointView<Eigen::Lower>();
    factor_.cholmodCommon()->print = 0;
    factor_.setPivotThreshold(kSingular * whole.coeffs().abs().maxCoeff());
    factor_.compute(whole);
    checkStatus(factor_.cholmodCommon()->status, size);
    require(factor_.info() == Eigen::Success, "SuiteSparseQR could not factor ", size, " points");
    requireRegular(factor_.rank() >= size, size, "singular");
  }

  Eigen::MatrixXd solve(const Eigen::MatrixXd& rhs, const Eigen::MatrixXd&) override {
    Eigen::MatrixXd solution(size, rhs.cols());
    for (Eigen::Index c = 0; c < rhs.cols(); ++c) solution.col(c) = factor_.solve(rhs.col(c));
    checkStatus(factor_.cholmodCommon()->status, size);
    return solution;
  }

 private:
  Eigen::SPQR<Lower> factor_;
};

void checkLower(const Lower& lower) {
  require<std::invalid_argument>(lower.rows() == lower.cols() && lower.isCompressed(), "matrix of ", lower.rows(),
                                 " x ", lower.cols(), " must be square and compressed");
  const Eigen::Map<const Eigen::ArrayXd> values(lower.valuePtr(), lower.nonZeros());
  require(lower.nonZeros() == 0 || values.allFinite(), "the system of ", lower.cols(),
          " points has a value that is not finite");
  for (Eigen::Index p = 0; p < lower.cols(); ++p) {
    const int begin = lower.outerIndexPtr()[p];
    requireRegular(begin < lower.outerIndexPtr()[p + 1], lower.cols(), "singular");
    require<std::invalid_argument>(lower.innerIndexPtr()[begin] >= p, "column ", p, " has an entry above the diagonal");
  }
}

void checkOrder(const std::vector<int>& order, Eigen::Index size) {
  if (order.empty()) return;
  std::vector<std::uint8_t> found(static_cast<std::size_t>(size), 0);
  bool ok = order.size() == found.size();
  for (std::size_t i = 0; ok && i < order.size(); ++i) {
    ok = order[i] >= 0 && order[i] < size && !std::exchange(found[static_cast<std::size_t>(order[i])], 1);
  }
  require<std::invalid_argument>(ok, "elimination order of ", order.size(), " must hold each of ", size,
                                 " points once");
}

}  // namespace

LinearSolver::LinearSolver(const Eigen::SparseMatrix<double>& lower, SolverKind solver,
                           const std::vector<int>& elimination_order) {
  checkLower(lower);
  checkOrder(elimination_order, lower.cols());
  if (lower.cols() == 0) return;
  switch (solver) {
    case SolverKind::kConjugateGradients:
      impl_ = std::make_unique<ConjugateGradientsImpl>(lower);
      break;
    case SolverKind::kCholmod:
      impl_ = std::make_unique<CholmodImpl>(lower, elimination_order);
      break;
    case SolverKind::kSpqr:
      impl_ = std::make_unique<SpqrImpl>(lower);
  }
}

LinearSolver::~LinearSolver() = default;
LinearSolver::LinearSolver(LinearSolver&&) noexcept = default;
LinearSolver& LinearSolver::operator=(LinearSolver&&) noexcept = default;

Eigen::MatrixXd LinearSolver::solve(const Eigen::MatrixXd& rhs, const Eigen::MatrixXd& guess) const {
  const Eigen::Index size = impl_ ? impl_->size : 0;
  require<std::invalid_argument>(rhs.rows() == size, "right-hand side of ", rhs.rows(), " rows for a system of ", size);
  if (rhs.size() == 0 && guess.size() == 0) return rhs;
  if (guess.size() == 0) return impl_->solve(rhs, Eigen::MatrixXd::Zero(rhs.rows(), rhs.cols()));
  require<std::invalid_argument>(guess.rows() == size && guess.cols() == rhs.cols(), "guess of ", guess.rows(), " x ",
                                 guess.cols(), " for a solution of ", size, " x ", rhs.cols());
  return impl_->solve(rhs, guess);
}

}  // namespace cloud_colorizer
