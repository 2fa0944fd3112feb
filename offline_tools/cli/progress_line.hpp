#pragma once
#include <string>
#include <string_view>

namespace swiftlet::tools {

/// A bar on one line of standard error that is written over, on a terminal, and gone with this object; nothing
/// elsewhere.
class ProgressLine {
 public:
  /// `wanted` false: nothing at all, for output that goes to the same terminal.
  explicit ProgressLine(bool wanted = true);
  ProgressLine(const ProgressLine&) = delete;
  ProgressLine& operator=(const ProgressLine&) = delete;
  ~ProgressLine();
  /// `done` of the stage, 0 to 1.
  void show(std::string_view stage, double done);

 private:
  bool terminal_;
  bool shown_ = false;
  std::string stage_;
  int percent_ = 0;
};

}  // namespace swiftlet::tools
