// SPDX-FileCopyrightText: 2026 The cloud_colorizer authors
// SPDX-License-Identifier: BSD-3-Clause
#include "cloud_colorizer/color/linear_solver.hpp"

#include <cholmod.h>

#include <SuiteSparseQR.hpp>
#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>
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

cholmod_dense denseView(const Eigen::MatrixXd& matrix) {
  cholmod_dense view{};
  view.nrow = static_cast<std::size_t>(matrix.rows());
  view.ncol = static_cast<std::size_t>(matrix.cols());
  view.nzmax = view.nrow * view.ncol;
  view.d = view.nrow;
  view.x = const_cast<double*>(matrix.data());  // CHOLMOD reads only
  view.xtype = CHOLMOD_REAL;
  view.dtype = CHOLMOD_DOUBLE;
  return view;
}

Eigen::MatrixXd copyDense(const cholmod_dense& dense) {
  return Eigen::Map<const Eigen::MatrixXd>(static_cast<const double*>(dense.x), static_cast<Eigen::Index>(dense.nrow),
                                           static_cast<Eigen::Index>(dense.ncol));
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
  CholmodImpl(const Lower& lower, const std::vector<int>& order) : Impl(lower.cols()) {
    cholmod_start(&common_);
    common_.print = 0;
    common_.final_ll = 1;  // L D L' would accept an indefinite matrix
    if (order.empty()) {
      common_.supernodal = CHOLMOD_AUTO;
    } else {
      common_.supernodal = CHOLMOD_SIMPLICIAL;
      common_.nmethods = 1;
      common_.method[0].ordering = CHOLMOD_GIVEN;
    }
    try {
      factor(lower, order);
    } catch (...) {
      release();
      throw;
    }
  }
  ~CholmodImpl() override { release(); }

  Eigen::MatrixXd solve(const Eigen::MatrixXd& rhs, const Eigen::MatrixXd&) override {
    cholmod_dense view = denseView(rhs);
    cholmod_dense* solution = cholmod_solve(CHOLMOD_A, factor_, &view, &common_);
    checkStatus(common_.status, size);
    require(solution != nullptr, "CHOLMOD could not solve for ", size, " points");
    Eigen::MatrixXd result = copyDense(*solution);
    cholmod_free_dense(&solution, &common_);
    return result;
  }

 private:
  void factor(const Lower& lower, const std::vector<int>& order) {
    cholmod_sparse view{};
    view.nrow = view.ncol = static_cast<std::size_t>(lower.cols());
    view.nzmax = static_cast<std::size_t>(lower.nonZeros());
    view.p = const_cast<int*>(lower.outerIndexPtr());
    view.i = const_cast<int*>(lower.innerIndexPtr());
    view.x = const_cast<double*>(lower.valuePtr());
    view.stype = -1;
    view.itype = CHOLMOD_INT;
    view.xtype = CHOLMOD_REAL;
    view.dtype = CHOLMOD_DOUBLE;
    view.sorted = view.packed = 1;
    int* given = order.empty() ? nullptr : const_cast<int*>(order.data());
    factor_ = cholmod_analyze_p(&view, given, nullptr, 0, &common_);
    checkStatus(common_.status, size);
    cholmod_factorize(&view, factor_, &common_);
    checkStatus(common_.status, size);
    requireRegular(cholmod_rcond(factor_, &common_) > kSingular, size, "singular");
  }

  void release() {
    cholmod_free_factor(&factor_, &common_);
    cholmod_finish(&common_);
  }

  cholmod_common common_{};
  cholmod_factor* factor_ = nullptr;
};

/// Q R of A. SuiteSparseQR has 64-bit indices only, and needs the whole matrix.
class SpqrImpl : public LinearSolver::Impl {
 public:
  explicit SpqrImpl(const Lower& lower) : Impl(lower.cols()) {
    cholmod_l_start(&common_);
    common_.print = 0;
    const Lower whole = lower.selfadjointView<Eigen::Lower>();
    const std::vector<SuiteSparse_long> columns(whole.outerIndexPtr(), whole.outerIndexPtr() + whole.cols() + 1);
    const std::vector<SuiteSparse_long> rows(whole.innerIndexPtr(), whole.innerIndexPtr() + whole.nonZeros());
    try {
      factor(whole, columns, rows);
    } catch (...) {
      release();
      throw;
    }
  }
  ~SpqrImpl() override { release(); }

  Eigen::MatrixXd solve(const Eigen::MatrixXd& rhs, const Eigen::MatrixXd&) override {
    cholmod_dense view = denseView(rhs);
    cholmod_dense* rotated = SuiteSparseQR_qmult<double>(SPQR_QTX, factor_, &view, &common_);
    checkStatus(common_.status, size);
    cholmod_dense* solution = SuiteSparseQR_solve<double>(SPQR_RETX_EQUALS_B, factor_, rotated, &common_);
    cholmod_l_free_dense(&rotated, &common_);
    checkStatus(common_.status, size);
    require(solution != nullptr, "SuiteSparseQR could not solve for ", size, " points");
    Eigen::MatrixXd result = copyDense(*solution);
    cholmod_l_free_dense(&solution, &common_);
    return result;
  }

 private:
  void factor(const Lower& whole, const std::vector<SuiteSparse_long>& columns,
              const std::vector<SuiteSparse_long>& rows) {
    cholmod_sparse view{};
    view.nrow = view.ncol = static_cast<std::size_t>(whole.cols());
    view.nzmax = rows.size();
    view.p = const_cast<SuiteSparse_long*>(columns.data());
    view.i = const_cast<SuiteSparse_long*>(rows.data());
    view.x = const_cast<double*>(whole.valuePtr());
    view.itype = CHOLMOD_LONG;
    view.xtype = CHOLMOD_REAL;
    view.dtype = CHOLMOD_DOUBLE;
    view.sorted = view.packed = 1;
    const double largest = Eigen::Map<const Eigen::ArrayXd>(whole.valuePtr(), whole.nonZeros()).abs().maxCoeff();
    factor_ = SuiteSparseQR_factorize<double>(SPQR_ORDERING_DEFAULT, kSingular * largest, &view, &common_);
    checkStatus(common_.status, size);
    require(factor_ != nullptr, "SuiteSparseQR could not factor ", size, " points");
    requireRegular(factor_->rank >= whole.cols(), size, "singular");
  }

  void release() {
    SuiteSparseQR_free<double>(&factor_, &common_);
    cholmod_l_finish(&common_);
  }

  cholmod_common common_{};
  SuiteSparseQR_factorization<double>* factor_ = nullptr;
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
