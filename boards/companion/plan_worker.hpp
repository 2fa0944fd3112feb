#pragma once
#include <cstdint>

#include "swiftlet/planner.hpp"

namespace swiftlet::companion {

/// One plan to be made. The map, and what it says is blocked, stay as they are until the job is done.
struct PlanJob {
  BoxGraphView map;
  PlanRequest request;
};

/// Makes plans one at a time while the flight goes on. The flight sees only at which step a plan was done, so a worker
/// that is done at the same steps gives the same flight.
class PlanWorker {
 public:
  /// Begins a plan; none is under way.
  virtual void start(const PlanJob& job) = 0;

  /// Asked once a step while a plan is under way, at the step's end, the step of `start` included; true ends the job.
  virtual bool done() = 0;

  /// The plan, after done(); good until the next start.
  [[nodiscard]] virtual const Plan& result() const = 0;

 protected:
  ~PlanWorker() = default;  // protected and non-virtual: a public virtual one links operator delete
};

/// Plans within `start` and lets the flight wait for `steps` further steps: for lock-step and for bare boards.
class InlineWorker final : public PlanWorker {
 public:
  explicit InlineWorker(const PlannerSpans& spans, std::uint32_t steps = 1) : planner_(spans), steps_(steps) {}

  void start(const PlanJob& job) override;
  bool done() override;
  [[nodiscard]] const Plan& result() const override { return planner_.result(); }

  /// From the next start on; a replay sets what was recorded.
  void set_steps(std::uint32_t steps) { steps_ = steps; }

 private:
  Planner planner_;
  std::uint32_t steps_;
  std::uint32_t left_ = 0;
};

}  // namespace swiftlet::companion
