#include "companion/plan_worker.hpp"

namespace swiftlet::companion {

void InlineWorker::start(const PlanJob& job) {
  (void)planner_.plan(job.map, job.request);
  left_ = steps_;
}

bool InlineWorker::done() { return left_-- == 0; }

}  // namespace swiftlet::companion
