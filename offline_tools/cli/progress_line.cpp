#include "cli/progress_line.hpp"

#include <unistd.h>

#include <algorithm>
#include <cstdio>

namespace swiftlet::tools {

ProgressLine::ProgressLine(bool wanted) : terminal_(wanted && ::isatty(STDERR_FILENO) == 1) {}

ProgressLine::~ProgressLine() {
  if (shown_) std::fprintf(stderr, "\r\033[K");
}

void ProgressLine::show(std::string_view stage, double done) {
  const int percent = static_cast<int>(100 * std::clamp(done, 0.0, 1.0));
  if (!terminal_ || (stage == stage_ && percent == percent_)) return;
  stage_ = stage;
  percent_ = percent;
  shown_ = true;
  const std::string bar(static_cast<std::size_t>(percent / 5), '#');
  std::fprintf(stderr, "\r\033[K%-22s [%-20s] %3d %%", stage_.c_str(), bar.c_str(), percent);
  std::fflush(stderr);
}

}  // namespace swiftlet::tools
