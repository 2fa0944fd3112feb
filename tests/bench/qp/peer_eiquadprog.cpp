#include <eiquadprog/eiquadprog-fast.hpp>

#include "axis_qp.hpp"

namespace swiftlet::bench {
namespace {

/// Thin gates as equalities, everything else as CI x + ci0 >= 0. It has no warm start.
class Eiquadprog : public Peer {
 public:
  Eiquadprog() : Peer("eiquadprog", 80) {}

  void load(const AxisQp& qp, bool /*fresh*/) override {
    H_ = qp.H;
    f_ = qp.f;
    const Eigen::Index equalities = (qp.lo.array() == qp.hi.array()).count();
    const Eigen::Index rows = static_cast<Eigen::Index>(qp.rows.size()) + 2 * (qp.bounded - equalities);
    CE_.setZero(equalities, qp.unknowns);
    ce_.resize(equalities);
    CI_.setZero(rows, qp.unknowns);
    ci_.resize(rows);
    Eigen::Index e = 0;
    Eigen::Index j = 0;
    for (Eigen::Index i = 0; i < qp.bounded; ++i) {
      if (qp.lo[i] == qp.hi[i]) {
        CE_(e, i) = 1;
        ce_[e++] = -qp.lo[i];
        continue;
      }
      CI_(j, i) = 1;
      ci_[j++] = -qp.lo[i];
      CI_(j, i) = -1;
      ci_[j++] = qp.hi[i];
    }
    for (const PeerRow& row : qp.rows) {
      for (std::size_t i = 0; i < row.index.size(); ++i) CI_(j, row.index[i]) = -row.value[i];
      ci_[j++] = row.bound;
    }
    x_.resize(qp.unknowns);
    solver_.reset(static_cast<std::size_t>(qp.unknowns), static_cast<std::size_t>(equalities),
                  static_cast<std::size_t>(rows));
    solver_.setMaxIter(10000);
  }

  bool solve(Eigen::VectorXd& x) override {
    const auto status = solver_.solve_quadprog(H_, f_, CE_, ce_, CI_, ci_, x_);
    x = x_;
    return status == eiquadprog::solvers::EIQUADPROG_FAST_OPTIMAL;
  }

 private:
  eiquadprog::solvers::EiquadprogFast solver_;
  Eigen::MatrixXd H_;
  Eigen::MatrixXd CE_;
  Eigen::MatrixXd CI_;
  Eigen::VectorXd f_;
  Eigen::VectorXd ce_;
  Eigen::VectorXd ci_;
  Eigen::VectorXd x_;
};

}  // namespace

std::vector<std::unique_ptr<Peer>> make_eiquadprog() {
  std::vector<std::unique_ptr<Peer>> peers;
  peers.push_back(std::make_unique<Eiquadprog>());
  return peers;
}

}  // namespace swiftlet::bench
