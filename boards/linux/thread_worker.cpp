#include "linux/thread_worker.hpp"

namespace swiftlet::board {

ThreadWorker::ThreadWorker(const PlannerSpans& spans, std::chrono::microseconds patience)
    : planner_(spans), patience_(patience), thread_([this] { work(); }) {}

ThreadWorker::~ThreadWorker() {
  {
    const std::lock_guard lock(mutex_);
    ends_ = true;
  }
  changed_.notify_all();
  thread_.join();
}

void ThreadWorker::start(const companion::PlanJob& job) {
  {
    const std::lock_guard lock(mutex_);
    job_ = job;
    busy_ = true;
    started_ = std::chrono::steady_clock::now();
  }
  changed_.notify_all();
}

bool ThreadWorker::done() {
  std::unique_lock lock(mutex_);
  return changed_.wait_until(lock, started_ + patience_, [this] { return !busy_; });
}

std::chrono::microseconds ThreadWorker::duration() const {
  const std::lock_guard lock(mutex_);
  return duration_;
}

void ThreadWorker::work() {
  std::unique_lock lock(mutex_);
  while (true) {
    changed_.wait(lock, [this] { return busy_ || ends_; });
    if (ends_) return;
    lock.unlock();
    const auto begun = std::chrono::steady_clock::now();
    (void)planner_.plan(job_.map, job_.request);
    const auto took = std::chrono::steady_clock::now() - begun;
    lock.lock();
    duration_ = std::chrono::duration_cast<std::chrono::microseconds>(took);
    busy_ = false;
    changed_.notify_all();
  }
}

}  // namespace swiftlet::board
