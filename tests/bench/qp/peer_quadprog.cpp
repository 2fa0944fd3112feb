#include "axis_qp.hpp"

extern "C" int qpgen2_(double* G, double* av, int n, double* xv, double* lagr, double* obj, double* C, double* bv,
                       int q, int meq, int* iact, int* nact, int* iter, double* work, int factorized);

namespace swiftlet::bench {
namespace {

/// The C core of the Python package: C' x >= b, the first `equalities` columns as equalities; destroys what it is
/// given.
class Quadprog : public Peer {
 public:
  Quadprog() : Peer("quadprog", 80) {}

  void load(const AxisQp& qp, bool /*fresh*/) override {
    G_ = qp.H;
    a_ = -qp.f;
    equalities_ = static_cast<int>((qp.lo.array() == qp.hi.array()).count());
    const Eigen::Index columns = static_cast<Eigen::Index>(qp.rows.size()) + 2 * qp.bounded - equalities_;
    C_.setZero(qp.unknowns, columns);
    b_.resize(columns);
    Eigen::Index e = 0;
    Eigen::Index j = equalities_;
    for (Eigen::Index i = 0; i < qp.bounded; ++i) {
      if (qp.lo[i] == qp.hi[i]) {
        C_(i, e) = 1;
        b_[e++] = qp.lo[i];
        continue;
      }
      C_(i, j) = 1;
      b_[j++] = qp.lo[i];
      C_(i, j) = -1;
      b_[j++] = -qp.hi[i];
    }
    for (const PeerRow& row : qp.rows) {
      for (std::size_t i = 0; i < row.index.size(); ++i) C_(row.index[i], j) = -row.value[i];
      b_[j++] = -row.bound;
    }
    const Eigen::Index r = std::min<Eigen::Index>(qp.unknowns, columns);
    work_.setZero(2 * qp.unknowns + 2 * columns + r * (r + 5) / 2);
    x_.setZero(qp.unknowns);
    multipliers_.setZero(columns);
    active_.assign(static_cast<std::size_t>(columns), 0);
  }

  bool solve(Eigen::VectorXd& x) override {
    double cost = 0;
    int active_count = 0;
    std::array<int, 2> iterations{};
    const int status = qpgen2_(G_.data(), a_.data(), static_cast<int>(G_.rows()), x_.data(), multipliers_.data(), &cost,
                               C_.data(), b_.data(), static_cast<int>(b_.size()), equalities_, active_.data(),
                               &active_count, iterations.data(), work_.data(), 0);
    x = x_;
    return status == 0;
  }

 private:
  int equalities_ = 0;
  Eigen::MatrixXd G_;
  Eigen::MatrixXd C_;
  Eigen::VectorXd a_;
  Eigen::VectorXd b_;
  Eigen::VectorXd x_;
  Eigen::VectorXd multipliers_;
  Eigen::VectorXd work_;
  std::vector<int> active_;
};

}  // namespace

std::vector<std::unique_ptr<Peer>> make_quadprog() {
  std::vector<std::unique_ptr<Peer>> peers;
  peers.push_back(std::make_unique<Quadprog>());
  return peers;
}

}  // namespace swiftlet::bench
