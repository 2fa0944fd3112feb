#include <limits>
#include <piqp/piqp.hpp>

#include "axis_qp.hpp"

namespace swiftlet::bench {
namespace {

/// Sparse LDL' back end with its defaults; equalities as equalities. A round with more rows is set up anew.
class Piqp : public Peer {
 public:
  Piqp() : Peer("PIQP sparse", 320) {}

  void load(const AxisQp& qp, bool /*fresh*/) override {
    H_ = qp.sparse_H;
    f_ = qp.f;
    std::vector<Eigen::Triplet<double>> equalities;
    std::vector<double> b;
    lo_.setConstant(qp.unknowns, -std::numeric_limits<double>::infinity());
    hi_.setConstant(qp.unknowns, std::numeric_limits<double>::infinity());
    for (int i = 0; i < qp.bounded; ++i) {
      if (qp.lo[i] == qp.hi[i]) {
        equalities.emplace_back(static_cast<int>(b.size()), i, 1.0);
        b.push_back(qp.lo[i]);
      } else {
        lo_[i] = qp.lo[i];
        hi_[i] = qp.hi[i];
      }
    }
    A_.resize(static_cast<Eigen::Index>(b.size()), qp.unknowns);
    A_.setFromTriplets(equalities.begin(), equalities.end());
    b_ = Eigen::Map<Eigen::VectorXd>(b.data(), static_cast<Eigen::Index>(b.size()));
    std::vector<Eigen::Triplet<double>> entries;
    h_.resize(static_cast<Eigen::Index>(qp.rows.size()));
    for (std::size_t j = 0; j < qp.rows.size(); ++j) {
      const PeerRow& row = qp.rows[j];
      for (std::size_t i = 0; i < row.index.size(); ++i) {
        entries.emplace_back(static_cast<int>(j), row.index[i], row.value[i]);
      }
      h_[static_cast<Eigen::Index>(j)] = row.bound;
    }
    G_.resize(static_cast<Eigen::Index>(qp.rows.size()), qp.unknowns);
    G_.setFromTriplets(entries.begin(), entries.end());
  }

  bool solve(Eigen::VectorXd& x) override {
    piqp::SparseSolver<double> solver;
    solver.setup(H_, f_, A_, b_, G_, piqp::nullopt, h_, lo_, hi_);
    const piqp::Status status = solver.solve();
    x = solver.result().x;
    return status == piqp::PIQP_SOLVED;
  }

 private:
  Eigen::SparseMatrix<double> H_;
  Eigen::SparseMatrix<double> A_;
  Eigen::SparseMatrix<double> G_;
  Eigen::VectorXd f_;
  Eigen::VectorXd b_;
  Eigen::VectorXd h_;
  Eigen::VectorXd lo_;
  Eigen::VectorXd hi_;
};

}  // namespace

std::vector<std::unique_ptr<Peer>> make_piqp() {
  std::vector<std::unique_ptr<Peer>> peers;
  peers.push_back(std::make_unique<Piqp>());
  return peers;
}

}  // namespace swiftlet::bench
