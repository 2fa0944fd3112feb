#include <qpOASES.hpp>

#include "axis_qp.hpp"

namespace swiftlet::bench {
namespace {

using RowMajor = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

/// A new object a round, with the last primal and dual solution and its working set as the guess. MPC options.
class QpOases : public Peer {
 public:
  QpOases() : Peer("qpOASES warm", 80) {}

  void load(const AxisQp& qp, bool fresh) override {
    const auto rows = static_cast<Eigen::Index>(qp.rows.size());
    H_ = qp.H;
    f_ = qp.f;
    lo_.setConstant(qp.unknowns, -qpOASES::INFTY);
    hi_.setConstant(qp.unknowns, qpOASES::INFTY);
    lo_.head(qp.bounded) = qp.lo;
    hi_.head(qp.bounded) = qp.hi;
    A_.setZero(rows, qp.unknowns);
    bound_.resize(rows);
    for (Eigen::Index j = 0; j < rows; ++j) {
      const PeerRow& row = qp.rows[static_cast<std::size_t>(j)];
      for (std::size_t i = 0; i < row.index.size(); ++i) A_(j, row.index[i]) = row.value[i];
      bound_[j] = row.bound;
    }
    warm_ = !fresh;
    const Eigen::VectorXd last_y = y_;
    y_.setZero(qp.unknowns + rows);
    if (warm_)
      y_.head(last_y.size()) = last_y;
    else
      x_.setZero(qp.unknowns);
  }

  bool solve(Eigen::VectorXd& x) override {
    const auto n = static_cast<qpOASES::int_t>(f_.size());
    const auto m = static_cast<qpOASES::int_t>(bound_.size());
    qpOASES::Options options;
    options.setToMPC();
    options.printLevel = qpOASES::PL_NONE;
    qpOASES::int_t steps = 100 * (n + m) + 1000;
    qpOASES::returnValue status = qpOASES::RET_INIT_FAILED;
    if (m == 0) {
      qpOASES::QProblemB problem(n, qpOASES::HST_POSDEF);
      problem.setOptions(options);
      status = problem.init(H_.data(), f_.data(), lo_.data(), hi_.data(), steps);
      problem.getPrimalSolution(x_.data());
      problem.getDualSolution(y_.data());
    } else {
      qpOASES::QProblem problem(n, m, qpOASES::HST_POSDEF);
      problem.setOptions(options);
      // With a primal and dual guess the working set follows from the signs of the multipliers.
      status = problem.init(H_.data(), f_.data(), A_.data(), lo_.data(), hi_.data(), nullptr, bound_.data(), steps,
                            nullptr, warm_ ? x_.data() : nullptr, warm_ ? y_.data() : nullptr);
      problem.getPrimalSolution(x_.data());
      problem.getDualSolution(y_.data());
    }
    x = x_;
    return status == qpOASES::SUCCESSFUL_RETURN;
  }

 private:
  bool warm_ = false;
  RowMajor H_;
  RowMajor A_;
  Eigen::VectorXd f_;
  Eigen::VectorXd lo_;
  Eigen::VectorXd hi_;
  Eigen::VectorXd bound_;
  Eigen::VectorXd x_;
  Eigen::VectorXd y_;
};

}  // namespace

std::vector<std::unique_ptr<Peer>> make_qpoases() {
  std::vector<std::unique_ptr<Peer>> peers;
  peers.push_back(std::make_unique<QpOases>());
  return peers;
}

}  // namespace swiftlet::bench
