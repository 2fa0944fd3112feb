#pragma once
#include <chrono>
#include <condition_variable>
#include <mutex>
#include <thread>

#include "companion/plan_worker.hpp"

namespace swiftlet::board {

/// Plans in a thread of its own.
class ThreadWorker final : public companion::PlanWorker {
 public:
  /// Of the program `companion`, in steps of 10 ms: the set-point has left by then, so that nearly every plan is
  /// committed in the step that asked for it, and the step ends well before the next one begins.
  static constexpr std::chrono::milliseconds kPatience{8};

  /// `patience`: until how long after its start `done` waits for a plan; later it does not wait at all.
  explicit ThreadWorker(const PlannerSpans& spans, std::chrono::microseconds patience = kPatience);
  ~ThreadWorker();
  ThreadWorker(const ThreadWorker&) = delete;
  ThreadWorker& operator=(const ThreadWorker&) = delete;

  void start(const companion::PlanJob& job) override;
  bool done() override;
  [[nodiscard]] const Plan& result() const override { return planner_.result(); }

  /// How long the last plan took, start to end, in real time.
  [[nodiscard]] std::chrono::microseconds duration() const;

 private:
  void work();

  Planner planner_;
  std::chrono::microseconds patience_;
  std::chrono::steady_clock::time_point started_;
  std::chrono::microseconds duration_{0};
  companion::PlanJob job_;
  bool busy_ = false;
  bool ends_ = false;
  mutable std::mutex mutex_;
  std::condition_variable changed_;
  std::thread thread_;
};

}  // namespace swiftlet::board
