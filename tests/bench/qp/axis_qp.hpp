#pragma once
#include <Eigen/SparseCore>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "swiftlet/min_jerk.hpp"
#include "swiftlet/trajectory_generator.hpp"

namespace swiftlet::bench {

/// A row a' x <= bound of at most six entries.
struct PeerRow {
  std::vector<int> index;
  std::vector<double> value;
  double bound = 0;
};

/// One axis as a general QP: minimise 1/2 x' H x + f' x with bounds on the first `bounded` unknowns (equal: a thin
/// gate) and `rows`. Unknowns are the junctions' positions, then pairs of velocity and acceleration, scaled so that
/// diag(H) = 1.
struct AxisQp {
  int unknowns = 0;
  int bounded = 0;
  Eigen::MatrixXd H;
  Eigen::SparseMatrix<double> sparse_H;
  Eigen::VectorXd f;
  Eigen::VectorXd lo;  ///< of the bounded ones
  Eigen::VectorXd hi;
  std::vector<PeerRow> rows;
};

/// A public solver. `load` brings the problem into the form it wants and is not timed; `solve` is.
class Peer {
 public:
  explicit Peer(std::string name, std::size_t most_segments) : name_(std::move(name)), most_segments_(most_segments) {}
  Peer(const Peer&) = delete;
  Peer& operator=(const Peer&) = delete;
  virtual ~Peer() = default;
  [[nodiscard]] const std::string& name() const { return name_; }
  [[nodiscard]] std::size_t most_segments() const { return most_segments_; }  ///< beyond that it would take too long
  /// `fresh`: another axis; otherwise only rows were appended since the last solve.
  virtual void load(const AxisQp& qp, bool fresh) = 0;
  /// False when no optimum was found. `x` has its size already: memory never changes hands between libraries.
  virtual bool solve(Eigen::VectorXd& x) = 0;

 private:
  std::string name_;
  std::size_t most_segments_;
};

[[gnu::visibility("default")]] std::vector<std::unique_ptr<Peer>> make_daqp();
[[gnu::visibility("default")]] std::vector<std::unique_ptr<Peer>> make_eiquadprog();
[[gnu::visibility("default")]] std::vector<std::unique_ptr<Peer>> make_osqp();
[[gnu::visibility("default")]] std::vector<std::unique_ptr<Peer>> make_piqp();
[[gnu::visibility("default")]] std::vector<std::unique_ptr<Peer>> make_qpoases();
[[gnu::visibility("default")]] std::vector<std::unique_ptr<Peer>> make_quadprog();

}  // namespace swiftlet::bench
