#include "axis_qp.hpp"

extern "C" {
#include "api.h"
#include "utils.h"
}

namespace swiftlet::bench {
namespace {

using RowMajor = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

/// Kept between the rounds of an axis: `warm` keeps the workspace and its working set, otherwise each round is one call
/// of its one-shot interface, which eliminates the equalities.
class Daqp : public Peer {
 public:
  explicit Daqp(bool warm) : Peer(warm ? "DAQP warm" : "DAQP cold", 320), warm_(warm) {}
  ~Daqp() override { release(); }

  void load(const AxisQp& qp, bool fresh) override {
    fresh_ = fresh;
    const auto rows = static_cast<Eigen::Index>(qp.rows.size());
    const Eigen::Index m = qp.bounded + rows;
    H_ = qp.H;
    f_ = qp.f;
    A_.setZero(rows, qp.unknowns);
    upper_.resize(m);
    lower_.resize(m);
    upper_.head(qp.bounded) = qp.hi;
    lower_.head(qp.bounded) = qp.lo;
    if (fresh) sense_.assign(static_cast<std::size_t>(qp.bounded), 0);
    if (!fresh && warm_) std::copy_n(work_.sense, sense_.size(), sense_.begin());
    for (Eigen::Index i = 0; fresh && i < qp.bounded; ++i) {
      if (qp.hi[i] == qp.lo[i]) sense_[static_cast<std::size_t>(i)] = DAQP_ACTIVE + DAQP_IMMUTABLE;
    }
    sense_.resize(static_cast<std::size_t>(m), 0);
    for (Eigen::Index j = 0; j < rows; ++j) {
      const PeerRow& row = qp.rows[static_cast<std::size_t>(j)];
      for (std::size_t i = 0; i < row.index.size(); ++i) A_(j, row.index[i]) = row.value[i];
      upper_[qp.bounded + j] = row.bound;
      lower_[qp.bounded + j] = -DAQP_INF;
    }
    problem_ = {};
    problem_.n = qp.unknowns;
    problem_.m = static_cast<int>(m);
    problem_.ms = qp.bounded;
    problem_.H = H_.data();
    problem_.f = f_.data();
    problem_.A = A_.data();
    problem_.bupper = upper_.data();
    problem_.blower = lower_.data();
    problem_.sense = sense_.data();
    x_.resize(qp.unknowns);
    lambda_.resize(m + kSpareRows);
    if (warm_ && (fresh || m > capacity_)) reserve(static_cast<int>(m));
  }

  bool solve(Eigen::VectorXd& x) override {
    DAQPResult result{};
    result.x = x_.data();
    result.lam = lambda_.data();
    if (warm_) {
      int mask = DAQP_UPDATE_M | DAQP_UPDATE_d | DAQP_UPDATE_sense;
      if (fresh_) mask |= DAQP_UPDATE_Rinv | DAQP_UPDATE_v;
      if (daqp_update_ldp(mask, &work_, &problem_) < 0) return false;
      daqp_solve(&result, &work_);
    } else {
      daqp_quadprog(&result, &problem_, nullptr);
    }
    x = x_;
    return result.exitflag > 0;
  }

 private:
  static constexpr int kSpareRows = 64;

  /// A workspace with room for more rows; a new one for each axis, so that nothing is left of the last.
  void reserve(int rows) {
    release();
    work_ = {};
    allocate_daqp_settings(&work_);
    allocate_daqp_workspace(&work_, problem_.n, 0);
    capacity_ = rows + kSpareRows;
    allocate_daqp_ldp(&work_, problem_.n, capacity_, problem_.ms, 1, 1);
    fresh_ = true;
  }
  void release() {
    if (capacity_ == 0) return;
    free_daqp_workspace(&work_);
    free_daqp_ldp(&work_);
    capacity_ = 0;
  }

  bool warm_;
  bool fresh_ = true;
  int capacity_ = 0;
  DAQPWorkspace work_{};
  DAQPProblem problem_{};
  RowMajor H_;
  RowMajor A_;
  Eigen::VectorXd f_;
  Eigen::VectorXd upper_;
  Eigen::VectorXd lower_;
  Eigen::VectorXd x_;
  Eigen::VectorXd lambda_;
  std::vector<int> sense_;
};

}  // namespace

std::vector<std::unique_ptr<Peer>> make_daqp() {
  std::vector<std::unique_ptr<Peer>> peers;
  peers.push_back(std::make_unique<Daqp>(true));
  peers.push_back(std::make_unique<Daqp>(false));
  return peers;
}

}  // namespace swiftlet::bench
