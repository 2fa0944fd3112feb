// The trajectory QPs of Sec. IV, solved by the core and by public solvers with the paper's loop (Sec. IV-C), on the
// same corridors, interleaved in one run. Run by run.sh; prints Markdown.
//   qp_bench [--quick] [--cases FILE] [--only NAME] [--limits]
// --limits prints instead what the caps of the core are derived from: iterations and active rows at zero margins.
// Time of a trajectory: three axes, all rounds, best of a few repetitions, in thread CPU time. A peer's time is that of
// its solver calls alone; ours includes the checks for violations and the emission of the polynomials.
#include <cstdio>
#include <cstring>
#include <ctime>
#include <fstream>
#include <map>
#include <nlohmann/json.hpp>

#include "axis_qp.hpp"
#include "octree_corridor.hpp"
#include "swiftlet/trajectory.hpp"

namespace swiftlet::bench {
namespace {

constexpr Real kTolerance = Real(1e-6);  // excess that counts as no violation [m, m/s, m/s^2]
constexpr Margins kMargins{Real(0.002), Real(0.05), Real(0.05)};
constexpr int kRoundLimit = 40;

double cpu_ms() {
  timespec now{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
  return static_cast<double>(now.tv_sec) * 1e3 + static_cast<double>(now.tv_nsec) * 1e-6;
}

/// One axis for the peers: the general QP, and the way from its unknowns back to the core's.
class PeerAxis {
 public:
  PeerAxis(const TrajectoryProblem& problem, std::span<const Real> scales, std::size_t axis) : problem_(problem) {
    const auto row = static_cast<Eigen::Index>(axis);
    const Real reference = problem.boxes[0].lo[row];
    axis_ = {axis,
             problem.durations,
             scales,
             problem.gates,
             {problem.start.position[row] - reference, problem.start.velocity[row], problem.start.acceleration[row]},
             {problem.goal.position[row] - reference, problem.goal.velocity[row], problem.goal.acceleration[row]},
             reference};
    add_cost();
    scale_to_unit_diagonal();
    add_gates();
  }

  [[nodiscard]] const AxisQp& qp() const { return qp_; }

  /// Eq. 10: a row with its margin at every extremum that exceeds its bound; false when there is none.
  bool add_violated(const Eigen::VectorXd& x) {
    const std::size_t before = qp_.rows.size();
    const std::vector<Real> unknowns = core_unknowns(x);
    for (std::size_t i = 0; i < axis_.segment_count(); ++i) {
      const Quintic quintic = quintic_from_ends(segment_ends(axis_, i, unknowns));
      for (int derivative = 0; derivative <= 2; ++derivative) {
        CriticalPoints points = critical_points(quintic, derivative);
        for (std::size_t k = 0; k < points.count; ++k) check(i, quintic, derivative, points.tau[k]);
        check(i, quintic, derivative, 0);
        if (i + 1 == axis_.segment_count()) check(i, quintic, derivative, 1);
      }
    }
    return qp_.rows.size() > before;
  }

  [[nodiscard]] double cost(const Eigen::VectorXd& x) const {
    return 2 * (0.5 * x.dot(qp_.H * x) + qp_.f.dot(x)) + constant_;
  }

 private:
  [[nodiscard]] int junctions() const { return static_cast<int>(axis_.segment_count()) - 1; }
  /// Positions first, then pairs of velocity and acceleration.
  [[nodiscard]] int place(std::size_t junction, std::size_t k) const {
    const int j = static_cast<int>(junction);
    return k == 0 ? j : junctions() + 2 * j + static_cast<int>(k) - 1;
  }

  /// Jerk of each segment at three Gauss points, over (left state, right state, 1).
  void add_cost() {
    qp_.unknowns = 3 * junctions();
    qp_.bounded = junctions();
    qp_.H.setZero(qp_.unknowns, qp_.unknowns);
    qp_.f.setZero(qp_.unknowns);
    const double offset = std::sqrt(0.15);
    for (std::size_t i = 0; i < axis_.segment_count(); ++i) {
      const double T = axis_.durations[i];
      for (const auto& [tau, weight] : {std::pair{0.5 - offset, 5.0 / 18}, {0.5, 8.0 / 18}, {0.5 + offset, 5.0 / 18}}) {
        add_square(i, tau, weight / std::pow(T, 5));
      }
    }
  }

  void add_square(std::size_t segment, double tau, double weight) {
    const double T = axis_.durations[segment];
    std::vector<std::pair<int, double>> entries;
    double constant = 0;
    for (std::size_t k = 0; k < 6; ++k) {
      QuinticEnds ends{};
      ends[k] = 1;
      const Quintic c = quintic_from_ends(ends);
      const double jerk = 6 * c[3] + 24 * c[4] * tau + 60 * c[5] * tau * tau;
      const std::size_t order = k % 3;
      const bool left = k < 3;
      const bool fixed = left ? segment == 0 : segment + 1 == axis_.segment_count();
      if (fixed) {
        constant += jerk * (left ? axis_.start : axis_.goal)[order] * std::pow(T, order);
      } else {
        const std::size_t junction = left ? segment - 1 : segment;
        entries.emplace_back(place(junction, order), jerk * std::pow(T / axis_.scales[junction], order));
      }
    }
    for (const auto& [i, a] : entries) {
      for (const auto& [j, b] : entries) qp_.H(i, j) += weight * a * b;
      qp_.f[i] += weight * a * constant;
    }
    constant_ += weight * constant * constant;
  }

  void scale_to_unit_diagonal() {
    scale_ = qp_.H.diagonal().cwiseSqrt().cwiseInverse();
    qp_.H = scale_.asDiagonal() * qp_.H * scale_.asDiagonal();
    qp_.f = scale_.asDiagonal() * qp_.f;
    qp_.sparse_H = qp_.H.sparseView();
  }

  void add_gates() {
    qp_.lo.resize(junctions());
    qp_.hi.resize(junctions());
    for (int k = 0; k < junctions(); ++k) {
      const auto junction = static_cast<std::size_t>(k);
      const bool pinned = is_pinned(axis_, junction);
      const double middle = (axis_.gate_lo(junction) + axis_.gate_hi(junction)) / 2;
      qp_.lo[k] = (pinned ? middle : axis_.gate_lo(junction)) / scale_[k];
      qp_.hi[k] = (pinned ? middle : axis_.gate_hi(junction)) / scale_[k];
    }
  }

  [[nodiscard]] std::vector<Real> core_unknowns(const Eigen::VectorXd& x) const {
    std::vector<Real> unknowns(static_cast<std::size_t>(qp_.unknowns));
    for (std::size_t k = 0; k < unknowns.size(); ++k) {
      const int at = place(k / 3, k % 3);
      unknowns[k] = scale_[at] * x[at];
    }
    return unknowns;
  }

  void check(std::size_t segment, const Quintic& quintic, int derivative, Real tau) {
    const auto row = static_cast<Eigen::Index>(axis_.axis);
    Real value = quintic_value(quintic, derivative, tau);
    for (int d = 0; d < derivative; ++d) value /= axis_.durations[segment];
    const Real limit = derivative == 1 ? problem_.v_max[row] : problem_.a_max[row];
    const Real hi = derivative == 0 ? problem_.boxes[segment].hi[row] - axis_.reference : limit;
    const Real lo = derivative == 0 ? problem_.boxes[segment].lo[row] - axis_.reference : -limit;
    const Margins& m = problem_.margins;
    const Real margin = derivative == 0 ? m.position : derivative == 1 ? m.velocity : m.acceleration;
    if (value > hi + kTolerance) push(extremum_row(axis_, segment, derivative, tau, 1, hi - margin));
    if (value < lo - kTolerance) push(extremum_row(axis_, segment, derivative, tau, -1, lo + margin));
  }

  void push(const QpRow& row) {
    PeerRow peer;
    peer.bound = row.bound;
    for (std::size_t k = 0; k < row.coefficients.size(); ++k) {
      if (row.coefficients[k] == 0) continue;
      const int at = place(row.block + k / 3, k % 3);
      peer.index.push_back(at);
      peer.value.push_back(row.coefficients[k] * scale_[at]);
    }
    qp_.rows.push_back(peer);
  }

  const TrajectoryProblem& problem_;
  AxisProblem axis_;
  AxisQp qp_;
  Eigen::VectorXd scale_;
  double constant_ = 0;
};

struct Answer {
  bool solved = false;
  double ms = 0;
  double cost = 0;
};

Answer solve_with(Peer& peer, const Corridor& corridor) {
  const TrajectoryProblem problem = corridor.problem();
  std::vector<Real> scales(corridor.gates.size());
  junction_scales(corridor.durations, scales);
  Answer answer;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    PeerAxis loop(problem, scales, axis);
    Eigen::VectorXd x(loop.qp().unknowns);
    for (int round = 0;; ++round) {
      if (round == kRoundLimit) return answer;
      peer.load(loop.qp(), round == 0);
      const double begin = cpu_ms();
      const bool solved = peer.solve(x);
      answer.ms += cpu_ms() - begin;
      if (!solved || !x.allFinite()) return answer;
      if (!loop.add_violated(x)) break;
    }
    answer.cost += loop.cost(x);
  }
  answer.solved = true;
  return answer;
}

Answer solve_with_ours(const Corridor& corridor) {
  TrajectoryProblem problem = corridor.problem();
  problem.effort.tolerance = kTolerance;
  std::vector<Segment> segments(corridor.boxes.size());
  TrajectoryReport report;
  Answer answer;
  const double begin = cpu_ms();
  answer.solved = generate_trajectory(problem, shared_storage().spans(), segments, report) == Status::kOk;
  answer.ms = cpu_ms() - begin;
  for (std::size_t axis = 0; axis < 3; ++axis) answer.cost += jerk_cost(segments, axis);
  return answer;
}

Vector3 vector_at(const nlohmann::json& numbers, std::size_t first) {
  return {numbers[first].get<Real>(), numbers[first + 1].get<Real>(), numbers[first + 2].get<Real>()};
}

Corridor corridor_of(const nlohmann::json& json) {
  Corridor corridor;
  for (const auto& box : json["boxes"]) corridor.boxes.push_back({vector_at(box, 0), vector_at(box, 3)});
  for (const auto& gate : json["gates"]) corridor.gates.push_back({vector_at(gate, 0), vector_at(gate, 3)});
  corridor.durations = json["durations"].get<std::vector<Real>>();
  corridor.start.position = vector_at(json["start"]["position"], 0);
  corridor.goal.position = vector_at(json["goal"]["position"], 0);
  corridor.v_max = json["vmax"].get<Real>();
  corridor.a_max = json["amax"].get<Real>();
  return corridor;
}

double quantile(std::vector<double> values, double share) {
  if (values.empty()) return std::nan("");
  std::sort(values.begin(), values.end());
  return values[std::min(values.size() - 1, static_cast<std::size_t>(share * static_cast<double>(values.size())))];
}

struct Options {
  bool quick = false;
  bool limits = false;
  std::string cases;
  std::string only;
};

/// All corridors of one set and length.
std::vector<Corridor> corridors(const Options& options, Gates gates, Times times, std::size_t count) {
  std::vector<Corridor> all;
  std::ifstream file(options.cases);
  for (std::string line; std::getline(file, line);) {
    const nlohmann::json json = nlohmann::json::parse(line);
    const std::string name = json["name"];
    const bool wanted = name.find(times == Times::kTrap ? "-trap-" : "-tight-") != std::string::npos &&
                        name.find(gates == Gates::kWindows ? "-windows" : "-relaxed") != std::string::npos;
    if (wanted && json["boxes"].size() == count) all.push_back(corridor_of(json));
  }
  std::size_t seeds = count <= 40 ? 30 : count <= 80 ? 15 : count <= 160 ? 7 : 5;
  if (options.quick) seeds = count <= 80 ? 5 : 2;
  for (std::uint64_t seed = 0; seed < seeds; ++seed) {
    Corridor corridor;
    if (make_corridor(seed, count, gates, times, corridor)) all.push_back(std::move(corridor));
  }
  for (Corridor& corridor : all) corridor.margins = kMargins;
  return all;
}

struct Column {
  std::vector<double> ms;
  std::vector<double> cost_difference;
  int failed = 0;
};

/// One set and length: every solver on every corridor; only corridors that we and DAQP solve count.
std::vector<Column> run_set(const std::vector<Corridor>& all, std::span<const std::unique_ptr<Peer>> peers,
                            std::size_t count) {
  std::vector<Column> columns(peers.size() + 1);
  const int repeats = count <= 20 ? 5 : count <= 40 ? 3 : count <= 80 ? 2 : 1;
  for (const Corridor& corridor : all) {
    std::vector<Answer> best(columns.size());
    for (int repeat = 0; repeat < repeats; ++repeat) {
      for (std::size_t s = 0; s < columns.size(); ++s) {
        if (s > 0 && peers[s - 1]->most_segments() < count) continue;
        Answer answer = s == 0 ? solve_with_ours(corridor) : solve_with(*peers[s - 1], corridor);
        // Ours is short: a few more tries against the noise of the clock.
        for (int k = 0; s == 0 && k < 4; ++k) answer.ms = std::min(answer.ms, solve_with_ours(corridor).ms);
        if (repeat > 0) answer.ms = std::min(answer.ms, best[s].ms);
        best[s] = answer;
      }
    }
    const std::size_t judge = peers.empty() ? 0 : 1;
    if (!best[0].solved || !best[judge].solved) continue;
    for (std::size_t s = 0; s < columns.size(); ++s) {
      if (s > 0 && peers[s - 1]->most_segments() < count) continue;
      columns[s].failed += best[s].solved ? 0 : 1;
      if (!best[s].solved) continue;
      columns[s].ms.push_back(best[s].ms);
      columns[s].cost_difference.push_back(std::fabs(best[s].cost / best[judge].cost - 1));
    }
  }
  return columns;
}

void append(const std::vector<Column>& some, std::vector<Column>& all) {
  all.resize(some.size());
  for (std::size_t s = 0; s < some.size(); ++s) {
    all[s].ms.insert(all[s].ms.end(), some[s].ms.begin(), some[s].ms.end());
    all[s].cost_difference.insert(all[s].cost_difference.end(), some[s].cost_difference.begin(),
                                  some[s].cost_difference.end());
    all[s].failed += some[s].failed;
  }
}

void print_table(const std::string& title, std::span<const std::size_t> lengths,
                 std::span<const std::unique_ptr<Peer>> peers, const std::vector<std::vector<Column>>& results) {
  std::printf("\n### %s\n\n| solver |", title.c_str());
  for (std::size_t i = 0; i < lengths.size(); ++i) {
    std::printf(" M=%zu (%zu) |", lengths[i], results[i][0].ms.size());
  }
  std::printf(" growth 20 to longest | cost, median and worst difference | failed |\n| --- |");
  for (std::size_t i = 0; i < lengths.size() + 3; ++i) std::printf(" --- |");
  std::printf("\n");
  for (std::size_t s = 0; s <= peers.size(); ++s) {
    std::printf("| %s |", s == 0 ? "swiftlet" : peers[s - 1]->name().c_str());
    std::vector<double> differences;
    int failed = 0;
    double first = 0;
    double growth = 0;
    for (std::size_t i = 0; i < lengths.size(); ++i) {
      const Column& column = results[i][s];
      const double median = quantile(column.ms, 0.5);
      const double reference = results[i][peers.empty() ? 0 : 1].ms.empty()
                                   ? std::nan("")
                                   : quantile(results[i][peers.empty() ? 0 : 1].ms, 0.5);
      if (column.ms.empty())
        std::printf(" |");
      else
        std::printf(" %.3g (x%.2g) |", median, median / reference);
      if (lengths[i] == 20) first = median;
      if (lengths[i] > 20 && first > 0 && !column.ms.empty()) {
        growth = std::log(median / first) / std::log(static_cast<double>(lengths[i]) / 20);
      }
      differences.insert(differences.end(), column.cost_difference.begin(), column.cost_difference.end());
      failed += column.failed;
    }
    std::printf(" %.2f | %.0e, %.0e | %d |\n", growth, quantile(differences, 0.5), quantile(differences, 1), failed);
  }
  std::fflush(stdout);
}

/// The largest counts of one length over all sets, infeasible corridors included, summed over the axes.
void print_limits(const Options& options, std::size_t count) {
  std::uint32_t iterations = 0;
  std::uint32_t active = 0;
  std::size_t solves = 0;
  std::size_t capped = 0;
  for (const Gates gates : {Gates::kWindows, Gates::kRelaxed}) {
    for (const Times times : {Times::kTrap, Times::kTight}) {
      for (const Corridor& corridor : corridors(options, gates, times, count)) {
        TrajectoryProblem problem = corridor.problem();
        problem.margins = {};
        std::vector<Segment> segments(count);
        TrajectoryReport report;
        const Status status = generate_trajectory(problem, shared_storage().spans(), segments, report);
        ++solves;
        if (status == Status::kIterationLimit) {
          ++capped;
          continue;
        }
        iterations = std::max(iterations, report.qp_iterations);
        active = std::max(active, report.active);
      }
    }
  }
  std::printf("M=%zu: %zu corridors, %zu met the cap, the others took at most %u iterations and %u active rows\n",
              count, solves, capped, iterations, active);
}

int run(const Options& options) {
  std::vector<std::unique_ptr<Peer>> peers;
  const auto add = [&](std::vector<std::unique_ptr<Peer>> some) {
    for (auto& peer : some) {
      if (options.only.empty() || peer->name().find(options.only) != std::string::npos)
        peers.push_back(std::move(peer));
    }
  };
#ifdef WITH_DAQP
  add(make_daqp());
#endif
#ifdef WITH_EIQUADPROG
  add(make_eiquadprog());
#endif
#ifdef WITH_QUADPROG
  add(make_quadprog());
#endif
#ifdef WITH_QPOASES
  add(make_qpoases());
#endif
#ifdef WITH_PIQP
  add(make_piqp());
#endif
#ifdef WITH_OSQP
  add(make_osqp());
#endif
  const std::vector<std::size_t> lengths{5, 10, 20, 40, 80, 160, 320};
  if (options.limits) {
    for (const std::size_t count : lengths) print_limits(options, count);
    return 0;
  }
  std::printf(
      "Median CPU time of a trajectory in ms; in brackets the ratio to the first peer. Corridors counted: M=... "
      "(n).\n");
  for (const Gates gates : {Gates::kWindows, Gates::kRelaxed}) {
    const std::string kind = gates == Gates::kWindows ? "windows" : "relaxed";
    std::vector<std::vector<Column>> both(lengths.size());
    for (const Times times : {Times::kTrap, Times::kTight}) {
      std::vector<std::vector<Column>> results;
      for (const std::size_t count : lengths) {
        results.push_back(run_set(corridors(options, gates, times, count), peers, count));
      }
      print_table(kind + (times == Times::kTrap ? ", trap" : ", tight"), lengths, peers, results);
      for (std::size_t i = 0; i < lengths.size(); ++i) append(results[i], both[i]);
    }
    print_table(kind + ", trap and tight", lengths, peers, both);
  }
  return 0;
}

}  // namespace
}  // namespace swiftlet::bench

int main(int argc, char** argv) {
  swiftlet::bench::Options options;
  for (int i = 1; i < argc; ++i) {
    const bool more = i + 1 < argc;
    if (std::strcmp(argv[i], "--quick") == 0)
      options.quick = true;
    else if (std::strcmp(argv[i], "--limits") == 0)
      options.limits = true;
    else if (std::strcmp(argv[i], "--cases") == 0 && more)
      options.cases = argv[++i];
    else if (std::strcmp(argv[i], "--only") == 0 && more)
      options.only = argv[++i];
    else {
      std::fprintf(stderr, "qp_bench: unknown option '%s'\n", argv[i]);
      return 2;
    }
  }
  return swiftlet::bench::run(options);
}
