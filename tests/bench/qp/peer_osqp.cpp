extern "C" {
#include "osqp.h"
}

#include "axis_qp.hpp"

namespace swiftlet::bench {
namespace {

constexpr double kUnbounded = 1e30;

/// Tolerance 1e-6; a round with more rows is set up anew and started from the last primal and dual solution.
class Osqp : public Peer {
 public:
  Osqp() : Peer("OSQP 1e-6", 80) {}

  void load(const AxisQp& qp, bool fresh) override {
    P_ = qp.sparse_H.triangularView<Eigen::Upper>();
    f_ = qp.f;
    std::vector<Eigen::Triplet<double>> entries;
    const auto m = static_cast<Eigen::Index>(qp.bounded) + static_cast<Eigen::Index>(qp.rows.size());
    lower_.setConstant(m, -kUnbounded);
    upper_.resize(m);
    for (int i = 0; i < qp.bounded; ++i) entries.emplace_back(i, i, 1.0);
    lower_.head(qp.bounded) = qp.lo;
    upper_.head(qp.bounded) = qp.hi;
    for (std::size_t j = 0; j < qp.rows.size(); ++j) {
      const PeerRow& row = qp.rows[j];
      const int at = qp.bounded + static_cast<int>(j);
      for (std::size_t i = 0; i < row.index.size(); ++i) entries.emplace_back(at, row.index[i], row.value[i]);
      upper_[at] = row.bound;
    }
    A_.resize(m, qp.unknowns);
    A_.setFromTriplets(entries.begin(), entries.end());
    P_.makeCompressed();
    A_.makeCompressed();
    warm_ = !fresh && x_.size() == qp.unknowns;
    const Eigen::VectorXd last_y = y_;
    y_.setZero(m);
    if (warm_) y_.head(last_y.size()) = last_y;
  }

  bool solve(Eigen::VectorXd& x) override {
    csc P = view(P_);
    csc A = view(A_);
    OSQPData data{P_.cols(), A_.rows(), &P, &A, f_.data(), lower_.data(), upper_.data()};
    OSQPSettings settings;
    osqp_set_default_settings(&settings);
    settings.eps_abs = settings.eps_rel = 1e-6;
    settings.max_iter = 100000;
    settings.verbose = 0;
    OSQPWorkspace* work = nullptr;
    if (osqp_setup(&work, &data, &settings) != 0) return false;
    if (warm_) osqp_warm_start(work, x_.data(), y_.data());
    osqp_solve(work);
    const bool solved = work->info->status_val == OSQP_SOLVED;
    x_ = Eigen::Map<Eigen::VectorXd>(work->solution->x, f_.size());
    y_ = Eigen::Map<Eigen::VectorXd>(work->solution->y, upper_.size());
    osqp_cleanup(work);
    x = x_;
    return solved;
  }

 private:
  using Matrix = Eigen::SparseMatrix<double, Eigen::ColMajor, c_int>;
  static csc view(Matrix& matrix) {
    return {matrix.nonZeros(),
            matrix.rows(),
            matrix.cols(),
            matrix.outerIndexPtr(),
            matrix.innerIndexPtr(),
            matrix.valuePtr(),
            -1};
  }

  bool warm_ = false;
  Matrix P_;
  Matrix A_;
  Eigen::VectorXd f_;
  Eigen::VectorXd lower_;
  Eigen::VectorXd upper_;
  Eigen::VectorXd x_;
  Eigen::VectorXd y_;
};

}  // namespace

std::vector<std::unique_ptr<Peer>> make_osqp() {
  std::vector<std::unique_ptr<Peer>> peers;
  peers.push_back(std::make_unique<Osqp>());
  return peers;
}

}  // namespace swiftlet::bench
